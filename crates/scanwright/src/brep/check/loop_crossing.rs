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
        let (crossings, first) = crossings(&mut segments);
        first.map(|edges| Problem::LoopsCross {
            face: FaceId(f as u32),
            edges,
            crossings: crossings.len(),
            places: crossings.into_iter().take(MOST_PLACES).map(|uv| domain.point(uv)).collect(),
        })
    });
    per_face.into_iter().flatten().collect()
}

/// Crossings that are located: more show no other fault.
const MOST_PLACES: usize = 20;

/// The crossings and the edges of the first of them.
fn crossings(segments: &mut [Segment]) -> (Vec<Uv>, Option<[EdgeId; 2]>) {
    let low = |s: &Segment| s.ends.0[0].min(s.ends.1[0]);
    segments.sort_by(|a, b| low(a).total_cmp(&low(b)));
    let (mut found, mut first) = (Vec::new(), None);
    for (i, a) in segments.iter().enumerate() {
        let high = a.ends.0[0].max(a.ends.1[0]);
        for b in segments[i + 1..].iter().take_while(|b| low(b) <= high) {
            if crosses(&a.ends, &b.ends) {
                found.push(crossing(&a.ends, &b.ends));
                first.get_or_insert([a.edge, b.edge]);
            }
        }
    }
    (found, first)
}

/// Where the lines of two segments that cross meet.
fn crossing((a, b): &(Uv, Uv), (c, d): &(Uv, Uv)) -> Uv {
    let side = |p: &Uv| (d[0] - c[0]) * (p[1] - c[1]) - (d[1] - c[1]) * (p[0] - c[0]);
    let share = side(a) / (side(a) - side(b));
    [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
}

/// Whether the insides of two segments cross; touching ends do not.
fn crosses((a, b): &(Uv, Uv), (c, d): &(Uv, Uv)) -> bool {
    if [a, b].iter().any(|p| *p == c || *p == d) {
        return false;
    }
    let side = |p: &Uv, q: &Uv, r: &Uv| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
