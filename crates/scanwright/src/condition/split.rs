//! Cutting a triangle complex into a manifold: every edge of at most two triangles, every vertex of one fan.
//!
//! Where three or more triangles meet at an edge, those that continue each other are joined two by two and the rest
//! left apart. Then every vertex is given one copy per fan of joined triangles. A fan that winds about an edge more
//! than once would keep three triangles there; such edges are cut whole and the fans found anew, until none is left.
//! Guéziec, Taubin, Lazarus, Horn, "Cutting and stitching: converting sets of polygons to manifold surfaces", IEEE
//! Transactions on Visualization and Computer Graphics 7 (2001), 136-151; we stitch by angle where they stitch by
//! position.
//!
//! Cost O(n). Which sheets belong together is a guess where they touch; positions never change.

use super::half_edges::{HalfEdges, NONE, ends, for_each_edge};
use crate::math::Vec3;
use crate::mesh::{Mesh, VertId};

/// An edge of more triangles is cut whole: no surface comes together like that, and pairs grow with the square.
const LARGEST_CROWD: usize = 16;
/// Steps of the cosine between half-planes within which two pairs continue each other equally well: about one degree
/// at a right angle.
const COSINE_STEPS: f64 = 64.0;

/// Joins triangles over edges. Also returns how many edges have three or more.
pub(super) fn join(mesh: &Mesh) -> (HalfEdges, usize) {
    let mut half_edges = HalfEdges::apart(mesh.triangles.len());
    let mut n_crowded = 0;
    for_each_edge(mesh, |edge| match edge {
        [_] => {}
        [h, g] => half_edges.join(*h, *g),
        crowd => {
            n_crowded += 1;
            join_crowd(mesh, crowd, &mut half_edges);
        }
    });
    (half_edges, n_crowded)
}

/// Joins the half-edges of one edge two by two: first those of like orientation, then the flattest, then those that
/// enclose material rather than air.
fn join_crowd(mesh: &Mesh, crowd: &[u32], half_edges: &mut HalfEdges) {
    if LARGEST_CROWD < crowd.len() {
        return;
    }
    let planes: Vec<HalfPlane> = crowd.iter().map(|&h| HalfPlane::new(mesh, h)).collect();
    let mut pairs = Vec::new();
    for i in 0..crowd.len() {
        for j in 0..i {
            let (p, q) = (&planes[i], &planes[j]);
            let opposed = p.low_to_high == q.low_to_high;
            let folded = (p.inward.dot(&q.inward) * COSINE_STEPS).round() as i64;
            let concave = 0.0 < p.normal.dot(&q.inward);
            pairs.push((opposed, folded, concave, crowd[j], crowd[i]));
        }
    }
    pairs.sort_unstable();
    for (.., h, g) in pairs {
        if half_edges.twin[h as usize] == NONE && half_edges.twin[g as usize] == NONE {
            half_edges.join(h, g);
        }
    }
}

/// How a triangle leaves one of its edges.
struct HalfPlane {
    /// Unit, from the edge into the triangle.
    inward: Vec3,
    normal: Vec3,
    low_to_high: bool,
}

impl HalfPlane {
    fn new(mesh: &Mesh, h: u32) -> Self {
        let (a, b) = ends(mesh, h);
        let t = h as usize / 3;
        let unit = |v: Vec3| v.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        let normal = unit(mesh.cross(t));
        let along = unit(mesh.vertices[b as usize] - mesh.vertices[a as usize]);
        Self { inward: normal.cross(&along), normal, low_to_high: a < b }
    }
}

/// Gives every fan of joined triangles its own vertices: `mesh` keeps each vertex for the fan of lowest triangle and
/// has the copies at its end. Returns how many were added. `recheck` says that joins do not follow from vertex indices alone.
pub(super) fn split_vertices(mesh: &mut Mesh, half_edges: &mut HalfEdges, recheck: bool) -> usize {
    let original = mesh.triangles.clone();
    let n_original = mesh.vertices.len();
    loop {
        mesh.vertices.truncate(n_original);
        mesh.triangles.clone_from(&original);
        number_fans(mesh, half_edges);
        if !recheck || !cut_shared(mesh, half_edges) {
            break;
        }
    }
    mesh.vertices.len() - n_original
}

fn number_fans(mesh: &mut Mesh, half_edges: &HalfEdges) {
    let mut visited = vec![false; half_edges.twin.len()];
    let mut used = vec![false; mesh.vertices.len()];
    let (mut fan, mut stack) = (Vec::new(), Vec::new());
    for corner in 0..visited.len() as u32 {
        if visited[corner as usize] {
            continue;
        }
        let vertex = mesh.triangles[corner as usize / 3][corner as usize % 3];
        fan.clear();
        visited[corner as usize] = true;
        stack.push(corner);
        while let Some(c) = stack.pop() {
            fan.push(c);
            for neighbor in around(mesh, half_edges, c, vertex) {
                if !std::mem::replace(&mut visited[neighbor as usize], true) {
                    stack.push(neighbor);
                }
            }
        }
        if std::mem::replace(&mut used[vertex as usize], true) {
            let copy = mesh.vertices.len() as VertId;
            mesh.vertices.push(mesh.vertices[vertex as usize]);
            for &c in &fan {
                mesh.triangles[c as usize / 3][c as usize % 3] = copy;
            }
        }
    }
}

/// The corners at `vertex` of the triangles joined to corner `c` over the two edges that meet there.
fn around(mesh: &Mesh, half_edges: &HalfEdges, c: u32, vertex: VertId) -> impl Iterator<Item = u32> {
    let before = if c.is_multiple_of(3) { c + 2 } else { c - 1 };
    let twins = [half_edges.twin[c as usize], half_edges.twin[before as usize]];
    twins.into_iter().filter(|g| *g != NONE).map(move |g| {
        let (first, _) = ends(mesh, g);
        if first == vertex { g } else { super::half_edges::next(g) }
    })
}

/// Cuts edges that three or more triangles, or two that were kept apart, still share by index. Returns whether there
/// were any; ends because each call that returns true has cut a join or made the last one possible.
fn cut_shared(mesh: &Mesh, half_edges: &mut HalfEdges) -> bool {
    let mut changed = false;
    for_each_edge(mesh, |edge| match edge {
        [_] => {}
        [h, g] if half_edges.twin[*h as usize] == *g => {}
        [h, g] if ends(mesh, *h).0 != ends(mesh, *g).0 => half_edges.join(*h, *g),
        [h, _] => {
            // Both ends are one fan: only taking a triangle out of it opens the edge.
            let first = h / 3 * 3;
            (first..first + 3).for_each(|side| half_edges.cut(side));
            changed = true;
        }
        crowd => {
            for &h in crowd {
                half_edges.cut(h);
            }
            changed = true;
        }
    });
    changed
}
