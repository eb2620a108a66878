use super::{Mesh, TriId, VertId};

/// Lists of varying length, stored in one array.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Csr {
    offsets: Vec<u32>,
    items: Vec<u32>,
}

impl Csr {
    /// Groups `(row, item)` pairs by row, keeping their order within a row.
    pub fn from_pairs(n_rows: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut offsets = vec![0_u32; n_rows + 1];
        for (row, _) in pairs.clone() {
            offsets[row as usize + 1] += 1;
        }
        for i in 0..n_rows {
            offsets[i + 1] += offsets[i];
        }
        let mut next = offsets.clone();
        let mut items = vec![0; offsets[n_rows] as usize];
        for (row, item) in pairs {
            items[next[row as usize] as usize] = item;
            next[row as usize] += 1;
        }
        Self { offsets, items }
    }

    /// The items of a row.
    pub fn row(&self, i: usize) -> &[u32] {
        &self.items[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Who touches whom in a mesh.
#[derive(Debug, Clone, Default)]
pub struct Adjacency {
    /// Triangles at each vertex, ascending.
    pub vertex_triangles: Csr,
    /// Vertices joined to each vertex by an edge, ascending.
    pub vertex_vertices: Csr,
    /// Triangle across each edge of each triangle: edge `k` joins corners `k` and `k + 1`. `None` on the boundary and
    /// at edges of three or more triangles.
    pub across: Vec<[Option<TriId>; 3]>,
    /// Whether a vertex lies on an edge of exactly one triangle.
    pub on_boundary: Vec<bool>,
}

impl Adjacency {
    /// Adjacency of `mesh`. O(n log n) in the number of edges.
    pub fn new(mesh: &Mesh) -> Self {
        let n_vertices = mesh.vertices.len();
        let corners = mesh.triangles.iter().enumerate().flat_map(|(t, tri)| tri.map(|v| (v, t as u32)));
        let vertex_triangles = Csr::from_pairs(n_vertices, corners);
        // One row per undirected edge: (low vertex, high vertex, triangle, edge of the triangle).
        let mut edges: Vec<(VertId, VertId, u32, u8)> = Vec::with_capacity(3 * mesh.triangles.len());
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                edges.push((a.min(b), a.max(b), t as u32, k as u8));
            }
        }
        edges.sort_unstable();
        let mut across = vec![[None; 3]; mesh.triangles.len()];
        let mut on_boundary = vec![false; n_vertices];
        let mut links = Vec::new();
        for group in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            let (a, b, t, k) = group[0];
            links.push((a, b));
            match group {
                [_] => {
                    on_boundary[a as usize] = true;
                    on_boundary[b as usize] = true;
                }
                [_, (_, _, u, l)] => {
                    across[t as usize][k as usize] = Some(*u);
                    across[*u as usize][*l as usize] = Some(t);
                }
                _ => {}
            }
        }
        let both_ways = links.iter().flat_map(|&(a, b)| [(a, b), (b, a)]);
        let mut vertex_vertices = Csr::from_pairs(n_vertices, both_ways);
        for i in 0..n_vertices {
            let (from, to) = (vertex_vertices.offsets[i] as usize, vertex_vertices.offsets[i + 1] as usize);
            vertex_vertices.items[from..to].sort_unstable();
        }
        Self { vertex_triangles, vertex_vertices, across, on_boundary }
    }

    /// Connected components over shared edges: the component of each triangle, numbered by first triangle, and how
    /// many there are.
    pub fn components(&self) -> (Vec<u32>, usize) {
        let mut component = vec![u32::MAX; self.across.len()];
        let mut n_components = 0;
        let mut stack = Vec::new();
        for start in 0..self.across.len() {
            if component[start] != u32::MAX {
                continue;
            }
            component[start] = n_components;
            stack.push(start);
            while let Some(t) = stack.pop() {
                for u in self.across[t].into_iter().flatten() {
                    if component[u as usize] == u32::MAX {
                        component[u as usize] = n_components;
                        stack.push(u as usize);
                    }
                }
            }
            n_components += 1;
        }
        (component, n_components as usize)
    }
}
