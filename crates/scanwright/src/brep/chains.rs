//! Chains and loops: the topology of the solid, read off the borders between patches.
//!
//! A junction is a vertex where other than two border edges meet. Chains run from junction to junction; a loop with
//! fewer than two junctions gets pseudo-junctions, so there are no closed edges anywhere.

use super::halfedge::HalfEdges;
use crate::mesh::{Mesh, VertId};

/// Index of a chain.
pub(super) type ChainId = usize;

/// A run of border half-edges between two junctions, on the side of its left patch.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    /// Patch on the left.
    pub left: u32,
    /// Patch on the right; `None` on the boundary of an open mesh.
    pub right: Option<u32>,
    /// Vertices, both ends included.
    pub vertices: Vec<VertId>,
}

impl Chain {
    pub(super) fn start(&self) -> VertId {
        self.vertices[0]
    }

    pub(super) fn end(&self) -> VertId {
        self.vertices[self.vertices.len() - 1]
    }
}

/// One loop of a patch: its chains in order, and whether each is run along its direction.
#[derive(Debug, Clone)]
pub(super) struct ChainLoop {
    pub patch: u32,
    pub uses: Vec<(ChainId, bool)>,
}

/// All chains and loops.
#[derive(Debug, Clone, Default)]
pub(super) struct Topology {
    pub chains: Vec<Chain>,
    pub loops: Vec<ChainLoop>,
}

/// Traces the borders between patches. `patch_of`: one per triangle. `cornered`: whether each vertex is a junction
/// whatever meets there.
pub(super) fn trace(mesh: &Mesh, half_edges: &HalfEdges, patch_of: &[u32], cornered: &[bool]) -> Topology {
    let patch = |h: u32| patch_of[HalfEdges::triangle(h)];
    let across = |h: u32| half_edges.twin(h).map(patch);
    let is_border = |h: u32| across(h) != Some(patch(h));
    let loops = border_loops(half_edges, &is_border);
    let junction = junctions(mesh, half_edges, &loops, &is_border, cornered);
    let mut chain_of: Vec<Option<(ChainId, bool)>> = vec![None; half_edges.len()];
    let mut topology = Topology::default();
    for run in &loops {
        let Some(first) = run.iter().position(|h| junction[half_edges.from(*h) as usize]) else { continue };
        let turned: Vec<u32> = run[first..].iter().chain(&run[..first]).copied().collect();
        let mut uses = Vec::new();
        let mut from = 0;
        for i in 0..turned.len() {
            if !junction[half_edges.to(turned[i]) as usize] {
                continue;
            }
            let piece = &turned[from..=i];
            from = i + 1;
            uses.push(chain_of[piece[0] as usize].unwrap_or_else(|| {
                let id = topology.chains.len();
                let mut vertices: Vec<VertId> = piece.iter().map(|h| half_edges.from(*h)).collect();
                vertices.push(half_edges.to(piece[piece.len() - 1]));
                topology.chains.push(Chain { left: patch(piece[0]), right: across(piece[0]), vertices });
                for h in piece {
                    chain_of[*h as usize] = Some((id, true));
                    if let Some(twin) = half_edges.twin(*h) {
                        chain_of[twin as usize] = Some((id, false));
                    }
                }
                (id, true)
            }));
        }
        topology.loops.push(ChainLoop { patch: patch(turned[0]), uses });
    }
    topology
}

/// Border half-edges in runs, each patch's interior on the left.
fn border_loops(half_edges: &HalfEdges, is_border: &impl Fn(u32) -> bool) -> Vec<Vec<u32>> {
    let n = half_edges.len();
    let mut seen = vec![false; n];
    let mut loops = Vec::new();
    for start in 0..n as u32 {
        if seen[start as usize] || !is_border(start) {
            continue;
        }
        let (mut run, mut h) = (Vec::new(), start);
        while !seen[h as usize] {
            seen[h as usize] = true;
            run.push(h);
            let mut next = HalfEdges::next(h);
            while !is_border(next) {
                next = HalfEdges::next(half_edges.twin(next).expect("an edge inside a patch has a twin"));
            }
            h = next;
        }
        loops.push(run);
    }
    loops
}

/// Marks junctions, and pseudo-junctions on loops with fewer than two.
fn junctions(
    mesh: &Mesh,
    half_edges: &HalfEdges,
    loops: &[Vec<u32>],
    is_border: &impl Fn(u32) -> bool,
    cornered: &[bool],
) -> Vec<bool> {
    let mut degree = vec![0_u32; mesh.vertices.len()];
    for run in loops {
        for h in run {
            // Each undirected border edge once: with a twin, from its lower half-edge.
            if half_edges.twin(*h).is_none_or(|g| *h < g || !is_border(g)) {
                degree[half_edges.from(*h) as usize] += 1;
                degree[half_edges.to(*h) as usize] += 1;
            }
        }
    }
    let mut junction: Vec<bool> =
        degree.iter().zip(cornered).map(|(d, forced)| *d > 2 || (*forced && *d > 0)).collect();
    for run in loops {
        let n_needed = 2 - run.iter().filter(|h| junction[half_edges.from(**h) as usize]).count().min(2);
        let first = run.iter().position(|h| junction[half_edges.from(*h) as usize]).unwrap_or(0);
        let at = |i: usize| half_edges.from(run[(first + i) % run.len()]) as usize;
        if n_needed == 2 {
            junction[at(0)] = true;
        }
        if n_needed >= 1 {
            junction[at(run.len() / 2)] = true;
        }
    }
    junction
}
