//! Hierarchical fitting primitives.
//!
//! M. Attene, B. Falcidieno, M. Spagnuolo, "Hierarchical mesh segmentation based on fitting primitives", The Visual Computer 22
//! (2006), 181-193: of all neighbouring clusters the two are merged that one plane, sphere or cylinder fits best together, until
//! one is left; any number of clusters is a cut of that tree.
//!
//! Published: the above, from single triangles, with fits in closed form (those of [`crate::fit`]). Reconstructed: the error of a
//! cluster as the integral of the squared distance. Ours: patches to start from; distances at a sample of a cluster's triangles,
//! so that a merge costs the same however large the clusters; the number where it is not given, by the jumps in the error.
//!
//! Cost O(n log n) for n patches of few neighbours. What it cannot do: a fillet is merged into what it is tangent to, as its
//! error is small beside that of large faces in noise.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Baseline;
use crate::fit::{FitMethod, Samples, fit_known};
use crate::math::Vec3;
use crate::mesh::Mesh;
use crate::par;
use crate::segment::spectral::MOST_GROUPS;
use crate::segment::spectral::patches::Patches;
use crate::segment::spectral::regions::{best_described, widest_gaps};
use crate::segment::{Scan, Segmentation};
use crate::surface::SurfaceKind;

/// Most patches.
const MOST_PATCHES: usize = 15_000;
/// Samples that the error of two clusters is measured at.
const N_SAMPLES: usize = 64;
/// The types of the paper.
const KINDS: [SurfaceKind; 3] = [SurfaceKind::Plane, SurfaceKind::Sphere, SurfaceKind::Cylinder];

/// Segments a scan.
pub(in crate::segment) fn run(scan: &Scan, options: &Baseline) -> Segmentation {
    let patches = Patches::of(scan, MOST_PATCHES, options.seed);
    let merges = Hierarchy::of(scan.mesh, &patches).merged();
    let n = patches.all.len();
    let tried = options.n_regions.map_or_else(|| by_jump(&merges, n), |k| vec![k]);
    best_described(scan, &tried, |k| patches.of_triangles(&cut(&merges, n, k)))
}

/// Two clusters become one that is called as the first.
struct Merge {
    kept: u32,
    gone: u32,
    error: f64,
}

/// The cluster of every patch of `n` when `k` are left, or as few as merges leave.
fn cut(merges: &[Merge], n: usize, k: usize) -> Vec<u32> {
    let mut cluster: Vec<u32> = (0..n as u32).collect();
    // Last first: what a cluster was merged into is then final.
    for merge in merges[..n.saturating_sub(k).min(merges.len())].iter().rev() {
        cluster[merge.gone as usize] = cluster[merge.kept as usize];
    }
    cluster
}

/// The numbers of clusters whose next merge costs most beside the one before; largest jump first.
fn by_jump(merges: &[Merge], n: usize) -> Vec<usize> {
    let fewest = n - merges.len();
    let jump = |k: usize| {
        // Clusters that do not touch are never merged.
        let Some(next) = merges.get(n - k) else { return 1.0 };
        let last = n.checked_sub(k + 1).map_or(0.0, |i| merges[i].error);
        (next.error - last) / next.error.max(f64::MIN_POSITIVE)
    };
    let numbers = widest_gaps(fewest.max(2)..(fewest + MOST_GROUPS).min(n + 1), jump);
    if numbers.is_empty() { vec![fewest.max(1)] } else { numbers }
}

struct Cluster {
    triangles: Vec<u32>,
    area: f64,
    /// Clusters that it touches, ascending.
    beside: Vec<u32>,
    /// How often it was merged: what the heap knows of an older one is out of date.
    version: u32,
}

struct Hierarchy<'a> {
    mesh: &'a Mesh,
    /// One per triangle.
    normals: &'a [Vec3],
    clusters: Vec<Cluster>,
    heap: BinaryHeap<Reverse<Offer>>,
}

/// What merging two clusters would cost; ordered by that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Offer {
    /// Of the error, which is not negative: they are in its order.
    bits: u64,
    pair: [u32; 2],
    /// Of both clusters when the offer was made.
    versions: [u32; 2],
}

