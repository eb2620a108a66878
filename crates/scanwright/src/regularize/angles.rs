//! Clusters at a right angle or another common one, found by evidence and made exact together.
//!
//! All clusters are one Gaussian state of two tilts each. A pair is tested with the covariance that the relations
//! accepted so far have left, so that what they imply is not taken for evidence and what they exclude is not
//! accepted; an accepted relation is an observation without error (`gaussian`). Right angles come first. In the end all
//! accepted relations are solved at once by Gauss-Newton steps from the directions as they were seen.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{DMatrix, DVector, Matrix3x2};

use super::custom::Custom;
use super::directions::Cluster;
use super::gaussian::{Gaussian, Row};
use super::{DECIDED, MAX_ACCIDENT, MAX_SIGMAS};
use crate::math::{Mat3, UnitVec3, Vec3};

/// Clusters that are related, best seen first: bounds the cost of the joint solution, cubic in their number.
const MAX_CLUSTERS: usize = 200;
/// Steps of the joint solution: each makes the error smaller by the deviations themselves, radians.
const STEPS: usize = 12;

/// Clusters at common angles, made exactly so.
pub(super) struct Angles {
    /// All clusters, turned.
    pub clusters: Vec<Cluster>,
    /// What was made exact.
    pub made: Vec<Deviation>,
    /// What nearly holds and was left, with the reason.
    pub left: Vec<(Deviation, String)>,
}

/// Two clusters, by index, and the angle between their directions, at most a right one, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pair {
    pub clusters: (usize, usize),
    pub angle: f64,
}

impl Pair {
    /// Whether the angle is a right one.
    pub fn is_right(&self) -> bool {
        self.angle == FRAC_PI_2
    }
}

/// How far a pair was from its angle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Deviation {
    pub pair: Pair,
    /// Radians, not negative.
    pub size: f64,
    /// Of `size`, with all that is not known of both.
    pub variance: f64,
}

/// Deviation from a right angle, radians, up to which a pair that is not made exact is worth a word.
const NEARLY: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// The same of other common angles, of which one is never far.
const NEARLY_COMMON: f64 = 0.25 * NEARLY;
/// Common angles other than right ones: multiples of this, radians.
const COMMON: f64 = std::f64::consts::PI / 12.0;
/// How many of them there are below a right one.
const N_COMMON: usize = 5;

/// The clusters with common angles between them made exact. `asked`: the pairs that are to have one; found by evidence when
/// `None`.
pub(super) fn related(clusters: &[Cluster], asked: Option<&[Pair]>) -> Angles {
    let state = State::new(&clusters[..clusters.len().min(MAX_CLUSTERS)]);
    let (mut pairs, refused) = asked.map_or_else(|| accepted(&state), |asked| (asked.to_vec(), Vec::new()));
    pairs.retain(|pair| {
        let (a, b) = pair.clusters;
        a != b && a.max(b) < state.seen.len()
    });
    let described = |pair: Pair| {
        let (deviation, row) = state.deviation(&pair);
        Deviation { pair, size: deviation.abs(), variance: state.tilts.variance(&row) }
    };
    let nearly = |deviation: &Deviation| {
        deviation.size < if deviation.pair.is_right() { NEARLY } else { NEARLY_COMMON }
    };
    let mut left: Vec<(Deviation, String)> =
        refused.into_iter().map(|(pair, why)| (described(pair), why)).filter(|(d, _)| nearly(d)).collect();
    let mut related = clusters.to_vec();
    let Some(solution) = state.solved(&pairs) else {
        let why = "the relations asked for contradict each other";
        left.extend(pairs.into_iter().map(|pair| (described(pair), why.to_owned())));
        return Angles { clusters: related, made: Vec::new(), left };
    };
    for Pair { clusters: (a, b), .. } in &pairs {
        related[*a].angled = true;
        related[*b].angled = true;
    }
    for (k, cluster) in related.iter_mut().enumerate().filter(|(_, c)| c.angled) {
        cluster.direction.unit = solution.unit(k);
        cluster.direction.covariance = solution.covariance(k);
    }
    Angles { clusters: related, made: pairs.into_iter().map(described).collect(), left }
}

