//! One orientation per component, outward where that can be told.
//!
//! A flood over joined triangles compares neighbours. It crosses edges whose two triangles already agree before it
//! crosses any other, so that as few triangles as possible end up against what the file says and, on a surface that
//! cannot be oriented (a Möbius band), the cut falls where the file already disagrees with itself.
//!
//! Then each component is turned as a whole: closed or nearly closed ones so that their volume is positive, open ones
//! so that the larger area keeps the winding it came with: scanners know which side they saw.
//!
//! Cost O(n). A closed shell inside the largest component, wound inward throughout, is taken for a cavity and kept.

use super::half_edges::{HalfEdges, NONE, ends};
use crate::math::{Point3, Vec3};
use crate::mesh::Mesh;

/// Largest share of the area that a hole may have, guessed from the boundary's length as if it were one circle, for
/// the volume about the boundary's centre to have a sure sign.
const NEARLY_CLOSED: f64 = 0.05;

/// Orientation of every triangle.
#[derive(Debug)]
pub(super) struct Orientation {
    /// Per triangle, whether to swap two corners.
    pub flip: Vec<bool>,
    /// Per triangle, the component that it was reached in: over joins as they were before any cut.
    pub component: Vec<u32>,
    /// Number of these components.
    pub n_components: usize,
    /// Edges cut because the surface cannot be oriented across them.
    pub n_cut_edges: usize,
}

/// Finds the triangles of `mesh` to flip and cuts `half_edges` where no orientation is consistent.
pub(super) fn orient(mesh: &Mesh, half_edges: &mut HalfEdges) -> Orientation {
    let mut flood = Flood::new(mesh.triangles.len());
    for seed in 0..mesh.triangles.len() as u32 {
        flood.fill(mesh, half_edges, seed);
    }
    let Flood { component, mut flip, n_components, .. } = flood;
    let n_cut_edges = cut_conflicts(mesh, half_edges, &flip);
    let turn = components_to_turn(mesh, half_edges, &component, &flip, n_components);
    for (flip, &c) in flip.iter_mut().zip(&component) {
        *flip ^= turn[c as usize];
    }
    Orientation { flip, component, n_components, n_cut_edges }
}

struct Flood {
    component: Vec<u32>,
    flip: Vec<bool>,
    n_components: usize,
    /// Triangles whose agreeing neighbours are to be visited.
    agreeing: Vec<u32>,
    /// Triangles to visit when nothing agrees any more, with their flip.
    opposed: Vec<(u32, bool)>,
}

impl Flood {
    fn new(n_triangles: usize) -> Self {
        let (component, flip) = (vec![u32::MAX; n_triangles], vec![false; n_triangles]);
        Self { component, flip, n_components: 0, agreeing: Vec::new(), opposed: Vec::new() }
    }

    fn fill(&mut self, mesh: &Mesh, half_edges: &HalfEdges, seed: u32) {
        if self.component[seed as usize] != u32::MAX {
            return;
        }
        self.visit(seed, false);
        loop {
            while let Some(t) = self.agreeing.pop() {
                let flip = self.flip[t as usize];
                for (h, g) in half_edges.neighbors(t) {
                    let u = g / 3;
                    if self.component[u as usize] != u32::MAX {
                        continue;
                    }
                    if opposed(mesh, h, g) {
                        self.opposed.push((u, !flip));
                    } else {
                        self.visit(u, flip);
                    }
                }
            }
            let Some((t, flip)) = self.opposed.pop() else { break };
            if self.component[t as usize] == u32::MAX {
                self.visit(t, flip);
            }
        }
        self.n_components += 1;
    }

    fn visit(&mut self, t: u32, flip: bool) {
        self.component[t as usize] = self.n_components as u32;
        self.flip[t as usize] = flip;
        self.agreeing.push(t);
    }
}

/// Whether two joined half-edges run the same way, so that their triangles face opposite sides.
fn opposed(mesh: &Mesh, h: u32, g: u32) -> bool {
    ends(mesh, h).0 == ends(mesh, g).0
}

