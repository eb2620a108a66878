//! The section across an edge, and what a scanner's spot makes of a corner, a chamfer or a fillet in it.
//!
//! A vertex near the edge of two surfaces has two coordinates, its distances to them. Where they are flat over the
//! width of the edge, corner, chamfer and fillet are chains of straight facets in these coordinates (the fillet many),
//! and the signed distance of a convex chain is `L_0 + sum_k max(0, L_{k+1} - L_k)` of the facets' distances `L`.
//! Each term is a kink along a line, whose blur by a Gaussian has a closed form (see `edge`); so has the sum.
//! Beside a thin wedge that is not the distance, and the true one is averaged over the spot.

use nalgebra::Vector2;

use crate::math::blur::{averaged_distance, blurred_magnitude};

/// A point in the section of two surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    /// Distance to the first surface, positive outside the chain; so for the second. Both change sign in a concave
    /// corner, where the chain is seen from within the material.
    pub a: f64,
    pub b: f64,
    /// Angle between the two normals, radians.
    pub angle: f64,
}

impl Place {
    /// Distance past the corner along the first surface (negative) or the second.
    pub fn across(&self) -> f64 {
        (self.b - self.a) / self.angle.sin()
    }

    /// How far the place lies past the border of `corner` with the first surface, and past that with the second: both
    /// positive on it. A fillet begins at its contacts, a chamfer at the bisectors.
    pub fn past_borders(&self, corner: &Corner) -> (f64, f64) {
        match *corner {
            Corner::Sharp { .. } => (-self.across(), self.across()),
            Corner::Fillet { radius } => {
                let (sin, cos) = self.angle.sin_cos();
                let (a, b) = (self.a + radius, self.b + radius);
                ((b - cos * a) / sin, (a - cos * b) / sin)
            }
            Corner::Chamfer { share, depth } => {
                let flat = self.facet(share * self.angle, -depth);
                (flat - self.a, flat - self.b)
            }
        }
    }

    /// Distance to a facet whose normal is turned by `turn` from the first surface's towards the second's.
    fn facet(&self, turn: f64, offset: f64) -> f64 {
        ((self.angle - turn).sin() * self.a + turn.sin() * self.b) / self.angle.sin() - offset
    }
}

/// What may be between two surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Corner {
    /// A sharp edge seen with a spot of this deviation.
    Sharp { blur: f64 },
    /// A flat whose normal is turned by this share of the angle between the two, this far below the sharp edge.
    Chamfer { share: f64, depth: f64 },
    /// An arc tangent to both.
    Fillet { radius: f64 },
}

/// Angle between the surfaces, radians, from which a thin wedge's outside matters: there the nearest point is the corner
/// itself, not a facet.
const WEDGE: f64 = 1.9;

/// Largest turn between the facets that stand for an arc, radians: their corners are 0.1 % of the radius outside it.
const FACET_TURN: f64 = 0.15;

impl Corner {
    /// Distance of a place to the corner seen with a spot of deviation `blur`; a sharp edge has its own.
    pub fn distance(&self, place: &Place, blur: f64) -> f64 {
        let blur = if let Self::Sharp { blur } = *self { blur } else { blur };
        if place.angle > WEDGE {
            let (sin, cos) = place.angle.sin_cos();
            let at = Vector2::new(place.a, (place.b - cos * place.a) / sin);
            return averaged_distance(&at, blur, |p| self.field(p, place.angle));
        }
        match *self {
            Self::Sharp { .. } => chain(place, blur, 1, |_| 0.0),
            Self::Chamfer { share, depth } => {
                let turn = share * place.angle;
                let facets = [(0.0, 0.0), (turn, -depth), (place.angle, 0.0)];
                chain_of(place, blur, facets.into_iter())
            }
            Self::Fillet { radius } => {
                let half = 0.5 * place.angle;
                let below = |turn: f64| radius * (1.0 - (turn - half).cos() / half.cos());
                let n = (place.angle / FACET_TURN).ceil().max(1.0) as usize;
                chain(place, blur, n, below)
            }
        }
    }

    /// Signed distance of a point in the section to the corner, and its gradient. The first surface's normal is the x
    /// axis, the second's is turned from it by `angle`; the sharp corner is the origin.
    fn field(&self, at: &Vector2<f64>, angle: f64) -> (f64, Vector2<f64>) {
        let normal = |turn: f64| Vector2::new(turn.cos(), turn.sin());
        match *self {
            Self::Sharp { .. } => outside_of(at, &[(normal(0.0), 0.0), (normal(angle), 0.0)]),
            Self::Chamfer { share, depth } => {
                let facets = [(normal(0.0), 0.0), (normal(share * angle), -depth), (normal(angle), 0.0)];
                outside_of(at, &facets)
            }
            Self::Fillet { radius } => {
                let half = 0.5 * angle;
                let from_center = at + normal(half) * (radius / half.cos());
                let turn = from_center.y.atan2(from_center.x);
                if (0.0..=angle).contains(&turn) {
                    let length = from_center.norm().max(f64::MIN_POSITIVE);
                    (length - radius, from_center / length)
                } else {
                    outside_of(at, &[(normal(0.0), 0.0), (normal(angle), 0.0)])
                }
            }
        }
    }
}

