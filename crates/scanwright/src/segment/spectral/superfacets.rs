//! Over-segmentation: many small patches that do not cross creases.
//!
//! Seeds spread over the triangles, each triangle given to the seed with the shortest way to it, where a way over a crease
//! is long; seeds moved to the middle of their patches, some rounds over.

use super::paths::from_nearest;
use crate::math::{Point3, Vec3};
use crate::mesh::{Adjacency, Mesh, TriId};
use crate::random::Rng;

/// Rounds of moving seeds.
const ROUNDS: usize = 3;
/// How much longer a way is per squared turn of the normal, in deviations of the normals.
const CREASE: f64 = 1.0;

/// The patch of every triangle: about `n` of them, at least one per connected part of the mesh.
///
/// `normals`: one per triangle. `normal_noise`: their deviation, radians.
pub(super) fn superfacets(
    mesh: &Mesh,
    adjacency: &Adjacency,
    normals: &[Vec3],
    normal_noise: f64,
    n: usize,
    seed: u64,
) -> Vec<u32> {
    let n_triangles = mesh.triangles.len();
    let centers: Vec<Point3> = (0..n_triangles).map(|t| mesh.triangle_center(t)).collect();
    let centers = centers.as_slice();
    let beside = move |t: u32| {
        let t = t as usize;
        let step = move |u: u32| {
            let turn = (normals[t] - normals[u as usize]).norm() / normal_noise.max(f64::MIN_POSITIVE);
            (u, (centers[t] - centers[u as usize]).norm() * (1.0 + CREASE * turn * turn))
        };
        adjacency.across[t].into_iter().flatten().map(step)
    };
    let mut rng = Rng::for_task(seed, "superfacets", 0);
    let stride = n_triangles as f64 / n.clamp(1, n_triangles.max(1)) as f64;
    let mut seeds: Vec<TriId> = (0..n.min(n_triangles))
        .map(|k| ((k as f64 + rng.uniform()) * stride).min(n_triangles as f64 - 1.0) as TriId)
        .collect();
    seeds.extend(first_of_parts(adjacency));
    seeds.sort_unstable();
    seeds.dedup();
    let (mut patch_of, _) = from_nearest(n_triangles, &seeds, beside);
    for _ in 0..ROUNDS {
        seeds = middles(mesh, centers, &patch_of, seeds.len());
        (patch_of, _) = from_nearest(n_triangles, &seeds, beside);
    }
    patch_of
}

/// The first triangle of every connected part.
fn first_of_parts(adjacency: &Adjacency) -> Vec<TriId> {
    let (part_of, n_parts) = adjacency.components();
    let mut first = vec![TriId::MAX; n_parts];
    for (t, part) in part_of.iter().enumerate().rev() {
        first[*part as usize] = t as TriId;
    }
    first
}

/// The triangle nearest to the middle of each patch.
fn middles(mesh: &Mesh, centers: &[Point3], patch_of: &[u32], n_patches: usize) -> Vec<TriId> {
    let mut sums = vec![(Vec3::zeros(), 0.0); n_patches];
    for (t, patch) in patch_of.iter().enumerate() {
        let area = mesh.area(t);
        let sum = &mut sums[*patch as usize];
        *sum = (sum.0 + centers[t].coords * area, sum.1 + area);
    }
    let mut nearest = vec![(f64::INFINITY, TriId::MAX); n_patches];
    for (t, patch) in patch_of.iter().enumerate() {
        let (sum, area) = sums[*patch as usize];
        let off = (centers[t].coords - sum / area.max(f64::MIN_POSITIVE)).norm_squared();
        let best = &mut nearest[*patch as usize];
        if off < best.0 || best.1 == TriId::MAX {
            *best = (off, t as TriId);
        }
    }
    // Every patch holds its seed.
    nearest.into_iter().map(|n| n.1).filter(|t| *t != TriId::MAX).collect()
}
