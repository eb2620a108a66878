//! Tests of `step`: the text as such, and what Open CASCADE reads in it.

use scanwright::brep::{Solid, build};
use scanwright::pipeline::{self, Options};
use scanwright::progress::Progress;
use scanwright::step::{LengthUnit, Schema, StepOptions, write};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::parts::{Part, STEP, block, block_with_two_bores, cap, dented, pipe, tolerances};
use crate::scans;

// ------------------------------------------------------------------------------------------------------ the text

#[test]
fn every_reference_is_defined_once_and_used() {
    for solids in [of(&block([12.0, 10.0, 8.0])), of(&cap()), Vec::new()] {
        let text = write(&solids, &StepOptions::default());
        assert!(
            text.starts_with("ISO-10303-21;\nHEADER;\n") && text.ends_with("ENDSEC;\nEND-ISO-10303-21;\n")
        );
        let data = text.split_once("DATA;\n").unwrap().1;
        let entities = || data.lines().filter_map(|line| line.strip_prefix('#')?.split_once('='));
        let mut defined = BTreeSet::new();
        let mut used = BTreeSet::new();
        for (id, body) in entities() {
            assert!(defined.insert(id.parse::<usize>().unwrap()), "#{id} is defined twice");
            used.extend(body.split('#').skip(1).map(|rest| {
                let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap();
                rest[..end].parse::<usize>().unwrap()
            }));
        }
        assert!(used.is_subset(&defined), "undefined: {:?}", used.difference(&defined));
        // What nothing refers to is a root: the shape, its category and its protocol, and the colours.
        let roots = [
            "SHAPE_DEFINITION_REPRESENTATION",
            "PRODUCT_RELATED",
            "APPLICATION_PROTOCOL",
            "MECHANICAL_DESIGN",
        ];
        for (id, body) in entities().filter(|(id, _)| !used.contains(&id.parse().unwrap())) {
            assert!(roots.iter().any(|root| body.starts_with(root)), "nothing uses #{id}={body}");
        }
    }
}

#[test]
fn each_edge_is_written_once_and_used_once_in_each_sense() {
    let solids = of(&pipe(14.0, 6.0, 40.0));
    let text = write(&solids, &StepOptions::default());
    assert_eq!(text.matches("=EDGE_CURVE(").count(), solids[0].edges.len());
    assert_eq!(text.matches("=ADVANCED_FACE(").count(), solids[0].faces.len());
    for sense in [".T.", ".F."] {
        let uses = text.lines().filter(|l| l.contains("=ORIENTED_EDGE(") && l.contains(sense));
        assert_eq!(uses.count(), solids[0].edges.len(), "uses {sense}");
    }
}

#[test]
fn names_schemas_and_units_are_written() {
    let solids = of(&block([12.0, 10.0, 8.0]));
    let name = "Träger 'A' \\ 1".to_owned();
    let options =
        StepOptions { name, schema: Schema::Ap214, unit: LengthUnit::Inch, ..StepOptions::default() };
    let text = write(&solids, &options);
    assert!(text.is_ascii());
    assert!(text.contains("PRODUCT('Tr\\X2\\00E4\\X0\\ger ''A'' \\\\ 1'"));
    assert!(
        text.contains("FILE_SCHEMA(('AUTOMOTIVE_DESIGN") && text.contains("CONVERSION_BASED_UNIT('INCH'")
    );
    let plain = write(&solids, &StepOptions::default());
    assert!(plain.contains("FILE_SCHEMA(('AP242") && !plain.contains("CONVERSION_BASED_UNIT"));
}

#[test]
fn assumed_faces_are_named_so() {
    let closed = pipe(14.0, 6.0, 40.0).without(|t, p| t == 2 || (t == 1 && p.z > 10.0)).close(None);
    let solids = build(&closed.labelled, &tolerances(STEP)).solids;
    let n_assumed = solids.iter().flat_map(|s| &s.faces).filter(|f| f.assumed).count();
    assert!(n_assumed > 0);
    let text = write(&solids, &StepOptions::default());
    assert_eq!(
        text.lines().filter(|l| l.contains("=ADVANCED_FACE(") && l.contains(" assumed'")).count(),
        n_assumed
    );
}

// -------------------------------------------------------------------------------------------------- Open CASCADE

#[test]
fn open_cascade_finds_our_solids_valid() {
    let bores = block_with_two_bores(20.0, 5.0, 6.0).close(None);
    let volume = |p: &Part| p.mesh.signed_volume();
    // Grids lie inside their round faces by sagittas: up to this share of the volume.
    let grid = 0.01;
    let cases = [
        Case::new("block", of(&block([12.0, 10.0, 8.0])), 960.0, 1e-9, &[("Plane", 6)]),
        Case::new(
            "pipe",
            of(&pipe(14.0, 6.0, 40.0)),
            std::f64::consts::PI * 160.0 * 40.0,
            1e-6,
            &[("Cylinder", 4), ("Plane", 2)],
        ),
        Case::new(
            "cap",
            of(&cap()),
            volume(&cap()),
            grid,
            &[("Cone", 2), ("Cylinder", 2), ("Plane", 2), ("Sphere", 1), ("Torus", 2)],
        ),
        Case::new(
            "dented",
            of(&dented()),
            std::f64::consts::PI * (1200.0 - 72.0),
            1e-6,
            &[("Cone", 2), ("Cylinder", 2), ("Plane", 2)],
        ),
        Case::new(
            "bores",
            build(&bores.labelled, &tolerances(STEP)).solids,
            bores.labelled.mesh.signed_volume(),
            grid,
            &[("Cylinder", 4), ("Plane", 8)],
        ),
    ];
    check_all(&cases, 0.05 * STEP);
}

