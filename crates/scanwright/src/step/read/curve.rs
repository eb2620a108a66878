//! Curves of edges and of swept surfaces.

use super::StepReadError;
use super::nurbs::{Jet1, Knots, NurbsCurve, Pole};
use super::part21::{Exchange, Fields, Instance};
use super::placement::{frame, point, vector};
use crate::math::{Frame, Point3, Vec3};

/// A curve in space.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Curve {
    /// `origin + t * direction`.
    Line { origin: Point3, direction: Vec3 },
    /// Also circles; `t` is an angle.
    Ellipse { frame: Frame, semi_axes: (f64, f64) },
    /// `focal_length * (t^2 x + 2 t y)`.
    Parabola { frame: Frame, focal_length: f64 },
    /// `a cosh t x + b sinh t y`.
    Hyperbola { frame: Frame, semi_axes: (f64, f64) },
    /// A B-spline, and starts for projections on it.
    Spline { curve: NurbsCurve, closed: bool, starts: Vec<(f64, Point3)> },
}

/// Most curves that one is given by in turn.
const LONGEST_CHAIN: usize = 8;
/// Highest degree of a spline; the schema sets none, systems stop at 25 or before.
const HIGHEST_DEGREE: usize = 32;

/// Reads a curve; trims are left to who uses it.
pub(super) fn read(exchange: &Exchange, id: u64) -> Result<Curve, StepReadError> {
    read_within(exchange, id, LONGEST_CHAIN)
}

fn read_within(exchange: &Exchange, id: u64, chain: usize) -> Result<Curve, StepReadError> {
    if chain == 0 {
        return Err(StepReadError::Cycle(id));
    }
    let entity = exchange.get(id)?;
    let placed = |name: &str| entity.fields(name, 1).reference(0).and_then(|id| frame(exchange, id));
    let size = |fields: Fields, i: usize| positive(&entity, fields.real(i)?);
    if entity.is("LINE") {
        let fields = entity.fields("LINE", 1);
        let direction = vector(exchange, fields.reference(1)?)?;
        if direction.norm() == 0.0 {
            return Err(entity.wrong("has a vector without length", "a direction"));
        }
        return Ok(Curve::Line { origin: point(exchange, fields.reference(0)?)?, direction });
    }
    if entity.is("CIRCLE") {
        let radius = size(entity.fields("CIRCLE", 2), 0)?;
        return Ok(Curve::Ellipse { frame: conic_frame(&entity, placed)?, semi_axes: (radius, radius) });
    }
    if entity.is("ELLIPSE") || entity.is("HYPERBOLA") {
        let is_ellipse = entity.is("ELLIPSE");
        let fields = entity.fields(if is_ellipse { "ELLIPSE" } else { "HYPERBOLA" }, 2);
        let semi_axes = (size(fields, 0)?, size(fields, 1)?);
        let frame = conic_frame(&entity, placed)?;
        return Ok(if is_ellipse {
            Curve::Ellipse { frame, semi_axes }
        } else {
            Curve::Hyperbola { frame, semi_axes }
        });
    }
    if entity.is("PARABOLA") {
        let focal_length = size(entity.fields("PARABOLA", 2), 0)?;
        return Ok(Curve::Parabola { frame: conic_frame(&entity, placed)?, focal_length });
    }
    if entity.is("POLYLINE") {
        let ids = entity.fields("POLYLINE", 1).references(0)?;
        let points: Result<Vec<Point3>, _> = ids.iter().map(|id| point(exchange, *id)).collect();
        return polyline(&entity, &points?);
    }
    if entity.is("B_SPLINE_CURVE") || entity.leaves.iter().any(|l| SPLINES.contains(&l.name)) {
        return spline(exchange, &entity);
    }
    for name in ["SURFACE_CURVE", "SEAM_CURVE", "INTERSECTION_CURVE", "TRIMMED_CURVE"] {
        if entity.is(name) {
            // A seam in several leaves holds its curve as a surface curve.
            let leaf = if entity.is("SURFACE_CURVE") { "SURFACE_CURVE" } else { name };
            return read_within(exchange, entity.fields(leaf, 1).reference(0)?, chain - 1);
        }
    }
    Err(entity.unsupported())
}

