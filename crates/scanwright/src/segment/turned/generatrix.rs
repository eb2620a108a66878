//! The curve that a turned face is made by: its vertices in the half-plane through the axis, a line or an arc.

use nalgebra::Vector2;

use super::profile::in_half_plane;
use super::turned_line;
use crate::fit::Fit;
use crate::math::{Axis, Frame, UnitVec3, Vec3, fitted_circle, fitted_parabola, longest_extent};
use crate::recognize::is_ring_or_lemon;
use crate::segment::field::Field;
use crate::surface::{Sphere, Surface, SurfaceKind, Torus};
use crate::tolerance::Tolerances;

/// Samples of a face.
const N_FIT: usize = 1500;
/// Parts of the turn that vote.
const N_PARTS: usize = 12;

/// Vertices in the half-plane through an axis, and the line through them.
pub(super) struct Generatrix {
    axis: Axis,
    frame: Frame,
    /// Radius and height of each vertex, and which part of the turn it is in.
    at: Vec<(Vector2<f64>, usize)>,
    mean: Vector2<f64>,
    /// Unit normal of the line, out of the material.
    normal: Vector2<f64>,
}

impl Generatrix {
    /// Of the face with these vertices.
    pub fn of(field: &Field, axis: &Axis, vertices: &[u32]) -> Self {
        let frame = Frame::from_z(axis.origin, axis.direction);
        let samples = field.samples(vertices, N_FIT);
        let planar: Vec<Vector2<f64>> = samples.points.iter().map(|p| in_half_plane(&frame, p)).collect();
        let (mean, along) = longest_extent(&planar);
        let line = Vector2::new(-along.y, along.x);
        let outward =
            samples.points.iter().zip(&samples.normals).fold(Vector2::zeros(), |sum, (p, normal)| {
                let radial = axis.radial(p);
                let length = radial.norm().max(f64::MIN_POSITIVE);
                sum + Vector2::new(normal.dot(&radial) / length, normal.dot(&frame.z))
            });
        let normal = if line.dot(&outward) < 0.0 { -line } else { line };
        let parts = samples.points.iter().map(|p| frame.sector(p, N_PARTS));
        Self { axis: *axis, frame, at: planar.into_iter().zip(parts).collect(), mean, normal }
    }

    /// The surfaces that it may leave, from simple to complex.
    pub fn surfaces(&self, field: &Field) -> Vec<Fit> {
        let lines = if self.is_bent(field.weights.distance_sigma) { Vec::new() } else { self.lines() };
        lines.into_iter().chain(self.arc(field)).collect()
    }

    /// The lines along the axis or across it, if it is nearly so, and the best.
    fn lines(&self) -> Vec<Fit> {
        /// Cosine of the angle to the axis, or to the plane across it, within which that is tried.
        const NEARLY: f64 = 0.97;
        let turned = |normal: Vector2<f64>| {
            let normal = self.frame.x.into_inner() * normal.x + self.frame.z.into_inner() * normal.y;
            let point = self.frame.global(&Vec3::new(self.mean.x, 0.0, self.mean.y));
            turned_line(&self.axis, &point, &UnitVec3::new_normalize(normal), Tolerances::SAME)
        };
        let nearly = [Vector2::x(), Vector2::y()].into_iter().filter_map(|exact| {
            let cos = self.normal.dot(&exact);
            (cos.abs() > NEARLY).then(|| exact * cos.signum())
        });
        nearly.chain([self.normal]).map(turned).collect()
    }

    fn arc(&self, field: &Field) -> Option<Fit> {
        let points: Vec<Vector2<f64>> = self.at.iter().map(|p| p.0).collect();
        let (center, radius) = fitted_circle(&points)?;
        let convex = (self.mean - center).dot(&self.normal) > 0.0;
        let is_shown = radius > field.limits.min_radius;
        surface_of_arc(&self.frame, &center, radius, convex).filter(|_| is_shown)
    }

