//! Whether a solid is one: every problem of the B-rep as it will be written, one file per check.
//!
//! Kernels heal what they read (flipped faces, small gaps), so their verdict is no proof; these checks heal nothing.

pub(super) mod curve_on_surface;
mod edge_use;
mod euler;
mod loop_closed;
mod loop_crossing;
mod loop_direction;
mod loop_winding;
mod vertex_on_curve;
mod volume;

use super::solid::{EdgeId, FaceId, Solid, VertexId};
use crate::math::Point3;

/// How sound a solid is; each rung holds all below it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Validity {
    /// Some edge lacks a second face, or some loop does not close.
    Open,
    /// Every edge has two faces and every loop closes.
    Closed,
    /// Edges are used in opposite senses, loops run the right way, the volume is positive.
    Oriented,
    /// Geometry lies on geometry within the gap, no loops cross, the counts are those of a solid.
    Valid,
}

/// One thing wrong with a solid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// Uses of an edge are not one in each sense.
    #[error("edge {edge:?} is used {forward} times forward and {backward} times backward, not once each")]
    EdgeUse {
        /// The edge.
        edge: EdgeId,
        /// Uses along it.
        forward: usize,
        /// Uses against it.
        backward: usize,
    },
    /// A loop has a use that does not begin where the one before ended, or none at all.
    #[error("loop {index} of face {face:?} does not close")]
    LoopOpen {
        /// The face.
        face: FaceId,
        /// Which of its loops.
        index: usize,
    },
    /// A loop runs the wrong way round its face.
    #[error(
        "loop {index} of face {face:?} runs the wrong way or encloses nothing: area {area:.3e} in the parameter plane"
    )]
    LoopDirection {
        /// The face.
        face: FaceId,
        /// Which of its loops.
        index: usize,
        /// Signed area seen from outside.
        area: f64,
    },
    /// A loop goes round the axis or the spine of its surface, which takes two loops to bound a face.
    #[error("loop {index} of face {face:?} goes round its surface")]
    LoopWinds {
        /// The face.
        face: FaceId,
        /// Which of its loops.
        index: usize,
    },
    /// Loops of a face cross each other or themselves.
    #[error("loops of face {face:?} cross at {crossings} places, among them edges {edges:?}")]
    LoopsCross {
        /// The face.
        face: FaceId,
        /// The edges of one of the crossings.
        edges: [EdgeId; 2],
        /// Where the crossings are, on the face.
        places: Vec<Point3>,
        /// Pairs of crossing segments.
        crossings: usize,
    },
    /// A vertex is off the end of an edge's curve.
    #[error("vertex {vertex:?} is {distance} off the curve of edge {edge:?}, more than {gap}")]
    VertexOffCurve {
        /// The vertex.
        vertex: VertexId,
        /// The edge.
        edge: EdgeId,
        /// Measured distance.
        distance: f64,
        /// Allowed distance.
        gap: f64,
    },
    /// A curve is off the surface of a face that uses it.
    #[error("the curve of edge {edge:?} is {distance} off the surface of face {face:?}, more than {gap}")]
    CurveOffSurface {
        /// The edge.
        edge: EdgeId,
        /// The face.
        face: FaceId,
        /// Measured distance.
        distance: f64,
        /// Allowed distance.
        gap: f64,
    },
    /// Counts that no solid has.
    #[error(
        "{vertices} vertices, {edges} edges, {faces} faces and {holes} holes in faces make no closed shells"
    )]
    Euler {
        /// Vertices in use.
        vertices: usize,
        /// Edges in use.
        edges: usize,
        /// Faces.
        faces: usize,
        /// Loops beyond the first of each face.
        holes: usize,
    },
    /// The solid encloses nothing.
    #[error("the volume is {0}, not positive")]
    Volume(f64),
}

impl Problem {
    /// The highest rung a solid with this problem can be on.
    pub fn limits_to(&self) -> Validity {
        match self {
            Self::EdgeUse { forward, backward, .. } if forward + backward == 2 => Validity::Closed,
            Self::EdgeUse { .. } | Self::LoopOpen { .. } => Validity::Open,
            Self::LoopDirection { .. } | Self::LoopWinds { .. } | Self::Volume(_) => Validity::Closed,
            Self::LoopsCross { .. }
            | Self::VertexOffCurve { .. }
            | Self::CurveOffSurface { .. }
            | Self::Euler { .. } => Validity::Oriented,
        }
    }

    /// The face at fault, if one is.
    pub fn face(&self) -> Option<FaceId> {
        match self {
            Self::LoopOpen { face, .. }
            | Self::LoopDirection { face, .. }
            | Self::LoopWinds { face, .. }
            | Self::LoopsCross { face, .. }
            | Self::CurveOffSurface { face, .. } => Some(*face),
            _ => None,
        }
    }
}

/// All problems of `solid`, whose geometry may be off by `gap`. An open shell has the problem of its free edges.
pub fn check(solid: &Solid, gap: f64) -> Vec<Problem> {
    let mut problems = edge_use::check(solid);
    problems.extend(loop_closed::check(solid));
    let connected = problems.is_empty();
    problems.extend(vertex_on_curve::check(solid, gap));
    problems.extend(curve_on_surface::check(solid, gap));
    if solid.faces.iter().all(|f| f.loops.iter().all(|l| !l.uses.is_empty())) {
        problems.extend(loop_direction::check(solid, gap));
        problems.extend(loop_winding::check(solid));
        problems.extend(loop_crossing::check(solid));
    }
    if connected {
        problems.extend(euler::check(solid));
        problems.extend(volume::check(solid));
    }
    problems
}

/// The rung of a solid with these problems.
pub fn validity(problems: &[Problem]) -> Validity {
    problems.iter().map(Problem::limits_to).min().unwrap_or(Validity::Valid)
}