const SPLINES: &[&str] = &[
    "B_SPLINE_CURVE_WITH_KNOTS",
    "BEZIER_CURVE",
    "QUASI_UNIFORM_CURVE",
    "UNIFORM_CURVE",
    "RATIONAL_B_SPLINE_CURVE",
];

fn conic_frame(
    entity: &Instance,
    placed: impl Fn(&str) -> Result<Frame, StepReadError>,
) -> Result<Frame, StepReadError> {
    // A complex instance keeps the placement with `CONIC`.
    if entity.leaves.len() > 1 { placed("CONIC") } else { placed("") }
}

pub(super) fn positive(entity: &Instance, x: f64) -> Result<f64, StepReadError> {
    if x > 0.0 { Ok(x) } else { Err(entity.wrong(format!("has a size of {x}"), "a positive size")) }
}

/// A polyline as a spline of degree one over its chords' lengths.
fn polyline(entity: &Instance, points: &[Point3]) -> Result<Curve, StepReadError> {
    let mut kept: Vec<Point3> = Vec::with_capacity(points.len());
    for p in points {
        if kept.last() != Some(p) {
            kept.push(*p);
        }
    }
    if kept.len() < 2 {
        return Err(entity.wrong("has fewer than two different points", "two or more"));
    }
    let mut values = vec![0.0, 0.0];
    for pair in kept.windows(2) {
        values.push(values[values.len() - 1] + (pair[1] - pair[0]).norm());
    }
    values.push(values[values.len() - 1]);
    let poles = kept.iter().map(Point3::to_homogeneous).collect();
    Ok(Curve::spline(NurbsCurve { knots: Knots { degree: 1, values }, poles }))
}

fn spline(exchange: &Exchange, entity: &Instance) -> Result<Curve, StepReadError> {
    let base = entity.fields("B_SPLINE_CURVE", 1);
    let (degree, ids) = (base.count(0)?, base.references(1)?);
    let weights = if entity.is("RATIONAL_B_SPLINE_CURVE") {
        Some(entity.fields("RATIONAL_B_SPLINE_CURVE", 6).reals(0)?)
    } else {
        None
    };
    if weights.as_ref().is_some_and(|w| w.len() != ids.len()) {
        return Err(entity.wrong("has another number of weights than of poles", "one weight per pole"));
    }
    let poles = ids
        .iter()
        .enumerate()
        .map(|(i, id)| pole(entity, point(exchange, *id)?, weights.as_ref().map_or(1.0, |w| w[i])));
    let poles: Vec<Pole> = poles.collect::<Result<_, _>>()?;
    let knots = if entity.is("B_SPLINE_CURVE_WITH_KNOTS") {
        let fields = entity.fields("B_SPLINE_CURVE_WITH_KNOTS", 6);
        knots(entity, degree, poles.len(), &fields.counts(0)?, &fields.reals(1)?)?
    } else {
        implied_knots(entity, degree, poles.len())?
    };
    Ok(Curve::spline(NurbsCurve { knots, poles }))
}

/// A pole with its weight.
pub(super) fn pole(entity: &Instance, p: Point3, weight: f64) -> Result<Pole, StepReadError> {
    let w = positive(entity, weight)?;
    Ok(Pole::new(p.x * w, p.y * w, p.z * w, w))
}

/// Knots from their values and multiplicities.
pub(super) fn knots(
    entity: &Instance,
    degree: usize,
    n_poles: usize,
    multiplicities: &[usize],
    distinct: &[f64],
) -> Result<Knots, StepReadError> {
    let most = n_poles + degree + 1;
    let sum = multiplicities.iter().fold(0_usize, |sum, m| sum.saturating_add(*m));
    if degree == 0 || degree > HIGHEST_DEGREE || n_poles <= degree {
        return Err(entity.wrong(
            format!("has degree {degree} with {n_poles} poles"),
            "a degree from 1 to 32 and more poles than that",
        ));
    }
    if multiplicities.len() != distinct.len() || sum != most {
        return Err(entity.wrong(format!("has {sum} knots"), "one per pole, the degree and one more"));
    }
    if distinct.windows(2).any(|w| w[0] >= w[1]) {
        return Err(entity.wrong("has knots that do not rise", "rising knots"));
    }
    let values = multiplicities.iter().zip(distinct).flat_map(|(m, t)| std::iter::repeat_n(*t, *m)).collect();
    let knots = Knots { degree, values };
    let (low, high) = knots.range();
    if low < high { Ok(knots) } else { Err(entity.wrong("has no range between its knots", "rising knots")) }
}

