//! What power iteration leaves of a few vectors over a graph: the embedding of 3D-PIC.
//!
//! F. Lin, W. Cohen, "Power iteration clustering", ICML 2010, iterate one vector, that of the degrees, and stop while what
//! tells groups apart is still there. One number per node cannot tell many groups apart, and on a part whose faces are alike
//! (a cube) the degrees tell none. Ours: random vectors beside it. What is left of a random vector is nearly constant on each
//! face, so each is a random projection of the faces, and some multiple of `log k` of them keeps all `k` apart: W. Johnson, J. Lindenstrauss, "Extensions of Lipschitz mappings into a Hilbert space", Contemporary Mathematics 26 (1984),
//! 189-206.
//!
//! Also ours: on a face of `m` nodes a vector needs some `m` rounds to become constant, so on the fine graph of a large scan it
//! would be stopped before faces part. Large graphs are walked coarsely first, strongly joined nodes as one, as in I. Dhillon,
//! Y. Guan, B. Kulis, "Weighted graph cuts without eigenvectors", IEEE Transactions on Pattern Analysis and Machine Intelligence
//! 29 (2007), 1944-1957, section 5.1.
//!
//! Cost: at most [`MAX_ROUNDS`] looks at every edge per vector and level.

use nalgebra::DVector;

use super::graph::Graph;
use crate::mesh::Csr;
use crate::par;
use crate::random::Rng;

/// Change of its steps at which a vector no longer speeds up, where its magnitudes have the mean one: that of the paper,
/// section 2.3.
const STILL: f64 = 1e-5;
/// Most rounds of one vector on one graph.
const MAX_ROUNDS: usize = 1000;
/// Fewest vectors. With five, as the logarithm gives for six groups, four of fifteen starts on cubes put two faces together;
/// with eight none of 25.
const FEWEST_VECTORS: usize = 8;
/// Nodes that so many rounds even out on faces. With 2 000 the six faces of a box of 140 000 triangles came in nine pieces and
/// more; with 500 the mean overlap on the benchmark was 0.02 lower.
const COARSE: usize = 1_500;
/// Weight, of the strongest of either node, from which two are strongly joined: creases are weaker by far.
const STRONG: f64 = 0.1;

/// Vectors that tell `k` groups apart.
pub(super) fn n_vectors(k: usize) -> usize {
    ((k as f64).log2().ceil() as usize + 2).max(FEWEST_VECTORS)
}

/// The first `n_vectors` vectors, each of mean zero and deviation one: what is left of the degrees, then of random values.
pub(super) fn vectors(graph: &Graph, n_vectors: usize, seed: u64) -> Vec<DVector<f64>> {
    let levels = levels(graph);
    let walks: Vec<Walk> =
        std::iter::once(graph).chain(levels.iter().map(|level| &level.graph)).map(Walk::of).collect();
    par::map_indices(n_vectors, |j| {
        let mut rng = Rng::for_task(seed, "power iteration", j as u64);
        let coarsest = &walks[walks.len() - 1];
        let start = |i: usize| if j == 0 { coarsest.degrees[i] } else { rng.uniform() };
        let mut v = coarsest
            .stopped_early(DVector::from_iterator(coarsest.graph.n, (0..coarsest.graph.n).map(start)));
        for (level, finer) in levels.iter().zip(&walks).rev() {
            v = finer.stopped_early(DVector::from_fn(finer.graph.n, |i, _| v[level.coarse_of[i] as usize]));
        }
        standardized(v)
    })
}

/// A graph whose nodes are pairs of a finer one's, or single ones.
struct Level {
    graph: Graph,
    /// The node here of every node of the finer graph.
    coarse_of: Vec<u32>,
}

/// Coarser and coarser graphs, down to [`COARSE`] nodes or as far as nodes are strongly joined.
fn levels(graph: &Graph) -> Vec<Level> {
    /// Fewer pairs than this share are not worth a level.
    const WORTH: f64 = 0.1;
    let mut levels: Vec<Level> = Vec::new();
    loop {
        let finest = levels.last().map_or(graph, |level| &level.graph);
        if finest.n <= COARSE {
            return levels;
        }
        let next = paired(finest);
        if next.graph.n as f64 > (1.0 - WORTH) * finest.n as f64 {
            return levels;
        }
        levels.push(next);
    }
}

