//! The thesis's experiments on denoising, recognition and parameters, run again on generated data.
//!
//! `experiments list` names them; `experiments run NAME... -o DIR` (or `all`) writes a table per experiment, as CSV and as
//! Markdown. `docs/experiments.md` shows them.

mod bodies;
mod denoising;
mod gauss;
mod models;
mod outliers;
mod parameters;
mod table;

use std::path::PathBuf;

use clap::{Parser, Subcommand};

use table::Table;

/// What experiments are run with.
pub struct Context {
    /// Where tables go.
    output: PathBuf,
    /// A folder with meshes that are not generated, for the experiments that take some.
    real: Option<PathBuf>,
}

/// A name, what it reproduces, and how.
type Experiment = (&'static str, &'static str, fn(&Context) -> anyhow::Result<Table>);

const EXPERIMENTS: [Experiment; 9] = [
    ("denoising", "figures 3.2 to 3.7: error of the normals by method and noise", denoising::denoising),
    ("skewness", "figure 2.17: skewness of 100 spheres and 100 tori", gauss::skewness),
    ("histograms", "figure 2.18: sorted histograms of 10 spheres and 10 tori", gauss::histograms),
    ("statistics", "table 3.1, in its shape: what the rules look at, by class", gauss::statistics),
    ("recognition", "rules, classifier, and both; by triangulation", gauss::recognition),
    ("folds", "table 3.4: C and gamma of each fold", gauss::folds),
    ("cells", "tables 3.3 and 3.5: number of cells, with and without skewness", gauss::cells),
    ("outliers", "types by the rules, with and without the removal of outlying normals", outliers::outliers),
    ("sizes", "figures 3.25 to 3.29, table 3.2: sizes by PGP2X, LSGE, Attene and us", parameters::sizes),
];

/// The thesis's experiments, on generated data.
#[derive(Debug, Parser)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Name the experiments
    List,
    /// Run some of them, or `all`
    Run {
        /// Their names
        #[arg(required = true)]
        names: Vec<String>,
        /// Where tables go
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
        /// Meshes that are not generated, for `denoising`: fandisk.obj and rocker-arm.obj
        #[arg(long, value_name = "DIR")]
        real: Option<PathBuf>,
    },
}

fn main() -> anyhow::Result<()> {
    match Cli::parse().verb {
        Verb::List => {
            for (name, what, _) in EXPERIMENTS {
                println!("{name:12} {what}");
            }
        }
        Verb::Run { names, output, real } => {
            let is_known = |name: &String| name == "all" || EXPERIMENTS.iter().any(|e| e.0 == name);
            if let Some(unknown) = names.iter().find(|name| !is_known(name)) {
                anyhow::bail!("there is no experiment `{unknown}`; `list` names them");
            }
            let context = Context { output, real };
            for (name, what, run) in EXPERIMENTS {
                if names.iter().any(|n| n == "all" || n == name) {
                    println!("{name}: {what}\n\n{}", run(&context)?.markdown());
                }
            }
        }
    }
    Ok(())
}