/// Directions as a Gaussian of tilts.
#[derive(Debug, Clone)]
struct State {
    /// One per cluster: the direction as it was seen, and its tangents.
    seen: Vec<(Vec3, Matrix3x2<f64>)>,
    /// Motions along the tangents.
    tilts: Gaussian,
}

impl State {
    fn new(clusters: &[Cluster]) -> Self {
        let n = 2 * clusters.len();
        let mut covariance = DMatrix::zeros(n, n);
        let mut seen = Vec::with_capacity(clusters.len());
        for (k, cluster) in clusters.iter().enumerate() {
            let tangents = cluster.direction.tangents();
            let own = cluster.direction.in_tangents(&tangents);
            covariance.fixed_view_mut::<2, 2>(2 * k, 2 * k).copy_from(&own);
            seen.push((cluster.direction.unit.into_inner(), tangents));
        }
        Self { seen, tilts: Gaussian::new(covariance) }
    }

    /// The direction of a cluster.
    fn unit(&self, k: usize) -> UnitVec3 {
        let (seen, tangents) = &self.seen[k];
        UnitVec3::new_normalize(seen + tangents * self.tilts.moved.fixed_rows::<2>(2 * k))
    }

    /// Covariance of its coordinates.
    fn covariance(&self, k: usize) -> Mat3 {
        let tangents = &self.seen[k].1;
        let covariance =
            tangents * self.tilts.covariance.fixed_view::<2, 2>(2 * k, 2 * k) * tangents.transpose();
        let unit = self.unit(k);
        let flat = Mat3::identity() - unit.into_inner() * unit.transpose();
        flat * covariance * flat
    }

    /// Angle between the directions of a pair, at most a right one, radians.
    fn angle(&self, (a, b): (usize, usize)) -> f64 {
        self.unit(a).dot(&self.unit(b)).abs().clamp(0.0, 1.0).acos()
    }

    /// What the angle of a pair is too large by, radians, to first order, and its derivative by the tilts of both.
    fn deviation(&self, pair: &Pair) -> (f64, Row) {
        let (a, b) = pair.clusters;
        let (ua, ub) = (self.unit(a), self.unit(b));
        let cosine = ua.dot(&ub);
        let (sin, cos) = if pair.is_right() { (1.0, 0.0) } else { pair.angle.sin_cos() };
        // Directions have no sign: the one in the other's half-space counts.
        let sign = if cosine < 0.0 && !pair.is_right() { 1.0 } else { -1.0 };
        let by_a = self.seen[a].1.transpose() * ub.into_inner() * (sign / sin);
        let by_b = self.seen[b].1.transpose() * ua.into_inner() * (sign / sin);
        let row = [(2 * a, by_a.x), (2 * a + 1, by_a.y), (2 * b, by_b.x), (2 * b + 1, by_b.y)];
        ((sign * cosine + cos) / sin, row)
    }

    /// The state nearest to what was seen in which all `pairs` have their angle; `None` without pairs, or when they
    /// contradict each other.
    fn solved(&self, pairs: &[Pair]) -> Option<Self> {
        if pairs.is_empty() {
            return None;
        }
        let mut state = self.clone();
        for _ in 0..STEPS {
            let mut jacobian = DMatrix::zeros(pairs.len(), self.tilts.moved.len());
            let mut aim = DVector::zeros(pairs.len());
            for (i, pair) in pairs.iter().enumerate() {
                let (deviation, row) = state.deviation(pair);
                for (j, x) in row {
                    jacobian[(i, j)] = x;
                    aim[i] += x * state.tilts.moved[j];
                }
                aim[i] -= deviation;
            }
            let effect = &self.tilts.covariance * jacobian.transpose();
            let inverse = (&jacobian * &effect).cholesky()?.inverse();
            state.tilts.moved = &effect * (&inverse * aim);
            state.tilts.covariance = &self.tilts.covariance - &effect * inverse * effect.transpose();
        }
        state.tilts.moved.iter().all(|x| x.is_finite()).then_some(state)
    }
}

