//! Fills a loop of several surfaces by their extensions.
//!
//! The loop is filled by a harmonic membrane first, triangulated over the plane it is seen best from. Then two steps
//! alternate. Labelling: every triangle takes the label of the stretch of rim it is reached from most cheaply, where a
//! path costs its length times its distance to that stretch's surface, so every label stays connected to its stretch.
//! Moving: every vertex goes to the surface of its triangles, to the intersection where there are two or three, after
//! an average with its neighbours. The membrane thus folds into the corner of the extended surfaces when they have
//! one near, and the labels settle.
//!
//! Ours; the alternation is that of D. Cohen-Steiner, P. Alliez and M. Desbrun, "Variational shape approximation",
//! ACM Transactions on Graphics 23 (2004), with known proxies. Cost: O(k n log n) for n triangles, k rounds. Fails,
//! leaving a membrane of poor shape, where the extensions do not meet near the loop.

use super::chart::Chart;
use super::fill::{SMOOTHINGS, interior_points, triangulate};
use super::shell::{Hole, Shell};
use crate::math::{Point3, Vec3, centroid, try_unit};
use crate::mesh::{Adjacency, Mesh};
use crate::recognize::{Primitive, Residual};
use crate::surface::{Plane, Surface};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Rounds of labelling and moving: a fold a hundred spacings deep is reached at a few spacings each.
const ROUNDS: usize = 24;
/// Passes that make the first membrane harmonic.
const HARMONIC_PASSES: usize = 200;
/// Passes of averaging per round.
const AVERAGINGS: usize = 2;
/// A vertex moves at most this far per round, in spacings, lest triangles turn over.
const STRIDE: f64 = 2.0;
/// Length counts for this much beside distance from the surface, in spacings: enough to break ties.
const LENGTH_COST: f64 = 0.1;

/// A part of the mesh being made: vertices of the rim first.
struct Patch {
    mesh: Mesh,
    labels: Vec<u32>,
    n_rim: usize,
    neighbors: Adjacency,
    /// Of every vertex of the rims: the next one, and the label behind the edge to it.
    rim_edges: Vec<(usize, u32)>,
}

/// Fills what `holes` bound together; false, changing nothing, when it cannot be seen whole from any side.
pub(super) fn fill_patch(shell: &mut Shell, holes: &[&Hole]) -> bool {
    let Some(mut patch) = membrane(shell, holes) else { return false };
    let flat = patch.mesh.vertices.clone();
    for _ in 0..ROUNDS {
        let labels = labelled(shell, &patch);
        patch.labels = labels;
        relax(shell, &mut patch);
    }
    patch.labels = labelled(shell, &patch);
    smooth_labels(&mut patch);
    let far = patch
        .mesh
        .vertices
        .iter()
        .zip(&flat)
        .any(|(p, q)| !p.coords.iter().all(|c| c.is_finite()) || (p - q).norm() > shell.mesh.diagonal());
    if far {
        patch.mesh.vertices = flat;
    }
    let mut names: Vec<u32> = holes.iter().flat_map(|hole| hole.rim.iter().copied()).collect();
    names.extend(patch.mesh.vertices[patch.n_rim..].iter().map(|p| shell.add_vertex(*p)));
    for (triangle, label) in patch.mesh.triangles.iter().zip(&patch.labels) {
        shell.add_triangle(triangle.map(|v| names[v as usize]), *label);
    }
    true
}

/// The harmonic membrane of the rims, triangulated in the plane across their vector area.
fn membrane(shell: &Shell, holes: &[&Hole]) -> Option<Patch> {
    let rims: Vec<Vec<Point3>> = holes.iter().map(|hole| shell.points(&hole.rim)).collect();
    let rim = rims.concat();
    let center = centroid(&rim);
    let n = rim.len();
    let mut rim_edges = Vec::with_capacity(n);
    for hole in holes {
        let (first, len) = (rim_edges.len(), hole.rim.len());
        rim_edges.extend((0..len).map(|i| (first + (i + 1) % len, hole.labels[i])));
    }
    let area: Vec3 = (0..n).map(|i| (rim[i] - center).cross(&(rim[rim_edges[i].0] - center))).sum();
    let plane = Plane { point: center, normal: try_unit(area)? };
    let across = Primitive {
        surface: Some(Surface::Plane(plane)),
        outward: true,
        residual: Residual::default(),
        covariance: Vec::new(),
        ambiguous: None,
    };
    let chart = Chart::new(&across, &rim)?;
    for n_smoothings in SMOOTHINGS {
        let flats = rims.iter().map(|r| chart.flat_loop(r, n_smoothings)).collect::<Option<Vec<_>>>()?;
        let inside = interior_points(&chart, &flats, &rim, shell.spacing);
        let extra: Vec<[f64; 2]> = inside.iter().map(|p| p.1).collect();
        let Some(triangles) = triangulate(&flats, &extra) else { continue };
        let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| v as u32)).collect();
        let vertices = rim.iter().copied().chain(inside.iter().map(|p| p.0)).collect();
        let mesh = Mesh { vertices, triangles };
        let neighbors = Adjacency::new(&mesh);
        let labels = vec![0; mesh.triangles.len()];
        let mut patch = Patch { mesh, labels, n_rim: n, neighbors, rim_edges };
        for _ in 0..HARMONIC_PASSES {
            average(&mut patch);
        }
        return Some(patch);
    }
    None
}

