//! Readers and writers of meshes.
//!
//! Readers check every count against the bytes that are there before they allocate, and every index and coordinate
//! before they return. What they return is what the file says: welding and repair belong to `condition`.

mod error;
mod obj;
mod off;
mod ply;
mod polygons;
mod stl;
mod text;
mod three_mf;
mod write_ply;

pub use error::{Place, ReadError};
pub use write_ply::{write_ply, write_ply_values};

use crate::mesh::{Mesh, VertId};
use std::path::Path;

/// Largest coordinate read. No part has such lengths in any unit; up to here fourth powers of lengths stay finite, and
/// so does `f32`, in which meshes are written.
const LARGEST_COORDINATE: f64 = 1e30;

/// Whether geometry can be done with a coordinate; NaN is none.
fn is_coordinate(x: f64) -> bool {
    x.abs() <= LARGEST_COORDINATE
}

/// A format of mesh files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// STL, binary.
    StlBinary,
    /// STL, text.
    StlAscii,
    /// PLY of any encoding.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Geomview OFF.
    Off,
    /// 3D Manufacturing Format.
    ThreeMf,
}

/// A unit of length that a file declares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// A thousandth of a millimetre.
    Micron,
    /// Millimetre.
    Millimeter,
    /// Ten millimetres.
    Centimeter,
    /// 25.4 millimetres.
    Inch,
    /// Twelve inches.
    Foot,
    /// A thousand millimetres.
    Meter,
}

impl Unit {
    /// Length of the unit in millimetres.
    pub fn millimeters(self) -> f64 {
        match self {
            Self::Micron => 0.001,
            Self::Millimeter => 1.0,
            Self::Centimeter => 10.0,
            Self::Inch => 25.4,
            Self::Foot => 304.8,
            Self::Meter => 1000.0,
        }
    }
}

/// What a file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanFile {
    /// The triangles, in the file's order; a soup if the format (STL) has no indices. At least one.
    pub mesh: Mesh,
    /// The format found.
    pub format: Format,
    /// The unit that the file declares; only 3MF does.
    pub units: Option<Unit>,
    /// Vertices that no triangle uses.
    pub n_unused_vertices: usize,
    /// Faces of more than three corners, cut into fans.
    pub n_polygons: usize,
}

/// Reads the mesh file `path`.
pub fn read_mesh_file(path: &Path) -> Result<ScanFile, ReadError> {
    let name = path.to_string_lossy();
    let bytes = std::fs::read(path).map_err(|source| ReadError::File { path: name.to_string(), source })?;
    read_mesh(&bytes, &name)
}

/// Reads a mesh from the bytes of a file called `name`. The content tells the format; the name's extension only where
/// the content leaves it open.
pub fn read_mesh(bytes: &[u8], name: &str) -> Result<ScanFile, ReadError> {
    let format = detect(bytes, name)?;
    let (mesh, n_polygons, units) = match format {
        Format::StlBinary => (stl::read_binary(bytes)?, 0, None),
        Format::StlAscii => (stl::read_ascii(bytes)?, 0, None),
        Format::Ply => {
            let ply = ply::read(bytes, None)?;
            (ply.mesh, ply.n_polygons, None)
        }
        Format::Obj => {
            let (mesh, n_polygons) = obj::read(bytes)?;
            (mesh, n_polygons, None)
        }
        Format::Off => {
            let (mesh, n_polygons) = off::read(bytes)?;
            (mesh, n_polygons, None)
        }
        Format::ThreeMf => {
            let (mesh, units) = three_mf::read(bytes)?;
            (mesh, 0, units)
        }
    };
    if mesh.triangles.is_empty() {
        let listed = if format == Format::Obj { text::count_points(bytes) } else { 0 };
        return Err(ReadError::NoTriangles { n_points: listed.max(mesh.vertices.len()) });
    }
    let n_unused_vertices = count_unused(&mesh);
    Ok(ScanFile { mesh, format, units, n_unused_vertices, n_polygons })
}

/// Reads an integer property of a PLY file's faces: one value per triangle of the mesh that [`read_mesh`] gives.
pub fn read_ply_face_property(bytes: &[u8], name: &str) -> Result<Vec<i32>, ReadError> {
    let missing = || ReadError::Value {
        place: Place::Line(1),
        element: format!("the faces' property {}", error::quoted(name.as_bytes())),
        value: "missing".to_owned(),
        expected: "declared in the header of a PLY file",
    };
    if !ply::is_ply(bytes) {
        return Err(missing());
    }
    ply::read(bytes, Some(name))?.labels.ok_or_else(missing)
}

fn detect(bytes: &[u8], name: &str) -> Result<Format, ReadError> {
    if bytes.is_empty() {
        return Err(ReadError::Empty);
    }
    let by_content = [
        (ply::is_ply as fn(&[u8]) -> bool, Format::Ply),
        (stl::is_binary, Format::StlBinary),
        (stl::is_ascii, Format::StlAscii),
        (three_mf::is_zip, Format::ThreeMf),
        (off::is_off, Format::Off),
        (obj::is_obj, Format::Obj),
    ];
    if let Some((_, format)) = by_content.iter().find(|(is, _)| is(bytes)) {
        return Ok(*format);
    }
    let extension = Path::new(name).extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("stl") => Ok(Format::StlBinary),
        Some("ply") => Ok(Format::Ply),
        Some("obj") => Ok(Format::Obj),
        Some("off") => Ok(Format::Off),
        Some("3mf") => Ok(Format::ThreeMf),
        _ => Err(match text::count_points(bytes) {
            0 => ReadError::UnknownFormat,
            n_points => ReadError::NoTriangles { n_points },
        }),
    }
}

fn count_unused(mesh: &Mesh) -> usize {
    let mut used = vec![false; mesh.vertices.len()];
    for v in mesh.triangles.as_flattened() {
        used[*v as usize] = true;
    }
    used.iter().filter(|used| !**used).count()
}

/// Refuses more elements than a [`VertId`] can number.
fn check_numbering(n: u64, element: &'static str) -> Result<(), ReadError> {
    let limit = u64::from(VertId::MAX);
    if n < limit { Ok(()) } else { Err(ReadError::TooMany { element, limit }) }
}
