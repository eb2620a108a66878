//! All geometry of one labelling, and what can be told from it.

use std::collections::BTreeMap;

use super::assemble::{ChainEdge, chain_edges};
use super::attempt::Choice;
use super::chains::{ChainLoop, Topology, trace};
use super::domain::nearest_on_spline;
use super::freeform::{self, Fitted};
use super::geometry::{Corners, Course, corners, courses};
use super::halfedge::HalfEdges;
use super::settle::Round;
use super::split::{Patch, patches};
use super::{Issue, IssueCode, LabelledMesh};
use crate::math::Point3;
use crate::mesh::{Mesh, VertId};
use crate::segment::RegionId;
use crate::surface::Surface;
use crate::tolerance::Tolerances;

/// Whether every sample of an edge is within `gap` of another edge.
fn run_together(edge: &ChainEdge, other: &ChainEdge, gap: f64) -> bool {
    let beside = |p: &Point3| {
        other.samples.windows(2).any(|pair| {
            let along = pair[1] - pair[0];
            let share = (p - pair[0]).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
            (pair[0] + along * share.clamp(0.0, 1.0) - p).norm() <= gap
        })
    };
    edge.samples.iter().all(beside)
}

/// For every cone whose face holds its apex the vertex of the cut across the face that becomes the tip: there the cut
/// turns from one ruling to another.
fn tips(
    mesh: &Mesh,
    half_edges: &HalfEdges,
    patches: &[Patch],
    patch_of: &[u32],
    spacing: f64,
) -> Vec<(VertId, usize)> {
    /// In spacings: how far a scan may round off the tip.
    const ROUNDED: f64 = 3.0;
    let patch = |h: u32| patch_of[HalfEdges::triangle(h)] as usize;
    let mut nearest: BTreeMap<[usize; 2], (f64, VertId)> = BTreeMap::new();
    for h in 0..half_edges.len() as u32 {
        let (left, Some(right)) = (patch(h), half_edges.twin(h).map(patch)) else { continue };
        let Some(Surface::Cone(cone)) = patches[left].surface.filter(|_| left < right) else { continue };
        let inside = |v: VertId| {
            let around = half_edges.leaving(v);
            around.iter().all(|h| half_edges.twin(*h).is_some() && [left, right].contains(&patch(*h)))
        };
        let v = half_edges.from(h);
        if patches[left].region != patches[right].region || !inside(v) {
            continue;
        }
        let off = (mesh.vertices[v as usize] - cone.apex()).norm();
        let best = nearest.entry([left, right]).or_insert((off, v));
        if off < best.0 {
            *best = (off, v);
        }
    }
    let found = nearest.into_iter().filter(|(_, (off, _))| *off <= ROUNDED * spacing);
    found.map(|([left, _], (_, v))| (v, left)).collect()
}

/// All geometry of one labelling.
pub(super) struct Draft {
    pub patches: Vec<Patch>,
    pub patch_of: Vec<u32>,
    pub topology: Topology,
    pub courses: Vec<Course>,
    pub corners: Corners,
    pub edges: Vec<Option<ChainEdge>>,
    /// Mesh vertices that become the tips of cones, and a patch of each cone.
    tips: Vec<(VertId, usize)>,
    /// Junctions that are one corner.
    shared: Vec<[VertId; 2]>,
}

impl Draft {
    pub(super) fn new(
        closed: &LabelledMesh,
        half_edges: &HalfEdges,
        surfaces: &[Option<Surface>],
        choice: &Choice,
        facets: u32,
        tolerances: &Tolerances,
    ) -> Self {
        let (mesh, spacing) = (&closed.mesh, tolerances.spacing());
        let (mut patches, patch_of) = patches(closed, half_edges, &choice.labels, surfaces, facets, spacing);
        for patch in patches.iter_mut().filter(|p| choice.demoted[p.region as usize]) {
            patch.surface = None;
        }
        let mut cornered = vec![false; mesh.vertices.len()];
        for t in patches.iter().filter(|p| p.facet).flat_map(|p| &p.triangles) {
            mesh.triangles[*t as usize].iter().for_each(|v| cornered[*v as usize] = true);
        }
        let tips = tips(mesh, half_edges, &patches, &patch_of, spacing);
        for (v, _) in &tips {
            cornered[*v as usize] = true;
        }
        let topology = trace(mesh, half_edges, &patch_of, &cornered);
        let mut is_end = vec![false; mesh.vertices.len()];
        for chain in &topology.chains {
            is_end[chain.start() as usize] = true;
            is_end[chain.end() as usize] = true;
        }
        let both_end = |pair: &&[VertId; 2]| pair.iter().all(|v| is_end[*v as usize]);
        let ends_of_chains = choice.shared.iter().filter(both_end).copied().collect();
        let mut draft = Self {
            patches,
            patch_of,
            topology,
            courses: Vec::new(),
            corners: Corners { corner_of: Vec::new(), corners: Vec::new() },
            edges: Vec::new(),
            tips,
            shared: ends_of_chains,
        };
        draft.solve(mesh, tolerances);
        draft
    }

