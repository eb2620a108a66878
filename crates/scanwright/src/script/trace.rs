//! What the faces of a solid leave on the plane of a profile: curves of faces that the motion keeps, and levels where
//! faces stand across it.

use std::collections::{BTreeMap, BTreeSet};

use super::body::Body;
use super::curve::Curve;
use super::sweep::{Motion, Point2, Sweep};
use crate::brep::{EdgeId, FaceId, Geometry};
use crate::math::{Axis, Point3, fitted_circle, longest_extent};
use crate::surface::{Surface, SurfaceKind};

/// A curve of the profile and the faces that lie on what it sweeps.
#[derive(Debug, Clone)]
pub(super) struct Trace {
    pub(super) curve: Curve,
    /// Ascending; empty for a line that only bounds what other faces cut.
    pub(super) faces: Vec<usize>,
    /// Whether most of the faces' area has its material on the left of a line, inside a circle.
    pub(super) is_material_inside: bool,
}

/// Where a profile may begin or end.
#[derive(Debug, Clone)]
pub(super) struct Level {
    pub(super) at: f64,
    /// Faces that lie in it, ascending.
    pub(super) faces: Vec<usize>,
}

/// What all faces leave.
#[derive(Debug, Clone)]
pub(super) struct Traces {
    pub(super) curves: Vec<Trace>,
    /// Ascending.
    pub(super) levels: Vec<Level>,
}

/// One face's share of a trace or level.
struct Seen {
    face: usize,
    area: f64,
    ends: [Point2; 2],
}

impl Traces {
    /// Faces count as kept by the motion when they stay within `tolerance` of what a curve sweeps.
    pub(super) fn new(body: &Body, sweep: &Sweep, tolerance: f64) -> Self {
        let mut curves: Vec<(Trace, Seen)> = Vec::new();
        let mut levels: Vec<Place> = Vec::new();
        let n_faces = body.solid.faces.len();
        let mut kept = vec![false; n_faces];
        for (face, kept) in kept.iter_mut().enumerate() {
            let points = body.points(face);
            if points.is_empty() {
                continue;
            }
            let area = body.area(face);
            if let Some((curve, ends)) = curve_of(body, sweep, face, &points, tolerance) {
                *kept = true;
                let is_material_inside = material_inside(body, sweep, face, &curve);
                let trace = Trace { curve, faces: vec![face], is_material_inside };
                curves.push((trace, Seen { face, area, ends }));
                if let Motion::Around = sweep.motion {
                    continue;
                }
            }
            levels
                .extend(levels_of(sweep, &points, tolerance).into_iter().map(|at| (at, Some((face, area)))));
        }
        let (bounds, stops) = borders(body, sweep, &kept, tolerance);
        levels.extend(stops.into_iter().map(|at| (at, None)));
        let mut curves = merged(curves, tolerance);
        for curve in bounds {
            let is_new = curves.iter().all(|t| !same_line(&t.curve, &curve, tolerance));
            if is_new {
                curves.push(Trace { curve, faces: Vec::new(), is_material_inside: false });
            }
        }
        Self { curves, levels: merged_levels(levels, sweep, tolerance) }
    }
}

/// The curve that a face leaves, and its ends there; `None` when the motion does not keep the face.
fn curve_of(
    body: &Body,
    sweep: &Sweep,
    face: usize,
    points: &[Point3],
    tolerance: f64,
) -> Option<(Curve, [Point2; 2])> {
    let flat: Vec<Point2> = points.iter().map(|p| sweep.coordinates(p).0).collect();
    let curve = match (body.solid.geometry(&body.solid.faces[face]), sweep.motion) {
        (Geometry::Analytic(Surface::Cylinder(s)), Motion::Along) => {
            let center = sweep.coordinates(&near(&s.axis, points)).0;
            Curve::Circle { center, radius: s.radius }
        }
        (Geometry::Analytic(Surface::Torus(s)), Motion::Around) => {
            let (center, radius) = fitted_circle(&flat)?;
            let known = Point2::new(s.major_radius.abs(), sweep.coordinates(&s.axis.origin).0.y);
            let is_known = (center - known).norm() <= tolerance && s.major_radius > 0.0;
            if is_known {
                Curve::Circle { center: known, radius: s.minor_radius }
            } else {
                Curve::Circle { center, radius }
            }
        }
        (Geometry::Analytic(Surface::Sphere(s)), Motion::Around) => {
            let (center, _) = sweep.coordinates(&s.center);
            if center.x > tolerance {
                return None;
            }
            Curve::Circle { center: Point2::new(0.0, center.y), radius: s.radius }
        }
        (Geometry::Analytic(surface), _) if surface.kind() != SurfaceKind::Sphere => {
            // What turns about the axis stands across it or along it, if it is no cone; a wall may have a draft.
            let slack = match (sweep.motion, surface.kind()) {
                (Motion::Around, SurfaceKind::Plane | SurfaceKind::Cylinder) => tolerance,
                _ => 0.5 * tolerance,
            };
            straightened(line_through(&flat)?, &flat, slack)
        }
        _ => return None,
    };
    let is_near = flat.iter().all(|p| curve.distance(p).abs() <= tolerance);
    if !is_near {
        return None;
    }
    let along = |p: &Point2| curve.parameter(p);
    let ends = match curve {
        Curve::Line { .. } => {
            let low = flat.iter().min_by(|a, b| along(a).total_cmp(&along(b)))?;
            let high = flat.iter().max_by(|a, b| along(a).total_cmp(&along(b)))?;
            // A face that a line sweeps has a length: what stands across the motion is a point, or no line at all.
            if (high - low).norm() <= tolerance {
                return None;
            }
            [*low, *high]
        }
        Curve::Circle { center, .. } => [center; 2],
    };
    Some((curve, ends))
}

