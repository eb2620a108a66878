//! Robust orthogonal-distance fit of any of the five surfaces.
//!
//! Minimizes `sum rho(D)`, `D = (d / sigma_d)^2 + w |n - n_S|^2 / sigma_n^2` with Cauchy's `rho` at three sigmas, by
//! Levenberg-Marquardt over six motions and two shape parameters. One formula gives the Jacobian of every type: when
//! the surface moves by `t` and turns by `omega` about a pivot, `d` changes by `-n.t - ((p - pivot) x n).omega`
//! (method of D. Shakarji, "Least-squares fitting algorithms of the NIST algorithm testing system", Journal of
//! Research of NIST 103 (1998), 633-641, in coordinate-free form). Motions that a type cannot show (a plane sliding
//! in itself) have zero columns and stay zero under the damping.
//!
//! Cost O(samples) per step, at most `max_steps` steps.

use nalgebra::{Rotation3, SVector};

use super::{Fit, Samples};
use crate::math::least_squares::{Normal, RELATIVE_FALL, minimize_to};
use crate::math::{Axis, Point3, Vec3, centroid};
use crate::surface::Surface;

/// How distances and normals are weighed against each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Standard deviation of distances, length.
    pub distance_sigma: f64,
    /// Standard deviation of normals, radians.
    pub normal_sigma: f64,
    /// Weight of the normal term; zero fits distances alone.
    pub normal_weight: f64,
}

impl Weights {
    /// Cost of one sample under a surface: squared distance and normal deviation in units of their deviations.
    pub fn cost(&self, fit: &Fit, point: &Point3, normal: &Vec3) -> f64 {
        let (distance, surface_normal) = fit.distance_and_outward_normal(point);
        let scaled = distance / self.distance_sigma;
        let tilt_sq = (normal - surface_normal).norm_squared();
        scaled * scaled + self.normal_weight * tilt_sq / (self.normal_sigma * self.normal_sigma)
    }
}

/// Square of the scale, in sigmas, at which Cauchy's function starts to discount a residual.
const CAUCHY_SQ: f64 = 9.0;

/// Fits a surface of the type of `start` to `samples`, from `start`.
///
/// `None` when the surface runs away (a radius not positive, a cone flat or closed).
pub fn refine(start: &Fit, samples: &Samples, weights: &Weights, max_steps: usize) -> Option<Fit> {
    refine_to(RELATIVE_FALL, start, samples, Loss::Cauchy(weights), max_steps)
}

/// The surface of least squares of the orthogonal distances alone, all counting alike, from a start near it.
///
/// It goes on until rounding ends it: where points hardly determine a parameter, the last millionth of the cost moves it
/// far.
pub fn least_squares(start: &Fit, samples: &Samples, max_steps: usize) -> Option<Fit> {
    refine_to(0.0, start, samples, Loss::Square, max_steps)
}

/// What a deviation costs.
#[derive(Clone, Copy)]
enum Loss<'a> {
    /// Distances and tilts in their deviations, large ones discounted.
    Cauchy(&'a Weights),
    /// Distances, squared.
    Square,
}

fn refine_to(
    relative_fall: f64,
    start: &Fit,
    samples: &Samples,
    loss: Loss,
    max_steps: usize,
) -> Option<Fit> {
    let pivot = centroid(&samples.points);
    let outward = start.outward;
    let start = recentered(&start.surface, &pivot);
    let linearize = |surface: &Surface| match loss {
        Loss::Cauchy(weights) => normal_equations(surface, outward, samples, weights, &pivot),
        Loss::Square => square_equations(surface, samples, &pivot),
    };
    let retract = |surface: &Surface, step: &SVector<f64, 8>| moved(surface, step, &pivot);
    let (surface, _, _) = minimize_to(relative_fall, start, max_steps, linearize, retract);
    let surface = recentered(&surface, &pivot);
    let size = surface_is_sane(&surface);
    size.then_some(Fit { surface, outward })
}

fn square_equations(surface: &Surface, samples: &Samples, pivot: &Point3) -> Normal<8> {
    let mut sum = Normal::zero();
    surface.for_each_jet(&samples.points, |i, jet| {
        let arm = samples.points[i] - pivot;
        let across = row8(-jet.normal, arm.cross(&-jet.normal), jet.distance_by_shape, 1.0);
        sum.add([jet.distance], &[across], 1.0);
        sum.cost += jet.distance * jet.distance;
    });
    sum
}

