//! Pieces of one turned face.
//!
//! Noise and shadows break a wide turned face in pieces, each with an axis of its own. Beside a face that shows the axis
//! well they are held against what turns about that axis: a cylinder, an annulus, a cone, a torus or a sphere, the
//! simplest that describes every piece as well as the piece's own surface does. Neighbours that share one become one
//! face; a face whose own axis is off takes the common one.

use nalgebra::{Matrix2, Vector2};

use super::run::{MIN_SECTORS, N_SECTORS, surface_of_arc};
use super::{axes, level_sectors, turned_line};
use crate::fit::{Fit, Samples};
use crate::math::{Axis, Frame, Mat3, Point3, UnitVec3, Vec3, fitted_circle};
use crate::par;
use crate::recognize::{COST_CAP, excess_cost, is_as_good, mean_cost};
use crate::segment::field::{Field, Scratch};
use crate::segment::finish::Regions;
use crate::segment::grow::{BORDER_RINGS, MIN_INTERIOR};
use crate::surface::SurfaceKind;

/// Fewer vertices show no face.
const MIN_PIECE: usize = 40;
/// Samples per piece in a test, and of a fit.
const N_TEST: usize = 150;
const N_FIT: usize = 1500;
/// A surface that describes a piece worse than this describes it by chance.
const MAX_COST: f64 = 5.0;

/// Gives the pieces of one turned face one region, and turned faces the axis of those that show it best.
pub(in crate::segment) fn unite(field: &Field, regions: &mut Regions) {
    let shows_axis = |kind| matches!(kind, SurfaceKind::Cylinder | SurfaceKind::Cone);
    let mut settled = vec![false; regions.fits.len()];
    for (owner, axis) in axes(field, regions, &regions.members(), shows_axis) {
        if settled[owner] {
            continue;
        }
        settled[owner] = true;
        let mut faces = faces(field, regions, &axis, &settled);
        join(field, regions, &axis, &mut faces);
        for face in &faces {
            let Some(fit) = face.shared(field, &axis).filter(|_| face.is_new(regions, &axis, field)) else {
                continue;
            };
            for &k in &face.regions {
                settled[k as usize] = true;
            }
            let first = face.regions[0];
            regions.fits[first as usize] = Some(fit);
            for label in regions.of_vertex.iter_mut().flatten() {
                if face.regions.contains(label) {
                    *label = first;
                }
            }
        }
    }
    regions.compact();
}

/// One or several pieces that turn about one axis.
#[derive(Debug, Clone)]
struct Face {
    regions: Vec<u32>,
    /// Of each piece: samples of its interior, and how well its own surface describes them.
    evidence: Vec<(Samples, f64)>,
    interior: Vec<u32>,
    sectors: [bool; N_SECTORS],
}

/// The regions that turn about the axis, as far as their extent shows.
fn faces(field: &Field, regions: &Regions, axis: &Axis, settled: &[bool]) -> Vec<Face> {
    let members = regions.members();
    let face = |k: usize| {
        let fit = regions.fits[k].filter(|_| members[k].len() >= MIN_PIECE && !settled[k])?;
        let sectors = level_sectors(field, axis, &members[k])?;
        let depths = field.depths(&members[k], BORDER_RINGS, false, &mut Scratch::new(field.n_vertices()));
        let is_inside = |(_, depth): &(&u32, &u8)| usize::from(**depth) >= BORDER_RINGS;
        let interior: Vec<u32> = members[k].iter().zip(&depths).filter(is_inside).map(|(v, _)| *v).collect();
        // What is narrower is resolved with its neighbours.
        if interior.len() < MIN_INTERIOR {
            return None;
        }
        let samples = field.samples(&interior, N_TEST);
        let own = mean_cost(&fit, &samples, &field.weights);
        Some(Face { regions: vec![k as u32], evidence: vec![(samples, own)], interior, sectors })
    };
    par::map_indices(members.len(), face).into_iter().flatten().collect()
}

