//! `scanwright assemble`.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use scanwright::align::Part;
use scanwright::assemble::{NotPlaced, Placement, place};
use scanwright::math::{Frame, Pose, Vec3};
use scanwright::pipeline::{self, Options};
use scanwright::prior::PriorModel;
use scanwright::progress::Progress;
use scanwright::step::{Component, StepOptions, read::read, write_assembly};

use crate::args::AssembleArgs;
use crate::console::{self, Console};
use crate::exit::{Code, Failure};
use crate::scan::Units;
use crate::{outputs, scan};

/// Places parts in a scan of the object they make.
pub fn run(args: &AssembleArgs) -> Result<Code, Failure> {
    let paths: Vec<&Path> =
        [Some(&args.output), args.json.as_ref()].into_iter().flatten().map(PathBuf::as_path).collect();
    outputs::check(&args.scan, &paths, args.run.force)?;
    for file in files(args)? {
        for part in [&file.looked_for, &file.written] {
            outputs::check(part, &paths, true).map_err(|failure| match failure {
                Failure::Usage(text) => {
                    Failure::Usage(text.replace("is the scan itself", "is one of the parts"))
                }
                other => other,
            })?;
        }
    }
    console::watched(args.run.quiet, args.run.threads, |console| assemble(args, console))
}

/// A part as asked for.
struct PartFile {
    name: String,
    /// The file whose shape is looked for in the scan.
    looked_for: PathBuf,
    /// The file that is written.
    written: PathBuf,
}

/// A part with what its files hold.
struct Loaded {
    name: String,
    model: PriorModel,
    text: Vec<u8>,
    written: PathBuf,
}

fn assemble(args: &AssembleArgs, console: &Console) -> Result<Code, Failure> {
    let file = scan::read(&args.scan)?;
    let units = scan::units(args.units, file.units);
    let parts: Vec<Loaded> = files(args)?.into_iter().map(|f| load(f, units)).collect::<Result<_, _>>()?;
    let progress = Progress::new(|stage, fraction| console.note(stage, fraction));
    let options = Options { seed: args.seed, support: args.support.into(), ..Options::default() };
    let segmented = pipeline::segment(&file.mesh, &options, &progress)
        .map_err(|error| Failure::of_run(&args.scan, error))?;
    let models: Vec<PriorModel> = parts.iter().map(|p| p.model.clone()).collect();
    let results = place(&models, &Part::new(&segmented));
    if let Some(Err(reason)) = results.iter().find(|_| results.iter().all(Result::is_err)) {
        return Err(Failure::input(&args.scan, format!("no part was placed; {}: {reason}", parts[0].name)));
    }
    let text = step_text(args, units, &parts, &results)?;
    let mut files = vec![(args.output.as_path(), text)];
    if let Some(path) = &args.json {
        files.push((path, json(args, units, &parts, &results).into_bytes()));
    }
    outputs::write(&files)?;
    console.finish();
    for part in parts.iter().filter(|_| !args.run.quiet) {
        for unread in &part.model.unread {
            console.log(&format!("{}: {unread}", part.name));
        }
    }
    if !args.run.quiet {
        print!("{}", summary(&parts, &results, units));
    }
    Ok(if results.iter().all(Result::is_ok) { Code::Done } else { Code::Partly })
}

/// The parts in the order given, newer files in their places; then newer files of parts that were not given.
fn files(args: &AssembleArgs) -> Result<Vec<PartFile>, Failure> {
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let newer = |name: &str| args.replace.iter().find(|(n, _)| n == name).map(|(_, path)| path.clone());
    let mut names = BTreeSet::new();
    for (name, _) in &args.replace {
        if !names.insert(name) {
            return Err(Failure::Usage(format!("--replace: {name} is given twice")));
        }
    }
    let given = args.parts.iter().map(|path| {
        let name = stem(path);
        PartFile { written: newer(&name).unwrap_or_else(|| path.clone()), name, looked_for: path.clone() }
    });
    let mut files: Vec<PartFile> = given.collect();
    for (name, path) in &args.replace {
        if files.iter().all(|f| f.name != *name) {
            files.push(PartFile { name: name.clone(), looked_for: path.clone(), written: path.clone() });
        }
    }
    Ok(files)
}

fn load(file: PartFile, units: Units) -> Result<Loaded, Failure> {
    let bytes =
        |path: &Path| std::fs::read(path).map_err(|e| Failure::input(path, format!("cannot be read: {e}")));
    let model = read(&bytes(&file.looked_for)?).map_err(|error| Failure::input(&file.looked_for, error))?;
    let factor = model.millimetres.map_or(1.0, |mm| mm / units.in_step().millimetres());
    let text = bytes(&file.written)?;
    Ok(Loaded { name: file.name, model: model.scaled(factor), text, written: file.written })
}

