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
    /// Density of the deviation if both mean one direction over its density if they have nothing in common.
    odds: f64,
}

impl Agreement {
    /// `pencil`: a direction that both are known to be perpendicular to, if there is one.
    fn new(one: &Direction, other: &Direction, pencil: Option<&UnitVec3>) -> Option<Self> {
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

/// Whether the scan does not contradict that two directions are perpendicular.
fn may_be_perpendicular(one: &Direction, other: &Direction) -> bool {
    let (u, v) = (one.unit.into_inner(), other.unit.into_inner());
    let variance = v.dot(&(one.covariance * v)) + u.dot(&(other.covariance * u));
    u.dot(&v).abs() < MAX_SIGMAS * variance.sqrt()
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
/// Directions come best seen first, so that strong ones meet before weak ones could draw them together. Each joins the
/// cluster that it most probably belongs to, if that is probable enough, or founds one: a face of a well-seen draft
/// contradicts every cluster, and a badly seen flank of a gear fits so many that none is probable.
///
/// How many directions of this part join a cluster is its own prior, by expectation and maximization (A. Dempster,
/// N. Laird, D. Rubin, Journal of the Royal Statistical Society B 39 (1977), 1-38) from a start of one half.
pub(super) fn parallel(directions: &[Option<Direction>]) -> Vec<Cluster> {
    /// Rounds of estimating the prior: decisions depend on it through the logarithm of its odds only.
    const ROUNDS: usize = 6;
    let mut order: Vec<(f64, usize, Direction)> =
        directions.iter().enumerate().filter_map(|(k, d)| d.map(|d| (d.spread(), k, d))).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut prior = 0.5;
    let mut clusters = Vec::new();
    for _ in 0..ROUNDS {
        let joined;
        (clusters, joined) = gathered(&order, prior);
        // Laplace's rule of succession; the first direction has nothing to join.
        prior = (joined + 1.0) / (order.len() as f64 + 1.0);
    }
    clusters
}

/// Clusters of the directions in `order`, and how many of these are expected to have joined one. `prior`: probability
/// that one does.
fn gathered(order: &[(f64, usize, Direction)], prior: f64) -> (Vec<Cluster>, f64) {
    let mut clusters: Vec<Cluster> = Vec::new();
    let mut n_joined = 0.0;
    for (n_before, &(_, k, direction)) in order.iter().enumerate() {
        let home = home(&clusters, &direction, n_before as f64, prior);
        n_joined += home.probability;
        match home.joint {
            Some((c, joint)) => {
                clusters[c].direction = joint;
                clusters[c].members.push(k);
            }
            None => clusters.push(Cluster { direction, members: vec![k], perpendicular: false }),
        }
    }
    (clusters, n_joined)
}

/// Where a direction belongs.
struct Home {
    /// The cluster, and its direction with the new one.
    joint: Option<(usize, Direction)>,
    /// Probability that it belongs to any.
    probability: f64,
}

/// The cluster that `direction` belongs to. A priori it joins one with probability `prior`, a large one rather than a
/// small one, in proportion to members; `n_before`: number of directions in all clusters.
fn home(clusters: &[Cluster], direction: &Direction, n_before: f64, prior: f64) -> Home {
    let pencils: Vec<&Cluster> =
        clusters.iter().filter(|c| may_be_perpendicular(&c.direction, direction)).collect();
    let mut best: Option<(f64, usize, Agreement)> = None;
    let mut sum = 1.0 - prior;
    for (c, cluster) in clusters.iter().enumerate() {
        let pencil = pencils
            .iter()
            .find(|p| may_be_perpendicular(&p.direction, &cluster.direction))
            .map(|p| &p.direction.unit);
        let Some(agreement) = Agreement::new(&cluster.direction, direction, pencil) else { continue };
        let weight = prior * cluster.members.len() as f64 / n_before * agreement.odds;
        if agreement.z_sq < max_z_sq() {
            sum += weight;
            if best.as_ref().is_none_or(|(w, _, _)| *w < weight) {
                best = Some((weight, c, agreement));
            }
        }
    }
    let probability = 1.0 - (1.0 - prior) / sum;
    let joint = best
        .filter(|(weight, _, _)| sum - weight < MAX_ACCIDENT * sum)
        .and_then(|(_, c, agreement)| clusters[c].direction.and(&agreement).map(|joint| (c, joint)));
    Home { joint, probability }
}
