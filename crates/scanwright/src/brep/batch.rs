//! Several mends in one build: where they lie apart, each is judged by the flaws around it.

use super::attempt::{Attempt, Bench};
use super::halfedge::HalfEdges;
use super::mend::{Mend, WORTH, applied};
use crate::math::Point3;

/// Where a mend can be felt.
struct Reach {
    low: Point3,
    high: Point3,
}

impl Reach {
    fn of(bench: &Bench, attempt: &Attempt, mend: &Mend) -> Self {
        /// In spacings: an edge beside a mend moves with it, those behind it hardly.
        const BESIDE: f64 = 8.0;
        let mesh = &bench.closed.mesh;
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut take = |t: u32| {
            for p in mesh.corners(t as usize) {
                for i in 0..3 {
                    low[i] = low[i].min(p[i] - BESIDE * bench.tolerances.spacing());
                    high[i] = high[i].max(p[i] + BESIDE * bench.tolerances.spacing());
                }
            }
        };
        match mend {
            Mend::Relabel { triangles, .. } => triangles.iter().for_each(|t| take(*t)),
            Mend::Share { ends } => {
                let around = ends.iter().flat_map(|v| bench.half_edges.leaving(*v));
                around.for_each(|h| take(HalfEdges::triangle(*h) as u32));
            }
            Mend::Demote { region } | Mend::Restore { region, .. } => {
                let labels = attempt.choice.labels.iter().enumerate();
                labels.filter(|(_, l)| *l == region).for_each(|(t, _)| take(t as u32));
            }
        }
        Self { low: Point3::from(low), high: Point3::from(high) }
    }

    fn holds(&self, point: &Point3) -> bool {
        (0..3).all(|i| self.low[i] <= point[i] && point[i] <= self.high[i])
    }

    fn meets(&self, other: &Self) -> bool {
        (0..3).all(|i| self.low[i] <= other.high[i] && other.low[i] <= self.high[i])
    }

    /// Weight of the flaws within.
    fn severity(&self, attempt: &Attempt) -> f64 {
        let inside = attempt.flaws.iter().filter(|f| f.at.iter().any(|p| self.holds(p)));
        inside.map(|f| f.weight).sum()
    }
}

/// The first of `mends` and those after it that lie apart from all taken before.
pub(super) fn apart(bench: &Bench, attempt: &Attempt, mends: &[Mend]) -> Vec<Mend> {
    let mut taken: Vec<(Mend, Reach)> = Vec::new();
    for mend in mends {
        let reach = Reach::of(bench, attempt, mend);
        let alone = taken.iter().all(|(_, other)| !reach.meets(other));
        if alone && (taken.is_empty() || reach.severity(attempt) > 0.0) {
            taken.push((mend.clone(), reach));
        }
    }
    taken.into_iter().map(|(mend, _)| mend).collect()
}

/// The best attempt that `mends` of each attempt lead to, tried in their order; none twice, at most `max_trials` builds,
/// and only while the attempt is `unsound`.
pub(super) fn search(
    bench: &Bench,
    start: Attempt,
    max_trials: usize,
    unsound: impl Fn(&Attempt) -> bool,
    mends: impl Fn(&Attempt) -> Vec<Mend>,
) -> Attempt {
    let mut best = start;
    let mut tried: Vec<Mend> = Vec::new();
    let mut n_trials = 0;
    while n_trials < max_trials && unsound(&best) {
        let new: Vec<Mend> = mends(&best).into_iter().filter(|m| !tried.contains(m)).collect();
        let new = apart(bench, &best, &new);
        if new.is_empty() {
            break;
        }
        let (better, n) = batch(bench, &best, &new, 0.0, WORTH);
        n_trials += n;
        tried.extend(new);
        best = better.unwrap_or(best);
    }
    best
}

/// The best attempt with those of `mends` that lessen the flaws around them by a share and more than `worth`, if it is
/// better than `start`; and the number of builds.
pub(super) fn batch(
    bench: &Bench,
    start: &Attempt,
    mends: &[Mend],
    share: f64,
    worth: f64,
) -> (Option<Attempt>, usize) {
    let with = |mends: &[&Mend]| {
        bench.attempt(mends.iter().fold(start.choice.clone(), |choice, mend| applied(&choice, mend)))
    };
    let better = |a: &Attempt| a.severity() < start.severity() - worth;
    let all: Vec<&Mend> = mends.iter().collect();
    let trial = with(&all);
    if mends.len() == 1 {
        return (Some(trial).filter(better), 1);
    }
    let good: Vec<&Mend> = mends
        .iter()
        .filter(|mend| {
            let reach = Reach::of(bench, start, mend);
            let before = reach.severity(start);
            reach.severity(&trial) < before - (share * before).max(worth)
        })
        .collect();
    if good.len() == mends.len() || good.is_empty() {
        return (Some(trial).filter(better), 1);
    }
    let second = with(&good);
    let best = if second.severity() <= trial.severity() { second } else { trial };
    (Some(best).filter(better), 2)
}
