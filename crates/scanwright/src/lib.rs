//! From a raw 3D scan to a closed CAD solid.
#![warn(missing_docs)]

pub mod brep;
pub mod condition;
pub mod denoise;
pub mod deviation;
pub mod fit;
pub mod io;
pub mod math;
pub mod mesh;
pub mod par;
pub mod pipeline;
pub mod progress;
pub mod random;
pub mod recognize;
pub mod regularize;
pub mod render;
pub mod report;
pub mod segment;
pub mod step;
pub mod surface;
pub mod tolerance;
