//! Where a scan lies on a model known before it.
//!
//! [`align`] finds the rigid motion that lays the part of a scan on a model. Guesses come from surfaces that agree in type,
//! size and place relative to each other (`coarse`), and, where there are too few, from principal axes and a grid of turns
//! (`turns`). The best of them are settled by robust least squares of the distances of raw vertices to the model's
//! surfaces (`fine`). The result says how well the scan determines the motion, which motions it leaves free, and which
//! other placements explain it as well (`spread`, `alternatives`).
//!
//! Cost: a few hundred guesses of a few hundred points each, then some thirty passes over at most two hundred thousand
//! vertices. It fails when less than about a third of the scan lies on the model and surfaces do not tell.

mod alternatives;
mod borders;
mod coarse;
mod elements;
mod fine;
#[cfg(test)]
mod samples;
mod spread;
mod target;
mod turns;

pub use alternatives::Alternative;
pub use elements::{Element, of_part as elements_of};
pub use spread::{Freedom, vertices_per_sample};
pub use target::{Hit, LEAST_COSINE, Measure, Target};

use crate::fit::Noise;
use crate::math::{Point3, Pose, Vec3};
use crate::mesh::{Adjacency, Mesh, VertId};
use crate::pipeline::Segmented;
use crate::prior::{PriorFace, PriorModel};
use crate::segment::Segmentation;
use crate::tolerance::Tolerances;
use crate::uncertainty::{self, Interior};

/// The part of a scan without its table.
#[derive(Debug, Clone)]
pub struct Part {
    /// Its triangles, vertices as the scanner gave them.
    pub mesh: Mesh,
    /// One per vertex: unit normal, zero where no triangle gives one.
    pub normals: Vec<Vec3>,
    /// One per vertex: which of the conditioned scan it is.
    pub scan_vertex: Vec<VertId>,
    /// Its regions.
    pub segmentation: Segmentation,
    /// What the scanner did.
    pub tolerances: Tolerances,
    /// Its noise, as what is left of it on the regions shows it.
    pub noise: Noise,
}

impl Part {
    /// The part of a scan that was cut into regions.
    pub fn new(segmented: &Segmented) -> Self {
        let on_part = |t: usize| segmented.support.as_ref().is_none_or(|support| !support.on_table[t]);
        let (mesh, old_triangles, scan_vertex) = segmented.mesh.submesh(on_part);
        let labels = old_triangles.iter().map(|&t| segmented.segmentation.labels[t as usize]).collect();
        let primitives = segmented.segmentation.primitives.clone();
        let segmentation = Segmentation { labels, primitives };
        let adjacency = Adjacency::new(&mesh);
        let interior = Interior::new(&mesh, &adjacency, &segmentation, &segmented.tolerances);
        let tolerances = segmented.tolerances;
        Self {
            noise: uncertainty::measure(&mesh, &adjacency, &interior, &segmentation, &tolerances),
            normals: mesh.vertex_normals(),
            mesh,
            scan_vertex,
            segmentation,
            tolerances,
        }
    }
}

/// A mesh that was cut into regions as a model: each region is a face, what belongs to none is the last one.
pub fn model_of(segmented: &Segmented) -> PriorModel {
    let regions = segmented.segmentation.primitives.iter().enumerate();
    let mut faces: Vec<PriorFace> = regions
        .map(|(k, p)| PriorFace { name: format!("region {k}"), surface: p.surface, outward: p.outward })
        .collect();
    let rest = faces.len() as u32;
    let labels = segmented.segmentation.labels.iter();
    let face_of: Vec<u32> = labels.map(|label| label.map_or(rest, |region| region.0)).collect();
    if face_of.contains(&rest) {
        faces.push(PriorFace { name: "rest".to_owned(), surface: None, outward: true });
    }
    PriorModel { mesh: segmented.mesh.clone(), face_of, faces, ..PriorModel::default() }
}

/// Distance from a sharp edge within which a scan with such tolerances does not show the faces beside it, length.
pub fn border_width(tolerances: &Tolerances) -> f64 {
    /// Deviations of the spot beyond which a right angle is bent by less than a hundredth of one.
    const SPOTS: f64 = 2.5;
    /// Spacings: normals of vertices on an edge are of both faces.
    const SPACINGS: f64 = 0.75;
    SPOTS * tolerances.edge_rounding() + SPACINGS * tolerances.spacing()
}

/// What a scan shows of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scene {
    /// The modelled part and little else: surfaces of the scan are looked for in the model.
    #[default]
    Part,
    /// An assembly that the model is a part of: surfaces of the model are looked for in the scan.
    Assembly,
}

/// What is known before.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// What the scan shows.
    pub scene: Scene,
    /// A motion to try besides those that are found.
    pub start: Option<Pose>,
}

/// A motion that lays a scan on a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// Takes the scan's coordinates to the model's: `target_from_source`.
    pub pose: Pose,
    /// Covariance of a small further motion: turn about `pivot` (radians), then way (length), both in the model's
    /// coordinates. Free motions are left out of it.
    pub covariance: [[f64; 6]; 6],
    /// How far curved walls are drawn towards their middle of curvature per curvature: half the variance of the scanner's
    /// spot, squared length.
    pub bend: f64,
    /// Its standard uncertainty.
    pub bend_uncertainty: f64,
    /// The middle of the points used, in the model's coordinates.
    pub pivot: Point3,
    /// Root mean square distance of the points used from `pivot`, length.
    pub radius: f64,
    /// Motions that the scan does not determine.
    pub freedom: Freedom,
    /// Other placements that explain the scan as well.
    pub alternatives: Vec<Alternative>,
    /// Standard deviation of the distances used, robust, length.
    pub sigma: f64,
    /// Points per independent sample of what the distances have in common.
    pub vertices_per_sample: f64,
    /// Points that the final motion was found from.
    pub n_points: usize,
    /// Share of the scan's vertices, those at sharp edges left out, that the model explains.
    pub explained: f64,
    /// Where the first guess came from.
    pub found_by: FoundBy,
}

