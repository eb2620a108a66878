//! Fewer facets, and the last resort for validity: the mesh itself.
//!
//! Mending is a search and may end with faces that receiving programs refuse. Then all faces at fault become facets,
//! then all that are at fault beside these, and in the end the whole part: a mesh that encloses something is a sound
//! solid, if a plain one. Slivers are relaxed first, for a facet without width is no face.

use super::Built;
use super::attempt::{Attempt, Bench, Choice};
use super::build::built;
use super::facets::MOST;
use super::thin::{Thinned, Thinning, relax_slivers};
use crate::surface::Surface;

/// An attempt as a result: sound if it can be, and with no more facets than that takes.
pub(super) fn plainly_built(bench: &Bench, made: Attempt) -> Built {
    if !made.is_fatal() {
        return thinned(bench, made);
    }
    let mut closed = bench.closed.clone();
    relax_slivers(&mut closed.mesh, bench.tolerances.spacing());
    let relaxed = Bench::new(&closed, bench.tolerances);
    let partly = spread(&relaxed, made.choice.clone()).map(|sound| thinned(&relaxed, sound));
    let n_faces = |built: &Built| built.solids.iter().map(|s| s.faces.len()).sum::<usize>();
    match partly {
        Some(partly) if n_faces(&partly) <= MOST => partly,
        partly => whole(&relaxed).or(partly).unwrap_or_else(|| built(bench, made)),
    }
}

/// A sound attempt with fewer facets, if it stays as sound with them.
fn thinned(bench: &Bench, made: Attempt) -> Built {
    let is_plane: Vec<bool> = bench
        .surfaces
        .iter()
        .zip(&made.choice.demoted)
        .map(|(s, demoted)| !demoted && matches!(s, Some(Surface::Plane(_))))
        .collect();
    // The rims of zones are the first to make trouble, then facets that are large.
    for (share, rims) in [(1.0, true), (1.0, false), (0.5, false), (0.2, false)] {
        let thinning = Thinning { bench, labels: &made.choice.labels, is_plane: &is_plane, share, rims };
        let Some(Thinned { closed, labels, vertices }) = thinning.run() else { break };
        let thin = Bench::new(&closed, bench.tolerances);
        // Facets keep their corners apart, so that a shared one is still there.
        let shared = made
            .choice
            .shared
            .iter()
            .filter_map(|[a, b]| Some([vertices[*a as usize]?, vertices[*b as usize]?]));
        let choice = Choice { labels, demoted: made.choice.demoted.clone(), shared: shared.collect() };
        let trial = thin.attempt(choice);
        if trial.severity() <= made.severity() {
            return built(&thin, trial);
        }
    }
    built(bench, made)
}

/// All faces at fault as facets, then those at fault beside them, as long as that takes; `None` when it does not end.
fn spread(bench: &Bench, choice: Choice) -> Option<Attempt> {
    const ROUNDS: usize = 6;
    let mut trial = bench.attempt(choice);
    for _ in 0..ROUNDS {
        if !trial.is_fatal() {
            return Some(trial);
        }
        let mut choice = trial.choice.clone();
        for triangle in trial.at_fault() {
            choice.labels[triangle as usize] = bench.facets;
        }
        if choice == trial.choice {
            return None;
        }
        trial = bench.attempt(choice);
    }
    (!trial.is_fatal()).then_some(trial)
}

/// The whole part as facets, if that is sound.
pub(super) fn whole(bench: &Bench) -> Option<Built> {
    let labels = vec![bench.facets; bench.closed.labels.len()];
    let thinning = Thinning { bench, labels: &labels, is_plane: &[], share: 1.0, rims: false };
    let Thinned { mut closed, labels, .. } = thinning.run()?;
    relax_slivers(&mut closed.mesh, bench.tolerances.spacing());
    let thin = Bench::new(&closed, bench.tolerances);
    let demoted = vec![false; bench.surfaces.len()];
    let trial = thin.attempt(Choice { labels, demoted, shared: Vec::new() });
    (!trial.is_fatal()).then(|| built(&thin, trial))
}
