//! Fewer and larger flat faces where facets stand.
//!
//! One face per triangle of the scan is more than a zone of facets needs. Vertices inside such a zone, and those on
//! its rim with a plane, are drawn onto a neighbour as long as every vertex that is gone stays as near to the facets as
//! noise leaves it to the part, no triangle turns over, and the mesh stays a manifold. The zones' other rims stay:
//! they lie on surfaces that a longer chord would leave.

use super::LabelledMesh;
use super::attempt::Bench;
use crate::math::{Point3, Vec3};
use crate::mesh::{Mesh, VertId};

/// Passes over all vertices; most are gone after two.
const PASSES: usize = 6;
/// Largest distance of a vertex that is gone from the facets: noise, and spacings.
const WITHIN: (f64, f64) = (3.0, 0.25);
/// Least height of a triangle over its longest side.
const LEAST_HEIGHT: f64 = 0.05;
/// Cosine of the largest angle by which a triangle may turn.
const MOST_TURN: f64 = 0.6;

/// What is thinned, and how far.
pub(super) struct Thinning<'a> {
    pub bench: &'a Bench<'a>,
    /// One per triangle.
    pub labels: &'a [u32],
    /// One per label: whether its surface is a plane.
    pub is_plane: &'a [bool],
    /// Of the largest distance that vertices may have from the facets.
    pub share: f64,
    /// Whether the rims with planes are thinned too.
    pub rims: bool,
}

/// A mesh with fewer facets.
pub(super) struct Thinned {
    pub closed: LabelledMesh,
    /// One per triangle.
    pub labels: Vec<u32>,
    /// One per vertex there was: which it is now, if it is left.
    pub vertices: Vec<Option<VertId>>,
}

impl Thinning<'_> {
    /// The mesh with fewer facets; `None` when none could go.
    pub fn run(&self) -> Option<Thinned> {
        let mut state = State::new(self);
        let n_before = state.n_triangles();
        for _ in 0..PASSES {
            let n = state.n_triangles();
            for v in 0..state.vertices.len() as VertId {
                state.draw_in(v);
            }
            if state.n_triangles() == n {
                break;
            }
        }
        (state.n_triangles() < n_before).then(|| state.finished(self.bench.closed))
    }
}

struct State<'a> {
    vertices: &'a [Point3],
    labels: &'a [u32],
    facets: u32,
    is_plane: &'a [bool],
    rims: bool,
    within: f64,
    /// Empty once gone.
    triangles: Vec<Option<[VertId; 3]>>,
    /// Triangles at each vertex.
    fans: Vec<Vec<u32>>,
    /// Vertices that are gone, by the facet that they are nearest to.
    covered: Vec<Vec<VertId>>,
}

