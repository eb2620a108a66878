//! What a region is: a surface type with its evidence.

mod ambiguity;
mod choose;
pub mod gauss;
mod moved;
mod sufficiency;

pub use ambiguity::{Ambiguity, ambiguity};
pub use choose::{
    COST_CAP, Choice, Limits, TYPE_ORDER, choose, excess_cost, fit_kind, is_as_good, is_better,
    is_ring_or_lemon, is_worth, mean_cost,
};
pub use sufficiency::{Missing, Sufficiency, arc_seen, sufficiency};

use crate::fit::{Fit, Samples, VERTICES_PER_SAMPLE, parameter_covariance};
use crate::math::stats;
use crate::surface::{Surface, SurfaceKind};

/// Distances of points to a surface, length.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Residual {
    /// Root mean square.
    pub rms: f64,
    /// 95th percentile of the magnitudes.
    pub p95: f64,
    /// Largest magnitude.
    pub max: f64,
}

impl Residual {
    /// Statistics of signed `distances`.
    pub fn from_distances(distances: &[f64]) -> Self {
        if distances.is_empty() {
            return Self::default();
        }
        let mut magnitudes: Vec<f64> = distances.iter().map(|d| d.abs()).collect();
        let rms = (magnitudes.iter().map(|d| d * d).sum::<f64>() / magnitudes.len() as f64).sqrt();
        let max = magnitudes.iter().fold(0.0, |m: f64, d| m.max(*d));
        let p95 = stats::quantile(&mut magnitudes, 0.95).unwrap_or(0.0);
        Self { rms, p95, max }
    }
}

/// A surface found in a region, with its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Primitive {
    /// The surface; `None` when no analytic surface describes the region (freeform).
    pub surface: Option<Surface>,
    /// Whether the surface's natural normal points out of the material: true for a shaft, false for a bore. Planes
    /// are always stored with their normal outward.
    pub outward: bool,
    /// Distances of the region's interior points.
    pub residual: Residual,
    /// Standard uncertainties of the parameters, in the order of `fit::parameter_names`; empty when freeform.
    pub covariance: Vec<Vec<f64>>,
    /// Why the type is not certain, if it is not.
    pub ambiguous: Option<String>,
}

impl Primitive {
    /// A region that no surface describes.
    pub fn freeform() -> Self {
        Self {
            surface: None,
            outward: true,
            residual: Residual::default(),
            covariance: Vec::new(),
            ambiguous: None,
        }
    }

    /// A region of a surface, with what `samples`, standing for `n_vertices` of its vertices, say about it. Planes are
    /// turned to have their normal outward.
    pub fn with_evidence(mut fit: Fit, samples: &Samples, n_vertices: usize) -> Self {
        if let (Surface::Plane(plane), false) = (&mut fit.surface, fit.outward) {
            plane.normal = -plane.normal;
            fit.outward = true;
        }
        let distances: Vec<f64> = samples.points.iter().map(|p| fit.surface.signed_distance(p)).collect();
        let residual = Residual::from_distances(&distances);
        let n_effective = (n_vertices as f64 / VERTICES_PER_SAMPLE).max(1.0);
        let covariance = parameter_covariance(&fit.surface, samples, residual.rms, n_effective);
        Self { surface: Some(fit.surface), outward: fit.outward, residual, covariance, ambiguous: None }
    }

    /// Its surface with its side, `None` for freeform.
    pub fn fit(&self) -> Option<Fit> {
        self.surface.map(|surface| Fit { surface, outward: self.outward })
    }

    /// The type of the surface, `None` for freeform.
    pub fn kind(&self) -> Option<SurfaceKind> {
        self.surface.as_ref().map(Surface::kind)
    }
}
