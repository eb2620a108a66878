//! A guess made exact: robust least squares of the distances of raw vertices to the model.
//!
//! Each vertex is compared with the nearest face whose normal is within sixty degrees of its own, and the motion that
//! makes the squares of these distances least is found by Gauss and Newton, over and over: point-to-plane ICP (Y. Chen,
//! G. Medioni, "Object modelling by registration of multiple range images", Image and Vision Computing 10 (1992),
//! 145-155) with the planes replaced by the surfaces themselves. Tukey's biweight discounts what the model does not
//! explain, its scale the spread of the distances, and the reach shrinks with it. Vertices at sharp edges, which
//! scanners round, do not count.
//!
//! A seventh number is found with the motion: how far a scanner's spot draws curved walls towards their middle of
//! curvature, half its variance times the curvature. Sharp edges say how wide the spot is, roughly, and are given as an
//! observation of it; curved faces say the rest. Left out it would push a part towards the hollow side of its walls.
//!
//! Last, whole faces are weighed too: a face that lies farther from the model than the others do, and than its own
//! uncertainty allows, was moved, and counts less. Otherwise a moved face would pull the part after it.

use nalgebra::{SMatrix, SVector};


use super::{FoundBy, Part, Target, spread};
use crate::math::{Point3, Pose, Vec3, centroid, stats};
use crate::par;

pub(super) type Vec7 = SVector<f64, 7>;
pub(super) type Mat7 = SMatrix<f64, 7, 7>;

/// Tukey's constant: 95 % of the efficiency of least squares.
pub(super) const TUKEY: f64 = 4.685;
/// Share of the scan that must lie on the model for a placement to be one.
pub(super) const LEAST_EXPLAINED: f64 = 0.25;
/// Score from which no more guesses are tried.
pub(super) const GOOD_SCORE: f64 = 0.7;

/// A motion, how much of the scan it explains, and where it came from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    pub pose: Pose,
    pub score: f64,
    pub found_by: FoundBy,
}

/// Points with normals, every so manieth of a scan's.
#[derive(Debug)]
pub(super) struct Cloud {
    points: Vec<Point3>,
    normals: Vec<Vec3>,
}

/// A motion, and how far a curved wall is drawn in per curvature.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub pose: Pose,
    /// Squared length.
    pub bend: f64,
}

