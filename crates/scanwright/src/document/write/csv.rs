//! CSV after RFC 4180. Tables follow each other; the first cell of every row is the name of its table, so that one table
//! is what a search for its name gives, head first.

use super::super::page::{Block, Document, Level, Table, Verdict};

/// The tables of the document.
pub fn csv(document: &Document) -> String {
    let mut text = String::new();
    line(&mut text, &["document", &document.title, &document.subtitle]);
    for block in document.sections.iter().flat_map(|section| &section.blocks) {
        match block {
            Block::Verdict(found) => verdict(&mut text, found),
            Block::Table(found) => table(&mut text, found),
            Block::Places(places) => {
                line(&mut text, &["weak", "Where", "Why", "What would help"]);
                for place in places {
                    let (why, advice) = (place.reasons.join("; "), place.advice.join("; "));
                    line(&mut text, &["weak", &place.title.name, &why, &advice]);
                }
            }
            Block::Heading(_) | Block::Text(_) | Block::List(_) | Block::Figures(_) | Block::Chart(_) => {}
        }
    }
    text
}

fn verdict(text: &mut String, verdict: &Verdict) {
    line(text, &["verdict", "What", "State", "Value", "Remark"]);
    line(text, &["verdict", "Verdict", verdict.level.word(), &verdict.headline, ""]);
    for fact in &verdict.facts {
        line(text, &["verdict", fact.label, fact.level.map_or("", Level::word), &fact.value, &fact.remark]);
    }
}

fn table(text: &mut String, table: &Table) {
    let heads = table.columns.iter().map(super::super::page::Column::title);
    line(text, &std::iter::once(table.name.to_owned()).chain(heads).collect::<Vec<_>>());
    for row in &table.rows {
        let cells = row.cells.iter().map(super::super::page::Cell::text);
        line(text, &std::iter::once(table.name.to_owned()).chain(cells).collect::<Vec<_>>());
    }
}

fn line<T: AsRef<str>>(text: &mut String, cells: &[T]) {
    let cells: Vec<String> = cells.iter().map(|cell| quoted(cell.as_ref())).collect();
    text.push_str(&cells.join(","));
    text.push_str("\r\n");
}

/// A cell. What a spreadsheet would run as a formula gets an apostrophe, by which it is text.
fn quoted(cell: &str) -> String {
    let number = cell.parse::<f64>().is_ok() || cell == "-";
    let formula = !number && cell.starts_with(['=', '+', '-', '@', '\t', '\r']);
    let cell = if formula { format!("'{cell}") } else { cell.to_owned() };
    if cell.contains(['"', ',', '\r', '\n']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn cells_are_quoted_and_never_formulas() {
        let cases = [
            ("plain", "plain"),
            ("-0.012", "-0.012"),
            ("+0.012", "+0.012"),
            ("-", "-"),
            ("a,b", "\"a,b\""),
            ("say \"no\"", "\"say \"\"no\"\"\""),
            ("=HYPERLINK(1)", "'=HYPERLINK(1)"),
            ("-2+3", "'-2+3"),
            ("@x\ny", "\"'@x\ny\""),
        ];
        for (cell, expected) in cases {
            assert_eq!(quoted(cell), expected);
        }
    }
}
