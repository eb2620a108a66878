//! Triangles of a face, in its parameter plane.
//!
//! Constrained Delaunay triangulation (L. P. Chew, "Constrained Delaunay triangulations", Algorithmica 4 (1989),
//! 97-108, through the `spade` crate) in coordinates that count permissible steps, so that triangles are long where the
//! surface is straight. Grid points first; then sides whose middles are too far from the surface are halved.

use std::collections::{BTreeMap, VecDeque};

use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

use super::layout::{Layout, Node, Polygon};
use super::patch::{Patch, Shape, Uv};
use crate::math::Point3;
use crate::tolerance::Tolerances;

/// Most points inside one face.
const MOST_INSIDE: usize = 60_000;

/// Most sides that all rows of a grid meet together; a border with more gets no grid.
const MOST_CROSSINGS: f64 = 2e7;

/// Triangles that fill the layout, counter-clockwise in the parameter plane; the face's own vertices grow in `layout`.
/// `None` where a number is beyond what can be triangulated.
pub(super) fn fill(
    patch: &Patch,
    layout: &mut Layout,
    shared: &[Point3],
    tolerance: f64,
) -> Option<Vec<[Node; 3]>> {
    let mut sheet = Sheet { steps: layout.steps, ..Sheet::default() };
    for polygon in &layout.polygons {
        sheet.border(polygon)?;
    }
    if !matches!(patch.shape, Shape::Plane) {
        for p in grid(layout) {
            sheet.inner(p, patch, &mut layout.own)?;
        }
        for _ in 0..ROUNDS {
            let coarse = sheet.coarse(patch, layout, shared, tolerance);
            if coarse.is_empty() || sheet.nodes.len() > 2 * MOST_INSIDE {
                break;
            }
            for p in coarse {
                sheet.inner(p, patch, &mut layout.own)?;
            }
        }
    }
    Some(sheet.triangles(&layout.polygons))
}

/// Halvings of sides that are too coarse.
const ROUNDS: usize = 6;

/// A face being triangulated.
#[derive(Default)]
struct Sheet {
    cdt: ConstrainedDelaunayTriangulation<Point2<f64>>,
    /// One per vertex of the triangulation.
    nodes: Vec<Option<Node>>,
    /// How often a border runs along a side, by its two vertices.
    uses: BTreeMap<(usize, usize), u32>,
    /// Whether a border had to be left out because it crosses another.
    crossed: bool,
    steps: Uv,
}

impl Sheet {
    fn scaled(&self, [u, v]: Uv) -> Option<Point2<f64>> {
        /// Numbers that exact predicates refuse: smaller ones are none, and where one is larger there is no point.
        const SMALLEST: f64 = 1e-60;
        let clean = |x: f64| if x.abs() < SMALLEST { 0.0 } else { x };
        let p = Point2::new(clean(u / self.steps[0]), clean(v / self.steps[1]));
        (p.x.abs().max(p.y.abs()) < 1.0 / SMALLEST).then_some(p)
    }

    fn border(&mut self, polygon: &Polygon) -> Option<()> {
        let mut handles = Vec::with_capacity(polygon.len());
        for (uv, node) in polygon {
            let handle = self.cdt.insert(self.scaled(*uv)?).ok()?;
            self.nodes.resize(self.nodes.len().max(handle.index() + 1), None);
            self.nodes[handle.index()].get_or_insert(*node);
            if handles.last() != Some(&handle) {
                handles.push(handle);
            }
        }
        for (i, a) in handles.iter().enumerate() {
            let b = handles[(i + 1) % handles.len()];
            if *a == b {
                continue;
            }
            let ends = (a.index().min(b.index()), a.index().max(b.index()));
            *self.uses.entry(ends).or_default() += 1;
            if self.cdt.can_add_constraint(*a, b) {
                self.cdt.add_constraint(*a, b);
            } else {
                self.crossed = true;
            }
        }
        Some(())
    }

    fn inner(&mut self, uv: Uv, patch: &Patch, own: &mut Vec<Point3>) -> Option<()> {
        let handle = self.cdt.insert(self.scaled(uv)?).ok()?;
        if handle.index() >= self.nodes.len() {
            self.nodes.resize(handle.index() + 1, None);
            self.nodes[handle.index()] = Some(Node::Own(own.len() as u32));
            own.push(patch.point(uv));
        }
        Some(())
    }

