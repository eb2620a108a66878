//! The noise of a scan: how much of it each vertex has of its own, and over what distance neighbours share the rest.
//!
//! Half the mean squared difference of two residuals at a distance, the variogram, starts at the variance of the white
//! noise and rises to that of all noise over the distance of correlation (G. Matheron, "Principles of geostatistics",
//! Economic Geology 58 (1963), 1246-1266). It is averaged robustly (N. Cressie, D. Hawkins, "Robust estimation of the
//! variogram: I", Mathematical Geology 12 (1980), 115-125) and fitted with weights by the numbers of pairs and the
//! relative error of each (N. Cressie, "Fitting variogram models by weighted least squares", same journal, 17 (1985),
//! 563-586).

use super::Interior;
use crate::fit::Noise;
use crate::mesh::{Adjacency, Mesh};
use crate::par;
use crate::segment::Segmentation;
use crate::tolerance::Tolerances;

/// Distances of pairs, in spacings: bins of one spacing.
const N_BINS: usize = 16;
/// Vertices whose pairs are looked at.
const N_CENTERS: usize = 8_000;
/// Pairs of one center.
const MOST_PAIRS: usize = 100;
/// Pairs of a bin that has something to say.
const MIN_PAIRS: usize = 200;
/// Share of a face's width over which its residuals are compared: beyond, the fit has taken part of the noise with it.
const WIDTH_SHARE: f64 = 0.4;
/// Faces of fewer vertices say nothing.
const MIN_VERTICES: usize = 200;

/// Signed distances of the vertices inside the regions to their surfaces.
#[derive(Debug, Clone)]
struct Residuals {
    /// One per vertex of the mesh; not a number where none is.
    of_vertex: Vec<f64>,
    /// One per vertex: its region.
    region: Vec<u32>,
    /// Vertices with a residual, by region.
    cores: Vec<Vec<u32>>,
}

impl Residuals {
    fn new(mesh: &Mesh, interior: &Interior, segmentation: &Segmentation) -> Self {
        let mut of_vertex = vec![f64::NAN; mesh.vertices.len()];
        let mut region = vec![u32::MAX; mesh.vertices.len()];
        let mut cores = Vec::new();
        for (k, primitive) in segmentation.primitives.iter().enumerate() {
            let Some(surface) = &primitive.surface else { continue };
            let core = interior.core(k);
            if core.len() < MIN_VERTICES {
                continue;
            }
            for &v in &core {
                of_vertex[v as usize] = surface.signed_distance(&mesh.vertices[v as usize]);
                region[v as usize] = k as u32;
            }
            cores.push(core);
        }
        Self { of_vertex, region, cores }
    }
}

/// The noise of a scan whose faces are known. Where no face is large enough, all of the noise measured on the mesh is
/// taken for white, and as much again for correlated over eight spacings: scanners filter what they see.
pub fn measure(
    mesh: &Mesh,
    adjacency: &Adjacency,
    interior: &Interior,
    segmentation: &Segmentation,
    tolerances: &Tolerances,
) -> Noise {
    const UNSEEN_LENGTH: f64 = 8.0;
    let spacing = tolerances.spacing();
    let white = tolerances.noise().max(tolerances.rounding());
    let residuals = Residuals::new(mesh, interior, segmentation);
    let n: usize = residuals.cores.iter().map(Vec::len).sum();
    let stride = n.div_ceil(N_CENTERS).max(1);
    let scan = Scan { mesh, adjacency, residuals: &residuals, spacing };
    let of_faces = par::map(&residuals.cores, |core| Variogram::new(&scan, core, stride));
    let n_centers = n.div_ceil(stride);
    let noise = fitted(&together(&of_faces), spacing, n_centers).unwrap_or(Noise {
        white,
        correlated: white,
        length: UNSEEN_LENGTH * spacing,
    });
    Noise { white: noise.white.max(tolerances.rounding()), ..noise }
}

/// Where pairs are looked for.
struct Scan<'a> {
    mesh: &'a Mesh,
    adjacency: &'a Adjacency,
    residuals: &'a Residuals,
    /// Of its vertices, length.
    spacing: f64,
}

/// Sums over pairs of vertices of one face, by their distance.
#[derive(Debug, Clone)]
struct Variogram {
    /// Sums of the square roots of the magnitudes of differences.
    roots: [f64; N_BINS],
    /// Sums of distances, length.
    distances: [f64; N_BINS],
    n_pairs: [usize; N_BINS],
}

/// One distance of a variogram.
#[derive(Debug, Clone, Copy)]
struct Bin {
    /// Mean distance, length.
    distance: f64,
    /// Half the mean squared difference, length squared.
    gamma: f64,
    /// Number of pairs.
    n: f64,
}

impl Variogram {
    /// The variogram of one face, from every so many of its vertices.
    fn new(scan: &Scan, core: &[u32], stride: usize) -> Self {
        let spacing = scan.spacing;
        let reach = (WIDTH_SHARE * (core.len() as f64).sqrt()).min(N_BINS as f64) * spacing;
        let mut sum = Self { roots: [0.0; N_BINS], distances: [0.0; N_BINS], n_pairs: [0; N_BINS] };
        let mut walk = Walk::default();
        for &center in core.iter().step_by(stride) {
            sum.add_pairs_of(scan, &mut walk, center, reach);
        }
        sum
    }

    fn add_pairs_of(&mut self, scan: &Scan, walk: &mut Walk, center: u32, reach: f64) {
        let Scan { mesh, residuals, spacing, .. } = scan;
        let around = walk.around(scan, center, reach);
        let stride = around.len().div_ceil(MOST_PAIRS).max(1);
        let (own, at) = (residuals.of_vertex[center as usize], mesh.vertices[center as usize]);
        for &v in around.iter().step_by(stride) {
            let distance = (mesh.vertices[v as usize] - at).norm();
            let bin = (distance / spacing) as usize;
            if v != center && bin < N_BINS {
                self.roots[bin] += (residuals.of_vertex[v as usize] - own).abs().sqrt();
                self.distances[bin] += distance;
                self.n_pairs[bin] += 1;
            }
        }
    }

