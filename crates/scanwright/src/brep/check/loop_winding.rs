//! No loop goes round its surface: faces are cut so that none needs a seam (`split`), and a loop that still winds
//! about an axis or a tube's spine bounds nothing by itself. A face over a cone's apex shows the same way.

use super::Problem;
use crate::brep::domain::Domain;
use crate::brep::solid::{FaceId, Solid};

pub(super) fn check(solid: &Solid) -> Vec<Problem> {
    let per_face = crate::par::map_indices(solid.faces.len(), |f| {
        let face = &solid.faces[f];
        let domain = Domain::new(solid, face);
        let periods = domain.periods();
        let mut problems = Vec::new();
        for (index, run) in face.loops.iter().enumerate() {
            let polygon = domain.polygon(solid, run);
            let turns = |axis: usize, period: f64| {
                let next = polygon.iter().cycle().skip(1);
                let steps = polygon.iter().zip(next).map(|(a, b)| b[axis] - a[axis]);
                steps.map(|step| step / period - (step / period).round()).sum::<f64>().round()
            };
            let winds = (0..2).any(|axis| periods[axis].is_some_and(|period| turns(axis, period) != 0.0));
            if winds {
                problems.push(Problem::LoopWinds { face: FaceId(f as u32), index });
            }
        }
        problems
    });
    per_face.into_iter().flatten().collect()
}
