//! Lines and circles of the profile's plane, and where they meet.

use super::sweep::Point2;

/// An unbounded curve of the profile's plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Curve {
    Line { point: Point2, direction: Point2 },
    Circle { center: Point2, radius: f64 },
}

impl Curve {
    /// Signed distance of a point: left of a line, outside of a circle.
    pub(super) fn distance(&self, p: &Point2) -> f64 {
        match self {
            Self::Line { point, direction } => cross(direction, &(p - point)),
            Self::Circle { center, radius } => (p - center).norm() - radius,
        }
    }

    /// Where a point lies along the curve: a length of a line, an angle in [0, 2 pi) of a circle.
    pub(super) fn parameter(&self, p: &Point2) -> f64 {
        match self {
            Self::Line { point, direction } => direction.dot(&(p - point)),
            Self::Circle { center, .. } => {
                let from = p - center;
                from.y.atan2(from.x).rem_euclid(std::f64::consts::TAU)
            }
        }
    }

    /// The point at a parameter.
    pub(super) fn at(&self, parameter: f64) -> Point2 {
        match self {
            Self::Line { point, direction } => point + direction * parameter,
            Self::Circle { center, radius } => {
                center + Point2::new(parameter.cos(), parameter.sin()) * *radius
            }
        }
    }

    /// Whether two curves are one within `tolerance`, where the first is of interest: between `low` and `high`.
    pub(super) fn is_same(&self, other: &Self, ends: [Point2; 2], tolerance: f64) -> bool {
        match (self, other) {
            (Self::Line { .. }, Self::Line { .. }) => {
                ends.iter().all(|end| other.distance(end).abs() <= tolerance)
            }
            (Self::Circle { center: a, radius: r }, Self::Circle { center: b, radius: s }) => {
                (a - b).norm() <= tolerance && (r - s).abs() <= tolerance
            }
            _ => false,
        }
    }

    /// Points that two curves share. Curves that touch or nearly do share one point: noise has parted them, or has let
    /// them cross twice where the part has one tangent.
    pub(super) fn meets(&self, other: &Self, tolerance: f64) -> Vec<Point2> {
        match (self, other) {
            (Self::Line { point: p, direction: d }, Self::Line { point: q, direction: e }) => {
                let sine = cross(d, e);
                if sine == 0.0 { Vec::new() } else { vec![p + d * (cross(&(q - p), e) / sine)] }
            }
            (Self::Line { point, direction }, Self::Circle { center, radius })
            | (Self::Circle { center, radius }, Self::Line { point, direction }) => {
                line_and_circle(point, direction, center, *radius, tolerance)
            }
            (Self::Circle { center: a, radius: r }, Self::Circle { center: b, radius: s }) => {
                circles(a, *r, b, *s, tolerance)
            }
        }
    }
}

fn line_and_circle(
    point: &Point2,
    direction: &Point2,
    center: &Point2,
    radius: f64,
    tolerance: f64,
) -> Vec<Point2> {
    let foot = point + direction * direction.dot(&(center - point));
    let off = (foot - center).norm();
    if (off - radius).abs() <= tolerance && off > 0.0 {
        let touching = center + (foot - center) * (radius / off);
        return vec![(foot + touching) * 0.5];
    }
    if off > radius {
        return Vec::new();
    }
    let half = (radius * radius - off * off).sqrt();
    vec![foot - direction * half, foot + direction * half]
}

fn circles(a: &Point2, r: f64, b: &Point2, s: f64, tolerance: f64) -> Vec<Point2> {
    let between = b - a;
    let distance = between.norm();
    if distance <= tolerance {
        return Vec::new();
    }
    let along = between / distance;
    // Touching from outside, or one inside the other: the middle of where each has its nearest point.
    if (distance - r - s).abs() <= tolerance {
        return vec![(a + along * r + b - along * s) * 0.5];
    }
    if (distance - (r - s).abs()).abs() <= tolerance {
        let side = if r > s { 1.0 } else { -1.0 };
        return vec![(a + along * (side * r) + b + along * (side * s)) * 0.5];
    }
    if distance > r + s || distance < (r - s).abs() {
        return Vec::new();
    }
    let x = (distance * distance + r * r - s * s) / (2.0 * distance);
    let y = (r * r - x * x).max(0.0).sqrt();
    let across = Point2::new(-along.y, along.x);
    vec![a + along * x - across * y, a + along * x + across * y]
}

/// Third component of the cross product.
pub(super) fn cross(a: &Point2, b: &Point2) -> f64 {
    a.x * b.y - a.y * b.x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_that_nearly_touch_share_one_point() {
        let line = Curve::Line { point: Point2::new(0.0, 0.0), direction: Point2::new(1.0, 0.0) };
        for lift in [-0.01, 0.0, 0.01] {
            let circle = Curve::Circle { center: Point2::new(3.0, 2.0 + lift), radius: 2.0 };
            let meets = line.meets(&circle, 0.02);
            assert_eq!(meets.len(), 1);
            assert!((meets[0] - Point2::new(3.0, 0.0)).norm() < 0.011, "{}", meets[0]);
            let inner = Curve::Circle { center: Point2::new(3.0, 1.5 + lift), radius: 1.5 };
            let outer = Curve::Circle { center: Point2::new(3.0, 2.0), radius: 2.0 };
            let meets = inner.meets(&outer, 0.02);
            assert_eq!(meets.len(), 1);
            assert!((meets[0] - Point2::new(3.0, 0.0)).norm() < 0.011, "{}", meets[0]);
        }
    }

    #[test]
    fn curves_meet_on_both() {
        let circle = Curve::Circle { center: Point2::new(1.0, 2.0), radius: 3.0 };
        let others = [
            Curve::Line { point: Point2::new(0.0, 1.0), direction: Point2::new(0.6, 0.8) },
            Curve::Circle { center: Point2::new(4.0, 1.0), radius: 2.0 },
        ];
        for other in others {
            let meets = other.meets(&circle, 1e-6);
            assert_eq!(meets.len(), 2);
            for p in meets {
                assert!(circle.distance(&p).abs() < 1e-12 && other.distance(&p).abs() < 1e-12);
            }
        }
    }
}
