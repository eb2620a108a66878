//! How well a primitive's own points show its direction.
//!
//! The covariance that comes with a primitive is that of its fit, which leaves out every point that the rounding of
//! an edge might have moved; for narrow faces that is nearly all of them, and the uncertainty said is several times the
//! error made. A test of relations needs the error that is really made: all vertices inside the region count, under the
//! noise that was measured (`uncertainty`).

use nalgebra::{DMatrix, DVector, Matrix2, Matrix3x2, Rotation3};

use super::directions::Direction;
use crate::fit::{
    Noise, Samples, VERTICES_PER_SAMPLE, correlated_covariance, distance_by_parameters, parameter_names,
};
use crate::math::{Frame, Mat3, Point3, UnitVec3, Vec3, angle_between, centroid};
use crate::mesh::Mesh;
use crate::recognize::Primitive;
use crate::surface::Surface;
use crate::tolerance::Tolerances;

/// Fewer vertices show no direction.
const MIN_VERTICES: usize = 8;
/// Samples of the information matrix, spread over the region: its shape needs no more.
const N_SAMPLES: usize = 4000;

/// Raw points of one primitive and what they say about its parameters.
#[derive(Debug)]
pub(super) struct Evidence {
    /// Points inside the region.
    pub samples: Samples,
    /// Their centroid with the direction, if the surface has one, as third axis: what `covariance` refers to.
    pub frame: Frame,
    /// Variance of one distance, as if the samples were independent.
    variance: f64,
    /// Covariance of the parameters in the order of `fit::parameter_names`.
    pub covariance: DMatrix<f64>,
    /// Place of the two tilts in it; a sphere has none.
    pub tilt: Option<usize>,
}

impl Evidence {
    /// The evidence of a primitive; `None` when it has no surface or its points do not show that.
    pub fn new(
        mesh: &Mesh,
        primitive: &Primitive,
        vertices: &[u32],
        noise: &Noise,
        rounding: Noise,
        tolerances: &Tolerances,
    ) -> Option<Self> {
        let surface = primitive.surface.as_ref()?;
        let tilt = parameter_names(surface).iter().position(|name| *name == "tilt_x");
        if vertices.len() < MIN_VERTICES {
            return None;
        }
        let points: Vec<Point3> = vertices.iter().map(|&v| mesh.vertices[v as usize]).collect();
        let normals = points.iter().map(|p| surface.normal(p).into_inner()).collect();
        let samples = Samples { points, normals }.thinned(N_SAMPLES);
        let sigma = primitive.residual.rms.max(tolerances.noise()).max(tolerances.rounding());
        let n_effective = (vertices.len() as f64 / VERTICES_PER_SAMPLE).max(1.0);
        let variance = sigma * sigma * samples.points.len() as f64 / n_effective;
        let misfit = (sigma / noise.sigma()).max(1.0);
        let noises = [noise.times(misfit), rounding];
        let rows = correlated_covariance(surface, &samples, vertices.len(), &noises, |_| 0.0);
        let covariance = DMatrix::from_fn(rows.len(), rows.len(), |i, j| rows[i][j]);
        if covariance.is_empty() {
            return None;
        }
        let origin = centroid(&samples.points);
        let frame = match direction_of(surface) {
            Some(direction) => Frame::from_z(origin, direction),
            None => Frame { origin, x: Vec3::x_axis(), y: Vec3::y_axis(), z: Vec3::z_axis() },
        };
        Some(Self { samples, frame, variance, covariance, tilt })
    }

    /// The direction with its covariance. `form_angle`: what real faces deviate by from their design, radians.
    pub fn direction(&self, form_angle: f64) -> Option<Direction> {
        let tilt = self.tilt?;
        let tilts: Matrix2<f64> = self.covariance.fixed_view::<2, 2>(tilt, tilt).into_owned();
        let tilts = tilts + Matrix2::identity() * (form_angle * form_angle);
        Some(Direction { unit: self.frame.z, covariance: covariance_of_direction(&self.frame, &tilts) })
    }

    /// Root mean square distance of the samples from their middle, length.
    pub fn reach(&self) -> f64 {
        let points = &self.samples.points;
        let sum: f64 = points.iter().map(|p| (p - self.frame.origin).norm_squared()).sum();
        (sum / points.len() as f64).sqrt()
    }

    /// Information that no parameter lies farther from its fit than about a vertex spacing, one per parameter.
    ///
    /// A parameter that hardly shows follows a turn by many times that (the centre of a tube of which a narrow band
    /// was seen): the distances of the points, which it hardly changes, do not object. With this it stays, and those
    /// seen better than a spacing follow as before.
    fn nearness(&self, surface: &Surface, spacing: f64) -> DVector<f64> {
        let names = parameter_names(surface);
        DVector::from_iterator(
            names.len(),
            names.iter().map(|name| match *name {
                "tilt_x" | "tilt_y" | "half_angle" => (self.reach() / spacing).powi(2),
                _ => spacing.powi(-2),
            }),
        )
    }

