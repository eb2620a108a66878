//! Triangles whose corners lie on a line ("caps"), removed without opening the surface.
//!
//! Dropping a cap would leave a crack: its two short sides against the one long side of its neighbour. Swapping the
//! edge between the two makes two triangles with area of them, and the surface stays where it was.
//! Botsch, Kobbelt, "A robust procedure to eliminate degenerate faces from triangle meshes", Vision, Modeling and
//! Visualization 2001, 283-290. They slice through caps from end to end; we swap one at a time, in rounds, which does
//! the same where few caps lie side by side, as in practice. Triangles with two equal corners ("needles") are gone
//! before.
//!
//! Cost O(n) per round. A cap with a boundary or a non-manifold edge as its long side, or in a heap of more caps than
//! there are rounds, stays flat and is left to the caller to drop.
//!
//! ```text
//!        d                 d
//!       / \               /|\
//!      / u \      ->     / | \
//!     /     \           /u | t\
//!    p---b---q         p---b---q      t = (p, q, b), flat
//! ```

use super::half_edges::{ends, for_each_edge};
use crate::mesh::{Mesh, VertId};

/// Caps side by side that can be dissolved; each round takes one layer.
const N_ROUNDS: usize = 4;

/// Gives every cap of `mesh` half of the neighbour across its longest side. `is_flat` tells caps. Returns how many were
/// swapped and which triangles are still flat.
pub(super) fn swap_caps(mesh: &mut Mesh, is_flat: impl Fn(&Mesh, usize) -> bool) -> (usize, Vec<usize>) {
    let mut caps: Vec<usize> = (0..mesh.triangles.len()).filter(|&t| is_flat(mesh, t)).collect();
    let mut n_swapped = 0;
    for _ in 0..N_ROUNDS {
        let n_before = caps.len();
        if caps.is_empty() {
            break;
        }
        let swaps = find_swaps(mesh, &caps);
        let mut changed = vec![false; mesh.triangles.len()];
        for (t, u) in swaps {
            if !changed[t] && !changed[u] && !is_flat(mesh, u) {
                swap(mesh, t, u);
                (changed[t], changed[u]) = (true, true);
            }
        }
        caps.retain(|&t| is_flat(mesh, t));
        n_swapped += n_before - caps.len();
        if caps.len() == n_before {
            break;
        }
    }
    (n_swapped, caps)
}

/// Caps with the one triangle across their longest side.
fn find_swaps(mesh: &Mesh, caps: &[usize]) -> Vec<(usize, usize)> {
    let mut long_side = vec![false; 3 * mesh.triangles.len()];
    for &t in caps {
        let [a, b, c] = mesh.corners(t);
        let lengths_sq = [(b - a).norm_squared(), (c - b).norm_squared(), (a - c).norm_squared()];
        let longest = (0..3).max_by(|&i, &j| lengths_sq[i].total_cmp(&lengths_sq[j])).expect("of three");
        long_side[3 * t + longest] = true;
    }
    let mut swaps = Vec::new();
    for_each_edge(mesh, |edge| {
        if let [h, g] = *edge {
            for (h, g) in [(h, g), (g, h)] {
                if long_side[h as usize] {
                    swaps.push((h as usize / 3, g as usize / 3));
                }
            }
        }
    });
    swaps
}

/// Replaces the edge that cap `t` shares with `u` by the other diagonal; both take the orientation of `u`.
fn swap(mesh: &mut Mesh, t: usize, u: usize) {
    let apex = |of: usize, other: usize| -> Option<VertId> {
        mesh.triangles[of].into_iter().find(|v| !mesh.triangles[other].contains(v))
    };
    // The two triangles may be one and the same, once more.
    let (Some(b), Some(d)) = (apex(t, u), apex(u, t)) else { return };
    let h = (0..3).map(|k| 3 * u as u32 + k).find(|&h| ends(mesh, h).0 != d && ends(mesh, h).1 != d);
    let (p, q) = ends(mesh, h.expect("one side does not touch a corner"));
    mesh.triangles[u] = [p, b, d];
    mesh.triangles[t] = [b, q, d];
}
