//! The noise of a scan, measured from the mesh alone.
//!
//! Along the normal: around a sample of vertices a quadric is fitted to the two-ring; the residual variance of a
//! patch with n vertices is `sum r^2 / (n - 6)`. Patches over creases have more residual than noise, so a low
//! quantile of the patches gives a first value, and patches whose residual noise alone would hardly ever reach are
//! then left out of the mean, again and again (clipping). The first value is divided by the same quantile of
//! chi-squared with the patch's degrees of freedom: without that a 30 % quantile of small patches reads 10 % low.
//! Of normals: each triangle beside a sampled vertex is compared with the normal of its patch's quadric.
//!
//! Only noise that differs between neighbours is seen. What is correlated over more than a patch (fusion,
//! registration) bends the quadric with it.
//! Cost is that of a bounded number of patches, O(vertices) only for the vertex normals. It fails, and reports too
//! much, when no part of the surface is smooth over two rings.

use crate::math::{UnitVec3, Vec3, stats};
use crate::mesh::{Adjacency, Mesh, VertId};
use crate::par;
use crate::tolerance::Measured;

use super::edge_rounding;
use super::patch::{N_QUADRIC, Quadric, rings};

/// Patches looked at: their mean variance is then known within half a percent, and time no longer grows with the mesh.
const MAX_PATCHES: usize = 40_000;
/// Rings of a patch: the smallest neighbourhood that leaves degrees of freedom beside a quadric's six.
const PATCH_RINGS: usize = 2;
/// Least degrees of freedom of a patch that counts; fewer make the chi-squared approximation useless.
const MIN_FREEDOM: usize = 4;
/// Share of the patches taken for smooth at first: even on scans that are mostly creases some third is smooth.
const SMOOTH_SHARE: f64 = 0.3;
/// Standard normal quantile of [`SMOOTH_SHARE`].
const SMOOTH_SHARE_Z: f64 = -0.5244;
/// Standard normal quantile up to which a patch is taken for smooth: 2.5 % of smooth ones are lost, which lowers
/// the mean by less than 2 %.
const CLIP_Z: f64 = 1.96;
/// Clipping rounds; the value is steady after three or four.
const CLIP_ROUNDS: usize = 6;
/// Median of a Rayleigh distribution of unit parameter: angles between noisy and true normals follow one.
const RAYLEIGH_MEDIAN: f64 = 1.177_41;

/// One neighbourhood and what was read from it.
pub(super) struct Patch {
    /// Its middle vertex.
    pub vertex: VertId,
    /// The surface that was fitted.
    pub quadric: Quadric,
    /// Degrees of freedom left by the fit.
    freedom: f64,
    /// Triangles at the middle vertex: area and angle to the quadric.
    angles: Vec<(f64, f64)>,
}

impl Patch {
    /// Squared noise that this patch alone suggests.
    fn variance(&self) -> f64 {
        self.quadric.residual_sq / self.freedom
    }
}

/// Measures spacing, noise and edge rounding of a scan. Zero where the mesh is too small to tell.
pub fn measure(mesh: &Mesh, adjacency: &Adjacency) -> Measured {
    let spacing = spacing(mesh);
    let normals = mesh.vertex_normals();
    let patches = sample_patches(mesh, adjacency, &normals, spacing);
    let variance = clipped_variance(&patches);
    let noise = variance.sqrt();
    Measured {
        largest_coordinate: mesh.largest_coordinate(),
        diagonal: mesh.diagonal(),
        spacing,
        noise,
        normal_noise: normal_noise(&patches, variance),
        edge_rounding: edge_rounding::edge_rounding(mesh, adjacency, &normals, &patches, spacing, noise),
    }
}

/// `sqrt(area / n)` over the vertices that triangles use.
fn spacing(mesh: &Mesh) -> f64 {
    let mut used = vec![false; mesh.vertices.len()];
    for &v in mesh.triangles.iter().flatten() {
        used[v as usize] = true;
    }
    let n_used = used.iter().filter(|u| **u).count();
    (mesh.total_area() / (n_used.max(1) as f64)).sqrt()
}

