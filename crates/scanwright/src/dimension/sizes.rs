//! Diameters, radii and angles of single faces.

use std::f64::consts::PI;

use super::known::Known;
use super::{Dimension, DimensionKind, dimension};
use crate::surface::Surface;

/// Turn below which a round face hardly shows its radius, radians: at 60 degrees the uncertainty of a radius is some ten times
/// that of the whole turn with as many points.
const SHORT_ARC: f64 = PI / 3.0;

/// The sizes of all primitives.
pub(super) fn of(known: &[Known]) -> Vec<Dimension> {
    known.iter().flat_map(of_one).collect()
}

fn of_one(known: &Known) -> Vec<Dimension> {
    let named = |kind: DimensionKind, name: &str, value: f64, times: f64| {
        let variance = known.variance(name)? * times * times;
        let mut size = dimension(kind, &[known], value * times, variance);
        size.guess = guess(known);
        Some(size)
    };
    // More than half of it is gripped by a calliper: a diameter.
    let is_gripped = known.arc.is_some_and(|arc| match &known.surface {
        Surface::Sphere(_) => arc > 0.5 * PI,
        _ => arc > PI,
    });
    let round = |radius: f64| {
        if is_gripped {
            named(DimensionKind::Diameter, "radius", radius, 2.0)
        } else {
            named(DimensionKind::Radius, "radius", radius, 1.0)
        }
    };
    let sizes = match &known.surface {
        Surface::Plane(_) => [None, None],
        Surface::Cylinder(s) => [round(s.radius), None],
        Surface::Sphere(s) => [round(s.radius), None],
        Surface::Cone(s) => [named(DimensionKind::HalfAngle, "half_angle", s.half_angle, 1.0), None],
        Surface::Torus(s) => [
            named(DimensionKind::MajorRadius, "major_radius", s.major_radius.abs(), 1.0),
            named(DimensionKind::MinorRadius, "minor_radius", s.minor_radius, 1.0),
        ],
    };
    sizes.into_iter().flatten().collect()
}

fn guess(known: &Known) -> Option<String> {
    if known.ambiguous {
        return Some("the type of its face is not certain".to_owned());
    }
    let arc = known.arc.filter(|arc| *arc < SHORT_ARC)?;
    Some(format!("only {:.0} degrees of it were seen", arc.to_degrees()))
}
