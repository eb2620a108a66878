//! Surfaces in closed form from points and normals of one region, without iteration over the surface.
//!
//! The pieces that the baselines share: principal directions of points and of normals, the algebraic sphere and circle,
//! and the apex of a cone. M. Attene, B. Falcidieno, M. Spagnuolo, "Hierarchical mesh segmentation based on fitting
//! primitives", The Visual Computer 22 (2006), 181-193, section 3, for plane, sphere and cylinder; the cone is fitted
//! likewise, the torus not at all.

use nalgebra::{Matrix4, Vector4};

use super::Samples;
use crate::math::{Axis, Frame, Mat3, Point3, UnitVec3, Vec3, centroid, nearest_circle, principal_axes};
use crate::surface::{Cone, Cylinder, Plane, Sphere, Surface, SurfaceKind};

/// The fits of Attene and others: `None` for a torus, and where the samples do not show the surface.
pub(super) fn attene(kind: SurfaceKind, samples: &Samples) -> Option<Surface> {
    match kind {
        SurfaceKind::Plane => Some(Surface::Plane(plane(samples))),
        SurfaceKind::Sphere => algebraic_sphere(&samples.points).map(Surface::Sphere),
        SurfaceKind::Cylinder => {
            let frame = Frame::from_z(centroid(&samples.points), circle_axis(samples).0);
            let flat = samples.points.iter().map(|p| frame.local(p)).map(|q| (1.0, q.x, q.y));
            let ([x, y], radius) = nearest_circle(flat)?;
            let axis = Axis { origin: frame.global(&Vec3::new(x, y, 0.0)), direction: frame.z };
            Some(Surface::Cylinder(Cylinder { axis, radius }))
        }
        SurfaceKind::Cone => cone(samples).map(Surface::Cone),
        SurfaceKind::Torus => None,
    }
}

/// The plane across the least principal direction of the points.
pub(super) fn plane(samples: &Samples) -> Plane {
    let point = centroid(&samples.points);
    let [(_, normal), ..] = principal_axes(&samples.points, point);
    let along: f64 = samples.normals.iter().map(|n| n.dot(&normal)).sum();
    Plane { point, normal: if along < 0.0 { -normal } else { normal } }
}

/// The sphere with the least squares of `|p|^2 - 2 c.p - (r^2 - |c|^2)`. Caps give radii that are too small.
pub(super) fn algebraic_sphere(points: &[Point3]) -> Option<Sphere> {
    let mean = centroid(points);
    let (mut matrix, mut right) = (Matrix4::zeros(), Vector4::zeros());
    for point in points {
        let p = point - mean;
        let row = Vector4::new(2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 1.0);
        matrix += row * row.transpose();
        right += row * p.norm_squared();
    }
    let found = matrix.try_inverse()? * right;
    let center = found.xyz();
    let radius = (found.w + center.norm_squared()).sqrt();
    (radius.is_finite() && radius > 0.0).then_some(Sphere { center: mean + center, radius })
}

/// The axis of the circle that the normals lie on, and how high it lies above the sphere's centre: the sine of a cone's
/// half-angle, signed along the axis.
pub(super) fn circle_axis(samples: &Samples) -> (UnitVec3, f64) {
    let tips = tips(samples);
    let mean = centroid(&tips);
    let [(_, axis), ..] = principal_axes(&tips, mean);
    (axis, mean.coords.dot(&axis))
}

/// The normals as points of the unit sphere.
pub(super) fn tips(samples: &Samples) -> Vec<Point3> {
    samples.normals.iter().map(|n| Point3::from(*n)).collect()
}

/// Axis and half-angle from the circle of the normals, the apex where their planes meet.
pub(super) fn cone(samples: &Samples) -> Option<Cone> {
    let (mut direction, mut offset) = circle_axis(samples);
    let center = centroid(&samples.points);
    // Every tangent plane n.(p - v) = 0 holds the apex v.
    let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
    for (p, n) in samples.points.iter().zip(&samples.normals) {
        matrix += n * n.transpose();
        right += n * n.dot(&(p - center));
    }
    let apex = center + matrix.try_inverse()? * right;
    // The axis runs from the apex into the cone, where the radius grows.
    if (center - apex).dot(&direction) < 0.0 {
        (direction, offset) = (-direction, -offset);
    }
    let half_angle = offset.abs().min(1.0).asin();
    let height = (center - apex).dot(&direction);
    let radius = height * half_angle.tan();
    let axis = Axis { origin: apex + direction.into_inner() * height, direction };
    (radius.is_finite() && radius > 0.0 && half_angle > 0.0).then_some(Cone { axis, radius, half_angle })
}
