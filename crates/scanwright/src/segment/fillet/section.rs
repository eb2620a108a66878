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
    a: f64,
    b: f64,
    /// Angle between the two normals, radians.
    angle: f64,
    /// Normal of the second surface, where the first one's is the x axis.
    second: Normal,
}

/// A unit vector in the section. Its x axis is the first surface's normal, and it turns towards the second's.
type Normal = Vector2<f64>;

/// A half-plane of the section: its normal, and its offset from the sharp corner.
type Facet = (Normal, f64);

const FIRST: Normal = Vector2::new(1.0, 0.0);

fn turned(turn: f64) -> Normal {
    let (sin, cos) = turn.sin_cos();
    Vector2::new(cos, sin)
}

impl Place {
    /// The place at these distances from two surfaces whose normals are `angle` apart, radians.
    pub fn new(a: f64, b: f64, angle: f64) -> Self {
        Self { a, b, angle, second: turned(angle) }
    }

    /// Angle between the two normals, radians.
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Distance past the corner along the first surface (negative) or the second.
    pub fn across(&self) -> f64 {
        (self.b - self.a) / self.second.y
    }

    /// How far the place lies past the border of `corner` with the first surface, and past that with the second: both
    /// positive on it. A fillet begins at its contacts, a chamfer at the bisectors.
    pub fn past_borders(&self, corner: &Corner) -> (f64, f64) {
        match *corner {
            Corner::Sharp { .. } => (-self.across(), self.across()),
            Corner::Fillet { radius } => {
                let (cos, sin) = (self.second.x, self.second.y);
                let (a, b) = (self.a + radius, self.b + radius);
                ((b - cos * a) / sin, (a - cos * b) / sin)
            }
            Corner::Chamfer { share, depth } => {
                let flat = self.height(&(turned(share * self.angle), -depth));
                (flat - self.a, flat - self.b)
            }
        }
    }

    /// The place in the section's own axes; the sharp corner is the origin.
    fn position(&self) -> Vector2<f64> {
        Vector2::new(self.a, (self.b - self.second.x * self.a) / self.second.y)
    }

    /// Distance to a facet.
    fn height(&self, (normal, offset): &Facet) -> f64 {
        normal.dot(&self.position()) - offset
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
        let at = place.position();
        if place.angle > WEDGE {
            return self.true_distance(place, &at, blur);
        }
        let last = (place.second, 0.0);
        match *self {
            Self::Sharp { .. } => chain(&at, blur, [last]),
            Self::Chamfer { share, depth } => chain(&at, blur, [(turned(share * place.angle), -depth), last]),
            Self::Fillet { radius } => {
                let n = (place.angle / FACET_TURN).ceil().max(1.0) as usize;
                chain(&at, blur, arc(place, radius, n))
            }
        }
    }

    /// The distance averaged over the spot, where the place is beside a thin wedge.
    fn true_distance(&self, place: &Place, at: &Vector2<f64>, blur: f64) -> f64 {
        let (first, last) = ((FIRST, 0.0), (place.second, 0.0));
        match *self {
            Self::Sharp { .. } => {
                let wedge = Convex::new([first, last]);
                averaged_distance(at, blur, |p| wedge.distance(p))
            }
            Self::Chamfer { share, depth } => {
                let bevel = Convex::new([first, (turned(share * place.angle), -depth), last]);
                averaged_distance(at, blur, |p| bevel.distance(p))
            }
            Self::Fillet { radius } => {
                let wedge = Convex::new([first, last]);
                let half = 0.5 * place.angle;
                let center = turned(half) * (-radius / half.cos());
                averaged_distance(at, blur, |p| {
                    let from_center = p - center;
                    let is_past_first = from_center.y >= 0.0;
                    if is_past_first && cross(&from_center, &place.second) >= 0.0 {
                        let length = from_center.norm().max(f64::MIN_POSITIVE);
                        (length - radius, from_center / length)
                    } else {
                        wedge.distance(p)
                    }
                })
            }
        }
    }
}

