//! From a labelled mesh to solids: the order of the steps, and what is done when one falls short.

use super::assemble::{ChainEdge, Parts, chain_edges, solids};
use super::chains::{Topology, trace};
use super::geometry::{Corners, Course, corners, courses};
use super::halfedge::HalfEdges;
use super::settle::Round;
use super::split::{Patch, patches};
use super::{Built, Issue, IssueCode, LabelledMesh, labels};
use crate::mesh::Mesh;
use crate::segment::RegionId;
use crate::surface::Surface;
use crate::tolerance::Tolerances;

/// Builds solids from a mesh whose every triangle has a region.
///
/// Topology is read off the borders between regions, geometry comes from their surfaces. What could not be built as
/// asked is listed; a mesh with holes gives an open shell.
pub fn build(closed: &LabelledMesh, tolerances: &Tolerances) -> Built {
    let mut issues = Vec::new();
    if closed.mesh.triangles.is_empty() || closed.labels.len() != closed.mesh.triangles.len() {
        issues.push(Issue::new(IssueCode::Empty, None, "the mesh has no labelled triangles".into()));
        return Built { solids: Vec::new(), issues };
    }
    let spacing = tolerances.spacing();
    let half_edges = HalfEdges::new(&closed.mesh);
    let surfaces: Vec<Option<Surface>> = closed.primitives.iter().map(|p| p.surface).collect();
    let mut work_labels: Vec<u32> = closed.labels.iter().map(|l| l.0).collect();
    labels::clean(&closed.mesh, &half_edges, &mut work_labels, spacing);
    let mut draft = Draft::new(closed, &half_edges, &work_labels, &surfaces, tolerances);
    /// Faces that collapse take their neighbours' corners with them; mending ends after a few rounds.
    const MAX_ROUNDS: usize = 6;
    for _ in 0..MAX_ROUNDS {
        let collapsed = draft.collapsed();
        if collapsed.is_empty() {
            break;
        }
        for p in collapsed {
            let region = RegionId(draft.patches[p].region);
            if draft.give_away(p, &half_edges, &mut work_labels) {
                let text = "a face collapsed to nothing; its neighbour was extended over it";
                issues.push(Issue::new(IssueCode::FaceDropped, Some(region), text.into()));
            }
        }
        labels::clean(&closed.mesh, &half_edges, &mut work_labels, spacing);
        draft = Draft::new(closed, &half_edges, &work_labels, &surfaces, tolerances);
    }
    draft.settle(&closed.mesh, &surfaces, tolerances);
    let splines = vec![None; draft.patches.len()];
    let (component, n) = half_edges.components(|_| 0);
    let made = solids(&Parts {
        mesh: &closed.mesh,
        patches: &draft.patches,
        topology: &draft.topology,
        corners: &draft.corners,
        edges: &draft.edges,
        splines: &splines,
        assumed: &closed.assumed,
        components: (&component, n),
    });
    draft.report(&mut issues, tolerances);
    Built { solids: made, issues }
}

/// All geometry of one labelling.
struct Draft {
    patches: Vec<Patch>,
    patch_of: Vec<u32>,
    topology: Topology,
    courses: Vec<Course>,
    corners: Corners,
    edges: Vec<Option<ChainEdge>>,
}

impl Draft {
    fn new(
        closed: &LabelledMesh,
        half_edges: &HalfEdges,
        labels: &[u32],
        surfaces: &[Option<Surface>],
        tolerances: &Tolerances,
    ) -> Self {
        let (mesh, spacing) = (&closed.mesh, tolerances.spacing());
        let (patches, patch_of) = patches(mesh, half_edges, labels, surfaces, spacing);
        let topology = trace(mesh, half_edges, &patch_of);
        let mut draft = Self {
            patches,
            patch_of,
            topology,
            courses: Vec::new(),
            corners: Corners { corner_of: Vec::new(), corners: Vec::new() },
            edges: Vec::new(),
        };
        draft.solve(mesh, tolerances);
        draft
    }

    /// Corners and edges for the patches' surfaces.
    fn solve(&mut self, mesh: &Mesh, tolerances: &Tolerances) {
        let spacing = tolerances.spacing();
        self.courses = courses(mesh, &self.topology, &self.patches, spacing);
        self.corners = corners(mesh, &self.topology, &self.courses, spacing);
        self.edges = chain_edges(&self.topology, &self.courses, &self.corners, spacing, tolerances.rounding());
    }

    /// Sum of what edges and corners are off by beyond a tolerance.
    fn excess(&self, tolerance: f64) -> f64 {
        let edges = self.edges.iter().flatten().map(|e| (e.gap - tolerance).max(0.0));
        edges.chain(self.corners.corners.iter().map(|c| (c.residual - tolerance).max(0.0))).sum()
    }

