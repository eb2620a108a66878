//! Loops of a face neither cross each other nor themselves, in the parameter plane.
//!
//! Segments are swept by their lowest first coordinate, so the cost is about n log n for loops that are not stacked.

use super::Problem;
use crate::brep::domain::{Domain, Uv};
use crate::brep::solid::{FaceId, Solid};

pub(super) fn check(solid: &Solid) -> Vec<Problem> {
    let per_face = crate::par::map_indices(solid.faces.len(), |f| {
        let face = &solid.faces[f];
        let domain = Domain::new(solid, face);
        let mut segments: Vec<(Uv, Uv)> = Vec::new();
        for run in &face.loops {
            let polygon = domain.polygon(solid, run);
            let n = polygon.len();
            segments.extend((0..n).map(|i| (polygon[i], polygon[(i + 1) % n])));
        }
        let crossings = count_crossings(&mut segments);
        (crossings > 0).then_some(Problem::LoopsCross { face: FaceId(f as u32), crossings })
    });
    per_face.into_iter().flatten().collect()
}

fn count_crossings(segments: &mut [(Uv, Uv)]) -> usize {
    let low = |s: &(Uv, Uv)| s.0[0].min(s.1[0]);
    segments.sort_by(|a, b| low(a).total_cmp(&low(b)));
    let mut count = 0;
    for (i, a) in segments.iter().enumerate() {
        let high = a.0[0].max(a.1[0]);
        for b in segments[i + 1..].iter().take_while(|b| low(b) <= high) {
            count += usize::from(crosses(a, b));
        }
    }
    count
}

/// Whether the insides of two segments cross; touching ends do not.
fn crosses((a, b): &(Uv, Uv), (c, d): &(Uv, Uv)) -> bool {
    if [a, b].iter().any(|p| *p == c || *p == d) {
        return false;
    }
    let side = |p: &Uv, q: &Uv, r: &Uv| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
