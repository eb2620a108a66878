//! Points, directions, placements and the maps between them.

use super::StepReadError;
use super::part21::Exchange;
use crate::math::{Axis, Frame, Mat3, Point3, UnitVec3, Vec3, any_perpendicular, try_unit};
use crate::surface::{Cone, Cylinder, Plane, Sphere, Surface, Torus};
use crate::tolerance::Tolerances;

/// `p -> linear * p + shift`: a motion, with a uniform scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::step) struct Motion {
    pub(in crate::step) linear: Mat3,
    pub(in crate::step) shift: Vec3,
}

impl Motion {
    pub(in crate::step) fn identity() -> Self {
        Self { linear: Mat3::identity(), shift: Vec3::zeros() }
    }

    pub(super) fn scaling(factor: f64) -> Self {
        Self { linear: Mat3::identity() * factor, shift: Vec3::zeros() }
    }

    /// From coordinates in the frame to those that the frame is given in.
    pub(in crate::step) fn of_frame(frame: &Frame) -> Self {
        let columns = [frame.x.into_inner(), frame.y.into_inner(), frame.z.into_inner()];
        Self { linear: Mat3::from_columns(&columns), shift: frame.origin.coords }
    }

    pub(super) fn point(&self, p: &Point3) -> Point3 {
        Point3::from(self.linear * p.coords + self.shift)
    }

    /// First `inner`, then this one.
    pub(super) fn after(&self, inner: &Self) -> Self {
        Self { linear: self.linear * inner.linear, shift: self.linear * inner.shift + self.shift }
    }

    pub(super) fn inverse(&self) -> Option<Self> {
        let linear = self.linear.try_inverse()?;
        Some(Self { linear, shift: -(linear * self.shift) })
    }

    /// The factor that it stretches lengths by.
    pub(super) fn scale(&self) -> f64 {
        self.linear.determinant().abs().cbrt()
    }

    /// Whether it turns a left hand into a right one.
    pub(super) fn mirrors(&self) -> bool {
        self.linear.determinant() < 0.0
    }