    /// Whether the profile is bent by more than noise, and all round the turn alike: each part of the turn votes with the
    /// curvature of its own profile, whatever the noise is like.
    fn is_bent(&self, sigma: f64) -> bool {
        const MIN_PARTS: usize = 4;
        /// Vertices of a part.
        const MIN_COUNT: usize = 20;
        /// Standard errors of the mean curvature.
        const CLEARLY: f64 = 4.0;
        let along = Vector2::new(-self.normal.y, self.normal.x);
        let local =
            |p: &Vector2<f64>| Vector2::new(along.dot(&(p - self.mean)), self.normal.dot(&(p - self.mean)));
        let mut parts: Vec<Vec<Vector2<f64>>> = vec![Vec::new(); N_PARTS];
        for (p, part) in &self.at {
            parts[*part].push(local(p));
        }
        let reach = parts.iter().flatten().map(|p| p.x.abs()).fold(0.0, f64::max);
        let bend = |part: &Vec<Vector2<f64>>| fitted_parabola(part.iter().copied()).map(|c| 2.0 * c[2]);
        let bends: Vec<f64> = parts.iter().filter(|p| p.len() >= MIN_COUNT).filter_map(bend).collect();
        let n = bends.len() as f64;
        let mean = bends.iter().sum::<f64>() / n.max(1.0);
        let variance = bends.iter().map(|b| (b - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        let sagitta = 0.5 * mean.abs() * reach * reach;
        bends.len() >= MIN_PARTS && mean.abs() > CLEARLY * (variance / n).sqrt() && sagitta > sigma
    }
}

/// The surface that an arc about `center`, in the half-plane of `frame`, leaves as it turns about the axis; `None` where it
/// is nearly a sphere off its centre.
pub(super) fn surface_of_arc(frame: &Frame, center: &Vector2<f64>, radius: f64, convex: bool) -> Option<Fit> {
    /// Radius of the tube's circle over that of the tube below which it is a sphere.
    const CENTERED: f64 = 0.05;
    let origin = frame.origin + frame.z.into_inner() * center.y;
    let surface = if center.x.abs() < CENTERED * radius {
        Surface::Sphere(Sphere { center: origin, radius })
    } else {
        let axis = Axis { origin, direction: frame.z };
        Surface::Torus(Torus { axis, major_radius: center.x, minor_radius: radius })
    };
    let is_one = surface.kind() == SurfaceKind::Sphere || is_ring_or_lemon(center.x / radius);
    is_one.then_some(Fit { surface, outward: convex })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Point3;

    /// A profile along x, 20 long all round the turn, of `off` by place along it and turn.
    fn profile(off: impl Fn(f64, f64) -> f64) -> Generatrix {
        let axis = Axis { origin: Point3::origin(), direction: Vec3::z_axis() };
        let frame = Frame::from_z(axis.origin, axis.direction);
        let at = (0..4000_u32).map(|i| {
            let (along, turn) =
                (f64::from(i % 40) * 0.5 - 9.75, f64::from(i / 40) * 0.01 * std::f64::consts::TAU);
            let part = i as usize / 40 * N_PARTS / 100;
            (Vector2::new(30.0 + along, off(along, turn)), part)
        });
        let mean = Vector2::new(30.0, 0.0);
        Generatrix { axis, frame, at: at.collect(), mean, normal: Vector2::y() }
    }

    #[test]
    fn a_profile_is_bent_that_is_so_all_round_and_not_where_noise_is_wavy() {
        let (sigma, length) = (0.2, 9.75);
        // Waves of twice the noise, as long as the profile, that come and go round the turn.
        let wave = |along: f64, turn: f64| 2.0 * sigma * (0.3 * along + 5.0 * turn).cos();
        let bend = |sagitta: f64| move |along: f64, _: f64| -sagitta * (along / length).powi(2);
        assert!(!profile(wave).is_bent(sigma));
        assert!(profile(bend(1.5 * sigma)).is_bent(sigma));
        assert!(!profile(bend(0.5 * sigma)).is_bent(sigma), "less than the noise is no bend");
        let both = |along: f64, turn: f64| wave(along, turn) + bend(6.0 * sigma)(along, turn);
        assert!(profile(both).is_bent(sigma));
    }
}
