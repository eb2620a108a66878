//! A surface with its two parameters, both ways.

use super::curve::{Curve, MOST_TURN, nearest};
use super::nurbs::NurbsSurface;
use crate::math::{Frame, Point3, Vec3, try_unit};
use crate::surface::Surface;

/// A point of the parameter plane.
pub(super) type Uv = [f64; 2];

/// A surface as the file parametrizes it. Directions of the first and second parameter, in this order, turn
/// counter-clockwise about the file's normal unless it is `mirrored`.
#[derive(Debug, Clone)]
pub(super) struct Patch {
    pub(super) shape: Shape,
    pub(super) frame: Frame,
    /// The surface, when it is one of the five.
    pub(super) analytic: Option<Surface>,
    /// Lengths after which the parameters come back.
    pub(super) periods: [Option<f64>; 2],
    /// Lowest and highest second parameter where the surface ends in one point.
    pub(super) poles: [Option<(f64, Point3)>; 2],
    /// Whether the parameters were exchanged.
    pub(super) mirrored: bool,
}

/// What a patch is.
#[derive(Debug, Clone)]
pub(super) enum Shape {
    Plane,
    Cylinder {
        radius: f64,
    },
    /// `below`: the nappe where `radius + v * slope` is negative.
    Cone {
        radius: f64,
        slope: f64,
        below: bool,
    },
    Sphere {
        radius: f64,
    },
    /// `lemon`: the inner part of a spindle.
    Torus {
        major: f64,
        minor: f64,
        lemon: bool,
    },
    /// `curve(u) + v * direction`.
    Extrusion {
        curve: Curve,
        direction: Vec3,
        starts: Vec<(f64, Point3)>,
    },
    /// `curve(v)` turned by `u` about the frame's third direction.
    Revolution {
        curve: Curve,
        starts: Vec<(f64, Point3)>,
    },
    Spline {
        surface: NurbsSurface,
        starts: Vec<(Point3, Uv)>,
        size: f64,
    },
}

impl Patch {
    /// The point and the derivatives by both parameters.
    pub(super) fn jet(&self, [u, v]: Uv) -> (Point3, Vec3, Vec3) {
        let frame = &self.frame;
        let vector = |x: f64, y: f64, z: f64| {
            frame.x.into_inner() * x + frame.y.into_inner() * y + frame.z.into_inner() * z
        };
        let (sin, cos) = u.sin_cos();
        // A profile of radius and height, with their derivatives, turned about the third direction.
        let turned = |(r, h): (f64, f64), (dr, dh): (f64, f64)| {
            (
                frame.origin + vector(r * cos, r * sin, h),
                vector(-r * sin, r * cos, 0.0),
                vector(dr * cos, dr * sin, dh),
            )
        };
        match &self.shape {
            Shape::Plane => (frame.origin + vector(u, v, 0.0), vector(1.0, 0.0, 0.0), vector(0.0, 1.0, 0.0)),
            Shape::Cylinder { radius } => turned((*radius, v), (0.0, 1.0)),
            Shape::Cone { radius, slope, .. } => turned((radius + v * slope, v), (*slope, 1.0)),
            Shape::Sphere { radius } => {
                let (s, c) = v.sin_cos();
                turned((radius * c, radius * s), (-radius * s, radius * c))
            }
            Shape::Torus { major, minor, .. } => {
                let (s, c) = v.sin_cos();
                turned((major + minor * c, minor * s), (-minor * s, minor * c))
            }
            Shape::Extrusion { curve, direction, .. } => {
                let (p, d, _) = curve.jet(curve.wrapped(u));
                (p + direction * v, d, *direction)
            }
            Shape::Revolution { curve, .. } => {
                let (p, d, _) = curve.jet(curve.wrapped(v));
                let (l, e) = (frame.local(&p), Vec3::new(d.dot(&frame.x), d.dot(&frame.y), d.dot(&frame.z)));
                let turn = |w: &Vec3| vector(w.x * cos - w.y * sin, w.x * sin + w.y * cos, w.z);
                let turn_slope = |w: &Vec3| vector(-w.x * sin - w.y * cos, w.x * cos - w.y * sin, 0.0);
                (frame.origin + turn(&l), turn_slope(&l), turn(&e))
            }
            Shape::Spline { surface, .. } => surface.jet(self.wrapped(0, u), self.wrapped(1, v)),
        }
    }

