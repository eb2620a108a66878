//! The database as a file: SQLite, so that anyone can open it.
//!
//! Three tables. `manifest`: the recipe, one row. `models`: one row per model, its truth as JSON and its descriptor.
//! `parts`: what was scanned and added. Meshes are not stored: the manifest makes them again. Rows are written in
//! transactions of some hundred, so that a run that is stopped has lost little and goes on where it was; readers wait for
//! one transaction at most. A rollback journal, not a write-ahead log: the database is one file.

use core::time::Duration;
use std::path::Path;

use rusqlite::{Connection, OpenFlags, OptionalExtension, params};
use serde::{Deserialize, Serialize};

use super::manifest::Manifest;
use super::model::{Split, Truth};
use super::shape::Class;
use crate::par;
use crate::progress::Cancelled;
use crate::recognize::gauss::{Accumulator, Cells, GaussImage, N_CELLS, Voting};

/// Marks the file as ours: "GPDB".
const APPLICATION_ID: i32 = 0x4750_4442;
/// Version of the tables.
const SCHEMA: i32 = 1;
/// How long one waits for another's transaction.
const PATIENCE: Duration = Duration::from_secs(10);
/// Models per transaction.
const BATCH: usize = 256;

/// A database of primitives.
#[derive(Debug)]
pub struct Database {
    connection: Connection,
}

/// Why a database cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatabaseError {
    /// SQLite says no.
    #[error(transparent)]
    Sqlite(#[from] rusqlite::Error),
    /// The file is something else.
    #[error("is no database of primitives: its application id is {0:#x}")]
    Foreign(i32),
    /// Another version of scanwright made it.
    #[error("has tables of version {found}, this program knows {SCHEMA}")]
    Schema {
        /// Its version.
        found: i32,
    },
    /// The database was begun with another manifest.
    #[error("was made from another manifest; a new file is needed")]
    OtherManifest,
    /// What is stored cannot be read.
    #[error("model `{name}` cannot be read: {reason}")]
    Broken {
        /// The model.
        name: String,
        /// Why.
        reason: String,
    },
    /// The caller said stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A row of the database.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Its place in the manifest.
    pub index: usize,
    /// What is known of it.
    pub truth: Truth,
    /// Triangles of its mesh.
    pub n_triangles: usize,
    /// See [`super::Model::checksum`].
    pub checksum: String,
    /// Gsh+s: the sorted histogram, then the skewness.
    pub descriptor: Vec<f32>,
}

/// Something that was scanned, verified by whoever added it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its name: unique.
    pub name: String,
    /// Where it comes from: file, date, who verified it.
    pub provenance: String,
    /// Its type.
    pub class: Class,
    /// Its sizes by name: radii and half-angle; millimetres and radians.
    pub sizes: Vec<(String, f64)>,
    /// Standard uncertainty of each size.
    pub uncertainties: Vec<f64>,
}

/// Something known that is like what was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Match {
    /// Its name in the database.
    pub name: String,
    /// Its sizes by name.
    pub sizes: Vec<(String, f64)>,
    /// Root mean square difference of the sizes in standard uncertainties.
    pub deviations: f64,
}

impl Database {
    /// Opens a database to read and write; makes it when there is none.
    pub fn open_or_create(path: &Path) -> Result<Self, DatabaseError> {
        let connection = Connection::open(path)?;
        let id: i32 = connection.query_row("PRAGMA application_id", [], |row| row.get(0))?;
        let n_tables: i64 =
            connection.query_row("SELECT count(*) FROM sqlite_master", [], |row| row.get(0))?;
        if n_tables == 0 {
            connection.execute_batch(&format!(
                "PRAGMA application_id = {APPLICATION_ID};
                 PRAGMA user_version = {SCHEMA};
                 BEGIN;
                 CREATE TABLE manifest (text TEXT NOT NULL);
                 CREATE TABLE models (
                     number INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, class TEXT NOT NULL,
                     split TEXT NOT NULL, partial INTEGER NOT NULL, triangles INTEGER NOT NULL,
                     checksum TEXT NOT NULL, truth TEXT NOT NULL, descriptor BLOB NOT NULL);
                 CREATE INDEX models_by_class ON models (class, split);
                 CREATE TABLE parts (
                     name TEXT PRIMARY KEY, class TEXT NOT NULL, provenance TEXT NOT NULL, part TEXT NOT NULL);
                 COMMIT;"
            ))?;
        } else {
            check(&connection, id)?;
        }
        connection.busy_timeout(PATIENCE)?;
        Ok(Self { connection })
    }

    /// Opens a database to read.
    pub fn open(path: &Path) -> Result<Self, DatabaseError> {
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(path, flags)?;
        let id: i32 = connection.query_row("PRAGMA application_id", [], |row| row.get(0))?;
        check(&connection, id)?;
        connection.busy_timeout(PATIENCE)?;
        Ok(Self { connection })
    }

