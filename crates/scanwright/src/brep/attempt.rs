//! One labelling carried through to solids, and what is wrong with them.

use super::assemble::{Made, Parts, solids};
use super::check::{Problem, check};
use super::draft::Draft;
use super::freeform::Fitted;
use super::halfedge::HalfEdges;
use super::solid::Solid;
use super::{LabelledMesh, labels};
use crate::math::{Point3, Vec3};
use crate::mesh::{Mesh, VertId};
use crate::surface::Surface;
use crate::tolerance::Tolerances;

/// What all attempts at one scan have in common.
pub(super) struct Bench<'a> {
    pub closed: &'a LabelledMesh,
    pub half_edges: HalfEdges,
    /// Component of the mesh that each triangle belongs to, and their number.
    pub components: (Vec<u32>, usize),
    /// One per component: whether it is no part but something that closing cut off.
    pub scrap: Vec<bool>,
    /// One per region: as they were fitted; last the label of facets, which has none.
    pub surfaces: Vec<Option<Surface>>,
    /// One per region: whether the natural normal of its surface points out of the material.
    pub outward: Vec<bool>,
    /// The label of triangles that become flat faces by themselves.
    pub facets: u32,
    pub tolerances: &'a Tolerances,
    /// Largest gap that receiving programs accept.
    pub limit: f64,
}

/// What can be chosen for one attempt.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Choice {
    /// One per triangle.
    pub labels: Vec<u32>,
    /// One per label: whether a B-spline takes the place of its surface.
    pub demoted: Vec<bool>,
    /// Pairs of mesh vertices that become one corner where edges end at both.
    pub shared: Vec<[VertId; 2]>,
}

/// Something wrong with an attempt, and where.
#[derive(Debug, Clone)]
pub(super) struct Flaw {
    /// Patches at fault or beside it.
    pub patches: Vec<usize>,
    /// Points beside it, none if it concerns all.
    pub at: Vec<Point3>,
    /// How much it is worth to be rid of it.
    pub weight: f64,
    /// Whether a receiving program would refuse the part for it.
    pub fatal: bool,
}

/// A labelling with the solids it gives.
pub(super) struct Attempt {
    pub choice: Choice,
    pub draft: Draft,
    pub splines: Vec<Option<Fitted>>,
    pub solids: Vec<Made>,
    pub flaws: Vec<Flaw>,
}

/// Diagonal of the box around the triangles that were not assumed: what is assumed may lie far out.
fn seen_diagonal(closed: &LabelledMesh) -> f64 {
    let seen = closed.mesh.triangles.iter().zip(&closed.assumed).filter(|(_, assumed)| !**assumed);
    let points = seen.flat_map(|(t, _)| t.map(|v| closed.mesh.vertices[v as usize]));
    let bounds = points.map(|p| (p, p)).reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)));
    bounds.map_or_else(|| closed.mesh.diagonal(), |(low, high)| (high - low).norm())
}

impl<'a> Bench<'a> {
    pub(super) fn new(closed: &'a LabelledMesh, tolerances: &'a Tolerances) -> Self {
        /// Share of the diagonal of what was seen of the part: readers widen their tolerances to the gap they find, and
        /// programs refuse a part from about a thousandth of its size; a fifth is kept for the difference between their
        /// measure and ours.
        const LIMIT: f64 = 8e-4;
        let half_edges = HalfEdges::new(&closed.mesh);
        let components = half_edges.components(|_| 0);
        let scrap = scrap(&closed.mesh, &components, tolerances.spacing());
        let surfaces = closed.primitives.iter().map(|p| p.surface).chain([None]).collect();
        let outward = closed.primitives.iter().map(|p| p.outward).collect();
        let facets = closed.primitives.len() as u32;
        let limit = (LIMIT * seen_diagonal(closed)).max(tolerances.gap());
        Self { closed, half_edges, components, scrap, surfaces, outward, facets, tolerances, limit }
    }

