//! What a check found, for people: one fact per line, the first word says what about.

use std::fmt::Write as _;

use scanwright::check::{FaceCheck, Verdict};

use super::{Done, listed};

/// Lines about one thing that are written out.
const MOST_LINES: usize = 20;

pub(super) fn of(done: &Done) -> String {
    let unit = done.units.name();
    let mut text = String::new();
    let mut line = |word: &str, fact: &str| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{word:10} {fact}");
    };
    let (found, alignment) = (done.found, &done.placed.alignment);
    let n_on = found.sightings.of_vertex.iter().flatten().count();
    line("read", &format!("{}: {} vertices, {n_on} of them on the model", done.args.scan.display(), done.part.mesh.vertices.len()));
    line("model", &format!("{}: {} faces", done.args.model.display(), found.faces.len()));
    for unread in done.target.model.unread.iter().take(MOST_LINES) {
        line("unread", unread);
    }
    line("alignment", &alignment_line(done));
    if let Some(free) = alignment.freedom.text() {
        line("free", &format!("the scan does not determine {free}"));
    }
    if !alignment.alternatives.is_empty() {
        let turns: Vec<String> = alignment
            .alternatives
            .iter()
            .filter_map(|a| a.turn_from(&alignment.pose))
            .map(|(angle, d)| format!("{:.1} degrees about ({:.2}, {:.2}, {:.2})", angle.to_degrees(), d.x, d.y, d.z))
            .collect();
        let n = alignment.alternatives.len();
        line("ambiguous", &format!("{n} other placements explain the scan as well: turned by {}", listed(&turns)));
    }
    let s = found.overall;
    line(
        "deviation",
        &format!(
            "mean {:+.4}  rms {:.4}  p95 {:.4}  99.7 % in {:+.4} .. {:+.4} {unit}",
            s.mean, s.rms, s.p95, s.range[0], s.range[1]
        ),
    );
    line("faces", &faces_line(done));
    let names: Vec<String> = done.target.model.faces.iter().map(|f| f.name.clone()).collect();
    for change in found.changes.iter().take(MOST_LINES) {
        line("change", &change.text(&names, unit));
    }
    if found.changes.len() > MOST_LINES {
        line("change", &format!("and {} more", found.changes.len() - MOST_LINES));
    }
    if found.changes.is_empty() {
        line("change", "none beyond what uncertainty and noise explain");
    }
    if let (Some(verdict), Some(tolerance)) = (found.verdict, done.args.tolerance) {
        verdict_lines(done, tolerance, &mut line);
        line("verdict", &format!("{} at {tolerance} {unit}", verdict.name()));
    }
    text
}

fn alignment_line(done: &Done) -> String {
    let (alignment, unit) = (&done.placed.alignment, done.units.name());
    let axes = [nalgebra_axis(0), nalgebra_axis(1), nalgebra_axis(2)];
    let way = axes.iter().map(|a| alignment.uncertainty_at(&alignment.pivot, a)).fold(0.0, f64::max);
    let turn = axes.iter().map(|a| alignment.turn_uncertainty(a)).fold(0.0, f64::max);
    let held = if done.placed.datums.is_empty() {
        done.args.align.name().to_owned()
    } else {
        format!("datum ({})", done.placed.datums.join(", "))
    };
    format!(
        "{held}; {:.1} % of the scan explained; place known to {way:.2e} {unit}, turn to {:.2e} degrees",
        100.0 * alignment.explained,
        turn.to_degrees()
    )
}

/// A coordinate direction.
fn nalgebra_axis(k: usize) -> scanwright::math::Vec3 {
    let mut axis = scanwright::math::Vec3::zeros();
    axis[k] = 1.0;
    axis
}

fn faces_line(done: &Done) -> String {
    let faces = &done.found.faces;
    let count = |state: &str| faces.iter().filter(|f| f.state() == state).count();
    let area: f64 = faces.iter().map(|f| f.coverage.area).sum();
    let seen: f64 = faces.iter().map(|f| f.coverage.area * f.coverage.seen).sum();
    format!(
        "{} seen, {} partly, {} unobserved, {} absent; {:.1} % of the model's area seen",
        count("seen"),
        count("partly"),
        count("unobserved"),
        count("absent"),
        100.0 * seen / area.max(f64::MIN_POSITIVE)
    )
}

/// What fails and what is undecided, by name.
fn verdict_lines(done: &Done, tolerance: f64, line: &mut impl FnMut(&str, &str)) {
    let name = |face: u32| done.target.face(face).name.clone();
    let unit = done.units.name();
    let (mut n_lines, mut left) = (0, 0);
    let mut say = |word: &str, text: &str| {
        if n_lines < MOST_LINES { line(word, text) } else { left += 1 }
        n_lines += 1;
    };
    for wanted in [Verdict::Fail, Verdict::Undecided] {
        let of_faces = |f: &&FaceCheck| f.verdict == Some(wanted);
        for face in done.found.faces.iter().filter(of_faces) {
            let profile = face.profile.map_or_else(String::new, |p| {
                format!(": surface off by {:+.4} +- {:.4} {unit}", p[0], p[1])
            });
            say(
                wanted.name(),
                &format!("{} ({}, {:.0} % seen){profile}", name(face.face), face.state(), 100.0 * face.coverage.seen),
            );
        }
        for feature in &done.found.features {
            for q in feature.quantities.iter().filter(|q| q.verdict == Some(wanted)) {
                say(
                    wanted.name(),
                    &format!(
                        "{} {}: {:+.4} +- {:.4} {unit} of {tolerance}",
                        name(feature.face),
                        q.name.replace('_', " "),
                        q.deviation,
                        q.deviation_uncertainty
                    ),
                );
            }
        }
    }
    if left > 0 {
        line("undecided", &format!("and {left} lines more, in the JSON and CSV"));
    }
}
