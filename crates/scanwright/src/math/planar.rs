//! Points of a plane: their longest extent, the smallest rectangle around them, the parabola and the circle nearest to
//! them.

use nalgebra::{Matrix2, Vector2};

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

/// Centre and radius of the circle from which points are nearest, by Gauss and Newton from a parabola along their
/// longest extent or from [`nearest_circle`], whichever is nearer; short noisy arcs are not biased. `None` when they lie
/// on a line.
pub fn fitted_circle(points: &[Vector2<f64>]) -> Option<(Vector2<f64>, f64)> {
    const STEPS: usize = 20;
    let algebraic =
        nearest_circle(points.iter().map(|p| (1.0, p.x, p.y))).map(|([x, y], r)| (Vector2::new(x, y), r));
    let off = |&(center, radius): &(Vector2<f64>, f64)| -> f64 {
        points.iter().map(|p| ((p - center).norm() - radius).powi(2)).sum()
    };
    let starts = parabola_circle(points).into_iter().chain(algebraic);
    let (mut center, mut radius) = starts.min_by(|a, b| off(a).total_cmp(&off(b)))?;
    for _ in 0..STEPS {
        let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
        for p in points {
            let from = p - center;
            let length = from.norm();
            if length > 0.0 {
                let row = Vec3::new(-from.x / length, -from.y / length, -1.0);
                matrix += row * row.transpose();
                right -= row * (length - radius);
            }
        }
        let Some(step) = matrix.try_inverse().map(|inverse| inverse * right) else { break };
        let next = (center + step.xy(), radius + step.z);
        let is_better = next.1 > 0.0 && off(&next) < off(&(center, radius));
        if !is_better {
            break;
        }
        (center, radius) = next;
    }
    radius.is_finite().then_some((center, radius))
}

/// Mean of points and the direction in which they spread most; the origin and x when there are none.
pub fn longest_extent(points: &[Vector2<f64>]) -> (Vector2<f64>, Vector2<f64>) {
    let mean = points.iter().sum::<Vector2<f64>>() / points.len().max(1) as f64;
    let spread: Matrix2<f64> = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
    let eigen = spread.symmetric_eigen();
    let most = usize::from(eigen.eigenvalues.y > eigen.eigenvalues.x);
    (mean, eigen.eigenvectors.column(most).into_owned())
}

/// The rectangle of least area around points: the angle of its first side, radians, and its lowest and highest corner
/// in coordinates along its sides, about the origin. `None` when the points lie on a line.
///
/// One side lies on a side of the convex hull (H. Freeman, R. Shapira, "Determining the minimum-area encasing rectangle
/// for an arbitrary closed curve", Communications of the ACM 18 (1975), 409-413). O(n log n + h^2) for h hull corners.
pub fn smallest_rectangle(points: &[[f64; 2]]) -> Option<(f64, [[f64; 2]; 2])> {
    let hull = convex_hull(points);
    if hull.len() < 3 {
        return None;
    }
    let sides = hull.iter().zip(hull.iter().cycle().skip(1));
    let around = |(a, b): (&[f64; 2], &[f64; 2])| {
        let angle = (b[1] - a[1]).atan2(b[0] - a[0]);
        let (sin, cos) = angle.sin_cos();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for [x, y] in &hull {
            for (i, t) in [x * cos + y * sin, y * cos - x * sin].into_iter().enumerate() {
                low[i] = low[i].min(t);
                high[i] = high[i].max(t);
            }
        }
        (angle, [low, high])
    };
    let area = |[low, high]: &[[f64; 2]; 2]| (high[0] - low[0]) * (high[1] - low[1]);
    sides.map(around).min_by(|a, b| area(&a.1).total_cmp(&area(&b.1)))
}

/// Corners of the convex hull, counter-clockwise: A. M. Andrew, "Another efficient algorithm for convex hulls in two
/// dimensions", Information Processing Letters 9 (1979), 216-219.
fn convex_hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let turns_left = |a: &[f64; 2], b: &[f64; 2], c: &[f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0
    };
    let chain = |points: &mut dyn Iterator<Item = &[f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while chain.len() >= 2 && !turns_left(&chain[chain.len() - 2], &chain[chain.len() - 1], p) {
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut sorted.iter());
    hull.extend(chain(&mut sorted.iter().rev()));
    hull
}

/// Coefficients of `1`, `x`, `x^2` of the parabola from which points are nearest along y; `None` when fewer than three
/// differ in x.
pub fn fitted_parabola(points: impl Iterator<Item = Vector2<f64>>) -> Option<[f64; 3]> {
    let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
    for p in points {
        let row = Vec3::new(1.0, p.x, p.x * p.x);
        matrix += row * row.transpose();
        right += row * p.y;
    }
    Some((matrix.try_inverse()? * right).into())
}

/// The circle that osculates the best parabola over the points' longest extent.
fn parabola_circle(points: &[Vector2<f64>]) -> Option<(Vector2<f64>, f64)> {
    let (mean, along) = longest_extent(points);
    let across = Vector2::new(-along.y, along.x);
    let local = points.iter().map(|p| Vector2::new(along.dot(&(p - mean)), across.dot(&(p - mean))));
    let [height, rise, bend] = fitted_parabola(local)?;
    let slope = rise.hypot(1.0);
    let radius = slope.powi(3) / (2.0 * bend);
    let normal = (across - along * rise) / slope;
    (radius.is_finite() && bend != 0.0).then(|| (mean + across * height + normal * radius, radius.abs()))
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

    #[test]
    fn a_short_noisy_arc_keeps_its_radius() {
        // Eight degrees of a circle, with noise of a quarter of its sagitta.
        let (radius, half) = (200.0, 0.07);
        let noise = 0.25 * radius * half * half / 2.0;
        let n = 4000;
        let points: Vec<Vector2<f64>> = (0..n)
            .map(|i| {
                let turn = half * (2.0 * f64::from(i) / f64::from(n) - 1.0);
                // An even distribution of the same deviation, each value met all along the arc.
                let r = radius + noise * 3.0_f64.sqrt() * (2.0 * (f64::from(i) * 0.618_034).fract() - 1.0);
                Vector2::new(r * turn.cos() + 5.0, r * turn.sin() - 7.0)
            })
            .collect();
        let (center, found) = fitted_circle(&points).expect("an arc");
        // Curvature of a parabola over 2 half: sigma * 6 sqrt(5) / (n^0.5 (radius half)^2).
        let sigma = noise * 6.0 * 5.0_f64.sqrt() / (f64::from(n).sqrt() * (radius * half).powi(2));
        assert!((1.0 / found - 1.0 / radius).abs() < 4.0 * sigma, "radius {found}");
        assert!((center - Vector2::new(5.0, -7.0)).norm() < 1.2 * (found - radius).abs() + 0.1);
    }
}
