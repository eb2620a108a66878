//! Markdown with the tables of GitHub's dialect, without pictures.

use std::fmt::Write as _;

use super::super::page::{Block, Cell, Column, Document, PlaceCard, Table, Verdict, names};

/// The document without its pictures.
pub fn markdown(document: &Document) -> String {
    let mut text = format!("# {}\n\n{}.\n", plain(&document.title), plain(&document.subtitle));
    for section in &document.sections {
        let _ = write!(text, "\n## {}\n", section.title);
        for block in &section.blocks {
            text.push('\n');
            match block {
                Block::Heading(heading) => {
                    let _ = writeln!(text, "### {heading}");
                }
                Block::Text(paragraph) => {
                    let _ = writeln!(text, "{}", prose(paragraph));
                }
                Block::List(items) => {
                    for item in items {
                        let _ = writeln!(text, "- {}", plain(item));
                    }
                }
                Block::Verdict(found) => verdict(&mut text, found),
                Block::Table(found) => table(&mut text, found),
                Block::Chart(chart) => {
                    let _ =
                        writeln!(text, "{} The histogram is in the HTML document.", plain(&chart.caption));
                }
                Block::Figures(_) => {}
                Block::Places(found) => places(&mut text, found),
            }
        }
    }
    text
}

fn verdict(text: &mut String, verdict: &Verdict) {
    let _ = writeln!(text, "**{}** ({})\n", plain(&verdict.headline), verdict.level.word());
    text.push_str("| what | state | value | remark |\n|---|---|---|---|\n");
    for fact in &verdict.facts {
        let level = fact.level.map_or("", super::super::page::Level::word);
        let _ =
            writeln!(text, "| {} | {level} | {} | {} |", fact.label, plain(&fact.value), plain(&fact.remark));
    }
    if !verdict.points.is_empty() {
        text.push_str("\nTo know before it is used:\n\n");
    }
    for point in &verdict.points {
        let regions =
            if point.regions.is_empty() { String::new() } else { format!(": {}", names(&point.regions)) };
        let _ = writeln!(text, "- {}: {}{}", point.level.word(), plain(&point.text), plain(&regions));
    }
}

fn table(text: &mut String, table: &Table) {
    if table.rows.is_empty() {
        let _ = writeln!(text, "{}", plain(&table.empty));
        return;
    }
    let heads: Vec<String> = table.columns.iter().map(|column| plain(&column.title())).collect();
    let rules = table.columns.iter().map(|Column { number, .. }| if *number { "---:" } else { "---" });
    let _ = writeln!(text, "| {} |\n|{}|", heads.join(" | "), rules.collect::<Vec<_>>().join("|"));
    for row in &table.rows {
        let cells: Vec<String> = row.cells.iter().map(Cell::text).map(|cell| plain(&cell)).collect();
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
}

fn places(text: &mut String, places: &[PlaceCard]) {
    text.push_str("| where | why | what would help |\n|---|---|---|\n");
    for place in places {
        let cells = [place.title.name.clone(), place.reasons.join("; "), place.advice.join("; ")];
        let _ = writeln!(text, "| {} |", cells.map(|cell| plain(&cell)).join(" | "));
    }
}

/// Text in which nothing is markup.
fn plain(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '|' | '#' | '&' | '!' => {
                escaped.push('\\');
                escaped.push(c);
            }
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Our own sentences, in which backticks mean code.
fn prose(text: &str) -> String {
    let piece = |(k, piece): (usize, &str)| if k % 2 == 1 { format!("`{piece}`") } else { plain(piece) };
    text.split('`').enumerate().map(piece).collect()
}
