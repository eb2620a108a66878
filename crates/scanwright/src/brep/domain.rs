//! A face in the parameter plane of its surface.
//!
//! Coordinates are lengths (angles times a radius), counted from the side opposite the frame's seam, so that a face
//! placed by its builder never meets a jump. Right-handed with the natural normal.

use std::sync::OnceLock;

use super::assemble::use_points;
use super::curve::Curve;
use super::solid::{EdgeId, Face, Geometry, Loop, Solid};
use crate::math::{Frame, Point3};
use crate::surface::Surface;
use crate::surface::bspline::SplineSurface;

/// A point of the parameter plane.
pub(super) type Uv = [f64; 2];

/// The map between a face's surface and its parameter plane.
#[derive(Debug, Clone)]
pub(super) struct Domain<'a> {
    geometry: &'a Geometry,
    frame: Frame,
    /// Angle about a tube's spine that becomes the second coordinate's zero.
    tube_zero: f64,
    /// Where projections on a spline start; made when first asked for.
    starts: OnceLock<Starts>,
}

/// The angle opposite the middle of the widest gap between `angles`, radians. Not their mean: of a tube that is open at
/// one side, more points may lie on the rims of the opening than across from it.
fn opposite_widest_gap(mut angles: Vec<f64>) -> f64 {
    use std::f64::consts::{PI, TAU};
    angles.sort_by(f64::total_cmp);
    let Some(first) = angles.first() else { return 0.0 };
    let next = angles[1..].iter().copied().chain([first + TAU]);
    let gaps = angles.iter().zip(next).map(|(a, b)| (b - a, 0.5 * (a + b)));
    gaps.max_by(|x, y| x.0.total_cmp(&y.0)).map_or(0.0, |(_, middle)| middle - PI)
}

impl<'a> Domain<'a> {
    pub(super) fn new(solid: &'a Solid, face: &Face) -> Self {
        /// Samples of an edge: on one that goes round a whole tube, steps of 15 degrees, less than a cut face leaves.
        const N_SAMPLES: usize = 24;
        let uses = face.loops.iter().flat_map(|l| &l.uses);
        Self::around(solid.geometry(face), face.frame, || {
            uses.flat_map(|u| use_points(solid, *u, N_SAMPLES)).collect::<Vec<_>>()
        })
    }

    /// The plane of `geometry` placed by `frame`; `points` tell which side of a tube is meant.
    pub(super) fn around(geometry: &'a Geometry, frame: Frame, points: impl FnOnce() -> Vec<Point3>) -> Self {
        let mut domain = Self { geometry, frame, tube_zero: 0.0, starts: OnceLock::new() };
        if let Geometry::Analytic(Surface::Torus(_)) = geometry {
            let angles = points().iter().map(|p| domain.tube_angle(p)).collect();
            domain.tube_zero = opposite_widest_gap(angles);
        }
        domain
    }

    fn tube_angle(&self, point: &Point3) -> f64 {
        let Geometry::Analytic(Surface::Torus(torus)) = self.geometry else { return 0.0 };
        torus.axis.height(point).atan2(torus.axis.radial(point).norm() - torus.major_radius)
    }

    fn starts(&self, spline: &SplineSurface) -> &Starts {
        self.starts.get_or_init(|| Starts::of(spline))
    }

    /// Coordinates of a point on (or near) the surface.
    pub(super) fn uv(&self, point: &Point3) -> Uv {
        let local = self.frame.local(point);
        let mut around = (-local.y).atan2(-local.x);
        /// Share of a cone's radius below which a point is its apex, where every angle is right.
        const APEX: f64 = 1e-9;
        if matches!(self.geometry, Geometry::Analytic(Surface::Cone(s)) if local.x.hypot(local.y) < APEX * s.radius)
        {
            around = 0.0;
        }
        match self.geometry {
            Geometry::Spline(spline) => {
                let (u, v) = self.starts(spline).project(spline, point);
                [u, v]
            }
            Geometry::Analytic(surface) => match surface {
                Surface::Plane(_) => [local.x, local.y],
                Surface::Cylinder(s) => [s.radius * around, local.z],
                Surface::Cone(s) => [self.cone_radius(s) * around, local.z / s.half_angle.cos()],
                Surface::Sphere(s) => [s.radius * around, s.radius * local.z.atan2(local.x.hypot(local.y))],
                Surface::Torus(s) => {
                    let tau = std::f64::consts::TAU;
                    let turn = self.tube_angle(point) - self.tube_zero;
                    let turn = turn - tau * (turn / tau).round();
                    [(s.major_radius.abs() + s.minor_radius) * around, s.minor_radius * turn]
                }
            },
        }
    }

