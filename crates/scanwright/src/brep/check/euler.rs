//! The counts are those of closed shells: V - E + F - (L - F) = 2 (S - G) with a genus G that is not negative.

use super::Problem;
use crate::brep::solid::Solid;

pub(super) fn check(solid: &Solid) -> Vec<Problem> {
    let mut used = vec![false; solid.vertices.len()];
    for edge in &solid.edges {
        used[edge.start.0 as usize] = true;
        used[edge.end.0 as usize] = true;
    }
    let vertices = used.iter().filter(|u| **u).count();
    let (edges, faces) = (solid.edges.len(), solid.faces.len());
    let holes: usize = solid.faces.iter().map(|f| f.loops.len().saturating_sub(1)).sum();
    let characteristic = (vertices + faces) as i64 - (edges + holes) as i64;
    let possible = characteristic % 2 == 0 && characteristic <= 2 * solid.shells.len() as i64;
    if possible { Vec::new() } else { vec![Problem::Euler { vertices, edges, faces, holes }] }
}
