use std::collections::BTreeMap;

use super::super::page::{Block, Cell, Column, Row, Section, Table};
use super::super::part::Part;
use super::references;

/// Codes that say that something stands in for what the scan does not give, with what it is.
const CODES: [(&str, &str); 9] = [
    ("W_NO_SOLID", "no solid"),
    ("W_OPEN", "open"),
    ("W_INVALID", "not valid"),
    ("W_ASSUMED_FACE", "assumed"),
    ("W_FREEFORM", "freeform"),
    ("W_FACETS", "facets"),
    ("W_FACE_DROPPED", "face dropped"),
    ("W_FACE_ADDED", "face added"),
    ("W_GAP", "gap"),
];

/// Faces that nobody saw, and what stands in for faces that could not be made.
pub fn section(part: &Part) -> Section {
    let mut rows = Vec::new();
    for (code, what) in CODES {
        let mut texts: BTreeMap<&str, Vec<u32>> = BTreeMap::new();
        for warning in part.warnings_of(code) {
            texts.entry(&warning.text).or_default().extend(warning.primitive);
        }
        for (text, mut ids) in texts {
            ids.sort_unstable();
            ids.dedup();
            let regions = Cell::Regions(references(part, &ids));
            rows.push(Row::new(vec![what.into(), regions, text.into(), code.into()]));
        }
    }
    let columns = ["What", "Where", "How", "Code"].map(Column::words).into();
    let empty = "Nothing was assumed, and no fallback was needed.".to_owned();
    let table = Table { name: "substitutes", columns, rows, empty };
    let title = "Assumed faces and fallbacks";
    Section { title, anchor: "substitutes", blocks: vec![Block::Table(table)] }
}
