//! The command line as the user types it.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

mod align;
mod assemble;
mod check;
mod report;
mod run;

pub use align::{ALIGN_EXAMPLES, AlignArgs, FrameFlag};
pub use assemble::AssembleArgs;
pub use check::{AlignFlag, CHECK_EXAMPLES, CheckArgs};
pub use report::ReportArgs;
pub use run::RunFlags;

/// From a raw 3D scan to a closed CAD solid.
#[derive(Debug, Parser)]
#[command(version, about, long_about = LONG_ABOUT, after_long_help = EXIT_CODES, max_term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Turn a scan into a STEP solid.
    #[command(long_about = CONVERT_ABOUT, after_long_help = CONVERT_EXAMPLES)]
    Convert(Box<ConvertArgs>),
    /// Say what a scan is: counts, holes, noise, likely units and why.
    #[command(after_long_help = INFO_EXAMPLES)]
    Info(InfoArgs),
    /// Take the table, the defects and the noise from a scan, keeping its edges.
    #[command(after_long_help = CLEAN_EXAMPLES)]
    Clean(CleanArgs),
    /// Cut a scan into regions, by the default, a method of the thesis or a baseline, without making a solid.
    #[command(after_long_help = SEGMENT_EXAMPLES)]
    Segment(SegmentArgs),
    /// GPrimDB: a database of generated primitives with their truth, and of parts you scanned.
    #[command(subcommand, after_long_help = GPRIMDB_EXAMPLES)]
    Gprimdb(GprimdbVerb),
    /// Name the type of a segment: by its normals, as the thesis did (rules, then a trained classifier), and by fitted
    /// surfaces, as `convert` does.
    #[command(after_long_help = CLASSIFY_EXAMPLES)]
    Classify(ClassifyArgs),
    /// Train the classifier on a database, with the accuracy of each fold of a cross-validation.
    Train(TrainArgs),
    /// Draw a scan, or the regions that `convert --segments` wrote.
    #[command(after_long_help = RENDER_EXAMPLES)]
    Render(RenderArgs),
    /// Write the result as a document for people: HTML with pictures, Markdown or CSV.
    #[command(after_long_help = report::EXAMPLES)]
    Report(ReportArgs),
    /// Hold a scan against the model it should be: deviations, sizes, places, form, changes, with uncertainties.
    #[command(after_long_help = CHECK_EXAMPLES)]
    Check(Box<CheckArgs>),
    /// Move a scan into the frame of its datums: level, rotate, zero.
    #[command(after_long_help = ALIGN_EXAMPLES)]
    Align(AlignArgs),
    /// Place parts that are modelled already in a scan of the object they make, and write one STEP assembly.
    #[command(after_long_help = assemble::EXAMPLES)]
    Assemble(AssembleArgs),
    /// Fit reference data of all five types whose answers are known, and print the errors.
    Selftest,
}

/// Flags of `classify`.
#[derive(Debug, Args)]
pub struct ClassifyArgs {
    /// A mesh of one segment: STL, PLY, OBJ, OFF or 3MF
    pub segment: PathBuf,
    /// A classifier that `train` wrote [default: the one that comes with the program]
    #[arg(long, value_name = "FILE.svm")]
    pub model: Option<PathBuf>,
    /// Whether normals that fit none of their neighbours are removed first
    #[arg(long, value_enum, default_value_t = OutliersFlag::Keep)]
    pub outliers: OutliersFlag,
}

/// `--outliers`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OutliersFlag {
    /// Every normal counts
    Keep,
    /// Outliers are removed, by the running median of the thesis with our threshold
    Remove,
}

/// Flags of `train`.
#[derive(Debug, Args)]
pub struct TrainArgs {
    /// A database that `gprimdb generate` made
    pub database: PathBuf,
    /// The classifier to write
    #[arg(short, long, value_name = "FILE.svm")]
    pub output: PathBuf,
    /// Folds of the cross-validation
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=100))]
    pub folds: u32,
    /// Threads to work with [default: all processors]; the result is the same
    #[arg(long, value_parser = parse_count)]
    pub threads: Option<usize>,
    /// Overwrite the classifier if it exists
    #[arg(long)]
    pub force: bool,
}

