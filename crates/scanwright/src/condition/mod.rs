//! From any triangles to a mesh the other stages can rely on, and what the scanner did to it.

mod caps;
mod clean;
mod components;
mod edge_rounding;
mod half_edges;
mod noise;
mod orient;
mod patch;
mod split;
mod support;
mod weld;

pub use clean::{ConditionReport, Conditioned, condition};
pub use noise::measure;
pub use support::find_support;

use crate::math::Point3;
use crate::surface::Plane;

/// The table that the part stood on.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    /// The table's plane, its normal towards the part.
    pub plane: Plane,
    /// One per triangle of the mesh: whether it lies on the table (or on the skirt between table and part).
    pub on_table: Vec<bool>,
    /// Closed outlines where parts met the table, on the plane: the trim of the assumed bottom faces.
    pub outlines: Vec<Vec<Point3>>,
}
