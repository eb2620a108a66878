//! How far the scanner's spot bends each vertex, where faces of different curvature meet without an edge.
//!
//! A spot of standard deviation b moves a vertex inwards by `b^2 / 2` times the sum of curvatures, and it sees that sum as it
//! sees everything, as a mean over itself: at the line where a fillet runs into a plane half of what it is inside. A fillet
//! as wide as a few spots would else seem of another radius.

use super::Sighting;
use crate::mesh::{Adjacency, Mesh};
use crate::par;

/// Largest share that a vertex takes of its neighbours in one pass: with all of it patterns of one edge would stand.
const LARGEST_SHARE: f64 = 0.8;
/// Passes of the mean: bounds the cost where a scan is much finer than the spot.
const MOST_PASSES: usize = 100;
/// Relative difference from which the bends of neighbours are two.
const DIFFERENT: f64 = 0.01;

/// Replaces the bend that each vertex has on its own face by the mean over the spot. `bend`: half the square of its deviation.
///
/// The mean is reached by diffusion along edges: a pass in which each vertex takes a share of the mean of its neighbours, an
/// edge h away, widens it by that share of `h^2 / 2` in each direction.
pub(super) fn averaged(of_vertex: &mut [Option<Sighting>], mesh: &Mesh, bend: f64) {
    let adjacency = Adjacency::new(mesh);
    let edge = mean_square_edge(mesh);
    if bend <= 0.0 || edge <= 0.0 {
        return;
    }
    let passes = 4.0 * bend / edge;
    let n_passes = ((passes / LARGEST_SHARE).ceil() as usize).clamp(1, MOST_PASSES);
    let share = (passes / n_passes as f64).min(LARGEST_SHARE);
    // Beside an edge vertices are rounded instead.
    let mut bent: Vec<Option<f64>> =
        of_vertex.iter().map(|s| s.filter(|s| !s.at_border).map(|s| s.bent)).collect();
    let near = near_changes(&adjacency, &bent, n_passes);
    for _ in 0..n_passes {
        let next = par::map(&near, |&v| {
            let own = bent[v as usize]?;
            let beside = adjacency.vertex_vertices.row(v as usize).iter().filter_map(|&w| bent[w as usize]);
            let (sum, n) = beside.fold((0.0, 0), |(sum, n), x| (sum + x, n + 1));
            Some(if n == 0 { own } else { own + share * (sum / f64::from(n) - own) })
        });
        for (&v, next) in near.iter().zip(next) {
            bent[v as usize] = next;
        }
    }
    for &v in &near {
        if let (Some(sighting), Some(mean)) = (&mut of_vertex[v as usize], bent[v as usize]) {
            sighting.bent = mean;
        }
    }
}

/// Vertices within `n_rings` edges of where the bend changes, ascending.
fn near_changes(adjacency: &Adjacency, bent: &[Option<f64>], n_rings: usize) -> Vec<u32> {
    let changes = par::map_indices(bent.len(), |v| {
        let Some(own) = bent[v] else { return false };
        let mut beside = adjacency.vertex_vertices.row(v).iter().filter_map(|&w| bent[w as usize]);
        beside.any(|other| (other - own).abs() > DIFFERENT * own.abs().max(other.abs()))
    });
    let mut front: Vec<u32> = (0..bent.len() as u32).filter(|&v| changes[v as usize]).collect();
    let mut is_near = changes;
    for _ in 0..n_rings {
        let mut next = Vec::new();
        for &v in &front {
            for &w in adjacency.vertex_vertices.row(v as usize) {
                if !is_near[w as usize] {
                    is_near[w as usize] = true;
                    next.push(w);
                }
            }
        }
        front = next;
    }
    (0..bent.len() as u32).filter(|&v| is_near[v as usize]).collect()
}

/// Mean squared length of the triangles' edges.
fn mean_square_edge(mesh: &Mesh) -> f64 {
    let edges = mesh.triangles.iter().flat_map(|t| (0..3).map(move |k| [t[k], t[(k + 1) % 3]]));
    let squares = edges.map(|[a, b]| (mesh.vertices[b as usize] - mesh.vertices[a as usize]).norm_squared());
    squares.sum::<f64>() / (3 * mesh.triangles.len()).max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Point3, Vec3};

    /// A step of the curvature becomes the integral of the spot.
    #[test]
    fn a_step_is_seen_as_wide_as_the_spot() {
        const SPACING: f64 = 0.5;
        const BLUR: f64 = 1.0;
        let n: u32 = 60;
        let place = |i: u32, j: u32| Point3::new(f64::from(i) * SPACING, f64::from(j) * SPACING, 0.0);
        let vertices: Vec<Point3> = (0..n * n).map(|v| place(v / n, v % n)).collect();
        let corners = (1..n).flat_map(|i| (1..n).map(move |j| i * n + j));
        let triangles = corners.flat_map(|v| [[v, v - n, v - n - 1], [v, v - n - 1, v - 1]]).collect();
        let mesh = Mesh { vertices, triangles };
        let middle = 0.5 * f64::from(n - 1) * SPACING;
        let seen = |point: &Point3| Sighting {
            face: 0,
            point: *point,
            foot: *point,
            distance: 0.0,
            normal: Vec3::z(),
            bent: if point.x > middle { 1.0 } else { 0.0 },
            at_border: false,
        };
        let mut sightings: Vec<Option<Sighting>> = mesh.vertices.iter().map(|p| Some(seen(p))).collect();
        averaged(&mut sightings, &mesh, 0.5 * BLUR * BLUR);
        for x in [-2.0, -1.0, -0.5, 0.5, 1.0, 2.0_f64] {
            let place = ((middle + x * BLUR) / SPACING).round() as u32;
            let apart = (f64::from(place) * SPACING - middle) / BLUR;
            // Integral of the normal density by the midpoint rule.
            let step = 1e-3;
            let heights = (0..8000).map(|i| apart - (f64::from(i) + 0.5) * step);
            let share: f64 =
                heights.map(|t| (-0.5 * t * t).exp() * step).sum::<f64>() / std::f64::consts::TAU.sqrt();
            let found = sightings[(place * n + n / 2) as usize].unwrap().bent;
            assert!((found - share).abs() < 0.03, "{found} instead of {share} at {apart}");
        }
    }
}
