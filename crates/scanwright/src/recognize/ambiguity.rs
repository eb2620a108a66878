//! Whether the type of a surface is certain, and what would make it so.
//!
//! Model selection answers always; near its threshold the answer is a toss. A type is ambiguous when another would have
//! been taken, had the evidence been half or twice what it is. What is missing is told by how the two surfaces part:
//! their distance grows with the square of the arc, or of the length, that is seen.

use super::choose::{Choice, Limits, TYPE_ORDER, departure, fit_kind, mean_cost, penalty};
use crate::fit::{Fit, Samples, Weights};
use crate::surface::SurfaceKind;

/// The type that the data nearly show as well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ambiguity {
    /// The type.
    pub rival: SurfaceKind,
    /// Largest distance of the two surfaces over what is seen, but for the last tenth; length.
    pub apart: f64,
    /// What that distance must be for the data to tell; length.
    pub needed: f64,
}

impl Ambiguity {
    /// One sentence.
    pub fn text(&self, kind: SurfaceKind) -> String {
        let Self { rival, apart, needed } = self;
        let more = (needed / apart.max(f64::MIN_POSITIVE)).sqrt();
        let advice = if more > MUCH_MORE {
            "a far wider part of it must be seen".to_owned()
        } else {
            format!("about {more:.1} times the arc or length must be seen")
        };
        let (kind, rival) = (kind.name(), rival.name());
        format!(
            "it may be a {rival} rather than a {kind}: over what was seen they part by {apart:.2e}; {advice}"
        )
    }
}

/// From here on it makes no sense to say how much more must be seen.
const MUCH_MORE: f64 = 5.0;

/// The strongest rival of the type of `fit`, chosen for `samples` that stand for `n` vertices; `None` when it is certain.
pub fn ambiguity(
    fit: &Fit,
    samples: &Samples,
    n: usize,
    weights: &Weights,
    limits: &Limits,
) -> Option<Ambiguity> {
    /// Evidence over what the choice asks for, or the inverse, up to which the choice is a toss: with many vertices, and
    /// what each of few adds to it.
    const TOSS: f64 = 2.0;
    const OF_FEW: f64 = 150.0;
    let toss = TOSS + OF_FEW / n.max(1) as f64;
    let kind = fit.surface.kind();
    let chosen = Choice { fit: *fit, mean_cost: mean_cost(fit, samples, weights) };
    let rank = |kind| TYPE_ORDER.iter().position(|k| *k == kind);
    let evidence = |rival: &Choice| {
        let (simple, complex) =
            if rank(rival.fit.surface.kind()) < rank(kind) { (rival, &chosen) } else { (&chosen, rival) };
        let gain = (simple.mean_cost - complex.mean_cost) / penalty(simple, complex, n);
        let parts = departure(&simple.fit, &complex.fit, samples);
        let apart = (parts.distance / limits.min_departure).max(parts.tilt / limits.min_tilt);
        (gain.min(apart), parts.distance, rank(rival.fit.surface.kind()) < rank(kind))
    };
    // What a scan cannot show may yet be what it is.
    let anything = Limits { min_radius: 0.0, min_taper: 0.0, ..*limits };
    let rivals = TYPE_ORDER.iter().filter(|k| **k != kind).filter_map(|k| {
        let rival = fit_kind(*k, samples, weights, &anything, None)?;
        let (strength, apart, is_simpler) = evidence(&rival);
        let closeness = if is_simpler { 1.0 / strength.max(f64::MIN_POSITIVE) } else { strength };
        let needed = TOSS * limits.min_departure;
        (closeness * toss > 1.0).then_some((closeness, Ambiguity { rival: *k, apart, needed }))
    });
    rivals.max_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Point3, Vec3};
    use crate::random::Rng;
    use crate::recognize::choose;

    const RADIUS: f64 = 20.0;
    const SIGMA: f64 = 0.05;

    /// A wall of a cylinder of some arc, in radians, a spacing apart, under noise.
    fn wall(arc: f64) -> Samples {
        let mut rng = Rng::for_task(1, "ambiguity", 0);
        let mut samples = Samples::default();
        let n_round = (arc * RADIUS).ceil() as usize;
        for (i, j) in (0..=n_round).flat_map(|i| (0..20).map(move |j| (i, j))) {
            let (sin, cos) = (arc * i as f64 / n_round as f64).sin_cos();
            let normal = Vec3::new(cos, sin, 0.0);
            let off = RADIUS + SIGMA * rng.normal();
            samples.points.push(Point3::new(off * cos, off * sin, f64::from(j)));
            samples.normals.push(normal);
        }
        samples
    }

    fn verdict(arc_deg: f64) -> (SurfaceKind, Option<Ambiguity>) {
        let samples = wall(arc_deg.to_radians());
        let weights = Weights { distance_sigma: SIGMA, normal_sigma: 0.1, normal_weight: 0.5 };
        let limits = Limits { min_radius: 1.6, min_taper: 0.7, min_departure: 1.5 * SIGMA, min_tilt: 0.1 };
        let n = samples.points.len();
        let choice = choose(&samples, n, &weights, &limits, None).expect("a type");
        (choice.fit.surface.kind(), ambiguity(&choice.fit, &samples, n, &weights, &limits))
    }

    #[test]
    fn a_long_arc_is_certain_and_a_short_one_is_not() {
        for arc in [90.0, 180.0, 340.0] {
            assert_eq!(verdict(arc), (SurfaceKind::Cylinder, None), "{arc} degrees");
        }
        // Where the answer turns from plane to cylinder, there is an arc at which either is called ambiguous.
        let mut kinds = Vec::new();
        let mut between = Vec::new();
        for arc in (4..40).map(f64::from) {
            let (kind, doubt) = verdict(arc);
            kinds.push(kind);
            if let Some(doubt) = doubt {
                between.push((arc, kind, doubt.rival));
                assert!(doubt.text(kind).contains(doubt.rival.name()));
            }
        }
        assert_eq!((kinds[0], kinds[kinds.len() - 1]), (SurfaceKind::Plane, SurfaceKind::Cylinder));
        let turns = kinds.iter().position(|k| *k == SurfaceKind::Cylinder).expect("it turns");
        let toss = |arc: f64, kind, rival| between.contains(&(arc, kind, rival));
        assert!(toss(4.0 + turns as f64, SurfaceKind::Cylinder, SurfaceKind::Plane), "{turns}: {between:?}");
        assert!(toss(3.0 + turns as f64, SurfaceKind::Plane, SurfaceKind::Cylinder), "{turns}: {between:?}");
    }
}
