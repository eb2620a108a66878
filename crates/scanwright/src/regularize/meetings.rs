//! Axes that meet: crossing bores, a shaft and its pin.
//!
//! Two lines of different directions pass each other at a distance whose variance is that of both along their common normal.
//! They meet when that distance is no larger than it explains and would rarely be so small by accident; the prior is how
//! often others meet the better seen of the two, as it is for angles. All lines are one Gaussian state of a motion across
//! each; what was accepted before is an observation without error (see `angles`).

use nalgebra::{DMatrix, Matrix2, Matrix3x2, Vector2};

use super::custom::Custom;
use super::directions::Direction;
use super::gaussian::{Gaussian, Row};
use super::lines::{Line, PlacedLine};
use super::{DECIDED, MAX_ACCIDENT, MAX_SIGMAS, PINNED};
use crate::math::{Mat3, Point3, Vec3, try_unit};

/// Lines that are looked at, best seen first: bounds the cost, cubic in their number.
const MAX_LINES: usize = 60;
/// Sine of the angle from which two directions are different enough for a common normal.
const APART: f64 = 0.1;

/// Two lines that meet.
#[derive(Debug, Clone)]
pub(super) struct Meeting {
    /// Indices of lines.
    pub lines: [usize; 2],
    /// The distance that they had, in its standard uncertainties and as a length.
    pub z: f64,
    pub shift: f64,
}

/// A line that may meet others.
struct Seen {
    line: usize,
    point: Point3,
    direction: Direction,
    tangents: Matrix3x2<f64>,
    /// What `point` moves by when the direction does.
    by_direction: Mat3,
    /// Whether an arrangement holds it where it is.
    is_fixed: bool,
}

/// Lines that meet; `placed` is moved to that. `is_arranged`: one per line, whether it is to stay. `extent`: size of the part.
/// `asked`: the pairs of lines that are to meet; found by evidence when `None`.
pub(super) fn meetings(
    lines: &[Line],
    directions: &[Direction],
    placed: &mut [PlacedLine],
    is_arranged: &[bool],
    extent: f64,
    asked: Option<&[[usize; 2]]>,
) -> Vec<Meeting> {
    let mut state = State::new(lines, directions, placed, is_arranged);
    let found = match asked {
        None => state.found(extent),
        Some(asked) => state.forced(asked),
    };
    for (k, seen) in state.seen.iter().enumerate() {
        let moved = state.motions.moved.fixed_rows::<2>(2 * k).into_owned();
        if moved != Vector2::zeros() && !is_arranged[seen.line] {
            let covariance: Matrix2<f64> =
                state.motions.covariance.fixed_view::<2, 2>(2 * k, 2 * k).into_owned();
            let line = &mut placed[seen.line];
            line.through += seen.tangents * moved;
            line.covariance = seen.tangents * covariance * seen.tangents.transpose();
        }
    }
    found
}

/// Lines as a Gaussian of motions across them.
struct State {
    seen: Vec<Seen>,
    /// Motions in the tangents of each.
    motions: Gaussian,
}

impl State {
    fn new(lines: &[Line], directions: &[Direction], placed: &[PlacedLine], is_arranged: &[bool]) -> Self {
        let mut order: Vec<usize> = (0..lines.len()).collect();
        order.sort_by(|&a, &b| {
            placed[a].covariance.trace().total_cmp(&placed[b].covariance.trace()).then(a.cmp(&b))
        });
        order.truncate(MAX_LINES);
        let mut covariance = DMatrix::zeros(2 * order.len(), 2 * order.len());
        let mut seen = Vec::with_capacity(order.len());
        for (k, line) in order.into_iter().enumerate() {
            let direction = directions[lines[line].cluster()];
            let tangents = direction.tangents();
            let own = tangents.transpose() * placed[line].covariance * tangents;
            let share = if is_arranged[line] { PINNED } else { 1.0 };
            covariance.fixed_view_mut::<2, 2>(2 * k, 2 * k).copy_from(&(own * share));
            let PlacedLine { through: point, by_direction, .. } = placed[line];
            let is_fixed = is_arranged[line];
            seen.push(Seen { line, point, direction, tangents, by_direction, is_fixed });
        }
        Self { seen, motions: Gaussian::new(covariance) }
    }