fn line_through(points: &[Point2]) -> Option<Curve> {
    let (point, direction) = longest_extent(points);
    let length = direction.norm();
    (length > 0.0 && length.is_finite()).then(|| Curve::Line { point, direction: direction / length })
}

/// A line along one of the plane's directions where it leaves that by less than `slack` over its points.
fn straightened(line: Curve, points: &[Point2], slack: f64) -> Curve {
    let Curve::Line { point, direction } = line else { return line };
    let (low, high) = range(points.iter().map(|p| line.parameter(p)));
    for axis in 0..2 {
        if direction[axis].abs() * (high - low) <= slack {
            let mut straight = Point2::zeros();
            straight[1 - axis] = direction[1 - axis].signum();
            return Curve::Line { point, direction: straight };
        }
    }
    line
}

/// The point of an axis beside the middle of points.
fn near(axis: &Axis, points: &[Point3]) -> Point3 {
    axis.foot(&crate::math::centroid(points))
}

/// Whether the material is on the left of a line, inside of a circle.
fn material_inside(body: &Body, sweep: &Sweep, face: usize, curve: &Curve) -> bool {
    let mesh = &body.tessellation.mesh;
    let mut side = 0.0;
    for &t in &body.triangles[face] {
        let center = mesh.triangle_center(t as usize);
        let outward = mesh.cross(t as usize);
        let length = outward.norm();
        if length <= 0.0 {
            continue;
        }
        // A step as long as the triangle is wide shows the side whatever the curve.
        let step = outward * (0.01 / length.sqrt());
        let [inner, outer] = [-step, step].map(|s| curve.distance(&sweep.coordinates(&(center + s)).0));
        let inside_is_lower = match curve {
            Curve::Line { .. } => inner > outer,
            Curve::Circle { .. } => inner < outer,
        };
        side += if inside_is_lower { length } else { -length };
    }
    side > 0.0
}

/// Where a face stands across the motion: one place, or two of a plane through the axis.
fn levels_of(sweep: &Sweep, points: &[Point3], tolerance: f64) -> Vec<f64> {
    let moved: Vec<(Point2, f64)> = points.iter().map(|p| sweep.coordinates(p)).collect();
    match sweep.motion {
        Motion::Along => {
            let (low, high) = range(moved.iter().map(|m| m.1));
            if high - low <= 2.0 * tolerance { vec![0.5 * (low + high)] } else { Vec::new() }
        }
        Motion::Around => {
            // The plane through the axis that the farthest point lies in.
            let Some(far) = moved.iter().max_by(|a, b| a.0.x.total_cmp(&b.0.x)) else { return Vec::new() };
            let off = |m: &(Point2, f64)| (m.0.x * (m.1 - far.1).sin()).abs();
            if !moved.iter().all(|m| off(m) <= tolerance) {
                return Vec::new();
            }
            let (mut ahead, mut behind) = (false, false);
            for m in moved.iter().filter(|m| m.0.x > tolerance) {
                let is_ahead = (m.1 - far.1).cos() > 0.0;
                ahead |= is_ahead;
                behind |= !is_ahead;
            }
            let tau = std::f64::consts::TAU;
            let opposite = (far.1 + 0.5 * tau).rem_euclid(tau);
            [(ahead, far.1), (behind, opposite)].into_iter().filter(|l| l.0).map(|l| l.1).collect()
        }
    }
}

/// Where kept faces end at others: lines across the axis and places along the motion.
fn borders(body: &Body, sweep: &Sweep, kept: &[bool], tolerance: f64) -> (Vec<Curve>, Vec<f64>) {
    let (mut lines, mut stops) = (Vec::new(), Vec::new());
    for (edge, faces) in faces_of_edges(body) {
        let n_kept = faces.iter().filter(|f| kept[f.0 as usize]).count();
        if n_kept != 1 || faces.len() != 2 {
            continue;
        }
        let e = body.solid.edge(edge);
        let points = e.curve.sample(&body.solid.point(e.start), &body.solid.point(e.end), 24);
        let moved: Vec<(Point2, f64)> = points.iter().map(|p| sweep.coordinates(p)).collect();
        match sweep.motion {
            Motion::Along => {
                let (low, high) = range(moved.iter().map(|m| m.1));
                stops.extend([low, high]);
            }
            Motion::Around => {
                stops.extend(levels_of(sweep, &points, tolerance));
                let (low, high) = range(moved.iter().map(|m| m.0.y));
                lines.extend(
                    [low, high].map(|z| Curve::Line {
                        point: Point2::new(0.0, z),
                        direction: Point2::new(1.0, 0.0),
                    }),
                );
            }
        }
    }
    (lines, stops)
}

