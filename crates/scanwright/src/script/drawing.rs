//! An outline as a designer draws it: corners joined by lines and arcs, corners then rounded or broken.

use super::curve::{Curve, cross};
use super::feature::{Ring, Segment};
use super::sweep::Point2;

/// What is done to a corner after it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Treatment {
    Sharp,
    /// An arc that touches both neighbours.
    Fillet {
        radius: f64,
        faces: Vec<usize>,
    },
    /// A line that takes as much off both neighbours.
    Chamfer {
        length: f64,
        faces: Vec<usize>,
    },
}

/// A corner, and the piece from it to the next one.
#[derive(Debug, Clone)]
pub(super) struct Corner {
    pub(super) at: Point2,
    /// Faces that its coordinates are those of: of a side upright there, of a side level there.
    pub(super) faces: [Vec<usize>; 2],
    pub(super) treatment: Treatment,
    /// The arc to the next corner; a line without one.
    pub(super) arc: Option<Arc>,
}

/// See [`Corner::arc`].
#[derive(Debug, Clone)]
pub(super) struct Arc {
    /// Positive when it turns left.
    pub(super) radius: f64,
    /// Whether it turns by more than half a turn.
    pub(super) is_large: bool,
    pub(super) shape: ArcShape,
    pub(super) faces: Vec<usize>,
}

/// What an arc is told by: near half a turn its radius and ends say little about where it runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ArcShape {
    Radius,
    /// Half a circle about the middle of its ends.
    Half,
    /// The point midway.
    Through(Point2),
}

/// The corners of a ring, in order; empty of a whole circle.
pub(super) fn corners(ring: &Ring, tolerance: f64) -> Vec<Corner> {
    if ring.circle().is_some() {
        return Vec::new();
    }
    let pieces = ring.segments.as_slice();
    let n = pieces.len();
    // A treated piece stands for the corner of its neighbours; two in a row would share one.
    let mut treated: Vec<Option<(Point2, Treatment)>> = vec![None; n];
    for i in 0..n {
        let (before, after) = ((i + n - 1) % n, (i + 1) % n);
        if n >= 4 && treated[before].is_none() && treated[after].is_none() {
            treated[i] = treatment(&pieces[before], &pieces[i], &pieces[after], tolerance);
        }
    }
    let mut made = Vec::new();
    for i in 0..n {
        let before = (i + n - 1) % n;
        // The corner where piece `i` begins.
        let (from, at, treatment) = if treated[before].is_some() {
            continue;
        } else if let Some((at, treatment)) = treated[i].clone() {
            ((i + n - 1) % n, at, treatment)
        } else {
            (before, pieces[i].from, Treatment::Sharp)
        };
        let to = if treated[i].is_some() { (i + 1) % n } else { i };
        made.push(corner(&pieces[from], &pieces[to], at, treatment, tolerance));
    }
    made
}

fn corner(before: &Segment, after: &Segment, at: Point2, treatment: Treatment, tolerance: f64) -> Corner {
    let (mut exact, mut faces) = (at, [Vec::new(), Vec::new()]);
    for piece in [before, after] {
        let Curve::Line { point, .. } = piece.curve else { continue };
        for axis in 0..2 {
            if is_constant(piece, axis) {
                exact[axis] = point[axis];
                faces[axis].clone_from(&piece.faces);
            }
        }
    }
    Corner { at: exact, faces, treatment, arc: arc(after, tolerance) }
}

/// Whether a line keeps one coordinate.
pub(super) fn is_constant(piece: &Segment, axis: usize) -> bool {
    /// Slope that rounding may leave.
    const LEVEL: f64 = 1e-4;
    matches!(piece.curve, Curve::Line { direction, .. } if direction[axis].abs() < LEVEL)
}

