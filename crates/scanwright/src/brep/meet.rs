//! Points where surfaces meet, by Gauss and Newton.
//!
//! The step is the shortest one that meets the linearised equations (pseudo-inverse with a cut), so a point on two
//! surfaces moves straight to their intersection, and a direction that the surfaces do not determine is left alone.
//! Tangent pairs would be such a direction; for them an equation is added that holds where a blend touches its
//! support: with t along the blend's spine, `(t x n_support) . n_blend = 0`; where two tubes of one radius continue
//! each other, the plane across the tube. Surfaces that only nearly touch then share the gap evenly.

use crate::math::{Axis, Mat3, Point3, UnitVec3, Vec3, symmetric_eigen, try_unit};
use crate::surface::{Plane, Surface};

/// Relative singular value below which two normals count as parallel: about three degrees between them.
pub(super) const PARALLEL: f64 = 0.05;
/// Gauss and Newton from a point a few spacings away converge in well under this many steps.
const MAX_STEPS: usize = 30;

/// Something that a point shall lie on.
#[derive(Debug, Clone, Copy)]
pub(super) enum Field {
    /// A surface.
    Surface(Surface),
    /// A cut or contact plane.
    Plane(Plane),
    /// Where a blend touches its support. The scale is the blend's radius, so that the value is a length.
    Contact { pair: [Surface; 2], spine: Spine, scale: f64 },
}

impl Field {
    /// Value, a length.
    pub(super) fn value(&self, point: &Point3) -> f64 {
        match self {
            Self::Surface(surface) => surface.signed_distance(point),
            Self::Plane(plane) => plane.signed_distance(point),
            Self::Contact { pair, spine, scale } => contact(pair, spine, point) * scale,
        }
    }

    /// Value, a length, and gradient.
    fn value_and_gradient(&self, point: &Point3) -> (f64, Vec3) {
        match self {
            Self::Surface(surface) => {
                let (distance, normal) = surface.distance_and_normal(point);
                (distance, normal.into_inner())
            }
            Self::Plane(plane) => (plane.signed_distance(point), plane.normal.into_inner()),
            Self::Contact { scale, .. } => {
                /// Step of the central difference as a share of the scale: cube root of the rounding unit.
                const DIFFERENCE: f64 = 6e-6;
                let step = DIFFERENCE * scale;
                let gradient = Vec3::from_fn(|i, _| {
                    let mut offset = Vec3::zeros();
                    offset[i] = step;
                    (self.value(&(point + offset)) - self.value(&(point - offset))) / (2.0 * step)
                });
                (self.value(point), gradient)
            }
        }
    }

    /// Distance from what it stands for, when that is a real surface of the solid.
    fn surface_distance(&self, point: &Point3) -> Option<f64> {
        match self {
            Self::Surface(surface) => Some(surface.signed_distance(point).abs()),
            Self::Plane(_) | Self::Contact { .. } => None,
        }
    }
}

/// The direction along a contact.
#[derive(Debug, Clone, Copy)]
pub(super) enum Spine {
    /// Along the spine of this tube.
    Of(Surface),
    /// One direction.
    Fixed(UnitVec3),
}

fn contact([a, b]: &[Surface; 2], spine: &Spine, point: &Point3) -> f64 {
    let along = match spine {
        Spine::Of(surface) => spine_direction(surface, point),
        Spine::Fixed(direction) => Some(*direction),
    };
    along.map_or(0.0, |along| along.cross(&a.normal(point)).dot(&b.normal(point)))
}

/// Direction of the spine of a tube beside `point`.
pub(super) fn spine_direction(surface: &Surface, point: &Point3) -> Option<UnitVec3> {
    match surface {
        Surface::Cylinder(s) => Some(s.axis.direction),
        Surface::Torus(s) => try_unit(s.axis.direction.cross(&s.axis.radial(point))),
        // A cone or sphere is no blend along a line, but may be touched by one round an axis.
        Surface::Cone(s) => try_unit(s.axis.direction.cross(&s.axis.radial(point))),
        Surface::Plane(_) | Surface::Sphere(_) => None,
    }
}

/// Where a solve ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    pub point: Point3,
    /// Largest distance to the real surfaces among the fields.
    pub residual: f64,
    /// Distance from the start.
    pub moved: f64,
}

