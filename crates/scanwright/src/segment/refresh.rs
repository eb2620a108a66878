//! Labelled regions become hypotheses again: retyped on their interior, merged with neighbours of the same surface.

use super::field::{Field, Hypothesis, Scratch};
use super::grow::{BORDER_RINGS, MIN_INTERIOR, collect, settle};
use super::label::Labels;
use super::merge::highest_wave;
use super::narrow::Rim;
use crate::fit::Fit;
use crate::par;
use crate::recognize::{COST_CAP, Choice, choose, excess_cost, is_as_good, mean_cost};
use crate::surface::SurfaceKind;

/// Smallest region that is refitted, in vertices.
const MIN_REGION: usize = 20;
/// Samples per region in a test of merging.
const N_MERGE: usize = 150;

/// A labelled region on its way to a hypothesis.
#[derive(Debug, Clone)]
struct Piece {
    fit: Fit,
    members: Vec<u32>,
    interior: Vec<u32>,
    mean_cost: f64,
    /// Whether the rounding of its edges was part of the choice of its type.
    narrow: bool,
}

/// Hypotheses from the regions of `labels`.
pub(super) fn refresh(field: &Field, labels: &Labels) -> Vec<Hypothesis> {
    let components: Vec<(u32, Vec<u32>)> =
        labels.components(field).into_iter().filter(|(_, m)| m.len() >= MIN_REGION).collect();
    let pieces: Vec<Piece> = par::map(&components, |(label, members)| {
        let mut scratch = Scratch::new(field.n_vertices());
        let fit_of = |v: u32| labels.of_vertex[v as usize].map(|k| labels.fits[k as usize]);
        refit(field, labels.fits[*label as usize], members.clone(), fit_of, &mut scratch)
    })
    .into_iter()
    .flatten()
    .collect();
    let merged = merge_neighbours(field, pieces);
    par::map(&merged, |piece| {
        let mut scratch = Scratch::new(field.n_vertices());
        if piece.narrow {
            let choice = Choice { fit: piece.fit, mean_cost: piece.mean_cost };
            return collect(field, &choice, &piece.interior, &mut scratch);
        }
        settle(field, &piece.fit, &piece.members, &mut scratch)
    })
    .into_iter()
    .flatten()
    .collect()
}

fn refit(
    field: &Field,
    fit: Fit,
    members: Vec<u32>,
    fit_of: impl Fn(u32) -> Option<Fit>,
    scratch: &mut Scratch,
) -> Option<Piece> {
    let interior = field.eroded(&members, BORDER_RINGS, MIN_INTERIOR, scratch);
    let samples = field.samples(&interior, N_MERGE);
    let choice = choose(&samples, interior.len(), &field.weights, &field.limits, Some(&fit))?;
    // Rounded ends make an arc of a narrow chamfer.
    let simpler = (choice.fit.surface.kind() > SurfaceKind::Cylinder)
        .then(|| Rim::of_narrow(field, &members, fit_of, scratch))
        .flatten()
        .and_then(|rim| rim.simpler(field, &choice.fit));
    let narrow = simpler.is_some();
    let Choice { fit, mean_cost } = simpler.unwrap_or(choice);
    Some(Piece { fit, members, interior, mean_cost, narrow })
}

