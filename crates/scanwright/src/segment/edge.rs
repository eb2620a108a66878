//! What the scanner makes of a sharp edge.
//!
//! A scanner with a spot of standard deviation `b` sees the signed distance of the part blurred by a Gaussian. Near a
//! convex edge that distance is `max(d_1, d_2) = (d_1 + d_2) / 2 + |t| / 2` with `t = d_1 - d_2` and the distances of
//! the two surfaces; across the edge `t` is linear, so its blurred magnitude has a closed form with deviation
//! `tau = b |n_1 - n_2|`: `E|t| = tau sqrt(2 / pi) exp(-t^2 / 2 tau^2) + t erf(t / tau sqrt 2)`. Concave edges are
//! `min`, with a minus sign. The model has no free parameter: vertices that it explains are no fillet.

use super::field::Field;
use crate::fit::Fit;
use crate::math::{Point3, Vec3};

/// Distance to the blurred edge of two surfaces and its outward normal, for the convex and the concave edge.
fn blurred(a: &Fit, b: &Fit, blur: f64, point: &Point3) -> [(f64, Vec3); 2] {
    let (da, na) = a.distance_and_outward_normal(point);
    let (db, nb) = b.distance_and_outward_normal(point);
    let (t, apart) = (da - db, na - nb);
    let tau = (blur * apart.norm()).max(f64::MIN_POSITIVE);
    let erf = erf(t / (tau * std::f64::consts::SQRT_2));
    let magnitude = tau * (2.0 / std::f64::consts::PI).sqrt() * (-t * t / (2.0 * tau * tau)).exp() + t * erf;
    [1.0, -1.0].map(|side| {
        let gradient = (na + nb) * 0.5 + apart * (0.5 * side * erf);
        let slope = gradient.norm().max(0.1);
        ((0.5 * (da + db) + 0.5 * side * magnitude) / slope, gradient / slope)
    })
}

/// Cost of a vertex under the blurred edge of two surfaces.
pub(super) fn cost(field: &Field, a: &Fit, b: &Fit, vertex: u32) -> f64 {
    let (point, normal) = (&field.points[vertex as usize], &field.normals[vertex as usize]);
    let w = &field.weights;
    blurred(a, b, field.blur, point)
        .into_iter()
        .map(|(distance, surface_normal)| {
            let scaled = distance / w.distance_sigma;
            let tilt_sq = (normal - surface_normal).norm_squared();
            // Filtering turns normals further than the scanner did: across an edge they say only half as much.
            scaled * scaled + 0.5 * w.normal_weight * tilt_sq / (w.normal_sigma * w.normal_sigma)
        })
        .fold(f64::MAX, f64::min)
}

/// Error function, within 1.5e-7: M. Abramowitz, I. Stegun, "Handbook of Mathematical Functions" (1964), 7.1.26.
fn erf(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs());
    let polynomial = t
        * (0.254_829_592
            + t * (-0.284_496_736 + t * (1.421_413_741 + t * (-1.453_152_027 + t * 1.061_405_429))));
    (1.0 - polynomial * (-x * x).exp()).copysign(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::UnitVec3;
    use crate::surface::{Plane, Surface};

    #[test]
    fn blurred_right_angle_recedes_by_its_closed_form() {
        let plane = |x: f64, y: f64| Fit {
            surface: Surface::Plane(Plane {
                point: Point3::origin(),
                normal: UnitVec3::new_normalize(Vec3::new(x, y, 0.0)),
            }),
            outward: true,
        };
        let (a, b, blur) = (plane(1.0, 1.0), plane(-1.0, 1.0), 0.8);
        // Along the bisector the surface lies at y = -b sqrt(2 / pi), whatever b.
        let depth = blur * (2.0 / std::f64::consts::PI).sqrt();
        let [(convex, normal), _] = blurred(&a, &b, blur, &Point3::new(0.0, -depth, 0.0));
        assert!(convex.abs() < 1e-6, "distance {convex}");
        assert!((normal - Vec3::y()).norm() < 1e-6, "normal {normal}");
    }
}
