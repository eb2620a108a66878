//! One HTML file with its style and pictures in it; it refers to nothing outside and runs nothing.

use std::fmt::Write as _;

use super::super::page::{
    Block, Cell, Chart, Column, Document, Figure, Figures, Level, PlaceCard, Reference, Row, Section, Table,
    Verdict,
};
use super::base64;

const STYLE: &str = include_str!("style.css");

/// The document as a page.
pub fn html(document: &Document) -> String {
    let title = escaped(&document.title);
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; \
         style-src 'unsafe-inline'\"/>\n<title>{title}: reconstruction report</title>\n<style>\n{STYLE}\n\
         @page {{ @top-left {{ content: \"{}\"; }} }}\n</style>\n</head>\n<body>\n",
        in_css(&document.title)
    );
    let _ = write!(
        text,
        "<header>\n<p class=\"kind\">Reconstruction report</p>\n<h1>{title}</h1>\n<p class=\"subtitle\">{}</p>\n\
         </header>\n",
        escaped(&document.subtitle)
    );
    contents(&mut text, document);
    text.push_str("<main>\n");
    for (k, found) in document.sections.iter().enumerate() {
        section(&mut text, k + 1, found);
    }
    text.push_str("</main>\n</body>\n</html>\n");
    text
}

fn contents(text: &mut String, document: &Document) {
    text.push_str("<nav aria-label=\"Contents\"><ol>");
    for found in &document.sections {
        let _ = write!(text, "<li><a href=\"#{}\">{}</a></li>", found.anchor, found.title);
    }
    text.push_str("</ol></nav>\n");
}

fn section(text: &mut String, number: usize, section: &Section) {
    let _ = writeln!(
        text,
        "<section id=\"{}\">\n<h2><span class=\"number\">{number}</span> {}</h2>",
        section.anchor, section.title
    );
    for block in &section.blocks {
        match block {
            Block::Heading(heading) => {
                let _ = writeln!(text, "<h3>{}</h3>", escaped(heading));
            }
            Block::Text(paragraph) => {
                let _ = writeln!(text, "<p>{}</p>", prose(paragraph));
            }
            Block::List(items) => {
                text.push_str("<ul>");
                list(text, items);
                text.push_str("</ul>\n");
            }
            Block::Verdict(found) => verdict(text, found),
            Block::Table(found) => table(text, found),
            Block::Figures(found) => figures(text, found),
            Block::Chart(found) => chart(text, found),
            Block::Places(found) => places(text, found),
        }
    }
    text.push_str("</section>\n");
}

fn verdict(text: &mut String, verdict: &Verdict) {
    let _ = writeln!(
        text,
        "<p class=\"headline {}\">{}{}</p>\n<table class=\"facts\"><tbody>",
        class(verdict.level),
        mark(Some(verdict.level)),
        escaped(&verdict.headline)
    );
    for fact in &verdict.facts {
        let _ = writeln!(
            text,
            "<tr><th scope=\"row\">{}</th><td class=\"state\">{}</td><td class=\"value\">{}</td><td>{}</td></tr>",
            fact.label,
            mark(fact.level),
            escaped(&fact.value),
            escaped(&fact.remark)
        );
    }
    text.push_str("</tbody></table>\n");
    if verdict.points.is_empty() {
        return;
    }
    text.push_str("<h3>To know before it is used</h3>\n<ul class=\"points\">\n");
    for point in &verdict.points {
        let regions =
            if point.regions.is_empty() { String::new() } else { format!(": {}", links(&point.regions)) };
        let _ = writeln!(text, "<li>{}{}{regions}</li>", mark(Some(point.level)), escaped(&point.text));
    }
    text.push_str("</ul>\n");
}

fn class(level: Level) -> &'static str {
    match level {
        Level::Good => "good",
        Level::Look => "look",
        Level::Bad => "bad",
    }
}

/// A sign that differs in shape as well as in color, with its word for those who hear the page.
fn mark(level: Option<Level>) -> String {
    let Some(level) = level else { return String::new() };
    let sign = match level {
        Level::Good => "✓",
        Level::Look => "!",
        Level::Bad => "✕",
    };
    format!(
        "<span class=\"mark {}\" role=\"img\" aria-label=\"{}\">{sign}</span> ",
        class(level),
        level.word()
    )
}

/// What column of words comes last is said in a row of its own, below: remarks are long and rare.
fn table(text: &mut String, table: &Table) {
    if table.rows.is_empty() {
        let _ = writeln!(text, "<p>{}</p>", escaped(&table.empty));
        return;
    }
    let remarks = table.columns.last().is_some_and(|column| matches!(column.head, "Remark" | "Why not"));
    let columns = &table.columns[..table.columns.len() - usize::from(remarks)];
    let _ = write!(text, "<div class=\"scroll\"><table class=\"data\">\n<thead><tr>");
    for column in columns {
        let unit = column
            .unit
            .as_ref()
            .map_or_else(String::new, |unit| format!(" <span class=\"unit\">{}</span>", escaped(unit)));
        let _ = write!(text, "<th scope=\"col\"{}>{}{unit}</th>", number_class(column), column.head);
    }
    text.push_str("</tr></thead>\n<tbody>\n");
    for found in &table.rows {
        row(text, found, columns);
    }
    text.push_str("</tbody></table></div>\n");
}

