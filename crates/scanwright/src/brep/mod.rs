//! From a labelled mesh to a closed solid.

pub mod close;

use crate::mesh::Mesh;
use crate::recognize::Primitive;
use crate::segment::RegionId;

/// A mesh whose every triangle belongs to a region.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelledMesh {
    /// The mesh: oriented and manifold; closed unless `brep::close` says why not.
    pub mesh: Mesh,
    /// One per triangle.
    pub labels: Vec<RegionId>,
    /// One per region: those of the scan, then those that were assumed.
    pub primitives: Vec<Primitive>,
    /// One per triangle: whether it was invented to close a hole of the scan.
    pub assumed: Vec<bool>,
}