    /// Its manifest; `None` when only parts were added.
    pub fn manifest(&self) -> Result<Option<Manifest>, DatabaseError> {
        let text: Option<String> =
            self.connection.query_row("SELECT text FROM manifest", [], |row| row.get(0)).optional()?;
        let broken = |reason: String| DatabaseError::Broken { name: "manifest".into(), reason };
        let Some(text) = text else { return Ok(None) };
        let manifest: Manifest = serde_json::from_str(&text).map_err(|error| broken(error.to_string()))?;
        manifest.problem().map_or(Ok(Some(manifest)), |problem| Err(broken(problem)))
    }

    /// Adds all models of `manifest` that are not there yet. `progress` is told how many of how many are, and says whether
    /// to go on.
    pub fn generate(
        &mut self,
        manifest: &Manifest,
        progress: &dyn Fn(usize, usize) -> bool,
    ) -> Result<(), DatabaseError> {
        match self.manifest()? {
            Some(known) if known != *manifest => return Err(DatabaseError::OtherManifest),
            Some(_) => {}
            None => {
                let text = serde_json::to_string(manifest).expect("a manifest is plain data");
                self.connection.execute("INSERT INTO manifest (text) VALUES (?1)", [text])?;
            }
        }
        let n = manifest.n_models();
        // Models are written in order: those that are there are the first.
        let mut done = self.n_models()?;
        let cells = Cells::new(N_CELLS);
        while done < n {
            if !progress(done, n) {
                return Err(Cancelled.into());
            }
            let batch: Vec<usize> = (done..n.min(done + BATCH)).collect();
            let rows = par::map(&batch, |&index| Row::of(manifest, index, &cells));
            let transaction = self.connection.transaction()?;
            for row in &rows {
                row.insert(&transaction)?;
            }
            transaction.commit()?;
            done += batch.len();
        }
        progress(n, n);
        Ok(())
    }

    /// Number of models.
    pub fn n_models(&self) -> Result<usize, DatabaseError> {
        let n: i64 = self.connection.query_row("SELECT count(*) FROM models", [], |row| row.get(0))?;
        Ok(n as usize)
    }

    /// Number of models per class, complete and partial.
    pub fn counts(&self) -> Result<Vec<(String, usize, usize)>, DatabaseError> {
        let mut statement = self.connection.prepare(
            "SELECT class, sum(1 - partial), sum(partial) FROM models GROUP BY class ORDER BY min(number)",
        )?;
        let rows = statement.query_map([], |row| {
            Ok((row.get(0)?, row.get::<_, i64>(1)? as usize, row.get::<_, i64>(2)? as usize))
        })?;
        Ok(rows.collect::<Result<_, _>>()?)
    }

    /// The model of a name.
    pub fn entry(&self, name: &str) -> Result<Option<Entry>, DatabaseError> {
        Ok(self.entries("WHERE name = ?1", [name])?.pop())
    }

    /// All models of a split, in order.
    pub fn of_split(&self, split: Split) -> Result<Vec<Entry>, DatabaseError> {
        let name = serde_json::to_value(split).expect("a split is a word");
        self.entries("WHERE split = ?1", [name.as_str().unwrap_or_default()])
    }

    fn entries(&self, which: &str, values: impl rusqlite::Params) -> Result<Vec<Entry>, DatabaseError> {
        let sql = format!(
            "SELECT number, truth, triangles, descriptor, name, checksum FROM models {which} ORDER BY number"
        );
        let mut statement = self.connection.prepare(&sql)?;
        let rows = statement.query_map(values, |row| {
            let (number, triangles): (i64, i64) = (row.get(0)?, row.get(2)?);
            let (truth, bytes, name): (String, Vec<u8>, String) = (row.get(1)?, row.get(3)?, row.get(4)?);
            Ok((number as usize, truth, triangles as usize, bytes, name, row.get(5)?))
        })?;
        rows.map(|row| {
            let (index, truth, n_triangles, bytes, name, checksum) = row?;
            let descriptor: Vec<f32> =
                bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
            if descriptor.len() != N_CELLS + 1 {
                let reason = format!("its descriptor has {} numbers", descriptor.len());
                return Err(DatabaseError::Broken { name, reason });
            }
            let truth = serde_json::from_str(&truth)
                .map_err(|error| DatabaseError::Broken { name, reason: error.to_string() })?;
            Ok(Entry { index, truth, n_triangles, checksum, descriptor })
        })
        .collect()
    }

    /// Adds a scanned part; one of the same name is replaced.
    pub fn add(&self, part: &Part) -> Result<(), DatabaseError> {
        let text = serde_json::to_string(part).expect("a part is plain data");
        self.connection.execute(
            "INSERT OR REPLACE INTO parts (name, class, provenance, part) VALUES (?1, ?2, ?3, ?4)",
            params![part.name, part.class.name(), part.provenance, text],
        )?;
        Ok(())
    }

