//! Robust statistics.

/// Turns the median absolute deviation of a normal distribution into its standard deviation.
pub const MAD_TO_SIGMA: f64 = 1.4826;

/// Quantile `q` in [0, 1] of `values`, reordering them; `None` when there are none.
pub fn quantile(values: &mut [f64], q: f64) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let k = ((values.len() - 1) as f64 * q.clamp(0.0, 1.0)).round() as usize;
    let (_, value, _) = values.select_nth_unstable_by(k, f64::total_cmp);
    Some(*value)
}

/// Median of `values`, reordering them; `None` when there are none.
pub fn median(values: &mut [f64]) -> Option<f64> {
    quantile(values, 0.5)
}

/// Robust standard deviation of `residuals` about zero: 1.4826 times the median of their magnitudes.
pub fn sigma_about_zero(residuals: &[f64]) -> Option<f64> {
    let mut magnitudes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
    median(&mut magnitudes).map(|m| m * MAD_TO_SIGMA)
}

/// `quantile / freedom` of chi-squared with so many degrees of freedom, where `z` is the standard normal quantile of the
/// same level: E. B. Wilson, M. M. Hilferty, "The distribution of chi-square", Proceedings of the National Academy of
/// Sciences 17 (1931), 684-688.
pub fn chi_squared_ratio(freedom: f64, z: f64) -> f64 {
    let a = 2.0 / (9.0 * freedom);
    (1.0 - a + z * a.sqrt()).max(0.0).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chi_squared_quantiles_match_the_tables() {
        // Abramowitz and Stegun, table 26.8: the 95 % quantile with 10 degrees of freedom is 18.307, the 5 % one 3.940.
        assert!((10.0 * chi_squared_ratio(10.0, 1.6449) - 18.307).abs() < 0.05);
        assert!((10.0 * chi_squared_ratio(10.0, -1.6449) - 3.940).abs() < 0.05);
    }
}
