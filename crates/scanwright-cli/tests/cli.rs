//! The command as a user meets it: exit codes, refusals, and files that appear together or not at all.

#[path = "cli/assemble.rs"]
mod assemble;
#[path = "cli/report.rs"]
mod report;

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;

#[path = "cli/check.rs"]
mod check;

#[test]
fn help_teaches_with_examples_and_exit_codes() {
    let top = text(&run(&["--help"]).stdout);
    let verbs = [
        "convert", "info", "segment", "gprimdb", "classify", "train", "render", "report", "check", "align",
        "assemble", "selftest",
    ];
    for verb in verbs {
        assert!(top.contains(verb), "`--help` does not name {verb}:\n{top}");
    }
    let convert = text(&run(&["convert", "--help"]).stdout);
    for needed in ["Examples:", "Exit codes:", "--units", "--allow", "130"] {
        assert!(convert.contains(needed), "`convert --help` lacks {needed}:\n{convert}");
    }
}

#[test]
fn the_selftest_passes_and_prints_a_line_per_data_set() {
    let output = run(&["selftest"]);
    check_exit(&output, 0, &["selftest"]);
    let text = text(&output.stdout);
    for kind in ["plane", "cylinder", "cone", "sphere", "torus"] {
        let lines = text.lines().filter(|line| line.starts_with(kind));
        assert!(lines.count() >= 4, "{text}");
    }
    assert!(text.ends_with("all within\n"), "{text}");
}

#[test]
fn senseless_command_lines_exit_2() {
    let dir = Folder::new();
    let scan = dir.scan("box.ply");
    let scan = scan.to_str().unwrap();
    for args in [
        vec![],
        vec!["convert"],
        vec!["convert", scan],
        vec!["convert", scan, "-o", "x.step", "--units", "parsec"],
        vec!["convert", scan, "-o", "x.step", "--up", "0,0,0"],
        vec!["convert", scan, "-o", "x.step", "--tolerance", "-1"],
        vec!["convert", scan, "-o", "x.step", "--threads", "0"],
        vec!["convert", scan, "-o", "x.step", "--strict", "--allow", "open"],
        vec!["convert", scan, "-o", scan, "--force"],
        vec!["convert", scan, "-o", "same.step", "--json", "./same.step"],
    ] {
        check_exit(&dir.run(&args), 2, &args);
    }
    assert_eq!(dir.names(), ["box.ply"]);
}

#[test]
fn unreadable_scans_exit_3_with_one_line_and_no_files() {
    let dir = Folder::new();
    let points_only = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
                       end_header\n0 0 0\n";
    let not_a_number = box_ply(1).replacen("end_header\n", "end_header\nnan 0 0\n", 1);
    let flat = "OFF\n3 1 0\n0 0 0\n1 1 1\n2 2 2\n3 0 1 2\n";
    let truncated: String = box_ply(1).chars().take(900).collect();
    let files = [
        ("empty.stl", ""),
        ("points.ply", points_only),
        ("nan.ply", &not_a_number),
        ("flat.off", flat),
        ("truncated.ply", &truncated),
        ("noise.ply", "no scan at all"),
    ];
    for (name, content) in files {
        fs::write(dir.path(name), content).unwrap();
    }
    let before = dir.names();
    for name in before.iter().map(String::as_str).chain(["missing.stl"]) {
        let args = ["convert", name, "-o", "part.step", "--json", "out/part.json"];
        let output = dir.run(&args);
        check_exit(&output, 3, &args);
        let message = text(&output.stderr);
        assert_eq!(message.lines().count(), 1, "{name}: {message}");
        assert!(message.contains(name), "{name}: {message}");
        check_exit(&dir.run(&["info", name]), 3, &["info", name]);
        check_exit(
            &dir.run(&["render", name, "-o", "x.png"]),
            if name == "flat.off" { 0 } else { 3 },
            &[name],
        );
        let _ = fs::remove_file(dir.path("x.png"));
    }
    assert_eq!(dir.names(), before);
}

