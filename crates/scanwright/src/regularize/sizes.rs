//! Sizes that are equal: radii, half-angles, and the places of parallel planes.
//!
//! Gathered as directions are (`gather`), in one dimension. Sizes that have nothing in common lie anywhere: offsets of
//! parallel planes in the part's extent, radii and half-angles within a factor of twenty.

use super::gather::{Agreement, Group};
use crate::math::{Mat3, Point3, UnitVec3, Vec3};

/// What may be equal to what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum SizeKind {
    /// Offset of a plane along the direction of a cluster.
    Offset { cluster: usize },
    /// Radius of a cylinder, all bosses or all bores.
    CylinderRadius { outward: bool },
    /// Radius of a sphere.
    SphereRadius { outward: bool },
    /// Half-angle of a cone.
    HalfAngle,
    /// Radius of a torus's spine.
    MajorRadius,
    /// Radius of a torus's tube.
    MinorRadius { outward: bool },
}

/// A size of a primitive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Size {
    pub primitive: usize,
    pub kind: SizeKind,
    /// Place of the parameter in `fit::parameter_names`.
    pub parameter: usize,
    pub value: f64,
    /// Of the value given the direction and the line of the primitive, as its points say.
    pub variance: f64,
    /// Square of what manufacture may deviate by.
    pub form: f64,
    /// Range that unrelated values are spread over.
    pub range: f64,
    /// Middle of the points of a plane, and the covariance of the direction of its cluster.
    pub at: Point3,
    pub direction: Mat3,
    /// Whether its face may change its size alone: a fillet would part from the faces that it is tangent to.
    pub free: bool,
}

/// Sizes that mean the same.
#[derive(Debug, Clone)]
pub(super) struct Sizes {
    pub members: Vec<Size>,
    /// Their common value: the mean with weights by information.
    pub value: f64,
    /// Of the value, as the points of all say.
    pub variance: f64,
    /// Middle of what they say.
    pub at: Point3,
}

impl Sizes {
    /// Whether its members may be made equal.
    pub fn is_free(&self) -> bool {
        self.members.iter().all(|size| size.free)
    }

    /// The variance that the common value is stated with: that of the best member. What the scanner's spot does to one of them
    /// it does to all, and no mean of them takes it away.
    pub fn stated(&self) -> f64 {
        self.members.iter().map(|size| size.variance).fold(f64::INFINITY, f64::min)
    }

    /// How far `size` is from the group in standard uncertainties, with and without what manufacture may deviate by.
    pub fn deviations(&self, size: &Size) -> (f64, f64) {
        let arm = size.at - self.at;
        let lever = arm.dot(&(size.direction * arm));
        let statistical = self.variance + size.variance + lever;
        // The group is as well made as one of its members.
        let total = statistical + 2.0 * size.form;
        let deviation = (size.value - self.value).abs();
        (deviation / total.sqrt(), deviation / statistical.sqrt())
    }
}

/// A size compared with a group.
#[derive(Debug)]
pub(super) struct Compared {
    z_sq: f64,
    odds: f64,
}

impl Agreement for Compared {
    fn dimensions(&self) -> usize {
        1
    }

    fn z_sq(&self) -> f64 {
        self.z_sq
    }

    fn odds(&self) -> f64 {
        self.odds
    }
}

impl Group for Sizes {
    type Thing = Size;
    type Agreement = Compared;

    fn founded_by(size: &Size) -> Self {
        Self { members: vec![*size], value: size.value, variance: size.variance, at: size.at }
    }

    fn n_members(&self) -> usize {
        self.members.len()
    }

    fn agreements(groups: &[Self], size: &Size) -> Vec<Option<Compared>> {
        let compared = |group: &Self| {
            if group.members[0].kind != size.kind {
                return None;
            }
            let (z, _) = group.deviations(size);
            let sigma = (size.value - group.value).abs() / z;
            // Equal values have no deviation to divide by.
            let sigma = if sigma.is_finite() && z > 0.0 {
                sigma
            } else {
                (group.variance + size.variance + 2.0 * size.form).sqrt()
            };
            let density = (-0.5 * z * z).exp() / (std::f64::consts::TAU.sqrt() * sigma);
            Some(Compared { z_sq: z * z, odds: density * size.range })
        };
        groups.iter().map(compared).collect()
    }

    fn with(&self, size: &Size, _: &Compared) -> Option<Self> {
        let (own, other) = (1.0 / self.variance, 1.0 / size.variance);
        let share = other / (own + other);
        if !share.is_finite() {
            return None;
        }
        Some(Self {
            members: self.members.iter().copied().chain([*size]).collect(),
            value: self.value + share * (size.value - self.value),
            variance: 1.0 / (own + other),
            at: self.at + (size.at - self.at) * share,
        })
    }
}

/// Where a plane that several share lies.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedPlane {
    pub normal: UnitVec3,
    /// Of the plane along the normal, from the origin of coordinates.
    pub offset: f64,
    /// Of the offset at `at`, given the direction.
    pub variance: f64,
    pub at: Point3,
}

impl PlacedPlane {
    /// Distance of a point along the normal.
    pub fn distance(&self, point: &Point3) -> f64 {
        self.normal.dot(&point.coords) - self.offset
    }

    /// What the plane moves by at `point`, along the normal, when that moves.
    pub fn by_direction(&self, point: &Point3) -> Vec3 {
        self.at - point
    }
}
