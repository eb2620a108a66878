//! From regions to solids: closing, building, checking, and triangles for pictures and distances.

use crate::brep::close::{self, Closed};
use crate::brep::{self, Built, Solid};
use crate::condition::Support;
use crate::mesh::Mesh;
use crate::segment::Segmentation;
use crate::tolerance::Tolerances;

use super::{Code, Model, SolidFacts, Warning, warning};

/// The solids of a part (a mesh without its table) and what there is to say about them.
pub(super) fn build(
    mesh: &Mesh,
    segmentation: &Segmentation,
    support: Option<&Support>,
    tolerances: &Tolerances,
) -> (Model, Vec<Warning>) {
    let Closed { labelled, open, assumed_faces, .. } = close::close(mesh, segmentation, support, tolerances);
    let Built { solids, issues, primitives } = brep::build(&labelled, tolerances);

    let mut model = Model { primitives, ..Model::default() };
    let mut warnings = warning::of_closing(&assumed_faces, &open);
    warnings.extend(issues.iter().map(warning::of_issue));
    for solid in solids {
        let problems = brep::check(&solid, solid.gap.max(tolerances.gap()));
        let problems: Vec<String> = problems.iter().map(ToString::to_string).collect();
        let volume = add_triangles(&mut model, &solid);
        if !problems.is_empty() {
            let text = format!("solid {}: {}", model.solids.len() + 1, first_of(&problems));
            warnings.push(Warning::new(Code::Invalid, text));
        }
        model.facts.push(facts(&solid, volume, problems));
        model.solids.push(solid);
    }
    if model.solids.is_empty() {
        warnings.push(Warning::new(Code::NoSolid, "no solid was made"));
    }
    (model, warnings)
}

/// The first few problems in one sentence: an open shell has one per open edge, and the facts hold them all.
fn first_of(problems: &[String]) -> String {
    const SHOWN: usize = 3;
    let shown = problems[..problems.len().min(SHOWN)].join("; ");
    if problems.len() > SHOWN { format!("{shown}; and {} more", problems.len() - SHOWN) } else { shown }
}

pub(super) fn facts(solid: &Solid, volume: f64, problems: Vec<String>) -> SolidFacts {
    SolidFacts {
        closed: solid.is_closed(),
        n_faces: solid.faces.len(),
        n_edges: solid.edges.len(),
        n_vertices: solid.vertices.len(),
        n_assumed: solid.faces.iter().filter(|face| face.assumed).count(),
        volume,
        largest_gap: solid.gap,
        problems,
    }
}

/// Adds the triangles of `solid` to the model's; returns their volume.
pub(super) fn add_triangles(model: &mut Model, solid: &Solid) -> f64 {
    let tessellation = brep::tessellate(solid);
    let shift = model.mesh.vertices.len() as u32;
    model.mesh.vertices.extend(&tessellation.mesh.vertices);
    model.mesh.triangles.extend(tessellation.mesh.triangles.iter().map(|t| t.map(|v| v + shift)));
    for face in tessellation.faces.iter().map(|face| solid.face(*face)) {
        model.regions.push(face.region);
        model.assumed.push(face.assumed);
    }
    tessellation.mesh.signed_volume()
}
