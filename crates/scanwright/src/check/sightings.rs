//! Which face of the model each vertex of a scan shows, and how far from it the vertex lies.

use super::bend;
use crate::align::{Alignment, Part, Target};
use crate::math::{Point3, Vec3, stats};
use crate::par;

/// A vertex on the model, in the model's coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// The face: its place in the model's list.
    pub face: u32,
    /// The vertex.
    pub point: Point3,
    /// The place of the model it shows.
    pub foot: Point3,
    /// Its distance, positive outside; what the scanner's spot bends is taken off.
    pub distance: f64,
    /// The model's unit normal there, outward.
    pub normal: Vec3,
    /// How far the scanner's spot has bent the vertex inwards, length.
    pub bent: f64,
    /// Whether it lies where scanners round an edge, or beyond the border of the face.
    pub at_border: bool,
}

/// What a scan shows of a model.
#[derive(Debug, Clone)]
pub struct Sightings {
    /// One per vertex of the part; `None` where the model has no face near that looks the same way.
    pub of_vertex: Vec<Option<Sighting>>,
    /// Distance beyond which a vertex shows no face, length.
    pub reach: f64,
}

impl Sightings {
    /// The reach follows from the distances themselves: three times what 99 % of the vertices near the model keep.
    pub(super) fn new(target: &Target, part: &Part, alignment: &Alignment) -> Self {
        /// Share of the model's diagonal in which faces are looked for.
        const WIDEST: f64 = 0.05;
        const KEPT: f64 = 0.99;
        const TIMES: f64 = 3.0;
        let spacing = part.tolerances.spacing();
        let widest = (WIDEST * target.diagonal()).max(4.0 * spacing);
        let mut of_vertex = par::map_indices(part.mesh.vertices.len(), |v| {
            let point = alignment.pose.point(&part.mesh.vertices[v]);
            let normal = alignment.pose.rotation * part.normals[v];
            let hit = target.hit(&point, &normal, widest)?;
            let (face, foot) = (hit.face, hit.foot);
            let bent = alignment.bend * target.curvature(face, &point);
            let (distance, normal, at_border) = (hit.distance, hit.normal, hit.at_border);
            Some(Sighting { face, point, foot, distance, normal, bent, at_border })
        });
        bend::averaged(&mut of_vertex, &part.mesh, alignment.bend);
        for sighting in of_vertex.iter_mut().flatten() {
            sighting.distance += sighting.bent;
        }
        let mut sizes: Vec<f64> = of_vertex.iter().flatten().map(|s| s.distance.abs()).collect();
        let kept = stats::quantile(&mut sizes, KEPT).unwrap_or(0.0);
        let reach = (TIMES * kept).max(2.0 * spacing + 6.0 * alignment.sigma).min(widest);
        for sighting in &mut of_vertex {
            *sighting = sighting.filter(|s| s.distance.abs() <= reach);
        }
        Self { of_vertex, reach }
    }

    /// One per face of a model with so many: its sightings, clear of edges.
    pub(super) fn by_face(&self, n_faces: usize) -> Vec<Vec<Sighting>> {
        let mut faces = vec![Vec::new(); n_faces];
        for sighting in self.of_vertex.iter().flatten().filter(|s| !s.at_border) {
            faces[sighting.face as usize].push(*sighting);
        }
        faces
    }
}
