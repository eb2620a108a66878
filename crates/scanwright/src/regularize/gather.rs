//! The gathering of things that mean the same, by Bayes' rule.
//!
//! Things come best seen first, so that strong ones meet before weak ones could draw them together. Each joins the
//! group that it most probably belongs to, if that is probable enough, or founds one: a face of a well-seen draft
//! contradicts every direction, and a badly seen flank of a gear fits so many that none is probable.
//!
//! How many things of this part join a group is its own prior, by expectation and maximization (A. Dempster, N. Laird,
//! D. Rubin, Journal of the Royal Statistical Society B 39 (1977), 1-38) from a start of one half.

use super::{MAX_ACCIDENT, max_chi_squared};

/// Things that mean the same.
pub(super) trait Group: Sized {
    /// What is gathered.
    type Thing;
    /// How a thing agrees with a group.
    type Agreement: Agreement;

    /// A group of one.
    fn founded_by(thing: &Self::Thing) -> Self;

    /// Number of its things.
    fn n_members(&self) -> usize;

    /// How `thing` agrees with each of `groups`; `None` where the two cannot be compared.
    fn agreements(groups: &[Self], thing: &Self::Thing) -> Vec<Option<Self::Agreement>>;

    /// The group with `thing`; `None` when their covariances are not those of anything.
    fn with(&self, thing: &Self::Thing, agreement: &Self::Agreement) -> Option<Self>;
}

/// A deviation of one coordinate, two or four.
pub(super) trait Agreement {
    /// Number of coordinates.
    fn dimensions(&self) -> usize;
    /// Its square in standard uncertainties.
    fn z_sq(&self) -> f64;
    /// Its density if both mean the same over its density if they have nothing in common.
    fn odds(&self) -> f64;
}

/// The groups of `things`, which come best seen first.
pub(super) fn gathered<G: Group>(things: &[G::Thing]) -> Vec<G> {
    /// Rounds of estimating the prior: decisions depend on it through the logarithm of its odds only.
    const ROUNDS: usize = 6;
    let mut prior = 0.5;
    let mut groups = Vec::new();
    for _ in 0..ROUNDS {
        let joined;
        (groups, joined) = gathered_once(things, prior);
        // Laplace's rule of succession; the first thing has nothing to join.
        prior = (joined + 1.0) / (things.len() as f64 + 1.0);
    }
    groups
}

/// The groups of `things`, and how many of these are expected to have joined one. `prior`: probability that one does.
fn gathered_once<G: Group>(things: &[G::Thing], prior: f64) -> (Vec<G>, f64) {
    let mut groups: Vec<G> = Vec::new();
    let mut n_joined = 0.0;
    for thing in things {
        let (home, probability) = home(&groups, thing, prior);
        n_joined += probability;
        match home {
            Some((g, joint)) => groups[g] = joint,
            None => groups.push(G::founded_by(thing)),
        }
    }
    (groups, n_joined)
}

/// The group that `thing` belongs to, with it in it, and the probability that it belongs to any. A priori it joins one
/// with probability `prior`, a large one rather than a small one, in proportion to members.
fn home<G: Group>(groups: &[G], thing: &G::Thing, prior: f64) -> (Option<(usize, G)>, f64) {
    let agreements = G::agreements(groups, thing);
    let comparable = groups.iter().zip(&agreements).filter(|(_, agreement)| agreement.is_some());
    let n_before = comparable.map(|(group, _)| group.n_members()).sum::<usize>() as f64;
    let mut best: Option<(f64, usize, &G::Agreement)> = None;
    let mut sum = 1.0 - prior;
    for (g, agreement) in agreements.iter().enumerate() {
        let Some(agreement) = agreement.as_ref().filter(|a| a.z_sq() < max_chi_squared(a.dimensions()))
        else {
            continue;
        };
        let weight = prior * groups[g].n_members() as f64 / n_before * agreement.odds();
        sum += weight;
        if best.is_none_or(|(w, _, _)| w < weight) {
            best = Some((weight, g, agreement));
        }
    }
    let probability = 1.0 - (1.0 - prior) / sum;
    let joint = best
        .filter(|(weight, _, _)| sum - weight < MAX_ACCIDENT * sum)
        .and_then(|(_, g, agreement)| groups[g].with(thing, agreement).map(|joint| (g, joint)));
    (joint, probability)
}

/// The groups that a user asks for: one per set of `sets`, and one per thing in none of them. `name`: what sets call it.
pub(super) fn forced<G: Group>(
    things: &[G::Thing],
    sets: &[Vec<usize>],
    name: impl Fn(&G::Thing) -> usize,
) -> Vec<G> {
    let mut groups: Vec<(Option<usize>, G)> = Vec::new();
    for thing in things {
        let set = sets.iter().position(|set| set.contains(&name(thing)));
        let home = groups.iter_mut().find(|(of, _)| set.is_some() && *of == set);
        let joint = home.and_then(|(_, group)| {
            let agreement = G::agreements(std::slice::from_ref(group), thing).pop()??;
            *group = group.with(thing, &agreement)?;
            Some(())
        });
        if joint.is_none() {
            groups.push((set, G::founded_by(thing)));
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}
