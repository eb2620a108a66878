//! Flags of `check`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{RunFlags, SupportFlag, Unit, parse_length};

/// Flags of `check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// What the part should be: a STEP file, or a mesh (STL, PLY, OBJ, OFF, 3MF)
    pub model: PathBuf,
    /// The scan: STL, PLY, OBJ, OFF or 3MF with triangles
    pub scan: PathBuf,
    /// How the scan is laid on the model
    #[arg(long, value_enum, default_value_t = AlignFlag::Best)]
    pub align: AlignFlag,
    /// With --align datum: faces of the model that hold the part, by name or number (from 1), most important first
    /// [default: chosen]
    #[arg(long, value_name = "A,B,C", value_delimiter = ',')]
    pub datums: Vec<String>,
    /// Largest deviation allowed, in the scan's unit: of every surface, size and place; without it nothing is decided
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub tolerance: Option<f64>,
    /// Write everything that was found, as JSON
    #[arg(long, value_name = "CHECK.json")]
    pub json: Option<PathBuf>,
    /// Write the scan where the model is, deviations as color and number of every vertex
    #[arg(long, value_name = "CHECK.ply")]
    pub ply: Option<PathBuf>,
    /// Draw deviations, and the model's faces with what was not seen, from two sides
    #[arg(long, value_name = "CHECK.png")]
    pub picture: Option<PathBuf>,
    /// Write the feature table
    #[arg(long, value_name = "CHECK.csv")]
    pub csv: Option<PathBuf>,
    /// Write the model's faces with their measured values, as JSON
    #[arg(long, value_name = "UPDATED.json")]
    pub update: Option<PathBuf>,
    /// The unit of the scan's coordinates; without it the file's own, else millimetres
    #[arg(long, value_enum)]
    pub units: Option<Unit>,
    /// Whether to look for a table under the part and take it away
    #[arg(long, value_enum, default_value_t = SupportFlag::Auto)]
    pub support: SupportFlag,
    /// Seed of all random choices
    #[arg(long, default_value_t = scanwright::pipeline::Options::DEFAULT_SEED)]
    pub seed: u64,
    /// How the run goes about it
    #[command(flatten)]
    pub run: RunFlags,
}

/// `--align` of `check`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AlignFlag {
    /// Best fit: least squares, what was changed counting less
    Best,
    /// By datums: the first holds three freedoms, the second two, the third one
    Datum,
    /// As the scan lies
    None,
}

impl AlignFlag {
    /// Name for files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Best => "best",
            Self::Datum => "datum",
            Self::None => "none",
        }
    }
}

/// Examples of `check`.
pub const CHECK_EXAMPLES: &str = "\
Examples:
  scanwright check bracket.step bracket.ply --tolerance 0.1 --json check.json --picture check.png
      Does every seen surface, size and place keep 0.1 mm? Exit 0 only when all is seen and shown to.
  scanwright check bracket.step bracket.ply --align datum --datums 4,7,2
      Laid on faces 4, 7 and 2 of the model, as a fixture would hold it.
  scanwright check old.step scan.ply --update new.json
      What has changed on the part, and the model's faces with their measured values.

Exit codes:
  0  in tolerance, or no tolerance given    4  something fails, is undecided or was not seen
  2  the command line makes no sense        5  an output cannot be written, or exists (see --force)
  3  model or scan cannot be read, or the   7  a bug: please report it
     scan cannot be laid on the model     130  stopped by Ctrl-C, nothing written";