#[test]
fn outputs_that_exist_are_refused_before_any_work() {
    let dir = Folder::new();
    // The scan cannot be read; that this is not the complaint shows that it was not looked at.
    fs::write(dir.path("bad.stl"), "").unwrap();
    fs::write(dir.path("part.json"), "precious").unwrap();
    fs::create_dir(dir.path("folder.step")).unwrap();
    let args = ["convert", "bad.stl", "-o", "part.step", "--json", "part.json"];
    check_exit(&dir.run(&args), 5, &args);
    let args = ["convert", "bad.stl", "-o", "folder.step", "--force"];
    check_exit(&dir.run(&args), 5, &args);
    let args = ["convert", "bad.stl", "-o", "part.json/part.step"];
    check_exit(&dir.run(&args), 5, &args);
    assert_eq!(fs::read_to_string(dir.path("part.json")).unwrap(), "precious");
    assert_eq!(dir.names(), ["bad.stl", "folder.step", "part.json"]);
}

#[test]
fn outputs_appear_together_and_force_overwrites() {
    let dir = Folder::new();
    dir.scan("box.ply");
    fs::write(dir.path("part.json"), "old").unwrap();
    let output = dir.run(&[
        "convert",
        "box.ply",
        "-o",
        "out/deep/part.step",
        "--json",
        "part.json",
        "--segments",
        "segments.ply",
        "--timings",
        "timings.json",
        "--force",
    ]);
    check_finished(&output);
    assert_eq!(dir.names(), ["box.ply", "out", "part.json", "segments.ply", "timings.json"]);
    assert!(dir.path("out/deep/part.step").is_file());
    let json: serde_json::Value = serde_json::from_slice(&fs::read(dir.path("part.json")).unwrap()).unwrap();
    assert_eq!(json["schema"], "scanwright/result/1");
    assert_eq!(json["units"]["source"], "assumed");
    assert!(text(&output.stdout).contains("mm assumed"), "{}", text(&output.stdout));
    let timings: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.path("timings.json")).unwrap()).unwrap();
    assert!(timings["total_seconds"].as_f64().unwrap() > 0.0);
}

#[test]
fn a_box_has_six_planes_and_every_triangle_one_of_them() {
    let dir = Folder::new();
    dir.scan("box.ply");
    let output = dir.run(&[
        "convert",
        "box.ply",
        "-o",
        "part.step",
        "--json",
        "part.json",
        "--segments",
        "s.ply",
        "--support",
        "none",
    ]);
    check_finished(&output);
    let json: serde_json::Value = serde_json::from_slice(&fs::read(dir.path("part.json")).unwrap()).unwrap();
    let primitives = json["primitives"].as_array().unwrap();
    let types: Vec<_> = primitives.iter().map(|p| p["type"].as_str().unwrap()).collect();
    assert_eq!(types, ["plane"; 6]);
    let in_json: u64 = primitives.iter().map(|p| p["triangles"].as_u64().unwrap()).sum();
    assert_eq!(in_json, json["scan"]["triangles"].as_u64().unwrap());
}

#[test]
fn faces_are_judged_against_the_uncertainty_that_is_needed() {
    let dir = Folder::new();
    dir.scan("box.ply");
    for (target, n_enough) in [("1000", 6), ("1e-30", 0)] {
        let args =
            ["convert", "box.ply", "-o", "box.step", "--json", "box.json", "--target", target, "--force"];
        let output = dir.run(&args);
        check_exit(&output, 0, &args);
        let said = text(&output.stdout);
        assert!(said.contains(&format!("{n_enough} of 6 faces have sizes")), "{said}");
        let json: serde_json::Value =
            serde_json::from_slice(&fs::read(dir.path("box.json")).unwrap()).unwrap();
        for primitive in json["primitives"].as_array().unwrap() {
            assert_eq!(primitive["sufficiency"]["missing"].is_null(), n_enough == 6, "{primitive}");
        }
    }
}

