//! A scan held against the model it should be.
//!
//! [`check`] takes a scan already placed ([`align`](crate::align)), gives every vertex to the model's face it lies on
//! (`sightings`), says of every face how much of it was seen (`coverage`) and how its points deviate (`faces`), fits the
//! face's own type of surface to them and compares sizes, places and directions with the model's (`features`), measures
//! form (`form`), and lists what is different (`changes`). Every number that is decided on has a standard uncertainty, and
//! what was not seen never passes.
//!
//! Decisions are those of ISO 14253-1: conformity is shown, or nonconformity is, with a guard band of the uncertainty on
//! either side of the limit; in between nothing is.

mod bend;
mod changes;
mod coverage;
mod faces;
mod features;
mod form;
mod json;
mod sightings;
mod table;

pub use changes::{Change, ChangeKind};
pub use coverage::Coverage;
pub use faces::{FaceCheck, Spread};
pub use features::{Feature, Quantity};
pub use form::Form;
pub use json::{Context, to_json, update_json};
pub use sightings::{Sighting, Sightings};
pub use table::to_csv;

use crate::align::{Alignment, Part, Target};

/// What the caller asks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// Largest deviation allowed, length: every surface within it of the model, sizes and places too. Nothing is decided
    /// without one.
    pub tolerance: Option<f64>,
}

/// What holds of a number and its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Within the limit, the guard band kept.
    Pass,
    /// Neither within nor beyond it for certain.
    Undecided,
    /// Beyond the limit by more than the guard band.
    Fail,
}

impl Verdict {
    /// Name for people and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Undecided => "undecided",
            Self::Fail => "fail",
        }
    }
}

/// Standard uncertainties of the guard band: 95 % on the side of the limit, as ISO 14253-1:2017 has it.
pub const GUARD: f64 = 1.65;

/// The verdict on a deviation.
pub fn decide(deviation: f64, uncertainty: f64, tolerance: f64) -> Verdict {
    let (size, guard) = (deviation.abs(), GUARD * uncertainty);
    if size + guard <= tolerance {
        Verdict::Pass
    } else if size - guard > tolerance {
        Verdict::Fail
    } else {
        Verdict::Undecided
    }
}

/// Everything that a check found.
#[derive(Debug, Clone)]
pub struct Check {
    /// Where each vertex of the part lies on the model.
    pub sightings: Sightings,
    /// Statistics of all vertices on the model, those at sharp edges left out.
    pub overall: Spread,
    /// One per face of the model.
    pub faces: Vec<FaceCheck>,
    /// One per face whose surface could be fitted, in the order of the faces.
    pub features: Vec<Feature>,
    /// What differs by more than uncertainty explains.
    pub changes: Vec<Change>,
    /// The worst verdict, when a tolerance was given.
    pub verdict: Option<Verdict>,
}

/// Holds a scan against a model. `alignment`: of this part to this target.
pub fn check(target: &Target, part: &Part, alignment: &Alignment, options: &Options) -> Check {
    let sightings = Sightings::new(target, part, alignment);
    let coverage = coverage::of_faces(target, part, alignment, &sightings);
    let features = features::measure(target, part, alignment, &sightings, options);
    let faces = faces::of_faces(target, part, alignment, &sightings, coverage, &features, options);
    let changes = changes::find(target, part, alignment, &sightings, &faces, &features);
    let overall = faces::overall(&sightings);
    let verdict = options.tolerance.map(|_| verdict(&faces, &features));
    Check { sightings, overall, faces, features, changes, verdict }
}

/// The worst of all verdicts.
fn verdict(faces: &[FaceCheck], features: &[Feature]) -> Verdict {
    let of_faces = faces.iter().filter_map(|face| face.verdict);
    let of_features = features.iter().flat_map(|f| &f.quantities).filter_map(|q| q.verdict);
    of_faces.chain(of_features).max().unwrap_or(Verdict::Undecided)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_guard_band_lies_on_both_sides_of_the_limit() {
        assert_eq!(decide(-0.08, 0.01, 0.1), Verdict::Pass);
        assert_eq!(decide(0.09, 0.01, 0.1), Verdict::Undecided);
        assert_eq!(decide(0.11, 0.01, 0.1), Verdict::Undecided);
        assert_eq!(decide(-0.12, 0.01, 0.1), Verdict::Fail);
    }
}
