//! Planar pictures of surfaces, in which holes are filled by triangulation.
//!
//! A surface of revolution is pictured conformally: angle `a` round its axis and isothermal coordinate `l` along its
//! generator become the polar coordinates `exp(-l)` and `a` of the plane. A tube is then an annulus without a seam, a
//! loop winds round the origin when it winds round the axis, and Delaunay triangles stay well shaped. A sphere is
//! pictured stereographically from the side away from the hole. All pictures show the surface from outside the
//! material, so that the material's loops keep their sense.

use crate::math::{Frame, Point3, Vec3, try_unit};
use crate::recognize::Primitive;
use crate::surface::Surface;
use std::f64::consts::{PI, TAU};

/// Largest isothermal coordinate that a picture may hold: beyond it `exp` leaves the range the triangulation takes.
const MAX_LOG: f64 = 90.0;

/// Which circle of a torus is the angle of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Round {
    Axis,
    Spine,
}

#[derive(Debug, Clone)]
enum Kind {
    Flat,
    Cylinder {
        radius: f64,
    },
    /// Frame at the apex.
    Cone {
        half_angle: f64,
    },
    /// Frame at the centre, `z` towards the middle of the picture.
    Sphere {
        radius: f64,
    },
    /// `middle` is the angle about the other circle that the picture is centred on.
    Torus {
        major: f64,
        minor: f64,
        round: Round,
        middle: f64,
    },
}

/// A picture of one surface.
#[derive(Debug, Clone)]
pub(super) struct Chart {
    frame: Frame,
    kind: Kind,
    outward: bool,
}

/// Point of the plane of a picture.
pub(super) type Flat = [f64; 2];

impl Chart {
    /// The picture of the surface of `primitive` around `points`; `None` when it has no surface.
    pub(super) fn new(primitive: &Primitive, points: &[Point3]) -> Option<Self> {
        let surface = primitive.surface.as_ref()?;
        let center = crate::math::centroid(points);
        let (frame, kind) = match surface {
            Surface::Plane(s) => (Frame::from_z(surface.project(&center), s.normal), Kind::Flat),
            Surface::Cylinder(s) => {
                (Frame::from_z(s.axis.foot(&center), s.axis.direction), Kind::Cylinder { radius: s.radius })
            }
            Surface::Cone(s) => {
                (Frame::from_z(s.apex(), s.axis.direction), Kind::Cone { half_angle: s.half_angle })
            }
            Surface::Sphere(s) => {
                let pole = try_unit(center - s.center).unwrap_or_else(Vec3::z_axis);
                (Frame::from_z(s.center, pole), Kind::Sphere { radius: s.radius })
            }
            Surface::Torus(s) => {
                let frame = Frame::from_z(s.axis.origin, s.axis.direction);
                (frame, torus_kind(&frame, s.major_radius, s.minor_radius, points))
            }
        };
        Some(Self { frame, kind, outward: primitive.outward })
    }

    /// Angle and isothermal coordinate of the projection of `point`; in-plane coordinates for a plane.
    fn natural(&self, point: &Point3) -> Flat {
        let q = self.frame.local(point);
        let angle = q.y.atan2(q.x);
        let radial = q.x.hypot(q.y);
        match self.kind {
            Kind::Flat => [q.x, q.y],
            Kind::Cylinder { radius } => [angle, q.z / radius],
            Kind::Cone { half_angle } => {
                let (sin, cos) = half_angle.sin_cos();
                let along = (q.z * cos + radial * sin).max(f64::MIN_POSITIVE);
                [-angle, -along.ln() / sin]
            }
            Kind::Sphere { .. } => {
                let tan_half = radial / (q.norm() + q.z).max(f64::MIN_POSITIVE);
                [angle, -tan_half.max(f64::MIN_POSITIVE).ln()]
            }
            Kind::Torus { major, minor, round, middle } => {
                let tube = q.z.atan2(radial - major);
                let ratio = minor / major.max(minor);
                match round {
                    Round::Axis => [angle, wrapped(tube - middle) * ratio],
                    Round::Spine => [tube, -wrapped(angle - middle) / ratio],
                }
            }
        }
    }

    /// Where the projection of `point` lies in the picture; `None` when out of its range.
    pub(super) fn flat(&self, point: &Point3) -> Option<Flat> {
        self.picture(self.natural(point))
    }

