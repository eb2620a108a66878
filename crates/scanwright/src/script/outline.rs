//! From chosen blocks to features: blocks that touch become one profile over one range.

use std::collections::{BTreeMap, BTreeSet};

use super::curve::Curve;
use super::feature::{Feature, Ring, Segment, Sign};
use super::grid::Grid;
use super::sweep::{Motion, Point2};

use crate::tolerance::Tolerances;

/// The features that chosen blocks stand for, in order of slabs: connected cells of a slab, and the slabs in which they
/// are the same.
pub(super) fn features(grid: &Grid, is_in: &[bool], sign: Sign) -> Vec<Feature> {
    let n_slabs = grid.slabs.len();
    let mut runs: Vec<(BTreeSet<usize>, usize, usize)> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    for slab in 0..n_slabs {
        let mut still_open = Vec::new();
        for piece in pieces(grid, |cell| is_in[cell * n_slabs + slab]) {
            let same = open.iter().copied().find(|&r| runs[r].0 == piece);
            let run = same.unwrap_or_else(|| {
                runs.push((piece, slab, slab));
                runs.len() - 1
            });
            runs[run].2 = slab;
            still_open.push(run);
        }
        open = still_open;
    }
    join_round(grid, &mut runs);
    runs.iter().filter_map(|(cells, first, last)| feature(grid, cells, (*first, *last), sign)).collect()
}

/// A run that ends with the last sector of a turn and one that begins with the first are one.
fn join_round(grid: &Grid, runs: &mut Vec<(BTreeSet<usize>, usize, usize)>) {
    let n_slabs = grid.slabs.len();
    if grid.sweep.motion == Motion::Along || grid.is_whole {
        return;
    }
    let mut i = 0;
    while i < runs.len() {
        if runs[i].1 == 0 && runs[i].2 + 1 < n_slabs {
            let end = runs.iter().position(|r| r.1 > runs[i].2 && r.2 + 1 == n_slabs && r.0 == runs[i].0);
            if let Some(end) = end {
                runs[end].2 = n_slabs + runs[i].2;
                runs.remove(i);
                continue;
            }
        }
        i += 1;
    }
}

/// Connected sets of the cells that are in.
fn pieces(grid: &Grid, is_in: impl Fn(usize) -> bool) -> Vec<BTreeSet<usize>> {
    let n = grid.plane.cells.len();
    let mut beside: Vec<Vec<usize>> = vec![Vec::new(); n];
    for side in &grid.plane.sides {
        if let [Some(a), Some(b)] = side.cells {
            beside[a].push(b);
            beside[b].push(a);
        }
    }
    let mut seen = vec![false; n];
    let mut pieces = Vec::new();
    for start in 0..n {
        if seen[start] || !is_in(start) {
            continue;
        }
        seen[start] = true;
        let (mut piece, mut stack) = (BTreeSet::from([start]), vec![start]);
        while let Some(cell) = stack.pop() {
            for &next in &beside[cell] {
                if !seen[next] && is_in(next) {
                    seen[next] = true;
                    piece.insert(next);
                    stack.push(next);
                }
            }
        }
        pieces.push(piece);
    }
    pieces
}

fn feature(grid: &Grid, cells: &BTreeSet<usize>, slabs: (usize, usize), sign: Sign) -> Option<Feature> {
    let n_slabs = grid.slabs.len();
    let mut rings = rings(grid, cells, slabs);
    // The outer ring is the one that encloses most.
    let area = |r: &Ring| super::arrangement::signed_area(&r.polygon);
    rings.sort_by(|a, b| area(b).total_cmp(&area(a)));
    if rings.first().is_none_or(|r| area(r) <= 0.0) {
        return None;
    }
    let tau = std::f64::consts::TAU;
    let from = grid.slabs[slabs.0].0;
    let mut to = grid.slabs[slabs.1 % n_slabs].1;
    if slabs.1 >= n_slabs {
        to += tau;
    }
    let is_whole =
        grid.is_whole || (grid.sweep.motion == Motion::Around && to - from >= tau - Tolerances::SAME);
    let mut feature = Feature::new(sign, grid.sweep, rings, (from, to), is_whole);
    if !is_whole {
        let total: f64 = cells.iter().map(|c| grid.plane.cells[*c].area).sum();
        for (end, floor) in [slabs.0, slabs.1 % n_slabs + 1].into_iter().enumerate() {
            let covered =
                cells.iter().map(|c| grid.floors[c * (n_slabs + 1) + floor] * grid.plane.cells[*c].area);
            feature.capped[end] = covered.sum::<f64>() / total;
            feature.caps[end] = grid.level_at([from, to][end]).map(|l| l.faces.clone()).unwrap_or_default();
        }
    }
    Some(feature)
}

