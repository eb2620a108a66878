//! Flags of `align`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{RunFlags, SupportFlag};

/// Flags of `align`.
#[derive(Debug, Args)]
pub struct AlignArgs {
    /// The scan: STL, PLY, OBJ, OFF or 3MF with triangles
    pub scan: PathBuf,
    /// The scan in the frame of its datums
    #[arg(short, long, value_name = "ALIGNED.ply")]
    pub output: PathBuf,
    /// Choose the datums: the largest plane or the main axis, what stands across it, symmetry [default without the others]
    #[arg(long, conflicts_with_all = ["level", "rotate", "zero"])]
    pub auto: bool,
    /// Primitive that is level: a plane becomes z = 0 with its material below, an axis becomes z
    #[arg(long, value_name = "ID", requires = "rotate")]
    pub level: Option<usize>,
    /// Primitive that stops the turn about z: the normal of a plane or an axis becomes x, or the way to a parallel axis or a
    /// centre
    #[arg(long, value_name = "ID", requires = "level")]
    pub rotate: Option<usize>,
    /// Primitive that is at the origin, as far as it fixes a place; the others fix what it leaves
    #[arg(long, value_name = "ID", requires = "level")]
    pub zero: Option<usize>,
    /// Write the motion, the datums and how they were chosen, as JSON
    #[arg(long, value_name = "ALIGNED.json")]
    pub json: Option<PathBuf>,
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

/// `--align` of `convert`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FrameFlag {
    /// The scan's
    None,
    /// The frame of the largest plane or main axis, what stands across it, and symmetry
    Auto,
}

/// Examples of `align`.
pub const ALIGN_EXAMPLES: &str = "\
Examples:
  scanwright align bracket.ply -o aligned.ply --json aligned.json
      Datums chosen; the JSON has the motion and says which.
  scanwright convert bracket.ply -o bracket.step --json bracket.json
  scanwright align bracket.ply -o aligned.ply --level 0 --rotate 3 --zero 7
      Primitive 0 level, the turn stopped by primitive 3, the origin on the axis of bore 7: numbers as in bracket.json.";