/// Joins faces that touch and share a surface, those that it describes best first.
fn join(field: &Field, regions: &Regions, axis: &Axis, faces: &mut Vec<Face>) {
    let touching = touching(field, regions);
    let touch = |a: &Face, b: &Face| {
        a.regions
            .iter()
            .any(|&k| b.regions.iter().any(|&l| touching.binary_search(&(k.min(l), k.max(l))).is_ok()))
    };
    let joint = |a: &Face, b: &Face| {
        let both = touch(a, b).then(|| a.with(b))?;
        both.shared(field, axis).map(|fit| (both.excess(field, &fit), both))
    };
    let pairs: Vec<(usize, usize)> =
        (0..faces.len()).flat_map(|i| (i + 1..faces.len()).map(move |j| (i, j))).collect();
    let mut joints: Vec<((usize, usize), f64, Face)> =
        par::map(&pairs, |&(i, j)| joint(&faces[i], &faces[j]).map(|(excess, face)| ((i, j), excess, face)))
            .into_iter()
            .flatten()
            .collect();
    let mut gone = vec![false; faces.len()];
    while let Some(best) = (0..joints.len())
        .min_by(|&a, &b| joints[a].1.total_cmp(&joints[b].1).then(joints[a].0.cmp(&joints[b].0)))
    {
        let ((i, j), _, face) = joints.swap_remove(best);
        faces[i] = face;
        gone[j] = true;
        joints.retain(|((a, b), ..)| ![i, j].contains(a) && ![i, j].contains(b));
        let others: Vec<usize> = (0..faces.len()).filter(|&k| k != i && !gone[k]).collect();
        let new = par::map(&others, |&k| {
            joint(&faces[i], &faces[k]).map(|(excess, face)| ((i.min(k), i.max(k)), excess, face))
        });
        joints.extend(new.into_iter().flatten());
    }
    let mut gone = gone.into_iter();
    faces.retain(|_| gone.next() == Some(false));
}

impl Face {
    fn with(&self, other: &Self) -> Self {
        let mut both = self.clone();
        both.regions.extend(&other.regions);
        both.evidence.extend(other.evidence.iter().cloned());
        both.interior.extend(&other.interior);
        for (mine, theirs) in both.sectors.iter_mut().zip(other.sectors) {
            *mine |= theirs;
        }
        both.regions.sort_unstable();
        both
    }

    /// Whether the face is in pieces, or in one with an axis of its own.
    fn is_new(&self, regions: &Regions, axis: &Axis, field: &Field) -> bool {
        /// Sine of the angle between two axes that are one.
        const PARALLEL: f64 = 1e-3;
        if self.regions.len() > 1 {
            return true;
        }
        let Some(fit) = regions.fits[self.regions[0] as usize] else { return false };
        fit.surface.axis().is_some_and(|own| {
            own.direction.cross(&axis.direction).norm() > PARALLEL
                || own.radial(&axis.origin).norm() > 0.1 * field.spacing
        })
    }

    /// The simplest surface about the axis that describes every piece as well as its own does.
    fn shared(&self, field: &Field, axis: &Axis) -> Option<Fit> {
        if self.sectors.iter().filter(|s| **s).count() < MIN_SECTORS {
            return None;
        }
        let profile = Profile::of(field, axis, &self.interior);
        let lines = if profile.is_bent(field.weights.distance_sigma) { Vec::new() } else { profile.lines() };
        lines.into_iter().chain(profile.arc(field)).find(|fit| {
            self.evidence.iter().all(|(samples, own)| {
                let shared = mean_cost(fit, samples, &field.weights);
                shared < MAX_COST && is_as_good(shared, *own)
            })
        })
    }

    /// Largest cost of a piece beyond what its own surface costs.
    fn excess(&self, field: &Field, fit: &Fit) -> f64 {
        let of = |(samples, own): &(Samples, f64)| excess_cost(mean_cost(fit, samples, &field.weights), *own);
        self.evidence.iter().map(of).fold(-COST_CAP, f64::max)
    }
}

/// Vertices in the half-plane through the axis, and the line through them.
struct Profile {
    axis: Axis,
    frame: Frame,
    /// Radius and height, and turn, of each vertex.
    at: Vec<(Vector2<f64>, f64)>,
    mean: Vector2<f64>,
    /// Unit normal of the line, out of the material.
    normal: Vector2<f64>,
}

