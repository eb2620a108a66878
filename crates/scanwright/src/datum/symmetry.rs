//! Planes that a part is symmetric about: mirrored, its surfaces are its surfaces.

use super::{Candidate, PARALLEL};
use crate::math::{Point3, UnitVec3, Vec3};
use crate::surface::Surface;

/// A plane of symmetry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mirror {
    /// A point of it.
    pub point: Point3,
    /// Its normal.
    pub normal: UnitVec3,
    /// Share of the area whose surfaces have their mirror images.
    pub share: f64,
}

/// Share of the area that must have its mirror image.
const LEAST_SHARE: f64 = 0.97;

/// Planes of symmetry across the directions of a frame: z, `x` and the third, midway between parallel surfaces.
pub fn mirrors(candidates: &[Candidate], z: &UnitVec3, x: Option<&UnitVec3>, tolerance: f64) -> Vec<Mirror> {
    let Some(x) = x else { return Vec::new() };
    let flat = x.into_inner() - z.into_inner() * x.dot(z);
    let y = UnitVec3::new_normalize(z.cross(&flat));
    let x = UnitVec3::new_normalize(flat);
    [x, y].iter().filter_map(|normal| across(candidates, normal, tolerance)).collect()
}

/// The plane of symmetry with a normal that the most area is symmetric about.
fn across(candidates: &[Candidate], normal: &UnitVec3, tolerance: f64) -> Option<Mirror> {
    let total: f64 = candidates.iter().map(|c| c.area).sum();
    let heights: Vec<(f64, f64)> = candidates
        .iter()
        .filter_map(|c| place(c, normal).map(|point| (point.coords.dot(normal), c.area)))
        .collect();
    let mut best: Option<Mirror> = None;
    for (i, a) in heights.iter().enumerate() {
        for b in &heights[i..] {
            // Images are of one size.
            if (a.1 / b.1).max(b.1 / a.1) > 1.5 {
                continue;
            }
            let point = Point3::from(normal.into_inner() * (0.5 * (a.0 + b.0)));
            let kept = candidates.iter().filter(|c| has_image(c, candidates, &point, normal, tolerance));
            let share = kept.map(|c| c.area).sum::<f64>() / total.max(f64::MIN_POSITIVE);
            if share > best.map_or(LEAST_SHARE, |b| b.share) {
                best = Some(Mirror { point, normal: *normal, share });
            }
        }
    }
    best
}

/// A point that a surface has along a direction: where a plane across it, an axis along the mirror or a centre is.
fn place(candidate: &Candidate, normal: &UnitVec3) -> Option<Point3> {
    match &candidate.datum.surface {
        Surface::Plane(s) => (s.normal.dot(normal).abs() > 1.0 - PARALLEL).then(|| candidate.datum.point()),
        Surface::Cylinder(_) | Surface::Cone(_) => {
            let direction = candidate.datum.direction()?;
            (direction.dot(normal).abs() < PARALLEL).then(|| candidate.datum.point())
        }
        Surface::Sphere(_) | Surface::Torus(_) => Some(candidate.datum.point()),
    }
}

/// Whether the mirror image of a surface is one of the surfaces.
fn has_image(
    of: &Candidate,
    all: &[Candidate],
    point: &Point3,
    normal: &UnitVec3,
    tolerance: f64,
) -> bool {
    let n = normal.into_inner();
    let flipped = |v: Vec3| v - n * (2.0 * v.dot(&n));
    let image = |p: &Point3| p - n * (2.0 * (p - point).dot(&n));
    let center = image(&of.datum.center);
    let reach = of.area.sqrt();
    let directions = [Vec3::x(), Vec3::y(), Vec3::z()];
    all.iter().any(|other| {
        if of.datum.surface.kind() != other.datum.surface.kind() || of.datum.outward != other.datum.outward {
            return false;
        }
        let turned = of.datum.direction().zip(other.datum.direction()).is_none_or(|(a, b)| {
            let cosine = flipped(a.into_inner()).dot(&b);
            let plane = matches!(of.datum.surface, Surface::Plane(_));
            (if plane { cosine } else { cosine.abs() }) > 1.0 - 0.5 * PARALLEL * PARALLEL
        });
        let near = (other.datum.center - center).norm() < 0.5 * reach + tolerance;
        // Places of the surface around its middle, mirrored, lie on the other.
        let lies = directions.iter().flat_map(|d| [d * (0.3 * reach), -d * (0.3 * reach)]).all(|offset| {
            let place = of.datum.surface.project(&(of.datum.center + offset));
            other.datum.surface.signed_distance(&image(&place)).abs() < tolerance
        });
        turned && near && lies
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::datum::{Datum, choose};
    use crate::math::Axis;
    use crate::surface::{Cylinder, Plane};

    /// A plate of 60 by 40 by 10 with bores at some places.
    fn plate(bores: &[[f64; 2]]) -> Vec<Candidate> {
        let mut all = Vec::new();
        for (axis, half, area) in [(2, 5.0, 2400.0), (0, 30.0, 400.0), (1, 20.0, 600.0)] {
            for side in [1.0, -1.0] {
                let mut normal = Vec3::zeros();
                normal[axis] = side;
                let point = Point3::from(normal * half);
                let normal = UnitVec3::new_normalize(normal);
                let surface = Surface::Plane(Plane { point, normal });
                all.push(Candidate { datum: Datum { surface, outward: true, center: point }, area });
            }
        }
        for [x, y] in bores {
            let axis = Axis { origin: Point3::new(*x, *y, 0.0), direction: Vec3::z_axis() };
            let surface = Surface::Cylinder(Cylinder { axis, radius: 4.0 });
            all.push(Candidate { datum: Datum { surface, outward: false, center: axis.origin }, area: 250.0 });
        }
        all
    }

    #[test]
    fn a_plate_is_symmetric_as_its_bores_are() {
        let plan = choose(&plate(&[[-20.0, 0.0], [20.0, 0.0]]), Some(0.1)).unwrap();
        assert_eq!((plan.level, plan.mirrors.len(), plan.turned), (0, 2, false));
        assert!(plan.mirrors.iter().all(|m| m.point.coords.norm() < 1e-9 && m.share > 0.999));
        // One bore off the middle leaves the symmetry across y only.
        let plan = choose(&plate(&[[-20.0, 0.0], [15.0, 0.0]]), Some(0.1)).unwrap();
        assert_eq!(plan.mirrors.len(), 1);
        assert!(plan.mirrors[0].normal.y.abs() > 0.999);
    }
}
