//! Filtered normals and positions for decisions of topology; parameters are fitted to the raw points.

use crate::math::{Point3, Vec3};

/// A filtered copy of a mesh's geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct Denoised {
    /// One unit normal per triangle.
    pub triangle_normals: Vec<Vec3>,
    /// One position per vertex.
    pub vertices: Vec<Point3>,
}
