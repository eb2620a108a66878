//! Directions with uncertainty, and the gathering of those that mean the same.

use nalgebra::{Matrix2, Matrix3x2, Vector2};

use super::MAX_SIGMAS;
use super::gather::{Agreement, Group, forced, gathered};
use crate::math::{Frame, Mat3, Point3, UnitVec3, Vec3};

/// An estimated direction; its sign says nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Direction {
    /// The estimate.
    pub unit: UnitVec3,
    /// Covariance of its coordinates, radians squared; none along `unit`.
    pub covariance: Mat3,
}

impl Direction {
    /// Two unit vectors perpendicular to it, as columns.
    pub fn tangents(&self) -> Matrix3x2<f64> {
        let frame = Frame::from_z(Point3::origin(), self.unit);
        Matrix3x2::from_columns(&[frame.x.into_inner(), frame.y.into_inner()])
    }

    /// Covariance in the basis of `tangents`.
    pub fn in_tangents(&self, tangents: &Matrix3x2<f64>) -> Matrix2<f64> {
        tangents.transpose() * self.covariance * tangents
    }

    /// Solid angle of one standard deviation over pi: product of the standard deviations of the two tilts.
    fn spread(&self) -> f64 {
        self.in_tangents(&self.tangents()).determinant().max(0.0).sqrt()
    }

    /// What `self` and `other` say together, when both mean one direction: the information-weighted mean.
    fn and(&self, comparison: &Comparison) -> Option<Self> {
        let own = self.in_tangents(&comparison.tangents);
        let gain = own * comparison.covariance.try_inverse()?;
        Some(self.moved(&comparison.tangents, &(gain * comparison.deviation), &(own - gain * own)))
    }

    /// The direction moved by `by` along `tangents`, with `covariance` in these.
    pub fn moved(&self, tangents: &Matrix3x2<f64>, by: &Vector2<f64>, covariance: &Matrix2<f64>) -> Self {
        let unit = UnitVec3::new_normalize(self.unit.into_inner() + tangents * by);
        let covariance = tangents * covariance * tangents.transpose();
        // The tangent plane of the mean: nothing is left along it.
        let flat = Mat3::identity() - unit.into_inner() * unit.transpose();
        Self { unit, covariance: flat * covariance * flat }
    }
}

/// Two directions compared.
pub(super) struct Comparison {
    tangents: Matrix3x2<f64>,
    /// The other less the one, in `tangents` of the one.
    deviation: Vector2<f64>,
    /// Covariance of `deviation`.
    covariance: Matrix2<f64>,
    /// Square of the deviation in standard uncertainties.
    z_sq: f64,
    /// Density of the deviation if both mean one direction over its density if they have nothing in common.
    odds: f64,
}

impl Comparison {
    /// `pencil`: a direction that both are known to be perpendicular to, if there is one.
    pub fn new(one: &Direction, other: &Direction, pencil: Option<&UnitVec3>) -> Option<Self> {
        let tangents = one.tangents();
        let sign = if one.unit.dot(&other.unit) < 0.0 { -1.0 } else { 1.0 };
        let difference: Vec3 = other.unit.into_inner() * sign - one.unit.into_inner();
        let deviation = tangents.transpose() * difference;
        let covariance = one.in_tangents(&tangents) + other.in_tangents(&tangents);
        let z_sq = deviation.dot(&(covariance.try_inverse()? * deviation));
        let (best, exponent) = match pencil {
            // Unrelated directions are uniform over the hemisphere of 2 pi.
            None => (1.0 / covariance.determinant().max(0.0).sqrt(), z_sq),
            // In a pencil they are uniform over pi.
            Some(axis) => {
                let along = tangents.transpose() * axis.cross(&one.unit);
                let variance = along.dot(&(covariance * along));
                let best = (0.5 * std::f64::consts::PI / variance).sqrt();
                (best, along.dot(&deviation).powi(2) / variance)
            }
        };
        let odds = best * (-0.5 * exponent).exp();
        Some(Self { tangents, deviation, covariance, z_sq, odds })
    }
}

impl Agreement for Comparison {
    fn dimensions(&self) -> usize {
        2
    }

    fn z_sq(&self) -> f64 {
        self.z_sq
    }

    fn odds(&self) -> f64 {
        self.odds
    }
}

/// Whether the scan does not contradict that two directions are perpendicular.
fn may_be_perpendicular(one: &Direction, other: &Direction) -> bool {
    let (u, v) = (one.unit.into_inner(), other.unit.into_inner());
    let variance = v.dot(&(one.covariance * v)) + u.dot(&(other.covariance * u));
    u.dot(&v).abs() < MAX_SIGMAS * variance.sqrt()
}

/// Primitives of one direction.
#[derive(Debug, Clone)]
pub(super) struct Cluster {
    /// The common direction.
    pub direction: Direction,
    /// Indices of primitives, best seen first.
    pub members: Vec<usize>,
    /// Whether its angle with another cluster was made exact.
    pub angled: bool,
}

impl Cluster {
    /// Whether a relation holds for its members.
    pub fn is_related(&self) -> bool {
        self.angled || self.members.len() > 1
    }
}

/// A direction of a primitive.
pub(super) struct Seen {
    primitive: usize,
    direction: Direction,
}

impl Group for Cluster {
    type Thing = Seen;
    type Agreement = Comparison;

    fn founded_by(seen: &Seen) -> Self {
        Self { direction: seen.direction, members: vec![seen.primitive], angled: false }
    }

    fn n_members(&self) -> usize {
        self.members.len()
    }

    fn agreements(clusters: &[Self], seen: &Seen) -> Vec<Option<Comparison>> {
        let direction = &seen.direction;
        let pencils: Vec<&Self> =
            clusters.iter().filter(|c| may_be_perpendicular(&c.direction, direction)).collect();
        let compared = |cluster: &Self| {
            let pencil = pencils.iter().find(|p| may_be_perpendicular(&p.direction, &cluster.direction));
            Comparison::new(&cluster.direction, direction, pencil.map(|p| &p.direction.unit))
        };
        clusters.iter().map(compared).collect()
    }

    fn with(&self, seen: &Seen, comparison: &Comparison) -> Option<Self> {
        let direction = self.direction.and(comparison)?;
        let members = self.members.iter().copied().chain([seen.primitive]).collect();
        Some(Self { direction, members, ..*self })
    }
}

/// Clusters of parallel directions, best seen first. `directions`: one per primitive, `None` for those without. `asked`:
/// the sets of primitives that are to be parallel; found by evidence when `None`.
pub(super) fn parallel(directions: &[Option<Direction>], asked: Option<&[Vec<usize>]>) -> Vec<Cluster> {
    let mut order: Vec<(f64, Seen)> = directions
        .iter()
        .enumerate()
        .filter_map(|(primitive, d)| d.map(|direction| (direction.spread(), Seen { primitive, direction })))
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.primitive.cmp(&b.1.primitive)));
    let order: Vec<Seen> = order.into_iter().map(|(_, seen)| seen).collect();
    asked.map_or_else(|| gathered(&order), |sets| forced(&order, sets, |seen: &Seen| seen.primitive))
}
