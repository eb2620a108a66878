//! The primitive of a finished region: its surface fitted once more, almost by distance alone, to raw points.

use super::field::{Field, Scratch};
use super::grow::{BORDER_RINGS, MIN_INTERIOR};
use super::narrow::Rim;
use crate::fit::{Fit, Samples, Weights, refine};
use crate::math::stats;
use crate::recognize::{Primitive, ambiguity, choose};
use crate::surface::Surface;

/// Samples of the final fit: parameters no longer gain from more, the noise being correlated.
const N_SAMPLES: usize = 20_000;
/// Steps of the final fit.
const STEPS: usize = 30;
/// Weight of normals: filtered normals are biased, raw distances are not.
const NORMAL_WEIGHT: f64 = 0.02;
/// Share of a region's vertices that the fit rests on at least: a few in the middle of a narrow band would leave its
/// axis free to turn.
const MIN_INTERIOR_SHARE: f64 = 0.3;

/// A region with a surface near `fit`. `fit_of`: the surface of each vertex of the mesh.
pub(super) fn fitted(
    field: &Field,
    fit: &Fit,
    members: &[u32],
    fit_of: impl Fn(u32) -> Option<Fit>,
) -> Primitive {
    let mut scratch = Scratch::new(field.n_vertices());
    let weights = Weights { normal_weight: NORMAL_WEIGHT, ..field.weights };
    let at_least = MIN_INTERIOR.max((MIN_INTERIOR_SHARE * members.len() as f64) as usize);
    let interior = field.eroded(members, BORDER_RINGS, at_least, &mut scratch);
    let narrow = Rim::of_narrow(field, members, fit_of, &mut scratch)
        .and_then(|rim| rim.refine(field, fit, &weights, N_SAMPLES));
    let (fit, seen) = narrow.map_or_else(
        || {
            let samples = field.samples(&interior, N_SAMPLES);
            (refine(fit, &samples, &weights, STEPS).unwrap_or(*fit), samples)
        },
        |(fit, rim)| (fit, rim.samples),
    );
    let samples = without_blur(&fit.surface, seen, field.blur);
    let fit = refine(&fit, &samples, &weights, STEPS).unwrap_or(fit);
    let doubt = doubt(field, &fit, &samples, interior.len());
    Primitive { ambiguous: doubt, ..Primitive::with_evidence(fit, &samples, interior.len()) }
}

/// Why the type of a fit to `samples`, standing for `n` vertices, is not certain, if it is not.
fn doubt(field: &Field, fit: &Fit, samples: &Samples, n: usize) -> Option<String> {
    /// Samples that types are compared on: as many as they are chosen by.
    const N_COMPARED: usize = 400;
    let found = ambiguity(fit, &samples.thinned(N_COMPARED), n, &field.weights, &field.limits)?;
    Some(found.text(fit.surface.kind()))
}

/// A mesh as one region: the surface of the type that describes it best, freeform when none does.
pub(super) fn of_all(field: &Field) -> Primitive {
    /// Samples of the choice.
    const N_CHOICE: usize = 400;
    /// Deviations of the noise beyond which a surface does not describe the mesh, and the share of the vertices that lie
    /// within one deviation: outliers shall not decide.
    const MISFIT: f64 = 2.0;
    const ONE_DEVIATION: f64 = 0.683;
    let all: Vec<u32> = (0..field.n_vertices() as u32).collect();
    let samples = field.samples(&all, N_CHOICE);
    let Some(choice) = choose(&samples, all.len(), &field.weights, &field.limits, None) else {
        return Primitive::freeform();
    };
    let mut primitive = fitted(field, &choice.fit, &all, |_| None);
    let Some(surface) = primitive.surface else { return primitive };
    let mut distances: Vec<f64> = field.points.iter().map(|p| surface.signed_distance(p).abs()).collect();
    let typical = stats::quantile(&mut distances, ONE_DEVIATION).unwrap_or(0.0);
    let times = typical / field.weights.distance_sigma;
    if times > MISFIT {
        primitive.ambiguous = Some(format!("its vertices lie {times:.1} times the noise off it"));
    }
    primitive
}

/// The region of a surface that is given, not fitted: what its vertices `members` say about it.
pub(super) fn given(field: &Field, fit: &Fit, members: &[u32]) -> Primitive {
    let samples = without_blur(&fit.surface, field.samples(members, N_SAMPLES), field.blur);
    Primitive::with_evidence(*fit, &samples, members.len())
}

/// The samples where a scanner with no spot would have seen them. A distance field blurred by a spot of deviation `b`
/// grows by `b^2 / 2` times its Laplacian, which on the surface is the sum of the curvatures: every round surface is
/// seen too near to its axis or centre, by `b^2 / 2r` on cylinders and twice that on spheres, bosses and bores alike.
fn without_blur(surface: &Surface, mut samples: Samples, blur: f64) -> Samples {
    for point in &mut samples.points {
        let shift = 0.5 * blur * blur * surface.curvature_sum(point);
        // The law is the first term of a series in the blur over the radius; beyond one blur it says nothing.
        *point += surface.normal(point).into_inner() * shift.clamp(-blur, blur);
    }
    samples
}
