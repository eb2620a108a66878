//! Half-edges of triangles and which of them are joined.
//!
//! Half-edge `3 t + k` runs from corner `k` of triangle `t` to the next corner. Joining is not by vertex index: two
//! half-edges between the same vertices may stay apart, which is how non-manifold edges are cut.

use crate::mesh::{Csr, Mesh, VertId};

/// No half-edge.
pub(super) const NONE: u32 = u32::MAX;

/// Two joined half-edges per edge; `NONE` on the boundary.
#[derive(Debug, Clone, Default)]
pub(super) struct HalfEdges {
    /// Per half-edge, the one it is joined with.
    pub twin: Vec<u32>,
}

impl HalfEdges {
    /// All half-edges apart.
    pub fn apart(n_triangles: usize) -> Self {
        Self { twin: vec![NONE; 3 * n_triangles] }
    }

    pub fn join(&mut self, h: u32, g: u32) {
        debug_assert!(self.twin[h as usize] == NONE && self.twin[g as usize] == NONE, "joined twice");
        self.twin[h as usize] = g;
        self.twin[g as usize] = h;
    }

    pub fn cut(&mut self, h: u32) {
        let g = std::mem::replace(&mut self.twin[h as usize], NONE);
        if g != NONE {
            self.twin[g as usize] = NONE;
        }
    }

    /// The triangles joined to `t`, each with the half-edges of `t` and of its own.
    pub fn neighbors(&self, t: u32) -> impl Iterator<Item = (u32, u32)> {
        (3 * t..3 * t + 3).map(|h| (h, self.twin[h as usize])).filter(|(_, g)| *g != NONE)
    }

    /// The half-edges of `t`, renumbered for the triangle with its last two corners swapped.
    pub fn renumber_flipped(&mut self, flip: &[bool]) {
        let new = |h: u32| if h != NONE && flip[h as usize / 3] { h / 3 * 3 + (2 - h % 3) } else { h };
        let mut twin = vec![NONE; self.twin.len()];
        for (h, &g) in self.twin.iter().enumerate() {
            twin[new(h as u32) as usize] = new(g);
        }
        self.twin = twin;
    }
}

/// The half-edge that follows `h` in its triangle.
pub(super) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// First and last vertex of a half-edge.
pub(super) fn ends(mesh: &Mesh, h: u32) -> (VertId, VertId) {
    let triangle = mesh.triangles[h as usize / 3];
    (triangle[h as usize % 3], triangle[next(h) as usize % 3])
}

/// Calls `visit` with the half-edges of every edge, ascending; edges by low, then high vertex.
pub(super) fn for_each_edge(mesh: &Mesh, mut visit: impl FnMut(&[u32])) {
    let pairs = (0..3 * mesh.triangles.len() as u32).map(|h| {
        let (a, b) = ends(mesh, h);
        (a.min(b), h)
    });
    let rows = Csr::from_pairs(mesh.vertices.len(), pairs);
    let (mut row, mut group) = (Vec::new(), Vec::new());
    for low in 0..rows.len() {
        row.clear();
        row.extend(rows.row(low).iter().map(|&h| {
            let (a, b) = ends(mesh, h);
            (a.max(b), h)
        }));
        row.sort_unstable();
        for edge in row.chunk_by(|x, y| x.0 == y.0) {
            group.clear();
            group.extend(edge.iter().map(|&(_, h)| h));
            visit(&group);
        }
    }
}
