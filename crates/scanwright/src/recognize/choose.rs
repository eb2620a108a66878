//! Which of the five types a set of samples is: nested model selection with noise that is correlated.
//!
//! Types are tried from simple to complex. A more complex one is taken only when the mean cost per sample falls by
//! more than its extra freedom could win by fitting the noise. Scan noise is wavy: a few hundred neighbouring
//! vertices make one independent sample, so the Bayesian information criterion with N independent samples breaks
//! every plane into cylinders. The penalty here is `min(cap, 250 q / N)`: 250 is the number of vertices per
//! independent sample, `q` the difference of degrees of freedom.
//!
//! Second, the more complex surface must depart from the simpler one by a length that the noise cannot explain.

use crate::fit::{Fit, Samples, Weights, refine, starts};
use crate::math::stats;
use crate::surface::{Surface, SurfaceKind};

/// Physical limits of what a scan can show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Smallest radius of curvature that is a surface and not a rounded edge, length.
    pub min_radius: f64,
    /// Smallest change of a cone's radius over its extent, length.
    pub min_taper: f64,
    /// Smallest departure from the simpler type, length.
    pub min_departure: f64,
    /// Departure of normals from the simpler type that counts as much, radians.
    pub min_tilt: f64,
}

/// A fit with its cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    /// The surface.
    pub fit: Fit,
    /// Mean of the samples' costs, each capped at [`COST_CAP`].
    pub mean_cost: f64,
}

/// Types from simple to complex. A strip of a cylinder or cone fits a sphere: the cone comes first.
pub const TYPE_ORDER: [SurfaceKind; 5] =
    [SurfaceKind::Plane, SurfaceKind::Cylinder, SurfaceKind::Cone, SurfaceKind::Sphere, SurfaceKind::Torus];
/// Cost at which one sample counts no more: five sigmas.
pub const COST_CAP: f64 = 25.0;
/// Vertices per independent sample of the wavy part of the noise (correlation length of 5 to 7 spacings).
const VERTICES_PER_SAMPLE: f64 = 250.0;
/// Samples of a first guess.
const N_START: usize = 40;
/// First guesses that are refined: the cheapest ones.
const N_GUESSES: usize = 3;
/// Steps of a first guess.
const START_STEPS: usize = 4;
/// Steps of the final fit.
const FINAL_STEPS: usize = 12;

/// Chooses the type of `samples`, standing for `n` vertices; `previous` is tried as one more start of its type.
pub fn choose(
    samples: &Samples,
    n: usize,
    weights: &Weights,
    limits: &Limits,
    previous: Option<&Fit>,
) -> Option<Choice> {
    let mut current: Option<Choice> = None;
    for kind in TYPE_ORDER {
        if current.is_some_and(|c| c.mean_cost < lowest_useful_gain(n)) {
            break;
        }
        let Some(next) = fit_kind(kind, samples, weights, limits, previous) else { continue };
        let better = current.is_none_or(|c| is_better(&c, &next, samples, n, limits));
        if better {
            current = Some(next);
        }
    }
    current
}

/// Whether a surface that several pieces share describes one of them as well as its own surface does: its mean cost may
/// be higher by what an own surface saves by following the noise.
pub fn is_as_good(shared: f64, own: f64) -> bool {
    excess_cost(shared, own) < 0.5
}

/// Mean cost of a shared surface beyond what the noise of an own one accounts for: see [`is_as_good`].
pub fn excess_cost(shared: f64, own: f64) -> f64 {
    shared - 1.3 * own
}

/// Fits one type from all its starts.
pub fn fit_kind(
    kind: SurfaceKind,
    samples: &Samples,
    weights: &Weights,
    limits: &Limits,
    previous: Option<&Fit>,
) -> Option<Choice> {
    let few = samples.thinned(N_START);
    let from_previous = previous.filter(|p| p.surface.kind() == kind).copied();
    let with_cost = |fit: Fit| Choice { fit, mean_cost: mean_cost(&fit, &few, weights) };
    let mut guesses: Vec<Choice> =
        from_previous.into_iter().chain(starts(kind, &few)).map(with_cost).collect();
    guesses.sort_by(|a, b| a.mean_cost.total_cmp(&b.mean_cost));
    let start = guesses
        .iter()
        .take(N_GUESSES)
        .filter_map(|guess| refine(&guess.fit, &few, weights, START_STEPS))
        .map(with_cost)
        .min_by(|a, b| a.mean_cost.total_cmp(&b.mean_cost))?;
    let fit = refine(&start.fit, samples, weights, FINAL_STEPS)?;
    is_possible(&fit.surface, samples, limits)
        .then(|| Choice { fit, mean_cost: mean_cost(&fit, samples, weights) })
}

