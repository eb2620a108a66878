//! The surface that a ball of one radius leaves as it rolls along two others, a cylinder or a torus; and that of a flat
//! that breaks their edge, a plane or a cone.
//!
//! It is one of the five only where both surfaces sweep the same section along a line or about an axis; other pairs
//! have no analytic fillet or chamfer. The centre of the ball is found in space by Newton's method on the two signed distances:
//! their gradients stay in the section, so no section is ever cut.

use super::section::Corner;
use crate::fit::Fit;
use crate::math::{Axis, Point3, UnitVec3, Vec3, try_unit};
use crate::recognize::is_ring_or_lemon;
use crate::segment::turned::turned_line;
use crate::surface::{Cylinder, Plane, Surface, Torus};

/// What two surfaces that share an edge have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Sweep {
    /// Both run straight along this direction.
    Along(UnitVec3),
    /// Both turn about this axis, as one of them shows it, and the other shows its direction.
    About(Axis, UnitVec3),
}

/// Largest angle by which fitted surfaces may miss a common direction, radians: narrow faces show theirs no better.
const MAX_ANGLE: f64 = 0.06;
/// Two planes less apart have no edge.
const MIN_EDGE_ANGLE: f64 = 0.1;

impl Sweep {
    /// What `a` and `b` have in common; `None` when no one sweep makes both. `slack`: length by which axes may miss
    /// each other. A plane's normal is better known than the axis of what stands on it.
    pub fn of(a: &Surface, b: &Surface, slack: f64) -> Option<Self> {
        let about = |axis: Axis| Self::About(axis, axis.direction);
        let (simple, other) = if a.kind() <= b.kind() { (a, b) } else { (b, a) };
        match (simple, other) {
            (Surface::Plane(p), Surface::Plane(q)) => {
                let along = p.normal.cross(&q.normal);
                (along.norm() > MIN_EDGE_ANGLE).then(|| Self::Along(UnitVec3::new_normalize(along)))
            }
            (Surface::Plane(p), Surface::Sphere(s)) => {
                Some(about(Axis { origin: s.center, direction: p.normal }))
            }
            (Surface::Plane(p), _) => {
                let axis = other.axis()?;
                let across = p.normal.dot(&axis.direction).abs();
                if across > MAX_ANGLE.cos() {
                    Some(Self::About(axis, p.normal))
                } else if across < MAX_ANGLE && matches!(other, Surface::Cylinder(_)) {
                    let n = p.normal.into_inner();
                    try_unit(axis.direction.into_inner() - n * n.dot(&axis.direction)).map(Self::Along)
                } else {
                    None
                }
            }
            (Surface::Sphere(p), Surface::Sphere(q)) => {
                let direction = try_unit(q.center - p.center)?;
                Some(about(Axis { origin: p.center, direction }))
            }
            (Surface::Sphere(s), _) | (_, Surface::Sphere(s)) => {
                let axis = a.axis().or_else(|| b.axis())?;
                (axis.radial(&s.center).norm() < slack).then_some(about(axis))
            }
            _ => {
                let (p, q) = (simple.axis()?, other.axis()?);
                if p.direction.dot(&q.direction).abs() < MAX_ANGLE.cos() {
                    return None;
                }
                let both_straight = matches!((simple, other), (Surface::Cylinder(_), Surface::Cylinder(_)));
                if both_straight {
                    return Some(Self::Along(p.direction));
                }
                (p.radial(&q.origin).norm() < slack).then_some(about(p))
            }
        }
    }

    /// The surface of `corner` between `a` and `b`, that nearest to `start`.
    pub fn surface(&self, a: &Fit, b: &Fit, corner: &Corner, convex: bool, start: &Point3) -> Option<Fit> {
        match *corner {
            Corner::Sharp { .. } => None,
            Corner::Fillet { radius } => self.fillet(a, b, radius, convex, start),
            Corner::Chamfer { share, depth } => self.chamfer(a, b, share, depth, convex, start),
        }
    }

    /// The chamfer whose normal is turned by `share` of the angle from that of `a` to that of `b`, `depth` below the
    /// sharp edge: a plane along a straight edge, else a cone about its axis.
    fn chamfer(&self, a: &Fit, b: &Fit, share: f64, depth: f64, convex: bool, start: &Point3) -> Option<Fit> {
        let edge = ball_center(a, b, 0.0, convex, start, depth)?;
        let (na, nb) = (a.distance_and_outward_normal(&edge).1, b.distance_and_outward_normal(&edge).1);
        let angle = na.dot(&nb).clamp(-1.0, 1.0).acos();
        let normal = try_unit(na * ((1.0 - share) * angle).sin() + nb * (share * angle).sin())?;
        let point = edge - normal.into_inner() * if convex { depth } else { -depth };
        Some(match self {
            Self::Along(_) => Fit { surface: Surface::Plane(Plane { point, normal }), outward: true },
            Self::About(axis, direction) => {
                turned_line(&Axis { direction: *direction, ..*axis }, &point, &normal, MAX_ANGLE)
            }
        })
    }

