//! Hypotheses: a surface grown from a seed, refitted and retyped as it grows.

use super::cover::Cover;
use super::field::{Field, Hypothesis, Scratch};
use super::label::Labels;
use crate::fit::Fit;
use crate::math::Vec3;
use crate::par;
use crate::recognize::{Choice, choose, fit_kind};
use crate::surface::SurfaceKind;

/// Cost up to which a growing surface takes a vertex: 3.5 sigmas.
const GROW_COST: f64 = 12.0;
/// Cost up to which a finished surface may explain a vertex.
pub(super) const SUPPORT_COST: f64 = 20.0;
/// Mean cost of a region's interior above which a hypothesis is no surface.
pub(super) const ACCEPT_COST: f64 = 2.5;
/// Rings that the scanner's rounding of edges may reach into a face.
pub(super) const BORDER_RINGS: usize = 3;
/// Vertices that must remain when a border is cut away.
pub(super) const MIN_INTERIOR: usize = 25;
/// Samples of a fit while growing.
const N_SAMPLES: usize = 120;
/// Innermost vertices that every flood starts from.
const CORE: usize = 7;
/// Seeds grown at a time. Fixed, so that results do not depend on the number of threads.
const BATCH: usize = 16;
/// Mean cost around a vertex below which it counts as explained.
const EXPLAINED_COST: f64 = 6.0;

/// Grows hypotheses from every seed that nothing explains yet, smoothest first.
///
/// `whole_ring`: a seed needs a full ring of unexplained vertices, else every rounded edge is tried.
pub(super) fn explore(
    field: &Field,
    hypotheses: &mut Vec<Hypothesis>,
    patch_sizes: &[usize],
    whole_ring: bool,
    labels: &Labels,
) {
    // Rounded edges between the surfaces found so far are explained too: no seed is wasted on them.
    let mut cover = Cover::of(field, hypotheses.iter());
    let roughness = normal_roughness(field);
    let mut order: Vec<u32> = (0..field.n_vertices() as u32).collect();
    order.sort_by(|&a, &b| roughness[a as usize].total_cmp(&roughness[b as usize]).then(a.cmp(&b)));
    for &patch_size in patch_sizes {
        let mut tried = vec![false; field.n_vertices()];
        let mut scratch = Scratch::new(field.n_vertices());
        let mut next = 0;
        loop {
            let mut batch = Vec::new();
            while next < order.len() && batch.len() < BATCH {
                let seed = order[next];
                next += 1;
                if !tried[seed as usize] && is_unexplained(field, &cover.best, labels, seed, whole_ring) {
                    // Neighbours would grow into the same surface.
                    for v in field.patch(seed, patch_size / 2, &mut scratch) {
                        tried[v as usize] = true;
                    }
                    batch.push(seed);
                }
            }
            if batch.is_empty() {
                break;
            }
            let grown = par::map(&batch, |&seed| {
                let mut scratch = Scratch::new(field.n_vertices());
                grow(field, seed, patch_size, &mut scratch)
            });
            for hypothesis in grown.into_iter().flatten() {
                // Seeds of one batch may find the same surface: later ones must still explain something.
                if gain_over(&cover.best, &hypothesis) > 0.0 {
                    cover.add(field, &hypothesis);
                    hypotheses.push(hypothesis);
                }
            }
        }
    }
}

fn gain_over(best: &[f32], hypothesis: &Hypothesis) -> f64 {
    let gain = |&(v, cost): &(u32, f32)| f64::from((best[v as usize] - cost.max(3.5)).max(0.0));
    hypothesis.support.iter().map(gain).sum::<f64>() - 60.0
}

fn is_unexplained(field: &Field, best: &[f32], labels: &Labels, seed: u32, whole_ring: bool) -> bool {
    let ring = field.rings.row(seed as usize);
    let sum: f32 = ring.iter().map(|&u| best[u as usize]).sum::<f32>() + best[seed as usize];
    if f64::from(sum) < EXPLAINED_COST * (ring.len() + 1) as f64 {
        return false;
    }
    !whole_ring
        || (labels.of_vertex[seed as usize].is_none()
            && ring.iter().all(|&u| {
                labels.of_vertex[u as usize].is_none() || f64::from(best[u as usize]) > EXPLAINED_COST
            }))
}

