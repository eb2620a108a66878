//! Tests of `script`: what the text says, and what build123d makes of it.

use std::path::{Path, PathBuf};
use std::process::Command;

use nalgebra::Rotation3;
use scanwright::brep::{Solid, build};
use scanwright::math::Vec3;
use scanwright::script::{Script, ScriptOptions, write};
use scanwright::step::StepOptions;

use crate::parts::{
    Part, STEP, block, block_with_two_bores, cap, counterbored, dented, grooved_pipe, pipe, post, tolerances,
};
use crate::step::Folder;

/// A part, how its script should see it, and how exactly.
struct Case {
    name: &'static str,
    part: Part,
    solids: Vec<Solid>,
    /// Features that a designer would need at most.
    n_features: usize,
}

impl Case {
    fn new(name: &'static str, part: Part, n_features: usize) -> Self {
        let solids = build(&part.labelled(), &tolerances(STEP * part.scale)).solids;
        Self { name, part, solids, n_features }
    }

    fn script(&self) -> Script {
        let options = ScriptOptions::new(&tolerances(STEP * self.part.scale));
        write(&self.solids, &self.part.primitives, &options)
    }
}

fn cases() -> Vec<Case> {
    let turn = Rotation3::from_euler_angles(0.4, -0.7, 1.1);
    let moved = cap().moved(&turn, 2.5, &Vec3::new(40.0, -70.0, 15.0));
    let bores = block_with_two_bores(20.0, 5.0, 6.0).close(None);
    let mut bored = Part::new();
    (bored.mesh, bored.primitives) = (bores.labelled.mesh.clone(), bores.labelled.primitives.clone());
    bored.labels = bores.labelled.labels.iter().map(|l| l.0).collect();
    vec![
        Case::new("block", block([12.0, 10.0, 8.0]), 1),
        Case::new("pipe", pipe(14.0, 6.0, 40.0), 2),
        // Three cylinders one on another, and a bore.
        Case::new("post", post([16.0, 8.0, 12.0], 4.0, 10.0), 4),
        Case::new("grooved", grooved_pipe(14.0, 6.0, 40.0, 3.0), 3),
        Case::new("cap", cap(), 2),
        Case::new("moved", moved, 2),
        Case::new("counterbored", counterbored(2.0), 2),
        Case::new("dented", dented(), 2),
        Case::new("bores", bored, 3),
    ]
}

#[test]
fn every_face_of_plain_parts_is_expressed_by_few_features() {
    for case in cases() {
        let script = case.script();
        assert_eq!(script.parts.len(), 1, "{}", case.name);
        let part = &script.parts[0];
        assert!(part.missing.is_empty(), "{}: {:?}\n{}", case.name, part.missing, script.text);
        assert!(part.n_features <= case.n_features, "{}: {}\n{}", case.name, part.n_features, script.text);
        // Samples count what differs: profiles within the tolerance of their faces differ by a skin of it at most.
        let options = ScriptOptions::new(&tolerances(STEP * case.part.scale));
        let skin = options.tolerance * case.part.mesh.total_area();
        assert!(part.differing_volume <= 0.1 * skin, "{}: {}", case.name, part.differing_volume);
    }
}

#[test]
fn the_same_solid_gives_the_same_bytes() {
    let case = Case::new("cap", cap(), 2);
    assert_eq!(case.script().text, case.script().text);
}

#[test]
fn lengths_are_named_and_say_what_they_are_of() {
    let text = Case::new("pipe", pipe(14.0, 6.0, 40.0), 2).script().text;
    for needed in ["# Expressed: ", "body_diameter = 28", "bore_1_diameter = 12", "primitive", "part.volume"]
    {
        assert!(text.contains(needed), "no {needed} in\n{text}");
    }
    // Below the parameters, numbers are only those of frames and of halving.
    let features =
        text.split("------ features").nth(1).unwrap().split("# Where the part lies").next().unwrap();
    for line in features.lines().filter(|l| !l.starts_with('#') && !l.starts_with("plane")) {
        let raw = line.split(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '.');
        let numbers: Vec<&str> =
            raw.filter(|w| w.parse::<f64>().is_ok_and(|x| x != 0.0 && x != 2.0)).collect();
        assert!(numbers.is_empty(), "{numbers:?} in {line}");
    }
}

#[test]
fn what_is_open_or_freeform_is_said() {
    let open = Case::new("open", pipe(14.0, 6.0, 40.0).without(|label, _| label == 2), 0);
    let script = open.script();
    assert_eq!(script.parts[0].missing.len(), script.parts[0].n_faces);
    assert!(script.text.contains("raise SystemExit") && script.text.contains("the solid is open"));
    // A wall that no surface describes.
    let mut part = pipe(14.0, 6.0, 40.0);
    part.primitives[0].surface = None;
    let freeform = Case::new("freeform", part, 0);
    let script = freeform.script();
    let missing = &script.parts[0].missing;
    assert!(missing.iter().any(|m| m.primitive == 0 && m.text.starts_with("freeform")), "{missing:?}");
    assert!(script.text.contains("# Not expressed: primitive 0 (freeform"), "{}", script.text);
    assert!(write(&[], &[], &ScriptOptions::new(&tolerances(STEP))).text.contains("raise SystemExit"));
}

#[test]
fn build123d_rebuilds_our_solids() {
    let folder = Folder::new("script");
    let cases = cases();
    let files: Vec<[PathBuf; 2]> = cases
        .iter()
        .map(|case| {
            let script = case.script();
            let step = folder.write(&format!("{}.step", case.name), &case.solids, &StepOptions::default());
            let path = step.with_extension("py");
            std::fs::write(&path, script.text).unwrap();
            [path, step]
        })
        .collect();
    for (case, verdict) in cases.iter().zip(rebuild(&files)) {
        let name = case.name;
        let (ours, theirs) = (&verdict["solid"], &verdict["rebuilt"]);
        assert_eq!(theirs["valid"], true, "{name}: {verdict}");
        assert_eq!(theirs["solids"], 1, "{name}: {verdict}");
        for measure in ["volume", "area"] {
            let [a, b] = [ours, theirs].map(|v| v[measure].as_f64().unwrap());
            assert!((b / a - 1.0).abs() < 0.01, "{name}: {measure} {b} instead of {a}");
        }
        // Boxes of curved faces are wide by what the kernel takes for their poles.
        let slack = ScriptOptions::new(&tolerances(STEP * case.part.scale)).tolerance;
        for end in ["low", "high"] {
            for axis in 0..3 {
                let [a, b] = [ours, theirs].map(|v| v[end][axis].as_f64().unwrap());
                assert!((a - b).abs() <= slack, "{name}: {end} {axis} {b} instead of {a}");
            }
        }
        assert!(theirs["said"].as_str().unwrap().contains("difference"), "{name}: {verdict}");
    }
}

/// What build123d makes of scripts, and Open CASCADE of the solids beside them.
fn rebuild(files: &[[PathBuf; 2]]) -> Vec<serde_json::Value> {
    let crate_root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = std::env::var_os("SCANWRIGHT_PYTHON")
        .map_or_else(|| crate_root.join("../../.venv/bin/python"), PathBuf::from);
    let output = Command::new(&python)
        .arg(crate_root.join("tests/rebuild.py"))
        .args(files.iter().flatten())
        .output()
        .unwrap_or_else(|error| panic!("{}: {error}; ./test.sh installs build123d there", python.display()));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let verdicts: Vec<serde_json::Value> =
        text.lines().filter(|l| l.starts_with('{')).map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(verdicts.len(), files.len(), "{text}");
    verdicts
}
