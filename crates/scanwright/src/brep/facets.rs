//! The last resort: where no surface and no B-spline gives a sound face, the triangles of the scan become flat faces.
//!
//! A flaw is mended where it is: the triangles within some spacings of it are cut out of their regions, whatever these
//! are, and each is a face between three straight edges. Its corners stay on the mesh, those at the rim on the surfaces
//! beside it, so nothing is left to extend or to intersect. What does not help is not kept; the reach grows while
//! something is wrong, and in the end takes the whole of the faces at fault.

use super::attempt::{Attempt, Bench, Flaw};
use super::batch::{apart, batch};
use super::domain::nearest_on_spline;
use super::mend::{Mend, WORTH};
use crate::math::Point3;

/// In spacings: how far round a flaw triangles are taken, least first; then the whole of the faces at fault.
const REACHES: [f64; 3] = [3.0, 6.0, 12.0];
/// In spacings: triangles farther from the surface of their face than its rounded borders are taken with those beside
/// them, for a rim has to lie on the surfaces beside it.
const MISFIT: f64 = 1.2;
/// Most triangles that become faces: more, and few programs would open the part.
const MOST: usize = 8_000;
/// Builds per scan.
const MAX_TRIALS: usize = 24;

/// The soundest attempt that facets beside the flaws of `start` lead to.
pub(super) fn faceted(bench: &Bench, start: Attempt) -> Attempt {
    let mut best = start;
    let mut tried: Vec<Mend> = Vec::new();
    let mut n_trials = 0;
    while n_trials < MAX_TRIALS && best.severity() > 0.0 {
        let mends: Vec<Mend> = zones(bench, &best).into_iter().filter(|m| !tried.contains(m)).collect();
        let mends = apart(bench, &best, &mends);
        if mends.is_empty() {
            break;
        }
        let (better, n) = batch(bench, &best, &mends, 0.0, WORTH);
        n_trials += n;
        tried.extend(mends);
        best = better.unwrap_or(best);
    }
    best
}

/// For every flaw the triangles round it that may become facets, the smallest zones first.
fn zones(bench: &Bench, attempt: &Attempt) -> Vec<Mend> {
    let labels = &attempt.choice.labels;
    let n_facets = labels.iter().filter(|l| **l == bench.facets).count();
    let mut mends = Vec::new();
    for reach in REACHES.map(Some).into_iter().chain([None]) {
        for flaw in &attempt.flaws {
            let mut taken = vec![false; labels.len()];
            match reach {
                Some(reach) => take_round(bench, attempt, flaw, reach, &mut taken),
                None => flaw
                    .patches
                    .iter()
                    .flat_map(|p| &attempt.draft.patches[*p].triangles)
                    .for_each(|t| taken[*t as usize] = true),
            }
            take_misfits(bench, attempt, &mut taken);
            let triangles: Vec<u32> = (0..labels.len() as u32)
                .filter(|t| taken[*t as usize] && labels[*t as usize] != bench.facets)
                .collect();
            if !triangles.is_empty() && n_facets + triangles.len() <= MOST {
                let labels = vec![bench.facets; triangles.len()];
                mends.push(Mend::Relabel { triangles, labels });
            }
        }
    }
    mends
}

/// Takes the triangles within `reach` spacings of where a flaw is, connected with the nearest of the patches at fault.
fn take_round(bench: &Bench, attempt: &Attempt, flaw: &Flaw, reach: f64, taken: &mut [bool]) {
    let mesh = &bench.closed.mesh;
    let reach = reach * bench.tolerances.spacing();
    let off = |t: u32, p: &Point3| (mesh.triangle_center(t as usize) - p).norm_squared();
    for at in &flaw.at {
        let at_fault = flaw.patches.iter().flat_map(|p| &attempt.draft.patches[*p].triangles);
        let Some(&nearest) = at_fault.min_by(|a, b| off(**a, at).total_cmp(&off(**b, at))) else { continue };
        let center = mesh.triangle_center(nearest as usize);
        let mut found = vec![nearest];
        let mut next = 0;
        while next < found.len() {
            for u in bench.half_edges.neighbours(found[next] as usize).into_iter().flatten() {
                let u = u as u32;
                if !found.contains(&u) && off(u, &center) <= reach * reach {
                    found.push(u);
                }
            }
            next += 1;
        }
        found.iter().for_each(|t| taken[*t as usize] = true);
    }
}

/// Takes the triangles connected with those taken that lie off the surface of their own face.
fn take_misfits(bench: &Bench, attempt: &Attempt, taken: &mut [bool]) {
    let mesh = &bench.closed.mesh;
    let limit = MISFIT * bench.tolerances.spacing();
    let misfit = |t: usize| {
        let patch = attempt.draft.patch_of[t] as usize;
        let surface = attempt.draft.patches[patch].surface;
        mesh.corners(t).iter().any(|p| match (&surface, &attempt.splines[patch]) {
            (Some(surface), _) => surface.signed_distance(p).abs() > limit,
            (None, Some(fitted)) => (nearest_on_spline(&fitted.surface, p) - p).norm() > limit,
            (None, None) => false,
        })
    };
    let mut front: Vec<usize> = (0..taken.len()).filter(|t| taken[*t]).collect();
    while let Some(t) = front.pop() {
        for u in bench.half_edges.neighbours(t).into_iter().flatten() {
            if !taken[u] && misfit(u) {
                taken[u] = true;
                front.push(u);
            }
        }
    }
}