/// Verbs of `gprimdb`.
#[derive(Debug, Subcommand)]
pub enum GprimdbVerb {
    /// Print a ready-made manifest, to change and give to `generate`
    Manifest {
        /// Which one
        #[arg(long, value_enum, default_value_t = TierFlag::Faithful)]
        tier: TierFlag,
    },
    /// Make a database, or go on with one that was stopped
    Generate {
        /// The database to write: an SQLite file
        #[arg(short, long, value_name = "FILE.db")]
        output: PathBuf,
        /// A ready-made manifest
        #[arg(long, value_enum, default_value_t = TierFlag::Faithful, conflicts_with = "manifest")]
        tier: TierFlag,
        /// A manifest of yours
        #[arg(long, value_name = "FILE.toml")]
        manifest: Option<PathBuf>,
        /// Threads to work with [default: all processors]; the result is the same
        #[arg(long, value_parser = parse_count)]
        threads: Option<usize>,
        /// Print nothing but errors
        #[arg(short, long)]
        quiet: bool,
    },
    /// Say what a database holds
    Info {
        /// The database
        database: PathBuf,
    },
    /// Print the truth about one model, as JSON
    Show {
        /// The database
        database: PathBuf,
        /// Its name, such as torus-0012-00
        name: String,
    },
    /// Write the mesh of one model
    Export {
        /// The database
        database: PathBuf,
        /// Its name
        name: String,
        /// The mesh to write
        #[arg(short, long, value_name = "MESH.ply")]
        output: PathBuf,
        /// Overwrite the mesh if it exists
        #[arg(long)]
        force: bool,
    },
    /// Find what is known that a primitive of PART.json may be
    Query {
        /// The database
        database: PathBuf,
        /// The JSON that `convert --json` wrote
        part: PathBuf,
        /// Number of the primitive in it
        #[arg(long, value_name = "ID")]
        primitive: u64,
    },
    /// Add a primitive of PART.json that you have verified; nothing is added by itself
    Add {
        /// The database; made when there is none
        database: PathBuf,
        /// The JSON that `convert --json` wrote
        part: PathBuf,
        /// Number of the primitive in it
        #[arg(long, value_name = "ID")]
        primitive: u64,
        /// Name to keep it under; one of that name is replaced
        #[arg(long)]
        name: String,
        /// Where it comes from and who verified it
        #[arg(long, value_name = "TEXT")]
        provenance: String,
    },
}

/// `--tier`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TierFlag {
    /// Complete and partial models of the five types, clean, on structured grids
    Faithful,
    /// 20 000 models of every resolution, triangulation and noise, and surfaces of other kinds
    Hard,
    /// What normals cannot tell apart
    Ambiguous,
}

