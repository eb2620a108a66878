//! The profile of a turned part of the scan: its vertices in the half-plane through the axis, averaged along the turn.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector2;

use crate::math::{Frame, Point3};
use crate::segment::field::Field;

/// Vertices of one place of a profile.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mean {
    /// Mean radius and height.
    pub at: Vector2<f64>,
    /// Mean normal in the half-plane, out of the material.
    pub normal: Vector2<f64>,
    /// Number of vertices.
    pub count: f64,
    /// Number of independent samples.
    pub weight: f64,
}

/// Cells of the half-plane, spacings.
const CELL: f64 = 0.5;
/// Bins along the profile, spacings.
const BIN: f64 = 0.6;
/// Rows along a turn per independent sample: the correlation length of scan noise.
const ROWS_PER_SAMPLE: f64 = 6.0;

/// A point in the half-plane: radius and height.
pub(super) fn in_half_plane(frame: &Frame, point: &Point3) -> Vector2<f64> {
    let local = frame.local(point);
    Vector2::new(local.x.hypot(local.y), local.z)
}

/// The means along the profile of `vertices`, from where `start` is; `None` where they do not lie on one curve.
pub(super) fn means(field: &Field, frame: &Frame, vertices: &[u32], start: &[u32]) -> Option<Vec<Mean>> {
    let planar: Vec<Vector2<f64>> =
        vertices.iter().map(|&v| in_half_plane(frame, &field.points[v as usize])).collect();
    let keys = arc_lengths(field, frame, &planar, start)?;
    let rough = binned(field, frame, vertices, &planar, &keys);
    // Lengths along cells are coarse; along the curve they give they are not.
    let keys: Vec<Option<f64>> = planar.iter().map(|p| Some(place_on(&rough, p).1)).collect();
    let means = binned(field, frame, vertices, &planar, &keys);
    is_thin(field, &planar, &means).then_some(means)
}

/// Length along the profile of each point: shortest ways over occupied cells from the farthest cell of `start`.
fn arc_lengths(
    field: &Field,
    frame: &Frame,
    planar: &[Vector2<f64>],
    start: &[u32],
) -> Option<Vec<Option<f64>>> {
    /// Share of vertices that must be reached.
    const MIN_REACHED: f64 = 0.9;
    let size = CELL * field.spacing;
    let cell = |p: &Vector2<f64>| ((p.x / size).floor() as i64, (p.y / size).floor() as i64);
    let mut counts: BTreeMap<(i64, i64), usize> = BTreeMap::new();
    for p in planar {
        *counts.entry(cell(p)).or_default() += 1;
    }
    let mean = planar.len() as f64 / counts.len().max(1) as f64;
    counts.retain(|_, n| *n as f64 > 0.1 * mean);
    let starts: BTreeSet<(i64, i64)> = start
        .iter()
        .map(|&v| cell(&in_half_plane(frame, &field.points[v as usize])))
        .filter(|c| counts.contains_key(c))
        .collect();
    let first = outer_end(&counts, &starts)?;
    let lengths = ways(&counts, first);
    let keys: Vec<Option<f64>> =
        planar.iter().map(|p| lengths.get(&cell(p)).map(|l| *l as f64 * 0.1 * size)).collect();
    let n_reached = keys.iter().filter(|k| k.is_some()).count();
    (n_reached as f64 >= MIN_REACHED * planar.len() as f64).then_some(keys)
}

/// The end of the profile that is in `starts`. Not their cell that is farthest from all others: where the profile turns
/// back on itself, as around a bead, that may be the corner at which the first face ends.
fn outer_end(counts: &BTreeMap<(i64, i64), usize>, starts: &BTreeSet<(i64, i64)>) -> Option<(i64, i64)> {
    let last = |from: (i64, i64)| ways(counts, from).into_iter().max_by_key(|(at, l)| (*l, *at)).map(|w| w.0);
    let one = last(*starts.first()?)?;
    let other = last(one)?;
    // Seen from the far end, the first face ends where the ways are longest.
    let far = if starts.contains(&one) { other } else { one };
    let lengths = ways(counts, far);
    starts.iter().filter_map(|c| Some((*lengths.get(c)?, *c))).max().map(|longest| longest.1)
}

/// Shortest ways from `first` over neighbouring cells, in tenths of a cell.
fn ways(counts: &BTreeMap<(i64, i64), usize>, first: (i64, i64)) -> BTreeMap<(i64, i64), i64> {
    /// Cells from one to the next, at most: the rows of a scanner's grid along the axis lie up to one and a half spacings
    /// apart, as each cell of the grid gives more than one vertex.
    const JUMP: i64 = 3;
    let mut lengths = BTreeMap::from([(first, 0)]);
    let mut front = BTreeSet::from([(0, first)]);
    while let Some((length, at)) = front.pop_first() {
        for dx in -JUMP..=JUMP {
            for dy in -JUMP..=JUMP {
                let to = (at.0 + dx, at.1 + dy);
                if !counts.contains_key(&to) {
                    continue;
                }
                let next = length + (10.0 * ((dx * dx + dy * dy) as f64).sqrt()).round() as i64;
                if lengths.get(&to).is_none_or(|l| next < *l) {
                    lengths.insert(to, next);
                    front.insert((next, to));
                }
            }
        }
    }
    lengths
}