impl Profile {
    fn of(field: &Field, axis: &Axis, vertices: &[u32]) -> Self {
        let frame = Frame::from_z(axis.origin, axis.direction);
        let samples = field.samples(vertices, N_FIT);
        let planar = |p: &Point3| {
            let local = frame.local(p);
            (Vector2::new(local.x.hypot(local.y), local.z), local.y.atan2(local.x))
        };
        let at: Vec<(Vector2<f64>, f64)> = samples.points.iter().map(planar).collect();
        let mean = at.iter().map(|p| p.0).sum::<Vector2<f64>>() / at.len().max(1) as f64;
        let spread: Matrix2<f64> = at.iter().map(|(p, _)| (p - mean) * (p - mean).transpose()).sum();
        let eigen = spread.symmetric_eigen();
        let across = usize::from(eigen.eigenvalues.y < eigen.eigenvalues.x);
        let line: Vector2<f64> = eigen.eigenvectors.column(across).into_owned();
        let outward =
            samples.points.iter().zip(&samples.normals).fold(Vector2::zeros(), |sum, (p, normal)| {
                let radial = axis.radial(p);
                let length = radial.norm().max(f64::MIN_POSITIVE);
                sum + Vector2::new(normal.dot(&radial) / length, normal.dot(&frame.z))
            });
        let normal = if line.dot(&outward) < 0.0 { -line } else { line };
        Self { axis: *axis, frame, at, mean, normal }
    }

    /// The lines along the axis or across it, if it is nearly so, and the best.
    fn lines(&self) -> Vec<Fit> {
        /// Cosine of the angle to the axis, or to the plane across it, within which that is tried.
        const NEARLY: f64 = 0.97;
        /// Radians within which a line is along the axis but for rounding.
        const EXACT: f64 = 1e-9;
        let turned = |normal: Vector2<f64>| {
            let normal = self.frame.x.into_inner() * normal.x + self.frame.z.into_inner() * normal.y;
            let point = self.frame.global(&Vec3::new(self.mean.x, 0.0, self.mean.y));
            turned_line(&self.axis, &point, &UnitVec3::new_normalize(normal), EXACT)
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
        const N_PARTS: usize = 12;
        const MIN_PARTS: usize = 4;
        /// Vertices of a part.
        const MIN_COUNT: usize = 20;
        /// Standard errors of the mean curvature.
        const CLEARLY: f64 = 4.0;
        let along = Vector2::new(-self.normal.y, self.normal.x);
        let local = |p: &Vector2<f64>| (along.dot(&(p - self.mean)), self.normal.dot(&(p - self.mean)));
        let reach = self.at.iter().map(|(p, _)| local(p).0.abs()).fold(0.0, f64::max);
        let mut parts: Vec<Vec<(f64, f64)>> = vec![Vec::new(); N_PARTS];
        for (p, turn) in &self.at {
            let share = (turn / std::f64::consts::TAU).rem_euclid(1.0);
            parts[((share * N_PARTS as f64) as usize).min(N_PARTS - 1)].push(local(p));
        }
        let bends: Vec<f64> =
            parts.iter().filter(|p| p.len() >= MIN_COUNT).filter_map(|p| curvature(p)).collect();
        let n = bends.len() as f64;
        let mean = bends.iter().sum::<f64>() / n.max(1.0);
        let variance = bends.iter().map(|b| (b - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        let sagitta = 0.5 * mean.abs() * reach * reach;
        bends.len() >= MIN_PARTS && mean.abs() > CLEARLY * (variance / n).sqrt() && sagitta > sigma
    }
}

/// Second derivative of the parabola nearest to `(along, off)` points.
fn curvature(points: &[(f64, f64)]) -> Option<f64> {
    let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
    for &(u, w) in points {
        let row = Vec3::new(1.0, u, u * u);
        matrix += row * row.transpose();
        right += row * w;
    }
    Some(2.0 * (matrix.try_inverse()? * right).z)
}

/// Pairs of regions that touch, ascending.
fn touching(field: &Field, regions: &Regions) -> Vec<(u32, u32)> {
    let mut pairs = Vec::new();
    for v in 0..field.n_vertices() {
        let Some(a) = regions.of_vertex[v] else { continue };
        let other = field.rings.row(v).iter().filter_map(|&u| regions.of_vertex[u as usize]);
        pairs.extend(other.filter(|&b| a < b).map(|b| (a, b)));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A profile along x, 20 long all round the turn, of `off` by place along it and turn.
    fn profile(off: impl Fn(f64, f64) -> f64) -> Profile {
        let axis = Axis { origin: Point3::origin(), direction: Vec3::z_axis() };
        let frame = Frame::from_z(axis.origin, axis.direction);
        let at = (0..4000).map(|i| {
            let (along, turn) =
                (f64::from(i % 40) * 0.5 - 9.75, f64::from(i / 40) * 0.01 * std::f64::consts::TAU);
            (Vector2::new(30.0 + along, off(along, turn)), turn)
        });
        let mean = Vector2::new(30.0, 0.0);
        Profile { axis, frame, at: at.collect(), mean, normal: Vector2::y() }
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
