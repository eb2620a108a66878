//! `scanwright gprimdb`.

use std::fs;
use std::path::Path;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use scanwright::gprimdb::{Class, Database, DatabaseError, Manifest, Part, Tier};
use scanwright::{io, par};
use serde_json::Value;

use crate::args::{GprimdbVerb, TierFlag};
use crate::exit::{Code, Failure};
use crate::{console, outputs};

/// Makes, shows and extends a database of primitives.
pub fn run(verb: &GprimdbVerb) -> Result<Code, Failure> {
    match verb {
        GprimdbVerb::Manifest { tier } => print_manifest(*tier),
        GprimdbVerb::Generate { output, tier, manifest, threads, quiet } => {
            let manifest = match manifest {
                Some(path) => read_manifest(path)?,
                None => Manifest::of_tier(tier_of(*tier)),
            };
            par::with_threads(*threads, || generate(output, &manifest, *quiet))
        }
        GprimdbVerb::Info { database } => info(database),
        GprimdbVerb::Show { database, name } => show(database, name),
        GprimdbVerb::Export { database, name, output, force } => export(database, name, output, *force),
        GprimdbVerb::Query { database, part, primitive } => query(database, part, *primitive),
        GprimdbVerb::Add { database, part, primitive, name, provenance } => {
            add(database, &measured(part, *primitive)?.named(name, provenance))
        }
    }
}

fn print_manifest(tier: TierFlag) -> Result<Code, Failure> {
    let text = toml::to_string(&Manifest::of_tier(tier_of(tier)));
    println!("{}", text.map_err(|error| Failure::Internal(error.to_string()))?.trim_end());
    Ok(Code::Done)
}

fn read_manifest(path: &Path) -> Result<Manifest, Failure> {
    let text = fs::read_to_string(path).map_err(|error| Failure::input(path, error))?;
    let manifest: Manifest =
        toml::from_str(&text).map_err(|error| Failure::input(path, error.to_string().trim_end()))?;
    match manifest.problem() {
        Some(problem) => Err(Failure::input(path, problem)),
        None => Ok(manifest),
    }
}

fn generate(path: &Path, manifest: &Manifest, quiet: bool) -> Result<Code, Failure> {
    console::handle_interrupts();
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(manifest.n_models() as u64), target).with_style(
        ProgressStyle::with_template("{bar:30} {pos} of {len} models  {elapsed}")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let mut database = Database::open_or_create(path).map_err(|error| on(path, error))?;
    let outcome = database.generate(manifest, &|done, _| {
        bar.set_position(done as u64);
        !console::cancelled()
    });
    bar.finish_and_clear();
    outcome.map_err(|error| match error {
        DatabaseError::Cancelled(_) => Failure::Cancelled,
        other => Failure::output(path, other),
    })?;
    if !quiet {
        println!("{}: {} models", path.display(), manifest.n_models());
    }
    Ok(Code::Done)
}

fn info(path: &Path) -> Result<Code, Failure> {
    let database = open(path)?;
    println!("class       complete  partial");
    for (class, complete, partial) in database.counts().map_err(|error| on(path, error))? {
        println!("{class:10}  {complete:8}  {partial:7}");
    }
    let parts = database.parts().map_err(|error| on(path, error))?;
    for part in &parts {
        println!("added       {}: {} ({})", part.name, described(part), part.provenance);
    }
    Ok(Code::Done)
}

fn show(path: &Path, name: &str) -> Result<Code, Failure> {
    let entry = open(path)?.entry(name).map_err(|error| on(path, error))?;
    let entry = entry.ok_or_else(|| Failure::input(path, format!("has no model `{name}`")))?;
    let mut value = serde_json::to_value(&entry.truth).expect("truth is plain data");
    value["triangles"] = entry.n_triangles.into();
    println!("{value:#}");
    Ok(Code::Done)
}

fn export(path: &Path, name: &str, output: &Path, force: bool) -> Result<Code, Failure> {
    outputs::check(path, &[output], force)?;
    let database = open(path)?;
    let entry = database.entry(name).map_err(|error| on(path, error))?;
    let manifest = database.manifest().map_err(|error| on(path, error))?;
    let (Some(entry), Some(manifest)) = (entry, manifest) else {
        return Err(Failure::input(path, format!("has no model `{name}`")));
    };
    if entry.index >= manifest.n_models() {
        return Err(Failure::input(path, format!("`{name}` is not in its manifest")));
    }
    let model = manifest.model(entry.index);
    if format!("{:016x}", model.checksum()) != entry.checksum {
        eprintln!(
            "scanwright: {name}: differs in its last bits from the mesh that the database was made with"
        );
    }
    outputs::write(&[(output, io::write_ply(&model.mesh, None, None))])?;
    Ok(Code::Done)
}

