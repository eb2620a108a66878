//! What is done when the labels do not give a solid as they are: faces that vanish, edges that do not exist, surfaces
//! that do not pass through their edges. Every mend is kept only if the solid's corners and edges lie better after it.

use super::draft::Draft;
use super::halfedge::HalfEdges;
use super::{Issue, IssueCode, LabelledMesh, labels};
use crate::segment::RegionId;
use crate::surface::Surface;
use crate::tolerance::Tolerances;

/// Residual, in spacings, from which a corner is taken to be wrong.
const WRONG_CORNER: f64 = 0.3;

/// A labelling at work, with the geometry it gives.
pub(super) struct Bench<'a> {
    pub closed: &'a LabelledMesh,
    pub half_edges: HalfEdges,
    pub labels: Vec<u32>,
    pub surfaces: Vec<Option<Surface>>,
    pub tolerances: &'a Tolerances,
    pub draft: Draft,
}

impl<'a> Bench<'a> {
    pub(super) fn new(
        closed: &'a LabelledMesh,
        half_edges: HalfEdges,
        labels: Vec<u32>,
        surfaces: Vec<Option<Surface>>,
        tolerances: &'a Tolerances,
    ) -> Self {
        let draft = Draft::new(closed, &half_edges, &labels, &surfaces, tolerances);
        Self { closed, half_edges, labels, surfaces, tolerances, draft }
    }

    fn redraft(&mut self) {
        let spacing = self.tolerances.spacing();
        labels::clean(&self.closed.mesh, &self.half_edges, &mut self.labels, spacing);
        self.draft = Draft::new(self.closed, &self.half_edges, &self.labels, &self.surfaces, self.tolerances);
    }

    /// Takes new labels if the solid lies better with them.
    fn try_labels(&mut self, labels: Vec<u32>) -> bool {
        let before = self.excess();
        let kept = std::mem::replace(&mut self.labels, labels);
        let mut spacing_labels = self.labels.clone();
        labels::clean(&self.closed.mesh, &self.half_edges, &mut spacing_labels, self.tolerances.spacing());
        let draft =
            Draft::new(self.closed, &self.half_edges, &spacing_labels, &self.surfaces, self.tolerances);
        if draft.collapsed().is_empty() && draft.excess(self.tolerances.gap()) < before {
            (self.labels, self.draft) = (spacing_labels, draft);
            return true;
        }
        self.labels = kept;
        false
    }

    fn excess(&self) -> f64 {
        self.draft.excess(self.tolerances.gap())
    }
}

/// Gives faces that collapsed to fewer than two edges to their neighbours.
pub(super) fn drop_collapsed(bench: &mut Bench, issues: &mut Vec<Issue>) {
    /// Faces that collapse take their neighbours' corners with them; mending ends after a few rounds.
    const MAX_ROUNDS: usize = 6;
    for _ in 0..MAX_ROUNDS {
        let collapsed = bench.draft.collapsed();
        if collapsed.is_empty() {
            return;
        }
        for p in collapsed {
            let region = RegionId(bench.draft.patches[p].region);
            if bench.draft.give_away(p, &bench.half_edges, &mut bench.labels) {
                let text = "a face collapsed to nothing; its neighbour was extended over it";
                issues.push(Issue::new(IssueCode::FaceDropped, Some(region), text.into()));
            }
        }
        bench.redraft();
    }
}

/// Takes away edges of A|B that are not there: those between two wrong corners where one face C passes between.
pub(super) fn dissolve(bench: &mut Bench) {
    /// Single trials; each costs as much as the whole geometry.
    const MAX_TRIALS: usize = 8;
    let bands = false_edges(bench);
    if bands.is_empty() {
        return;
    }
    let mut all = bench.labels.clone();
    for (triangles, region) in &bands {
        for &t in triangles {
            all[t] = *region;
        }
    }
    if bench.try_labels(all) || bands.len() == 1 {
        return;
    }
    for (triangles, region) in bands.iter().take(MAX_TRIALS) {
        let mut labels = bench.labels.clone();
        for &t in triangles {
            labels[t] = *region;
        }
        bench.try_labels(labels);
    }
}

