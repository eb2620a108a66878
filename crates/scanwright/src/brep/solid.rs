//! The flat B-rep: vectors and index newtypes, geometry stored once.

use crate::math::{Frame, Point3};
use crate::segment::RegionId;
use crate::surface::bspline::SplineSurface;
use crate::surface::{Surface, SurfaceKind};

use super::curve::Curve;

/// Index into [`Solid::vertices`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VertexId(pub u32);
/// Index into [`Solid::edges`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EdgeId(pub u32);
/// Index into [`Solid::faces`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FaceId(pub u32);
/// Index into [`Solid::surfaces`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SurfaceId(pub u32);

/// A corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Where it is.
    pub point: Point3,
}

/// A bounded curve that runs from `start` to `end` in the direction of its parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// The curve, unbounded where it is a line or conic.
    pub curve: Curve,
    /// Where it begins.
    pub start: VertexId,
    /// Where it ends; never `start`.
    pub end: VertexId,
}

/// One use of an edge by a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EdgeUse {
    /// The edge.
    pub edge: EdgeId,
    /// Whether the loop runs along the edge rather than against it.
    pub forward: bool,
}

/// A closed run of edges, the face on its left when seen from outside.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Loop {
    /// In order; the end of each use is the start of the next.
    pub uses: Vec<EdgeUse>,
}

/// What lies under a face.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// One of the five analytic surfaces.
    Analytic(Surface),
    /// A fitted bicubic B-spline, where no analytic surface describes the region.
    Spline(SplineSurface),
}

impl Geometry {
    /// The analytic type, `None` for a spline.
    pub fn kind(&self) -> Option<SurfaceKind> {
        match self {
            Self::Analytic(surface) => Some(surface.kind()),
            Self::Spline(_) => None,
        }
    }
}

/// A bounded piece of a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// Its surface.
    pub surface: SurfaceId,
    /// Placement of the surface's parameters, turned so that the face stays clear of seams and poles. Its third
    /// direction is the axis (the normal of a plane); meaningless for a spline.
    pub frame: Frame,
    /// Whether the surface's natural normal points out of the material.
    pub same_sense: bool,
    /// The outer loop first, then the holes.
    pub loops: Vec<Loop>,
    /// The region it was made from.
    pub region: RegionId,
    /// Whether most of its mesh was invented to close a hole of the scan.
    pub assumed: bool,
}

/// A connected set of faces.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shell {
    /// Its faces.
    pub faces: Vec<FaceId>,
    /// Whether every edge of it has two faces.
    pub closed: bool,
}

/// One part: an outer shell and the shells of its cavities.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Solid {
    /// Corners.
    pub vertices: Vec<Vertex>,
    /// Bounded curves.
    pub edges: Vec<Edge>,
    /// Surfaces, each once.
    pub surfaces: Vec<Geometry>,
    /// Faces.
    pub faces: Vec<Face>,
    /// The outer shell first, then the cavities.
    pub shells: Vec<Shell>,
    /// Largest measured distance between an edge's curve and its faces' surfaces or its vertices, length.
    pub gap: f64,
}

impl Solid {
    /// Where a vertex is.
    pub fn point(&self, vertex: VertexId) -> Point3 {
        self.vertices[vertex.0 as usize].point
    }

    /// An edge.
    pub fn edge(&self, edge: EdgeId) -> &Edge {
        &self.edges[edge.0 as usize]
    }

    /// A face.
    pub fn face(&self, face: FaceId) -> &Face {
        &self.faces[face.0 as usize]
    }

    /// The surface under a face.
    pub fn geometry(&self, face: &Face) -> &Geometry {
        &self.surfaces[face.surface.0 as usize]
    }

    /// Where a use of an edge begins and ends.
    pub fn ends(&self, edge_use: EdgeUse) -> (VertexId, VertexId) {
        let edge = self.edge(edge_use.edge);
        if edge_use.forward { (edge.start, edge.end) } else { (edge.end, edge.start) }
    }

    /// Adds the shells of another solid; the two share nothing.
    pub fn append(&mut self, other: Self) {
        let [n_vertices, n_edges, n_surfaces, n_faces] =
            [self.vertices.len(), self.edges.len(), self.surfaces.len(), self.faces.len()].map(|n| n as u32);
        self.vertices.extend(other.vertices);
        self.edges.extend(other.edges.into_iter().map(|edge| Edge {
            start: VertexId(edge.start.0 + n_vertices),
            end: VertexId(edge.end.0 + n_vertices),
            ..edge
        }));
        self.surfaces.extend(other.surfaces);
        self.faces.extend(other.faces.into_iter().map(|mut face| {
            face.surface.0 += n_surfaces;
            face.loops.iter_mut().flat_map(|l| &mut l.uses).for_each(|u| u.edge.0 += n_edges);
            face
        }));
        self.shells.extend(other.shells.into_iter().map(|mut shell| {
            shell.faces.iter_mut().for_each(|face| face.0 += n_faces);
            shell
        }));
        self.gap = self.gap.max(other.gap);
    }

    /// Whether every shell is closed.
    pub fn is_closed(&self) -> bool {
        !self.shells.is_empty() && self.shells.iter().all(|shell| shell.closed)
    }
}
