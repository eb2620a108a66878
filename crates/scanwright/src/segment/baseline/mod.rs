//! Segmentations of others, for the tables beside the default and the thesis's methods.
//!
//! Three that the thesis compares with or cites, all on the patches of [`crate::segment::spectral`] instead of single
//! triangles, so that a scan of a million can be cut, and all ending in the same step from groups to regions with surfaces:
//! what is compared is the grouping. Each file says what is published and what is ours.

pub(super) mod hfp;
pub(super) mod liu_zhang;
pub(super) mod xiao;

/// Options of hierarchical fitting primitives, and of Liu and Zhang's method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Baseline {
    /// Number of groups; found when `None`, which neither paper does. A group in several pieces gives several regions.
    pub n_regions: Option<usize>,
    /// Seed of the patches and of the starts of k-means. Default 1.
    pub seed: u64,
}

impl Default for Baseline {
    fn default() -> Self {
        Self { n_regions: None, seed: 1 }
    }
}
