//! Which hypotheses to keep: a greedy cover that pays for every surface.
//!
//! The gain of a surface is what it saves over the best explanation so far, less a price per degree of freedom.
//! Costs below a dead zone count as equally good: without it a plane is tiled by patches that each follow the wavy
//! noise a little better.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::cover::Cover;
use super::field::{Field, Hypothesis};
use crate::par;
use crate::surface::SurfaceKind;

/// Costs below this are all perfect: two sigmas.
pub(super) const DEAD_ZONE: f32 = 3.5;
/// Cost of a vertex that nothing explains.
pub(super) const UNEXPLAINED: f32 = 15.0;
/// Price of one degree of freedom.
pub(super) const PRICE: f64 = 25.0;
/// Least gain of a surface worth having.
const MIN_GAIN: f64 = 120.0;

/// Selected surfaces in the order of their gain, each with its smoothed costs, and what they explain.
pub(super) fn select(field: &Field, hypotheses: &[Hypothesis]) -> (Vec<Hypothesis>, Cover) {
    let smoothed: Vec<Hypothesis> = par::map(hypotheses, |h| h.with_support(smooth(field, h)));
    let chosen = greedy(field, &smoothed);
    let chosen = exchange(field, &smoothed, chosen);
    let cover = Cover::of(field, chosen.iter().map(|&k| &smoothed[k]));
    (chosen.into_iter().map(|k| smoothed[k].clone()).collect(), cover)
}

/// Price of using a surface.
pub(super) fn price(hypothesis: &Hypothesis) -> f64 {
    PRICE * hypothesis.fit.surface.kind().degrees_of_freedom() as f64
}

/// What a hypothesis saves over `best`, less its price.
fn gain(hypothesis: &Hypothesis, best: &[f32]) -> f64 {
    let saved =
        hypothesis.support.iter().map(|&(v, c)| f64::from((best[v as usize] - c.max(DEAD_ZONE)).max(0.0)));
    saved.sum::<f64>() - price(hypothesis)
}

/// Indices of the hypotheses taken one by one, always the one that saves most.
fn greedy(field: &Field, hypotheses: &[Hypothesis]) -> Vec<usize> {
    let mut cover = Cover::new(field);
    let mut heap: BinaryHeap<Candidate> = hypotheses
        .iter()
        .enumerate()
        .map(|(index, h)| Candidate { gain: gain(h, &cover.best), index })
        .collect();
    let mut chosen = Vec::new();
    while let Some(top) = heap.pop() {
        if top.gain < MIN_GAIN {
            break;
        }
        // Gains only fall as the cover grows: a candidate is the best if its refreshed gain still is.
        let now = gain(&hypotheses[top.index], &cover.best);
        if heap.peek().is_some_and(|next| next.gain > now) {
            heap.push(Candidate { gain: now, index: top.index });
        } else if now >= MIN_GAIN {
            cover.add(field, &hypotheses[top.index]);
            chosen.push(top.index);
        }
    }
    chosen
}

/// Replaces surfaces that greed took too early: a torus over two chamfers and the ring between them saves more than
/// each of the three alone, but less than all three with their rounded edges.
fn exchange(field: &Field, hypotheses: &[Hypothesis], mut chosen: Vec<usize>) -> Vec<usize> {
    /// Rounds of trying every surface; an exchange rarely opens the way to another.
    const ROUNDS: usize = 2;
    for _ in 0..ROUNDS {
        let is_complex = |k: &usize| SurfaceKind::Cone <= hypotheses[*k].fit.surface.kind();
        let mut order: Vec<usize> = chosen.iter().copied().filter(is_complex).collect();
        order.sort_by_key(|&k| (Reverse(hypotheses[k].fit.surface.kind()), k));
        let mut n_exchanged = 0;
        let mut cover = Cover::of(field, chosen.iter().map(|&k| &hypotheses[k]));
        for k in order {
            let Some(at) = chosen.iter().position(|&c| c == k) else { continue };
            let Some(instead) = cover.replacement(field, hypotheses, &chosen, at) else { continue };
            chosen.remove(at);
            chosen.extend(instead);
            cover = Cover::of(field, chosen.iter().map(|&k| &hypotheses[k]));
            n_exchanged += 1;
        }
        if n_exchanged == 0 {
            break;
        }
    }
    chosen
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
