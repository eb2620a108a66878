//! The whole path, from a mesh to a solid.
//!
//! [`run`] calls the stages in order and returns everything they found as plain data. It reads no file, no clock and
//! no environment; [`Progress`] is how a caller watches it, measures it or stops it. What the scan does not support
//! is never an error: it is a [`Warning`] in the result. The only errors are a mesh with nothing in it, one too large
//! for the method asked for, and a caller that said stop.

mod attempt;
mod model;
mod placement;
mod stages;
mod thesis;
mod warning;

pub use placement::Placement;
pub use thesis::run_thesis;
pub use warning::{Code, Fallback, Warning};

use crate::brep::Solid;
use crate::condition::{self, ConditionReport, Support};
use crate::denoise::{self, DenoiseMethod};
use crate::deviation::{self, Deviation};
use crate::dimension::{Dimension, Systematic};
use crate::fit::Noise;
use crate::math::{Point3, UnitVec3};
use crate::mesh::{Adjacency, Mesh, TriId};
use crate::par;
use crate::progress::{Cancelled, Progress, Stage};
use crate::recognize::{self, Primitive, Sufficiency};
use crate::regularize::{Manufacture, Relation, Relations};
use crate::segment::{self, RegionId, SegmentMethod, Segmentation};
use crate::tolerance::{Measured, Tolerances};

use attempt::Attempt;

/// What the caller may choose. Everything else is measured from the scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Seed of all random choices.
    pub seed: u64,
    /// Largest gap of the solid, length; measured when `None`.
    pub gap: Option<f64>,
    /// Narrowest face worth a surface of its own, length; measured when `None`.
    pub min_face: Option<f64>,
    /// How the part is segmented.
    pub method: SegmentMethod,
    /// Whether a supporting table is looked for.
    pub support: SupportSearch,
    /// Direction away from the supporting table, if known.
    pub up: Option<UnitVec3>,
    /// Standard uncertainty that the sizes of every face shall have, length; not judged when `None`.
    pub target: Option<f64>,
    /// Which relations between primitives are made exact.
    pub relations: Relations,
    /// What real faces deviate by from their design; a relation is not refused for that.
    pub manufacture: Manufacture,
    /// What the scanner may be wrong by beside its noise.
    pub systematic: Systematic,
    /// Length of the scan's unit in millimetres: round values and holes of threads depend on it.
    pub millimetres: f64,
    /// Whether round values replace measured ones.
    pub snap: bool,
    /// In which coordinates the result is.
    pub coordinates: Coordinates,
}

/// In which coordinates a result is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coordinates {
    /// The scan's.
    #[default]
    Scan,
    /// Those of the part's datums, chosen: see [`crate::datum`]. The scan's where there is none.
    Datums,
}

impl Options {
    /// The seed used when none is given.
    pub const DEFAULT_SEED: u64 = 1;
}

impl Default for Options {
    /// Seed 1; the rest measured; fit-driven; the table and relations looked for; the scan's coordinates.
    fn default() -> Self {
        Self {
            seed: Self::DEFAULT_SEED,
            gap: None,
            min_face: None,
            method: SegmentMethod::default(),
            support: SupportSearch::Auto,
            up: None,
            target: None,
            relations: Relations::Auto,
            manufacture: Manufacture::default(),
            systematic: Systematic::default(),
            millimetres: 1.0,
            snap: false,
            coordinates: Coordinates::Scan,
        }
    }
}

/// Whether a supporting table is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SupportSearch {
    /// Looked for, and taken away when there is one.
    #[default]
    Auto,
    /// Everything in the scan is part.
    None,
}

/// Why a run has no result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The mesh has no triangle with an area.
    #[error("the scan has no triangles with an area: {n_triangles} triangles, {n_vertices} vertices")]
    Empty {
        /// Triangles in the scan.
        n_triangles: usize,
        /// Vertices in the scan.
        n_vertices: usize,
    },
    /// The method works on vertices, and the part has more than its vectors can be kept for.
    #[error(
        "the part has {n_vertices} vertices, and the method can group {most} at most, as its eigenvectors must fit in 2 GiB: \
         group patches instead, or ask for fewer regions"
    )]
    TooManyVertices {
        /// Vertices of the part.
        n_vertices: usize,
        /// See [`SegmentMethod::most_vertices`].
        most: usize,
    },
    /// The progress callback said stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Everything that was found in one scan.
