use super::super::number::{count, counted, large, percent, short};
use super::super::page::{Block, Fact, Level, Point, Reference, Section, Verdict};
use super::super::part::{Part, Solid};
use super::{WeakPlace, Weakness, references};

/// Share of the part's area on analytic surfaces below which it is worth a look; `W_UNEXPLAINED` has the same.
const EXPLAINED: f64 = 0.995;
/// Warnings that are about the whole.
const ABOUT_ALL: [(&str, Level); 5] = [
    ("W_NO_SOLID", Level::Bad),
    ("W_OPEN", Level::Bad),
    ("W_INVALID", Level::Bad),
    ("W_UNEXPLAINED", Level::Look),
    ("W_UNITS_ASSUMED", Level::Look),
];

/// What the result is, in one glance.
pub fn section(part: &Part, places: &[WeakPlace]) -> Section {
    let (level, headline) = headline(part);
    let facts = [
        solid(part),
        faces(part),
        explained(part),
        deviation(part),
        dimensions(part),
        types(part),
        units(part),
    ];
    let verdict = Verdict { level, headline, facts: facts.into(), points: points(part, places) };
    Section { title: "Verdict", anchor: "verdict", blocks: vec![Block::Verdict(verdict)] }
}

fn headline(part: &Part) -> (Level, String) {
    let solids = &part.solids;
    let n = solids.len();
    if n == 0 {
        return (Level::Bad, "No solid was made".to_owned());
    }
    let subject = if n == 1 { "solid".to_owned() } else { counted(n, "solid") };
    let n_open = solids.iter().filter(|solid| !solid.closed).count();
    if n_open > 0 {
        let which =
            if n == 1 { "The shell is open".to_owned() } else { format!("{n_open} of {n} shells are open") };
        return (Level::Bad, format!("{which}: not a solid yet"));
    }
    let n_problems: usize = solids.iter().map(|solid| solid.problems.len()).sum();
    if n_problems > 0 {
        return (
            Level::Bad,
            format!("Closed, but not valid: {} in our own check", counted(n_problems, "problem")),
        );
    }
    let (freeform, facets) = (regions_with(part, "W_FREEFORM"), regions_with(part, "W_FACETS"));
    let article = if n == 1 { "Closed, valid " } else { "Closed and valid: " };
    if freeform.is_empty() && facets.is_empty() {
        let all = format!("{article}{subject}, all faces analytic");
        return (Level::Good, all);
    }
    let n_regions = distinct(freeform.iter().chain(&facets).copied());
    (Level::Look, format!("{article}{subject}, but {} not analytic", are(n_regions, "region")))
}

fn solid(part: &Part) -> Fact {
    let (level, value) = match part.solids.as_slice() {
        [] => (Level::Bad, "none".to_owned()),
        solids if solids.iter().any(|s| !s.closed) => (Level::Bad, "open".to_owned()),
        solids if solids.iter().any(|s| !s.problems.is_empty()) => {
            (Level::Bad, "closed, not valid".to_owned())
        }
        _ => (Level::Good, "closed, valid".to_owned()),
    };
    let sum = |of: fn(&Solid) -> Option<f64>| part.solids.iter().map(of).sum::<Option<f64>>();
    let gap = part.solids.iter().filter_map(|s| s.largest_gap).reduce(f64::max);
    let unit = part.unit();
    let remark = if part.solids.is_empty() {
        String::new()
    } else {
        format!("volume {} {unit}³, largest gap {} {unit}", large(sum(|s| s.volume)), short(gap))
    };
    Fact { label: "Solid", value, remark, level: Some(level) }
}

fn faces(part: &Part) -> Fact {
    let n: usize = part.solids.iter().map(|s| s.n_faces).sum();
    let n_assumed: usize = part.solids.iter().map(|s| s.n_assumed).sum();
    let n_assumed_regions = regions_with(part, "W_ASSUMED_FACE").len();
    let n_edges: usize = part.solids.iter().map(|s| s.n_edges).sum();
    let unseen = if n_assumed > 0 {
        format!("{} assumed, which nobody saw", are(n_assumed, "face"))
    } else if n_assumed_regions > 0 {
        format!("{} into what was not seen", have(n_assumed_regions, "region", "extended"))
    } else {
        "none assumed".to_owned()
    };
    let level = if n_assumed + n_assumed_regions > 0 { Level::Look } else { Level::Good };
    Fact {
        label: "Faces",
        value: count(n),
        remark: format!("{} edges; {unseen}", count(n_edges)),
        level: Some(level),
    }
}

fn explained(part: &Part) -> Fact {
    let share = part.scan.area_explained.zip(part.scan.area).map(|(explained, area)| explained / area);
    let level = share.map(|share| if share >= EXPLAINED { Level::Good } else { Level::Look });
    let unit = part.unit();
    Fact {
        label: "Area explained",
        value: format!("{} %", percent(share)),
        remark: format!("of {} {unit}² seen lies on analytic surfaces", large(part.scan.area)),
        level,
    }
}

fn deviation(part: &Part) -> Fact {
    let unit = part.unit();
    let Some(deviation) = &part.deviation else {
        let remark = "without a solid there is nothing to compare the scan with".to_owned();
        return Fact { label: "Deviation", value: "not measured".to_owned(), remark, level: None };
    };
    Fact {
        label: "Deviation",
        value: format!("{} {unit} rms", short(deviation.rms)),
        remark: format!(
            "95 % within {}, largest {}; {} % within three sigma of the noise ({} {unit})",
            short(deviation.p95),
            short(deviation.max),
            percent(deviation.within_three_noise),
            short(part.scan.noise)
        ),
        level: None,
    }
}

