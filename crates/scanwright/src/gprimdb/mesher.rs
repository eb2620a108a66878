//! Triangle meshes of bounded surfaces, in rows along `u`.
//!
//! Every triangulation is made of rows of vertices from the lower to the upper end of `v`, stitched one to the next. What
//! differs is how many vertices a row has and where they lie.

use serde::{Deserialize, Serialize};

use super::shape::{Class, Shape};
use crate::math::{Point3, Vec3};
use crate::mesh::{Mesh, VertId};
use crate::random::Rng;

/// How a surface is triangulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Triangulation {
    /// Rows of equal numbers of vertices: dense at poles and inside rings.
    Grid,
    /// Rows with as many vertices as make edges of one length, staggered: nearly equilateral triangles.
    Isotropic,
    /// The same with vertices shaken out of their rows.
    Irregular,
    /// As CAD programs export: across what is straight, one long triangle.
    Cad,
    /// Irregular, with holes.
    Scanner,
}

impl Triangulation {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Grid, Self::Isotropic, Self::Irregular, Self::Cad, Self::Scanner];
}

/// A triangulated shape, with the natural coordinates of each vertex.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Meshed {
    pub mesh: Mesh,
    /// One per vertex: `(u, v)`.
    pub places: Vec<[f64; 2]>,
    /// The edge length asked for.
    pub edge: f64,
}

/// Share of the distance to its neighbours that a shaken vertex moves, at most.
const SHAKE: f64 = 0.3;
/// Fewest vertices round a closed row.
const FEWEST_ROUND: usize = 6;
/// Length of a row over that of the longest below which it is a pole: sines of whole turns are zero but for rounding.
const POLE: f64 = 1e-9;
/// Steps by which lengths are measured.
const N_MEASURE: usize = 64;

/// A mesh of `shape` with about `resolution` edges along the square root of its area.
pub(super) fn mesh(shape: &Shape, kind: Triangulation, resolution: u32, rng: &mut Rng) -> Meshed {
    let edge = shape.area().sqrt() / f64::from(resolution);
    let rows = rows(shape, kind, edge, rng);
    let places: Vec<[f64; 2]> = rows.iter().flatten().copied().collect();
    let vertices: Vec<Point3> = places.iter().map(|[u, v]| shape.point(*u, *v)).collect();
    let starts: Vec<usize> = rows
        .iter()
        .scan(0, |next, row| {
            let start = *next;
            *next += row.len();
            Some(start)
        })
        .collect();
    let mut stitcher =
        Stitcher { vertices: &vertices, crossing: kind != Triangulation::Grid, triangles: Vec::new() };
    let n_bands = if shape.wraps[1] { rows.len() } else { rows.len() - 1 };
    for k in 0..n_bands {
        let ring = |r: usize| {
            let ids = (starts[r]..starts[r] + rows[r].len()).map(|i| i as VertId);
            let closes = shape.wraps[0].then_some(starts[r] as VertId);
            ids.chain(closes.filter(|_| rows[r].len() > 1)).collect::<Vec<_>>()
        };
        stitcher.stitch(&ring(k), &ring((k + 1) % rows.len()));
    }
    let mut mesh = Mesh { triangles: stitcher.triangles, vertices };
    face_the_normal(shape, &mut mesh, &places);
    let meshed = Meshed { mesh, places, edge };
    if kind == Triangulation::Scanner { with_holes(&meshed, rng) } else { meshed }
}

