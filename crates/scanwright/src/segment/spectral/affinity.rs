//! How alike neighbours on the surface are.
//!
//! At the level of vertices the thesis's measure: `exp(-|n_i - n_j|^2 / s_n^2)`, over the one-ring. At the level of patches
//! ours: each patch's normals are taken as a linear function of the place, so that a patch of a round face and the next one
//! agree where they meet, and what is compared is the crease between them, and their curvatures.

use super::graph::Graph;
use super::patches::{Border, Patches};
use crate::segment::Field;

/// Difference of neighbouring vertices' normals that counts as much, beside their noise.
const VERTEX_TURN: f64 = 0.2;
/// Crease between patches that counts as much, radians, beside their noise: 4 degrees.
const PATCH_TURN: f64 = 0.07;
/// Difference of curvatures that counts as much, in radians over a patch.
const PATCH_BEND: f64 = 0.2;
/// Weight below which two neighbours count as cut; kept above zero so that the graph stays connected.
const LEAST: f64 = 1e-6;

/// The graph of the vertices.
pub(super) fn of_vertices(field: &Field, normal_noise: f64) -> Graph {
    let turn = VERTEX_TURN.max(normal_noise);
    let mut edges = Vec::new();
    for v in 0..field.n_vertices() {
        for &u in field.rings.row(v).iter().filter(|u| **u as usize > v) {
            let off_sq = (field.normals[v] - field.normals[u as usize]).norm_squared() / (turn * turn);
            edges.push((v as u32, u, (-off_sq).exp().max(LEAST)));
        }
    }
    Graph { n: field.n_vertices(), edges }
}

/// The graph of patches of triangles. `normal_noise`: deviation of the raw normals, radians.
pub(super) fn of_patches(patches: &Patches, normal_noise: f64) -> Graph {
    let edge = |border: &Border| {
        let [a, b] = border.between;
        let (pa, pb) = (&patches.all[a as usize], &patches.all[b as usize]);
        let fewest = pa.n_triangles.min(pb.n_triangles) as f64;
        let turn = PATCH_TURN.max(3.0 * normal_noise / fewest.sqrt());
        let crease = (pa.normal_at(&border.middle) - pb.normal_at(&border.middle)).norm() / turn;
        let size_sq = pa.area.min(pb.area);
        let bend_sq: f64 = pa.curvatures.iter().zip(pb.curvatures).map(|(x, y)| (x - y).powi(2)).sum::<f64>()
            * size_sq
            / (PATCH_BEND * PATCH_BEND);
        (a, b, border.length * (-crease * crease - bend_sq).exp().max(LEAST))
    };
    let edges = patches.borders.iter().map(edge).filter(|e| e.2 > 0.0).collect();
    Graph { n: patches.all.len(), edges }
}
