use serde_json::{Map, Value};

use super::super::page::{Block, Column, Row, Section, Table};
use super::super::part::Part;
use super::reproduce::leaves;

/// Keys whose numbers are those of primitives.
const DATUMS: [&str; 4] = ["level", "rotate", "zero", "datums"];

/// The datum frame, when the part was aligned.
pub fn section(part: &Part) -> Option<Section> {
    let frame = part.frame.as_ref()?.as_object()?;
    let named: Map<String, Value> = frame
        .iter()
        .map(|(key, value)| {
            let value = if DATUMS.contains(&key.as_str()) { names(part, value) } else { value.clone() };
            (key.clone(), value)
        })
        .collect();
    let rows = leaves("", &named).into_iter().map(|(name, value)| Row::new(vec![name.into(), value.into()]));
    let columns = ["What", "Value"].map(Column::words).into();
    let table = Table { name: "frame", columns, rows: rows.collect(), empty: String::new() };
    Some(Section { title: "Datum frame", anchor: "frame", blocks: vec![Block::Table(table)] })
}

/// Numbers of primitives as their names.
fn names(part: &Part, value: &Value) -> Value {
    let ids: Option<Vec<u64>> = match value {
        Value::Array(values) => values.iter().map(Value::as_u64).collect(),
        other => other.as_u64().map(|id| vec![id]),
    };
    let name = |id: u64| u32::try_from(id).map_or_else(|_| id.to_string(), |id| part.name_of(id));
    ids.map_or_else(|| value.clone(), |ids| ids.into_iter().map(name).collect::<Vec<_>>().join(", ").into())
}