/// For each edge that may not exist: the band of triangles round it, and the region that would take them.
fn false_edges(bench: &Bench) -> Vec<(Vec<usize>, u32)> {
    /// Longest chain, in mesh edges, that may be turned between two faces that do not both touch its ends.
    const MAX_FLIP: usize = 10;
    /// Rings of triangles on each side of the edge that are given away.
    const RINGS: usize = 2;
    let draft = &bench.draft;
    let wrong = WRONG_CORNER * bench.tolerances.spacing();
    let region = |p: u32| draft.patches[p as usize].region;
    let mut regions_at: Vec<Vec<u32>> = vec![Vec::new(); draft.corners.corners.len()];
    for chain in &draft.topology.chains {
        for v in [chain.start(), chain.end()] {
            let Some(c) = draft.corners.corner_of[v as usize] else { continue };
            regions_at[c as usize].extend([Some(chain.left), chain.right].into_iter().flatten().map(region));
        }
    }
    let mut bands = Vec::new();
    for chain in &draft.topology.chains {
        let Some(right) = chain.right else { continue };
        let (a, b) = (region(chain.left), region(right));
        let ends = [chain.start(), chain.end()].map(|v| draft.corners.corner_of[v as usize]);
        let [Some(start), Some(end)] = ends else { continue };
        let residual = |c: u32| draft.corners.corners[c as usize].residual;
        if residual(start).max(residual(end)) <= wrong {
            continue;
        }
        let third = |c: u32| regions_at[c as usize].iter().copied().find(|r| *r != a && *r != b);
        let shared = regions_at[start as usize]
            .iter()
            .copied()
            .find(|r| *r != a && *r != b && regions_at[end as usize].contains(r));
        let taker = if start == end || shared.is_none() {
            (chain.vertices.len() <= MAX_FLIP).then(|| third(start).or(third(end))).flatten()
        } else {
            shared
        };
        let Some(taker) = taker else { continue };
        bands.push((band(bench, &chain.vertices, [a, b], RINGS), taker));
    }
    bands
}

/// Triangles of two regions within some rings of a run of vertices.
fn band(bench: &Bench, vertices: &[u32], regions: [u32; 2], rings: usize) -> Vec<usize> {
    let mut front: Vec<u32> = vertices.to_vec();
    let mut triangles: Vec<usize> = Vec::new();
    for _ in 0..rings {
        let around = front.iter().flat_map(|v| bench.half_edges.leaving(*v)).map(|h| HalfEdges::triangle(*h));
        triangles.extend(around.filter(|t| regions.contains(&bench.labels[*t])));
        triangles.sort_unstable();
        triangles.dedup();
        front = triangles.iter().flat_map(|t| bench.closed.mesh.triangles[*t]).collect();
        front.sort_unstable();
        front.dedup();
    }
    triangles
}

/// Turns the surfaces that keep edges or corners from closing into B-splines, weakest first.
pub(super) fn demote(bench: &mut Bench, issues: &mut Vec<Issue>) {
    /// In spacings: a gap that a reader may not accept, a quarter of a thousandth of a usual diagonal and up.
    const INTOLERABLE: f64 = 0.1;
    /// Faces that may be demoted, one per round.
    const MAX_ROUNDS: usize = 10;
    let limit = (INTOLERABLE * bench.tolerances.spacing()).max(bench.tolerances.gap());
    for _ in 0..MAX_ROUNDS {
        let Some(region) = weakest(&bench.draft, limit) else { return };
        let before = bench.draft.excess(limit);
        let kept: Vec<Option<Surface>> = bench.draft.patches.iter().map(|p| p.surface).collect();
        for patch in bench.draft.patches.iter_mut().filter(|p| p.region == region) {
            patch.surface = None;
        }
        bench.draft.solve(&bench.closed.mesh, bench.tolerances);
        let splines = bench.draft.splines(&bench.closed.mesh, bench.tolerances);
        let border = splines.iter().flatten().map(|s| (s.border_gap - limit).max(0.0)).sum::<f64>();
        if bench.draft.excess(limit) + border >= before {
            for (patch, surface) in bench.draft.patches.iter_mut().zip(kept) {
                patch.surface = surface;
            }
            bench.draft.solve(&bench.closed.mesh, bench.tolerances);
            return;
        }
        let text = "its surface does not pass through its edges; a B-spline takes its place";
        issues.push(Issue::new(IssueCode::Freeform, Some(RegionId(region)), text.into()));
    }
}

/// The region with the most excess for its size on edges and corners off by more than `limit`.
fn weakest(draft: &Draft, limit: f64) -> Option<u32> {
    let n = draft.patches.iter().map(|p| p.region as usize + 1).max()?;
    let (mut excess, mut size) = (vec![0.0; n], vec![0_usize; n]);
    for patch in &draft.patches {
        size[patch.region as usize] += patch.triangles.len();
    }
    for (chain, edge) in draft.topology.chains.iter().zip(&draft.edges) {
        let corner =
            |v: u32| draft.corners.corner_of[v as usize].map(|c| draft.corners.corners[c as usize].residual);
        let ends = [chain.start(), chain.end()].into_iter().filter_map(corner).map(|r| (r - limit).max(0.0));
        let off = ends.sum::<f64>() + edge.as_ref().map_or(0.0, |e| (e.gap - limit).max(0.0));
        for p in [Some(chain.left), chain.right].into_iter().flatten() {
            let patch = &draft.patches[p as usize];
            if patch.surface.is_some() {
                excess[patch.region as usize] += off;
            }
        }
    }
    let score = |r: usize| excess[r] / (size[r] as f64).sqrt();
    (0..n)
        .filter(|r| excess[*r] > 0.0)
        .max_by(|a, b| score(*a).total_cmp(&score(*b)).then(b.cmp(a)))
        .map(|r| r as u32)
}