    /// The point of the surface with the given coordinates.
    pub(super) fn point(&self, [u, v]: Uv) -> Point3 {
        let polar = |angle: f64, radius: f64, height: f64| {
            let (sin, cos) = angle.sin_cos();
            self.frame.global(&crate::math::Vec3::new(-radius * cos, -radius * sin, height))
        };
        match self.geometry {
            Geometry::Spline(spline) => spline.point(u, v),
            Geometry::Analytic(surface) => match surface {
                Surface::Plane(_) => self.frame.global(&crate::math::Vec3::new(u, v, 0.0)),
                Surface::Cylinder(s) => polar(u / s.radius, s.radius, v),
                Surface::Cone(s) => {
                    let height = v * s.half_angle.cos();
                    let scale = self.cone_radius(s);
                    polar(u / scale, self.radius_at_origin(s) + height * s.half_angle.tan(), height)
                }
                Surface::Sphere(s) => {
                    polar(u / s.radius, s.radius * (v / s.radius).cos(), s.radius * (v / s.radius).sin())
                }
                Surface::Torus(s) => {
                    let angle = v / s.minor_radius + self.tube_zero;
                    let radius = s.major_radius + s.minor_radius * angle.cos();
                    polar(u / (s.major_radius.abs() + s.minor_radius), radius, s.minor_radius * angle.sin())
                }
            },
        }
    }

    fn radius_at_origin(&self, cone: &crate::surface::Cone) -> f64 {
        cone.radius + cone.axis.height(&self.frame.origin) * cone.half_angle.tan()
    }

    /// A positive scale for a cone's angle even where the frame sits on the apex.
    fn cone_radius(&self, cone: &crate::surface::Cone) -> f64 {
        self.radius_at_origin(cone).max(f64::EPSILON * cone.radius.abs()).max(f64::MIN_POSITIVE)
    }

    /// Steps in both coordinates that turn the normal by `angle`; `None` where the surface is straight.
    pub(super) fn steps(&self, angle: f64) -> [Option<f64>; 2] {
        match self.geometry {
            // A spline's coordinates run from 0 to 1.
            Geometry::Spline(s) => [s.n_poles().0, s.n_poles().1].map(|n| Some(1.0 / n as f64)),
            Geometry::Analytic(surface) => match surface {
                Surface::Plane(_) => [None, None],
                Surface::Cylinder(s) => [Some(s.radius * angle), None],
                Surface::Cone(s) => [Some(self.cone_radius(s) * angle), None],
                Surface::Sphere(s) => [Some(s.radius * angle); 2],
                Surface::Torus(s) => {
                    [Some((s.major_radius.abs() + s.minor_radius) * angle), Some(s.minor_radius * angle)]
                }
            },
        }
    }

    /// The lengths after which the coordinates come back to the same point; `None` where they never do.
    pub(super) fn periods(&self) -> [Option<f64>; 2] {
        let tau = std::f64::consts::TAU;
        match self.geometry {
            Geometry::Spline(_) => [None, None],
            Geometry::Analytic(surface) => match surface {
                Surface::Plane(_) => [None, None],
                Surface::Cylinder(s) => [Some(tau * s.radius), None],
                Surface::Cone(s) => [Some(tau * self.cone_radius(s)), None],
                Surface::Sphere(s) => [Some(tau * s.radius), None],
                Surface::Torus(s) => {
                    [Some(tau * (s.major_radius.abs() + s.minor_radius)), Some(tau * s.minor_radius)]
                }
            },
        }
    }

    /// Distance of a point from the surface.
    pub(super) fn distance(&self, point: &Point3) -> f64 {
        match self.geometry {
            Geometry::Analytic(surface) => surface.signed_distance(point).abs(),
            Geometry::Spline(spline) => {
                let (u, v) = self.starts(spline).project(spline, point);
                (spline.point(u, v) - point).norm()
            }
        }
    }

