//! Solvers: orthogonal-distance least squares for the five surfaces, on points and normals.
//!
//! `start` gives closed-form first guesses from points and normals, `refine` the robust least-squares fit,
//! `covariance` its uncertainty. Nothing here knows what a region is or which type is right.

mod covariance;
mod refine;
mod start;

pub use covariance::{VERTICES_PER_SAMPLE, distance_by_parameters, parameter_covariance, parameter_names};
pub use refine::{Weights, refine};
pub use start::starts;

use crate::math::{Point3, Vec3};
use crate::surface::Surface;

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
            normals: (0..n).map(|i| self.normals[pick(i)]).collect(),
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