impl Cloud {
    pub(super) fn new(part: &Part, most: usize) -> Self {
        let n = part.mesh.vertices.len();
        let picked: Vec<usize> = if n <= most { (0..n).collect() } else { (0..most).map(|i| i * n / most).collect() };
        Self {
            points: picked.iter().map(|&i| part.mesh.vertices[i]).collect(),
            normals: picked.iter().map(|&i| part.normals[i]).collect(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.points.len()
    }
}

/// A vertex on the model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contact {
    pub face: u32,
    /// Distance, what the scanner's spot bends taken off.
    pub distance: f64,
    /// Its derivative by a turn about the pivot, a way, and the bend.
    pub row: [f64; 7],
    /// Its place on the model: cells of places do not depend on the distances in them.
    pub foot: Point3,
    pub at_border: bool,
}

/// One per point: the place of the model that it belongs to.
pub(super) fn contacts(
    target: &Target,
    cloud: &Cloud,
    state: &State,
    pivot: &Point3,
    reach: f64,
) -> Vec<Option<Contact>> {
    par::map_indices(cloud.points.len(), |i| {
        let point = state.pose.point(&cloud.points[i]);
        let normal = state.pose.rotation * cloud.normals[i];
        let hit = target.hit(&point, &normal, reach)?;
        let turn = (point - pivot).cross(&hit.normal);
        let curvature = target.curvature(hit.face, &point);
        let row = [turn.x, turn.y, turn.z, hit.normal.x, hit.normal.y, hit.normal.z, curvature];
        let distance = hit.distance + state.bend * curvature;
        Some(Contact { face: hit.face, distance, row, foot: hit.foot, at_border: hit.at_border })
    })
}

/// Tukey's weight of a distance.
fn weight(distance: f64, scale: f64) -> f64 {
    let share = distance / scale;
    if share.abs() >= 1.0 { 0.0 } else { (1.0 - share * share).powi(2) }
}

/// Tukey's cost of a distance, one for what is not explained.
pub(super) fn cost(distance: f64, scale: f64) -> f64 {
    let share = distance / scale;
    if share.abs() >= 1.0 { 1.0 } else { 1.0 - (1.0 - share * share).powi(3) }
}

/// The guesses that explain most, each settled on few points, best first; near repetitions are left out.
pub(super) fn ranked(target: &Target, part: &Part, guesses: &[(Pose, FoundBy)]) -> Vec<Placed> {
    /// Points that a first look and a short settling take.
    const LOOK: usize = 400;
    const SETTLE: usize = 800;
    /// Guesses settled.
    const MOST: usize = 56;
    const STEPS: usize = 12;
    let (look, settle) = (Cloud::new(part, LOOK), Cloud::new(part, SETTLE));
    let wide = wide_reach(target, part);
    let mut scored = par::map(guesses, |(pose, found_by)| {
        Placed { pose: *pose, score: score(target, &look, pose, wide), found_by: *found_by }
    });
    // A stable sort: equal guesses keep the order in which they were made.
    scored.sort_by(|a, b| b.score.total_cmp(&a.score));
    scored.truncate(MOST);
    let narrow = narrow_reach(part);
    let mut placed = par::map(&scored, |guess| {
        let path = Path { reach: wide, steps: STEPS, ..Path::new(part, guess.pose) };
        let pose = path.walk(target, &settle).pose;
        Placed { pose, score: score(target, &settle, &pose, narrow), ..*guess }
    });
    placed.sort_by(|a, b| b.score.total_cmp(&a.score));
    let middle = centroid(&settle.points);
    let radius = spread_of(&settle.points, &middle);
    let mut kept: Vec<Placed> = Vec::new();
    for guess in placed {
        let is_repetition = |other: &Placed| {
            let apart = guess.pose.after(&other.pose.inverse());
            let way = (guess.pose.point(&middle) - other.pose.point(&middle)).norm();
            way + radius * apart.angle() < narrow
        };
        if guess.score > 0.0 && !kept.iter().any(is_repetition) {
            kept.push(guess);
        }
    }
    kept
}

/// Length: from how far a guess may be drawn to the model.
fn wide_reach(target: &Target, part: &Part) -> f64 {
    const SHARE: f64 = 0.06;
    (SHARE * target.diagonal()).max(6.0 * part.tolerances.spacing())
}

/// Length: distance from the model within which a settled scan lies, edges rounded.
pub(super) fn narrow_reach(part: &Part) -> f64 {
    2.0 * part.tolerances.spacing() + 2.0 * TUKEY * part.tolerances.noise()
}

/// Length: spread of distances below which they say nothing.
fn floor(part: &Part) -> f64 {
    part.tolerances.noise().max(part.tolerances.rounding())
}

/// Share of the points that a motion lays on the model, those farther off counting less.
fn score(target: &Target, cloud: &Cloud, pose: &Pose, reach: f64) -> f64 {
    let mut explained = 0.0;
    for i in 0..cloud.points.len() {
        let point = pose.point(&cloud.points[i]);
        let normal = pose.rotation * cloud.normals[i];
        if let Some(hit) = target.hit(&point, &normal, reach) {
            explained += 1.0 - cost(hit.distance, reach);
        }
    }
    explained / cloud.points.len().max(1) as f64
}

/// Repeated least squares from a start.
struct Path {
    start: State,
    /// Distance from which vertices are drawn to the model at first, and at least.
    reach: f64,
    least_reach: f64,
    /// Smallest deviation of distances.
    floor: f64,
    steps: usize,
    prior: Prior,
}

/// What sharp edges say about the bend: its value and standard uncertainty.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    pub bend: f64,
    pub uncertainty: f64,
}