/// Residual of a linear model of the normals over the two-ring: small inside any smooth surface, whatever its
/// curvature, large at creases.
fn normal_roughness(field: &Field) -> Vec<f64> {
    par::map_indices(field.n_vertices(), |v| {
        let origin = field.points[v];
        let mut ring: Vec<u32> = vec![v as u32];
        for &u in field.rings.row(v) {
            ring.push(u);
            ring.extend(field.rings.row(u as usize));
        }
        ring.sort_unstable();
        ring.dedup();
        linear_residual(ring.iter().map(|&u| (field.points[u as usize] - origin, field.normals[u as usize])))
    })
}

fn linear_residual(data: impl Iterator<Item = (Vec3, Vec3)> + Clone) -> f64 {
    let n = data.clone().count() as f64;
    let (mut x_mean, mut y_mean) = (Vec3::zeros(), Vec3::zeros());
    for (x, y) in data.clone() {
        x_mean += x / n;
        y_mean += y / n;
    }
    let (mut xx, mut yx, mut yy) = (crate::math::Mat3::zeros(), crate::math::Mat3::zeros(), 0.0);
    for (x, y) in data {
        let (x, y) = (x - x_mean, y - y_mean);
        xx += x * x.transpose();
        yx += y * x.transpose();
        yy += y.norm_squared();
    }
    // The patch is nearly flat: a small ridge keeps the thin direction from being fitted.
    let ridge = crate::math::Mat3::identity() * (0.05 * xx.trace() + f64::MIN_POSITIVE);
    let Some(inverse) = (xx + ridge).try_inverse() else { return f64::MAX };
    let explained = (yx * inverse).component_mul(&yx).sum();
    ((yy - explained) / n).max(0.0)
}

/// Grows one hypothesis; `None` when the seed lies on no surface.
fn grow(field: &Field, seed: u32, patch_size: usize, scratch: &mut Scratch) -> Option<Hypothesis> {
    let patch = field.patch(seed, patch_size, scratch);
    let samples = field.samples(&patch, N_SAMPLES);
    let first = choose(&samples, patch.len(), &field.weights, &field.limits, None)?;
    let core: Vec<u32> = patch[..patch.len().min(CORE)].to_vec();
    let (mut choice, mut region) = spread(field, first, &core, patch_size, scratch)?;
    for kind in SurfaceKind::ALL {
        if kind <= choice.fit.surface.kind() {
            continue;
        }
        if let Some((other, larger)) = widen(field, kind, &region, &core, scratch)
            && larger.len() as f64 > 1.3 * region.len() as f64
            && other.mean_cost < ACCEPT_COST
        {
            (choice, region) = (other, larger);
        }
    }
    settle(field, &choice.fit, &region, scratch)
}

/// Floods from the core, refits and retypes, until the region stops growing.
fn spread(
    field: &Field,
    first: Choice,
    core: &[u32],
    patch_size: usize,
    scratch: &mut Scratch,
) -> Option<(Choice, Vec<u32>)> {
    /// Steps from a patch of 14 vertices to ten million, at a factor of three each.
    const MAX_STEPS: usize = 14;
    let mut choice = first;
    let mut n_last = patch_size;
    let mut region: Vec<u32> = Vec::new();
    for _ in 0..MAX_STEPS {
        let flooded = field.flood(&choice.fit, core, GROW_COST, 3 * n_last, scratch);
        if flooded.len() < CORE {
            return None;
        }
        region = flooded.iter().map(|f| f.0).collect();
        let interior = field.eroded(&region, 1, MIN_INTERIOR, scratch);
        let samples = field.samples(&interior, N_SAMPLES);
        let Some(next) = choose(&samples, region.len(), &field.weights, &field.limits, Some(&choice.fit))
        else {
            break;
        };
        choice = next;
        if region.len() as f64 <= 1.1 * n_last as f64 {
            break;
        }
        n_last = region.len();
    }
    Some((choice, region))
}

