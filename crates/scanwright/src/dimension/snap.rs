//! Round values in place of measured ones.

use super::{Dimension, DimensionKind};
use crate::segment::Segmentation;
use crate::surface::{Plane, Surface};
use crate::tolerance::Tolerances;

/// The segmentation with the round values that were offered in place of the measured ones where that leaves nothing else
/// undone: diameters, half-angles, and distances of planes from the largest of their direction. Each decision is noted in
/// its dimension. Covariances stay: they say how well the part was measured.
#[must_use]
pub fn snapped(segmentation: &Segmentation, dimensions: &mut [Dimension]) -> Segmentation {
    let mut snapped = segmentation.clone();
    for dimension in dimensions {
        let (kind, value, of) = (dimension.kind, dimension.value, dimension.of.clone());
        let Some(nominal) = &mut dimension.nominal else { continue };
        let outcome = if dimension.guess.is_some() {
            Err("what was measured is a guess")
        } else {
            apply(&mut snapped, kind, &of, value, nominal.value)
        };
        nominal.applied = outcome.is_ok();
        outcome.map_or_else(|why| why, |()| "applied").clone_into(&mut nominal.why);
    }
    snapped
}

fn apply(
    segmentation: &mut Segmentation,
    kind: DimensionKind,
    of: &[u32],
    measured: f64,
    nominal: f64,
) -> Result<(), &'static str> {
    let surface = |segmentation: &Segmentation, k: usize| segmentation.primitives[of[k] as usize].surface;
    match kind {
        DimensionKind::Diameter => match &mut segmentation.primitives[of[0] as usize].surface {
            Some(Surface::Cylinder(s)) => s.radius = 0.5 * nominal,
            Some(Surface::Sphere(s)) => s.radius = 0.5 * nominal,
            _ => return Err("not a round face"),
        },
        DimensionKind::HalfAngle => match &mut segmentation.primitives[of[0] as usize].surface {
            // The radius stays where the cone's place is given.
            Some(Surface::Cone(s)) => s.half_angle = nominal,
            _ => return Err("not a cone"),
        },
        DimensionKind::Distance => {
            let (Some(Surface::Plane(datum)), Some(Surface::Plane(level))) =
                (surface(segmentation, 0), surface(segmentation, 1))
            else {
                return Err("not two planes");
            };
            move_level(segmentation, &datum, &level, nominal - measured);
        }
        DimensionKind::Radius | DimensionKind::MajorRadius | DimensionKind::MinorRadius => {
            return Err("its neighbours may be tangent to it");
        }
        DimensionKind::Thickness | DimensionKind::Width | DimensionKind::Depth => {
            return Err("it follows from the distances from the datum");
        }
        DimensionKind::AxisDistance | DimensionKind::AxisToPlane | DimensionKind::Angle => {
            return Err("places and directions stay as measured");
        }
    }
    Ok(())
}

/// Moves all planes that are one with `level` away from `datum` by `by`.
fn move_level(segmentation: &mut Segmentation, datum: &Plane, level: &Plane, by: f64) {
    // Relations make planes one to rounding.
    const ONE: f64 = Tolerances::SAME;
    let away = datum.signed_distance(&level.point).signum();
    let motion = datum.normal.into_inner() * (away * by);
    let scale = level.point.coords.amax().max(datum.point.coords.amax());
    let is_one = |plane: &Plane| {
        plane.normal.cross(&level.normal).norm() < ONE
            && level.signed_distance(&plane.point).abs() < ONE * scale
    };
    for primitive in &mut segmentation.primitives {
        if let Some(Surface::Plane(plane)) = &mut primitive.surface
            && is_one(plane)
        {
            plane.point += motion;
        }
    }
}