    /// Whether each triangle is inside, by how many borders lie between it and the outside. Where borders cross, by the
    /// place of its centre.
    fn inside(&self, polygons: &[Polygon]) -> Vec<bool> {
        let n = self.cdt.num_all_faces();
        let mut inside = vec![None; n];
        let mut open = VecDeque::new();
        inside[self.cdt.outer_face().fix().index()] = Some(false);
        open.push_back(self.cdt.outer_face());
        while let Some(face) = open.pop_front() {
            let here = inside[face.fix().index()].unwrap_or(false);
            let edges: Vec<_> = match face.as_inner() {
                Some(inner) => inner.adjacent_edges().to_vec(),
                None => self.cdt.convex_hull().collect(),
            };
            for edge in edges {
                // The hull's sides run along the outside; a triangle's along itself.
                let other =
                    if face.is_outer() && !edge.face().is_outer() { edge.face() } else { edge.rev().face() };
                let slot = &mut inside[other.fix().index()];
                if slot.is_none() {
                    *slot = Some(here != self.parts(edge));
                    open.push_back(other);
                }
            }
        }
        let mut inside: Vec<bool> = inside.into_iter().map(|i| i.unwrap_or(false)).collect();
        if self.crossed {
            for face in self.cdt.inner_faces() {
                let c = face.center();
                let uv = [c.x * self.steps[0], c.y * self.steps[1]];
                let n = polygons.iter().filter(|p| super::layout::contains(p, uv)).count();
                inside[face.fix().index()] = n % 2 == 1;
            }
        }
        inside
    }

    /// Whether an odd number of borders run along a side: a slit is there twice and parts nothing.
    fn parts(
        &self,
        edge: spade::handles::DirectedEdgeHandle<'_, Point2<f64>, (), spade::CdtEdge<()>, ()>,
    ) -> bool {
        let (a, b) = (edge.from().fix().index(), edge.to().fix().index());
        edge.is_constraint_edge() && self.uses.get(&(a.min(b), a.max(b))).is_none_or(|n| n % 2 == 1)
    }

    /// Middles of inner sides that are farther than `tolerance` from the surface.
    fn coarse(&self, patch: &Patch, layout: &Layout, shared: &[Point3], tolerance: f64) -> Vec<Uv> {
        let inside = self.inside(&layout.polygons);
        let mut middles = Vec::new();
        for edge in self.cdt.undirected_edges() {
            let is_inner = !edge.is_constraint_edge()
                && inside[edge.as_directed().face().fix().index()]
                && inside[edge.as_directed().rev().face().fix().index()];
            if !is_inner {
                continue;
            }
            let ends = edge.vertices();
            let [Some(a), Some(b)] = ends.map(|v| self.nodes[v.fix().index()]) else { continue };
            let [p, q] = [a, b].map(|node| match node {
                Node::Shared(i) => shared[i as usize],
                Node::Own(i) => layout.own[i as usize],
            });
            let middle = (p.coords + q.coords) * 0.5;
            let [x, y] = ends.map(|v| v.position());
            let uv = [0.5 * (x.x + y.x) * self.steps[0], 0.5 * (x.y + y.y) * self.steps[1]];
            let Some(normal) = patch.normal(uv) else { continue };
            if (patch.point(uv).coords - middle).dot(&normal).abs() > tolerance {
                middles.push(uv);
            }
        }
        middles
    }

    fn triangles(&self, polygons: &[Polygon]) -> Vec<[Node; 3]> {
        let inside = self.inside(polygons);
        let mut triangles = Vec::new();
        for face in self.cdt.inner_faces() {
            if !inside[face.fix().index()] {
                continue;
            }
            let [Some(a), Some(b), Some(c)] = face.vertices().map(|v| self.nodes[v.fix().index()]) else {
                continue;
            };
            // All points of a pole are one vertex.
            if a != b && b != c && c != a {
                triangles.push([a, b, c]);
            }
        }
        triangles
    }
}