    /// Distance at which two lines pass each other, signed, and its derivative by the motions; `None` for parallel ones
    /// and for two that neither may move.
    fn distance(&self, (a, b): (usize, usize)) -> Option<(f64, Row)> {
        let [one, other] = [&self.seen[a], &self.seen[b]];
        let across = one.direction.unit.cross(&other.direction.unit);
        let may_meet = across.norm() > APART && !(one.is_fixed && other.is_fixed);
        let normal = try_unit(across).filter(|_| may_meet)?;
        let at =
            |k: usize| self.seen[k].point + self.seen[k].tangents * self.motions.moved.fixed_rows::<2>(2 * k);
        let apart: Vec3 = at(b) - at(a);
        let by_a = -one.tangents.transpose() * normal.into_inner();
        let by_b = other.tangents.transpose() * normal.into_inner();
        let row = [(2 * a, by_a.x), (2 * a + 1, by_a.y), (2 * b, by_b.x), (2 * b + 1, by_b.y)];
        Some((normal.dot(&apart), row))
    }

    /// What the directions of two lines add to the variance of their distance: where the two meet they have a lever.
    fn variance_by_direction(&self, (a, b): (usize, usize)) -> f64 {
        let [one, other] = [&self.seen[a], &self.seen[b]];
        let Some(normal) = try_unit(one.direction.unit.cross(&other.direction.unit)) else { return 0.0 };
        let of = |own: &Seen, met: &Seen| {
            // The place along `own` that is nearest to the other line.
            let beside = met.direction.unit.cross(&normal);
            let along = (met.point - own.point).dot(&beside) / own.direction.unit.dot(&beside);
            let lever = (own.by_direction + Mat3::identity() * along).transpose() * normal.into_inner();
            lever.dot(&(own.direction.covariance * lever))
        };
        of(one, other) + of(other, one)
    }

    fn meeting(&self, (a, b): (usize, usize), distance: f64, variance: f64) -> Meeting {
        let lines = [self.seen[a].line, self.seen[b].line];
        Meeting { lines, z: distance.abs() / variance.sqrt(), shift: distance.abs() }
    }

    /// Makes the lines meet that do by the evidence, best seen first.
    fn found(&mut self, extent: f64) -> Vec<Meeting> {
        let n = self.seen.len();
        let mut candidates: Vec<(f64, (usize, usize))> = (0..n)
            .flat_map(|a| (a + 1..n).map(move |b| (a, b)))
            .filter_map(|pair| Some((self.motions.variance(&self.distance(pair)?.1), pair)))
            .collect();
        candidates.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        let mut customs = vec![Custom::default(); n];
        let mut meetings = Vec::new();
        for (at_first, pair) in candidates {
            let Some((distance, row)) = self.distance(pair) else { continue };
            let variance = self.motions.variance(&row);
            if variance < DECIDED * at_first {
                continue;
            }
            let total = variance + self.variance_by_direction(pair);
            // Unrelated lines pass each other at any distance up to the size of the part, on either side.
            let accident = MAX_SIGMAS * total.sqrt() / extent;
            let holds = distance.abs() < MAX_SIGMAS * total.sqrt();
            let custom = &mut customs[pair.0];
            if holds && custom.accident(accident) < MAX_ACCIDENT {
                meetings.push(self.meeting(pair, distance, total));
                self.motions.observe(distance, &row, variance);
            }
            if accident < MAX_ACCIDENT {
                custom.count(holds);
            }
        }
        meetings
    }

    /// Makes the lines meet that are asked to, as far as others leave them free to.
    fn forced(&mut self, asked: &[[usize; 2]]) -> Vec<Meeting> {
        let home = |state: &Self, line: usize| state.seen.iter().position(|seen| seen.line == line);
        let mut meetings = Vec::new();
        for &[a, b] in asked {
            let Some(pair) = home(self, a).zip(home(self, b)) else { continue };
            let Some((distance, row)) = self.distance(pair) else { continue };
            let variance = self.motions.variance(&row);
            if variance > 0.0 {
                meetings.push(self.meeting(pair, distance, variance));
                self.motions.observe(distance, &row, variance);
            }
        }
        meetings
    }
}
