//! Fits of reference data whose least-squares answer is known beforehand.
//!
//! The data are made from the answer: points of a surface are moved along its normals by deviations that no small motion
//! and no change of size of the surface can lessen, so that it is exactly the surface of least squares of the moved
//! points. (The orthogonal distance of a point has the same derivatives by the parameters all along a normal; deviations
//! without a share in these derivatives leave the gradient zero. As they are far smaller than the radii, it is the
//! minimum.) No other implementation and no longer arithmetic is needed: the answer is exact to the rounding of the
//! points. A. Forbes, "Least-squares best-fit geometric elements", NPL Report DITC 140/89 (1989), describes data sets of
//! this kind.

use nalgebra::{DMatrix, DVector, Rotation3};

use crate::fit::{FitMethod, Samples, distance_by_parameters, fit_known};
use crate::math::{Axis, Frame, Point3, UnitVec3, Vec3, angle_between, centroid};
use crate::random::Rng;
use crate::surface::samples::point_at;
use crate::surface::{Cone, Cylinder, Plane, Sphere, Surface, Torus};

/// Largest error of a length that passes, mm.
pub const LENGTH: f64 = 1e-5;
/// Largest error of an angle that passes, radians.
pub const ANGLE: f64 = 1e-7;

/// One data set with its answer.
#[derive(Debug, Clone)]
pub struct Reference {
    /// What it is.
    pub name: String,
    /// The points, with the normals of the answer there.
    pub samples: Samples,
    /// The answer.
    pub surface: Surface,
}

/// Errors of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Largest error of a radius, or distance of the position from the answer's, length.
    pub length: f64,
    /// Largest error of the direction or the half-angle, radians.
    pub angle: f64,
}

impl Errors {
    /// Whether both are small enough.
    pub fn pass(&self) -> bool {
        self.length <= LENGTH && self.angle <= ANGLE
    }
}

/// Root of the mean square deviation of the points, mm.
const DEVIATION: f64 = 0.02;
/// Points along each coordinate of a surface.
const N_SIDE: usize = 24;

/// The data sets: each surface at the origin and far from it, in a slanted pose.
pub fn references() -> Vec<Reference> {
    /// Where scans in machine coordinates lie, mm.
    const FAR: [f64; 3] = [2.0e4, -5.0e4, 1.0e5];
    let mut references = Vec::new();
    for (far, at) in [("", Vec3::zeros()), (", far away", Vec3::from(FAR))] {
        for (name, surface, u, v) in surfaces() {
            let rotation = Rotation3::from_euler_angles(0.4, -0.7, 1.1);
            references.push(Reference::new(format!("{name}{far}"), &surface, [u, v], &rotation, &at));
        }
    }
    references
}

/// Name, surface about the z axis, and the ranges of its natural coordinates.
fn surfaces() -> Vec<(&'static str, Surface, [f64; 2], [f64; 2])> {
    let axis = Axis { origin: Point3::origin(), direction: Vec3::z_axis() };
    let plane = Surface::Plane(Plane { point: Point3::origin(), normal: Vec3::z_axis() });
    let cylinder = Surface::Cylinder(Cylinder { axis, radius: 10.0 });
    let cone = |degrees: f64| Surface::Cone(Cone { axis, radius: 10.0, half_angle: degrees.to_radians() });
    let sphere = Surface::Sphere(Sphere { center: Point3::origin(), radius: 10.0 });
    let torus = |major_radius| Surface::Torus(Torus { axis, major_radius, minor_radius: 5.0 });
    let arc = |degrees: f64| [0.0, degrees.to_radians()];
    let cap = |degrees: f64| [(90.0 - degrees).to_radians(), 1.5];
    vec![
        ("plane", plane, [-20.0, 20.0], [-15.0, 15.0]),
        ("plane, a strip", plane, [-40.0, 40.0], [-0.5, 0.5]),
        ("cylinder", cylinder, arc(360.0), [-10.0, 10.0]),
        ("cylinder, a quarter", cylinder, arc(90.0), [-10.0, 10.0]),
        ("cylinder, 20 degrees", cylinder, arc(20.0), [-10.0, 10.0]),
        ("cylinder, a ring", cylinder, arc(360.0), [-0.5, 0.5]),
        ("cone, 30 degrees", cone(30.0), arc(360.0), [-8.0, 8.0]),
        ("cone, 30 degrees, a quarter", cone(30.0), arc(90.0), [-8.0, 8.0]),
        ("cone, slender", cone(2.0), arc(360.0), [-8.0, 8.0]),
        ("cone, flat", cone(80.0), arc(360.0), [0.2, 1.5]),
        ("sphere", sphere, arc(360.0), [-1.5, 1.5]),
        ("sphere, a cap of 45 degrees", sphere, arc(360.0), cap(45.0)),
        ("sphere, a cap of 15 degrees", sphere, arc(360.0), cap(15.0)),
        ("torus", torus(20.0), arc(360.0), arc(360.0)),
        ("torus, a quarter of its turn", torus(20.0), arc(90.0), arc(360.0)),
        ("torus, a fillet", torus(20.0), arc(120.0), arc(90.0)),
        ("torus, nearly a sphere", torus(2.0), arc(360.0), [-1.2, 1.2]),
    ]
}

