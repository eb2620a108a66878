//! Loops of a face neither cross each other nor themselves, in the parameter plane.
//!
//! Segments are swept by their lowest first coordinate, so the cost is about n log n for loops that are not stacked.

use super::Problem;
use crate::brep::domain::{Domain, Uv};
use crate::brep::solid::{EdgeId, FaceId, Solid};

/// A piece of an edge in the parameter plane.
struct Segment {
    ends: (Uv, Uv),
    edge: EdgeId,
}

pub(super) fn check(solid: &Solid) -> Vec<Problem> {
    let per_face = crate::par::map_indices(solid.faces.len(), |f| {
        let face = &solid.faces[f];
        let domain = Domain::new(solid, face);
        let mut segments: Vec<Segment> = Vec::new();
        for run in &face.loops {
            let (polygon, edges) = domain.polygon_with_edges(solid, run);
            let n = polygon.len();
            segments
                .extend((0..n).map(|i| Segment { ends: (polygon[i], polygon[(i + 1) % n]), edge: edges[i] }));
        }
        let (crossings, first) = count_crossings(&mut segments);
        first.map(|edges| Problem::LoopsCross { face: FaceId(f as u32), edges, crossings })
    });
    per_face.into_iter().flatten().collect()
}

/// The number of crossings and the edges of one of them.
fn count_crossings(segments: &mut [Segment]) -> (usize, Option<[EdgeId; 2]>) {
    let low = |s: &Segment| s.ends.0[0].min(s.ends.1[0]);
    segments.sort_by(|a, b| low(a).total_cmp(&low(b)));
    let (mut count, mut first) = (0, None);
    for (i, a) in segments.iter().enumerate() {
        let high = a.ends.0[0].max(a.ends.1[0]);
        for b in segments[i + 1..].iter().take_while(|b| low(b) <= high) {
            if crosses(&a.ends, &b.ends) {
                count += 1;
                first.get_or_insert([a.edge, b.edge]);
            }
        }
    }
    (count, first)
}

/// Whether the insides of two segments cross; touching ends do not.
fn crosses((a, b): &(Uv, Uv), (c, d): &(Uv, Uv)) -> bool {
    if [a, b].iter().any(|p| *p == c || *p == d) {
        return false;
    }
    let side = |p: &Uv, q: &Uv, r: &Uv| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
