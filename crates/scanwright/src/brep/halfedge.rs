//! Half-edges of a triangle mesh: `3 * triangle + k` runs from corner `k` to corner `k + 1`.

use crate::mesh::{Mesh, VertId};

/// Marks a half-edge without a twin.
pub(super) const NONE: u32 = u32::MAX;

/// The half-edges of one mesh.
#[derive(Debug, Clone)]
pub(super) struct HalfEdges {
    triangles: Vec<[VertId; 3]>,
    twin: Vec<u32>,
    /// First half-edge that leaves each vertex, in the order of half-edges grouped by vertex.
    offsets: Vec<u32>,
    leaving: Vec<u32>,
}

impl HalfEdges {
    /// Pairs half-edges. Edges of more or less than two triangles, or of two that disagree, stay without twins.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let n = 3 * mesh.triangles.len();
        let end = |h: usize| {
            let triangle = mesh.triangles[h / 3];
            (triangle[h % 3], triangle[(h + 1) % 3])
        };
        let mut sorted: Vec<(VertId, VertId, u32)> = (0..n)
            .map(|h| {
                let (a, b) = end(h);
                (a.min(b), a.max(b), h as u32)
            })
            .collect();
        sorted.sort_unstable();
        let mut twin = vec![NONE; n];
        for group in sorted.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            if let [(.., h), (.., g)] = group
                && end(*h as usize).0 == end(*g as usize).1
            {
                twin[*h as usize] = *g;
                twin[*g as usize] = *h;
            }
        }
        let mut offsets = vec![0_u32; mesh.vertices.len() + 1];
        for v in mesh.triangles.iter().flatten() {
            offsets[*v as usize + 1] += 1;
        }
        for i in 1..offsets.len() {
            offsets[i] += offsets[i - 1];
        }
        let (mut next, mut leaving) = (offsets.clone(), vec![0; n]);
        for h in 0..n {
            let v = end(h).0 as usize;
            leaving[next[v] as usize] = h as u32;
            next[v] += 1;
        }
        Self { triangles: mesh.triangles.clone(), twin, offsets, leaving }
    }

    pub(super) fn len(&self) -> usize {
        self.twin.len()
    }

    pub(super) fn twin(&self, h: u32) -> Option<u32> {
        let twin = self.twin[h as usize];
        (twin != NONE).then_some(twin)
    }

    pub(super) fn from(&self, h: u32) -> VertId {
        self.triangles[h as usize / 3][h as usize % 3]
    }

    pub(super) fn to(&self, h: u32) -> VertId {
        self.triangles[h as usize / 3][(h as usize + 1) % 3]
    }

    pub(super) fn triangle(h: u32) -> usize {
        h as usize / 3
    }

    pub(super) fn next(h: u32) -> u32 {
        h / 3 * 3 + (h + 1) % 3
    }

    pub(super) fn previous(h: u32) -> u32 {
        h / 3 * 3 + (h + 2) % 3
    }

    /// Half-edges that leave a vertex, ascending.
    pub(super) fn leaving(&self, v: VertId) -> &[u32] {
        &self.leaving[self.offsets[v as usize] as usize..self.offsets[v as usize + 1] as usize]
    }

    /// The triangle across each edge of a triangle.
    pub(super) fn neighbours(&self, triangle: usize) -> [Option<usize>; 3] {
        [0, 1, 2].map(|k| self.twin((3 * triangle + k) as u32).map(Self::triangle))
    }

    /// The triangles round a vertex, in runs of the same `key`: (key, triangles). The runs are in order round the
    /// vertex when it is inside the mesh and manifold.
    pub(super) fn sectors(&self, v: VertId, key: impl Fn(usize) -> u32) -> Vec<(u32, Vec<usize>)> {
        let leaving = self.leaving(v);
        let Some(&start) = leaving.first() else { return Vec::new() };
        // Turn clockwise to the first change of key or to the boundary, then once round counter-clockwise.
        let mut first = start;
        for _ in 0..leaving.len() {
            let Some(twin) = self.twin(first) else { break };
            let before = Self::next(twin);
            if key(Self::triangle(before)) != key(Self::triangle(first)) || before == start {
                break;
            }
            first = before;
        }
        let mut sectors: Vec<(u32, Vec<usize>)> = Vec::new();
        let mut h = first;
        for _ in 0..leaving.len() {
            let t = Self::triangle(h);
            match sectors.last_mut() {
                Some((last, triangles)) if *last == key(t) => triangles.push(t),
                _ => sectors.push((key(t), vec![t])),
            }
            match self.twin(Self::previous(h)) {
                Some(next) if next != first => h = next,
                _ => break,
            }
        }
        sectors
    }

    /// Connected components of triangles with equal `key`, joined over edges; numbered by first triangle.
    pub(super) fn components(&self, key: impl Fn(usize) -> u32) -> (Vec<u32>, usize) {
        let n = self.triangles.len();
        let mut component = vec![NONE; n];
        let (mut count, mut stack) = (0, Vec::new());
        for start in 0..n {
            if component[start] != NONE {
                continue;
            }
            component[start] = count;
            stack.push(start);
            while let Some(t) = stack.pop() {
                for u in self.neighbours(t).into_iter().flatten() {
                    if component[u] == NONE && key(u) == key(t) {
                        component[u] = count;
                        stack.push(u);
                    }
                }
            }
            count += 1;
        }
        (component, count as usize)
    }
}
