use serde_json::{Map, Value};

use super::super::number::count;
use super::super::page::{Block, Column, Row, Section, Table};
use super::super::part::Part;
use super::spoken;

/// Everything that the same result needs.
pub fn section(part: &Part) -> Section {
    let mut rows: Vec<(String, String)> =
        vec![("program".to_owned(), format!("scanwright {}", part.version))];
    rows.extend(source(part));
    rows.extend(settings(part));
    rows.extend(scan(part));
    let rows = rows.into_iter().map(|(name, value)| Row::new(vec![name.into(), value.into()])).collect();
    let columns = ["What", "Value"].map(Column::words).into();
    let table = Table { name: "reproduce", columns, rows, empty: String::new() };
    let text = "The same scan, settings and version give the same bytes, on any number of threads. This document has no \
                date for that reason.";
    let blocks = vec![Block::Text(text.to_owned()), Block::Table(table)];
    Section { title: "To reproduce this", anchor: "reproduce", blocks }
}

fn source(part: &Part) -> Vec<(String, String)> {
    match &part.scan.source {
        None => vec![("scan".to_owned(), "its file is not recorded in this result".to_owned())],
        Some(source) => vec![
            ("scan".to_owned(), format!("{}, {} bytes", source.file, count(source.bytes))),
            ("scan, SHA-256".to_owned(), source.sha256.clone()),
        ],
    }
}

fn settings(part: &Part) -> Vec<(String, String)> {
    let mut rows = Vec::new();
    if let Some(units) = &part.units {
        let text = format!("{} = {} mm, source: {}", units.name, units.millimetres, units.source);
        rows.push(("unit of length".to_owned(), text));
    }
    rows.extend(leaves("setting ", &part.settings));
    rows
}

fn scan(part: &Part) -> Vec<(String, String)> {
    let scan = &part.scan;
    let mut rows = Vec::new();
    let counts = [("triangles read", scan.triangles), ("vertices read", scan.vertices)];
    rows.extend(counts.into_iter().filter_map(|(name, n)| Some((name.to_owned(), count(n?)))));
    let lengths = [
        ("diagonal", scan.diagonal),
        ("mean distance of neighbouring vertices", scan.spacing),
        ("noise along the normal, standard deviation", scan.noise),
        ("spot of the scanner, standard deviation", scan.edge_rounding),
    ];
    let unit = part.unit();
    let text = |x: f64| format!("{} {unit}", super::super::number::significant(Some(x), 5));
    rows.extend(lengths.into_iter().filter_map(|(name, length)| Some((name.to_owned(), text(length?)))));
    // Zeros and absent things are left out: what conditioning did not find, it did not do.
    let did = leaves("conditioning ", &scan.conditioned);
    rows.extend(did.into_iter().filter(|(_, value)| value != "0" && value != "0.0" && value != "none"));
    rows
}

/// Names and values of an object and of the objects in it.
pub fn leaves(prefix: &str, object: &Map<String, Value>) -> Vec<(String, String)> {
    let mut rows = Vec::new();
    for (name, value) in object {
        let name = format!("{prefix}{}", spoken(name.strip_prefix("n_").unwrap_or(name)));
        match value {
            Value::Object(inner) => rows.extend(leaves(&format!("{name} "), inner)),
            Value::Null => rows.push((name, "none".to_owned())),
            Value::String(text) => rows.push((name, text.clone())),
            Value::Array(values) => {
                let texts: Vec<String> = values.iter().map(Value::to_string).collect();
                rows.push((name, texts.join(", ")));
            }
            other => rows.push((name, other.to_string())),
        }
    }
    rows
}
