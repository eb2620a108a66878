//! STL, binary and ASCII: a soup of triangles, each with its own three corners.
//!
//! The size decides: a file of 84 + 50 n bytes with n at byte 80 is binary even if it begins with "solid", as many
//! writers' headers do. Normals are not read; the order of the corners says the same.

use super::error::{Place, ReadError, quoted};
use super::text::{Item, Lines, bad_coordinate, coordinate, next_word};
use super::{check_numbering, is_coordinate};
use crate::math::Point3;
use crate::mesh::Mesh;

const HEADER: usize = 84;
const RECORD: usize = 50;

/// Whether the size is that of a binary STL with the declared count.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    declared(bytes).is_some_and(|n| HEADER as u64 + RECORD as u64 * n == bytes.len() as u64)
}

fn declared(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(u64::from(u32::from_le_bytes(count.try_into().expect("four bytes"))))
}

/// Whether the file begins like an ASCII STL and goes on as text.
pub(super) fn is_ascii(bytes: &[u8]) -> bool {
    /// A binary file that begins with "solid" has its count and first floats within this many bytes.
    const LOOKED_AT: usize = 512;
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let begins = text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    begins && !bytes[..bytes.len().min(LOOKED_AT)].contains(&0)
}

pub(super) fn read_binary(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let place = Place::Byte(HEADER - 4);
    let Some(n) = declared(bytes) else {
        return Err(ReadError::Truncated {
            place: Place::Byte(bytes.len()),
            element: "the STL header".to_owned(),
        });
    };
    let possible = ((bytes.len() - HEADER) / RECORD) as u64;
    if possible < n {
        return Err(ReadError::Count { place, element: "triangles", declared: n, possible });
    }
    let end = HEADER + RECORD * n as usize;
    if end < bytes.len() {
        return Err(ReadError::Trailing { place: Place::Byte(end), element: "triangles" });
    }
    check_numbering(3 * n, "corners")?;
    let mut vertices = Vec::with_capacity(3 * n as usize);
    for (t, record) in bytes[HEADER..].chunks_exact(RECORD).enumerate() {
        for corner in 0..3 {
            let at = 12 + 12 * corner;
            let xyz: [f64; 3] = std::array::from_fn(|axis| {
                let raw = &record[at + 4 * axis..at + 4 * axis + 4];
                f64::from(f32::from_le_bytes(raw.try_into().expect("four bytes")))
            });
            if let Some(axis) = xyz.iter().position(|x| !is_coordinate(*x)) {
                let place = Place::Byte(HEADER + t * RECORD + at + 4 * axis);
                let value = xyz[axis].to_string();
                let item = Item { kind: "corner", index: corner };
                let error = bad_coordinate(Some(value.as_bytes()), axis, item, place);
                return Err(in_triangle(error, t));
            }
            vertices.push(Point3::from(xyz));
        }
    }
    Ok(soup(vertices))
}

pub(super) fn read_ascii(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let mut lines = Lines::new(bytes, 0);
    let mut vertices = Vec::new();
    let mut inside_solid = false;
    // Corners of the facet being read; `None` between facets.
    let mut n_corners = None;
    while let Some(line) = lines.next_nonblank() {
        let mut rest = line;
        let word = next_word(&mut rest).expect("the line is not blank");
        let n_triangles = vertices.len() / 3;
        let keyword = word.to_ascii_lowercase();
        match (keyword.as_slice(), n_corners) {
            (b"vertex", Some(n)) if n < 3 => {
                let item = Item { kind: "corner", index: n };
                let mut xyz = [0.0; 3];
                for (axis, x) in xyz.iter_mut().enumerate() {
                    *x = coordinate(next_word(&mut rest), axis, item, || lines.place())
                        .map_err(|error| in_triangle(error, n_triangles))?;
                }
                vertices.push(Point3::from(xyz));
                n_corners = Some(n + 1);
            }
            (b"facet", None) if inside_solid => n_corners = Some(0),
            (b"outer", Some(0)) | (b"endloop", Some(3)) => {}
            (b"endfacet", Some(3)) => n_corners = None,
            (b"solid", None) if !inside_solid => inside_solid = true,
            (b"endsolid", None) if inside_solid => inside_solid = false,
            _ => return Err(unexpected(word, n_corners, inside_solid, &lines)),
        }
    }
    if inside_solid {
        let element = format!("a solid, after {} triangles, without 'endsolid'", vertices.len() / 3);
        return Err(ReadError::Truncated { place: lines.place(), element });
    }
    check_numbering(vertices.len() as u64, "corners")?;
    Ok(soup(vertices))
}

fn soup(vertices: Vec<Point3>) -> Mesh {
    let triangles = (0..vertices.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Mesh { vertices, triangles }
}

fn unexpected(word: &[u8], n_corners: Option<usize>, inside_solid: bool, lines: &Lines<'_>) -> ReadError {
    let expected = match n_corners {
        Some(3) => "'endloop' or 'endfacet', a triangle has three corners",
        Some(0) => "'outer loop' or 'vertex'",
        Some(_) => "'vertex'",
        None if inside_solid => "'facet' or 'endsolid'",
        None => "'solid'",
    };
    ReadError::Value {
        place: lines.place(),
        element: "the keyword".to_owned(),
        value: quoted(word),
        expected,
    }
}

fn in_triangle(error: ReadError, triangle: usize) -> ReadError {
    match error {
        ReadError::Value { place, element, value, expected } => {
            ReadError::Value { place, element: format!("{element} of triangle {triangle}"), value, expected }
        }
        other => other,
    }
}
