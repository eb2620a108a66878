//! Scans held against models: nothing where nothing differs, and what was changed on purpose with its value.

use scanwright::align::{self, Alignment, Measure, Part, Target, align, border_width};
use scanwright::check::{Change, ChangeKind, Check, Options, Verdict, check};
use scanwright::mesh::Mesh;
use scanwright::prior::PriorModel;

use crate::plates::{BOSS, Plate, part_of, random_pose, scan_of};

const SPACING: f64 = 1.0;
const NOISE: f64 = 0.05;

/// A scan laid on a model and held against it.
fn checked(model: &PriorModel, scan: &Mesh, tolerance: Option<f64>) -> (Part, Alignment, Check) {
    let part = part_of(scan);
    let target = Target::new(model, Measure::Surfaces, border_width(&part.tolerances)).unwrap();
    let found = align(&target, &part, &align::Options::default()).unwrap();
    let result = check(&target, &part, &found, &Options { tolerance });
    (part, found, result)
}

fn change_of<'a>(result: &'a Check, model: &PriorModel, name: &str, kind: ChangeKind) -> &'a Change {
    let of_name = |c: &&Change| c.face.is_some_and(|f| model.faces[f as usize].name == name);
    let found = result.changes.iter().filter(of_name).find(|c| c.kind == kind);
    found.unwrap_or_else(|| panic!("no {kind:?} of {name}: {:?}", result.changes))
}

#[test]
fn a_part_that_is_as_designed_has_no_changes_and_passes() {
    let model = Plate::default().model();
    let scan = scan_of(&Plate::default().mesh(SPACING), NOISE, &random_pose(11), 1);
    // Two and a half times what the boss's direction is known to over its height, guard band included.
    let (_, _, result) = checked(&model, &scan, Some(0.25));
    assert!(result.changes.is_empty(), "{:?}", result.changes);
    assert_eq!(result.verdict, Some(Verdict::Pass));
}

#[test]
fn a_model_against_its_own_vertices_is_zero_within_rounding() {
    let plate = Plate::default();
    let model = plate.model();
    let (_, found, result) = checked(&model, &plate.mesh(SPACING), None);
    let rounding = 1e-9;
    assert!((found.pose.translation.norm() + found.pose.angle()) < rounding, "{:?}", found.pose);
    let worst = result
        .sightings
        .of_vertex
        .iter()
        .flatten()
        .filter(|s| !s.at_border)
        .map(|s| s.distance.abs())
        .fold(0.0, f64::max);
    assert!(worst < rounding, "{worst}");
    assert!(result.changes.is_empty(), "{:?}", result.changes);
}

#[test]
fn a_wider_bore_a_lower_face_and_a_new_boss_are_found_with_their_values() {
    let model = Plate::default().model();
    let made = Plate { bore: 5.1, extra: true, ..Plate::default() };
    let scan = scan_of(&made.mesh_with_boss(0.7 * SPACING, BOSS.2 - 0.05), NOISE, &random_pose(12), 2);
    let (_, _, result) = checked(&model, &scan, Some(0.03));

    let wider = change_of(&result, &model, "bore", ChangeKind::Resized);
    let u = wider.uncertainty.unwrap();
    assert!((wider.value - 0.1).abs() < 3.5 * u && u < 0.02, "{wider:?}");
    let lower = change_of(&result, &model, "boss top", ChangeKind::Moved);
    let u = lower.uncertainty.unwrap();
    assert!((lower.value + 0.05).abs() < 3.5 * u && u < 0.0125, "{lower:?}");
    let new = result.changes.iter().filter(|c| c.kind == ChangeKind::New).count();
    assert_eq!(new, 2, "wall and top of the boss that no model knows: {:?}", result.changes);
    assert_eq!(result.changes.len(), 4, "{:?}", result.changes);
    assert_eq!(result.verdict, Some(Verdict::Fail));
}

#[test]
fn a_missing_boss_is_missing_and_nothing_else_is() {
    let model = Plate::default().model();
    let made = Plate { boss: false, ..Plate::default() };
    let scan = scan_of(&made.mesh(SPACING), NOISE, &random_pose(14), 5);
    let (_, _, result) = checked(&model, &scan, Some(0.25));
    change_of(&result, &model, "boss", ChangeKind::Missing);
    change_of(&result, &model, "boss top", ChangeKind::Missing);
    assert_eq!(result.changes.len(), 2, "{:?}", result.changes);
    assert_eq!(result.verdict, Some(Verdict::Fail));
}

#[test]
fn a_moved_bore_is_one_change_with_its_way() {
    let model = Plate::default().model();
    for way in [0.2, 3.0] {
        let made = Plate { bore_at: [-15.0 + way, 5.0], ..Plate::default() };
        let scan = scan_of(&made.mesh(SPACING), NOISE, &random_pose(13), 3);
        let (_, _, result) = checked(&model, &scan, None);
        let moved = change_of(&result, &model, "bore", ChangeKind::Moved);
        let shift = moved.shift.unwrap();
        assert!((shift - nalgebra::Vector3::x() * way).norm() < 0.05, "{shift}");
        assert_eq!(result.changes.len(), 1, "{:?}", result.changes);
    }
}

#[test]
fn what_was_not_seen_does_not_pass() {
    let model = Plate::default().model();
    let whole = Plate::default().mesh(SPACING);
    let (scan, _, _) = whole.submesh(|t| whole.triangle_center(t).z > 1.0);
    let (_, _, result) = checked(&model, &scan, Some(0.1));
    let bottom = result.faces.iter().find(|f| model.faces[f.face as usize].name == "bottom").unwrap();
    assert_eq!((bottom.state(), bottom.verdict), ("unobserved", Some(Verdict::Undecided)));
    assert_eq!(result.verdict, Some(Verdict::Undecided));
    assert!(result.changes.is_empty(), "{:?}", result.changes);
}