impl Prior {
    fn new(part: &Part) -> Self {
        /// Edges may be round by design, or cut by meshing: no bend at all is two deviations away.
        const UNCERTAIN: f64 = 0.5;
        let bend = 0.5 * part.tolerances.edge_rounding().powi(2);
        Self { bend, uncertainty: UNCERTAIN * bend }
    }

    /// Weight of the observation beside distances of deviation `sigma`, so many of which say what one does.
    pub(super) fn weight(&self, sigma: f64, vertices_per_sample: f64) -> f64 {
        let share = sigma / self.uncertainty.max(f64::MIN_POSITIVE);
        // Without an uncertainty the bend is fixed: by a weight that outdoes any number of vertices.
        (share * share * vertices_per_sample).min(1e30)
    }
}

impl Path {
    fn new(part: &Part, start: Pose) -> Self {
        let prior = Prior::new(part);
        Self {
            start: State { pose: start, bend: prior.bend },
            reach: narrow_reach(part),
            least_reach: narrow_reach(part),
            floor: floor(part),
            steps: 25,
            prior,
        }
    }

    fn walk(&self, target: &Target, cloud: &Cloud) -> State {
        /// Motion, in deviations of the distances, after which none follows that matters beside their mean.
        const STILL: f64 = 1e-4;
        /// Vertices per independent one, until it is measured.
        const PER_SAMPLE: f64 = 10.0;
        let mut state = self.start;
        let mut reach = self.reach;
        let middle = centroid(&cloud.points);
        let radius = spread_of(&cloud.points, &middle).max(f64::MIN_POSITIVE);
        for _ in 0..self.steps {
            let pivot = state.pose.point(&middle);
            let found: Vec<Contact> =
                contacts(target, cloud, &state, &pivot, reach).into_iter().flatten().collect();
            let used = inner(&found);
            let Some(sigma) = deviation(&used) else { break };
            let sigma = sigma.max(self.floor);
            let sums = Sums::new(&used, TUKEY * sigma, |_| 1.0);
            let step = sums.step(radius, &self.prior, state.bend, self.prior.weight(sigma, PER_SAMPLE));
            state = moved(&state, &step, &pivot);
            reach = (2.0 * TUKEY * sigma).max(self.least_reach).min(reach);
            let way = radius * step.fixed_rows::<3>(0).norm() + step.fixed_rows::<3>(3).norm();
            if way < STILL * sigma {
                break;
            }
        }
        state
    }
}

fn moved(state: &State, step: &Vec7, pivot: &Point3) -> State {
    let motion = step.fixed_rows::<6>(0).into_owned();
    State { pose: Pose::of_step(&motion, pivot).after(&state.pose), bend: state.bend + step[6] }
}

/// The contacts that are clear of sharp edges; all when that leaves too few.
fn inner(found: &[Contact]) -> Vec<Contact> {
    const LEAST_SHARE: f64 = 0.2;
    let inner: Vec<Contact> = found.iter().filter(|c| !c.at_border).copied().collect();
    if (inner.len() as f64) < LEAST_SHARE * found.len() as f64 { found.to_vec() } else { inner }
}

/// Robust deviation of distances about zero.
fn deviation(contacts: &[Contact]) -> Option<f64> {
    let distances: Vec<f64> = contacts.iter().map(|c| c.distance).collect();
    stats::sigma_about_zero(&distances)
}

pub(super) fn spread_of(points: &[Point3], middle: &Point3) -> f64 {
    let sum: f64 = points.iter().map(|p| (p - middle).norm_squared()).sum();
    (sum / points.len().max(1) as f64).sqrt()
}

/// Normal equations of the weighted distances.
#[derive(Debug, Clone)]
pub(super) struct Sums {
    /// `J^T W J`.
    pub information: Mat7,
    /// `J^T W r`.
    gradient: Vec7,
    /// `sum (w r)^2 J J^T`.
    pub scatter: Mat7,
    /// `sum psi'(r) J J^T`, the curvature of the cost.
    pub curvature: Mat7,
}

