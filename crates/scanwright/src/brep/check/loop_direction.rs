//! Seen from outside, the outer loop of a face runs counter-clockwise and its holes clockwise.

use super::Problem;
use crate::brep::domain::{Domain, signed_area};
use crate::brep::solid::{FaceId, Solid};

pub(super) fn check(solid: &Solid) -> Vec<Problem> {
    let per_face = crate::par::map_indices(solid.faces.len(), |f| {
        let face = &solid.faces[f];
        let domain = Domain::new(solid, face);
        let seen_from_outside = if face.same_sense { 1.0 } else { -1.0 };
        let areas: Vec<f64> =
            face.loops.iter().map(|l| seen_from_outside * signed_area(&domain.polygon(solid, l))).collect();
        let outer = (0..areas.len()).max_by(|a, b| areas[*a].abs().total_cmp(&areas[*b].abs()));
        let wrong = |(index, area): &(usize, f64)| {
            area.is_nan() || if Some(*index) == outer { *area <= 0.0 } else { *area >= 0.0 }
        };
        let wrong = areas.into_iter().enumerate().filter(wrong);
        wrong
            .map(|(index, area)| Problem::LoopDirection { face: FaceId(f as u32), index, area })
            .collect::<Vec<_>>()
    });
    per_face.into_iter().flatten().collect()
}
