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
use crate::par;
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
    par::map_indices(near.len(), |v| {
        let Some(own) = own_region(v, adjacency, segmentation) else { return 0.0 };
        let others = near[v].iter().filter(|&&region| region != own);
        let of = |other| Some(rounding(fit(&own)?, fit(other)?, spot, &mesh.vertices[v]));
        others.filter_map(of).fold(0.0, f64::max)
    })
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
    let mut near: Vec<Vec<RegionId>> = par::map_indices(n_vertices, at);
    for _ in 0..BORDER_RINGS {
        let wider = |v: usize| {
            let beside = adjacency.vertex_vertices.row(v).iter().flat_map(|&w| near[w as usize].iter());
            sorted(near[v].iter().chain(beside).copied().collect())
        };
        near = par::map_indices(n_vertices, wider);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::recognize::Primitive;
    use crate::surface::{Plane, Surface};
    use crate::tolerance::Measured;

    /// Two planes that turn by an angle along the y axis, a grid of one length each.
    fn folded(turn: f64, spot: f64) -> (Mesh, Vec<f64>) {
        let n: u32 = 21;
        let along = Vec3::new(turn.cos(), 0.0, -turn.sin());
        let place = |i: u32, j: u32| {
            let (x, y) = (f64::from(i) - 10.0, f64::from(j));
            Point3::from(if x < 0.0 { Vec3::x() * x } else { along * x } + Vec3::y() * y)
        };
        let vertices: Vec<Point3> = (0..n * n).map(|v| place(v / n, v % n)).collect();
        let corners = (1..n).flat_map(|i| (1..n).map(move |j| (i, i * n + j)));
        let (mut triangles, mut labels) = (Vec::new(), Vec::new());
        for (i, v) in corners {
            triangles.extend([[v, v - n - 1, v - n], [v, v - 1, v - n - 1]]);
            labels.extend([Some(RegionId(u32::from(i > 10))); 2]);
        }
        let mesh = Mesh { vertices, triangles };
        let plane = |normal: Vec3| Primitive {
            surface: Some(Surface::Plane(Plane {
                point: Point3::origin(),
                normal: crate::math::UnitVec3::new_normalize(normal),
            })),
            ..Primitive::freeform()
        };
        let primitives = vec![plane(Vec3::z()), plane(Vec3::new(turn.sin(), 0.0, turn.cos()))];
        let measured = Measured {
            largest_coordinate: 20.0,
            diagonal: 30.0,
            spacing: 1.0,
            noise: 0.01,
            normal_noise: 0.01,
            edge_rounding: spot,
        };
        let tolerances = Tolerances::new(measured, None);
        let adjacency = Adjacency::new(&mesh);
        let moved = of_vertices(&mesh, &adjacency, &Segmentation { labels, primitives }, &tolerances);
        (mesh, moved)
    }

    /// Mean of the larger of the two distances of a right-angled wedge over a round spot, at `t` from the edge on one side.
    fn integrated(t: f64, spot: f64) -> f64 {
        const N: i32 = 400;
        const REACH: f64 = 6.0;
        let places = || (0..N).map(|i| (f64::from(i) + 0.5) * 2.0 * REACH / f64::from(N) - REACH);
        let (mut sum, mut total) = (0.0, 0.0);
        for (x, y) in places().flat_map(|x| places().map(move |y| (x, y))) {
            let weight = (-0.5 * (x * x + y * y)).exp();
            sum += weight * (spot * x).max(spot * y - t);
            total += weight;
        }
        sum / total
    }

    #[test]
    fn vertices_beside_an_edge_are_moved_by_the_blurred_wedge() {
        const SPOT: f64 = 0.8;
        let right = std::f64::consts::FRAC_PI_2;
        let (mesh, moved) = folded(right, SPOT);
        for (point, moved) in mesh.vertices.iter().zip(&moved).filter(|(p, _)| p.y == 10.0 && p.x < 0.0) {
            let t = -point.x;
            let seen = if t <= f64::from(BORDER_RINGS) { integrated(t, SPOT) } else { 0.0 };
            assert!((moved - seen).abs() < 1e-4 * SPOT, "{moved} instead of {seen} at {t}");
        }
        let largest = |turn: f64| folded(turn, SPOT).1.into_iter().fold(0.0, f64::max);
        assert!(largest(0.1) < 0.3 * largest(right), "a flat fold hardly rounds");
        assert_eq!(folded(right, 0.0).1.into_iter().fold(0.0, f64::max), 0.0);
    }
}