    fn bin(&self, k: usize) -> Option<Bin> {
        let n = self.n_pairs[k] as f64;
        // The fourth power of the mean root, over what it is for a unit normal distribution (Cressie, Hawkins).
        let gamma = || 0.5 * (self.roots[k] / n).powi(4) / (0.457 + 0.494 / n);
        (self.n_pairs[k] >= MIN_PAIRS).then(|| Bin { distance: self.distances[k] / n, gamma: gamma(), n })
    }
}

/// The bins of all faces together, each with its median over faces, which count by their pairs: a face that holds something
/// of a neighbour, or is of another type than was found, shows more than noise.
fn together(of_faces: &[Variogram]) -> Vec<Bin> {
    let median = |k: usize| {
        let mut bins: Vec<Bin> = of_faces.iter().filter_map(|v| v.bin(k)).collect();
        bins.sort_by(|a, b| a.gamma.total_cmp(&b.gamma));
        let n: f64 = bins.iter().map(|bin| bin.n).sum();
        let mut below = 0.0;
        let middle = bins.into_iter().find(|bin| {
            below += bin.n;
            2.0 * below >= n
        });
        middle.map(|bin| Bin { n, ..bin })
    };
    (0..N_BINS).filter_map(median).collect()
}

/// The noise with the variogram `bins`; `None` when too few distances were compared.
///
/// From `n` vertices the variance of white noise is known within `sqrt(2 / n)` of it: correlated noise that is not more than
/// four times that is chance, and would be taken for what no number of vertices averages.
fn fitted(bins: &[Bin], spacing: f64, n: usize) -> Option<Noise> {
    /// Least bins: three unknowns and one to spare.
    const MIN_BINS: usize = 4;
    /// Lengths of correlation that are tried, in spacings: from what is as good as white to what looks like form.
    const LENGTHS: [f64; 2] = [1.5, 24.0];
    const RATIO: f64 = 1.08;
    if bins.len() < MIN_BINS {
        return None;
    }
    let n_lengths = ((LENGTHS[1] / LENGTHS[0]).ln() / RATIO.ln()) as i32;
    let lengths = (0..=n_lengths).map(|i| LENGTHS[0] * RATIO.powi(i) * spacing);
    lengths
        .map(|length| {
            let (white, correlated, misfit) = two_variances(bins, length);
            (misfit, Noise { white: white.sqrt(), correlated: correlated.sqrt(), length })
        })
        .filter(|(misfit, noise)| misfit.is_finite() && noise.sigma() > 0.0)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, noise)| {
            let chance = 4.0 * (2.0 / n.max(1) as f64).sqrt() * noise.white.powi(2);
            if noise.correlated.powi(2) > chance { noise } else { Noise { correlated: 0.0, ..noise } }
        })
}

/// Variances of white noise and of noise correlated over `length` that explain the bins of a variogram best, neither
/// negative, and the weighted sum of squares that is left.
fn two_variances(bins: &[Bin], length: f64) -> (f64, f64, f64) {
    let rise = |d: f64| 1.0 - (-(d / length).powi(2)).exp();
    let weight = |bin: &Bin| bin.n / (bin.gamma * bin.gamma);
    let misfit = |white: f64, correlated: f64| -> f64 {
        bins.iter().map(|b| weight(b) * (white + correlated * rise(b.distance) - b.gamma).powi(2)).sum()
    };
    let (mut s, mut sr, mut srr, mut sg, mut srg) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for bin in bins {
        let (w, r) = (weight(bin), rise(bin.distance));
        s += w;
        sr += w * r;
        srr += w * r * r;
        sg += w * bin.gamma;
        srg += w * r * bin.gamma;
    }
    let determinant = s * srr - sr * sr;
    let both = ((sg * srr - srg * sr) / determinant, (srg * s - sg * sr) / determinant);
    let candidates = [both, (sg / s, 0.0), (0.0, srg / srr)];
    let feasible = candidates.into_iter().filter(|(a, b)| *a >= 0.0 && *b >= 0.0);
    let best = feasible.map(|(a, b)| (a, b, misfit(a, b))).min_by(|x, y| x.2.total_cmp(&y.2));
    best.unwrap_or((0.0, 0.0, f64::INFINITY))
}

/// A walk over a face, its memory kept between centers.
#[derive(Default)]
struct Walk {
    seen: Vec<bool>,
    found: Vec<u32>,
}

impl Walk {
    /// Vertices of the face of `center` that can be walked to within `reach` of it, in the order of the walk.
    fn around(&mut self, scan: &Scan, center: u32, reach: f64) -> &[u32] {
        let Scan { mesh, adjacency, residuals, .. } = scan;
        self.seen.resize(mesh.vertices.len(), false);
        for &v in &self.found {
            self.seen[v as usize] = false;
        }
        self.found.clear();
        self.found.push(center);
        self.seen[center as usize] = true;
        let (at, region) = (mesh.vertices[center as usize], residuals.region[center as usize]);
        let mut next = 0;
        while let Some(&v) = self.found.get(next) {
            next += 1;
            for &w in adjacency.vertex_vertices.row(v as usize) {
                let near = (mesh.vertices[w as usize] - at).norm_squared() < reach * reach;
                if near && residuals.region[w as usize] == region && !self.seen[w as usize] {
                    self.seen[w as usize] = true;
                    self.found.push(w);
                }
            }
        }
        &self.found
    }
}
