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

use crate::math::{Axis, Point3, UnitVec3, Vec3};

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

    /// Axis of revolution of a cylinder, cone or torus.
    pub fn axis(&self) -> Option<Axis> {
        match self {
            Self::Plane(_) | Self::Sphere(_) => None,
            Self::Cylinder(s) => Some(s.axis),
            Self::Cone(s) => Some(s.axis),
            Self::Torus(s) => Some(s.axis),
        }
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
