//! Curves of edges, and how samples are recognised as one.
//!
//! No table of surface pairs: samples of an intersection are computed numerically and then recognised as a line, a
//! circle or an ellipse when they are one within a tolerance, else interpolated by a cubic B-spline. The recognition is
//! exact where the surfaces are (two planes, coaxial surfaces of revolution) and harmless where they are not.

use crate::math::{Frame, Point3, UnitVec3, Vec3, centroid, nearest_circle, principal_axes, try_unit};
use crate::surface::bspline::SplineCurve;

/// A curve. Its parameter increases along the edge that carries it.
#[derive(Debug, Clone, PartialEq)]
pub enum Curve {
    /// A straight line.
    Line {
        /// A point of it.
        origin: Point3,
        /// Its direction.
        direction: UnitVec3,
    },
    /// A circle, counter-clockwise about the third direction of its frame.
    Circle {
        /// Centre and plane.
        frame: Frame,
        /// Radius, length.
        radius: f64,
    },
    /// An ellipse, counter-clockwise about the third direction of its frame, the long semi-axis along the first.
    Ellipse {
        /// Centre, plane and direction of the long axis.
        frame: Frame,
        /// Long and short semi-axis, length.
        semi_axes: (f64, f64),
    },
    /// A clamped cubic B-spline that begins and ends with the edge.
    Spline(SplineCurve),
}

impl Curve {
    /// The line, circle or ellipse that stays within `tolerance` of all `samples`, else the spline through them.
    ///
    /// `samples`: in order along the edge, ends included, at least five. `None` when neighbouring samples coincide.
    pub fn recognize(samples: &[Point3], tolerance: f64) -> Option<Self> {
        line(samples, tolerance)
            .or_else(|| circle(samples, tolerance))
            .or_else(|| ellipse(samples, tolerance))
            .or_else(|| SplineCurve::interpolate(samples).map(Self::Spline))
    }

