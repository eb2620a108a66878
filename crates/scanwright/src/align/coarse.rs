//! Guesses from surfaces that correspond.
//!
//! Two or three surfaces of the source fix a motion once they are matched to surfaces of the target. Matches must agree
//! in type, side and size, and in how they lie to each other: the angle between their directions, and the distance
//! that a motion does not change (of parallel planes, axes, centres). For a few well-chosen bases of the source all
//! matches are enumerated; guesses are ranked by the area of the source's surfaces that they lay on surfaces of the
//! target. Interpretation trees: W. E. L. Grimson, T. Lozano-Pérez, "Localizing overlapping parts by searching the
//! interpretation tree", IEEE Transactions on Pattern Analysis and Machine Intelligence 9 (1987), 469-482.

use super::elements::{Element, Locus};
use super::{Part, Target};
use crate::math::{Frame, Mat3, Point3, Pose, UnitVec3, Vec3, angle_between, try_unit};
use crate::par;

/// How far matched surfaces may differ.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Angles, radians.
    angle: f64,
    /// Lengths.
    length: f64,
    /// Radii, as a share.
    size: f64,
}

impl Limits {
    /// Wide enough for what has changed on a part, and for fits to narrow faces.
    pub fn new(target: &Target, part: &Part) -> Self {
        /// Three degrees.
        const ANGLE: f64 = 0.052;
        /// Share of the diagonal, and spacings.
        const LENGTH: (f64, f64) = (0.01, 4.0);
        const SIZE: f64 = 0.1;
        let length = (LENGTH.0 * target.diagonal()).max(LENGTH.1 * part.tolerances.spacing());
        Self { angle: ANGLE, length, size: SIZE }
    }
}

/// Largest surfaces of the source that bases are made of.
const MOST_IN_BASES: usize = 16;
/// Bases tried: several, as a surface of one may not be on the target.
const MOST_BASES: usize = 10;
/// Matches of one base that are looked at.
const MOST_MATCHES: usize = 4_000;
/// Guesses returned: a part may have as many symmetries.
const MOST_GUESSES: usize = 60;
/// Turns about the only direction that a base has.
const FREE_TURNS: usize = 12;
/// Sine of the angle between directions from which they fix a turn: ten degrees.
const APART: f64 = 0.17;

/// Motions that lay surfaces of `source` on surfaces of `target`, both largest first; the best first.
pub fn guesses(source: &[Element], target: &[Element], limits: &Limits) -> Vec<Pose> {
    let bases = bases(source);
    let found = par::map(&bases, |base| of_base(base, source, target, limits));
    let mut scored: Vec<(f64, Pose)> = found.into_iter().flatten().collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let reach = source.iter().map(|e| e.reach).fold(limits.length, f64::max);
    let mut kept: Vec<Pose> = Vec::new();
    for (_, pose) in scored {
        let known = |other: &Pose| is_near(&pose, other, reach, limits);
        if kept.len() < MOST_GUESSES && !kept.iter().any(known) {
            kept.push(pose);
        }
    }
    kept
}

/// Whether fine alignment would make one of two guesses.
fn is_near(a: &Pose, b: &Pose, reach: f64, limits: &Limits) -> bool {
    let apart = a.after(&b.inverse());
    apart.angle() < 2.0 * limits.angle
        && apart.translation.norm() < 3.0 * limits.length + reach * apart.angle()
}

