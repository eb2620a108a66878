//! Specks: small pieces of clutter away from everything else.
//!
//! A component is a speck when its area, its extent and its nearness to larger components all say so. Fused scans
//! break into small pieces along seams, where they lie within an edge or two of their neighbours: those are data.
//!
//! Cost O(n log n) where there are small components, else O(n).

use super::half_edges::HalfEdges;
use crate::math::Point3;
use crate::mesh::Mesh;

/// Largest share of the whole area; method.md 1.
const SPECK_AREA: f64 = 5e-4;
/// Largest share of the whole diagonal: a wire or a rim may have little area but is no speck.
const SPECK_EXTENT: f64 = 0.05;
/// Pieces within this many median edges of a larger one touch it: seams leave gaps of one to two.
const TOUCHING_EDGES: f64 = 3.0;

/// Component of each triangle over joined edges, numbered by lowest triangle, and how many there are.
pub(super) fn components(half_edges: &HalfEdges) -> (Vec<u32>, usize) {
    let n_triangles = half_edges.twin.len() / 3;
    let mut component = vec![u32::MAX; n_triangles];
    let mut n_components = 0;
    let mut stack = Vec::new();
    for seed in 0..n_triangles as u32 {
        if component[seed as usize] != u32::MAX {
            continue;
        }
        component[seed as usize] = n_components;
        stack.push(seed);
        while let Some(t) = stack.pop() {
            for (_, g) in half_edges.neighbors(t) {
                if component[g as usize / 3] == u32::MAX {
                    component[g as usize / 3] = n_components;
                    stack.push(g / 3);
                }
            }
        }
        n_components += 1;
    }
    (component, n_components as usize)
}

/// Per component, whether it is a speck. Never all of them.
pub(super) fn specks(mesh: &Mesh, component: &[u32], n_components: usize, median_edge: f64) -> Vec<bool> {
    let mut area = vec![0.0; n_components];
    let mut bounds: Vec<Option<(Point3, Point3)>> = vec![None; n_components];
    for (t, &c) in component.iter().enumerate() {
        area[c as usize] += mesh.area(t);
        let bounds = &mut bounds[c as usize];
        for p in mesh.corners(t) {
            let (lo, hi) = bounds.unwrap_or((p, p));
            *bounds = Some((lo.inf(&p), hi.sup(&p)));
        }
    }
    let total_area: f64 = area.iter().sum();
    let largest_extent = SPECK_EXTENT * mesh.diagonal();
    let mut speck: Vec<bool> = area
        .iter()
        .zip(&bounds)
        .map(|(&area, bounds)| {
            let extent = bounds.map_or(0.0, |(lo, hi)| (hi - lo).norm());
            area < SPECK_AREA * total_area && extent < largest_extent
        })
        .collect();
    let n_small = speck.iter().filter(|s| **s).count();
    if n_small == n_components {
        return vec![false; n_components];
    }
    if 0 < n_small {
        keep_touching(mesh, component, TOUCHING_EDGES * median_edge, &mut speck);
    }
    speck
}

/// Clears the mark of components with a vertex within about `reach` of one of the others: in the same or a
/// neighbouring cell of that size.
fn keep_touching(mesh: &Mesh, component: &[u32], reach: f64, speck: &mut [bool]) {
    let cell = |p: Point3| -> [i64; 3] { std::array::from_fn(|axis| (p[axis] / reach).floor() as i64) };
    let mut occupied: Vec<[i64; 3]> = component
        .iter()
        .enumerate()
        .filter(|(_, c)| !speck[**c as usize])
        .flat_map(|(t, _)| mesh.corners(t).map(cell))
        .collect();
    occupied.sort_unstable();
    occupied.dedup();
    let near = |c: [i64; 3]| {
        let sides = [-1, 0, 1];
        let beside = |i: i64, j: i64| -> bool {
            // The third axis is contiguous in the order.
            let low = [c[0].saturating_add(i), c[1].saturating_add(j), c[2].saturating_sub(1)];
            let at = occupied.partition_point(|o| *o < low);
            occupied.get(at).is_some_and(|o| o[..2] == low[..2] && o[2] <= c[2].saturating_add(1))
        };
        sides.iter().any(|&i| sides.iter().any(|&j| beside(i, j)))
    };
    let small = speck.to_vec();
    for (t, &c) in component.iter().enumerate() {
        if small[c as usize] && speck[c as usize] && mesh.corners(t).into_iter().any(|p| near(cell(p))) {
            speck[c as usize] = false;
        }
    }
}