#[test]
fn a_box_as_a_script_is_one_extrusion() {
    let dir = Folder::new();
    dir.scan("box.ply");
    let output = dir.run(&["convert", "box.ply", "-o", "part.step", "--script", "part.py"]);
    check_finished(&output);
    let summary = text(&output.stdout);
    assert!(
        summary.lines().any(|l| l.starts_with("script") && l.contains("6 of 6 faces by 1 feature")),
        "{summary}"
    );
    let script = fs::read_to_string(dir.path("part.py")).unwrap();
    assert_eq!(script.matches("extrude(Plane.XY").count(), 1, "{script}");
    assert!(!script.contains("# Not expressed") && script.contains("  # +- "), "{script}");
    let args = ["convert", "box.ply", "-o", "x.step", "--script", "x.py", "--pipeline", "thesis"];
    check_exit(&dir.run(&args), 2, &args);
    let args = ["convert", "box.ply", "-o", "x.step", "--script", "part.py"];
    check_exit(&dir.run(&args), 5, &args);
}

#[test]
fn quiet_says_nothing() {
    let dir = Folder::new();
    dir.scan("box.ply");
    let output = dir.run(&["convert", "box.ply", "-o", "part.step", "--quiet"]);
    check_finished(&output);
    assert_eq!((text(&output.stdout).as_str(), text(&output.stderr).as_str()), ("", ""));
}

#[test]
fn results_are_the_same_bytes_from_one_and_two_threads_and_two_runs() {
    let dir = Folder::new();
    dir.scan("box.ply");
    fs::write(dir.path("ring.ply"), ring_ply()).unwrap();
    let outputs = ["part.step", "part.json", "segments.ply", "part.png"];
    let convert = |scan: &str, threads: &str| {
        let files =
            ["-o", outputs[0], "--json", outputs[1], "--segments", outputs[2], "--picture", outputs[3]];
        let output = dir.run(&[&["convert", scan, "--threads", threads, "--force"], &files[..]].concat());
        check_finished(&output);
        let files = outputs.map(|name| fs::read(dir.path(name)).unwrap());
        (files, text(&output.stdout))
    };
    for scan in ["box.ply", "ring.ply"] {
        let first = convert(scan, "1");
        for threads in ["1", "2"] {
            let again = convert(scan, threads);
            for (i, name) in outputs.iter().enumerate() {
                assert!(again.0[i] == first.0[i], "{name} of {scan} differs with {threads} threads");
            }
            assert_eq!(again.1, first.1);
        }
    }
}

#[test]
fn strict_writes_nothing_when_something_fell_back() {
    let dir = Folder::new();
    // Two thirds of a sheet torn at random: no closed solid has this as its surface.
    fs::write(dir.path("torn.ply"), torn_sheet_ply()).unwrap();
    let args = ["convert", "torn.ply", "-o", "part.step", "--strict", "--support", "none"];
    check_exit(&dir.run(&args), 4, &args);
    assert_eq!(dir.names(), ["torn.ply"]);
}

#[test]
fn pictures_are_png_and_colors_need_regions() {
    let dir = Folder::new();
    dir.scan("box.ply");
    check_exit(&dir.run(&["render", "box.ply", "-o", "scan.png"]), 0, &["render"]);
    let bytes = fs::read(dir.path("scan.png")).unwrap();
    assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"));
    let args = ["render", "box.ply", "-o", "regions.png", "--color", "region"];
    check_exit(&dir.run(&args), 3, &args);
    check_finished(&dir.run(&[
        "convert",
        "box.ply",
        "-o",
        "p.step",
        "--segments",
        "p.ply",
        "--json",
        "p.json",
    ]));
    for color in ["type", "region"] {
        let args = ["render", "p.ply", "-o", "regions.png", "--color", color, "--force"];
        check_exit(&dir.run(&args), 0, &args);
    }
    assert!(fs::read(dir.path("regions.png")).unwrap() != bytes);
}

