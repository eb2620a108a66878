//! `PART.json` read back.
//!
//! What a field does not know is absent: results of older and newer versions are read too, and types, kinds and settings
//! that are not known here are shown under their own names.

use std::f64::consts::TAU;

use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value};

use crate::deviation::Histogram;
use crate::math::{Axis, Point3, Vec3, try_unit};
use crate::report::{Place, SCHEMA, Source, Units};
use crate::surface::{Cone, Cylinder, Plane, Sphere, Surface, SurfaceKind, Torus};

/// Why a text is no result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PartError {
    /// It is no JSON, or its values are not what the schema says.
    #[error("line {line}: {reason}")]
    Json {
        /// Line of the text, from 1.
        line: usize,
        /// What is wrong there.
        reason: String,
    },
    /// It is another kind of file.
    #[error("schema is {found:?}; {SCHEMA:?} is needed, as `convert --json` writes it")]
    Schema {
        /// What the file says.
        found: String,
    },
    /// Two primitives have one number.
    #[error("two primitives have id {id}")]
    RepeatedId {
        /// The number.
        id: u32,
    },
}

/// A result, as far as it is shown.
#[derive(Debug, Clone, Deserialize)]
pub struct Part {
    #[serde(default, deserialize_with = "or_default")]
    pub(super) version: String,
    #[serde(default, deserialize_with = "or_default")]
    pub(super) units: Option<Units>,
    #[serde(default, deserialize_with = "or_default")]
    pub(super) settings: Map<String, Value>,
    #[serde(default, deserialize_with = "or_default")]
    pub(super) scan: Scan,
    pub(super) support: Option<Support>,
    #[serde(default, deserialize_with = "or_default")]
    pub(super) primitives: Vec<Primitive>,
    #[serde(default, deserialize_with = "or_default")]
    pub(super) known: Vec<Known>,
    pub(super) dimensions: Option<Vec<Dimension>>,
    pub(super) relations: Option<Vec<Relation>>,
    #[serde(default, deserialize_with = "or_default")]
    pub(super) solids: Vec<Solid>,
    pub(super) deviation: Option<Deviation>,
    #[serde(default, deserialize_with = "or_default")]
    pub(super) warnings: Vec<Warning>,
    /// Where the datums put the part.
    #[serde(alias = "placement", alias = "alignment")]
    pub(super) frame: Option<Value>,
}

/// `scan`.
#[derive(Debug, Clone, Default, Deserialize)]
pub(super) struct Scan {
    pub source: Option<Source>,
    pub triangles: Option<usize>,
    pub vertices: Option<usize>,
    #[serde(default, deserialize_with = "or_default")]
    pub conditioned: Map<String, Value>,
    pub area: Option<f64>,
    pub area_explained: Option<f64>,
    pub diagonal: Option<f64>,
    pub spacing: Option<f64>,
    pub noise: Option<f64>,
    pub edge_rounding: Option<f64>,
}

/// `support`.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Support {
    pub point: Option<[f64; 3]>,
    pub normal: Option<[f64; 3]>,
    pub triangles: Option<usize>,
}

/// One of `primitives`.
#[derive(Debug, Clone, Default, Deserialize)]
pub(super) struct Primitive {
    pub id: u32,
    #[serde(rename = "type", default, deserialize_with = "or_default")]
    pub kind: String,
    pub point: Option<[f64; 3]>,
    pub normal: Option<[f64; 3]>,
    pub axis_point: Option<[f64; 3]>,
    pub axis_direction: Option<[f64; 3]>,
    pub apex: Option<[f64; 3]>,
    pub center: Option<[f64; 3]>,
    pub radius: Option<f64>,
    pub half_angle: Option<f64>,
    pub major_radius: Option<f64>,
    pub minor_radius: Option<f64>,
    pub outward: Option<bool>,
    #[serde(default, deserialize_with = "or_default")]
    pub residual: Residual,
    #[serde(default, deserialize_with = "or_default")]
    pub parameters: Vec<String>,
    #[serde(default, deserialize_with = "or_default")]
    pub uncertainty: Vec<Option<f64>>,
    pub triangles: Option<usize>,
    pub area: Option<f64>,
    pub place: Option<Place>,
    pub ambiguous: Option<String>,
    pub sufficiency: Option<Sufficiency>,
}

/// Distances of points to a surface.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
pub(super) struct Residual {
    pub rms: Option<f64>,
    pub p95: Option<f64>,
    pub max: Option<f64>,
}

/// Whether a size is known as well as was asked.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Sufficiency {
    pub uncertainty: Option<f64>,
    pub missing: Option<Missing>,
}