/// Knots of the types that do not list them.
pub(super) fn implied_knots(
    entity: &Instance,
    degree: usize,
    n_poles: usize,
) -> Result<Knots, StepReadError> {
    let clamped = |n_spans: usize, inner: usize| {
        let mut multiplicities = vec![inner; n_spans + 1];
        multiplicities[0] = degree + 1;
        multiplicities[n_spans] = degree + 1;
        multiplicities
    };
    let has = |word: &str| entity.leaves.iter().any(|l| l.name.starts_with(word));
    let multiplicities = if has("BEZIER") {
        clamped(n_poles.saturating_sub(1).checked_div(degree).unwrap_or(0).max(1), degree)
    } else if has("UNIFORM") {
        vec![1; n_poles + degree + 1]
    } else {
        clamped(n_poles.saturating_sub(degree).max(1), 1)
    };
    let distinct: Vec<f64> = (0..multiplicities.len()).map(|i| i as f64).collect();
    knots(entity, degree, n_poles, &multiplicities, &distinct)
}

impl Curve {
    pub(super) fn spline(curve: NurbsCurve) -> Self {
        /// Starts per span and degree: between two of them a span has no room for a second nearest point.
        const STARTS: usize = 3;
        let mut starts = Vec::new();
        let breaks = curve.knots.breaks();
        let n = STARTS * curve.knots.degree;
        for pair in breaks.windows(2) {
            let at = (0..n).map(|i| pair[0] + (pair[1] - pair[0]) * i as f64 / n as f64);
            starts.extend(at.map(|t| (t, curve.jet(t).0)));
        }
        let (low, high) = curve.knots.range();
        starts.push((high, curve.jet(high).0));
        let (first, last) = (curve.jet(low).0, curve.jet(high).0);
        let size = starts.iter().map(|(_, p)| (p - first).norm()).fold(0.0, f64::max);
        Self::Spline { closed: (last - first).norm() <= CLOSED * size, curve, starts }
    }

    /// Point, first and second derivative.
    pub(super) fn jet(&self, t: f64) -> Jet1 {
        let in_frame = |frame: &Frame, (x, y): (f64, f64), d: (f64, f64), dd: (f64, f64)| {
            let vector = |(a, b): (f64, f64)| frame.x.into_inner() * a + frame.y.into_inner() * b;
            (frame.origin + vector((x, y)), vector(d), vector(dd))
        };
        match self {
            Self::Line { origin, direction } => (origin + direction * t, *direction, Vec3::zeros()),
            Self::Ellipse { frame, semi_axes: (a, b) } => {
                let (sin, cos) = t.sin_cos();
                in_frame(frame, (a * cos, b * sin), (-a * sin, b * cos), (-a * cos, -b * sin))
            }
            Self::Parabola { frame, focal_length: f } => {
                in_frame(frame, (f * t * t, 2.0 * f * t), (2.0 * f * t, 2.0 * f), (2.0 * f, 0.0))
            }
            Self::Hyperbola { frame, semi_axes: (a, b) } => {
                let (sinh, cosh) = (t.sinh(), t.cosh());
                in_frame(frame, (a * cosh, b * sinh), (a * sinh, b * cosh), (a * cosh, b * sinh))
            }
            Self::Spline { curve, .. } => curve.jet(t),
        }
    }

    pub(super) fn point(&self, t: f64) -> Point3 {
        self.jet(t).0
    }

    /// Parameter of the point nearest to `p`, or near to it where the curve is an ellipse and `p` beside it.
    pub(super) fn parameter(&self, p: &Point3) -> f64 {
        match self {
            Self::Line { origin, direction } => (p - origin).dot(direction) / direction.norm_squared(),
            Self::Ellipse { frame, semi_axes: (a, b) } => {
                let local = frame.local(p);
                (local.y / b).atan2(local.x / a)
            }
            Self::Parabola { frame, focal_length } => frame.local(p).y / (2.0 * focal_length),
            Self::Hyperbola { frame, semi_axes: (_, b) } => (frame.local(p).y / b).asinh(),
            Self::Spline { starts, .. } => nearest(starts, |t| {
                let (q, d, dd) = self.jet(t);
                let off = q - p;
                (off.norm_squared(), off.dot(&d), d.norm_squared() + off.dot(&dd))
            }),
        }
    }

