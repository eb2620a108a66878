//! Segmentation by the spectrum of a graph: the thesis's 3D-NCuts and 3D-PIC.
//!
//! The nodes of a graph are cut into groups that are well joined inside and badly to one another. 3D-NCuts groups by the
//! eigenvectors of the normalized Laplacian: J. Shi, J. Malik, "Normalized cuts and image segmentation", IEEE Transactions
//! on Pattern Analysis and Machine Intelligence 22 (2000), 888-905; rows made unit vectors as by A. Ng, M. Jordan, Y. Weiss,
//! "On spectral clustering", NIPS 2001. 3D-PIC groups by vectors that a few rounds of power iteration leave: F. Lin,
//! W. Cohen, "Power iteration clustering", ICML 2010.
//!
//! Known of the thesis: vertices are the nodes, their normals are compared, PIC was modified. Reconstructed: the measure
//! ([`affinity`]). Ours: patches as nodes, so that a million triangles can be cut; several vectors in PIC, as one cannot
//! tell many groups apart; the number of regions by the gap in the eigenvalues and by how well surfaces fit.
//!
//! What neither can do, whatever the measure: tell a fillet from the planes it is tangent to by normals alone; keep a large
//! face whole beside small ones, as cuts want groups of one size. `docs/thesis.md` has the figures beside the default's.

mod affinity;
mod cluster;
mod graph;
mod regions;
mod superfacets;

use nalgebra::DVector;

use super::Segmentation;
use super::field::Field;
use crate::math::Vec3;
use crate::mesh::{Adjacency, Mesh};
use crate::random::Rng;
use graph::{Eigen, Graph};

/// Options of both methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Spectral {
    /// Number of groups, at most [`MOST_ASKED`]; found when `None`. A group in several pieces gives several regions.
    pub n_regions: Option<usize>,
    /// What is grouped. Default: patches.
    pub nodes: Nodes,
    /// Seed of the starts. Default 1.
    pub seed: u64,
}

/// What a graph joins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Nodes {
    /// Up to some thousand patches of triangles.
    #[default]
    Patches,
    /// Vertices, as in the thesis: for a hundred thousand, not for millions.
    Vertices,
}

impl Default for Spectral {
    fn default() -> Self {
        Self { n_regions: None, nodes: Nodes::default(), seed: 1 }
    }
}

/// Which vectors the nodes are grouped by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Vectors {
    /// Eigenvectors.
    Eigen,
    /// Power iteration.
    Power,
}

/// Most groups that are looked for when their number is not given.
const MOST_GROUPS: usize = 40;
/// Most groups that may be asked for: the work grows with their square.
pub const MOST_ASKED: usize = 500;
/// Numbers of groups that are tried out: those with the largest gaps.
const N_TRIED: usize = 6;
/// Triangles per patch, and most patches.
const PATCH_TRIANGLES: usize = 24;
const MOST_PATCHES: usize = 15_000;