/// What would make it known.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Missing {
    pub arc: Option<f64>,
    pub points: Option<f64>,
}

/// One of `known`.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Known {
    pub id: u32,
    #[serde(default, deserialize_with = "or_default")]
    pub name: String,
    #[serde(default, deserialize_with = "or_default")]
    pub taken: bool,
}

/// One of `dimensions`.
#[derive(Debug, Clone, Default, Deserialize)]
pub(super) struct Dimension {
    pub id: Option<u32>,
    #[serde(default, deserialize_with = "or_default")]
    pub kind: String,
    #[serde(default, deserialize_with = "or_default")]
    pub of: Vec<u32>,
    pub value: Option<f64>,
    pub uncertainty: Option<f64>,
    #[serde(default, deserialize_with = "or_default")]
    pub quantity: Quantity,
    pub evidence: Option<Evidence>,
    pub guess: Option<String>,
    pub nominal: Option<Nominal>,
}

/// What a dimension measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Quantity {
    #[default]
    Length,
    /// Radians.
    Angle,
}

/// What a dimension rests on.
#[derive(Debug, Clone, Default, Deserialize)]
pub(super) struct Evidence {
    pub arc: Option<f64>,
    pub area: Option<f64>,
    pub triangles: Option<usize>,
}

/// A round value that a dimension may have been designed with.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Nominal {
    pub value: Option<f64>,
    #[serde(default, deserialize_with = "or_default")]
    pub grid: String,
    pub z: Option<f64>,
    pub coincidence: Option<f64>,
    #[serde(default, deserialize_with = "or_default")]
    pub applied: bool,
    pub why: Option<String>,
}

/// One of `relations`.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Relation {
    #[serde(default, deserialize_with = "or_default")]
    pub kind: String,
    #[serde(default, deserialize_with = "or_default")]
    pub of: Vec<u32>,
    pub angle: Option<f64>,
    pub z: Option<f64>,
    pub z_statistical: Option<f64>,
    pub shift: Option<f64>,
    pub turn: Option<f64>,
    pub before: Option<f64>,
    pub after: Option<f64>,
    #[serde(default, deserialize_with = "or_default")]
    pub accepted: bool,
    pub reason: Option<String>,
}

/// One of `solids`.
#[derive(Debug, Clone, Default, Deserialize)]
pub(super) struct Solid {
    #[serde(default, deserialize_with = "or_default")]
    pub closed: bool,
    #[serde(default, deserialize_with = "or_default")]
    pub n_faces: usize,
    #[serde(default, deserialize_with = "or_default")]
    pub n_edges: usize,
    #[serde(default, deserialize_with = "or_default")]
    pub n_assumed: usize,
    pub volume: Option<f64>,
    pub largest_gap: Option<f64>,
    #[serde(default, deserialize_with = "or_default")]
    pub problems: Vec<String>,
}

/// `deviation`.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Deviation {
    pub rms: Option<f64>,
    pub p95: Option<f64>,
    pub max: Option<f64>,
    pub within_three_noise: Option<f64>,
    pub histogram: Option<Histogram>,
}

/// One of `warnings`.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Warning {
    #[serde(default, deserialize_with = "or_default")]
    pub code: String,
    pub primitive: Option<u32>,
    #[serde(default, deserialize_with = "or_default")]
    pub text: String,
}

/// A `null` counts as absent.
fn or_default<'de, D: Deserializer<'de>, T: Default + Deserialize<'de>>(from: D) -> Result<T, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or_default())
}

impl Part {
    /// Reads the text of `PART.json`.
    pub fn read(text: &str) -> Result<Self, PartError> {
        let json = |error: serde_json::Error| {
            // The place is said once, by us.
            let reason = error.to_string();
            let reason = reason.split(" at line ").next().unwrap_or_default().to_owned();
            PartError::Json { line: error.line(), reason }
        };
        #[derive(Deserialize)]
        struct Head {
            schema: Option<String>,
        }
        let head: Head = serde_json::from_str(text).map_err(json)?;
        if head.schema.as_deref() != Some(SCHEMA) {
            return Err(PartError::Schema { found: head.schema.unwrap_or_default() });
        }
        let mut part: Self = serde_json::from_str(text).map_err(json)?;
        part.primitives.sort_by_key(|primitive| primitive.id);
        match part.primitives.windows(2).find(|pair| pair[0].id == pair[1].id) {
            Some(pair) => Err(PartError::RepeatedId { id: pair[0].id }),
            None => Ok(part),
        }
    }

    /// Triangles and vertices of the scan that the result was made from.
    pub fn scan_counts(&self) -> (Option<usize>, Option<usize>) {
        (self.scan.triangles, self.scan.vertices)
    }