/// Points a step apart inside the polygons, in staggered rows, none nearer to the border than a good part of a step.
fn grid(layout: &Layout) -> Vec<Uv> {
    /// Share of a step that points keep from the border.
    const CLEAR: f64 = 0.4;
    let [du, dv] = layout.steps;
    let sides: Vec<[Uv; 2]> = layout
        .polygons
        .iter()
        .flat_map(|p| p.iter().zip(p.iter().cycle().skip(1)))
        .map(|(a, b)| [[a.0[0] / du, a.0[1] / dv], [b.0[0] / du, b.0[1] / dv]])
        .collect();
    let range = |i: usize| {
        sides
            .iter()
            .flatten()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[i]), h.max(p[i])))
    };
    let ((x0, x1), (y0, y1)) = (range(0), range(1));
    let (width, height) = (x1 - x0, y1 - y0);
    if !(width > 0.0 && height > 0.0) {
        return Vec::new();
    }
    // Coarser where there would be too many: a bad surface must not cost the run.
    let coarser = (width * height / MOST_INSIDE as f64).sqrt().max(1.0);
    let n_rows = ((height / coarser - Tolerances::SAME).ceil() as usize).clamp(1, MOST_INSIDE);
    let spacing = coarser;
    let crossings: f64 = sides.iter().map(|[a, b]| 2.0 + (a[1] - b[1]).abs() / coarser).sum();
    if crossings > MOST_CROSSINGS {
        return Vec::new();
    }
    let rows = Rows::new(&sides, (y0, y1), n_rows);
    let mut points = Vec::new();
    for j in 1..n_rows {
        let y = y0 + height * j as f64 / n_rows as f64;
        let offset = if j % 2 == 0 { 0.0 } else { 0.5 };
        for [from, to] in rows.spans(y, j) {
            let first = ((from - x0) / spacing - offset).ceil() as i64;
            let last = ((to - x0) / spacing - offset).floor() as i64;
            for k in first..=last {
                let x = x0 + (k as f64 + offset) * spacing;
                if points.len() < 2 * MOST_INSIDE && rows.distance([x, y], j) > CLEAR {
                    points.push([x * du, y * dv]);
                }
            }
        }
    }
    points
}

/// Sides of the border by the rows of the grid that they come near.
struct Rows<'s> {
    sides: &'s [[Uv; 2]],
    near: Vec<Vec<u32>>,
}

impl<'s> Rows<'s> {
    fn new(sides: &'s [[Uv; 2]], (low, high): (f64, f64), n: usize) -> Self {
        let mut near = vec![Vec::new(); n + 1];
        let row = |y: f64| ((y - low) / (high - low) * n as f64).clamp(0.0, n as f64);
        for (i, [a, b]) in sides.iter().enumerate() {
            // A row knows what is within half a step of it, too.
            let first = (row(a[1].min(b[1]) - 0.5)).floor() as usize;
            let last = (row(a[1].max(b[1]) + 0.5)).ceil() as usize;
            for list in &mut near[first..=last] {
                list.push(i as u32);
            }
        }
        Self { sides, near }
    }

    /// Where row `j`, at height `y`, is inside.
    fn spans(&self, y: f64, j: usize) -> Vec<[f64; 2]> {
        let crossed = self.near[j].iter().map(|i| &self.sides[*i as usize]);
        let mut at: Vec<f64> = crossed
            .filter(|[a, b]| (a[1] > y) != (b[1] > y))
            .map(|[a, b]| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
            .collect();
        at.sort_by(f64::total_cmp);
        at.chunks_exact(2).map(|c| [c[0], c[1]]).collect()
    }

    fn distance(&self, p: Uv, j: usize) -> f64 {
        let to = |[a, b]: &[Uv; 2]| {
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let length_sq = dx * dx + dy * dy;
            let share = ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length_sq.max(f64::MIN_POSITIVE);
            let share = share.clamp(0.0, 1.0);
            (a[0] + share * dx - p[0]).hypot(a[1] + share * dy - p[1])
        };
        self.near[j].iter().map(|i| to(&self.sides[*i as usize])).fold(f64::INFINITY, f64::min)
    }
}
