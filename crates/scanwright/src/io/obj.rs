//! Wavefront OBJ: vertices and faces; everything else in the format is passed over.

use super::check_numbering;
use super::error::{Place, ReadError, quoted};
use super::polygons::Polygons;
use super::text::{Item, Lines, coordinate, next_word, parse};
use crate::math::Point3;
use crate::mesh::{Mesh, VertId};

/// Statements without triangles.
const PASSED_OVER: &[&[u8]] = &[
    b"vt",
    b"vn",
    b"vp",
    b"g",
    b"o",
    b"s",
    b"l",
    b"p",
    b"usemtl",
    b"mtllib",
    b"usemap",
    b"maplib",
    b"lod",
    b"mg",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"shadow_obj",
    b"trace_obj",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"ctech",
    b"stech",
];

/// Whether the first statement is one that OBJ files begin with.
pub(super) fn is_obj(bytes: &[u8]) -> bool {
    let Some(mut line) = Lines::new(bytes, 0).next_uncommented() else { return false };
    let word = next_word(&mut line).unwrap_or_default();
    matches!(word, b"v" | b"vt" | b"vn" | b"f" | b"g" | b"o" | b"s" | b"mtllib" | b"usemtl")
        && !line.contains(&0)
}

/// The face that refers to the highest vertex so far: vertices may follow the faces that use them.
#[derive(Debug, Clone, Copy)]
struct Farthest {
    index: i64,
    item: Item,
    line: usize,
}

/// Reads the mesh and how many faces had more than three corners.
pub(super) fn read(bytes: &[u8]) -> Result<(Mesh, usize), ReadError> {
    let mut lines = Lines::new(bytes, 0);
    let mut vertices = Vec::new();
    let mut polygons = Polygons::new(VertId::MAX as usize, 1);
    let mut farthest = Farthest { index: 0, item: Item { kind: "face", index: 0 }, line: 0 };
    let mut n_faces = 0;
    while let Some(line) = lines.next_uncommented() {
        let mut rest = line;
        match next_word(&mut rest).expect("the line is not blank") {
            b"v" => {
                let item = Item { kind: "vertex", index: vertices.len() + 1 };
                let mut xyz = [0.0; 3];
                for (axis, x) in xyz.iter_mut().enumerate() {
                    *x = coordinate(next_word(&mut rest), axis, item, || lines.place())?;
                }
                vertices.push(Point3::from(xyz));
            }
            b"f" => {
                n_faces += 1;
                let item = Item { kind: "face", index: n_faces };
                read_face(rest, &mut lines, item, vertices.len(), &mut polygons, &mut farthest)?;
            }
            word if PASSED_OVER.contains(&word) => {}
            word => {
                return Err(ReadError::Value {
                    place: lines.place(),
                    element: "the keyword".to_owned(),
                    value: quoted(word),
                    expected: "'v', 'f' or another keyword of the format",
                });
            }
        }
    }
    check_numbering(vertices.len() as u64, "vertices")?;
    let last = vertices.len() as i64;
    if last < farthest.index {
        let Farthest { index, item, line } = farthest;
        return Err(ReadError::Index {
            place: Place::Line(line),
            element: item.to_string(),
            index,
            first: 1,
            last,
        });
    }
    Ok((Mesh { vertices, triangles: polygons.triangles }, polygons.n_larger))
}

fn read_face<'a>(
    mut rest: &'a [u8],
    lines: &mut Lines<'a>,
    item: Item,
    n_vertices: usize,
    polygons: &mut Polygons,
    farthest: &mut Farthest,
) -> Result<(), ReadError> {
    while let Some(word) = next_word(&mut rest) {
        if word == b"\\" && rest.trim_ascii().is_empty() {
            rest = lines.next_line().unwrap_or_default();
            continue;
        }
        // Of "vertex/texture/normal" the first counts.
        let number = word.split(|&b| b == b'/').next().unwrap_or_default();
        let Some(given) = parse::<i64>(number) else {
            return Err(ReadError::Value {
                place: lines.place(),
                element: format!("a corner of {item}"),
                value: quoted(word),
                expected: "a whole number, as in '7', '7/1' or '7//3'",
            });
        };
        // Negative indices count back from the vertex read last.
        let index = if given < 0 { given.saturating_add(n_vertices as i64 + 1) } else { given };
        if index < 1 || i64::from(VertId::MAX) <= index {
            let (element, last) = (item.to_string(), n_vertices as i64);
            return Err(ReadError::Index { place: lines.place(), element, index: given, first: 1, last });
        }
        if farthest.index < index {
            *farthest = Farthest { index, item, line: lines.number };
        }
        polygons.corner(index, item, || lines.place())?;
    }
    polygons.finish(item, || lines.place())
}
