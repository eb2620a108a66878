//! A primitive drawn by itself: its surface over the range where a region saw it, as an open shell.
//!
//! The thesis's Part-to-CAD draws every recognised primitive so, complete or partial, beside the others and joined to
//! none; the product's solids are made by `build`. A plane is the smallest rectangle around its points; cylinder, cone
//! and torus are a rectangle of their own two parameters; a sphere is a zone about the axis that needs least of it.
//! Faces are cut as everywhere here: none goes round a seam or over a pole.

use std::f64::consts::{PI, TAU};

use super::curve::Curve;
use super::solid::{
    Edge, EdgeId, EdgeUse, Face, FaceId, Geometry, Loop, Shell, Solid, SurfaceId, Vertex, VertexId,
};
use crate::fit::Fit;
use crate::math::{
    Axis, Frame, Point3, UnitVec3, Vec3, any_perpendicular, centroid, principal_axes, smallest_rectangle,
    stats, try_unit,
};
use crate::segment::RegionId;
use crate::surface::{Cone, Sphere, Surface, Torus};
use crate::tolerance::Tolerances;

/// Widest gap between the angles of a whole turn, radians: the sectors of a coarse scan.
const FULL_TURN_GAP: f64 = 0.35;
/// Share of the points at either end of a range that may be strays.
const STRAYS: f64 = 0.005;
/// Largest turn of one face, radians.
const MOST_TURN: f64 = PI;

/// The surface of `fit` over the range of `points`; `None` when they span none.
pub fn draw(fit: &Fit, points: &[Point3], region: RegionId) -> Option<Solid> {
    if points.len() < 3 {
        return None;
    }
    let mut drawing = Drawing::new(fit, region);
    match &fit.surface {
        Surface::Plane(_) => drawing.rectangle(points)?,
        Surface::Cylinder(s) => {
            let frame = frame_of(&s.axis);
            let span = Span::of_angles(&frame, points);
            let heights = range(points.iter().map(|p| s.axis.height(p)))?;
            let profile = Profile::Straight([s.radius, s.radius], heights);
            drawing.grid(&Turned { frame, profile }, &span)?;
        }
        Surface::Cone(s) => {
            let frame = frame_of(&s.axis);
            let span = Span::of_angles(&frame, points);
            let heights = range(points.iter().map(|p| s.axis.height(p)))?;
            drawing.grid(&Turned { frame, profile: cone_profile(s, heights)? }, &span)?;
        }
        Surface::Sphere(s) => drawing.zone(s, points)?,
        Surface::Torus(s) => drawing.tube(s, points)?,
    }
    Some(drawing.solid)
}

/// A range of angles, counted in one piece; whole turns begin anywhere.
#[derive(Debug, Clone, Copy)]
struct Span {
    from: f64,
    to: f64,
    whole: bool,
}

impl Span {
    /// All of `angles` but their widest gap.
    fn of(mut angles: Vec<f64>) -> Self {
        angles.sort_by(f64::total_cmp);
        let next = angles[1..].iter().copied().chain([angles[0] + TAU]);
        let gaps = angles.iter().zip(next).map(|(a, b)| (b - a, *a, b));
        let widest = gaps.max_by(|x, y| x.0.total_cmp(&y.0));
        match widest {
            Some((gap, before, after)) if gap > FULL_TURN_GAP => {
                Self { from: after, to: before + TAU, whole: false }
            }
            _ => Self { from: 0.0, to: TAU, whole: true },
        }
    }

    fn of_angles(frame: &Frame, points: &[Point3]) -> Self {
        Self::of(points.iter().map(|p| frame.local(p)).map(|l| l.y.atan2(l.x)).collect())
    }

    /// Angles of the cuts: the first and the last are one place on a whole turn.
    fn cuts(&self) -> Vec<f64> {
        let n = ((self.to - self.from) / MOST_TURN).ceil().max(if self.whole { 2.0 } else { 1.0 });
        (0..=n as usize).map(|i| self.from + (self.to - self.from) * i as f64 / n).collect()
    }
}

/// Range of numbers but for strays; `None` when it is empty.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let mut values: Vec<f64> = values.collect();
    let low = stats::quantile(&mut values, STRAYS)?;
    let high = stats::quantile(&mut values, 1.0 - STRAYS)?;
    (low < high).then_some([low, high])
}

/// The rows of a cone: cut off at its apex.
fn cone_profile(cone: &Cone, [low, high]: [f64; 2]) -> Option<Profile> {
    let tan = cone.half_angle.tan();
    let radius = |height: f64| cone.radius + height * tan;
    let low = low.max(-cone.radius / tan);
    (low < high).then(|| Profile::Straight([radius(low).max(0.0), radius(high)], [low, high]))
}

