//! The search for features: at each step the one change of the model that sets most volume right.
//!
//! Candidates are the best unions of blocks of every grid, to be added or to be cut; what they are worth is known from
//! samples whose answer the solid has given. T. Du, J. P. Inala, Y. Pu, A. Spielberg, A. Schulz, D. Rus, A. Solar-Lezama,
//! W. Matusik, "`InverseCSG`: automatic conversion of 3D models to CSG trees", ACM Transactions on Graphics 37 (2018),
//! takes primitives and samples likewise; here the building blocks are profiles that are swept, as a designer would draw
//! them.

use super::body::Body;
use super::candidates::sweeps;
use super::feature::{Feature, Model, Sign};
use super::grid::Grid;
use super::holes::holes;
use super::overlap::overlapped;
use super::sweep::Motion;
use crate::math::Point3;
use crate::par;
use crate::random::Rng;

/// Steps of one search.
const MOST_STEPS: usize = 60;
/// Share of the volume that a feature must set right at least.
const LEAST: f64 = 2e-5;
/// Share of the volume that a further feature of a step must be worth: one feature is easier to edit than two.
const PER_FEATURE: f64 = 4e-3;
/// Power of the share of a choice's border that is faces, by which its worth is weighed: profiles that end at faces are
/// the part's own, others cut it where nothing is.
const CLOSED: i32 = 4;
/// What sectors of a turn are worth beside a whole one: they meet face to face.
const SECTORS: f64 = 0.9;

/// How a search goes about it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strategy {
    /// How many times a wrong volume counts. Few: large features that later ones correct, as pockets correct a block.
    /// Many: features that are right as they are.
    pub(super) wrong: f64,
    /// Lengths below it are noise.
    pub(super) tolerance: f64,
    pub(super) seed: u64,
}

/// The grids of a body, with nothing found.
pub(super) fn grids(body: &Body, tolerance: f64, seed: u64) -> Vec<Grid> {
    let mut grids: Vec<Grid> = Vec::new();
    for sweep in sweeps(body, tolerance) {
        if sweep.motion == Motion::Around {
            grids.extend(Grid::new(body, sweep, true, tolerance, seed));
        }
        let parts = Grid::new(body, sweep, false, tolerance, seed);
        grids.extend(parts.filter(|g| !g.is_whole));
    }
    grids
}

/// The features of a solid, looked for in `grids`.
pub(super) fn search(body: &Body, mut grids: Vec<Grid>, strategy: &Strategy) -> Model {
    let Strategy { tolerance, seed, .. } = *strategy;
    let volume = body.volume().abs();
    let mut model = Model::default();
    for g in 0..grids.len() {
        if !grids[g].is_whole {
            continue;
        }
        for hole in holes(body, &grids[g]) {
            let worth = Worth::of(&hole, body, |p| !model.is_hole(p), seed);
            if worth.right < LEAST * volume || worth.wrong > 0.02 * worth.right {
                continue;
            }
            let hole = overlapped(hole, tolerance, |p| !body.contains(p));
            for grid in &mut grids {
                grid.note_hole(&hole);
            }
            model.holes.push(hole);
        }
    }
    for _ in 0..MOST_STEPS {
        let Some(features) = step(body, &grids, &model, volume, strategy) else { break };
        for feature in features {
            for grid in &mut grids {
                grid.note(&feature);
            }
            model.body.push(feature);
        }
    }
    join(body, &mut model);
    prune(body, &mut model);
    for f in 0..model.body.len() {
        let feature = model.body[f].clone();
        let is_free = |p: &Point3| body.contains(p) == (feature.sign == Sign::Add) || model.is_hole(p);
        model.body[f] = overlapped(feature.clone(), tolerance, is_free);
    }
    model
}

/// Features of one profile that are parted by nothing but what is there anyway become one.
fn join(body: &Body, model: &mut Model) {
    let mut i = 0;
    while i < model.body.len() {
        let joined = (i + 1..model.body.len()).find_map(|k| {
            let whole = model.body[i].joined(&model.body[k])?;
            let is_between = |p: &Point3| !model.body[i].contains(p) && !model.body[k].contains(p);
            let fits = |p: &Point3| body.contains(p) == (whole.sign == Sign::Add) || model.is_hole(p);
            let n_apart = model.body[i + 1..k].iter().filter(|f| f.sign != whole.sign).count();
            let is_same = whole.samples().iter().filter(|p| is_between(p)).all(fits);
            (is_same && n_apart == 0).then_some((k, whole))
        });
        match joined {
            Some((k, whole)) => {
                model.body[i] = whole;
                model.body.remove(k);
            }
            None => i += 1,
        }
    }
}

