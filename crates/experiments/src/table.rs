//! A table, as CSV for programs and Markdown for people.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Rows of cells under headings.
pub struct Table {
    headings: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    pub fn new(headings: &[&str]) -> Self {
        Self { headings: headings.iter().map(|h| (*h).to_owned()).collect(), rows: Vec::new() }
    }

    /// Adds a row of as many cells as there are headings.
    pub fn row(&mut self, cells: Vec<String>) {
        assert_eq!(cells.len(), self.headings.len(), "one cell per heading");
        self.rows.push(cells);
    }

    /// The table in Markdown.
    pub fn markdown(&self) -> String {
        let mut text =
            format!("| {} |\n|{}\n", self.headings.join(" | "), "---|".repeat(self.headings.len()));
        for row in &self.rows {
            let _ = writeln!(text, "| {} |", row.join(" | "));
        }
        text
    }

    /// Writes `name.csv` and `name.md` into a folder.
    pub fn write(&self, folder: &Path, name: &str) -> anyhow::Result<()> {
        fs::create_dir_all(folder)?;
        let quoted = |cell: &String| if cell.contains(',') { format!("\"{cell}\"") } else { cell.clone() };
        let lines = std::iter::once(&self.headings).chain(&self.rows);
        let csv: Vec<String> =
            lines.map(|row| row.iter().map(quoted).collect::<Vec<_>>().join(",")).collect();
        fs::write(folder.join(name).with_extension("csv"), csv.join("\n") + "\n")?;
        fs::write(folder.join(name).with_extension("md"), self.markdown())?;
        Ok(())
    }
}

/// A share in percent.
pub fn percent(part: usize, of: usize) -> String {
    format!("{:.1} %", 100.0 * part as f64 / of.max(1) as f64)
}