    /// Builds from a choice.
    pub(super) fn attempt(&self, mut choice: Choice) -> Attempt {
        let mesh = &self.closed.mesh;
        labels::clean(mesh, &self.half_edges, &mut choice.labels, self.tolerances.spacing());
        let mut draft = self.draft(&choice);
        for _ in 0..MAX_COLLAPSES {
            let collapsed = draft.collapsed(self.tolerances.gap());
            let given =
                collapsed.into_iter().filter(|p| draft.give_away(*p, &self.half_edges, &mut choice.labels));
            if given.count() == 0 {
                break;
            }
            labels::clean(mesh, &self.half_edges, &mut choice.labels, self.tolerances.spacing());
            draft = self.draft(&choice);
        }
        draft.settle(mesh, &self.surfaces_of(&choice), &self.outward, self.tolerances);
        let splines = draft.splines(mesh, self.tolerances);
        if choice.labels.contains(&self.facets) && splines.iter().any(Option::is_some) {
            draft.meet_splines(&splines, self.tolerances.spacing(), self.tolerances.rounding());
        }
        let solids = self.solids(&draft, &splines);
        let flaws = self.flaws(&draft, &splines, &solids);
        Attempt { choice, draft, splines, solids, flaws }
    }

    fn draft(&self, choice: &Choice) -> Draft {
        Draft::new(self.closed, &self.half_edges, &self.surfaces, choice, self.facets, self.tolerances)
    }

    fn surfaces_of(&self, choice: &Choice) -> Vec<Option<Surface>> {
        self.surfaces.iter().zip(&choice.demoted).map(|(s, demoted)| s.filter(|_| !demoted)).collect()
    }

    fn solids(&self, draft: &Draft, splines: &[Option<Fitted>]) -> Vec<Made> {
        let mut solids = solids(&Parts {
            mesh: &self.closed.mesh,
            patches: &draft.patches,
            topology: &draft.topology,
            corners: &draft.corners,
            edges: &draft.edges,
            splines,
            assumed: &self.closed.assumed,
            components: (&self.components.0, self.components.1),
        });
        let of = |made: &Made| self.components.0[draft.patches[made.patches[0]].triangles[0] as usize];
        solids.retain(|made| !self.scrap[of(made) as usize]);
        solids
    }

    fn flaws(&self, draft: &Draft, splines: &[Option<Fitted>], solids: &[Made]) -> Vec<Flaw> {
        let mut flaws = Vec::new();
        for made in solids {
            flaws.extend(check(&made.solid, self.limit).iter().map(|problem| Flaw {
                patches: made.patches_of(problem),
                at: made.points_of(problem),
                weight: self.weight(problem),
                fatal: true,
            }));
        }
        /// Share of the limit that splines may use: readers compare curves with them by parameter, not by distance.
        const BY_PARAMETER: f64 = 0.5;
        let spacing = self.tolerances.spacing();
        for (p, fitted) in splines.iter().enumerate().filter_map(|(p, s)| Some((p, s.as_ref()?))) {
            let gap = fitted.border_gap;
            if gap > BY_PARAMETER * self.limit {
                let weight = (gap - BY_PARAMETER * self.limit) / spacing;
                let at = fitted.worst.into_iter().collect();
                flaws.push(Flaw { patches: vec![p], at, weight, fatal: gap > self.limit });
            }
        }
        for (c, corner) in draft.corners.corners.iter().enumerate() {
            if corner.residual > self.limit {
                flaws.push(Flaw {
                    patches: draft.patches_at(c as u32),
                    at: vec![corner.point],
                    weight: (corner.residual - self.limit) / spacing,
                    // What it does to edges is a flaw of theirs.
                    fatal: false,
                });
            }
        }
        flaws
    }

    fn weight(&self, problem: &Problem) -> f64 {
        let excess = |distance: f64| {
            let share = (distance - self.limit) / self.tolerances.spacing();
            // A number that is none is as bad as a face that crosses itself.
            if share.is_finite() { share } else { 1.0 }
        };
        match problem {
            Problem::CurveOffSurface { distance, .. } | Problem::VertexOffCurve { distance, .. } => {
                excess(*distance)
            }
            Problem::LoopsCross { crossings, .. } => 1.0 + 0.1 * (*crossings).min(20) as f64,
            _ => 1.0,
        }
    }
}

