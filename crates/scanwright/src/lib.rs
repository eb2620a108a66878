//! From a raw 3D scan to a closed CAD solid of planes, cylinders, cones, spheres and tori.
//!
//! [`pipeline::run`] is the whole way; each stage is a pure function of its own that can be called, tested and
//! replaced alone. `docs/architecture.md` in the repository is the map. All lengths are in the scan's unit, all angles
//! in radians.
//!
//! ```no_run
//! use scanwright::{io, pipeline, progress::Progress};
//!
//! let scan = io::read_mesh_file("bracket.ply".as_ref())?;
//! let result = pipeline::run(&scan.mesh, &pipeline::Options::default(), &Progress::none())?;
//! for primitive in &result.segmentation.primitives {
//!     println!("{:?}, rms {}", primitive.surface, primitive.residual.rms);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! How far points are from a model, positive outside:
//!
//! ```
//! use scanwright::{deviation, io, math::Point3};
//!
//! let tetrahedron = b"OFF\n4 4 0\n0 0 0\n3 0 0\n0 3 0\n0 0 3\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
//! let model = io::read_mesh(tetrahedron, "tetrahedron.off")?.mesh;
//! let points = [Point3::new(0.5, 0.5, -0.25), Point3::new(0.5, 0.5, 0.125)];
//! let deviation = deviation::measure(&points, &model).expect("there are points and a model");
//! assert_eq!(deviation.distances, [0.25, -0.125]);
//! # Ok::<(), scanwright::io::ReadError>(())
//! ```

pub mod align;
pub mod assemble;
pub mod brep;
pub mod check;
pub mod condition;
pub mod datum;
pub mod denoise;
pub mod deviation;
pub mod dimension;
pub mod document;
pub mod fit;
pub mod gprimdb;
pub mod io;
pub mod math;
pub mod mesh;
pub mod par;
pub mod pipeline;
pub mod prior;
pub mod progress;
pub mod random;
pub mod recognize;
pub mod regularize;
pub mod render;
pub mod report;
pub mod script;
pub mod segment;
pub mod selftest;
pub mod step;
pub mod surface;
pub mod tolerance;
pub mod uncertainty;
