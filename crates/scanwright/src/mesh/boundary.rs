//! The boundary of a mesh as ordered loops.
//!
//! From a boundary half-edge `a -> b` the next one is found by turning about `b` from triangle to triangle, staying
//! in the fan that the half-edge belongs to. So loops that only touch at a vertex (bow-ties) stay apart.
//!
//! An edge of three or more triangles counts as boundary of each of them, as `Adjacency::across` has it; after
//! conditioning there are none. Cost O(n).

use super::{Adjacency, Mesh, VertId};

/// Closed loops of boundary vertices, first not repeated at the end, each following its half-edges with the mesh on
/// the left. Ordered by lowest triangle. A vertex where two fans meet occurs once per fan.
///
/// Where neighbouring triangles are oriented against each other the loop takes the sense of its lowest triangle.
pub fn boundary_loops(mesh: &Mesh, adjacency: &Adjacency) -> Vec<Vec<VertId>> {
    let mut visited = vec![[false; 3]; mesh.triangles.len()];
    let mut loops = Vec::new();
    for t in 0..mesh.triangles.len() {
        for k in 0..3 {
            if adjacency.across[t][k].is_none() && !visited[t][k] {
                loops.push(follow(mesh, adjacency, t, k, &mut visited));
            }
        }
    }
    loops
}

fn follow(mesh: &Mesh, adjacency: &Adjacency, t: usize, k: usize, visited: &mut [[bool; 3]]) -> Vec<VertId> {
    let mut vertices = Vec::new();
    let (mut t, mut k, mut to_corner) = (t, k, (k + 1) % 3);
    while !visited[t][k] {
        visited[t][k] = true;
        // The half-edge runs from its other corner to `to_corner`.
        let from_corner = if to_corner == k { (k + 1) % 3 } else { k };
        vertices.push(mesh.triangles[t][from_corner]);
        let Some(next) = turn(mesh, adjacency, t, k, to_corner) else { break };
        (t, k, to_corner) = next;
    }
    vertices
}

/// The boundary edge on the other side of the fan of triangle `t` about its corner `pivot`, starting from edge `k`:
/// triangle, edge and far corner. `None` only when triangles that use a vertex twice break the fan.
fn turn(
    mesh: &Mesh,
    adjacency: &Adjacency,
    mut t: usize,
    mut k: usize,
    mut pivot: usize,
) -> Option<(usize, usize, usize)> {
    let vertex = mesh.triangles[t][pivot];
    let longest_fan = adjacency.vertex_triangles.row(vertex as usize).len();
    for _ in 0..longest_fan {
        k = if k == pivot { (pivot + 2) % 3 } else { pivot };
        let Some(u) = adjacency.across[t][k] else {
            let far = if k == pivot { (k + 1) % 3 } else { k };
            return Some((t, k, far));
        };
        let far_vertex = mesh.triangles[t][if k == pivot { (k + 1) % 3 } else { k }];
        let corners = mesh.triangles[u as usize];
        let (next_k, next_pivot) = (0..3).find_map(|l| {
            let ends = (corners[l], corners[(l + 1) % 3]);
            match ends {
                _ if adjacency.across[u as usize][l] != Some(t as u32) => None,
                (a, b) if (a, b) == (vertex, far_vertex) => Some((l, l)),
                (a, b) if (b, a) == (vertex, far_vertex) => Some((l, (l + 1) % 3)),
                _ => None,
            }
        })?;
        (t, k, pivot) = (u as usize, next_k, next_pivot);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Point3;

    fn loops_of(n_vertices: usize, triangles: &[[VertId; 3]]) -> Vec<Vec<VertId>> {
        let vertices = (0..n_vertices).map(|i| Point3::new(i as f64, 0.0, 0.0)).collect();
        let mesh = Mesh { vertices, triangles: triangles.to_vec() };
        boundary_loops(&mesh, &Adjacency::new(&mesh))
    }

    #[test]
    fn a_square_has_one_loop_in_the_sense_of_its_triangles() {
        assert_eq!(loops_of(4, &[[0, 1, 2], [0, 2, 3]]), vec![vec![0, 1, 2, 3]]);
    }

    #[test]
    fn a_tetrahedron_has_none_and_without_a_triangle_one_against_it() {
        let tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        assert!(loops_of(4, &tetrahedron).is_empty());
        let open = loops_of(4, &tetrahedron[1..]);
        assert_eq!(open, vec![vec![0, 1, 2]]);
    }

    #[test]
    fn loops_that_touch_at_a_vertex_stay_apart() {
        //  1     4
        //  |\   /|
        //  | \ / |
        //  |  0  |
        //  | / \ |
        //  |/   \|
        //  2     3
        assert_eq!(loops_of(5, &[[0, 1, 2], [0, 3, 4]]), vec![vec![0, 1, 2], vec![0, 3, 4]]);
        // Neighbours in the fan are joined.
        let fan = loops_of(5, &[[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert_eq!(fan, vec![vec![0, 1, 2, 3, 4]]);
    }

    #[test]
    fn inconsistent_orientation_and_triple_edges_end() {
        assert_eq!(loops_of(4, &[[0, 1, 2], [0, 3, 2]]), vec![vec![0, 1, 2, 3]]);
        let triple = loops_of(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert_eq!(triple.iter().map(Vec::len).sum::<usize>(), 9);
        let degenerate = loops_of(2, &[[0, 1, 0], [0, 0, 0], [1, 1, 0]]);
        assert!(degenerate.iter().map(Vec::len).sum::<usize>() <= 9);
    }
}