/// The facets after the first of an arc tangent to both surfaces: `n` at equal turns.
fn arc(place: &Place, radius: f64, n: usize) -> impl Iterator<Item = Facet> {
    let half = turned(0.5 * place.angle);
    let step = turned(place.angle / n as f64);
    let mut normal = FIRST;
    (0..n).map(move |_| {
        normal = Vector2::new(normal.x * step.x - normal.y * step.y, normal.x * step.y + normal.y * step.x);
        (normal, radius * (1.0 - normal.dot(&half) / half.x))
    })
}

fn cross(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

/// The convex region below all of `N` facets, ordered by turn, the first and the last through the origin.
struct Convex<const N: usize> {
    facets: [Facet; N],
    /// Corner of each facet with the next; that of the last has no meaning.
    corners: [Vector2<f64>; N],
}

impl<const N: usize> Convex<N> {
    fn new(facets: [Facet; N]) -> Self {
        let corner = |k: usize| {
            let (a, b) = (&facets[k], &facets[(k + 1) % N]);
            Vector2::new(a.1 * b.0.y - b.1 * a.0.y, b.1 * a.0.x - a.1 * b.0.x) / cross(&a.0, &b.0)
        };
        Self { facets, corners: std::array::from_fn(corner) }
    }

    /// Signed distance of a point to the region, and its gradient.
    fn distance(&self, at: &Vector2<f64>) -> (f64, Vector2<f64>) {
        let heights = self.facets.map(|(normal, offset)| normal.dot(at) - offset);
        let highest = (1..N).fold(0, |best, k| if heights[k] >= heights[best] { k } else { best });
        if heights[highest] <= 0.0 {
            return (heights[highest], self.facets[highest].0);
        }
        // Outside, the nearest point is a corner between two facets or lies on a facet between its corners.
        let mut nearest = (f64::INFINITY, self.facets[highest].0);
        for (k, (normal, _)) in self.facets.iter().enumerate() {
            let is_after = k == 0 || cross(normal, &(at - self.corners[k - 1])) >= 0.0;
            let is_before = k + 1 == N || cross(normal, &(at - self.corners[k])) <= 0.0;
            if is_after && is_before && heights[k].abs() < nearest.0 {
                nearest = (heights[k].abs(), *normal);
            }
        }
        for corner in &self.corners[..N - 1] {
            let from = at - corner;
            let distance = from.norm();
            if distance < nearest.0 {
                nearest = (distance, from / distance.max(f64::MIN_POSITIVE));
            }
        }
        nearest
    }
}

/// Distance of a point to the first surface and the facets after it, blurred, over the slope of the blurred distance.
fn chain(at: &Vector2<f64>, blur: f64, facets: impl IntoIterator<Item = Facet>) -> f64 {
    let (mut normal, mut height) = (FIRST, at.x);
    let (mut distance, mut slope) = (height, normal);
    for facet in facets {
        let next = facet.0.dot(at) - facet.1;
        let kink = next - height;
        let turn = facet.0 - normal;
        let (magnitude, erf) = blurred_magnitude(kink, blur * turn.norm());
        distance += 0.5 * (kink + magnitude);
        slope += turn * (0.5 * (1.0 + erf));
        (normal, height) = (facet.0, next);
    }
    distance / slope.norm().max(0.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A place `along` a right angle's bisector, negative inside.
    fn on_bisector(along: f64) -> Place {
        let a = along * std::f64::consts::FRAC_1_SQRT_2;
        Place::new(a, a, std::f64::consts::FRAC_PI_2)
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
        let place = Place::new(0.0, -3.0, std::f64::consts::FRAC_PI_2);
        let (at_a, at_b) = place.past_borders(&Corner::Fillet { radius: 3.0 });
        assert!(at_a.abs() < 1e-12 && (at_b - 3.0).abs() < 1e-12);
    }
}
