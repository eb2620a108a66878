//! What is done when the labels do not give a sound solid as they are: faces too narrow to have edges of their own,
//! edges that do not exist, surfaces that do not pass through their edges.
//!
//! A greedy search: every mend is a small change of the labels beside a flaw, tried by building the whole solid again,
//! and kept only if less is wrong with it. Nothing that was seen is moved by more than what a scan can show. Cost: one
//! build per trial, only where something is wrong.

use super::attempt::{Attempt, Bench, Choice};
use super::batch::{apart, batch};
use super::halfedge::HalfEdges;
use super::straighten;
use crate::par;
use crate::surface::Surface;

/// A change that may mend a flaw.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Mend {
    /// Other labels for some triangles.
    Relabel { triangles: Vec<u32>, labels: Vec<u32> },
    /// A B-spline in place of a region's surface.
    Demote { region: u32 },
}

/// The soundest attempt that small changes lead to from `start`.
pub(super) fn mended(bench: &Bench, start: Attempt) -> Attempt {
    demoted(bench, relabelled(bench, start))
}

/// Mends that take less than this from the severity are not worth a change.
const WORTH: f64 = 1e-3;

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
    let mut tried: Vec<Mend> = Vec::new();
    let mut n_trials = 0;
    while n_trials < MAX_TRIALS && best.severity() > 0.0 {
        let mends: Vec<Mend> =
            relabellings(bench, &best).into_iter().filter(|m| !tried.contains(m)).collect();
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
        let mut next: Option<Attempt> = None;
        for (trial, (_, blame)) in trials.into_iter().zip(candidates) {
            let limit = next.as_ref().map_or(best.severity() - (CURED * blame).max(WORTH), Attempt::severity);
            if trial.severity() < limit {
                next = Some(trial);
            }
        }
        let Some(next) = next else { break };
        best = next;
    }
    best
}

/// The regions beside flaws that still have surfaces, and what is wrong beside each, per size of the region.
fn blamed(bench: &Bench, attempt: &Attempt) -> Vec<(u32, f64)> {
    let mut regions: Vec<u32> =
        attempt.flaws.iter().flat_map(|f| &f.patches).map(|p| attempt.draft.patches[*p].region).collect();
    regions.sort_unstable();
    regions.dedup();
    let free = |r: &u32| !attempt.choice.demoted[*r as usize] && bench.surfaces[*r as usize].is_some();
    let size = |r: u32| attempt.choice.labels.iter().filter(|l| **l == r).count() as f64;
    let mut blamed: Vec<(u32, f64, f64)> = regions
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
        Mend::Demote { region } => choice.demoted[*region as usize] = true,
    }
    choice
}

/// Changes of labels that may mend the flaws of an attempt, the surest first, then the least.
fn relabellings(bench: &Bench, attempt: &Attempt) -> Vec<Mend> {
    let (sure, mut mends) = false_edges(bench, attempt);
    let sure = straightenings(bench, attempt).into_iter().chain(sure).chain(misplaced(bench, attempt));
    let mut patches: Vec<usize> = attempt.flaws.iter().flat_map(|f| f.patches.iter().copied()).collect();
    patches.sort_unstable();
    patches.dedup();
    let mut seen: Vec<usize> = Vec::new();
    for p in patches {
        let group = attempt.draft.group_of(p);
        if seen.contains(&group[0]) {
            continue;
        }
        seen.push(group[0]);
        mends.extend(giving_away(bench, attempt, &group));
    }
    mends.sort_by_key(|m| if let Mend::Relabel { triangles, .. } = m { triangles.len() } else { 0 });
    sure.chain(mends).collect()
}

/// The borders beside flaws whose surfaces touch, each moved to where they touch.
fn straightenings(bench: &Bench, attempt: &Attempt) -> Vec<Mend> {
    let flawed = |pair: &[u32; 2]| {
        attempt
            .flaws
            .iter()
            .any(|f| pair.iter().all(|r| f.patches.iter().any(|p| attempt.draft.patches[*p].region == *r)))
    };
    straighten::straightenings(bench, &attempt.choice.labels, &attempt.choice.demoted)
        .into_iter()
        .filter(|(pair, _)| flawed(pair))
        .map(|(_, (triangles, labels))| Mend::Relabel { triangles, labels })
        .collect()
}

