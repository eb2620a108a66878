//! What lies along the edge of two surfaces: a sharp corner, a chamfer or a fillet.
//!
//! One vertex hardly tells a fillet of three spacings from a chamfer; all vertices along an edge do. Deviations from
//! each model are averaged along the edge, in bins of about one row of vertices across it, and the averages are held
//! against what noise leaves in them.

use super::section::{Corner, Place};
use crate::segment::field::Field;

/// Rows along an edge per independent sample: the correlation length of scan noise.
const ROWS_PER_SAMPLE: f64 = 6.0;
/// Deviations beyond this many sigmas are outliers.
const CLIP: f64 = 4.0;
/// Width of a bin across the edge, spacings.
const BIN: f64 = 0.8;
/// Places that a model is fitted to.
const N_FIT: usize = 300;
/// Standard deviation of what sharp edges of one scan show of its spot, as a share of the measured one: 0.21, 0.12 and 0.15
/// in the median over 13 clean, 14 quiet and 5 rough scans of the benchmark (1 687 fits without a price).
const SPOT_SPREAD: f64 = 0.15;
/// Price of a spot that was measured wrong, as if one scan in a hundred were.
const WRONG_SPOT: f64 = 9.2;
/// Largest spot, spacings.
const LARGEST_SPOT: f64 = 1.5;

/// A model with its misfit: deviations of the averages, squared, in units of their noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fitted {
    pub corner: Corner,
    pub misfit: f64,
    /// Root mean square of the averages over the noise of one vertex.
    pub systematic: f64,
}

/// The places along one edge.
#[derive(Debug)]
pub(super) struct Edge<'p> {
    places: &'p [Place],
    sample: Vec<Place>,
    sigma: f64,
    blur: f64,
    spacing: f64,
}

impl<'p> Edge<'p> {
    pub fn new(field: &Field, places: &'p [Place]) -> Self {
        let stride = places.len().div_ceil(N_FIT).max(1);
        Self {
            places,
            sample: places.iter().copied().step_by(stride).collect(),
            sigma: field.weights.distance_sigma,
            blur: field.blur,
            spacing: field.spacing,
        }
    }

    /// The best sharp edge. Its own spot may differ from the scan's, at the price of how far edges of one scan do; where the
    /// scan's was measured wrong, at that of so unlikely an event.
    pub fn sharp(&self) -> Fitted {
        let largest = (LARGEST_SPOT * self.spacing).max(2.0 * self.blur);
        let priced = |blur: f64| {
            let fitted = self.fitted(Corner::Sharp { blur });
            let off = (blur / self.blur.max(f64::MIN_POSITIVE) - 1.0) / SPOT_SPREAD;
            Fitted { misfit: fitted.misfit + (off * off).min(WRONG_SPOT), ..fitted }
        };
        let loss = |[blur]: [f64; 1]| {
            if (0.0..=largest).contains(&blur) { priced(blur).misfit } else { f64::MAX }
        };
        let starts = [0.7, 1.0, 1.4].map(|share| [self.blur * share]);
        let others = [0.1, 0.3, 0.5, 0.7, 0.9].map(|share| [share * largest]);
        let starts: Vec<[f64; 1]> = starts.into_iter().chain(others).collect();
        let [blur] = search(&starts, [0.1 * largest], loss);
        priced(blur)
    }

    pub fn chamfer(&self) -> Fitted {
        let depths = (0..8).map(|k| self.spacing * 0.2 * 1.6_f64.powi(k));
        let starts: Vec<[f64; 2]> =
            depths.flat_map(|depth| [0.3, 0.5, 0.7].map(|share| [share, depth])).collect();
        let make = |[share, depth]: [f64; 2]| {
            ((0.1..=0.9).contains(&share) && depth > 0.0).then_some(Corner::Chamfer { share, depth })
        };
        let best = search(&starts, [0.1, 0.3 * self.spacing], |x| self.loss(make(x)));
        self.fitted(make(best).expect("the best is possible"))
    }

    /// The best fillet of at least `min_radius`.
    pub fn fillet(&self, min_radius: f64) -> Fitted {
        let starts: Vec<[f64; 1]> = (0..12).map(|k| [min_radius * 1.35_f64.powi(k)]).collect();
        let make = |[radius]: [f64; 1]| (radius >= min_radius).then_some(Corner::Fillet { radius });
        let best = search(&starts, [0.25 * min_radius], |x| self.loss(make(x)));
        self.fitted(make(best).expect("the best is possible"))
    }

    /// Squares over the sample; the largest number where there is no corner.
    fn loss(&self, corner: Option<Corner>) -> f64 {
        let Some(corner) = corner else { return f64::MAX };
        self.sample
            .iter()
            .map(|p| (corner.distance(p, self.blur) / self.sigma).powi(2).min(CLIP * CLIP))
            .sum()
    }

    fn fitted(&self, corner: Corner) -> Fitted {
        let bin_of = |p: &Place| (p.across() / (BIN * self.spacing)).round() as i64;
        let low = self.places.iter().map(bin_of).min().unwrap_or(0);
        let high = self.places.iter().map(bin_of).max().unwrap_or(0);
        let mut bins = vec![(0.0, 0.0); (high - low + 1) as usize];
        for place in self.places {
            let deviation = (corner.distance(place, self.blur) / self.sigma).clamp(-CLIP, CLIP);
            let bin = &mut bins[(bin_of(place) - low) as usize];
            bin.0 += deviation;
            bin.1 += 1.0;
        }
        let (mut misfit, mut sum_sq, mut n) = (0.0, 0.0, 0.0);
        for (sum, count) in bins.into_iter().filter(|b| b.1 > 0.0) {
            let mean_sq = (sum / count).powi(2);
            misfit += mean_sq * (BIN * count / ROWS_PER_SAMPLE).max(1.0);
            sum_sq += mean_sq * count;
            n += count;
        }
        Fitted { corner, misfit, systematic: (sum_sq / f64::max(n, 1.0)).sqrt() }
    }
}

/// Hooke and Jeeves' pattern search from the best of `starts`; `loss` is the largest number outside its bounds.
fn search<const N: usize>(
    starts: &[[f64; N]],
    mut steps: [f64; N],
    loss: impl Fn([f64; N]) -> f64,
) -> [f64; N] {
    const ROUNDS: usize = 40;
    const FINEST: f64 = 0.01;
    let first = starts.iter().map(|&x| (loss(x), x)).min_by(|a, b| a.0.total_cmp(&b.0));
    let (mut lowest, mut best) = first.expect("there is a start");
    let smallest = steps.map(|s| s * FINEST);
    for _ in 0..ROUNDS {
        let before = lowest;
        for k in 0..N {
            for sign in [1.0, -1.0] {
                let mut trial = best;
                trial[k] += sign * steps[k];
                let l = loss(trial);
                if l < lowest {
                    (lowest, best) = (l, trial);
                }
            }
        }
        if lowest >= before {
            if steps.iter().zip(&smallest).all(|(s, least)| s <= least) {
                break;
            }
            steps = steps.map(|s| 0.5 * s);
        }
    }
    best
}