    /// A surface moved, or mirrored: all directions of the five are those of their points, so they mirror with them.
    pub(super) fn surface(&self, surface: &Surface) -> Surface {
        let scale = self.scale();
        let point = |p: &Point3| self.point(p);
        let unit = |u: &UnitVec3| UnitVec3::new_normalize(self.linear * u.into_inner());
        let axis = |a: &Axis| Axis { origin: point(&a.origin), direction: unit(&a.direction) };
        match surface {
            Surface::Plane(s) => Surface::Plane(Plane { point: point(&s.point), normal: unit(&s.normal) }),
            Surface::Cylinder(s) => {
                Surface::Cylinder(Cylinder { axis: axis(&s.axis), radius: s.radius * scale })
            }
            Surface::Cone(s) => Surface::Cone(Cone {
                axis: axis(&s.axis),
                radius: s.radius * scale,
                half_angle: s.half_angle,
            }),
            Surface::Sphere(s) => {
                Surface::Sphere(Sphere { center: point(&s.center), radius: s.radius * scale })
            }
            Surface::Torus(s) => Surface::Torus(Torus {
                axis: axis(&s.axis),
                major_radius: s.major_radius * scale,
                minor_radius: s.minor_radius * scale,
            }),
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.linear.iter().chain(self.shift.iter()).all(|x| x.is_finite())
    }
}

/// A `CARTESIAN_POINT`.
pub(super) fn point(exchange: &Exchange, id: u64) -> Result<Point3, StepReadError> {
    let entity = exchange.get(id)?;
    if !entity.is("CARTESIAN_POINT") {
        return Err(entity.wrong(format!("is {}", entity.kind()), "CARTESIAN_POINT"));
    }
    let x = entity.fields("CARTESIAN_POINT", 1).reals(0)?;
    match x[..] {
        [x, y, z] => Ok(Point3::new(x, y, z)),
        _ => Err(entity.wrong(format!("has {} coordinates", x.len()), "3")),
    }
}

/// A `DIRECTION`.
pub(super) fn direction(exchange: &Exchange, id: u64) -> Result<UnitVec3, StepReadError> {
    let entity = exchange.get(id)?;
    if !entity.is("DIRECTION") {
        return Err(entity.wrong(format!("is {}", entity.kind()), "DIRECTION"));
    }
    let x = entity.fields("DIRECTION", 1).reals(0)?;
    let vector = match x[..] {
        [x, y, z] => Vec3::new(x, y, z),
        _ => return Err(entity.wrong(format!("has {} components", x.len()), "3")),
    };
    try_unit(vector).ok_or_else(|| entity.wrong("has no length", "a direction"))
}

/// A `VECTOR`, with its length.
pub(super) fn vector(exchange: &Exchange, id: u64) -> Result<Vec3, StepReadError> {
    let entity = exchange.get(id)?;
    if entity.is("DIRECTION") {
        return Ok(direction(exchange, id)?.into_inner());
    }
    let fields = entity.fields("VECTOR", 1);
    Ok(direction(exchange, fields.reference(0)?)?.into_inner() * fields.real(1)?)
}

/// An `AXIS2_PLACEMENT_3D` or `AXIS1_PLACEMENT`.
pub(super) fn frame(exchange: &Exchange, id: u64) -> Result<Frame, StepReadError> {
    let entity = exchange.get(id)?;
    if !(entity.is("AXIS2_PLACEMENT_3D") || entity.is("AXIS1_PLACEMENT")) {
        return Err(entity.wrong(format!("is {}", entity.kind()), "AXIS2_PLACEMENT_3D"));
    }
    let origin = point(exchange, entity.fields("PLACEMENT", 1).reference(0)?)?;
    let name = if entity.is("AXIS2_PLACEMENT_3D") { "AXIS2_PLACEMENT_3D" } else { "AXIS1_PLACEMENT" };
    let fields = entity.fields(name, 2);
    let (axis, reference) = (fields.optional(0), fields.optional(1));
    let z = axis.map_or(Ok(Vec3::z_axis()), |id| direction(exchange, id))?;
    let wanted = reference.map_or(Ok(Vec3::x_axis()), |id| direction(exchange, id))?;
    Ok(frame_of(origin, z, &wanted))
}

/// The frame with the third direction `z` and the first one as near to `x` as that leaves.
fn frame_of(origin: Point3, z: UnitVec3, x: &Vec3) -> Frame {
    let across = x - z.into_inner() * z.dot(x);
    let x = if across.norm() > Tolerances::SAME {
        UnitVec3::new_normalize(across)
    } else {
        any_perpendicular(&z)
    };
    Frame { origin, x, y: UnitVec3::new_normalize(z.cross(&x)), z }
}

/// A placement, or a `CARTESIAN_TRANSFORMATION_OPERATOR_3D`, as the map from its own coordinates.
pub(super) fn motion(exchange: &Exchange, id: u64) -> Result<Motion, StepReadError> {
    let entity = exchange.get(id)?;
    if !entity.is("CARTESIAN_TRANSFORMATION_OPERATOR_3D") {
        return frame(exchange, id).map(|f| Motion::of_frame(&f));
    }
    // Simple: name, [name, description,] axis 1, axis 2, origin, scale, axis 3.
    let (base, third) = if entity.leaves.len() == 1 {
        let fields = entity.all_fields();
        let first = fields.len().saturating_sub(5);
        (entity.fields("", first), entity.fields("", first + 4))
    } else {
        let base = entity.fields("CARTESIAN_TRANSFORMATION_OPERATOR", 0);
        (base, entity.fields("CARTESIAN_TRANSFORMATION_OPERATOR_3D", 0))
    };
    let axis = |id: Option<u64>| id.map(|id| direction(exchange, id)).transpose();
    let (x, y, z) = (axis(base.optional(0))?, axis(base.optional(1))?, axis(third.optional(0))?);
    let z = z.or_else(|| try_unit(x?.cross(y?.as_ref()))).unwrap_or(Vec3::z_axis());
    let origin = point(exchange, base.reference(2)?)?;
    let frame = frame_of(origin, z, &x.unwrap_or(Vec3::x_axis()));
    let mut motion = Motion::of_frame(&frame);
    // The second axis only says on which side of the first it lies.
    if y.is_some_and(|y| y.dot(&frame.y) < 0.0) {
        motion.linear.set_column(1, &-frame.y.into_inner());
    }
    motion.linear *= base.real(3).unwrap_or(1.0);
    Ok(motion)
}
