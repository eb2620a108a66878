//! PGP2X: the thesis's estimation of parameters, by principal directions and profiles.
//!
//! "Extracting Structured Models From Raw Scans of Manufactured Objects" (2015). Known of it: that it rests on principal
//! component analysis, improves known methods for cylinder, cone and sphere, and is new for the torus, complete and
//! partial. Reconstructed, by the titles of its figures: every step here. Planes by the points' principal directions;
//! spheres and cylinders by an algebraic fit that Gauss and Newton refine; cones by the plane through the normals; tori by
//! the distances to the plane across the axis, and circles through the rings of points that these single out.

use nalgebra::Vector2;

use super::closed::{algebraic_sphere, circle_axis, cone, plane, tips};
use super::{Samples, by_least_squares};
use crate::math::{Axis, Frame, Point3, UnitVec3, Vec3, centroid, fitted_circle, principal_axes, stats};
use crate::surface::{Cylinder, Surface, SurfaceKind, Torus};

/// The surface of `kind` through the samples; `None` where they do not show one.
pub(super) fn pgp2x(kind: SurfaceKind, samples: &Samples) -> Option<Surface> {
    match kind {
        SurfaceKind::Plane => Some(Surface::Plane(plane(samples))),
        SurfaceKind::Sphere => sphere(samples),
        SurfaceKind::Cylinder => cylinder(samples).map(Surface::Cylinder),
        SurfaceKind::Cone => cone(samples).map(Surface::Cone),
        SurfaceKind::Torus => torus(samples).map(Surface::Torus),
    }
}

/// The algebraic sphere, refined by the distances.
fn sphere(samples: &Samples) -> Option<Surface> {
    let start = Surface::Sphere(algebraic_sphere(&samples.points)?);
    by_least_squares(&start, samples)
}

