//! Holes that join the part's contact line with the table to what the part hid from the scanner above it.
//!
//! Where a flange overhangs, the shadow it casts on the wall below reaches the table: one loop then runs along the
//! contact line, up the rim of the shadow and down again. It is parted where it leaves the table and comes back, by a
//! line along the wall on which it does both, or the two walls, just above the table: they go on there unseen. One of the
//! parts is the contact line, the others are windows like any.

use super::shell::{Hole, Shell};
use crate::math::Point3;
use crate::surface::{Plane, Surface};

/// Share of the height within which a loop is near the table that it must come back to, so that teeth of its rim do not
/// part it.
const FOOT: f64 = 0.5;
/// The wall must cross the table at least this steeply (sine) to be continued along it.
const STEEP: f64 = 0.5;
/// How far the line may lie off the straight way, in its length: on a round wall it bulges.
const BULGE: f64 = 0.5;
/// Steps of the alternating projection onto the wall and the height.
const STEPS: usize = 12;

/// Lines that part a hole which comes within `near` of `table` (normal towards the part) and also rises above; none where
/// it does not, or where one of them cannot be drawn.
pub(super) fn lines(shell: &Shell, hole: &Hole, table: &Plane, near: f64) -> Vec<Line> {
    let excursions = excursions(shell, hole, table, near);
    let lines: Option<Vec<Line>> = excursions.iter().map(|e| line(shell, hole, table, *e)).collect();
    lines.unwrap_or_default()
}

/// Places in a rim of the vertices at the table between which it rises; the second may be beyond the end, counted on.
type Excursion = [usize; 2];

/// Where the rim leaves the neighbourhood of the table and comes back; none if it does not come near it at all.
fn excursions(shell: &Shell, hole: &Hole, table: &Plane, near: f64) -> Vec<Excursion> {
    let n = hole.rim.len();
    let heights: Vec<f64> = shell.points(&hole.rim).iter().map(|p| table.signed_distance(p)).collect();
    let is_foot = |i: usize| heights[i % n] < FOOT * near;
    let Some(start) = (0..n).find(|i| is_foot(*i)) else { return Vec::new() };
    let mut excursions = Vec::new();
    let mut last_foot = start;
    for i in start + 1..=start + n {
        if !is_foot(i) {
            continue;
        }
        if (last_foot + 1..i).any(|k| heights[k % n] >= near) {
            excursions.push([last_foot, i]);
        }
        last_foot = i;
    }
    excursions
}

/// A line along walls that takes the place of an excursion in the contact line.
pub(super) struct Line {
    excursion: Excursion,
    /// Between the ends.
    points: Vec<Point3>,
    /// Wall of every step, from the one end to the other.
    walls: Vec<u32>,
}

/// The line for an excursion that begins and ends on one wall, or on two that meet in an upright corner; `None` where
/// they do not lead from end to end.
fn line(shell: &Shell, hole: &Hole, table: &Plane, excursion: Excursion) -> Option<Line> {
    let n = hole.rim.len();
    let [from, to] = excursion;
    let label = |i: usize| hole.labels[i % n];
    // At a corner the first edge of the excursion may lie on the next face already.
    let ends = [[from, to - 1], [from + n - 1, to]].map(|ends| ends.map(label));
    let [first, last] = ends.into_iter().find(|[a, b]| a == b).unwrap_or(ends[0]);
    let [start, end] = excursion.map(|i| shell.point(hole.rim[i % n]));
    if first == last {
        let points = along(shell, first, table, [start, end])?;
        let walls = vec![first; points.len() + 1];
        return Some(Line { excursion, points, walls });
    }
    let middle = nalgebra::center(&start, &end);
    let reach = BULGE * (end - start).norm();
    let corner =
        on_walls(&[*shell.surface(first)?, *shell.surface(last)?], table, &middle, shell.spacing, reach)?;
    let mut points = along(shell, first, table, [start, corner])?;
    let mut walls = vec![first; points.len() + 1];
    points.push(corner);
    points.extend(along(shell, last, table, [corner, end])?);
    walls.resize(points.len() + 1, last);
    Some(Line { excursion, points, walls })
}

/// Points on the wall between two ends, a spacing apart.
fn along(shell: &Shell, wall: u32, table: &Plane, [start, end]: [Point3; 2]) -> Option<Vec<Point3>> {
    let surface = [*shell.surface(wall)?];
    let length = (end - start).norm();
    let n_steps = (length / shell.spacing).round().max(2.0) as usize;
    let point = |k: usize| {
        let straight = start + (end - start) * (k as f64 / n_steps as f64);
        on_walls(&surface, table, &straight, shell.spacing, BULGE * length)
    };
    (1..n_steps).map(point).collect()
}

/// The point near `start` that lies on all of `walls`, as high above `table` as `start` and at least `least`; `None`
/// where that is farther than `reach`.
fn on_walls(walls: &[Surface], table: &Plane, start: &Point3, least: f64, reach: f64) -> Option<Point3> {
    let up = table.normal.into_inner();
    let height = table.signed_distance(start).max(least);
    let mut point = *start;
    for _ in 0..STEPS {
        for wall in walls {
            point += up * (height - table.signed_distance(&point));
            let (distance, normal) = wall.distance_and_normal(&point);
            let level = normal.into_inner() - up * normal.dot(&up);
            if level.norm() < STEEP {
                return None;
            }
            point -= level * (distance / level.norm_squared());
        }
    }
    ((point - start).norm() <= reach).then_some(point)
}

/// A hole parted by its `lines`: the contact line and the windows.
pub(super) fn parts(shell: &mut Shell, hole: &Hole, lines: &[Line]) -> (Hole, Vec<Hole>) {
    let n = hole.rim.len();
    let mut contact = Hole { rim: Vec::new(), labels: Vec::new() };
    let mut windows = Vec::new();
    for (k, line) in lines.iter().enumerate() {
        let [from, to] = line.excursion;
        let new: Vec<u32> = line.points.iter().map(|p| shell.add_vertex(*p)).collect();
        let mut window = Hole { rim: Vec::new(), labels: Vec::new() };
        for i in from..to {
            window.rim.push(hole.rim[i % n]);
            window.labels.push(hole.labels[i % n]);
        }
        window.rim.push(hole.rim[to % n]);
        window.rim.extend(new.iter().rev());
        window.labels.extend(line.walls.iter().rev());
        windows.push(window);

        contact.rim.push(hole.rim[from % n]);
        contact.rim.extend(new);
        contact.labels.extend(&line.walls);
        // On from where this excursion ends to where the next begins, which may be the first again.
        let next = lines.get(k + 1).map_or(lines[0].excursion[0] + n, |next| next.excursion[0]);
        for i in to..next {
            contact.rim.push(hole.rim[i % n]);
            contact.labels.push(hole.labels[i % n]);
        }
    }
    (contact, windows)
}
