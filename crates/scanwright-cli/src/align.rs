//! `scanwright align`.

use std::fmt::Write as _;

use scanwright::align::{Part, elements_of};
use scanwright::datum::{self, Candidate, Datum, Found, Plan};
use scanwright::io;
use scanwright::math::{Point3, Pose, UnitVec3, centroid};
use scanwright::pipeline::{self, Options, Segmented};
use scanwright::progress::Progress;

use crate::args::AlignArgs;
use crate::console::{self, Console};
use crate::exit::{Code, Failure};
use crate::{outputs, scan};

/// Moves a scan into the frame of its datums.
pub fn run(args: &AlignArgs) -> Result<Code, Failure> {
    let mut paths = vec![args.output.as_path()];
    paths.extend(args.json.as_deref());
    outputs::check(&args.scan, &paths, args.run.force)?;
    console::watched(args.run.quiet, args.run.threads, |console| align(args, console))
}

fn align(args: &AlignArgs, console: &Console) -> Result<Code, Failure> {
    let file = scan::read(&args.scan)?;
    let progress = Progress::new(|stage, fraction| console.note(stage, fraction));
    let options = Options { seed: args.seed, support: args.support.into(), ..Options::default() };
    let segmented = pipeline::segment(&file.mesh, &options, &progress)
        .map_err(|error| Failure::of_run(&args.scan, error))?;
    let placed = match args.level.zip(args.rotate) {
        Some((level, rotate)) => named(args, &segmented, level, rotate)?,
        None => chosen(args, &segmented)?,
    };
    let mut files = vec![(args.output.as_path(), io::write_ply(&file.mesh.moved(&placed.pose), None, None))];
    if let Some(path) = &args.json {
        files.push((path, placed.json().into_bytes()));
    }
    outputs::write(&files)?;
    console.finish();
    if !args.run.quiet {
        print!("{}", placed.summary());
        for (path, _) in &files {
            println!("wrote      {}", path.display());
        }
        console.log(&crate::summary::timings_line(&console.timings()));
    }
    Ok(Code::Done)
}

/// A frame and where it comes from.
struct Placed {
    /// Takes the scan's coordinates to those of the datums.
    pose: Pose,
    method: &'static str,
    /// What each datum is for, and the primitive, or none for a plane of symmetry.
    datums: Vec<(&'static str, Option<usize>)>,
    free_turn: bool,
    free_ways: usize,
}

impl Placed {
    fn new(found: &Found, method: &'static str, datums: Vec<(&'static str, Option<usize>)>) -> Self {
        let (free_turn, free_ways) = (found.free_turn, found.free_ways);
        Self { pose: Pose::into_frame(&found.frame), method, datums, free_turn, free_ways }
    }

    fn json(&self) -> String {
        let datum = |(role, primitive): &(&str, Option<usize>)| {
            serde_json::json!({
                "role": role,
                "primitive": primitive,
                "kind": if primitive.is_some() { "primitive" } else { "symmetry" },
            })
        };
        let document = serde_json::json!({
            "schema": "scanwright/placement/1",
            "version": env!("CARGO_PKG_VERSION"),
            "method": self.method,
            "datums": self.datums.iter().map(datum).collect::<Vec<_>>(),
            "aligned_from_scan": self.pose.rows(),
            "free_turn": self.free_turn,
            "free_ways": self.free_ways,
        });
        format!("{document:#}\n")
    }

    fn summary(&self) -> String {
        let datum = |(role, primitive): &(&str, Option<usize>)| match primitive {
            Some(id) => format!("{role}: primitive {id}"),
            None => format!("{role}: plane of symmetry"),
        };
        let datums: Vec<String> = self.datums.iter().map(datum).collect();
        let mut text = format!("datums     {} ({})\n", datums.join(", "), self.method);
        if self.free_turn {
            text += "free       no datum stops the turn about z\n";
        }
        if self.free_ways > 0 {
            let _ =
                writeln!(text, "free       no datum fixes the origin along {} directions", self.free_ways);
        }
        text
    }
}

fn named(args: &AlignArgs, segmented: &Segmented, level: usize, rotate: usize) -> Result<Placed, Failure> {
    let part = Part::new(segmented);
    let elements = elements_of(&part);
    let datum = |flag: &str, id: usize| {
        let n = segmented.segmentation.primitives.len();
        let element = elements.iter().find(|(region, _)| region.0 as usize == id);
        element.map(|(_, e)| Datum { surface: e.surface, outward: e.outward, center: e.center }).ok_or_else(
            || {
                Failure::Usage(format!(
                    "{flag} {id}: the scan has primitives 0 to {}, and a freeform one is no datum",
                    n.saturating_sub(1)
                ))
            },
        )
    };
    let (z, x) = (datum("--level", level)?, datum("--rotate", rotate)?);
    let mut places = Vec::new();
    let mut datums = vec![("level", Some(level)), ("rotate", Some(rotate))];
    if let Some(zero) = args.zero {
        places.push(datum("--zero", zero)?);
        datums.push(("zero", Some(zero)));
    }
    places.extend([z, x]);
    let about = centroid(&part.mesh.vertices);
    let found = datum::frame(&[z, x], &places, &about, None)
        .map_err(|error| Failure::Usage(format!("--level: {error}")))?;
    Ok(Placed::new(&found, "named", datums))
}

fn chosen(args: &AlignArgs, segmented: &Segmented) -> Result<Placed, Failure> {
    let part = Part::new(segmented);
    let elements = elements_of(&part);
    let candidates: Vec<Candidate> = elements
        .iter()
        .map(|(_, e)| Candidate {
            datum: Datum { surface: e.surface, outward: e.outward, center: e.center },
            area: e.area,
        })
        .collect();
    let up = segmented.support.as_ref().map(|s| s.plane.normal);
    let about = centroid(&part.mesh.vertices);
    let tolerance = part.tolerances.spacing();
    let (plan, found) = placed_by(&candidates, up, &about, tolerance)
        .ok_or_else(|| Failure::input(&args.scan, "has neither a plane nor an axis that could be a datum"))?;
    let id = |k: usize| Some(elements[k].0.0 as usize);
    let mut datums = vec![("level", id(plan.level))];
    datums.extend(plan.rotate.map(|k| ("rotate", id(k))));
    datums.extend(plan.mirrors.iter().map(|_| ("zero", None)));
    datums.extend(plan.zero.iter().map(|&k| ("zero", id(k))));
    Ok(Placed::new(&found, "auto", datums))
}

/// Datums chosen and their frame.
fn placed_by(
    candidates: &[Candidate],
    up: Option<UnitVec3>,
    about: &Point3,
    tolerance: f64,
) -> Option<(Plan, Found)> {
    let plan = datum::choose(candidates, Some(tolerance))?;
    let found = datum::auto_frame(candidates, &plan, up, about)?;
    Some((plan, found))
}
