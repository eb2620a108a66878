//! From a labelled mesh to solids: the order of the steps.

use super::assemble::{Parts, solids};
use super::halfedge::HalfEdges;
use super::mend::{Bench, demote, dissolve, drop_collapsed};
use super::{Built, Issue, IssueCode, LabelledMesh, labels};
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
    let half_edges = HalfEdges::new(&closed.mesh);
    let surfaces: Vec<Option<Surface>> = closed.primitives.iter().map(|p| p.surface).collect();
    let mut labels: Vec<u32> = closed.labels.iter().map(|l| l.0).collect();
    labels::clean(&closed.mesh, &half_edges, &mut labels, tolerances.spacing());
    let mut bench = Bench::new(closed, half_edges, labels, surfaces, tolerances);
    drop_collapsed(&mut bench, &mut issues);
    dissolve(&mut bench);
    bench.draft.settle(&closed.mesh, &bench.surfaces, tolerances);
    demote(&mut bench, &mut issues);
    let draft = &bench.draft;
    let splines = draft.splines(&closed.mesh, tolerances);
    for (patch, spline) in draft.patches.iter().zip(&splines) {
        if let Some(spline) = spline {
            let text = format!("a face is a B-spline, its border within {:.3e}", spline.border_gap);
            issues.push(Issue::new(IssueCode::Freeform, Some(RegionId(patch.region)), text));
        }
    }
    let (component, n) = bench.half_edges.components(|_| 0);
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