    /// The fillet of `radius` between `a` and `b` nearest to `start`; `convex`: it rounds an edge of the part off,
    /// else it fills a corner.
    pub fn fillet(&self, a: &Fit, b: &Fit, radius: f64, convex: bool, start: &Point3) -> Option<Fit> {
        let center = ball_center(a, b, radius, convex, start, radius)?;
        let surface = match self {
            Self::Along(direction) => {
                Surface::Cylinder(Cylinder { axis: Axis { origin: center, direction: *direction }, radius })
            }
            Self::About(axis, direction) => {
                // A tilted axis is where it should be beside the edge.
                let axis = Axis { origin: axis.foot(start), direction: *direction };
                let major_radius = axis.radial(&center).norm();
                // Else the ball turns on the spot.
                if !is_ring_or_lemon(major_radius / radius) {
                    return None;
                }
                let axis = Axis { origin: axis.foot(&center), ..axis };
                Surface::Torus(Torus { axis, major_radius, minor_radius: radius })
            }
        };
        Some(Fit { surface, outward: convex })
    }
}

/// Centre of a ball that touches both surfaces: inside the material under a convex edge, outside in a concave one. A ball
/// of no radius is a point of the edge itself. `size`: length that the centre is exact to a small share of.
fn ball_center(a: &Fit, b: &Fit, radius: f64, convex: bool, start: &Point3, size: f64) -> Option<Point3> {
    const STEPS: usize = 20;
    /// Of the size: distances are exact to some 1e-15 of coordinates that may be a million times larger.
    const EXACT: f64 = 1e-9;
    let wanted = if convex { -radius } else { radius };
    let mut center = *start;
    for _ in 0..STEPS {
        let (da, na) = a.distance_and_outward_normal(&center);
        let (db, nb) = b.distance_and_outward_normal(&center);
        let (ra, rb) = (wanted - da, wanted - db);
        if ra.abs().max(rb.abs()) < EXACT * size {
            return Some(center);
        }
        center += step(&na, &nb, ra, rb)?;
    }
    None
}

/// The shortest step that changes the distances with gradients `na` and `nb` by `ra` and `rb`.
fn step(na: &Vec3, nb: &Vec3, ra: f64, rb: f64) -> Option<Vec3> {
    let cos = na.dot(nb);
    let sin_sq = 1.0 - cos * cos;
    (sin_sq > MIN_EDGE_ANGLE * MIN_EDGE_ANGLE)
        .then(|| na * ((ra - cos * rb) / sin_sq) + nb * ((rb - cos * ra) / sin_sq))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(surface: Surface, outward: bool) -> Fit {
        Fit { surface, outward }
    }

    fn plane(point: [f64; 3], normal: [f64; 3]) -> Fit {
        fit(
            Surface::Plane(Plane {
                point: Point3::from(point),
                normal: UnitVec3::new_normalize(Vec3::from(normal)),
            }),
            true,
        )
    }

    fn shaft(radius: f64) -> Surface {
        Surface::Cylinder(Cylinder {
            axis: Axis { origin: Point3::origin(), direction: Vec3::z_axis() },
            radius,
        })
    }

    #[test]
    fn box_edge_gives_a_cylinder_tangent_to_both_planes() {
        let (a, b) = (plane([5.0, 0.0, 0.0], [1.0, 0.0, 0.0]), plane([0.0, 4.0, 0.0], [0.0, 1.0, 0.2]));
        let sweep = Sweep::of(&a.surface, &b.surface, 0.1).expect("planes meet");
        let found = sweep.fillet(&a, &b, 1.5, true, &Point3::new(5.0, 4.0, 0.0)).expect("a fillet");
        let Surface::Cylinder(cylinder) = found.surface else { panic!("not a cylinder") };
        for plane in [&a, &b] {
            let distance = plane.distance_and_outward_normal(&cylinder.axis.origin).0;
            assert!((distance + 1.5).abs() < 1e-9, "the axis lies {distance} off");
            let Surface::Plane(p) = plane.surface else { unreachable!() };
            assert!(cylinder.axis.direction.dot(&p.normal).abs() < 1e-12);
        }
    }

    #[test]
    fn shaft_on_a_flange_gives_a_torus_outside_the_shaft() {
        let (a, b) = (plane([0.0; 3], [0.0, 0.0, 1.0]), fit(shaft(6.0), true));
        let sweep = Sweep::of(&a.surface, &b.surface, 0.1).expect("a common axis");
        let found = sweep.fillet(&a, &b, 2.0, false, &Point3::new(6.5, 0.0, 0.5)).expect("a fillet");
        let Surface::Torus(torus) = found.surface else { panic!("not a torus") };
        assert!((torus.major_radius - 8.0).abs() < 1e-9 && (torus.axis.origin.z - 2.0).abs() < 1e-9);
        assert!(!found.outward, "the fillet is hollow");
    }

    #[test]
    fn crossing_shafts_have_no_analytic_fillet() {
        let across = Surface::Cylinder(Cylinder {
            axis: Axis { origin: Point3::origin(), direction: Vec3::x_axis() },
            radius: 2.0,
        });
        assert_eq!(Sweep::of(&shaft(6.0), &across, 0.1), None);
    }
}
