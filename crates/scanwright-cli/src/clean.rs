//! `scanwright clean`.

use scanwright::denoise::{DenoiseMethod, Neighbors, Sun2007, Weighting};
use scanwright::io;
use scanwright::pipeline::{self, Cleaned, Options};
use scanwright::progress::Progress;

use crate::args::{CleanArgs, DenoiseFlag, NeighborsFlag};
use crate::console::{self, Console};
use crate::exit::{Code, Failure};
use crate::{outputs, scan};

/// Takes table, defects and noise from a scan.
pub fn run(args: &CleanArgs) -> Result<Code, Failure> {
    let is_suns = matches!(args.denoise, DenoiseFlag::Sun2007 | DenoiseFlag::RandomWalk);
    if args.neighbors == NeighborsFlag::Edge && !is_suns {
        return Err(Failure::Usage("--neighbors is for --denoise sun2007 and random-walk".into()));
    }
    outputs::check(&args.scan, &[&args.output], args.run.force)?;
    console::watched(args.run.quiet, args.run.threads, |console| clean(args, console))
}

fn clean(args: &CleanArgs, console: &Console) -> Result<Code, Failure> {
    let file = scan::read(&args.scan)?;
    let progress = Progress::new(|stage, fraction| console.note(stage, fraction));
    let options = Options { support: args.support.into(), ..Options::default() };
    let cleaned = pipeline::clean(&file.mesh, &options, method(args).as_ref(), &progress)
        .map_err(|error| Failure::of_run(&args.scan, error))?;
    outputs::write(&[(&args.output, io::write_ply(&cleaned.mesh, None, None))])?;
    console.finish();
    if !args.run.quiet {
        println!("{}", summary(&cleaned));
        console.log(&crate::summary::timings_line(&console.timings()));
    }
    Ok(Code::Done)
}

fn method(args: &CleanArgs) -> Option<DenoiseMethod> {
    let neighbors = match args.neighbors {
        NeighborsFlag::Vertex => Neighbors::Vertex,
        NeighborsFlag::Edge => Neighbors::Edge,
    };
    let suns = |weighting| DenoiseMethod::Sun2007(Sun2007 { neighbors, weighting, ..Sun2007::default() });
    let [adaptive, _, bilateral, guided] = DenoiseMethod::all_defaults();
    Some(match args.denoise {
        DenoiseFlag::None => return None,
        DenoiseFlag::Adaptive => adaptive,
        DenoiseFlag::Sun2007 => suns(Weighting::Threshold),
        DenoiseFlag::RandomWalk => suns(Weighting::RandomWalk { steps: 1 }),
        DenoiseFlag::Bilateral => bilateral,
        DenoiseFlag::Guided => guided,
    })
}

/// What was there and what was done, for people.
fn summary(cleaned: &Cleaned) -> String {
    let Cleaned { mesh, measured, support, moved_rms, .. } = cleaned;
    let table = support.as_ref().map_or(0, |s| s.on_table.iter().filter(|on| **on).count());
    let table = if table > 0 { format!("{table} triangles taken away") } else { "none found".to_owned() };
    format!(
        "mesh      {} triangles, {} vertices\n\
         table     {table}\n\
         noise     {:.3}; vertices moved by {moved_rms:.3} rms, in the scan's unit",
        mesh.triangles.len(),
        mesh.vertices.len(),
        measured.noise,
    )
}
