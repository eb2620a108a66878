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
//! After each round of the normals the vertices follow, and the next round starts from the normals of the moved mesh, as
//! in the paper's algorithm: filtered normals need not belong to any surface, those of a mesh do.
//!
//! Deviations: the range deviation follows the measured normal noise; rounds end when the vertices have moved by the
//! noise, root mean square over all (the discrepancy principle: V. A. Morozov, "On the solution of functional equations
//! by the method of regularization", Soviet Mathematics Doklady 7 (1966), 414-417); `max |n_a - n_b|` is taken as the
//! largest distance from the patch's mean, which is within a factor two of it and linear in the patch's size.
//! Cost O(n) per round, ten times the bilateral's. Faces narrower than a patch have no consistent patch and lose their
//! normals to their neighbours.

use crate::math::Vec3;
use crate::mesh::{Adjacency, Mesh, TriId};
use crate::par;
use crate::tolerance::Tolerances;

use super::Denoised;
use super::neighborhood::{Neighborhood, Neighbors};
use super::vertices::follow_normals;

/// Options of the method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guided {
    /// Standard deviation of the range weight in standard deviations of the normals. Default 1.
    pub range_sigmas: f64,
    /// Standard deviation of the spatial weight in mean distances of neighbouring centroids. Default 2.
    pub reach: f64,
    /// Most rounds. Default 20.
    pub max_rounds: usize,
}

impl Default for Guided {
    fn default() -> Self {
        Self { range_sigmas: 1.0, reach: 2.0, max_rounds: 20 }
    }
}

/// Largest range deviation, as length of the difference of unit normals: guidance normals are smooth, so half the
/// bilateral's is enough (of 0.2, 0.25, 0.3 and 0.35 those in the middle leave least on a part with sharp edges).
const MAX_RANGE: f64 = 0.25;
/// Difference of normals, in standard deviations of the normals, below which a patch's inner edges are flat: keeps
/// the share of the largest edge from deciding among patches without any.
const FLAT_SIGMAS: f64 = 0.01;
/// Rounds of the vertices after each of the normals.
const VERTEX_ROUNDS: usize = 10;

pub(super) fn run(mesh: &Mesh, adjacency: &Adjacency, tolerances: &Tolerances, options: &Guided) -> Denoised {
    let normal_noise = tolerances.normal_noise();
    let range = (options.range_sigmas * normal_noise).min(MAX_RANGE);
    let mut neighborhood = Neighborhood::new(mesh, adjacency, Neighbors::Vertex);
    let mut moved = mesh.clone();
    let mut triangle_normals = mesh.triangle_normals();
    for _ in 0..options.max_rounds {
        // Normals of the moved mesh, not the filtered ones: they are those of a surface, which filtered normals alone
        // need not be, and that takes a quarter off the error.
        let normals = normals_or(&moved, triangle_normals);
        triangle_normals = filtered(&neighborhood, adjacency, &normals, normal_noise, range, options.reach);
        let start = std::mem::take(&mut moved.vertices);
        moved.vertices =
            follow_normals(mesh, adjacency, start, &triangle_normals, tolerances.noise(), VERTEX_ROUNDS);
        neighborhood.measure(&moved, adjacency);
        if is_noise_gone(mesh, &moved, tolerances.noise()) {
            break;
        }
    }
    Denoised { triangle_normals, vertices: moved.vertices }
}

/// Normals of the triangles of `mesh`; of those without area, `else_normals`.
fn normals_or(mesh: &Mesh, else_normals: Vec<Vec3>) -> Vec<Vec3> {
    let normals = mesh.triangle_normals().into_iter().zip(else_normals);
    normals.map(|(n, other)| if n == Vec3::zeros() { other } else { n }).collect()
}

/// Whether as much has been taken off as there was: what would come off next is the surface itself.
fn is_noise_gone(raw: &Mesh, moved: &Mesh, noise: f64) -> bool {
    let sum: f64 = raw.vertices.iter().zip(&moved.vertices).map(|(a, b)| (a - b).norm_squared()).sum();
    sum >= noise * noise * raw.vertices.len() as f64
}

/// One round of the filter.
fn filtered(
    neighborhood: &Neighborhood,
    adjacency: &Adjacency,
    normals: &[Vec3],
    normal_noise: f64,
    range: f64,
    reach: f64,
) -> Vec<Vec3> {
    let guidance = guidance(neighborhood, adjacency, normals, normal_noise);
    let spatial = neighborhood.spatial_weights(reach);
    par::map_indices(normals.len(), |t| {
        let mut sum = Vec3::zeros();
        let weights = &spatial[neighborhood.offset(t)..];
        for (&u, weight) in neighborhood.around(t).iter().zip(weights) {
            let difference_sq = (guidance[t] - guidance[u as usize]).norm_squared();
            sum += normals[u as usize] * (weight * (-0.5 * difference_sq / (range * range)).exp());
        }
        sum.try_normalize(0.0).unwrap_or(normals[t])
    })
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