/// Ways to do without the patches of one face: every triangle to the nearest of the neighbours, or all to one.
fn giving_away(bench: &Bench, attempt: &Attempt, group: &[usize]) -> Vec<Mend> {
    /// Neighbours with the longest common borders that are asked.
    const MAX_TAKERS: usize = 3;
    let draft = &attempt.draft;
    let region = draft.patches[group[0]].region;
    let triangles: Vec<u32> =
        group.iter().flat_map(|p| draft.patches[*p].triangles.iter().copied()).collect();
    let mut takers: Vec<(u32, usize)> = Vec::new();
    for t in &triangles {
        for u in bench.half_edges.neighbours(*t as usize).into_iter().flatten() {
            let other = attempt.choice.labels[u];
            if other == region {
                continue;
            }
            match takers.iter_mut().find(|taker| taker.0 == other) {
                Some(taker) => taker.1 += 1,
                None => takers.push((other, 1)),
            }
        }
    }
    takers.sort_by_key(|t| (std::cmp::Reverse(t.1), t.0));
    takers.truncate(MAX_TAKERS);
    let surfaces: Vec<(u32, Surface)> =
        takers.iter().filter_map(|(r, _)| bench.surfaces[*r as usize].map(|s| (*r, s))).collect();
    let center = |t: &u32| bench.closed.mesh.triangle_center(*t as usize);
    let mut mends = Vec::new();
    if surfaces.len() > 1 {
        let nearest = |t: &u32| {
            let off = |s: &Surface| s.signed_distance(&center(t)).abs();
            surfaces.iter().min_by(|a, b| off(&a.1).total_cmp(&off(&b.1))).expect("there are some")
        };
        let labels: Vec<u32> = triangles.iter().map(|t| nearest(t).0).collect();
        let off = triangles.iter().map(|t| nearest(t).1.signed_distance(&center(t)).abs());
        if harmless(bench, off.collect()) {
            mends.push(Mend::Relabel { triangles: triangles.clone(), labels });
        }
    }
    for (taker, surface) in &surfaces {
        if harmless(bench, triangles.iter().map(|t| surface.signed_distance(&center(t)).abs()).collect()) {
            mends.push(Mend::Relabel { triangles: triangles.clone(), labels: vec![*taker; triangles.len()] });
        }
    }
    mends
}

/// Whether triangles this far from the surface that takes them are lost in what a scan rounds off.
fn harmless(bench: &Bench, mut distances: Vec<f64>) -> bool {
    /// In spacings: the rounding of an edge.
    const ROUNDED: f64 = 1.2;
    /// Share of the triangles that must be nearer.
    const MOST: f64 = 0.9;
    crate::math::stats::quantile(&mut distances, MOST)
        .is_none_or(|d| d <= ROUNDED * bench.tolerances.spacing())
}

/// Triangles that lie off the surface of their own region, beside a flaw, and nearer to that of a neighbour: what the
/// scan shows of a table through a bore, or of a wall beyond a worn edge.
fn misplaced(bench: &Bench, attempt: &Attempt) -> Vec<Mend> {
    /// In spacings: farther than the rounding of an edge.
    const OFF: f64 = 1.2;
    /// Share of that distance within which the other surface must be.
    const NEARER: f64 = 0.5;
    let labels = &attempt.choice.labels;
    let mut regions: Vec<u32> =
        attempt.flaws.iter().flat_map(|f| &f.patches).map(|p| attempt.draft.patches[*p].region).collect();
    regions.sort_unstable();
    regions.dedup();
    let mut mends = Vec::new();
    for region in regions {
        let Some(own) = bench.surfaces[region as usize] else { continue };
        let members: Vec<u32> = (0..labels.len() as u32).filter(|t| labels[*t as usize] == region).collect();
        let mut beside: Vec<u32> = members
            .iter()
            .flat_map(|t| bench.half_edges.neighbours(*t as usize))
            .flatten()
            .map(|u| labels[u])
            .filter(|l| *l != region)
            .collect();
        beside.sort_unstable();
        beside.dedup();
        let beside: Vec<(u32, Surface)> =
            beside.into_iter().filter_map(|r| bench.surfaces[r as usize].map(|s| (r, s))).collect();
        let (mut triangles, mut given) = (Vec::new(), Vec::new());
        for t in members {
            let center = bench.closed.mesh.triangle_center(t as usize);
            let off = own.signed_distance(&center).abs();
            let away = |s: &Surface| s.signed_distance(&center).abs();
            let nearest = beside.iter().min_by(|x, y| away(&x.1).total_cmp(&away(&y.1)));
            let Some((other, surface)) = nearest else { continue };
            if off > OFF * bench.tolerances.spacing() && away(surface) < NEARER * off {
                triangles.push(t);
                given.push(*other);
            }
        }
        if !triangles.is_empty() {
            mends.push(Mend::Relabel { triangles, labels: given });
        }
    }
    mends
}