/// Segments a mesh. `normal_noise`: deviation of the mesh's raw normals, radians.
pub(super) fn run(
    mesh: &Mesh,
    adjacency: &Adjacency,
    field: &Field,
    normal_noise: f64,
    vectors: Vectors,
    options: &Spectral,
) -> Segmentation {
    let normals = triangle_normals(mesh, field, normal_noise);
    let nodes = match options.nodes {
        Nodes::Vertices => GraphNodes::Vertices,
        Nodes::Patches => {
            let n = (mesh.triangles.len() / PATCH_TRIANGLES).clamp(1, MOST_PATCHES);
            // Normals of the filter, whose noise is a third of that of the raw ones at most.
            let filtered = normal_noise.max(0.05) / 3.0;
            GraphNodes::Patches(superfacets::superfacets(
                mesh,
                adjacency,
                &normals,
                filtered,
                n,
                options.seed,
            ))
        }
    };
    let graph = match &nodes {
        GraphNodes::Vertices => affinity::of_vertices(field, normal_noise),
        GraphNodes::Patches(patch_of) => {
            affinity::of_patches(mesh, adjacency, &normals, normal_noise, patch_of)
        }
    };
    let weights = nodes.areas(mesh, graph.n);
    let most = options.n_regions.map_or(MOST_GROUPS, |k| k.min(MOST_ASKED)) + 1;
    let parts: Vec<Part> = graph
        .parts()
        .into_iter()
        .filter_map(|(members, graph)| {
            let eigen = graph.smallest_eigenpairs(most, options.seed)?;
            Some(Part { members, graph, eigen })
        })
        .collect();
    let tried = options.n_regions.map_or_else(|| by_gap(&parts), |k| vec![k.min(MOST_ASKED)]);
    let segmented = crate::par::map(&tried, |&k| {
        let groups = groups(&parts, &weights, k, vectors, options.seed, graph.n);
        regions::of_groups(mesh, adjacency, field, &nodes.of_triangles(mesh, &groups))
    });
    let best = segmented.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, regions)| regions.segmentation(field)).unwrap_or_default()
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

enum GraphNodes {
    Vertices,
    /// The patch of every triangle.
    Patches(Vec<u32>),
}

impl GraphNodes {
    /// Area of every node.
    fn areas(&self, mesh: &Mesh, n: usize) -> Vec<f64> {
        let mut areas = vec![0.0; n];
        for t in 0..mesh.triangles.len() {
            let area = mesh.area(t);
            match self {
                Self::Vertices => mesh.triangles[t].iter().for_each(|&v| areas[v as usize] += area / 3.0),
                Self::Patches(patch_of) => areas[patch_of[t] as usize] += area,
            }
        }
        areas
    }

    /// The group of every triangle: that of its patch, or of most of its vertices.
    fn of_triangles(&self, mesh: &Mesh, groups: &[u32]) -> Vec<u32> {
        match self {
            Self::Patches(patch_of) => patch_of.iter().map(|p| groups[*p as usize]).collect(),
            Self::Vertices => mesh
                .triangles
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(|v| groups[v as usize]);
                    if b == c { b } else { a }
                })
                .collect(),
        }
    }
}

/// A connected part of the graph.
struct Part {
    members: Vec<u32>,
    graph: Graph,
    eigen: Eigen,
}

/// The numbers of groups with the largest gaps after them, relative to the eigenvalue above; largest first.
fn by_gap(parts: &[Part]) -> Vec<usize> {
    let mut values: Vec<f64> = parts.iter().flat_map(|p| p.eigen.values.iter().copied()).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().min(parts.len() + MOST_GROUPS);
    let gap = |k: usize| (values[k] - values[k - 1]) / values[k].max(f64::MIN_POSITIVE);
    let mut numbers: Vec<usize> = (parts.len().max(2)..last).collect();
    numbers.sort_by(|&a, &b| gap(b).total_cmp(&gap(a)).then(a.cmp(&b)));
    numbers.truncate(N_TRIED);
    if numbers.is_empty() { vec![parts.len().max(1)] } else { numbers }
}

/// The group of every node of the whole graph, `k` groups together.
fn groups(
    parts: &[Part],
    weights: &[f64],
    k: usize,
    vectors: Vectors,
    seed: u64,
    n_nodes: usize,
) -> Vec<u32> {
    let mut group_of = vec![0; n_nodes];
    let mut first = 0;
    for (part, k) in parts.iter().zip(shares(parts, k)) {
        let weights: Vec<f64> = part.members.iter().map(|&m| weights[m as usize]).collect();
        let points = match vectors {
            Vectors::Eigen => part.by_eigenvectors(k),
            Vectors::Power => part.by_power_iteration(k, seed),
        };
        for (member, label) in part.members.iter().zip(cluster::k_means(&points, &weights, k, seed)) {
            group_of[*member as usize] = first + label;
        }
        first += k as u32;
    }
    group_of
}

