//! What a spot of Gaussian profile makes of a kink.

/// `E|t + tau x|` for a standard normal `x`, and its derivative by `t`.
pub fn blurred_magnitude(t: f64, tau: f64) -> (f64, f64) {
    let tau = tau.max(f64::MIN_POSITIVE);
    let erf = erf(t / (tau * std::f64::consts::SQRT_2));
    let magnitude = tau * (2.0 / std::f64::consts::PI).sqrt() * (-t * t / (2.0 * tau * tau)).exp() + t * erf;
    (magnitude, erf)
}

/// Error function, within 1.5e-7: M. Abramowitz, I. Stegun, "Handbook of Mathematical Functions" (1964), 7.1.26.
fn erf(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs());
    let polynomial = t
        * (0.254_829_592
            + t * (-0.284_496_736 + t * (1.421_413_741 + t * (-1.453_152_027 + t * 1.061_405_429))));
    (1.0 - polynomial * (-x * x).exp()).copysign(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn magnitude_is_rounded_at_zero_and_its_own_far_away() {
        let (at_zero, slope) = blurred_magnitude(0.0, 1.0);
        assert!((at_zero - (2.0 / std::f64::consts::PI).sqrt()).abs() < 1e-7 && slope.abs() < 1e-7);
        assert_eq!(blurred_magnitude(-9.0, 1.0), (9.0, -1.0));
    }
}