impl<'a> Hierarchy<'a> {
    /// Patches, and what merging each two neighbours would cost.
    fn of(mesh: &'a Mesh, patches: &'a Patches) -> Self {
        let mut clusters: Vec<Cluster> = patches
            .triangles()
            .into_iter()
            .zip(&patches.all)
            .map(|(triangles, patch)| Cluster { triangles, area: patch.area, beside: Vec::new(), version: 0 })
            .collect();
        for border in &patches.borders {
            let [a, b] = border.between;
            clusters[a as usize].beside.push(b);
            clusters[b as usize].beside.push(a);
        }
        for cluster in &mut clusters {
            cluster.beside.sort_unstable();
        }
        let mut hierarchy = Self { mesh, normals: &patches.normals, clusters, heap: BinaryHeap::new() };
        let pairs: Vec<[u32; 2]> = patches.borders.iter().map(|border| border.between).collect();
        hierarchy.offer(&pairs);
        hierarchy
    }

    /// All merges, in order.
    fn merged(mut self) -> Vec<Merge> {
        let mut merges = Vec::with_capacity(self.clusters.len());
        while let Some(Reverse(Offer { bits, pair, versions })) = self.heap.pop() {
            if pair.map(|k| self.clusters[k as usize].version) != versions {
                continue;
            }
            let [kept, gone] = pair;
            self.merge(kept, gone);
            merges.push(Merge { kept, gone, error: f64::from_bits(bits) });
            let pairs: Vec<[u32; 2]> =
                self.clusters[kept as usize].beside.iter().map(|&k| [kept.min(k), kept.max(k)]).collect();
            self.offer(&pairs);
        }
        merges
    }

    fn merge(&mut self, kept: u32, gone: u32) {
        let Cluster { mut triangles, area, beside, .. } = std::mem::replace(
            &mut self.clusters[gone as usize],
            Cluster { triangles: Vec::new(), area: 0.0, beside: Vec::new(), version: u32::MAX },
        );
        for &k in &beside {
            let others = &mut self.clusters[k as usize].beside;
            others.retain(|other| *other != gone);
            if k != kept
                && let Err(place) = others.binary_search(&kept)
            {
                others.insert(place, kept);
            }
        }
        let into = &mut self.clusters[kept as usize];
        // The shorter to the longer: each triangle moves at most log n times.
        if triangles.len() > into.triangles.len() {
            std::mem::swap(&mut triangles, &mut into.triangles);
        }
        into.triangles.extend(triangles);
        into.area += area;
        into.beside.extend(beside.into_iter().filter(|k| *k != kept));
        into.beside.sort_unstable();
        into.beside.dedup();
        into.version += 1;
    }

    /// Puts what merging pairs would cost on the heap.
    fn offer(&mut self, pairs: &[[u32; 2]]) {
        let errors = par::map(pairs, |pair| self.error(*pair));
        for (&pair, error) in pairs.iter().zip(errors) {
            let versions = pair.map(|k| self.clusters[k as usize].version);
            self.heap.push(Reverse(Offer { bits: error.to_bits(), pair, versions }));
        }
    }

    /// Integral of the squared distance of two clusters to the plane, sphere or cylinder that fits both best; length to the
    /// fourth.
    fn error(&self, pair: [u32; 2]) -> f64 {
        let [a, b] = pair.map(|k| &self.clusters[k as usize]);
        let share = a.triangles.len() as f64 / (a.triangles.len() + b.triangles.len()) as f64;
        let of_a = ((N_SAMPLES as f64 * share).round() as usize).clamp(1, N_SAMPLES - 1);
        let samples =
            self.samples(&a.triangles, of_a).followed_by(&self.samples(&b.triangles, N_SAMPLES - of_a));
        let mean_sq = KINDS.into_iter().map(|kind| mean_sq(kind, &samples)).fold(f64::INFINITY, f64::min);
        // Too few to show any surface: they are whatever their neighbours are.
        if mean_sq.is_finite() { mean_sq * (a.area + b.area) } else { 0.0 }
    }

    /// The middles of `n` of the triangles, or of all, with their normals.
    fn samples(&self, triangles: &[u32], n: usize) -> Samples {
        let n = n.min(triangles.len());
        let picked = (0..n).map(|i| triangles[i * triangles.len() / n] as usize);
        let (points, normals) = picked.map(|t| (self.mesh.triangle_center(t), self.normals[t])).unzip();
        Samples { points, normals }
    }
}

fn mean_sq(kind: SurfaceKind, samples: &Samples) -> f64 {
    // Fits in closed form ask for no noise.
    let Some(surface) = fit_known(kind, samples, 0.0, FitMethod::Attene) else { return f64::INFINITY };
    let sum: f64 = samples.points.iter().map(|p| surface.signed_distance(p).powi(2)).sum();
    let mean = sum / samples.points.len().max(1) as f64;
    if mean.is_finite() { mean } else { f64::INFINITY }
}
