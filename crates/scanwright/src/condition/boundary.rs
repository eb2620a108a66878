//! Closed loops of boundary edges.

use crate::mesh::{Adjacency, Mesh, VertId};

/// Loops of directed edges that have no neighbour among the triangles that `keep` holds for, as these triangles run
/// along them; the vertices of each loop once. Where loops touch in a vertex they are split there.
pub(super) fn boundary_loops(
    mesh: &Mesh,
    adjacency: &Adjacency,
    keep: impl Fn(usize) -> bool,
) -> Vec<Vec<VertId>> {
    let mut edges: Vec<(VertId, VertId)> = Vec::new();
    for (t, triangle) in mesh.triangles.iter().enumerate().filter(|(t, _)| keep(*t)) {
        for k in 0..3 {
            if !adjacency.across[t][k].is_some_and(|u| keep(u as usize)) {
                edges.push((triangle[k], triangle[(k + 1) % 3]));
            }
        }
    }
    edges.sort_unstable();
    let mut used = vec![false; edges.len()];
    let mut loops = Vec::new();
    for first in 0..edges.len() {
        if !used[first] {
            walk(&edges, &mut used, first, &mut loops);
        }
    }
    loops
}

/// Follows edges from `first` and cuts off a loop whenever a vertex is met again.
fn walk(edges: &[(VertId, VertId)], used: &mut [bool], first: usize, loops: &mut Vec<Vec<VertId>>) {
    let mut path: Vec<VertId> = vec![edges[first].0];
    let mut next = Some(first);
    while let Some(e) = next {
        used[e] = true;
        let (_, to) = edges[e];
        // A vertex rarely has more than one outgoing edge, so the path itself is searched only at junctions.
        let from = edges.partition_point(|edge| edge.0 < to);
        let out = from..from + edges[from..].partition_point(|edge| edge.0 == to);
        let is_start = path[0] == to;
        let seen = if is_start {
            Some(0)
        } else if out.len() > 1 {
            path.iter().rposition(|v| *v == to)
        } else {
            None
        };
        if let Some(at) = seen {
            let closed: Vec<VertId> = path.drain(at..).collect();
            if closed.len() >= 3 {
                loops.push(closed);
            }
        }
        path.push(to);
        next = out.into_iter().find(|e| !used[*e]);
        if is_start {
            // What remains at the start vertex, if anything, begins a walk of its own.
            next = None;
        }
    }
}
