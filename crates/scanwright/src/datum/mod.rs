//! The frame of a part's datums, by the 3-2-1 rule.
//!
//! The first datum fixes two turns (a plane is level, an axis stands upright), the second the turn that is left, and all
//! of them, in their order, the place of the origin: each fixes what those before it leave free (ISO 5459). What no
//! datum fixes is said.
//!
//! [`choose`] picks datums when nobody names them (`choice`), and origins in planes of symmetry (`symmetry`).

mod choice;
mod symmetry;

pub use choice::{Candidate, Plan, choose};
pub use symmetry::{Mirror, mirrors};

use crate::math::{Axis, Frame, Mat3, Point3, UnitVec3, Vec3, symmetric_eigen, try_unit};
use crate::surface::Surface;

/// A surface that holds a part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Datum {
    /// The surface.
    pub surface: Surface,
    /// Whether its natural normal points out of the material.
    pub outward: bool,
    /// The middle of where it was seen.
    pub center: Point3,
}

impl Datum {
    /// The normal of a plane, out of the material; the direction of an axis.
    pub fn direction(&self) -> Option<UnitVec3> {
        match &self.surface {
            Surface::Plane(s) => Some(if self.outward { s.normal } else { -s.normal }),
            other => other.axis().map(|axis| axis.direction),
        }
    }

    /// The same surface looking the other way.
    #[must_use]
    fn reversed(mut self) -> Self {
        match &mut self.surface {
            Surface::Plane(s) => s.normal = -s.normal,
            Surface::Cylinder(s) => s.axis.direction = -s.axis.direction,
            Surface::Torus(s) => s.axis.direction = -s.axis.direction,
            Surface::Cone(s) => {
                // The same cone: its radius grows the other way.
                s.axis.direction = -s.axis.direction;
                s.half_angle = -s.half_angle;
            }
            Surface::Sphere(_) => {}
        }
        self
    }

    /// The axis of a cylinder or cone; a torus has a centre.
    fn line(&self) -> Option<Axis> {
        match &self.surface {
            Surface::Cylinder(s) => Some(s.axis),
            Surface::Cone(s) => Some(s.axis),
            Surface::Plane(_) | Surface::Sphere(_) | Surface::Torus(_) => None,
        }
    }

    /// A point that its place is told by.
    fn point(&self) -> Point3 {
        match &self.surface {
            Surface::Plane(_) => self.surface.project(&self.center),
            Surface::Sphere(s) => s.center,
            Surface::Torus(s) => s.axis.origin,
            Surface::Cylinder(s) => s.axis.foot(&self.center),
            Surface::Cone(s) => s.axis.foot(&self.center),
        }
    }

    /// Projector on the directions in which it fixes a place.
    fn fixed(&self) -> Mat3 {
        if let Surface::Plane(s) = &self.surface {
            return s.normal.into_inner() * s.normal.transpose();
        }
        self.line().map_or_else(Mat3::identity, |axis| {
            Mat3::identity() - axis.direction.into_inner() * axis.direction.transpose()
        })
    }
}

/// A frame and what datums left free of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Origin and directions, in the coordinates of the datums.
    pub frame: Frame,
    /// Whether no datum stops the turn about z.
    pub free_turn: bool,
    /// Along how many directions no datum fixes the origin.
    pub free_ways: usize,
}

/// Why datums make no frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DatumError {
    /// There is none.
    #[error("no datum is given")]
    None,
    /// The first datum has no direction.
    #[error("the first datum is a sphere: it has no direction that could be level")]
    NoDirection,
}

/// Sine of the angle between directions up to which they are parallel: ten degrees.
const PARALLEL: f64 = 0.17;

/// The frame of some datums. `directions`: the first gives z, the next that can stops the turn about it. `places`: what
/// fixes the origin, most important first. What is left free stays beside `about`; a free turn keeps x near `hint`.
pub fn frame(
    directions: &[Datum],
    places: &[Datum],
    about: &Point3,
    hint: Option<Vec3>,
) -> Result<Found, DatumError> {
    let first = directions.first().ok_or(DatumError::None)?;
    let z = first.direction().ok_or(DatumError::NoDirection)?;
    let stopped = across(directions, &z);
    let hinted = || hint.and_then(|h| try_unit(h - z.into_inner() * h.dot(&z)));
    let x = stopped.or_else(hinted).unwrap_or_else(|| crate::math::any_perpendicular(&z));
    let y = UnitVec3::new_normalize(z.cross(&x));
    let (origin, free_ways) = origin(places, about);
    Ok(Found { frame: Frame { origin, x, y, z }, free_turn: stopped.is_none(), free_ways })
}

/// The frame of chosen datums. A plane is laid level with its material above it, as a part stands on a table; an axis, and
/// a plane that faces the table's way, point `up` when that is known.
pub fn auto_frame(candidates: &[Candidate], plan: &Plan, up: Option<UnitVec3>, about: &Point3) -> Option<Found> {
    let mut level = candidates[plan.level].datum;
    let z = level.direction()?;
    let plane = matches!(level.surface, Surface::Plane(_));
    let turned_over = match up {
        Some(up) => z.dot(&up) < 0.0,
        None => plane,
    };
    if turned_over {
        level = level.reversed();
    }
    let mut directions = vec![level];
    directions.extend(plan.rotate.map(|k| candidates[k].datum));
    // Planes of symmetry first: what they fix is not fixed by a side.
    let mut places: Vec<Datum> = plan.mirrors.iter().map(Mirror::datum).collect();
    places.extend(plan.zero.iter().map(|&k| candidates[k].datum));
    frame(&directions, &places, about, None).ok()
}

