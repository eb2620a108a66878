//! Guesses without surfaces: principal axes laid on each other, and a grid of turns.

use super::{Part, Target};
use crate::math::{Frame, Mat3, Point3, Pose, UnitVec3, Vec3, symmetric_eigen};
use crate::mesh::Mesh;
use nalgebra::{Rotation3, UnitQuaternion};

/// Middle of a mesh's area and its principal axes.
fn axes(mesh: &Mesh) -> Frame {
    let (mut area, mut first, mut second) = (0.0, Vec3::zeros(), Mat3::zeros());
    let base = mesh.vertices.first().copied().unwrap_or_else(Point3::origin);
    for t in 0..mesh.triangles.len() {
        let (a, center) = (mesh.area(t), mesh.triangle_center(t) - base);
        area += a;
        first += center * a;
        second += center * center.transpose() * a;
    }
    let middle = first / area.max(f64::MIN_POSITIVE);
    let spread = second / area.max(f64::MIN_POSITIVE) - middle * middle.transpose();
    let [(_, z), (_, y), _] = symmetric_eigen(&spread);
    let x = UnitVec3::new_normalize(y.cross(&z));
    Frame { origin: base + middle, x, y, z }
}

/// The twenty-four turns that lay axes on axes: eigenvalues may come in another order when part of the scan is missing.
pub fn principal(target: &Target, part: &Part) -> Vec<Pose> {
    let into = Pose::into_frame(&axes(&part.mesh));
    let out = Pose::into_frame(&axes(&target.model.mesh)).inverse();
    let turned = |rotation| out.after(&Pose { rotation, translation: Vec3::zeros() }).after(&into);
    cube_turns().into_iter().map(turned).collect()
}

/// Turns of the cube.
fn cube_turns() -> Vec<Rotation3<f64>> {
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let signed: Vec<Vec3> = axes.iter().flat_map(|a| [*a, -a]).collect();
    let mut turns = Vec::new();
    for x in &signed {
        for y in signed.iter().filter(|y| y.dot(x) == 0.0) {
            turns.push(Rotation3::from_matrix_unchecked(Mat3::from_columns(&[*x, *y, x.cross(y)])));
        }
    }
    turns
}

/// Turns spread over all, middle on middle: products of the cube's turns with a few between them.
pub fn grid(target: &Target, part: &Part) -> Vec<Pose> {
    let (from, to) = (axes(&part.mesh), axes(&target.model.mesh));
    let (into, out) = (Pose::into_frame(&from), Pose::into_frame(&to).inverse());
    let between = Rotation3::from_matrix_unchecked(Mat3::identity());
    // Half a turn of the cube's cell along each of its axes and diagonals.
    let mut small = vec![between];
    for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
        small.push(Rotation3::new(axis * std::f64::consts::FRAC_PI_4));
    }
    for (i, j) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let axis = UnitVec3::new_normalize(Vec3::new(i, j, 1.0));
        let third = UnitQuaternion::from_axis_angle(&axis, std::f64::consts::FRAC_PI_3);
        small.push(third.to_rotation_matrix());
    }
    let turned = |rotation| out.after(&Pose { rotation, translation: Vec3::zeros() }).after(&into);
    let all = small.iter().flat_map(|s| cube_turns().into_iter().map(move |c| c * s));
    all.map(turned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cube_has_twenty_four_turns_and_no_reflection() {
        let turns = cube_turns();
        assert_eq!(turns.len(), 24);
        assert!(turns.iter().all(|t| (t.matrix().determinant() - 1.0).abs() < 1e-12));
        for (i, a) in turns.iter().enumerate() {
            assert!(turns[..i].iter().all(|b| a.angle_to(b) > 1.0), "turn {i} is there twice");
        }
    }
}
