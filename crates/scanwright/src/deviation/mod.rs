//! Signed distances between a scan and a model.
//!
//! The distance of a point to a triangle mesh is that to its nearest triangle; its sign, positive outside, is that
//! of the angle-weighted pseudonormal of the nearest feature, which is right for every closed oriented mesh.
//! J. A. Bærentzen, H. Aanæs, "Signed distance computation using the angle weighted pseudonormal", IEEE Transactions
//! on Visualization and Computer Graphics 11 (2005), 243-253. Near the border of an open mesh the sign is a guess.

mod histogram;
mod nearest;

pub use histogram::{Histogram, LimitFrom};
pub use nearest::{Feature, Found, Nearest};

use crate::math::Point3;
use crate::mesh::Mesh;
use crate::par;
use crate::recognize::Residual;

/// Signed distances of points to a model, positive outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviation {
    /// One per point, length.
    pub distances: Vec<f64>,
    /// Their statistics.
    pub residual: Residual,
}

impl Deviation {
    /// Share of the points not farther than `tolerance` from the model.
    pub fn share_within(&self, tolerance: f64) -> f64 {
        let n_within = self.distances.iter().filter(|d| d.abs() <= tolerance).count();
        n_within as f64 / self.distances.len().max(1) as f64
    }
}

/// Distances of `points` to `model`; `None` when either is empty. O((n + m) log m).
pub fn measure(points: &[Point3], model: &Mesh) -> Option<Deviation> {
    let nearest = Nearest::new(model)?;
    if points.is_empty() {
        return None;
    }
    let distances = par::map(points, |point| nearest.signed_distance(point));
    let residual = Residual::from_distances(&distances);
    Some(Deviation { distances, residual })
}