fn normal_equations(
    surface: &Surface,
    outward: bool,
    samples: &Samples,
    weights: &Weights,
    pivot: &Point3,
) -> Normal<8> {
    let sign = if outward { 1.0 } else { -1.0 };
    let per_distance = 1.0 / weights.distance_sigma;
    let per_tilt = weights.normal_weight.sqrt() / weights.normal_sigma;
    let mut sum = Normal::zero();
    let mut logarithms = LogSum::default();
    surface.for_each_jet(&samples.points, |i, jet| {
        let arm = samples.points[i] - pivot;
        let observed = samples.normals[i] * sign;
        let scaled = jet.distance * per_distance;
        let tilt_sq = (observed - jet.normal).norm_squared() * per_tilt * per_tilt;
        let discount = 1.0 + (scaled * scaled + tilt_sq) / CAUCHY_SQ;
        logarithms.add(discount);
        let across = row8(-jet.normal, arm.cross(&-jet.normal), jet.distance_by_shape, per_distance);
        if per_tilt == 0.0 {
            sum.add([scaled], &[across], 1.0 / discount);
            return;
        }
        let along = [jet.tilt_by_shape, [0.0; 2]];
        let tilts: [_; 2] = std::array::from_fn(|k| {
            let (tangent, curvature) = (jet.tangents[k], jet.curvatures[k]);
            let turn = arm.cross(&tangent) * curvature - observed.cross(&tangent);
            row8(tangent * curvature, turn, along[k], per_tilt)
        });
        let residuals = jet.tangents.map(|tangent| observed.dot(&tangent) * per_tilt);
        sum.add([scaled, residuals[0], residuals[1]], &[across, tilts[0], tilts[1]], 1.0 / discount);
    });
    sum.cost = CAUCHY_SQ * logarithms.sum();
    sum
}

fn row8(translation: Vec3, turn: Vec3, shape: [f64; 2], scale: f64) -> [f64; 8] {
    let (t, w) = (translation * scale, turn * scale);
    [t.x, t.y, t.z, w.x, w.y, w.z, shape[0] * scale, shape[1] * scale]
}

/// A sum of logarithms, taken as those of products: a logarithm costs as much as all else of a sample.
struct LogSum {
    product: f64,
    sum: f64,
}

impl Default for LogSum {
    fn default() -> Self {
        Self { product: 1.0, sum: 0.0 }
    }
}

impl LogSum {
    /// Adds the logarithm of `factor`, which is at least one.
    fn add(&mut self, factor: f64) {
        /// Far from overflow by one more factor.
        const LARGE: f64 = 1e150;
        self.product *= factor;
        if self.product > LARGE {
            self.sum = self.sum();
            self.product = 1.0;
        }
    }

    fn sum(&self) -> f64 {
        self.sum + self.product.ln()
    }
}

/// The surface moved by a step; `None` when that leaves the shapes that exist.
pub(super) fn moved(surface: &Surface, step: &SVector<f64, 8>, pivot: &Point3) -> Option<Surface> {
    /// Largest turn of one step, radians: beyond it the linear model says nothing.
    const LARGEST_TURN: f64 = 0.5;
    let turn = Vec3::new(step[3], step[4], step[5]);
    if !step.iter().all(|s| s.is_finite()) || turn.norm() > LARGEST_TURN {
        return None;
    }
    let rotation = Rotation3::new(turn);
    let translation = pivot.coords - rotation * pivot.coords + Vec3::new(step[0], step[1], step[2]);
    let mut surface = surface.transformed(&rotation, 1.0, &translation);
    match &mut surface {
        Surface::Plane(_) => {}
        Surface::Cylinder(s) => s.radius += step[6],
        Surface::Sphere(s) => s.radius += step[6],
        Surface::Cone(s) => {
            s.radius += step[6];
            s.half_angle += step[7];
            if s.half_angle < 0.0 {
                s.half_angle = -s.half_angle;
                s.axis.direction = -s.axis.direction;
            }
        }
        Surface::Torus(s) => {
            s.major_radius += step[6];
            s.minor_radius += step[7];
        }
    }
    surface_is_sane(&surface).then_some(surface)
}