    /// All parts that were added, by name.
    pub fn parts(&self) -> Result<Vec<Part>, DatabaseError> {
        let mut statement = self.connection.prepare("SELECT name, part FROM parts ORDER BY name")?;
        let rows = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
        rows.map(|row| {
            let (name, text): (String, String) = row?;
            serde_json::from_str(&text)
                .map_err(|error| DatabaseError::Broken { name, reason: error.to_string() })
        })
        .collect()
    }

    /// What is known that has the type and, as far as its uncertainty shows, the sizes of something measured: nearest first,
    /// parts before models.
    ///
    /// `sizes`, `uncertainties`: of the measured one, in the order of [`Part::sizes`].
    pub fn query(
        &self,
        class: Class,
        sizes: &[(String, f64)],
        uncertainties: &[f64],
    ) -> Result<Vec<Match>, DatabaseError> {
        /// Standard uncertainties within which a size agrees.
        const AGREE: f64 = 3.0;
        let apart = |others: &[(String, f64)], own: &[f64]| -> Option<f64> {
            let mut sum = 0.0;
            for ((name, size), u) in sizes.iter().zip(uncertainties) {
                let place = others.iter().position(|o| o.0 == *name)?;
                let u_sq = u * u + own.get(place).map_or(0.0, |v| v * v);
                let off_sq = (others[place].1 - size).powi(2) / u_sq.max(f64::MIN_POSITIVE);
                if off_sq > AGREE * AGREE {
                    return None;
                }
                sum += off_sq;
            }
            Some((sum / sizes.len().max(1) as f64).sqrt())
        };
        let of = |name: String, known: Vec<(String, f64)>, own: &[f64]| {
            let deviations = apart(&known, own)?;
            Some(Match { name, sizes: known, deviations })
        };
        let parts = self.parts()?.into_iter().filter(|p| p.class == class);
        let mut found: Vec<Match> = parts.filter_map(|p| of(p.name, p.sizes, &p.uncertainties)).collect();
        found.sort_by(|a, b| a.deviations.total_cmp(&b.deviations));
        // A shape is known once, however many copies of it there are.
        let models = self.entries("WHERE class = ?1", [class.name()])?;
        let mut seen = std::collections::BTreeSet::new();
        let firsts = models.into_iter().filter(|m| seen.insert(m.truth.group));
        let mut of_models: Vec<Match> =
            firsts.filter_map(|m| of(m.truth.name.clone(), sizes_of(&m.truth), &[])).collect();
        of_models.sort_by(|a, b| a.deviations.total_cmp(&b.deviations));
        found.extend(of_models);
        Ok(found)
    }
}

/// What does not change when a model is moved, by name.
fn sizes_of(truth: &Truth) -> Vec<(String, f64)> {
    let size = |name: &&str| Some(((*name).to_owned(), truth.parameter(name)?));
    truth.class.sizes().iter().filter_map(size).collect()
}

fn check(connection: &Connection, id: i32) -> Result<(), DatabaseError> {
    if id != APPLICATION_ID {
        return Err(DatabaseError::Foreign(id));
    }
    let found: i32 = connection.query_row("PRAGMA user_version", [], |row| row.get(0))?;
    if found == SCHEMA { Ok(()) } else { Err(DatabaseError::Schema { found }) }
}

struct Row {
    index: usize,
    truth: Truth,
    n_triangles: usize,
    checksum: u64,
    descriptor: Vec<u8>,
}

impl Row {
    fn of(manifest: &Manifest, index: usize, cells: &Cells) -> Self {
        let model = manifest.model(index);
        let image = GaussImage::of_mesh(&model.mesh);
        let values = Accumulator::new(&image, cells, Voting::Area).descriptor().values();
        let checksum = model.checksum();
        Self {
            index,
            truth: model.truth,
            n_triangles: model.mesh.triangles.len(),
            checksum,
            descriptor: values.iter().flat_map(|v| (*v as f32).to_le_bytes()).collect(),
        }
    }

    fn insert(&self, connection: &Connection) -> Result<(), DatabaseError> {
        let split = serde_json::to_value(self.truth.split).expect("a split is a word");
        connection.prepare_cached(
            "INSERT INTO models (number, name, class, split, partial, triangles, checksum, truth, descriptor)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)",
        )?
        .execute(params![
            self.index as i64,
            self.truth.name,
            self.truth.class.name(),
            split.as_str(),
            self.truth.partial,
            self.n_triangles as i64,
            format!("{:016x}", self.checksum),
            serde_json::to_string(&self.truth).expect("truth is plain data"),
            self.descriptor,
        ])?;
        Ok(())
    }
}
