//! Solvers: orthogonal-distance least squares for the five surfaces, on points and normals.
//!
//! `start` gives closed-form first guesses from points and normals, `refine` the robust least-squares fit, `covariance`
//! and `noise` its uncertainty, `minimum_zone` the surface of least form deviation. [`fit_known`] fits a known type by the
//! product's method or by a baseline (`closed`, `pgp2x`). Nothing
//! here knows what a region is or which type is right.

mod closed;
mod covariance;
mod minimum_zone;
mod noise;
mod pgp2x;
mod refine;
mod start;

pub use covariance::{
    VERTICES_PER_SAMPLE, distance_by_parameters, parameter_covariance, parameter_frame, parameter_names,
    stepped,
};
pub use minimum_zone::minimum_zone;
pub use noise::{Noise, correlated_covariance};
pub use refine::{Weights, least_squares, refine};
pub use start::starts;

use crate::math::{Point3, Vec3};
use crate::surface::{Surface, SurfaceKind};

/// How the parameters of a known type are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FitMethod {
    /// Robust orthogonal distances, from all closed-form starts, then all but the outliers counting alike: the product's.
    Robust,
    /// Orthogonal distances alone, all counting alike, from the same starts: the least-squares geometric elements of
    /// metrology (C. Shakarji, Journal of Research of NIST 103 (1998), 633-641).
    Lsge,
    /// The thesis's.
    Pgp2x,
    /// Closed forms alone, of Attene and others (2006); no torus.
    Attene,
}

impl FitMethod {
    /// All of them, the product's first.
    pub const ALL: [Self; 4] = [Self::Robust, Self::Lsge, Self::Pgp2x, Self::Attene];

    /// Name for tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Robust => "ours",
            Self::Lsge => "LSGE",
            Self::Pgp2x => "PGP2X",
            Self::Attene => "Attene",
        }
    }
}

/// The surface of a known type through samples whose distances have the deviation `noise`; `None` where a method finds
/// none.
pub fn fit_known(kind: SurfaceKind, samples: &Samples, noise: f64, method: FitMethod) -> Option<Surface> {
    /// Fewer points lie on every plane.
    const LEAST_SAMPLES: usize = 3;
    /// Deviation that counts as none, of the extent.
    const EXACT: f64 = 1e-9;
    if samples.points.len() < LEAST_SAMPLES {
        return None;
    }
    let noise = noise.max(EXACT * extent(samples));
    match method {
        FitMethod::Robust => {
            iterated(kind, samples, noise).map(|found| without_outliers(&found, samples, noise))
        }
        FitMethod::Lsge => iterated_squares(kind, samples),
        FitMethod::Pgp2x => pgp2x::pgp2x(kind, samples),
        FitMethod::Attene => closed::attene(kind, samples),
    }
}

/// A fit once more, to the samples that are no outliers to it.
fn without_outliers(found: &Surface, samples: &Samples, noise: f64) -> Surface {
    /// Deviations beyond which a distance is no noise.
    const OUTLIER: f64 = 4.0;
    let kept = |p: &Point3| found.signed_distance(p).abs() <= OUTLIER * noise;
    let (points, normals) =
        samples.points.iter().zip(&samples.normals).filter(|(p, _)| kept(p)).map(|(p, n)| (*p, *n)).unzip();
    let kept = Samples { points, normals };
    // Where most are outliers the noise was told wrong.
    if 2 * kept.points.len() < samples.points.len() {
        return *found;
    }
    by_least_squares(found, &kept).unwrap_or(*found)
}

/// The best of the fits from all starts, by distance alone, distances of some `noise` discounted.
fn iterated(kind: SurfaceKind, samples: &Samples, noise: f64) -> Option<Surface> {
    let weights = Weights { distance_sigma: noise, normal_sigma: 1.0, normal_weight: 0.0 };
    let fit = |start: &Surface| {
        refine(&Fit { surface: *start, outward: true }, samples, &weights, STEPS).map(|fit| fit.surface)
    };
    best(kind, samples, fit, |distance| (distance / noise).powi(2).ln_1p())
}

/// The best of the least-squares fits from all starts.
fn iterated_squares(kind: SurfaceKind, samples: &Samples) -> Option<Surface> {
    best(kind, samples, |start| by_least_squares(start, samples), |distance| distance * distance)
}

/// The cheapest of the fits from all starts.
fn best(
    kind: SurfaceKind,
    samples: &Samples,
    fit: impl Fn(&Surface) -> Option<Surface>,
    cost_of: impl Fn(f64) -> f64,
) -> Option<Surface> {
    let fits = starts(kind, samples).into_iter().filter_map(|s| fit(&s.surface));
    let cost = |surface: &Surface| -> f64 {
        samples.points.iter().map(|p| cost_of(surface.signed_distance(p))).sum()
    };
    fits.map(|surface| (cost(&surface), surface)).min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
}

/// Steps of a fit.
const STEPS: usize = 60;

fn by_least_squares(start: &Surface, samples: &Samples) -> Option<Surface> {
    least_squares(&Fit { surface: *start, outward: true }, samples, STEPS).map(|fit| fit.surface)
}

/// Largest distance from the first point.
fn extent(samples: &Samples) -> f64 {
    let Some(first) = samples.points.first() else { return 0.0 };
    samples.points.iter().map(|p| (p - first).norm()).fold(0.0, f64::max)
}

/// Points with outward unit normals: what a surface is fitted to.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// Positions.
    pub points: Vec<Point3>,
    /// One per point: unit normal, out of the material.
    pub normals: Vec<Vec3>,
}

impl Samples {
    /// These samples, then those of `other`.
    #[must_use]
    pub fn followed_by(&self, other: &Self) -> Self {
        Self {
            points: self.points.iter().chain(&other.points).copied().collect(),
            normals: self.normals.iter().chain(&other.normals).copied().collect(),
        }
    }

    /// Every so manieth sample, so that at most `n` remain; deterministic and spread over the order given.
    #[must_use]
    pub fn thinned(&self, n: usize) -> Self {
        let len = self.points.len();
        if len <= n {
            return self.clone();
        }
        let pick = |i: usize| i * len / n;
        Self {
            points: (0..n).map(|i| self.points[pick(i)]).collect(),
            // What only asks for distances brings none.
            normals: (0..n.min(self.normals.len())).map(|i| self.normals[pick(i)]).collect(),
        }
    }
}

/// A surface fitted to samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// The surface.
    pub surface: Surface,
    /// Whether its natural normal points out of the material.
    pub outward: bool,
}

impl Fit {
    /// Signed distance of a point and the surface's normal there, out of the material.
    pub fn distance_and_outward_normal(&self, point: &Point3) -> (f64, Vec3) {
        let (distance, normal) = self.surface.distance_and_normal(point);
        if self.outward { (distance, normal.into_inner()) } else { (-distance, -normal.into_inner()) }
    }
}