#[derive(Debug, Clone)]
pub struct Reconstruction {
    /// The conditioned scan: welded, manifold, oriented. The supporting table is still in it.
    pub mesh: Mesh,
    /// One per triangle of `mesh`: the triangle of the scan it came from.
    pub source_triangle: Vec<TriId>,
    /// What conditioning found and did.
    pub conditioned: ConditionReport,
    /// What the scanner did.
    pub measured: Measured,
    /// Its noise, as what is left of it on the faces shows it.
    pub noise: Noise,
    /// Thresholds of the run.
    pub tolerances: Tolerances,
    /// The supporting table, if there was one.
    pub support: Option<Support>,
    /// Regions of `mesh` and their primitives, after regularization.
    pub segmentation: Segmentation,
    /// Relations between the primitives, made exact and refused.
    pub relations: Vec<Relation>,
    /// Sizes, distances and angles as measured, with the round values they may mean.
    pub dimensions: Vec<Dimension>,
    /// The solids.
    pub model: Model,
    /// Signed distances of the part's vertices to the model; `None` without a model.
    pub deviation: Option<Deviation>,
    /// How the result, `mesh` with it, came into the frame of its datums; `None` in the scan's coordinates.
    pub placement: Option<Placement>,
    /// What was assumed, replaced or not found, in the order of the stages.
    pub warnings: Vec<Warning>,
}

impl Reconstruction {
    /// The region of every triangle of the scan as it was given; `None` where there is none. `n_triangles` is the
    /// scan's count: triangles that conditioning dropped have no region.
    pub fn labels_of_scan(&self, n_triangles: usize) -> Vec<Option<RegionId>> {
        labels_of_scan(&self.segmentation, &self.source_triangle, n_triangles)
    }

    /// Whether enough was seen of each region for its sizes to be known within `target`: see [`recognize::sufficiency`].
    pub fn sufficiency(&self, target: f64) -> Vec<Option<Sufficiency>> {
        let n = self.segmentation.primitives.len();
        let mut vertices: Vec<Vec<u32>> = vec![Vec::new(); n];
        for (triangle, label) in self.mesh.triangles.iter().zip(&self.segmentation.labels) {
            if let Some(region) = label {
                vertices[region.0 as usize].extend(triangle);
            }
        }
        par::map_indices(n, |k| {
            let mut mine = vertices[k].clone();
            mine.sort_unstable();
            mine.dedup();
            let points: Vec<Point3> = mine.iter().map(|v| self.mesh.vertices[*v as usize]).collect();
            recognize::sufficiency(&self.segmentation.primitives[k], &points, target, &self.noise)
        })
    }

    /// The fallbacks that were needed, each kind once, ascending.
    pub fn fallbacks(&self) -> Vec<Fallback> {
        let mut kinds: Vec<Fallback> = self.warnings.iter().filter_map(|w| w.code.fallback()).collect();
        kinds.sort_unstable();
        kinds.dedup();
        kinds
    }
}

/// The solids of a run and what is known about them.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// One per connected part of the scan; what STEP holds.
    pub solids: Vec<Solid>,
    /// One per solid.
    pub facts: Vec<SolidFacts>,
    /// Triangles of all solids, for pictures and distances.
    pub mesh: Mesh,
    /// One per triangle of `mesh`: the region whose surface the face lies on.
    pub regions: Vec<RegionId>,
    /// One per region: those of the scan, then those that were assumed.
    pub primitives: Vec<Primitive>,
    /// One per triangle of `mesh`: whether its face was invented to close the solid.
    pub assumed: Vec<bool>,
}

/// Counts and measures of one solid.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct SolidFacts {
    /// Whether every edge is used twice in opposite senses.
    pub closed: bool,
    /// Number of faces.
    pub n_faces: usize,
    /// Number of edges.
    pub n_edges: usize,
    /// Number of vertices.
    pub n_vertices: usize,
    /// Faces invented where the scan saw nothing.
    pub n_assumed: usize,
    /// Volume, cubed length.
    pub volume: f64,
    /// Largest gap between a vertex or edge and its surfaces, length.
    pub largest_gap: f64,
    /// What `brep::check` found, one sentence each; empty when the solid is valid.
    pub problems: Vec<String>,
}

