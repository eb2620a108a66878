//! Points, directions, frames, and the small numerical tools every stage uses.
//!
//! Everything is `f64`; nalgebra's generics stay behind these aliases.

pub mod blur;
mod eigen;
mod frame;
pub mod least_squares;
mod planar;
mod pose;
pub mod stats;

pub use eigen::symmetric_eigen;
pub use frame::{Axis, Frame, any_perpendicular};
pub use planar::{fitted_circle, fitted_parabola, longest_extent, nearest_circle, smallest_rectangle};
pub use pose::Pose;

/// A position, in the scan's unit.
pub type Point3 = nalgebra::Point3<f64>;
/// A displacement, in the scan's unit.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A direction of length one.
pub type UnitVec3 = nalgebra::Unit<nalgebra::Vector3<f64>>;
/// A 3x3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;

/// Mean of `points`; the origin when there are none.
pub fn centroid(points: &[Point3]) -> Point3 {
    let sum = points.iter().fold(Vec3::zeros(), |sum, point| sum + point.coords);
    Point3::from(sum / (points.len().max(1) as f64))
}

/// Principal axes of `points` about `center`: (variance, direction), ascending by variance.
pub fn principal_axes(points: &[Point3], center: Point3) -> [(f64, UnitVec3); 3] {
    let mut covariance = Mat3::zeros();
    for point in points {
        let offset = point - center;
        covariance += offset * offset.transpose();
    }
    symmetric_eigen(&(covariance / (points.len().max(1) as f64)))
}

/// Angle between two directions, in [0, pi], accurate near 0 and pi where `acos` is not.
pub fn angle_between(a: &Vec3, b: &Vec3) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// Normalized `v`, or `None` when its length is zero or not finite.
pub fn try_unit(v: Vec3) -> Option<UnitVec3> {
    let length = v.norm();
    (length.is_finite() && length > 0.0).then(|| UnitVec3::new_unchecked(v / length))
}
