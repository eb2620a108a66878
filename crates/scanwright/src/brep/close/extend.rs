//! Extends the surfaces along loops to a plane, and caps there.

use super::fill::fill_on_surface;
use super::shell::{Hole, Shell};
use crate::math::{Point3, Vec3};
use crate::surface::{Plane, Surface};

/// A wall must cross the plane at least this steeply (sine) to be extended along itself; flatter ones drop straight.
const STEEP: f64 = 0.25;
/// Passes that even out the contact line, each followed by a return to wall and plane. A tooth of the scan's rim is a
/// few vertices long; diffusion over so many vertices takes about its square.
const SMOOTHINGS: usize = 40;
/// Steps of the alternating projection onto wall and plane.
const NEWTON_STEPS: usize = 12;

/// Extends all `holes` to `plane` (normal out of the material) and closes them there with one cap labelled `cap`.
/// `walls[i]`: the label that each edge of hole `i` is extended by. False, changing nothing, when the contact lines
/// bound nothing on the plane.
pub(super) fn extend_and_cap(
    shell: &mut Shell,
    holes: &[&Hole],
    walls: &[Vec<u32>],
    plane: &Plane,
    cap: u32,
) -> bool {
    let backup = shell.clone();
    let contacts: Vec<Vec<u32>> =
        holes.iter().zip(walls).map(|(hole, labels)| extrude(shell, hole, labels, plane)).collect();
    let rims: Vec<&[u32]> = contacts.iter().map(Vec::as_slice).collect();
    let closed = fill_on_surface(shell, &rims, cap);
    if !closed {
        *shell = backup;
    }
    closed
}

/// Walls from the rim of `hole` to the plane; the vertices of their contact line with it.
fn extrude(shell: &mut Shell, hole: &Hole, walls: &[u32], plane: &Plane) -> Vec<u32> {
    let targets = contact_line(shell, hole, walls, plane);
    let rim = shell.points(&hole.rim);
    let n = rim.len();
    let mean: f64 = rim.iter().zip(&targets).map(|(a, b)| (b - a).norm()).sum::<f64>() / n as f64;
    let n_rows = (mean / shell.spacing).round().clamp(1.0, 1000.0) as usize;
    let mut upper = hole.rim.clone();
    for row in 1..=n_rows {
        let share = row as f64 / n_rows as f64;
        let lower: Vec<u32> = (0..n)
            .map(|i| {
                let mut point = rim[i] + (targets[i] - rim[i]) * share;
                if row < n_rows && walls[i] == walls[(i + n - 1) % n] {
                    if let Some(surface) = shell.surface(walls[i]) {
                        let projected = surface.project(&point);
                        if (projected - point).norm() < shell.spacing * SLACK {
                            point = projected;
                        }
                    }
                }
                shell.add_vertex(point)
            })
            .collect();
        for i in 0..n {
            let j = (i + 1) % n;
            shell.add_triangle([upper[i], upper[j], lower[i]], walls[i]);
            shell.add_triangle([upper[j], lower[j], lower[i]], walls[i]);
        }
        upper = lower;
    }
    upper
}

/// How far a wall's vertex may be drawn onto its surface, in spacings: further means the wall is not that surface.
const SLACK: f64 = 3.0;

fn contact_line(shell: &Shell, hole: &Hole, walls: &[u32], plane: &Plane) -> Vec<Point3> {
    let n = hole.rim.len();
    let surfaces =
        |i: usize| [shell.surface(walls[(i + n - 1) % n]).copied(), shell.surface(walls[i]).copied()];
    let is_corner = |i: usize| walls[(i + n - 1) % n] != walls[i];
    let mut line: Vec<Point3> =
        (0..n).map(|i| contact(&shell.point(hole.rim[i]), surfaces(i), plane, shell.spacing)).collect();
    for _ in 0..SMOOTHINGS {
        line = (0..n)
            .map(|i| {
                if is_corner(i) {
                    return line[i];
                }
                let mean = Point3::from(
                    0.25 * (line[(i + n - 1) % n].coords + 2.0 * line[i].coords + line[(i + 1) % n].coords),
                );
                contact(&mean, surfaces(i), plane, shell.spacing)
            })
            .collect();
    }
    line
}

/// The point near `start` on the plane and on the walls, each step the smallest that meets them to first order. Drops
/// straight onto the plane when the walls do not cross it, or far away.
fn contact(start: &Point3, walls: [Option<Surface>; 2], plane: &Plane, spacing: f64) -> Point3 {
    let down = -plane.normal.into_inner() * plane.signed_distance(start);
    let straight = start + down;
    let mut point = straight;
    for _ in 0..NEWTON_STEPS {
        for surface in walls.iter().flatten() {
            let (distance, normal) = surface.distance_and_normal(&point);
            let in_plane: Vec3 = normal.into_inner() - plane.normal.into_inner() * normal.dot(&plane.normal);
            let steepness_sq = in_plane.norm_squared();
            if steepness_sq < STEEP * STEEP {
                return straight;
            }
            point -= in_plane * (distance / steepness_sq);
        }
    }
    let reach = SLACK * spacing + REACH * down.norm();
    if (point - straight).norm() < reach { point } else { straight }
}

/// How far a contact may lie aside, per height dropped: a wall at the flattest angle extended.
const REACH: f64 = 4.0;
