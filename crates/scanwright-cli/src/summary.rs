//! The answer a person reads: one line per fact, each begun by a word to look for.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use scanwright::gprimdb::Known;
use scanwright::io::ScanFile;
use scanwright::pipeline::{Code, Options, Placement, Reconstruction};
use scanwright::recognize::Missing;
use scanwright::report;
use scanwright::script::{Script, ScriptPart};
use scanwright::surface::SurfaceKind;

use crate::dimensions;
use crate::picture::counted;
use crate::scan::{UnitSource, Units};

/// Lines about one code that are written out.
const MOST_LINES: usize = 5;
/// Primitives that one line names.
const MOST_PLACES: usize = 12;

/// What was found, assumed and replaced in a run.
pub fn of_run(
    scan: &Path,
    file: &ScanFile,
    units: Units,
    (result, options): (&Reconstruction, &Options),
    known: &[Known],
    script: Option<&Script>,
    written: &[&Path],
) -> String {
    let mut lines = Lines::default();
    let unit = units.name();
    lines.add("read", &read_line(scan, file, result, unit));
    lines.add("units", &units_line(units));
    if let Some(support) = &result.support {
        let n = support.on_table.iter().filter(|on| **on).count();
        lines.add("support", &format!("a table of {} triangles was taken away", count(n)));
    }
    if let Some(placement) = &result.placement {
        lines.add("datums", &placement_line(placement));
    }
    lines.add("regions", &regions_line(result));
    if let Some(text) = dimensions::relations_line(result) {
        lines.add("relations", &text);
    }
    for text in dimensions::dimension_lines(result, options, unit) {
        lines.add("dims", &text);
    }
    for known in known {
        lines.add("known", &known_line(known));
    }
    for text in solid_lines(result, unit) {
        lines.add("solid", &text);
    }
    if let Some(deviation) = &result.deviation {
        let r = deviation.residual;
        let within = 100.0 * deviation.share_within(3.0 * result.measured.noise);
        let text = format!(
            "rms {}  p95 {}  max {} {unit}   within 3 sigma of the noise: {within:.1} %",
            short(r.rms),
            short(r.p95),
            short(r.max)
        );
        lines.add("deviation", &text);
    }
    if let Some(target) = options.target {
        for text in target_lines(result, target, unit) {
            lines.add("target", &text);
        }
    }
    for part in script.into_iter().flat_map(|s| &s.parts) {
        for text in script_lines(part) {
            lines.add("script", &text);
        }
    }
    for (word, text) in warning_lines(result) {
        lines.add(word, &text);
    }
    for path in written {
        lines.add("wrote", &path.display().to_string());
    }
    lines.0
}

/// How many faces are known as well as asked, then those that are not, the least known first.
fn target_lines(result: &Reconstruction, target: f64, unit: &str) -> Vec<String> {
    let judged = result.sufficiency(target);
    let mut weak: Vec<(usize, f64, Missing)> = judged
        .iter()
        .enumerate()
        .filter_map(|(k, s)| s.and_then(|s| Some((k, s.uncertainty, s.missing?))))
        .collect();
    weak.sort_by(|a, b| b.1.total_cmp(&a.1));
    let n = judged.iter().flatten().count();
    let mut lines = vec![format!(
        "{} of {n} faces have sizes with standard uncertainties up to {} {unit}",
        n - weak.len(),
        short(target)
    )];
    lines.extend(weak.iter().take(MOST_LINES).map(|(k, uncertainty, missing)| {
        format!("primitive {k} is known within {} {unit}: {}", short(*uncertainty), missing.text())
    }));
    if weak.len() > MOST_LINES {
        lines.push(format!("and {} more, see the JSON", weak.len() - MOST_LINES));
    }
    lines
}

fn placement_line(placement: &Placement) -> String {
    let mut text = format!("level: primitive {}", placement.level.0);
    if let Some(rotate) = placement.rotate {
        let _ = write!(text, ", rotate: primitive {}", rotate.0);
    }
    let zero: Vec<String> = placement.zero.iter().map(|r| r.0.to_string()).collect();
    let _ =
        write!(text, ", zero: {} planes of symmetry, then primitives {}", placement.mirrors, zero.join(" "));
    if placement.free_turn {
        text += "; nothing stops the turn about z";
    }
    text
}

fn known_line(known: &Known) -> String {
    let sizes: Vec<String> =
        known.sizes.iter().map(|(name, size)| crate::gprimdb::size_text(name, *size)).collect();
    let others = match known.others {
        0 => String::new(),
        n => format!(", as are {n} more"),
    };
    let taken = if known.taken { "; its sizes were taken" } else { "" };
    format!(
        "primitive {} may be `{}` ({}), {:.1} standard uncertainties off{others}{taken}",
        known.id,
        known.name,
        sizes.join(", "),
        known.deviations
    )
}