/// Flags of `convert`.
#[derive(Debug, Args)]
#[allow(clippy::struct_excessive_bools, reason = "flags")]
pub struct ConvertArgs {
    /// The scan: STL, PLY, OBJ, OFF or 3MF with triangles
    pub scan: PathBuf,
    /// The STEP file to write
    #[arg(short, long, value_name = "PART.step")]
    pub output: PathBuf,
    /// Also write everything that was found, as JSON
    #[arg(long, value_name = "PART.json")]
    pub json: Option<PathBuf>,
    /// Also write the scan with the number of its primitive on every triangle
    #[arg(long, value_name = "SEGMENTS.ply")]
    pub segments: Option<PathBuf>,
    /// Also draw the scan beside the part, from two sides
    #[arg(long, value_name = "PART.png")]
    pub picture: Option<PathBuf>,
    /// Also write everything that was found as a document for people: .html with pictures, .md or .csv
    #[arg(long, value_name = "REPORT.html")]
    pub report: Option<PathBuf>,
    /// Also write the part as a build123d script with named parameters
    #[arg(long, value_name = "PART.py", conflicts_with = "pipeline")]
    pub script: Option<PathBuf>,
    /// The way to the model: ours to a solid, or the thesis's to primitives drawn one by one
    #[arg(long, value_enum, default_value_t = PipelineFlag::Default)]
    pub pipeline: PipelineFlag,
    /// Name the primitives whose sizes a GPrimDB has, within the uncertainties of both
    #[arg(long, value_name = "FILE.db", conflicts_with = "pipeline")]
    pub database: Option<PathBuf>,
    /// What to do with what the database knows
    #[arg(long, value_enum, default_value_t = KnownFlag::Report, requires = "database")]
    pub known: KnownFlag,
    /// The unit of the scan's coordinates; without it the file's own, else millimetres
    #[arg(long, value_enum)]
    pub units: Option<Unit>,
    /// Whether to look for a table under the part and take it away
    #[arg(long, value_enum, default_value_t = SupportFlag::Auto)]
    pub support: SupportFlag,
    /// Direction away from the table, if you know it: X,Y,Z
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_direction, allow_hyphen_values = true)]
    pub up: Option<[f64; 3]>,
    /// Narrowest face worth a surface of its own, in the scan's unit [default: what the scan can show]
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub min_face: Option<f64>,
    /// Largest gap the solid may have, in the scan's unit [default: far below what the scan can show]
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub tolerance: Option<f64>,
    /// Standard uncertainty that you need, in the scan's unit: says of each face whether its sizes are known so well, and
    /// what is missing
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub target: Option<f64>,
    /// Relations between primitives (parallel, coaxial, equal radii, ...): auto, off, or a TOML file that lists those to
    /// make exact
    #[arg(long, value_name = "auto|off|LIST.toml", default_value = "auto", conflicts_with = "pipeline")]
    pub relations: PathBuf,
    /// Standard deviation of what real faces keep from their design by manufacture, in the scan's unit: relations are not
    /// refused for that [default: 0.03 mm, and 0.05 degrees]; 0: none, of angles neither
    #[arg(long, value_name = "LENGTH", value_parser = parse_length_or_zero)]
    pub manufacture: Option<f64>,
    /// What the scanner may be wrong by beside its noise, as standard uncertainty: LENGTH, or LENGTH,SHARE with a share of
    /// every length (0.02,0.00003 is 0.02 and 0.03 per thousand)
    #[arg(long, value_name = "LENGTH[,SHARE]", value_parser = parse_systematic)]
    pub systematic: Option<scanwright::dimension::Systematic>,
    /// Put the round values that measured ones may mean into the model; by default they are offered only
    #[arg(long)]
    pub snap: bool,
    /// The coordinates of everything that is written: the scan's, or those of the part's datums, chosen as `align` does
    #[arg(long, value_enum, default_value_t = FrameFlag::None, conflicts_with = "pipeline")]
    pub align: FrameFlag,
    /// Fallbacks that count as success: a list of open, freeform, facets
    #[arg(long, value_enum, value_delimiter = ',', conflicts_with = "strict")]
    pub allow: Vec<FallbackFlag>,
    /// Write nothing rather than fall back on an open shell, a freeform face or facets
    #[arg(long)]
    pub strict: bool,
    /// Flavour of STEP
    #[arg(long, value_enum, default_value_t = SchemaFlag::Ap242)]
    pub schema: SchemaFlag,
    /// Seed of all random choices
    #[arg(long, default_value_t = scanwright::pipeline::Options::DEFAULT_SEED)]
    pub seed: u64,
    /// Write how long each stage took, as JSON
    #[arg(long, value_name = "FILE")]
    pub timings: Option<PathBuf>,
    /// How the run goes about it
    #[command(flatten)]
    pub run: RunFlags,
}

/// `--pipeline`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PipelineFlag {
    /// A closed solid
    Default,
    /// Part-to-CAD: 3D-NCuts, types by normals, sizes by PGP2X, each primitive drawn over what was seen of it
    Thesis,
}

/// `--known`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum KnownFlag {
    /// Name it in the summary and the JSON
    Report,
    /// Give primitives the stored sizes; where they are stays as measured
    Take,
}

/// Flags of `info`.
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// The scan: STL, PLY, OBJ, OFF or 3MF
    pub scan: PathBuf,
}

/// Flags of `clean`.
#[derive(Debug, Args)]
pub struct CleanArgs {
    /// The scan: STL, PLY, OBJ, OFF or 3MF
    pub scan: PathBuf,
    /// The cleaned mesh; holes stay open
    #[arg(short, long, value_name = "CLEAN.ply")]
    pub output: PathBuf,
    /// How noise is taken off; the strength follows the noise that is measured
    #[arg(long, value_enum, default_value_t = DenoiseFlag::Adaptive)]
    pub denoise: DenoiseFlag,
    /// Whose normals sun2007 and random-walk average
    #[arg(long, value_enum, default_value_t = NeighborsFlag::Vertex)]
    pub neighbors: NeighborsFlag,
    /// Whether to look for a table under the part and take it away
    #[arg(long, value_enum, default_value_t = SupportFlag::Auto)]
    pub support: SupportFlag,
    /// How the run goes about it
    #[command(flatten)]
    pub run: RunFlags,
}

/// `--denoise`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DenoiseFlag {
    /// bilateral where the noise is weak, guided where it is strong
    Adaptive,
    /// The thesis's filter: mean of the neighbours within a threshold (Sun and others 2007)
    Sun2007,
    /// The same with weights by random walks (Sun and others 2008)
    RandomWalk,
    /// Weights by distance and angle (Zheng and others 2011)
    Bilateral,
    /// Weights by distance and by the flattest patch around (Zhang and others 2015)
    Guided,
    /// Vertices stay where they are
    None,
}

