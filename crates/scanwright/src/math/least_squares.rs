//! Small dense nonlinear least squares.
//!
//! Levenberg-Marquardt with Marquardt's diagonal scaling on the normal equations of at most eight unknowns.
//! K. Levenberg, Quarterly of Applied Mathematics 2 (1944), 164-168; D. Marquardt, Journal of the Society for
//! Industrial and Applied Mathematics 11 (1963), 431-441.

use nalgebra::{SMatrix, SVector};

/// The quadratic model of a cost at one state: gradient and Gauss-Newton Hessian.
#[derive(Debug, Clone)]
pub struct Normal<const N: usize> {
    /// `J^T W r`.
    pub gradient: SVector<f64, N>,
    /// `J^T W J`.
    pub hessian: SMatrix<f64, N, N>,
    /// `sum rho(r)`.
    pub cost: f64,
}

impl<const N: usize> Normal<N> {
    /// An empty sum.
    pub fn zero() -> Self {
        Self { gradient: SVector::zeros(), hessian: SMatrix::zeros(), cost: 0.0 }
    }

    /// Adds residuals that share a weight, with their Jacobian rows. Their share of the cost is the caller's to add.
    ///
    /// Fits spend most of their time here: plain loops over whole columns become vector instructions.
    #[inline]
    pub fn add<const R: usize>(&mut self, residuals: [f64; R], rows: &[[f64; N]; R], weight: f64) {
        let columns = self.hessian.as_mut_slice().as_chunks_mut::<N>().0;
        for (j, column) in columns.iter_mut().enumerate() {
            let mut sums = *column;
            for row in rows {
                let scaled = row[j] * weight;
                for (sum, entry) in sums.iter_mut().zip(row) {
                    *sum += scaled * entry;
                }
            }
            *column = sums;
        }
        for (row, residual) in rows.iter().zip(residuals) {
            let scaled = weight * residual;
            for (sum, entry) in self.gradient.iter_mut().zip(row) {
                *sum += scaled * entry;
            }
        }
    }
}

/// Why an iteration stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The cost no longer falls by more than the relative tolerance.
    Converged,
    /// The maximum number of iterations was reached.
    MaxIterations,
    /// No step reduces the cost.
    Stalled,
}

/// Relative fall of the cost below which further steps cannot matter beside the noise.
pub const RELATIVE_FALL: f64 = 1e-7;

/// Minimizes a cost over a state that moves by `N`-vectors (its retraction).
///
/// `linearize` gives the normal equations at a state, `retract` applies a step. Stops when the cost falls by less
/// than a ten-millionth of itself, or after `max_iterations`.
pub fn minimize<const N: usize, S: Clone>(
    start: S,
    max_iterations: usize,
    linearize: impl Fn(&S) -> Normal<N>,
    retract: impl Fn(&S, &SVector<f64, N>) -> Option<S>,
) -> (S, Normal<N>, Stop) {
    minimize_to(RELATIVE_FALL, start, max_iterations, linearize, retract)
}

/// The same, until the cost falls by less than a share of itself: zero goes on until rounding ends it.
pub fn minimize_to<const N: usize, S: Clone>(
    relative_fall: f64,
    start: S,
    max_iterations: usize,
    linearize: impl Fn(&S) -> Normal<N>,
    retract: impl Fn(&S, &SVector<f64, N>) -> Option<S>,
) -> (S, Normal<N>, Stop) {
    /// Nearly a Gauss-Newton step: starts are good, and a step that fails raises it.
    const FIRST_DAMPING: f64 = 1e-4;
    /// Below this it changes no digit, and raising it from zero would never bring it back.
    const LEAST_DAMPING: f64 = 1e-12;
    let mut state = start;
    let mut model = linearize(&state);
    let mut damping = FIRST_DAMPING;
    for _ in 0..max_iterations {
        let mut stepped = false;
        for _ in 0..8 {
            if let Some((next, next_model)) = attempt(&state, &model, damping, &linearize, &retract) {
                let fall = model.cost - next_model.cost;
                let enough = fall > relative_fall * model.cost;
                state = next;
                model = next_model;
                damping = (damping * 0.2).max(LEAST_DAMPING);
                stepped = true;
                if !enough {
                    return (state, model, Stop::Converged);
                }
                break;
            }
            damping *= 8.0;
        }
        if !stepped {
            return (state, model, Stop::Stalled);
        }
    }
    (state, model, Stop::MaxIterations)
}

fn attempt<const N: usize, S: Clone>(
    state: &S,
    model: &Normal<N>,
    damping: f64,
    linearize: &impl Fn(&S) -> Normal<N>,
    retract: &impl Fn(&S, &SVector<f64, N>) -> Option<S>,
) -> Option<(S, Normal<N>)> {
    /// Share of the trace that keeps unobservable directions from making the system singular.
    const UNSHOWN: f64 = 1e-12;
    let mut damped = model.hessian;
    let trace = damped.trace().max(f64::MIN_POSITIVE);
    for i in 0..N {
        damped[(i, i)] += damping * damped[(i, i)] + UNSHOWN * trace;
    }
    let step = solve_spd(damped, -model.gradient)?;
    let next = retract(state, &step)?;
    let next_model = linearize(&next);
    (next_model.cost.is_finite() && next_model.cost <= model.cost).then_some((next, next_model))
}

/// Solves a symmetric positive definite system by Cholesky decomposition, `None` when it is not one.
pub fn solve_spd<const N: usize>(
    mut a: SMatrix<f64, N, N>,
    mut b: SVector<f64, N>,
) -> Option<SVector<f64, N>> {
    for j in 0..N {
        for k in 0..j {
            let l_jk = a[(j, k)];
            for i in j..N {
                a[(i, j)] -= a[(i, k)] * l_jk;
            }
        }
        let pivot = a[(j, j)];
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let root = pivot.sqrt();
        for i in j..N {
            a[(i, j)] /= root;
        }
    }
    for i in 0..N {
        for k in 0..i {
            b[i] -= a[(i, k)] * b[k];
        }
        b[i] /= a[(i, i)];
    }
    for i in (0..N).rev() {
        for k in i + 1..N {
            b[i] -= a[(k, i)] * b[k];
        }
        b[i] /= a[(i, i)];
    }
    Some(b)
}