    /// Moves surfaces so that edges and corners lie on them, as long as that makes them lie better.
    fn settle(&mut self, mesh: &Mesh, original: &[Option<Surface>], tolerances: &Tolerances) {
        /// Each round halves the gaps; after eight a gap of a quarter spacing is a thousandth.
        const MAX_ROUNDS: usize = 8;
        /// Share of the allowed gap that is aimed at.
        const AIM: f64 = 0.3;
        let aim = AIM * tolerances.gap();
        for _ in 0..MAX_ROUNDS {
            let before = self.excess(aim);
            if before <= 0.0 {
                return;
            }
            let mut current = vec![None; original.len()];
            for patch in &self.patches {
                current[patch.region as usize] = patch.surface;
            }
            let round = Round {
                mesh,
                patches: &self.patches,
                topology: &self.topology,
                corners: &self.corners,
                edges: &self.edges,
            };
            let next = round.settled(original, &current, aim, tolerances.spacing());
            let kept = (self.courses.clone(), self.corners.clone(), self.edges.clone());
            self.take_surfaces(&next);
            self.solve(mesh, tolerances);
            if self.excess(aim) >= before {
                self.take_surfaces(&current);
                (self.courses, self.corners, self.edges) = kept;
                return;
            }
        }
    }

    fn take_surfaces(&mut self, surfaces: &[Option<Surface>]) {
        for patch in &mut self.patches {
            patch.surface = surfaces[patch.region as usize];
        }
    }

    /// Patches with a loop of fewer than two edges.
    fn collapsed(&self) -> Vec<usize> {
        let mut found: Vec<usize> = self
            .topology
            .loops
            .iter()
            .filter(|run| run.uses.iter().filter(|(c, _)| self.edges[*c].is_some()).count() == 1)
            .map(|run| run.patch as usize)
            .collect();
        let mut n_uses = vec![0; self.patches.len()];
        for run in &self.topology.loops {
            n_uses[run.patch as usize] += run.uses.iter().filter(|(c, _)| self.edges[*c].is_some()).count();
        }
        let has_loops = |p: usize| self.topology.loops.iter().any(|r| r.patch as usize == p);
        found.extend((0..self.patches.len()).filter(|p| n_uses[*p] == 0 && has_loops(*p)));
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Gives a patch's triangles to the region with the longest common border; whether there was one.
    fn give_away(&self, p: usize, half_edges: &HalfEdges, labels: &mut [u32]) -> bool {
        let mut counts: Vec<(u32, usize)> = Vec::new();
        for &t in &self.patches[p].triangles {
            for u in half_edges.neighbours(t as usize).into_iter().flatten() {
                let region = labels[u];
                if self.patch_of[u] as usize == p || region == self.patches[p].region {
                    continue;
                }
                match counts.iter_mut().find(|c| c.0 == region) {
                    Some(count) => count.1 += 1,
                    None => counts.push((region, 1)),
                }
            }
        }
        let Some(&(region, _)) = counts.iter().max_by_key(|c| (c.1, std::cmp::Reverse(c.0))) else { return false };
        for &t in &self.patches[p].triangles {
            labels[t as usize] = region;
        }
        true
    }

    fn report(&self, issues: &mut Vec<Issue>, tolerances: &Tolerances) {
        /// In spacings: a corner farther from its surfaces than this is wrong topology or a weak surface.
        const CORNER_RESIDUAL: f64 = 0.3;
        let spacing = tolerances.spacing();
        let bad = self.corners.corners.iter().filter(|c| c.residual > CORNER_RESIDUAL * spacing).count();
        if bad > 0 {
            let text = format!("{bad} corners lie off their surfaces by more than {CORNER_RESIDUAL} spacings");
            issues.push(Issue::new(IssueCode::CornerOff, None, text));
        }
        for (chain, edge) in self.topology.chains.iter().zip(&self.edges) {
            let Some(edge) = edge else { continue };
            if edge.gap > tolerances.gap() {
                let region = RegionId(self.patches[chain.left as usize].region);
                let text = format!("an edge lies off its surfaces by {:.3e}, more than {:.3e}", edge.gap, tolerances.gap());
                issues.push(Issue::new(IssueCode::GapLarge, Some(region), text));
            }
        }
        if self.topology.chains.iter().any(|c| c.right.is_none()) {
            issues.push(Issue::new(IssueCode::OpenShell, None, "the mesh has holes: the shell is open".into()));
        }
    }
}