fn query(path: &Path, part: &Path, primitive: u64) -> Result<Code, Failure> {
    let measured = measured(part, primitive)?;
    let found = open(path)?
        .query(measured.class, &measured.sizes, &measured.uncertainties)
        .map_err(|error| on(path, error))?;
    if found.is_empty() {
        println!("nothing known has these sizes");
    }
    for known in found {
        let sizes: Vec<String> = known.sizes.iter().map(|(name, size)| size_text(name, *size)).collect();
        println!("{}: {}, {:.1} standard uncertainties off", known.name, sizes.join(", "), known.deviations);
    }
    Ok(Code::Done)
}

fn add(path: &Path, part: &Part) -> Result<Code, Failure> {
    let database = Database::open_or_create(path).map_err(|error| Failure::output(path, error))?;
    database.add(part).map_err(|error| Failure::output(path, error))?;
    println!("{}: {}", part.name, described(part));
    Ok(Code::Done)
}

/// Sizes of one primitive of a JSON file, with their uncertainties.
struct Measured {
    class: Class,
    sizes: Vec<(String, f64)>,
    uncertainties: Vec<f64>,
}

impl Measured {
    fn named(self, name: &str, provenance: &str) -> Part {
        Part {
            name: name.to_owned(),
            provenance: provenance.to_owned(),
            class: self.class,
            sizes: self.sizes,
            uncertainties: self.uncertainties,
        }
    }
}

fn measured(path: &Path, id: u64) -> Result<Measured, Failure> {
    let text = fs::read_to_string(path).map_err(|error| Failure::input(path, error))?;
    let value: Value = serde_json::from_str(&text).map_err(|error| Failure::input(path, error))?;
    let is_it = |p: &&Value| p["id"].as_u64() == Some(id);
    let primitive = value["primitives"].as_array().into_iter().flatten().find(is_it);
    let primitive = primitive.ok_or_else(|| Failure::input(path, format!("has no primitive {id}")))?;
    let class = Class::PRIMITIVES.into_iter().find(|class| primitive["type"] == class.name());
    let class = class.ok_or_else(|| Failure::input(path, format!("primitive {id} is of no known type")))?;
    let names = class.sizes();
    if names.is_empty() {
        return Err(Failure::input(path, format!("primitive {id} is a {}, which has no size", class.name())));
    }
    let listed: Vec<&str> =
        primitive["parameters"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let (mut sizes, mut uncertainties) = (Vec::new(), Vec::new());
    for name in names {
        let place = listed.iter().position(|listed| listed == name);
        let uncertainty = place.and_then(|place| primitive["uncertainty"][place].as_f64());
        let (Some(size), Some(uncertainty)) = (primitive[*name].as_f64(), uncertainty) else {
            return Err(Failure::input(path, format!("primitive {id} has no {name} with an uncertainty")));
        };
        sizes.push(((*name).to_owned(), size));
        uncertainties.push(uncertainty);
    }
    Ok(Measured { class, sizes, uncertainties })
}

fn described(part: &Part) -> String {
    let sizes = part.sizes.iter().zip(&part.uncertainties).map(|((name, size), u)| {
        let (size, u) = if name == "half_angle" { (size.to_degrees(), u.to_degrees()) } else { (*size, *u) };
        format!("{} {size:.4} +- {u:.4}", name.replace('_', " "))
    });
    format!("{}, {}", part.class.name(), sizes.collect::<Vec<_>>().join(", "))
}

/// One size for people.
pub fn size_text(name: &str, size: f64) -> String {
    let size = if name == "half_angle" { size.to_degrees() } else { size };
    format!("{} {size:.4}", name.replace('_', " "))
}

/// A database to read.
pub fn open(path: &Path) -> Result<Database, Failure> {
    if !path.is_file() {
        return Err(Failure::input(path, "is no file"));
    }
    Database::open(path).map_err(|error| on(path, error))
}

fn on(path: &Path, error: DatabaseError) -> Failure {
    Failure::input(path, error)
}

fn tier_of(flag: TierFlag) -> Tier {
    match flag {
        TierFlag::Faithful => Tier::Faithful,
        TierFlag::Hard => Tier::Hard,
        TierFlag::Ambiguous => Tier::Ambiguous,
    }
}