/// Quadric patches about evenly chosen inner vertices.
fn sample_patches(mesh: &Mesh, adjacency: &Adjacency, normals: &[Vec3], spacing: f64) -> Vec<Patch> {
    let n = mesh.vertices.len();
    if spacing <= 0.0 {
        return Vec::new();
    }
    let n_samples = n.min(MAX_PATCHES);
    let patches = par::map_indices(n_samples, |i| {
        let vertex = (i as u64 * n as u64 / n_samples as u64) as VertId;
        patch(mesh, adjacency, normals, spacing, vertex)
    });
    patches.into_iter().flatten().collect()
}

fn patch(
    mesh: &Mesh,
    adjacency: &Adjacency,
    normals: &[Vec3],
    spacing: f64,
    vertex: VertId,
) -> Option<Patch> {
    // Beside the boundary the ring is one-sided and the quadric extrapolates.
    if adjacency.on_boundary[vertex as usize] || normals[vertex as usize] == Vec3::zeros() {
        return None;
    }
    let vertices = rings(adjacency, vertex, PATCH_RINGS, |_| true);
    if vertices.len() < N_QUADRIC + MIN_FREEDOM {
        return None;
    }
    let normal = UnitVec3::new_unchecked(normals[vertex as usize]);
    let quadric = Quadric::fit(mesh, &vertices, normal, spacing)?;
    let angles = adjacency
        .vertex_triangles
        .row(vertex as usize)
        .iter()
        .filter_map(|&t| {
            let cross = mesh.cross(t as usize);
            let normal = cross.try_normalize(0.0)?;
            let expected = quadric.normal_over(&mesh.triangle_center(t as usize));
            Some((0.5 * cross.norm(), crate::math::angle_between(&normal, &expected)))
        })
        .collect();
    Some(Patch { vertex, quadric, freedom: (vertices.len() - N_QUADRIC) as f64, angles })
}

/// Mean variance of the smooth patches, weighted by their degrees of freedom.
fn clipped_variance(patches: &[Patch]) -> f64 {
    let mut first: Vec<f64> =
        patches.iter().map(|p| p.variance() / stats::chi_squared_ratio(p.freedom, SMOOTH_SHARE_Z)).collect();
    let Some(mut variance) = stats::quantile(&mut first, SMOOTH_SHARE) else { return 0.0 };
    for _ in 0..CLIP_ROUNDS {
        let (mut sum, mut freedom) = (0.0, 0.0);
        for p in patches.iter().filter(|p| is_smooth(p, variance)) {
            sum += p.quadric.residual_sq;
            freedom += p.freedom;
        }
        if freedom <= 0.0 {
            break;
        }
        variance = sum / freedom;
    }
    variance
}

fn is_smooth(patch: &Patch, variance: f64) -> bool {
    patch.variance() <= variance * stats::chi_squared_ratio(patch.freedom, CLIP_Z)
}

/// Per-axis deviation of triangle normals on the smooth patches: area-weighted median angle over that of a Rayleigh
/// distribution. By area, because slivers have wild normals and no weight in anything that follows.
fn normal_noise(patches: &[Patch], variance: f64) -> f64 {
    let smooth = patches.iter().filter(|p| is_smooth(p, variance));
    let mut angles: Vec<(f64, f64)> = smooth.flat_map(|p| p.angles.iter().map(|&(w, a)| (a, w))).collect();
    angles.sort_unstable_by(|x, y| x.0.total_cmp(&y.0));
    let half = 0.5 * angles.iter().map(|(_, w)| w).sum::<f64>();
    let mut sum = 0.0;
    for &(angle, weight) in &angles {
        sum += weight;
        if sum >= half {
            return angle / RAYLEIGH_MEDIAN;
        }
    }
    0.0
}