    /// The turn after which parameters come back; `None` where they never do.
    pub(super) fn period(&self) -> Option<f64> {
        match self {
            Self::Ellipse { .. } => Some(std::f64::consts::TAU),
            Self::Spline { curve, closed: true, .. } => {
                let (low, high) = curve.knots.range();
                Some(high - low)
            }
            _ => None,
        }
    }

    /// Parameters and points from the first to the last, both as given, so dense that chords are within `tolerance` of
    /// the curve and turn by no more than [`MOST_TURN`].
    pub(super) fn samples(&self, ends: [Point3; 2], along: Along) -> (Vec<f64>, Vec<Point3>) {
        let [a, b] = self.interval(ends, along);
        if matches!(self, Self::Line { .. }) {
            return (vec![a, b], ends.to_vec());
        }
        let mut at = vec![a];
        for pair in self.breaks(a, b).windows(2) {
            self.divide([pair[0], pair[1]], along.tolerance, 0, &mut at);
        }
        let mut points: Vec<Point3> = at.iter().map(|t| self.point(self.wrapped(*t))).collect();
        points[0] = ends[0];
        let last = points.len() - 1;
        points[last] = ends[1];
        (at, points)
    }

    /// A few points between and at both ends, enough to see the extent.
    pub(super) fn rough(&self, ends: [Point3; 2], along: Along) -> Vec<Point3> {
        const PIECES: usize = 16;
        let [a, b] = self.interval(ends, along);
        let at = (1..PIECES).map(|i| a + (b - a) * i as f64 / PIECES as f64);
        let mut points: Vec<Point3> = at.map(|t| self.point(self.wrapped(t))).collect();
        points.extend(ends);
        points
    }

    /// Parameters of both ends, unwrapped.
    fn interval(&self, [first, last]: [Point3; 2], Along { forward, is_loop, .. }: Along) -> [f64; 2] {
        let (mut a, mut b) = (self.parameter(&first), self.parameter(&last));
        let Some(period) = self.period() else { return [a, b] };
        if let Self::Spline { curve, .. } = self {
            // The seam of a closed spline is both its first and its last parameter.
            let (low, high) = curve.knots.range();
            let at_seam = |t: f64| (t - low).min(high - t) < SEAM * period;
            let (start, end) = if forward { (low, high) } else { (high, low) };
            a = if at_seam(a) { start } else { a };
            b = if at_seam(b) { end } else { b };
        }
        let sign = if forward { 1.0 } else { -1.0 };
        if is_loop {
            return [a, a + sign * period];
        }
        let turn = ((b - a) * sign).rem_euclid(period);
        // Two vertices in one place are joined by nothing, not by a whole turn.
        let (chord, length) = ((last - first).norm(), self.jet(a).1.norm() * turn);
        let turn = if period - turn < SEAM * period && chord < SEAM * length { turn - period } else { turn };
        b = a + sign * turn;
        [a, b]
    }

    /// The ends and the parameters between them where division begins.
    fn breaks(&self, a: f64, b: f64) -> Vec<f64> {
        let mut breaks = vec![a];
        if let Self::Spline { curve, closed, .. } = self {
            let inner = curve.knots.breaks();
            let period = if *closed { self.period() } else { None };
            let shifts = period.map_or(vec![0.0], |p| vec![-p, 0.0, p]);
            let all = shifts.iter().flat_map(|s| inner.iter().map(move |t| t + s));
            let mut within: Vec<f64> = all.filter(|t| a.min(b) < *t && *t < a.max(b)).collect();
            within.sort_by(f64::total_cmp);
            if b < a {
                within.reverse();
            }
            breaks.extend(within);
        } else {
            // Halves of a half turn are so short that bends between samples are seen.
            const PIECES: usize = 4;
            breaks.extend((1..PIECES).map(|i| a + (b - a) * i as f64 / PIECES as f64));
        }
        breaks.push(b);
        breaks
    }

