//! Perpendicular clusters, found by evidence and made exact together.
//!
//! All clusters are one Gaussian state of two tilts each. A pair is tested with the covariance that the relations
//! accepted so far have left, so that what they imply is not taken for evidence and what they exclude is not
//! accepted; an accepted relation is an observation without error. R. Kalman, "A new approach to linear filtering and
//! prediction problems", Journal of Basic Engineering 82 (1960), 35-45. In the end all accepted relations are solved at
//! once by Gauss-Newton steps from the directions as they were seen.

use nalgebra::{DMatrix, DVector, Matrix3x2};

use super::custom::Custom;
use super::directions::Cluster;
use super::{MAX_ACCIDENT, MAX_SIGMAS};
use crate::math::{Mat3, UnitVec3, Vec3};

/// Clusters that are related, best seen first: bounds the cost of the joint solution, cubic in their number.
const MAX_CLUSTERS: usize = 200;
/// Steps of the joint solution: each makes the error smaller by the deviations themselves, radians.
const STEPS: usize = 12;
/// Share of a pair's variance below which the relations accepted so far decide it.
const DECIDED: f64 = 0.01;

/// Perpendicular clusters, made exactly so.
pub(super) struct Perpendicular {
    /// All clusters, turned.
    pub clusters: Vec<Cluster>,
    /// Pairs that were made perpendicular, by index.
    pub pairs: Vec<Pair>,
    /// Pairs that are nearly perpendicular and were left, with the reason.
    pub left: Vec<(Pair, String)>,
}

/// Two clusters and how far from perpendicular they were.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    pub clusters: (usize, usize),
    /// Deviation from a right angle, radians.
    pub deviation: f64,
    /// Its variance with all that is not known of both.
    pub variance: f64,
}

/// Deviation from a right angle, radians, up to which a pair that is not made perpendicular is worth a word.
const NEARLY: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// The clusters with perpendicular ones made exactly so. `asked`: the pairs that are to be; found by evidence when `None`.
pub(super) fn related(clusters: &[Cluster], asked: Option<&[(usize, usize)]>) -> Perpendicular {
    let state = State::new(&clusters[..clusters.len().min(MAX_CLUSTERS)]);
    let (mut pairs, refused) = asked.map_or_else(|| accepted(&state), |asked| (asked.to_vec(), Vec::new()));
    pairs.retain(|(a, b)| a != b && a.max(b) < &state.seen.len());
    let described = |pair: (usize, usize)| {
        let (cosine, row) = state.cosine(pair);
        Pair {
            clusters: pair,
            deviation: cosine.clamp(-1.0, 1.0).asin().abs(),
            variance: state.variance(&row),
        }
    };
    let nearly = |pair: &Pair| pair.deviation < NEARLY;
    let mut left: Vec<(Pair, String)> =
        refused.into_iter().map(|(pair, why)| (described(pair), why)).filter(|(p, _)| nearly(p)).collect();
    let mut related = clusters.to_vec();
    let Some(solution) = state.solved(&pairs) else {
        let why = "the relations asked for contradict each other";
        left.extend(pairs.into_iter().map(|pair| (described(pair), why.to_owned())));
        return Perpendicular { clusters: related, pairs: Vec::new(), left };
    };
    for &(a, b) in &pairs {
        related[a].perpendicular = true;
        related[b].perpendicular = true;
    }
    for (k, cluster) in related.iter_mut().enumerate().filter(|(_, c)| c.perpendicular) {
        cluster.direction.unit = solution.unit(k);
        cluster.direction.covariance = solution.covariance(k);
    }
    Perpendicular { clusters: related, pairs: pairs.into_iter().map(described).collect(), left }
}

