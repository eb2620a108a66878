//! The result as data: `part.json` and the labels of `segments.ply`.
//!
//! The schema is documented in `docs/output.md`. Keys come in declaration order, numbers in their shortest form that
//! reads back the same, and what is not a number is `null`: the same result is the same bytes.

mod geometry;
mod regions;

pub use geometry::Geometry;
pub use regions::{Neighbor, PrimitiveReport};

use serde::Serialize;

use crate::condition::ConditionReport;
use crate::pipeline::{Options, Reconstruction, SolidFacts, SupportSearch, Warning};
use crate::recognize::Residual;

/// Name and version of the schema.
pub const SCHEMA: &str = "scanwright/result/1";

/// What the result does not know about itself.
#[derive(Debug, Clone)]
pub struct Context<'a> {
    /// Version of the program.
    pub version: &'a str,
    /// The unit of all lengths.
    pub units: Units,
    /// The options of the run.
    pub options: &'a Options,
    /// Triangles of the scan as it was read.
    pub n_triangles: usize,
    /// Vertices of the scan as it was read.
    pub n_vertices: usize,
}

/// The unit of all lengths of a report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Units {
    /// Abbreviation.
    pub name: String,
    /// Length of the unit in millimetres.
    pub millimetres: f64,
    /// Who said so: `flag`, `file` or `assumed`.
    pub source: String,
}

/// The document written as `part.json`.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    schema: &'static str,
    version: String,
    units: Units,
    settings: Settings,
    scan: Scan,
    support: Option<Support>,
    primitives: Vec<PrimitiveReport>,
    solids: Vec<SolidFacts>,
    deviation: Option<DeviationReport>,
    warnings: Vec<Warning>,
}

#[derive(Debug, Clone, Serialize)]
struct Settings {
    seed: u64,
    gap: f64,
    min_face: Option<f64>,
    support: &'static str,
    up: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Serialize)]
struct Scan {
    triangles: usize,
    vertices: usize,
    conditioned: ConditionReport,
    area: f64,
    area_explained: f64,
    diagonal: f64,
    spacing: f64,
    noise: f64,
    normal_noise: f64,
    edge_rounding: f64,
}

#[derive(Debug, Clone, Serialize)]
struct Support {
    #[serde(flatten)]
    plane: Geometry,
    triangles: usize,
    outlines: usize,
}

#[derive(Debug, Clone, Serialize)]
struct DeviationReport {
    #[serde(flatten)]
    residual: Residual,
    within_three_noise: f64,
}

/// Sigmas of noise within which a point counts as on the model: 99.7 % of a normal distribution.
const SIGMAS_WITHIN: f64 = 3.0;

impl Report {
    /// The report of one run.
    pub fn new(result: &Reconstruction, context: &Context) -> Self {
        let support = result.support.as_ref().map(|support| Support {
            plane: Geometry::of_plane(&support.plane),
            triangles: support.on_table.iter().filter(|on| **on).count(),
            outlines: support.outlines.len(),
        });
        let noise = result.measured.noise;
        let deviation = result.deviation.as_ref().map(|deviation| DeviationReport {
            residual: deviation.residual,
            within_three_noise: deviation.share_within(SIGMAS_WITHIN * noise),
        });
        Self {
            schema: SCHEMA,
            version: context.version.to_owned(),
            units: context.units.clone(),
            settings: Settings::new(result, context.options),
            scan: Scan::new(result, context),
            support,
            primitives: regions::primitives(result, context.n_triangles),
            solids: result.model.solids.clone(),
            deviation,
            warnings: result.warnings.clone(),
        }
    }

    /// The text of `part.json`.
    pub fn to_json(&self) -> String {
        // Every field is a number, a string or a list of those, which JSON can hold.
        let mut text = serde_json::to_string_pretty(self).expect("plain data serializes");
        text.push('\n');
        text
    }

    /// One entry per region, in the order of their ids.
    pub fn primitives(&self) -> &[PrimitiveReport] {
        &self.primitives
    }
}

impl Settings {
    fn new(result: &Reconstruction, options: &Options) -> Self {
        let support = match options.support {
            SupportSearch::Auto => "auto",
            SupportSearch::None => "none",
        };
        Self {
            seed: options.seed,
            gap: result.tolerances.gap(),
            min_face: options.min_face,
            support,
            up: options.up.map(|up| [up.x, up.y, up.z]),
        }
    }
}

impl Scan {
    fn new(result: &Reconstruction, context: &Context) -> Self {
        let measured = &result.measured;
        let (area, area_explained) = areas(result);
        Self {
            triangles: context.n_triangles,
            vertices: context.n_vertices,
            conditioned: result.conditioned.clone(),
            area,
            area_explained,
            diagonal: measured.diagonal,
            spacing: measured.spacing,
            noise: measured.noise,
            normal_noise: measured.normal_noise,
            edge_rounding: measured.edge_rounding,
        }
    }
}

/// Area of the part in the scan, the table left out, and how much of it lies on analytic surfaces.
pub fn areas(result: &Reconstruction) -> (f64, f64) {
    let (mut part, mut explained) = (0.0, 0.0);
    for (t, label) in result.segmentation.labels.iter().enumerate() {
        if result.support.as_ref().is_some_and(|s| s.on_table[t]) {
            continue;
        }
        let area = result.mesh.area(t);
        part += area;
        let analytic = label.is_some_and(|r| result.segmentation.primitives[r.0 as usize].surface.is_some());
        if analytic {
            explained += area;
        }
    }
    (part, explained)
}

/// One number per triangle of the scan as it was read: the id of its primitive, -1 for none.
pub fn segment_ids(result: &Reconstruction, n_triangles: usize) -> Vec<i32> {
    let labels = result.labels_of_scan(n_triangles);
    labels.into_iter().map(|label| label.map_or(-1, |region| region.0 as i32)).collect()
}
