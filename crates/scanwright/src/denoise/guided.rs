//! Guided normal filtering.
//!
//! As the bilateral filter, but the range weight compares *guidance* normals. The guidance of a triangle is the mean
//! normal of the most consistent of the patches that contain it, a patch being a triangle with all that share a
//! vertex with it: beside a crease that patch lies on one side.
//! Consistency is `max |n_a - n_b|` over the patch times the share of its largest inner edge in the sum over inner
//! edges of `|n_a - n_b|`; the smaller the better.
//! W. Zhang, B. Deng, J. Zhang, S. Bouaziz, L. Liu, "Guided mesh normal filtering", Computer Graphics Forum 34 (2015),
//! 23-34.
//!
//! Deviations: range deviation and number of rounds follow the measured normal noise; `max |n_a - n_b|` is taken as
//! the largest distance from the patch's mean, which is within a factor two of it and linear in the patch's size.
//! Cost O(n) per round, three times the bilateral's. Faces narrower than a patch have no consistent patch and lose
//! their normals to their neighbours.

use crate::math::Vec3;
use crate::mesh::{Adjacency, TriId};
use crate::par;

use super::bilateral::STILL_SIGMAS;
use super::neighborhood::Neighborhood;

/// Options of the method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guided {
    /// Standard deviation of the range weight in standard deviations of the normals. Default 1.
    pub range_sigmas: f64,
    /// Standard deviation of the spatial weight in mean distances of neighbouring centroids. Default 2.
    pub reach: f64,
    /// Most rounds. Default 10.
    pub max_rounds: usize,
}

impl Default for Guided {
    fn default() -> Self {
        Self { range_sigmas: 1.0, reach: 2.0, max_rounds: 10 }
    }
}

/// Largest range deviation: guidance normals are smooth, so less than the bilateral's is needed.
const MAX_RANGE: f64 = 0.35;
/// Difference of normals, in standard deviations of the normals, below which a patch's inner edges are flat: keeps
/// the share of the largest edge from deciding among patches without any.
const FLAT_SIGMAS: f64 = 0.01;

pub(super) fn run(
    neighborhood: &Neighborhood,
    adjacency: &Adjacency,
    raw: Vec<Vec3>,
    normal_noise: f64,
    options: &Guided,
) -> Vec<Vec3> {
    let range = (options.range_sigmas * normal_noise).min(MAX_RANGE);
    let spatial = neighborhood.spatial_weights(options.reach);
    let mut normals = raw;
    for _ in 0..options.max_rounds {
        let guidance = guidance(neighborhood, adjacency, &normals, normal_noise);
        let next = par::map_indices(normals.len(), |t| {
            let mut sum = Vec3::zeros();
            let weights = &spatial[neighborhood.offset(t)..];
            for (&u, weight) in neighborhood.around(t).iter().zip(weights) {
                let difference_sq = (guidance[t] - guidance[u as usize]).norm_squared();
                sum += normals[u as usize] * (weight * (-0.5 * difference_sq / (range * range)).exp());
            }
            sum.try_normalize(0.0).unwrap_or(normals[t])
        });
        let change: f64 = next.iter().zip(&normals).map(|(a, b)| (a - b).norm()).sum();
        let mean = change / (next.len().max(1) as f64);
        normals = next;
        if mean < STILL_SIGMAS * normal_noise {
            break;
        }
    }
    normals
}

/// Guidance normal of every triangle.
fn guidance(
    neighborhood: &Neighborhood,
    adjacency: &Adjacency,
    normals: &[Vec3],
    normal_noise: f64,
) -> Vec<Vec3> {
    let patches =
        par::map_indices(normals.len(), |t| patch(neighborhood, adjacency, normals, normal_noise, t));
    par::map_indices(normals.len(), |t| {
        let around = neighborhood.around(t).iter();
        let best = around.min_by(|a, b| patches[**a as usize].0.total_cmp(&patches[**b as usize].0));
        best.map_or(normals[t], |&u| patches[u as usize].1)
    })
}

/// Inconsistency and mean normal of the patch about triangle `t`.
fn patch(
    neighborhood: &Neighborhood,
    adjacency: &Adjacency,
    normals: &[Vec3],
    normal_noise: f64,
    t: usize,
) -> (f64, Vec3) {
    let around = neighborhood.around(t);
    let sum = around
        .iter()
        .fold(Vec3::zeros(), |sum, &u| sum + normals[u as usize] * neighborhood.areas[u as usize]);
    let mean = sum.try_normalize(0.0).unwrap_or(normals[t]);
    let spread = around.iter().map(|&u| (normals[u as usize] - mean).norm()).fold(0.0, f64::max);
    let (mut largest, mut total): (f64, f64) = (0.0, FLAT_SIGMAS * normal_noise);
    for &u in around {
        let inner = |w: &TriId| *w > u && around.binary_search(w).is_ok();
        for w in adjacency.across[u as usize].into_iter().flatten().filter(inner) {
            let difference = (normals[u as usize] - normals[w as usize]).norm();
            largest = largest.max(difference);
            total += difference;
        }
    }
    (spread * largest / total, mean)
}
