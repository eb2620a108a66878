//! Bilateral normal filtering.
//!
//! Each normal becomes the mean of those around it, weighted by area, by a Gaussian of the centroids' distance and by
//! a Gaussian of the difference of the normals.
//! Y. Zheng, H. Fu, O. K.-C. Au, C.-L. Tai, "Bilateral normal filtering for mesh denoising", IEEE Transactions on
//! Visualization and Computer Graphics 17 (2011), 1521-1530; the local, iterative scheme.
//!
//! Deviations: the range deviation and the number of rounds follow the measured normal noise.
//! Cost O(n) per round. Under strong noise creases are crossed before the noise is gone.

use crate::math::Vec3;

use super::neighborhood::{Neighborhood, repeat};

/// Options of the method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bilateral {
    /// Standard deviation of the range weight in standard deviations of the normals. Default 1.5.
    pub range_sigmas: f64,
    /// Standard deviation of the spatial weight in mean distances of neighbouring centroids. Default 1.
    pub reach: f64,
    /// Most rounds. Default 20.
    pub max_rounds: usize,
}

impl Default for Bilateral {
    fn default() -> Self {
        Self { range_sigmas: 1.5, reach: 1.0, max_rounds: 20 }
    }
}

/// Largest range deviation, as length of the difference of unit normals: beyond it a square edge, 1.41, is crossed.
const MAX_RANGE: f64 = 0.5;
/// Mean change per round, in standard deviations of the normals, that ends the iteration.
const STILL_SIGMAS: f64 = 0.02;

pub(super) fn run(
    neighborhood: &Neighborhood,
    raw: Vec<Vec3>,
    normal_noise: f64,
    options: &Bilateral,
) -> Vec<Vec3> {
    let range = (options.range_sigmas * normal_noise).min(MAX_RANGE);
    let spatial = neighborhood.spatial_weights(options.reach);
    repeat(raw, options.max_rounds, STILL_SIGMAS * normal_noise, |normals, t| {
        let own = normals[t];
        let mut sum = Vec3::zeros();
        let weights = &spatial[neighborhood.offset(t)..];
        for (&u, weight) in neighborhood.around(t).iter().zip(weights) {
            let other = normals[u as usize];
            sum += other * (weight * (-0.5 * (own - other).norm_squared() / (range * range)).exp());
        }
        sum.try_normalize(0.0).unwrap_or(own)
    })
}