/// Occurrences of one part are told apart by numbers.
fn occurrence_names(parts: &[Loaded]) -> Vec<String> {
    let number = |i: usize| parts[..=i].iter().filter(|p| p.name == parts[i].name).count();
    (0..parts.len())
        .map(
            |i| {
                if number(i) > 1 { format!("{}-{}", parts[i].name, number(i)) } else { parts[i].name.clone() }
            },
        )
        .collect()
}

/// The other places that explain the scan as well, as rows.
fn others_from_part(placement: &Placement) -> Vec<[[f64; 4]; 4]> {
    placement.alignment.alternatives.iter().map(|a| a.pose.inverse().rows()).collect()
}

/// Where the part's coordinates lie in the scan.
fn scan_from_part(placement: &Placement) -> Pose {
    placement.alignment.pose.inverse()
}

fn step_text(
    args: &AssembleArgs,
    units: Units,
    parts: &[Loaded],
    results: &[Result<Placement, NotPlaced>],
) -> Result<Vec<u8>, Failure> {
    let names = occurrence_names(parts);
    let mut components = Vec::new();
    for ((part, result), name) in parts.iter().zip(results).zip(names) {
        let Ok(placement) = result else { continue };
        let pose = scan_from_part(placement);
        let frame = Frame {
            origin: pose.point(&scanwright::math::Point3::origin()),
            x: pose.unit(&Vec3::x_axis()),
            y: pose.unit(&Vec3::y_axis()),
            z: pose.unit(&Vec3::z_axis()),
        };
        components.push(Component { name, text: &part.text, frame });
    }
    let name = args.output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let options = StepOptions { unit: units.in_step(), name, ..StepOptions::default() };
    write_assembly(&components, &options).map_err(|error| {
        let written = parts.iter().find(|p| p.name == error.name).map(|p| p.written.clone());
        Failure::input(&written.unwrap_or_default(), error.reason)
    })
}

/// Standard uncertainty of a part's place: of its middle in the direction that is known least, and of its turn.
fn uncertainty(placement: &Placement) -> (f64, f64) {
    let alignment = &placement.alignment;
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let largest = |of: &dyn Fn(&Vec3) -> f64| axes.iter().map(of).fold(0.0, f64::max);
    (largest(&|d| alignment.uncertainty_at(&alignment.pivot, d)), largest(&|d| alignment.turn_uncertainty(d)))
}

fn summary(parts: &[Loaded], results: &[Result<Placement, NotPlaced>], units: Units) -> String {
    let mut text = String::new();
    for (name, result) in occurrence_names(parts).iter().zip(results) {
        let line = match result {
            Ok(placement) => {
                let (way, turn) = uncertainty(placement);
                let open =
                    placement.alignment.freedom.text().map(|t| format!("; open: {t}")).unwrap_or_default();
                let others = match placement.alignment.alternatives.len() {
                    0 => String::new(),
                    1 => "; another place fits as well".to_owned(),
                    n => format!("; {n} other places fit as well"),
                };
                format!(
                    "placed, to {way:.2e} {} and {:.2e} deg, by {:.0} % of its area{open}{others}",
                    units.name(),
                    turn.to_degrees(),
                    100.0 * placement.covered
                )
            }
            Err(reason) => format!("not placed: {reason}"),
        };
        let _ = writeln!(text, "{name:<12} {line}");
    }
    text
}

fn json(
    args: &AssembleArgs,
    units: Units,
    parts: &[Loaded],
    results: &[Result<Placement, NotPlaced>],
) -> String {
    let parts: Vec<serde_json::Value> = occurrence_names(parts)
        .iter()
        .zip(parts)
        .zip(results)
        .map(|((name, part), result)| match result {
            Ok(placement) => {
                let alignment = &placement.alignment;
                let (way, turn) = uncertainty(placement);
                serde_json::json!({
                    "name": name, "file": part.written.to_string_lossy(), "placed": true,
                    "scan_from_part": scan_from_part(placement).rows(),
                    "pivot_in_part": alignment.pivot.coords.as_slice(),
                    "covariance": alignment.covariance,
                    "place_uncertainty": way, "turn_uncertainty": turn,
                    "open": alignment.freedom.text(),
                    "alternatives": others_from_part(placement),
                    "covered": placement.covered, "unread": part.model.unread,
                })
            }
            Err(reason) => serde_json::json!({
                "name": name, "file": part.written.to_string_lossy(), "placed": false,
                "reason": reason.to_string(), "unread": part.model.unread,
            }),
        })
        .collect();
    let whole = serde_json::json!({
        "version": env!("CARGO_PKG_VERSION"), "scan": args.scan.to_string_lossy(), "units": units.name(), "parts": parts,
    });
    format!("{whole:#}\n")
}
