//! A check as data; `docs/output.md` has the schema.

use serde::Serialize;

use super::{Change, Check, FaceCheck, Feature, Form, Spread, Verdict};
use crate::align::{Alignment, FoundBy, Target};
use crate::math::Vec3;
use crate::pipeline::SupportSearch;
use crate::report::{Geometry, Units};

/// What a check does not know about itself.
#[derive(Debug, Clone)]
pub struct Context<'a> {
    /// Version of the program.
    pub version: &'a str,
    /// The unit of all lengths.
    pub units: Units,
    /// What `--align` asked for, and the datums used.
    pub method: &'a str,
    /// Names of the datums, in their order.
    pub datums: &'a [String],
    /// Largest deviation allowed.
    pub tolerance: Option<f64>,
    /// Standard deviation of the scan's noise along the normal, and mean distance of its vertices.
    pub noise: f64,
    /// See `noise`.
    pub spacing: f64,
    /// Vertices of the part.
    pub n_vertices: usize,
    /// Whether a table was looked for.
    pub support: SupportSearch,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    version: &'a str,
    units: &'a Units,
    settings: Settings,
    scan: Scan,
    model: Model<'a>,
    alignment: Placement<'a>,
    verdict: Option<Verdict>,
    deviation: Overall,
    faces: Vec<Face<'a>>,
    changes: Vec<Different>,
}

#[derive(Serialize)]
struct Settings {
    tolerance: Option<f64>,
    support: &'static str,
}

#[derive(Serialize)]
struct Scan {
    vertices: usize,
    vertices_on_model: usize,
    spacing: f64,
    noise: f64,
}

#[derive(Serialize)]
struct Model<'a> {
    faces: usize,
    area: f64,
    unread: &'a [String],
}

#[derive(Serialize)]
struct Placement<'a> {
    method: &'a str,
    datums: &'a [String],
    found_by: FoundBy,
    model_from_scan: [[f64; 4]; 4],
    pivot: [f64; 3],
    covariance: [[f64; 6]; 6],
    free: Option<String>,
    n_free: usize,
    alternatives: Vec<Other>,
    explained: f64,
    sigma: f64,
    vertices_per_sample: f64,
    n_vertices: usize,
    bend: f64,
    bend_uncertainty: f64,
}

#[derive(Serialize)]
struct Other {
    model_from_scan: [[f64; 4]; 4],
    turn: f64,
    excess: f64,
}

#[derive(Serialize)]
struct Overall {
    #[serde(flatten)]
    spread: Spread,
    reach: f64,
}

#[derive(Serialize)]
#[allow(clippy::struct_field_names, reason = "keys of the document")]
struct Face<'a> {
    face: u32,
    name: &'a str,
    state: &'static str,
    area: f64,
    seen: f64,
    absent: f64,
    deviation: Option<Spread>,
    profile: Option<f64>,
    profile_uncertainty: Option<f64>,
    verdict: Option<Verdict>,
    #[serde(flatten)]
    measured: Option<Measured>,
}

#[derive(Serialize)]
#[allow(clippy::struct_field_names, reason = "keys of the document")]
struct Measured {
    nominal: Geometry,
    measured: Geometry,
    n_points: usize,
    rms: f64,
    quantities: Vec<Number>,
    form: Form,
}

#[derive(Serialize)]
struct Number {
    name: &'static str,
    nominal: f64,
    measured: f64,
    uncertainty: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    shift: Option<[f64; 3]>,
    verdict: Option<Verdict>,
}

#[derive(Serialize)]
struct Different {
    #[serde(flatten)]
    what: What,
    text: String,
}

#[derive(Serialize)]
struct What {
    kind: super::ChangeKind,
    face: Option<u32>,
    region: Option<u32>,
    quantity: &'static str,
    value: f64,
    uncertainty: Option<f64>,
    shift: Option<[f64; 3]>,
    surface: Geometry,
}

fn array(v: Vec3) -> [f64; 3] {
    [v.x, v.y, v.z]
}

