//! The triangles of one solid or surface model, in its own coordinates.
//!
//! Edges are sampled once, so faces that share them meet without cracks.

use std::collections::BTreeMap;

use super::StepReadError;
use super::curve::{self, Along, Curve};
use super::fill::fill;
use super::layout::{Corner, Layout, Node, layout};
use super::part21::Exchange;
use super::patch::Patch;
use super::placement::point;
use super::surface;
use super::topology::{self, Bound, EdgeText, FaceText, FaceUse};
use crate::math::{Frame, Point3, Vec3, try_unit};
use crate::mesh::Mesh;
use crate::prior::PriorFace;

/// Largest distance of chords from curve and surface, as a share of the shape's diagonal: 3 um on 100 mm, a tenth of the
/// noise of a good scanner.
const CHORD: f64 = 3e-5;
/// Most vertices of one shape.
const MOST_VERTICES: usize = 20_000_000;
/// Faces triangulated between two looks at how many vertices there are.
const CHUNK: usize = 256;

/// Triangles of a shape and what was left out of it.
#[derive(Debug, Clone, Default)]
pub(super) struct ShapeMesh {
    pub(super) mesh: Mesh,
    /// One per triangle.
    pub(super) face_of: Vec<u32>,
    pub(super) faces: Vec<PriorFace>,
    pub(super) unread: Vec<String>,
}

/// A face ready to be laid out.
struct Face {
    id: u64,
    text: FaceText,
    /// Whether the shell uses it the other way round.
    reversed: bool,
    patch: Patch,
}

/// An edge sampled.
struct Edge {
    curve: Option<Curve>,
    /// Parameters of the points.
    at: Vec<f64>,
    /// Vertices of the shape, from its start.
    vertices: Vec<u32>,
}

/// Vertices of a shape, found by their coordinates' bits.
#[derive(Default)]
struct Vertices {
    points: Vec<Point3>,
    known: BTreeMap<[u64; 3], u32>,
}

impl Vertices {
    /// The vertex at a corner: one for all corners with the same coordinates.
    fn corner(&mut self, p: Point3) -> u32 {
        // Adding zero makes minus zero plain.
        let key = [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits());
        let next = self.points.len() as u32;
        let id = *self.known.entry(key).or_insert(next);
        if id == next {
            self.points.push(p);
        }
        id
    }

    fn add(&mut self, p: Point3) -> u32 {
        self.points.push(p);
        self.points.len() as u32 - 1
    }
}

/// Reads and triangulates the shape `item`; `radians`: the unit of its angles.
pub(super) fn mesh(exchange: &Exchange, item: u64, radians: f64) -> Result<ShapeMesh, StepReadError> {
    let mut made = ShapeMesh::default();
    let uses = topology::faces(exchange, item, &mut made.unread)?;
    let mut texts: Vec<(FaceUse, FaceText, bool)> = Vec::new();
    for use_ in uses {
        match topology::face(exchange, use_) {
            Ok((text, reversed)) => texts.push((use_, text, reversed)),
            Err(error) => made.leave_out(use_.id, &error),
        }
    }
    let mut vertices = Vertices::default();
    let edges = Edges::read(exchange, &texts);
    let faces = faces(exchange, radians, texts, &edges, &mut made);
    let tolerance = CHORD * diagonal(&faces, &edges);
    let edges = edges.sampled(&faces, tolerance, &mut vertices)?;
    for chunk in faces.chunks(CHUNK) {
        let loops: Vec<_> = chunk.iter().map(|f| loops(exchange, f, &edges, &mut vertices)).collect();
        let pieces = crate::par::map_indices(chunk.len(), |i| {
            let loops = loops[i].as_ref().map_err(Clone::clone)?;
            triangles(&chunk[i], loops, &vertices.points, tolerance)
        });
        for (face, piece) in chunk.iter().zip(pieces) {
            match piece {
                Ok(piece) => made.add(face, piece, &mut vertices),
                Err(error) => made.leave_out(face.id, &error),
            }
        }
        if vertices.points.len() > MOST_VERTICES {
            return Err(StepReadError::TooLarge { id: item, most: MOST_VERTICES, what: "vertices" });
        }
    }
    made.mesh.vertices = vertices.points;
    Ok(made.without_unused())
}