impl Sums {
    /// `scale`: where Tukey's weight is zero. `of_face`: weight of a face.
    pub(super) fn new(contacts: &[Contact], scale: f64, of_face: impl Fn(u32) -> f64) -> Self {
        let mut information = SMatrix::zeros();
        let mut gradient = SVector::zeros();
        let mut scatter = SMatrix::zeros();
        let mut curvature = SMatrix::zeros();
        for contact in contacts {
            let row = Vec7::from(contact.row);
            let share_sq = (contact.distance / scale).powi(2);
            let face = of_face(contact.face);
            let w = weight(contact.distance, scale) * face;
            if w == 0.0 {
                continue;
            }
            let outer = row * row.transpose();
            information += outer * w;
            gradient += row * (w * contact.distance);
            scatter += outer * (w * contact.distance).powi(2);
            curvature += outer * (face * (1.0 - share_sq) * (1.0 - 5.0 * share_sq));
        }
        Self { information, gradient, scatter, curvature }
    }

    /// The step that makes the squares least; none along what the distances do not show.
    fn step(&self, radius: f64, prior: &Prior, bend: f64, prior_weight: f64) -> Vec7 {
        /// Share of the largest information below which there is none.
        const UNSHOWN: f64 = 1e-9;
        // The bend first: what is left of motions is free of it, however firmly it is known.
        let own = self.information[(6, 6)] + prior_weight;
        let own = if own > 0.0 { own } else { 1.0 };
        let cross = self.information.fixed_view::<6, 1>(0, 6).into_owned();
        let bend_gradient = self.gradient[6] + prior_weight * (bend - prior.bend);
        let motions: SMatrix<f64, 6, 6> =
            self.information.fixed_view::<6, 6>(0, 0) - cross * cross.transpose() / own;
        let gradient: SVector<f64, 6> = self.gradient.fixed_rows::<6>(0) - cross * (bend_gradient / own);
        let scale = spread::scale(radius);
        let eigen = spread::scaled(&motions, radius).symmetric_eigen();
        let gradient = gradient.component_mul(&scale);
        let largest = eigen.eigenvalues.max();
        let mut step = SVector::<f64, 6>::zeros();
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            if *value > UNSHOWN * largest && largest > 0.0 {
                step -= vector * (vector.dot(&gradient) / value);
            }
        }
        let step = step.component_mul(&scale);
        let further = -(bend_gradient + cross.dot(&step)) / own;
        // Beyond a fifth of a radian the linear model says nothing.
        let turn = step.fixed_rows::<3>(0).norm();
        let share = if turn > 0.2 { 0.2 / turn } else { 1.0 };
        Vec7::from_fn(|i, _| share * if i < 6 { step[i] } else { further })
    }

    /// The bend that makes the squares least, nothing moved.
    fn bend(&self, prior: &Prior, bend: f64, prior_weight: f64) -> f64 {
        let own = self.information[(6, 6)] + prior_weight;
        let gradient = self.gradient[6] + prior_weight * (bend - prior.bend);
        if own > 0.0 { bend - gradient / own } else { bend }
    }

    /// Information about the motion alone, the bend unknown but for its observation.
    pub(super) fn of_motion(&self, prior_weight: f64) -> SMatrix<f64, 6, 6> {
        let own = self.information[(6, 6)] + prior_weight;
        let cross = self.information.fixed_view::<6, 1>(0, 6).into_owned();
        let own = if own > 0.0 { own } else { 1.0 };
        self.information.fixed_view::<6, 6>(0, 0) - cross * cross.transpose() / own
    }
}

/// A motion with the contacts that it was found from.
#[derive(Debug)]
pub(super) struct Settled {
    pub state: State,
    pub pivot: Point3,
    pub radius: f64,
    pub sigma: f64,
    pub prior: Prior,
    pub contacts: Vec<Contact>,
    /// One per face of the model.
    pub face_weights: Vec<f64>,
    pub explained: f64,
    pub vertices_per_sample: f64,
}