/// The direction that stops the turn about z: of the first datum after the first that has one, else from an axis or
/// centre to another.
fn across(directions: &[Datum], z: &UnitVec3) -> Option<UnitVec3> {
    let flat = |v: Vec3| v - z.into_inner() * v.dot(z);
    let own = directions.iter().skip(1).filter_map(Datum::direction).map(|d| flat(d.into_inner()));
    if let Some(x) = own.into_iter().find(|x| x.norm() > PARALLEL) {
        return try_unit(x);
    }
    let places: Vec<Vec3> = directions
        .iter()
        .filter(|d| !matches!(d.surface, Surface::Plane(_)))
        .map(|d| flat(d.point().coords))
        .collect();
    let farthest = places.iter().skip(1).map(|p| p - places[0]).max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
    let size = places.iter().fold(0.0, |m: f64, p| m.max(p.norm()));
    // Two axes that are one say nothing.
    (farthest.norm() > f64::EPSILON.sqrt() * size).then(|| try_unit(farthest)).flatten()
}

/// The point that datums fix, each as far as those before it leave it free, and how many directions none fixes.
fn origin(places: &[Datum], about: &Point3) -> (Point3, usize) {
    let mut point = *about;
    // Projector on what is still free.
    let mut free = Mat3::identity();
    for datum in places {
        let fixed = datum.fixed();
        // Free directions that this datum fixes: those it moves along as far as it does.
        for (value, direction) in symmetric_eigen(&(free * fixed * free)) {
            if value <= PARALLEL * PARALLEL {
                continue;
            }
            let d = direction.into_inner();
            // Along d until the datum's own directions are met: exact for one direction, and for planes at a slant.
            let miss = fixed * (datum.point() - point);
            let own = fixed * d;
            point += d * (miss.dot(&own) / own.norm_squared());
            free -= d * d.transpose();
        }
    }
    let left = symmetric_eigen(&free).iter().filter(|(value, _)| *value > 0.5).count();
    (point, left)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Pose;
    use crate::surface::{Cylinder, Plane};
    use nalgebra::SVector;

    fn plane(point: [f64; 3], normal: [f64; 3]) -> Datum {
        let (point, normal) = (Point3::from(point), UnitVec3::new_normalize(Vec3::from(normal)));
        Datum { surface: Surface::Plane(Plane { point, normal }), outward: true, center: point }
    }

    fn bore(point: [f64; 3]) -> Datum {
        let axis = Axis { origin: Point3::from(point), direction: Vec3::z_axis() };
        Datum { surface: Surface::Cylinder(Cylinder { axis, radius: 2.0 }), outward: false, center: axis.origin }
    }

    fn near(found: &Found, origin: [f64; 3], x: Vec3, z: Vec3) {
        let frame = &found.frame;
        assert!((frame.origin - Point3::from(origin)).norm() < 1e-12, "{found:?}");
        assert!((frame.x.into_inner() - x).norm() < 1e-12 && (frame.z.into_inner() - z).norm() < 1e-12, "{found:?}");
    }

    #[test]
    fn three_planes_meet_in_the_origin_even_where_they_are_not_square() {
        let slanted = plane([5.0, 0.0, 0.0], [1.0, 0.0, 0.1]);
        let datums = [plane([1.0, 2.0, 3.0], [0.0, 0.0, 1.0]), slanted, plane([0.0, 7.0, 0.0], [0.0, 1.0, 0.0])];
        let found = frame(&datums, &datums, &Point3::new(9.0, 9.0, 9.0), None).unwrap();
        // On the slanted plane at height 3: x + 0.1 * 3 = 5.
        near(&found, [4.7, 7.0, 3.0], Vec3::x(), Vec3::z());
        assert_eq!((found.free_turn, found.free_ways), (false, 0));
    }

    #[test]
    fn a_plane_and_two_bores_make_a_frame_and_one_bore_leaves_a_turn() {
        let datums = [plane([0.0, 0.0, 4.0], [0.0, 0.0, 1.0]), bore([1.0, 2.0, 0.0]), bore([1.0, 12.0, 9.0])];
        let found = frame(&datums, &datums, &Point3::origin(), None).unwrap();
        near(&found, [1.0, 2.0, 4.0], Vec3::y(), Vec3::z());
        let found = frame(&datums[..2], &datums[..2], &Point3::origin(), Some(Vec3::new(0.0, -2.0, 1.0))).unwrap();
        near(&found, [1.0, 2.0, 4.0], -Vec3::y(), Vec3::z());
        assert_eq!((found.free_turn, found.free_ways), (true, 0));
        let found = frame(&datums[..1], &datums[..1], &Point3::new(5.0, 6.0, 7.0), None).unwrap();
        assert_eq!((found.free_turn, found.free_ways, found.frame.origin), (true, 2, Point3::new(5.0, 6.0, 4.0)));
    }

    #[test]
    fn a_moved_part_has_its_frame_moved_alike() {
        let step = SVector::<f64, 6>::from([0.3, -1.2, 0.8, 10.0, -20.0, 5.0]);
        let pose = Pose::of_step(&step, &Point3::origin());
        let datums = [plane([1.0, 2.0, 3.0], [0.0, 0.0, 1.0]), plane([5.0, 0.0, 0.0], [1.0, 0.2, 0.1]), bore([3.0, 7.0, 1.0])];
        let moved = datums.map(|d| Datum { surface: d.surface.moved(&pose), center: pose.point(&d.center), ..d });
        let about = Point3::new(0.5, 0.6, 0.7);
        let a = frame(&datums, &datums, &about, None).unwrap().frame;
        let b = frame(&moved, &moved, &pose.point(&about), None).unwrap().frame;
        assert!((pose.point(&a.origin) - b.origin).norm() < 1e-12);
        assert!((pose.rotation * a.x.into_inner() - b.x.into_inner()).norm() < 1e-12);
    }
}
