//! The z-buffer: which triangle each sample sees, how deep, and with which normal.

use crate::math::Vec3;
use crate::mesh::{Adjacency, Mesh};
use crate::par;

use super::camera::Screen;

/// No triangle.
pub(super) const NOTHING: u32 = u32::MAX;
/// Rows of samples per task. Bands share nothing, so the picture does not depend on the number of threads.
const BAND: usize = 64;

/// What each sample sees.
pub(super) struct Buffer {
    pub width: usize,
    pub height: usize,
    /// Triangle, or [`NOTHING`].
    pub triangles: Vec<u32>,
    /// Group of the triangle, or [`NOTHING`].
    pub groups: Vec<u32>,
    /// Depth in samples, larger is nearer.
    pub depths: Vec<f32>,
    /// Unit normal: right, up, towards the eye.
    pub normals: Vec<[f32; 3]>,
    /// Whether the triangle's back is seen.
    pub backs: Vec<bool>,
    /// How much the triangle's first and second corner count.
    pub weights: Vec<[f32; 2]>,
}

/// Rasterizes `mesh`; `groups`: one per triangle; `normals`: one per triangle and corner.
pub(super) fn rasterize(
    mesh: &Mesh,
    groups: &[u32],
    normals: &[[Vec3; 3]],
    screen: &Screen,
    (width, height): (usize, usize),
) -> Buffer {
    let points: Vec<[f32; 3]> = mesh.vertices.iter().map(|p| screen.project(p)).collect();
    let n_bands = height.div_ceil(BAND);
    let mut members = vec![Vec::new(); n_bands];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let ys = triangle.map(|v| points[v as usize][1]);
        let (lo, hi) = (ys[0].min(ys[1]).min(ys[2]), ys[0].max(ys[1]).max(ys[2]));
        if hi < 0.0 || lo >= height as f32 {
            continue;
        }
        let first = lo.max(0.0) as usize / BAND;
        let last = (hi as usize / BAND).min(n_bands - 1);
        for band in &mut members[first..=last] {
            band.push(t as u32);
        }
    }
    let bands = par::map_indices(n_bands, |band| {
        let top = band * BAND;
        let mut buffer = Buffer::empty(width, BAND.min(height - top));
        for &t in &members[band] {
            let corners = mesh.triangles[t as usize].map(|v| points[v as usize]);
            let normals = normals[t as usize].map(|n| screen.direction(&n));
            buffer.add(t, groups[t as usize], &corners, &normals, top);
        }
        buffer
    });
    bands.into_iter().fold(Buffer::empty(width, 0), Buffer::below)
}

impl Buffer {
    fn empty(width: usize, height: usize) -> Self {
        let n = width * height;
        Self {
            width,
            height,
            triangles: vec![NOTHING; n],
            groups: vec![NOTHING; n],
            depths: vec![f32::NEG_INFINITY; n],
            normals: vec![[0.0, 0.0, 1.0]; n],
            backs: vec![false; n],
            weights: vec![[0.0; 2]; n],
        }
    }

    /// This buffer with `other` below it.
    fn below(mut self, other: Self) -> Self {
        self.height += other.height;
        self.triangles.extend(other.triangles);
        self.groups.extend(other.groups);
        self.depths.extend(other.depths);
        self.normals.extend(other.normals);
        self.backs.extend(other.backs);
        self.weights.extend(other.weights);
        self
    }

    /// Draws one triangle into a buffer whose first row is row `top` of the panel.
    fn add(&mut self, t: u32, group: u32, corners: &[[f32; 3]; 3], normals: &[[f32; 3]; 3], top: usize) {
        let [a, b, c] = *corners;
        // Twice the area on the screen; rows grow downwards, so a front has a negative one.
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let back = area > 0.0;
        let range = |k: usize, limit: usize, offset: f32| {
            let lo = a[k].min(b[k]).min(c[k]) - offset;
            let hi = a[k].max(b[k]).max(c[k]) - offset;
            ((lo - 0.5).ceil().max(0.0) as usize, ((hi + 0.5).ceil().max(0.0) as usize).min(limit))
        };
        let (x0, x1) = range(0, self.width, 0.0);
        let (y0, y1) = range(1, self.height, top as f32);
        for y in y0..y1 {
            let py = (y + top) as f32 + 0.5;
            for x in x0..x1 {
                let px = x as f32 + 0.5;
                let wa = ((b[0] - px) * (c[1] - py) - (b[1] - py) * (c[0] - px)) / area;
                let wb = ((c[0] - px) * (a[1] - py) - (c[1] - py) * (a[0] - px)) / area;
                let wc = 1.0 - wa - wb;
                if wa < 0.0 || wb < 0.0 || wc < 0.0 {
                    continue;
                }
                let depth = wa * a[2] + wb * b[2] + wc * c[2];
                let i = y * self.width + x;
                if depth <= self.depths[i] {
                    continue;
                }
                let [na, nb, nc] = normals;
                let normal = [0, 1, 2].map(|k| wa * na[k] + wb * nb[k] + wc * nc[k]);
                self.depths[i] = depth;
                self.triangles[i] = t;
                self.groups[i] = group;
                self.normals[i] = facing(normal, back);
                self.backs[i] = back;
                self.weights[i] = [wa, wb];
            }
        }
    }
}

/// Unit normal, turned to the eye's side when the back is seen.
fn facing(n: [f32; 3], back: bool) -> [f32; 3] {
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt().max(f32::MIN_POSITIVE);
    let sign = if back { -1.0 } else { 1.0 };
    n.map(|c| sign * c / length)
}

/// Per triangle and corner: the area-weighted normal of the corner's triangles of the same group.
pub(super) fn corner_normals(mesh: &Mesh, groups: &[u32]) -> Vec<[Vec3; 3]> {
    let adjacency = Adjacency::new(mesh);
    let crosses: Vec<Vec3> = (0..mesh.triangles.len()).map(|t| mesh.cross(t)).collect();
    par::map_indices(mesh.triangles.len(), |t| {
        mesh.triangles[t].map(|v| {
            let around = adjacency.vertex_triangles.row(v as usize).iter().map(|&u| u as usize);
            // A crease within a group stays sharp: only triangles turned less than a right angle are averaged.
            let smooth = |u: &usize| groups[*u] == groups[t] && crosses[*u].dot(&crosses[t]) >= 0.0;
            let sum: Vec3 = around.filter(smooth).map(|u| crosses[u]).sum();
            sum.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
        })
    })
}
