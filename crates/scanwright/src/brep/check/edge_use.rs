//! Every edge is used exactly twice, once in each sense.

use super::Problem;
use crate::brep::solid::{EdgeId, Solid};

pub(super) fn check(solid: &Solid) -> Vec<Problem> {
    let mut uses = vec![[0, 0]; solid.edges.len()];
    for edge_use in solid.faces.iter().flat_map(|f| &f.loops).flat_map(|l| &l.uses) {
        uses[edge_use.edge.0 as usize][usize::from(!edge_use.forward)] += 1;
    }
    let wrong = uses.into_iter().enumerate().filter(|(_, u)| *u != [1, 1]);
    wrong
        .map(|(i, [forward, backward])| Problem::EdgeUse { edge: EdgeId(i as u32), forward, backward })
        .collect()
}