/// The borders of a set of cells, the set on their left.
fn rings(grid: &Grid, cells: &BTreeSet<usize>, slabs: (usize, usize)) -> Vec<Ring> {
    let plane = &grid.plane;
    let mut next: BTreeMap<(usize, bool), (usize, bool)> = BTreeMap::new();
    for cell in cells {
        let border = &plane.cells[*cell].border;
        for (i, half) in border.iter().enumerate() {
            next.insert(*half, border[(i + 1) % border.len()]);
        }
    }
    // A half whose other side is in the set too is inside.
    let is_border = |(side, forward): (usize, bool)| {
        plane.sides[side].cells[usize::from(forward)].is_none_or(|other| !cells.contains(&other))
    };
    let mut seen = BTreeSet::new();
    let mut rings = Vec::new();
    for &start in next.keys() {
        if !is_border(start) || seen.contains(&start) {
            continue;
        }
        let mut halves = Vec::new();
        let mut half = start;
        while seen.insert(half) {
            halves.push(half);
            half = next[&half];
            while !is_border(half) {
                half = next[&(half.0, !half.1)];
            }
        }
        rings.push(Ring::new(segments(grid, &halves, slabs)));
    }
    rings
}

/// Halves in a row on one curve are one segment.
fn segments(grid: &Grid, halves: &[(usize, bool)], slabs: (usize, usize)) -> Vec<Segment> {
    let plane = &grid.plane;
    let curves =
        |half: (usize, bool)| -> BTreeSet<usize> { plane.sides[half.0].curves.iter().copied().collect() };
    let n = halves.len();
    let common = |a: usize, b: usize| -> BTreeSet<usize> {
        curves(halves[a]).intersection(&curves(halves[b])).copied().collect()
    };
    let continues = |i: usize| !common((i + n - 1) % n, i).is_empty();
    let first = (0..n).find(|&i| !continues(i));
    let Some(first) = first else {
        // One circle all the way round.
        return vec![segment(grid, halves, slabs)];
    };
    let mut made: Vec<Vec<(usize, bool)>> = Vec::new();
    for k in 0..n {
        let i = (first + k) % n;
        match made.last_mut() {
            Some(last) if k > 0 && continues(i) && shares(grid, last, halves[i]) => last.push(halves[i]),
            _ => made.push(vec![halves[i]]),
        }
    }
    made.iter().map(|run| segment(grid, run, slabs)).collect()
}

/// Whether one curve runs along all of `run` and `half`.
fn shares(grid: &Grid, run: &[(usize, bool)], half: (usize, bool)) -> bool {
    let sides = &grid.plane.sides;
    sides[half.0].curves.iter().any(|c| run.iter().all(|(side, _)| sides[*side].curves.contains(c)))
}

fn segment(grid: &Grid, run: &[(usize, bool)], slabs: (usize, usize)) -> Segment {
    let plane = &grid.plane;
    let n_slabs = grid.slabs.len();
    let (first, last) = (run[0], run[run.len() - 1]);
    let on_all = |c: &usize| run.iter().all(|(side, _)| plane.sides[*side].curves.contains(c));
    let shared = plane.sides[first.0].curves.iter().copied().find(on_all);
    let index = shared.unwrap_or(plane.sides[first.0].curve);
    let curve = plane.curves[index];
    let end = |(side, forward): (usize, bool), at_start: bool| -> Point2 {
        let s = &plane.sides[side];
        plane.vertices[if forward == at_start { s.from } else { s.to }]
    };
    let mut faces: Vec<usize> = run
        .iter()
        .flat_map(|(side, _)| plane.sides[*side].curves.iter().copied())
        .filter(|c| *c < grid.traces.len())
        .flat_map(|c| grid.traces[c].faces.iter().copied())
        .collect();
    faces.sort_unstable();
    faces.dedup();
    let (mut covered, mut total) = (0.0, 0.0);
    for (side, _) in run {
        for slab in slabs.0..=slabs.1 {
            let (from, to) = grid.slabs[slab % n_slabs];
            let area = plane.length(*side) * (to - from);
            covered += grid.walls[side * n_slabs + slab % n_slabs] * area;
            total += area;
        }
    }
    // A helper's orientation is the first side's: all sides of a curve run along it.
    let forward = match curve {
        Curve::Line { direction, .. } => direction.dot(&(end(last, false) - end(first, true))) > 0.0,
        Curve::Circle { .. } => first.1,
    };
    Segment {
        curve,
        faces,
        from: end(first, true),
        to: end(last, false),
        middle: plane.middle(run[run.len() / 2].0),
        forward,
        backed: covered / total,
    }
}