/// How many of `k` groups each part gets: one, and one more for each of its eigenvalues among the smallest.
fn shares(parts: &[Part], k: usize) -> Vec<usize> {
    let mut values: Vec<(f64, usize)> = parts
        .iter()
        .enumerate()
        .flat_map(|(i, part)| part.eigen.values.iter().skip(1).map(move |value| (*value, i)))
        .collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut shares = vec![1; parts.len()];
    for (_, i) in values.into_iter().take(k.saturating_sub(parts.len())) {
        shares[i] += 1;
    }
    shares
}

impl Part {
    /// Rows of the first `k` eigenvectors, made unit vectors.
    fn by_eigenvectors(&self, k: usize) -> Vec<Vec<f64>> {
        (0..self.graph.n)
            .map(|i| {
                let row: Vec<f64> = self.eigen.vectors.iter().take(k).map(|v| v[i]).collect();
                let length = row.iter().map(|x| x * x).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
                row.into_iter().map(|x| x / length).collect()
            })
            .collect()
    }

    /// What power iteration leaves of the degrees and of some random vectors, each stopped when it no longer speeds up.
    fn by_power_iteration(&self, k: usize, seed: u64) -> Vec<Vec<f64>> {
        /// Change of its steps at which a vector no longer speeds up, where its magnitudes have the mean one: that of the
        /// paper, section 2.3.
        const STILL: f64 = 1e-5;
        const MAX_ROUNDS: usize = 1000;
        let degrees = self.graph.degrees();
        let total: f64 = degrees.iter().sum();
        let n_vectors = (k as f64).log2().ceil() as usize + 2;
        let n = self.graph.n;
        let vectors = (0..n_vectors as u64).map(|j| {
            let mut rng = Rng::for_task(seed, "power iteration", j);
            let mut v = DVector::from_fn(n, |i, _| if j == 0 { degrees[i] } else { rng.uniform() });
            let mut last_step: Option<DVector<f64>> = None;
            for _ in 0..MAX_ROUNDS {
                let next = self.walk(&v, &degrees, total);
                let step = (&next - &v).abs();
                let still = last_step.as_ref().is_some_and(|last| (&step - last).amax() < STILL);
                v = next;
                last_step = Some(step);
                if still {
                    break;
                }
            }
            standardized(v)
        });
        let vectors: Vec<DVector<f64>> = vectors.collect();
        (0..n).map(|i| vectors.iter().map(|v| v[i]).collect()).collect()
    }

    /// One round `(v + D^-1 W v) / 2`, without the constant vector that all end in, magnitudes scaled to the mean one. Half
    /// stays where it is: on a grid, whose nodes are of two colors, a walk that always leaves never settles.
    fn walk(&self, v: &DVector<f64>, degrees: &[f64], total: f64) -> DVector<f64> {
        let mut next = DVector::zeros(self.graph.n);
        for &(a, b, weight) in &self.graph.edges {
            let (a, b) = (a as usize, b as usize);
            next[a] += weight * v[b];
            next[b] += weight * v[a];
        }
        let mut mean = 0.0;
        for ((x, old), degree) in next.iter_mut().zip(v.iter()).zip(degrees) {
            *x = 0.5 * (*x / degree.max(f64::MIN_POSITIVE) + old);
            mean += *x * degree / total.max(f64::MIN_POSITIVE);
        }
        next.add_scalar_mut(-mean);
        let size = next.abs().mean();
        if size > 0.0 { next / size } else { next }
    }
}

/// A vector of mean zero and deviation one.
fn standardized(mut v: DVector<f64>) -> DVector<f64> {
    v.add_scalar_mut(-v.mean());
    let deviation = (v.norm_squared() / v.len().max(1) as f64).sqrt();
    if deviation > 0.0 { v / deviation } else { v }
}
