//! Weights of a random walk over triangles.
//!
//! A particle on triangle `i` steps to one of the triangles around it, or stays, with a probability that falls off as
//! a Gaussian with the difference of the normals. The new normal of `i` is the mean of the normals weighted by the
//! probability that a walk of a fixed number of steps from `i` ends there.
//! X. Sun, P. L. Rosin, R. R. Martin, F. C. Langbein, "Random walks for mesh denoising", ACM Symposium on Solid and
//! Physical Modeling 2007, 11-22; "Random walks for feature-preserving mesh denoising", Computer Aided Geometric
//! Design 25 (2008), 437-456.
//!
//! Known from the papers' abstracts: walk of fixed length, Gaussian of the angle, a width that adapts, and that one step
//! applied again and again serves as well as long walks. Reconstructed: the width, which here follows the median
//! difference of normals across the edges and so shrinks as the noise goes. The papers move vertices by conjugate
//! gradients; here the update of the 2007 method does.
//!
//! The mean over the ends of a walk of k steps is k averagings with the same weights, so no probabilities of pairs are
//! kept: cost O(n k) per round.

use crate::math::{Vec3, stats};
use crate::mesh::Adjacency;
use crate::par;

use super::neighborhood::Neighborhood;

/// Width of the Gaussian in median differences of normals across edges: with 1, 1.5, 2 or 2.5 noise stays that is
/// taken for creases.
const WIDTH: f64 = 3.0;
/// Largest width, as length of the difference of unit normals: well below a square edge, 1.41. With 0.5 or 0.7 strong
/// noise stays.
const MAX_WIDTH: f64 = 1.0;

pub(super) fn run(
    neighborhood: &Neighborhood,
    adjacency: &Adjacency,
    raw: Vec<Vec3>,
    steps: usize,
    max_rounds: usize,
) -> Vec<Vec3> {
    let mut normals = raw;
    for _ in 0..max_rounds {
        let width = (WIDTH * median_difference(adjacency, &normals)).min(MAX_WIDTH);
        if width <= 0.0 {
            break;
        }
        let weight = |t: usize, u: usize| {
            let difference_sq = (normals[t] - normals[u]).norm_squared();
            (-0.5 * difference_sq / (width * width)).exp()
        };
        let rows = par::map_indices(normals.len(), |t| {
            neighborhood.around(t).iter().map(|&u| weight(t, u as usize)).collect::<Vec<f64>>()
        });
        let mut ends = normals.clone();
        for _ in 0..steps.max(1) {
            ends = par::map_indices(ends.len(), |t| {
                let total: f64 = rows[t].iter().sum();
                let steps = neighborhood.around(t).iter().zip(&rows[t]);
                steps.fold(Vec3::zeros(), |sum, (&u, weight)| sum + ends[u as usize] * (weight / total))
            });
        }
        normals = ends.iter().zip(&normals).map(|(n, old)| n.try_normalize(0.0).unwrap_or(*old)).collect();
    }
    normals
}

/// Median length of the difference of normals across an edge; zero without edges.
fn median_difference(adjacency: &Adjacency, normals: &[Vec3]) -> f64 {
    let mut differences = Vec::with_capacity(3 * normals.len() / 2);
    for (t, across) in adjacency.across.iter().enumerate() {
        for u in across.iter().flatten().map(|u| *u as usize).filter(|u| *u > t) {
            differences.push((normals[t] - normals[u]).norm());
        }
    }
    stats::median(&mut differences).unwrap_or(0.0)
}