#[test]
fn segment_gives_a_box_its_six_faces() {
    let dir = Folder::new();
    fs::write(dir.0.join("fine.ply"), box_ply(24)).unwrap();
    fs::write(dir.0.join("coarse.ply"), box_ply(4)).unwrap();
    // In the fine one noise is half the spacing: too much for some.
    for (scan, methods) in
        [("fine.ply", ["default", "ncuts"].as_slice()), ("coarse.ply", &["pic", "hfp", "liu-zhang", "xiao"])]
    {
        for &method in methods {
            let mut args = vec!["segment", scan, "-o", "regions.ply", "--method", method, "--force"];
            if !["default", "xiao"].contains(&method) {
                args.extend(["--regions", "6"]);
            }
            let output = dir.run(&args);
            check_exit(&output, 0, &args);
            assert!(text(&output.stdout).contains("6: 6 plane"), "{method}: {}", text(&output.stdout));
        }
    }
    let args = ["segment", "fine.ply", "-o", "x.ply", "--regions", "6"];
    check_exit(&dir.run(&args), 2, &args);
    let args = ["segment", "coarse.ply", "-o", "x.ply", "--method", "xiao", "--regions", "6"];
    check_exit(&dir.run(&args), 2, &args);
    let args = ["segment", "coarse.ply", "-o", "x.ply", "--method", "hfp", "--nodes", "vertices"];
    check_exit(&dir.run(&args), 2, &args);
}

#[test]
fn clean_takes_noise_off_a_box() {
    let dir = Folder::new();
    fs::write(dir.0.join("box.ply"), box_ply(8)).unwrap();
    let rms = |name: &str| {
        let vertices = scanwright::io::read_mesh_file(&dir.0.join(name)).unwrap().mesh.vertices;
        let off = |p: &[f64; 3]| {
            let sides =
                [24.0, 18.0, 12.0].into_iter().zip(p).flat_map(|(size, x)| [x.abs(), (x - size).abs()]);
            sides.fold(f64::INFINITY, f64::min)
        };
        let sum: f64 = vertices.iter().map(|p| off(&[p.x, p.y, p.z]).powi(2)).sum();
        (sum / vertices.len() as f64).sqrt()
    };
    let raw = rms("box.ply");
    for method in ["adaptive", "sun2007", "random-walk", "bilateral", "guided", "none"] {
        let args = ["clean", "box.ply", "-o", "clean.ply", "--denoise", method, "--force"];
        check_exit(&dir.run(&args), 0, &args);
        let left = rms("clean.ply") / raw;
        assert!(if method == "none" { (left - 1.0).abs() < 1e-6 } else { left < 0.7 }, "{method}: {left:.2}");
    }
    let args =
        ["clean", "box.ply", "-o", "clean.ply", "--denoise", "guided", "--neighbors", "edge", "--force"];
    check_exit(&dir.run(&args), 2, &args);
}

#[test]
fn more_vertices_than_eigenvectors_fit_for_are_refused() {
    let dir = Folder::new();
    fs::write(dir.0.join("fine.ply"), box_ply(10)).unwrap();
    // 2 GiB hold 3 066 vectors of 87 552 vertices; the box has 187 202.
    let args =
        ["segment", "fine.ply", "-o", "x.ply", "--method", "pic", "--nodes", "vertices", "--regions", "500"];
    let output = dir.run(&args);
    check_exit(&output, 3, &args);
    assert!(text(&output.stderr).contains("group patches instead"), "{}", text(&output.stderr));
    assert!(!dir.0.join("x.ply").exists());
}

