//! Sharp edges of a model, for the places near them that a scanner rounds.

use crate::deviation::Nearest;
use crate::math::{Point3, Vec3};
use crate::mesh::{Adjacency, Csr, TriId};
use crate::prior::PriorModel;

/// Sharp edges, listed with the triangles of the faces beside them.
#[derive(Debug)]
pub struct Borders {
    width: f64,
    edges: Vec<[Point3; 2]>,
    /// Per triangle: edges of its face within `width` of its leaf of the hierarchy.
    near: Csr,
}

/// Cosine of the turn across an edge beyond which it is sharp: 20 degrees, twice what the flats of a curved face turn.
const SHARP_COSINE: f64 = 0.939_7;

impl Borders {
    /// `normals`: one per triangle. An edge of one triangle only is sharp.
    pub fn new(
        model: &PriorModel,
        adjacency: &Adjacency,
        normals: &[Vec3],
        nearest: &Nearest,
        width: f64,
    ) -> Self {
        let (mut edges, mut pairs) = (Vec::new(), Vec::new());
        for (t, across) in adjacency.across.iter().enumerate() {
            let corners = model.mesh.corners(t);
            for (k, other) in across.iter().enumerate() {
                let face = model.face_of[t];
                let sharp = other.is_none_or(|u| {
                    face != model.face_of[u as usize] && normals[t].dot(&normals[u as usize]) < SHARP_COSINE
                });
                if !sharp {
                    continue;
                }
                let ends = [corners[k], corners[(k + 1) % 3]];
                let id = edges.len() as u32;
                edges.push(ends);
                let (lo, hi) = (ends[0].inf(&ends[1]), ends[0].sup(&ends[1]));
                nearest.for_each_near(&lo, &hi, width, |u| {
                    if model.face_of[u as usize] == face {
                        pairs.push((u, id));
                    }
                });
            }
        }
        let near = Csr::from_pairs(model.mesh.triangles.len(), pairs.iter().copied());
        Self { width, edges, near }
    }

    /// Whether `place`, on a triangle, is near a sharp edge of the triangle's face.
    pub fn near(&self, triangle: TriId, place: &Point3) -> bool {
        let mut edges = self.near.row(triangle as usize).iter();
        edges.any(|&e| distance_sq(&self.edges[e as usize], place) < self.width * self.width)
    }
}

fn distance_sq([a, b]: &[Point3; 2], p: &Point3) -> f64 {
    let along = b - a;
    let length_sq = along.norm_squared();
    let share = if length_sq > 0.0 { ((p - a).dot(&along) / length_sq).clamp(0.0, 1.0) } else { 0.0 };
    (p - (a + along * share)).norm_squared()
}
