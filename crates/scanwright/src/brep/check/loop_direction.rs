//! Seen from outside, the outer loop of a face runs counter-clockwise and its holes clockwise, and all enclose something.

use super::Problem;
use crate::brep::domain::{Domain, Uv, signed_area};
use crate::brep::solid::{FaceId, Solid};

/// Share of the allowed gap below which a loop's mean width is none: its edges are one to every reader.
const NO_WIDTH: f64 = 1e-3;

pub(super) fn check(solid: &Solid, gap: f64) -> Vec<Problem> {
    let per_face = crate::par::map_indices(solid.faces.len(), |f| {
        let face = &solid.faces[f];
        let domain = Domain::new(solid, face);
        let seen_from_outside = if face.same_sense { 1.0 } else { -1.0 };
        // The coordinates of a spline are no lengths.
        let least_width = if solid.geometry(face).kind().is_some() { NO_WIDTH * gap } else { 0.0 };
        let (areas, least): (Vec<f64>, Vec<f64>) = face
            .loops
            .iter()
            .map(|l| domain.polygon(solid, l))
            .map(|polygon| (seen_from_outside * signed_area(&polygon), least_width * perimeter(&polygon)))
            .unzip();
        let outer = (0..areas.len()).max_by(|a, b| areas[*a].abs().total_cmp(&areas[*b].abs()));
        let wrong = |(index, area): &(usize, f64)| {
            area.is_nan()
                || if Some(*index) == outer { *area <= least[*index] } else { *area >= -least[*index] }
        };
        let wrong = areas.into_iter().enumerate().filter(wrong);
        wrong
            .map(|(index, area)| Problem::LoopDirection { face: FaceId(f as u32), index, area })
            .collect::<Vec<_>>()
    });
    per_face.into_iter().flatten().collect()
}

fn perimeter(polygon: &[Uv]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1])).sum()
}
