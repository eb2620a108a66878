//! Triangulation of a loop by least area, for holes that no surface tells how to fill.
//!
//! G. Barequet and M. Sharir, "Filling gaps in the boundary of a polyhedron", Computer Aided Geometric Design 12
//! (1995): dynamic programming over the triangulations of the polygon. O(n^3).

use super::shell::{Hole, Shell};
use crate::math::Point3;

/// Loops longer than this are not triangulated: the table of costs grows with the square, time with the cube.
pub(super) const MAX_RIM: usize = 700;

/// Fills `hole` with triangles labelled like the nearest edge of the rim.
pub(super) fn fill_with_membrane(shell: &mut Shell, hole: &Hole) -> bool {
    let n = hole.rim.len();
    if !(3..=MAX_RIM).contains(&n) {
        return false;
    }
    let points = shell.points(&hole.rim);
    for [i, j, k] in least_area(&points) {
        // The shortest side along the rim tells the label.
        let label = if j == i + 1 {
            hole.labels[i]
        } else if k == j + 1 {
            hole.labels[j]
        } else {
            hole.labels[k % n]
        };
        shell.add_triangle([hole.rim[i], hole.rim[j], hole.rim[k]], label);
    }
    true
}

/// The triangulation of a closed polygon of least area.
pub(super) fn least_area(points: &[Point3]) -> Vec<[usize; 3]> {
    let n = points.len();
    let area =
        |i: usize, j: usize, k: usize| 0.5 * (points[j] - points[i]).cross(&(points[k] - points[i])).norm();
    let mut cost = vec![0.0_f64; n * n];
    let mut choice = vec![0_usize; n * n];
    for span in 2..n {
        for i in 0..n - span {
            let k = i + span;
            let mut best = (f64::INFINITY, i + 1);
            for j in i + 1..k {
                let total = cost[i * n + j] + cost[j * n + k] + area(i, j, k);
                if total < best.0 {
                    best = (total, j);
                }
            }
            cost[i * n + k] = best.0;
            choice[i * n + k] = best.1;
        }
    }
    let mut triangles = Vec::with_capacity(n.saturating_sub(2));
    let mut open = vec![(0, n - 1)];
    while let Some((i, k)) = open.pop() {
        if k < i + 2 {
            continue;
        }
        let j = choice[i * n + k];
        triangles.push([i, j, k]);
        open.push((i, j));
        open.push((j, k));
    }
    triangles
}
