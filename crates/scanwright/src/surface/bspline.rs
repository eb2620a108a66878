//! Cubic B-spline curves and bicubic B-spline surfaces with clamped knots.
//!
//! Basis functions by the triangular scheme of C. de Boor, "On calculating with B-splines", Journal of Approximation
//! Theory 6 (1972), 50-62; interpolation with averaged knots after L. Piegl and W. Tiller, "The NURBS Book", Springer
//! 1997, section 9.2. The collocation matrix is totally positive, so its banded elimination needs no pivoting.
//! Cost O(n) for a curve of n points.

use crate::math::{Point3, Vec3};

/// Degree of every spline here.
pub const DEGREE: usize = 3;

/// A clamped cubic B-spline curve.
#[derive(Debug, Clone, PartialEq)]
pub struct SplineCurve {
    /// Non-decreasing, the first and last four equal; `poles.len() + 4` of them.
    pub knots: Vec<f64>,
    /// Control points, at least four.
    pub poles: Vec<Point3>,
}

/// A clamped bicubic B-spline surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SplineSurface {
    /// Knots of the first parameter.
    pub knots_u: Vec<f64>,
    /// Knots of the second parameter.
    pub knots_v: Vec<f64>,
    /// Control points: `poles[i * n_v + j]`, `n_v = knots_v.len() - 4`.
    pub poles: Vec<Point3>,
}

impl SplineCurve {
    /// The curve through `points` with chord-length parameters in [0, 1]; fewer than four points, or coinciding
    /// neighbours, give `None`.
    pub fn interpolate(points: &[Point3]) -> Option<Self> {
        let n = points.len();
        if n <= DEGREE {
            return None;
        }
        let parameters = chord_parameters(points)?;
        let mut knots = vec![0.0; DEGREE + 1];
        for j in 1..n - DEGREE {
            knots.push(parameters[j..j + DEGREE].iter().sum::<f64>() / DEGREE as f64);
        }
        knots.extend([1.0; DEGREE + 1]);
        let poles = solve_collocation(&knots, &parameters, points)?;
        Some(Self { knots, poles })
    }

    /// The point at parameter `t`, clamped to the curve's domain.
    pub fn point(&self, t: f64) -> Point3 {
        let t = t.clamp(0.0, 1.0);
        let span = find_span(&self.knots, t);
        let basis = basis(&self.knots, span, t);
        let sum =
            (0..=DEGREE).fold(Vec3::zeros(), |s, k| s + self.poles[span - DEGREE + k].coords * basis[k]);
        Point3::from(sum)
    }
}

impl SplineSurface {
    /// Number of poles in each direction.
    pub fn n_poles(&self) -> (usize, usize) {
        (self.knots_u.len() - DEGREE - 1, self.knots_v.len() - DEGREE - 1)
    }

    /// The point at `(u, v)`, clamped to the unit square, with both first derivatives.
    pub fn point_and_derivatives(&self, u: f64, v: f64) -> (Point3, Vec3, Vec3) {
        let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
        let (su, sv) = (find_span(&self.knots_u, u), find_span(&self.knots_v, v));
        let (bu, bv) = (basis(&self.knots_u, su, u), basis(&self.knots_v, sv, v));
        let (du, dv) = (basis_derivative(&self.knots_u, su, u), basis_derivative(&self.knots_v, sv, v));
        let n_v = self.n_poles().1;
        let (mut point, mut along_u, mut along_v) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
        for i in 0..=DEGREE {
            for j in 0..=DEGREE {
                let pole = self.poles[(su - DEGREE + i) * n_v + sv - DEGREE + j].coords;
                point += pole * (bu[i] * bv[j]);
                along_u += pole * (du[i] * bv[j]);
                along_v += pole * (bu[i] * dv[j]);
            }
        }
        (Point3::from(point), along_u, along_v)
    }

    /// The point at `(u, v)`.
    pub fn point(&self, u: f64, v: f64) -> Point3 {
        self.point_and_derivatives(u, v).0
    }

    /// Parameters of a point of the surface close to `target`, by Gauss and Newton from `start`.
    pub fn project(&self, target: &Point3, start: (f64, f64)) -> (f64, f64) {
        /// Newton from a start in the same knot span converges in a handful of steps.
        const MAX_STEPS: usize = 12;
        let (mut u, mut v) = start;
        for _ in 0..MAX_STEPS {
            let (point, a, b) = self.point_and_derivatives(u, v);
            let offset = target - point;
            let (aa, ab, bb) = (a.dot(&a), a.dot(&b), b.dot(&b));
            let det = aa * bb - ab * ab;
            if det.is_nan() || det <= 0.0 {
                break;
            }
            let (ra, rb) = (a.dot(&offset), b.dot(&offset));
            let (step_u, step_v) = ((bb * ra - ab * rb) / det, (aa * rb - ab * ra) / det);
            let next = ((u + step_u).clamp(0.0, 1.0), (v + step_v).clamp(0.0, 1.0));
            let change = (next.0 - u).abs() + (next.1 - v).abs();
            (u, v) = next;
            if change <= f64::EPSILON.sqrt() {
                break;
            }
        }
        (u, v)
    }
}

/// Uniform clamped knots on [0, 1] for `n_poles` poles.
pub fn uniform_knots(n_poles: usize) -> Vec<f64> {
    let n_spans = n_poles - DEGREE;
    let mut knots = vec![0.0; DEGREE];
    knots.extend((0..=n_spans).map(|i| i as f64 / n_spans as f64));
    knots.extend([1.0; DEGREE]);
    knots
}

