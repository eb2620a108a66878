//! `report`, and the document that `convert` writes.

use std::fs;

use super::{Folder, box_ply, check_exit, check_finished, text};

#[test]
fn one_run_gives_a_page_and_report_gives_it_again() {
    let dir = Folder::new();
    dir.scan("box.ply");
    let args = ["convert", "box.ply", "-o", "box.step", "--json", "box.json", "--segments", "s.ply"];
    check_finished(&dir.run(&[&args[..], &["--report", "run.html", "--support", "none"]].concat()));
    let page = fs::read_to_string(dir.path("run.html")).unwrap();
    // The box has six faces; two pictures of the scan, two of the part, six of the deviation.
    assert!(
        page.matches("<img src=\"data:image/png;base64,").count() >= 10,
        "{} pictures",
        page.matches("<img").count()
    );
    for id in 0..6 {
        assert!(page.contains(&format!("id=\"region-{id}\"")), "plane {id} has no row");
    }
    let json: serde_json::Value = serde_json::from_slice(&fs::read(dir.path("box.json")).unwrap()).unwrap();
    let hash = json["scan"]["source"]["sha256"].as_str().unwrap();
    assert_eq!(hash, scanwright::io::sha256(&fs::read(dir.path("box.ply")).unwrap()));
    assert!(page.contains(hash));

    // From files.
    let args =
        ["report", "box.json", "-o", "a.html", "--scan", "s.ply", "--model", "box.step", "--threads", "1"];
    check_exit(&dir.run(&args), 0, &args);
    let again = fs::read_to_string(dir.path("a.html")).unwrap();
    let without_pictures =
        |page: &str| page.split("<img").map(|p| p.split_once("/>").map_or(p, |p| p.1)).collect::<String>();
    let rows =
        |page: &str| without_pictures(page).split("<tr").skip(1).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(rows(&again), rows(&page), "other numbers");
    assert_eq!(again.matches("<img").count(), page.matches("<img").count(), "other pictures");
    let same =
        ["report", "box.json", "-o", "c.html", "--scan", "s.ply", "--model", "box.step", "--threads", "2"];
    check_exit(&dir.run(&same), 0, &same);
    assert!(fs::read(dir.path("a.html")).unwrap() == fs::read(dir.path("c.html")).unwrap(), "other bytes");
}

#[test]
fn pages_of_one_run_are_the_same_bytes_from_one_and_two_threads() {
    let dir = Folder::new();
    dir.scan("box.ply");
    let page = |threads: &str| {
        let args =
            ["convert", "box.ply", "-o", "x.step", "--report", "x.html", "--threads", threads, "--force"];
        check_finished(&dir.run(&args));
        fs::read(dir.path("x.html")).unwrap()
    };
    assert!(page("1") == page("2"));
}

#[test]
fn the_extension_says_what_a_document_is() {
    let dir = Folder::new();
    dir.scan("box.ply");
    let args = ["convert", "box.ply", "-o", "box.step", "--json", "box.json", "--report", "box.csv"];
    check_finished(&dir.run(&args));
    assert!(fs::read_to_string(dir.path("box.csv")).unwrap().starts_with("document,box,"));
    let args = ["report", "box.json", "-o", "box.md", "--name", "A *box*"];
    check_exit(&dir.run(&args), 0, &args);
    assert!(fs::read_to_string(dir.path("box.md")).unwrap().starts_with("# A \\*box\\*\n"));
    for output in ["box.pdf", "box"] {
        let args = ["report", "box.json", "-o", output];
        check_exit(&dir.run(&args), 2, &args);
        // Before any work: the scan is not even looked at.
        let args = ["convert", "missing.ply", "-o", "y.step", "--report", output];
        check_exit(&dir.run(&args), 2, &args);
    }
    let args = ["report", "box.json", "-o", "box.md"];
    check_exit(&dir.run(&args), 5, &args);
    let args = ["report", "box.json", "-o", "box.json", "--force"];
    check_exit(&dir.run(&args), 2, &args);
}

#[test]
fn what_is_no_result_and_scans_of_others_are_refused() {
    let dir = Folder::new();
    dir.scan("box.ply");
    check_finished(&dir.run(&["convert", "box.ply", "-o", "box.step", "--json", "box.json"]));
    fs::write(dir.path("other.ply"), box_ply(2)).unwrap();
    fs::write(dir.path("bad.json"), "{\n\"schema\": 1}").unwrap();
    let before = dir.names();
    for (args, expected) in [
        (vec!["bad.json"], "bad.json: line 2"),
        (vec!["missing.json"], "missing.json"),
        (vec!["box.ply"], "box.ply: line 1"),
        (vec!["box.json", "--scan", "other.ply"], "is not the scan of this result"),
        (vec!["box.json", "--scan", "missing.ply"], "missing.ply"),
        (vec!["box.json", "--model", "bad.json"], "bad.json"),
    ] {
        let args = [&["report", "-o", "x.html"], &args[..]].concat();
        let output = dir.run(&args);
        check_exit(&output, 3, &args);
        let said = text(&output.stderr);
        assert!(said.contains(expected) && said.lines().count() == 1, "{args:?}: {said}");
    }
    assert_eq!(dir.names(), before);
}
