//! Models from STEP files of any system: AP203, AP214, AP242.
//!
//! Every face is triangulated on its own surface, so finely that chords miss it by less than a scan can show, and keeps
//! its surface where that is one of the five. What is not supported is said with the number of its entity, and the other
//! faces are read all the same. ISO 10303-21 (clear text), -42 (geometry and topology), -43 and -44 (placements).

mod curve;
mod error;
mod fill;
mod layout;
mod nurbs;
pub(in crate::step) mod part21;
mod patch;
pub(in crate::step) mod placement;
mod shape;
pub(in crate::step) mod structure;
mod surface;
mod text;
mod topology;
mod units;

use std::collections::BTreeMap;

pub use error::StepReadError;

use crate::mesh::Mesh;
use crate::prior::{PriorModel, PriorPart};
use part21::Exchange;
use shape::ShapeMesh;
use structure::Placed;

/// Most triangles of all placed shapes together.
const MOST_TRIANGLES: usize = 20_000_000;

/// Reads the faces of all solids, shells and surface models of a STEP file, where its assemblies place them.
///
/// Lengths are in the unit of the file's first shape. Chords miss curves and surfaces by 3e-5 of the diagonal of the solid
/// at most, and by no more than a turn of six degrees leaves. A tessellated shape (AP242) is not read.
pub fn read(text: &[u8]) -> Result<PriorModel, StepReadError> {
    let exchange = Exchange::parse(text)?;
    let structure = structure::read(&exchange)?;
    let mut shapes: BTreeMap<(u64, u64), ShapeMesh> = BTreeMap::new();
    let mut model = PriorModel { millimetres: structure.units.millimetres, ..PriorModel::default() };
    model.unread = structure.unread;
    for placed in &structure.placed {
        let shape = shapes.entry((placed.item, placed.units.radians.to_bits())).or_insert_with(|| {
            let shape = shape::mesh(&exchange, placed.item, placed.units.radians).unwrap_or_else(|error| {
                let unread = vec![format!("shape #{} is left out: {error}", placed.item)];
                ShapeMesh { unread, ..ShapeMesh::default() }
            });
            model.unread.extend(shape.unread.iter().cloned());
            shape
        });
        add(&mut model, shape, placed)?;
    }
    if model.mesh.triangles.is_empty() {
        Err(StepReadError::NoFaces { first: model.unread.into_iter().next() })
    } else {
        Ok(model)
    }
}

/// Adds a shape where it is placed.
fn add(model: &mut PriorModel, shape: &ShapeMesh, placed: &Placed) -> Result<(), StepReadError> {
    if model.mesh.triangles.len() + shape.mesh.triangles.len() > MOST_TRIANGLES {
        return Err(StepReadError::TooLarge { id: placed.item, most: MOST_TRIANGLES, what: "triangles" });
    }
    let Mesh { vertices, triangles } = &mut model.mesh;
    let (first_vertex, first_face) = (vertices.len() as u32, model.faces.len() as u32);
    vertices.extend(shape.mesh.vertices.iter().map(|p| placed.motion.point(p)));
    let mirrors = placed.motion.mirrors();
    triangles.extend(shape.mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| v + first_vertex);
        if mirrors { [a, c, b] } else { [a, b, c] }
    }));
    model.face_of.extend(shape.face_of.iter().map(|f| f + first_face));
    for face in &shape.faces {
        let mut face = face.clone();
        if face.name.is_empty() {
            face.name = format!("face {}", model.faces.len() + 1);
        }
        face.surface = face.surface.map(|s| placed.motion.surface(&s));
        model.faces.push(face);
    }
    let n_faces = shape.faces.len() as u32;
    model.parts.push(PriorPart { name: placed.name.clone(), first_face, n_faces });
    Ok(())
}