/// Directions as a Gaussian of tilts.
#[derive(Debug, Clone)]
struct State {
    /// One per cluster: the direction as it was seen, and its tangents.
    seen: Vec<(Vec3, Matrix3x2<f64>)>,
    /// Two per cluster: motion along the tangents.
    moved: DVector<f64>,
    covariance: DMatrix<f64>,
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
        Self { seen, moved: DVector::zeros(n), covariance }
    }

    /// The direction of a cluster.
    fn unit(&self, k: usize) -> UnitVec3 {
        let (seen, tangents) = &self.seen[k];
        UnitVec3::new_normalize(seen + tangents * self.moved.fixed_rows::<2>(2 * k))
    }

    /// Covariance of its coordinates.
    fn covariance(&self, k: usize) -> Mat3 {
        let tangents = &self.seen[k].1;
        let covariance = tangents * self.covariance.fixed_view::<2, 2>(2 * k, 2 * k) * tangents.transpose();
        let unit = self.unit(k);
        let flat = Mat3::identity() - unit.into_inner() * unit.transpose();
        flat * covariance * flat
    }

    /// Cosine of the angle of a pair and its derivative by the tilts of both.
    fn cosine(&self, (a, b): (usize, usize)) -> (f64, [(usize, f64); 4]) {
        let (ua, ub) = (self.unit(a), self.unit(b));
        let by_a = self.seen[a].1.transpose() * ub.into_inner();
        let by_b = self.seen[b].1.transpose() * ua.into_inner();
        let row = [(2 * a, by_a.x), (2 * a + 1, by_a.y), (2 * b, by_b.x), (2 * b + 1, by_b.y)];
        (ua.dot(&ub), row)
    }

    /// Variance of the cosine with derivative `row`.
    fn variance(&self, row: &[(usize, f64); 4]) -> f64 {
        let mut sum = 0.0;
        for &(i, x) in row {
            for &(j, y) in row {
                sum += x * y * self.covariance[(i, j)];
            }
        }
        sum
    }

    /// Makes the cosine with value `cosine` and derivative `row` zero, to first order.
    fn observe(&mut self, cosine: f64, row: &[(usize, f64); 4], variance: f64) {
        let mut effect = DVector::zeros(self.moved.len());
        for &(i, x) in row {
            effect.axpy(x, &self.covariance.column(i), 1.0);
        }
        self.moved.axpy(-cosine / variance, &effect, 1.0);
        self.covariance.ger(-1.0 / variance, &effect, &effect, 1.0);
    }

    /// The state nearest to what was seen in which all `pairs` are perpendicular; `None` without pairs, or when they
    /// contradict each other.
    fn solved(&self, pairs: &[(usize, usize)]) -> Option<Self> {
        if pairs.is_empty() {
            return None;
        }
        let mut state = self.clone();
        for _ in 0..STEPS {
            let mut jacobian = DMatrix::zeros(pairs.len(), self.moved.len());
            let mut aim = DVector::zeros(pairs.len());
            for (i, &pair) in pairs.iter().enumerate() {
                let (cosine, row) = state.cosine(pair);
                for (j, x) in row {
                    jacobian[(i, j)] = x;
                    aim[i] += x * state.moved[j];
                }
                aim[i] -= cosine;
            }
            let effect = &self.covariance * jacobian.transpose();
            let inverse = (&jacobian * &effect).cholesky()?.inverse();
            state.moved = &effect * (&inverse * aim);
            state.covariance = &self.covariance - &effect * inverse * effect.transpose();
        }
        state.moved.iter().all(|x| x.is_finite()).then_some(state)
    }
}

/// Pairs of clusters, by index.
type Pairs = Vec<(usize, usize)>;
/// Pairs with the reason why they are none.
type Refused = Vec<((usize, usize), String)>;

/// Pairs of clusters that are perpendicular by the evidence, best seen first, and others with the reason.
fn accepted(state: &State) -> (Pairs, Refused) {
    let n = state.seen.len();
    let mut candidates: Vec<(f64, (usize, usize))> = (0..n)
        .flat_map(|a| (a + 1..n).map(move |b| (a, b)))
        .map(|pair| (state.variance(&state.cosine(pair).1), pair))
        // The cosine of random directions is uniform.
        .filter(|(variance, _)| accident(*variance) < 1.0)
        .collect();
    candidates.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
    let mut state = state.clone();
    let mut pairs = Vec::new();
    let mut refused = Vec::new();
    let mut customs = vec![Custom::default(); n];
    for (at_first, pair) in candidates {
        let (cosine, row) = state.cosine(pair);
        let variance = state.variance(&row);
        if variance < DECIDED * at_first {
            continue;
        }
        let holds = cosine.abs() < MAX_SIGMAS * variance.sqrt();
        // What is the rule with the better seen of the two needs less evidence than what would be an exception.
        let custom = &mut customs[pair.0];
        if holds && custom.accident(accident(variance)) < MAX_ACCIDENT {
            state.observe(cosine, &row, variance);
            pairs.push(pair);
        } else if holds {
            refused.push((pair, "so badly seen that it may be by accident".to_owned()));
        } else {
            let z = cosine.abs() / variance.sqrt();
            refused.push((pair, format!("off by {z:.1} standard uncertainties")));
        }
        if accident(variance) < MAX_ACCIDENT {
            custom.count(holds);
        }
    }
    (pairs, refused)
}

/// Probability that random directions are perpendicular as well as is asked: their cosine is uniform in [-1, 1].
fn accident(variance: f64) -> f64 {
    MAX_SIGMAS * variance.sqrt()
}
