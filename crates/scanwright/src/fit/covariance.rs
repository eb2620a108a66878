//! Uncertainty of fitted parameters.
//!
//! `Cov = sigma^2 (J^T J)^-1 N / N_eff` over the motions and shapes that the type can show. Motions it cannot show
//! are left out, so the matrix is regular unless the data themselves leave something unobserved.

use nalgebra::{DMatrix, DVector, SVector};

use super::Samples;
use crate::math::{Frame, Point3, Vec3, centroid};
use crate::surface::Surface;

/// Vertices of a scan per independent sample of its noise, which is correlated: twice what its correlation length asks
/// for, as that is not measured.
pub const VERTICES_PER_SAMPLE: f64 = 80.0;

/// Names of the parameters of a covariance matrix: the surface's motions that show (translations, length; tilts,
/// radians), then its shape.
pub fn parameter_names(surface: &Surface) -> &'static [&'static str] {
    match surface {
        Surface::Plane(_) => &["offset", "tilt_x", "tilt_y"],
        Surface::Sphere(_) => &["center_x", "center_y", "center_z", "radius"],
        Surface::Cylinder(_) => &["offset_x", "offset_y", "tilt_x", "tilt_y", "radius"],
        Surface::Cone(_) => &["offset_x", "offset_y", "tilt_x", "tilt_y", "radius", "half_angle"],
        Surface::Torus(_) => {
            &["offset_x", "offset_y", "offset_z", "tilt_x", "tilt_y", "major_radius", "minor_radius"]
        }
    }
}

/// The frame that motions of a surface are told in: about `pivot`, its third direction that of the surface's axis (plane:
/// its normal; sphere: the coordinate axes).
pub fn parameter_frame(surface: &Surface, pivot: Point3) -> Frame {
    match surface {
        Surface::Plane(s) => Frame::from_z(pivot, s.normal),
        Surface::Sphere(_) => {
            Frame { origin: pivot, x: Vec3::x_axis(), y: Vec3::y_axis(), z: Vec3::z_axis() }
        }
        Surface::Cylinder(s) => Frame::from_z(pivot, s.axis.direction),
        Surface::Cone(s) => Frame::from_z(pivot, s.axis.direction),
        Surface::Torus(s) => Frame::from_z(pivot, s.axis.direction),
    }
}

/// The surface after a step of its parameters, in the order of [`parameter_names`], motions about the origin of `frame`;
/// `None` when that leaves the shapes that exist.
pub fn stepped(surface: &Surface, frame: &Frame, step: &[f64]) -> Option<Surface> {
    let mut full = [0.0; 8];
    for (column, value) in columns(surface).iter().zip(step) {
        full[*column] = *value;
    }
    let along = |k: usize| {
        frame.x.into_inner() * full[k]
            + frame.y.into_inner() * full[k + 1]
            + frame.z.into_inner() * full[k + 2]
    };
    let (way, turn) = (along(0), along(3));
    let step = SVector::<f64, 8>::from([way.x, way.y, way.z, turn.x, turn.y, turn.z, full[6], full[7]]);
    let surface = super::refine::recentered(surface, &frame.origin);
    super::refine::moved(&surface, &step, &frame.origin)
}

/// Derivative of the distance of `point` by the parameters of `surface`, in the order of [`parameter_names`]: motions
/// about the origin of `frame`, along its directions and about them, then shapes.
pub fn distance_by_parameters(surface: &Surface, frame: &Frame, point: &Point3) -> DVector<f64> {
    let (columns, full) = (columns(surface), distance_by_motions(surface, frame, point));
    DVector::from_fn(columns.len(), |i, _| full[columns[i]])
}

/// Places in [`distance_by_motions`] of the parameters that the type can show.
fn columns(surface: &Surface) -> &'static [usize] {
    match surface {
        Surface::Plane(_) => &[2, 3, 4],
        Surface::Sphere(_) => &[0, 1, 2, 6],
        Surface::Cylinder(_) => &[0, 1, 3, 4, 6],
        Surface::Cone(_) => &[0, 1, 3, 4, 6, 7],
        Surface::Torus(_) => &[0, 1, 2, 3, 4, 6, 7],
    }
}

/// Derivative of the distance of `point` by translations x, y, z; turns x, y, z; shapes.
fn distance_by_motions(surface: &Surface, frame: &Frame, point: &Point3) -> SVector<f64, 8> {
    let jet = surface.jet(point);
    let turn = (point - frame.origin).cross(&jet.normal);
    SVector::<f64, 8>::from([
        -jet.normal.dot(&frame.x),
        -jet.normal.dot(&frame.y),
        -jet.normal.dot(&frame.z),
        -turn.dot(&frame.x),
        -turn.dot(&frame.y),
        -turn.dot(&frame.z),
        jet.distance_by_shape[0],
        jet.distance_by_shape[1],
    ])
}

/// Covariance of the parameters of `surface` fitted to `samples`, in the order of [`parameter_names`].
///
/// Motions are of the surface about the samples' centroid, in the frame whose third direction is the surface's axis
/// (plane: its normal; sphere: the coordinate axes). `sigma`: standard deviation of one distance, length.
/// `n_effective`: number of independent samples among them. Empty when the data leave a parameter unobserved.
pub fn parameter_covariance(
    surface: &Surface,
    samples: &Samples,
    sigma: f64,
    n_effective: f64,
) -> Vec<Vec<f64>> {
    let frame = parameter_frame(surface, centroid(&samples.points));
    let columns = columns(surface);
    let n = columns.len();
    let mut information = DMatrix::<f64>::zeros(n, n);
    for point in &samples.points {
        let full = distance_by_motions(surface, &frame, point);
        for (i, &a) in columns.iter().enumerate() {
            for (j, &b) in columns.iter().enumerate() {
                information[(i, j)] += full[a] * full[b];
            }
        }
    }
    let inflation = samples.points.len() as f64 / n_effective.max(1.0);
    information
        .cholesky()
        .map(|c| c.inverse() * (sigma * sigma * inflation))
        .filter(|c| c.iter().all(|x| x.is_finite()))
        .map(|c| (0..n).map(|i| (0..n).map(|j| c[(i, j)]).collect()).collect())
        .unwrap_or_default()
}