/// Index `i` with `knots[i] <= t < knots[i + 1]`, the last non-empty span at the end.
pub fn find_span(knots: &[f64], t: f64) -> usize {
    let n_poles = knots.len() - DEGREE - 1;
    let above = knots[..n_poles].partition_point(|k| *k <= t);
    above.clamp(DEGREE + 1, n_poles) - 1
}

/// The four cubic basis functions that are not zero on a span.
pub fn basis(knots: &[f64], span: usize, t: f64) -> [f64; DEGREE + 1] {
    basis_of_degree(knots, span, t, DEGREE)
}

/// First derivatives of the four basis functions that are not zero on a span.
pub fn basis_derivative(knots: &[f64], span: usize, t: f64) -> [f64; DEGREE + 1] {
    let lower = basis_of_degree(knots, span, t, DEGREE - 1);
    let scaled: Vec<f64> = (0..DEGREE)
        .map(|k| {
            let i = span + k + 1 - DEGREE;
            lower[k] * DEGREE as f64 / (knots[i + DEGREE] - knots[i])
        })
        .collect();
    [-scaled[0], scaled[0] - scaled[1], scaled[1] - scaled[2], scaled[2]]
}

fn basis_of_degree(knots: &[f64], span: usize, t: f64, degree: usize) -> [f64; DEGREE + 1] {
    let mut values = [0.0; DEGREE + 1];
    values[0] = 1.0;
    for d in 1..=degree {
        let mut saved = 0.0;
        for r in 0..d {
            let (left, right) = (knots[span + r + 1 - d], knots[span + r + 1]);
            let share = values[r] / (right - left);
            values[r] = saved + (right - t) * share;
            saved = (t - left) * share;
        }
        values[d] = saved;
    }
    values
}

/// Chord-length parameters in [0, 1]; `None` when neighbours coincide.
fn chord_parameters(points: &[Point3]) -> Option<Vec<f64>> {
    let mut lengths = vec![0.0];
    for pair in points.windows(2) {
        let step = (pair[1] - pair[0]).norm();
        let last = lengths[lengths.len() - 1];
        if step.is_nan() || last + step <= last {
            return None;
        }
        lengths.push(last + step);
    }
    let total = lengths[lengths.len() - 1];
    let mut parameters: Vec<f64> = lengths.iter().map(|l| l / total).collect();
    *parameters.last_mut()? = 1.0;
    Some(parameters)
}

/// Poles that take the values `points` at `parameters`: elimination in a band of half-width three.
fn solve_collocation(knots: &[f64], parameters: &[f64], points: &[Point3]) -> Option<Vec<Point3>> {
    let n = points.len();
    let mut rows = vec![[0.0; 2 * DEGREE + 1]; n];
    for (i, &t) in parameters.iter().enumerate() {
        let span = find_span(knots, t);
        for (k, value) in basis(knots, span, t).into_iter().enumerate() {
            let column = span - DEGREE + k;
            if let Some(place) = (column + DEGREE).checked_sub(i).filter(|p| *p <= 2 * DEGREE) {
                rows[i][place] = value;
            } else if value.abs() > 0.0 {
                return None;
            }
        }
    }
    let mut right: Vec<Vec3> = points.iter().map(|p| p.coords).collect();
    for i in 0..n {
        let pivot = rows[i][DEGREE];
        if pivot.is_nan() || pivot.abs() <= f64::EPSILON {
            return None;
        }
        for j in i + 1..(i + DEGREE + 1).min(n) {
            let factor = rows[j][DEGREE + i - j] / pivot;
            for column in i..(i + DEGREE + 1).min(n) {
                let value = rows[i][column + DEGREE - i];
                rows[j][column + DEGREE - j] -= factor * value;
            }
            let pivot_right = right[i];
            right[j] -= pivot_right * factor;
        }
    }
    for i in (0..n).rev() {
        for column in i + 1..(i + DEGREE + 1).min(n) {
            let known = right[column];
            right[i] -= known * rows[i][column + DEGREE - i];
        }
        right[i] /= rows[i][DEGREE];
    }
    Some(right.into_iter().map(Point3::from).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_passes_through_its_points() {
        let points: Vec<Point3> =
            (0..12).map(|i| f64::from(i) * 0.3).map(|t| Point3::new(t.cos(), t.sin(), t * t)).collect();
        let curve = SplineCurve::interpolate(&points).unwrap();
        let parameters = chord_parameters(&points).unwrap();
        for (point, t) in points.iter().zip(parameters) {
            let off = (curve.point(t) - point).norm();
            assert!(off < 1e-12 * 12.0, "off by {off} at {t}");
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let knots = uniform_knots(6);
        let poles = (0..36).map(|i| {
            let (x, y) = (f64::from(i / 6), f64::from(i % 6));
            Point3::new(x, y, (0.3 * x * y).sin())
        });
        let surface = SplineSurface { knots_u: knots.clone(), knots_v: knots, poles: poles.collect() };
        let (step, at) = (1e-6, (0.37, 0.81));
        let (_, along_u, along_v) = surface.point_and_derivatives(at.0, at.1);
        let numeric_u = (surface.point(at.0 + step, at.1) - surface.point(at.0 - step, at.1)) / (2.0 * step);
        let numeric_v = (surface.point(at.0, at.1 + step) - surface.point(at.0, at.1 - step)) / (2.0 * step);
        // Central differences: error of order step^2 plus rounding over step.
        assert!((along_u - numeric_u).norm() < 1e-7, "{along_u} {numeric_u}");
        assert!((along_v - numeric_v).norm() < 1e-7, "{along_v} {numeric_v}");
    }
}
