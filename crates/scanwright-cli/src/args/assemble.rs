use std::path::PathBuf;

use clap::Args;

use super::{RunFlags, SupportFlag, Unit};

pub const EXAMPLES: &str = "\
Examples:
  scanwright assemble housing.step shaft.step bush.step --scan whole.ply -o whole.step
  scanwright assemble housing.step bush.step bush.step --scan whole.ply -o whole.step --json whole.json
  scanwright assemble housing.step shaft.step --replace shaft=shaft-v2.step --scan whole.ply -o new.step

A part that the scan shows too little of is left out and said so; the others are written (exit 4).";

/// Flags of `assemble`.
#[derive(Debug, Args)]
pub struct AssembleArgs {
    /// The parts: STEP files of any system. One given twice is looked for twice
    #[arg(required = true, value_name = "PART.step")]
    pub parts: Vec<PathBuf>,
    /// A scan of the assembled object: STL, PLY, OBJ, OFF or 3MF
    #[arg(long, value_name = "SCAN")]
    pub scan: PathBuf,
    /// The assembly to write
    #[arg(short, long, value_name = "ALL.step")]
    pub output: PathBuf,
    /// A newer file for the part NAME (its file's name without the ending), in the coordinates of the old one: it is
    /// written where the old one is found. For a part that is not among the others, the new file itself is looked for
    #[arg(long, value_name = "NAME=NEW.step", value_parser = parse_replacement)]
    pub replace: Vec<(String, PathBuf)>,
    /// Write where each part is, how surely, and what was not placed, as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Unit of the scan's coordinates [default: the file's, else mm]
    #[arg(long, value_enum)]
    pub units: Option<Unit>,
    /// Whether to look for a table under the object and take it away
    #[arg(long, value_enum, default_value_t = SupportFlag::Auto)]
    pub support: SupportFlag,
    /// Seed of all random choices
    #[arg(long, default_value_t = scanwright::pipeline::Options::DEFAULT_SEED)]
    pub seed: u64,
    /// How the run goes about it
    #[command(flatten)]
    pub run: RunFlags,
}

fn parse_replacement(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((name, path)) if !name.is_empty() && !path.is_empty() => Ok((name.into(), path.into())),
        _ => Err("NAME=NEW.step is needed".into()),
    }
}