impl Alignment {
    /// Standard uncertainty of the place of `point`, of the model, along `direction`.
    pub fn uncertainty_at(&self, point: &Point3, direction: &Vec3) -> f64 {
        let turn = (point - self.pivot).cross(direction);
        let row = [turn.x, turn.y, turn.z, direction.x, direction.y, direction.z];
        let mut sum = 0.0;
        for (i, a) in row.iter().enumerate() {
            for (j, b) in row.iter().enumerate() {
                sum += a * self.covariance[i][j] * b;
            }
        }
        sum.max(0.0).sqrt()
    }

    /// Standard uncertainty of the turn about `direction`, radians.
    pub fn turn_uncertainty(&self, direction: &Vec3) -> f64 {
        let mut sum = 0.0;
        for (i, row) in self.covariance.iter().take(3).enumerate() {
            for (j, entry) in row.iter().take(3).enumerate() {
                sum += direction[i] * entry * direction[j];
            }
        }
        sum.max(0.0).sqrt()
    }
}

/// Where the guess came from that became the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FoundBy {
    /// The caller, or the scan's own place.
    Start,
    /// Surfaces that correspond.
    Surfaces,
    /// Principal axes or a grid of turns.
    Turns,
}

/// Why there is no motion.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AlignError {
    /// The scan's part has too few vertices.
    #[error("the scan has {0} vertices on its part; an alignment needs at least {LEAST_POINTS}")]
    TooFewPoints(usize),
    /// No guess laid enough of the scan on the model.
    #[error("no placement lays more than {:.0} % of the scan on the model", 100.0 * .0)]
    NoPlacement(f64),
}

/// Points that six numbers and their uncertainty can be found from.
const LEAST_POINTS: usize = 30;

/// Lays the part of a scan on a model.
pub fn align(target: &Target, part: &Part, options: &Options) -> Result<Alignment, AlignError> {
    let n = part.mesh.vertices.len();
    if n < LEAST_POINTS {
        return Err(AlignError::TooFewPoints(n));
    }
    let placed = placements(target, part, options);
    let Some(best) = placed.first() else { return Err(AlignError::NoPlacement(fine::LEAST_EXPLAINED)) };
    let settled = fine::settle(target, part, best);
    if settled.explained < fine::LEAST_EXPLAINED && options.scene == Scene::Part {
        return Err(AlignError::NoPlacement(fine::LEAST_EXPLAINED));
    }
    let freedom = spread::freedom(&settled);
    let alternatives = alternatives::find(target, part, &settled, &freedom, best.score, &placed[1..]);
    Ok(Alignment { alternatives, ..spread::alignment(&settled, freedom, best.found_by) })
}

/// A motion of the scan that is already near: settled, with what the scan says about it.
pub fn refine(target: &Target, part: &Part, start: &Pose) -> Result<Alignment, AlignError> {
    let n = part.mesh.vertices.len();
    if n < LEAST_POINTS {
        return Err(AlignError::TooFewPoints(n));
    }
    let guess = fine::Placed { pose: *start, score: 0.0, found_by: FoundBy::Start };
    let settled = fine::settle(target, part, &guess);
    let freedom = spread::freedom(&settled);
    Ok(spread::alignment(&settled, freedom, FoundBy::Start))
}

/// The scan as it lies, without moving it: what it explains, and no uncertainty.
pub fn as_placed(target: &Target, part: &Part, pose: &Pose) -> Alignment {
    let settled = fine::assess(target, part, pose);
    Alignment { covariance: [[0.0; 6]; 6], ..spread::alignment(&settled, Freedom::default(), FoundBy::Start) }
}

/// A placement that some faces hold, found elsewhere (by datums): what these faces alone say of it.
pub fn held_by(target: &Target, part: &Part, pose: &Pose, faces: &[u32], known: &Alignment) -> Alignment {
    let weights = (0..target.model.faces.len() as u32).map(|f| if faces.contains(&f) { 1.0 } else { 0.0 });
    let settled = fine::held(target, part, pose, known.bend, weights.collect());
    let freedom = spread::freedom(&settled);
    spread::alignment(&settled, freedom, known.found_by)
}

/// Guesses, roughly settled, best first.
fn placements(target: &Target, part: &Part, options: &Options) -> Vec<fine::Placed> {
    let of_model = elements::of_model(target.model);
    let of_scan: Vec<Element> = elements::of_part(part).into_iter().map(|(_, element)| element).collect();
    let limits = coarse::Limits::new(target, part);
    let by_surfaces = match options.scene {
        Scene::Part => coarse::guesses(&of_scan, &of_model, &limits),
        Scene::Assembly => {
            let found = coarse::guesses(&of_model, &of_scan, &limits);
            found.into_iter().map(|pose| pose.inverse()).collect()
        }
    };
    let start = options.start.unwrap_or_default();
    let mut guesses = vec![(start, FoundBy::Start)];
    guesses.extend(by_surfaces.into_iter().map(|pose| (pose, FoundBy::Surfaces)));
    guesses.extend(turns::principal(target, part).into_iter().map(|pose| (pose, FoundBy::Turns)));
    let placed = fine::ranked(target, part, &guesses);
    let enough = placed.first().is_some_and(|best| best.score >= fine::GOOD_SCORE);
    if enough || options.scene == Scene::Assembly {
        return placed;
    }
    let grid = turns::grid(target, part).into_iter().map(|pose| (pose, FoundBy::Turns));
    guesses.extend(grid);
    fine::ranked(target, part, &guesses)
}
