//! The surface from which the farthest point is nearest: the minimum zone of form standards (ISO 1101, ISO 12180, ISO
//! 12781).
//!
//! The distances are linear in small steps of the parameters up to the square of the form deviation over the size, so a
//! few linear programs, minimize `t` with `|d_i + J_i step| <= t`, lead from the least-squares surface to it. A program
//! holds the points near the limits only; those that a step lets through join it (the exchange of E. Remez, Comptes
//! Rendus de l'Académie des Sciences 198 (1934), 2063-2065, by the set). It is solved by an interior-point method (S.
//! Mehrotra, "On the implementation of a primal-dual interior point method", SIAM Journal on Optimization 2 (1992),
//! 575-601).
//!
//! Cost: a pass over the points per round, at most `ROUNDS`. No guarantee where a type is nearly undetermined by its
//! points: the best surface met is returned, which is never worse than the start.

use nalgebra::{DMatrix, DVector};

use super::{distance_by_parameters, parameter_frame, stepped};
use crate::math::{Point3, centroid};
use crate::surface::Surface;

/// Linear programs at most.
const ROUNDS: usize = 30;
/// Points that the first program holds.
const FIRST: usize = 120;
/// Points that join it per round.
const JOINING: usize = 40;
/// Fall of the largest distance, as a share, that ends it.
const RELATIVE_FALL: f64 = 1e-9;

/// The surface near `start` whose largest distance from `points` is least, and the width of the zone between its two
/// parallel surfaces that holds all points: twice that distance.
pub fn minimum_zone(start: &Surface, points: &[Point3]) -> (Surface, f64) {
    let frame = parameter_frame(start, centroid(points));
    let distances =
        |surface: &Surface| -> Vec<f64> { points.iter().map(|p| surface.signed_distance(p)).collect() };
    let mut best = (*start, distances(start));
    let mut members: Vec<usize> = farthest(&best.1, FIRST);
    for _ in 0..ROUNDS {
        let width = largest(&best.1);
        let rows: Vec<DVector<f64>> =
            members.iter().map(|&i| distance_by_parameters(&best.0, &frame, &points[i])).collect();
        let values: Vec<f64> = members.iter().map(|&i| best.1[i]).collect();
        let Some(step) = least_largest(&rows, &values) else { break };
        // Half the way where the whole one leaves the range in which distances are linear.
        let tried = [1.0, 0.5, 0.25].iter().find_map(|share| {
            let scaled: Vec<f64> = step.iter().map(|s| s * share).collect();
            let surface = stepped(&best.0, &frame, &scaled)?;
            let found = distances(&surface);
            (largest(&found) < width).then_some((surface, found))
        });
        let joined = |found: &[f64], members: &mut Vec<usize>| {
            let before = members.len();
            members.extend(farthest(found, JOINING));
            members.sort_unstable();
            members.dedup();
            members.len() > before
        };
        if let Some(next) = tried {
            let fell = width - largest(&next.1) > RELATIVE_FALL * width;
            let new = joined(&next.1, &mut members);
            best = next;
            if !fell && !new {
                break;
            }
        } else {
            let whole = stepped(&best.0, &frame, step.as_slice()).map(|s| distances(&s));
            if !whole.is_some_and(|found| joined(&found, &mut members)) {
                break;
            }
        }
    }
    (best.0, 2.0 * largest(&best.1))
}

fn largest(distances: &[f64]) -> f64 {
    distances.iter().fold(0.0, |m: f64, d| m.max(d.abs()))
}

/// The points with the largest distances.
fn farthest(distances: &[f64], n: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..distances.len()).collect();
    let by_size = |a: &usize, b: &usize| distances[*b].abs().total_cmp(&distances[*a].abs()).then(a.cmp(b));
    if n < order.len() {
        order.select_nth_unstable_by(n, by_size);
        order.truncate(n);
    }
    order.sort_unstable();
    order
}