impl Reference {
    fn new(
        name: String,
        upright: &Surface,
        [u, v]: [[f64; 2]; 2],
        rotation: &Rotation3<f64>,
        at: &Vec3,
    ) -> Self {
        let surface = upright.transformed(rotation, 1.0, at);
        let along =
            |range: [f64; 2], i: usize| range[0] + (range[1] - range[0]) * (i as f64 + 0.5) / N_SIDE as f64;
        let points: Vec<Point3> = (0..N_SIDE * N_SIDE)
            .map(|i| rotation * point_at(upright, along(u, i / N_SIDE), along(v, i % N_SIDE)) + at)
            .collect();
        let normals: Vec<Vec3> = points.iter().map(|p| surface.normal(p).into_inner()).collect();
        let deviations = without_gradient(&surface, &points);
        let points =
            points.iter().zip(&normals).zip(deviations.iter()).map(|((p, n), d)| p + n * *d).collect();
        Self { name, samples: Samples { points, normals }, surface }
    }

    /// Errors of the fit by `method`; `None` when it finds no surface.
    pub fn errors(&self, method: FitMethod) -> Option<Errors> {
        let found = fit_known(self.surface.kind(), &self.samples, DEVIATION, method)?;
        Some(difference(&found, &self.surface, &centroid(&self.samples.points)))
    }
}

/// Deviations of the points that have no share in the derivatives of the distances by the parameters.
fn without_gradient(surface: &Surface, points: &[Point3]) -> DVector<f64> {
    let mut rng = Rng::for_task(1, "selftest", points.len() as u64);
    let frame = Frame::from_z(centroid(points), direction(surface).unwrap_or_else(Vec3::z_axis));
    let rows: Vec<DVector<f64>> = points.iter().map(|p| distance_by_parameters(surface, &frame, p)).collect();
    let derivatives = DMatrix::from_fn(points.len(), rows[0].len(), |i, j| rows[i][j]);
    let basis = derivatives.qr().q();
    let mut deviations = DVector::from_fn(points.len(), |_, _| rng.normal());
    // Once more, as one subtraction leaves the rounding of the first.
    for _ in 0..2 {
        let share = basis.transpose() * &deviations;
        deviations -= &basis * share;
    }
    let scale = DEVIATION * (points.len() as f64).sqrt() / deviations.norm();
    deviations * scale
}

fn direction(surface: &Surface) -> Option<UnitVec3> {
    match surface {
        Surface::Plane(plane) => Some(plane.normal),
        _ => surface.axis().map(|axis| axis.direction),
    }
}

/// Errors of `found`; positions are compared at `near`.
fn difference(found: &Surface, truth: &Surface, near: &Point3) -> Errors {
    let turn = match (direction(found), direction(truth)) {
        (Some(a), Some(b)) => angle_between(&a, &b).min(angle_between(&-a.into_inner(), &b)),
        _ => 0.0,
    };
    let across = |a: &Axis, b: &Axis| (a.foot(near) - b.foot(near)).norm();
    let (lengths, angle) = match (found, truth) {
        (Surface::Plane(a), Surface::Plane(b)) => {
            let facing = a.normal.dot(&b.normal).signum();
            (vec![facing * a.signed_distance(near) - b.signed_distance(near)], 0.0)
        }
        (Surface::Cylinder(a), Surface::Cylinder(b)) => {
            (vec![across(&a.axis, &b.axis), a.radius - b.radius], 0.0)
        }
        (Surface::Cone(a), Surface::Cone(b)) => {
            // Where their axes pass the data, the radii: a cone may be described at any height.
            let radius = |cone: &Cone| cone.radius + cone.axis.height(near) * cone.half_angle.tan();
            (vec![across(&a.axis, &b.axis), radius(a).abs() - radius(b).abs()], a.half_angle - b.half_angle)
        }
        (Surface::Sphere(a), Surface::Sphere(b)) => {
            (vec![(a.center - b.center).norm(), a.radius - b.radius], 0.0)
        }
        (Surface::Torus(a), Surface::Torus(b)) => (
            vec![
                (a.axis.origin - b.axis.origin).norm(),
                a.major_radius - b.major_radius,
                a.minor_radius - b.minor_radius,
            ],
            0.0,
        ),
        _ => (vec![f64::INFINITY], f64::INFINITY),
    };
    let length = lengths.iter().map(|x| x.abs()).fold(0.0, f64::max);
    Errors { length, angle: angle.abs().max(turn) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_is_where_the_sum_of_squares_is_least() {
        for reference in references().iter().filter(|r| !r.name.ends_with("far away")) {
            let sum = |surface: &Surface| -> f64 {
                reference.samples.points.iter().map(|p| surface.signed_distance(p).powi(2)).sum()
            };
            let least = sum(&reference.surface);
            let n = reference.samples.points.len() as f64;
            assert!(
                (least / n).sqrt() > 0.9 * DEVIATION,
                "{}: the points are off the surface",
                reference.name
            );
            // Small motions in every direction, and a change of size: none is better.
            let center = centroid(&reference.samples.points).coords;
            for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
                for step in [-1e-5, 1e-5] {
                    let moved = reference.surface.transformed(&Rotation3::identity(), 1.0, &(axis * step));
                    let turn = Rotation3::new(axis * step);
                    let turned = reference.surface.transformed(&turn, 1.0, &(center - turn * center));
                    let grown =
                        reference.surface.transformed(&Rotation3::identity(), 1.0 + step, &(center * -step));
                    for other in [moved, turned, grown] {
                        assert!(sum(&other) > least - 1e-12, "{}: {other:?}", reference.name);
                    }
                }
            }
        }
    }

    #[test]
    fn fits_reach_the_answers() {
        for reference in references() {
            for method in [FitMethod::Robust, FitMethod::Lsge] {
                let errors = reference.errors(method).expect(&reference.name);
                assert!(errors.pass(), "{} by {}: {errors:?}", reference.name, method.name());
            }
        }
    }
}