    /// Adds the parameters of a piece, its first one left out, halving where the chord is too coarse.
    fn divide(&self, [a, b]: [f64; 2], tolerance: f64, depth: usize, at: &mut Vec<f64>) {
        /// Halvings of one piece.
        const DEEPEST: usize = 10;
        /// Points of one edge: a curve that needs more is none.
        const MOST: usize = 100_000;
        let middle = 0.5 * (a + b);
        if depth < DEEPEST && at.len() < MOST && !self.is_fine([a, b], tolerance) {
            self.divide([a, middle], tolerance, depth + 1, at);
            self.divide([middle, b], tolerance, depth + 1, at);
        } else {
            at.push(b);
        }
    }

    fn is_fine(&self, [a, b]: [f64; 2], tolerance: f64) -> bool {
        let wrap = |t: f64| self.wrapped(t);
        let ((p, d, _), (q, e, _)) = (self.jet(wrap(a)), self.jet(wrap(b)));
        let chord = q - p;
        let off = |share: f64| {
            let from = self.point(wrap(a + (b - a) * share)) - p;
            (from - chord * (from.dot(&chord) / chord.norm_squared().max(f64::MIN_POSITIVE))).norm()
        };
        crate::math::angle_between(&d, &e) <= MOST_TURN
            && [0.25, 0.5, 0.75].iter().all(|s| off(*s) <= tolerance)
    }

    /// The parameter brought into a closed spline's range.
    pub(super) fn wrapped(&self, t: f64) -> f64 {
        match self {
            Self::Spline { curve, closed: true, .. } => {
                let (low, high) = curve.knots.range();
                if (low..=high).contains(&t) { t } else { low + (t - low).rem_euclid(high - low) }
            }
            _ => t,
        }
    }
}

/// How an edge runs along its curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Along {
    /// Towards growing parameters.
    pub(super) forward: bool,
    /// Whether both ends are one vertex.
    pub(super) is_loop: bool,
    /// Largest distance of a chord from the curve.
    pub(super) tolerance: f64,
}

/// Largest angle between neighbouring chords, radians: six degrees, a thousandth of a radius.
pub(super) const MOST_TURN: f64 = std::f64::consts::PI / 30.0;
/// Share of a curve's size within which its ends are one point; systems write seven digits and more.
pub(super) const CLOSED: f64 = 1e-6;
/// Share of a period within which a parameter is at the seam.
const SEAM: f64 = 1e-7;

/// Parameter of a spline where `distance` (its value, half its slope and half its bend) is least.
pub(super) fn nearest(starts: &[(f64, Point3)], distance: impl Fn(f64) -> (f64, f64, f64)) -> f64 {
    /// Starts that are followed.
    const FOLLOWED: usize = 3;
    let mut near: Vec<(f64, usize)> =
        starts.iter().enumerate().map(|(i, (t, _))| (distance(*t).0, i)).collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let ends = near.iter().take(FOLLOWED).map(|(_, i)| {
        let before = starts[i.saturating_sub(1)].0;
        let after = starts[(i + 1).min(starts.len() - 1)].0;
        descend(starts[*i].0, (before, after), &distance)
    });
    ends.min_by(|a, b| distance(*a).0.total_cmp(&distance(*b).0)).unwrap_or(0.0)
}

/// The minimum of `distance` within `bounds` by Newton's method, by golden section where that leaves them.
fn descend(start: f64, (low, high): (f64, f64), distance: &impl Fn(f64) -> (f64, f64, f64)) -> f64 {
    const STEPS: usize = 40;
    let (mut low, mut high, mut t) = (low, high, start);
    for _ in 0..STEPS {
        let (_, slope, bend) = distance(t);
        if slope == 0.0 {
            break;
        }
        // The sign of the slope says on which side the minimum is.
        if slope > 0.0 {
            high = t;
        } else {
            low = t;
        }
        let newton = t - slope / bend;
        let next = if bend > 0.0 && low < newton && newton < high { newton } else { 0.5 * (low + high) };
        if (next - t).abs() <= f64::EPSILON * (low.abs() + high.abs()) {
            break;
        }
        t = next;
    }
    t
}
