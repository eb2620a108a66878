//! How well a set of surfaces, and the rounded edges between them, explains every vertex.

use super::edge;
use super::field::{Field, Hypothesis, Scratch};
use super::select::{DEAD_ZONE, UNEXPLAINED};
use crate::fit::Fit;

/// Surfaces with the vertices near each of them.
#[derive(Debug)]
pub(super) struct Cover {
    /// The surfaces.
    pub fits: Vec<Fit>,
    /// One per vertex: lowest cost under any surface or edge.
    pub best: Vec<f32>,
    /// One per vertex: the surfaces whose support lies within reach of an edge's rounding.
    pub near: Vec<Vec<u32>>,
    scratch: Scratch,
    reach: usize,
}

/// Blurs beyond which an edge is not rounded any more.
const REACH_BLURS: f64 = 3.0;

impl Cover {
    /// Nothing explained.
    pub fn new(field: &Field) -> Self {
        let n = field.len();
        Self {
            fits: Vec::new(),
            best: vec![UNEXPLAINED; n],
            near: vec![Vec::new(); n],
            scratch: Scratch::new(n),
            reach: (REACH_BLURS * field.blur / field.spacing).ceil() as usize,
        }
    }

    /// Adds a surface with the vertices it explains itself.
    pub fn add(&mut self, field: &Field, hypothesis: &Hypothesis) {
        let index = self.fits.len() as u32;
        self.fits.push(hypothesis.fit);
        for &(v, cost) in &hypothesis.support {
            let slot = &mut self.best[v as usize];
            *slot = slot.min(cost.max(DEAD_ZONE));
        }
        let core: Vec<u32> = hypothesis.support.iter().map(|s| s.0).collect();
        for v in field.dilated(&core, self.reach, &mut self.scratch) {
            for k in 0..self.near[v as usize].len() {
                let other = self.fits[self.near[v as usize][k] as usize];
                let cost = edge::cost(field, &hypothesis.fit, &other, v) as f32;
                let slot = &mut self.best[v as usize];
                *slot = slot.min(cost.max(DEAD_ZONE));
            }
            self.near[v as usize].push(index);
        }
    }

    /// Cost of a vertex if it belongs to a surface: its own, or that of a rounded edge with a neighbour whose far side
    /// it is not on.
    pub fn cost(&self, field: &Field, label: u32, vertex: u32) -> f64 {
        let fit = &self.fits[label as usize];
        let mut cost = field.cost(fit, vertex);
        let near = &self.near[vertex as usize];
        if cost <= f64::from(DEAD_ZONE) || !near.contains(&label) {
            return cost;
        }
        let point = &field.points[vertex as usize];
        let distance = fit.surface.signed_distance(point).abs();
        for &other in near.iter().filter(|&&k| k != label) {
            let other = &self.fits[other as usize];
            let past = (distance - other.surface.signed_distance(point).abs()).max(0.0) / field.weights.distance_sigma;
            cost = cost.min(edge::cost(field, fit, other, vertex) + past);
        }
        cost
    }
}