/// The axis along the normals' least principal direction; the circle of the points seen along it.
fn cylinder(samples: &Samples) -> Option<Cylinder> {
    let frame = Frame::from_z(centroid(&samples.points), circle_axis(samples).0);
    let flat: Vec<Vector2<f64>> = samples.points.iter().map(|p| frame.local(p).xy()).collect();
    let (center, radius) = fitted_circle(&flat)?;
    let (low, high) = range(samples.points.iter().map(|p| frame.local(p).z));
    let middle = Vec3::new(center.x, center.y, 0.5 * (low + high));
    Some(Cylinder { axis: Axis { origin: frame.global(&middle), direction: frame.z }, radius })
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// The torus about the principal direction whose rings are the best circles.
fn torus(samples: &Samples) -> Option<Torus> {
    let center = centroid(&samples.points);
    let of_points = principal_axes(&samples.points, center).map(|pair| pair.1);
    let of_normals = principal_axes(&tips(samples), Point3::origin()).map(|pair| pair.1);
    let tori = of_points.into_iter().chain(of_normals).filter_map(|axis| torus_about(samples, center, axis));
    let off = |t: &Torus| {
        let mut off: Vec<f64> = samples.points.iter().map(|p| t.signed_distance(p).abs()).collect();
        stats::median(&mut off).unwrap_or(f64::INFINITY)
    };
    tori.map(|t| (off(&t), t)).min_by(|a, b| a.0.total_cmp(&b.0)).map(|found| found.1)
}

/// The torus about a direction: where the normals are along it, top and bottom, the points are a ring of the major radius,
/// a minor radius above or below the spine; where they are across it, inside and outside, rings of the difference and the
/// sum of both.
fn torus_about(samples: &Samples, center: Point3, direction: UnitVec3) -> Option<Torus> {
    /// Sine of the tilt up to which a normal counts as along or across the axis: a twelfth of the tube's turn each way.
    const TILT: f64 = 0.26;
    const FEWEST: usize = 12;
    let frame = Frame::from_z(center, direction);
    let mut rings: [Vec<Vec3>; 4] = Default::default();
    for (p, n) in samples.points.iter().zip(&samples.normals) {
        let along = n.dot(&direction);
        let local = frame.local(p);
        let ring = if along > (1.0 - TILT * TILT).sqrt() {
            0
        } else if along < -(1.0 - TILT * TILT).sqrt() {
            1
        } else if along.abs() < TILT {
            // Which of the two a point is on shows once the centre is known.
            2
        } else {
            3
        };
        rings[ring].push(local);
    }
    let fit = |ring: &Vec<Vec3>| -> Option<(Vector2<f64>, f64, f64)> {
        if ring.len() < FEWEST {
            return None;
        }
        let flat: Vec<Vector2<f64>> = ring.iter().map(nalgebra::Matrix::xy).collect();
        let (at, radius) = fitted_circle(&flat)?;
        let mut heights: Vec<f64> = ring.iter().map(|q| q.z).collect();
        Some((at, radius, stats::median(&mut heights)?))
    };
    let (top, bottom) = (fit(&rings[0]), fit(&rings[1]));
    let at = top.or(bottom).map(|ring| ring.0).or_else(|| middle_of(&rings[2]))?;
    let middles = split_by_radius(&rings[2], at);
    let [inner, outer] = middles.map(|ring| fit(&ring));
    let level = |ring: Option<(Vector2<f64>, f64, f64)>| ring.map(|r| r.2);
    let (major_radius, minor_radius, height) = match (top, bottom, inner, outer) {
        (Some(t), Some(b), ..) => (0.5 * (t.1 + b.1), 0.5 * (t.2 - b.2).abs(), 0.5 * (t.2 + b.2)),
        (.., Some(i), Some(o)) => {
            (0.5 * (i.1 + o.1), 0.5 * (o.1 - i.1).abs(), 0.5 * (level(inner)? + level(outer)?))
        }
        (Some(ring), None, ..) | (None, Some(ring), ..) => {
            let side = inner.or(outer)?;
            (ring.1, (side.1 - ring.1).abs(), side.2)
        }
        // One side of the tube alone: its bend shows in the heights of the rest.
        (None, None, i, o) => one_sided(samples, &frame, at, i.or(o)?)?,
    };
    let is_ring =
        major_radius.is_finite() && minor_radius.is_finite() && minor_radius > 0.0 && major_radius > 0.0;
    let origin = frame.global(&Vec3::new(at.x, at.y, height));
    is_ring.then_some(Torus { axis: Axis { origin, direction }, major_radius, minor_radius })
}

/// Centre of the circle through all points where the normals are across the axis.
fn middle_of(ring: &[Vec3]) -> Option<Vector2<f64>> {
    let flat: Vec<Vector2<f64>> = ring.iter().map(nalgebra::Matrix::xy).collect();
    fitted_circle(&flat).map(|circle| circle.0)
}

/// Points nearer to `at` than halfway between the nearest and the farthest, and the others; all in the second where there
/// is no gap.
fn split_by_radius(ring: &[Vec3], at: Vector2<f64>) -> [Vec<Vec3>; 2] {
    let (low, high) = range(ring.iter().map(|q| (q.xy() - at).norm()));
    let half = 0.5 * (low + high);
    let (inner, outer): (Vec<Vec3>, Vec<Vec3>) = ring.iter().partition(|q| (q.xy() - at).norm() < half);
    let spread = |side: &[Vec3]| {
        let (low, high) = range(side.iter().map(|q| (q.xy() - at).norm()));
        high - low
    };
    // Two rings lie farther apart than each is wide.
    let is_two =
        !inner.is_empty() && !outer.is_empty() && spread(&inner).max(spread(&outer)) < 0.5 * (high - low);
    if is_two { [inner, outer] } else { [Vec::new(), ring.to_vec()] }
}

/// Radii and height of a torus of which only the inner or outer side is seen, whose extreme ring has this centre, radius
/// and height: the circle through the profile.
fn one_sided(
    samples: &Samples,
    frame: &Frame,
    at: Vector2<f64>,
    side: (Vector2<f64>, f64, f64),
) -> Option<(f64, f64, f64)> {
    let profile: Vec<Vector2<f64>> = samples
        .points
        .iter()
        .map(|p| frame.local(p))
        .map(|q| Vector2::new((q.xy() - at).norm(), q.z))
        .collect();
    let (center, radius) = fitted_circle(&profile)?;
    let is_beside = (center.x - side.1).abs() < 2.0 * radius;
    is_beside.then_some((center.x, radius, center.y))
}
