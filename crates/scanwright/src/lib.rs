//! From a raw 3D scan to a closed CAD solid.
#![warn(missing_docs)]

pub mod math;
pub mod mesh;
pub mod par;
pub mod progress;
pub mod random;
pub mod recognize;
pub mod segment;
pub mod surface;
pub mod tolerance;
