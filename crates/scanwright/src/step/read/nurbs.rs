//! Rational B-splines of any degree: points and derivatives.
//!
//! Basis functions by the recursion of M. G. Cox and C. de Boor, derivatives from those of lower degree (L. Piegl,
//! W. Tiller, "The NURBS Book", Springer 1997, sections 2.2, 2.3 and 4.3).

use crate::math::{Point3, Vec3};

/// A point with the first and second derivatives.
pub(super) type Jet1 = (Point3, Vec3, Vec3);

/// Knots and degree of one parameter.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Knots {
    pub(super) degree: usize,
    /// Non-decreasing; as many as poles, plus the degree, plus one.
    pub(super) values: Vec<f64>,
}

/// A homogeneous pole: weight times position, and weight.
pub(super) type Pole = nalgebra::Vector4<f64>;

/// A B-spline curve.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NurbsCurve {
    pub(super) knots: Knots,
    pub(super) poles: Vec<Pole>,
}

/// A B-spline surface.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NurbsSurface {
    pub(super) u: Knots,
    pub(super) v: Knots,
    /// `poles[i * n_v + j]`.
    pub(super) poles: Vec<Pole>,
}

impl Knots {
    pub(super) fn n_poles(&self) -> usize {
        self.values.len() - self.degree - 1
    }

    /// First and last parameter.
    pub(super) fn range(&self) -> (f64, f64) {
        (self.values[self.degree], self.values[self.n_poles()])
    }

    /// Distinct knots within the range, its ends among them.
    pub(super) fn breaks(&self) -> Vec<f64> {
        let (low, high) = self.range();
        let mut breaks: Vec<f64> = self.values.iter().copied().filter(|t| (low..=high).contains(t)).collect();
        breaks.dedup();
        breaks
    }

    /// Index of the first basis function that is not zero at `t`, and their values, derivatives and second
    /// derivatives: `degree + 1` of each.
    fn basis(&self, t: f64) -> (usize, [Vec<f64>; 3]) {
        let p = self.degree;
        let (low, high) = self.range();
        let t = t.clamp(low, high);
        let after = self.values.partition_point(|knot| *knot <= t);
        // At the end the last span that has a length.
        let mut span = after.saturating_sub(1).clamp(p, self.n_poles() - 1);
        while span > p && self.values[span] >= self.values[span + 1] {
            span -= 1;
        }
        let of_degree = |degree: usize| self.values_at(span, t, degree);
        let values = of_degree(p);
        let first = if p >= 1 { self.derivative(span, p, &of_degree(p - 1)) } else { vec![0.0] };
        let second = if p >= 2 {
            let lower = self.derivative(span, p - 1, &of_degree(p - 2));
            self.derivative(span, p, &lower)
        } else {
            vec![0.0; p + 1]
        };
        (span - p, [values, first, second])
    }

    /// Values of the `degree + 1` basis functions that are not zero in a span.
    fn values_at(&self, span: usize, t: f64, degree: usize) -> Vec<f64> {
        let knots = &self.values;
        let mut values = vec![1.0];
        for k in 1..=degree {
            let mut next = vec![0.0; k + 1];
            for (r, value) in values.iter().enumerate() {
                let (left, right) = (knots[span + 1 + r - k], knots[span + 1 + r]);
                let share = if right > left { value / (right - left) } else { 0.0 };
                next[r] += (right - t) * share;
                next[r + 1] += (t - left) * share;
            }
            values = next;
        }
        values
    }

    /// Derivatives of the basis functions of `degree` from values (or derivatives) of those one degree lower.
    fn derivative(&self, span: usize, degree: usize, lower: &[f64]) -> Vec<f64> {
        let knots = &self.values;
        let mut out = vec![0.0; degree + 1];
        for (r, value) in lower.iter().enumerate() {
            let (left, right) = (knots[span + 1 + r - degree], knots[span + 1 + r]);
            let slope = if right > left { degree as f64 * value / (right - left) } else { 0.0 };
            out[r] -= slope;
            out[r + 1] += slope;
        }
        out
    }
}

impl NurbsCurve {
    pub(super) fn jet(&self, t: f64) -> Jet1 {
        let (first, weights) = self.knots.basis(t);
        let sum = |k: usize| -> Pole {
            weights[k].iter().zip(&self.poles[first..]).map(|(w, pole)| pole * *w).sum()
        };
        let (a, a1, a2) = (sum(0), sum(1), sum(2));
        let p = a.xyz() / a.w;
        let d = (a1.xyz() - p * a1.w) / a.w;
        let dd = (a2.xyz() - d * (2.0 * a1.w) - p * a2.w) / a.w;
        (Point3::from(p), d, dd)
    }
}

impl NurbsSurface {
    /// The point and the two first derivatives.
    pub(super) fn jet(&self, u: f64, v: f64) -> (Point3, Vec3, Vec3) {
        let (first_u, in_u) = self.u.basis(u);
        let (first_v, in_v) = self.v.basis(v);
        let n_v = self.v.n_poles();
        let (mut a, mut a_u, mut a_v) = (Pole::zeros(), Pole::zeros(), Pole::zeros());
        for (i, (w, w_u)) in in_u[0].iter().zip(&in_u[1]).enumerate() {
            let row = &self.poles[(first_u + i) * n_v + first_v..];
            for ((x, x_v), pole) in in_v[0].iter().zip(&in_v[1]).zip(row) {
                a += pole * (w * x);
                a_u += pole * (w_u * x);
                a_v += pole * (w * x_v);
            }
        }
        let p = a.xyz() / a.w;
        let derivative = |d: Pole| (d.xyz() - p * d.w) / a.w;
        (Point3::from(p), derivative(a_u), derivative(a_v))
    }

    /// The same surface with its parameters exchanged.
    pub(super) fn transposed(&self) -> Self {
        let (n_u, n_v) = (self.u.n_poles(), self.v.n_poles());
        let poles = (0..n_v).flat_map(|j| (0..n_u).map(move |i| (i, j)));
        let poles = poles.map(|(i, j)| self.poles[i * n_v + j]).collect();
        Self { u: self.v.clone(), v: self.u.clone(), poles }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of the unit circle, exactly.
    fn quarter() -> NurbsCurve {
        let w = 0.5_f64.sqrt();
        let poles =
            vec![Pole::new(1.0, 0.0, 0.0, 1.0), Pole::new(w, w, 0.0, w), Pole::new(0.0, 1.0, 0.0, 1.0)];
        NurbsCurve { knots: Knots { degree: 2, values: vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0] }, poles }
    }

    #[test]
    fn a_rational_quarter_is_on_the_circle_and_its_derivatives_are_its_differences() {
        let curve = quarter();
        for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let (p, d, dd) = curve.jet(t);
            assert!((p.coords.norm() - 1.0).abs() < 1e-15);
            let h = 1e-4;
            if (h..1.0 - h).contains(&t) {
                let (a, b) = (curve.jet(t - h).0, curve.jet(t + h).0);
                assert!(((b - a) / (2.0 * h) - d).norm() < 1e-6);
                assert!(((b.coords + a.coords - 2.0 * p.coords) / (h * h) - dd).norm() < 1e-5);
            }
        }
    }
}
