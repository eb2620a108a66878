use crate::math::{Point3, UnitVec3};

/// A plane through `point`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// A point of the plane, best near the data.
    pub point: Point3,
    /// Unit normal.
    pub normal: UnitVec3,
}

impl Plane {
    /// Height above the plane along its normal.
    pub fn signed_distance(&self, point: &Point3) -> f64 {
        (point - self.point).dot(&self.normal)
    }

    /// The plane's normal, wherever `point` is.
    pub fn normal(&self, _point: &Point3) -> UnitVec3 {
        self.normal
    }
}
