//! PLY, ascii and binary in both orders.
//!
//! Elements other than `vertex` and `face`, and properties other than coordinates and corner lists, are passed over.

mod body;
mod header;

use super::error::{Place, ReadError};
use super::polygons::Polygons;
use super::text::{Item, bad_coordinate};
use super::{check_numbering, is_coordinate};
use crate::math::Point3;
use crate::mesh::Mesh;
use body::{Body, Number};
use header::{Element, Header, Kind};

/// Whether the file begins as PLY files do.
pub(super) fn is_ply(bytes: &[u8]) -> bool {
    bytes.len() > 3 && bytes.starts_with(b"ply") && bytes[3].is_ascii_whitespace()
}

/// What was read of a PLY file.
#[derive(Debug, Default)]
pub(super) struct Ply {
    pub mesh: Mesh,
    pub n_polygons: usize,
    /// The face property asked for, one per triangle of `mesh`; `None` when the faces have none.
    pub labels: Option<Vec<i32>>,
}

/// Reads a PLY file; `label` names a face property to read too.
pub(super) fn read(bytes: &[u8], label: Option<&str>) -> Result<Ply, ReadError> {
    let header = Header::read(bytes)?;
    check_elements(&header)?;
    let n_vertices = header.elements.iter().find(|e| e.name == b"vertex").map_or(0, |e| e.count);
    let mut body = Body::new(bytes, &header);
    let mut ply = Ply::default();
    let mut last = "vertices";
    for element in &header.elements {
        match element.name {
            b"vertex" => {
                last = "vertices";
                body.check_count(element, header.encoding, last)?;
                check_numbering(n_vertices, last)?;
                ply.mesh.vertices = read_vertices(&mut body, element)?;
            }
            b"face" => {
                last = "faces";
                body.check_count(element, header.encoding, last)?;
                read_faces(&mut body, element, n_vertices as usize, label, &mut ply)?;
            }
            _ => {
                last = "elements";
                body.check_count(element, header.encoding, last)?;
                skip_element(&mut body, element)?;
            }
        }
    }
    body.check_end(last)?;
    if ply.mesh.triangles.is_empty() {
        check_strips(&header)?;
    }
    Ok(ply)
}

/// Refuses a second element of a name that is read.
fn check_elements(header: &Header<'_>) -> Result<(), ReadError> {
    for name in [&b"vertex"[..], b"face"] {
        if let Some(second) = header.elements.iter().filter(|e| e.name == name).nth(1) {
            return Err(ReadError::Value {
                place: Place::Line(second.line),
                element: "the element".to_owned(),
                value: format!("a second {}", super::error::quoted(name)),
                expected: "declared once",
            });
        }
    }
    Ok(())
}

fn check_strips(header: &Header<'_>) -> Result<(), ReadError> {
    match header.elements.iter().find(|e| e.name == b"tristrips") {
        Some(strips) => Err(ReadError::Unsupported {
            place: Place::Line(strips.line),
            what: "a PLY of triangle strips".to_owned(),
            instead: "save it with single faces (element 'face')",
        }),
        None => Ok(()),
    }
}

fn read_vertices(body: &mut Body<'_>, element: &Element<'_>) -> Result<Vec<Point3>, ReadError> {
    let axis_of = axes(element)?;
    let mut vertices = Vec::with_capacity(element.count as usize);
    for index in 0..element.count as usize {
        let item = Item { kind: "vertex", index };
        body.start_row(item)?;
        let mut xyz = [0.0; 3];
        for (property, axis) in element.properties.iter().zip(&axis_of) {
            match (property.kind, axis) {
                (Kind::Scalar(scalar), Some(axis)) => {
                    let place = body.place();
                    let x = body.scalar(scalar, item)?.as_real();
                    if !is_coordinate(x) {
                        return Err(bad_coordinate(Some(x.to_string().as_bytes()), *axis, item, place));
                    }
                    xyz[*axis] = x;
                }
                (kind, _) => body.skip(kind, item)?,
            }
        }
        body.end_row(item)?;
        vertices.push(Point3::from(xyz));
    }
    Ok(vertices)
}

