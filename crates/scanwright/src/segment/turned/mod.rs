//! Narrow faces of turned parts, all at once.
//!
//! Chamfer, collar, groove and countersink lie side by side, each a few vertices wide and rounded by the spot as a
//! whole; one by one they are read as a cone or torus over several of them. Averaged along the turn they are a curve
//! with hardly any noise (`profile`), and between the wide faces at its two ends that curve is a chain of straight
//! lines whose corners may be rounded (`chain`). Chains of more and more lines are fitted with the spot in the model;
//! the one that describes the curve best for its number of parameters replaces the faces that were there, if it
//! describes it clearly better than they do.

mod chain;
mod profile;
mod run;

use std::cmp::Reverse;

use super::field::Field;
use super::finish::Regions;
use crate::math::Axis;
use crate::par;
use crate::surface::SurfaceKind;
pub(super) use run::Resolved;
use run::Run;

/// Regions of fewer vertices show no axis that others could turn about.
const MIN_AXIS_VERTICES: usize = 100;

/// Replaces runs of narrow turned faces by those that their common profile shows.
pub(super) fn resolve(field: &Field, regions: &mut Regions) {
    let mut tried = Vec::new();
    for (_, axis) in axes(field, regions, &regions.members(), |_| true) {
        let members = regions.members();
        let runs = run::runs(field, regions, &members, &axis, &tried);
        let found = par::map(&runs, |run: &Run| run.resolved(field, regions, &members));
        for (run, faces) in runs.iter().zip(found) {
            if let Some(faces) = faces {
                tried.extend(regions.replace(&run.regions, faces));
            }
        }
    }
    regions.compact();
}

/// The axes that regions of the wanted kinds turn about, best seen first, each once, with their regions.
pub(super) fn axes(
    field: &Field,
    regions: &Regions,
    members: &[Vec<u32>],
    is_wanted: impl Fn(SurfaceKind) -> bool,
) -> Vec<(usize, Axis)> {
    /// Sine below which two axes are parallel.
    const PARALLEL: f64 = 0.02;
    let mut turned: Vec<usize> = (0..members.len())
        .filter(|&k| members[k].len() >= MIN_AXIS_VERTICES)
        .filter(|&k| {
            regions.fits[k].is_some_and(|f| f.surface.axis().is_some() && is_wanted(f.surface.kind()))
        })
        .collect();
    turned.sort_by_key(|&k| (regions.fits[k].map(|f| f.surface.kind()), Reverse(members[k].len()), k));
    let mut axes: Vec<(usize, Axis)> = Vec::new();
    for k in turned {
        let Some(axis) = regions.fits[k].and_then(|f| f.surface.axis()) else { continue };
        let is_known = axes.iter().any(|(_, known)| {
            known.direction.cross(&axis.direction).norm() < PARALLEL
                && known.radial(&axis.origin).norm() < field.spacing
        });
        if !is_known {
            axes.push((k, axis));
        }
    }
    axes
}