/// The step that makes the largest of `|values + rows step|` least; `None` when rounding ends it early.
fn least_largest(rows: &[DVector<f64>], values: &[f64]) -> Option<DVector<f64>> {
    const STEPS: usize = 60;
    /// Complementarity, as a share of the largest value, at which the answer is found.
    const EXACT: f64 = 1e-12;
    /// Share of the trace, a hundred roundings, that keeps unknowns which nothing shows from making the system singular.
    const UNSHOWN: f64 = 1e-14;
    let n = rows.first()?.len() + 1;
    let size = values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    if size == 0.0 {
        return None;
    }
    // Unknowns in units in which each moves the points by the size at most.
    let scale: Vec<f64> =
        (0..n - 1).map(|j| size / rows.iter().fold(f64::MIN_POSITIVE, |m, r| m.max(r[j].abs()))).collect();
    let m = 2 * rows.len();
    let matrix = DMatrix::from_fn(m, n, |i, j| {
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        if j + 1 == n { -1.0 } else { sign * rows[i / 2][j] * scale[j] / size }
    });
    let right = DVector::from_fn(m, |i, _| (if i % 2 == 0 { -1.0 } else { 1.0 }) * values[i / 2] / size);
    let mut x = DVector::zeros(n);
    x[n - 1] = 1.1;
    let mut slack = &right - &matrix * &x;
    let mut dual = DVector::from_element(m, 1.0 / m as f64);
    let mut cost = DVector::zeros(n);
    cost[n - 1] = 1.0;
    for _ in 0..STEPS {
        let gap = slack.dot(&dual);
        if gap < EXACT {
            break;
        }
        let residual = &cost + matrix.transpose() * &dual;
        let weights = dual.component_div(&slack);
        let mut system = matrix.transpose() * DMatrix::from_fn(m, n, |i, j| weights[i] * matrix[(i, j)]);
        let trace = system.trace();
        for i in 0..n {
            system[(i, i)] += UNSHOWN * trace;
        }
        let factors = system.cholesky()?;
        let solve = |center: &DVector<f64>| {
            // center: what slack times dual shall become, less what it is.
            let pull = center.component_div(&slack);
            let dx = factors.solve(&(-&residual - matrix.transpose() * &pull));
            let ds = -(&matrix * &dx);
            let dz = (center - dual.component_mul(&ds)).component_div(&slack);
            (dx, ds, dz)
        };
        let products = slack.component_mul(&dual);
        let (_, ds, dz) = solve(&-&products);
        let (to_wall, to_dual) = (room(&slack, &ds), room(&dual, &dz));
        let after = (&slack + &ds * to_wall).dot(&(&dual + &dz * to_dual));
        let target = (after / gap).powi(3) * gap / m as f64;
        let corrected = DVector::from_fn(m, |i, _| target - products[i] - ds[i] * dz[i]);
        let (dx, ds, dz) = solve(&corrected);
        let (to_wall, to_dual) = (0.99 * room(&slack, &ds), 0.99 * room(&dual, &dz));
        x += dx * to_wall.min(1.0);
        slack += ds * to_wall.min(1.0);
        dual += dz * to_dual.min(1.0);
        if !x.iter().all(|v| v.is_finite()) {
            return None;
        }
    }
    Some(DVector::from_fn(n - 1, |j, _| x[j] * scale[j]))
}

/// How far `values` may go along `way` and stay positive, at most a little over the whole way.
fn room(values: &DVector<f64>, way: &DVector<f64>) -> f64 {
    let limits = values.iter().zip(way.iter()).filter(|(_, w)| **w < 0.0).map(|(v, w)| -v / w);
    limits.fold(1.0 / 0.99, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Axis, UnitVec3, Vec3};
    use crate::random::Rng;
    use crate::surface::{Cylinder, Plane, Sphere};

    #[test]
    fn four_points_of_a_folded_square_have_a_zone_of_their_fold() {
        // Two opposite corners lifted by one: the zone between two planes is one wide, whatever the tilt tried.
        let points =
            [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 0.0]].map(Point3::from).to_vec();
        let start = Surface::Plane(Plane { point: Point3::new(0.0, 0.0, 0.7), normal: Vec3::z_axis() });
        let (_, width) = minimum_zone(&start, &points);
        assert!((width - 1.0).abs() < 1e-9, "{width}");
    }

    #[test]
    fn a_planted_zone_is_found_and_is_never_wider_than_least_squares() {
        let mut rng = Rng::for_task(5, "zones", 0);
        let axis = Axis {
            origin: Point3::new(3.0, -2.0, 1.0),
            direction: UnitVec3::new_normalize(Vec3::new(0.2, 0.1, 1.0)),
        };
        let frame = parameter_frame(&Surface::Cylinder(Cylinder { axis, radius: 8.0 }), axis.origin);
        // A wall whose deviation is a wave of three lobes, 0.02 high each way: its zone is that and no less.
        let points: Vec<Point3> = (0..4000)
            .map(|_| {
                let (angle, height) = (std::f64::consts::TAU * rng.uniform(), 20.0 * rng.uniform() - 10.0);
                let radius = 8.0 + 0.02 * (3.0 * angle).cos();
                frame.global(&Vec3::new(radius * angle.cos(), radius * angle.sin(), height))
            })
            .collect();
        let off = Axis { origin: axis.origin + Vec3::new(0.01, 0.004, 0.0), ..axis };
        let start = Surface::Cylinder(Cylinder { axis: off, radius: 8.01 });
        let (found, width) = minimum_zone(&start, &points);
        assert!((width - 0.04).abs() < 2e-4, "{width}");
        let Surface::Cylinder(found) = found else { panic!("stays a cylinder") };
        assert!((found.radius - 8.0).abs() < 1e-4, "{}", found.radius);
    }

    #[test]
    fn random_steps_around_a_sphere_find_nothing_better() {
        let mut rng = Rng::for_task(6, "zones", 0);
        let center = Point3::new(1.0, 2.0, 3.0);
        let mut direction = || Vec3::new(rng.normal(), rng.normal(), rng.normal().abs()).normalize();
        let points: Vec<Point3> =
            (0..500).map(|_| center + direction() * (5.0 + 0.01 * direction().x)).collect();
        let start = Surface::Sphere(Sphere { center, radius: 5.0 });
        let (found, width) = minimum_zone(&start, &points);
        let frame = parameter_frame(&found, centroid(&points));
        let mut better: f64 = 0.0;
        for scale in [1e-3, 1e-4, 1e-5] {
            for _ in 0..300 {
                let step = [direction() * scale, direction() * scale];
                let moved = stepped(&found, &frame, &[step[0].x, step[0].y, step[1].x, step[1].y]).unwrap();
                let zone = 2.0 * points.iter().fold(0.0, |m: f64, p| m.max(moved.signed_distance(p).abs()));
                better = better.max(width - zone);
            }
        }
        assert!(better < 1e-8, "a zone narrower by {better} is beside it");
    }
}
