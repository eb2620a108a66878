//! `scanwright convert`.

use std::path::Path;

use scanwright::document::{self, Input, Part, Scene};
use scanwright::gprimdb::{DatabaseError, Known, take};
use scanwright::io::{self, ScanFile};
use scanwright::math::{UnitVec3, Vec3};
use scanwright::pipeline::{
    self, Code as WarningCode, Coordinates, Fallback, Options, Reconstruction, Warning,
};
use scanwright::progress::{Progress, Stage};
use scanwright::report::{self, Context, Report};
use scanwright::script::{self, Script, ScriptOptions};
use scanwright::step::{self, Schema, StepOptions};

use crate::args::{ConvertArgs, FallbackFlag, FrameFlag, KnownFlag, PipelineFlag, SchemaFlag};
use crate::console::{self, Console};
use crate::exit::{Code, Failure};
use crate::scan::{self, UnitSource, Units};
use crate::{classify, gprimdb, outputs, picture, relations, summary};

/// Turns a scan into a STEP solid.
pub fn run(args: &ConvertArgs) -> Result<Code, Failure> {
    outputs::check(&args.scan, &output_paths(args), args.run.force)?;
    if let Some(path) = &args.report {
        crate::report::format_of(path)?;
    }
    console::watched(args.run.quiet, args.run.threads, |console| convert(args, console))
}

fn convert(args: &ConvertArgs, console: &Console) -> Result<Code, Failure> {
    let file = scan::read(&args.scan)?;
    let units = scan::units(args.units, file.units);
    let options = options(args, units)?;
    let (result, known) = reconstruct(args, &file, &options, units, console)?;
    if args.strict && !result.fallbacks().is_empty() {
        return Err(Failure::Strict(names(&result.fallbacks())));
    }
    console.note(Stage::Write, 0.0);
    let script = args.script.as_ref().map(|_| script_of(args, units, &result));
    let mut files = results(args, &file, &options, units, &result, known.as_deref())?;
    if let (Some(path), Some(script)) = (&args.script, &script) {
        files.push((path, script.text.clone().into_bytes()));
    }
    console.note(Stage::Write, 0.5);
    let timings = console.timings();
    if let Some(path) = &args.timings {
        files.push((path, summary::timings_json(&timings, args.run.threads)));
    }
    outputs::write(&files)?;
    console.note(Stage::Write, 1.0);
    console.finish();
    if !args.run.quiet {
        let written: Vec<&Path> = files.iter().map(|(path, _)| *path).collect();
        let known = known.as_deref().unwrap_or_default();
        print!(
            "{}",
            summary::of_run(&args.scan, &file, units, (&result, &options), known, script.as_ref(), &written)
        );
        console.log(&summary::timings_line(&console.timings()));
    }
    let refused = result.fallbacks().into_iter().any(|fallback| !args.allow.contains(&flag_of(fallback)));
    Ok(if refused { Code::Partly } else { Code::Done })
}

fn reconstruct(
    args: &ConvertArgs,
    file: &ScanFile,
    options: &Options,
    units: Units,
    console: &Console,
) -> Result<(Reconstruction, Option<Vec<Known>>), Failure> {
    let progress = Progress::new(|stage, fraction| console.note(stage, fraction));
    let database = args.database.as_deref().map(gprimdb::open).transpose()?;
    let mut known = None;
    let result = match args.pipeline {
        PipelineFlag::Default => pipeline::run_revised(&file.mesh, options, &progress, &mut |primitives| {
            known = database.as_ref().map(|database| {
                let mut known = database.known(primitives)?;
                if args.known == KnownFlag::Take {
                    take(&mut known, primitives);
                }
                Ok(known)
            });
        }),
        PipelineFlag::Thesis => pipeline::run_thesis(&file.mesh, options, &classify::shipped()?, &progress),
    };
    let mut result = result.map_err(|error| Failure::of_run(&args.scan, error))?;
    if units.source == UnitSource::Assumed {
        let text = "lengths were taken as millimetres; --units says otherwise";
        result.warnings.insert(0, Warning::new(WarningCode::UnitsAssumed, text));
    }
    let path = args.database.as_deref().unwrap_or(&args.scan);
    let known = known.transpose().map_err(|error: DatabaseError| Failure::input(path, error))?;
    Ok((result, known))
}

