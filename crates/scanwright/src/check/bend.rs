//! How far the scanner's spot bends each vertex, where faces of different curvature meet without an edge.
//!
//! A spot of standard deviation b moves a vertex inwards by `b^2 / 2` times the sum of curvatures, and it sees that sum as it
//! sees everything, as a mean over itself: at the line where a fillet runs into a plane half of what it is inside. A fillet
//! as wide as a few spots would else seem of another radius.

use std::collections::BTreeSet;

use super::Sighting;
use crate::mesh::{Adjacency, Mesh, VertId};
use crate::par;

/// Deviations of the spot beyond which a vertex has no part in the mean.
const REACH: f64 = 2.5;
/// Vertices that a mean is taken over: bounds the cost where a scan is much finer than the spot.
const MOST: usize = 400;
/// Relative difference from which the bends of neighbours are two.
const DIFFERENT: f64 = 0.01;

/// Replaces the bend that each vertex has on its own face by the mean over the spot. `bend`: half the square of its deviation.
pub(super) fn averaged(of_vertex: &mut [Option<Sighting>], mesh: &Mesh, bend: f64) {
    if bend <= 0.0 {
        return;
    }
    let blur = (2.0 * bend).sqrt();
    let adjacency = Adjacency::new(mesh);
    let bent: Vec<Option<f64>> =
        of_vertex.iter().map(|s| s.filter(|s| !s.at_border).map(|s| s.bent)).collect();
    let is_mixed = par::map_indices(mesh.vertices.len(), |v| {
        let Some(own) = bent[v] else { return false };
        let beside = adjacency.vertex_vertices.row(v).iter().filter_map(|&w| bent[w as usize]);
        beside.into_iter().any(|other| (other - own).abs() > DIFFERENT * own.abs().max(other.abs()))
    });
    let spot = Spot { mesh, adjacency: &adjacency, bent: &bent, blur };
    let near: BTreeSet<VertId> = (0..mesh.vertices.len() as u32)
        .filter(|&v| is_mixed[v as usize])
        .flat_map(|v| spot.around(v))
        .collect();
    let near: Vec<VertId> = near.into_iter().collect();
    let means = par::map(&near, |&v| spot.mean(v));
    for (&v, mean) in near.iter().zip(means) {
        if let (Some(sighting), Some(mean)) = (&mut of_vertex[v as usize], mean) {
            sighting.bent = mean;
        }
    }
}

struct Spot<'a> {
    mesh: &'a Mesh,
    adjacency: &'a Adjacency,
    /// One per vertex: its bend on its own face; `None` beside an edge, where it is rounded instead.
    bent: &'a [Option<f64>],
    blur: f64,
}

impl Spot<'_> {
    /// Vertices within reach of `v` that are joined to it through such.
    fn around(&self, v: VertId) -> Vec<VertId> {
        let center = self.mesh.vertices[v as usize];
        let mut reached = vec![v];
        let mut known = BTreeSet::from([v]);
        let mut next = 0;
        while next < reached.len() && reached.len() < MOST {
            for &w in self.adjacency.vertex_vertices.row(reached[next] as usize) {
                let apart = (self.mesh.vertices[w as usize] - center).norm();
                if apart < REACH * self.blur && self.bent[w as usize].is_some() && known.insert(w) {
                    reached.push(w);
                }
            }
            next += 1;
        }
        reached
    }

    /// The mean bend about `v` with the spot's weights.
    fn mean(&self, v: VertId) -> Option<f64> {
        self.bent[v as usize]?;
        let center = self.mesh.vertices[v as usize];
        let (mut sum, mut total) = (0.0, 0.0);
        for w in self.around(v) {
            let apart = (self.mesh.vertices[w as usize] - center).norm() / self.blur;
            let weight = (-0.5 * apart * apart).exp();
            sum += weight * self.bent[w as usize].unwrap_or(0.0);
            total += weight;
        }
        Some(sum / total)
    }
}
