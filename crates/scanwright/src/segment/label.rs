//! One surface per vertex: selection order, then iterated conditional modes.
//!
//! J. Besag, "On the statistical analysis of dirty pictures", Journal of the Royal Statistical Society B 48 (1986),
//! 259-302. Prototypes showed little to gain from graph cuts here: what carries the result is the selection.

use super::cover::Cover;
use super::field::{Field, Hypothesis};
use super::select::{DEAD_ZONE, UNEXPLAINED};
use crate::fit::Fit;

/// Cost of an edge between differently labelled vertices.
pub(super) const BORDER_COST: f64 = 5.0;
/// Sweeps over all vertices; changes die out after four or five.
const SWEEPS: usize = 8;

/// The surface of every vertex.
#[derive(Debug, Clone)]
pub struct Labels {
    /// One per vertex: index into `fits`.
    pub of_vertex: Vec<Option<u32>>,
    /// The surfaces.
    pub fits: Vec<Fit>,
}

impl Labels {
    /// Nothing labelled.
    pub(super) fn none(field: &Field) -> Self {
        Self { of_vertex: vec![None; field.n_vertices()], fits: Vec::new() }
    }

    /// Vertices of each connected set of one label, and its label.
    pub(super) fn components(&self, field: &Field) -> Vec<(u32, Vec<u32>)> {
        field.connected(|v| self.of_vertex[v as usize])
    }
}

/// Labels every vertex that a selected surface explains.
pub(super) fn label(field: &Field, selected: &[Hypothesis], cover: &Cover) -> Labels {
    let n = field.n_vertices();
    let mut cost = vec![UNEXPLAINED; n];
    let mut of_vertex: Vec<Option<u32>> = vec![None; n];
    for (k, hypothesis) in selected.iter().enumerate() {
        for &(v, c) in &hypothesis.support {
            let v = v as usize;
            let limit = if of_vertex[v].is_some() { cost[v].max(DEAD_ZONE) } else { cost[v] };
            if c < limit {
                cost[v] = c;
                of_vertex[v] = Some(k as u32);
            }
        }
    }
    // Rounded edges: the nearer of the two surfaces.
    for v in 0..n as u32 {
        if of_vertex[v as usize].is_some() && cost[v as usize] <= DEAD_ZONE {
            continue;
        }
        for &k in &cover.near[v as usize] {
            let c = cover.cost(field, k, v) as f32;
            if c < cost[v as usize] {
                cost[v as usize] = c;
                of_vertex[v as usize] = Some(k);
            }
        }
    }
    let mut labels = Labels { of_vertex, fits: selected.iter().map(|h| h.fit).collect() };
    for _ in 0..SWEEPS {
        if sweep(field, cover, &mut labels) == 0 {
            break;
        }
    }
    labels
}

/// One pass in vertex order; returns the number of changes.
fn sweep(field: &Field, cover: &Cover, labels: &mut Labels) -> usize {
    let mut n_changed = 0;
    for v in 0..field.n_vertices() {
        let ring = field.rings.row(v);
        let current = labels.of_vertex[v];
        if ring.iter().all(|&u| labels.of_vertex[u as usize] == current) {
            continue;
        }
        let energy = |label: Option<u32>| {
            let data = label
                .map_or(f64::from(UNEXPLAINED), |k| cover.cost(field, k, v as u32).max(f64::from(DEAD_ZONE)));
            let n_other = ring.iter().filter(|&&u| labels.of_vertex[u as usize] != label).count();
            data + BORDER_COST * n_other as f64
        };
        let mut best = (energy(current), current);
        let mut candidates: Vec<Option<u32>> = ring.iter().map(|&u| labels.of_vertex[u as usize]).collect();
        candidates.sort_unstable();
        candidates.dedup();
        for candidate in candidates {
            let e = energy(candidate);
            if e < best.0 {
                best = (e, candidate);
            }
        }
        if best.1 != current {
            labels.of_vertex[v] = best.1;
            n_changed += 1;
        }
    }
    n_changed
}
