//! What rounded edges do to the faces beside them.
//!
//! The scanner sees a spot, not a point: a sharp edge is rounded over the width of that, and the vertices beside it lie off
//! their faces. A fit keeps away from borders where the face is wide enough; a narrow face has nothing but borders.
//!
//! With d and e the distances of a point to its own and to the other surface the spot moves it by
//! `(E|t + tau x| - |t|) / 2` off its own, `t = d - e`, `tau = b |n - m|`, b the deviation of the spot and n, m the two
//! normals (the wedge of `segment/edge.rs`).

use super::{BORDER_RINGS, Interior};
use crate::fit::{Fit, Noise};
use crate::math::Point3;
use crate::math::blur::blurred_magnitude;
use crate::mesh::{Adjacency, Mesh};
use crate::segment::{RegionId, Segmentation};
use crate::tolerance::Tolerances;

/// Distance, in deviations of the spot, over which vertices beside an edge are rounded alike: how far the border of a region
/// strays from the edge varies along it.
const ALIKE: f64 = 3.0;

/// How far rounded edges may have moved each vertex of `mesh` off the surface of its region, length.
pub(super) fn of_vertices(
    mesh: &Mesh,
    adjacency: &Adjacency,
    segmentation: &Segmentation,
    tolerances: &Tolerances,
) -> Vec<f64> {
    let spot = tolerances.edge_rounding();
    if spot == 0.0 {
        return vec![0.0; mesh.vertices.len()];
    }
    let fits: Vec<Option<Fit>> = segmentation
        .primitives
        .iter()
        .map(|p| p.surface.map(|surface| Fit { surface, outward: p.outward }))
        .collect();
    let fit = |region: &RegionId| fits[region.0 as usize].as_ref();
    let near = regions_near(adjacency, segmentation, mesh.vertices.len());
    let moved = |(v, near): (usize, &Vec<RegionId>)| {
        let Some(own) = own_region(v, adjacency, segmentation) else { return 0.0 };
        let others = near.iter().filter(|&&region| region != own);
        let of = |other| Some(rounding(fit(&own)?, fit(other)?, spot, &mesh.vertices[v]));
        others.filter_map(of).fold(0.0, f64::max)
    };
    near.iter().enumerate().map(moved).collect()
}

/// What rounded edges do to a fit to `vertices`, as a noise.
pub(super) fn noise(interior: &Interior, vertices: &[u32], tolerances: &Tolerances) -> Noise {
    let sum: f64 = vertices.iter().map(|&v| interior.rounding[v as usize].powi(2)).sum();
    let length = (ALIKE * tolerances.edge_rounding()).max(tolerances.spacing());
    Noise { white: 0.0, correlated: (sum / vertices.len().max(1) as f64).sqrt(), length }
}

/// The regions within `BORDER_RINGS` edges of each vertex that lies so near to a border; none elsewhere.
fn regions_near(adjacency: &Adjacency, segmentation: &Segmentation, n_vertices: usize) -> Vec<Vec<RegionId>> {
    let sorted = |mut regions: Vec<RegionId>| {
        regions.sort_unstable();
        regions.dedup();
        if regions.len() < 2 { Vec::new() } else { regions }
    };
    let at = |v: usize| {
        let triangles = adjacency.vertex_triangles.row(v).iter();
        sorted(triangles.filter_map(|&t| segmentation.labels[t as usize]).collect())
    };
    let mut near: Vec<Vec<RegionId>> = (0..n_vertices).map(at).collect();
    for _ in 0..BORDER_RINGS {
        let wider = |v: usize| {
            let beside = adjacency.vertex_vertices.row(v).iter().flat_map(|&w| near[w as usize].iter());
            sorted(near[v].iter().chain(beside).copied().collect())
        };
        near = (0..n_vertices).map(wider).collect();
    }
    near
}

/// The region of all triangles at a vertex.
fn own_region(v: usize, adjacency: &Adjacency, segmentation: &Segmentation) -> Option<RegionId> {
    let mut labels = adjacency.vertex_triangles.row(v).iter().map(|&t| segmentation.labels[t as usize]);
    let first = labels.next()??;
    labels.all(|label| label == Some(first)).then_some(first)
}

/// How far the spot moves a point near the edge of `own` and `other` off `own`.
fn rounding(own: &Fit, other: &Fit, spot: f64, point: &Point3) -> f64 {
    let (d, n) = own.distance_and_outward_normal(point);
    let (e, m) = other.distance_and_outward_normal(point);
    let t = (d - e).abs();
    0.5 * (blurred_magnitude(t, spot * (n - m).norm()).0 - t)
}
