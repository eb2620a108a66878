//! The search for features: at each step the one change of the model that sets most volume right.
//!
//! Candidates are the best unions of blocks of every grid, to be added or to be cut; what they are worth is known from
//! samples whose answer the solid has given. T. Du, J. P. Inala, Y. Pu, A. Spielberg, A. Schulz, D. Rus, A. Solar-Lezama,
//! W. Matusik, "InverseCSG: automatic conversion of 3D models to CSG trees", ACM Transactions on Graphics 37 (2018),
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
const PER_FEATURE: f64 = 2e-3;
/// What is wrong counts so many times.
const WRONG: f64 = 3.0;

/// The features of a solid. Lengths below `tolerance` are noise.
pub(super) fn search(body: &Body, tolerance: f64, seed: u64) -> Model {
    let mut grids: Vec<Grid> = Vec::new();
    for sweep in sweeps(body, tolerance) {
        if sweep.motion == Motion::Around {
            grids.extend(Grid::new(body, sweep, true, tolerance, seed));
        }
        let parts = Grid::new(body, sweep, false, tolerance, seed);
        grids.extend(parts.filter(|g| !g.is_whole));
    }
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
            let hole = overlapped(body, hole, tolerance, |p| !body.contains(p));
            grids.iter_mut().for_each(|grid| grid.note_hole(&hole));
            model.holes.push(hole);
        }
    }
    for _ in 0..MOST_STEPS {
        let Some(features) = step(body, &grids, &model, volume, tolerance, seed) else { break };
        for feature in features {
            grids.iter_mut().for_each(|grid| grid.note(&feature));
            model.body.push(feature);
        }
    }
    model
}

/// The best change of all grids.
fn step(
    body: &Body,
    grids: &[Grid],
    model: &Model,
    volume: f64,
    tolerance: f64,
    seed: u64,
) -> Option<Vec<Feature>> {
    let signs: &[Sign] = if model.body.is_empty() { &[Sign::Add] } else { &[Sign::Add, Sign::Cut] };
    let tasks: Vec<(usize, Sign)> = (0..grids.len()).flat_map(|g| signs.iter().map(move |s| (g, *s))).collect();
    let mut choices: Vec<(f64, usize, Sign, Vec<bool>)> = par::map(&tasks, |(g, sign)| {
        let choice = grids[*g].choose(*sign, tolerance);
        (choice.gain, *g, *sign, choice.is_in)
    });
    choices.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut best: Option<(f64, Vec<Feature>)> = None;
    for (gain, g, sign, is_in) in choices {
        if gain < LEAST * volume || best.as_ref().is_some_and(|b| gain <= b.0) {
            break;
        }
        let mut kept = Vec::new();
        let mut score = 0.0;
        for feature in grids[g].features(&is_in, sign) {
            let is_drilled = |p: &Point3| model.is_hole(p);
            let changes = |p: &Point3| match sign {
                Sign::Add => !model.is_body(p),
                Sign::Cut => model.is_body(p),
            };
            let worth = Worth::of(&feature, body, |p| changes(p) && (body.contains(p) || !is_drilled(p)), seed);
            let gain = worth.right - WRONG * worth.wrong;
            if gain >= LEAST * volume {
                score += gain - PER_FEATURE * volume;
                kept.push(feature);
            }
        }
        score += PER_FEATURE * volume;
        if !kept.is_empty() && best.as_ref().is_none_or(|b| score > b.0) {
            best = Some((score, kept));
        }
    }
    best.map(|b| b.1)
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
