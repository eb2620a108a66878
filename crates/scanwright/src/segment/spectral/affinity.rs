//! How alike neighbours on the surface are.
//!
//! At the level of vertices the thesis's measure: `exp(-|n_i - n_j|^2 / s_n^2)`, over the one-ring. At the level of patches
//! ours: each patch's normals are taken as a linear function of the place, so that a patch of a round face and the next one
//! agree where they meet, and what is compared is the crease between them, and their curvatures.

use nalgebra::{Matrix2, Vector2};

use super::graph::Graph;
use crate::math::{Frame, Point3, UnitVec3, Vec3};
use crate::mesh::{Adjacency, Mesh};
use crate::segment::Field;

/// Difference of neighbouring vertices' normals that counts as much, beside their noise.
const VERTEX_TURN: f64 = 0.2;
/// Crease between patches that counts as much, radians, beside their noise: 4 degrees.
const PATCH_TURN: f64 = 0.07;
/// Difference of curvatures that counts as much, in radians over a patch.
const PATCH_BEND: f64 = 0.2;
/// Weight below which two neighbours count as cut; kept above zero so that the graph stays connected.
const LEAST: f64 = 1e-6;

/// The graph of the vertices.
pub(super) fn of_vertices(field: &Field, normal_noise: f64) -> Graph {
    let turn = VERTEX_TURN.max(normal_noise);
    let mut edges = Vec::new();
    for v in 0..field.n_vertices() {
        for &u in field.rings.row(v).iter().filter(|u| **u as usize > v) {
            let off_sq = (field.normals[v] - field.normals[u as usize]).norm_squared() / (turn * turn);
            edges.push((v as u32, u, (-off_sq).exp().max(LEAST)));
        }
    }
    Graph { n: field.n_vertices(), edges }
}

/// The graph of patches of triangles. `normals`: one per triangle, of deviation `normal_noise`.
pub(super) fn of_patches(
    mesh: &Mesh,
    adjacency: &Adjacency,
    normals: &[Vec3],
    normal_noise: f64,
    patch_of: &[u32],
) -> Graph {
    let n = patch_of.iter().max().map_or(0, |last| *last as usize + 1);
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); n];
    for (t, patch) in patch_of.iter().enumerate() {
        members[*patch as usize].push(t as u32);
    }
    let patches = crate::par::map(&members, |triangles| Patch::of(mesh, normals, triangles));
    let mut borders: Vec<(u32, u32, f64, Vec3)> = Vec::new();
    for (t, across) in adjacency.across.iter().enumerate() {
        for (k, u) in across.iter().enumerate().filter_map(|(k, u)| u.map(|u| (k, u as usize))) {
            let (a, b) = (patch_of[t], patch_of[u]);
            if a < b {
                let corners = mesh.corners(t);
                let (p, q) = (corners[k], corners[(k + 1) % 3]);
                let length = (q - p).norm();
                borders.push((a, b, length, nalgebra::center(&p, &q).coords * length));
            }
        }
    }
    borders.sort_by_key(|border| (border.0, border.1));
    let edge = |group: &[(u32, u32, f64, Vec3)]| {
        let (a, b) = (group[0].0, group[0].1);
        let length: f64 = group.iter().map(|g| g.2).sum();
        let middle =
            Point3::from(group.iter().fold(Vec3::zeros(), |s, g| s + g.3) / length.max(f64::MIN_POSITIVE));
        let (pa, pb) = (&patches[a as usize], &patches[b as usize]);
        let fewest = pa.n_triangles.min(pb.n_triangles) as f64;
        let turn = PATCH_TURN.max(3.0 * normal_noise / fewest.sqrt());
        let crease = (pa.normal_at(&middle) - pb.normal_at(&middle)).norm() / turn;
        let size_sq = pa.area.min(pb.area);
        let bend_sq: f64 = pa.curvatures.iter().zip(pb.curvatures).map(|(x, y)| (x - y).powi(2)).sum::<f64>()
            * size_sq
            / (PATCH_BEND * PATCH_BEND);
        (a, b, length * (-crease * crease - bend_sq).exp().max(LEAST))
    };
    let edges = borders.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)).map(edge).filter(|e| e.2 > 0.0).collect();
    Graph { n, edges }
}

/// A patch's normals as a linear function of the place.
struct Patch {
    frame: Frame,
    bend: Matrix2<f64>,
    curvatures: [f64; 2],
    area: f64,
    n_triangles: usize,
}

impl Patch {
    fn of(mesh: &Mesh, normals: &[Vec3], triangles: &[u32]) -> Self {
        /// Share of the spread that keeps a patch of few triangles from being bent by their noise.
        const RIDGE: f64 = 0.05;
        let (mut normal, mut center, mut area) = (Vec3::zeros(), Vec3::zeros(), 0.0);
        for &t in triangles {
            let share = mesh.area(t as usize);
            normal += normals[t as usize] * share;
            center += mesh.triangle_center(t as usize).coords * share;
            area += share;
        }
        let center = Point3::from(center / f64::max(area, f64::MIN_POSITIVE));
        let unit = crate::math::try_unit(normal).unwrap_or_else(|| UnitVec3::new_unchecked(Vec3::z()));
        let frame = Frame::from_z(center, unit);
        let (mut spread, mut turned) = (Matrix2::zeros(), Matrix2::zeros());
        for &t in triangles {
            let at = frame.local(&mesh.triangle_center(t as usize)).xy();
            let n = normals[t as usize];
            let lean = Vector2::new(n.dot(&frame.x), n.dot(&frame.y));
            let share = mesh.area(t as usize);
            spread += at * at.transpose() * share;
            turned += lean * at.transpose() * share;
        }
        let ridge = Matrix2::identity() * (RIDGE * spread.trace() + f64::MIN_POSITIVE);
        let bend = (spread + ridge).try_inverse().map_or_else(Matrix2::zeros, |inverse| turned * inverse);
        let bend = (bend + bend.transpose()) * 0.5;
        let mean = 0.5 * bend.trace();
        let half_gap = (0.25 * (bend.m11 - bend.m22).powi(2) + bend.m12 * bend.m12).sqrt();
        Self {
            frame,
            bend,
            curvatures: [mean - half_gap, mean + half_gap],
            area,
            n_triangles: triangles.len(),
        }
    }

    fn normal_at(&self, point: &Point3) -> Vec3 {
        let lean = self.bend * self.frame.local(point).xy();
        let Frame { x, y, z, .. } = self.frame;
        let normal = z.into_inner() + x.into_inner() * lean.x + y.into_inner() * lean.y;
        normal.normalize()
    }
}
