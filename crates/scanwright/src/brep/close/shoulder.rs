//! Shoulders: flat faces, ring-shaped or whole, on which a bore or shaft ends beside another loop.

use super::extend::{extend_and_cap, tube_to};
use super::mouth::{Mouth, mouth};
use super::patch::fill_patch;
use super::shell::{Hole, Shell};
use crate::math::Vec3;
use crate::surface::{Plane, Surface};

/// A mouth ends on a plane this near its rim, in spacings.
const NEAR: f64 = 8.0;
/// Cosine between axis and normal above which a plane lies across an axis.
const ACROSS: f64 = 0.9;
/// Cosine between normal and axis below which a wall runs along the axis.
const ALONG: f64 = 0.35;
/// Walls with fewer of a loop's edges do not count.
const MIN_SHARE: f64 = 0.05;
/// Loops farther apart than this, in radii of the mouth, do not share a shoulder.
const MAX_GAP: f64 = 3.0;

/// Ends mouths on planes that other loops show in places, and fills these loops with the mouth's ring as an island.
pub(super) fn join_at_planes(shell: &mut Shell, holes: &mut Vec<Hole>) {
    for i in 0..holes.len() {
        let Some(mouth) = mouth(shell, &holes[i]) else { continue };
        for j in 0..holes.len() {
            if i == j || holes[j].rim.is_empty() || holes[i].rim.is_empty() {
                continue;
            }
            let label = holes[j].distinct_labels().into_iter().find(|&l| ends_on(shell, &mouth, l));
            if let Some(label) = label {
                if join(shell, &holes[i], &holes[j], &mouth, label) {
                    holes[i].rim.clear();
                    holes[j].rim.clear();
                }
            }
        }
    }
    holes.retain(|hole| !hole.rim.is_empty());
}

/// Whether the plane `label` is one that a bore leaves the part through, or a shaft stands on, just beyond the rim.
fn ends_on(shell: &Shell, mouth: &Mouth, label: u32) -> bool {
    let Some(Surface::Plane(plane)) = shell.surface(label) else { return false };
    let facing = plane.normal.dot(&mouth.direction);
    let sense = if shell.primitives[mouth.label as usize].outward { -1.0 } else { 1.0 };
    if facing * sense < ACROSS {
        return false;
    }
    let height = -plane.signed_distance(&mouth.origin) / facing;
    height > mouth.mean - shell.spacing && (height - mouth.depth).abs() < NEAR * shell.spacing
}

fn join(shell: &mut Shell, island: &Hole, outer: &Hole, mouth: &Mouth, label: u32) -> bool {
    let Some(Surface::Plane(plane)) = shell.surface(label).copied() else { return false };
    let backup = shell.clone();
    let walls = vec![mouth.label; island.rim.len()];
    if let Some(ring) = tube_to(shell, island, &walls, &plane) {
        let ring = Hole { labels: vec![label; ring.len()], rim: ring };
        if fill_patch(shell, &[outer, &ring]) {
            return true;
        }
    }
    *shell = backup;
    false
}

/// Joins every mouth with a loop of walls along its axis by an assumed plane across it, where the even one of the two
/// rims ends. Returns the labels of these planes.
pub(super) fn assume_shoulders(shell: &mut Shell, holes: &mut Vec<Hole>) -> Vec<u32> {
    let mut made = Vec::new();
    for i in 0..holes.len() {
        let Some(mouth) = mouth(shell, &holes[i]) else { continue };
        let mut others: Vec<(f64, usize)> = (0..holes.len())
            .filter(|&j| j != i && !holes[j].rim.is_empty())
            .filter_map(|j| Some((gap(shell, &mouth, &holes[i], &holes[j])?, j)))
            .collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, j) in others {
            if let Some(label) = assume(shell, &mouth, &holes[i], &holes[j]) {
                made.push(label);
                holes[i].rim.clear();
                holes[j].rim.clear();
                break;
            }
        }
    }
    holes.retain(|hole| !hole.rim.is_empty());
    made
}

/// Distance along the axis from the mouth to a loop of walls along the axis, if it lies beyond.
fn gap(shell: &Shell, mouth: &Mouth, hole: &Hole, other: &Hole) -> Option<f64> {
    let n = other.labels.len() as f64;
    let runs_along = other.distinct_labels().into_iter().all(|label| {
        let share = other.labels.iter().filter(|l| **l == label).count() as f64 / n;
        share < MIN_SHARE || is_along(shell, label, &mouth.direction)
    });
    let (lo, _) = heights(shell, mouth, other);
    let points = shell.points(&hole.rim);
    let radius = points
        .iter()
        .map(|p| shell.surface(mouth.label).map_or(0.0, |s| radius_at(s, p)))
        .fold(0.0, f64::max);
    let gap = lo - mouth.mean;
    (runs_along && !hole.rim.is_empty() && gap > 0.0 && gap < MAX_GAP * radius).then_some(gap)
}

fn radius_at(surface: &Surface, point: &crate::math::Point3) -> f64 {
    surface.axis().map_or(0.0, |axis| axis.radial(point).norm())
}

fn is_along(shell: &Shell, label: u32, direction: &Vec3) -> bool {
    match shell.surface(label) {
        Some(Surface::Plane(plane)) => plane.normal.dot(direction).abs() < ALONG,
        Some(Surface::Cylinder(s)) => s.axis.direction.dot(direction).abs() > ACROSS,
        Some(Surface::Cone(s)) => {
            s.axis.direction.dot(direction).abs() > ACROSS && s.half_angle.sin() < ALONG
        }
        _ => false,
    }
}

/// Lowest and highest point of a rim along a mouth's direction.
fn heights(shell: &Shell, mouth: &Mouth, hole: &Hole) -> (f64, f64) {
    let heights = hole.rim.iter().map(|&v| mouth.height(&shell.point(v)));
    heights.fold((f64::MAX, f64::MIN), |(lo, hi), h| (lo.min(h), hi.max(h)))
}

fn assume(shell: &mut Shell, mouth: &Mouth, hole: &Hole, other: &Hole) -> Option<u32> {
    let (near, far) = (heights(shell, mouth, hole), heights(shell, mouth, other));
    let half = 0.5 * shell.spacing;
    let height = if near.1 - near.0 < far.1 - far.0 { near.1 + half } else { far.0 - half };
    let point = mouth.origin + mouth.direction.into_inner() * height;
    for normal in [mouth.direction, -mouth.direction] {
        let plane = Plane { point, normal };
        let label = shell.add_plane(plane);
        let walls = [vec![mouth.label; hole.rim.len()], other.labels.clone()];
        if extend_and_cap(shell, &[hole, other], &walls, &plane, label) {
            return Some(label);
        }
        shell.primitives.pop();
    }
    None
}
