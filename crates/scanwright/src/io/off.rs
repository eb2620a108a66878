//! OFF and its variants with colors, normals and texture coordinates, as text.

use super::check_numbering;
use super::error::{Place, ReadError, quoted};
use super::polygons::Polygons;
use super::text::{Item, Lines, coordinate, next_word, parse};
use crate::math::Point3;
use crate::mesh::Mesh;

/// Fewest bytes of a vertex, "0 0 0" and a line end, and of a face, "0" and a line end.
const SMALLEST_VERTEX: usize = 6;
const SMALLEST_FACE: usize = 2;

/// Whether the first word is OFF with one of its prefixes.
pub(super) fn is_off(bytes: &[u8]) -> bool {
    let Some(mut line) = Lines::new(bytes, 0).next_uncommented() else { return false };
    next_word(&mut line).is_some_and(is_keyword)
}

fn is_keyword(word: &[u8]) -> bool {
    word.strip_suffix(b"OFF").is_some_and(|prefix| prefix.iter().all(|b| b"STCN4n".contains(b)))
}

/// Reads the mesh and how many faces had more than three corners.
pub(super) fn read(bytes: &[u8]) -> Result<(Mesh, usize), ReadError> {
    let mut lines = Lines::new(bytes, 0);
    let (n_vertices, n_faces) = read_counts(&mut lines)?;
    check_count(&lines, "vertices", n_vertices, SMALLEST_VERTEX)?;
    check_numbering(n_vertices, "vertices")?;
    let mut vertices = Vec::with_capacity(n_vertices as usize);
    for index in 0..n_vertices as usize {
        let item = Item { kind: "vertex", index };
        let mut line = next_line(&mut lines, item)?;
        let mut xyz = [0.0; 3];
        for (axis, x) in xyz.iter_mut().enumerate() {
            *x = coordinate(next_word(&mut line), axis, item, || lines.place())?;
        }
        vertices.push(Point3::from(xyz));
    }
    check_count(&lines, "faces", n_faces, SMALLEST_FACE)?;
    let mut polygons = Polygons::new(vertices.len(), 0);
    for index in 0..n_faces as usize {
        let item = Item { kind: "face", index };
        let mut line = next_line(&mut lines, item)?;
        let n_corners: u64 = whole(next_word(&mut line), item, "the number of corners", &lines)?;
        for _ in 0..n_corners {
            let corner = whole(next_word(&mut line), item, "a corner", &lines)?;
            polygons.corner(corner, item, || lines.place())?;
        }
        polygons.finish(item, || lines.place())?;
    }
    if lines.next_uncommented().is_some_and(|line| line.iter().any(|&b| b != 0)) {
        return Err(ReadError::Trailing { place: lines.place(), element: "faces" });
    }
    Ok((Mesh { vertices, triangles: polygons.triangles }, polygons.n_larger))
}

/// The keyword, if there is one, and the counts after it.
fn read_counts(lines: &mut Lines<'_>) -> Result<(u64, u64), ReadError> {
    let header = Item { kind: "the header, line", index: 1 };
    let mut line = next_line(lines, header)?;
    let mut after_keyword = line;
    if let Some(keyword) = next_word(&mut after_keyword).filter(|word| is_keyword(word)) {
        line = after_keyword;
        if keyword.iter().any(|b| b"4n".contains(b)) {
            return Err(unsupported(lines, format!("the variant {}", quoted(keyword))));
        }
        if next_word(&mut after_keyword) == Some(b"BINARY") {
            return Err(unsupported(lines, "the binary variant of OFF".to_owned()));
        }
        if line.trim_ascii().is_empty() {
            line = next_line(lines, header)?;
        }
    }
    let count = |word: Option<&[u8]>, element: &str| {
        word.and_then(parse).ok_or_else(|| ReadError::Value {
            place: lines.place(),
            element: element.to_owned(),
            value: word.map_or_else(|| "missing".to_owned(), quoted),
            expected: "a whole number, not negative",
        })
    };
    let n_vertices = count(next_word(&mut line), "the number of vertices")?;
    let n_faces = count(next_word(&mut line), "the number of faces")?;
    Ok((n_vertices, n_faces))
}

fn unsupported(lines: &Lines<'_>, what: String) -> ReadError {
    ReadError::Unsupported { place: lines.place(), what, instead: "save it as plain OFF text or as PLY" }
}

fn next_line<'a>(lines: &mut Lines<'a>, item: Item) -> Result<&'a [u8], ReadError> {
    let line = lines.next_uncommented();
    line.ok_or_else(|| ReadError::Truncated { place: lines.place(), element: item.to_string() })
}

fn check_count(
    lines: &Lines<'_>,
    element: &'static str,
    declared: u64,
    smallest: usize,
) -> Result<(), ReadError> {
    // The last line of a text needs no end.
    let possible = ((lines.bytes_left() + 1) / smallest) as u64;
    if declared <= possible {
        return Ok(());
    }
    Err(ReadError::Count { place: Place::Line(lines.number), element, declared, possible })
}

fn whole<T: std::str::FromStr>(
    word: Option<&[u8]>,
    item: Item,
    what: &str,
    lines: &Lines<'_>,
) -> Result<T, ReadError> {
    word.and_then(parse).ok_or_else(|| ReadError::Value {
        place: lines.place(),
        element: format!("{what} of {item}"),
        value: word.map_or_else(|| "missing".to_owned(), quoted),
        expected: "a whole number",
    })
}