/// Most vertices that a motion is found from: beyond, each adds less than what they have in common.
const MOST_POINTS: usize = 200_000;

/// A guess settled on all vertices, faces that were moved counting less.
pub(super) fn settle(target: &Target, part: &Part, guess: &Placed) -> Settled {
    const FEW: usize = 6_000;
    let few = Cloud::new(part, FEW);
    let path = Path { reach: wide_reach(target, part), ..Path::new(part, guess.pose) };
    let start = path.walk(target, &few);
    let all = Cloud::new(part, MOST_POINTS);
    let state = Path { start, ..Path::new(part, guess.pose) }.walk(target, &all);
    by_faces(target, part, &all, &state)
}

/// What a motion explains, nothing moved.
pub(super) fn assess(target: &Target, part: &Part, pose: &Pose) -> Settled {
    let cloud = Cloud::new(part, MOST_POINTS);
    let even = || vec![1.0; target.model.faces.len()];
    let mut known = settled(target, part, &cloud, State { pose: *pose, bend: Prior::new(part).bend }, even());
    for _ in 0..FACE_ROUNDS {
        let sums = Sums::new(&known.contacts, TUKEY * known.sigma, |_| 1.0);
        let prior_weight = known.prior.weight(known.sigma, known.vertices_per_sample);
        let bend = sums.bend(&known.prior, known.state.bend, prior_weight);
        known = settled(target, part, &cloud, State { pose: *pose, bend }, even());
    }
    known
}

/// What weighed faces say of a motion, nothing moved.
pub(super) fn held(target: &Target, part: &Part, pose: &Pose, bend: f64, weights: Vec<f64>) -> Settled {
    settled(target, part, &Cloud::new(part, MOST_POINTS), State { pose: *pose, bend }, weights)
}

/// Rounds in which faces are weighed.
const FACE_ROUNDS: usize = 5;

fn by_faces(target: &Target, part: &Part, cloud: &Cloud, start: &State) -> Settled {
    let mut known = settled(target, part, cloud, *start, vec![1.0; target.model.faces.len()]);
    for _ in 0..FACE_ROUNDS {
        let weights = face_weights(&known);
        let sums = Sums::new(&known.contacts, TUKEY * known.sigma, |f| weights[f as usize]);
        let prior_weight = known.prior.weight(known.sigma, known.vertices_per_sample);
        if loses_a_freedom(&known, &sums, prior_weight) {
            break;
        }
        let step = sums.step(known.radius, &known.prior, known.state.bend, prior_weight);
        let state = moved(&known.state, &step, &known.pivot);
        known = settled(target, part, cloud, state, weights);
    }
    known
}

