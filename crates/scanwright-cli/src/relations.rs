//! `--relations` and `--manufacture` of `convert`.

use std::fs;
use std::path::Path;

use scanwright::regularize::{Listed, Manufacture, RelationKind, Relations};

use crate::exit::Failure;
use crate::scan::Units;

/// A list of relations as a file holds it.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    #[serde(default)]
    relation: Vec<Listed>,
}

/// What `--relations` asks for: a word, or the file of that name.
pub fn read(value: &Path) -> Result<Relations, Failure> {
    match value.to_str() {
        Some("auto") => return Ok(Relations::Auto),
        Some("off") => return Ok(Relations::Off),
        _ => {}
    }
    let text = fs::read_to_string(value).map_err(|error| Failure::input(value, error))?;
    let list: List =
        toml::from_str(&text).map_err(|error| Failure::input(value, error.to_string().trim_end()))?;
    if let Some(short) = list.relation.iter().position(|relation| relation.of.len() < 2) {
        return Err(Failure::input(value, format!("relation {} names fewer than two primitives", short + 1)));
    }
    let has_angle = |relation: &Listed| match (relation.kind, relation.degrees) {
        (RelationKind::CommonAngle, degrees) => degrees.is_some_and(|x| x.is_finite() && x % 180.0 != 0.0),
        (_, degrees) => degrees.is_none(),
    };
    if let Some(wrong) = list.relation.iter().position(|relation| !has_angle(relation)) {
        let what = "common_angle has degrees, not a multiple of 180, and no other kind has";
        return Err(Failure::input(value, format!("relation {}: {what}", wrong + 1)));
    }
    Ok(Relations::Listed(list.relation))
}

/// What `--manufacture` says, or 0.03 mm and 0.05 degrees: what milled and printed faces keep.
pub fn manufacture(length: Option<f64>, units: Units) -> Manufacture {
    const MILLIMETRES: f64 = 0.03;
    match length {
        None => Manufacture { length: MILLIMETRES / units.unit.millimeters(), ..Manufacture::default() },
        Some(0.0) => Manufacture { length: 0.0, angle: 0.0 },
        Some(length) => Manufacture { length, ..Manufacture::default() },
    }
}
