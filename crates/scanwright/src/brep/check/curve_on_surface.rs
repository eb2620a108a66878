//! The curves of a face lie on its surface.

use super::Problem;
use crate::brep::assemble::use_points;
use crate::brep::domain::{Domain, n_samples};
use crate::brep::solid::{EdgeUse, FaceId, Solid};

/// Samples per drawn interval of a curve: between the points that it was made from, too.
const REFINE: usize = 2;
/// Fewest samples of an edge; a straight one may still leave a curved surface.
const FEWEST: usize = 8;

pub(super) fn check(solid: &Solid, gap: f64) -> Vec<Problem> {
    let per_face = crate::par::map_indices(solid.faces.len(), |f| {
        let face = &solid.faces[f];
        let domain = Domain::new(solid, face);
        let mut problems = Vec::new();
        for edge_use in face.loops.iter().flat_map(|l| &l.uses) {
            let distance = distance(solid, &domain, *edge_use);
            if distance.is_nan() || distance > gap {
                problems.push(Problem::CurveOffSurface {
                    edge: edge_use.edge,
                    face: FaceId(f as u32),
                    distance,
                    gap,
                });
            }
        }
        problems
    });
    per_face.into_iter().flatten().collect()
}

/// Largest distance of an edge's curve from the surface of a face.
pub(in crate::brep) fn distance(solid: &Solid, domain: &Domain, edge_use: EdgeUse) -> f64 {
    let edge = solid.edge(edge_use.edge);
    let n = n_samples(&edge.curve, &solid.point(edge.start), &solid.point(edge.end));
    let points = use_points(solid, edge_use, (REFINE * n).max(FEWEST));
    let off = points.iter().map(|p| domain.distance(p));
    // Not `max`: a distance that is no number must win.
    off.fold(0.0, |m: f64, d| if d <= m { m } else { d })
}
