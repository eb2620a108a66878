//! The circle nearest to points of a plane.

use super::{Mat3, Vec3};

/// Centre and radius of the circle from which weighted points, (weight, x, y) each, are nearest in the algebraic
/// sense: the squares of their powers are least. `None` when they lie on a line.
///
/// I. Kasa, "A circle fitting procedure and its error analysis", IEEE Transactions on Instrumentation and Measurement
/// 25 (1976), 8-14. Short noisy arcs give radii that are too small.
pub fn nearest_circle(points: impl Iterator<Item = (f64, f64, f64)>) -> Option<([f64; 2], f64)> {
    let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
    for (weight, x, y) in points {
        let row = Vec3::new(2.0 * x, 2.0 * y, 1.0);
        matrix += row * row.transpose() * weight;
        right += row * (weight * (x * x + y * y));
    }
    let found = matrix.try_inverse()? * right;
    let radius = (found.z + found.x * found.x + found.y * found.y).sqrt();
    (radius.is_finite() && radius > 0.0).then_some(([found.x, found.y], radius))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_circle_give_it_back_and_those_of_a_line_nothing() {
        let on = |k: usize| {
            let (sin, cos) = (0.4 * k as f64).sin_cos();
            (1.0 + k as f64, 3.0 + 2.0 * cos, -1.0 + 2.0 * sin)
        };
        let ([x, y], radius) = nearest_circle((0..7).map(on)).expect("a circle");
        let off = (x - 3.0).abs().max((y + 1.0).abs()).max((radius - 2.0).abs());
        assert!(off < 1e-12, "off by {off}");
        assert_eq!(nearest_circle((0..4).map(|k| (1.0, f64::from(k), 0.0))), None);
    }
}