/// Each node with the one that it is joined to most strongly and that is still single.
fn paired(graph: &Graph) -> Level {
    let mut strongest = vec![0.0_f64; graph.n];
    for &(a, b, weight) in &graph.edges {
        for k in [a, b] {
            strongest[k as usize] = strongest[k as usize].max(weight);
        }
    }
    // Edges by their numbers, so that weights are at hand.
    let ends = graph.edges.iter().enumerate().flat_map(|(e, edge)| [(edge.0, e as u32), (edge.1, e as u32)]);
    let edges_at = Csr::from_pairs(graph.n, ends);
    let mut coarse_of = vec![u32::MAX; graph.n];
    let mut n = 0;
    for k in 0..graph.n {
        if coarse_of[k] != u32::MAX {
            continue;
        }
        let mut best: Option<(f64, u32)> = None;
        for &e in edges_at.row(k) {
            let (a, b, weight) = graph.edges[e as usize];
            let other = if a as usize == k { b } else { a };
            let is_strong = weight >= STRONG * strongest[k].max(strongest[other as usize]);
            if coarse_of[other as usize] == u32::MAX && is_strong && best.is_none_or(|best| weight > best.0) {
                best = Some((weight, other));
            }
        }
        coarse_of[k] = n;
        if let Some((_, other)) = best {
            coarse_of[other as usize] = n;
        }
        n += 1;
    }
    let mut edges: Vec<(u32, u32, f64)> = graph
        .edges
        .iter()
        .map(|&(a, b, weight)| (coarse_of[a as usize], coarse_of[b as usize], weight))
        .filter(|(a, b, _)| a != b)
        .map(|(a, b, weight)| (a.min(b), a.max(b), weight))
        .collect();
    edges.sort_by_key(|edge| (edge.0, edge.1));
    let joined = edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1));
    let edges = joined.map(|group| (group[0].0, group[0].1, group.iter().map(|e| e.2).sum())).collect();
    Level { graph: Graph { n: n as usize, edges }, coarse_of }
}

/// The lazy random walk on a graph.
struct Walk<'a> {
    graph: &'a Graph,
    degrees: Vec<f64>,
    total: f64,
}

impl<'a> Walk<'a> {
    fn of(graph: &'a Graph) -> Self {
        let degrees = graph.degrees();
        Self { graph, total: degrees.iter().sum(), degrees }
    }

    /// The vector after so many rounds that it no longer speeds up.
    fn stopped_early(&self, mut v: DVector<f64>) -> DVector<f64> {
        let mut last_step: Option<DVector<f64>> = None;
        for _ in 0..MAX_ROUNDS {
            let next = self.step(&v);
            let step = (&next - &v).abs();
            let still = last_step.as_ref().is_some_and(|last| (&step - last).amax() < STILL);
            v = next;
            last_step = Some(step);
            if still {
                break;
            }
        }
        v
    }

    /// One round `(v + D^-1 W v) / 2`, without the constant vector that all end in, magnitudes scaled to the mean one. Half
    /// stays where it is: on a grid, whose nodes are of two colors, a walk that always leaves never settles.
    fn step(&self, v: &DVector<f64>) -> DVector<f64> {
        let mut next = DVector::zeros(self.graph.n);
        for &(a, b, weight) in &self.graph.edges {
            let (a, b) = (a as usize, b as usize);
            next[a] += weight * v[b];
            next[b] += weight * v[a];
        }
        let mut mean = 0.0;
        for ((x, old), degree) in next.iter_mut().zip(v.iter()).zip(&self.degrees) {
            *x = 0.5 * (*x / degree.max(f64::MIN_POSITIVE) + old);
            mean += *x * degree / self.total.max(f64::MIN_POSITIVE);
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