/// The faces at each edge, ascending, except between faces of one surface.
fn faces_of_edges(body: &Body) -> BTreeMap<EdgeId, Vec<FaceId>> {
    let mut at: BTreeMap<EdgeId, Vec<FaceId>> = BTreeMap::new();
    for (f, face) in body.solid.faces.iter().enumerate() {
        for edge_use in face.loops.iter().flat_map(|l| &l.uses) {
            at.entry(edge_use.edge).or_default().push(FaceId(f as u32));
        }
    }
    at.retain(|_, faces| {
        let surfaces: BTreeSet<_> = faces.iter().map(|f| body.solid.face(*f).surface).collect();
        surfaces.len() == 2
    });
    at
}

/// Curves that are one within the tolerance, as one: the middle of them by area.
fn merged(mut curves: Vec<(Trace, Seen)>, tolerance: f64) -> Vec<Trace> {
    // The largest faces say best where a curve is.
    curves.sort_by(|a, b| b.1.area.total_cmp(&a.1.area).then(a.1.face.cmp(&b.1.face)));
    let mut made: Vec<(Trace, f64)> = Vec::new();
    for (trace, seen) in curves {
        let known = made.iter_mut().find(|(m, _)| trace.curve.is_same(&m.curve, seen.ends, tolerance));
        let Some((known, area)) = known else {
            made.push((trace, seen.area));
            continue;
        };
        known.faces.extend(&trace.faces);
        let share = seen.area / (*area + seen.area);
        *area += seen.area;
        known.curve = match (known.curve, trace.curve) {
            (Curve::Line { point, direction }, Curve::Line { .. }) => {
                let middle = (seen.ends[0] + seen.ends[1]) * 0.5;
                let across = Point2::new(-direction.y, direction.x);
                let shift = share * across.dot(&(middle - point));
                Curve::Line { point: point + across * shift, direction }
            }
            (Curve::Circle { center: a, radius: r }, Curve::Circle { center: b, radius: s }) => {
                Curve::Circle { center: a + (b - a) * share, radius: r + (s - r) * share }
            }
            (known, _) => known,
        };
    }
    let mut traces: Vec<Trace> = made.into_iter().map(|m| m.0).collect();
    for trace in &mut traces {
        trace.faces.sort_unstable();
    }
    traces
}

/// Whether a line across the axis is one of `curve` already.
fn same_line(curve: &Curve, line: &Curve, tolerance: f64) -> bool {
    let (Curve::Line { point: p, direction: d }, Curve::Line { point: q, direction: e }) = (curve, line)
    else {
        return false;
    };
    /// Sine up to which two lines of a profile run alike: over its length they part by no more than a drawing shows.
    const ALIKE: f64 = 1e-6;
    super::curve::cross(d, e).abs() < ALIKE && super::curve::cross(d, &(q - p)).abs() <= tolerance
}

/// A place with the face that lies there and its area, if one does.
type Place = (f64, Option<(usize, f64)>);

/// Places within the tolerance of one another, as one: where faces lie, else the middle.
fn merged_levels(mut levels: Vec<Place>, sweep: &Sweep, tolerance: f64) -> Vec<Level> {
    // An angle's tolerance is that of a point a hundred tolerances from the axis.
    let room = if sweep.motion == Motion::Around { 0.01 } else { tolerance };
    let tau = std::f64::consts::TAU;
    levels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut made: Vec<Vec<Place>> = Vec::new();
    for level in levels {
        match made.last_mut() {
            Some(last) if level.0 - last[last.len() - 1].0 <= room => last.push(level),
            _ => made.push(vec![level]),
        }
    }
    if sweep.motion == Motion::Around && made.len() > 1 {
        let (first, last) = (made[0][0].0, made[made.len() - 1][0].0);
        if first + tau - last <= room {
            let turned = made.remove(0).into_iter().map(|(at, face)| (at + tau, face));
            made.last_mut().expect("more than one").extend(turned);
        }
    }
    made.into_iter()
        .map(|group| {
            let with_face: Vec<(f64, f64)> =
                group.iter().filter_map(|(at, face)| face.map(|f| (*at, f.1))).collect();
            let total: f64 = with_face.iter().map(|w| w.1).sum();
            let at = if total > 0.0 {
                with_face.iter().map(|w| w.0 * w.1).sum::<f64>() / total
            } else {
                group.iter().map(|l| l.0).sum::<f64>() / group.len() as f64
            };
            let mut faces: Vec<usize> = group.iter().filter_map(|l| l.1.map(|f| f.0)).collect();
            faces.sort_unstable();
            faces.dedup();
            Level { at: if sweep.motion == Motion::Around { at.rem_euclid(tau) } else { at }, faces }
        })
        .collect()
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}