impl<'a> State<'a> {
    fn new(thinning: &Thinning<'a>) -> Self {
        let mesh = &thinning.bench.closed.mesh;
        let mut fans = vec![Vec::new(); mesh.vertices.len()];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            for v in triangle {
                fans[*v as usize].push(t as u32);
            }
        }
        let tolerances = thinning.bench.tolerances;
        let within = (WITHIN.0 * tolerances.noise()).max(WITHIN.1 * tolerances.spacing());
        Self {
            vertices: &mesh.vertices,
            labels: thinning.labels,
            facets: thinning.bench.facets,
            is_plane: thinning.is_plane,
            rims: thinning.rims,
            within: thinning.share * within,
            triangles: mesh.triangles.iter().copied().map(Some).collect(),
            covered: vec![Vec::new(); mesh.triangles.len()],
            fans,
        }
    }

    fn n_triangles(&self) -> usize {
        self.triangles.iter().flatten().count()
    }

    fn triangle(&self, t: u32) -> [VertId; 3] {
        self.triangles[t as usize].expect("a fan holds triangles that are there")
    }

    fn corners(&self, triangle: [VertId; 3]) -> [Point3; 3] {
        triangle.map(|v| self.vertices[v as usize])
    }

    /// Neighbours of a vertex, each with the triangles at the edge to it.
    fn ring(&self, v: VertId) -> Vec<(VertId, Vec<u32>)> {
        let mut ring: Vec<(VertId, Vec<u32>)> = Vec::new();
        for &t in &self.fans[v as usize] {
            for u in self.triangle(t).into_iter().filter(|u| *u != v) {
                match ring.iter_mut().find(|r| r.0 == u) {
                    Some(r) => r.1.push(t),
                    None => ring.push((u, vec![t])),
                }
            }
        }
        ring.sort_by_key(|r| r.0);
        ring
    }

    /// Draws a vertex onto the neighbour that keeps the zone nearest to what it was, if any does.
    fn draw_in(&mut self, v: VertId) {
        let best = self
            .targets(v)
            .into_iter()
            .filter_map(|to| Some((self.deviation(v, to)?, to)))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        if let Some((_, to)) = best {
            self.draw(v, to);
        }
    }

    /// Neighbours that a vertex may be drawn onto.
    fn targets(&self, v: VertId) -> Vec<VertId> {
        let fan = &self.fans[v as usize];
        let label = |t: &u32| self.labels[*t as usize];
        if !fan.iter().any(|t| label(t) == self.facets) {
            return Vec::new();
        }
        let ring = self.ring(v);
        // A vertex inside a closed mesh: every edge has two triangles.
        if ring.iter().any(|r| r.1.len() != 2) {
            return Vec::new();
        }
        let mut others: Vec<u32> = fan.iter().map(label).filter(|l| *l != self.facets).collect();
        others.sort_unstable();
        others.dedup();
        match others[..] {
            [] => ring.into_iter().map(|r| r.0).collect(),
            [plane] if self.rims && self.is_plane[plane as usize] => {
                let is_rim = |r: &&(VertId, Vec<u32>)| label(&r.1[0]) != label(&r.1[1]);
                let rim: Vec<VertId> = ring.iter().filter(is_rim).map(|r| r.0).collect();
                let [a, b] = rim[..] else { return Vec::new() };
                let [p, from, to] = self.corners([v, a, b]);
                let along = to - from;
                let t = (p - from).dot(&along) / along.norm_squared();
                let off = (from + along * t - p).norm();
                if (0.0..=1.0).contains(&t) && off < self.within { rim } else { Vec::new() }
            }
            _ => Vec::new(),
        }
    }

    /// Largest distance of vertices that are gone from the facets once `v` is drawn onto `to`; `None` where that must
    /// not be.
    fn deviation(&self, v: VertId, to: VertId) -> Option<f64> {
        let (own, others) = (self.ring(v), self.ring(to));
        let n_common = own.iter().filter(|r| others.iter().any(|o| o.0 == r.0)).count();
        if n_common != 2 {
            return None;
        }
        let mut facets = Vec::new();
        let mut lost = vec![v];
        for &t in &self.fans[v as usize] {
            let before = self.triangle(t);
            lost.extend(&self.covered[t as usize]);
            if before.contains(&to) {
                continue;
            }
            let after = before.map(|u| if u == v { to } else { u });
            let (old, new) = (self.corners(before), self.corners(after));
            if !is_kept(&old, &new) {
                return None;
            }
            if self.labels[t as usize] == self.facets {
                facets.push(new);
            }
        }
        if facets.is_empty() {
            return None;
        }
        let off = |u: &VertId| {
            let p = &self.vertices[*u as usize];
            facets.iter().map(|f| distance(p, f)).fold(f64::INFINITY, f64::min)
        };
        let worst = lost.iter().map(off).fold(0.0, f64::max);
        (worst < self.within).then_some(worst)
    }

    fn draw(&mut self, v: VertId, to: VertId) {
        let fan = std::mem::take(&mut self.fans[v as usize]);
        let mut lost = vec![v];
        for &t in &fan {
            lost.append(&mut self.covered[t as usize]);
            let before = self.triangle(t);
            if before.contains(&to) {
                self.triangles[t as usize] = None;
                for u in before.into_iter().filter(|u| *u != v) {
                    self.fans[u as usize].retain(|s| *s != t);
                }
            } else {
                self.triangles[t as usize] = Some(before.map(|u| if u == v { to } else { u }));
                self.fans[to as usize].push(t);
            }
        }
        let kept: Vec<u32> = fan
            .into_iter()
            .filter(|t| self.triangles[*t as usize].is_some() && self.labels[*t as usize] == self.facets)
            .collect();
        for u in lost {
            let off = |t: &u32| distance(&self.vertices[u as usize], &self.corners(self.triangle(*t)));
            if let Some(&t) = kept.iter().min_by(|a, b| off(a).total_cmp(&off(b))) {
                self.covered[t as usize].push(u);
            }
        }
    }

    /// What is left as a mesh.
    fn finished(self, closed: &LabelledMesh) -> Thinned {
        let mut thin = closed.clone();
        let mut labels = Vec::new();
        thin.mesh.triangles.clear();
        thin.labels.clear();
        thin.assumed.clear();
        for (t, triangle) in self.triangles.iter().enumerate() {
            let Some(triangle) = triangle else { continue };
            thin.mesh.triangles.push(*triangle);
            thin.labels.push(closed.labels[t]);
            thin.assumed.push(closed.assumed[t]);
            labels.push(self.labels[t]);
        }
        let mut vertices: Vec<Option<VertId>> = vec![None; thin.mesh.vertices.len()];
        let mut kept = Vec::new();
        for v in thin.mesh.triangles.iter_mut().flatten() {
            let point = thin.mesh.vertices[*v as usize];
            *v = *vertices[*v as usize].get_or_insert_with(|| {
                kept.push(point);
                kept.len() as VertId - 1
            });
        }
        thin.mesh.vertices = kept;
        Thinned { closed: thin, labels, vertices }
    }
}

