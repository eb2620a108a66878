//! Clean-up of the labels before topology is read off them.
//!
//! Zig-zags: a triangle with two neighbours of one other label takes it. Specks: a component smaller than a few
//! squared spacings goes to the neighbour with the longest common border. Pinches: where one region owns two separate
//! sectors round a vertex, the smallest sector is given away. Each flip shortens the border between labels, so the
//! first two end; the last is bounded by a count.

use super::halfedge::HalfEdges;
use crate::mesh::Mesh;

/// Components smaller than this many squared spacings cannot be told from noise at a border.
const SPECK_AREA: f64 = 4.0;
/// Rounds of pinch mending; each usually mends all, a few leave new ones.
const MAX_PINCH_ROUNDS: usize = 8;

/// Cleans `labels` (one per triangle) in place.
pub(super) fn clean(mesh: &Mesh, half_edges: &HalfEdges, labels: &mut [u32], spacing: f64) {
    flip_zigzags(half_edges, labels);
    absorb_specks(mesh, half_edges, labels, SPECK_AREA * spacing * spacing);
    flip_zigzags(half_edges, labels);
    for _ in 0..MAX_PINCH_ROUNDS {
        if !mend_pinches(mesh, half_edges, labels) {
            break;
        }
        flip_zigzags(half_edges, labels);
    }
    absorb_specks(mesh, half_edges, labels, SPECK_AREA * spacing * spacing);
}

/// Gives every triangle that two neighbours agree against their label.
fn flip_zigzags(half_edges: &HalfEdges, labels: &mut [u32]) {
    let mut queue: Vec<usize> = (0..labels.len()).rev().collect();
    while let Some(t) = queue.pop() {
        let neighbours = half_edges.neighbours(t);
        let around = neighbours.map(|u| u.map(|u| labels[u]));
        let agreed = [(0, 1), (1, 2), (2, 0)]
            .into_iter()
            .find_map(|(i, j)| around[i].filter(|l| around[j] == Some(*l) && *l != labels[t]));
        if let Some(label) = agreed {
            labels[t] = label;
            queue.extend(neighbours.into_iter().flatten());
        }
    }
}

/// Gives components smaller than `min_area` to the neighbour with the longest common border, smallest first.
fn absorb_specks(mesh: &Mesh, half_edges: &HalfEdges, labels: &mut [u32], min_area: f64) {
    /// Specks beside specks need another round; more than a few only in noise.
    const MAX_ROUNDS: usize = 4;
    for _ in 0..MAX_ROUNDS {
        let (component, n) = half_edges.components(|t| labels[t]);
        let mut area = vec![0.0; n];
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); n];
        for t in 0..labels.len() {
            area[component[t] as usize] += mesh.area(t);
            members[component[t] as usize].push(t);
        }
        let mut specks: Vec<usize> = (0..n).filter(|c| area[*c] < min_area).collect();
        specks.sort_by(|a, b| area[*a].total_cmp(&area[*b]).then(a.cmp(b)));
        let mut changed = false;
        for speck in specks {
            let mut borders: Vec<(u32, f64)> = Vec::new();
            for &t in &members[speck] {
                for k in 0..3 {
                    let h = (3 * t + k) as u32;
                    let Some(twin) = half_edges.twin(h) else { continue };
                    let other = labels[HalfEdges::triangle(twin)];
                    if component[HalfEdges::triangle(twin)] as usize == speck {
                        continue;
                    }
                    let ends = (half_edges.from(h) as usize, half_edges.to(h) as usize);
                    let length = (mesh.vertices[ends.0] - mesh.vertices[ends.1]).norm();
                    match borders.iter_mut().find(|b| b.0 == other) {
                        Some(border) => border.1 += length,
                        None => borders.push((other, length)),
                    }
                }
            }
            let longest = borders.iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
            if let Some(&(label, _)) = longest {
                for &t in &members[speck] {
                    changed |= labels[t] != label;
                    labels[t] = label;
                }
            }
        }
        if !changed {
            break;
        }
    }
}

/// Gives away the smallest sector at every vertex where a connected piece of one label owns two; whether any did.
fn mend_pinches(mesh: &Mesh, half_edges: &HalfEdges, labels: &mut [u32]) -> bool {
    let mut changed = false;
    for v in 0..mesh.vertices.len() as u32 {
        let sectors = half_edges.sectors(v, |t| labels[t]);
        if sectors.len() < 4 {
            continue;
        }
        let repeated: Vec<usize> = (0..sectors.len())
            .filter(|i| sectors.iter().filter(|s| s.0 == sectors[*i].0).count() > 1)
            .collect();
        let area = |i: usize| sectors[i].1.iter().map(|t| mesh.area(*t)).sum::<f64>();
        let n = sectors.len();
        let between_equals = |i: usize| sectors[(i + n - 1) % n].0 == sectors[(i + 1) % n].0;
        // A sector between two of one label closes a pinch of that label whatever its own.
        let smallest = (0..n)
            .filter(|i| between_equals(*i) || repeated.contains(i))
            .filter(|_| !repeated.is_empty())
            .min_by(|a, b| between_equals(*b).cmp(&between_equals(*a)).then(area(*a).total_cmp(&area(*b))));
        if let Some(i) = smallest {
            let label = sectors[(i + 1) % n].0;
            for &t in &sectors[i].1 {
                labels[t] = label;
            }
            changed = true;
        }
    }
    changed
}
