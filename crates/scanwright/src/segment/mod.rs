//! Regions of the scan, one primitive each.

use crate::recognize::Primitive;

/// Index of a region: its place in [`Segmentation::primitives`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
pub struct RegionId(pub u32);

/// The labelling of all triangles of a mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Segmentation {
    /// One per triangle; `None` where nothing describes it.
    pub labels: Vec<Option<RegionId>>,
    /// One per region.
    pub primitives: Vec<Primitive>,
}
