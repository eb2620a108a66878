//! Axes that are arranged: evenly around a circle, evenly along a row, at the corners of a rectangle.
//!
//! Lines of one direction that carry equal bores, or equal bosses, are points in a plane across it. An arrangement has fewer
//! parameters than they have coordinates; it holds when the points lie no farther from it than their uncertainty explains, by
//! chi squared, and would rarely do so by accident. They are then moved to the arrangement that fits best, and its covariance
//! becomes theirs. Circles are tried about every other axis first, which then is their middle, then without one.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, Matrix2, Matrix3x2, Rotation2, Vector2};

use super::directions::Direction;
use super::lines::{Line, PlacedLine};
use super::relation::{Manufacture, RelationKind};
use super::{MAX_ACCIDENT, MAX_SIGMAS, PINNED, max_chi_squared};
use crate::recognize::Primitive;
use crate::surface::Surface;

/// Fewer lines make no arrangement: two are a row and a circle always.
const MIN_LINES: usize = 3;
/// Lines of one size and direction that are looked at: bounds the cost, quadratic in their number.
const MAX_LINES: usize = 200;
/// Standard deviations up to which sizes and distances make a candidate; whether it holds is tested for all of it together.
const CANDIDATE: f64 = 2.0 * MAX_SIGMAS;
/// Steps of Gauss and Newton of the one arrangement that is not linear.
const STEPS: usize = 8;

/// Lines that are arranged.
#[derive(Debug, Clone)]
pub(super) struct Pattern {
    pub kind: RelationKind,
    /// Indices of lines in their order around the circle or along the row, then that in the middle, if there is one.
    pub lines: Vec<usize>,
    /// Largest deviation of a line from its place, in standard uncertainties with what manufacture may deviate by and
    /// without, and as a length.
    pub z: f64,
    pub z_statistical: f64,
    pub shift: f64,
}

/// A line as a point across its direction.
#[derive(Debug, Clone, Copy)]
struct Spot {
    line: usize,
    at: Vector2<f64>,
    covariance: Matrix2<f64>,
}

/// The arrangements among `lines`, which are moved to them. `placed`: one per line, with the directions as they are now.
/// `asked`: the sets of primitives that are to be arranged and how; found by evidence when `None`.
pub(super) fn arranged(
    lines: &[Line],
    directions: &[Direction],
    placed: &mut [PlacedLine],
    primitives: &[Primitive],
    manufacture: &Manufacture,
    asked: Option<&[(RelationKind, Vec<usize>)]>,
) -> Vec<Pattern> {
    let form = Matrix2::identity() * manufacture.length.powi(2);
    let mut patterns = Vec::new();
    for (cluster, direction) in directions.iter().enumerate() {
        let tangents = direction.tangents();
        let mut spots = spots(lines, cluster, &tangents, direction, placed);
        for spot in &mut spots {
            spot.covariance += form;
        }
        if spots.len() < MIN_LINES {
            continue;
        }
        let found = match asked {
            None => found(&spots, lines, primitives),
            Some(asked) => forced(asked, &mut spots, lines),
        };
        for (arrangement, fitted) in found {
            let kind = arrangement.kind();
            let mut pattern = Pattern { kind, lines: Vec::new(), z: 0.0, z_statistical: 0.0, shift: 0.0 };
            for (spot, (to, covariance)) in arrangement.spots().zip(&fitted.places) {
                let moved = to - spot.at;
                pattern.lines.push(spot.line);
                pattern.shift = pattern.shift.max(moved.norm());
                pattern.z = pattern.z.max(deviation(&moved, &spot.covariance));
                let statistical = deviation(&moved, &(spot.covariance - form));
                pattern.z_statistical = pattern.z_statistical.max(statistical);
                let line = &mut placed[spot.line];
                line.through += tangents * moved;
                line.covariance = tangents * covariance * tangents.transpose();
            }
            patterns.push(pattern);
        }
    }
    patterns
}