/// `--neighbors`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum NeighborsFlag {
    /// Triangles that share a vertex
    Vertex,
    /// Triangles that share an edge
    Edge,
}

/// Flags of `segment`.
#[derive(Debug, Args)]
pub struct SegmentArgs {
    /// The scan: STL, PLY, OBJ, OFF or 3MF
    pub scan: PathBuf,
    /// The scan with the number of its primitive on every triangle
    #[arg(short, long, value_name = "SEGMENTS.ply")]
    pub output: PathBuf,
    /// How the scan is cut
    #[arg(long, value_enum, default_value_t = MethodFlag::Default)]
    pub method: MethodFlag,
    /// Groups that ncuts, pic, hfp and liu-zhang look for; one in several pieces gives several regions [default: found]
    #[arg(long, value_name = "K", value_parser = parse_count)]
    pub regions: Option<usize>,
    /// What ncuts and pic group: patches of triangles, or single vertices as in the thesis, slowly and not too many
    #[arg(long, value_enum, default_value_t = NodesFlag::Patches)]
    pub nodes: NodesFlag,
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

/// `--method`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MethodFlag {
    /// Surfaces grown and fitted, as `convert` does
    Default,
    /// The thesis's 3D-NCuts: normalized cuts of a graph of normals
    Ncuts,
    /// The thesis's 3D-PIC: power iteration clustering of the same graph
    Pic,
    /// Hierarchical fitting primitives (Attene and others 2006): patches merged by how well a surface fits
    Hfp,
    /// Spectral clustering of all distances over the surface (Liu and Zhang 2004)
    LiuZhang,
    /// Peaks of the Gauss map, then mean shift of curvatures (after Xiao and others 2011); finds the number itself
    Xiao,
}

/// `--nodes`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum NodesFlag {
    /// Up to fifteen thousand patches
    Patches,
    /// Every vertex
    Vertices,
}

/// Flags of `render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A scan, or a PLY file with regions from `convert --segments`
    pub scan: PathBuf,
    /// The picture to write
    #[arg(short, long, value_name = "X.png")]
    pub output: PathBuf,
    /// What colors mean; types are read from PART.json beside the PLY file [default: region if there are regions]
    #[arg(long, value_enum)]
    pub color: Option<ColorFlag>,
    /// Direction that is up in the picture: X,Y,Z
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_direction, allow_hyphen_values = true)]
    pub up: Option<[f64; 3]>,
    /// Overwrite the picture if it exists
    #[arg(long)]
    pub force: bool,
}

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Unit {
    /// Millimetre.
    Mm,
    /// Centimetre.
    Cm,
    /// Metre.
    M,
    /// Inch.
    In,
}

/// `--support`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SupportFlag {
    /// Take the table away if there is one
    Auto,
    /// Everything is part
    None,
}

impl From<SupportFlag> for scanwright::pipeline::SupportSearch {
    fn from(flag: SupportFlag) -> Self {
        match flag {
            SupportFlag::Auto => Self::Auto,
            SupportFlag::None => Self::None,
        }
    }
}

/// `--allow`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FallbackFlag {
    /// A shell that is not closed
    Open,
    /// A face without an analytic surface
    Freeform,
    /// Flat faces, one per triangle of the scan
    Facets,
}

/// `--schema`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SchemaFlag {
    /// ISO 10303-242
    Ap242,
    /// ISO 10303-214, for older programs
    Ap214,
}

/// `--color`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ColorFlag {
    /// One color per type of surface
    Type,
    /// One color per region
    Region,
}

fn parse_direction(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    let numbers = numbers.map_err(|_| "three numbers separated by commas are needed, such as 0,0,1")?;
    let direction: [f64; 3] = numbers.try_into().map_err(|_| "exactly three numbers are needed")?;
    let length = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
    if length.is_finite() && length > 0.0 {
        Ok(direction)
    } else {
        Err("a direction has a length".to_owned())
    }
}

fn parse_length(text: &str) -> Result<f64, String> {
    let length: f64 = text.parse().map_err(|_| "a number is needed")?;
    if length.is_finite() && length > 0.0 { Ok(length) } else { Err("a length is positive".to_owned()) }
}

fn parse_length_or_zero(text: &str) -> Result<f64, String> {
    let length: f64 = text.parse().map_err(|_| "a number is needed")?;
    let is_one = length.is_finite() && length >= 0.0;
    if is_one { Ok(length) } else { Err("a length is not negative".to_owned()) }
}