/// Natural coordinates of all vertices, row by row.
fn rows(shape: &Shape, kind: Triangulation, edge: f64, rng: &mut Rng) -> Vec<Vec<[f64; 2]>> {
    let [v0, v1] = shape.v;
    let widest = (0..=8)
        .map(|k| {
            length(|s| {
                shape.point(shape.u[0] + (shape.u[1] - shape.u[0]) * s, v0 + (v1 - v0) * f64::from(k) / 8.0)
            })
        })
        .fold(0.0, f64::max);
    let tallest = (0..=8)
        .map(|k| shape.u[0] + (shape.u[1] - shape.u[0]) * f64::from(k) / 8.0)
        .map(|u| length(|s| shape.point(u, v0 + (v1 - v0) * s)))
        .fold(0.0, f64::max);
    let spaced = |length: f64, spacing: f64, closed: bool| {
        let n = (length / spacing).round().max(1.0) as usize;
        if closed { n.max(FEWEST_ROUND) } else { n }
    };
    let height = if kind == Triangulation::Isotropic { 0.75_f64.sqrt() } else { 1.0 };
    let is_ruled = matches!(shape.class, Class::Plane | Class::Cylinder | Class::Cone);
    let n_bands = if kind == Triangulation::Cad && is_ruled {
        1
    } else {
        spaced(tallest, height * edge, shape.wraps[1])
    };
    let n_rows = if shape.wraps[1] { n_bands } else { n_bands + 1 };
    let mut rows = Vec::with_capacity(n_rows);
    for k in 0..n_rows {
        let v = v0 + (v1 - v0) * k as f64 / n_bands as f64;
        let along = length(|s| shape.point(shape.u[0] + (shape.u[1] - shape.u[0]) * s, v));
        if along <= POLE * widest {
            rows.push(vec![[shape.u[0], v]]);
            continue;
        }
        let uniform = matches!(kind, Triangulation::Grid | Triangulation::Cad);
        let n = spaced(if uniform { widest } else { along }, edge, shape.wraps[0]);
        let is_inner = shape.wraps[1] || (k > 0 && k < n_rows - 1);
        let shakes = matches!(kind, Triangulation::Irregular | Triangulation::Scanner);
        let stagger = if !uniform && shape.wraps[0] && k % 2 == 1 { 0.5 } else { 0.0 };
        let n_vertices = if shape.wraps[0] { n } else { n + 1 };
        let row = (0..n_vertices).map(|i| {
            let is_free = shape.wraps[0] || (i > 0 && i < n);
            let mut shake =
                |free: bool| if shakes && free { SHAKE * (2.0 * rng.uniform() - 1.0) } else { 0.0 };
            let u = shape.u[0] + (shape.u[1] - shape.u[0]) * (i as f64 + stagger + shake(is_free)) / n as f64;
            let v = v + (v1 - v0) * shake(is_inner) / n_bands as f64;
            [u, v]
        });
        rows.push(row.collect());
    }
    rows
}

fn length(at: impl Fn(f64) -> Point3) -> f64 {
    let step = |k: usize| (at((k + 1) as f64 / N_MEASURE as f64) - at(k as f64 / N_MEASURE as f64)).norm();
    (0..N_MEASURE).map(step).sum()
}

struct Stitcher<'a> {
    vertices: &'a [Point3],
    /// Whether each quad takes its shorter diagonal; else always the same.
    crossing: bool,
    triangles: Vec<[VertId; 3]>,
}

impl Stitcher<'_> {
    /// Triangles between a row and the next; of a closed row the first vertex comes again at the end.
    fn stitch(&mut self, lower: &[VertId], upper: &[VertId]) {
        let (mut i, mut j) = (0, 0);
        while i + 1 < lower.len() || j + 1 < upper.len() {
            let along_lower = if i + 1 == lower.len() {
                false
            } else if j + 1 == upper.len() {
                true
            } else if self.crossing {
                self.apart(lower[i + 1], upper[j]) <= self.apart(lower[i], upper[j + 1])
            } else {
                i <= j
            };
            if along_lower {
                self.triangles.push([lower[i], lower[i + 1], upper[j]]);
                i += 1;
            } else {
                self.triangles.push([lower[i], upper[j + 1], upper[j]]);
                j += 1;
            }
        }
    }

    fn apart(&self, a: VertId, b: VertId) -> f64 {
        (self.vertices[a as usize] - self.vertices[b as usize]).norm_squared()
    }
}

/// Turns all triangles so that they face along the shape's normal.
fn face_the_normal(shape: &Shape, mesh: &mut Mesh, places: &[[f64; 2]]) {
    let faces = |t: usize| {
        let normal: Vec3 = mesh.triangles[t]
            .iter()
            .map(|&v| places[v as usize])
            .fold(Vec3::zeros(), |sum, [u, v]| sum + shape.normal(u, v));
        mesh.cross(t).dot(&normal)
    };
    if (0..mesh.triangles.len()).map(faces).sum::<f64>() < 0.0 {
        for triangle in &mut mesh.triangles {
            triangle.swap(1, 2);
        }
    }
}

/// The mesh with holes, as shadows leave them: up to five, a twelfth of the area at most.
fn with_holes(meshed: &Meshed, rng: &mut Rng) -> Meshed {
    const MOST: usize = 5;
    let Meshed { mesh, places, edge } = meshed;
    let largest = (mesh.total_area() / (12.0 * MOST as f64 * std::f64::consts::PI)).sqrt();
    let holes: Vec<(Point3, f64)> = (0..=rng.below(MOST))
        .map(|_| {
            let center = mesh.vertices[rng.below(mesh.vertices.len())];
            (center, edge.min(largest) + (largest - edge).max(0.0) * rng.uniform())
        })
        .collect();
    let keeps = |t: usize| {
        let center = mesh.triangle_center(t);
        holes.iter().all(|(hole, radius)| (center - hole).norm() > *radius)
    };
    let (mesh, _, old) = mesh.submesh(keeps);
    Meshed { places: old.iter().map(|v| places[*v as usize]).collect(), mesh, edge: *edge }
}
