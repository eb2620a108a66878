//! What is done when the labels do not give a sound solid as they are: faces too narrow to have edges of their own,
//! edges that do not exist, surfaces that do not pass through their edges.
//!
//! A greedy search: every mend is a small change of the labels beside a flaw, tried by building the whole solid again,
//! and kept only if less is wrong with it. Nothing that was seen is moved by more than what a scan can show. Cost: one
//! build per trial, only where something is wrong.

use super::attempt::{Attempt, Bench, Choice};
use super::batch::{apart, batch, search};
use super::facets::faceted;
use super::relabel::{misplaced, relabellings, sharings, straightenings, sure_false_edges};
use crate::mesh::VertId;
use crate::par;

/// A change that may mend a flaw.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Mend {
    /// Other labels for some triangles.
    Relabel { triangles: Vec<u32>, labels: Vec<u32> },
    /// One corner at both ends of a short edge.
    Share { ends: [VertId; 2] },
    /// A B-spline in place of a region's surface.
    Demote { region: u32 },
    /// A region's surface in place of a B-spline, with a label for the triangles that lie off it.
    Restore { region: u32, triangles: Vec<u32>, label: u32 },
}

/// The soundest attempt that small changes lead to from `start`. `steps`: faces that may be missing between others.
pub(super) fn mended(bench: &Bench, start: Attempt, steps: &[Mend]) -> Attempt {
    /// Builds for steps: they are sure, and most lie apart.
    const MAX_STEPS: usize = 8;
    /// Builds for shared corners.
    const MAX_SHARED: usize = 8;
    let stepped = search(bench, start, MAX_STEPS, |a| a.severity() > 0.0, |_| steps.to_vec());
    let shared = search(bench, stepped, MAX_SHARED, |a| a.severity() > 0.0, |a| sharings(bench, a));
    faceted(bench, demoted(bench, relabelled(bench, shared)))
}

/// Mends that take less than this from the severity, a sum of gaps in spacings, are not worth a change.
pub(super) const WORTH: f64 = 1e-3;

/// Changes labels as long as that helps.
fn relabelled(bench: &Bench, start: Attempt) -> Attempt {
    /// Builds per scan: a flaw takes about three, and those that lie apart are mended together.
    const MAX_TRIALS: usize = 16;
    let mut best = start;
    for sure in [straightenings, sure_false_edges, misplaced] {
        if let Some(all) = joined(&sure(bench, &best)).filter(|_| best.severity() > 0.0) {
            let trial = bench.attempt(applied(&best.choice, &all));
            if trial.severity() < best.severity() - WORTH {
                best = trial;
            }
        }
    }
    search(bench, best, MAX_TRIALS, |a| a.severity() > 0.0, |a| relabellings(bench, a))
}

/// Puts B-splines in place of surfaces as long as that helps: where many are needed all that lie apart, then of those
/// beside flaws each time the one that cures most.
fn demoted(bench: &Bench, start: Attempt) -> Attempt {
    /// Regions at fault that lie apart from which they are not worth a choice each.
    const MANY: usize = 3;
    /// Rounds with many.
    const MAX_BATCHES: usize = 6;
    let mut best = start;
    let mut tried: Vec<Mend> = Vec::new();
    for _ in 0..MAX_BATCHES {
        let mends: Vec<Mend> = blamed(bench, &best)
            .into_iter()
            .map(|(region, _)| Mend::Demote { region })
            .filter(|m| !tried.contains(m))
            .collect();
        let mends = apart(bench, &best, &mends);
        if mends.len() < MANY {
            break;
        }
        let (better, _) = batch(bench, &best, &mends, CURED, WORTH);
        tried.extend(mends);
        best = better.unwrap_or(best);
    }
    demoted_singly(bench, best)
}

/// Share of the flaws beside a face that a B-spline in its place has to cure.
const CURED: f64 = 0.2;

/// What it is worth to keep the surface that all of a part lies on: as much as to be rid of one face that crosses
/// itself.
const LOSS: f64 = 1.0;