#[test]
fn open_cascade_finds_scanned_parts_valid() {
    let size = [24.0, 18.0, 12.0];
    let block = pipeline::run(&scans::block(size, 1.2), &Options::default(), &Progress::none()).unwrap();
    assert_eq!(block.model.solids.len(), 1);
    // Each of six faces is uncertain by its noise over the root of its points: far below a thousandth of the size.
    let case = Case::new("scan", block.model.solids, size.iter().product(), 2e-3, &[("Plane", 6)]);
    check_all(&[case], block.tolerances.gap());
}

#[test]
fn open_cascade_reads_our_units() {
    let solids = of(&block([12.0, 10.0, 8.0]));
    let folder = Folder::new("units");
    let units = [
        (LengthUnit::Millimetre, 1.0),
        (LengthUnit::Centimetre, 10.0),
        (LengthUnit::Metre, 1000.0),
        (LengthUnit::Inch, 25.4),
        (LengthUnit::Foot, 304.8),
        (LengthUnit::Micrometre, 1e-3),
    ];
    let files: Vec<PathBuf> = units
        .iter()
        .enumerate()
        .map(|(i, (unit, _))| {
            let schema = if i % 2 == 0 { Schema::Ap242 } else { Schema::Ap214 };
            folder.write(
                &format!("{i}.step"),
                &solids,
                &StepOptions { unit: *unit, schema, ..StepOptions::default() },
            )
        })
        .collect();
    for (verdict, (unit, factor)) in judge(&files).iter().zip(units) {
        let expected = 960.0 * f64::powi(factor, 3);
        let volume = verdict["volume"].as_f64().unwrap();
        assert!((volume / expected - 1.0).abs() < 1e-6, "{unit:?}: {verdict}");
    }
}

/// Solids that are one, and what they shall be read as.
struct Case {
    name: &'static str,
    solids: Vec<Solid>,
    volume: f64,
    /// Allowed relative difference of the volume.
    relative: f64,
    faces: serde_json::Value,
}

impl Case {
    fn new(
        name: &'static str,
        solids: Vec<Solid>,
        volume: f64,
        relative: f64,
        faces: &[(&str, usize)],
    ) -> Self {
        let faces = faces.iter().map(|(kind, n)| ((*kind).to_owned(), (*n).into()));
        Self { name, solids, volume, relative, faces: serde_json::Value::Object(faces.collect()) }
    }
}

fn check_all(cases: &[Case], gap: f64) {
    let folder = Folder::new(cases[0].name);
    let files: Vec<PathBuf> = cases
        .iter()
        .map(|case| folder.write(&format!("{}.step", case.name), &case.solids, &StepOptions::default()))
        .collect();
    for (case, verdict) in cases.iter().zip(judge(&files)) {
        let name = case.name;
        assert_eq!(verdict["valid"], true, "{name}: {verdict}");
        assert_eq!(verdict["solids"], 1, "{name}: {verdict}");
        assert_eq!(verdict["faces"], case.faces, "{name}: {verdict}");
        let volume = verdict["volume"].as_f64().unwrap();
        assert!(
            (volume / case.volume - 1.0).abs() <= case.relative,
            "{name}: {verdict}, not {}",
            case.volume
        );
        let healed = verdict["gap"].as_f64().unwrap();
        assert!(healed <= gap, "{name}: gaps of {healed} were healed");
    }
}

/// Runs Open CASCADE on STEP files: one verdict per file.
pub fn judge(files: &[PathBuf]) -> Vec<serde_json::Value> {
    let crate_root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = std::env::var_os("SCANWRIGHT_PYTHON")
        .map_or_else(|| crate_root.join("../../.venv/bin/python"), PathBuf::from);
    let output =
        Command::new(&python).arg(crate_root.join("tests/occ.py")).args(files).output().unwrap_or_else(
            |error| panic!("{}: {error}; ./test.sh installs Open CASCADE there", python.display()),
        );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    // Open CASCADE prints progress of its own.
    let verdicts: Vec<serde_json::Value> =
        text.lines().filter(|l| l.starts_with('{')).map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(verdicts.len(), files.len(), "{text}");
    verdicts
}

/// A folder for the files of one test.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn write(&self, name: &str, solids: &[Solid], options: &StepOptions) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, write(solids, options)).unwrap();
        path
    }
}

/// The solids of a part.
fn of(part: &Part) -> Vec<Solid> {
    build(&part.labelled(), &tolerances(STEP)).solids
}