    pub(super) fn point(&self, uv: Uv) -> Point3 {
        self.jet(uv).0
    }

    /// A plane by its frame.
    pub(super) fn plane(frame: Frame) -> Self {
        let surface = Surface::Plane(crate::surface::Plane { point: frame.origin, normal: frame.z });
        Self {
            shape: Shape::Plane,
            frame,
            analytic: Some(surface),
            periods: [None; 2],
            poles: [None; 2],
            mirrored: false,
        }
    }

    /// The same sphere about other axes.
    pub(super) fn turned(&self) -> Vec<Self> {
        let Shape::Sphere { radius } = self.shape else { return Vec::new() };
        let Frame { origin, x, y, z } = self.frame;
        let diagonal = crate::math::UnitVec3::new_normalize(x.into_inner() + y.into_inner() + z.into_inner());
        let across =
            crate::math::UnitVec3::new_normalize(x.into_inner() - y.into_inner() * 2.0 + z.into_inner());
        let frames = [x, y, diagonal, across].map(|axis| Frame::from_z(origin, axis));
        frames.map(|frame| super::surface::sphere(frame, radius)).to_vec()
    }

    /// Points that tell the extent of a surface that is closed by itself.
    pub(super) fn extent(&self) -> Vec<Point3> {
        let reach = match &self.shape {
            Shape::Sphere { radius } => *radius,
            Shape::Torus { major, minor, .. } => major + minor,
            Shape::Spline { starts, .. } => return starts.iter().map(|(p, _)| *p).collect(),
            _ => return Vec::new(),
        };
        let axes = [self.frame.x, self.frame.y, self.frame.z].map(crate::math::UnitVec3::into_inner);
        axes.iter().flat_map(|d| [self.frame.origin + d * reach, self.frame.origin - d * reach]).collect()
    }

    /// Unit normal of its parameters; `None` where the parameters are singular.
    pub(super) fn normal(&self, uv: Uv) -> Option<Vec3> {
        let (_, by_u, by_v) = self.jet(uv);
        try_unit(by_u.cross(&by_v)).map(crate::math::UnitVec3::into_inner)
    }

    /// A spline's parameter brought into its range.
    fn wrapped(&self, i: usize, t: f64) -> f64 {
        let (Shape::Spline { surface, .. }, Some(period)) = (&self.shape, self.periods[i]) else { return t };
        let (low, high) = if i == 0 { surface.u.range() } else { surface.v.range() };
        if (low..=high).contains(&t) { t } else { low + (t - low).rem_euclid(period) }
    }

    /// Parameters of the point nearest to `p`; `hint`: those of a point beside it.
    pub(super) fn uv(&self, p: &Point3, hint: Option<Uv>) -> Uv {
        let local = self.frame.local(p);
        let (rho, around) = (local.x.hypot(local.y), local.y.atan2(local.x));
        let opposite = (-local.y).atan2(-local.x);
        match &self.shape {
            Shape::Plane => [local.x, local.y],
            Shape::Cylinder { .. } => [around, local.z],
            Shape::Cone { radius, slope, below } => {
                let signed = if *below { -rho } else { rho };
                // The foot on the generator, not the height: points may lie a little beside the surface.
                let v = (local.z + slope * (signed - radius)) / (1.0 + slope * slope);
                [if *below { opposite } else { around }, v]
            }
            Shape::Sphere { .. } => [around, local.z.atan2(rho)],
            Shape::Torus { major, lemon: false, .. } => [around, local.z.atan2(rho - major)],
            Shape::Torus { major, lemon: true, .. } => {
                [opposite, local.z.atan2(-rho - major).rem_euclid(std::f64::consts::TAU)]
            }
            Shape::Extrusion { curve, direction, starts } => {
                let along = direction.normalize();
                let across = |w: &Vec3| w - along * w.dot(&along);
                let u = nearest(starts, |t| {
                    let (q, d, dd) = curve.jet(t);
                    let (off, d, dd) = (across(&(q - p)), across(&d), across(&dd));
                    (off.norm_squared(), off.dot(&d), d.norm_squared() + off.dot(&dd))
                });
                [u, (p - curve.point(u)).dot(direction) / direction.norm_squared()]
            }
            Shape::Revolution { curve, starts } => {
                let v = nearest(starts, |t| self.profile_distance(curve, t, (rho, local.z)));
                let on_curve = self.frame.local(&curve.point(v));
                let u = around - on_curve.y.atan2(on_curve.x);
                [u, v]
            }
            Shape::Spline { surface, starts, size } => self.project(surface, starts, *size, p, hint),
        }
    }

