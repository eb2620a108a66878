//! How well a scan determines its place: covariance, motions it leaves free, and how many of its points say something new.
//!
//! Distances of neighbouring vertices have their errors in common: the noise of a fused scan is correlated, and so is a
//! part's departure from its model. How much is read from the distances themselves: sums over cells of growing size have
//! the variance of so many independent values as the cell holds samples. The covariance of the motion is that of
//! robust regression with each point counting so much less (P. Huber, "Robust Statistics" (1981), section 7.6).

use nalgebra::{SMatrix, SVector};

use super::fine::{Contact, Mat7, Settled, Sums, TUKEY, Vec7};
use super::{Alignment, FoundBy};
use crate::math::{Axis, Mat3, Point3, UnitVec3, Vec3, symmetric_eigen, try_unit};

/// Motions that a scan leaves free.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Freedom {
    /// None: its place is determined.
    #[default]
    None,
    /// Turns about an axis: a turned part.
    Turn(Axis),
    /// Ways along a direction: a profile without ends.
    Slide(UnitVec3),
    /// Turns and ways along one axis: a cylinder without ends.
    TurnAndSlide(Axis),
    /// Turns about a point: a sphere.
    TurnsAbout(Point3),
    /// Turns about a direction and ways across it: a plane.
    InPlane(UnitVec3),
    /// So many others.
    Other(usize),
}

impl Freedom {
    /// How many numbers of the motion are free.
    pub fn count(&self) -> usize {
        match self {
            Self::None => 0,
            Self::Turn(_) | Self::Slide(_) => 1,
            Self::TurnAndSlide(_) => 2,
            Self::TurnsAbout(_) | Self::InPlane(_) => 3,
            Self::Other(n) => *n,
        }
    }

    /// One phrase; `None` when nothing is free.
    pub fn text(&self) -> Option<String> {
        let of = |d: &Vec3| format!("({:.4}, {:.4}, {:.4})", d.x, d.y, d.z);
        match self {
            Self::None => None,
            Self::Turn(axis) => Some(format!(
                "its turn about the axis through {} along {}",
                of(&axis.origin.coords),
                of(&axis.direction)
            )),
            Self::Slide(d) => Some(format!("its place along {}", of(d))),
            Self::TurnAndSlide(axis) => Some(format!(
                "its turn about the axis through {} along {}, and its place along it",
                of(&axis.origin.coords),
                of(&axis.direction)
            )),
            Self::TurnsAbout(point) => Some(format!("its turns about {}", of(&point.coords))),
            Self::InPlane(n) => Some(format!("its turn about {} and its place across it", of(n))),
            Self::Other(n) => Some(format!("{n} of the six numbers of its place")),
        }
    }
}

/// Turns in units in which a point at the radius moves as far as by a way.
pub(super) fn scale(radius: f64) -> SVector<f64, 6> {
    SVector::from([1.0 / radius, 1.0 / radius, 1.0 / radius, 1.0, 1.0, 1.0])
}

/// A matrix over turns and ways in those units.
pub(super) fn scaled(matrix: &SMatrix<f64, 6, 6>, radius: f64) -> SMatrix<f64, 6, 6> {
    let s = scale(radius);
    SMatrix::from_fn(|i, j| matrix[(i, j)] * s[i] * s[j])
}

/// Largest standard uncertainty of a way, as a share of the part's radius, at which a motion is still determined.
const UNDETERMINED: f64 = 0.01;
/// Share of the largest information below which there is none but rounding's.
pub(super) const NO_INFORMATION: f64 = 1e-8;

/// Whether an eigenvalue of the scaled information leaves its motion free.
fn is_free(value: f64, largest: f64, settled: &Settled) -> bool {
    let variance = settled.sigma.powi(2) * settled.vertices_per_sample / value.max(f64::MIN_POSITIVE);
    value <= NO_INFORMATION * largest || variance.sqrt() > UNDETERMINED * settled.radius
}

/// The motions that the contacts leave free.
pub(super) fn freedom(settled: &Settled) -> Freedom {
    let sums = Sums::new(&settled.contacts, TUKEY * settled.sigma, |f| settled.face_weights[f as usize]);
    let prior_weight = settled.prior.weight(settled.sigma, settled.vertices_per_sample);
    let eigen = scaled(&sums.of_motion(prior_weight), settled.radius).symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let free: Vec<SVector<f64, 6>> = eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
        .filter(|(value, _)| is_free(**value, largest, settled))
        .map(|(_, vector)| vector.component_mul(&scale(settled.radius)))
        .collect();
    named(&free, &settled.pivot, settled.radius)
}

