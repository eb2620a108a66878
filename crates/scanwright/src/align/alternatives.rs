//! Other placements that explain a scan as well: the symmetries of a part, as far as the scan shows them.

use super::fine::{Placed, Settled, State, TUKEY, compared, mean_cost};
use super::spread::Freedom;
use super::{Part, Target};
use crate::math::{Axis, Pose, UnitVec3, Vec3};

/// Another placement that explains the scan as well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alternative {
    /// Takes the scan's coordinates to the model's.
    pub pose: Pose,
    /// How much worse it explains the scan, in squared standard deviations; negative when better.
    pub excess: f64,
}

impl Alternative {
    /// The turn, radians, and its direction, that takes the found placement to this one, in the model's coordinates.
    pub fn turn_from(&self, found: &Pose) -> Option<(f64, UnitVec3)> {
        let apart = self.pose.after(&found.inverse());
        apart.rotation.axis().map(|axis| (apart.angle(), UnitVec3::new_normalize(axis.into_inner())))
    }
}

/// Squared standard deviations up to which a placement is no worse: three and a half.
const AS_GOOD: f64 = 12.0;
/// Placements looked at, and returned.
const MOST_TRIED: usize = 48;
const MOST: usize = 24;
/// Points on which placements are compared.
const POINTS: usize = 10_000;
/// Share of the best score below which a placement is not looked at.
const LEAST_SCORE: f64 = 0.96;

/// The placements among `others`, best first, that are as good as the settled one and not one with it.
pub(super) fn find(
    target: &Target,
    part: &Part,
    settled: &Settled,
    freedom: &Freedom,
    best_score: f64,
    others: &[Placed],
) -> Vec<Alternative> {
    let scale = TUKEY * settled.sigma;
    let best = mean_cost(target, part, &settled.state, scale, POINTS);
    let n_samples = part.mesh.vertices.len() as f64 / settled.vertices_per_sample;
    // Tukey's cost of one, a third of the square of its constant, in squared deviations.
    let per_cost = TUKEY * TUKEY / 3.0 * n_samples;
    let least = LEAST_SCORE * others.iter().map(|o| o.score).fold(best_score, f64::max);
    let tried: Vec<&Placed> = others.iter().take(MOST_TRIED).filter(|o| o.score >= least).collect();
    let near = Nearness { length: super::fine::narrow_reach(part) + 0.01 * settled.radius, angle: 0.035 };
    let mut found: Vec<Alternative> = Vec::new();
    for other in tried {
        if found.len() >= MOST || near.same(&other.pose, &settled.state.pose, freedom, settled) {
            continue;
        }
        let start = State { pose: other.pose, bend: settled.state.bend };
        let (pose, cost) = compared(target, part, &start, scale, POINTS);
        let known = |a: &Pose| near.same(&pose, a, freedom, settled);
        let excess = (cost - best) * per_cost;
        if excess < AS_GOOD && !known(&settled.state.pose) && !found.iter().any(|a| known(&a.pose)) {
            found.push(Alternative { pose, excess });
        }
    }
    found.sort_by(|a, b| a.excess.total_cmp(&b.excess));
    found
}

/// Differences that are none.
struct Nearness {
    length: f64,
    angle: f64,
}

impl Nearness {
    /// Whether two placements differ by free motions only.
    fn same(&self, a: &Pose, b: &Pose, freedom: &Freedom, settled: &Settled) -> bool {
        let apart = a.after(&b.inverse());
        let kept = |axis: &Axis, ends: bool| {
            let way = apart.point(&axis.origin) - axis.origin;
            let along = way.dot(&axis.direction);
            let off = if ends { way.norm() } else { (way - axis.direction.into_inner() * along).norm() };
            let turned = (apart.rotation * axis.direction.into_inner() - axis.direction.into_inner()).norm();
            off < self.length && turned < self.angle
        };
        let way = apart.point(&settled.pivot) - settled.pivot;
        let across = |d: &UnitVec3| (way - d.into_inner() * way.dot(d)).norm();
        match freedom {
            Freedom::None => way.norm() < self.length && apart.angle() < self.angle,
            Freedom::Turn(axis) => kept(axis, true),
            Freedom::TurnAndSlide(axis) => kept(axis, false),
            Freedom::Slide(d) => across(d) < self.length && apart.angle() < self.angle,
            Freedom::TurnsAbout(p) => (apart.point(p) - p).norm() < self.length,
            Freedom::InPlane(n) => {
                let normal: Vec3 = n.into_inner();
                way.dot(n).abs() < self.length && (apart.rotation * normal - normal).norm() < self.angle
            }
            // Nothing tells them apart.
            Freedom::Other(_) => true,
        }
    }
}