impl ShapeMesh {
    fn leave_out(&mut self, face: u64, error: &StepReadError) {
        self.unread.push(format!("face #{face} is left out: {error}"));
    }

    fn add(&mut self, face: &Face, (layout, triangles): (Layout, Vec<[Node; 3]>), vertices: &mut Vertices) {
        let base = vertices.points.len() as u32;
        vertices.points.extend(layout.own);
        let number = self.faces.len() as u32;
        let flips = [!face.text.same_sense, face.patch.mirrored, face.reversed];
        let is_flipped = flips.iter().filter(|f| **f).count() % 2 == 1;
        let first = self.mesh.triangles.len();
        for triangle in triangles {
            let [a, b, c] = triangle.map(|node| match node {
                Node::Shared(id) => id,
                Node::Own(id) => base + id,
            });
            self.mesh.triangles.push(if is_flipped { [a, c, b] } else { [a, b, c] });
            self.face_of.push(number);
        }
        let mut read =
            PriorFace { name: face.text.name.clone(), surface: face.patch.analytic, outward: true };
        // Which way the natural normal points, by the triangles: parametrizations differ, areas do not.
        if let Some(surface) = &read.surface {
            let along: f64 = self.mesh.triangles[first..]
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(|v| vertices.points[v as usize]);
                    let center = Point3::from((a.coords + b.coords + c.coords) / 3.0);
                    (b - a).cross(&(c - a)).dot(&surface.normal(&center))
                })
                .sum();
            read.outward = along >= 0.0;
        }
        self.faces.push(read);
    }

    /// Without vertices that no triangle uses.
    fn without_unused(mut self) -> Self {
        let mut new = vec![u32::MAX; self.mesh.vertices.len()];
        let mut kept = Vec::new();
        for v in self.mesh.triangles.iter_mut().flatten() {
            let slot = &mut new[*v as usize];
            if *slot == u32::MAX {
                *slot = kept.len() as u32;
                kept.push(self.mesh.vertices[*v as usize]);
            }
            *v = *slot;
        }
        self.mesh.vertices = kept;
        self
    }
}

/// The edges of a shape by number, not yet sampled; an error is told by each face that has the edge.
struct Edges(BTreeMap<u64, Result<RawEdge, StepReadError>>);

struct RawEdge {
    text: EdgeText,
    ends: [Point3; 2],
    curve: Option<Curve>,
}

impl Edges {
    fn read(exchange: &Exchange, faces: &[(FaceUse, FaceText, bool)]) -> Self {
        let bounds = faces.iter().flat_map(|(_, text, _)| &text.bounds);
        let ids = bounds.flat_map(|b| match b {
            Bound::Edges(edges) => edges.as_slice(),
            Bound::Points(_) | Bound::Vertex => &[],
        });
        let mut edges = BTreeMap::new();
        for (id, _) in ids {
            edges.entry(*id).or_insert_with(|| raw_edge(exchange, *id));
        }
        Self(edges)
    }

    fn get(&self, id: u64) -> Result<&RawEdge, StepReadError> {
        self.0[&id].as_ref().map_err(Clone::clone)
    }

    fn sampled(
        self,
        faces: &[Face],
        tolerance: f64,
        vertices: &mut Vertices,
    ) -> Result<BTreeMap<u64, Edge>, StepReadError> {
        let mut edges = BTreeMap::new();
        for (id, raw) in self.0 {
            let Ok(raw) = raw else { continue };
            let ends = raw.ends.map(|p| vertices.corner(p));
            let along = Along { forward: raw.text.same_sense, is_loop: ends[0] == ends[1], tolerance };
            let (at, points) = match &raw.curve {
                Some(curve) => curve.samples(raw.ends, along),
                None => (vec![0.0, 1.0], raw.ends.to_vec()),
            };
            let inner = &points[1..points.len() - 1];
            let mut ids = vec![ends[0]];
            ids.extend(inner.iter().map(|p| vertices.add(*p)));
            ids.push(ends[1]);
            edges.insert(id, Edge { curve: raw.curve, at, vertices: ids });
            if vertices.points.len() > MOST_VERTICES {
                return Err(StepReadError::TooLarge { id, most: MOST_VERTICES, what: "vertices" });
            }
        }
        for face in faces {
            for (_, pole) in face.patch.poles.iter().flatten() {
                for id in edge_ids(&face.text) {
                    if let Some(edge) = edges.get_mut(&id) {
                        edge.pass_through(pole, tolerance, vertices);
                    }
                }
            }
        }
        Ok(edges)
    }
}