/// Which motions these are. `free`: turns about the pivot and ways.
fn named(free: &[SVector<f64, 6>], pivot: &Point3, radius: f64) -> Freedom {
    /// Share of a motion below which it is none.
    const SMALL: f64 = 0.1;
    let turns: Vec<Vec3> = free.iter().map(|m| m.fixed_rows::<3>(0) * radius).collect();
    let ways: Vec<Vec3> = free.iter().map(|m| m.fixed_rows::<3>(3).into_owned()).collect();
    let spread: Mat3 = turns.iter().map(|t| t * t.transpose()).sum();
    let values = symmetric_eigen(&spread);
    let rank = values.iter().filter(|(value, _)| *value > SMALL * SMALL).count();
    let along = values[2].1;
    // The motion with the most turn about that direction, and where its axis runs.
    let axis = || {
        let (mut turn, mut way) = (Vec3::zeros(), Vec3::zeros());
        for (t, w) in turns.iter().zip(&ways) {
            let share = t.dot(&along);
            turn += t / radius * share;
            way += w * share;
        }
        let origin = pivot + turn.cross(&way) / turn.norm_squared();
        Axis { origin, direction: along }
    };
    match (free.len(), rank) {
        (0, _) => Freedom::None,
        (1, 1) => Freedom::Turn(axis()),
        (1, 0) => try_unit(ways[0]).map_or(Freedom::Other(1), Freedom::Slide),
        (2, 1) => {
            let slide = ways[0] * turns[1].dot(&along) - ways[1] * turns[0].dot(&along);
            let straight = try_unit(slide).is_some_and(|s| s.cross(&along).norm() < SMALL);
            if straight { Freedom::TurnAndSlide(axis()) } else { Freedom::Other(2) }
        }
        (3, 1) => Freedom::InPlane(along),
        (3, 3) => still_point(&turns, &ways, pivot, radius).map_or(Freedom::Other(3), Freedom::TurnsAbout),
        (n, _) => Freedom::Other(n),
    }
}

/// The point that none of some motions moves.
fn still_point(turns: &[Vec3], ways: &[Vec3], pivot: &Point3, radius: f64) -> Option<Point3> {
    let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
    for (turn, way) in turns.iter().zip(ways) {
        let turn = turn / radius;
        // way + turn x p = 0 for p from the pivot.
        let rows = turn.cross_matrix();
        matrix += rows.transpose() * rows;
        right -= rows.transpose() * way;
    }
    matrix.try_inverse().map(|inverse| pivot + inverse * right)
}

/// The result: pose, covariance and counts. Alternatives are left to the caller.
pub(super) fn alignment(settled: &Settled, freedom: Freedom, found_by: FoundBy) -> Alignment {
    let sums = Sums::new(&settled.contacts, TUKEY * settled.sigma, |f| settled.face_weights[f as usize]);
    let covariance = covariance(&sums, settled);
    Alignment {
        pose: settled.state.pose,
        bend: settled.state.bend,
        bend_uncertainty: covariance[(6, 6)].max(0.0).sqrt(),
        covariance: std::array::from_fn(|i| std::array::from_fn(|j| covariance[(i, j)])),
        pivot: settled.pivot,
        radius: settled.radius,
        freedom,
        alternatives: Vec::new(),
        sigma: settled.sigma,
        vertices_per_sample: settled.vertices_per_sample,
        n_points: settled.contacts.len(),
        explained: settled.explained,
        found_by,
    }
}

/// `A^-1 B A^-1` over the motions that are determined and the bend, points counting by how many say something new.
fn covariance(sums: &Sums, settled: &Settled) -> Mat7 {
    let prior_weight = settled.prior.weight(settled.sigma, settled.vertices_per_sample);
    let eigen = scaled(&sums.of_motion(prior_weight), settled.radius).symmetric_eigen();
    let largest = eigen.eigenvalues.max().max(f64::MIN_POSITIVE);
    let mut shown = Mat7::zeros();
    shown[(6, 6)] = 1.0;
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if !is_free(*value, largest, settled) {
            let mut block = shown.fixed_view_mut::<6, 6>(0, 0);
            block += vector * vector.transpose();
        }
    }
    let hidden = (Mat7::identity() - shown) * largest;
    let curvature = scaled7(&sums.curvature, settled.radius);
    // In the same units as the rest: the bend over the radius squared is of the size of a distance over the radius.
    let observed = prior_weight * settled.radius.powi(2);
    let mut regular = shown * curvature * shown + hidden;
    regular[(6, 6)] += observed.max(f64::MIN_POSITIVE);
    let Some(inverse) = regular.try_inverse() else { return Mat7::zeros() };
    let inverse = shown * inverse * shown;
    let mut scatter = scaled7(&sums.scatter, settled.radius) * settled.vertices_per_sample;
    scatter[(6, 6)] += observed * settled.sigma.powi(2) * settled.vertices_per_sample;
    scaled7(&(inverse * scatter * inverse), settled.radius)
}

