//! How well a set of surfaces, and the rounded edges between them, explains every vertex.

use super::edge;
use super::field::{Field, Hypothesis, Scratch};
use super::select::{DEAD_ZONE, UNEXPLAINED, price};
use crate::fit::Fit;
use crate::par;

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
        let n = field.n_vertices();
        Self {
            fits: Vec::new(),
            best: vec![UNEXPLAINED; n],
            near: vec![Vec::new(); n],
            scratch: Scratch::new(n),
            reach: (REACH_BLURS * field.blur / field.spacing).ceil() as usize,
        }
    }

    /// What these surfaces explain together.
    pub fn of<'h>(field: &Field, hypotheses: impl Iterator<Item = &'h Hypothesis>) -> Self {
        let mut cover = Self::new(field);
        for hypothesis in hypotheses {
            cover.add(field, hypothesis);
        }
        cover
    }

    /// Hypotheses that together explain the surroundings of the chosen surface at `at` better than it does, prices
    /// included; `None` when there are none. `chosen`: indices into `hypotheses`, in the order of this cover.
    pub fn replacement(
        &mut self,
        field: &Field,
        hypotheses: &[Hypothesis],
        chosen: &[usize],
        at: usize,
    ) -> Option<Vec<usize>> {
        /// Surfaces that may replace one: a ring and the chamfers and rims on both sides.
        const MOST: usize = 5;
        let old = &hypotheses[chosen[at]];
        let core: Vec<u32> = old.support.iter().map(|s| s.0).collect();
        let mut local = Local::new(self, field, &core, at as u32);
        let old_total: f64 =
            local.vertices.iter().map(|&v| f64::from(self.best[v as usize])).sum::<f64>() + price(old);
        let candidates: Vec<usize> = (0..hypotheses.len())
            .filter(|k| !chosen.contains(k) && local.overlap(&hypotheses[*k]) > 0.3)
            .collect();
        let mut added: Vec<usize> = Vec::new();
        let mut total: f64 = local.best.iter().map(|b| f64::from(*b)).sum();
        while added.len() < MOST {
            let trials = candidates.iter().filter(|k| !added.contains(k)).map(|&k| {
                let best = local.with(field, self, &hypotheses[k], &added, hypotheses);
                (best.iter().map(|b| f64::from(*b)).sum::<f64>() + price(&hypotheses[k]), k, best)
            });
            let Some((next, k, best)) = trials.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))) else {
                break;
            };
            if next >= total {
                break;
            }
            total = next;
            local.best = best;
            added.push(k);
        }
        (total < old_total).then_some(added)
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
            if let Some(ground) = field.ground_near(v) {
                let slot = &mut self.best[v as usize];
                *slot = slot.min((edge::cost(field, &hypothesis.fit, ground, v) as f32).max(DEAD_ZONE));
            }
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
        if !self.near[vertex as usize].contains(&label) {
            return field.cost(&self.fits[label as usize], vertex);
        }
        self.cost_under(field, &self.fits[label as usize], &[label], vertex)
    }

    /// The same for any surface, its edges with the surfaces of `except` left out.
    pub fn cost_under(&self, field: &Field, fit: &Fit, except: &[u32], vertex: u32) -> f64 {
        let mut cost = field.cost(fit, vertex);
        if cost <= f64::from(DEAD_ZONE) {
            return cost;
        }
        let near = &self.near[vertex as usize];
        let point = &field.points[vertex as usize];
        let distance = fit.surface.signed_distance(point).abs();
        if let Some(ground) = field.ground_near(vertex) {
            cost = cost.min(edge::cost(field, fit, ground, vertex));
        }
        for &other in near.iter().filter(|k| !except.contains(k)) {
            let other = &self.fits[other as usize];
            let past = (distance - other.surface.signed_distance(point).abs()).max(0.0)
                / field.weights.distance_sigma;
            cost = cost.min(edge::cost(field, fit, other, vertex) + past);
        }
        cost
    }
}

/// The surroundings of one surface, explained without it.
struct Local {
    vertices: Vec<u32>,
    /// Position in `vertices` of each vertex of the mesh, plus one; zero elsewhere.
    place: Vec<u32>,
    without: u32,
    best: Vec<f32>,
}

impl Local {
    fn new(cover: &mut Cover, field: &Field, core: &[u32], without: u32) -> Self {
        let reach = cover.reach;
        let vertices = field.dilated(core, reach, &mut cover.scratch);
        let mut place = vec![0; field.n_vertices()];
        for (i, &v) in vertices.iter().enumerate() {
            place[v as usize] = i as u32 + 1;
        }
        let best = par::map(&vertices, |&v| {
            let near: Vec<&Fit> = cover.near[v as usize]
                .iter()
                .filter(|&&k| k != without)
                .map(|&k| &cover.fits[k as usize])
                .collect();
            let mut best = UNEXPLAINED;
            for (i, fit) in near.iter().enumerate() {
                best = best.min(field.cost(fit, v) as f32);
                if let Some(ground) = field.ground_near(v) {
                    best = best.min(edge::cost(field, fit, ground, v) as f32);
                }
                for other in &near[..i] {
                    best = best.min(edge::cost(field, fit, other, v) as f32);
                }
            }
            best.max(DEAD_ZONE)
        });
        Self { vertices, place, without, best }
    }

    /// Share of a hypothesis' support that lies here.
    fn overlap(&self, hypothesis: &Hypothesis) -> f64 {
        let n = hypothesis.support.iter().filter(|s| self.place[s.0 as usize] > 0).count();
        n as f64 / hypothesis.support.len().max(1) as f64
    }

    /// Best costs once `hypothesis` is added, with its edges to the surfaces near and to those added before.
    fn with(
        &self,
        field: &Field,
        cover: &Cover,
        hypothesis: &Hypothesis,
        added: &[usize],
        hypotheses: &[Hypothesis],
    ) -> Vec<f32> {
        let mut best = self.best.clone();
        for &(v, cost) in &hypothesis.support {
            let place = self.place[v as usize];
            if place > 0 {
                let slot = &mut best[place as usize - 1];
                *slot = slot.min(cost.max(DEAD_ZONE));
            }
        }
        // Only what is still badly explained and close to the surface can gain from its edges.
        let close = 3.0 * field.blur + 3.0 * field.weights.distance_sigma;
        for (slot, &v) in best.iter_mut().zip(&self.vertices) {
            let distance = hypothesis.fit.surface.signed_distance(&field.points[v as usize]).abs();
            if *slot <= DEAD_ZONE || distance > close {
                continue;
            }
            let near = cover.near[v as usize]
                .iter()
                .filter(|&&k| k != self.without)
                .map(|&k| &cover.fits[k as usize]);
            let added = added.iter().map(|&k| &hypotheses[k].fit);
            for other in near.chain(added).chain(field.ground_near(v)) {
                *slot = slot.min((edge::cost(field, &hypothesis.fit, other, v) as f32).max(DEAD_ZONE));
            }
        }
        best
    }
}