/// Sets of up to three elements, by what they fix and how large they are; none used over and over.
fn bases(source: &[Element]) -> Vec<Vec<usize>> {
    let n = source.len().min(MOST_IN_BASES);
    let mut sets: Vec<(usize, f64, Vec<usize>)> = Vec::new();
    for i in 0..n {
        for j in i + 1..n.max(i + 2) {
            for k in j + 1..n.max(j + 2) {
                let set: Vec<usize> = [i, j, k].into_iter().filter(|&e| e < n).collect();
                let members: Vec<&Element> = set.iter().map(|&e| &source[e]).collect();
                let area: f64 = members.iter().map(|e| e.area).product::<f64>().powf(1.0 / set.len() as f64);
                sets.push((fixed(&members), area, set));
            }
        }
    }
    let mut used = vec![0; n];
    let mut chosen = Vec::new();
    while chosen.len() < MOST_BASES {
        let weight = |(fixed, area, set): &(usize, f64, Vec<usize>)| {
            let repeats: i32 = set.iter().map(|&e| used[e]).sum();
            (*fixed, area * 0.5_f64.powi(repeats))
        };
        let best = (0..sets.len()).max_by(|&a, &b| {
            let (a, b) = (weight(&sets[a]), weight(&sets[b]));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        let Some(best) = best else { break };
        let (_, _, set) = sets.swap_remove(best);
        for &e in &set {
            used[e] += 1;
        }
        chosen.push(set);
    }
    chosen
}

/// How many of the six freedoms of a motion some elements fix.
fn fixed(elements: &[&Element]) -> usize {
    let posed: Vec<Posed> = elements.iter().map(|e| Posed::new(e, 1.0)).collect();
    let turns = match Basis::new(&posed) {
        Some(Basis { second: Some(_), .. }) => 3,
        Some(_) => 2,
        None => 0,
    };
    let rows = posed.iter().fold(Mat3::zeros(), |sum, p| sum + p.rows());
    let values = crate::math::symmetric_eigen(&rows);
    turns + values.iter().filter(|(value, _)| *value > APART * APART).count()
}

/// An element with one of its directions.
#[derive(Debug, Clone, Copy)]
struct Posed {
    locus: Locus,
    direction: Option<Vec3>,
    place: Point3,
    center: Point3,
}

impl Posed {
    fn new(element: &Element, sign: f64) -> Self {
        Self {
            locus: element.locus(),
            direction: element.direction().map(|d| d * sign),
            place: element.place(),
            center: element.center,
        }
    }

    /// Projector on the directions in which its place is fixed.
    fn rows(&self) -> Mat3 {
        match (self.locus, self.direction) {
            (Locus::Plane, Some(n)) => n * n.transpose(),
            (Locus::Line, Some(d)) => Mat3::identity() - d * d.transpose(),
            _ => Mat3::identity(),
        }
    }

    /// From its locus to that of `other`, across whichever direction it has; none when that is no direction of its own.
    fn way_to(&self, other: &Self) -> Option<Vec3> {
        let way = other.place - self.place;
        match (self.locus, other.locus) {
            (Locus::Plane, _) | (_, Locus::Plane) => None,
            (Locus::Point, Locus::Point) => Some(way),
            (Locus::Line, _) => self.direction.map(|d| way - d * d.dot(&way)),
            (Locus::Point, Locus::Line) => other.direction.map(|d| way - d * d.dot(&way)),
        }
    }
}

/// Angle of the directions of two elements, and the length between them that motions keep. `parallel`: whether to take
/// their directions for parallel.
fn relation(a: &Posed, b: &Posed, parallel: bool) -> (Option<f64>, Option<f64>) {
    let angle = a.direction.zip(b.direction).map(|(a, b)| angle_between(&a, &b));
    let way = b.place - a.place;
    let length = match (a.locus, b.locus) {
        (Locus::Plane, Locus::Plane) => a.direction.filter(|_| parallel).map(|n| n.dot(&way)),
        (Locus::Plane, Locus::Point) => a.direction.map(|n| n.dot(&way)),
        (Locus::Point, Locus::Plane) => b.direction.map(|n| -n.dot(&way)),
        // A line in a plane's direction has no height over it.
        (Locus::Plane, Locus::Line) => a.direction.filter(|_| !parallel).map(|n| n.dot(&way)),
        (Locus::Line, Locus::Plane) => b.direction.filter(|_| !parallel).map(|n| -n.dot(&way)),
        (Locus::Line, Locus::Line) if !parallel => a.direction.zip(b.direction).map(|(a, b)| {
            let across = a.cross(&b);
            (across.dot(&way) / across.norm()).abs()
        }),
        _ => a.way_to(b).map(|way| way.norm()),
    };
    (angle, length)
}

/// Whether two pairs lie to each other alike.
fn agree(source: [&Posed; 2], target: [&Posed; 2], limits: &Limits) -> bool {
    let angle = target[0].direction.zip(target[1].direction).map(|(a, b)| angle_between(&a, &b));
    let along = angle.map(|angle| angle.min(std::f64::consts::PI - angle));
    let parallel = along.is_none_or(|along| along < APART);
    // A line that stands neither in nor across a plane has no one height over it.
    let mixed = [source[0].locus, source[1].locus].iter().filter(|l| **l == Locus::Plane).count() == 1
        && along.is_some_and(|along| along < std::f64::consts::FRAC_PI_2 - limits.angle)
        && source.iter().any(|p| p.locus == Locus::Line);
    let (a, b) = (relation(source[0], source[1], parallel), relation(target[0], target[1], parallel));
    let close =
        |a: Option<f64>, b: Option<f64>, limit: f64| a.zip(b).is_none_or(|(a, b)| (a - b).abs() < limit);
    close(a.0, b.0, limits.angle) && (mixed || close(a.1, b.1, limits.length))
}

fn is_alike(a: &Element, b: &Element, limits: &Limits) -> bool {
    let mut sizes = a.sizes().into_iter().zip(b.sizes());
    a.surface.kind() == b.surface.kind()
        && (a.outward == b.outward || a.locus() == Locus::Plane)
        && sizes.all(|(a, b)| (a - b).abs() <= limits.length.min(limits.size * a.max(b)).max(0.02 * a.max(b)))
}

/// Guesses by one base with the area that each explains.
fn of_base(base: &[usize], source: &[Element], target: &[Element], limits: &Limits) -> Vec<(f64, Pose)> {
    let posed: Vec<Posed> = base.iter().map(|&e| Posed::new(&source[e], 1.0)).collect();
    let choices: Vec<Vec<Posed>> = base
        .iter()
        .map(|&e| {
            let alike = target.iter().filter(|t| is_alike(&source[e], t, limits));
            alike
                .flat_map(|t| {
                    let signs: &[f64] =
                        if t.oriented() || t.direction().is_none() { &[1.0] } else { &[1.0, -1.0] };
                    signs.iter().map(|sign| Posed::new(t, *sign)).collect::<Vec<_>>()
                })
                .collect()
        })
        .collect();
    let mut matches = Vec::new();
    extend(&posed, &choices, &mut Vec::new(), &mut matches, limits);
    let poses = matches.iter().flat_map(|matched| motions(&posed, matched));
    let scored = poses.map(|pose| (explained(&pose, source, target, limits), pose));
    scored.filter(|(area, _)| *area > 0.0).collect()
}

/// Completes a partial match in every way that agrees.
fn extend(
    posed: &[Posed],
    choices: &[Vec<Posed>],
    matched: &mut Vec<Posed>,
    found: &mut Vec<Vec<Posed>>,
    limits: &Limits,
) {
    let depth = matched.len();
    if depth == posed.len() {
        found.push(matched.clone());
        return;
    }
    for choice in &choices[depth] {
        if found.len() >= MOST_MATCHES {
            return;
        }
        let fits = (0..depth).all(|i| agree([&posed[i], &posed[depth]], [&matched[i], choice], limits));
        if fits {
            matched.push(*choice);
            extend(posed, choices, matched, found, limits);
            matched.pop();
        }
    }
}

/// The directions that some elements have, alone and together, in an order that depends on their types only.
struct Basis {
    first: Vec3,
    second: Option<Vec3>,
}

impl Basis {
    fn new(elements: &[Posed]) -> Option<Self> {
        let mut all: Vec<Vec3> = elements.iter().filter_map(|e| e.direction).collect();
        let pairs = (0..elements.len()).flat_map(|i| (i + 1..elements.len()).map(move |j| (i, j)));
        let size = elements.iter().map(|e| (e.place - elements[0].place).norm()).fold(0.0, f64::max);
        // A way much shorter than the base is wide says nothing about directions.
        let ways = pairs.filter_map(|(i, j)| elements[i].way_to(&elements[j]));
        all.extend(
            ways.filter(|way| way.norm() > APART * size).filter_map(try_unit).map(UnitVec3::into_inner),
        );
        let first = *all.first()?;
        let second = all.into_iter().find(|d| d.cross(&first).norm() > APART);
        Some(Self { first, second })
    }

    fn frame(&self) -> Frame {
        let z = UnitVec3::new_normalize(self.first);
        let across = self.second.and_then(|s| try_unit(s - self.first * s.dot(&self.first)));
        across.map_or_else(
            || Frame::from_z(Point3::origin(), z),
            |x| Frame { origin: Point3::origin(), x, y: UnitVec3::new_normalize(z.cross(&x)), z },
        )
    }
}

/// Motions that lay a base on its match: several when it leaves a turn free.
fn motions(source: &[Posed], target: &[Posed]) -> Vec<Pose> {
    let Some((from, to)) = Basis::new(source).zip(Basis::new(target)) else { return Vec::new() };
    let free = from.second.is_none() || to.second.is_none();
    let into = Pose::into_frame(&from.frame());
    let out = Pose::into_frame(&to.frame()).inverse();
    let n = if free { FREE_TURNS } else { 1 };
    (0..n)
        .map(|k| {
            let angle = std::f64::consts::TAU * k as f64 / n as f64;
            let turn = nalgebra::Rotation3::from_axis_angle(&Vec3::z_axis(), angle);
            let rotation = out.rotation * turn * into.rotation;
            Pose { rotation, translation: way(source, target, &rotation) }
        })
        .collect()
}

/// The way after a turn that brings places together; along what no element fixes, middles of data.
fn way(source: &[Posed], target: &[Posed], rotation: &nalgebra::Rotation3<f64>) -> Vec3 {
    /// Weight of middles, which a scan may show in part.
    const MIDDLES: f64 = 1e-4;
    let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
    for (a, b) in source.iter().zip(target) {
        let rows = b.rows();
        matrix += rows + Mat3::identity() * MIDDLES;
        right += rows * (b.place - rotation * a.place) + (b.center - rotation * a.center) * MIDDLES;
    }
    matrix.try_inverse().map_or_else(Vec3::zeros, |inverse| inverse * right)
}

/// Area of the source's elements that a motion lays on elements of the target.
fn explained(pose: &Pose, source: &[Element], target: &[Element], limits: &Limits) -> f64 {
    let lies_on = |a: &Element, b: &Element| {
        let turned = a.direction().zip(b.direction()).is_none_or(|(from, to)| {
            let cosine = (pose.rotation * from).dot(&to);
            (if b.oriented() { cosine } else { cosine.abs() }) > limits.angle.cos()
        });
        let off = Posed::new(b, 1.0).rows() * (pose.point(&a.place()) - b.place());
        let apart = (pose.point(&a.center) - b.center).norm();
        turned
            && off.norm() < limits.length
            && apart < a.reach + b.reach + limits.length
            && is_alike(a, b, limits)
    };
    source.iter().filter(|a| target.iter().any(|b| lies_on(a, b))).map(|a| a.area).sum()
}
