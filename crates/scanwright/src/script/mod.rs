//! Features of a solid, and the script that rebuilds it from them.

mod arrangement;
mod body;
mod candidates;
mod curve;
mod feature;
mod grid;
mod holes;
mod judge;
mod min_cut;
mod outline;
mod overlap;
mod search;
mod sweep;
mod trace;

use crate::brep::Solid;

/// Debug.
pub fn debug(solid: &Solid, tolerance: f64) -> String {
    use std::fmt::Write as _;
    let mut out = String::new();
    let Some(body) = body::Body::new(solid) else { return out };
    let model = search::search(&body, tolerance, 1);
    for f in model.features() {
        let _ = writeln!(
            out,
            "{:?} {:?} z={:.3?} at {:.3?} range {:.3?} whole {} capped {:.2?} faces {:?}",
            f.sign, f.sweep.motion, f.sweep.frame.z.into_inner(), f.sweep.frame.origin, f.range, f.is_whole, f.capped, f.faces()
        );
        for r in &f.rings {
            let _ = writeln!(out, "   ring");
            for s in &r.segments {
                let _ = writeln!(out, "      {:.3?} -> {:.3?} {:.2} {:?} {}", s.from.as_slice(), s.to.as_slice(), s.backed, s.faces, match s.curve { curve::Curve::Line{..} => String::new(), curve::Curve::Circle{radius, ..} => format!("r={radius:.3}") });
            }
        }
    }
    let v = judge::judge(&body, &model, tolerance, 1);
    let missing: Vec<usize> = v.expressed.iter().enumerate().filter(|e| !e.1).map(|e| e.0).collect();
    let _ = writeln!(out, "volume {:.2} expected {:.2} +- {:.2} differs {:.2} ({:.3} %) expressed {}/{} missing {missing:?}", v.volume, v.expected, v.error, v.differs, 100.0*v.differs/v.volume, v.expressed.len()-missing.len(), v.expressed.len());
    out
}
