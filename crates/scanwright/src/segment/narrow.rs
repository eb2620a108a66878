//! Faces so narrow that the scanner's rounding of their edges reaches most of them.
//!
//! Cutting a border away, as for wide faces, would leave nothing; keeping it makes an arc of every chamfer. Instead
//! the neighbours are taken as known, the rounding of the common edges is predicted (`edge`), and surfaces are
//! fitted to what the scan would show without it. The fit and the prediction improve each other in a few rounds.

use super::edge::{self, Sharpened};
use super::field::{Field, Scratch};
use crate::fit::{Fit, Samples, Weights, refine};
use crate::recognize::{COST_CAP, Choice, TYPE_ORDER, fit_kind, is_better};

/// Share of a face within reach of rounding at which it is narrow.
const NARROW_SHARE: f64 = 0.6;
/// Rounds of predicting the rounding and fitting.
const ROUNDS: usize = 3;
/// Samples of a fit.
const N_SAMPLES: usize = 200;
/// Fewer samples say nothing about a surface of eight parameters.
const MIN_SAMPLES: usize = 16;
/// Steps of a fit per round.
const STEPS: usize = 6;

/// A face with the neighbour that each of its vertices may be rounded towards.
#[derive(Debug)]
pub(super) struct Rim {
    members: Vec<u32>,
    /// One per member: the nearest other surface within reach of its rounding.
    across: Vec<Option<Fit>>,
}

impl Rim {
    /// The rim of a region; `None` when the region is wide, or has no neighbour. `label_of`: the surface of a vertex.
    pub fn of_narrow(
        field: &Field,
        members: &[u32],
        fit_of: impl Fn(u32) -> Option<Fit>,
        scratch: &mut Scratch,
    ) -> Option<Self> {
        let reach = (2.0 * field.blur / field.spacing).ceil() as usize + 1;
        let across = field.nearest_outside(members, reach, scratch);
        let is_rim = |(v, u): (&u32, &Option<u32>)| u.is_some() || field.ground_near(*v).is_some();
        let n_rim = members.iter().zip(&across).filter(|pair| is_rim(*pair)).count();
        if field.blur <= 0.0 || (n_rim as f64) < NARROW_SHARE * members.len() as f64 {
            return None;
        }
        let across: Vec<Option<Fit>> = members
            .iter()
            .zip(across)
            .map(|(&v, u)| u.and_then(&fit_of).or_else(|| field.ground_near(v).copied()))
            .collect();
        across.iter().any(Option::is_some).then(|| Self { members: members.to_vec(), across })
    }

    /// A simpler surface that explains the face together with the rounding of its edges as well as `complex` does.
    pub fn simpler(&self, field: &Field, complex: &Fit) -> Option<Choice> {
        let start = self.sharpened(field, complex).samples;
        let (complex, rim) = self.refine(field, complex, &field.weights, N_SAMPLES)?;
        let complex = Choice { fit: complex, mean_cost: rim.mean_cost };
        TYPE_ORDER.into_iter().take_while(|kind| *kind < complex.fit.surface.kind()).find_map(|kind| {
            let first = fit_kind(kind, &start, &field.weights, &field.limits, None)?;
            let (fit, rim) = self.refine(field, &first.fit, &field.weights, N_SAMPLES)?;
            let simple = Choice { fit, mean_cost: rim.mean_cost };
            let enough = !is_better(&simple, &complex, &rim.samples, self.members.len(), &field.limits);
            enough.then_some(simple)
        })
    }

    /// Fits the surface of `start` and the rounding in turns.
    pub fn refine(
        &self,
        field: &Field,
        start: &Fit,
        weights: &Weights,
        n_samples: usize,
    ) -> Option<(Fit, SharpRim)> {
        let mut fit = *start;
        for _ in 0..ROUNDS {
            let samples = self.sharpened(field, &fit).samples.thinned(n_samples);
            if samples.points.len() < MIN_SAMPLES {
                return None;
            }
            fit = refine(&fit, &samples, weights, STEPS)?;
        }
        Some((fit, self.sharpened(field, &fit)))
    }

    /// The samples without the rounding that `fit` and the neighbours predict, where they still speak of `fit`.
    fn sharpened(&self, field: &Field, fit: &Fit) -> SharpRim {
        /// Part of a change of the surface that a sample must show.
        const MIN_SENSITIVITY: f64 = 0.3;
        let mut samples = Samples::default();
        let mut cost = 0.0;
        let stride = self.members.len().div_ceil(2 * N_SAMPLES).max(1);
        for (&v, across) in self.members.iter().zip(&self.across).step_by(stride) {
            let sharp = match across {
                Some(other) => edge::sharpen(field, fit, other, v),
                None => Sharpened {
                    point: field.points[v as usize],
                    normal: field.normals[v as usize],
                    cost: field.cost(fit, v),
                    sensitivity: 1.0,
                },
            };
            cost += sharp.cost.min(COST_CAP);
            if sharp.sensitivity > MIN_SENSITIVITY {
                samples.points.push(sharp.point);
                samples.normals.push(sharp.normal);
            }
        }
        let n = self.members.len().div_ceil(stride).max(1);
        SharpRim { samples, mean_cost: cost / n as f64 }
    }
}

/// A rim without its rounding.
#[derive(Debug)]
pub(super) struct SharpRim {
    /// What speaks of the face's own surface.
    pub samples: Samples,
    /// Mean cost of all members, rounding included.
    pub mean_cost: f64,
}