/// Signed distance of a point to the convex region below all `facets` (normal, offset), ordered by turn, with its
/// gradient.
fn outside_of(at: &Vector2<f64>, facets: &[(Vector2<f64>, f64)]) -> (f64, Vector2<f64>) {
    let height = |(normal, offset): &(Vector2<f64>, f64)| normal.dot(at) - offset;
    let highest = facets.iter().max_by(|a, b| height(a).total_cmp(&height(b))).expect("a corner has facets");
    let inside = (height(highest), highest.0);
    if inside.0 <= 0.0 {
        return inside;
    }
    // Outside, the nearest point is a corner between two facets or lies on a facet between its corners.
    let along = |normal: &Vector2<f64>, point: &Vector2<f64>| normal.x * point.y - normal.y * point.x;
    let corners: Vec<Vector2<f64>> = facets
        .windows(2)
        .map(|pair| {
            let (a, b) = (&pair[0], &pair[1]);
            let sin = a.0.x * b.0.y - a.0.y * b.0.x;
            Vector2::new(a.1 * b.0.y - b.1 * a.0.y, b.1 * a.0.x - a.1 * b.0.x) / sin
        })
        .collect();
    let mut nearest = (f64::INFINITY, inside.1);
    for (k, facet) in facets.iter().enumerate() {
        let place = along(&facet.0, at);
        let after = k == 0 || place >= along(&facet.0, &corners[k - 1]);
        let before = k == corners.len() || place <= along(&facet.0, &corners[k]);
        if after && before && height(facet).abs() < nearest.0 {
            nearest = (height(facet).abs(), facet.0);
        }
    }
    for corner in &corners {
        let from = at - corner;
        let distance = from.norm();
        if distance < nearest.0 {
            nearest = (distance, from / distance.max(f64::MIN_POSITIVE));
        }
    }
    nearest
}

/// Distance to `n + 1` facets at equal turns.
fn chain(place: &Place, blur: f64, n: usize, offset: impl Fn(f64) -> f64) -> f64 {
    let facets = (0..=n).map(|k| {
        let turn = place.angle * k as f64 / n as f64;
        (turn, offset(turn))
    });
    chain_of(place, blur, facets)
}

/// Distance to a chain of facets, (turn, offset) each, blurred, over the slope of the blurred distance.
fn chain_of(place: &Place, blur: f64, mut facets: impl Iterator<Item = (f64, f64)>) -> f64 {
    let Some(first) = facets.next() else { return 0.0 };
    let mut last = (first.0, place.facet(first.0, first.1));
    let mut distance = last.1;
    let (mut x, mut y) = (first.0.cos(), first.0.sin());
    for (turn, offset) in facets {
        let next = (turn, place.facet(turn, offset));
        let kink = next.1 - last.1;
        let apart = 2.0 * (0.5 * (next.0 - last.0)).sin();
        let (magnitude, erf) = blurred_magnitude(kink, blur * apart);
        let share = 0.5 * (1.0 + erf);
        distance += 0.5 * (kink + magnitude);
        x += share * (next.0.cos() - last.0.cos());
        y += share * (next.0.sin() - last.0.sin());
        last = next;
    }
    distance / x.hypot(y).max(0.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A place `along` a right angle's bisector, negative inside.
    fn on_bisector(along: f64) -> Place {
        let a = along * std::f64::consts::FRAC_1_SQRT_2;
        Place { a, b: a, angle: std::f64::consts::FRAC_PI_2 }
    }

    /// Depth of the middle of an arc in a right angle below the corner.
    fn depth_of_arc(radius: f64) -> f64 {
        radius * (2.0_f64.sqrt() - 1.0)
    }

    #[test]
    fn a_small_spot_sees_an_arc_where_it_is() {
        let radius = 3.0;
        let distance = Corner::Fillet { radius }.distance(&on_bisector(-depth_of_arc(radius)), 1e-3);
        // Facets stand for the arc: half their turn leaves the corners this far outside.
        let bound = radius * FACET_TURN * FACET_TURN / 8.0 + 1e-3;
        assert!(distance.abs() < bound, "the arc is seen {distance} off, {bound} allowed");
    }

    #[test]
    fn a_wide_arc_shrinks_by_the_law_of_cylinders() {
        let (radius, blur) = (8.0, 1.0);
        let depth = depth_of_arc(radius) + blur * blur / (2.0 * radius);
        let distance = Corner::Fillet { radius }.distance(&on_bisector(-depth), blur);
        assert!(distance.abs() < 0.15 * blur * blur / (2.0 * radius), "the arc is seen {distance} off");
    }

    #[test]
    fn contacts_bound_the_arc() {
        let place = Place { a: 0.0, b: -3.0, angle: std::f64::consts::FRAC_PI_2 };
        let (at_a, at_b) = place.past_borders(&Corner::Fillet { radius: 3.0 });
        assert!(at_a.abs() < 1e-12 && (at_b - 3.0).abs() < 1e-12);
    }
}