fn dimensions(part: &Part) -> Fact {
    let dimensions = part.all_dimensions();
    let n_guesses = dimensions.iter().filter(|dimension| dimension.guess.is_some()).count();
    let n_offered = dimensions.iter().filter(|d| d.nominal.as_ref().is_some_and(|n| !n.applied)).count();
    let n_applied = dimensions.iter().filter(|d| d.nominal.as_ref().is_some_and(|n| n.applied)).count();
    let guesses = if part.dimensions.is_none() {
        "this result does not say which are guesses".to_owned()
    } else if n_guesses == 0 {
        "none is a guess".to_owned()
    } else {
        format!("{} little evidence", have_only(n_guesses))
    };
    let nominal = match (n_offered, n_applied) {
        (0, 0) => String::new(),
        (n, 0) => format!("; nominal values offered for {n}, none applied"),
        (n, applied) => format!("; nominal values applied to {applied}, offered for {n} more"),
    };
    let level = part.dimensions.as_ref().map(|_| if n_guesses > 0 { Level::Look } else { Level::Good });
    let value = count(dimensions.len());
    Fact { label: "Dimensions", value, remark: format!("{guesses}{nominal}"), level }
}

fn types(part: &Part) -> Fact {
    let n = part.primitives.len();
    let n_ambiguous = part.primitives.iter().filter(|p| p.ambiguous.is_some()).count();
    let remark = if n_ambiguous == 0 {
        "every type certain by what was seen".to_owned()
    } else {
        format!("the type of {n_ambiguous} is not certain")
    };
    let level = if n_ambiguous > 0 { Level::Look } else { Level::Good };
    Fact { label: "Regions", value: count(n), remark, level: Some(level) }
}

fn units(part: &Part) -> Fact {
    let source = part.units.as_ref().map(|units| units.source.as_str());
    let (level, remark) = match source {
        Some("flag") => (Some(Level::Good), "as given on the command line"),
        Some("file") => (Some(Level::Good), "as the scan's file says"),
        Some("assumed") => (Some(Level::Look), "assumed: neither file nor command line said so"),
        _ => (None, "of unknown source"),
    };
    Fact { label: "Unit of length", value: part.unit().to_owned(), remark: remark.to_owned(), level }
}

/// What to know before the result is used, the worst first.
fn points(part: &Part, places: &[WeakPlace]) -> Vec<Point> {
    let mut points = Vec::new();
    for (code, level) in ABOUT_ALL {
        for warning in part.warnings_of(code).filter(|w| w.primitive.is_none()) {
            points.push(Point { level, text: capital(&warning.text), regions: Vec::new() });
        }
    }
    for problem in part.solids.iter().flat_map(|solid| &solid.problems) {
        points.push(Point {
            level: Level::Bad,
            text: format!("Our own check: {problem}"),
            regions: Vec::new(),
        });
    }
    let mut add = |level: Level, text: &str, regions: Vec<Reference>| {
        if !regions.is_empty() {
            points.push(Point { level, text: text.to_owned(), regions });
        }
    };
    let of_code = |code: &str| references(part, &regions_with(part, code));
    add(Level::Look, "Faces assumed or extended where the scan saw nothing", of_code("W_ASSUMED_FACE"));
    add(Level::Look, "Not analytic, a B-spline stands in", of_code("W_FREEFORM"));
    add(Level::Look, "Not analytic, triangles of the scan stand in", of_code("W_FACETS"));
    add(Level::Look, "Without a face, the neighbours were extended over it", of_code("W_FACE_DROPPED"));
    let uncertain: Vec<u32> =
        part.primitives.iter().filter(|p| p.ambiguous.is_some()).map(|p| p.id).collect();
    add(Level::Look, "The type is not certain", references(part, &uncertain));
    let with = |weakness: Weakness| -> Vec<u32> {
        places.iter().filter(|place| place.has(weakness)).filter_map(|place| place.id).collect()
    };
    let guessed = with(Weakness::Guess);
    add(Level::Look, "Dimensions that are guesses", references(part, &guessed));
    let insufficient = with(Weakness::Insufficient);
    add(Level::Look, "Sizes known less well than was asked", references(part, &insufficient));
    points.sort_by_key(|point| std::cmp::Reverse(point.level));
    points
}

/// The regions that warnings of a code name, each once, ascending.
fn regions_with(part: &Part, code: &str) -> Vec<u32> {
    let mut ids: Vec<u32> = part.warnings_of(code).filter_map(|warning| warning.primitive).collect();
    ids.sort_unstable();
    ids.dedup();
    ids
}

fn distinct(ids: impl Iterator<Item = u32>) -> usize {
    ids.collect::<std::collections::BTreeSet<_>>().len()
}

fn are(n: usize, noun: &str) -> String {
    format!("{} {}", counted(n, noun), if n == 1 { "is" } else { "are" })
}

fn have(n: usize, noun: &str, done: &str) -> String {
    format!("{} {} {done}", counted(n, noun), if n == 1 { "was" } else { "were" })
}

fn have_only(n: usize) -> String {
    if n == 1 { "1 is a guess: it has".to_owned() } else { format!("{} are guesses: they have", count(n)) }
}

/// The text with a capital letter.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
