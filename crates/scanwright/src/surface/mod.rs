//! The five analytic surfaces, unbounded: distance, normal, projection, rigid and scaling maps.
//!
//! Every surface has a *natural* normal, the gradient of its signed distance: the normal of a plane, away from the
//! axis of a cylinder or cone, away from the centre of a sphere, away from the tube's spine of a torus.

pub mod bspline;
mod cone;
mod cylinder;
mod jet;
mod plane;
pub mod samples;
mod sphere;
mod torus;

pub use cone::Cone;
pub use cylinder::Cylinder;
pub use jet::Jet;
pub use plane::Plane;
pub use sphere::Sphere;
pub use torus::Torus;

use crate::math::{Axis, Point3, Pose, UnitVec3, Vec3};

/// The type of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SurfaceKind {
    /// Flat.
    Plane,
    /// Right circular cylinder.
    Cylinder,
    /// Right circular cone.
    Cone,
    /// Sphere.
    Sphere,
    /// Ring torus, or the lemon of a spindle torus.
    Torus,
}

impl SurfaceKind {
    /// All kinds, simplest first.
    pub const ALL: [Self; 5] = [Self::Plane, Self::Cylinder, Self::Cone, Self::Sphere, Self::Torus];

    /// Name for people and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plane => "plane",
            Self::Cylinder => "cylinder",
            Self::Cone => "cone",
            Self::Sphere => "sphere",
            Self::Torus => "torus",
        }
    }

    /// Number of parameters that position and shape a surface of this kind.
    pub fn degrees_of_freedom(self) -> usize {
        match self {
            Self::Plane => 3,
            Self::Sphere => 4,
            Self::Cylinder => 5,
            Self::Cone => 6,
            Self::Torus => 7,
        }
    }
}

/// An analytic surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Surface {
    /// See [`Plane`].
    Plane(Plane),
    /// See [`Cylinder`].
    Cylinder(Cylinder),
    /// See [`Cone`].
    Cone(Cone),
    /// See [`Sphere`].
    Sphere(Sphere),
    /// See [`Torus`].
    Torus(Torus),
}

/// Calls the method of the same name on whichever surface it is.
macro_rules! each {
    ($surface:expr, $s:ident => $call:expr) => {
        match $surface {
            Surface::Plane($s) => $call,
            Surface::Cylinder($s) => $call,
            Surface::Cone($s) => $call,
            Surface::Sphere($s) => $call,
            Surface::Torus($s) => $call,
        }
    };
}
use each;

impl Surface {
    /// Its type.
    pub fn kind(&self) -> SurfaceKind {
        match self {
            Self::Plane(_) => SurfaceKind::Plane,
            Self::Cylinder(_) => SurfaceKind::Cylinder,
            Self::Cone(_) => SurfaceKind::Cone,
            Self::Sphere(_) => SurfaceKind::Sphere,
            Self::Torus(_) => SurfaceKind::Torus,
        }
    }

    /// Signed orthogonal distance of `point`, positive on the side of the natural normal.
    pub fn signed_distance(&self, point: &Point3) -> f64 {
        each!(self, s => s.signed_distance(point))
    }

    /// Natural normal at the projection of `point`: the gradient of the signed distance.
    pub fn normal(&self, point: &Point3) -> UnitVec3 {
        each!(self, s => s.normal(point))
    }

    /// Signed distance and natural normal at once.
    pub fn distance_and_normal(&self, point: &Point3) -> (f64, UnitVec3) {
        (self.signed_distance(point), self.normal(point))
    }

    /// The point of the surface nearest to `point`.
    pub fn project(&self, point: &Point3) -> Point3 {
        let (distance, normal) = self.distance_and_normal(point);
        point - normal.into_inner() * distance
    }

    /// Sum of the principal curvatures at the projection of `point`, per length: positive where the surface bends away
    /// from its natural normal, as a sphere does.
    pub fn curvature_sum(&self, point: &Point3) -> f64 {
        let from_axis = |axis: &Axis| {
            let foot = self.project(point);
            (foot - axis.foot(&foot)).norm().max(f64::MIN_POSITIVE)
        };
        match self {
            Self::Plane(_) => 0.0,
            Self::Cylinder(s) => 1.0 / s.radius,
            Self::Sphere(s) => 2.0 / s.radius,
            Self::Cone(s) => s.half_angle.cos() / from_axis(&s.axis),
            Self::Torus(s) => {
                let radius = from_axis(&s.axis);
                1.0 / s.minor_radius + (radius - s.major_radius) / (s.minor_radius * radius)
            }
        }
    }

