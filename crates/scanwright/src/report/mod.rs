//! The result as data: `part.json` and the labels of `segments.ply`.
//!
//! The schema is documented in `docs/output.md`. Keys come in declaration order, numbers in their shortest form that
//! reads back the same, and what is not a number is `null`: the same result is the same bytes.

mod geometry;
mod place;
mod regions;

pub use geometry::Geometry;
pub use place::Place;
pub use regions::{Neighbor, PrimitiveReport};

use serde::{Deserialize, Serialize};

use crate::condition::ConditionReport;
use crate::deviation::Histogram;
use crate::dimension::{Dimension, Systematic};
use crate::fit::Noise;
use crate::gprimdb::Known;
use crate::pipeline::{Options, Placement, Reconstruction, SolidFacts, SupportSearch, Warning};
use crate::recognize::Residual;
use crate::regularize::{Manufacture, Relation, Relations};
use crate::segment::RegionId;

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
    /// The file that the scan was read from, if it was one.
    pub source: Option<Source>,
    /// What a database knows of the primitives; `None` when none was asked.
    pub known: Option<&'a [Known]>,
}

/// The file that a scan was read from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    /// Its name, without folders.
    pub file: String,
    /// Its length.
    pub bytes: usize,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

/// The unit of all lengths of a report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    #[serde(skip_serializing_if = "Option::is_none")]
    placement: Option<PlacementReport>,
    primitives: Vec<PrimitiveReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    known: Option<Vec<Known>>,
    dimensions: Vec<Dimension>,
    relations: Vec<Relation>,
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
    target: Option<f64>,
    relations: &'static str,
    manufacture: Manufacture,
    systematic: Systematic,
    snap: bool,
}

#[derive(Debug, Clone, Serialize)]
struct Scan {
    source: Option<Source>,
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
    /// Noise as what is left of the scan on its faces shows it.
    residual_noise: Noise,
}

#[derive(Debug, Clone, Serialize)]
struct Support {
    #[serde(flatten)]
    plane: Geometry,
    triangles: usize,
    outlines: usize,
}

#[derive(Debug, Clone, Serialize)]
struct PlacementReport {
    aligned_from_scan: [[f64; 4]; 4],
    level: u32,
    rotate: Option<u32>,
    zero: Vec<u32>,
    planes_of_symmetry: usize,
    free_turn: bool,
    free_ways: usize,
}

impl PlacementReport {
    fn new(placement: &Placement) -> Self {
        Self {
            aligned_from_scan: placement.pose.rows(),
            level: placement.level.0,
            rotate: placement.rotate.map(|r| r.0),
            zero: placement.zero.iter().map(|r| r.0).collect(),
            planes_of_symmetry: placement.mirrors,
            free_turn: placement.free_turn,
            free_ways: placement.free_ways,
        }
    }
}

#[derive(Debug, Clone, Serialize)]
struct DeviationReport {
    #[serde(flatten)]
    residual: Residual,
    within_three_noise: f64,
    histogram: Histogram,
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
            histogram: Histogram::new(&deviation.distances, deviation.residual.p95, noise),
        });
        Self {
            schema: SCHEMA,
            version: context.version.to_owned(),
            units: context.units.clone(),
            settings: Settings::new(result, context.options),
            scan: Scan::new(result, context),
            support,
            placement: result.placement.as_ref().map(PlacementReport::new),
            primitives: regions::primitives(result, context),
            known: context.known.map(<[Known]>::to_vec),
            dimensions: result.dimensions.clone(),
            relations: result.relations.clone(),
            solids: result.model.facts.clone(),
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
            target: options.target,
            relations: match options.relations {
                Relations::Auto => "auto",
                Relations::Off => "off",
                Relations::Listed(_) => "listed",
            },
            manufacture: options.manufacture,
            systematic: options.systematic,
            snap: options.snap,
        }
    }
}