/// The lines of a cluster as points. What the direction may still turn by moves those at other heights differently.
fn spots(
    lines: &[Line],
    cluster: usize,
    tangents: &Matrix3x2<f64>,
    direction: &Direction,
    placed: &[PlacedLine],
) -> Vec<Spot> {
    let own: Vec<usize> =
        (0..lines.len()).filter(|&k| lines[k].cluster() == cluster).take(MAX_LINES).collect();
    let lever = |k: usize| tangents.transpose() * placed[k].by_direction * tangents;
    let mean = own.iter().map(|&k| lever(k)).sum::<Matrix2<f64>>() / own.len().max(1) as f64;
    let turn = direction.in_tangents(tangents);
    own.into_iter()
        .map(|k| {
            let lever = lever(k) - mean;
            let covariance = tangents.transpose() * placed[k].covariance * tangents;
            let at = tangents.transpose() * placed[k].through.coords;
            Spot { line: k, at, covariance: covariance + lever * turn * lever.transpose() }
        })
        .collect()
}

/// Points in the order of their arrangement.
#[derive(Debug, Clone)]
enum Arrangement {
    /// Evenly around a circle, whose middle may be a line too.
    Circle { spots: Vec<Spot>, middle: Option<Spot> },
    /// Evenly along a line.
    Row(Vec<Spot>),
    /// The corners of a rectangle, in order.
    Rectangle(Vec<Spot>),
}

/// An arrangement fitted to its points.
struct Fitted {
    /// Where each point comes to lie, and the covariance of that.
    places: Vec<(Vector2<f64>, Matrix2<f64>)>,
    chi_squared: f64,
    degrees_of_freedom: usize,
}

impl Arrangement {
    fn kind(&self) -> RelationKind {
        match self {
            Self::Circle { .. } => RelationKind::CircularPattern,
            Self::Row(_) => RelationKind::EqualSpacing,
            Self::Rectangle(_) => RelationKind::RectangularPattern,
        }
    }

    /// All points without that in the middle.
    fn rim(&self) -> impl Iterator<Item = &Spot> {
        match self {
            Self::Circle { spots, .. } | Self::Row(spots) | Self::Rectangle(spots) => spots.iter(),
        }
    }

    fn spots(&self) -> impl Iterator<Item = &Spot> {
        let middle = if let Self::Circle { middle, .. } = self { middle.as_ref() } else { None };
        self.rim().chain(middle)
    }

    /// Points around their centroid or `middle` in order of angle, starting anywhere.
    fn circle(spots: &[Spot], middle: Option<Spot>) -> Self {
        let center = middle.map_or_else(|| mean(spots), |spot| spot.at);
        Self::Circle { spots: around(spots, &center), middle }
    }

    /// Points in order along the line through the two that are farthest apart.
    fn row(spots: &[Spot]) -> Self {
        let pairs = spots.iter().flat_map(|a| spots.iter().map(move |b| b.at - a.at));
        let along = pairs
            .fold(Vector2::zeros(), |best: Vector2<f64>, d| if d.norm() > best.norm() { d } else { best });
        let mut spots = spots.to_vec();
        spots.sort_by(|a, b| along.dot(&a.at).total_cmp(&along.dot(&b.at)));
        Self::Row(spots)
    }

    fn rectangle(spots: &[Spot]) -> Self {
        Self::Rectangle(around(spots, &mean(spots)))
    }

    /// That of a kind; the last of a circle is its middle when it is nearer to that than to the rim, as in the list of what
    /// was found.
    fn of_kind(kind: RelationKind, spots: &[Spot]) -> Option<Self> {
        let (last, others) = spots.split_last().filter(|_| spots.len() >= MIN_LINES)?;
        match kind {
            RelationKind::CircularPattern => {
                let center = mean(others);
                let radius =
                    others.iter().map(|spot| (spot.at - center).norm()).sum::<f64>() / others.len() as f64;
                let is_middle = others.len() >= MIN_LINES && (last.at - center).norm() < 0.5 * radius;
                Some(if is_middle { Self::circle(others, Some(*last)) } else { Self::circle(spots, None) })
            }
            RelationKind::EqualSpacing => Some(Self::row(spots)),
            RelationKind::RectangularPattern if spots.len() == 4 => Some(Self::rectangle(spots)),
            _ => None,
        }
    }

