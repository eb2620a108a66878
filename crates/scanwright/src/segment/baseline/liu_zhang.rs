//! Groups by the eigenvectors of all distances over the surface.
//!
//! R. Liu, H. Zhang, "Segmentation of 3D meshes through spectral clustering", Pacific Graphics 2004, 298-305; the distance is
//! that of S. Katz, A. Tal, "Hierarchical mesh decomposition using fuzzy clustering and cuts", ACM Transactions on Graphics 22
//! (2003), 954-961. A step between neighbours is `DELTA` of its way over the surface and the rest of its angle, `eta (1 - cos)`
//! with `eta` small over convex edges, each over its mean; distances are shortest ways, weights `exp(-d / 2 s^2)` with `s` the
//! mean distance, and rows of the largest eigenvectors of `D^-1/2 W D^-1/2`, made unit vectors, are clustered.
//!
//! Published: the above, on single triangles. Ours: patches, as the matrix is full; k-means from spread starts, where the paper
//! chooses its starts by the least alike rows; the number of groups where it is not given, by the gaps in the eigenvalues.
//!
//! Cost O(n^2 log n) for n patches, memory O(n^2): at most [`MOST_PATCHES`].

use super::Baseline;
use crate::par;
use crate::segment::spectral::graph::Graph;
use crate::segment::spectral::patches::{Border, Patches};
use crate::segment::spectral::paths::from_nearest;
use crate::segment::spectral::{self, GraphNodes, Nodes, Spectral, Vectors};
use crate::segment::{Scan, Segmentation};

/// Most patches: their weights take 32 MB.
const MOST_PATCHES: usize = 2_000;
/// Share of the way in a step: the paper takes 0.01 to 0.05.
const DELTA: f64 = 0.03;
/// What the angle of a convex edge counts beside that of a concave one: the paper takes 0.1 to 0.2.
const CONVEX: f64 = 0.2;

/// Segments a scan.
pub(in crate::segment) fn run(scan: &Scan, options: &Baseline) -> Segmentation {
    let patches = Patches::of(scan, MOST_PATCHES, options.seed);
    let graph = of_distances(&patches);
    let spectral = Spectral { n_regions: options.n_regions, nodes: Nodes::Patches, seed: options.seed };
    spectral::by_graph(scan, &GraphNodes::Patches(patches), &graph, Vectors::Eigen, &spectral)
}

/// The full graph of all patches that some way joins.
fn of_distances(patches: &Patches) -> Graph {
    let n = patches.all.len();
    let steps = steps(patches);
    let mut beside: Vec<Vec<(u32, f64)>> = vec![Vec::new(); n];
    for (border, &step) in patches.borders.iter().zip(&steps) {
        let [a, b] = border.between;
        beside[a as usize].push((b, step));
        beside[b as usize].push((a, step));
    }
    let lengths =
        par::map_indices(n, |i| from_nearest(n, &[i as u32], |k| beside[k as usize].iter().copied()).1);
    let joined = |i: usize| (i + 1..n).map(move |j| (i, j)).filter(|&(i, j)| lengths[i][j].is_finite());
    let (sum, count) =
        (0..n).flat_map(joined).fold((0.0, 0_usize), |(sum, count), (i, j)| (sum + lengths[i][j], count + 1));
    let scale = sum / count.max(1) as f64;
    let weight =
        |way: f64| (-way / (2.0 * scale * scale).max(f64::MIN_POSITIVE)).exp().max(f64::MIN_POSITIVE);
    let edges = (0..n).flat_map(joined).map(|(i, j)| (i as u32, j as u32, weight(lengths[i][j])));
    Graph { n, edges: edges.collect() }
}

/// One per border: the length of the step across it.
fn steps(patches: &Patches) -> Vec<f64> {
    let ways_and_turns: Vec<(f64, f64)> = patches.borders.iter().map(|b| way_and_turn(patches, b)).collect();
    let n = ways_and_turns.len().max(1) as f64;
    let (way, turn) = ways_and_turns.iter().fold((0.0, 0.0), |sum, x| (sum.0 + x.0 / n, sum.1 + x.1 / n));
    let share = |x: f64, mean: f64| if mean > 0.0 { x / mean } else { 0.0 };
    ways_and_turns.iter().map(|x| DELTA * share(x.0, way) + (1.0 - DELTA) * share(x.1, turn)).collect()
}

/// The way between the middles of two patches over that of their border, and what the angle between their normals counts.
fn way_and_turn(patches: &Patches, border: &Border) -> (f64, f64) {
    let [a, b] = border.between.map(|k| &patches.all[k as usize].frame);
    let way = (a.origin - border.middle).norm() + (b.origin - border.middle).norm();
    // Normals point out of the material: over a convex edge they part.
    let is_convex = (b.z.into_inner() - a.z.into_inner()).dot(&(b.origin - a.origin)) > 0.0;
    (way, (1.0 - a.z.dot(&b.z)) * if is_convex { CONVEX } else { 1.0 })
}
