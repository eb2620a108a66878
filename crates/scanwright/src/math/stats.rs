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