/// A scan cut into regions, without a solid.
#[derive(Debug, Clone)]
pub struct Segmented {
    /// The conditioned scan; the supporting table is still in it.
    pub mesh: Mesh,
    /// One per triangle of `mesh`: the triangle of the scan it came from.
    pub source_triangle: Vec<TriId>,
    /// Thresholds of the run.
    pub tolerances: Tolerances,
    /// The supporting table, if there was one.
    pub support: Option<Support>,
    /// Its regions, as the method found them.
    pub segmentation: Segmentation,
}

impl Segmented {
    /// See [`Reconstruction::labels_of_scan`].
    pub fn labels_of_scan(&self, n_triangles: usize) -> Vec<Option<RegionId>> {
        labels_of_scan(&self.segmentation, &self.source_triangle, n_triangles)
    }
}

fn labels_of_scan(
    segmentation: &Segmentation,
    source_triangle: &[TriId],
    n_triangles: usize,
) -> Vec<Option<RegionId>> {
    let mut labels = vec![None; n_triangles];
    for (label, &source) in segmentation.labels.iter().zip(source_triangle) {
        labels[source as usize] = *label;
    }
    labels
}

/// The stages of [`run`] up to the regions.
pub fn segment(mesh: &Mesh, options: &Options, progress: &Progress) -> Result<Segmented, Error> {
    let Regions { scan, support, part, segmentation } = regions(mesh, options, progress)?;
    let segmentation = stages::on_scan(&scan, &part, &segmentation);
    let stages::Scan { mesh, source_triangle, tolerances, .. } = scan;
    Ok(Segmented { mesh, source_triangle, tolerances, support, segmentation })
}

/// Reconstructs the parts in `mesh`. The same bytes for the same input and options, whatever the thread count.
pub fn run(mesh: &Mesh, options: &Options, progress: &Progress) -> Result<Reconstruction, Error> {
    run_revised(mesh, options, progress, &mut |_| ())
}

/// [`run`] with a word of the caller: `revise` sees the regular primitives before solids are made of them, and may give
/// them what is known of them from elsewhere.
pub fn run_revised(
    mesh: &Mesh,
    options: &Options,
    progress: &Progress,
    revise: &mut dyn FnMut(&mut [Primitive]),
) -> Result<Reconstruction, Error> {
    let mut regions = regions(mesh, options, progress)?;
    let stated = stages::stated(&regions.part, &regions.segmentation, &regions.scan.tolerances);
    progress.report(Stage::Regularize, 1.0)?;

    let Attempt { segmentation, relations, dimensions, mut model, mut warnings, mut deviation } =
        attempt::best(&regions, &stated, options, revise);
    regions.segmentation = segmentation;
    let placement = match options.coordinates {
        Coordinates::Scan => None,
        Coordinates::Datums => regions.enter_datums(),
    };
    let Regions { scan, support, part, segmentation } = &regions;
    if placement.is_some() {
        (model, warnings) = model::build(&part.mesh, segmentation, support.as_ref(), &scan.tolerances);
        deviation = deviation::measure(&part.mesh.vertices, &model.mesh);
    }
    progress.report(Stage::Build, 1.0)?;

    let result = reconstruction(regions, stated.noise, model, deviation, warnings);
    Ok(Reconstruction { relations, dimensions, placement, ..result })
}

/// What was found. `warnings`: those about the model.
fn reconstruction(
    regions: Regions,
    noise: Noise,
    model: Model,
    deviation: Option<Deviation>,
    warnings: Vec<Warning>,
) -> Reconstruction {
    let Regions { scan, support, part, segmentation } = regions;
    let segmentation = stages::on_scan(&scan, &part, &segmentation);
    let of_regions = warning::of_segmentation(&scan.mesh, &segmentation, support.as_ref());
    let warnings = warning::without_repeats(of_regions, warnings);
    let stages::Scan { mesh, source_triangle, report, measured, tolerances, .. } = scan;
    Reconstruction {
        mesh,
        source_triangle,
        conditioned: report,
        measured,
        noise,
        tolerances,
        support,
        segmentation,
        relations: Vec::new(),
        dimensions: Vec::new(),
        model,
        deviation,
        placement: None,
        warnings,
    }
}

/// The scan, its table, the part on it, and the part's regions.
struct Regions {
    scan: stages::Scan,
    support: Option<Support>,
    part: stages::Part,
    segmentation: Segmentation,
}