/// Share of the part's triangles that lie on the surface of a region of theirs: one that leaves them is no loss.
fn share(bench: &Bench, attempt: &Attempt, region: u32) -> f64 {
    /// In spacings: the rounding of an edge.
    const ROUNDED: f64 = 1.2;
    let Some(surface) = bench.surfaces[region as usize] else { return 0.0 };
    let mesh = &bench.closed.mesh;
    let on = |t: usize| {
        surface.signed_distance(&mesh.triangle_center(t)).abs() <= ROUNDED * bench.tolerances.spacing()
    };
    let labels = attempt.choice.labels.iter().enumerate();
    labels.filter(|(t, l)| **l == region && on(*t)).count() as f64 / mesh.triangles.len() as f64
}

/// Of the faces beside flaws each time the one that is most worth a B-spline.
fn demoted_singly(bench: &Bench, start: Attempt) -> Attempt {
    /// Faces that may be demoted.
    const MAX_ROUNDS: usize = 12;
    /// Regions that are tried in each round.
    const MAX_TRIALS: usize = 4;
    let mut best = start;
    for _ in 0..MAX_ROUNDS {
        if best.severity() <= 0.0 {
            break;
        }
        let mut candidates = blamed(bench, &best);
        candidates.truncate(MAX_TRIALS);
        let trials = par::map(&candidates, |&(region, _)| {
            bench.attempt(applied(&best.choice, &Mend::Demote { region }))
        });
        let cured =
            |trial: &Attempt, blame: f64| trial.severity() < best.severity() - (CURED * blame).max(WORTH);
        let next = trials
            .into_iter()
            .zip(candidates)
            .filter(|(trial, (_, blame))| cured(trial, *blame))
            .map(|(trial, (region, _))| (trial.severity() + LOSS * share(bench, &best, region), trial))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, next)) = next else { break };
        best = next;
    }
    best
}

/// The regions beside flaws that still have surfaces, and what is wrong beside each, per size of the region.
fn blamed(bench: &Bench, attempt: &Attempt) -> Vec<(u32, f64)> {
    let free = |r: &u32| !attempt.choice.demoted[*r as usize] && bench.surfaces[*r as usize].is_some();
    let size = |r: u32| attempt.choice.labels.iter().filter(|l| **l == r).count() as f64;
    let mut blamed: Vec<(u32, f64, f64)> = attempt
        .flawed_regions()
        .into_iter()
        .filter(free)
        .map(|r| (r, blame(attempt, r), blame(attempt, r) / size(r).max(1.0).sqrt().sqrt()))
        .collect();
    blamed.sort_by(|a, b| b.2.total_cmp(&a.2).then(a.0.cmp(&b.0)));
    blamed.into_iter().map(|(r, blame, _)| (r, blame)).collect()
}

/// What is wrong beside a region.
fn blame(attempt: &Attempt, region: u32) -> f64 {
    let beside = |p: &usize| attempt.draft.patches[*p].region == region;
    attempt.flaws.iter().filter(|f| f.patches.iter().any(beside)).map(|f| f.weight).sum()
}

pub(super) fn applied(choice: &Choice, mend: &Mend) -> Choice {
    let mut choice = choice.clone();
    match mend {
        Mend::Relabel { triangles, labels } => {
            for (t, label) in triangles.iter().zip(labels) {
                choice.labels[*t as usize] = *label;
            }
        }
        Mend::Share { ends } => choice.shared.push(*ends),
        Mend::Demote { region } => choice.demoted[*region as usize] = true,
        Mend::Restore { region, triangles, label } => {
            choice.demoted[*region as usize] = false;
            for t in triangles {
                choice.labels[*t as usize] = *label;
            }
        }
    }
    choice
}

/// All relabellings in one.
fn joined(mends: &[Mend]) -> Option<Mend> {
    let (mut triangles, mut labels) = (Vec::new(), Vec::new());
    for mend in mends {
        if let Mend::Relabel { triangles: t, labels: l } = mend {
            triangles.extend(t);
            labels.extend(l);
        }
    }
    (!triangles.is_empty()).then_some(Mend::Relabel { triangles, labels })
}
