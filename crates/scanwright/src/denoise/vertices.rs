//! Vertices moved to agree with filtered normals.
//!
//! Each vertex moves by the mean, over its triangles, of the way along the filtered normal to the plane through the
//! triangle's centroid, a fixed number of times: the vertex update of Sun, Rosin, Martin and Langbein (2007).
//! Deviations: no vertex leaves its raw place by more than three deviations of the noise, which keeps the drift of
//! any number of rounds and the shrinking of small fillets within what the scan cannot show; boundary vertices stay.

use crate::math::{Point3, Vec3};
use crate::mesh::{Adjacency, Mesh};
use crate::par;

/// Rounds after which more no longer change the surface beside the noise.
pub(super) const ROUNDS: usize = 20;
/// Largest move in standard deviations of the noise.
const MAX_MOVE_SIGMAS: f64 = 3.0;

/// Positions that follow `triangle_normals`, one per vertex: `n_rounds` rounds from `start`, within the noise of the
/// raw places, which are those of `mesh`.
pub(super) fn follow_normals(
    mesh: &Mesh,
    adjacency: &Adjacency,
    start: Vec<Point3>,
    triangle_normals: &[Vec3],
    noise: f64,
    n_rounds: usize,
) -> Vec<Point3> {
    let largest = MAX_MOVE_SIGMAS * noise;
    let mut vertices = start;
    for _ in 0..n_rounds {
        let centers = par::map(&mesh.triangles, |triangle| {
            let [a, b, c] = triangle.map(|v| vertices[v as usize].coords);
            (a + b + c) / 3.0
        });
        vertices = par::map_indices(vertices.len(), |v| {
            let triangles = adjacency.vertex_triangles.row(v);
            if adjacency.on_boundary[v] || triangles.is_empty() {
                return vertices[v];
            }
            let moves = triangles.iter().fold(Vec3::zeros(), |sum, &t| {
                let normal = triangle_normals[t as usize];
                sum + normal * normal.dot(&(centers[t as usize] - vertices[v].coords))
            });
            let offset = vertices[v] + moves / triangles.len() as f64 - mesh.vertices[v];
            let length = offset.norm();
            mesh.vertices[v] + if length > largest { offset * (largest / length) } else { offset }
        });
    }
    vertices
}