/// The whole check, schema `scanwright/check/1`.
pub fn to_json(check: &Check, target: &Target, alignment: &Alignment, context: &Context) -> String {
    let names: Vec<String> = target.model.faces.iter().map(|f| f.name.clone()).collect();
    let different = |change: &Change| Different {
        what: What {
            kind: change.kind,
            face: change.face,
            region: change.region.map(|r| r.0),
            quantity: change.quantity,
            value: change.value,
            uncertainty: change.uncertainty,
            shift: change.shift.map(array),
            surface: Geometry::of(change.surface.as_ref()),
        },
        text: change.text(&names, &context.units.name),
    };
    let document = Document {
        schema: "scanwright/check/1",
        version: context.version,
        units: &context.units,
        settings: Settings {
            tolerance: context.tolerance,
            support: if context.support == SupportSearch::Auto { "auto" } else { "none" },
        },
        scan: Scan {
            vertices: context.n_vertices,
            vertices_on_model: check.sightings.of_vertex.iter().flatten().count(),
            spacing: context.spacing,
            noise: context.noise,
        },
        model: Model {
            faces: target.model.faces.len(),
            area: check.faces.iter().map(|f| f.coverage.area).sum(),
            unread: &target.model.unread,
        },
        alignment: placement(alignment, context),
        verdict: check.verdict,
        deviation: Overall { spread: check.overall, reach: check.sightings.reach },
        faces: check.faces.iter().map(|f| face(f, check, &names)).collect(),
        changes: check.changes.iter().map(different).collect(),
    };
    text(&document)
}

fn placement<'a>(alignment: &Alignment, context: &'a Context) -> Placement<'a> {
    let other = |a: &crate::align::Alternative| Other {
        model_from_scan: a.pose.rows(),
        turn: a.turn_from(&alignment.pose).map_or(0.0, |t| t.0),
        excess: a.excess,
    };
    Placement {
        method: context.method,
        datums: context.datums,
        found_by: alignment.found_by,
        model_from_scan: alignment.pose.rows(),
        pivot: array(alignment.pivot.coords),
        covariance: alignment.covariance,
        free: alignment.freedom.text(),
        n_free: alignment.freedom.count(),
        alternatives: alignment.alternatives.iter().map(other).collect(),
        explained: alignment.explained,
        sigma: alignment.sigma,
        vertices_per_sample: alignment.vertices_per_sample,
        n_vertices: alignment.n_points,
        bend: alignment.bend,
        bend_uncertainty: alignment.bend_uncertainty,
    }
}

fn face<'a>(face: &FaceCheck, check: &Check, names: &'a [String]) -> Face<'a> {
    let feature = check.features.iter().find(|f| f.face == face.face);
    Face {
        face: face.face,
        name: &names[face.face as usize],
        state: face.state(),
        area: face.coverage.area,
        seen: face.coverage.seen,
        absent: face.coverage.absent,
        deviation: face.spread,
        profile: face.profile.map(|p| p[0]),
        profile_uncertainty: face.profile.map(|p| p[1]),
        verdict: face.verdict,
        measured: feature.map(measured),
    }
}

fn measured(feature: &Feature) -> Measured {
    let number = |q: &super::Quantity| Number {
        name: q.name,
        nominal: q.nominal,
        measured: q.measured,
        uncertainty: q.uncertainty,
        shift: q.shift.map(array),
        verdict: q.verdict,
    };
    Measured {
        nominal: Geometry::of(Some(&feature.nominal)),
        measured: Geometry::of(Some(&feature.measured)),
        n_points: feature.n_points,
        rms: feature.rms,
        quantities: feature.quantities.iter().map(number).collect(),
        form: feature.form,
    }
}

#[derive(Serialize)]
struct Update<'a> {
    schema: &'static str,
    version: &'a str,
    units: &'a Units,
    faces: Vec<Updated<'a>>,
}

#[derive(Serialize)]
struct Updated<'a> {
    face: u32,
    name: &'a str,
    state: &'static str,
    outward: bool,
    changed: bool,
    nominal: Geometry,
    measured: Geometry,
    uncertainty: Vec<(&'static str, f64)>,
}

/// The model's faces with the values they were measured at, schema `scanwright/update/1`; a face that could not be
/// measured keeps the model's. `changed`: whether it differs by more than uncertainty explains.
pub fn update_json(check: &Check, target: &Target, context: &Context) -> String {
    let updated = |face: &FaceCheck| {
        let feature = check.features.iter().find(|f| f.face == face.face);
        let prior = target.face(face.face);
        let measured = feature.map_or(prior.surface, |f| Some(f.measured));
        let numbers = feature.iter().flat_map(|f| &f.quantities);
        Updated {
            face: face.face,
            name: &target.face(face.face).name,
            state: face.state(),
            outward: prior.outward,
            changed: check.changes.iter().any(|c| c.face == Some(face.face)),
            nominal: Geometry::of(prior.surface.as_ref()),
            measured: Geometry::of(measured.as_ref()),
            uncertainty: numbers.map(|q| (q.name, q.uncertainty)).collect(),
        }
    };
    text(&Update {
        schema: "scanwright/update/1",
        version: context.version,
        units: &context.units,
        faces: check.faces.iter().map(updated).collect(),
    })
}

fn text(document: &impl Serialize) -> String {
    let mut text =
        serde_json::to_string_pretty(document).expect("plain data with string keys is always JSON");
    text.push('\n');
    text
}
