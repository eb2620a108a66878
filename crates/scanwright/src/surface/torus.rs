use crate::math::{Axis, Point3, UnitVec3, any_perpendicular, try_unit};

/// A torus. With `major_radius < minor_radius` (spindle torus) it is the outer part, the apple; a negative major radius
/// is the inner part, the lemon of the spindle torus with the opposite radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Torus {
    /// Axis of revolution; its origin is the centre.
    pub axis: Axis,
    /// Distance of the tube's spine from the axis, length.
    pub major_radius: f64,
    /// Radius of the tube, length.
    pub minor_radius: f64,
}

impl Torus {
    /// Distance from the spine minus the minor radius.
    pub fn signed_distance(&self, point: &Point3) -> f64 {
        let height = self.axis.height(point);
        let radial = self.axis.radial(point).norm();
        (radial - self.major_radius).hypot(height) - self.minor_radius
    }

    /// Away from the spine.
    pub fn normal(&self, point: &Point3) -> UnitVec3 {
        let direction = self.axis.direction.into_inner();
        let radial = self.axis.radial(point);
        let outward =
            try_unit(radial).unwrap_or_else(|| any_perpendicular(&self.axis.direction)).into_inner();
        let from_spine = outward * (radial.norm() - self.major_radius) + direction * self.axis.height(point);
        try_unit(from_spine).unwrap_or_else(|| UnitVec3::new_unchecked(outward))
    }
}