    /// The file that the result was made from.
    pub fn source(&self) -> Option<&Source> {
        self.scan.source.as_ref()
    }

    pub(super) fn primitive(&self, id: u32) -> Option<&Primitive> {
        let place = self.primitives.binary_search_by_key(&id, |primitive| primitive.id).ok()?;
        Some(&self.primitives[place])
    }

    /// Rows of the motion from the scan's coordinates to those of the result, when they differ.
    pub(super) fn aligned_from_scan(&self) -> Option<[[f64; 4]; 4]> {
        serde_json::from_value(self.frame.as_ref()?.get("aligned_from_scan")?.clone()).ok()
    }

    /// Length of the unit in millimetres.
    pub fn millimetres(&self) -> Option<f64> {
        self.units
            .as_ref()
            .map(|units| units.millimetres)
            .filter(|length| length.is_finite() && *length > 0.0)
    }

    /// Abbreviation of the unit of length.
    pub(super) fn unit(&self) -> &str {
        self.units.as_ref().map_or("?", |units| units.name.as_str())
    }

    /// Type and number, as in the name of its STEP faces.
    pub(super) fn name_of(&self, id: u32) -> String {
        match self.primitive(id) {
            Some(primitive) if !primitive.kind.is_empty() => format!("{} {id}", primitive.kind),
            _ => format!("region {id}"),
        }
    }

    pub(super) fn warnings_of<'a>(&'a self, code: &'a str) -> impl Iterator<Item = &'a Warning> {
        self.warnings.iter().filter(move |warning| warning.code == code)
    }

    /// The dimensions listed, or the sizes of the primitives where a result lists none.
    pub(super) fn all_dimensions(&self) -> Vec<Dimension> {
        if let Some(dimensions) = &self.dimensions {
            return dimensions.clone();
        }
        let of = |primitive: &Primitive| {
            let sizes = [
                ("radius", primitive.radius, Quantity::Length),
                ("half_angle", primitive.half_angle, Quantity::Angle),
                ("major_radius", primitive.major_radius, Quantity::Length),
                ("minor_radius", primitive.minor_radius, Quantity::Length),
            ];
            let dimension = |(kind, value, quantity): (&str, Option<f64>, Quantity)| Dimension {
                kind: kind.to_owned(),
                of: vec![primitive.id],
                value,
                uncertainty: primitive.uncertainty_of(kind),
                quantity,
                evidence: Some(Evidence { arc: None, area: primitive.area, triangles: primitive.triangles }),
                ..Dimension::default()
            };
            sizes.into_iter().filter(|size| size.1.is_some()).map(dimension).collect::<Vec<_>>()
        };
        self.primitives.iter().flat_map(of).collect()
    }
}

impl Primitive {
    /// Standard uncertainty of a parameter.
    pub fn uncertainty_of(&self, name: &str) -> Option<f64> {
        let place = self.parameters.iter().position(|parameter| parameter == name)?;
        *self.uncertainty.get(place)?
    }

    /// Its type, when that is an analytic one.
    pub fn surface_kind(&self) -> Option<SurfaceKind> {
        SurfaceKind::ALL.into_iter().find(|kind| kind.name() == self.kind)
    }

    /// Its surface, when that is analytic and all of it is there.
    pub fn surface(&self) -> Option<Surface> {
        let point = |p: Option<[f64; 3]>| p.map(Point3::from);
        let direction = |d: Option<[f64; 3]>| try_unit(Vec3::from(d?));
        let axis = |origin: Option<[f64; 3]>| {
            Some(Axis { origin: point(origin)?, direction: direction(self.axis_direction)? })
        };
        let surface = match self.surface_kind()? {
            SurfaceKind::Plane => {
                Surface::Plane(Plane { point: point(self.point)?, normal: direction(self.normal)? })
            }
            SurfaceKind::Cylinder => {
                Surface::Cylinder(Cylinder { axis: axis(self.axis_point)?, radius: self.radius? })
            }
            SurfaceKind::Cone => {
                let half_angle = self.half_angle.filter(|angle| (0.0..TAU / 4.0).contains(angle))?;
                Surface::Cone(Cone { axis: axis(self.apex)?, radius: 0.0, half_angle })
            }
            SurfaceKind::Sphere => {
                Surface::Sphere(Sphere { center: point(self.center)?, radius: self.radius? })
            }
            SurfaceKind::Torus => Surface::Torus(Torus {
                axis: axis(self.center)?,
                major_radius: self.major_radius?,
                minor_radius: self.minor_radius?,
            }),
        };
        Some(surface)
    }
}
