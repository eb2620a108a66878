//! The two motions that profiles are swept by: along a direction and about an axis.

use crate::math::{Frame, Point3, Vec3};

/// A point of the profile's plane: across the direction, or (radius, height) beside the axis.
pub(super) type Point2 = nalgebra::Vector2<f64>;

/// How a profile moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Motion {
    /// Along the third direction of the frame.
    Along,
    /// About the third direction of the frame.
    Around,
}

/// A motion in space.
///
/// Coordinates are a point of the profile's plane and how far it has moved: a length, or an angle in [0, 2 pi).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sweep {
    pub(super) motion: Motion,
    pub(super) frame: Frame,
}

impl Sweep {
    /// Coordinates of a point.
    pub(super) fn coordinates(&self, point: &Point3) -> (Point2, f64) {
        let local = self.frame.local(point);
        match self.motion {
            Motion::Along => (local.xy(), local.z),
            Motion::Around => {
                let angle = local.y.atan2(local.x).rem_euclid(std::f64::consts::TAU);
                (Point2::new(local.x.hypot(local.y), local.z), angle)
            }
        }
    }

    /// The point with given coordinates.
    pub(super) fn point(&self, profile: &Point2, moved: f64) -> Point3 {
        match self.motion {
            Motion::Along => self.frame.global(&Vec3::new(profile.x, profile.y, moved)),
            Motion::Around => {
                let (sin, cos) = moved.sin_cos();
                self.frame.global(&Vec3::new(profile.x * cos, profile.x * sin, profile.y))
            }
        }
    }

    /// Volume that a small area at `profile` sweeps, per area and motion.
    pub(super) fn density(&self, profile: &Point2) -> f64 {
        match self.motion {
            Motion::Along => 1.0,
            Motion::Around => profile.x.max(0.0),
        }
    }
}