impl Scan {
    fn new(result: &Reconstruction, context: &Context) -> Self {
        let measured = &result.measured;
        let (area, area_explained) = areas(result);
        Self {
            source: context.source.clone(),
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
            residual_noise: result.noise,
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

/// One number per label: the id of its primitive, -1 for none.
pub fn segment_ids(labels: &[Option<RegionId>]) -> Vec<i32> {
    labels.iter().map(|label| label.map_or(-1, |region| region.0 as i32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::Noise;
    use crate::math::{Axis, Point3, Vec3};
    use crate::mesh::Mesh;
    use crate::pipeline::{Code, Model};
    use crate::recognize::Primitive;
    use crate::segment::Segmentation;
    use crate::surface::{Cone, Cylinder, Plane, Sphere, Surface, Torus};
    use crate::tolerance::{Measured, Tolerances};

    #[test]
    fn segment_ids_follow_the_order_of_the_scan() {
        // Of the scan's five triangles conditioning kept numbers 1, 3 and 4.
        let result = reconstruction(vec![None; 3], &[1, 3, 4], &[Some(1), None, Some(0)]);
        assert_eq!(segment_ids(&result.labels_of_scan(5)), [-1, 1, -1, -1, 0]);
    }

    #[test]
    fn types_and_parameters_have_the_names_of_the_benchmark() {
        let axis = Axis { origin: Point3::new(1.0, 2.0, 3.0), direction: Vec3::z_axis() };
        let surfaces = [
            Surface::Plane(Plane { point: axis.origin, normal: axis.direction }),
            Surface::Cylinder(Cylinder { axis, radius: 2.0 }),
            Surface::Cone(Cone { axis, radius: 1.0, half_angle: std::f64::consts::FRAC_PI_4 }),
            Surface::Sphere(Sphere { center: axis.origin, radius: 2.0 }),
            Surface::Torus(Torus { axis, major_radius: 5.0, minor_radius: 2.0 }),
        ];
        let surfaces = surfaces.into_iter().map(Some).chain([None]).collect();
        let json = json(&reconstruction(surfaces, &[0], &[None]));
        let expected: [(&str, &[&str]); 6] = [
            ("plane", &["point", "normal"]),
            ("cylinder", &["axis_point", "axis_direction", "radius"]),
            ("cone", &["apex", "axis_direction", "half_angle"]),
            ("sphere", &["center", "radius"]),
            ("torus", &["center", "axis_direction", "major_radius", "minor_radius"]),
            ("freeform", &[]),
        ];
        for (id, (kind, names)) in expected.into_iter().enumerate() {
            let primitive = &json["primitives"][id];
            assert_eq!(primitive["id"], id);
            assert_eq!(primitive["type"], kind);
            for name in names {
                assert!(!primitive[name].is_null(), "{kind} lacks {name}: {primitive}");
            }
        }
        // The radius is 1 at height 3 and grows by as much as the height.
        assert_eq!(json["primitives"][2]["apex"][1], 2.0);
        assert!((json["primitives"][2]["apex"][2].as_f64().unwrap() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_a_number_is_null() {
        let mut result = reconstruction(vec![None], &[0], &[Some(0)]);
        result.segmentation.primitives[0].residual.rms = f64::NAN;
        result.segmentation.primitives[0].residual.max = f64::INFINITY;
        let json = json(&result);
        assert!(json["primitives"][0]["residual"]["rms"].is_null());
        assert!(json["primitives"][0]["residual"]["max"].is_null());
    }

    #[test]
    fn regions_that_share_an_edge_are_neighbors_by_its_length() {
        let result = reconstruction(vec![None, None], &[0, 1], &[Some(0), Some(1)]);
        let json = json(&result);
        for (id, other) in [(0, 1), (1, 0)] {
            let neighbors = json["primitives"][id]["neighbors"].as_array().unwrap();
            assert_eq!(neighbors.len(), 1);
            assert_eq!(neighbors[0]["id"], other);
            // Consecutive triangles of the strip share a diagonal of its unit squares.
            assert_eq!(neighbors[0]["length"], std::f64::consts::SQRT_2);
        }
    }

    fn json(result: &Reconstruction) -> serde_json::Value {
        let units = Units { name: "mm".to_owned(), millimetres: 1.0, source: "flag".to_owned() };
        let options = Options::default();
        let context = Context {
            version: "0",
            units,
            options: &options,
            n_triangles: 9,
            n_vertices: 9,
            source: None,
            known: None,
        };
        serde_json::from_str(&Report::new(result, &context).to_json()).unwrap()
    }

    /// A strip of triangles on which regions with these surfaces were found. `source`: the scan's triangle of each;
    /// `labels`: one per triangle.
    fn reconstruction(
        surfaces: Vec<Option<Surface>>,
        source: &[u32],
        labels: &[Option<u32>],
    ) -> Reconstruction {
        let vertices =
            (0..source.len() + 2).map(|i| Point3::new((i / 2) as f64, (i % 2) as f64, 0.0)).collect();
        let triangle = |i: u32| if i.is_multiple_of(2) { [i, i + 2, i + 1] } else { [i, i + 1, i + 2] };
        let mesh = Mesh { vertices, triangles: (0..source.len() as u32).map(triangle).collect() };
        let primitive = |surface| Primitive {
            surface,
            outward: true,
            residual: Residual::default(),
            covariance: Vec::new(),
            ambiguous: None,
        };
        let measured = Measured {
            largest_coordinate: 1.0,
            diagonal: 1.0,
            spacing: 1.0,
            noise: 0.0,
            normal_noise: 0.0,
            edge_rounding: 0.0,
        };
        Reconstruction {
            mesh,
            source_triangle: source.to_vec(),
            conditioned: ConditionReport::default(),
            measured,
            noise: Noise { white: 0.0, correlated: 0.0, length: 1.0 },
            tolerances: Tolerances::new(measured, None),
            support: None,
            segmentation: Segmentation {
                labels: labels.iter().map(|l| l.map(RegionId)).collect(),
                primitives: surfaces.into_iter().map(primitive).collect(),
            },
            relations: Vec::new(),
            dimensions: Vec::new(),
            model: Model::default(),
            deviation: None,
            placement: None,
            warnings: vec![Warning::new(Code::NoSolid, "none")],
        }
    }
}