    /// Corners and edges for the patches' surfaces.
    pub(super) fn solve(&mut self, mesh: &Mesh, tolerances: &Tolerances) {
        let spacing = tolerances.spacing();
        self.courses = courses(mesh, &self.topology, &self.patches, spacing);
        let apex = |(v, p): &(VertId, usize)| match self.patches[*p].surface {
            Some(Surface::Cone(cone)) => Some((*v, cone.apex())),
            _ => None,
        };
        let tips: Vec<(VertId, Point3)> = self.tips.iter().filter_map(apex).collect();
        self.corners = corners(mesh, &self.topology, &self.courses, &tips, &self.shared, spacing);
        self.edges =
            chain_edges(&self.topology, &self.courses, &self.corners, spacing, tolerances.rounding());
    }

    /// Sum of what edges and corners are off by beyond a tolerance.
    pub(super) fn excess(&self, tolerance: f64) -> f64 {
        let edges = self.edges.iter().flatten().map(|e| (e.gap - tolerance).max(0.0));
        edges.chain(self.corners.corners.iter().map(|c| (c.residual - tolerance).max(0.0))).sum()
    }

    /// Moves surfaces so that edges and corners lie on them, as long as that makes them lie better.
    pub(super) fn settle(
        &mut self,
        mesh: &Mesh,
        original: &[Option<Surface>],
        outward: &[bool],
        tolerances: &Tolerances,
    ) {
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
                outward,
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

    pub(super) fn take_surfaces(&mut self, surfaces: &[Option<Surface>]) {
        for patch in &mut self.patches {
            patch.surface = surfaces[patch.region as usize];
        }
    }

    /// Patches with a loop of fewer than two edges, or between two edges that are one within `gap`.
    pub(super) fn collapsed(&self, gap: f64) -> Vec<usize> {
        let mut n_loops = vec![0; self.patches.len()];
        let mut n_uses = vec![0; self.patches.len()];
        let mut found: Vec<usize> = Vec::new();
        for run in &self.topology.loops {
            let p = run.patch as usize;
            let edges: Vec<&ChainEdge> =
                run.uses.iter().filter_map(|(c, _)| self.edges[*c].as_ref()).collect();
            n_loops[p] += 1;
            n_uses[p] += edges.len();
            let collapsed = match edges[..] {
                [_] => true,
                // The hole round such a face is as thin; to give away what surrounds it would be no cure.
                [a, b] => run_together(a, b, gap) && self.is_island(run),
                _ => false,
            };
            if collapsed {
                found.push(p);
            }
        }
        found.extend((0..self.patches.len()).filter(|p| n_uses[*p] == 0 && n_loops[*p] > 0));
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Whether a loop is the only one of its patch.
    fn is_island(&self, run: &ChainLoop) -> bool {
        self.topology.loops.iter().filter(|r| r.patch == run.patch).count() == 1
    }

    /// The patches with a chain that ends in a corner.
    pub(super) fn patches_at(&self, corner: u32) -> Vec<usize> {
        let at = |v: u32| self.corners.corner_of[v as usize] == Some(corner);
        let touching = self.topology.chains.iter().filter(|chain| at(chain.start()) || at(chain.end()));
        let mut patches: Vec<usize> =
            touching.flat_map(|c| [Some(c.left), c.right]).flatten().map(|p| p as usize).collect();
        patches.sort_unstable();
        patches.dedup();
        patches
    }

    /// A patch and all that are joined to it through patches of its own region, ascending.
    pub(super) fn group_of(&self, patch: usize) -> Vec<usize> {
        let region = self.patches[patch].region;
        let mut group = vec![patch];
        let mut at = 0;
        while at < group.len() {
            for chain in &self.topology.chains {
                let Some(right) = chain.right else { continue };
                let pair = [chain.left as usize, right as usize];
                if !pair.contains(&group[at]) || pair.iter().any(|p| self.patches[*p].region != region) {
                    continue;
                }
                for p in pair {
                    if !group.contains(&p) {
                        group.push(p);
                    }
                }
            }
            at += 1;
        }
        group.sort_unstable();
        group
    }

    /// Gives a patch's triangles to the region with the longest common border; whether there was one.
    pub(super) fn give_away(&self, p: usize, half_edges: &HalfEdges, labels: &mut [u32]) -> bool {
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
        let Some(&(region, _)) = counts.iter().max_by_key(|c| (c.1, std::cmp::Reverse(c.0))) else {
            return false;
        };
        for &t in &self.patches[p].triangles {
            labels[t as usize] = region;
        }
        true
    }

    /// Splines of the patches without an analytic surface.
    pub(super) fn splines(&self, mesh: &Mesh, tolerances: &Tolerances) -> Vec<Option<Fitted>> {
        let mut borders: Vec<Vec<Point3>> = vec![Vec::new(); self.patches.len()];
        for (i, (chain, edge)) in self.topology.chains.iter().zip(&self.edges).enumerate() {
            // A border with facets is a zig-zag that no spline follows: there the corners come to the spline.
            let Some(edge) = edge.as_ref().filter(|_| !self.courses[i].straight) else { continue };
            for p in [Some(chain.left), chain.right].into_iter().flatten() {
                if self.patches[p as usize].surface.is_none() {
                    borders[p as usize].extend(edge.curve.sample(
                        &edge.samples[0],
                        &edge.samples[edge.samples.len() - 1],
                        2 * edge.samples.len(),
                    ));
                }
            }
        }
        crate::par::map_indices(self.patches.len(), |p| {
            let patch = &self.patches[p];
            if patch.surface.is_some() || patch.facet {
                return None;
            }
            freeform::fit(mesh, patch, &borders[p], tolerances.spacing(), tolerances.gap())
        })
    }

    /// Moves the corners that only facets and one spline share onto the spline, and the edges of facets with them.
    pub(super) fn meet_splines(&mut self, splines: &[Option<Fitted>], spacing: f64, rounding: f64) {
        let mut beside: Vec<Vec<u32>> = vec![Vec::new(); self.corners.corners.len()];
        let mut held = vec![false; beside.len()];
        let corner = |v: u32| self.corners.corner_of[v as usize].expect("chains end at junctions") as usize;
        for (chain, course) in self.topology.chains.iter().zip(&self.courses) {
            for c in [chain.start(), chain.end()].map(corner) {
                let sides = [Some(chain.left), chain.right].into_iter().flatten();
                beside[c].extend(sides.filter(|p| !self.patches[*p as usize].facet));
                // The end of an edge that is not a facet's lies where that one lies.
                held[c] |= !course.straight;
            }
        }
        for (c, patches) in beside.iter().enumerate().filter(|(c, _)| !held[*c]) {
            let Some(&p) = patches.first().filter(|p| patches.iter().all(|q| q == *p)) else { continue };
            if let Some(fitted) = &splines[p as usize] {
                let point = &mut self.corners.corners[c].point;
                *point = nearest_on_spline(&fitted.surface, point);
            }
        }
        self.edges = chain_edges(&self.topology, &self.courses, &self.corners, spacing, rounding);
    }

    /// What is wrong with corners, edges and the shell; of the edges between two regions, and of the corners of the
    /// same regions, the worst only.
    pub(super) fn report(&self, issues: &mut Vec<Issue>, tolerances: &Tolerances) {
        self.report_corners(issues, tolerances);
        self.report_edges(issues, tolerances);
        if self.topology.chains.iter().any(|c| c.right.is_none()) {
            issues.push(Issue::new(
                IssueCode::OpenShell,
                None,
                "the mesh has holes: the shell is open".into(),
            ));
        }
    }

    fn report_corners(&self, issues: &mut Vec<Issue>, tolerances: &Tolerances) {
        /// In spacings: a corner farther from its surfaces than this is wrong topology or a weak surface.
        const CORNER_RESIDUAL: f64 = 0.3;
        let spacing = tolerances.spacing();
        let mut worst: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
        for (c, corner) in self.corners.corners.iter().enumerate() {
            if corner.residual <= CORNER_RESIDUAL * spacing {
                continue;
            }
            let at = |v: u32| self.corners.corner_of[v as usize] == Some(c as u32);
            let touching = self.topology.chains.iter().filter(|chain| at(chain.start()) || at(chain.end()));
            let mut regions: Vec<u32> = touching
                .flat_map(|chain| [Some(chain.left), chain.right])
                .flatten()
                .map(|p| self.patches[p as usize].origin.0)
                .collect();
            regions.sort_unstable();
            regions.dedup();
            let at = worst.entry(regions).or_insert(c);
            if corner.residual > self.corners.corners[*at].residual {
                *at = c;
            }
        }
        for (regions, c) in worst {
            let corner = &self.corners.corners[c];
            let (off, moved) = (corner.residual / spacing, corner.moved / spacing);
            let text = format!(
                "the corner of regions {regions:?} at {:.3?} lies off their surfaces by {off:.2} spacings (moved {moved:.1})",
                corner.point.coords.as_slice()
            );
            issues.push(Issue::new(IssueCode::CornerOff, regions.first().map(|r| RegionId(*r)), text));
        }
    }

    fn report_edges(&self, issues: &mut Vec<Issue>, tolerances: &Tolerances) {
        let mut worst: BTreeMap<(u32, Option<u32>), f64> = BTreeMap::new();
        for (chain, edge) in self.topology.chains.iter().zip(&self.edges) {
            let Some(edge) = edge else { continue };
            if edge.gap > tolerances.gap() {
                let left = self.patches[chain.left as usize].origin.0;
                let right = chain.right.map(|p| self.patches[p as usize].origin.0);
                let pair = right.map_or((left, None), |right| (left.min(right), Some(left.max(right))));
                let gap = worst.entry(pair).or_insert(edge.gap);
                *gap = gap.max(edge.gap);
            }
        }
        for ((region, other), gap) in worst {
            let other = other.map_or("nothing".to_owned(), |region| format!("primitive {region}"));
            let text = format!(
                "its edge with {other} lies off its surfaces by {gap:.3e}, more than {:.3e}",
                tolerances.gap()
            );
            issues.push(Issue::new(IssueCode::GapLarge, Some(RegionId(region)), text));
        }
    }
}