fn cross(triangle: &[Point3; 3]) -> Vec3 {
    (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0]))
}

fn is_sliver(triangle: &[Point3; 3]) -> bool {
    let side = |k: usize| (triangle[(k + 1) % 3] - triangle[k]).norm();
    cross(triangle).norm() <= LEAST_HEIGHT * (0..3).map(side).fold(0.0, f64::max).powi(2)
}

/// Whether a triangle that moves stays one and does not turn far. A sliver, whose normal says nothing, may turn.
fn is_kept(old: &[Point3; 3], new: &[Point3; 3]) -> bool {
    let (a, b) = (cross(old), cross(new));
    !is_sliver(new) && (is_sliver(old) || a.dot(&b) > MOST_TURN * a.norm() * b.norm())
}

/// Moves the corners of slivers towards their neighbours until none is left, or some steps have not helped: where two
/// rims touched, triangles stand between corners in one place, and none of these can be drawn onto another.
pub(super) fn relax_slivers(mesh: &mut Mesh, spacing: f64) {
    const ROUNDS: usize = 12;
    /// In spacings: largest move of a round.
    const STEP: f64 = 0.1;
    let mut ring: Vec<Vec<VertId>> = vec![Vec::new(); mesh.vertices.len()];
    for triangle in &mesh.triangles {
        for k in 0..3 {
            ring[triangle[k] as usize].push(triangle[(k + 1) % 3]);
        }
    }
    for _ in 0..ROUNDS {
        let slivers = (0..mesh.triangles.len()).filter(|t| is_sliver(&mesh.corners(*t)));
        let mut moved: Vec<VertId> = slivers.flat_map(|t| mesh.triangles[t]).collect();
        if moved.is_empty() {
            return;
        }
        moved.sort_unstable();
        moved.dedup();
        for v in moved {
            let p = mesh.vertices[v as usize];
            let around = ring[v as usize].iter().map(|u| mesh.vertices[*u as usize] - p);
            let step = around.sum::<Vec3>() / ring[v as usize].len() as f64;
            mesh.vertices[v as usize] += step.cap_magnitude(STEP * spacing);
        }
    }
}

/// Distance of a point from a triangle.
fn distance(p: &Point3, triangle: &[Point3; 3]) -> f64 {
    let [a, b, c] = triangle;
    let normal = (b - a).cross(&(c - a));
    let inside = (0..3).all(|k| {
        let (from, to) = (&triangle[k], &triangle[(k + 1) % 3]);
        normal.cross(&(to - from)).dot(&(p - from)) >= 0.0
    });
    if inside {
        return (p - a).dot(&normal).abs() / normal.norm().max(f64::MIN_POSITIVE);
    }
    let to_side = |k: usize| {
        let (from, to) = (&triangle[k], &triangle[(k + 1) % 3]);
        let along = to - from;
        let t = ((p - from).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (from + along * t - p).norm()
    };
    (0..3).map(to_side).fold(f64::INFINITY, f64::min)
}