    /// Parameters to start from: for all but rectangles any will do.
    fn start(&self) -> DVector<f64> {
        let Self::Rectangle(corners) = self else { return DVector::zeros(4) };
        let center = mean(corners);
        let half = |a: usize, b: usize| (corners[a].at + corners[b].at) * 0.5 - center;
        let (u, v) = (half(0, 1), half(1, 2));
        let across = Vector2::new(-u.y, u.x);
        DVector::from_vec(vec![center.x, center.y, u.x, u.y, across.dot(&v) / u.norm_squared()])
    }

    /// Places of the points under `parameters`, and their derivatives by these.
    fn places(&self, parameters: &DVector<f64>) -> Vec<(Vector2<f64>, DMatrix<f64>)> {
        let linear = |by_second: Matrix2<f64>| {
            let mut jacobian = DMatrix::zeros(2, 4);
            jacobian.view_mut((0, 0), (2, 2)).fill_with_identity();
            jacobian.view_mut((0, 2), (2, 2)).copy_from(&by_second);
            let at = &jacobian * parameters;
            (Vector2::new(at[0], at[1]), jacobian)
        };
        match self {
            Self::Circle { spots, middle } => {
                let n = spots.len();
                let turn = |i: usize| Rotation2::new(TAU * i as f64 / n as f64).into_inner();
                let middle = middle.iter().map(|_| linear(Matrix2::zeros()));
                (0..n).map(|i| linear(turn(i))).chain(middle).collect()
            }
            Self::Row(spots) => (0..spots.len()).map(|i| linear(Matrix2::identity() * i as f64)).collect(),
            Self::Rectangle(_) => {
                let (center, u) = (parameters.fixed_rows::<2>(0), parameters.fixed_rows::<2>(2));
                let ratio = parameters[4];
                let across = Vector2::new(-u[1], u[0]);
                [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
                    .map(|(s, t): (f64, f64)| {
                        let by_u = Matrix2::new(s, -t * ratio, t * ratio, s);
                        let mut jacobian = DMatrix::zeros(2, 5);
                        jacobian.view_mut((0, 0), (2, 2)).fill_with_identity();
                        jacobian.view_mut((0, 2), (2, 2)).copy_from(&by_u);
                        jacobian.view_mut((0, 4), (2, 1)).copy_from(&(across * t));
                        (center + by_u * u, jacobian)
                    })
                    .to_vec()
            }
        }
    }

    /// The arrangement nearest to its points in their uncertainties; `None` where they do not determine it.
    fn fitted(&self) -> Option<Fitted> {
        let mut parameters = self.start();
        let n = parameters.len();
        let weights: Vec<Matrix2<f64>> =
            self.spots().map(|s| s.covariance.try_inverse()).collect::<Option<_>>()?;
        let mut covariance = DMatrix::zeros(n, n);
        for _ in 0..STEPS {
            let mut information = DMatrix::zeros(n, n);
            let mut gradient = DVector::zeros(n);
            for ((spot, weight), (at, jacobian)) in self.spots().zip(&weights).zip(self.places(&parameters)) {
                information += jacobian.transpose() * weight * &jacobian;
                gradient += jacobian.transpose() * (weight * (spot.at - at));
            }
            covariance = information.try_inverse()?;
            parameters += &covariance * gradient;
        }
        let mut chi_squared = 0.0;
        let mut places = Vec::new();
        for ((spot, weight), (at, jacobian)) in self.spots().zip(&weights).zip(self.places(&parameters)) {
            let off = spot.at - at;
            chi_squared += off.dot(&(weight * off));
            let own = &jacobian * &covariance * jacobian.transpose();
            places.push((at, own.fixed_view::<2, 2>(0, 0).into_owned()));
        }
        let degrees_of_freedom = 2 * places.len() - n;
        chi_squared.is_finite().then_some(Fitted { places, chi_squared, degrees_of_freedom })
    }

    /// The fit, when the points do not contradict it and would rarely meet it by accident among `n_tried`. `extent`: of what
    /// they are spread over.
    fn accepted(self, extent: f64, n_tried: usize) -> Option<(Self, Fitted)> {
        let fitted = self.fitted()?;
        let n = self.spots().count();
        let log_spread: f64 =
            self.spots().map(|spot| 0.25 * spot.covariance.determinant().max(0.0).ln()).sum();
        let share = 2.0 * MAX_SIGMAS * (log_spread / n as f64).exp() / extent;
        let accident = n_tried as f64 * share.powi(fitted.degrees_of_freedom as i32);
        let is_met = fitted.chi_squared < max_chi_squared(fitted.degrees_of_freedom);
        (is_met && accident < MAX_ACCIDENT).then_some((self, fitted))
    }
}

/// All that is arranged among the spots of one direction. None is in two arrangements, but one may be the middle of several.
fn found(spots: &[Spot], lines: &[Line], primitives: &[Primitive]) -> Vec<(Arrangement, Fitted)> {
    let center = mean(spots);
    let extent = 2.0 * spots.iter().map(|spot| (spot.at - center).norm()).fold(0.0, f64::max);
    let mut patterns = Vec::new();
    let mut middles = spots.to_vec();
    // Lines that have no place yet, and lines that have one on a rim.
    let (mut is_free, mut is_on_rim) = (vec![true; lines.len()], vec![false; lines.len()]);
    for alike in alike(spots, lines, primitives) {
        let mut left: Vec<Spot> = alike.into_iter().filter(|spot| is_free[spot.line]).collect();
        for middle in &mut middles {
            if is_on_rim[middle.line] {
                continue;
            }
            let others: Vec<Spot> = left.iter().copied().filter(|spot| spot.line != middle.line).collect();
            for ring in rings(&others, middle) {
                let circle = Arrangement::circle(&ring, Some(*middle));
                let Some((circle, fitted)) = circle.accepted(extent, spots.len()) else { continue };
                if let Some((at, covariance)) = fitted.places.last() {
                    *middle = Spot { at: *at, covariance: covariance * PINNED, ..*middle };
                }
                circle.spots().for_each(|spot| is_free[spot.line] = false);
                circle.rim().for_each(|spot| is_on_rim[spot.line] = true);
                patterns.push((circle, fitted));
            }
            left.retain(|spot| is_free[spot.line]);
        }
        if left.len() < MIN_LINES {
            continue;
        }
        let mut tries = vec![Arrangement::circle(&left, None), Arrangement::row(&left)];
        if left.len() == 4 {
            tries.push(Arrangement::rectangle(&left));
        }
        let n_tried = tries.len();
        if let Some(pattern) = tries.into_iter().find_map(|arrangement| arrangement.accepted(extent, n_tried))
        {
            for spot in pattern.0.rim() {
                is_free[spot.line] = false;
                is_on_rim[spot.line] = true;
            }
            patterns.push(pattern);
        }
    }
    patterns
}

/// The arrangements that a user asks for whose primitives are all on lines of this direction, one after the other: what one
/// has put in its place the next leaves there.
fn forced(
    asked: &[(RelationKind, Vec<usize>)],
    spots: &mut [Spot],
    lines: &[Line],
) -> Vec<(Arrangement, Fitted)> {
    let mut patterns = Vec::new();
    for (kind, of) in asked {
        let home = |k: &usize| spots.iter().find(|spot| lines[spot.line].members.contains(k)).copied();
        let own: Option<Vec<Spot>> = of.iter().map(home).collect();
        let arrangement = own.and_then(|own| Arrangement::of_kind(*kind, &own));
        let Some((arrangement, fitted)) = arrangement.and_then(|a| a.fitted().map(|fitted| (a, fitted)))
        else {
            continue;
        };
        for (placed, (at, covariance)) in arrangement.spots().zip(&fitted.places) {
            for spot in spots.iter_mut().filter(|spot| spot.line == placed.line) {
                *spot = Spot { at: *at, covariance: covariance * PINNED, ..*spot };
            }
        }
        patterns.push((arrangement, fitted));
    }
    patterns
}

/// Spots whose lines carry cylinders of one radius, all bores or all bosses: at least three each.
fn alike(spots: &[Spot], lines: &[Line], primitives: &[Primitive]) -> Vec<Vec<Spot>> {
    let mut groups: Vec<(Size, Vec<Spot>)> = Vec::new();
    for spot in spots {
        let Some(size) = Size::of(&lines[spot.line], primitives) else { continue };
        match groups.iter_mut().find(|(other, _)| other.is(&size)) {
            Some((_, group)) => group.push(*spot),
            None => groups.push((size, vec![*spot])),
        }
    }
    groups.into_iter().map(|(_, group)| group).filter(|group| group.len() >= MIN_LINES).collect()
}

/// The size of the smallest cylinder on a line, with its variance.
#[derive(Debug, Clone, Copy)]
struct Size {
    radius: f64,
    variance: f64,
    outward: bool,
}

impl Size {
    fn of(line: &Line, primitives: &[Primitive]) -> Option<Self> {
        let size = |&k: &usize| {
            let primitive = &primitives[k];
            let Some(Surface::Cylinder(cylinder)) = primitive.surface else { return None };
            let variance = primitive.covariance.last().and_then(|row| row.last()).copied()?;
            Some(Self { radius: cylinder.radius, variance, outward: primitive.outward })
        };
        line.members.iter().filter_map(size).min_by(|a, b| a.radius.total_cmp(&b.radius))
    }