fn number_class(column: &Column) -> &'static str {
    if column.number { " class=\"number\"" } else { "" }
}

fn row(text: &mut String, row: &Row, columns: &[Column]) {
    let remark = row.cells.get(columns.len()).map(Cell::text).filter(|remark| !remark.is_empty());
    let anchor = row.region.map_or_else(String::new, |id| format!(" id=\"region-{id}\""));
    let mut classes = Vec::new();
    classes.extend(row.level.map(class));
    classes.extend(remark.as_ref().map(|_| "remarked"));
    let classes =
        if classes.is_empty() { String::new() } else { format!(" class=\"{}\"", classes.join(" ")) };
    let _ = write!(text, "<tr{anchor}{classes}>");
    for (k, (cell, column)) in row.cells.iter().zip(columns).enumerate() {
        let sign = if k == 0 { mark(row.level) } else { String::new() };
        let content = match cell {
            Cell::Text(content) => escaped(content),
            Cell::Regions(regions) => links(regions),
        };
        let _ = write!(text, "<td{}>{sign}{content}</td>", number_class(column));
    }
    text.push_str("</tr>\n");
    if let Some(remark) = remark {
        let n = columns.len();
        let _ = writeln!(text, "<tr class=\"remark\"><td colspan=\"{n}\">{}</td></tr>", escaped(&remark));
    }
}

/// Names of regions that lead to their rows.
fn links(regions: &[Reference]) -> String {
    let link = |region: &Reference| {
        let name = escaped(&region.name);
        if region.listed { format!("<a href=\"#region-{}\">{name}</a>", region.id) } else { name }
    };
    regions.iter().map(link).collect::<Vec<_>>().join(", ")
}

fn figures(text: &mut String, figures: &Figures) {
    let _ = writeln!(text, "<div class=\"figures of{}\">", figures.columns);
    for found in &figures.figures {
        figure(text, found);
    }
    text.push_str("</div>\n");
    if !figures.legend.is_empty() {
        text.push_str("<ul class=\"legend\">");
        for (color, name) in &figures.legend {
            let _ = write!(
                text,
                "<li><span class=\"swatch\" style=\"background:{color}\"></span>{}</li>",
                escaped(name)
            );
        }
        text.push_str("</ul>\n");
    }
}

fn figure(text: &mut String, figure: &Figure) {
    let _ = writeln!(
        text,
        "<figure><img src=\"data:image/png;base64,{}\" width=\"{}\" height=\"{}\" alt=\"{}\"/>\
         <figcaption>{}</figcaption></figure>",
        base64::encoded(&figure.png),
        figure.size.0,
        figure.size.1,
        escaped(&figure.alt),
        escaped(&figure.caption)
    );
}

fn chart(text: &mut String, chart: &Chart) {
    let caption = escaped(&chart.caption);
    let _ =
        writeln!(text, "<figure class=\"chart\">{}<figcaption>{caption}</figcaption></figure>", chart.svg);
}

fn places(text: &mut String, places: &[PlaceCard]) {
    text.push_str("<div class=\"places\">\n");
    for place in places {
        let _ = writeln!(
            text,
            "<article class=\"{}\">\n<h3>{}{}</h3>",
            class(place.level),
            mark(Some(place.level)),
            links(std::slice::from_ref(&place.title))
        );
        if let Some(found) = &place.figure {
            figure(text, found);
        }
        text.push_str("<ul>");
        list(text, &place.reasons);
        text.push_str("</ul>\n<ul class=\"advice\">");
        list(text, &place.advice);
        text.push_str("</ul>\n</article>\n");
    }
    text.push_str("</div>\n");
}

fn list(text: &mut String, items: &[String]) {
    for item in items {
        let _ = write!(text, "<li>{}</li>", escaped(item));
    }
}

/// Text in which nothing is markup, in elements and in quoted attributes. Characters that XML forbids become blanks.
pub fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for (at, c) in text.char_indices() {
        match c {
            // A number stays beside its sign.
            ' ' if text[at..].starts_with(" %") => escaped.push_str("&#160;"),
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\u{fffe}' | '\u{ffff}' => escaped.push(' '),
            c if c.is_control() || is_direction(c) => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Marks that turn the direction of the text after them, beyond the name they came with.
fn is_direction(c: char) -> bool {
    matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A string of CSS inside `<style>`: all but letters and digits by their numbers.
fn in_css(text: &str) -> String {
    let mut css = String::new();
    for c in text.chars().filter(|c| !c.is_control() && !is_direction(*c)) {
        if c.is_ascii_alphanumeric() {
            css.push(c);
        } else {
            let _ = write!(css, "\\{:06x}", u32::from(c));
        }
    }
    css
}

/// Our own sentences, in which backticks mean code.
fn prose(text: &str) -> String {
    let piece = |(k, piece): (usize, &str)| {
        if k % 2 == 1 { format!("<code>{}</code>", escaped(piece)) } else { escaped(piece) }
    };
    text.split('`').enumerate().map(piece).collect()
}
