use serde_json::Value;

use super::super::page::{Block, Column, Row, Section, Table};
use super::super::part::Part;
use super::reproduce::leaves;

/// The datum frame, when the part was aligned.
pub fn section(part: &Part) -> Option<Section> {
    let frame = part.frame.as_ref().filter(|frame| !frame.is_null())?;
    let rows = match frame {
        Value::Object(object) => leaves("", object),
        other => vec![("frame".to_owned(), other.to_string())],
    };
    let rows = rows.into_iter().map(|(name, value)| Row::new(vec![name.into(), value.into()])).collect();
    let columns = ["What", "Value"].map(Column::words).into();
    let table = Table { name: "frame", columns, rows, empty: String::new() };
    Some(Section { title: "Datum frame", anchor: "frame", blocks: vec![Block::Table(table)] })
}