/// Per property of the vertices, the coordinate that it holds.
fn axes(element: &Element<'_>) -> Result<Vec<Option<usize>>, ReadError> {
    let mut axis_of = vec![None; element.properties.len()];
    for (axis, name) in [&b"x"[..], b"y", b"z"].into_iter().enumerate() {
        match element.property(name) {
            Some(i) if matches!(element.properties[i].kind, Kind::Scalar(_)) => axis_of[i] = Some(axis),
            found => {
                return Err(ReadError::Value {
                    place: Place::Line(element.line),
                    element: format!("property {} of the vertices", super::error::quoted(name)),
                    value: if found.is_some() { "a list" } else { "missing" }.to_owned(),
                    expected: "a number per vertex",
                });
            }
        }
    }
    Ok(axis_of)
}

fn read_faces(
    body: &mut Body<'_>,
    element: &Element<'_>,
    n_vertices: usize,
    label: Option<&str>,
    ply: &mut Ply,
) -> Result<(), ReadError> {
    let corners = element.property(b"vertex_indices").or_else(|| element.property(b"vertex_index"));
    let corners = corners
        .filter(|&i| matches!(element.properties[i].kind, Kind::List { item, .. } if item.is_integer()));
    let Some(corners) = corners else {
        if element.count == 0 {
            return Ok(());
        }
        return Err(ReadError::Value {
            place: Place::Line(element.line),
            element: "the faces' property 'vertex_indices'".to_owned(),
            value: "missing or no list of an integer type".to_owned(),
            expected: "'property list uchar int vertex_indices'",
        });
    };
    let is_scalar = |p: &usize| matches!(element.properties[*p].kind, Kind::Scalar(_));
    let label = label.and_then(|name| element.property(name.as_bytes())).filter(is_scalar);
    let mut labels = Vec::new();
    // A triangle takes more than the smallest row: reserve what can be there.
    let mut polygons = Polygons::new(n_vertices, 0);
    polygons.triangles.reserve((element.count as usize).min(body.bytes_left() / 4));
    for index in 0..element.count as usize {
        let item = Item { kind: "face", index };
        body.start_row(item)?;
        let mut row_label = 0;
        for (p, property) in element.properties.iter().enumerate() {
            match property.kind {
                Kind::List { count, item: of } if p == corners => {
                    for _ in 0..body.list_length(count, of, item)? {
                        let place = body.place();
                        if let Number::Integer(vertex) = body.scalar(of, item)? {
                            polygons.corner(vertex, item, || place.clone())?;
                        }
                    }
                }
                Kind::Scalar(scalar) if Some(p) == label => {
                    let place = body.place();
                    row_label = label_of(body.scalar(scalar, item)?, item, place)?;
                }
                kind => body.skip(kind, item)?,
            }
        }
        body.end_row(item)?;
        polygons.finish(item, || body.place())?;
        if label.is_some() {
            labels.resize(polygons.triangles.len(), row_label);
        }
    }
    ply.mesh.triangles = polygons.triangles;
    ply.n_polygons = polygons.n_larger;
    ply.labels = label.map(|_| labels);
    Ok(())
}

fn label_of(number: Number, item: Item, place: Place) -> Result<i32, ReadError> {
    let (label, value) = match number {
        Number::Integer(i) => (i32::try_from(i).ok(), i.to_string()),
        Number::Real(x) => (None, x.to_string()),
    };
    let error = || ReadError::Value {
        place,
        element: format!("the label of {item}"),
        value,
        expected: "a whole number of 32 bits",
    };
    label.ok_or_else(error)
}

fn skip_element(body: &mut Body<'_>, element: &Element<'_>) -> Result<(), ReadError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for index in 0..element.count as usize {
        let item = Item { kind: "element", index };
        body.start_row(item)?;
        for property in &element.properties {
            body.skip(property.kind, item)?;
        }
        body.end_row(item)?;
    }
    Ok(())
}
