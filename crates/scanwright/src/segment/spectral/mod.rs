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
pub(super) mod cluster;
pub(super) mod graph;
pub(super) mod patches;
pub(super) mod paths;
mod power;
pub(super) mod regions;
mod superfacets;

use nalgebra::DVector;

use super::{Scan, Segmentation};
use crate::mesh::Mesh;
use crate::par;
use graph::{Eigen, Graph};
use patches::Patches;
use regions::{best_described, widest_gaps};

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
    /// Vertices, as in the thesis: at most [`Spectral::most_vertices`].
    Vertices,
}

impl Default for Spectral {
    fn default() -> Self {
        Self { n_regions: None, nodes: Nodes::default(), seed: 1 }
    }
}

impl Spectral {
    /// Most vertices that a part may have; none where patches are grouped. With more, the vectors among which Lanczos'
    /// method looks for eigenvectors, all kept to stay orthogonal, would take more than 2 GiB.
    pub fn most_vertices(&self) -> Option<usize> {
        const MOST_BYTES: usize = 2 << 30;
        let of_basis = graph::most_in_basis(self.most_eigenpairs()) * size_of::<f64>();
        (self.nodes == Nodes::Vertices).then_some(MOST_BYTES / of_basis)
    }

    /// One more than there may be groups: the last gap has two ends.
    fn most_eigenpairs(&self) -> usize {
        self.n_regions.map_or(MOST_GROUPS, |k| k.min(MOST_ASKED)) + 1
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
pub(super) const MOST_GROUPS: usize = 40;
/// Most groups that may be asked for: the work grows with their square.
pub const MOST_ASKED: usize = 500;
/// Most patches.
const MOST_PATCHES: usize = 15_000;

/// Segments a scan.
pub(super) fn run(scan: &Scan, vectors: Vectors, options: &Spectral) -> Segmentation {
    let nodes = match options.nodes {
        Nodes::Vertices => GraphNodes::Vertices,
        Nodes::Patches => GraphNodes::Patches(Patches::of(scan, MOST_PATCHES, options.seed)),
    };
    let graph = match &nodes {
        GraphNodes::Vertices => affinity::of_vertices(scan.field, scan.normal_noise),
        GraphNodes::Patches(patches) => affinity::of_patches(patches, scan.normal_noise),
    };
    by_graph(scan, &nodes, &graph, vectors, options)
}

/// Regions of the groups of a graph's nodes.
pub(super) fn by_graph(
    scan: &Scan,
    nodes: &GraphNodes,
    graph: &Graph,
    vectors: Vectors,
    options: &Spectral,
) -> Segmentation {
    let areas = nodes.areas(scan.mesh, graph.n);
    let most = options.most_eigenpairs();
    let mut parts: Vec<Part> = graph
        .parts()
        .into_iter()
        .filter_map(|(members, graph)| {
            let eigen = graph.smallest_eigenpairs(most, options.seed)?;
            let weights = members.iter().map(|&m| areas[m as usize]).collect();
            Some(Part { members, weights, graph, eigen, power: Vec::new() })
        })
        .collect();
    let tried = options.n_regions.map_or_else(|| by_gap(&parts), |k| vec![k.min(MOST_ASKED)]);
    if vectors == Vectors::Power {
        let most_tried = shares(&parts, tried.iter().copied().max().unwrap_or(1));
        for (part, k) in parts.iter_mut().zip(most_tried) {
            part.power = power::vectors(&part.graph, power::n_vectors(k), options.seed);
        }
    }
    best_described(scan, &tried, |k| {
        nodes.of_triangles(scan.mesh, &groups(&parts, k, vectors, options.seed, graph.n))
    })
}

/// What the nodes of a graph are.
pub(super) enum GraphNodes {
    Vertices,
    Patches(Patches),
}

impl GraphNodes {
    /// Area of every node.
    fn areas(&self, mesh: &Mesh, n: usize) -> Vec<f64> {
        let mut areas = vec![0.0; n];
        for t in 0..mesh.triangles.len() {
            let area = mesh.area(t);
            match self {
                Self::Vertices => mesh.triangles[t].iter().for_each(|&v| areas[v as usize] += area / 3.0),
                Self::Patches(patches) => areas[patches.patch_of[t] as usize] += area,
            }
        }
        areas
    }

    /// The group of every triangle: that of its patch, or of most of its vertices.
    fn of_triangles(&self, mesh: &Mesh, groups: &[u32]) -> Vec<u32> {
        match self {
            Self::Patches(patches) => patches.of_triangles(groups),
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
    /// One per member.
    weights: Vec<f64>,
    graph: Graph,
    eigen: Eigen,
    /// For 3D-PIC: as many as the largest number of groups needs.
    power: Vec<DVector<f64>>,
}

/// The numbers of groups with the largest gaps after them, relative to the eigenvalue above; largest first.
fn by_gap(parts: &[Part]) -> Vec<usize> {
    let mut values: Vec<f64> = parts.iter().flat_map(|p| p.eigen.values.iter().copied()).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().min(parts.len() + MOST_GROUPS);
    let gap = |k: usize| (values[k] - values[k - 1]) / values[k].max(f64::MIN_POSITIVE);
    let numbers = widest_gaps(parts.len().max(2)..last, gap);
    if numbers.is_empty() { vec![parts.len().max(1)] } else { numbers }
}

/// The group of every node of the whole graph, `k` groups together.
fn groups(parts: &[Part], k: usize, vectors: Vectors, seed: u64, n_nodes: usize) -> Vec<u32> {
    let mut group_of = vec![0; n_nodes];
    let mut first = 0;
    for (part, k) in parts.iter().zip(shares(parts, k)) {
        let points = match vectors {
            Vectors::Eigen => part.by_eigenvectors(k),
            Vectors::Power => part.by_power_iteration(k),
        };
        for (member, label) in part.members.iter().zip(cluster::k_means(&points, &part.weights, k, seed)) {
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
        let unit = |row: Vec<f64>| {
            let length = row.iter().map(|x| x * x).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
            row.into_iter().map(|x| x / length).collect()
        };
        par::map_indices(self.graph.n, |i| unit(self.eigen.vectors.iter().take(k).map(|v| v[i]).collect()))
    }

    /// Rows of as many of the power iteration's vectors as tell `k` groups apart.
    fn by_power_iteration(&self, k: usize) -> Vec<Vec<f64>> {
        let vectors = &self.power[..power::n_vectors(k).min(self.power.len())];
        par::map_indices(self.graph.n, |i| vectors.iter().map(|v| v[i]).collect())
    }
}
