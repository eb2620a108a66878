//! Extends the surfaces along loops to a plane, and caps there.

use super::fill::fill_on_surface;
use super::mouth::mouth;
use super::shell::{Hole, Shell};
use crate::math::{Frame, Point3, Vec3};
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
    let mut contacts = Vec::new();
    for (hole, labels) in holes.iter().zip(walls) {
        let ring = tube_to(shell, hole, labels, plane);
        contacts.push(ring.unwrap_or_else(|| extrude(shell, hole, labels, plane)));
    }
    let rims: Vec<&[u32]> = contacts.iter().map(Vec::as_slice).collect();
    let closed = fill_on_surface(shell, &rims, cap);
    if !closed {
        *shell = backup;
    }
    closed
}

/// The rest of the bore or shaft that `hole` is a mouth of, down to an even ring on the plane; the ring's vertices.
pub(super) fn tube_to(shell: &mut Shell, hole: &Hole, walls: &[u32], plane: &Plane) -> Option<Vec<u32>> {
    let mouth = mouth(shell, hole).filter(|mouth| walls.iter().all(|w| *w == mouth.label))?;
    let surface = *shell.surface(mouth.label)?;
    let ring = ring_on_plane(&surface, plane, shell.spacing)?;
    let outward = shell.primitives[mouth.label as usize].outward;
    let along = mouth.direction.dot(&surface.axis()?.direction) > 0.0;
    let first = shell.mesh.vertices.len() as u32;
    let mut contact: Vec<u32> = (0..ring.len() as u32).map(|i| first + i).collect();
    shell.mesh.vertices.extend(ring);
    // The ring runs with growing angle; the rim does on a shaft that goes on along its axis.
    if outward != along {
        contact.reverse();
    }
    let border: Vec<u32> = contact.iter().rev().copied().collect();
    if fill_on_surface(shell, &[&hole.rim, &border], mouth.label) {
        return Some(contact);
    }
    shell.mesh.vertices.truncate(first as usize);
    None
}

/// Points round the section of a cylinder or cone by a plane that crosses all its generators.
fn ring_on_plane(surface: &Surface, plane: &Plane, spacing: f64) -> Option<Vec<Point3>> {
    let axis = surface.axis()?;
    let (radius, slope) = match surface {
        Surface::Cylinder(s) => (s.radius, 0.0),
        Surface::Cone(s) => (s.radius, s.half_angle.tan()),
        _ => return None,
    };
    let along = axis.direction.into_inner();
    let fall = along.dot(&plane.normal);
    let height = -plane.signed_distance(&axis.origin) / fall;
    let middle = radius + slope * height;
    if !(middle > 0.5 * spacing) || !height.is_finite() {
        return None;
    }
    let n = (std::f64::consts::TAU * middle / spacing).round().clamp(MIN_RING, MAX_RING) as usize;
    let frame = Frame::from_z(axis.origin, axis.direction);
    let point = |i: usize| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
        let round = frame.x.into_inner() * cos + frame.y.into_inner() * sin;
        let start = axis.origin + round * radius;
        let generator = along + round * slope;
        let rate = generator.dot(&plane.normal);
        let step = -plane.signed_distance(&start) / rate;
        (rate * fall > 0.0 && radius + slope * step > 0.0).then(|| start + generator * step)
    };
    (0..n).map(point).collect()
}

/// Fewest and most vertices of a ring: a circle needs the first to be one, memory the second.
const MIN_RING: f64 = 12.0;
const MAX_RING: f64 = 4000.0;

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
