//! The feature table as comma-separated values.

use std::fmt::Write as _;

use super::Check;
use crate::align::Target;

/// One line per number: `face,name,type,state,seen,quantity,nominal,measured,uncertainty,verdict`. Lengths in the scan's
/// unit, angles in radians. The distances of a face are its quantity `deviation` (mean), its form that of the name.
pub fn to_csv(check: &Check, target: &Target) -> String {
    let mut text = String::from("face,name,type,state,seen,quantity,nominal,measured,uncertainty,verdict\n");
    for face in &check.faces {
        let prior = target.face(face.face);
        let kind = prior.surface.map_or("freeform", |s| s.kind().name());
        let state = face.state();
        let start = format!("{},{},{kind},{state},{:.4}", face.face, quoted(&prior.name), face.coverage.seen);
        let mut line = |quantity: &str, nominal: f64, measured: f64, u: Option<f64>, verdict: &str| {
            let u = u.map_or_else(String::new, |u| format!("{u:.6e}"));
            // Writing to a string does not fail.
            let _ = writeln!(text, "{start},{quantity},{nominal:.9},{measured:.9},{u},{verdict}");
        };
        let verdict = face.verdict.map_or("", super::Verdict::name);
        let mean = face.spread.map_or(f64::NAN, |s| s.mean);
        if mean.is_finite() {
            line("deviation", 0.0, mean, face.profile.map(|p| p[1]), verdict);
        } else {
            let _ = writeln!(text, "{start},deviation,,,,{verdict}");
            continue;
        }
        for feature in check.features.iter().filter(|f| f.face == face.face) {
            for q in &feature.quantities {
                let verdict = q.verdict.map_or("", super::Verdict::name);
                line(q.name, q.nominal, q.measured, Some(q.uncertainty), verdict);
            }
            line(feature.form.name, 0.0, feature.form.robust, None, "");
        }
    }
    text
}

/// A field with its commas and quotes kept.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}
