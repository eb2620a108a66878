//! Which single surfaces a loop may lie on.

use super::shell::{Hole, Shell};
use crate::math::{Vec3, centroid, stats};
use crate::surface::{Plane, Surface};

/// A rim lies on a surface when nine tenths of it are this near, in spacings: teeth and rounded edges reach as far.
const NEAR: f64 = 2.5;
/// A rim with this share of its edges on a surface lies on it, wherever the others are.
const ON_ONE: f64 = 0.8;
/// A rim with some edges on a plane lies on it when all of it is this near, in spacings.
const NEAR_OWN: f64 = 8.0;
/// A loop whose projection is rounder than this (isoperimetric quotient) surrounds something; a window in a wall seen
/// along the wall is near zero.
const ROUND: f64 = 0.05;

/// Labels of the surfaces that `hole` may be filled on, the nearest to its rim first.
pub(super) fn candidates(shell: &Shell, hole: &Hole) -> Vec<u32> {
    let (main, share) = hole.main_label();
    let mut found: Vec<(f64, u32)> = hole
        .distinct_labels()
        .into_iter()
        .filter_map(|label| Some((mean_distance(shell, hole, label)?, label)))
        .filter(|&(near, label)| near.is_finite() || (label == main && share >= ON_ONE))
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.into_iter().map(|(_, label)| label).collect()
}

/// Mean distance of the rim to the surface of `label`; infinite when the rim does not lie on it or a filling there
/// would stand across the loop.
fn mean_distance(shell: &Shell, hole: &Hole, label: u32) -> Option<f64> {
    let surface = shell.surface(label)?;
    let points = shell.points(&hole.rim);
    let mut distances: Vec<f64> = points.iter().map(|p| surface.signed_distance(p).abs()).collect();
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    let wide = stats::quantile(&mut distances, 0.9)?;
    let center = centroid(&points);
    let area: Vec3 = (0..points.len())
        .map(|i| (points[i] - center).cross(&(points[(i + 1) % points.len()] - center)))
        .sum();
    let sense = if shell.primitives[label as usize].outward { 1.0 } else { -1.0 };
    let along = surface.normal(&center).dot(&area) * sense;
    let fits = wide < NEAR * shell.spacing && along > 0.5 * area.norm();
    Some(if fits { mean } else { f64::INFINITY })
}

/// Planes with two or more loops on them, and these loops.
pub(super) fn shared_planes(shell: &Shell, holes: &[Hole]) -> Vec<(u32, Vec<usize>)> {
    let mut labels: Vec<u32> = holes.iter().flat_map(Hole::distinct_labels).collect();
    labels.sort_unstable();
    labels.dedup();
    let on_plane = |label: u32, hole: &Hole| {
        let Some(Surface::Plane(plane)) = shell.surface(label) else { return false };
        let reach = if hole.labels.contains(&label) { NEAR_OWN } else { NEAR };
        surrounds_at(shell, hole, plane, reach * shell.spacing)
    };
    labels
        .into_iter()
        .map(|label| (label, (0..holes.len()).filter(|&i| on_plane(label, &holes[i])).collect::<Vec<_>>()))
        .filter(|(label, members)| {
            members.len() > 1 && members.iter().any(|&i| holes[i].labels.contains(label))
        })
        .collect()
}

/// Whether all of the rim is less than `reach` above `plane` and surrounds a part of it.
pub(super) fn surrounds(shell: &Shell, hole: &Hole, plane: &Plane, reach: f64) -> bool {
    shell.points(&hole.rim).iter().all(|p| plane.signed_distance(p) < reach) && is_round(shell, hole, plane)
}

fn surrounds_at(shell: &Shell, hole: &Hole, plane: &Plane, reach: f64) -> bool {
    shell.points(&hole.rim).iter().all(|p| plane.signed_distance(p).abs() < reach)
        && is_round(shell, hole, plane)
}

fn is_round(shell: &Shell, hole: &Hole, plane: &Plane) -> bool {
    let points = shell.points(&hole.rim);
    let n = points.len();
    let (mut area, mut length) = (Vec3::zeros(), 0.0);
    for i in 0..n {
        let (a, b) = (points[i] - points[0], points[(i + 1) % n] - points[0]);
        area += a.cross(&b) * 0.5;
        length += (b - a).norm();
    }
    4.0 * std::f64::consts::PI * area.dot(&plane.normal).abs() > ROUND * length * length
}