/// Whether weighing faces leaves a motion undetermined that was determined before.
fn loses_a_freedom(known: &Settled, sums: &Sums, prior_weight: f64) -> bool {
    /// Loss of information at which what is left is no longer the whole part's word.
    const LOST: f64 = 0.1;
    let even = Sums::new(&known.contacts, TUKEY * known.sigma, |_| 1.0);
    let sorted = |sums: &Sums| {
        let eigen = spread::scaled(&sums.of_motion(prior_weight), known.radius).symmetric_eigen();
        let mut values: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let largest = sorted(&even)[5];
    // What was not determined before cannot be lost.
    let counts = |before: f64| before > spread::NO_INFORMATION * largest;
    sorted(&even).into_iter().zip(sorted(sums)).any(|(before, after)| counts(before) && after < LOST * before)
}

/// Weights of faces, by Tukey's function: of their mean distances, beside what the noise allows and what faces on the
/// whole keep, and of how much more than faces on the whole their distances scatter. A bore that was moved has the
/// scatter, a step that was milled deeper the mean.
fn face_weights(known: &Settled) -> Vec<f64> {
    /// Share of Tukey's constant for scatter: half the deviation more is still a face's own.
    const SCATTER: f64 = 0.5;
    let mut sums = vec![(0.0, 0.0, 0.0); known.face_weights.len()];
    for contact in &known.contacts {
        let sum = &mut sums[contact.face as usize];
        *sum = (sum.0 + contact.distance, sum.1 + contact.distance.powi(2), sum.2 + 1.0);
    }
    let of = |f: &dyn Fn(f64, f64) -> f64| -> Vec<(f64, f64)> {
        sums.iter().filter(|s| s.2 > 0.0).map(|s| (f(s.0 / s.2, s.1 / s.2), s.2)).collect()
    };
    let usual = weighted_median(&of(&|mean, _| mean)) * stats::MAD_TO_SIGMA;
    let scatter = weighted_median(&of(&|_, square| square.sqrt()));
    let of_face = |&(sum, square, n): &(f64, f64, f64)| {
        if n == 0.0 {
            return 1.0;
        }
        let per_sample = known.vertices_per_sample / n;
        let own = known.sigma * per_sample.sqrt();
        // Three deviations of a variance from so many samples.
        let allowed = scatter.powi(2) * (1.0 + 3.0 * (2.0 * per_sample).sqrt());
        let excess = (square / n - allowed).max(0.0).sqrt();
        let by_scatter = weight(excess, SCATTER * TUKEY * scatter.max(known.sigma));
        weight(sum / n, TUKEY * own.hypot(usual)) * by_scatter
    };
    sums.iter().map(of_face).collect()
}

/// Median of the magnitudes of values, by weight.
fn weighted_median(values: &[(f64, f64)]) -> f64 {
    let mut sorted: Vec<(f64, f64)> = values.iter().map(|(v, w)| (v.abs(), *w)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * sorted.iter().map(|v| v.1).sum::<f64>();
    let mut sum = 0.0;
    for (value, weight) in sorted {
        sum += weight;
        if sum >= half {
            return value;
        }
    }
    0.0
}

fn settled(target: &Target, part: &Part, cloud: &Cloud, state: State, face_weights: Vec<f64>) -> Settled {
    let middle = centroid(&cloud.points);
    let pivot = state.pose.point(&middle);
    let all = contacts(target, cloud, &state, &pivot, narrow_reach(part));
    let found: Vec<Contact> = all.iter().flatten().copied().collect();
    let used = inner(&found);
    let sigma = deviation(&used).unwrap_or(0.0).max(floor(part));
    let near = used.iter().filter(|c| c.distance.abs() < TUKEY * sigma).count();
    let n_judged = all.len() - (found.len() - used.len());
    let vertices_per_sample = spread::correlation(&used, TUKEY * sigma, part.tolerances.spacing());
    Settled {
        state,
        pivot,
        radius: spread_of(&cloud.points, &middle).max(f64::MIN_POSITIVE),
        sigma,
        prior: Prior::new(part),
        contacts: used,
        face_weights,
        explained: near as f64 / n_judged.max(1) as f64,
        vertices_per_sample,
    }
}

/// A placement settled on few points, and its cost.
pub(super) fn compared(target: &Target, part: &Part, start: &State, scale: f64, most: usize) -> (Pose, f64) {
    const FEW: usize = 2_500;
    const STEPS: usize = 10;
    let path = Path { start: *start, steps: STEPS, ..Path::new(part, start.pose) };
    let state = path.walk(target, &Cloud::new(part, FEW));
    (state.pose, mean_cost(target, part, &state, scale, most))
}

/// Mean of Tukey's costs of so many points, one for each that is not explained; those at borders are discounted by how
/// much a scanner rounds there.
pub(super) fn mean_cost(target: &Target, part: &Part, state: &State, scale: f64, most: usize) -> f64 {
    let cloud = Cloud::new(part, most);
    let rounded = scale + super::border_width(&part.tolerances);
    let of_contact = |contact: &Option<Contact>| match contact {
        None => 1.0,
        Some(c) => cost(c.distance, if c.at_border { rounded } else { scale }),
    };
    let found = contacts(target, &cloud, state, &Point3::origin(), narrow_reach(part).max(rounded));
    found.iter().map(of_contact).sum::<f64>() / cloud.len().max(1) as f64
}
