//! Parts placed in scans, and the files that hold them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use nalgebra::SVector;
use scanwright::align::{Alignment, Freedom};
use scanwright::assemble::{NotPlaced, place};
use scanwright::brep::build;
use scanwright::math::{Frame, Point3, Pose, UnitVec3, Vec3};
use scanwright::prior::PriorModel;
use scanwright::step::read::{StepReadError, read};
use scanwright::step::{Component, LengthUnit, StepOptions, write, write_assembly};

use crate::parts::{Part, STEP, block, pipe, tolerances};
use crate::plates::{Plate, part_of, scan_of};
use crate::scanned::scan;

// ----------------------------------------------------------------------------------------------------------- files

fn text_of(part: &Part, name: &str, unit: LengthUnit) -> String {
    let solids = build(&part.labelled(), &tolerances(STEP)).solids;
    write(&solids, &StepOptions { name: name.into(), unit, ..StepOptions::default() })
}

/// Two blocks, one turned, and a pipe drawn in inches, in millimetres.
fn assembly(block: &str, pipe: &str) -> Vec<u8> {
    let at = |x: f64, y: f64, z: f64| Frame::from_z(Point3::new(x, y, z), Vec3::z_axis());
    let turned = Frame {
        origin: Point3::new(0.0, 0.0, 50.0),
        x: Vec3::y_axis(),
        y: UnitVec3::new_normalize(-Vec3::x()),
        z: Vec3::z_axis(),
    };
    let component = |name: &str, text, frame| Component { name: name.to_owned(), text, frame };
    let components = [
        component("base", block.as_bytes(), at(100.0, 0.0, 0.0)),
        component("Träger 'A'", block.as_bytes(), turned),
        component("tube", pipe.as_bytes(), at(0.0, -1000.0, 0.0)),
    ];
    write_assembly(&components, &StepOptions { name: "whole".into(), ..StepOptions::default() }).unwrap()
}

#[test]
fn an_assembly_holds_its_parts_where_they_were_put() {
    let block_text = text_of(&block([12.0, 10.0, 8.0]), "block", LengthUnit::Millimetre);
    let pipe_text = text_of(&pipe(14.0, 6.0, 40.0), "pipe", LengthUnit::Inch);
    let text = assembly(&block_text, &pipe_text);
    let pipe_alone = read(pipe_text.as_bytes()).unwrap();
    let pipe_volume = pipe_alone.mesh.signed_volume() * 25.4_f64.powi(3);
    let model = read(&text).unwrap();
    assert_eq!(model.unread, [""; 0]);
    let volume = model.mesh.signed_volume();
    assert!((volume / (2.0 * 960.0 + pipe_volume) - 1.0).abs() < 1e-9, "volume {volume}");
    let names: Vec<&str> = model.parts.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["block", "block", "pipe"]);
    let bounds = |part: usize| {
        let first = model.parts[part].first_face;
        let faces = first..first + model.parts[part].n_faces;
        let (mesh, ..) = model.mesh.submesh(|t| faces.contains(&model.face_of[t]));
        mesh.bounds().unwrap()
    };
    let near = |a: Point3, b: [f64; 3]| assert!((a - Point3::from(b)).norm() < 1e-9, "{a}, should be {b:?}");
    near(bounds(0).0, [100.0, 0.0, 0.0]);
    near(bounds(0).1, [112.0, 10.0, 8.0]);
    near(bounds(1).0, [-10.0, 0.0, 50.0]);
    near(bounds(1).1, [0.0, 12.0, 58.0]);
    let (low, high) = pipe_alone.mesh.bounds().unwrap();
    near(bounds(2).0, [low.x * 25.4, low.y * 25.4 - 1000.0, low.z * 25.4]);
    near(bounds(2).1, [high.x * 25.4, high.y * 25.4 - 1000.0, high.z * 25.4]);
}

#[test]
fn every_reference_of_an_assembly_is_defined_once_and_parts_are_written_once() {
    let block_text = text_of(&block([12.0, 10.0, 8.0]), "block", LengthUnit::Millimetre);
    let pipe_text = text_of(&pipe(14.0, 6.0, 40.0), "pipe", LengthUnit::Inch);
    let text = String::from_utf8(assembly(&block_text, &pipe_text)).unwrap();
    let data = text.split_once("DATA;\n").unwrap().1;
    let (mut defined, mut used) = (BTreeSet::new(), BTreeSet::new());
    for (id, body) in data.lines().filter_map(|line| line.strip_prefix('#')?.split_once('=')) {
        assert!(defined.insert(id.parse::<u64>().unwrap()), "#{id} is defined twice");
        used.extend(body.split('#').skip(1).map(|rest| {
            let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap();
            rest[..end].parse::<u64>().unwrap()
        }));
    }
    assert!(used.is_subset(&defined), "undefined: {:?}", used.difference(&defined));
    let count = |text: &str, word: &str| text.matches(word).count();
    for word in ["=ADVANCED_FACE(", "=COLOUR_RGB(", "=EDGE_CURVE("] {
        assert_eq!(count(&text, word), count(&block_text, word) + count(&pipe_text, word), "{word}");
    }
    assert_eq!(count(&text, "=NEXT_ASSEMBLY_USAGE_OCCURRENCE("), 3);
}