    /// How a surface that became `moved` from `fitted`, its parameters by `by`, is to be corrected by Gauss and Newton
    /// so that the distances of the points change least, given that the combinations `fixed` of parameters stay: the
    /// step, and the cost it starts from. `spacing` of the vertices: see [`Self::nearness`].
    pub fn correction(
        &self,
        fitted: &Surface,
        moved: &Surface,
        by: &DVector<f64>,
        fixed: &DMatrix<f64>,
        spacing: f64,
    ) -> Option<(DVector<f64>, f64)> {
        let near = self.nearness(fitted, spacing);
        let weight = 1.0 / self.variance;
        let mut information = DMatrix::from_diagonal(&near);
        let mut gradient = near.component_mul(by);
        let mut cost = gradient.dot(by);
        for point in &self.samples.points {
            let change = moved.signed_distance(point) - fitted.signed_distance(point);
            let row = distance_by_parameters(moved, &self.frame, point);
            information.ger(weight, &row, &row, 1.0);
            gradient.axpy(weight * change, &row, 1.0);
            cost += weight * change * change;
        }
        let covariance = information.try_inverse()?;
        let cross = &covariance * fixed.transpose();
        let free = &covariance - &cross * (fixed * &cross).try_inverse()? * cross.transpose();
        Some((-(free * gradient), cost))
    }

    /// Variance of a parameter given those of `fixed`.
    pub fn variance_given(&self, parameter: usize, fixed: &[usize]) -> Option<f64> {
        let own = self.covariance[(parameter, parameter)];
        let fixed: Vec<usize> = fixed.iter().copied().filter(|&k| k != parameter).collect();
        let n = fixed.len();
        if n == 0 {
            return Some(own);
        }
        let cross = DVector::from_fn(n, |i, _| self.covariance[(parameter, fixed[i])]);
        let block = DMatrix::from_fn(n, n, |i, j| self.covariance[(fixed[i], fixed[j])]);
        let explained = cross.dot(&block.cholesky()?.solve(&cross));
        Some(own - explained).filter(|variance| *variance > 0.0)
    }

    /// Root mean square distance of the samples from a surface, length.
    pub fn rms(&self, surface: &Surface) -> f64 {
        let points = &self.samples.points;
        let sum: f64 = points.iter().map(|p| surface.signed_distance(p).powi(2)).sum();
        (sum / points.len() as f64).sqrt()
    }

    /// Where the axis or the centre of `surface` is; `None` for a plane.
    pub fn position(&self, surface: &Surface) -> Option<Position> {
        let along = Matrix3x2::from_columns(&[self.frame.x.into_inner(), self.frame.y.into_inner()]);
        let (point, covariance, by_turn) = match (surface, self.tilt) {
            (Surface::Sphere(sphere), _) => {
                (sphere.center, self.covariance.fixed_view::<3, 3>(0, 0).into_owned(), None)
            }
            (_, Some(tilt)) => {
                let tilts: Matrix2<f64> = self.covariance.fixed_view::<2, 2>(tilt, tilt).into_owned();
                let offsets: Matrix2<f64> = self.covariance.fixed_view::<2, 2>(0, 0).into_owned();
                let cross: Matrix2<f64> = self.covariance.fixed_view::<2, 2>(0, tilt).into_owned();
                let by_tilt = cross * tilts.try_inverse()?;
                let given = offsets - by_tilt * cross.transpose();
                let by_turn = along * by_tilt * along.transpose();
                (surface.axis()?.foot(&self.frame.origin), along * given * along.transpose(), Some(by_turn))
            }
            (_, None) => return None,
        };
        Some(Position { frame: self.frame, point, covariance, by_turn, reach: self.reach() })
    }
}

/// Where an axis or a centre is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Position {
    frame: Frame,
    /// The centre, or the point of the axis beside the middle of the samples.
    point: Point3,
    /// Covariance of `point`, given the direction of the axis.
    pub covariance: Mat3,
    /// What the point of the axis moves by when that turns, per radian; `None` for a centre.
    by_turn: Option<Mat3>,
    /// Root mean square distance of the samples from their middle, length.
    pub reach: f64,
}

impl Position {
    /// Whether it is that of an axis.
    pub fn is_axis(&self) -> bool {
        self.by_turn.is_some()
    }

    /// The most probable point given that the axis has the direction `unit`, up to sign, and its derivative by that.
    pub fn given(&self, unit: &UnitVec3) -> (Point3, Mat3) {
        let Some(by_turn) = self.by_turn else { return (self.point, Mat3::zeros()) };
        let turn = turn_to(&self.frame.z, unit);
        let pivot = self.frame.origin;
        let point = pivot + Rotation3::new(turn) * (self.point - pivot) + by_turn * turn;
        // A direction that moves by u turns by unit x u.
        (point, by_turn * unit.cross_matrix())
    }
}

/// The shortest turn that takes the line of `from` to that of `to`, as a rotation vector.
pub(super) fn turn_to(from: &UnitVec3, to: &UnitVec3) -> Vec3 {
    let to = UnitVec3::new_unchecked(to.into_inner() * if from.dot(to) < 0.0 { -1.0 } else { 1.0 });
    let axis = from.cross(&to);
    let sin = axis.norm();
    if sin > 0.0 { axis * (angle_between(from, &to) / sin) } else { Vec3::zeros() }
}

/// Covariance of the third direction of `frame` when it is tilted about the first two with covariance `tilts`.
fn covariance_of_direction(frame: &Frame, tilts: &Matrix2<f64>) -> Mat3 {
    let moves = moves(frame);
    moves * tilts * moves.transpose()
}

/// What tilts about the first two directions of `frame` move the third by: a turn by omega moves z by omega x z.
pub(super) fn moves(frame: &Frame) -> Matrix3x2<f64> {
    Matrix3x2::from_columns(&[-frame.y.into_inner(), frame.x.into_inner()])
}

/// Normal of a plane, axis of a cylinder, cone or torus.
pub(super) fn direction_of(surface: &Surface) -> Option<UnitVec3> {
    match surface {
        Surface::Plane(plane) => Some(plane.normal),
        _ => surface.axis().map(|axis| axis.direction),
    }
}