    fn is(&self, other: &Self) -> bool {
        let apart = (self.radius - other.radius).abs();
        self.outward == other.outward && apart < CANDIDATE * (self.variance + other.variance).sqrt()
    }
}

/// Spots at one distance from `middle`, at least three each.
fn rings(spots: &[Spot], middle: &Spot) -> Vec<Vec<Spot>> {
    let distance = |spot: &Spot| {
        let apart = spot.at - middle.at;
        let size = apart.norm();
        let along = if size > 0.0 { apart / size } else { Vector2::x() };
        (size, along.dot(&((spot.covariance + middle.covariance) * along)))
    };
    let mut sorted: Vec<(f64, f64, Spot)> =
        spots.iter().map(|s| (distance(s).0, distance(s).1, *s)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.line.cmp(&b.2.line)));
    sorted
        .chunk_by(|a, b| b.0 - a.0 < CANDIDATE * (a.1 + b.1).sqrt())
        .filter(|ring| ring.len() >= MIN_LINES && ring[0].0 > MAX_SIGMAS * ring[0].1.sqrt())
        .map(|ring| ring.iter().map(|(_, _, spot)| *spot).collect())
        .collect()
}

fn mean(spots: &[Spot]) -> Vector2<f64> {
    spots.iter().map(|spot| spot.at).sum::<Vector2<f64>>() / spots.len().max(1) as f64
}

/// Spots in order of their angle about `center`.
fn around(spots: &[Spot], center: &Vector2<f64>) -> Vec<Spot> {
    let angle = |spot: &Spot| (spot.at.y - center.y).atan2(spot.at.x - center.x);
    let mut spots = spots.to_vec();
    spots.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    spots
}

/// A motion in its standard uncertainties.
fn deviation(moved: &Vector2<f64>, covariance: &Matrix2<f64>) -> f64 {
    let size = moved.norm();
    if size == 0.0 {
        return 0.0;
    }
    let along = moved / size;
    size / along.dot(&(covariance * along)).sqrt()
}