    /// A loop as a polygon, its curves sampled.
    pub(super) fn polygon(&self, solid: &Solid, run: &Loop) -> Vec<Uv> {
        self.polygon_with_edges(solid, run).0
    }

    /// A loop as a polygon, and the edge that each of its sides is from.
    pub(super) fn polygon_with_edges(&self, solid: &Solid, run: &Loop) -> (Vec<Uv>, Vec<EdgeId>) {
        let (mut polygon, mut edges) = (Vec::new(), Vec::new());
        for edge_use in &run.uses {
            let edge = solid.edge(edge_use.edge);
            let n = n_samples(&edge.curve, &solid.point(edge.start), &solid.point(edge.end));
            let points = use_points(solid, *edge_use, n);
            polygon.extend(points[..n].iter().map(|p| self.uv(p)));
            edges.resize(polygon.len(), edge_use.edge);
        }
        (polygon, edges)
    }
}

/// Intervals that a curve is divided into: about ten degrees of a conic, two per pole of a spline.
pub(super) fn n_samples(curve: &Curve, start: &Point3, end: &Point3) -> usize {
    /// Most intervals of one spline.
    const MOST: usize = 96;
    match curve {
        // Straight edges on curved surfaces are rulings, straight in the parameter plane too.
        Curve::Line { .. } => 1,
        Curve::Circle { .. } | Curve::Ellipse { .. } => {
            (curve.sweep(start, end) / ANGLE_STEP).ceil().max(2.0) as usize
        }
        Curve::Spline(spline) => (2 * spline.poles.len()).min(MOST),
    }
}

/// Radians of turn per interval: ten degrees.
pub(super) const ANGLE_STEP: f64 = std::f64::consts::PI / 18.0;

/// The point of a spline nearest to `point`.
pub(super) fn nearest_on_spline(spline: &SplineSurface, point: &Point3) -> Point3 {
    let (u, v) = Starts::of(spline).project(spline, point);
    spline.point(u, v)
}

/// Starts tried along each side of a spline.
const GRID: usize = 12;

/// A grid of points of a spline, from which projections start.
#[derive(Debug, Clone)]
struct Starts(Vec<(Point3, (f64, f64))>);

impl Starts {
    fn of(spline: &SplineSurface) -> Self {
        let at = |i: usize| (i as f64 + 0.5) / GRID as f64;
        let places = (0..GRID).flat_map(|i| (0..GRID).map(move |j| (at(i), at(j))));
        Self(places.map(|(u, v)| (spline.point(u, v), (u, v))).collect())
    }

    /// Parameters of the point of the spline nearest to `point`.
    fn project(&self, spline: &SplineSurface, point: &Point3) -> (f64, f64) {
        /// The nearest starts that are followed: beside a bend the nearest one may lead astray.
        const FOLLOWED: usize = 3;
        let mut starts: Vec<(f64, (f64, f64))> =
            self.0.iter().map(|(start, place)| ((start - point).norm_squared(), *place)).collect();
        starts.select_nth_unstable_by(FOLLOWED - 1, |a, b| a.0.total_cmp(&b.0));
        starts[..FOLLOWED].sort_by(|a, b| a.0.total_cmp(&b.0));
        let ends = starts[..FOLLOWED].iter().map(|s| spline.project(point, s.1));
        let off = |s: &(f64, f64)| (spline.point(s.0, s.1) - point).norm_squared();
        ends.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or((0.5, 0.5))
    }
}

/// Signed area of a polygon, positive when counter-clockwise.
pub(super) fn signed_area(polygon: &[Uv]) -> f64 {
    let n = polygon.len();
    let Some(base) = polygon.first() else { return 0.0 };
    let cross = |a: &Uv, b: &Uv| (a[0] - base[0]) * (b[1] - base[1]) - (a[1] - base[1]) * (b[0] - base[0]);
    (0..n).map(|i| cross(&polygon[i], &polygon[(i + 1) % n])).sum::<f64>() * 0.5
}

/// Whether a point is inside an odd number of polygons.
pub(super) fn inside(polygons: &[Vec<Uv>], [x, y]: Uv) -> bool {
    let mut odd = false;
    for polygon in polygons {
        for (i, a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            if (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
                odd = !odd;
            }
        }
    }
    odd
}
