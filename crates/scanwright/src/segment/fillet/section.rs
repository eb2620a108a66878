//! The section across an edge, and what a scanner's spot makes of a corner, a chamfer or a fillet in it.
//!
//! A vertex near the edge of two surfaces has two coordinates, its distances to them. Where they are flat over the
//! width of the edge, corner, chamfer and fillet are chains of straight facets in these coordinates (the fillet many),
//! and the signed distance of a convex chain is `L_0 + sum_k max(0, L_{k+1} - L_k)` of the facets' distances `L`.
//! Each term is a kink along a line, whose blur by a Gaussian has a closed form (see `edge`); so has the sum.

use crate::math::blur::blurred_magnitude;

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

    /// How far the place lies inside the fillet of `radius`, from its contact with the first surface and from that
    /// with the second: both positive on the fillet.
    pub fn past_contacts(&self, radius: f64) -> (f64, f64) {
        let (sin, cos) = self.angle.sin_cos();
        let (a, b) = (self.a + radius, self.b + radius);
        ((b - cos * a) / sin, (a - cos * b) / sin)
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

/// Largest turn between the facets that stand for an arc, radians: their corners are 0.1 % of the radius outside it.
const FACET_TURN: f64 = 0.15;

impl Corner {
    /// Distance of a place to the corner seen with a spot of deviation `blur`.
    pub fn distance(&self, place: &Place, blur: f64) -> f64 {
        match *self {
            Self::Sharp { blur } => chain(place, blur, 1, |_| 0.0),
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
        let (at_a, at_b) = Place { a: 0.0, b: -3.0, angle: std::f64::consts::FRAC_PI_2 }.past_contacts(3.0);
        assert!(at_a.abs() < 1e-12 && (at_b - 3.0).abs() < 1e-12);
    }
}
