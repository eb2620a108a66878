//! Normal filtering by a thresholded mean.
//!
//! Each normal becomes the mean of those around it, itself included, weighted by `(n_i . n_j - T)^2` where the
//! product exceeds T and by zero elsewhere: neighbours across a crease have no say.
//! X. Sun, P. L. Rosin, R. R. Martin, F. C. Langbein, "Fast and effective feature-preserving mesh denoising", IEEE
//! Transactions on Visualization and Computer Graphics 13 (2007), 925-938. Neighbours share at least a vertex.
//!
//! Deviations: T follows the measured normal noise; weights are multiplied by area, since meshes from marching
//! cubes are full of slivers with wild normals; rounds stop when the normals stand still.
//! Cost O(n) per round. Fails where noise turns normals as far as the creases do: then T lets the crease through.

use crate::math::Vec3;

use super::neighborhood::{Neighborhood, repeat};

/// Options of the method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun2007 {
    /// The threshold is the cosine of this many standard deviations of the normals. Default 2.2: it reproduces the
    /// best thresholds that were found by search for noise of 0.25 to 0.8 edge lengths.
    pub threshold_sigmas: f64,
    /// Most rounds. Default 20.
    pub max_rounds: usize,
}

impl Default for Sun2007 {
    fn default() -> Self {
        Self { threshold_sigmas: 2.2, max_rounds: 20 }
    }
}

/// Range of the threshold: above it even slightly curved surfaces are left alone, below it nothing is a crease.
const THRESHOLD_RANGE: [f64; 2] = [0.15, 0.8];
/// Mean change per round, in standard deviations of the normals, that ends the iteration.
const STILL_SIGMAS: f64 = 0.02;

pub(super) fn run(
    neighborhood: &Neighborhood,
    raw: Vec<Vec3>,
    normal_noise: f64,
    options: &Sun2007,
) -> Vec<Vec3> {
    // Beyond a right angle the cosine would rise again.
    let angle = (options.threshold_sigmas * normal_noise).min(std::f64::consts::FRAC_PI_2);
    let threshold = angle.cos().clamp(THRESHOLD_RANGE[0], THRESHOLD_RANGE[1]);
    repeat(raw, options.max_rounds, STILL_SIGMAS * normal_noise, |normals, t| {
        let own = normals[t];
        let mut sum = Vec3::zeros();
        for &u in neighborhood.around(t) {
            let other = normals[u as usize];
            let excess = own.dot(&other) - threshold;
            if excess > 0.0 {
                sum += other * (excess * excess * neighborhood.areas[u as usize]);
            }
        }
        sum.try_normalize(0.0).unwrap_or(own)
    })
}
