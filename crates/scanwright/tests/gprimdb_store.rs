//! The database as a file: it goes on where it was stopped, refuses what it is not, and finds what is known.

use std::cell::Cell;

use scanwright::gprimdb::{Class, Database, DatabaseError, Manifest, Noise, Part, Split, Tier};

/// A manifest of 60 shapes of each type, two copies each: more models than one transaction holds.
fn manifest() -> Manifest {
    let mut manifest = Manifest::of_tier(Tier::Faithful);
    for shapes in &mut manifest.shapes {
        shapes.count = 60;
    }
    Manifest { copies: 2, resolutions: vec![8], noises: Noise::all(), ..manifest }
}

fn go_on(_: usize, _: usize) -> bool {
    true
}

/// All rows of the table of models, as text.
fn dump(path: &std::path::Path) -> Vec<String> {
    let connection = rusqlite::Connection::open(path).unwrap();
    let mut rows = connection
        .prepare("SELECT number, name, split, triangles, checksum, truth, hex(descriptor) FROM models ORDER BY number")
        .unwrap();
    let row = |row: &rusqlite::Row<'_>| {
        let (number, triangles): (i64, i64) = (row.get(0)?, row.get(3)?);
        let words: Vec<String> = [1, 2, 4, 5, 6].into_iter().map(|k| row.get(k)).collect::<Result<_, _>>()?;
        Ok(format!("{number} {triangles} {}", words.join(" ")))
    };
    rows.query_map([], row).unwrap().collect::<Result<_, _>>().unwrap()
}

#[test]
fn a_run_that_was_stopped_goes_on_to_the_same_database() {
    let dir = tempfile::tempdir().unwrap();
    let (whole, stopped) = (dir.path().join("whole.db"), dir.path().join("stopped.db"));
    Database::open_or_create(&whole).unwrap().generate(&manifest(), &go_on).unwrap();

    let calls = Cell::new(0);
    let stop = |_: usize, _: usize| {
        calls.set(calls.get() + 1);
        calls.get() <= 1
    };
    let outcome = Database::open_or_create(&stopped).unwrap().generate(&manifest(), &stop);
    assert!(matches!(outcome, Err(DatabaseError::Cancelled(_))), "{outcome:?}");
    let n_first = Database::open(&stopped).unwrap().n_models().unwrap();
    assert!(0 < n_first && n_first < manifest().n_models(), "{n_first} models were written");
    Database::open_or_create(&stopped).unwrap().generate(&manifest(), &go_on).unwrap();

    assert_eq!(dump(&whole), dump(&stopped));
    assert_eq!(dump(&whole).len(), manifest().n_models());
}

#[test]
fn another_manifest_and_foreign_files_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.db");
    let mut database = Database::open_or_create(&path).unwrap();
    database.generate(&manifest(), &go_on).unwrap();
    let other = Manifest { seed: 3, ..manifest() };
    assert!(matches!(database.generate(&other, &go_on), Err(DatabaseError::OtherManifest)));

    let foreign = dir.path().join("foreign.db");
    rusqlite::Connection::open(&foreign).unwrap().execute_batch("CREATE TABLE notes (text TEXT)").unwrap();
    assert!(matches!(Database::open_or_create(&foreign), Err(DatabaseError::Foreign(0))));
    let text = dir.path().join("text.db");
    std::fs::write(&text, "no database, but longer than the header of one would be".repeat(4)).unwrap();
    assert!(matches!(Database::open(&text), Err(DatabaseError::Sqlite(_))));
}

#[test]
fn a_model_read_back_is_the_one_that_was_made() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.db");
    Database::open_or_create(&path).unwrap().generate(&manifest(), &go_on).unwrap();
    let database = Database::open(&path).unwrap();
    assert_eq!(database.manifest().unwrap(), Some(manifest()));
    let model = manifest().model(123);
    let entry = database.entry(&model.truth.name).unwrap().expect("it is there");
    assert_eq!(
        (entry.index, &entry.truth, entry.n_triangles),
        (123, &model.truth, model.mesh.triangles.len())
    );
    let of_splits = [Split::Train, Split::Validate, Split::Test].map(|s| database.of_split(s).unwrap().len());
    assert_eq!(of_splits.iter().sum::<usize>(), manifest().n_models(), "{of_splits:?}");
}

#[test]
fn what_is_known_is_found_within_its_uncertainty_and_nothing_else() {
    let dir = tempfile::tempdir().unwrap();
    let mut database = Database::open_or_create(&dir.path().join("a.db")).unwrap();
    database.generate(&manifest(), &go_on).unwrap();
    let part = |name: &str, radius: f64| Part {
        name: name.into(),
        provenance: "a test".into(),
        class: Class::Cylinder,
        sizes: vec![("radius".into(), radius)],
        uncertainties: vec![0.01],
    };
    database.add(&part("pin", 6.0)).unwrap();
    database.add(&part("shaft", 6.5)).unwrap();
    let found = |radius: f64, u: f64| -> Vec<String> {
        let query = database.query(Class::Cylinder, &[("radius".into(), radius)], &[u]).unwrap();
        query.into_iter().map(|m| m.name).filter(|name| ["pin", "shaft"].contains(&name.as_str())).collect()
    };
    // Three deviations of both, root of the sum of their squares: 0.042.
    assert_eq!(found(6.04, 0.01), ["pin"]);
    assert!(found(6.05, 0.01).is_empty());
    // A rough measurement may be either; the nearer comes first.
    assert_eq!(found(6.3, 0.2), ["shaft", "pin"]);
    database.add(&part("pin", 7.0)).unwrap();
    assert!(found(6.0, 0.01).is_empty(), "it was replaced");

    // A generated cylinder, known once though there are two copies of it.
    let truth = manifest().model(2 * 60 + 10).truth;
    assert_eq!(truth.class, Class::Cylinder);
    let radius = truth.parameter("radius").unwrap();
    let known = database.query(Class::Cylinder, &[("radius".into(), radius)], &[1e-9 * radius]).unwrap();
    assert_eq!(known.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), [truth.name.as_str()]);
}
