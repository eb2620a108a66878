//! Features of a solid, and the build123d script that rebuilds the solid from them.
//!
//! A solid is explained by profiles that are swept along a direction or about an axis, added to one another and cut from
//! one another, and by holes that are drilled last. For every direction and axis that its faces share, the curves its
//! faces leave across the motion cut a plane into cells; each cell over each range of the motion is asked by samples how
//! much of it is material, and a search takes the unions of cells that explain most. Every feature can be asked whether
//! it holds a point, so what the features get wrong is known before anything is written.

mod arrangement;
mod body;
mod candidates;
mod curve;
mod drawing;
mod feature;
mod grid;
mod holes;
mod judge;
mod min_cut;
mod outline;
mod overlap;
mod parameters;
mod python;
mod search;
mod sweep;
mod text;
mod trace;

use crate::brep::Solid;
use crate::recognize::Primitive;
use body::Body;

/// How a script is written.
#[derive(Debug, Clone, PartialEq)]
pub struct ScriptOptions {
    /// Name of the part; "part" by default.
    pub name: String,
    /// Name of the unit of length; "mm" by default.
    pub unit: String,
    /// Length below which what the scan shows is noise: faces that differ by less from a common profile share it.
    pub tolerance: f64,
    /// Seed of the samples; 1 by default.
    pub seed: u64,
}

impl ScriptOptions {
    /// Options for solids made with these tolerances.
    pub fn new(tolerances: &crate::tolerance::Tolerances) -> Self {
        /// Share of the spacing within which a narrow face's place is known, even without noise.
        const PER_SPACING: f64 = 0.2;
        Self {
            name: "part".to_owned(),
            unit: "mm".to_owned(),
            tolerance: (PER_SPACING * tolerances.spacing() + tolerances.noise()).max(tolerances.gap()),
            seed: 1,
        }
    }
}

/// A script and what it has of the solids.
#[derive(Debug, Clone, PartialEq)]
pub struct Script {
    /// Python.
    pub text: String,
    /// One per solid.
    pub parts: Vec<ScriptPart>,
}

/// What a script has of one solid.
#[derive(Debug, Clone, PartialEq)]
pub struct ScriptPart {
    /// Number of features.
    pub n_features: usize,
    /// Faces of the solid.
    pub n_faces: usize,
    /// What of the solid the features do not have: the face, its primitive, and why.
    pub missing: Vec<MissingFace>,
    /// Volume of the solid, cubed length.
    pub volume: f64,
    /// Volume that the script is expected to make, from samples, cubed length.
    pub expected_volume: f64,
    /// Volume that is in one of the two only, cubed length.
    pub differing_volume: f64,
}

impl ScriptPart {
    /// What it has, for people: faces and features.
    pub fn text(&self) -> String {
        let plural = if self.n_features == 1 { "" } else { "s" };
        let n_expressed = self.n_faces - self.missing.len();
        format!("{n_expressed} of {} faces by {} feature{plural}", self.n_faces, self.n_features)
    }
}

/// A face that a script does not have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingFace {
    /// Its place in the solid.
    pub face: usize,
    /// Its primitive.
    pub primitive: u32,
    /// Its type and why it is missing.
    pub text: String,
}

/// The script of `solids`, whose faces are of `primitives`. Says in its head what it does not have; of a solid that no
/// feature explains it says that and nothing else.
pub fn write(solids: &[Solid], primitives: &[Primitive], options: &ScriptOptions) -> Script {
    let parts: Vec<(ScriptPart, Option<python::Text>)> = solids
        .iter()
        .enumerate()
        .map(|(i, solid)| {
            let prefix = if solids.len() == 1 { String::new() } else { format!("p{}_", i + 1) };
            part(solid, primitives, options, &prefix)
        })
        .collect();
    let text = text::whole(&parts, options);
    Script { text, parts: parts.into_iter().map(|p| p.0).collect() }
}

fn part(
    solid: &Solid,
    primitives: &[Primitive],
    options: &ScriptOptions,
    prefix: &str,
) -> (ScriptPart, Option<python::Text>) {
    let n_faces = solid.faces.len();
    let empty = ScriptPart {
        n_features: 0,
        n_faces,
        missing: Vec::new(),
        volume: 0.0,
        expected_volume: 0.0,
        differing_volume: 0.0,
    };
    let Some(body) = Body::new(solid).filter(|_| solid.is_closed()) else {
        let missing = (0..n_faces).map(|face| missing_face(solid, face, "the solid is open")).collect();
        return (ScriptPart { missing, ..empty }, None);
    };
    let (model, verdict) = explained(&body, options);
    let missing = (0..n_faces)
        .filter(|face| !verdict.expressed[*face])
        .map(|face| missing_face(solid, face, "no profile that was found has it"))
        .collect();
    let variable = format!("{prefix}part");
    let text = python::write(&body, &model, primitives, options.tolerance, (&variable, prefix));
    let part = ScriptPart {
        n_features: model.features().count(),
        n_faces,
        missing,
        volume: verdict.volume,
        expected_volume: verdict.expected,
        differing_volume: verdict.differs,
    };
    (part, text)
}

/// The features that explain a solid best, of those that different strategies find.
fn explained(body: &Body, options: &ScriptOptions) -> (feature::Model, judge::Verdict) {
    /// See [`search::Strategy::wrong`].
    const WRONG: [f64; 2] = [3.0, 40.0];
    /// What one more feature costs: as much as a hundredth of the faces, or a thousandth of the volume.
    const PER_FEATURE: f64 = 0.01;
    const PER_VOLUME: f64 = 10.0;
    let ScriptOptions { tolerance, seed, .. } = *options;
    let grids = search::grids(body, tolerance, seed);
    let found = WRONG.map(|wrong| {
        let strategy = search::Strategy { wrong, tolerance, seed };
        let model = search::search(body, grids.clone(), &strategy);
        let verdict = judge::judge(body, &model, tolerance, seed);
        let n_missing = verdict.expressed.iter().filter(|e| !**e).count();
        let cost = n_missing as f64 / verdict.expressed.len() as f64
            + PER_VOLUME * verdict.differs / verdict.volume
            + PER_FEATURE * model.features().count() as f64;
        (cost, model, verdict)
    });
    let [first, second] = found;
    let best = if second.0 < first.0 { second } else { first };
    (best.1, best.2)
}

fn missing_face(solid: &Solid, face: usize, reason: &str) -> MissingFace {
    let kind = solid.geometry(&solid.faces[face]).kind();
    let (kind, reason) = match kind {
        Some(kind) => (kind.name(), reason),
        None => ("freeform", "profiles are made of lines and arcs"),
    };
    let primitive = solid.faces[face].region.0;
    MissingFace { face, primitive, text: format!("{kind}: {reason}") }
}