/// Marks components that enclose next to nothing, or are inside out; never the largest.
fn scrap(mesh: &Mesh, (component, n): &(Vec<u32>, usize), spacing: f64) -> Vec<bool> {
    /// In cubed spacings: a body that shows a few triangles on each side.
    const LEAST: f64 = 216.0;
    // About a point of the mesh, so that open components far from the origin do not seem large.
    let origin = mesh.vertices.first().map_or_else(Vec3::zeros, |v| v.coords);
    let mut volumes = vec![0.0; *n];
    for (t, c) in component.iter().enumerate() {
        let [a, b, c3] = mesh.corners(t).map(|p| p.coords - origin);
        volumes[*c as usize] += a.cross(&b).dot(&c3) / 6.0;
    }
    let largest = volumes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    volumes.iter().map(|v| *v < LEAST * spacing.powi(3) && *v < largest).collect()
}

/// Faces that collapse take their neighbours' corners with them; mending ends after a few rounds.
const MAX_COLLAPSES: usize = 6;

impl Attempt {
    /// Sum of all that is wrong: zero for solids that every check accepts.
    pub(super) fn severity(&self) -> f64 {
        self.flaws.iter().map(|f| f.weight).sum()
    }

    /// Whether a receiving program would refuse it.
    pub(super) fn is_fatal(&self) -> bool {
        self.flaws.iter().any(|f| f.fatal)
    }

    /// Triangles of the faces that a receiving program would refuse the part for.
    pub(super) fn at_fault(&self) -> impl Iterator<Item = u32> {
        let patches = self.flaws.iter().filter(|f| f.fatal).flat_map(|f| &f.patches);
        patches.flat_map(|p| self.draft.patches[*p].triangles.iter().copied())
    }

    /// Regions at fault or beside a flaw, ascending.
    pub(super) fn flawed_regions(&self) -> Vec<u32> {
        let mut regions: Vec<u32> =
            self.flaws.iter().flat_map(|f| &f.patches).map(|p| self.draft.patches[*p].region).collect();
        regions.sort_unstable();
        regions.dedup();
        regions
    }
}

impl Made {
    /// The ends of the edges that a problem names, or of those of its face.
    fn points_of(&self, problem: &Problem) -> Vec<Point3> {
        let solid: &Solid = &self.solid;
        let ends = |edge| [solid.edge(edge).start, solid.edge(edge).end].map(|v| solid.point(v));
        match problem {
            Problem::CurveOffSurface { edge, .. }
            | Problem::VertexOffCurve { edge, .. }
            | Problem::EdgeUse { edge, .. } => ends(*edge).to_vec(),
            Problem::LoopsCross { edges, places, .. } => {
                edges.iter().flat_map(|e| ends(*e)).chain(places.iter().copied()).collect()
            }
            Problem::LoopOpen { face, index }
            | Problem::LoopWinds { face, index }
            | Problem::LoopDirection { face, index, .. } => {
                solid.face(*face).loops[*index].uses.iter().flat_map(|u| ends(u.edge)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Patches of the faces that a problem names, or of those at the edge it names.
    fn patches_of(&self, problem: &Problem) -> Vec<usize> {
        let solid: &Solid = &self.solid;
        let at_edge = |edge| {
            let uses = |f: &super::Face| f.loops.iter().flat_map(|l| &l.uses).any(|u| u.edge == edge);
            (0..solid.faces.len())
                .filter(|f| uses(&solid.faces[*f]))
                .map(|f| self.patches[f])
                .collect::<Vec<_>>()
        };
        match problem {
            Problem::CurveOffSurface { edge, .. }
            | Problem::VertexOffCurve { edge, .. }
            | Problem::EdgeUse { edge, .. } => at_edge(*edge),
            Problem::LoopsCross { face, edges, .. } => {
                let mut patches = vec![self.patches[face.0 as usize]];
                patches.extend(edges.iter().flat_map(|e| at_edge(*e)));
                patches
            }
            _ => problem.face().map(|f| self.patches[f.0 as usize]).into_iter().collect(),
        }
    }
}