/// Moves every inner vertex to the mean of its neighbours, in order.
fn average(patch: &mut Patch) {
    for v in patch.n_rim..patch.mesh.vertices.len() {
        let around = patch.neighbors.vertex_vertices.row(v);
        if around.is_empty() {
            continue;
        }
        let sum: Vec3 = around.iter().map(|&u| patch.mesh.vertices[u as usize].coords).sum();
        patch.mesh.vertices[v] = Point3::from(sum / around.len() as f64);
    }
}

/// Labels by cheapest paths from the rim.
fn labelled(shell: &Shell, patch: &Patch) -> Vec<u32> {
    let n = patch.mesh.triangles.len();
    let mut labels = vec![u32::MAX; n];
    // Costs are compared as ordered bits: non-negative floats sort like their bits.
    let mut queue: BinaryHeap<Reverse<(u64, u32, u32)>> = BinaryHeap::new();
    let step = |t: usize, label: u32, length: f64| {
        let center = patch.mesh.triangle_center(t);
        let off = shell.surface(label).map_or(shell.spacing, |s| s.signed_distance(&center).abs());
        length * (LENGTH_COST + off / shell.spacing)
    };
    for (t, triangle) in patch.mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (triangle[k] as usize, triangle[(k + 1) % 3] as usize);
            let edge = patch.rim_edges.get(a).filter(|edge| edge.0 == b);
            if let Some(&(_, label)) = edge {
                queue.push(Reverse((step(t, label, shell.spacing).to_bits(), t as u32, label)));
            }
        }
    }
    while let Some(Reverse((cost, t, label))) = queue.pop() {
        if labels[t as usize] != u32::MAX {
            continue;
        }
        labels[t as usize] = label;
        let here = patch.mesh.triangle_center(t as usize);
        for u in patch.neighbors.across[t as usize].into_iter().flatten() {
            if labels[u as usize] == u32::MAX {
                let length = (patch.mesh.triangle_center(u as usize) - here).norm();
                let total = f64::from_bits(cost) + step(u as usize, label, length);
                queue.push(Reverse((total.to_bits(), u, label)));
            }
        }
    }
    labels
}

/// Moves inner vertices to the surfaces of their triangles.
fn relax(shell: &Shell, patch: &mut Patch) {
    for _ in 0..AVERAGINGS {
        average(patch);
    }
    for v in patch.n_rim..patch.mesh.vertices.len() {
        let mut labels: Vec<u32> =
            patch.neighbors.vertex_triangles.row(v).iter().map(|&t| patch.labels[t as usize]).collect();
        labels.sort_unstable();
        labels.dedup();
        let surfaces: Vec<Surface> = labels.iter().filter_map(|&l| shell.surface(l).copied()).collect();
        let start = patch.mesh.vertices[v];
        let shift = meet(&start, &surfaces) - start;
        let length = shift.norm();
        let limit = STRIDE * shell.spacing;
        let share = if length > limit { limit / length } else { 1.0 };
        if share.is_finite() {
            patch.mesh.vertices[v] = start + shift * share;
        }
    }
}

/// Sweeps of the alternating projections.
const SWEEPS: usize = 8;

/// A point near `start` on all `surfaces`, by alternating projections: they end at the nearest common point of surfaces
/// that cross, and between those that do not.
fn meet(start: &Point3, surfaces: &[Surface]) -> Point3 {
    let mut point = *start;
    for _ in 0..SWEEPS {
        for surface in surfaces {
            point = surface.project(&point);
        }
    }
    point
}

/// Flips triangles that two of their three neighbours outvote: single teeth of the borders between labels.
fn smooth_labels(patch: &mut Patch) {
    const PASSES: usize = 3;
    for _ in 0..PASSES {
        for t in 0..patch.labels.len() {
            let around: Vec<u32> =
                patch.neighbors.across[t].into_iter().flatten().map(|u| patch.labels[u as usize]).collect();
            let outvoting = around
                .iter()
                .find(|l| **l != patch.labels[t] && around.iter().filter(|m| m == l).count() > 1);
            if let (3, Some(&label)) = (around.len(), outvoting) {
                patch.labels[t] = label;
            }
        }
    }
}
