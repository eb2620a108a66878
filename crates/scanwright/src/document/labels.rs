//! The regions of a scan whose labels were not kept.
//!
//! A triangle belongs to the primitive that its corners are nearest to, among those in whose box it lies. Along borders
//! that is not exactly what segmentation decided, which is enough to show where a primitive is.

use super::part::Part;
use crate::math::{Point3, Vec3};
use crate::mesh::Mesh;
use crate::par;
use crate::surface::Surface;

/// Farther than so many standard deviations of the noise, or percentiles of a primitive's own residuals, no triangle
/// belongs to it.
const SIGMAS: f64 = 5.0;
const PERCENTILES: f64 = 2.0;

struct Candidate {
    id: u32,
    surface: Option<Surface>,
    low: Vec3,
    high: Vec3,
    reach: f64,
}

/// One per triangle of `mesh`.
pub(super) fn of_scan(part: &Part, mesh: &Mesh) -> Vec<Option<u32>> {
    let noise = part.scan.noise.unwrap_or(0.0);
    let rim = Vec3::repeat(part.scan.spacing.unwrap_or(0.0));
    let candidates: Vec<Candidate> = part
        .primitives
        .iter()
        .filter_map(|primitive| {
            let place = primitive.place?;
            Some(Candidate {
                id: primitive.id,
                surface: primitive.surface(),
                low: Vec3::from(place.low) - rim,
                high: Vec3::from(place.high) + rim,
                reach: (SIGMAS * noise).max(PERCENTILES * primitive.residual.p95.unwrap_or(0.0)),
            })
        })
        .collect();
    par::map_indices(mesh.triangles.len(), |t| nearest(&candidates, &mesh.corners(t)))
}

fn nearest(candidates: &[Candidate], corners: &[Point3; 3]) -> Option<u32> {
    let inside = |candidate: &&Candidate| {
        let between = |p: &Point3| (0..3).all(|k| candidate.low[k] <= p[k] && p[k] <= candidate.high[k]);
        corners.iter().all(between)
    };
    let distance = |candidate: &Candidate| match &candidate.surface {
        // What has no surface takes what nothing else takes.
        None => Some(f64::INFINITY),
        Some(surface) => {
            let farthest = corners.iter().map(|p| surface.signed_distance(p).abs()).fold(0.0, f64::max);
            (farthest <= candidate.reach).then_some(farthest)
        }
    };
    let near = candidates.iter().filter(inside).filter_map(|c| Some((distance(c)?, c.id)));
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| id)
}
