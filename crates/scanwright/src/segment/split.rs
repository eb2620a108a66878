//! Simpler surfaces in place of one complex surface.
//!
//! A torus, sphere, cone or cylinder may have been laid over several facets. Its vertices are ordered along its
//! profile and cut where two simpler surfaces describe the parts best, then each part once more. The parts become
//! hypotheses; whether they replace the whole is decided in `select`.

use std::f64::consts::PI;

use super::field::{Field, Hypothesis, Scratch};
use super::grow::{settle, BORDER_RINGS, MIN_INTERIOR};
use crate::fit::Fit;
use crate::math::Frame;
use crate::recognize::{fit_kind, COST_CAP};
use crate::surface::{Surface, SurfaceKind};

/// Samples per part while cutting.
const N_CUT: usize = 60;
/// Places tried for a cut.
const N_PLACES: usize = 8;
/// Vertices of a part, at least.
const MIN_PART: usize = 40;

/// Hypotheses for the parts of a complex one.
pub(super) fn parts(field: &Field, hypothesis: &Hypothesis, scratch: &mut Scratch) -> Vec<Hypothesis> {
    let support: Vec<u32> = hypothesis.support.iter().map(|s| s.0).collect();
    let Some(ordered) = along_profile(field, &hypothesis.fit, &support, scratch) else { return Vec::new() };
    let kinds: &[SurfaceKind] = if hypothesis.fit.surface.kind() == SurfaceKind::Cylinder {
        &[SurfaceKind::Plane]
    } else {
        &[SurfaceKind::Plane, SurfaceKind::Cylinder, SurfaceKind::Cone]
    };
    let mut found = Vec::new();
    let halves = cut(field, &ordered, kinds);
    for half in &halves {
        found.extend(cut(field, half, kinds));
    }
    found.extend(halves);
    found.push(ordered);
    found
        .into_iter()
        .filter_map(|part| {
            let (fit, _) = simple(field, &part, kinds)?;
            settle(field, &fit, &part, scratch)
        })
        .collect()
}

/// Vertices ordered along the profile of a surface; `None` when it has none.
fn along_profile(field: &Field, fit: &Fit, support: &[u32], scratch: &mut Scratch) -> Option<Vec<u32>> {
    let surface = match fit.surface {
        // A sphere's profile needs an axis: that of the torus nearest to it.
        Surface::Sphere(_) => {
            let interior = field.eroded(support, BORDER_RINGS, MIN_INTERIOR, scratch);
            let samples = field.samples(&interior, 2 * N_CUT);
            fit_kind(SurfaceKind::Torus, &samples, &field.weights, &field.limits, None)?.fit.surface
        }
        other => other,
    };
    let axis = surface.axis()?;
    let frame = Frame::from_z(axis.origin, axis.direction);
    let angles = matches!(surface, Surface::Torus(_) | Surface::Cylinder(_));
    let mut keyed: Vec<(f64, u32)> = support
        .iter()
        .map(|&v| {
            let local = frame.local(&field.points[v as usize]);
            let key = match surface {
                Surface::Torus(s) => local.z.atan2(local.x.hypot(local.y) - s.major_radius),
                Surface::Cylinder(_) => local.y.atan2(local.x),
                _ => local.z,
            };
            (key, v)
        })
        .collect();
    if angles {
        let (x, y) = keyed.iter().fold((0.0, 0.0), |(x, y), k| (x + k.0.cos(), y + k.0.sin()));
        let middle = f64::atan2(y, x);
        for k in &mut keyed {
            k.0 = (k.0 - middle + 3.0 * PI).rem_euclid(2.0 * PI);
        }
    }
    keyed.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    Some(keyed.into_iter().map(|k| k.1).collect())
}

/// The two parts, in profile order, that simple surfaces describe best; empty when there is no room to cut.
fn cut(field: &Field, ordered: &[u32], kinds: &[SurfaceKind]) -> Vec<Vec<u32>> {
    if ordered.len() < 2 * MIN_PART {
        return Vec::new();
    }
    let best = (1..N_PLACES)
        .filter_map(|place| {
            let at = place * ordered.len() / N_PLACES;
            if at < MIN_PART || ordered.len() - at < MIN_PART {
                return None;
            }
            let (_, left) = simple(field, &ordered[..at], kinds)?;
            let (_, right) = simple(field, &ordered[at..], kinds)?;
            Some((left * at as f64 + right * (ordered.len() - at) as f64, at))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    best.map_or_else(Vec::new, |(_, at)| vec![ordered[..at].to_vec(), ordered[at..].to_vec()])
}

/// The simplest of `kinds` that describes a part about as well as any, with its mean cost.
fn simple(field: &Field, part: &[u32], kinds: &[SurfaceKind]) -> Option<(Fit, f64)> {
    /// Share by which a more complex type must be better.
    const CLEARLY: f64 = 0.7;
    // Profile order is no spatial order: thinning by a stride that is prime spreads the samples.
    let samples = field.samples(part, N_CUT);
    let mut best: Option<(Fit, f64)> = None;
    for &kind in kinds {
        let Some(choice) = fit_kind(kind, &samples, &field.weights, &field.limits, None) else { continue };
        if best.is_none_or(|(_, cost)| choice.mean_cost < CLEARLY * cost) {
            best = Some((choice.fit, choice.mean_cost.min(COST_CAP)));
        }
    }
    best
}