/// Seven numbers in units of ways: see [`scale`].
fn scaled7(matrix: &Mat7, radius: f64) -> Mat7 {
    let s = scale(radius);
    let s = Vec7::from_fn(|i, _| if i < 6 { s[i] } else { radius });
    Mat7::from_fn(|i, j| matrix[(i, j)] * s[i] * s[j])
}

/// Points per independent sample among contacts: see the module. `spacing`: of the scan.
pub(super) fn correlation(contacts: &[Contact], scale: f64, spacing: f64) -> f64 {
    let values: Vec<(u32, Point3, f64)> =
        contacts.iter().filter(|c| c.distance.abs() < scale).map(|c| (c.face, c.foot, c.distance)).collect();
    vertices_per_sample(&values, spacing)
}

/// Points per independent sample of values at places, one (group, place, value) each; values of different groups are
/// independent. At least one. `spacing`: mean distance of neighbouring places.
pub fn vertices_per_sample(values: &[(u32, Point3, f64)], spacing: f64) -> f64 {
    /// Cells without which a variance means nothing: it is known to a fifth.
    const LEAST_CELLS: usize = 50;
    /// Sizes of cells, spacings: from a few vertices to more than any correlation length of a fused scan.
    const SIZES: [f64; 5] = [2.0, 4.0, 8.0, 16.0, 32.0];
    let total: f64 = values.iter().map(|(_, _, v)| v * v).sum();
    let mut most: f64 = 1.0;
    for size in SIZES {
        let cell = |p: &Point3| [p.x, p.y, p.z].map(|x| (x / (size * spacing)).floor() as i64);
        let mut keyed: Vec<((u32, [i64; 3]), f64)> =
            values.iter().map(|(group, place, value)| ((*group, cell(place)), *value)).collect();
        keyed.sort_by_key(|a| a.0);
        let sums: Vec<f64> =
            keyed.chunk_by(|a, b| a.0 == b.0).map(|cell| cell.iter().map(|c| c.1).sum::<f64>()).collect();
        if sums.len() < LEAST_CELLS || total <= 0.0 {
            break;
        }
        most = most.max(sums.iter().map(|s| s * s).sum::<f64>() / total);
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Rng;

    #[test]
    fn free_motions_are_named_with_their_place() {
        let (pivot, radius) = (Point3::new(1.0, 2.0, 3.0), 10.0);
        // A turn about the line through (4, 6, ...) along z: the pivot moves by z x (pivot - origin).
        let z = Vec3::z();
        let origin = Point3::new(4.0, 6.0, 0.0);
        let way = z.cross(&(pivot - origin));
        let turn = SVector::<f64, 6>::from([0.0, 0.0, 1.0, way.x, way.y, way.z]) / radius;
        let Freedom::Turn(axis) = named(&[turn], &pivot, radius) else { panic!("a turn") };
        assert!((axis.foot(&origin) - origin).norm() < 1e-9 && axis.direction.dot(&z).abs() > 0.999);
        let slide = SVector::<f64, 6>::from([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert!(matches!(named(&[slide], &pivot, radius), Freedom::Slide(_)));
        let mixed = [turn + slide * 0.3, turn * 0.4 - slide];
        assert!(matches!(named(&mixed, &pivot, radius), Freedom::TurnAndSlide(_)));
    }

    #[test]
    fn points_per_sample_are_counted_for_white_and_for_smoothed_noise() {
        let mut rng = Rng::for_task(3, "spread", 0);
        let n = 160_usize;
        let white: Vec<f64> = (0..n * n).map(|_| rng.normal()).collect();
        let at = |i: usize| Point3::new((i % n) as f64, (i / n) as f64, 0.0);
        let values: Vec<_> = (0..n * n).map(|i| (0, at(i), white[i])).collect();
        let of_white = vertices_per_sample(&values, 1.0);
        assert!((1.0..1.6).contains(&of_white), "{of_white}");
        // Blocks of 3 x 3 share a value: nine per sample.
        let values: Vec<_> = (0..n * n).map(|i| (0, at(i), white[i / n / 3 * n + i % n / 3])).collect();
        let of_blocks = vertices_per_sample(&values, 1.0);
        assert!((8.0..13.0).contains(&of_blocks), "{of_blocks}");
    }
}
