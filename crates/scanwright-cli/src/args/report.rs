use std::path::PathBuf;

use clap::Args;

/// Flags of `report`.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// The JSON that `convert --json` wrote
    pub part: PathBuf,
    /// The document to write: .html with pictures, .md, or .csv with the tables alone
    #[arg(short, long, value_name = "REPORT.html")]
    pub output: PathBuf,
    /// For pictures of the scan: the scan that was converted, or what `convert --segments` wrote
    #[arg(long, value_name = "SCAN")]
    pub scan: Option<PathBuf>,
    /// For pictures of the part and the deviation: the solid, as STEP or as a mesh
    #[arg(long, value_name = "PART.step")]
    pub model: Option<PathBuf>,
    /// Name of the part in the document [default: that of the JSON file]
    #[arg(long)]
    pub name: Option<String>,
    /// Threads to work with [default: all processors]; the document is the same
    #[arg(long, value_parser = super::parse_count)]
    pub threads: Option<usize>,
    /// Overwrite the document if it exists
    #[arg(long)]
    pub force: bool,
}

/// Examples of `report --help`.
pub const EXAMPLES: &str = "\
Examples:
  scanwright report bracket.json -o bracket.html --scan bracket.ply --model bracket.step
      One page to hand on: verdict, dimensions, relations, deviation, where to scan again.
  scanwright report bracket.json -o bracket.csv
      The same tables for a spreadsheet; so does .md for text.
  scanwright convert bracket.ply -o bracket.step --report bracket.html
      The page with its pictures in the same run.";
