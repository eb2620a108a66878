//! Triangles of a solid: each face in its parameter plane by constrained Delaunay triangulation.
//!
//! Edges are sampled once, so faces meet without cracks. L. P. Chew, "Constrained Delaunay triangulations",
//! Algorithmica 4 (1989), 97-108, through the `spade` crate. A face whose loops cross in the parameter plane loses the
//! crossing constraints; the check names such faces. Cost O(n log n) per face and O(n * border) for the inside test.

use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

use super::assemble::use_points;
use super::domain::{ANGLE_STEP, Domain, Uv, inside, n_samples};
use super::solid::{EdgeUse, Face, FaceId, Solid};
use crate::math::Point3;
use crate::mesh::Mesh;

/// The triangles of a solid and the face that each belongs to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tessellation {
    /// The triangles, outward where the solid is right. Faces share the vertices of their common edges.
    pub mesh: Mesh,
    /// One per triangle.
    pub faces: Vec<FaceId>,
}

/// Triangles of a solid, about ten degrees of turn each.
pub fn tessellate(solid: &Solid) -> Tessellation {
    let mut vertices: Vec<Point3> = solid.vertices.iter().map(|v| v.point).collect();
    // Mesh vertices along every edge, in its direction, both ends included.
    let mut along: Vec<Vec<u32>> = Vec::with_capacity(solid.edges.len());
    for (i, edge) in solid.edges.iter().enumerate() {
        let n = n_samples(&edge.curve, &solid.point(edge.start), &solid.point(edge.end));
        let forward = EdgeUse { edge: super::solid::EdgeId(i as u32), forward: true };
        let points = use_points(solid, forward, n);
        let mut ids = vec![edge.start.0];
        for point in &points[1..n] {
            ids.push(vertices.len() as u32);
            vertices.push(*point);
        }
        ids.push(edge.end.0);
        along.push(ids);
    }
    let pieces =
        crate::par::map_indices(solid.faces.len(), |f| face_triangles(solid, &solid.faces[f], &along));
    let mut made = Tessellation { mesh: Mesh { vertices, triangles: Vec::new() }, faces: Vec::new() };
    for (f, (inner, triangles)) in pieces.into_iter().enumerate() {
        let base = made.mesh.vertices.len() as u32;
        made.mesh.vertices.extend(inner);
        for triangle in triangles {
            made.mesh.triangles.push(triangle.map(|v| match v {
                Node::Border(id) => id,
                Node::Inner(i) => base + i,
            }));
            made.faces.push(FaceId(f as u32));
        }
    }
    made
}

/// A corner of a triangle of one face.
#[derive(Debug, Clone, Copy)]
enum Node {
    /// A vertex shared along an edge.
    Border(u32),
    /// A vertex of this face alone.
    Inner(u32),
}

fn face_triangles(solid: &Solid, face: &Face, along: &[Vec<u32>]) -> (Vec<Point3>, Vec<[Node; 3]>) {
    let domain = Domain::new(solid, face);
    let polygons: Vec<Vec<Uv>> = face.loops.iter().map(|l| domain.polygon(solid, l)).collect();
    let mut cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut nodes: Vec<Option<Node>> = Vec::new();
    for (run, polygon) in face.loops.iter().zip(&polygons) {
        let mut ids = Vec::with_capacity(polygon.len());
        for edge_use in &run.uses {
            let mut edge = along[edge_use.edge.0 as usize].clone();
            if !edge_use.forward {
                edge.reverse();
            }
            ids.extend(&edge[..edge.len() - 1]);
        }
        let mut handles = Vec::with_capacity(polygon.len());
        for (uv, id) in polygon.iter().zip(&ids) {
            let Ok(handle) = cdt.insert(Point2::new(uv[0], uv[1])) else { continue };
            nodes.resize(nodes.len().max(handle.index() + 1), None);
            nodes[handle.index()].get_or_insert(Node::Border(*id));
            handles.push(handle);
        }
        for i in 0..handles.len() {
            let (a, b) = (handles[i], handles[(i + 1) % handles.len()]);
            if a != b && cdt.can_add_constraint(a, b) {
                cdt.add_constraint(a, b);
            }
        }
    }
    let mut inner = Vec::new();
    for uv in inner_points(&domain, &polygons) {
        let Ok(handle) = cdt.insert(Point2::new(uv[0], uv[1])) else { continue };
        if handle.index() >= nodes.len() {
            nodes.resize(handle.index() + 1, None);
            nodes[handle.index()] = Some(Node::Inner(inner.len() as u32));
            inner.push(domain.point(uv));
        }
    }
    let mut triangles = Vec::new();
    for triangle in cdt.inner_faces() {
        let corners = triangle.vertices();
        let [a, b, c] = corners.map(|v| v.position());
        let center = [(a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0];
        if is_flat([a, b, c]) || !inside(&polygons, center) {
            continue;
        }
        let [Some(a), Some(b), Some(c)] = corners.map(|v| nodes[v.fix().index()]) else { continue };
        triangles.push(if face.same_sense { [a, b, c] } else { [a, c, b] });
    }
    (inner, triangles)
}

/// Whether three corners lie on one line but for rounding: between the samples of an edge that is straight in the
/// parameter plane and the convex hull. In space such a triangle would span a bore from wall to wall.
fn is_flat([a, b, c]: [Point2<f64>; 3]) -> bool {
    const ROUNDING: f64 = 1e-7;
    let side = |p: Point2<f64>, q: Point2<f64>| (q.x - p.x).powi(2) + (q.y - p.y).powi(2);
    let longest_sq = side(a, b).max(side(b, c)).max(side(c, a));
    let twice_area = ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)).abs();
    twice_area < ROUNDING * longest_sq
}

/// Grid points inside the polygons, as dense as the surface turns.
fn inner_points(domain: &Domain, polygons: &[Vec<Uv>]) -> Vec<Uv> {
    /// Most grid lines in one direction: a bad surface must not cost the run.
    const MOST: usize = 72;
    /// Cells in a direction in which the surface is straight.
    const STRAIGHT_CELLS: f64 = 6.0;
    let steps = domain.steps(ANGLE_STEP);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for uv in polygons.iter().flatten() {
        for i in 0..2 {
            low[i] = low[i].min(uv[i]);
            high[i] = high[i].max(uv[i]);
        }
    }
    if steps == [None, None] || !(low[0] < high[0] && low[1] < high[1]) {
        return Vec::new();
    }
    let counts = [0, 1].map(|i| {
        let range = high[i] - low[i];
        let step = steps[i].unwrap_or(range / STRAIGHT_CELLS);
        ((range / step).ceil() as usize).clamp(2, MOST)
    });
    let mut points = Vec::new();
    for i in 1..counts[0] {
        for j in 1..counts[1] {
            let at =
                |axis: usize, k: usize| low[axis] + (high[axis] - low[axis]) * k as f64 / counts[axis] as f64;
            let uv = [at(0, i), at(1, j)];
            if inside(polygons, uv) {
                points.push(uv);
            }
        }
    }
    points
}
