//! The nearest triangle of a mesh: a bounding-volume hierarchy split at the median of the longest axis.

use crate::math::{Point3, Vec3};
use crate::mesh::{Mesh, TriId};

/// Triangles per leaf. Four keep the tree shallow while a leaf is still cheaper than two more boxes.
const LEAF: usize = 4;

/// Answers which triangle of a mesh is nearest to a point.
#[derive(Debug, Clone)]
pub struct Nearest {
    corners: Vec<[Point3; 3]>,
    pseudonormals: Vec<Pseudonormals>,
    /// One per triangle here: which of the mesh it is.
    of_mesh: Vec<TriId>,
    nodes: Vec<Node>,
}

/// A triangle near a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// The triangle of the mesh.
    pub triangle: TriId,
    /// Its point nearest to the one asked about.
    pub closest: Point3,
    /// Where on the triangle that is.
    pub feature: Feature,
    /// Away from the mesh there; not of length one.
    pub outward: Vec3,
}

impl Found {
    /// Distance of `point`, which this was found for, positive outside.
    pub fn signed_distance(&self, point: &Point3) -> f64 {
        let way = point - self.closest;
        if way.dot(&self.outward) < 0.0 { -way.norm() } else { way.norm() }
    }
}

#[derive(Debug, Clone)]
struct Node {
    lo: Point3,
    hi: Point3,
    /// Triangles `start..end` of a leaf; of an inner node, `start` is its second child, the first follows it.
    start: u32,
    end: u32,
    leaf: bool,
}

/// Outward directions of a triangle's seven features.
#[derive(Debug, Clone)]
struct Pseudonormals {
    triangle: Vec3,
    edges: [Vec3; 3],
    corners: [Vec3; 3],
}

/// The part of a triangle that is nearest: edge `k` joins corners `k` and `k + 1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feature {
    /// A corner.
    Corner(usize),
    /// An edge, without its ends.
    Edge(usize),
    /// Neither.
    Inside,
}

impl Nearest {
    /// A hierarchy over the triangles of `mesh` that have an area; `None` when there are none.
    pub fn new(mesh: &Mesh) -> Option<Self> {
        let normals = mesh.triangle_normals();
        let mut order: Vec<u32> =
            (0..mesh.triangles.len() as u32).filter(|&t| normals[t as usize] != Vec3::zeros()).collect();
        if order.is_empty() {
            return None;
        }
        let centers: Vec<Point3> = (0..mesh.triangles.len()).map(|t| mesh.triangle_center(t)).collect();
        let mut nodes = Vec::new();
        let n = order.len();
        split(mesh, &centers, &mut order, 0, n, &mut nodes);
        let all = pseudonormals(mesh, &normals);
        let corners = order.iter().map(|&t| mesh.corners(t as usize)).collect();
        let pseudonormals = order.iter().map(|&t| all[t as usize].clone()).collect();
        Some(Self { corners, pseudonormals, of_mesh: order, nodes })
    }

    /// Distance of `point` to the mesh, positive outside.
    pub fn signed_distance(&self, point: &Point3) -> f64 {
        self.triangle_and_distance(point).1
    }

    /// The nearest triangle's place in the mesh, and the distance of `point` to it, positive outside; infinite where its
    /// square is no number.
    pub fn triangle_and_distance(&self, point: &Point3) -> (usize, f64) {
        self.find(point, f64::INFINITY, |_| true)
            .map_or((0, f64::INFINITY), |found| (found.triangle as usize, found.signed_distance(point)))
    }

    /// The nearest of the triangles that `accept` takes (by their number in the mesh) and that are nearer than `within`.
    pub fn find(&self, point: &Point3, within: f64, accept: impl Fn(TriId) -> bool) -> Option<Found> {
        let (mut best_sq, mut best) = (within * within, None);
        // A tree of 2^32 triangles is 32 deep, and a node leaves one brother behind.
        let mut stack = [(0_u32, 0.0_f64); 40];
        stack[0] = (0, self.distance_sq_to_box(0, point));
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (i, box_sq) = stack[depth];
            if box_sq >= best_sq {
                continue;
            }
            let node = &self.nodes[i as usize];
            if node.leaf {
                for t in node.start as usize..node.end as usize {
                    if !accept(self.of_mesh[t]) {
                        continue;
                    }
                    let (closest, feature) = closest_point(&self.corners[t], point);
                    let distance_sq = (point - closest).norm_squared();
                    if distance_sq < best_sq {
                        (best_sq, best) = (distance_sq, Some((t, feature, closest)));
                    }
                }
                continue;
            }
            let children = [i + 1, node.start].map(|c| (c, self.distance_sq_to_box(c as usize, point)));
            let near_first = children[0].1 <= children[1].1;
            // The last one pushed is looked at first.
            stack[depth] = children[usize::from(near_first)];
            stack[depth + 1] = children[usize::from(!near_first)];
            depth += 2;
        }
        best.map(|(t, feature, closest)| {
            let normals = &self.pseudonormals[t];
            let outward = match feature {
                Feature::Corner(k) => normals.corners[k],
                Feature::Edge(k) => normals.edges[k],
                Feature::Inside => normals.triangle,
            };
            Found { triangle: self.of_mesh[t], closest, feature, outward }
        })
    }

    /// Calls `visit` with every triangle whose leaf's box is nearer than `reach` to the box from `lo` to `hi`.
    pub fn for_each_near(&self, lo: &Point3, hi: &Point3, reach: f64, mut visit: impl FnMut(TriId)) {
        let mut stack = vec![0_usize];
        while let Some(i) = stack.pop() {
            let node = &self.nodes[i];
            let apart = (node.lo - hi).sup(&(lo - node.hi)).sup(&Vec3::zeros());
            if apart.norm_squared() > reach * reach {
                continue;
            }
            if node.leaf {
                (node.start..node.end).for_each(|t| visit(self.of_mesh[t as usize]));
            } else {
                stack.extend([i + 1, node.start as usize]);
            }
        }
    }

    fn distance_sq_to_box(&self, node: usize, point: &Point3) -> f64 {
        let Node { lo, hi, .. } = &self.nodes[node];
        let outside = (lo - point).sup(&(point - hi)).sup(&Vec3::zeros());
        outside.norm_squared()
    }
}

