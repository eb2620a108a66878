use crate::math::{Axis, Point3, UnitVec3, any_perpendicular, try_unit};

/// A right circular cylinder, unbounded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// Axis, its origin best near the data.
    pub axis: Axis,
    /// Radius, length.
    pub radius: f64,
}

impl Cylinder {
    /// Distance from the axis minus the radius.
    pub fn signed_distance(&self, point: &Point3) -> f64 {
        self.axis.radial(point).norm() - self.radius
    }

    /// Away from the axis; any perpendicular direction on the axis itself.
    pub fn normal(&self, point: &Point3) -> UnitVec3 {
        try_unit(self.axis.radial(point)).unwrap_or_else(|| any_perpendicular(&self.axis.direction))
    }
}