/// A curve in the half-plane beside an axis, which turns about it.
#[derive(Debug, Clone)]
enum Profile {
    /// Radii and heights of the two ends of a straight line.
    Straight([f64; 2], [f64; 2]),
    /// Radius of the centre, radius, and angles of the cuts of an arc.
    Arc(f64, f64, Vec<f64>),
}

/// A surface of revolution by its two parameters.
#[derive(Debug, Clone)]
struct Turned {
    frame: Frame,
    profile: Profile,
}

impl Turned {
    fn n_rows(&self) -> usize {
        match &self.profile {
            Profile::Straight(..) => 2,
            Profile::Arc(_, _, cuts) => cuts.len(),
        }
    }

    /// Whether the last row is the first.
    fn is_tube(&self) -> bool {
        /// Radians: the ends of a full turn differ by what rounding did to them, those of a part by a spacing.
        const ROUNDING: f64 = Tolerances::SAME;
        matches!(&self.profile, Profile::Arc(_, _, cuts) if cuts[cuts.len() - 1] - cuts[0] > TAU - ROUNDING)
    }

    /// Radius and height of a row.
    fn row(&self, j: usize) -> (f64, f64) {
        match &self.profile {
            Profile::Straight(radii, heights) => (radii[j], heights[j]),
            Profile::Arc(center, radius, cuts) => {
                let (sin, cos) = cuts[j].sin_cos();
                (center + radius * cos, radius * sin)
            }
        }
    }

    /// Height of a face's frame: beside the face on a straight profile, the centre of an arc.
    fn placed_at(&self, j: usize) -> f64 {
        match &self.profile {
            Profile::Straight(_, heights) => heights[(j + 1).min(1)],
            Profile::Arc(..) => 0.0,
        }
    }

    fn radial(&self, angle: f64) -> UnitVec3 {
        let (sin, cos) = angle.sin_cos();
        UnitVec3::new_normalize(self.frame.x.into_inner() * cos + self.frame.y.into_inner() * sin)
    }

    fn point(&self, angle: f64, j: usize) -> Point3 {
        let (radius, height) = self.row(j);
        self.frame.origin + self.radial(angle).into_inner() * radius + self.frame.z.into_inner() * height
    }

    /// The circle of a row.
    fn around(&self, j: usize) -> Curve {
        let (radius, height) = self.row(j);
        let origin = self.frame.origin + self.frame.z.into_inner() * height;
        Curve::Circle { frame: Frame { origin, ..self.frame }, radius }
    }

    /// The profile at an angle, from row `j` to the next.
    fn along(&self, angle: f64, j: usize) -> Option<Curve> {
        match &self.profile {
            Profile::Straight(..) => {
                let (origin, end) = (self.point(angle, j), self.point(angle, j + 1));
                Some(Curve::Line { origin, direction: try_unit(end - origin)? })
            }
            Profile::Arc(center, radius, _) => {
                let x = self.radial(angle);
                let origin = self.frame.origin + x.into_inner() * *center;
                let z = UnitVec3::new_normalize(x.cross(&self.frame.z));
                Some(Curve::Circle { frame: Frame { origin, x, y: self.frame.z, z }, radius: *radius })
            }
        }
    }
}

/// A shell in the making.
struct Drawing {
    solid: Solid,
    outward: bool,
    region: RegionId,
}

impl Drawing {
    fn new(fit: &Fit, region: RegionId) -> Self {
        let solid = Solid {
            surfaces: vec![Geometry::Analytic(fit.surface)],
            shells: vec![Shell { faces: Vec::new(), closed: false }],
            ..Solid::default()
        };
        Self { solid, outward: fit.outward, region }
    }

    fn vertex(&mut self, point: Point3) -> VertexId {
        self.solid.vertices.push(Vertex { point });
        VertexId(self.solid.vertices.len() as u32 - 1)
    }

    fn edge(&mut self, curve: Curve, start: VertexId, end: VertexId) -> EdgeId {
        self.solid.edges.push(Edge { curve, start, end });
        EdgeId(self.solid.edges.len() as u32 - 1)
    }

