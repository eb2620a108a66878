//! What is read from STEP files, one line of JSON each: volume, area, open sides, faces by type.
//!
//! `cargo run --example step_faces -- FILE.step...`; `scripts/step_faces.py` holds it against Open CASCADE.

use std::collections::BTreeMap;
use std::io::Write as _;

use scanwright::prior::PriorModel;
use scanwright::step::read::read;

fn main() {
    let mut out = std::io::stdout();
    for path in std::env::args().skip(1) {
        let bytes = std::fs::read(&path).expect("the file can be read");
        let start = std::time::Instant::now();
        let line = match read(&bytes) {
            Ok(model) => {
                let seconds = start.elapsed().as_secs_f64();
                let mesh = &model.mesh;
                serde_json::json!({
                    "path": path, "seconds": seconds, "triangles": mesh.triangles.len(),
                    "volume": mesh.signed_volume(), "area": mesh.total_area(), "open": open_sides(&model),
                    "faces": model.faces.len(), "kinds": kinds(&model), "millimetres": model.millimetres,
                    "parts": model.parts.iter().map(|p| p.name.clone()).collect::<Vec<_>>(),
                    "unread": model.unread, "areas": areas(&model),
                })
            }
            Err(error) => serde_json::json!({ "path": path, "error": error.to_string() }),
        };
        writeln!(out, "{line}").expect("stdout");
    }
}

/// Sides of triangles without exactly one opposite side.
fn open_sides(model: &PriorModel) -> usize {
    let mut sides: BTreeMap<(u32, u32), [usize; 2]> = BTreeMap::new();
    for [a, b, c] in &model.mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            sides.entry((*from.min(to), *from.max(to))).or_default()[usize::from(from < to)] += 1;
        }
    }
    sides.values().filter(|uses| **uses != [1, 1]).count()
}

fn kinds(model: &PriorModel) -> BTreeMap<&'static str, usize> {
    let mut kinds = BTreeMap::new();
    for face in &model.faces {
        *kinds.entry(face.surface.map_or("freeform", |s| s.kind().name())).or_default() += 1;
    }
    kinds
}

/// Name and area of every face.
fn areas(model: &PriorModel) -> Vec<(&str, f64)> {
    let mut areas: Vec<(&str, f64)> = model.faces.iter().map(|f| (f.name.as_str(), 0.0)).collect();
    for (t, face) in model.face_of.iter().enumerate() {
        areas[*face as usize].1 += model.mesh.area(t);
    }
    areas
}
