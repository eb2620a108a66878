//! The thesis's experiments on denoising, recognition and parameters, run again on generated data.
//!
//! `experiments list` names them; `experiments run NAME... -o DIR` (or `all`) writes a table per experiment, as CSV and as
//! Markdown, and a picture; `experiments draw -o DIR` draws pictures again from the tables there. `docs/experiments.md`
//! shows them.

mod bodies;
mod bound;
mod calibration;
mod comparison;
mod denoising;
mod descriptors;
mod gallery;
mod gauss;
mod hard;
mod models;
mod outliers;
mod parameters;
mod part_to_cad;
mod pictures;
mod plot;
mod recognizers;
mod robustness;
mod table;

use std::path::{Path, PathBuf};

use clap::{Parser, Subcommand};

use plot::Figure;
use table::Table;

/// What experiments are run with.
pub struct Context {
    /// Where tables and pictures go.
    output: PathBuf,
    /// A folder with meshes that are not generated, for the experiments that take some.
    real: Option<PathBuf>,
}

/// One of the experiments.
struct Experiment {
    name: &'static str,
    /// What it reproduces.
    what: &'static str,
    /// Writes its table, and a picture of what the table does not hold.
    run: fn(&Context) -> anyhow::Result<Table>,
    /// A picture of the table; `None` where `run` draws it.
    draw: Option<fn(&Table) -> Figure>,
}

const EXPERIMENTS: [Experiment; 18] = [
    Experiment {
        name: "denoising",
        what: "figures 3.2 to 3.7: error of the normals by method and noise",
        run: denoising::denoising,
        draw: None,
    },
    Experiment {
        name: "gallery",
        what: "normals of one complete and one partial model per type on the Gaussian sphere",
        run: gallery::gallery,
        draw: None,
    },
    Experiment {
        name: "skewness",
        what: "figure 2.17: skewness of 100 spheres and 100 tori",
        run: gauss::skewness,
        draw: None,
    },
    Experiment {
        name: "histograms",
        what: "figure 2.18: sorted histograms of 10 spheres and 10 tori",
        run: gauss::histograms,
        draw: None,
    },
    Experiment {
        name: "statistics",
        what: "table 3.1, in its shape: what the rules look at, by class",
        run: gauss::statistics,
        draw: Some(pictures::statistics),
    },
    Experiment {
        name: "recognition",
        what: "rules, classifier, and both; by triangulation",
        run: gauss::recognition,
        draw: Some(pictures::recognition),
    },
    Experiment {
        name: "descriptors",
        what: "figures 3.19 and 3.20, in their shape: Gsh+s beside D2, Laplacian spectrum and surflet pairs",
        run: comparison::descriptors,
        draw: Some(pictures::descriptors),
    },
    Experiment {
        name: "d2-partial",
        what: "D2 on partial models, by type",
        run: comparison::d2_partial,
        draw: None,
    },
    Experiment {
        name: "decimation",
        what: "recognition by number of triangles and triangulation",
        run: robustness::decimation,
        draw: Some(pictures::decimation),
    },
    Experiment {
        name: "half-angle",
        what: "recognition of slender cones and short arcs",
        run: robustness::half_angle,
        draw: Some(pictures::half_angle),
    },
    Experiment {
        name: "hard",
        what: "recognition on the hard tier: every resolution, triangulation and noise, and what is called ambiguous",
        run: hard::hard,
        draw: Some(pictures::hard),
    },
    Experiment {
        name: "folds",
        what: "table 3.4: C and gamma of each fold",
        run: gauss::folds,
        draw: Some(pictures::folds),
    },
    Experiment {
        name: "cells",
        what: "tables 3.3 and 3.5: number of cells, with and without skewness",
        run: gauss::cells,
        draw: Some(pictures::cells),
    },
    Experiment {
        name: "outliers",
        what: "types by the rules, with and without the removal of outlying normals",
        run: outliers::outliers,
        draw: None,
    },
    Experiment {
        name: "sizes",
        what: "figures 3.25 to 3.29, table 3.2: sizes by PGP2X, LSGE, Attene and us",
        run: parameters::sizes,
        draw: Some(pictures::sizes),
    },
    Experiment {
        name: "bound",
        what: "spread of sizes over the Cramer-Rao bound, by PGP2X, LSGE, Attene and us",
        run: bound::bound,
        draw: Some(pictures::bound),
    },
    Experiment {
        name: "calibration",
        what: "errors over their stated uncertainties, with white and with correlated noise",
        run: calibration::calibration,
        draw: None,
    },
    Experiment {
        name: "part-to-cad",
        what: "Part-to-CAD with its errors on the example scan, and our default",
        run: part_to_cad::part_to_cad,
        draw: None,
    },
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
        /// Where tables and pictures go
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
        /// Meshes that are not generated, for `denoising`: fandisk.obj and rocker-arm.obj
        #[arg(long, value_name = "DIR")]
        real: Option<PathBuf>,
    },
    /// Draw the pictures of tables again
    Draw {
        /// Where the tables are, and the pictures go
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
    },
}

fn main() -> anyhow::Result<()> {
    match Cli::parse().verb {
        Verb::List => {
            for experiment in &EXPERIMENTS {
                println!("{:12} {}", experiment.name, experiment.what);
            }
            Ok(())
        }
        Verb::Run { names, output, real } => run(&names, &Context { output, real }),
        Verb::Draw { output } => draw(&output),
    }
}

fn run(names: &[String], context: &Context) -> anyhow::Result<()> {
    let is_known = |name: &String| name == "all" || EXPERIMENTS.iter().any(|e| e.name == name);
    if let Some(unknown) = names.iter().find(|name| !is_known(name)) {
        anyhow::bail!("there is no experiment `{unknown}`; `list` names them");
    }
    for Experiment { name, what, run, draw } in &EXPERIMENTS {
        if names.iter().any(|n| n == "all" || n == name) {
            let table = run(context)?;
            println!("{name}: {what}\n\n{}", table.markdown());
            if let Some(draw) = draw {
                draw(&table).write(&context.output, name)?;
            }
        }
    }
    Ok(())
}

fn draw(output: &Path) -> anyhow::Result<()> {
    for Experiment { name, draw, .. } in &EXPERIMENTS {
        let Some(draw) = draw else { continue };
        if output.join(name).with_extension("csv").exists() {
            draw(&Table::read(output, name)?).write(output, name)?;
        }
    }
    Ok(())
}