    /// Adds a face bounded by `uses`, the natural normal towards the reader when they run counter-clockwise.
    fn face(&mut self, frame: Frame, uses: &[(EdgeId, bool)]) {
        let mut uses: Vec<EdgeUse> = uses.iter().map(|&(edge, forward)| EdgeUse { edge, forward }).collect();
        if !self.outward {
            uses.reverse();
            for edge_use in &mut uses {
                edge_use.forward = !edge_use.forward;
            }
        }
        self.solid.shells[0].faces.push(FaceId(self.solid.faces.len() as u32));
        self.solid.faces.push(Face {
            surface: SurfaceId(0),
            frame,
            same_sense: self.outward,
            loops: vec![Loop { uses }],
            region: self.region,
            assumed: false,
        });
    }

    /// The smallest rectangle around the points of a plane.
    fn rectangle(&mut self, points: &[Point3]) -> Option<()> {
        let Geometry::Analytic(Surface::Plane(plane)) = self.solid.surfaces[0] else { return None };
        let center = centroid(points);
        let frame =
            Frame::from_z(center - plane.normal.into_inner() * plane.signed_distance(&center), plane.normal);
        let flat: Vec<[f64; 2]> = points.iter().map(|p| frame.local(p)).map(|l| [l.x, l.y]).collect();
        let (angle, [low, high]) = smallest_rectangle(&flat)?;
        let (sin, cos) = angle.sin_cos();
        let corner = |u: f64, v: f64| frame.global(&Vec3::new(u * cos - v * sin, u * sin + v * cos, 0.0));
        let corners = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
            .map(|(u, v)| corner(u, v));
        let ids = corners.map(|point| self.vertex(point));
        let mut uses = Vec::new();
        for k in 0..4 {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            let line = Curve::Line { origin: a, direction: try_unit(b - a)? };
            uses.push((self.edge(line, ids[k], ids[(k + 1) % 4]), true));
        }
        self.face(frame, &uses);
        Some(())
    }

    /// All faces of a surface of revolution over a turn, four edges each; three where a row is a point on the axis.
    /// Returns the edges of every row's circle.
    fn grid(&mut self, turned: &Turned, span: &Span) -> Option<Vec<Vec<Option<EdgeId>>>> {
        let cuts = span.cuts();
        let (n_cuts, n_rows) = (cuts.len(), turned.n_rows());
        let (n_columns, n_rings) = (
            if span.whole { n_cuts - 1 } else { n_cuts },
            if turned.is_tube() { n_rows - 1 } else { n_rows },
        );
        let is_point = |j: usize| turned.row(j).0 <= 0.0;
        let mut ids = Vec::new();
        for j in 0..n_rings {
            let first = self.vertex(turned.point(cuts[0], j));
            let mut row = vec![first; n_columns];
            for (i, id) in row.iter_mut().enumerate().skip(1) {
                if !is_point(j) {
                    *id = self.vertex(turned.point(cuts[i], j));
                }
            }
            ids.push(row);
        }
        let id = |i: usize, j: usize| ids[j % n_rings][i % n_columns];
        let mut around = Vec::new();
        for j in 0..n_rings {
            let mut row = Vec::new();
            for i in 0..n_cuts - 1 {
                row.push((!is_point(j)).then(|| self.edge(turned.around(j), id(i, j), id(i + 1, j))));
            }
            around.push(row);
        }
        let mut along = Vec::new();
        for j in 0..n_rows - 1 {
            let mut row = Vec::new();
            for (i, angle) in cuts.iter().enumerate().take(n_columns) {
                row.push(self.edge(turned.along(*angle, j)?, id(i, j), id(i, j + 1)));
            }
            along.push(row);
        }
        for j in 0..n_rows - 1 {
            for i in 0..n_cuts - 1 {
                let sides = [
                    around[j][i].map(|e| (e, true)),
                    Some((along[j][(i + 1) % n_columns], true)),
                    around[(j + 1) % n_rings][i].map(|e| (e, false)),
                    Some((along[j][i % n_columns], false)),
                ];
                let uses: Vec<(EdgeId, bool)> = sides.into_iter().flatten().collect();
                let middle = turned.radial(0.5 * (cuts[i] + cuts[i + 1]));
                self.face(facing(&turned.frame, &middle, turned.placed_at(j)), &uses);
            }
        }
        Some(around)
    }

    /// A torus over its turn and the part of its tube that was seen.
    fn tube(&mut self, torus: &Torus, points: &[Point3]) -> Option<()> {
        let frame = frame_of(&torus.axis);
        let span = Span::of_angles(&frame, points);
        let tube = Span::of(
            points
                .iter()
                .map(|p| torus.axis.height(p).atan2(torus.axis.radial(p).norm() - torus.major_radius))
                .collect(),
        );
        // Of a spindle torus only the part outside its axis is a surface of one piece.
        let reach = (-torus.major_radius / torus.minor_radius).clamp(-1.0, 1.0).acos();
        let cuts = if reach < PI {
            const OFF_AXIS: f64 = 0.02;
            let middle = 0.5 * (tube.from + tube.to);
            let turns = TAU * (middle / TAU).round();
            let (from, to) =
                ((tube.from - turns).max(OFF_AXIS - reach), (tube.to - turns).min(reach - OFF_AXIS));
            Span { from, to, whole: false }.cuts()
        } else {
            tube.cuts()
        };
        let profile = Profile::Arc(torus.major_radius, torus.minor_radius, cuts);
        self.grid(&Turned { frame, profile }, &span).map(|_| ())
    }

