//! `check` and `align` as a user meets them.

use std::fs;

use super::{Folder, check_exit, text};

#[test]
fn a_box_passes_against_its_own_solid_and_fails_against_a_shorter_one() {
    let dir = Folder::new();
    dir.scan("box.ply");
    check_exit(&dir.run(&["convert", "box.ply", "-o", "box.step"]), 0, &["convert"]);

    let all = [
        "check",
        "box.step",
        "box.ply",
        "--tolerance",
        "0.5",
        "--json",
        "c.json",
        "--ply",
        "c.ply",
        "--picture",
        "c.png",
        "--csv",
        "c.csv",
        "--update",
        "u.json",
    ];
    let output = dir.run(&all);
    check_exit(&output, 0, &all);
    let said = text(&output.stdout);
    assert!(said.contains("verdict    pass"), "{said}");

    let json: serde_json::Value = serde_json::from_slice(&fs::read(dir.path("c.json")).unwrap()).unwrap();
    assert_eq!(json["schema"], "scanwright/check/1");
    assert_eq!(json["verdict"], "pass");
    assert_eq!(json["alignment"]["free"], serde_json::Value::Null);
    let faces = json["faces"].as_array().unwrap();
    assert!(
        faces.len() == 6 && faces.iter().all(|f| f["state"] == "seen" && f["seen"].as_f64().unwrap() > 0.95)
    );
    assert_eq!(json["changes"], serde_json::json!([]));
    assert!(fs::read(dir.path("c.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(
        String::from_utf8_lossy(&fs::read(dir.path("c.ply")).unwrap()[..400])
            .contains("property float deviation")
    );
    // A line per face and number: mean, position, orientation and flatness of six planes, and the head.
    assert_eq!(fs::read_to_string(dir.path("c.csv")).unwrap().lines().count(), 25);
    let update: serde_json::Value = serde_json::from_slice(&fs::read(dir.path("u.json")).unwrap()).unwrap();
    assert_eq!(update["faces"].as_array().unwrap().len(), 6);

    // No box keeps a thousandth of the noise for certain.
    let tight = ["check", "box.step", "box.ply", "--tolerance", "0.0001", "-q"];
    check_exit(&dir.run(&tight), 4, &tight);
    let datum =
        ["check", "box.step", "box.ply", "--align", "datum", "--tolerance", "0.5", "--json", "d.json"];
    check_exit(&dir.run(&datum), 0, &datum);
    let json: serde_json::Value = serde_json::from_slice(&fs::read(dir.path("d.json")).unwrap()).unwrap();
    assert_eq!(json["alignment"]["datums"].as_array().unwrap().len(), 3);
}

#[test]
fn a_mesh_against_itself_deviates_by_nothing() {
    let dir = Folder::new();
    dir.scan("box.ply");
    let args = ["check", "box.ply", "box.ply", "--json", "c.json"];
    fs::copy(dir.path("box.ply"), dir.path("model.ply")).unwrap();
    let args = args.map(|a| if a == "box.ply" { "model.ply" } else { a });
    check_exit(&dir.run(&args), 0, &args);
    let json: serde_json::Value = serde_json::from_slice(&fs::read(dir.path("c.json")).unwrap()).unwrap();
    let rms = json["deviation"]["rms"].as_f64().unwrap();
    assert!(rms < 1e-9, "{rms}");
}

#[test]
fn senseless_checks_are_refused() {
    let dir = Folder::new();
    dir.scan("box.ply");
    fs::write(dir.path("broken.step"), "ISO-10303-21;\nHEADER;\n").unwrap();
    for (args, code) in [
        (vec!["check", "box.ply"], 2),
        (vec!["check", "box.ply", "box.ply", "--datums", "1"], 2),
        (vec!["check", "box.ply", "box.ply", "--update", "new.step"], 2),
        (vec!["check", "box.ply", "box.ply", "--tolerance", "0"], 2),
        (vec!["check", "box.ply", "box.ply", "--json", "box.ply"], 2),
        (vec!["check", "broken.step", "box.ply"], 3),
        (vec!["check", "missing.step", "box.ply"], 3),
        (vec!["check", "box.ply", "broken.step"], 3),
        (vec!["align", "box.ply", "-o", "a.ply", "--level", "0"], 2),
        (vec!["align", "box.ply", "-o", "a.ply", "--level", "0", "--rotate", "99"], 2),
        (vec!["align", "box.ply", "-o", "a.ply", "--auto", "--level", "0", "--rotate", "1"], 2),
    ] {
        check_exit(&dir.run(&args), code, &args);
    }
    assert_eq!(dir.names(), ["box.ply", "broken.step"]);
}

#[test]
fn align_and_convert_lay_a_box_on_its_datums_alike() {
    let dir = Folder::new();
    dir.scan("box.ply");
    let args = ["align", "box.ply", "-o", "a.ply", "--json", "a.json"];
    check_exit(&dir.run(&args), 0, &args);
    let aligned: serde_json::Value = serde_json::from_slice(&fs::read(dir.path("a.json")).unwrap()).unwrap();
    assert_eq!((&aligned["method"], &aligned["free_ways"]), (&"auto".into(), &0.into()));

    let args = ["convert", "box.ply", "-o", "box.step", "--json", "box.json", "--align", "auto"];
    check_exit(&dir.run(&args), 0, &args);
    let result: serde_json::Value = serde_json::from_slice(&fs::read(dir.path("box.json")).unwrap()).unwrap();
    let placement = &result["placement"];
    for i in 0..3 {
        for j in 0..4 {
            let (a, b) = (&placement["aligned_from_scan"][i][j], &aligned["aligned_from_scan"][i][j]);
            // Regularizing turns faces by less than the noise lets one see.
            assert!((a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 0.05, "{i} {j}: {a} and {b}");
        }
    }
    // The largest face is level with the box above it, and the origin in its two planes of symmetry.
    assert_eq!(placement["planes_of_symmetry"], 2);
    let planes: Vec<[f64; 4]> = result["primitives"].as_array().unwrap().iter().map(plane_of).collect();
    for (axis, half) in [(2, [0.0, 12.0]), (0, [-9.0, 9.0]), (1, [-12.0, 12.0])] {
        for (side, height) in [-1.0, 1.0].into_iter().zip(half) {
            let found =
                planes.iter().any(|p| (p[axis] - side).abs() < 0.01 && (p[3] - side * height).abs() < 0.1);
            assert!(found, "no plane {side} of axis {axis} at {height}: {planes:?}");
        }
    }
    assert!(planes.iter().all(|p| p[..3].iter().filter(|n| n.abs() > 0.999).count() == 1), "{planes:?}");
}

/// Normal and height along it of a plane of PART.json.
fn plane_of(primitive: &serde_json::Value) -> [f64; 4] {
    let numbers = |key: &str| -> Vec<f64> {
        primitive[key].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let (point, normal) = (numbers("point"), numbers("normal"));
    let height = point.iter().zip(&normal).map(|(p, n)| p * n).sum();
    [normal[0], normal[1], normal[2], height]
}
