//! What is known of many motions together, and what an exact relation between some of them adds.
//!
//! R. Kalman, "A new approach to linear filtering and prediction problems", Journal of Basic Engineering 82 (1960), 35-45.

use nalgebra::{DMatrix, DVector};

/// Derivative of a deviation by the four motions that it depends on.
pub(super) type Row = [(usize, f64); 4];

/// Mean and covariance of motions, two for each of many things.
#[derive(Debug, Clone)]
pub(super) struct Gaussian {
    pub moved: DVector<f64>,
    pub covariance: DMatrix<f64>,
}

impl Gaussian {
    /// Nothing has moved yet.
    pub fn new(covariance: DMatrix<f64>) -> Self {
        Self { moved: DVector::zeros(covariance.nrows()), covariance }
    }

    /// Variance of a deviation.
    pub fn variance(&self, row: &Row) -> f64 {
        let pairs = row.iter().flat_map(|&(i, x)| row.iter().map(move |&(j, y)| (i, j, x * y)));
        pairs.map(|(i, j, weight)| weight * self.covariance[(i, j)]).sum()
    }

    /// Makes a deviation zero, to first order.
    pub fn observe(&mut self, deviation: f64, row: &Row, variance: f64) {
        let mut effect = DVector::zeros(self.moved.len());
        for &(i, x) in row {
            effect.axpy(x, &self.covariance.column(i), 1.0);
        }
        self.moved.axpy(-deviation / variance, &effect, 1.0);
        self.covariance.ger(-1.0 / variance, &effect, &effect, 1.0);
    }
}
