use nalgebra::{Matrix4, Rotation3, SVector};

use super::{Axis, Frame, Point3, UnitVec3, Vec3};

/// A rigid motion: `target = rotation * source + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// The turn.
    pub rotation: Rotation3<f64>,
    /// Where the source's origin goes.
    pub translation: Vec3,
}

impl Default for Pose {
    fn default() -> Self {
        Self::identity()
    }
}

impl Pose {
    /// Nothing moves.
    pub fn identity() -> Self {
        Self { rotation: Rotation3::identity(), translation: Vec3::zeros() }
    }

    /// The motion that takes `point` to the coordinates it has in `frame`.
    pub fn into_frame(frame: &Frame) -> Self {
        let columns = nalgebra::Matrix3::from_columns(&[*frame.x, *frame.y, *frame.z]);
        let rotation = Rotation3::from_matrix_unchecked(columns.transpose());
        Self { rotation, translation: -(rotation * frame.origin.coords) }
    }

    /// A turn by `step[0..3]` (radians, about `pivot`) and then a way of `step[3..6]`.
    pub fn of_step(step: &SVector<f64, 6>, pivot: &Point3) -> Self {
        let rotation = Rotation3::new(Vec3::new(step[0], step[1], step[2]));
        let way = Vec3::new(step[3], step[4], step[5]);
        Self { rotation, translation: pivot.coords - rotation * pivot.coords + way }
    }

    /// Where a point goes.
    pub fn point(&self, point: &Point3) -> Point3 {
        self.rotation * point + self.translation
    }

    /// Where a direction points.
    pub fn unit(&self, direction: &UnitVec3) -> UnitVec3 {
        UnitVec3::new_normalize(self.rotation * direction.into_inner())
    }

    /// Where a line goes.
    pub fn axis(&self, axis: &Axis) -> Axis {
        Axis { origin: self.point(&axis.origin), direction: self.unit(&axis.direction) }
    }

    /// First `first`, then this.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        let mut rotation = self.rotation * first.rotation;
        // Products of many drift from a turn by rounding.
        rotation.renormalize();
        Self { rotation, translation: self.rotation * first.translation + self.translation }
    }

    /// Back again.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.inverse();
        Self { rotation, translation: -(rotation * self.translation) }
    }

    /// Rows of the 4 x 4 matrix that multiplies columns of homogeneous coordinates.
    pub fn rows(&self) -> [[f64; 4]; 4] {
        let m: Matrix4<f64> = nalgebra::Isometry3::from_parts(
            nalgebra::Translation3::from(self.translation),
            nalgebra::UnitQuaternion::from_rotation_matrix(&self.rotation),
        )
        .to_homogeneous();
        std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]))
    }

    /// Angle of the turn, radians.
    pub fn angle(&self) -> f64 {
        self.rotation.angle()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_and_its_inverse_cancel_and_a_frame_is_entered() {
        let step = SVector::<f64, 6>::from([0.3, -0.2, 0.9, 5.0, -7.0, 2.0]);
        let pose = Pose::of_step(&step, &Point3::new(1.0, 2.0, 3.0));
        let moved = pose.point(&Point3::new(1.0, 2.0, 3.0));
        assert!((moved - Point3::new(6.0, -5.0, 5.0)).norm() < 1e-12, "the pivot only goes its way");
        let same = pose.inverse().after(&pose);
        assert!(same.angle() < 1e-7 && same.translation.norm() < 1e-12);
        let frame =
            Frame::from_z(Point3::new(4.0, 5.0, 6.0), UnitVec3::new_normalize(Vec3::new(1.0, 1.0, 0.2)));
        let point = Point3::new(-3.0, 8.0, 1.0);
        assert!((Pose::into_frame(&frame).point(&point).coords - frame.local(&point)).norm() < 1e-12);
    }
}