    fn picture(&self, natural: Flat) -> Option<Flat> {
        let [x, y] = match self.kind {
            Kind::Flat => natural,
            _ => {
                let [a, l] = natural;
                if !(l.abs() < MAX_LOG) {
                    return None;
                }
                let (sin, cos) = a.sin_cos();
                [(-l).exp() * cos, (-l).exp() * sin]
            }
        };
        Some([x, if self.outward { y } else { -y }])
    }

    /// Whether loops that wind round the origin of the picture enclose nothing of the surface there: all but the apex
    /// of a cone and the pole of a sphere.
    pub(super) fn is_endless_at_origin(&self) -> bool {
        matches!(self.kind, Kind::Cylinder { .. } | Kind::Torus { .. })
    }

    /// Pictures of the points of a loop, whose natural coordinates are averaged `n_smoothings` times with those of
    /// their neighbours along the loop; `None` when out of range.
    pub(super) fn flat_loop(&self, points: &[Point3], n_smoothings: usize) -> Option<Vec<Flat>> {
        let mut natural: Vec<Flat> = points.iter().map(|p| self.natural(p)).collect();
        let n = natural.len();
        for _ in 0..n_smoothings {
            natural = (0..n)
                .map(|i| {
                    let [before, here, after] = [natural[(i + n - 1) % n], natural[i], natural[(i + 1) % n]];
                    let step = |x: f64, y: f64| match self.kind {
                        Kind::Flat => x - y,
                        _ => wrapped(x - y),
                    };
                    let a = here[0] + 0.25 * (step(before[0], here[0]) + step(after[0], here[0]));
                    [a, 0.25 * (before[1] + 2.0 * here[1] + after[1])]
                })
                .collect();
        }
        natural.into_iter().map(|p| self.picture(p)).collect()
    }

    /// Points of the surface in rows `step` apart that cover what the loops of `points` span, with their pictures.
    pub(super) fn grid(&self, points: &[Point3], step: f64) -> Vec<(Point3, Flat)> {
        let locals: Vec<Vec3> = points.iter().map(|p| self.frame.local(p)).collect();
        let rows: Vec<(f64, f64)> = match self.kind {
            Kind::Flat => return self.flat_grid(&locals, step),
            Kind::Cylinder { radius } => {
                let (lo, hi) = range(locals.iter().map(|q| q.z));
                steps(lo, hi, step).into_iter().map(|z| (radius, z)).collect()
            }
            Kind::Cone { half_angle } => {
                let (sin, cos) = half_angle.sin_cos();
                let (lo, hi) = range(locals.iter().map(|q| q.z * cos + q.x.hypot(q.y) * sin));
                // A tip inside the loop is covered down to the apex.
                let lo = if lo < 2.0 * step { 0.0 } else { lo };
                let lo = if self.winds_apex(points) { 0.0 } else { lo };
                steps(lo.max(0.0), hi, step).into_iter().map(|s| (s * sin, s * cos)).collect()
            }
            Kind::Sphere { radius } => {
                let (_, hi) = range(locals.iter().map(|q| q.x.hypot(q.y).atan2(q.z)));
                let rows = steps(0.0, hi, step / radius);
                rows.into_iter().map(|t| (radius * t.sin(), radius * t.cos())).collect()
            }
            Kind::Torus { major, minor, round, middle } => {
                return self.torus_grid(&locals, step, (major, minor), round, middle);
            }
        };
        self.ring_grid(&rows, step)
    }

    fn winds_apex(&self, points: &[Point3]) -> bool {
        let n = points.len();
        let angles: Vec<f64> = points.iter().map(|p| self.natural(p)[0]).collect();
        let total: f64 = (0..n).map(|i| wrapped(angles[(i + 1) % n] - angles[i])).sum();
        total.abs() > PI
    }

    fn flat_grid(&self, locals: &[Vec3], step: f64) -> Vec<(Point3, Flat)> {
        let ((x0, x1), (y0, y1)) = (range(locals.iter().map(|q| q.x)), range(locals.iter().map(|q| q.y)));
        let mut found = Vec::new();
        for (row, y) in steps(y0, y1, step * ROW_PER_STEP).into_iter().enumerate() {
            for x in steps(x0, x1, step) {
                let point = self.frame.global(&Vec3::new(x + shift(row) * step, y, 0.0));
                found.extend(self.flat(&point).map(|flat| (point, flat)));
            }
        }
        found
    }

