//! Patches of triangles: what graphs of a large mesh join, and hierarchies merge.

use nalgebra::{Matrix2, Vector2};

use super::superfacets::superfacets;
use crate::math::{Frame, Point3, UnitVec3, Vec3};
use crate::mesh::{Adjacency, Mesh};
use crate::par;
use crate::segment::{Field, Scan};

/// Triangles per patch.
const PATCH_TRIANGLES: usize = 24;

/// The patches of a mesh and where they touch.
pub(in crate::segment) struct Patches {
    /// Filtered normal of every triangle.
    pub normals: Vec<Vec3>,
    /// The patch of every triangle.
    pub patch_of: Vec<u32>,
    /// One per patch.
    pub all: Vec<Patch>,
    /// One per pair of patches that touch, ascending.
    pub borders: Vec<Border>,
}

/// What two patches have in common.
pub(in crate::segment) struct Border {
    /// The patches, the lower first.
    pub between: [u32; 2],
    /// Length of the common border.
    pub length: f64,
    /// Its middle.
    pub middle: Point3,
}

impl Patches {
    /// Patches that do not cross creases, at most about `most`.
    pub fn of(scan: &Scan, most: usize, seed: u64) -> Self {
        let Scan { mesh, adjacency, field, normal_noise } = scan;
        let normals = triangle_normals(mesh, field, *normal_noise);
        let n = (mesh.triangles.len() / PATCH_TRIANGLES).clamp(1, most);
        // Normals of the filter, whose noise is a third of that of the raw ones at most.
        let filtered = normal_noise.max(0.05) / 3.0;
        let patch_of = superfacets(mesh, adjacency, &normals, filtered, n, seed);
        let all = par::map(&triangles(&patch_of), |triangles| Patch::of(mesh, &normals, triangles));
        Self { borders: borders(mesh, adjacency, &patch_of), all, patch_of, normals }
    }

    /// The triangles of every patch, ascending.
    pub fn triangles(&self) -> Vec<Vec<u32>> {
        triangles(&self.patch_of)
    }

    /// The group of every triangle, from those of the patches.
    pub fn of_triangles(&self, groups: &[u32]) -> Vec<u32> {
        self.patch_of.iter().map(|patch| groups[*patch as usize]).collect()
    }
}

fn triangles(patch_of: &[u32]) -> Vec<Vec<u32>> {
    let n = patch_of.iter().max().map_or(0, |last| *last as usize + 1);
    let mut triangles: Vec<Vec<u32>> = vec![Vec::new(); n];
    for (t, patch) in patch_of.iter().enumerate() {
        triangles[*patch as usize].push(t as u32);
    }
    triangles
}

/// One per triangle: the mean of its vertices' filtered normals; its own where there is no noise to filter, as vertices on a
/// sharp edge have none that is right for both sides.
fn triangle_normals(mesh: &Mesh, field: &Field, normal_noise: f64) -> Vec<Vec3> {
    /// Radians.
    const NO_NOISE: f64 = 0.01;
    if normal_noise < NO_NOISE {
        return mesh.triangle_normals();
    }
    let mean = |t: &[u32; 3]| t.iter().map(|&v| field.normals[v as usize]).sum::<Vec3>().try_normalize(0.0);
    mesh.triangles.iter().map(|t| mean(t).unwrap_or_else(Vec3::zeros)).collect()
}

fn borders(mesh: &Mesh, adjacency: &Adjacency, patch_of: &[u32]) -> Vec<Border> {
    let mut edges: Vec<([u32; 2], f64, Vec3)> = Vec::new();
    for (t, across) in adjacency.across.iter().enumerate() {
        for (k, u) in across.iter().enumerate().filter_map(|(k, u)| u.map(|u| (k, u as usize))) {
            let between = [patch_of[t], patch_of[u]];
            if between[0] < between[1] {
                let corners = mesh.corners(t);
                let (p, q) = (corners[k], corners[(k + 1) % 3]);
                let length = (q - p).norm();
                edges.push((between, length, nalgebra::center(&p, &q).coords * length));
            }
        }
    }
    edges.sort_by_key(|edge| edge.0);
    let border = |group: &[([u32; 2], f64, Vec3)]| {
        let length: f64 = group.iter().map(|g| g.1).sum();
        let middle = group.iter().fold(Vec3::zeros(), |s, g| s + g.2) / length.max(f64::MIN_POSITIVE);
        Border { between: group[0].0, length, middle: Point3::from(middle) }
    };
    edges.chunk_by(|x, y| x.0 == y.0).map(border).collect()
}

/// A patch's normals as a linear function of the place.
pub(in crate::segment) struct Patch {
    /// At its middle, z along its mean normal.
    pub frame: Frame,
    bend: Matrix2<f64>,
    /// Principal curvatures, ascending, one over length; positive where the material is convex.
    pub curvatures: [f64; 2],
    /// Squared length.
    pub area: f64,
    pub n_triangles: usize,
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

    /// Its unit normal at a place near it.
    pub fn normal_at(&self, point: &Point3) -> Vec3 {
        let lean = self.bend * self.frame.local(point).xy();
        let Frame { x, y, z, .. } = self.frame;
        let normal = z.into_inner() + x.into_inner() * lean.x + y.into_inner() * lean.y;
        normal.normalize()
    }
}