/// Whether the material is on the right of a profile.
pub(super) fn has_material_right(means: &[Mean]) -> bool {
    means.windows(2).map(|m| m[0].normal.perp(&(m[1].at - m[0].at))).sum::<f64>() < 0.0
}

fn binned(
    field: &Field,
    frame: &Frame,
    vertices: &[u32],
    planar: &[Vector2<f64>],
    keys: &[Option<f64>],
) -> Vec<Mean> {
    let width = BIN * field.spacing;
    let mut bins: BTreeMap<i64, (f64, Vector2<f64>, Vector2<f64>)> = BTreeMap::new();
    for ((&v, p), key) in vertices.iter().zip(planar).zip(keys) {
        let Some(key) = key else { continue };
        let local = frame.local(&(frame.origin + field.normals[v as usize]));
        let radial = frame.local(&field.points[v as usize]);
        let radial = Vector2::new(radial.x, radial.y);
        let outward = Vector2::new(local.x, local.y).dot(&radial) / radial.norm().max(f64::MIN_POSITIVE);
        let bin = bins.entry((key / width).floor() as i64).or_default();
        bin.0 += 1.0;
        bin.1 += p;
        bin.2 += Vector2::new(outward, local.z);
    }
    let mean = |(n, at, normal): (f64, Vector2<f64>, Vector2<f64>)| Mean {
        at: at / n,
        normal: normal / normal.norm().max(f64::MIN_POSITIVE),
        count: n,
        weight: (BIN * n / ROWS_PER_SAMPLE).max(1.0),
    };
    let least = 0.1 * vertices.len() as f64 / bins.len().max(1) as f64;
    bins.into_values().filter(|bin| bin.0 > least).map(mean).collect()
}

/// The point of a segment nearest to `at`, and its place between the ends.
pub(super) fn foot([from, to]: [Vector2<f64>; 2], at: &Vector2<f64>) -> (Vector2<f64>, f64) {
    let along = to - from;
    let t = ((at - from).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (from + along * t, t)
}

/// Squared distance to the curve through `means`, and the length along it to the nearest point.
fn place_on(means: &[Mean], at: &Vector2<f64>) -> (f64, f64) {
    let mut best = (f64::INFINITY, 0.0);
    let mut length = 0.0;
    for pair in means.windows(2) {
        let (foot, t) = foot([pair[0].at, pair[1].at], at);
        let distance_sq = (foot - at).norm_squared();
        let own = (pair[1].at - pair[0].at).norm();
        if distance_sq < best.0 {
            best = (distance_sq, length + t * own);
        }
        length += own;
    }
    best
}

/// Whether the points lie as near to the curve through their means as noise leaves them.
fn is_thin(field: &Field, planar: &[Vector2<f64>], means: &[Mean]) -> bool {
    /// Root mean square distance, noise, and that from which a point counts no more.
    const MAX_SIGMAS: f64 = 2.5;
    const CLIP: f64 = 6.0;
    /// Means of the shortest curve.
    const MIN_MEANS: usize = 4;
    let sigma = field.weights.distance_sigma;
    let sum: f64 = planar.iter().map(|p| place_on(means, p).0.min((CLIP * sigma).powi(2))).sum();
    means.len() >= MIN_MEANS && sum < (MAX_SIGMAS * sigma).powi(2) * planar.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_of_a_bead_begins_at_the_far_end_of_the_face_below_it() {
        // From the left along the floor, up the wall and back over the bead: the corner, not the end of the floor, is
        // farthest from the middle of the rest.
        let floor = (0..20).map(|x| (x, 0));
        let wall = (0..12).map(|y| (19, y));
        let bead = (2..19).rev().map(|x| (x, 11));
        let counts: BTreeMap<(i64, i64), usize> =
            floor.clone().chain(wall).chain(bead).map(|cell| (cell, 1)).collect();
        for first_seen in [0, 8, 14] {
            let starts = floor.clone().skip(first_seen).collect();
            let seen: BTreeMap<(i64, i64), usize> = counts
                .iter()
                .filter(|(c, _)| c.1 > 0 || c.0 >= first_seen as i64)
                .map(|(c, n)| (*c, *n))
                .collect();
            assert_eq!(outer_end(&seen, &starts), Some((first_seen as i64, 0)));
        }
    }

    #[test]
    fn ways_step_over_the_rows_of_a_grid_and_not_over_a_gap() {
        let wall = |step: i64| (0..10).map(|row| ((0, row * step), 1)).collect::<BTreeMap<_, _>>();
        // Rows of a fused scan along the axis are 1.2 spacings apart: two cells or three.
        assert_eq!(ways(&wall(3), (0, 0)).len(), 10);
        assert_eq!(ways(&wall(4), (0, 0)).len(), 1);
    }
}
