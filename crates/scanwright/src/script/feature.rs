//! Features: profiles that are swept, added to a body or cut from it, as something that can be asked about points.

use super::arrangement::is_inside;
use super::curve::Curve;
use super::sweep::{Motion, Point2, Sweep};
use crate::math::Point3;

/// What a feature does to what is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Sign {
    Add,
    Cut,
}

/// A piece of an outline.
#[derive(Debug, Clone)]
pub(super) struct Segment {
    pub(super) curve: Curve,
    /// Faces that lie on what it sweeps, ascending.
    pub(super) faces: Vec<usize>,
    pub(super) from: Point2,
    pub(super) to: Point2,
    /// A point between the ends.
    pub(super) middle: Point2,
    /// Whether it runs along the curve: a circle's angle grows.
    pub(super) forward: bool,
    /// Share of what it sweeps that is a face.
    pub(super) backed: f64,
}

/// A closed run of segments: counter-clockwise, or clockwise round a hole. A whole circle is one segment whose ends meet.
#[derive(Debug, Clone)]
pub(super) struct Ring {
    pub(super) segments: Vec<Segment>,
    /// Arcs as chords of a few degrees.
    pub(super) polygon: Vec<Point2>,
}

impl Ring {
    pub(super) fn new(segments: Vec<Segment>) -> Self {
        let polygon = segments.iter().flat_map(Segment::walk).collect();
        Self { segments, polygon }
    }

    /// Centre and radius, if it is one circle.
    pub(super) fn circle(&self) -> Option<(Point2, f64)> {
        match (self.segments.as_slice(), self.segments[0].curve) {
            ([_], Curve::Circle { center, radius }) => Some((center, radius)),
            _ => None,
        }
    }
}

impl Segment {
    /// Its points from the start to before the end; arcs as chords.
    fn walk(&self) -> Vec<Point2> {
        /// Radians of a chord.
        const CHORD: f64 = std::f64::consts::PI / 60.0;
        let Curve::Circle { center, radius } = self.curve else { return vec![self.from] };
        let sweep = self.sweep();
        let n = (sweep.abs() / CHORD).ceil().max(2.0) as usize;
        let start = (self.from - center).y.atan2((self.from - center).x);
        let arc = (1..n).map(|i| {
            let angle = start + sweep * i as f64 / n as f64;
            center + Point2::new(angle.cos(), angle.sin()) * radius
        });
        std::iter::once(self.from).chain(arc).collect()
    }

    /// Radians it turns about its centre, negative clockwise; zero of a line.
    pub(super) fn sweep(&self) -> f64 {
        let Curve::Circle { .. } = self.curve else { return 0.0 };
        let tau = std::f64::consts::TAU;
        let turn = self.curve.parameter(&self.to) - self.curve.parameter(&self.from);
        let turn = if self.forward { turn.rem_euclid(tau) } else { -(-turn).rem_euclid(tau) };
        if turn == 0.0 || self.from == self.to { if self.forward { tau } else { -tau } } else { turn }
    }

    /// Direction in which it leaves its start.
    pub(super) fn leaves(&self) -> Point2 {
        self.tangent(&self.from)
    }

    /// Direction in which it reaches its end.
    pub(super) fn arrives(&self) -> Point2 {
        self.tangent(&self.to)
    }

    fn tangent(&self, at: &Point2) -> Point2 {
        match self.curve {
            Curve::Line { .. } => (self.to - self.from).normalize(),
            Curve::Circle { center, .. } => {
                let out = (at - center).normalize();
                let turned = Point2::new(-out.y, out.x);
                if self.forward { turned } else { -turned }
            }
        }
    }
}

/// A swept profile.
#[derive(Debug, Clone)]
pub(super) struct Feature {
    pub(super) sign: Sign,
    pub(super) sweep: Sweep,
    /// The outer ring first.
    pub(super) rings: Vec<Ring>,
    /// Range of the motion.
    pub(super) range: (f64, f64),
    /// Whether it turns all the way round.
    pub(super) is_whole: bool,
    /// Faces that lie at its beginning and at its end, ascending.
    pub(super) caps: [Vec<usize>; 2],
    /// Share of its beginning and its end that is a face.
    pub(super) capped: [f64; 2],
    bounds: (Point2, Point2),
}

impl Feature {
    pub(super) fn new(sign: Sign, sweep: Sweep, rings: Vec<Ring>, range: (f64, f64), is_whole: bool) -> Self {
        let mut feature = Self {
            sign,
            sweep,
            rings,
            range,
            is_whole,
            caps: [Vec::new(), Vec::new()],
            capped: [0.0; 2],
            bounds: (Point2::zeros(), Point2::zeros()),
        };
        feature.refresh();
        feature
    }