/// Appends the hierarchy over `order[start..end]`, a node before its children.
fn split(
    mesh: &Mesh,
    centers: &[Point3],
    order: &mut [u32],
    start: usize,
    end: usize,
    nodes: &mut Vec<Node>,
) {
    let first = mesh.corners(order[start] as usize)[0];
    let (mut lo, mut hi) = (first, first);
    for &t in &order[start..end] {
        for corner in mesh.corners(t as usize) {
            (lo, hi) = (lo.inf(&corner), hi.sup(&corner));
        }
    }
    let leaf = end - start <= LEAF;
    let this = nodes.len();
    nodes.push(Node { lo, hi, start: start as u32, end: end as u32, leaf });
    if leaf {
        return;
    }
    let axis = (hi - lo).imax();
    let middle = usize::midpoint(start, end);
    order[start..end].select_nth_unstable_by(middle - start, |&a, &b| {
        centers[a as usize][axis].total_cmp(&centers[b as usize][axis]).then(a.cmp(&b))
    });
    split(mesh, centers, order, start, middle, nodes);
    nodes[this].start = nodes.len() as u32;
    split(mesh, centers, order, middle, end, nodes);
}

/// The point of a triangle nearest to `point`, and where it lies.
///
/// C. Ericson, "Real-Time Collision Detection" (2005), section 5.1.5.
fn closest_point(&[a, b, c]: &[Point3; 3], point: &Point3) -> (Point3, Feature) {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, Feature::Corner(0));
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, Feature::Corner(1));
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3)), Feature::Edge(0));
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, Feature::Corner(2));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6)), Feature::Edge(2));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (b + (c - b) * along, Feature::Edge(1));
    }
    let sum = va + vb + vc;
    (a + ab * (vb / sum) + ac * (vc / sum), Feature::Inside)
}

/// Per triangle: its normal, the sums at its edges, and the angle-weighted sums at its corners.
fn pseudonormals(mesh: &Mesh, normals: &[Vec3]) -> Vec<Pseudonormals> {
    let adjacency = crate::mesh::Adjacency::new(mesh);
    let mut at_vertex = vec![Vec3::zeros(); mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let corners = mesh.corners(t);
        for k in 0..3 {
            let (u, v) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
            at_vertex[triangle[k] as usize] += normals[t] * crate::math::angle_between(&u, &v);
        }
    }
    let of_triangle = |t: usize| Pseudonormals {
        triangle: normals[t],
        edges: adjacency.across[t].map(|u| normals[t] + u.map_or(Vec3::zeros(), |u| normals[u as usize])),
        corners: mesh.triangles[t].map(|v| at_vertex[v as usize]),
    };
    (0..mesh.triangles.len()).map(of_triangle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of edge 2 about the origin.
    fn cube() -> Mesh {
        let sign = |bit: u32| if bit == 0 { -1.0 } else { 1.0 };
        let vertices =
            (0..8_u32).map(|i| Point3::new(sign(i & 1), sign(i >> 1 & 1), sign(i >> 2 & 1))).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Mesh { vertices, triangles }
    }

    #[test]
    fn distances_to_a_cube_are_exact_on_both_sides() {
        let nearest = Nearest::new(&cube()).unwrap();
        let check = |x: f64, y: f64, z: f64, expected: f64| {
            let got = nearest.signed_distance(&Point3::new(x, y, z));
            assert!((got - expected).abs() < 1e-12, "at {x} {y} {z}: got {got}, expected {expected}");
        };
        check(0.0, 0.0, 0.0, -1.0);
        check(0.5, 0.2, 0.1, -0.5);
        check(3.0, 0.1, -0.2, 2.0);
        check(2.0, 2.0, 0.0, 2.0_f64.sqrt());
        check(2.0, 2.0, 2.0, 3.0_f64.sqrt());
        check(-1.0, -1.0, -4.0, 3.0);
    }

    #[test]
    fn hierarchy_agrees_with_looking_at_every_triangle() {
        let mut rng = crate::random::Rng::for_task(1, "nearest", 0);
        let mut point = |size: f64| {
            let mut coordinate = || size * (rng.uniform() - 0.5);
            Point3::new(coordinate(), coordinate(), coordinate())
        };
        let vertices: Vec<Point3> = (0..300).map(|_| point(1.0)).collect();
        let triangles = (0..100).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh { vertices, triangles };
        let nearest = Nearest::new(&mesh).unwrap();
        for _ in 0..200 {
            let query = point(2.0);
            let expected = (0..100)
                .map(|t| (closest_point(&mesh.corners(t), &query).0 - query).norm())
                .fold(f64::INFINITY, f64::min);
            let got = nearest.signed_distance(&query).abs();
            assert!((got - expected).abs() < 1e-12, "got {got}, expected {expected}");
        }
    }

    #[test]
    fn triangles_without_area_are_nobodys_nearest() {
        let vertices = vec![Point3::origin(); 3];
        assert!(Nearest::new(&Mesh { vertices, triangles: vec![[0, 1, 2]] }).is_none());
    }
}