#[test]
fn gprimdb_makes_shows_exports_and_its_models_are_classified() {
    let dir = Folder::new();
    let manifest = text(&dir.run(&["gprimdb", "manifest"]).stdout).replace("count = 200", "count = 4");
    fs::write(dir.0.join("small.toml"), &manifest).unwrap();
    let steps: [&[&str]; 4] = [
        &["gprimdb", "generate", "--manifest", "small.toml", "-o", "small.db"],
        &["gprimdb", "info", "small.db"],
        &["gprimdb", "show", "small.db", "sphere-0001-00"],
        &["gprimdb", "export", "small.db", "sphere-0001-00", "-o", "sphere.ply"],
    ];
    for args in steps {
        check_exit(&dir.run(args), 0, args);
    }
    let output = dir.run(&["classify", "sphere.ply"]);
    check_exit(&output, 0, &["classify"]);
    for named in ["type         sphere", "surfaces     sphere"] {
        assert!(text(&output.stdout).contains(named), "{}", text(&output.stdout));
    }
    let args = ["train", "small.db", "-o", "small.svm"];
    let output = dir.run(&args);
    check_exit(&output, 3, &args);
    assert!(text(&output.stderr).contains("10 shapes each"), "{}", text(&output.stderr));

    let wrong = manifest.replace("truncation = [0.0, 0.95]", "truncation = [0.0, 1.5]");
    fs::write(dir.0.join("wrong.toml"), wrong).unwrap();
    let args = ["gprimdb", "generate", "--manifest", "wrong.toml", "-o", "wrong.db"];
    let output = dir.run(&args);
    check_exit(&output, 3, &args);
    assert!(text(&output.stderr).contains("ranges.truncation"), "{}", text(&output.stderr));
    assert!(!dir.0.join("wrong.db").exists());
}

#[test]
fn what_was_added_is_found_again() {
    let dir = Folder::new();
    let part = r#"{"primitives": [
        {"id": 0, "type": "plane"},
        {"id": 4, "type": "cylinder", "radius": 6.003,
         "parameters": ["offset_x", "offset_y", "tilt_x", "tilt_y", "radius"],
         "uncertainty": [0.1, 0.1, 0.1, 0.1, 0.004]}]}"#;
    fs::write(dir.path("part.json"), part).unwrap();
    let add = [
        "gprimdb",
        "add",
        "shop.db",
        "part.json",
        "--primitive",
        "4",
        "--name",
        "pin",
        "--provenance",
        "a test",
    ];
    let output = dir.run(&add);
    check_exit(&output, 0, &add);
    assert!(text(&output.stdout).contains("radius 6.0030 +- 0.0040"), "{}", text(&output.stdout));
    let query = |radius: &str| {
        fs::write(dir.path("other.json"), part.replace("6.003", radius)).unwrap();
        let args = ["gprimdb", "query", "shop.db", "other.json", "--primitive", "4"];
        let output = dir.run(&args);
        check_exit(&output, 0, &args);
        text(&output.stdout)
    };
    assert!(query("6.01").contains("pin: radius 6.0030"));
    assert!(query("6.1").contains("nothing known"));
    for id in ["0", "7"] {
        let args = ["gprimdb", "query", "shop.db", "part.json", "--primitive", id];
        check_exit(&dir.run(&args), 3, &args);
    }
}