/// The point near `start` on all `fields`, never farther than `reach` away.
pub(super) fn meet(start: &Point3, fields: &[Field], reach: f64, cut: f64) -> Meeting {
    let mut point = *start;
    for _ in 0..MAX_STEPS {
        let mut step = shortest_step(&point, fields, cut);
        let length = step.norm();
        if !length.is_finite() {
            break;
        }
        if length > reach {
            step *= reach / length;
        }
        point += step;
        let offset = point - start;
        if offset.norm() > reach {
            point = start + offset * (reach / offset.norm());
        }
        if length <= reach * f64::EPSILON.sqrt() * f64::EPSILON.sqrt().sqrt() {
            break;
        }
    }
    let residual = fields.iter().filter_map(|f| f.surface_distance(&point)).fold(0.0, f64::max);
    Meeting { point, residual, moved: (point - start).norm() }
}

fn shortest_step(point: &Point3, fields: &[Field], cut: f64) -> Vec3 {
    let (mut hessian, mut gradient) = (Mat3::zeros(), Vec3::zeros());
    for field in fields {
        let (value, row) = field.value_and_gradient(point);
        hessian += row * row.transpose();
        gradient += row * value;
    }
    let eigen = symmetric_eigen(&hessian);
    let largest = eigen[2].0;
    let mut step = Vec3::zeros();
    for (value, direction) in eigen {
        if value > cut * cut * largest && value > 0.0 {
            step -= direction.into_inner() * (direction.dot(&gradient) / value);
        }
    }
    step
}

/// The extra equation of a tangent pair near `points`, or `None` when the pair has no such equation.
pub(super) fn contact_field(a: &Surface, b: &Surface, center: &Point3, along: &Vec3) -> Option<Field> {
    let (support, blend) = if tube_radius(a, center) >= tube_radius(b, center) { (a, b) } else { (b, a) };
    if let Some(plane) = across_tube(support, blend, center, along) {
        return Some(Field::Plane(plane));
    }
    let scale = tube_radius(blend, center);
    let direction = try_unit(*along)?;
    /// Cosine between chain and spine from which the chain runs along the spine.
    const ALONG: f64 = 0.8;
    let runs_along =
        |s: &&Surface| spine_direction(s, center).is_some_and(|d| d.dot(&direction).abs() > ALONG);
    let spine =
        [blend, support].into_iter().find(runs_along).map_or(Spine::Fixed(direction), |s| Spine::Of(*s));
    scale.is_finite().then_some(Field::Contact { pair: [*support, *blend], spine, scale })
}

/// Where two tubes of one radius continue each other, the plane across both.
fn across_tube(support: &Surface, blend: &Surface, center: &Point3, along: &Vec3) -> Option<Plane> {
    /// Radii closer than this share count as one tube: fitted radii of short tubes differ by up to a tenth.
    const SAME_RADIUS: f64 = 0.15;
    /// Sine of the angle between chain and spine from which the chain runs round the tube rather than along it.
    const ROUND: f64 = 0.7;
    let (r, q) = (tube_radius(support, center), tube_radius(blend, center));
    if !(r.is_finite() && (r - q).abs() <= SAME_RADIUS * r) {
        return None;
    }
    let directions = [support, blend].map(|s| match s {
        Surface::Sphere(_) => None,
        Surface::Cone(s) => Some(s.axis.direction),
        _ => spine_direction(s, center),
    });
    let runs_round = |d: &UnitVec3| d.cross(along).norm() > ROUND * along.norm();
    let straight = |s: &Surface| !matches!(s, Surface::Torus(_));
    let (first, second) =
        if straight(support) { (directions[0], directions[1]) } else { (directions[1], directions[0]) };
    let normal = first.or(second).filter(runs_round)?;
    let point = [support, blend]
        .iter()
        .find_map(|s| if let Surface::Sphere(s) = s { Some(s.center) } else { None })
        .or_else(|| {
            // Straight tube into bend: the plane through the bend's centre across the tube.
            [support, blend].iter().find_map(|s| match s {
                Surface::Torus(t) if straight(support) || straight(blend) => Some(t.axis.origin),
                _ => None,
            })
        })
        .unwrap_or(*center);
    Some(Plane { point, normal })
}

/// Radius of curvature across the spine: infinite for a plane.
pub(super) fn tube_radius(surface: &Surface, point: &Point3) -> f64 {
    match surface {
        Surface::Plane(_) => f64::INFINITY,
        Surface::Cylinder(s) => s.radius,
        Surface::Cone(s) => {
            let axis: &Axis = &s.axis;
            axis.radial(point).norm() / s.half_angle.cos()
        }
        Surface::Sphere(s) => s.radius,
        Surface::Torus(s) => s.minor_radius,
    }
}
