//! Normal filtering by a thresholded mean, or by the end of a random walk.
//!
//! Each normal becomes the mean of those around it, itself included, weighted by `(n_i . n_j - T)^2` where the
//! product exceeds T and by zero elsewhere: neighbours across a crease have no say.
//! X. Sun, P. L. Rosin, R. R. Martin, F. C. Langbein, "Fast and effective feature-preserving mesh denoising", IEEE
//! Transactions on Visualization and Computer Graphics 13 (2007), 925-938.
//! The same authors' random walks are an alternative weighting (`random_walk`).
//!
//! Deviation: T follows the measured normal noise. Which neighbours the thesis took, and how it adapted the method,
//! is not known: neighbours share a vertex unless told otherwise.
//! Cost O(n) per round. Fails where noise turns normals as far as the creases do: then T lets the crease through.
//! Rounds are not stopped early, so smooth surfaces with little noise are flattened more than need be.

use crate::math::Vec3;
use crate::mesh::Adjacency;

use super::neighborhood::{Neighborhood, Neighbors, repeat};
use super::random_walk;

/// Options of the method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun2007 {
    /// The threshold is the cosine of this many standard deviations of the normals, within 0.15 to 0.65. Default 2:
    /// close to the best thresholds that a search found for noise of 0.25 to 0.8 edge lengths (0.65, 0.5, 0.2).
    pub threshold_sigmas: f64,
    /// Whose normals are averaged. Default: triangles that share a vertex.
    pub neighbors: Neighbors,
    /// How they are weighted. Default: by the threshold.
    pub weighting: Weighting,
    /// Rounds. Default 20.
    pub max_rounds: usize,
}

/// How [`Sun2007`] weights the normals around a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weighting {
    /// By the square of what the product of the normals exceeds the threshold by.
    #[default]
    Threshold,
    /// By the probability that a random walk of so many steps from the triangle ends there; steps across creases are
    /// improbable.
    RandomWalk {
        /// At least one; one is as good as more, says the source.
        steps: usize,
    },
}

impl Default for Sun2007 {
    fn default() -> Self {
        Self {
            threshold_sigmas: 2.0,
            neighbors: Neighbors::default(),
            weighting: Weighting::default(),
            max_rounds: 20,
        }
    }
}

/// Range of the threshold: above it strong noise is left alone, below it nothing is a crease.
const THRESHOLD_RANGE: [f64; 2] = [0.15, 0.65];

pub(super) fn run(
    neighborhood: &Neighborhood,
    adjacency: &Adjacency,
    raw: Vec<Vec3>,
    normal_noise: f64,
    options: &Sun2007,
) -> Vec<Vec3> {
    if let Weighting::RandomWalk { steps } = options.weighting {
        return random_walk::run(neighborhood, adjacency, raw, steps, options.max_rounds);
    }
    // Beyond a right angle the cosine would rise again.
    let angle = (options.threshold_sigmas * normal_noise).min(std::f64::consts::FRAC_PI_2);
    let threshold = angle.cos().clamp(THRESHOLD_RANGE[0], THRESHOLD_RANGE[1]);
    repeat(raw, options.max_rounds, 0.0, |normals, t| {
        let own = normals[t];
        let mut sum = Vec3::zeros();
        for &u in neighborhood.around(t) {
            let other = normals[u as usize];
            let excess = own.dot(&other) - threshold;
            if excess > 0.0 {
                sum += other * (excess * excess);
            }
        }
        sum.try_normalize(0.0).unwrap_or(own)
    })
}