/// Features go without which the others are as right as with them; the first ones first, as later ones were found in
/// spite of them.
fn prune(body: &Body, model: &mut Model) {
    /// Share of a feature's points that may become wrong: those beside its border.
    const SLACK: f64 = 2e-3;
    let mut f = 0;
    while f < model.body.len() {
        let feature = model.body[f].clone();
        let samples: Vec<Point3> = feature.samples().into_iter().filter(|p| feature.contains(p)).collect();
        let wrong = |model: &Model| {
            let n = par::map(&samples, |p| model.contains(p) != body.contains(p)).into_iter();
            n.filter(|w| *w).count() as f64
        };
        let before = wrong(&*model);
        model.body.remove(f);
        let is_needed = model.body.is_empty() || wrong(&*model) > before + SLACK * samples.len() as f64;
        if is_needed {
            model.body.insert(f, feature);
            f += 1;
        }
    }
}

/// The best change of all grids.
fn step(
    body: &Body,
    grids: &[Grid],
    model: &Model,
    volume: f64,
    strategy: &Strategy,
) -> Option<Vec<Feature>> {
    let signs: &[Sign] = if model.body.is_empty() { &[Sign::Add] } else { &[Sign::Add, Sign::Cut] };
    let mut tasks: Vec<(f64, usize, Sign)> = Vec::new();
    for (g, grid) in grids.iter().enumerate() {
        tasks.extend(signs.iter().map(|sign| (grid.most(*sign, strategy.wrong), g, *sign)));
    }
    tasks.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut best: Option<(f64, Vec<Feature>)> = None;
    for (most, g, sign) in tasks {
        if most < LEAST * volume || best.as_ref().is_some_and(|b| most <= b.0) {
            break;
        }
        let choice = grids[g].choose(sign, strategy.wrong, strategy.tolerance);
        if best.as_ref().is_some_and(|b| choice.gain <= b.0) {
            continue;
        }
        let (worth, kept) = worthy(body, grids[g].features(&choice.is_in, sign), model, volume, strategy);
        let is_sectors = grids[g].sweep.motion == Motion::Around && !grids[g].is_whole;
        let turn = if is_sectors { SECTORS } else { 1.0 };
        let score = worth * turn * (1.0 - choice.open).max(0.0).powi(CLOSED);
        if !kept.is_empty() && best.as_ref().is_none_or(|b| score > b.0) {
            best = Some((score, kept));
        }
    }
    best.map(|b| b.1)
}

/// The features of a choice that are worth it, and what they are worth together.
fn worthy(
    body: &Body,
    features: Vec<Feature>,
    model: &Model,
    volume: f64,
    strategy: &Strategy,
) -> (f64, Vec<Feature>) {
    let mut score = PER_FEATURE * volume;
    let mut kept: Vec<(f64, Feature)> = Vec::new();
    for feature in features {
        let matters = |p: &Point3| {
            model.is_body(p) != (feature.sign == Sign::Add) && (body.contains(p) || !model.is_hole(p))
        };
        let worth = Worth::of(&feature, body, matters, strategy.seed);
        let gain = worth.right - strategy.wrong * worth.wrong;
        if gain >= LEAST * volume {
            score += gain - PER_FEATURE * volume;
            kept.push((gain, feature));
        }
    }
    // The largest first: it is what the others stand on.
    kept.sort_by(|a, b| b.0.total_cmp(&a.0));
    (score, kept.into_iter().map(|k| k.1).collect())
}

/// Volume that a feature sets right, and volume that it sets wrong.
struct Worth {
    right: f64,
    wrong: f64,
}

impl Worth {
    /// `changes`: where the feature makes a difference that matters.
    fn of(feature: &Feature, body: &Body, changes: impl Fn(&Point3) -> bool + Sync, seed: u64) -> Self {
        const N: usize = 3000;
        let (low, high) = feature.bounds();
        let (from, to) = if feature.is_whole { (0.0, std::f64::consts::TAU) } else { feature.range };
        let box_volume = (high.x - low.x) * (high.y - low.y) * (to - from);
        let mut rng = Rng::for_task(seed, "script-worth", 0);
        let places: Vec<(super::sweep::Point2, f64)> = (0..N)
            .map(|_| {
                let x = low.x + (high.x - low.x) * rng.uniform();
                let y = low.y + (high.y - low.y) * rng.uniform();
                (super::sweep::Point2::new(x, y), from + (to - from) * rng.uniform())
            })
            .collect();
        let worth = par::map(&places, |(profile, moved)| {
            let p = feature.sweep.point(profile, *moved);
            let weight = feature.sweep.density(profile) * box_volume / N as f64;
            if !feature.contains(&p) || !changes(&p) {
                return (0.0, 0.0);
            }
            if body.contains(&p) == (feature.sign == Sign::Add) { (weight, 0.0) } else { (0.0, weight) }
        });
        Self { right: worth.iter().map(|w| w.0).sum(), wrong: worth.iter().map(|w| w.1).sum() }
    }
}
