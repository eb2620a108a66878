//! `scanwright segment`.

use std::collections::BTreeMap;

use scanwright::io;
use scanwright::pipeline::{self, Options, Segmented};
use scanwright::progress::Progress;
use scanwright::report;
use scanwright::segment::{Baseline, MOST_ASKED, Nodes, SegmentMethod, Spectral};

use crate::args::{MethodFlag, NodesFlag, SegmentArgs};
use crate::console::{self, Console};
use crate::exit::{Code, Failure};
use crate::{outputs, scan};

/// Cuts a scan into regions.
pub fn run(args: &SegmentArgs) -> Result<Code, Failure> {
    let is_spectral = matches!(args.method, MethodFlag::Ncuts | MethodFlag::Pic);
    if args.nodes == NodesFlag::Vertices && !is_spectral {
        return Err(Failure::Usage("--nodes is for --method ncuts and pic".into()));
    }
    if args.regions.is_some() && matches!(args.method, MethodFlag::Default | MethodFlag::Xiao) {
        let text =
            "--regions is for --method ncuts, pic, hfp and liu-zhang; default and xiao find the number";
        return Err(Failure::Usage(text.into()));
    }
    if args.regions.is_some_and(|k| k > MOST_ASKED) {
        return Err(Failure::Usage(format!("--regions: {MOST_ASKED} at most")));
    }
    outputs::check(&args.scan, &[&args.output], args.run.force)?;
    console::watched(args.run.quiet, args.run.threads, |console| segment(args, console))
}

fn segment(args: &SegmentArgs, console: &Console) -> Result<Code, Failure> {
    let file = scan::read(&args.scan)?;
    let progress = Progress::new(|stage, fraction| console.note(stage, fraction));
    let segmented = pipeline::segment(&file.mesh, &options(args), &progress)
        .map_err(|error| Failure::of_run(&args.scan, error))?;
    let ids = report::segment_ids(&segmented.labels_of_scan(file.mesh.triangles.len()));
    outputs::write(&[(&args.output, io::write_ply(&file.mesh, Some(("primitive", &ids)), None))])?;
    console.finish();
    if !args.run.quiet {
        println!("{}", summary(&segmented));
        console.log(&crate::summary::timings_line(&console.timings()));
    }
    Ok(Code::Done)
}

/// How many regions of which type.
fn summary(segmented: &Segmented) -> String {
    let primitives = &segmented.segmentation.primitives;
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for primitive in primitives {
        *counts.entry(primitive.kind().map_or("freeform", |kind| kind.name())).or_default() += 1;
    }
    let types: Vec<String> = counts.iter().map(|(name, n)| format!("{n} {name}")).collect();
    format!("regions   {}: {}", primitives.len(), types.join(", "))
}

fn options(args: &SegmentArgs) -> Options {
    let nodes = match args.nodes {
        NodesFlag::Patches => Nodes::Patches,
        NodesFlag::Vertices => Nodes::Vertices,
    };
    let spectral = Spectral { n_regions: args.regions, nodes, seed: args.seed };
    let baseline = Baseline { n_regions: args.regions, seed: args.seed };
    Options {
        seed: args.seed,
        method: match args.method {
            MethodFlag::Default => SegmentMethod::FitDriven,
            MethodFlag::Ncuts => SegmentMethod::NCuts(spectral),
            MethodFlag::Pic => SegmentMethod::Pic(spectral),
            MethodFlag::Hfp => SegmentMethod::Hfp(baseline),
            MethodFlag::LiuZhang => SegmentMethod::LiuZhang(baseline),
            MethodFlag::Xiao => SegmentMethod::Xiao { seed: args.seed },
        },
        support: args.support.into(),
        ..Options::default()
    }
}
