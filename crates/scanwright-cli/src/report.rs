//! `scanwright report`.

use std::path::Path;

use scanwright::document::{self, Format, Input, Part, ScanInput, Scene};
use scanwright::io::{self, ScanFile};
use scanwright::par;
use scanwright::prior::PriorModel;
use scanwright::step;

use crate::args::ReportArgs;
use crate::exit::{Code, Failure};
use crate::known::is_step;
use crate::{console, outputs, scan};

/// Writes a result as a document.
pub fn run(args: &ReportArgs) -> Result<Code, Failure> {
    let format = format_of(&args.output)?;
    for input in std::iter::once(&args.part).chain(&args.scan).chain(&args.model) {
        outputs::check(input, &[&args.output], args.force)?;
    }
    console::handle_interrupts();
    par::with_threads(args.threads, || report(args, format))
}

fn report(args: &ReportArgs, format: Format) -> Result<Code, Failure> {
    let text = std::fs::read_to_string(&args.part).map_err(|error| Failure::input(&args.part, error))?;
    let part = Part::read(&text).map_err(|error| Failure::input(&args.part, error))?;
    // Only HTML has pictures, but a file that was named is read: that it is missing should not go unsaid.
    let scan = args.scan.as_deref().map(|path| read_scan(path, &part)).transpose()?;
    let model = args.model.as_deref().map(|path| read_model(path, &part)).transpose()?;
    let scan = scan.as_ref().map(|(file, labels)| ScanInput { mesh: &file.mesh, labels: labels.as_deref() });
    let scene = Scene::of_files(&part, scan, model.as_ref());
    let name = args.name.clone().unwrap_or_else(|| name_of(&args.part));
    let dots_per_inch = document::DOTS_PER_INCH;
    let text = document::write(&Input { part: &part, name: &name, scene: &scene, dots_per_inch }, format);
    outputs::write(&[(&args.output, text.into_bytes())])?;
    Ok(Code::Done)
}

/// What the extension of a document's file asks for.
pub fn format_of(path: &Path) -> Result<Format, Failure> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("html" | "htm") => Ok(Format::Html),
        Some("md") => Ok(Format::Markdown),
        Some("csv") => Ok(Format::Csv),
        _ => Err(Failure::Usage(format!("{}: a document ends in .html, .md or .csv", path.display()))),
    }
}

/// The name of a part by that of its file.
pub fn name_of(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// One per triangle: its region, if it has one.
type Labels = Vec<Option<u32>>;

/// A scan with its regions if it has them. It must be the one that the result was made from.
fn read_scan(path: &Path, part: &Part) -> Result<(ScanFile, Option<Labels>), Failure> {
    let file = scan::read(path)?;
    let (triangles, _) = part.scan_counts();
    let n = file.mesh.triangles.len();
    if let Some(expected) = triangles.filter(|expected| *expected != n) {
        let reason =
            format!("is not the scan of this result: it has {n} triangles, and {expected} were converted");
        return Err(Failure::input(path, reason));
    }
    if file.format != io::Format::Ply {
        return Ok((file, None));
    }
    let bytes = std::fs::read(path).map_err(|error| Failure::input(path, error))?;
    let labels = io::read_ply_face_property(&bytes, "primitive").ok();
    let labels = labels.map(|labels| labels.into_iter().map(|id| u32::try_from(id).ok()).collect());
    Ok((file, labels))
}

/// A solid as STEP or a mesh, its lengths in the unit of the result. A mesh without a unit of its own has that.
fn read_model(path: &Path, part: &Part) -> Result<PriorModel, Failure> {
    let bytes =
        std::fs::read(path).map_err(|error| Failure::input(path, format!("cannot be read: {error}")))?;
    let model = if is_step(&bytes, path) {
        step::read::read(&bytes).map_err(|error| Failure::input(path, error))?
    } else {
        let file =
            io::read_mesh(&bytes, &path.to_string_lossy()).map_err(|error| Failure::input(path, error))?;
        PriorModel { millimetres: file.units.map(io::Unit::millimeters), ..PriorModel::from_mesh(file.mesh) }
    };
    let factor = model.millimetres.zip(part.millimetres()).map_or(1.0, |(own, unit)| own / unit);
    Ok(model.scaled(factor))
}
