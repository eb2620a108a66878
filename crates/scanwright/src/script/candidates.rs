//! The sweeps worth trying: along the directions that faces share, about the axes they share.

use super::body::Body;
use super::sweep::{Motion, Sweep};
use crate::brep::Geometry;
use crate::math::{Axis, Frame, Point3, UnitVec3, Vec3, try_unit};
use crate::surface::Surface;
use crate::tolerance::Tolerances;

/// Directions tried, those with most area first; the rest seldom carry a profile.
const MOST_DIRECTIONS: usize = 12;
/// Axes tried.
const MOST_AXES: usize = 40;

/// A direction or axis with the area of its faces.
struct Weighted<T> {
    value: T,
    area: f64,
}

/// The frame of the part, and the sweeps in order of area: along its directions first, then about its axes.
///
/// Directions that differ by less than `tolerance` over the part are one, and those nearly perpendicular are made so:
/// a script that says 89.98 degrees says nothing that the scan shows.
pub(super) fn sweeps(body: &Body, tolerance: f64) -> Vec<Sweep> {
    let size = (body.bounds.1 - body.bounds.0).norm();
    let angle = (2.0 * tolerance / size).max(MIN_ANGLE);
    let directions = directions(body, angle);
    let Some(main) = directions.first().copied() else { return Vec::new() };
    let middle = nalgebra::center(&body.bounds.0, &body.bounds.1);
    let own = own_frame(middle, main, &directions);
    let frame = |origin: Point3, z: UnitVec3| turned_to(&own, origin, z);
    let along = directions
        .iter()
        .take(MOST_DIRECTIONS)
        .map(|z| Sweep { motion: Motion::Along, frame: frame(middle, *z) });
    let axes = axes(body, &directions, tolerance, angle);
    let around = axes
        .iter()
        .take(MOST_AXES)
        .map(|a| Sweep { motion: Motion::Around, frame: frame(a.foot(&middle), a.direction) });
    along.chain(around).collect()
}

/// The frame of the part: its first direction upward, the next one across it beside.
fn own_frame(origin: Point3, z: UnitVec3, directions: &[UnitVec3]) -> Frame {
    match directions.iter().find(|d| d.dot(&z).abs() < Tolerances::SAME) {
        Some(x) => Frame { origin, x: *x, y: UnitVec3::new_normalize(z.cross(x)), z },
        None => Frame::from_z(origin, z),
    }
}

/// A frame with a third direction whose others are those of the part in turn, so that the coordinates of all profiles
/// are lengths along its faces.
fn turned_to(own: &Frame, origin: Point3, z: UnitVec3) -> Frame {
    let axes = [own.x, own.y, own.z];
    for i in 0..3 {
        if axes[i].dot(&z).abs() > 1.0 - Tolerances::SAME {
            let (z, x, y) = (axes[i], axes[(i + 1) % 3], axes[(i + 2) % 3]);
            return Frame { origin, x, y, z };
        }
    }
    let across = axes.iter().find(|a| a.dot(&z).abs() < Tolerances::SAME).copied();
    match across.or_else(|| try_unit(z.cross(&own.z))) {
        Some(x) => Frame { origin, x, y: UnitVec3::new_normalize(z.cross(&x)), z },
        None => Frame::from_z(origin, z),
    }
}

/// Radians below which two directions are one however long the part: form deviations are larger.
const MIN_ANGLE: f64 = 0.005;

/// Directions of planes and axes, those of most area first.
fn directions(body: &Body, angle: f64) -> Vec<UnitVec3> {
    let mut found: Vec<Weighted<Vec3>> = Vec::new();
    let faces = (0..body.solid.faces.len()).filter_map(|f| {
        let Geometry::Analytic(surface) = body.solid.geometry(&body.solid.faces[f]) else { return None };
        let direction = match surface {
            Surface::Plane(s) => s.normal,
            other => other.axis()?.direction,
        };
        Some((direction.into_inner(), body.area(f)))
    });
    let mut faces: Vec<(Vec3, f64)> = faces.collect();
    faces.sort_by(|a, b| b.1.total_cmp(&a.1));
    for (direction, area) in faces {
        let known = found.iter_mut().find(|w| w.value.normalize().cross(&direction).norm() <= angle);
        if let Some(known) = known {
            let sign = known.value.dot(&direction).signum();
            known.value += direction * (sign * area);
            known.area += area;
        } else {
            found.push(Weighted { value: direction * area, area });
        }
    }
    found.sort_by(|a, b| b.area.total_cmp(&a.area));
    let mut made: Vec<UnitVec3> = Vec::new();
    for weighted in found {
        let mut direction = without_sign(&weighted.value.normalize());
        for _ in 0..2 {
            for known in &made {
                let along = direction.dot(known);
                if along.abs() <= angle {
                    direction = (direction - known.into_inner() * along).normalize();
                }
            }
        }
        made.push(UnitVec3::new_normalize(direction));
    }
    made
}

/// Axes of revolution, those of most area first.
fn axes(body: &Body, directions: &[UnitVec3], tolerance: f64, angle: f64) -> Vec<Axis> {
    let mut found: Vec<Weighted<Axis>> = Vec::new();
    let mut faces: Vec<(usize, f64)> = (0..body.solid.faces.len()).map(|f| (f, body.area(f))).collect();
    faces.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut spheres = Vec::new();
    for (f, area) in faces {
        let Geometry::Analytic(surface) = body.solid.geometry(&body.solid.faces[f]) else { continue };
        if let Surface::Sphere(sphere) = surface {
            spheres.push((sphere.center, area));
        }
        let Some(axis) = surface.axis() else { continue };
        let direction = directions.iter().find(|d| d.cross(&axis.direction).norm() <= angle);
        let Some(direction) = direction.copied() else { continue };
        let origin = axis.foot(&crate::math::centroid(&body.points(f)));
        let known = found
            .iter_mut()
            .find(|w| w.value.direction == direction && w.value.radial(&origin).norm() <= tolerance);
        if let Some(known) = known {
            let shift = known.value.radial(&origin) * (area / (known.area + area));
            known.value.origin += shift;
            known.area += area;
        } else {
            found.push(Weighted { value: Axis { origin, direction }, area });
        }
    }
    // A sphere on no axis turns about the first direction.
    for (center, area) in spheres {
        let is_on = found.iter().any(|w| w.value.radial(&center).norm() <= tolerance);
        if let (false, Some(direction)) = (is_on, directions.first()) {
            found.push(Weighted { value: Axis { origin: center, direction: *direction }, area });
        }
    }
    found.sort_by(|a, b| b.area.total_cmp(&a.area));
    found.into_iter().map(|w| w.value).collect()
}

/// A direction up to its sign: the one whose largest component is positive.
fn without_sign(direction: &Vec3) -> Vec3 {
    if direction[direction.iamax()] < 0.0 { -direction } else { *direction }
}
