//! Features that end where nothing is are made a little longer there: a hole beyond the mouth it opens in, a boss into
//! the body it stands on. Faces that only touch leave films and gaps in a kernel's hands.

use super::curve::{Curve, cross};
use super::feature::{Feature, Ring, Segment};
use super::sweep::{Motion, Point2};
use crate::math::Point3;

/// Share of an end that is a face, below which the end is open.
const OPEN: f64 = 0.2;
/// Component of a direction below which it is another axis's.
const STRAIGHT: f64 = 0.01;
/// Tolerances by which an open end is moved.
const MOVES: f64 = 4.0;

/// `feature` with its open ends moved outward where `may_hold` holds for all that it gains.
pub(super) fn overlapped(
    mut feature: Feature,
    tolerance: f64,
    may_hold: impl Fn(&Point3) -> bool,
) -> Feature {
    let by = MOVES * tolerance;
    if feature.sweep.motion == Motion::Along {
        for end in 0..2 {
            if feature.capped[end] > OPEN {
                continue;
            }
            let sign = [-1.0, 1.0][end];
            let at = [feature.range.0, feature.range.1][end];
            let gained = inner_points(&feature.rings, by).into_iter();
            let is_free = gained
                .flat_map(|p| [0.25, 0.75, 1.0].map(|t| (p, at + sign * by * t)))
                .all(|(p, moved)| may_hold(&feature.sweep.point(&p, moved)));
            if is_free {
                *[&mut feature.range.0, &mut feature.range.1][end] += sign * by;
                feature.caps[end].clear();
                feature.capped[end] = 0.0;
            }
        }
    }
    for r in 0..feature.rings.len() {
        // From the last: steps that are put in do not move those before.
        for s in (0..feature.rings[r].segments.len()).rev() {
            let Some(ring) = moved_out(&feature.rings[r], s, by) else { continue };
            let is_free =
                gained(&feature, &feature.rings[r].segments[s], by).into_iter().all(|p| may_hold(&p));
            if is_free {
                feature.rings[r] = ring;
            }
        }
    }
    feature.refresh();
    feature
}

/// A ring with one open straight segment moved to its right; `None` when it is a face. Straight neighbours are made
/// longer or shorter, others are left as they are and joined by a step.
fn moved_out(ring: &Ring, s: usize, by: f64) -> Option<Ring> {
    let n = ring.segments.len();
    let segment = &ring.segments[s];
    let Curve::Line { .. } = segment.curve else { return None };
    if segment.backed > OPEN || n < 3 || is_on_axis(segment.from, segment.to) {
        return None;
    }
    let along = (segment.to - segment.from).normalize();
    let shift = Point2::new(along.y, -along.x) * by;
    let (before, after) = ((s + n - 1) % n, (s + 1) % n);
    let from = crossing(&ring.segments[before], along, shift, segment.from);
    let to = crossing(&ring.segments[after], along, shift, segment.to);
    let mut segments = ring.segments.clone();
    let (mut start, mut end) = (from.unwrap_or(segment.from + shift), to.unwrap_or(segment.to + shift));
    // What is no face may as well be straight.
    for axis in 0..2 {
        if along[axis].abs() < STRAIGHT {
            let middle = 0.5 * (start[axis] + end[axis]);
            (start[axis], end[axis]) = (middle, middle);
        }
    }
    if from.is_some() {
        segments[before].to = start;
    }
    if to.is_some() {
        segments[after].from = end;
    }
    segments[s] = straight(start, end);
    if to.is_none() {
        segments.insert(s + 1, straight(end, segment.to));
    }
    if from.is_none() {
        segments.insert(s, straight(segment.from, start));
    }
    let moved = Ring::new(segments);
    (!crosses_itself(&moved.polygon)).then_some(moved)
}

/// Whether two sides of a polygon that are no neighbours cross.
fn crosses_itself(polygon: &[Point2]) -> bool {
    let n = polygon.len();
    let side = |i: usize| (polygon[i], polygon[(i + 1) % n]);
    let turn = |a: Point2, b: Point2, c: Point2| cross(&(b - a), &(c - a));
    (0..n).any(|i| {
        let (a, b) = side(i);
        (i + 2..n).filter(|j| (j + 1) % n != i).any(|j| {
            let (c, d) = side(j);
            turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0
        })
    })
}

/// Where a straight neighbour that ends at `end` meets the moved line; `None` when it does not, or would far away.
fn crossing(neighbour: &Segment, along: Point2, shift: Point2, end: Point2) -> Option<Point2> {
    /// Sine of the angle between them.
    const STEEP: f64 = 0.3;
    let Curve::Line { .. } = neighbour.curve else { return None };
    let direction = (neighbour.to - neighbour.from).normalize();
    let sine = cross(&along, &direction);
    let at = end + direction * (cross(&along, &shift) / sine);
    (sine.abs() > STEEP && at.x >= 0.0_f64.min(end.x)).then_some(at)
}

/// A side that is no face.
fn straight(from: Point2, to: Point2) -> Segment {
    let direction = (to - from).normalize();
    Segment {
        curve: Curve::Line { point: from, direction },
        faces: Vec::new(),
        from,
        to,
        middle: (from + to) * 0.5,
        forward: true,
        backed: 0.0,
    }
}

fn is_on_axis(a: Point2, b: Point2) -> bool {
    a.x == 0.0 && b.x == 0.0
}

/// Points of what a feature gains when a segment is moved out.
fn gained(feature: &Feature, segment: &Segment, by: f64) -> Vec<Point3> {
    const ALONG: usize = 8;
    const MOVED: usize = 16;
    let along = (segment.to - segment.from).normalize();
    let out = Point2::new(along.y, -along.x);
    let (from, to) = if feature.is_whole { (0.0, std::f64::consts::TAU) } else { feature.range };
    let mut points = Vec::new();
    for i in 0..ALONG {
        let at = segment.from + (segment.to - segment.from) * ((i as f64 + 0.5) / ALONG as f64);
        for k in 0..MOVED {
            let moved = from + (to - from) * (k as f64 + 0.5) / MOVED as f64;
            for t in [0.25, 0.75, 1.0] {
                points.push(feature.sweep.point(&(at + out * (by * t)), moved));
            }
        }
    }
    points
}

/// Points of a profile, away from its border by a little.
fn inner_points(rings: &[Ring], by: f64) -> Vec<Point2> {
    const ACROSS: usize = 16;
    let polygons: Vec<&[Point2]> = rings.iter().map(|r| r.polygon.as_slice()).collect();
    let first = polygons[0][0];
    let (low, high) = polygons[0].iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
    let step = (high - low) / ACROSS as f64;
    let mut points = Vec::new();
    for i in 0..ACROSS {
        for j in 0..ACROSS {
            let p = low + Point2::new(step.x * (i as f64 + 0.5), step.y * (j as f64 + 0.5));
            if super::arrangement::is_inside(polygons.iter().copied(), &p) {
                points.push(p);
            }
        }
    }
    // Corners count most: pulled inward by a little.
    for polygon in polygons {
        for p in polygon {
            for d in
                [Point2::new(by, 0.0), Point2::new(-by, 0.0), Point2::new(0.0, by), Point2::new(0.0, -by)]
            {
                let near = p + d * 0.25;
                if super::arrangement::is_inside(rings.iter().map(|r| r.polygon.as_slice()), &near) {
                    points.push(near);
                }
            }
        }
    }
    points
}
