//! Votes of normals in the cells of the Gaussian sphere, their statistics, and the sorted histogram.

use super::{Cells, GaussImage};

/// What a triangle's vote counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Voting {
    /// The same for all: distorted where triangles are dense, as at the poles of a sphere's grid.
    Count,
    /// Its area: the density of the surface, not of its triangles.
    Area,
}

/// Votes per cell, their mean scaled to one.
#[derive(Debug, Clone, PartialEq)]
pub struct Accumulator {
    /// One per cell.
    pub votes: Vec<f64>,
    /// Number of normals that voted.
    pub n_votes: usize,
}

/// The thesis's descriptor `Gsh+s`: sorted votes with their skewness. It does not change when the region is turned, but
/// for where the cells' borders fall.
#[derive(Debug, Clone, PartialEq)]
pub struct Descriptor {
    /// Votes, descending.
    pub histogram: Vec<f64>,
    /// See [`Accumulator::skewness`].
    pub skewness: f64,
}

impl Accumulator {
    /// The votes of an image in `cells`. All are zero when nothing votes.
    pub fn new(image: &GaussImage, cells: &Cells, voting: Voting) -> Self {
        let mut votes = vec![0.0; cells.len()];
        let mut total = 0.0;
        for (normal, area) in image.normals.iter().zip(&image.areas) {
            let vote = if voting == Voting::Area { *area } else { 1.0 };
            votes[cells.of(normal)] += vote;
            total += vote;
        }
        if total > 0.0 {
            let scale = cells.len() as f64 / total;
            for vote in &mut votes {
                *vote *= scale;
            }
        }
        Self { votes, n_votes: image.normals.len() }
    }

    /// Third standardized moment of the votes; zero when all cells have the same.
    pub fn skewness(&self) -> f64 {
        let (mean, deviation) = self.mean_and_deviation();
        if deviation <= f64::EPSILON * mean {
            return 0.0;
        }
        let cubes: f64 = self.votes.iter().map(|v| ((v - mean) / deviation).powi(3)).sum();
        cubes / self.votes.len() as f64
    }

    /// Deviation of the votes over their mean, beyond what so few votes scatter by chance.
    pub fn dispersion(&self) -> f64 {
        let (mean, deviation) = self.mean_and_deviation();
        let by_chance_sq = self.votes.len() as f64 / self.n_votes.max(1) as f64;
        ((deviation / mean.max(f64::MIN_POSITIVE)).powi(2) - by_chance_sq).max(0.0).sqrt()
    }

    /// The sorted histogram with the skewness.
    pub fn descriptor(&self) -> Descriptor {
        let mut histogram = self.votes.clone();
        histogram.sort_by(|a, b| b.total_cmp(a));
        Descriptor { histogram, skewness: self.skewness() }
    }

    fn mean_and_deviation(&self) -> (f64, f64) {
        let n = self.votes.len() as f64;
        let mean = self.votes.iter().sum::<f64>() / n;
        let variance = self.votes.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
        (mean, variance.sqrt())
    }
}

impl Descriptor {
    /// All its numbers: the histogram, then the skewness.
    pub fn values(&self) -> Vec<f64> {
        self.histogram.iter().copied().chain([self.skewness]).collect()
    }
}
