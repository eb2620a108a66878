//! The model a scan is held against: a STEP file, or a mesh with the faces found in it.

use std::path::Path;

use scanwright::align::{Measure, model_of};
use scanwright::io;
use scanwright::pipeline::{self, Options, SupportSearch};
use scanwright::prior::PriorModel;
use scanwright::progress::Progress;
use scanwright::step;

use crate::exit::Failure;
use crate::scan::{self, Units};

/// Reads a model, its lengths in `units`; a mesh without a unit of its own is taken to have the scan's.
pub fn read(path: &Path, units: Units, seed: u64) -> Result<(PriorModel, Measure), Failure> {
    let bytes =
        std::fs::read(path).map_err(|error| Failure::input(path, format!("cannot be read: {error}")))?;
    if is_step(&bytes, path) {
        let model = step::read::read(&bytes).map_err(|error| Failure::input(path, error))?;
        return Ok((in_units(model, units), Measure::Surfaces));
    }
    let file = io::read_mesh(&bytes, &path.to_string_lossy()).map_err(|error| Failure::input(path, error))?;
    let declared = file.units.map(|unit| scan::units(None, Some(unit)).unit.millimeters());
    let options = Options { seed, support: SupportSearch::None, ..Options::default() };
    let segmented = pipeline::segment(&file.mesh, &options, &Progress::none())
        .map_err(|error| Failure::of_run(path, error))?;
    let model = PriorModel { millimetres: declared, ..model_of(&segmented) };
    Ok((in_units(model, units), Measure::Triangles))
}

pub fn is_step(bytes: &[u8], path: &Path) -> bool {
    let start = bytes.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(0);
    is_step_name(path) || bytes[start..].starts_with(b"ISO-10303-21")
}

/// Whether a file is named as STEP files are.
pub fn is_step_name(path: &Path) -> bool {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    matches!(extension.as_deref(), Some("step" | "stp" | "p21"))
}

fn in_units(model: PriorModel, units: Units) -> PriorModel {
    let own = model.millimetres.unwrap_or_else(|| units.unit.millimeters());
    model.scaled(own / units.unit.millimeters())
}
