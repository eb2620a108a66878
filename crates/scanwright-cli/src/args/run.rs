//! Flags of every verb that works on a scan and writes files.

use clap::Args;

use super::parse_count;

/// How a run goes about it.
#[derive(Debug, Clone, Copy, Args)]
pub struct RunFlags {
    /// Threads to work with [default: all processors]; the result is the same
    #[arg(long, value_parser = parse_count)]
    pub threads: Option<usize>,
    /// Overwrite outputs that exist
    #[arg(long)]
    pub force: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}