impl Edge {
    /// Adds a sample where the edge passes through a pole, so that the border does not jump over it.
    fn pass_through(&mut self, pole: &Point3, tolerance: f64, vertices: &mut Vertices) {
        let Some(curve) = &self.curve else { return };
        let known =
            self.vertices.iter().any(|v| (vertices.points[*v as usize] - pole).norm() <= at_pole(tolerance));
        let mut t = curve.parameter(pole);
        let (first, last) = (self.at[0], self.at[self.at.len() - 1]);
        let (low, high) = (first.min(last), first.max(last));
        if let Some(period) = curve.period() {
            t = low + (t - low).rem_euclid(period);
        }
        if known
            || !(low < t && t < high)
            || (curve.point(curve.wrapped(t)) - pole).norm() > at_pole(tolerance)
        {
            return;
        }
        let before = self.at.iter().position(|s| (*s > t) == (last > first) && *s != t);
        let i = before.unwrap_or(self.at.len() - 1).max(1);
        self.at.insert(i, t);
        self.vertices.insert(i, vertices.add(*pole));
    }
}

/// Distance within which a point is at a pole: a tenth of that by which chords miss the curves.
fn at_pole(tolerance: f64) -> f64 {
    0.1 * tolerance
}

fn raw_edge(exchange: &Exchange, id: u64) -> Result<RawEdge, StepReadError> {
    let text = topology::edge(exchange, id)?;
    let ends = [point(exchange, text.ends[0])?, point(exchange, text.ends[1])?];
    let curve = text.curve.map(|c| curve::read(exchange, c)).transpose()?;
    Ok(RawEdge { text, ends, curve })
}

fn edge_ids(text: &FaceText) -> Vec<u64> {
    let mut ids = Vec::new();
    for bound in &text.bounds {
        if let Bound::Edges(edges) = bound {
            ids.extend(edges.iter().map(|(id, _)| *id));
        }
    }
    ids
}

fn faces(
    exchange: &Exchange,
    radians: f64,
    texts: Vec<(FaceUse, FaceText, bool)>,
    edges: &Edges,
    made: &mut ShapeMesh,
) -> Vec<Face> {
    let mut faces = Vec::new();
    for (use_, text, reversed) in texts {
        match patch(exchange, radians, &text, edges) {
            Ok(patch) => faces.push(Face { id: use_.id, text, reversed, patch }),
            Err(error) => made.leave_out(use_.id, &error),
        }
    }
    faces
}

fn patch(exchange: &Exchange, radians: f64, text: &FaceText, edges: &Edges) -> Result<Patch, StepReadError> {
    let mut border = Vec::new();
    for id in edge_ids(text) {
        border.extend(edges.get(id)?.rough());
    }
    for bound in &text.bounds {
        if let Bound::Points(ids) = bound {
            for id in ids {
                border.push(point(exchange, *id)?);
            }
        }
    }
    match text.surface {
        Some(id) => surface::read(exchange, id, radians, &border),
        None => Ok(Patch::plane(corner_plane(&border))),
    }
}

/// The plane of a polygon by its vector area (M. E. Newell's normal).
fn corner_plane(points: &[Point3]) -> Frame {
    let center = crate::math::centroid(points);
    let pairs = points.iter().zip(points.iter().cycle().skip(1));
    let normal: Vec3 = pairs.map(|(a, b)| (a - center).cross(&(b - center))).sum();
    Frame::from_z(center, try_unit(normal).unwrap_or(Vec3::z_axis()))
}