/// Pairs with the reason why they do not have their angle.
type Refused = Vec<(Pair, String)>;

/// Pairs of clusters that have a common angle by the evidence, best seen first, and others with the reason.
fn accepted(state: &State) -> (Vec<Pair>, Refused) {
    let n = state.seen.len();
    let mut by_evidence = ByEvidence {
        at_first: state,
        state: state.clone(),
        customs: vec![Custom::default(); n],
        accepted: Vec::new(),
        refused: Vec::new(),
    };
    let all: Vec<(usize, usize)> = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))).collect();
    by_evidence.test(all.iter().map(|&clusters| Pair { clusters, angle: FRAC_PI_2 }), right_by_accident);
    by_evidence.customs = vec![Custom::default(); n];
    let nearest = |clusters: (usize, usize)| {
        let multiple = (state.angle(clusters) / COMMON).round();
        let is_common = (1..=N_COMMON).any(|k| multiple == k as f64);
        is_common.then_some(Pair { clusters, angle: multiple * COMMON })
    };
    by_evidence.test(all.iter().filter_map(|&clusters| nearest(clusters)), common_by_accident);
    (by_evidence.accepted, by_evidence.refused)
}

/// What the evidence has decided so far.
struct ByEvidence<'a> {
    /// Before anything was accepted.
    at_first: &'a State,
    state: State,
    /// One per cluster.
    customs: Vec<Custom>,
    accepted: Vec<Pair>,
    refused: Refused,
}

impl ByEvidence<'_> {
    /// Tests pairs, best seen first. `by_accident`: probability that unrelated directions meet the angle as well as is
    /// asked, by the variance of the deviation.
    fn test(&mut self, pairs: impl Iterator<Item = Pair>, by_accident: impl Fn(f64) -> f64) {
        let variance_at_first = |pair: &Pair| self.at_first.tilts.variance(&self.at_first.deviation(pair).1);
        let mut candidates: Vec<(f64, Pair)> = pairs
            .map(|pair| (variance_at_first(&pair), pair))
            .filter(|(variance, _)| by_accident(*variance) < 1.0)
            .collect();
        candidates.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.clusters.cmp(&y.1.clusters)));
        for (at_first, pair) in candidates {
            let (deviation, row) = self.state.deviation(&pair);
            let variance = self.state.tilts.variance(&row);
            if variance < DECIDED * at_first {
                continue;
            }
            let accident = by_accident(variance);
            let holds = deviation.abs() < MAX_SIGMAS * variance.sqrt();
            // What is the rule with the better seen of the two needs less evidence than what would be an exception.
            let custom = &mut self.customs[pair.clusters.0];
            if holds && custom.accident(accident) < MAX_ACCIDENT {
                self.state.tilts.observe(deviation, &row, variance);
                self.accepted.push(pair);
            } else if holds {
                self.refused.push((pair, "so badly seen that it may be by accident".to_owned()));
            } else {
                let z = deviation.abs() / variance.sqrt();
                self.refused.push((pair, format!("off by {z:.1} standard uncertainties")));
            }
            if accident < MAX_ACCIDENT {
                custom.count(holds);
            }
        }
    }
}

/// The cosine of random directions is uniform in [-1, 1].
fn right_by_accident(variance: f64) -> f64 {
    MAX_SIGMAS * variance.sqrt()
}

/// Any of the common angles counts; on prismatic parts angles are uniform up to a right one.
fn common_by_accident(variance: f64) -> f64 {
    2.0 * MAX_SIGMAS * variance.sqrt() * N_COMMON as f64 / FRAC_PI_2
}
