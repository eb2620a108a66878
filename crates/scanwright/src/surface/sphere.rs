use crate::math::{Point3, UnitVec3, Vec3, try_unit};

/// A sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub center: Point3,
    /// Radius, length.
    pub radius: f64,
}

impl Sphere {
    /// Distance from the centre minus the radius.
    pub fn signed_distance(&self, point: &Point3) -> f64 {
        (point - self.center).norm() - self.radius
    }

    /// Away from the centre; z at the centre itself.
    pub fn normal(&self, point: &Point3) -> UnitVec3 {
        try_unit(point - self.center).unwrap_or_else(Vec3::z_axis)
    }
}
