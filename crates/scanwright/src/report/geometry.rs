use serde::Serialize;

use crate::math::{Point3, UnitVec3};
use crate::surface::{Plane, Surface};

/// Parameters of a surface, named as the benchmark's truth names them. Lengths in the scan's unit, angles in radians.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum Geometry {
    /// Flat.
    Plane {
        /// A point of the plane.
        point: [f64; 3],
        /// Unit normal, out of the material.
        normal: [f64; 3],
    },
    /// Right circular cylinder.
    Cylinder {
        /// A point of the axis.
        axis_point: [f64; 3],
        /// Unit direction of the axis.
        axis_direction: [f64; 3],
        /// Radius.
        radius: f64,
    },
    /// Right circular cone.
    Cone {
        /// The tip.
        apex: [f64; 3],
        /// Unit direction of the axis, to where the radius grows.
        axis_direction: [f64; 3],
        /// Angle between axis and generator.
        half_angle: f64,
    },
    /// Sphere.
    Sphere {
        /// Center.
        center: [f64; 3],
        /// Radius.
        radius: f64,
    },
    /// Torus.
    Torus {
        /// Center.
        center: [f64; 3],
        /// Unit direction of the axis.
        axis_direction: [f64; 3],
        /// Radius of the tube's spine.
        major_radius: f64,
        /// Radius of the tube.
        minor_radius: f64,
    },
    /// None of these.
    Freeform,
}

impl Geometry {
    /// The parameters of `surface`; freeform without one.
    pub fn of(surface: Option<&Surface>) -> Self {
        match surface {
            None => Self::Freeform,
            Some(Surface::Plane(plane)) => Self::of_plane(plane),
            Some(Surface::Cylinder(s)) => Self::Cylinder {
                axis_point: point(&s.axis.origin),
                axis_direction: direction(&s.axis.direction),
                radius: s.radius,
            },
            Some(Surface::Cone(s)) => Self::Cone {
                apex: point(&s.apex()),
                axis_direction: direction(&s.axis.direction),
                half_angle: s.half_angle,
            },
            Some(Surface::Sphere(s)) => Self::Sphere { center: point(&s.center), radius: s.radius },
            Some(Surface::Torus(s)) => Self::Torus {
                center: point(&s.axis.origin),
                axis_direction: direction(&s.axis.direction),
                // The lemon of a spindle torus has the radii of the whole torus.
                major_radius: s.major_radius.abs(),
                minor_radius: s.minor_radius,
            },
        }
    }

    /// The parameters of a plane.
    pub fn of_plane(plane: &Plane) -> Self {
        Self::Plane { point: point(&plane.point), normal: direction(&plane.normal) }
    }
}

fn point(p: &Point3) -> [f64; 3] {
    [p.x, p.y, p.z]
}

fn direction(d: &UnitVec3) -> [f64; 3] {
    [d.x, d.y, d.z]
}
