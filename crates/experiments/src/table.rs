//! A table, as CSV for programs and Markdown for people.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::Context as _;

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

    /// What stands above the columns.
    pub fn headings(&self) -> &[String] {
        &self.headings
    }

    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        self.rows.len()
    }

    /// The cells under a heading.
    ///
    /// # Panics
    /// When there is no such heading.
    pub fn column(&self, heading: &str) -> Vec<&str> {
        let place = self.headings.iter().position(|h| h == heading);
        let place = place.unwrap_or_else(|| panic!("the table has no column `{heading}`"));
        self.rows.iter().map(|row| row[place].as_str()).collect()
    }

    /// The numbers that the cells under a heading begin with, whatever their unit; NaN where there is none.
    pub fn numbers(&self, heading: &str) -> Vec<f64> {
        let number = |cell: &str| cell.split(' ').next().and_then(|n| n.parse().ok()).unwrap_or(f64::NAN);
        self.column(heading).into_iter().map(number).collect()
    }

    /// The table that [`Self::write`] wrote.
    pub fn read(folder: &Path, name: &str) -> anyhow::Result<Self> {
        let path = folder.join(name).with_extension("csv");
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let mut rows = text.lines().map(cells);
        let headings = rows.next().with_context(|| format!("{}: is empty", path.display()))?;
        let rows: Vec<Vec<String>> = rows.collect();
        if rows.iter().any(|row| row.len() != headings.len()) {
            anyhow::bail!("{}: a row has not one cell per heading", path.display());
        }
        Ok(Self { headings, rows })
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

/// The cells of a line; commas within quotes part none.
fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut is_quoted = false;
    for letter in line.chars() {
        match letter {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(String::new()),
            other => cells.last_mut().expect("there is one").push(other),
        }
    }
    cells
}

/// A share in percent.
pub fn percent(part: usize, of: usize) -> String {
    format!("{:.1} %", 100.0 * part as f64 / of.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_within_quotes_part_no_cells() {
        assert_eq!(cells("\"a, b\",1.0 %,"), ["a, b", "1.0 %", ""]);
    }
}