/// Every file asked for, with its bytes.
fn results<'a>(
    args: &'a ConvertArgs,
    file: &ScanFile,
    options: &Options,
    units: Units,
    result: &Reconstruction,
    known: Option<&[Known]>,
) -> Result<Vec<(&'a Path, Vec<u8>)>, Failure> {
    let n_triangles = file.mesh.triangles.len();
    let mut files = vec![(args.output.as_path(), step_text(args, units, result).into_bytes())];
    if args.json.is_some() || args.report.is_some() {
        let context = Context {
            version: env!("CARGO_PKG_VERSION"),
            units: report::Units {
                name: units.name().to_owned(),
                millimetres: units.unit.millimeters(),
                source: units.source.name().to_owned(),
            },
            options,
            n_triangles,
            n_vertices: file.mesh.vertices.len(),
            source: Some(report::Source {
                file: args.scan.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                bytes: file.n_bytes,
                sha256: file.sha256.clone(),
            }),
            known,
        };
        let json = Report::new(result, &context).to_json();
        if let Some(path) = &args.report {
            files.push((path, document(args, path, &json, result)?));
        }
        if let Some(path) = &args.json {
            files.push((path, json.into_bytes()));
        }
    }
    if let Some(path) = &args.segments {
        let ids = report::segment_ids(&result.labels_of_scan(n_triangles));
        let moved = result.placement.as_ref().map(|placement| file.mesh.moved(&placement.pose));
        let mesh = moved.as_ref().unwrap_or(&file.mesh);
        files.push((path, io::write_ply(mesh, Some(("primitive", &ids)), None)));
    }
    if let Some(path) = &args.picture {
        files.push((path, picture::of_reconstruction(result).to_png()));
    }
    Ok(files)
}

/// The document that `report` makes of the same JSON, with pictures of what is in memory.
fn document(
    args: &ConvertArgs,
    path: &Path,
    json: &str,
    result: &Reconstruction,
) -> Result<Vec<u8>, Failure> {
    let part = Part::read(json).map_err(|error| Failure::Internal(error.to_string()))?;
    let name = crate::report::name_of(&args.output);
    let input = Input {
        part: &part,
        name: &name,
        scene: &Scene::of_run(result),
        dots_per_inch: document::DOTS_PER_INCH,
    };
    Ok(document::write(&input, crate::report::format_of(path)?).into_bytes())
}

fn script_of(args: &ConvertArgs, units: Units, result: &Reconstruction) -> Script {
    let options = ScriptOptions {
        name: args.output.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        unit: units.name().to_owned(),
        seed: args.seed,
        ..ScriptOptions::new(&result.tolerances)
    };
    script::write(&result.model.solids, &result.model.primitives, &options)
}

fn step_text(args: &ConvertArgs, units: Units, result: &Reconstruction) -> String {
    let schema = match args.schema {
        SchemaFlag::Ap242 => Schema::Ap242,
        SchemaFlag::Ap214 => Schema::Ap214,
    };
    let name = args.output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let options = StepOptions { schema, unit: units.in_step(), name, ..StepOptions::default() };
    step::write(&result.model.solids, &options)
}

fn options(args: &ConvertArgs, units: Units) -> Result<Options, Failure> {
    Ok(Options {
        seed: args.seed,
        gap: args.tolerance,
        min_face: args.min_face,
        support: args.support.into(),
        target: args.target,
        coordinates: match args.align {
            FrameFlag::None => Coordinates::Scan,
            FrameFlag::Auto => Coordinates::Datums,
        },
        up: args.up.map(|[x, y, z]| UnitVec3::new_normalize(Vec3::new(x, y, z))),
        relations: relations::read(&args.relations)?,
        manufacture: relations::manufacture(args.manufacture, units),
        systematic: args.systematic.unwrap_or_default(),
        millimetres: units.unit.millimeters(),
        snap: args.snap,
        ..Options::default()
    })
}

fn output_paths(args: &ConvertArgs) -> Vec<&Path> {
    let optional = [&args.json, &args.report, &args.segments, &args.picture, &args.script, &args.timings];
    let optional = optional.into_iter().flatten().map(std::path::PathBuf::as_path);
    std::iter::once(args.output.as_path()).chain(optional).collect()
}

fn flag_of(fallback: Fallback) -> FallbackFlag {
    match fallback {
        Fallback::Open => FallbackFlag::Open,
        Fallback::Freeform => FallbackFlag::Freeform,
        Fallback::Facets => FallbackFlag::Facets,
    }
}

fn names(fallbacks: &[Fallback]) -> String {
    fallbacks.iter().map(|f| f.name()).collect::<Vec<_>>().join(", ")
}