    /// Squared distance in the plane of radius and height, half its slope and half its bend (of Gauss and Newton).
    fn profile_distance(&self, curve: &Curve, t: f64, (rho, height): (f64, f64)) -> (f64, f64, f64) {
        let (q, d, _) = curve.jet(t);
        let l = self.frame.local(&q);
        let (dx, dy, dz) = (d.dot(&self.frame.x), d.dot(&self.frame.y), d.dot(&self.frame.z));
        let r = l.x.hypot(l.y);
        let dr = if r > 0.0 { (l.x * dx + l.y * dy) / r } else { dx.hypot(dy) };
        let (off_r, off_h) = (r - rho, l.z - height);
        (off_r * off_r + off_h * off_h, off_r * dr + off_h * dz, dr * dr + dz * dz)
    }

    fn project(
        &self,
        surface: &NurbsSurface,
        starts: &[(Point3, Uv)],
        size: f64,
        p: &Point3,
        hint: Option<Uv>,
    ) -> Uv {
        /// Starts that are followed when the hint leads astray.
        const FOLLOWED: usize = 4;
        /// Share of the size within which a point is on the surface.
        const ON: f64 = 1e-5;
        let off = |uv: Uv| (self.point(uv) - p).norm();
        let hinted = hint.map(|h| self.descend(surface, h, p)).map(|uv| (off(uv), uv));
        if let Some((distance, uv)) = hinted
            && distance <= ON * size
        {
            return uv;
        }
        let mut near: Vec<(f64, usize)> =
            starts.iter().enumerate().map(|(i, (q, _))| ((q - p).norm_squared(), i)).collect();
        let n = FOLLOWED.min(near.len());
        near.select_nth_unstable_by(n - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near[..n].sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let found =
            near[..n].iter().map(|(_, i)| self.descend(surface, starts[*i].1, p)).map(|uv| (off(uv), uv));
        let best = found.chain(hinted).min_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or([0.0, 0.0], |(_, uv)| uv)
    }

    /// Gauss and Newton's steps to the nearest point of a spline, held within its range.
    fn descend(&self, surface: &NurbsSurface, start: Uv, p: &Point3) -> Uv {
        const STEPS: usize = 30;
        /// Of a parameter: a thousand roundings, below which a step is none.
        const ROUNDING: f64 = 1e-13;
        /// Squared sine of the angle between the two directions below which they are one, a millionth.
        const SINGULAR: f64 = 1e-12;
        let ranges = [surface.u.range(), surface.v.range()];
        let held = |i: usize, t: f64| match self.periods[i] {
            Some(_) => t,
            None => t.clamp(ranges[i].0, ranges[i].1),
        };
        let mut uv = [held(0, start[0]), held(1, start[1])];
        for _ in 0..STEPS {
            let (q, by_u, by_v) = self.jet(uv);
            let off = p - q;
            let (a, b, c) = (by_u.norm_squared(), by_u.dot(&by_v), by_v.norm_squared());
            let (f, g) = (off.dot(&by_u), off.dot(&by_v));
            let det = a * c - b * b;
            // Where the directions are one, as at a pole, each parameter by itself.
            let singular = det <= SINGULAR * a * c;
            let mut step = if singular {
                [if a > 0.0 { f / a } else { 0.0 }, if c > 0.0 { g / c } else { 0.0 }]
            } else {
                [(f * c - g * b) / det, (g * a - f * b) / det]
            };
            // At the end of a range the other parameter goes on alone.
            for i in 0..2 {
                let (low, high) = ranges[i];
                let out = self.periods[i].is_none()
                    && ((uv[i] <= low && step[i] < 0.0) || (uv[i] >= high && step[i] > 0.0));
                if out {
                    step[i] = 0.0;
                    step[1 - i] = if i == 0 && c > 0.0 {
                        g / c
                    } else if i == 1 && a > 0.0 {
                        f / a
                    } else {
                        0.0
                    };
                }
            }
            let next = [held(0, uv[0] + step[0]), held(1, uv[1] + step[1])];
            let moved = (0..2).all(|i| (next[i] - uv[i]).abs() <= ROUNDING * (ranges[i].1 - ranges[i].0));
            uv = next;
            if moved {
                break;
            }
        }
        uv
    }

    /// Steps of both parameters within which chords stay within `tolerance`, over the given range.
    pub(super) fn steps(&self, low: Uv, high: Uv, tolerance: f64) -> Uv {
        let arc = |radius: f64| (8.0 * tolerance / radius.max(f64::MIN_POSITIVE)).sqrt().min(MOST_TURN);
        let whole = [0, 1].map(|i| (high[i] - low[i]).max(f64::MIN_POSITIVE));
        match &self.shape {
            Shape::Plane => whole,
            Shape::Cylinder { radius } => [arc(*radius), whole[1]],
            Shape::Cone { radius, slope, .. } => {
                let widest = [low[1], high[1]].iter().map(|v| (radius + v * slope).abs()).fold(0.0, f64::max);
                [arc(widest), whole[1]]
            }
            Shape::Sphere { radius } => [arc(*radius); 2],
            Shape::Torus { major, minor, .. } => {
                // Round a thin tube chords must not be so long that its triangles stand across it (the lantern of
                // H. A. Schwarz): a hundredth of the tube's radius is a tenth of the steps across.
                let round = (8.0 * tolerance.min(0.01 * minor) / (major + minor)).sqrt().min(MOST_TURN);
                [round, arc(*minor)]
            }
            Shape::Extrusion { .. } => [self.measured(0, low, high, tolerance), whole[1]],
            Shape::Revolution { .. } | Shape::Spline { .. } => {
                [0, 1].map(|i| self.measured(i, low, high, tolerance))
            }
        }
    }

    /// A step of parameter `i`, from the bends seen on a grid.
    fn measured(&self, i: usize, low: Uv, high: Uv, tolerance: f64) -> f64 {
        const GRID: usize = 12;
        let range = high[i] - low[i];
        let h = range / GRID as f64;
        let mut sharpest = 0.0_f64;
        let mut most_turn = 0.0_f64;
        for k in 0..=GRID / 2 {
            let mut uv = low;
            uv[1 - i] = low[1 - i] + (high[1 - i] - low[1 - i]) * (k as f64 / (GRID / 2) as f64);
            let at = |t: f64| {
                let mut uv = uv;
                uv[i] = t;
                uv
            };
            for j in 0..GRID {
                let t = low[i] + h * (j as f64 + 0.5);
                let ends = [at(t - 0.5 * h), at(t), at(t + 0.5 * h)];
                let [Some(before), Some(normal), Some(after)] = ends.map(|uv| self.normal(uv)) else {
                    continue;
                };
                let [a, b, c] = ends.map(|uv| self.point(uv));
                let sagitta = ((a.coords + c.coords) * 0.5 - b.coords).dot(&normal).abs();
                sharpest = sharpest.max(sagitta);
                most_turn = most_turn.max(crate::math::angle_between(&before, &after));
            }
        }
        let by_chord = h * (tolerance / sharpest.max(f64::MIN_POSITIVE)).sqrt();
        let by_turn = h * MOST_TURN / most_turn.max(f64::MIN_POSITIVE);
        by_chord.min(by_turn).min(range.max(f64::MIN_POSITIVE))
    }
}
