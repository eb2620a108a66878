//! Which hypotheses to keep: a greedy cover that pays for every surface.
//!
//! The gain of a surface is what it saves over the best explanation so far, less a price per degree of freedom.
//! Costs below a dead zone count as equally good: without it a plane is tiled by patches that each follow the wavy
//! noise a little better.

use std::collections::BinaryHeap;

use super::cover::Cover;
use super::field::{Field, Hypothesis};
use crate::par;

/// Costs below this are all perfect: two sigmas.
pub(super) const DEAD_ZONE: f32 = 3.5;
/// Cost of a vertex that nothing explains.
pub(super) const UNEXPLAINED: f32 = 15.0;
/// Price of one degree of freedom.
const PRICE: f64 = 25.0;
/// Least gain of a surface worth having.
const MIN_GAIN: f64 = 120.0;

/// Selected surfaces in the order of their gain, each with its smoothed costs.
pub(super) fn select(field: &Field, hypotheses: &[Hypothesis]) -> (Vec<Hypothesis>, Cover) {
    let smoothed = par::map(hypotheses, |h| smooth(field, h));
    let price: Vec<f64> =
        hypotheses.iter().map(|h| PRICE * h.fit.surface.kind().degrees_of_freedom() as f64).collect();
    let mut cover = Cover::new(field);
    let gain = |k: usize, best: &[f32]| {
        let sum: f64 =
            smoothed[k].iter().map(|&(v, c)| f64::from((best[v as usize] - c.max(DEAD_ZONE)).max(0.0))).sum();
        sum - price[k]
    };
    let mut heap: BinaryHeap<Candidate> =
        (0..hypotheses.len()).map(|k| Candidate { gain: gain(k, &cover.best), index: k }).collect();
    let mut selected = Vec::new();
    while let Some(top) = heap.pop() {
        if top.gain < MIN_GAIN {
            break;
        }
        // Gains only fall as the cover grows: a candidate is the best if its refreshed gain still is.
        let now = gain(top.index, &cover.best);
        if heap.peek().is_some_and(|next| next.gain > now) {
            heap.push(Candidate { gain: now, index: top.index });
            continue;
        }
        if now < MIN_GAIN {
            continue;
        }
        let hypothesis = Hypothesis {
            support: smoothed[top.index].clone(),
            fit: hypotheses[top.index].fit,
            mean_cost: hypotheses[top.index].mean_cost,
            lack: hypotheses[top.index].lack,
        };
        cover.add(field, &hypothesis);
        selected.push(hypothesis);
    }
    (selected, cover)
}

/// Mean cost over each supporting vertex and its supporting ring.
fn smooth(field: &Field, hypothesis: &Hypothesis) -> Vec<(u32, f32)> {
    let mut sorted = hypothesis.support.clone();
    sorted.sort_unstable_by_key(|s| s.0);
    let cost_of = |v: u32| sorted.binary_search_by_key(&v, |s| s.0).ok().map(|i| sorted[i].1);
    sorted
        .iter()
        .map(|&(v, cost)| {
            let (mut sum, mut n) = (cost, 1.0);
            for &u in field.rings.row(v as usize) {
                // A neighbour that the surface does not reach speaks against it, within reason.
                sum += cost_of(u).unwrap_or(super::grow::SUPPORT_COST as f32);
                n += 1.0;
            }
            (v, sum / n)
        })
        .collect()
}

#[derive(Debug, PartialEq)]
struct Candidate {
    gain: f64,
    index: usize,
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.gain.total_cmp(&other.gain).then(other.index.cmp(&self.index))
    }
}
