//! From a labelled mesh to solids: the order of the steps.

use super::attempt::{Attempt, Bench, Choice};
use super::mend::mended;
use super::plain::plainly_built;
use super::riser::risers;
use super::{Built, Issue, IssueCode, LabelledMesh};
use crate::segment::RegionId;
use crate::tolerance::Tolerances;

/// Builds solids from a mesh whose every triangle has a region.
///
/// Topology is read off the borders between regions, geometry comes from their surfaces. What could not be built as
/// asked is listed; a mesh with holes gives an open shell.
pub fn build(closed: &LabelledMesh, tolerances: &Tolerances) -> Built {
    if closed.mesh.triangles.is_empty() || closed.labels.len() != closed.mesh.triangles.len() {
        let issue = Issue::new(IssueCode::Empty, None, "the mesh has no labelled triangles".into());
        return Built { solids: Vec::new(), issues: vec![issue], primitives: closed.primitives.clone() };
    }
    let bench = Bench::new(closed, tolerances);
    let choice = Choice {
        labels: closed.labels.iter().map(|l| l.0).collect(),
        demoted: vec![false; bench.surfaces.len()],
        shared: Vec::new(),
    };
    let mut start = bench.attempt(choice);
    let (added, mends) = risers(&bench, &start);
    if mends.is_empty() {
        return plainly_built(&bench, mended(&bench, start, &[]));
    }
    let mut closed = closed.clone();
    closed.primitives.extend(added);
    let bench = Bench::new(&closed, tolerances);
    start.choice.demoted.resize(bench.surfaces.len(), false);
    plainly_built(&bench, mended(&bench, start, &mends))
}

/// An attempt as a result, with what is to be said about it.
pub(super) fn built(bench: &Bench, made: Attempt) -> Built {
    let first = &bench.closed.labels;
    let mut issues = Vec::new();
    let mut kept = vec![false; bench.surfaces.len()];
    let mut n_facets = vec![0; bench.surfaces.len()];
    for (label, first) in made.choice.labels.iter().zip(first) {
        let facet = *label == bench.facets;
        kept[if facet { first.0 } else { *label } as usize] = true;
        n_facets[first.0 as usize] += usize::from(facet);
    }
    let mut was = vec![false; kept.len()];
    for label in first {
        was[label.0 as usize] = true;
    }
    for region in (0..kept.len()).filter(|r| was[*r] != kept[*r]) {
        let (code, text) = if was[region] {
            let text = "its face is too narrow to have edges; its neighbours were extended over it";
            (IssueCode::FaceDropped, text)
        } else {
            (IssueCode::FaceAdded, "a narrow face between two others that do not meet, read off their border")
        };
        issues.push(Issue::new(code, Some(RegionId(region as u32)), text.into()));
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
    made.draft.report(&mut issues, bench.tolerances);
    let solids = made.solids.into_iter().map(|m| m.solid).collect();
    Built { solids, issues, primitives: bench.closed.primitives.clone() }
}