fn cut_conflicts(mesh: &Mesh, half_edges: &mut HalfEdges, flip: &[bool]) -> usize {
    let mut n_cut = 0;
    for h in 0..half_edges.twin.len() as u32 {
        let g = half_edges.twin[h as usize];
        if g != NONE && opposed(mesh, h, g) != (flip[h as usize / 3] != flip[g as usize / 3]) {
            half_edges.cut(h);
            n_cut += 1;
        }
    }
    n_cut
}

/// Sums over one component, with its triangles flipped as the flood left them.
#[derive(Debug, Clone)]
struct Sums {
    area: f64,
    flipped_area: f64,
    boundary_length: f64,
    /// Length-weighted sum of the boundary edges' middles, relative to `base`.
    boundary_moment: Vec3,
    base: Point3,
    lo: Point3,
    hi: Point3,
    six_volumes: f64,
}

fn components_to_turn(
    mesh: &Mesh,
    half_edges: &HalfEdges,
    component: &[u32],
    flip: &[bool],
    n_components: usize,
) -> Vec<bool> {
    let mut sums: Vec<Option<Sums>> = vec![None; n_components];
    for (t, &c) in component.iter().enumerate() {
        let corners = mesh.corners(t);
        let base = corners[0];
        let sums = sums[c as usize].get_or_insert_with(|| Sums {
            area: 0.0,
            flipped_area: 0.0,
            boundary_length: 0.0,
            boundary_moment: Vec3::zeros(),
            base,
            lo: base,
            hi: base,
            six_volumes: 0.0,
        });
        let area = mesh.area(t);
        sums.area += area;
        sums.flipped_area += if flip[t] { area } else { 0.0 };
        (sums.lo, sums.hi) = corners.iter().fold((sums.lo, sums.hi), |(lo, hi), p| (lo.inf(p), hi.sup(p)));
        for k in (0..3).filter(|k| half_edges.twin[3 * t + k] == NONE) {
            let (p, q) = (corners[k], corners[(k + 1) % 3]);
            let length = (q - p).norm();
            sums.boundary_length += length;
            sums.boundary_moment += length * 0.5 * ((p - sums.base) + (q - sums.base));
        }
    }
    let mut sums: Vec<Sums> = sums.into_iter().map(|s| s.expect("a component has triangles")).collect();
    // A flat hole subtends no volume from a point in its plane.
    let origins: Vec<Point3> = sums
        .iter()
        .map(
            |s| if s.boundary_length > 0.0 { s.base + s.boundary_moment / s.boundary_length } else { s.base },
        )
        .collect();
    for (t, &c) in component.iter().enumerate() {
        let [p, q, r] = mesh.corners(t).map(|p| p - origins[c as usize]);
        let six_volume = p.dot(&q.cross(&r));
        sums[c as usize].six_volumes += if flip[t] { -six_volume } else { six_volume };
    }
    let largest = sums.iter().max_by(|x, y| x.area.total_cmp(&y.area)).cloned();
    sums.iter().map(|s| s.turns(largest.as_ref().expect("there is one"))).collect()
}

impl Sums {
    fn turns(&self, largest: &Self) -> bool {
        let hole_area = self.boundary_length * self.boundary_length / (4.0 * std::f64::consts::PI);
        let nearly_closed = hole_area < NEARLY_CLOSED * self.area;
        if !nearly_closed || self.six_volumes == 0.0 {
            return 0.5 * self.area < self.flipped_area;
        }
        let unanimous = self.flipped_area == 0.0 || self.flipped_area == self.area;
        let given_inward = (self.six_volumes < 0.0) == (self.flipped_area == 0.0);
        let inside = (0..3).all(|axis| largest.lo[axis] < self.lo[axis] && self.hi[axis] < largest.hi[axis]);
        let cavity = self.boundary_length == 0.0 && unanimous && given_inward && inside;
        if cavity { self.flipped_area > 0.0 } else { self.six_volumes < 0.0 }
    }
}