    /// Whether every parameter is a finite number.
    pub fn is_finite(&self) -> bool {
        let finite = |p: &Point3, d: &UnitVec3| p.iter().chain(d.iter()).all(|x| x.is_finite());
        match self {
            Self::Plane(s) => finite(&s.point, &s.normal),
            Self::Cylinder(s) => finite(&s.axis.origin, &s.axis.direction) && s.radius.is_finite(),
            Self::Cone(s) => {
                finite(&s.axis.origin, &s.axis.direction) && (s.radius + s.half_angle).is_finite()
            }
            Self::Sphere(s) => s.center.iter().all(|x| x.is_finite()) && s.radius.is_finite(),
            Self::Torus(s) => {
                finite(&s.axis.origin, &s.axis.direction) && (s.major_radius + s.minor_radius).is_finite()
            }
        }
    }

    /// Axis of revolution of a cylinder, cone or torus.
    pub fn axis(&self) -> Option<Axis> {
        match self {
            Self::Plane(_) | Self::Sphere(_) => None,
            Self::Cylinder(s) => Some(s.axis),
            Self::Cone(s) => Some(s.axis),
            Self::Torus(s) => Some(s.axis),
        }
    }

    /// The surface after a rigid motion.
    #[must_use]
    pub fn moved(&self, pose: &Pose) -> Self {
        self.transformed(&pose.rotation, 1.0, &pose.translation)
    }

    /// The surface after `p -> rotation * (p * scale) + translation`.
    #[must_use]
    pub fn transformed(&self, rotation: &nalgebra::Rotation3<f64>, scale: f64, translation: &Vec3) -> Self {
        let point = |p: &Point3| rotation * Point3::from(p.coords * scale) + translation;
        let unit = |u: &UnitVec3| UnitVec3::new_normalize(rotation * u.into_inner());
        let axis = |a: &Axis| Axis { origin: point(&a.origin), direction: unit(&a.direction) };
        match self {
            Self::Plane(s) => Self::Plane(Plane { point: point(&s.point), normal: unit(&s.normal) }),
            Self::Cylinder(s) => Self::Cylinder(Cylinder { axis: axis(&s.axis), radius: s.radius * scale }),
            Self::Cone(s) => {
                Self::Cone(Cone { axis: axis(&s.axis), radius: s.radius * scale, half_angle: s.half_angle })
            }
            Self::Sphere(s) => Self::Sphere(Sphere { center: point(&s.center), radius: s.radius * scale }),
            Self::Torus(s) => Self::Torus(Torus {
                axis: axis(&s.axis),
                major_radius: s.major_radius * scale,
                minor_radius: s.minor_radius * scale,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Axis;

    #[test]
    fn curvatures_are_those_of_the_offset_area() {
        // The area of a parallel surface grows by the curvature sum: d(dA)/dn = (k1 + k2) dA.
        let axis = Axis { origin: Point3::origin(), direction: Vec3::z_axis() };
        let torus = Surface::Torus(crate::surface::Torus { axis, major_radius: 5.0, minor_radius: 2.0 });
        assert!((torus.curvature_sum(&Point3::new(7.5, 0.0, 0.0)) - (1.0 / 2.0 + 1.0 / 7.0)).abs() < 1e-12);
        assert!((torus.curvature_sum(&Point3::new(3.2, 0.0, 0.0)) - (1.0 / 2.0 - 1.0 / 3.0)).abs() < 1e-12);
        assert!((torus.curvature_sum(&Point3::new(5.0, 0.0, 3.0)) - 0.5).abs() < 1e-12);
        let half_angle = 0.5_f64;
        let cone = Surface::Cone(crate::surface::Cone { axis, radius: 3.0, half_angle });
        // One curvature along the circle: the normal section's is the cosine of the half angle over the radius.
        assert!((cone.curvature_sum(&Point3::new(3.0, 0.0, 0.0)) - half_angle.cos() / 3.0).abs() < 1e-12);
    }
}
