//! Planted truth: points sampled from known surfaces, for tests and benches.

use super::Surface;
use crate::math::{Frame, Point3, UnitVec3, Vec3};
use crate::random::Rng;

/// Which part of a surface to sample: ranges of its two natural coordinates.
///
/// Plane: in-plane coordinates (lengths). Cylinder, cone: angle (radians), height (length). Sphere: longitude,
/// latitude. Torus: angle about the axis, angle about the spine, zero outward.
#[derive(Debug, Clone, Copy)]
pub struct Patch {
    /// Range of the first coordinate.
    pub u: (f64, f64),
    /// Range of the second coordinate.
    pub v: (f64, f64),
}

/// `n` random points with natural normals on a patch of `surface`, moved along the normal by normal noise.
pub fn sample(surface: &Surface, patch: Patch, n: usize, noise: f64, seed: u64) -> Vec<(Point3, UnitVec3)> {
    let mut rng = Rng::for_task(seed, "samples", 0);
    (0..n)
        .map(|_| {
            let u = patch.u.0 + (patch.u.1 - patch.u.0) * rng.uniform();
            let v = patch.v.0 + (patch.v.1 - patch.v.0) * rng.uniform();
            let on_surface = point_at(surface, u, v);
            let normal = surface.normal(&on_surface);
            (on_surface + normal.into_inner() * (noise * rng.normal()), normal)
        })
        .collect()
}

/// The point of `surface` with natural coordinates `(u, v)`.
pub fn point_at(surface: &Surface, u: f64, v: f64) -> Point3 {
    let (sin_u, cos_u) = u.sin_cos();
    match surface {
        Surface::Plane(s) => Frame::from_z(s.point, s.normal).global(&Vec3::new(u, v, 0.0)),
        Surface::Cylinder(s) => {
            let frame = Frame::from_z(s.axis.origin, s.axis.direction);
            frame.global(&Vec3::new(s.radius * cos_u, s.radius * sin_u, v))
        }
        Surface::Cone(s) => {
            let radius = s.radius + v * s.half_angle.tan();
            Frame::from_z(s.axis.origin, s.axis.direction).global(&Vec3::new(
                radius * cos_u,
                radius * sin_u,
                v,
            ))
        }
        Surface::Sphere(s) => {
            let (sin_v, cos_v) = v.sin_cos();
            s.center + Vec3::new(cos_u * cos_v, sin_u * cos_v, sin_v) * s.radius
        }
        Surface::Torus(s) => {
            let (sin_v, cos_v) = v.sin_cos();
            let radius = s.major_radius + s.minor_radius * cos_v;
            let frame = Frame::from_z(s.axis.origin, s.axis.direction);
            frame.global(&Vec3::new(radius * cos_u, radius * sin_u, s.minor_radius * sin_v))
        }
    }
}
