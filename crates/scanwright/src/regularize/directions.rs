//! Directions with uncertainty, and the gathering of those that mean the same.

use nalgebra::{Matrix2, Matrix3x2, Vector2};

use super::{MAX_ACCIDENT, MAX_SIGMAS};
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
    fn and(&self, agreement: &Agreement) -> Option<Self> {
        let own = self.in_tangents(&agreement.tangents);
        let gain = own * agreement.covariance.try_inverse()?;
        let unit = UnitVec3::new_normalize(
            self.unit.into_inner() + agreement.tangents * (gain * agreement.deviation),
        );
        let covariance = agreement.tangents * (own - gain * own) * agreement.tangents.transpose();
        // The tangent plane of the mean: nothing is left along it.
        let flat = Mat3::identity() - unit.into_inner() * unit.transpose();
        Some(Self { unit, covariance: flat * covariance * flat })
    }
}

/// Two directions compared.
struct Agreement {
    tangents: Matrix3x2<f64>,
    /// The other less the one, in `tangents` of the one.
    deviation: Vector2<f64>,
    /// Covariance of `deviation`.
    covariance: Matrix2<f64>,
    /// Square of the deviation in standard uncertainties.
    z_sq: f64,
    /// Probability that a random direction would agree as well as is asked.
    accident: f64,
}

impl Agreement {
    fn new(one: &Direction, other: &Direction) -> Option<Self> {
        let tangents = one.tangents();
        let sign = if one.unit.dot(&other.unit) < 0.0 { -1.0 } else { 1.0 };
        let difference: Vec3 = other.unit.into_inner() * sign - one.unit.into_inner();
        let deviation = tangents.transpose() * difference;
        let covariance = one.in_tangents(&tangents) + other.in_tangents(&tangents);
        let z_sq = deviation.dot(&(covariance.try_inverse()? * deviation));
        // The ellipse of `max_z_sq` as a share of the hemisphere of 2 pi.
        let accident = 0.5 * max_z_sq() * covariance.determinant().max(0.0).sqrt();
        Some(Self { tangents, deviation, covariance, z_sq, accident })
    }
}

/// Square of the deviation of two coordinates that is exceeded as rarely as [`MAX_SIGMAS`] is by one.
fn max_z_sq() -> f64 {
    // P(|z| > 2.5) = 0.0124; chi squared of two degrees of freedom exceeds -2 ln p with probability p.
    const RARE: f64 = 0.0124;
    const { assert!(MAX_SIGMAS == 2.5, "RARE belongs to 2.5 sigmas") };
    -2.0 * RARE.ln()
}

/// Primitives of one direction.
#[derive(Debug, Clone)]
pub(super) struct Cluster {
    /// The common direction.
    pub direction: Direction,
    /// Indices of primitives, best seen first.
    pub members: Vec<usize>,
    /// Whether it takes part in a relation with other clusters.
    pub perpendicular: bool,
}

impl Cluster {
    /// Whether a relation holds for its members.
    pub fn is_related(&self) -> bool {
        self.perpendicular || self.members.len() > 1
    }
}

/// Clusters of parallel directions, best seen first. `directions`: one per primitive, `None` for those without.
///
/// The best seen direction that no cluster holds founds one; each other joins the cluster that it agrees with best.
/// Strong directions thus meet before weak ones could draw them together, and a face of a well-seen draft founds a
/// cluster of its own.
pub(super) fn parallel(directions: &[Option<Direction>]) -> Vec<Cluster> {
    let mut order: Vec<(f64, usize, Direction)> =
        directions.iter().enumerate().filter_map(|(k, d)| d.map(|d| (d.spread(), k, d))).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut clusters: Vec<Cluster> = Vec::new();
    for (_, k, direction) in order {
        let trials = clusters.len() as f64;
        let best = clusters
            .iter_mut()
            .filter_map(|c| Agreement::new(&c.direction, &direction).map(|a| (a, c)))
            .filter(|(a, _)| a.z_sq < max_z_sq() && a.accident * trials < MAX_ACCIDENT)
            .min_by(|(a, _), (b, _)| a.z_sq.total_cmp(&b.z_sq));
        let joint = best.and_then(|(a, c)| c.direction.and(&a).map(|joint| (joint, c)));
        match joint {
            Some((joint, cluster)) => {
                cluster.direction = joint;
                cluster.members.push(k);
            }
            None => clusters.push(Cluster { direction, members: vec![k], perpendicular: false }),
        }
    }
    clusters
}