#[test]
fn what_a_database_knows_is_named_and_taken() {
    let dir = Folder::new();
    let manifest = text(&dir.run(&["gprimdb", "manifest"]).stdout).replace("count = 200", "count = 2");
    fs::write(dir.path("small.toml"), &manifest).unwrap();
    let convert = ["convert", "ball.ply", "-o", "ball.step", "--json", "ball.json", "--force"];
    let add = ["gprimdb", "add", "shop.db", "ball.json", "--primitive", "0", "--name", "marble"];
    let with_shop = [&convert[..], &["--database", "shop.db"]].concat();
    let taking = [&with_shop[..], &["--known", "take"]].concat();
    let steps: [&[&str]; 5] = [
        &["gprimdb", "generate", "--manifest", "small.toml", "-o", "small.db"],
        &["gprimdb", "export", "small.db", "sphere-0001-00", "-o", "ball.ply"],
        &convert,
        &[&add[..], &["--provenance", "a test"]].concat(),
        &with_shop,
    ];
    for args in steps {
        check_exit(&dir.run(args), 0, args);
    }
    let json = |dir: &Folder| -> serde_json::Value {
        serde_json::from_str(&fs::read_to_string(dir.path("ball.json")).unwrap()).unwrap()
    };
    let measured = json(&dir)["primitives"][0]["radius"].as_f64().unwrap();
    assert_eq!(json(&dir)["known"][0]["name"], "marble");
    assert_eq!(json(&dir)["known"][0]["taken"], false);
    // Another radius within the uncertainty is taken as it is stored.
    let mut part = json(&dir);
    let near = measured * (1.0 + 1e-3);
    part["primitives"][0]["radius"] = near.into();
    part["primitives"][0]["uncertainty"] = vec![measured * 1e-3; 4].into();
    fs::write(dir.path("ball.json"), part.to_string()).unwrap();
    check_exit(&dir.run(steps[3]), 0, steps[3]);
    let output = dir.run(&taking);
    check_exit(&output, 0, &taking);
    assert!(text(&output.stdout).contains("its sizes were taken"), "{}", text(&output.stdout));
    assert_eq!(json(&dir)["primitives"][0]["radius"].as_f64(), Some(near));
    check_exit(&dir.run(&[&convert[..], &["--known", "take"]].concat()), 2, &["--known alone"]);
}

#[test]
fn the_thesis_draws_primitives_one_by_one() {
    let dir = Folder::new();
    dir.scan("box.ply");
    let args = ["convert", "box.ply", "-o", "box.step", "--json", "box.json", "--pipeline", "thesis"];
    let output = dir.run(&args);
    check_exit(&output, 0, &args);
    assert!(text(&output.stdout).contains("6 planes"), "{}", text(&output.stdout));
    let step = fs::read_to_string(dir.path("box.step")).unwrap();
    assert_eq!(step.matches("=ADVANCED_FACE(").count(), 6);
    assert_eq!(step.matches("=OPEN_SHELL(").count(), 6);
}

#[test]
fn info_counts_and_guesses_the_unit() {
    let dir = Folder::new();
    dir.scan("box.ply");
    let output = dir.run(&["info", "box.ply"]);
    check_exit(&output, 0, &["info"]);
    let said = text(&output.stdout);
    for needed in ["PLY", "the mesh is closed", "noise", "likely mm"] {
        assert!(said.contains(needed), "{said}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_nothing_behind() {
    let dir = Folder::new();
    fs::write(dir.path("box.ply"), box_ply(8)).unwrap();
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("scanwright"))
        .args(["convert", "box.ply", "-o", "out/part.step", "--picture", "part.png"])
        .current_dir(&dir.0)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    // Long enough for the handler to be there, far too short for the run to end.
    std::thread::sleep(std::time::Duration::from_millis(300));
    let pid = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(dir.names(), ["box.ply"]);
}

/// A folder that goes away with its test.
struct Folder(PathBuf, #[expect(dead_code, reason = "removes the folder when dropped")] tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        Self(dir.path().to_owned(), dir)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes the scan of a box.
    fn scan(&self, name: &str) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, box_ply(1)).unwrap();
        path
    }

    fn run(&self, args: &[&str]) -> Output {
        command(&self.0).args(args).output().unwrap()
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> =
            entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

fn command(dir: &Path) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("scanwright"));
    command.current_dir(dir);
    command
}

fn run(args: &[&str]) -> Output {
    command(Path::new(".")).args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn check_exit(output: &Output, expected: i32, args: &[&str]) {
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(expected), "{args:?}: {said}");
}