    /// The zone of a sphere, about whichever axis it is smallest, that holds all points.
    fn zone(&mut self, sphere: &Sphere, points: &[Point3]) -> Option<()> {
        let Zone { frame, turn, polar: [low, high] } = Zone::smallest(sphere, points)?;
        // Angles of the profile are latitudes, from the south upwards.
        let caps = [high >= PI, low <= 0.0];
        let (from, to) = (
            0.5 * PI - if caps[0] { low.max(PI - CAP) } else { high },
            0.5 * PI - if caps[1] { high.min(CAP) } else { low },
        );
        let rows = if from < to { Span { from, to, whole: false }.cuts() } else { vec![from] };
        let turned = Turned { frame, profile: Profile::Arc(0.0, sphere.radius, rows) };
        let circles = self.grid(&turned, &turn)?;
        if caps[0] {
            let uses: Vec<(EdgeId, bool)> = circles[0].iter().rev().flatten().map(|e| (*e, false)).collect();
            self.face(beside(&frame), &uses);
        }
        if caps[1] {
            let uses: Vec<(EdgeId, bool)> =
                circles[circles.len() - 1].iter().flatten().map(|e| (*e, true)).collect();
            self.face(beside(&Frame { z: -frame.z, ..frame }), &uses);
        }
        Some(())
    }
}

/// Polar angle up to which a cap is one face: the poles of a frame that lies on its side are then clear of it.
const CAP: f64 = 1.4;

/// A part of a sphere: polar angles and longitudes about an axis.
struct Zone {
    frame: Frame,
    turn: Span,
    polar: [f64; 2],
}

impl Zone {
    /// The zone with least area of those about the mean direction and the principal axes of the points.
    fn smallest(sphere: &Sphere, points: &[Point3]) -> Option<Self> {
        let mean: Vec3 = points.iter().map(|p| (p - sphere.center) / sphere.radius).sum();
        let axes = principal_axes(points, sphere.center).map(|axis| axis.1);
        let zones =
            try_unit(mean).into_iter().chain(axes).filter_map(|axis| Self::about(sphere, axis, points));
        zones.min_by(|a, b| a.area().total_cmp(&b.area()))
    }

    fn about(sphere: &Sphere, axis: UnitVec3, points: &[Point3]) -> Option<Self> {
        /// Polar angle below which the pole itself was seen.
        const POLE: f64 = 0.25;
        let frame = Frame::from_z(sphere.center, axis);
        let polar = |p: &Point3| {
            let local = frame.local(p);
            local.x.hypot(local.y).atan2(local.z)
        };
        let [low, high] = range(points.iter().map(polar))?;
        let polar = [if low < POLE { 0.0 } else { low }, if high > PI - POLE { PI } else { high }];
        let turn = Span::of_angles(&frame, points);
        // A wedge would end in a pole, where no frame's parameters are clear.
        let is_wedge = !turn.whole && (polar[0] <= 0.0 || polar[1] >= PI);
        (!is_wedge).then_some(Self { frame, turn, polar })
    }

    fn area(&self) -> f64 {
        (self.polar[0].cos() - self.polar[1].cos()) * (self.turn.to - self.turn.from)
    }
}

fn frame_of(axis: &Axis) -> Frame {
    Frame::from_z(axis.origin, axis.direction)
}

/// The frame of a face in the direction `middle` from the axis: its seam is opposite, its origin beside the face.
fn facing(frame: &Frame, middle: &UnitVec3, height: f64) -> Frame {
    let x = -*middle;
    let y = UnitVec3::new_normalize(frame.z.cross(&x));
    Frame { origin: frame.origin + frame.z.into_inner() * height, x, y, z: frame.z }
}

/// The frame of a cap opposite the third direction of `frame`: its poles and its seam are clear of it.
fn beside(frame: &Frame) -> Frame {
    let z = any_perpendicular(&frame.z);
    Frame { origin: frame.origin, x: frame.z, y: UnitVec3::new_normalize(z.cross(&frame.z)), z }
}