    /// Name for people and files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Line { .. } => "line",
            Self::Circle { .. } => "circle",
            Self::Ellipse { .. } => "ellipse",
            Self::Spline(_) => "spline",
        }
    }

    /// Distance from `point` to the curve, for a spline to its nearer end: vertices are only held against ends.
    pub fn distance_to_end(&self, point: &Point3) -> f64 {
        match self {
            Self::Line { origin, direction } => (point - origin).cross(direction).norm(),
            Self::Circle { frame, radius } => {
                let local = frame.local(point);
                (local.x.hypot(local.y) - radius).hypot(local.z)
            }
            Self::Ellipse { frame, semi_axes: (a, b) } => {
                let local = frame.local(point);
                let angle = (local.y / b).atan2(local.x / a);
                (local - Vec3::new(a * angle.cos(), b * angle.sin(), 0.0)).norm()
            }
            Self::Spline(spline) => {
                let ends = [spline.poles[0], spline.poles[spline.poles.len() - 1]];
                ends.iter().map(|end| (point - end).norm()).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// `n + 1` points from `start` to `end`, both exactly included, in the direction of the parameter.
    pub fn sample(&self, start: &Point3, end: &Point3, n: usize) -> Vec<Point3> {
        let n = n.max(1);
        let mut points = Vec::with_capacity(n + 1);
        points.push(*start);
        let span = |frame: &Frame, a: f64, b: f64| {
            let angle = |p: &Point3| {
                let local = frame.local(p);
                (local.y / b).atan2(local.x / a)
            };
            let from = angle(start);
            let sweep = (angle(end) - from).rem_euclid(std::f64::consts::TAU);
            (from, if sweep > 0.0 { sweep } else { std::f64::consts::TAU })
        };
        for i in 1..n {
            let t = i as f64 / n as f64;
            points.push(match self {
                Self::Line { .. } => start + (end - start) * t,
                Self::Circle { frame, radius } => {
                    let (from, sweep) = span(frame, 1.0, 1.0);
                    let (sin, cos) = (from + sweep * t).sin_cos();
                    frame.global(&Vec3::new(radius * cos, radius * sin, 0.0))
                }
                Self::Ellipse { frame, semi_axes: (a, b) } => {
                    let (from, sweep) = span(frame, *a, *b);
                    let (sin, cos) = (from + sweep * t).sin_cos();
                    frame.global(&Vec3::new(a * cos, b * sin, 0.0))
                }
                Self::Spline(spline) => spline.point(t),
            });
        }
        points.push(*end);
        points
    }

    /// Angle swept from `start` to `end` by a circle or ellipse; zero for the others.
    pub fn sweep(&self, start: &Point3, end: &Point3) -> f64 {
        let (frame, a, b) = match self {
            Self::Circle { frame, .. } => (frame, 1.0, 1.0),
            Self::Ellipse { frame, semi_axes: (a, b) } => (frame, *a, *b),
            Self::Line { .. } | Self::Spline(_) => return 0.0,
        };
        let angle = |p: &Point3| {
            let local = frame.local(p);
            (local.y / b).atan2(local.x / a)
        };
        (angle(end) - angle(start)).rem_euclid(std::f64::consts::TAU)
    }
}

/// The line through the first and the last sample, when all are within `tolerance` of it.
fn line(samples: &[Point3], tolerance: f64) -> Option<Curve> {
    let (first, last) = (samples.first()?, samples.last()?);
    let direction = try_unit(last - first)?;
    let close = samples.iter().all(|p| (p - first).cross(&direction).norm() <= tolerance);
    close.then_some(Curve::Line { origin: *first, direction })
}

/// The least-squares circle in the best plane, when all samples are within `tolerance` of it.
fn circle(samples: &[Point3], tolerance: f64) -> Option<Curve> {
    let frame = oriented_plane(samples, tolerance)?;
    let flat = samples.iter().map(|sample| frame.local(sample)).map(|p| (1.0, p.x, p.y));
    let ([x, y], radius) = nearest_circle(flat)?;
    let middle = Vec3::new(x, y, 0.0);
    let center = frame.global(&middle);
    let x = try_unit(frame.local(&samples[0]).xy().push(0.0) - middle)?;
    let x = UnitVec3::new_normalize(frame.x.into_inner() * x.x + frame.y.into_inner() * x.y);
    let frame = Frame { origin: center, x, y: UnitVec3::new_normalize(frame.z.cross(&x)), z: frame.z };
    let curve = Curve::Circle { frame, radius };
    let close = samples.iter().all(|p| curve.distance_to_end(p) <= tolerance);
    (close && runs_forward(&frame, 1.0, 1.0, samples)).then_some(curve)
}

/// The least-squares conic in the best plane, when it is an ellipse within `tolerance` of all samples.
fn ellipse(samples: &[Point3], tolerance: f64) -> Option<Curve> {
    /// A longer ellipse is a bad fit of something else.
    const MAX_ASPECT: f64 = 20.0;
    let plane = oriented_plane(samples, tolerance)?;
    let locals: Vec<Vec3> = samples.iter().map(|p| plane.local(p)).collect();
    let scale = locals.iter().map(Vec3::norm).fold(0.0, f64::max);
    let (mut ata, mut atb) = (nalgebra::SMatrix::<f64, 5, 5>::zeros(), nalgebra::SVector::<f64, 5>::zeros());
    for local in &locals {
        let (x, y) = (local.x / scale, local.y / scale);
        let row = nalgebra::SVector::<f64, 5>::from([x * x, x * y, y * y, x, y]);
        ata += row * row.transpose();
        atb += row;
    }
    let q = ata.try_inverse()? * atb;
    let det = 4.0 * q[0] * q[2] - q[1] * q[1];
    if det.is_nan() || det <= 0.0 {
        return None;
    }
    let (cx, cy) = ((q[1] * q[4] - 2.0 * q[2] * q[3]) / det, (q[1] * q[3] - 2.0 * q[0] * q[4]) / det);
    let right = 1.0 + q[0] * cx * cx + q[1] * cx * cy + q[2] * cy * cy;
    let turn = 0.5 * q[1].atan2(q[0] - q[2]);
    let (sin, cos) = turn.sin_cos();
    let along = (q[0] * cos * cos + q[1] * cos * sin + q[2] * sin * sin) / right;
    let beside = (q[0] * sin * sin - q[1] * cos * sin + q[2] * cos * cos) / right;
    if !(along > 0.0 && beside > 0.0) {
        return None;
    }
    let (mut a, mut b) = (scale / along.sqrt(), scale / beside.sqrt());
    let mut x = plane.x.into_inner() * cos + plane.y.into_inner() * sin;
    if a < b {
        (a, b) = (b, a);
        x = plane.z.cross(&x);
    }
    let x = UnitVec3::new_normalize(x);
    let origin = plane.global(&Vec3::new(cx * scale, cy * scale, 0.0));
    let frame = Frame { origin, x, y: UnitVec3::new_normalize(plane.z.cross(&x)), z: plane.z };
    let curve = Curve::Ellipse { frame, semi_axes: (a, b) };
    let close = a <= MAX_ASPECT * b && samples.iter().all(|p| curve.distance_to_end(p) <= tolerance);
    (close && runs_forward(&frame, a, b, samples)).then_some(curve)
}

/// Best plane of the samples, its normal such that they run counter-clockwise; `None` when they leave it.
fn oriented_plane(samples: &[Point3], tolerance: f64) -> Option<Frame> {
    let center = centroid(samples);
    let [(_, mut z), _, (_, x)] = principal_axes(samples, center);
    if samples.iter().any(|p| (p - center).dot(&z).abs() > tolerance) {
        return None;
    }
    // Counter-clockwise: turning at every corner of the polyline, summed.
    let turning: f64 = samples.windows(3).map(|w| (w[1] - w[0]).cross(&(w[2] - w[1])).dot(&z)).sum();
    if turning < 0.0 {
        z = -z;
    }
    let y = try_unit(z.cross(&x))?;
    Some(Frame { origin: center, x, y, z })
}

/// Whether the angle grows from sample to sample and by less than a full turn in all.
fn runs_forward(frame: &Frame, a: f64, b: f64, samples: &[Point3]) -> bool {
    let angles: Vec<f64> = samples
        .iter()
        .map(|p| {
            let local = frame.local(p);
            (local.y / b).atan2(local.x / a)
        })
        .collect();
    let mut total = 0.0;
    for pair in angles.windows(2) {
        let step = (pair[1] - pair[0]).rem_euclid(std::f64::consts::TAU);
        if step > std::f64::consts::PI {
            return false;
        }
        total += step;
    }
    total < std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(f: impl Fn(f64) -> Point3) -> Vec<Point3> {
        (0..=20).map(|i| f(f64::from(i) * 0.2)).collect()
    }

    #[test]
    fn an_arc_is_recognised_and_runs_the_right_way_round() {
        for sign in [1.0, -1.0] {
            let samples = arc(|t| Point3::new(3.0 * t.cos(), sign * 3.0 * t.sin(), 7.0));
            let Some(Curve::Circle { frame, radius }) = Curve::recognize(&samples, 1e-9) else {
                panic!("no circle");
            };
            assert!((radius - 3.0).abs() < 1e-12, "radius {radius}");
            assert!((frame.z.z - sign).abs() < 1e-12, "axis {}", frame.z.z);
        }
    }

    #[test]
    fn an_ellipse_is_recognised_and_sampled_back() {
        let samples = arc(|t| Point3::new(3.0 * t.cos(), 1.0, 1.5 * t.sin()));
        let curve = Curve::recognize(&samples, 1e-9).unwrap();
        assert_eq!(curve.name(), "ellipse");
        let back = curve.sample(&samples[0], &samples[20], 40);
        let off = (back[20] - samples[10]).norm();
        assert!(off < 1e-9, "off by {off}");
    }

    #[test]
    fn a_helix_becomes_a_spline() {
        let samples = arc(|t| Point3::new(t.cos(), t.sin(), t));
        assert_eq!(Curve::recognize(&samples, 1e-6).unwrap().name(), "spline");
    }
}