/// Whether a run came to its end, with or without fallbacks.
fn check_finished(output: &Output) {
    assert!(matches!(output.status.code(), Some(0 | 4)), "{:?}: {}", output.status, text(&output.stderr));
}

/// A noisy closed box of 24 x 18 x 12, `fineness` vertices per unit.
fn box_ply(fineness: usize) -> String {
    let size = [24 * fineness, 18 * fineness, 12 * fineness];
    let mut index = std::collections::BTreeMap::new();
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0, size[axis]] {
            for i in 0..size[u] {
                for j in 0..size[v] {
                    let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| {
                        let mut p = [0; 3];
                        (p[axis], p[u], p[v]) = (side, i + di, j + dj);
                        *index.entry(p).or_insert_with(|| {
                            vertices.push(p);
                            vertices.len() - 1
                        })
                    });
                    let [a, b, c, d] = corners;
                    // Counter-clockwise seen from outside.
                    let quad = if side == 0 { [a, d, c, b] } else { [a, b, c, d] };
                    triangles.push([quad[0], quad[1], quad[2]]);
                    triangles.push([quad[0], quad[2], quad[3]]);
                }
            }
        }
    }
    let mut noise = Noise(1);
    let points = vertices.iter().map(|p| p.map(|c| c as f64 / fineness as f64 + 0.02 * noise.next()));
    ply(&points.collect::<Vec<_>>(), &triangles)
}

/// A noisy ring with a chamfer: planes, cylinders and a cone.
fn ring_ply() -> String {
    const N: usize = 100;
    let outline = [(9.0, 0.0), (16.0, 0.0), (16.0, 8.0), (12.0, 12.0), (9.0, 12.0)];
    let mut profile = Vec::new();
    for (k, &(r0, z0)) in outline.iter().enumerate() {
        let (r1, z1): (f64, f64) = outline[(k + 1) % outline.len()];
        let n = (r1 - r0).hypot(z1 - z0).round() as usize;
        profile.extend((0..n).map(|i| i as f64 / n as f64).map(|t| (r0 + t * (r1 - r0), z0 + t * (z1 - z0))));
    }
    let mut noise = Noise(3);
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for j in 0..N {
        let (sin, cos) = (std::f64::consts::TAU * j as f64 / N as f64).sin_cos();
        for (i, (r, z)) in profile.iter().enumerate() {
            points.push([r * cos, r * sin, *z].map(|c| c + 0.03 * noise.next()));
            let at = |j: usize, i: usize| (j % N) * profile.len() + i % profile.len();
            let [a, b, c, d] = [at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    ply(&points, &triangles)
}

/// A bent sheet with a ragged border.
fn torn_sheet_ply() -> String {
    const N: usize = 40;
    let mut noise = Noise(2);
    let mut points = Vec::new();
    for i in 0..N {
        for j in 0..N {
            let (x, y) = (i as f64, j as f64);
            points.push([x, y, 3.0 * (0.2 * x).sin() * (0.17 * y).cos() + 0.02 * noise.next()]);
        }
    }
    let mut triangles = Vec::new();
    for i in 0..N - 1 {
        for j in 0..N - 1 {
            let [a, b, c, d] = [i * N + j, (i + 1) * N + j, (i + 1) * N + j + 1, i * N + j + 1];
            let torn = (i == 0 || j == 0) && noise.next() > 0.0;
            if !torn {
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    ply(&points, &triangles)
}

fn ply(points: &[[f64; 3]], triangles: &[[usize; 3]]) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        triangles.len()
    );
    for [x, y, z] in points {
        writeln!(text, "{x} {y} {z}").unwrap();
    }
    for [a, b, c] in triangles {
        writeln!(text, "3 {a} {b} {c}").unwrap();
    }
    text
}

/// Roughly normal numbers of deviation one, the same every time.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        // A sum of twelve uniforms has variance one.
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    /// D. Knuth's MMIX generator.
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