fn surface_is_sane(surface: &Surface) -> bool {
    if !surface.is_finite() {
        return false;
    }
    match surface {
        Surface::Plane(_) => true,
        Surface::Cylinder(s) => s.radius > 0.0,
        Surface::Sphere(s) => s.radius > 0.0,
        Surface::Cone(s) => {
            s.radius > 0.0 && s.half_angle > 0.0 && s.half_angle < std::f64::consts::FRAC_PI_2
        }
        Surface::Torus(s) => s.minor_radius > 0.0 && s.major_radius > -s.minor_radius,
    }
}

/// The same surface with its reference point beside `pivot`, so that parameters are well conditioned there.
pub(super) fn recentered(surface: &Surface, pivot: &Point3) -> Surface {
    let at_foot = |axis: &Axis| Axis { origin: axis.foot(pivot), direction: axis.direction };
    let mut surface = *surface;
    match &mut surface {
        Surface::Plane(s) => s.point = pivot - s.normal.into_inner() * s.signed_distance(pivot),
        Surface::Cylinder(s) => s.axis = at_foot(&s.axis),
        Surface::Cone(s) => {
            let radius = s.radius + s.axis.height(pivot) * s.half_angle.tan();
            if radius > 0.0 {
                s.radius = radius;
                s.axis = at_foot(&s.axis);
            }
        }
        Surface::Sphere(_) | Surface::Torus(_) => {}
    }
    surface
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::UnitVec3;
    use crate::surface::samples::{Patch, sample};
    use crate::surface::{Cone, Cylinder, Plane, Sphere, SurfaceKind, Torus};

    fn planted() -> Vec<(Surface, Patch)> {
        let direction = UnitVec3::new_normalize(Vec3::new(1.0, 2.0, -0.5));
        let axis = Axis { origin: Point3::new(30.0, -20.0, 10.0), direction };
        vec![
            (
                Surface::Plane(Plane { point: axis.origin, normal: direction }),
                Patch { u: (-10.0, 10.0), v: (-5.0, 5.0) },
            ),
            (Surface::Cylinder(Cylinder { axis, radius: 8.0 }), Patch { u: (0.0, 2.0), v: (-6.0, 6.0) }),
            (
                Surface::Cone(Cone { axis, radius: 8.0, half_angle: 0.5 }),
                Patch { u: (0.0, 2.5), v: (-6.0, 6.0) },
            ),
            (
                Surface::Sphere(Sphere { center: axis.origin, radius: 9.0 }),
                Patch { u: (0.0, 2.0), v: (-0.6, 0.9) },
            ),
            (
                Surface::Torus(Torus { axis, major_radius: 20.0, minor_radius: 5.0 }),
                Patch { u: (0.0, 1.5), v: (-0.5, 1.5) },
            ),
        ]
    }

    #[test]
    fn every_type_is_recovered_from_points_and_normals() {
        let noise = 0.02;
        let weights = Weights { distance_sigma: noise, normal_sigma: 0.05, normal_weight: 0.02 };
        for (k, (surface, patch)) in planted().into_iter().enumerate() {
            let samples = sample(&surface, patch, 2000, noise, k as u64);
            let samples = Samples {
                points: samples.iter().map(|s| s.0).collect(),
                normals: samples.iter().map(|s| s.1.into_inner()).collect(),
            };
            let best = super::super::starts(surface.kind(), &samples)
                .iter()
                .filter_map(|start| refine(start, &samples, &weights, 40))
                .min_by(|a, b| rms(a, &samples).total_cmp(&rms(b, &samples)))
                .expect("some start converges");
            assert!(best.outward, "{:?}: normals are the natural ones", surface.kind());
            // The fitted surface stays within the noise of the planted one all over the patch.
            let worst = sample(&surface, patch, 200, 0.0, 99)
                .iter()
                .map(|(p, _)| best.surface.signed_distance(p).abs())
                .fold(0.0, f64::max);
            // Extrapolated to the corners of the patch the deviation is at most a few sigma / sqrt(n) per parameter.
            let bound = 6.0 * noise * (8.0_f64 / 2000.0).sqrt() * 3.0;
            assert!(worst < bound, "{:?}: {worst} over {bound}", surface.kind());
        }
        assert_eq!(planted().len(), SurfaceKind::ALL.len());
    }

    fn rms(fit: &Fit, samples: &Samples) -> f64 {
        let sum: f64 = samples.points.iter().map(|p| fit.surface.signed_distance(p).powi(2)).sum();
        (sum / samples.points.len() as f64).sqrt()
    }
}
