//! The one-way data flow of `docs/architecture.md`, held by a test.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Modules by rank; a module may use only modules of a lower rank.
const RANKS: &[&[&str]] = &[
    &["math"],
    &["tolerance", "random", "par", "progress"],
    &["mesh", "surface"],
    &["io", "condition", "denoise", "fit", "prior"],
    &["recognize"],
    &["segment", "gprimdb"],
    &["uncertainty"],
    &["regularize", "datum"],
    &["brep", "dimension"],
    &["step", "deviation", "render"],
    &["pipeline", "script"],
    &["align", "report"],
    &["assemble", "check", "document"],
];

#[test]
fn modules_only_use_lower_ranks() {
    let mut violations = BTreeSet::new();
    let mut n_edges = 0;
    for (module, text) in sources(&source_root(), None) {
        let Some(rank) = rank_of(&module) else { continue };
        for used in text.split("crate::").skip(1) {
            let end = used.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(used.len());
            let used = &used[..end];
            n_edges += 1;
            if used != module && rank_of(used).is_none_or(|used_rank| rank <= used_rank) {
                violations.insert(format!("{module} uses {used}"));
            }
        }
    }
    assert!(0 < n_edges, "the scan found no `crate::` path; is it looking in the right folder?");
    assert!(violations.is_empty(), "{violations:#?}");
}

/// Words that have one home, and the modules that are it.
const HOMES: &[(&str, &[&str])] = &[
    ("rayon", &["par"]),
    ("rand_chacha", &["random"]),
    ("std::fs", &["io"]),
    ("std::env", &[]),
    ("std::time", &[]),
    ("std::thread", &[]),
    ("println!", &[]),
    ("eprint", &[]),
    ("dbg!", &[]),
];

#[test]
fn threads_randomness_files_and_clocks_have_one_home() {
    let mut violations = BTreeSet::new();
    for (module, text) in sources(&source_root(), None) {
        for (word, homes) in HOMES {
            let used =
                text.lines().map(str::trim_start).any(|line| !line.starts_with("//") && line.contains(word));
            if used && !homes.contains(&module.as_str()) {
                violations.insert(format!("{module} uses {word}"));
            }
        }
    }
    assert!(violations.is_empty(), "{violations:#?}");
}

#[test]
fn no_file_is_longer_than_800_lines() {
    let mut violations = Vec::new();
    for (module, text) in sources(&source_root(), None) {
        let n_lines = text.lines().count();
        if n_lines > 800 {
            violations.push(format!("a file of {module} has {n_lines} lines"));
        }
    }
    assert!(violations.is_empty(), "{violations:#?}");
}

#[test]
fn warning_codes_are_documented_under_their_written_names() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/output.md");
    let page = fs::read_to_string(page).unwrap();
    for code in scanwright::pipeline::Code::ALL {
        assert_eq!(serde_json::to_value(code).unwrap(), code.name());
        assert!(
            page.contains(&format!("`{}`", code.name())),
            "docs/output.md does not explain {}",
            code.name()
        );
    }
    let n_documented = page.matches("| `W_").count();
    assert_eq!(
        n_documented,
        scanwright::pipeline::Code::ALL.len(),
        "docs/output.md explains codes that are gone"
    );
}

#[test]
fn links_of_the_documentation_lead_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let docs = fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let pages: Vec<_> = docs
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .chain(["README.md", "CHANGELOG.md"].map(|name| root.join(name)))
        .collect();
    let (mut n_links, mut dead) = (0, Vec::new());
    for page in pages {
        let text = fs::read_to_string(&page).unwrap();
        for target in text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next()) {
            if target.is_empty() || target.contains("://") {
                continue;
            }
            n_links += 1;
            if !page.parent().unwrap().join(target).exists() {
                dead.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(n_links > 5, "only {n_links} links were found; is the test looking in the right folder?");
    assert!(dead.is_empty(), "{dead:#?}");
}

fn source_root() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

fn rank_of(module: &str) -> Option<usize> {
    RANKS.iter().position(|modules| modules.contains(&module))
}

/// Every source file with the top-level module it belongs to.
fn sources(dir: &Path, module: Option<&str>) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path()) {
        let stem = entry.file_stem().unwrap().to_string_lossy().into_owned();
        let name = module.unwrap_or(&stem).to_owned();
        if entry.is_dir() {
            found.extend(sources(&entry, Some(&name)));
        } else {
            found.push((name, fs::read_to_string(&entry).unwrap()));
        }
    }
    found
}