    /// Rings of the given (radius, height) about the frame's axis.
    fn ring_grid(&self, rows: &[(f64, f64)], step: f64) -> Vec<(Point3, Flat)> {
        let mut found = Vec::new();
        for (row, &(radius, height)) in rows.iter().enumerate() {
            let n = (TAU * radius / step).round().max(1.0).min(MAX_RING) as usize;
            for i in 0..n {
                let (sin, cos) = (TAU * (i as f64 + shift(row)) / n as f64).sin_cos();
                let point = self.frame.global(&Vec3::new(radius * cos, radius * sin, height));
                found.extend(self.flat(&point).map(|flat| (point, flat)));
            }
        }
        found
    }

    fn torus_grid(
        &self,
        locals: &[Vec3],
        step: f64,
        (major, minor): (f64, f64),
        round: Round,
        middle: f64,
    ) -> Vec<(Point3, Flat)> {
        let tube = |q: &Vec3| q.z.atan2(q.x.hypot(q.y) - major);
        let (lo, hi) = match round {
            Round::Axis => range(locals.iter().map(|q| wrapped(tube(q) - middle))),
            Round::Spine => (-PI, PI),
        };
        let rows: Vec<(f64, f64)> = steps(lo, hi, step / minor)
            .into_iter()
            .map(|v| (major + minor * (v + middle).cos(), minor * (v + middle).sin()))
            .filter(|row| row.0 > 0.0)
            .collect();
        self.ring_grid(&rows, step)
    }
}

/// Height of a row of equilateral triangles, per side.
const ROW_PER_STEP: f64 = 0.866;
/// A ring or row never holds more points: protects memory when a radius is absurd for the spacing.
const MAX_RING: f64 = 4000.0;

/// Every other row is shifted by half a step.
fn shift(row: usize) -> f64 {
    if row % 2 == 0 { 0.0 } else { 0.5 }
}

/// From `lo` to `hi` in equal steps near `step`.
fn steps(lo: f64, hi: f64, step: f64) -> Vec<f64> {
    let n = ((hi - lo) / step).ceil();
    if !n.is_finite() || n < 0.0 {
        return Vec::new();
    }
    let n = n.clamp(1.0, MAX_RING) as usize;
    (0..=n).map(|i| lo + (hi - lo) * i as f64 / n as f64).collect()
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)))
}

/// The angle in [-pi, pi) equal to `angle` up to full turns.
pub(super) fn wrapped(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

/// Sum of the steps of `angles` along a closed loop, in turns.
pub(super) fn turns(angles: &[f64]) -> i32 {
    let n = angles.len();
    let total: f64 = (0..n).map(|i| wrapped(angles[(i + 1) % n] - angles[i])).sum();
    (total / TAU).round() as i32
}

fn torus_kind(frame: &Frame, major: f64, minor: f64, points: &[Point3]) -> Kind {
    let tubes: Vec<f64> = points
        .iter()
        .map(|p| {
            let q = frame.local(p);
            q.z.atan2(q.x.hypot(q.y) - major)
        })
        .collect();
    let angles: Vec<f64> = points
        .iter()
        .map(|p| {
            let q = frame.local(p);
            q.y.atan2(q.x)
        })
        .collect();
    let spans_tube = largest_gap(&tubes).1;
    let spans_axis = largest_gap(&angles).1;
    // The circle with the wider empty arc is unrolled, cut in the middle of that arc.
    let (round, cut) = if spans_tube >= spans_axis {
        (Round::Axis, largest_gap(&tubes).0)
    } else {
        (Round::Spine, largest_gap(&angles).0)
    };
    Kind::Torus { major, minor, round, middle: wrapped(cut + PI) }
}

/// Middle and width of the widest arc free of `angles`.
fn largest_gap(angles: &[f64]) -> (f64, f64) {
    let mut sorted = angles.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some((&first, &last)) = sorted.first().zip(sorted.last()) else { return (PI, TAU) };
    let around = (last + 0.5 * (first + TAU - last), first + TAU - last);
    sorted
        .windows(2)
        .map(|pair| (0.5 * (pair[0] + pair[1]), pair[1] - pair[0]))
        .fold(around, |best, gap| if gap.1 > best.1 { gap } else { best })
}