fn parse_systematic(text: &str) -> Result<scanwright::dimension::Systematic, String> {
    let (offset, share) = text.split_once(',').unwrap_or((text, "0"));
    Ok(scanwright::dimension::Systematic {
        offset: parse_length_or_zero(offset)?,
        share: parse_length_or_zero(share)?,
    })
}

fn parse_count(text: &str) -> Result<usize, String> {
    let count: usize = text.parse().map_err(|_| "a whole number is needed")?;
    if count > 0 { Ok(count) } else { Err("at least one is needed".to_owned()) }
}

const LONG_ABOUT: &str = "\
From a raw 3D scan to a closed CAD solid.

A scan is a triangle mesh as a scanner delivers it: noisy, with holes, perhaps with the table under the part. \
scanwright finds the planes, cylinders, cones, spheres and tori it is made of, and writes the part as a STEP file \
that any CAD program opens. Nothing has to be set: noise and resolution are measured from the scan.";

const CONVERT_ABOUT: &str = "\
Turn a scan into a STEP solid.

What the scan does not show is never made up silently: faces that were assumed (under the part, behind holes), and \
faces that are not analytic, are listed in the summary, in the JSON and by name in the STEP file. All outputs appear \
together at the end; a run that fails or is stopped leaves nothing behind.";

const CONVERT_EXAMPLES: &str = "\
Examples:
  scanwright convert bracket.stl -o bracket.step
      The part in STEP, lengths taken as millimetres.
  scanwright convert bracket.ply -o bracket.step --json bracket.json --picture bracket.png
      Also every surface with its uncertainty, and a picture to check by eye.
  scanwright convert bracket.ply -o bracket.step --report bracket.html
      Also a page to hand on: verdict, dimensions, deviation, where to scan again.
  scanwright convert valve.obj -o valve.step --units in --up 0,0,1
      A scan in inches that stood upright on a table.
  scanwright convert lever.ply -o lever.step --script lever.py
      Also its features as a Python script: parameters to edit, one block per feature.
  scanwright convert casting.ply -o casting.step --allow freeform
      Faces that are not analytic are fine: exit 0 although there are some.

Exit codes:
  0  done                                   4  written, but only partly analytic or open
  2  the command line makes no sense        5  an output cannot be written, or exists (see --force)
  3  the scan cannot be read                7  a bug: please report it
                                          130  stopped by Ctrl-C, nothing written";

const INFO_EXAMPLES: &str = "\
Example:
  scanwright info bracket.stl";

const CLEAN_EXAMPLES: &str = "\
Examples:
  scanwright clean bracket.stl -o clean.ply
      The part without table and noise, for other programs; `convert` does its own cleaning.
  scanwright clean bracket.stl -o clean.ply --denoise sun2007 --neighbors edge";

const SEGMENT_EXAMPLES: &str = "\
Examples:
  scanwright segment bracket.stl -o regions.ply
      The regions that `convert` would start from.
  scanwright segment bracket.stl -o regions.ply --method ncuts --regions 12
      The thesis's 3D-NCuts with twelve groups. Draw them: scanwright render regions.ply -o regions.png";

const GPRIMDB_EXAMPLES: &str = "\
Examples:
  scanwright gprimdb generate -o primitives.db
      1 000 clean models, as the thesis had.
  scanwright gprimdb manifest --tier hard > mine.toml
  scanwright gprimdb generate --manifest mine.toml -o mine.db
      A database of your own: change the manifest in between.
  scanwright gprimdb export primitives.db torus-0003-00 -o torus.ply
  scanwright gprimdb add shop.db part.json --primitive 4 --name \"pin 6h6\" --provenance \"gauge room, 2026-11\"
  scanwright gprimdb query shop.db other.json --primitive 2";

const CLASSIFY_EXAMPLES: &str = "\
Examples:
  scanwright classify segment.ply
  scanwright classify segment.ply --outliers remove
      Without the normals that a few wild points left.
  scanwright gprimdb generate --tier hard -o hard.db
  scanwright train hard.db -o hard.svm
  scanwright classify segment.ply --model hard.svm";

const RENDER_EXAMPLES: &str = "\
Examples:
  scanwright render bracket.stl -o bracket.png
      The scan in grey, from two sides.
  scanwright render segments.ply -o regions.png --color region
      One color per region that `convert --segments segments.ply` found.";

const EXIT_CODES: &str = "\
`scanwright convert --help` has examples and the exit codes.";