/// Tries a more complex type: fitted, grown, refitted, grown.
fn widen(
    field: &Field,
    kind: SurfaceKind,
    region: &[u32],
    core: &[u32],
    scratch: &mut Scratch,
) -> Option<(Choice, Vec<u32>)> {
    let interior = field.eroded(region, 1, MIN_INTERIOR, scratch);
    let samples = field.samples(&interior, N_SAMPLES);
    let mut choice = fit_kind(kind, &samples, &field.weights, &field.limits, None)?;
    if !reaches_out(field, &choice.fit, region, scratch) {
        return None;
    }
    let mut region: Vec<u32> = Vec::new();
    for _ in 0..2 {
        region = field.flood(&choice.fit, core, GROW_COST, usize::MAX, scratch).iter().map(|f| f.0).collect();
        if region.len() < MIN_INTERIOR {
            return None;
        }
        let interior = field.eroded(&region, BORDER_RINGS, MIN_INTERIOR, scratch);
        let samples = field.samples(&interior, N_SAMPLES);
        choice = fit_kind(kind, &samples, &field.weights, &field.limits, Some(&choice.fit))?;
    }
    Some((choice, region))
}

/// Whether a surface takes a fair share of the vertices just outside a region: else it cannot grow.
fn reaches_out(field: &Field, fit: &Fit, region: &[u32], scratch: &mut Scratch) -> bool {
    const FAIR_SHARE: f64 = 0.15;
    let around = field.dilated(region, 2, scratch);
    let outside = &around[region.len()..];
    let n_taken = outside.iter().filter(|&&v| field.cost(fit, v) < GROW_COST).count();
    n_taken as f64 > FAIR_SHARE * outside.len() as f64
}

/// Types the interior of a grown region once more and collects what its surface may explain.
pub(super) fn settle(field: &Field, fit: &Fit, region: &[u32], scratch: &mut Scratch) -> Option<Hypothesis> {
    let interior = field.eroded(region, BORDER_RINGS, MIN_INTERIOR, scratch);
    let samples = field.samples(&interior, N_SETTLED);
    let choice = choose(&samples, interior.len(), &field.weights, &field.limits, Some(fit))?;
    // What settles the type need not settle the parameters of a large face.
    let is_large = n_settled(interior.len()) > N_SETTLED;
    let settled = is_large.then(|| fit_settled(field, &choice.fit, &interior)).flatten();
    collect(field, &settled.unwrap_or(choice), &interior, scratch)
}

/// The same without a choice: the type of `fit` stands.
pub(super) fn settle_as(
    field: &Field,
    fit: &Fit,
    region: &[u32],
    scratch: &mut Scratch,
) -> Option<Hypothesis> {
    let interior = field.eroded(region, BORDER_RINGS, MIN_INTERIOR, scratch);
    let choice = fit_settled(field, fit, &interior)?;
    collect(field, &choice, &interior, scratch)
}

/// Samples that settle the type of a face, and the parameters of one that is not large.
const N_SETTLED: usize = 400;

/// Samples of a settled fit to `n` vertices: enough that its parameters are at the floor of the noise.
///
/// Its error costs every vertex in proportion to one over the samples. With their number fixed the sum would grow with
/// the face, and from some hundred thousand vertices on be worth more than the price of a second surface.
pub(super) fn n_settled(n: usize) -> usize {
    const VERTICES_PER_SAMPLE: usize = 64;
    N_SETTLED.max(n / VERTICES_PER_SAMPLE)
}

/// The surface of the kind of `fit` for an interior.
fn fit_settled(field: &Field, fit: &Fit, interior: &[u32]) -> Option<Choice> {
    let samples = field.samples(interior, n_settled(interior.len()));
    fit_kind(fit.surface.kind(), &samples, &field.weights, &field.limits, Some(fit))
}

/// The hypothesis of a chosen surface: all that it may explain around `interior`; `None` when it fits too badly.
pub(super) fn collect(
    field: &Field,
    choice: &Choice,
    interior: &[u32],
    scratch: &mut Scratch,
) -> Option<Hypothesis> {
    if choice.mean_cost > ACCEPT_COST {
        return None;
    }
    let support = field.flood(&choice.fit, interior, SUPPORT_COST, usize::MAX, scratch);
    Some(Hypothesis { fit: choice.fit, mean_cost: choice.mean_cost, support })
}