impl Regions {
    /// Moves everything into the frame of the part's datums.
    fn enter_datums(&mut self) -> Option<Placement> {
        let Self { scan, support, part, segmentation } = self;
        let placement = placement::find(&part.mesh, segmentation, support.as_ref(), &scan.tolerances)?;
        let pose = &placement.pose;
        scan.mesh = scan.mesh.moved(pose);
        part.mesh = part.mesh.moved(pose);
        *support = support.as_ref().map(|s| placement::moved_support(s, pose));
        for primitive in &mut segmentation.primitives {
            *primitive = primitive.moved(pose);
        }
        Some(placement)
    }
}

/// A scan made ready for other programs.
#[derive(Debug, Clone)]
pub struct Cleaned {
    /// The part without its table: welded, manifold, oriented, its vertices moved after the filtered normals.
    pub mesh: Mesh,
    /// What conditioning found and did.
    pub conditioned: ConditionReport,
    /// What the scanner did.
    pub measured: Measured,
    /// The supporting table, if there was one.
    pub support: Option<Support>,
    /// Root mean square of how far vertices were moved, length.
    pub moved_rms: f64,
}

/// The stages before the regions: conditioning, removal of the table, and denoising by `method`, or none. Holes are not
/// filled.
pub fn clean(
    mesh: &Mesh,
    options: &Options,
    method: Option<&DenoiseMethod>,
    progress: &Progress,
) -> Result<Cleaned, Error> {
    let Prepared { scan, support, part } = prepared(mesh, options, progress)?;
    let mut mesh = part.mesh;
    let mut moved_rms = 0.0;
    if let Some(method) = method {
        let denoised = denoise::denoise(&mesh, &part.adjacency, &scan.tolerances, method);
        let ways = mesh.vertices.iter().zip(&denoised.vertices).map(|(a, b)| (a - b).norm_squared());
        moved_rms = (ways.sum::<f64>() / mesh.vertices.len().max(1) as f64).sqrt();
        mesh.vertices = denoised.vertices;
    }
    progress.report(Stage::Denoise, 1.0)?;
    Ok(Cleaned { mesh, conditioned: scan.report, measured: scan.measured, support, moved_rms })
}

/// What a segment is: a mesh that is one region, conditioned, its noise measured.
pub fn recognize(segment: &Mesh) -> Result<Primitive, Error> {
    let mesh = condition::condition(segment).mesh;
    if mesh.triangles.is_empty() {
        return Err(Error::Empty {
            n_triangles: segment.triangles.len(),
            n_vertices: segment.vertices.len(),
        });
    }
    let adjacency = Adjacency::new(&mesh);
    let tolerances = Tolerances::new(condition::measure(&mesh, &adjacency), None);
    let normals = denoise::ring_filtered_normals(&mesh, &adjacency, &tolerances);
    Ok(segment::as_one(&mesh, &adjacency, &normals, &tolerances))
}

/// The scan, its table, and the part on it.
struct Prepared {
    scan: stages::Scan,
    support: Option<Support>,
    part: stages::Part,
}

fn prepared(mesh: &Mesh, options: &Options, progress: &Progress) -> Result<Prepared, Error> {
    progress.report(Stage::Condition, 0.0)?;
    let conditioned = condition::condition(mesh);
    if conditioned.mesh.triangles.is_empty() {
        return Err(Error::Empty { n_triangles: mesh.triangles.len(), n_vertices: mesh.vertices.len() });
    }
    let scan = stages::measure(conditioned, options);
    progress.report(Stage::Condition, 1.0)?;

    let support = stages::find_support(&scan, options);
    progress.report(Stage::Support, 1.0)?;

    let part = stages::part(&scan, support.as_ref());
    Ok(Prepared { scan, support, part })
}

fn regions(mesh: &Mesh, options: &Options, progress: &Progress) -> Result<Regions, Error> {
    let Prepared { scan, support, part } = prepared(mesh, options, progress)?;
    let n_vertices = part.mesh.vertices.len();
    if let Some(most) = options.method.most_vertices().filter(|most| n_vertices > *most) {
        return Err(Error::TooManyVertices { n_vertices, most });
    }
    let normals = stages::denoise(&part, &scan.tolerances);
    progress.report(Stage::Denoise, 1.0)?;

    let segmentation = stages::segment(&part, &normals, support.as_ref(), &scan.tolerances, options);
    progress.report(Stage::Segment, 1.0)?;
    Ok(Regions { scan, support, part, segmentation })
}
