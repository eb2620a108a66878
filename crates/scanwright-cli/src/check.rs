//! `scanwright check`.

use std::fmt::Write as _;
use std::path::Path;

use scanwright::align::{self, Alignment, Part, Target, border_width};
use scanwright::check::{self, Check, Context, Verdict, check};
use scanwright::math::Pose;
use scanwright::pipeline::{self, Options, Segmented};
use scanwright::progress::{Progress, Stage};
use scanwright::{io, report};

use crate::args::{AlignFlag, CheckArgs};
use crate::console::{self, Console};
use crate::exit::{Code, Failure};
use crate::scan::{self, Units};
use crate::{known, outputs, picture};

mod datums;
mod summary;

/// Holds a scan against a model.
pub fn run(args: &CheckArgs) -> Result<Code, Failure> {
    let optional = [&args.json, &args.ply, &args.picture, &args.csv, &args.update];
    let paths: Vec<&Path> = optional.into_iter().flatten().map(std::path::PathBuf::as_path).collect();
    if !args.datums.is_empty() && args.align != AlignFlag::Datum {
        return Err(Failure::Usage("--datums is for --align datum".into()));
    }
    if let Some(step) = args.update.as_deref().filter(|path| known::is_step_name(path)) {
        let reason =
            format!("{}: measured values are written as JSON; no STEP file is updated", step.display());
        return Err(Failure::Usage(reason));
    }
    outputs::check(&args.scan, &paths, args.run.force)?;
    outputs::check(&args.model, &paths, args.run.force)?;
    console::watched(args.run.quiet, args.run.threads, |console| run_watched(args, console))
}

/// A scan on its model.
struct Placed {
    alignment: Alignment,
    datums: Vec<String>,
}

fn run_watched(args: &CheckArgs, console: &Console) -> Result<Code, Failure> {
    let file = scan::read(&args.scan)?;
    let units = scan::units(args.units, file.units);
    let (model, measure) = known::read(&args.model, units, args.seed)?;
    let options = Options { seed: args.seed, support: args.support.into(), ..Options::default() };
    let progress = Progress::new(|stage, fraction| console.note(stage, fraction));
    let segmented = pipeline::segment(&file.mesh, &options, &progress)
        .map_err(|error| Failure::of_run(&args.scan, error))?;
    let part = Part::new(&segmented);
    let target = Target::new(&model, measure, border_width(&part.tolerances))
        .ok_or_else(|| Failure::input(&args.model, "has no triangles with an area"))?;
    console.note(Stage::Build, 0.0);
    let placed = place(args, &target, &part)?;
    console.note(Stage::Build, 0.5);
    let asked = check::Options { tolerance: args.tolerance };
    let found = check(&target, &part, &placed.alignment, &asked);
    console.note(Stage::Build, 1.0);
    let done = Done {
        args,
        units,
        segmented: &segmented,
        part: &part,
        target: &target,
        placed: &placed,
        found: &found,
    };
    let files = done.files();
    outputs::write(&files)?;
    console.note(Stage::Write, 1.0);
    console.finish();
    if !args.run.quiet {
        print!("{}", summary::of(&done));
        for (path, _) in &files {
            println!("wrote      {}", path.display());
        }
        console.log(&crate::summary::timings_line(&console.timings()));
    }
    let refused = found.verdict.is_some_and(|verdict| verdict != Verdict::Pass);
    Ok(if refused { Code::Partly } else { Code::Done })
}

fn place(args: &CheckArgs, target: &Target, part: &Part) -> Result<Placed, Failure> {
    let as_it_lies = |alignment| Placed { alignment, datums: Vec::new() };
    if args.align == AlignFlag::None {
        return Ok(as_it_lies(align::as_placed(target, part, &Pose::identity())));
    }
    let best = align::align(target, part, &align::Options::default())
        .map_err(|error| Failure::input(&args.scan, error))?;
    match args.align {
        AlignFlag::Datum => datums::place(args, target, part, &best),
        AlignFlag::Best | AlignFlag::None => Ok(as_it_lies(best)),
    }
}

/// Everything there is to write.
struct Done<'a> {
    args: &'a CheckArgs,
    units: Units,
    segmented: &'a Segmented,
    part: &'a Part,
    target: &'a Target<'a>,
    placed: &'a Placed,
    found: &'a Check,
}

impl<'a> Done<'a> {
    fn files(&self) -> Vec<(&'a Path, Vec<u8>)> {
        let (target, alignment) = (self.target, &self.placed.alignment);
        let context = Context {
            version: env!("CARGO_PKG_VERSION"),
            units: report::Units {
                name: self.units.name().to_owned(),
                millimetres: self.units.unit.millimeters(),
                source: self.units.source.name().to_owned(),
            },
            method: self.args.align.name(),
            datums: &self.placed.datums,
            tolerance: self.args.tolerance,
            noise: self.part.tolerances.noise(),
            spacing: self.part.tolerances.spacing(),
            n_vertices: self.part.mesh.vertices.len(),
            support: self.args.support.into(),
        };
        let mut files: Vec<(&'a Path, Vec<u8>)> = Vec::new();
        if let Some(path) = &self.args.json {
            files.push((path, check::to_json(self.found, target, alignment, &context).into_bytes()));
        }
        if let Some(path) = &self.args.csv {
            files.push((path, check::to_csv(self.found, target).into_bytes()));
        }
        if let Some(path) = &self.args.update {
            files.push((path, check::update_json(self.found, target, &context).into_bytes()));
        }
        if let Some(path) = &self.args.ply {
            let (values, colors) = picture::deviations(self.segmented, self.part, self.found, self.scale());
            let mesh = self.segmented.mesh.moved(&alignment.pose);
            files.push((path, io::write_ply_values(&mesh, "deviation", &values, &colors)));
        }
        if let Some(path) = &self.args.picture {
            let image = picture::of_check(self.part, self.target, alignment, self.found, self.scale());
            files.push((path, image.to_png()));
        }
        files
    }

    /// The end of the color scale: the tolerance, else what 99.7 % of the vertices keep.
    fn scale(&self) -> f64 {
        let [low, high] = self.found.overall.range;
        self.args.tolerance.unwrap_or(low.abs().max(high.abs())).max(f64::MIN_POSITIVE)
    }
}

/// A list of names, at most some of them.
fn listed(names: &[String]) -> String {
    const MOST: usize = 8;
    let mut text = names[..names.len().min(MOST)].join(", ");
    if names.len() > MOST {
        let _ = write!(text, " and {} more", names.len() - MOST);
    }
    text
}
