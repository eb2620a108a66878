//! What the scanner makes of a sharp edge.
//!
//! A scanner with a spot of standard deviation `b` sees the signed distance of the part blurred by a Gaussian. Near a
//! convex edge that distance is `max(d_1, d_2) = (d_1 + d_2) / 2 + |t| / 2` with `t = d_1 - d_2` and the distances of
//! the two surfaces; across the edge `t` is linear, so its blurred magnitude has a closed form with deviation
//! `tau = b |n_1 - n_2|`: `E|t| = tau sqrt(2 / pi) exp(-t^2 / 2 tau^2) + t erf(t / tau sqrt 2)`. Concave edges are
//! `min`, with a minus sign. The model has no free parameter: vertices that it explains are no fillet.

use super::field::Field;
use crate::fit::Fit;
use crate::math::blur::blurred_magnitude;
use crate::math::{Point3, Vec3};

/// A blurred edge at one point.
struct Blurred {
    /// Signed distance to the rounded surface.
    distance: f64,
    /// Its outward normal.
    normal: Vec3,
    /// Change of the distance per change of the distance to the first surface.
    sensitivity: f64,
    /// Signed distance to the first surface, and its outward normal.
    first: (f64, Vec3),
}

/// The blurred edge of two surfaces, convex and concave.
fn blurred(a: &Fit, b: &Fit, blur: f64, point: &Point3) -> [Blurred; 2] {
    let (da, na) = a.distance_and_outward_normal(point);
    let (db, nb) = b.distance_and_outward_normal(point);
    let apart = na - nb;
    let (magnitude, erf) = blurred_magnitude(da - db, blur * apart.norm());
    [1.0, -1.0].map(|side| {
        let gradient = (na + nb) * 0.5 + apart * (0.5 * side * erf);
        let slope = gradient.norm().max(0.1);
        Blurred {
            distance: (0.5 * (da + db) + 0.5 * side * magnitude) / slope,
            normal: gradient / slope,
            sensitivity: 0.5 * (1.0 + side * erf),
            first: (da, na),
        }
    })
}

/// `max(a, b)` blurred; `tau`: the deviation of `a - b`.
pub(super) fn blurred_maximum(a: f64, b: f64, tau: f64) -> f64 {
    0.5 * (a + b + blurred_magnitude(a - b, tau).0)
}

/// Cost of a vertex under the blurred edge of two surfaces.
pub(super) fn cost(field: &Field, a: &Fit, b: &Fit, vertex: u32) -> f64 {
    let edges = blurred(a, b, field.blur, &field.points[vertex as usize]);
    edges.iter().map(|edge| cost_under(field, edge, vertex)).fold(f64::MAX, f64::min)
}

fn cost_under(field: &Field, edge: &Blurred, vertex: u32) -> f64 {
    let w = &field.weights;
    let scaled = edge.distance / w.distance_sigma;
    let tilt_sq = (field.normals[vertex as usize] - edge.normal).norm_squared();
    // Filtering turns normals further than the scanner did: across an edge they say only half as much.
    scaled * scaled + 0.5 * w.normal_weight * tilt_sq / (w.normal_sigma * w.normal_sigma)
}

/// A vertex as the scanner would have seen it without blur.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sharpened {
    /// On the first surface but for what the edge model leaves unexplained.
    pub point: Point3,
    /// Unit normal, likewise.
    pub normal: Vec3,
    /// Cost under the blurred edge.
    pub cost: f64,
    /// How much the vertex says about the first surface: one far from the edge, one half on it, zero past it.
    pub sensitivity: f64,
}

/// Takes the rounding of the edge between `a` and `b` off a vertex of `a`.
pub(super) fn sharpen(field: &Field, a: &Fit, b: &Fit, vertex: u32) -> Sharpened {
    let (point, normal) = (&field.points[vertex as usize], &field.normals[vertex as usize]);
    let [convex, concave] = blurred(a, b, field.blur, point);
    let (c, d) = (cost_under(field, &convex, vertex), cost_under(field, &concave, vertex));
    let (edge, cost) = if c <= d { (convex, c) } else { (concave, d) };
    let (distance, outward) = edge.first;
    Sharpened {
        point: point + outward * (edge.distance - distance),
        normal: (outward + normal - edge.normal).try_normalize(0.0).unwrap_or(outward),
        cost,
        sensitivity: edge.sensitivity,
    }
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
        let [convex, _] = blurred(&a, &b, blur, &Point3::new(0.0, -depth, 0.0));
        assert!(convex.distance.abs() < 1e-6, "distance {}", convex.distance);
        assert!((convex.normal - Vec3::y()).norm() < 1e-6, "normal {}", convex.normal);
        assert!((convex.sensitivity - 0.5).abs() < 1e-6, "sensitivity {}", convex.sensitivity);
    }
}
