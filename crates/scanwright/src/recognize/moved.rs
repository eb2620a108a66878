//! A primitive after a rigid motion.

use super::Primitive;
use crate::fit::{parameter_frame, parameter_names};
use crate::math::{Mat3, Point3, Pose};
use crate::surface::Surface;

impl Primitive {
    /// The primitive after a rigid motion. Its covariance is told in the frame of the moved surface, whose directions across
    /// the axis are not the moved ones.
    #[must_use]
    pub fn moved(&self, pose: &Pose) -> Self {
        let Some(surface) = self.surface else { return self.clone() };
        let moved = surface.moved(pose);
        let covariance = if self.covariance.is_empty() {
            Vec::new()
        } else {
            turned(&surface, &moved, pose, &self.covariance)
        };
        Self { surface: Some(moved), covariance, ..self.clone() }
    }
}

/// What a parameter is of: a way or a turn along a direction of the frame, or a shape.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Way(usize),
    Turn(usize),
    Shape(usize),
}

fn parts(surface: &Surface) -> Vec<Part> {
    let of = |(k, name): (usize, &&str)| match *name {
        "offset_x" | "center_x" => Part::Way(0),
        "offset_y" | "center_y" => Part::Way(1),
        "offset" | "offset_z" | "center_z" => Part::Way(2),
        "tilt_x" => Part::Turn(0),
        "tilt_y" => Part::Turn(1),
        _ => Part::Shape(k),
    };
    parameter_names(surface).iter().enumerate().map(of).collect()
}

fn turned(from: &Surface, to: &Surface, pose: &Pose, covariance: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let (a, b) = (parameter_frame(from, Point3::origin()), parameter_frame(to, Point3::origin()));
    let old = [a.x, a.y, a.z].map(|d| pose.rotation * d.into_inner());
    let new = [b.x, b.y, b.z].map(crate::math::UnitVec3::into_inner);
    let change = Mat3::from_fn(|i, j| new[i].dot(&old[j]));
    let parts = parts(to);
    let share = |i: usize, j: usize| match (parts[i], parts[j]) {
        (Part::Way(i), Part::Way(j)) | (Part::Turn(i), Part::Turn(j)) => change[(i, j)],
        (Part::Shape(i), Part::Shape(j)) if i == j => 1.0,
        _ => 0.0,
    };
    let n = parts.len();
    let entry = |i: usize, j: usize| {
        let mut sum = 0.0;
        for (k, row) in covariance.iter().enumerate() {
            for (l, value) in row.iter().enumerate() {
                sum += share(i, k) * value * share(j, l);
            }
        }
        sum
    };
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Fit, Samples};
    use crate::math::{Axis, UnitVec3, Vec3};
    use crate::surface::samples::{Patch, sample};
    use crate::surface::{Cone, Cylinder, Plane, Sphere, Torus};
    use nalgebra::SVector;

    #[test]
    fn moving_a_primitive_and_seeing_it_moved_are_one() {
        let axis = Axis {
            origin: Point3::new(3.0, -2.0, 1.0),
            direction: UnitVec3::new_normalize(Vec3::new(1.0, 2.0, -0.5)),
        };
        let patch = Patch { u: (0.0, 1.5), v: (-0.5, 1.2) };
        let step = SVector::<f64, 6>::from([0.4, -1.3, 0.6, 10.0, 20.0, -5.0]);
        let pose = Pose::of_step(&step, &Point3::origin());
        for surface in [
            Surface::Plane(Plane { point: axis.origin, normal: axis.direction }),
            Surface::Cylinder(Cylinder { axis, radius: 8.0 }),
            Surface::Cone(Cone { axis, radius: 8.0, half_angle: 0.5 }),
            Surface::Sphere(Sphere { center: axis.origin, radius: 9.0 }),
            Surface::Torus(Torus { axis, major_radius: 20.0, minor_radius: 5.0 }),
        ] {
            let seen = sample(&surface, patch, 500, 0.02, 7);
            let samples = Samples {
                points: seen.iter().map(|s| s.0).collect(),
                normals: seen.iter().map(|s| s.1.into_inner()).collect(),
            };
            let elsewhere = Samples {
                points: samples.points.iter().map(|p| pose.point(p)).collect(),
                normals: samples.normals.iter().map(|n| pose.rotation * n).collect(),
            };
            let primitive =
                |surface, samples| Primitive::with_evidence(Fit { surface, outward: true }, samples, 500);
            let moved = primitive(surface, &samples).moved(&pose);
            let seen = primitive(surface.moved(&pose), &elsewhere);
            let size = seen.covariance.iter().enumerate().map(|(i, row)| row[i]).fold(0.0, f64::max);
            for (a, b) in moved.covariance.iter().flatten().zip(seen.covariance.iter().flatten()) {
                assert!((a - b).abs() < 1e-7 * size, "{:?}: {a} and {b}", surface.kind());
            }
        }
    }
}
