//! From a labelled mesh to a closed solid.

mod assemble;
mod attempt;
mod banded;
mod batch;
mod build;
mod chains;
pub mod check;
pub mod close;
mod curve;
mod domain;
mod draft;
mod draw;
mod facets;
mod freeform;
mod geometry;
mod halfedge;
mod labels;
mod meet;
mod mend;
mod plain;
mod relabel;
mod riser;
mod settle;
mod solid;
mod split;
mod straighten;
mod tessellate;
mod thin;

pub use build::build;
pub use check::{Problem, Validity, check, validity};
pub use curve::Curve;
pub use draw::draw;
pub use solid::{
    Edge, EdgeId, EdgeUse, Face, FaceId, Geometry, Loop, Shell, Solid, SurfaceId, Vertex, VertexId,
};
pub use tessellate::{Tessellation, tessellate};

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

/// What [`build()`] made.
#[derive(Debug, Clone, PartialEq)]
pub struct Built {
    /// One per connected part of the mesh.
    pub solids: Vec<Solid>,
    /// What is not as it was asked for.
    pub issues: Vec<Issue>,
    /// One per region: those given, then those of risers that were looked for between them.
    pub primitives: Vec<Primitive>,
}

/// Something that could not be built as asked.
#[derive(Debug, Clone, PartialEq)]
pub struct Issue {
    /// What kind of thing.
    pub code: IssueCode,
    /// Where, if in one place.
    pub region: Option<RegionId>,
    /// One sentence with the numbers.
    pub message: String,
}

impl Issue {
    fn new(code: IssueCode, region: Option<RegionId>, message: String) -> Self {
        Self { code, region, message }
    }
}

/// Stable names of issues.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum IssueCode {
    /// Nothing to build from.
    Empty,
    /// The mesh has holes, so the shell is open.
    OpenShell,
    /// A face was dropped and a neighbour extended over it.
    FaceDropped,
    /// A face was put between two others that do not meet.
    FaceAdded,
    /// Corners lie off their surfaces.
    CornerOff,
    /// An edge lies off its surfaces by more than the tolerance.
    GapLarge,
    /// A face became a B-spline.
    Freeform,
    /// Part of a region became flat faces, one per triangle.
    Facets,
}

impl IssueCode {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Empty => "empty",
            Self::OpenShell => "open-shell",
            Self::FaceDropped => "face-dropped",
            Self::FaceAdded => "face-added",
            Self::CornerOff => "corner-off",
            Self::GapLarge => "gap-large",
            Self::Freeform => "freeform",
            Self::Facets => "facets",
        }
    }
}
