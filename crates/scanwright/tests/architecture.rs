//! The one-way data flow of `docs/architecture.md`, held by a test.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Modules by rank; a module may use only modules of a lower rank.
const RANKS: &[&[&str]] = &[
    &["math"],
    &["tolerance", "random", "par", "progress"],
    &["mesh", "surface"],
    &["io", "condition", "denoise", "fit"],
    &["recognize"],
    &["segment"],
    &["regularize"],
    &["brep"],
    &["step", "deviation", "render"],
    &["pipeline"],
    &["report"],
];

#[test]
fn modules_only_use_lower_ranks() {
    let mut violations = BTreeSet::new();
    let mut n_edges = 0;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for (module, text) in sources(&root, None) {
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
