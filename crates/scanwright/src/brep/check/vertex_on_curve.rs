//! The vertices of an edge lie on its curve, at the ends of a spline.

use super::Problem;
use crate::brep::solid::{EdgeId, Solid};

pub(super) fn check(solid: &Solid, gap: f64) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (i, edge) in solid.edges.iter().enumerate() {
        for vertex in [edge.start, edge.end] {
            let distance = edge.curve.distance_to_end(&solid.point(vertex));
            if distance > gap || distance.is_nan() {
                problems.push(Problem::VertexOffCurve { vertex, edge: EdgeId(i as u32), distance, gap });
            }
        }
    }
    problems
}
