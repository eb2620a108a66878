//! How well each primitive is known: the noise of this scan, measured from what is left of it on the faces that were found,
//! and the covariance of every fit under that noise.
//!
//! `variogram` measures how far noise is shared over the surface. A fit then has the covariance that least squares have
//! under such noise ([`correlated_covariance`]); the correction for the scanner's spot adds its own uncertainty. Cost
//! O(vertices) and a bounded number of pairs per primitive.

mod rounding;
mod variogram;

pub use variogram::measure;

use crate::fit::{Noise, Samples, correlated_covariance, parameter_names};
use crate::math::Point3;
use crate::mesh::{Adjacency, Mesh};
use crate::par;
use crate::recognize::Primitive;
use crate::segment::Segmentation;
use crate::surface::Surface;
use crate::tolerance::Tolerances;

/// Rings from the border of a region on which points may lie off its surface: the reach of rounded edges.
const BORDER_RINGS: u8 = 3;
/// Share of a region's vertices, those farthest from its border, that its fit rests on at least.
const MIN_INTERIOR_SHARE: f64 = 0.3;
/// Standard uncertainty of the scanner's spot, as a share of it: sites of sharp edges scatter by so much.
const SPOT_UNCERTAINTY: f64 = 0.1;
/// Standard deviation of the spot, in spacings, that a scan without sharp edges may have: scanners mesh about as finely as
/// they see.
const UNSEEN_SPOT: f64 = 0.5;

/// Vertices inside the regions of a segmentation.
#[derive(Debug, Clone)]
pub struct Interior {
    /// One list per region, ascending: vertices whose triangles all belong to it.
    pub vertices: Vec<Vec<u32>>,
    /// One per vertex of the mesh: edges to the nearest vertex outside the lists, at most `BORDER_RINGS`. The border of the
    /// scan is none: what lies there was seen beside nothing else.
    depth: Vec<u8>,
    /// One per vertex of the mesh: how far rounded edges may have moved it off its surface, length.
    rounding: Vec<f64>,
}

impl Interior {
    /// The vertices inside each region of `segmentation`.
    pub fn new(
        mesh: &Mesh,
        adjacency: &Adjacency,
        segmentation: &Segmentation,
        tolerances: &Tolerances,
    ) -> Self {
        let mut vertices = vec![Vec::new(); segmentation.primitives.len()];
        let mut depth = vec![0; mesh.vertices.len()];
        for (v, depth) in depth.iter_mut().enumerate() {
            let triangles = adjacency.vertex_triangles.row(v);
            let mut labels = triangles.iter().map(|&t| segmentation.labels[t as usize]);
            if let Some(Some(first)) = labels.next()
                && labels.all(|label| label == Some(first))
            {
                vertices[first.0 as usize].push(v as u32);
                *depth = BORDER_RINGS;
            }
        }
        let mut front: Vec<u32> = (0..depth.len() as u32).filter(|&v| depth[v as usize] == 0).collect();
        for ring in 1..BORDER_RINGS {
            let mut next = Vec::new();
            for &v in &front {
                for &w in adjacency.vertex_vertices.row(v as usize) {
                    if depth[w as usize] > ring {
                        depth[w as usize] = ring;
                        next.push(w);
                    }
                }
            }
            front = next;
        }
        let rounding = rounding::of_vertices(mesh, adjacency, segmentation, tolerances);
        Self { vertices, depth, rounding }
    }

    /// What rounded edges do to a fit to `vertices`, as a noise that these share.
    pub fn rounding(&self, vertices: &[u32], tolerances: &Tolerances) -> Noise {
        rounding::noise(self, vertices, tolerances)
    }

    /// The vertices of a region that its fit rests on: away from its border, or on a narrow one those farthest from it.
    pub fn core(&self, region: usize) -> Vec<u32> {
        let all = &self.vertices[region];
        let at_least = (MIN_INTERIOR_SHARE * all.len() as f64) as usize;
        let deeper = |ring: u8| all.iter().copied().filter(move |&v| self.depth[v as usize] >= ring);
        (1..=BORDER_RINGS)
            .rev()
            .find(|&ring| deeper(ring).count() > at_least)
            .map_or_else(|| all.clone(), |ring| deeper(ring).collect())
    }
}

/// The segmentation with the covariance of every primitive as the noise of the scan makes it.
#[must_use]
pub fn stated(
    mesh: &Mesh,
    interior: &Interior,
    segmentation: &Segmentation,
    noise: &Noise,
    tolerances: &Tolerances,
) -> Segmentation {
    let primitives = par::map_indices(segmentation.primitives.len(), |k| {
        let primitive = &segmentation.primitives[k];
        match &primitive.surface {
            Some(surface) => {
                let core = interior.core(k);
                let points: Vec<Point3> = core.iter().map(|&v| mesh.vertices[v as usize]).collect();
                let rounding = interior.rounding(&core, tolerances);
                match of_fit(surface, points, noise, rounding, tolerances) {
                    Some(covariance) => Primitive { covariance, ..primitive.clone() },
                    // So few that they leave a parameter open: what the fit itself said stays.
                    None => primitive.clone(),
                }
            }
            None => primitive.clone(),
        }
    });
    Segmentation { primitives, labels: segmentation.labels.clone() }
}

/// Covariance of a fit to `points`; `None` when these leave a parameter unobserved.
///
/// Where they lie off it by more than noise explains, what is left is not noise but form, and spread over the face: all
/// of the covariance is larger by as much.
fn of_fit(
    surface: &Surface,
    points: Vec<Point3>,
    noise: &Noise,
    rounding: Noise,
    tolerances: &Tolerances,
) -> Option<Vec<Vec<f64>>> {
    let n = points.len();
    if n < parameter_names(surface).len() {
        return None;
    }
    let spot = unknown_shift(tolerances);
    let mean_square = points.iter().map(|p| surface.signed_distance(p).powi(2)).sum::<f64>() / n as f64;
    let misfit = (mean_square.sqrt() / noise.sigma()).max(1.0);
    let samples = Samples { points, normals: Vec::new() };
    let covariance = correlated_covariance(surface, &samples, n, &[noise.times(misfit), rounding], |p| {
        spot * surface.curvature_sum(p)
    });
    Some(covariance).filter(|c| !c.is_empty())
}

/// What the correction for the scanner's spot may be wrong by, per sum of curvatures; length squared. It moves a surface
/// by `b^2 / 2` times that, `b` the deviation of the spot.
fn unknown_shift(tolerances: &Tolerances) -> f64 {
    let blur = tolerances.edge_rounding();
    if blur > 0.0 {
        SPOT_UNCERTAINTY * blur * blur
    } else {
        0.5 * (UNSEEN_SPOT * tolerances.spacing()).powi(2)
    }
}