    /// To be called when a ring has changed.
    pub(super) fn refresh(&mut self) {
        let first = self.rings[0].polygon[0];
        let points = self.rings[0].polygon.iter();
        self.bounds = points.fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
    }

    /// Lowest and highest corner of the profile.
    pub(super) fn bounds(&self) -> (Point2, Point2) {
        self.bounds
    }

    /// The feature over the range of both, if both sweep one profile along one direction.
    pub(super) fn joined(&self, other: &Self) -> Option<Self> {
        let is_one = self.sweep == other.sweep
            && self.sign == other.sign
            && self.sweep.motion == Motion::Along
            && self.rings.len() == other.rings.len()
            && self.rings.iter().zip(&other.rings).all(|(a, b)| a.polygon == b.polygon);
        if !is_one {
            return None;
        }
        let mut joined = self.clone();
        for (end, is_farther) in
            [other.range.0 < self.range.0, other.range.1 > self.range.1].into_iter().enumerate()
        {
            if is_farther {
                *[&mut joined.range.0, &mut joined.range.1][end] = [other.range.0, other.range.1][end];
                joined.caps[end].clone_from(&other.caps[end]);
                joined.capped[end] = other.capped[end];
            }
        }
        for (ring, more) in joined.rings.iter_mut().zip(&other.rings) {
            for (segment, more) in ring.segments.iter_mut().zip(&more.segments) {
                segment.backed = segment.backed.max(more.backed);
            }
        }
        Some(joined)
    }

    /// Points all over it.
    pub(super) fn samples(&self) -> Vec<Point3> {
        const ACROSS: usize = 12;
        let (low, high) = self.bounds;
        let step = 1.0 / ACROSS as f64;
        let at = |i: usize| (i as f64 + 0.5) * step;
        let mut points = Vec::new();
        for i in 0..ACROSS {
            for j in 0..ACROSS {
                let p = Point2::new(low.x + (high.x - low.x) * at(i), low.y + (high.y - low.y) * at(j));
                if is_inside(self.rings.iter().map(|r| r.polygon.as_slice()), &p) {
                    let moved = (0..4 * ACROSS).map(|k| (k as f64 + 0.5) / (4 * ACROSS) as f64);
                    points.extend(moved.map(|t| {
                        let (from, to) =
                            if self.is_whole { (0.0, std::f64::consts::TAU) } else { self.range };
                        self.sweep.point(&p, from + (to - from) * t)
                    }));
                }
            }
        }
        points
    }

    pub(super) fn contains(&self, point: &Point3) -> bool {
        let (profile, moved) = self.sweep.coordinates(point);
        let in_range = match self.sweep.motion {
            Motion::Along => moved >= self.range.0 && moved <= self.range.1,
            Motion::Around => {
                let tau = std::f64::consts::TAU;
                self.is_whole || (moved - self.range.0).rem_euclid(tau) <= self.range.1 - self.range.0
            }
        };
        let (low, high) = self.bounds;
        in_range
            && profile.x >= low.x
            && profile.x <= high.x
            && profile.y >= low.y
            && profile.y <= high.y
            && is_inside(self.rings.iter().map(|r| r.polygon.as_slice()), &profile)
    }

    /// Faces of the solid that it has walls or caps on, ascending.
    pub(super) fn faces(&self) -> Vec<usize> {
        let walls = self.rings.iter().flat_map(|r| &r.segments).flat_map(|s| s.faces.iter().copied());
        let mut faces: Vec<usize> = walls.chain(self.caps.iter().flatten().copied()).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }
}

/// Features in order; holes are drilled last.
#[derive(Debug, Clone, Default)]
pub(super) struct Model {
    pub(super) body: Vec<Feature>,
    pub(super) holes: Vec<Feature>,
}

impl Model {
    /// Whether a point is in the body before holes are drilled.
    pub(super) fn is_body(&self, point: &Point3) -> bool {
        // The last feature that holds a point says what is there.
        let last = self.body.iter().rev().find(|f| f.contains(point));
        last.is_some_and(|f| f.sign == Sign::Add)
    }

    pub(super) fn is_hole(&self, point: &Point3) -> bool {
        self.holes.iter().any(|h| h.contains(point))
    }

    pub(super) fn contains(&self, point: &Point3) -> bool {
        self.is_body(point) && !self.is_hole(point)
    }

    pub(super) fn features(&self) -> impl Iterator<Item = &Feature> {
        self.body.iter().chain(&self.holes)
    }
}