fn arc(piece: &Segment, tolerance: f64) -> Option<Arc> {
    /// Share of the radius that the centre must be beside the chord for ends and radius to say where the arc runs.
    const BESIDE: f64 = 0.3;
    let Curve::Circle { center, radius } = piece.curve else { return None };
    let sweep = piece.sweep();
    let is_large = sweep.abs() > std::f64::consts::PI;
    let middle = (piece.from + piece.to) * 0.5;
    let half = 0.5 * (piece.to - piece.from).norm();
    let off = (center - middle).norm();
    let shape = if off > BESIDE * radius {
        ArcShape::Radius
    } else if off <= tolerance && (half - radius).abs() <= tolerance {
        ArcShape::Half
    } else {
        let start = piece.from - center;
        let (sin, cos) = (0.5 * sweep).sin_cos();
        let turned = Point2::new(start.x * cos - start.y * sin, start.x * sin + start.y * cos);
        ArcShape::Through(center + turned)
    };
    Some(Arc { radius: radius * sweep.signum(), is_large, shape, faces: piece.faces.clone() })
}

/// The corner of its neighbours that a piece stands for, if it is a fillet or a chamfer between two lines.
fn treatment(
    before: &Segment,
    piece: &Segment,
    after: &Segment,
    tolerance: f64,
) -> Option<(Point2, Treatment)> {
    let (Curve::Line { .. }, Curve::Line { .. }) = (before.curve, after.curve) else { return None };
    let (a, b) = ((before.to - before.from).normalize(), (after.to - after.from).normalize());
    let sine = cross(&a, &b);
    /// Sine of the angle of neighbours that are too nearly in line to have a corner.
    const FLAT: f64 = 0.1;
    if sine.abs() < FLAT {
        return None;
    }
    let at = before.to + a * (cross(&(after.from - before.to), &b) / sine);
    let (first, second) = ((at - before.to).dot(&a), (after.from - at).dot(&b));
    if first <= 0.0 || second <= 0.0 || at.x < 0.0_f64.min(piece.from.x) {
        return None;
    }
    let faces = piece.faces.clone();
    match piece.curve {
        Curve::Circle { radius, .. } => {
            // As far as noise may turn a tangent: what moves its end by the tolerance.
            let slack = (2.0 * (2.0 * tolerance / radius).sqrt()).min(0.5);
            // A round end leaves nothing straight between its two arcs, and a kernel nothing to round.
            let lengths = [(before.to - before.from).norm(), (after.to - after.from).norm()];
            let touches = lengths.iter().all(|l| *l > 2.0 * tolerance)
                && cross(&a, &piece.leaves()).abs() < slack
                && cross(&piece.arrives(), &b).abs() < slack
                && a.dot(&piece.leaves()) > 0.0
                && b.dot(&piece.arrives()) > 0.0
                && piece.sweep().abs() < 3.0;
            touches.then_some((at, Treatment::Fillet { radius, faces }))
        }
        Curve::Line { .. } => {
            let is_equal = (first - second).abs() <= 2.0 * tolerance;
            let is_square = sine.abs() > 0.999;
            let length = 0.5 * (first + second);
            let lengths = [(before.to - before.from).norm(), (after.to - after.from).norm()];
            let is_small = lengths.iter().all(|l| length < *l);
            let is_chamfer = is_equal && is_square && is_small && !faces.is_empty();
            is_chamfer.then_some((at, Treatment::Chamfer { length, faces }))
        }
    }
}

/// Low and high corner of a rectangle along the axes without treatment; `None` of anything else.
pub(super) fn rectangle(corners: &[Corner]) -> Option<(Point2, Point2)> {
    if corners.len() != 4 || corners.iter().any(|c| c.arc.is_some() || c.treatment != Treatment::Sharp) {
        return None;
    }
    let first = corners[0].at;
    let (low, high) = corners.iter().fold((first, first), |(l, h), c| (l.inf(&c.at), h.sup(&c.at)));
    let is_end = |c: &Corner, axis: usize| c.at[axis] == low[axis] || c.at[axis] == high[axis];
    corners.iter().all(|c| is_end(c, 0) && is_end(c, 1)).then_some((low, high))
}
