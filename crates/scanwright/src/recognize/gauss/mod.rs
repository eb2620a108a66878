//! Recognition on the Gaussian sphere: the type of a region from its normals alone.
//!
//! The thesis's path, beside the product's choice by fitted surfaces (`recognize::choose`). The unit normals of a region
//! are points on a sphere: a plane's fall on one spot, a cylinder's on a great circle, a cone's on a small one (`rules`).
//! What fills the sphere is told apart by how densely: a sphere's normals are spread evenly, a torus's gather at the ends
//! of its axis. Votes of triangle areas in cells of equal area (`cells`, `accumulator`) show it, and sorted they are a
//! descriptor that does not change when the region is turned.
//!
//! Source: doctoral thesis "Extracting Structured Models From Raw Scans of Manufactured Objects" (2015). Its method
//! chapters were not at hand. Known from it: the plane through the normals with mean or median as centre, the
//! accumulator, voting weighted by density, skewness, the sorted histogram of 202 cells. Reconstructed: formulas and
//! thresholds. Ours: equal-area cells of any number, statistics of partial models.
//!
//! Normals alone cannot tell a short arc of a great circle from one of a small circle, nor a cap of a sphere from a piece
//! of a torus. `Verdict::certain` says when they do not.

mod accumulator;
mod cells;
mod classifier;
mod nearest;
mod outliers;
mod rules;

pub use accumulator::{Accumulator, Descriptor, Voting};
pub use cells::Cells;
pub use classifier::{Classifier, Example, Fold, Parameters, ReadClassifierError, TooFew, cross_validated};
pub use outliers::{OutlierSearch, Outliers, Threshold, rings};
pub use rules::{Center, Evidence, Rules, Verdict};

use crate::math::Vec3;
use crate::mesh::Mesh;

/// Cells of the thesis's accumulator.
pub const N_CELLS: usize = 202;

/// The image of a region on the Gaussian sphere: unit normals with areas.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GaussImage {
    /// One per triangle with an area.
    pub normals: Vec<Vec3>,
    /// One per normal: area of its triangle.
    pub areas: Vec<f64>,
}

impl GaussImage {
    /// The image of `triangles` of a mesh; triangles without area have none.
    pub fn of_triangles(mesh: &Mesh, triangles: impl IntoIterator<Item = usize>) -> Self {
        let mut image = Self::default();
        for t in triangles {
            let cross = mesh.cross(t);
            if let Some(normal) = cross.try_normalize(0.0) {
                image.normals.push(normal);
                image.areas.push(0.5 * cross.norm());
            }
        }
        image
    }

    /// The image of a whole mesh.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        Self::of_triangles(mesh, 0..mesh.triangles.len())
    }
}