impl RawEdge {
    /// A few points of the edge.
    fn rough(&self) -> Vec<Point3> {
        let mut points = self.ends.to_vec();
        if let Some(curve) = &self.curve {
            let is_loop = self.ends[0] == self.ends[1];
            let along = Along { forward: self.text.same_sense, is_loop, tolerance: f64::INFINITY };
            // One sample per piece is enough to see the extent.
            points = curve.rough(self.ends, along);
        }
        points
    }
}

/// Diagonal of the box around all edges, and around what is closed without them.
fn diagonal(faces: &[Face], edges: &Edges) -> f64 {
    let mut vertices: Vec<Point3> = edges.0.values().flatten().flat_map(RawEdge::rough).collect();
    for face in faces {
        if edge_ids(&face.text).is_empty() {
            vertices.extend(face.patch.extent());
        }
    }
    Mesh { vertices, triangles: Vec::new() }.diagonal()
}

/// The loops of a face, counter-clockwise about the normal of its patch's parameters.
fn loops(
    exchange: &Exchange,
    face: &Face,
    edges: &BTreeMap<u64, Edge>,
    vertices: &mut Vertices,
) -> Result<Vec<Vec<Corner>>, StepReadError> {
    let mut all = Vec::new();
    for bound in &face.text.bounds {
        let mut ids = Vec::new();
        match bound {
            Bound::Vertex => continue,
            Bound::Points(points) => {
                for id in points {
                    ids.push(vertices.corner(point(exchange, *id)?));
                }
                ids.dedup();
            }
            Bound::Edges(uses) => {
                for (i, (id, forward)) in uses.iter().enumerate() {
                    let mut run = edges[id].vertices.clone();
                    if !forward {
                        run.reverse();
                    }
                    let next = &uses[(i + 1) % uses.len()];
                    let after = &edges[&next.0].vertices;
                    let start = if next.1 { after[0] } else { after[after.len() - 1] };
                    let end = run.pop().expect("an edge has two ends");
                    if end != start {
                        let gap = (vertices.points[end as usize] - vertices.points[start as usize]).norm();
                        let size = run
                            .iter()
                            .map(|v| (vertices.points[*v as usize] - vertices.points[end as usize]).norm());
                        if gap > size.fold(0.0, f64::max) {
                            return Err(StepReadError::Face {
                                id: face.id,
                                reason: "its edges do not follow one another",
                            });
                        }
                        run.push(end);
                    }
                    ids.extend(run);
                }
            }
        }
        if ids.iter().any(|v| vertices.points[*v as usize].iter().any(|x| !x.is_finite())) {
            return Err(StepReadError::Face {
                id: face.id,
                reason: "a curve of its border is beyond all numbers",
            });
        }
        if face.text.same_sense == face.patch.mirrored {
            ids.reverse();
        }
        all.push(ids.iter().map(|v| Corner { point: vertices.points[*v as usize], vertex: *v }).collect());
    }
    Ok(all)
}

fn triangles(
    face: &Face,
    loops: &[Vec<Corner>],
    points: &[Point3],
    tolerance: f64,
) -> Result<(Layout, Vec<[Node; 3]>), StepReadError> {
    let failed = |reason| StepReadError::Face { id: face.id, reason };
    let attempt = |patch: &Patch, loops: &[Vec<Corner>]| {
        let mut laid = layout(patch, loops, tolerance, at_pole(tolerance))?;
        let triangles = fill(patch, &mut laid, points, tolerance).ok_or("its numbers are too large")?;
        if laid.own.iter().any(|p| p.iter().any(|x| !x.is_finite())) {
            return Err("its numbers are too large");
        }
        if triangles.is_empty() { Err("its border encloses nothing") } else { Ok((laid, triangles)) }
    };
    let first = match attempt(&face.patch, loops) {
        Ok(made) => return Ok(made),
        Err(reason) => reason,
    };
    // A sphere has no axis of its own: where one does not serve, others may. Last, all senses the other way round.
    if let Some(made) = face.patch.turned().iter().find_map(|patch| attempt(patch, loops).ok()) {
        return Ok(made);
    }
    let turned: Vec<Vec<Corner>> = loops.iter().map(|l| l.iter().rev().copied().collect()).collect();
    attempt(&face.patch, &turned).map_err(|_| failed(first))
}