#[test]
fn open_cascade_reads_the_names_and_the_places() {
    let block_text = text_of(&block([12.0, 10.0, 8.0]), "block", LengthUnit::Millimetre);
    let pipe_text = text_of(&pipe(14.0, 6.0, 40.0), "pipe", LengthUnit::Inch);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("assembly");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("whole.step");
    std::fs::write(&path, assembly(&block_text, &pipe_text)).unwrap();
    let verdict = &crate::step::judge(std::slice::from_ref(&path))[0];
    assert_eq!((verdict["readable"].as_bool(), verdict["valid"].as_bool()), (Some(true), Some(true)));
    assert_eq!(verdict["solids"], 3);
    let expected = 2.0 * 960.0 + std::f64::consts::PI * 160.0 * 40.0 * 25.4_f64.powi(3);
    assert!((verdict["volume"].as_f64().unwrap() / expected - 1.0).abs() < 1e-6, "{verdict}");
    let names = xcaf(&path);
    assert_eq!(
        names,
        serde_json::json!([["whole", [["base", "block"], ["Träger 'A'", "block"], ["tube", "pipe"]]]])
    );
}

fn xcaf(path: &Path) -> serde_json::Value {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = std::env::var_os("SCANWRIGHT_PYTHON")
        .map_or_else(|| root.join("../../.venv/bin/python"), PathBuf::from);
    let output = Command::new(&python).arg(root.join("tests/xcaf.py")).arg(path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let line = text.lines().find(|l| l.starts_with('[')).unwrap_or_else(|| panic!("{text}"));
    serde_json::from_str(line).unwrap()
}

#[test]
fn a_part_with_a_dangling_reference_is_refused_by_name() {
    let text = text_of(&block([12.0, 10.0, 8.0]), "block", LengthUnit::Millimetre)
        .replace("PLANE('',#", "PLANE('',#99");
    let frame = Frame::from_z(Point3::origin(), Vec3::z_axis());
    let components = [Component { name: "bad".into(), text: text.as_bytes(), frame }];
    let error = write_assembly(&components, &StepOptions::default()).unwrap_err();
    assert_eq!(error.name, "bad");
    assert!(matches!(error.reason, StepReadError::Missing(id) if id >= 99), "{error}");
}

// ------------------------------------------------------------------------------------------------------- placement

const SPACING: f64 = 0.8;
const NOISE: f64 = 0.05;

/// How far a found place is from the true one in units of its own uncertainty: six numbers.
fn in_sigmas(found: &Alignment, scan_from_part: &Pose) -> SVector<f64, 6> {
    let left = found.pose.after(scan_from_part);
    let turn = left.rotation.scaled_axis();
    let way = left.point(&found.pivot) - found.pivot;
    let step = SVector::<f64, 6>::from([turn.x, turn.y, turn.z, way.x, way.y, way.z]);
    let covariance = nalgebra::SMatrix::<f64, 6, 6>::from_fn(|i, j| found.covariance[i][j]);
    let root = covariance.cholesky().expect("all six numbers are known");
    root.l().solve_lower_triangular(&step).expect("and none exactly")
}

#[test]
fn two_plates_on_one_another_are_placed_and_a_third_that_is_not_there_is_not() {
    let lower = Plate::default();
    let upper = Plate { bore: 7.0, bore_at: [-10.0, 0.0], top: 7.0, boss: false, ..Plate::default() };
    let turned = nalgebra::Rotation3::from_axis_angle(&Vec3::z_axis(), 0.4);
    // On the lower one's upper face, over its boss's edge.
    let upper_place = Pose { rotation: turned, translation: Vec3::new(-32.0, 8.0, 10.0) };
    let back = upper_place.inverse();
    let union = |p: &Point3| lower.distance(p).min(upper.distance(&back.point(p)));
    let mesh = scan(union, [-75.03, -30.01, -2.02], [34.0, 42.0, 19.0], SPACING);
    let truth = crate::plates::random_pose(3);
    let scanned = part_of(&scan_of(&mesh, NOISE, &truth, 7));
    let absent = Plate { bore: 2.0, bore_at: [20.0, 12.0], top: 25.0, extra: true, boss: false };
    let models: Vec<PriorModel> = [absent, upper, lower].iter().map(Plate::model).collect();
    let results = place(&models, &scanned);
    assert!(
        matches!(results[0], Err(NotPlaced::TooLittle(_) | NotPlaced::Undetermined(_))),
        "{:?}",
        results[0]
    );
    for (result, at) in results[1..].iter().zip([truth.after(&upper_place), truth]) {
        let placement = result.as_ref().unwrap();
        assert_eq!(placement.alignment.freedom, Freedom::None);
        assert!(placement.covered > 0.4, "{}", placement.covered);
        let z = in_sigmas(&placement.alignment, &at);
        // Six numbers of a normal distribution: beyond 4.5 once in 25 000.
        assert!(z.amax() < 4.5, "{z}");
    }
}
