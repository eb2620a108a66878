use serde::{Deserialize, Serialize};

/// Deviations counted, on a scale that pictures share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Histogram {
    /// End of the scale on both sides, length.
    pub limit: f64,
    /// What the end of the scale was chosen by.
    pub limit_from: LimitFrom,
    /// Points per bin; the bins divide the scale from `-limit` to `limit` evenly.
    pub counts: Vec<usize>,
    /// Points below the scale.
    pub below: usize,
    /// Points above the scale.
    pub above: usize,
}

/// What the end of a scale of deviations was chosen by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LimitFrom {
    /// Three standard deviations of the scanner's noise.
    Noise,
    /// The 95th percentile of the deviations, where that is larger.
    Percentile,
}

/// An even number: zero is a border between bins.
const N_BINS: usize = 40;
/// Sigmas of noise that the scale spans on each side: 99.7 % of a normal distribution.
const SIGMAS: f64 = 3.0;

impl Histogram {
    /// Counts `distances`, whose 95th percentile is `p95`; `noise`: standard deviation of the scan along the normal. The
    /// scale ends at the next round number above what noise alone makes, or above the 95th percentile if that is larger.
    pub fn new(distances: &[f64], p95: f64, noise: f64) -> Self {
        let by_noise = SIGMAS * noise;
        let limit_from = if p95 > by_noise { LimitFrom::Percentile } else { LimitFrom::Noise };
        let limit = round_up(p95.max(by_noise));
        let mut histogram = Self { limit, limit_from, counts: vec![0; N_BINS], below: 0, above: 0 };
        for &distance in distances {
            histogram.add(distance);
        }
        histogram
    }

    fn add(&mut self, distance: f64) {
        if distance < -self.limit {
            self.below += 1;
        } else if distance > self.limit {
            self.above += 1;
        } else if distance.is_finite() {
            let place = (distance + self.limit) / (2.0 * self.limit) * N_BINS as f64;
            self.counts[(place as usize).min(N_BINS - 1)] += 1;
        }
    }

    /// All points counted.
    pub fn total(&self) -> usize {
        self.counts.iter().sum::<usize>() + self.below + self.above
    }
}

/// The smallest of 1, 1.5, 2, 3, 4, 5, 6, 8 times a power of ten that is not below `x`; 1 when nothing is to be shown.
fn round_up(x: f64) -> f64 {
    if !(x.is_finite() && x > 0.0) {
        return 1.0;
    }
    let power = 10_f64.powi(x.log10().floor() as i32);
    let steps = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    // Written as a quotient where the power is below one: decimal fractions then are the nearest numbers to themselves.
    let scaled = |step: f64| if power < 1.0 { step / (1.0 / power).round() } else { step * power };
    steps.into_iter().map(scaled).find(|limit| *limit >= x * (1.0 - f64::EPSILON)).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_at_round_numbers() {
        for (x, limit) in [(0.0871, 0.1), (0.1, 0.1), (0.101, 0.15), (3.1, 4.0), (99.0, 100.0), (0.0, 1.0)] {
            assert_eq!(round_up(x), limit, "{x}");
        }
        assert_eq!(round_up(f64::NAN), 1.0);
    }

    #[test]
    fn every_point_is_counted_once_on_its_side() {
        let distances = [-5.0, -0.29, -0.01, 0.0, 0.29, 0.3, 7.0];
        let histogram = Histogram::new(&distances, 0.05, 0.1);
        assert_eq!((histogram.limit, histogram.limit_from), (0.3, LimitFrom::Noise));
        assert_eq!((histogram.below, histogram.above, histogram.total()), (1, 1, 7));
        let negative: usize = histogram.counts[..N_BINS / 2].iter().sum();
        assert_eq!(negative, 2);
        assert_eq!(histogram.counts[N_BINS - 1], 2);
        assert_eq!(Histogram::new(&distances, 5.0, 0.1).limit_from, LimitFrom::Percentile);
    }
}
