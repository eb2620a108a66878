//! From a labelled mesh to solids: the order of the steps.

use super::attempt::{Bench, Choice};
use super::mend::mended;
use super::{Built, Issue, IssueCode, LabelledMesh};
use crate::segment::RegionId;
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
    let bench = Bench::new(closed, tolerances);
    let choice = Choice {
        labels: closed.labels.iter().map(|l| l.0).collect(),
        demoted: vec![false; bench.surfaces.len()],
    };
    let made = mended(&bench, bench.attempt(choice));
    let mut kept = vec![false; bench.surfaces.len()];
    let mut n_facets = vec![0; bench.surfaces.len()];
    for (label, first) in made.choice.labels.iter().zip(&closed.labels) {
        let facet = *label == bench.facets;
        kept[if facet { first.0 } else { *label } as usize] = true;
        n_facets[first.0 as usize] += usize::from(facet);
    }
    let mut was = vec![false; kept.len()];
    closed.labels.iter().for_each(|l| was[l.0 as usize] = true);
    for region in (0..kept.len()).filter(|r| was[*r] && !kept[*r]) {
        let text = "its face is too narrow to have edges; its neighbours were extended over it";
        issues.push(Issue::new(IssueCode::FaceDropped, Some(RegionId(region as u32)), text.into()));
    }
    for (region, n) in n_facets.iter().enumerate().filter(|(_, n)| **n > 0) {
        let text = format!("{n} of its triangles are flat faces, for its surface gave no sound ones");
        issues.push(Issue::new(IssueCode::Facets, Some(RegionId(region as u32)), text));
    }
    for (patch, spline) in made.draft.patches.iter().zip(&made.splines) {
        if let Some(spline) = spline {
            let text = format!("a face is a B-spline, its border within {:.3e}", spline.border_gap);
            issues.push(Issue::new(IssueCode::Freeform, Some(patch.origin), text));
        }
    }
    made.draft.report(&mut issues, tolerances);
    Built { solids: made.solids.into_iter().map(|m| m.solid).collect(), issues }
}
