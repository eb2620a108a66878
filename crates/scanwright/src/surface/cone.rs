use crate::math::{Axis, Point3, UnitVec3, any_perpendicular, try_unit};

/// One nappe of a right circular cone: the half where the radius is positive.
///
/// Stored by a point of its axis beside the data and the radius there, so that a half-angle of zero is a cylinder
/// and not a singularity. The radius grows along the axis direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Axis, pointing to where the radius grows.
    pub axis: Axis,
    /// Radius at the axis' origin, length.
    pub radius: f64,
    /// Angle between axis and generator, in (0, pi/2).
    pub half_angle: f64,
}

impl Cone {
    /// The apex. Far away when the half-angle is small.
    pub fn apex(&self) -> Point3 {
        self.axis.origin - self.axis.direction.into_inner() * (self.radius / self.half_angle.tan())
    }

    /// Orthogonal distance, positive outside; beyond the apex, the distance to the apex.
    pub fn signed_distance(&self, point: &Point3) -> f64 {
        let height = self.axis.height(point);
        let radial = self.axis.radial(point).norm();
        if self.is_beyond_apex(height, radial) {
            return (point - self.apex()).norm();
        }
        let (sin, cos) = self.half_angle.sin_cos();
        (radial - self.radius) * cos - height * sin
    }

    /// Gradient of the signed distance.
    pub fn normal(&self, point: &Point3) -> UnitVec3 {
        let height = self.axis.height(point);
        let radial = self.axis.radial(point);
        if self.is_beyond_apex(height, radial.norm()) {
            return try_unit(point - self.apex()).unwrap_or_else(|| -self.axis.direction);
        }
        let outward = try_unit(radial).unwrap_or_else(|| any_perpendicular(&self.axis.direction));
        let (sin, cos) = self.half_angle.sin_cos();
        UnitVec3::new_normalize(outward.into_inner() * cos - self.axis.direction.into_inner() * sin)
    }

    /// Whether the foot point on the generator's line lies on the other side of the apex.
    fn is_beyond_apex(&self, height: f64, radial: f64) -> bool {
        let (sin, cos) = self.half_angle.sin_cos();
        // Position along the generator, measured from the apex.
        (height * cos + radial * sin) * sin + self.radius * cos * cos < 0.0
            && height * sin + self.radius * cos < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn distance_beyond_the_apex_is_to_the_apex() {
        let axis = Axis { origin: Point3::new(0.0, 0.0, 1.0), direction: Vec3::z_axis() };
        let cone = Cone { axis, radius: 1.0, half_angle: std::f64::consts::FRAC_PI_4 };
        assert!((cone.apex() - Point3::origin()).norm() < 1e-12, "apex {}", cone.apex());
        assert!((cone.signed_distance(&Point3::new(0.0, 0.0, -2.0)) - 2.0).abs() < 1e-12);
        assert!(cone.signed_distance(&Point3::new(3.0, 0.0, 3.0)).abs() < 1e-12);
        assert!(cone.signed_distance(&Point3::new(0.0, 0.0, 3.0)) < 0.0, "the axis is inside");
    }
}
