//! Faces whose blunt ends were taken for curvature.
//!
//! The spot rounds a face off along its border; a barrel then describes a short cylinder, rounded ends and all, better
//! than a cylinder does, and a disc becomes a cap. Deep inside no rounding reaches, and what it can do along the border
//! is known: a right angle that the spot rounds recedes by the closed form of `math::blur`. A simpler surface that the
//! inside shows, and that explains the rest but for what rounding may have taken off or filled in, is the surface.

use super::field::{Field, Scratch};
use super::finish::Regions;
use crate::fit::Fit;
use crate::math::blur::blurred_magnitude;
use crate::par;
use crate::recognize::{COST_CAP, Choice, TYPE_ORDER, fit_kind, is_worth};

/// Share of the vertices that lie deep inside, at least: else nothing tells rounding from curvature.
const MIN_DEEP_SHARE: f64 = 0.25;
/// Fewer vertices deep inside show no surface.
const MIN_DEEP: usize = 25;
/// Samples of a fit.
const N_SAMPLES: usize = 400;

/// Gives regions the simplest type that their insides show.
pub(super) fn retype(field: &Field, regions: &mut Regions) {
    let members = regions.members();
    let fits = par::map_indices(members.len(), |k| {
        let fit = regions.fits[k]?;
        Some(simpler(field, &members[k], &fit).map_or(fit, |choice| choice.fit))
    });
    regions.fits = fits;
}

/// A simpler surface than `complex` that explains the face but for rounded ends.
fn simpler(field: &Field, members: &[u32], complex: &Fit) -> Option<Choice> {
    let reach = (2.0 * field.blur / field.spacing).ceil() as usize;
    if field.blur <= 0.0 || complex.surface.kind() == TYPE_ORDER[0] {
        return None;
    }
    let depths = field.depths(members, reach + 1, true, &mut Scratch::new(field.n_vertices()));
    let deep: Vec<u32> =
        members.iter().zip(&depths).filter(|(_, d)| usize::from(**d) >= reach).map(|(v, _)| *v).collect();
    if deep.len() < MIN_DEEP || (deep.len() as f64) < MIN_DEEP_SHARE * members.len() as f64 {
        return None;
    }
    let samples = field.samples(&deep, N_SAMPLES);
    let with_cost = |fit: Fit| Choice { fit, mean_cost: blunt_cost(field, &fit, members, &depths) };
    let complex = with_cost(*complex);
    TYPE_ORDER.into_iter().take_while(|kind| *kind < complex.fit.surface.kind()).find_map(|kind| {
        let inside = fit_kind(kind, &samples, &field.weights, &field.limits, None)?;
        let simple = with_cost(inside.fit);
        (!is_worth(&simple, &complex, members.len())).then_some(simple)
    })
}

/// Mean cost of the distances beyond what the rounding of a right angle accounts for.
fn blunt_cost(field: &Field, fit: &Fit, members: &[u32], depths: &[u8]) -> f64 {
    // A border may lie as far beyond the edge as the rounding reaches; what lies outside it speaks of the neighbour.
    let off = field.blur / field.spacing;
    let recess = |t: f64| 0.5 * (blurred_magnitude(t, field.blur * std::f64::consts::SQRT_2).0 - t);
    let cost = |(v, depth): (&u32, &u8)| {
        let inside = f64::from(*depth) - off;
        let distance = fit.surface.signed_distance(&field.points[*v as usize]).abs();
        let beyond = (distance - recess(inside * field.spacing)).max(0.0);
        (inside > 0.0).then(|| (beyond / field.weights.distance_sigma).powi(2).min(COST_CAP))
    };
    let costs: Vec<f64> = members.iter().zip(depths).filter_map(cost).collect();
    costs.iter().sum::<f64>() / costs.len().max(1) as f64
}
