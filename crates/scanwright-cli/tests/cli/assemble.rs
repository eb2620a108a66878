//! `assemble`: what is placed, what is not, and what is refused.

use std::fs;

use super::{Folder, check_exit, ring_ply, text};

#[test]
fn a_part_that_is_there_is_written_and_one_that_is_not_is_told() {
    let dir = Folder::new();
    dir.scan("box.ply");
    fs::write(dir.path("ring.ply"), ring_ply()).unwrap();
    for name in ["box", "ring"] {
        let args =
            ["convert", &format!("{name}.ply"), "-o", &format!("{name}.step"), "--support", "none", "-q"];
        check_exit(&dir.run(&args), 0, &args);
    }
    let args = ["assemble", "ring.step", "--scan", "ring.ply", "-o", "one.step", "--support", "none"];
    let output = dir.run(&args);
    check_exit(&output, 0, &args);
    let told = text(&output.stdout);
    assert!(
        told.contains("ring") && told.contains("placed") && told.contains("open: its turn about"),
        "{told}"
    );

    let args = [
        "assemble",
        "ring.step",
        "box.step",
        "--scan",
        "ring.ply",
        "-o",
        "all.step",
        "--json",
        "all.json",
        "--support",
        "none",
        "--replace",
        "ring=box.step",
    ];
    let output = dir.run(&args);
    check_exit(&output, 4, &args);
    assert!(text(&output.stdout).contains("not placed: "), "{}", text(&output.stdout));
    let json: serde_json::Value = serde_json::from_slice(&fs::read(dir.path("all.json")).unwrap()).unwrap();
    let placed: Vec<bool> =
        json["parts"].as_array().unwrap().iter().map(|p| p["placed"].as_bool().unwrap()).collect();
    assert_eq!(placed, [true, false]);
    assert_eq!(json["parts"][0]["file"], "box.step");
    // The box is written where the ring was found.
    let all = fs::read_to_string(dir.path("all.step")).unwrap();
    assert_eq!(all.matches("=NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','ring',").count(), 1);
    let planes =
        |text: &str| (text.matches("=PLANE(").count(), text.matches("=CYLINDRICAL_SURFACE(").count());
    assert_eq!(planes(&all), planes(&fs::read_to_string(dir.path("box.step")).unwrap()));

    let args = ["assemble", "box.step", "--scan", "ring.ply", "-o", "none.step", "--support", "none"];
    let output = dir.run(&args);
    check_exit(&output, 3, &args);
    assert!(text(&output.stderr).contains("no part was placed; box: "), "{}", text(&output.stderr));
    assert!(!dir.path("none.step").exists());
}

#[test]
fn senseless_assemblies_are_refused_before_any_work() {
    let dir = Folder::new();
    dir.scan("box.ply");
    fs::write(dir.path("broken.step"), "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=PLANE('',#2").unwrap();
    for (code, args) in [
        (2, vec!["assemble", "--scan", "box.ply", "-o", "all.step"]),
        (2, vec!["assemble", "broken.step", "--scan", "box.ply", "-o", "all.step", "--replace", "broken"]),
        (2, vec!["assemble", "broken.step", "--scan", "box.ply", "-o", "broken.step", "--force"]),
        (
            2,
            vec![
                "assemble",
                "broken.step",
                "--scan",
                "box.ply",
                "-o",
                "a.step",
                "--replace",
                "x=n",
                "--replace",
                "x=m",
            ],
        ),
        (3, vec!["assemble", "gone.step", "--scan", "box.ply", "-o", "all.step"]),
        (3, vec!["assemble", "broken.step", "--scan", "box.ply", "-o", "all.step"]),
        (3, vec!["assemble", "box.ply", "--scan", "box.ply", "-o", "all.step"]),
    ] {
        let output = dir.run(&args);
        check_exit(&output, code, &args);
        if code == 3 {
            assert_eq!(text(&output.stderr).lines().count(), 1, "{}", text(&output.stderr));
        }
    }
    let told = text(&dir.run(&["assemble", "broken.step", "--scan", "box.ply", "-o", "all.step"]).stderr);
    assert!(told.contains("broken.step: line 5: the file ends inside an entity"), "{told}");
    assert_eq!(dir.names(), ["box.ply", "broken.step"]);
}