/// Merges adjacent pieces, best pair first, until no joint surface describes two of them as well as their own.
fn merge_neighbours(field: &Field, mut pieces: Vec<Piece>) -> Vec<Piece> {
    let mut pairs = neighbours(field, &pieces);
    let mut into: Vec<usize> = (0..pieces.len()).collect();
    let mut stale: Vec<u32> = vec![0; pieces.len()];
    let mut tests = par::map(&pairs, |&(a, b)| joint(field, &pieces[a], &pieces[b]));
    loop {
        let best = pairs
            .iter()
            .zip(&tests)
            .filter_map(|(pair, test)| test.map(|(excess, fit)| (excess, *pair, fit)))
            .min_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        let Some((_, (a, b), fit)) = best else { break };
        let mut members = std::mem::take(&mut pieces[b].members);
        let interior = std::mem::take(&mut pieces[b].interior);
        pieces[a].members.append(&mut members);
        pieces[a].interior.extend(interior);
        pieces[a].fit = fit;
        pieces[a].narrow = false;
        let samples = field.samples(&pieces[a].interior, N_MERGE);
        pieces[a].mean_cost = mean_cost(&fit, &samples, &field.weights);
        into[b] = a;
        stale[a] += 1;
        // Pairs of `b` become pairs of `a`; only those of `a` are tested again.
        for pair in &mut pairs {
            let renamed = (if pair.0 == b { a } else { pair.0 }, if pair.1 == b { a } else { pair.1 });
            *pair = (renamed.0.min(renamed.1), renamed.0.max(renamed.1));
        }
        let mut kept: Vec<((usize, usize), _)> =
            pairs.iter().copied().zip(tests).filter(|((x, y), _)| x != y).collect();
        kept.sort_by_key(|k| k.0);
        kept.dedup_by_key(|k| k.0);
        pairs = kept.iter().map(|k| k.0).collect();
        let fresh = par::map(&pairs, |&(x, y)| {
            if x == a || y == a { Some(joint(field, &pieces[x], &pieces[y])) } else { None }
        });
        tests = kept.into_iter().zip(fresh).map(|((_, old), new)| new.unwrap_or(old)).collect();
    }
    pieces.into_iter().filter(|p| !p.members.is_empty()).collect()
}

/// A joint surface of two pieces and how much worse it is than their own; `None` when it is too much worse.
fn joint(field: &Field, a: &Piece, b: &Piece) -> Option<(f64, Fit)> {
    let (sa, sb) = (field.samples(&a.interior, N_MERGE), field.samples(&b.interior, N_MERGE));
    // Far apart under each other's surface: no joint fit can save them.
    const HOPELESS: f64 = 0.8 * COST_CAP;
    if mean_cost(&a.fit, &sb, &field.weights) > HOPELESS && mean_cost(&b.fit, &sa, &field.weights) > HOPELESS
    {
        return None;
    }
    let (large, small, of_small) = if a.members.len() < b.members.len() { (b, a, &sa) } else { (a, b, &sb) };
    let is_wave = large.fit.surface.kind() == small.fit.surface.kind()
        && highest_wave(large.members.len(), small.members.len())
            .is_some_and(|highest| mean_cost(&large.fit, of_small, &field.weights) < highest);
    if is_wave {
        return Some((0.0, large.fit));
    }
    // Areas decide the joint fit, so that a small piece cannot bend a large one.
    let (na, nb) = (a.interior.len(), b.interior.len());
    let share = |n: usize| (2 * N_MERGE * n / (na + nb)).clamp(N_MERGE / 5, 2 * N_MERGE);
    let both = field.samples(&a.interior, share(na)).followed_by(&field.samples(&b.interior, share(nb)));
    let n = na + nb;
    [Some(&a.fit), Some(&b.fit)]
        .into_iter()
        .filter_map(|previous| choose(&both, n, &field.weights, &field.limits, previous))
        .filter_map(|choice| {
            let shared = [&sa, &sb].map(|samples| mean_cost(&choice.fit, samples, &field.weights));
            let own = [a.mean_cost, b.mean_cost];
            let excess = excess_cost(shared[0], own[0]).max(excess_cost(shared[1], own[1]));
            (is_as_good(shared[0], own[0]) && is_as_good(shared[1], own[1])).then_some((excess, choice.fit))
        })
        .min_by(|x, y| x.0.total_cmp(&y.0))
}

/// Pairs of pieces whose regions meet when both grow by the width of a rounded edge.
fn neighbours(field: &Field, pieces: &[Piece]) -> Vec<(usize, usize)> {
    let mut owner: Vec<Option<u32>> = vec![None; field.n_vertices()];
    let mut front: Vec<u32> = Vec::new();
    for (k, piece) in pieces.iter().enumerate() {
        for &v in &piece.members {
            owner[v as usize] = Some(k as u32);
        }
        front.extend(&piece.members);
    }
    for _ in 0..BORDER_RINGS {
        let mut next = Vec::new();
        for &v in &front {
            for &u in field.rings.row(v as usize) {
                if owner[u as usize].is_none() {
                    owner[u as usize] = owner[v as usize];
                    next.push(u);
                }
            }
        }
        front = next;
    }
    let mut pairs = Vec::new();
    for v in 0..field.n_vertices() {
        let Some(a) = owner[v] else { continue };
        for &u in field.rings.row(v) {
            if let Some(b) = owner[u as usize]
                && a < b
            {
                pairs.push((a as usize, b as usize));
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}