/// Edges whose surfaces do not meet, given away.
fn sure_false_edges(bench: &Bench, attempt: &Attempt) -> Vec<Mend> {
    false_edges(bench, attempt).0
}

/// Edges of A|B that may not exist, because one face C passes between two wrong corners: a band round each goes to C.
/// First those whose surfaces do not meet, then those whose corners are wrong.
fn false_edges(bench: &Bench, attempt: &Attempt) -> (Vec<Mend>, Vec<Mend>) {
    /// Longest chain, in mesh edges, that may be turned between two faces that do not both touch its ends.
    const MAX_FLIP: usize = 10;
    /// Rings of triangles on each side of the edge that are given away.
    const RINGS: usize = 2;
    let draft = &attempt.draft;
    let region = |p: u32| draft.patches[p as usize].region;
    let at = |c: u32| -> Vec<u32> { draft.patches_at(c).into_iter().map(|p| region(p as u32)).collect() };
    let (mut sure, mut doubtful) = (Vec::new(), Vec::new());
    for (chain, course) in draft.topology.chains.iter().zip(&draft.courses) {
        let Some(right) = chain.right else { continue };
        let (a, b) = (region(chain.left), region(right));
        let ends = [chain.start(), chain.end()].map(|v| draft.corners.corner_of[v as usize]);
        let [Some(start), Some(end)] = ends else { continue };
        let residual = |c: u32| draft.corners.corners[c as usize].residual;
        let apart = a != b && course.apart(bench.tolerances.spacing()) > bench.limit;
        if !apart && residual(start).max(residual(end)) <= bench.limit {
            continue;
        }
        let (first, last) = (at(start), at(end));
        let others = |regions: &[u32]| regions.iter().copied().find(|r| *r != a && *r != b);
        let shared = first.iter().copied().find(|r| *r != a && *r != b && last.contains(r));
        let taker = if start == end || shared.is_none() {
            (chain.vertices.len() <= MAX_FLIP).then(|| others(&first).or(others(&last))).flatten()
        } else {
            shared
        };
        let Some(taker) = taker else { continue };
        let triangles = band(bench, &attempt.choice.labels, &chain.vertices, [a, b], RINGS);
        let labels = vec![taker; triangles.len()];
        if apart { &mut sure } else { &mut doubtful }.push(Mend::Relabel { triangles, labels });
    }
    (sure, doubtful)
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

/// Triangles of two regions within some rings of a run of vertices.
fn band(bench: &Bench, labels: &[u32], vertices: &[u32], regions: [u32; 2], rings: usize) -> Vec<u32> {
    let mut front: Vec<u32> = vertices.to_vec();
    let mut triangles: Vec<u32> = Vec::new();
    for _ in 0..rings {
        let around = front.iter().flat_map(|v| bench.half_edges.leaving(*v)).map(|h| HalfEdges::triangle(*h));
        triangles.extend(around.filter(|t| regions.contains(&labels[*t])).map(|t| t as u32));
        triangles.sort_unstable();
        triangles.dedup();
        front = triangles.iter().flat_map(|t| bench.closed.mesh.triangles[*t as usize]).collect();
        front.sort_unstable();
        front.dedup();
    }
    triangles
}
