//! What a spot of Gaussian profile makes of a kink, and of any distance field of the plane.

use nalgebra::Vector2;

/// `E|t + tau x|` for a standard normal `x`, and its derivative by `t`.
pub fn blurred_magnitude(t: f64, tau: f64) -> (f64, f64) {
    let tau = tau.max(f64::MIN_POSITIVE);
    let x = t / (tau * std::f64::consts::SQRT_2);
    let bell = (-x * x).exp();
    let erf = erf(x, bell);
    (tau * (2.0 / std::f64::consts::PI).sqrt() * bell + t * erf, erf)
}

/// Distance of `at` to the zero line of a field as a spot of deviation `blur` sees it: the field averaged over the spot,
/// over the slope of that average. `field`: signed distance and gradient at a point.
///
/// A midpoint rule of 8 by 8 places out to three deviations: a kink through its middle, which lies between places,
/// comes out within 3 %.
pub fn averaged_distance(
    at: &Vector2<f64>,
    blur: f64,
    field: impl Fn(&Vector2<f64>) -> (f64, Vector2<f64>),
) -> f64 {
    const N: usize = 8;
    const STEP: f64 = 2.0 * SPOT_REACH / N as f64;
    let places: [(f64, f64); N] = std::array::from_fn(|i| {
        let offset = (i as f64 + 0.5) * STEP - SPOT_REACH;
        (offset, (-0.5 * offset * offset).exp())
    });
    let (mut sum, mut slope, mut total) = (0.0, Vector2::zeros(), 0.0);
    for (x, weight_x) in places {
        for (y, weight_y) in places {
            let weight = weight_x * weight_y;
            let (distance, gradient) = field(&(at + Vector2::new(x, y) * blur));
            sum += weight * distance;
            slope += gradient * weight;
            total += weight;
        }
    }
    sum / total / (slope.norm() / total).max(0.1)
}

/// Deviations beyond which a spot is taken to see nothing.
pub const SPOT_REACH: f64 = 3.0;

/// Error function, within 1.5e-7, with `bell = exp(-x^2)`: M. Abramowitz, I. Stegun, "Handbook of Mathematical Functions"
/// (1964), 7.1.26.
fn erf(x: f64, bell: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs());
    let polynomial = t
        * (0.254_829_592
            + t * (-0.284_496_736 + t * (1.421_413_741 + t * (-1.453_152_027 + t * 1.061_405_429))));
    (1.0 - polynomial * bell).copysign(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_average_of_a_kink_is_near_its_closed_form() {
        // A ridge of a right angle: the larger of two distances, along its bisector.
        let (blur, n) = (0.8, std::f64::consts::FRAC_1_SQRT_2);
        let ridge = |p: &Vector2<f64>| {
            let normal = Vector2::new(if p.x > 0.0 { n } else { -n }, n);
            (normal.dot(p), normal)
        };
        let seen = averaged_distance(&Vector2::zeros(), blur, ridge);
        let exact = blurred_magnitude(0.0, blur).0;
        assert!((seen - exact).abs() < 0.03 * exact, "{seen} instead of {exact}");
    }

    #[test]
    fn magnitude_is_rounded_at_zero_and_its_own_far_away() {
        let (at_zero, slope) = blurred_magnitude(0.0, 1.0);
        assert!((at_zero - (2.0 / std::f64::consts::PI).sqrt()).abs() < 1e-7 && slope.abs() < 1e-7);
        assert_eq!(blurred_magnitude(-9.0, 1.0), (9.0, -1.0));
    }
}