/// Mean of the samples' costs under a surface, each capped at [`COST_CAP`]; zero when there are none.
pub fn mean_cost(fit: &Fit, samples: &Samples, weights: &Weights) -> f64 {
    let sum: f64 =
        samples.points.iter().zip(&samples.normals).map(|(p, n)| weights.cost(fit, p, n).min(COST_CAP)).sum();
    sum / samples.points.len().max(1) as f64
}

/// Degrees of freedom that count in the comparison. A sphere is worth more than its four: see `choose`.
fn freedom(kind: SurfaceKind) -> f64 {
    match kind {
        SurfaceKind::Plane => 3.0,
        SurfaceKind::Cylinder => 5.0,
        SurfaceKind::Cone => 6.0,
        SurfaceKind::Sphere => 6.5,
        SurfaceKind::Torus => 8.0,
    }
}

/// Below this mean cost no type can be better by enough.
fn lowest_useful_gain(n: usize) -> f64 {
    0.1 + (VERTICES_PER_SAMPLE / n as f64).min(0.6)
}

/// Whether the more complex of two fits to `samples`, standing for `n` vertices, is worth its freedom and parts from the
/// other.
pub fn is_better(simple: &Choice, complex: &Choice, samples: &Samples, n: usize, limits: &Limits) -> bool {
    is_worth(simple, complex, n) && is_apart(&simple.fit, &complex.fit, samples, limits)
}

/// Whether what the more complex of two fits to `n` vertices saves is worth its freedom.
pub fn is_worth(simple: &Choice, complex: &Choice, n: usize) -> bool {
    simple.mean_cost - complex.mean_cost > penalty(simple, complex, n)
}

/// What the more complex of two fits to `n` vertices must save.
pub(super) fn penalty(simple: &Choice, complex: &Choice, n: usize) -> f64 {
    let q = freedom(complex.fit.surface.kind()) - freedom(simple.fit.surface.kind());
    let n = n as f64;
    (0.6 + 10.0 * q / n).min(VERTICES_PER_SAMPLE * q / n) + 0.1 * (1.0 + 0.3 * complex.mean_cost)
}

/// Whether the two surfaces part over the samples by more than noise: in distance, or clearly in direction.
fn is_apart(a: &Fit, b: &Fit, samples: &Samples, limits: &Limits) -> bool {
    let Departure { distance, tilt } = departure(a, b, samples);
    distance > limits.min_departure || tilt > limits.min_tilt
}

/// How far two surfaces part over some samples, but for the tenth of them where they part most.
pub(super) struct Departure {
    /// Length.
    pub distance: f64,
    /// Of the normals, radians.
    pub tilt: f64,
}

pub(super) fn departure(a: &Fit, b: &Fit, samples: &Samples) -> Departure {
    let (mut lengths, mut tilts): (Vec<f64>, Vec<f64>) = samples
        .points
        .iter()
        .map(|p| {
            let (da, na) = a.distance_and_outward_normal(p);
            let (db, nb) = b.distance_and_outward_normal(p);
            ((da - db).abs(), (na - nb).norm())
        })
        .unzip();
    let high = |values: &mut Vec<f64>| stats::quantile(values, 0.9).unwrap_or(0.0);
    Departure { distance: high(&mut lengths), tilt: high(&mut tilts) }
}

/// Whether a torus with this ratio of radii is a shape of its own and not nearly a sphere.
pub fn is_ring_or_lemon(ratio: f64) -> bool {
    const NEARLY_SPHERE: f64 = 0.1;
    ratio.abs() > NEARLY_SPHERE
}

/// Whether a scan can show this surface at all.
fn is_possible(surface: &Surface, samples: &Samples, limits: &Limits) -> bool {
    match surface {
        Surface::Plane(_) => true,
        Surface::Cylinder(s) => s.radius >= limits.min_radius,
        Surface::Sphere(s) => s.radius >= limits.min_radius,
        Surface::Torus(s) => {
            s.minor_radius >= limits.min_radius && is_ring_or_lemon(s.major_radius / s.minor_radius)
        }
        Surface::Cone(s) => {
            let heights = samples.points.iter().map(|p| s.axis.height(p));
            let (low, high) = heights.fold((f64::MAX, f64::MIN), |(lo, hi), h| (lo.min(h), hi.max(h)));
            (high - low) * s.half_angle.tan() > limits.min_taper
        }
    }
}