/// Seconds of the stages, for people.
pub fn timings_line((stages, total): &(Vec<(&'static str, f64)>, f64)) -> String {
    let parts: Vec<String> = stages.iter().map(|(stage, secs)| format!("{stage} {secs:.2}")).collect();
    format!("{:10}{total:.2} s: {}", "time", parts.join(", "))
}

/// Seconds of the stages and the number of threads, as JSON.
pub fn timings_json((stages, total): &(Vec<(&'static str, f64)>, f64), threads: Option<usize>) -> Vec<u8> {
    let stages: serde_json::Map<String, serde_json::Value> =
        stages.iter().map(|(stage, secs)| ((*stage).to_owned(), (*secs).into())).collect();
    let available = std::thread::available_parallelism().map_or(1, usize::from);
    let value = serde_json::json!({
        "seconds": stages,
        "total_seconds": total,
        "threads": threads.unwrap_or(available),
    });
    format!("{value:#}\n").into_bytes()
}

/// What the script has of a solid, then what it does not have.
fn script_lines(part: &ScriptPart) -> Vec<String> {
    let mut text = part.text();
    if part.n_features > 0 && part.volume > 0.0 {
        let share = 100.0 * part.differing_volume / part.volume;
        let _ = write!(text, ", {} % of the volume is expected to differ", short(share));
    }
    let mut groups: BTreeMap<&str, Vec<u32>> = BTreeMap::new();
    for missing in &part.missing {
        groups.entry(&missing.text).or_default().push(missing.primitive);
    }
    let mut lines = vec![text];
    for (text, mut ids) in groups {
        ids.sort_unstable();
        ids.dedup();
        lines.push(format!("not in it: {}{text}", places(&ids)));
    }
    lines
}

/// Digits in groups of three.
pub fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut grouped = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            grouped.push(' ');
        }
        grouped.push(digit);
    }
    grouped
}

/// Three significant digits.
pub fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let digits = (2.0 - x.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{x:.digits$}")
}

/// Lines that begin with a word.
#[derive(Default)]
pub struct Lines(String);

impl Lines {
    /// The lines so far.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Adds a line about `word`.
    pub fn add(&mut self, word: &str, text: &str) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{word:10}{text}");
    }
}

fn read_line(scan: &Path, file: &ScanFile, result: &Reconstruction, unit: &str) -> String {
    format!(
        "{}  {} triangles, {} vertices, spacing {} {unit}, noise {} {unit}",
        scan.display(),
        count(file.mesh.triangles.len()),
        count(file.mesh.vertices.len()),
        short(result.measured.spacing),
        short(result.measured.noise),
    )
}

fn units_line(units: Units) -> String {
    match units.source {
        UnitSource::Flag => format!("{}, as given", units.name()),
        UnitSource::File => format!("{}, as the file says", units.name()),
        UnitSource::Assumed => format!("{} assumed, the file does not say; --units sets it", units.name()),
    }
}

fn regions_line(result: &Reconstruction) -> String {
    let primitives = &result.segmentation.primitives;
    let mut text = count(primitives.len());
    let mut separator = ": ";
    for kind in SurfaceKind::ALL.into_iter().map(Some).chain([None]) {
        let n = primitives.iter().filter(|p| p.kind() == kind).count();
        if n > 0 {
            let _ = write!(text, "{separator}{}", counted(n, kind));
            separator = ", ";
        }
    }
    let (part, explained) = report::areas(result);
    let share = if part > 0.0 { 100.0 * explained / part } else { 0.0 };
    let _ = write!(text, "   {share:.1} % of the area explained");
    text
}

fn solid_lines(result: &Reconstruction, unit: &str) -> Vec<String> {
    if result.model.facts.is_empty() {
        return vec!["none".to_owned()];
    }
    let line = |solid: &scanwright::pipeline::SolidFacts| {
        let state = match (solid.closed, solid.problems.is_empty()) {
            (true, true) => "closed",
            (true, false) => "closed, but not valid",
            (false, _) => "open",
        };
        let mut text = format!("{state}, {} faces {} edges", solid.n_faces, solid.n_edges);
        if solid.n_assumed > 0 {
            let _ = write!(text, ", {} assumed", solid.n_assumed);
        }
        if solid.closed {
            let _ = write!(text, ", volume {} {unit}3", short(solid.volume));
        }
        let _ = write!(text, ", largest gap {} {unit}", short(solid.largest_gap));
        text
    };
    result.model.facts.iter().map(line).collect()
}

/// Warnings that no other line has said; those of one code and text are one line.
fn warning_lines(result: &Reconstruction) -> Vec<(&'static str, String)> {
    let said_elsewhere = |code| matches!(code, Code::UnitsAssumed | Code::SupportRemoved | Code::NoSolid);
    let mut groups: BTreeMap<(Code, &str), Vec<u32>> = BTreeMap::new();
    for warning in result.warnings.iter().filter(|w| !said_elsewhere(w.code)) {
        let group = groups.entry((warning.code, warning.text.as_str())).or_default();
        group.extend(warning.region.map(|region| region.0));
    }
    let mut lines: Vec<(&'static str, String)> = Vec::new();
    let mut n_of_code = 0;
    let mut last = None;
    for ((code, text), regions) in groups {
        n_of_code = if last == Some(code) { n_of_code + 1 } else { 1 };
        last = Some(code);
        let line = match n_of_code {
            n if n <= MOST_LINES => format!("{}{text} [{}]", places(&regions), code.name()),
            n if n == MOST_LINES + 1 => format!("and more, see the JSON [{}]", code.name()),
            _ => continue,
        };
        lines.push((word(code), line));
    }
    lines
}

/// The primitives that a line is about.
fn places(regions: &[u32]) -> String {
    let names = |ids: &[u32]| ids.iter().map(u32::to_string).collect::<Vec<_>>().join(" ");
    match regions {
        [] => String::new(),
        [one] => format!("primitive {one}: "),
        few if few.len() <= MOST_PLACES => format!("primitives {}: ", names(few)),
        many => format!("{} primitives ({} ..): ", many.len(), names(&many[..MOST_PLACES])),
    }
}

/// How a line about `code` begins.
fn word(code: Code) -> &'static str {
    match code {
        Code::AmbiguousType => "weak",
        Code::AssumedFace => "assumed",
        Code::Freeform | Code::Facets => "fallback",
        Code::Open | Code::Invalid | Code::Gap => "problem",
        _ => "note",
    }
}
