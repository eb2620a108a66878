//! GPrimDB: a database of primitives, generated from a manifest.
//!
//! Planes, cylinders, cones, spheres and tori, complete and partial, in any resolution, triangulation and noise, with the
//! truth about each; and surfaces that are none of them. The thesis made its own because there was none ("Extracting
//! Structured Models From Raw Scans of Manufactured Objects", 2015). Its content is not known beyond the five types and
//! their partial models: classes, ranges and numbers here are reconstructed.
//!
//! A model is a function of its manifest and its number ([`Manifest::model`]), so that a database is as small as its
//! truth and can be made again: the same bytes on the same system, elsewhere to the last bits of sines.

mod known;
mod manifest;
mod mesher;
mod model;
mod noise;
mod shape;
mod store;

pub use known::{Known, Measured, take};
pub use manifest::{ClassCount, Manifest, Ranges, Tier};
pub use mesher::Triangulation;
pub use model::{Model, Split, Truth};
pub use noise::Noise;
pub use shape::Class;
pub use store::{Database, DatabaseError, Entry, Match, Part};
