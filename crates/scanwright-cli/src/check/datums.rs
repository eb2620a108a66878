//! `--align datum`: the scan laid on faces of the model as a fixture would hold it.

use scanwright::align::{self, Alignment, Part, Target};
use scanwright::check::{self, Feature, check};
use scanwright::datum::{self, Candidate, Datum};
use scanwright::math::Pose;

use super::Placed;
use crate::args::CheckArgs;
use crate::exit::Failure;

/// From a best fit, which says what belongs to which face, to a placement by datums.
pub(super) fn place(args: &CheckArgs, target: &Target, part: &Part, best: &Alignment) -> Result<Placed, Failure> {
    let found = check(target, part, best, &check::Options::default());
    let refused = |reason: String| Failure::input(&args.scan, reason);
    let outward = |f: &Feature| target.face(f.face).outward;
    let features: Vec<&Feature> = if args.datums.is_empty() {
        let candidates: Vec<Candidate> = found
            .features
            .iter()
            .map(|f| Candidate {
                datum: Datum { surface: f.nominal, outward: outward(f), center: f.center },
                area: found.faces[f.face as usize].coverage.area,
            })
            .collect();
        let plan = datum::choose(&candidates, None)
            .ok_or_else(|| refused("no plane or axis was seen that could be a datum".into()))?;
        plan.order().into_iter().map(|k| &found.features[k]).collect()
    } else {
        args.datums.iter().map(|name| named(args, target, &found.features, name)).collect::<Result<_, _>>()?
    };
    let of = |surface, f: &&Feature| Datum { surface, outward: outward(f), center: f.center };
    let nominal: Vec<Datum> = features.iter().map(|f| of(f.nominal, f)).collect();
    let measured: Vec<Datum> = features.iter().map(|f| of(f.measured, f)).collect();
    let about = best.pivot;
    let model_frame = datum::frame(&nominal, &nominal, &about, None).map_err(|e| refused(e.to_string()))?;
    let hint = Some(model_frame.frame.x.into_inner());
    let scan_frame = datum::frame(&measured, &measured, &about, hint).map_err(|e| refused(e.to_string()))?;
    let corrected = Pose::into_frame(&model_frame.frame).inverse().after(&Pose::into_frame(&scan_frame.frame));
    let pose = corrected.after(&best.pose);
    let faces: Vec<u32> = features.iter().map(|f| f.face).collect();
    let alignment = align::held_by(target, part, &pose, &faces, best);
    let datums = features.iter().map(|f| target.face(f.face).name.clone()).collect();
    Ok(Placed { alignment: Alignment { alternatives: best.alternatives.clone(), ..alignment }, datums })
}

/// The feature of a face by its name or number.
fn named<'a>(
    args: &CheckArgs,
    target: &Target,
    features: &'a [Feature],
    name: &str,
) -> Result<&'a Feature, Failure> {
    let faces = &target.model.faces;
    let by_number = name.parse::<usize>().ok().filter(|n| (1..=faces.len()).contains(n)).map(|n| n - 1);
    let face = faces.iter().position(|f| f.name == name).or(by_number).ok_or_else(|| {
        Failure::Usage(format!("--datums: the model has no face {name:?}; its {} faces are numbered from 1", faces.len()))
    })?;
    features.iter().find(|f| f.face as usize == face).ok_or_else(|| {
        let reason = format!("face {name:?} was not seen well enough to be a datum, or has no analytic surface");
        Failure::input(&args.scan, reason)
    })
}
