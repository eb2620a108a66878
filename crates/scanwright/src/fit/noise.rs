//! Noise of a scan along the normal, part of it white and part of it correlated over the surface, and what it makes of
//! the parameters of a fit.

use nalgebra::{DMatrix, DVector};

use super::Samples;
use super::covariance::{distance_by_parameters, parameter_frame, parameter_names};
use crate::math::{Point3, centroid};
use crate::surface::Surface;

/// Standard deviations of the two kinds of noise.
///
/// Two vertices at a distance d share `correlated^2 exp(-(d / length)^2)`.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Noise {
    /// Of the noise that every vertex has of its own, length.
    pub white: f64,
    /// Of the noise that neighbours share, length.
    pub correlated: f64,
    /// Distance over which they share it: correlation falls to 1/e, length.
    pub length: f64,
}

impl Noise {
    /// Standard deviation of one distance.
    pub fn sigma(&self) -> f64 {
        self.white.hypot(self.correlated)
    }

    /// So many times as much of both kinds.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self { white: self.white * factor, correlated: self.correlated * factor, ..*self }
    }

    /// Covariance of the distances of two vertices whose distance, squared, is given.
    fn shared(&self, distance_sq: f64) -> f64 {
        self.correlated * self.correlated * (-distance_sq / (self.length * self.length)).exp()
    }
}

/// Samples that the double sum over pairs takes: its error falls with their number, its cost rises with the square.
const N_PAIRED: usize = 600;

/// Covariance of the parameters of `surface`, fitted by least squares to `samples` that stand for `n_vertices` of a scan
/// with these noises together; in the order of [`parameter_names`], motions about the centroid of the samples.
///
/// With J the derivatives of the distances and S their covariance it is `(J^T J)^-1 J^T S J (J^T J)^-1`: least squares does
/// not know of the correlation, and the result says what that costs (A. Aitken, "On least squares and linear combination of
/// observations", Proceedings of the Royal Society of Edinburgh 55 (1936), 42-48). `bias`: an error of each distance that
/// all vertices share up to this factor, as a systematic contribution. Empty when the data leave a parameter unobserved.
pub fn correlated_covariance(
    surface: &Surface,
    samples: &Samples,
    n_vertices: usize,
    noises: &[Noise],
    bias: impl Fn(&Point3) -> f64,
) -> Vec<Vec<f64>> {
    let few = samples.thinned(N_PAIRED);
    let n = few.points.len();
    let frame = parameter_frame(surface, centroid(&samples.points));
    let names = parameter_names(surface).len();
    let mut jacobian = DMatrix::zeros(n, names);
    for (i, point) in few.points.iter().enumerate() {
        jacobian.set_row(i, &distance_by_parameters(surface, &frame, point).transpose());
    }
    let Some(inverse) = (jacobian.transpose() * &jacobian).cholesky().map(|c| c.inverse()) else {
        return Vec::new();
    };
    // A sample stands for vertices beside it: their own noise is averaged, what they share is not.
    let averaged = n as f64 / n_vertices.max(n) as f64;
    let own: f64 = noises.iter().map(|of| of.white.powi(2) * averaged + of.correlated.powi(2)).sum();
    let shared = DMatrix::from_fn(n, n, |i, j| {
        let distance_sq = (few.points[i] - few.points[j]).norm_squared();
        if i == j { own } else { noises.iter().map(|of| of.shared(distance_sq)).sum() }
    });
    let shared_error = DVector::from_iterator(n, few.points.iter().map(bias));
    let gain = &inverse * jacobian.transpose();
    let moved = &gain * shared_error;
    let covariance = &gain * shared * gain.transpose() + &moved * moved.transpose();
    if covariance.iter().any(|x| !x.is_finite()) || (0..names).any(|i| covariance[(i, i)] <= 0.0) {
        return Vec::new();
    }
    (0..names)
        .map(|i| (0..names).map(|j| 0.5 * (covariance[(i, j)] + covariance[(j, i)])).collect())
        .collect()
}
