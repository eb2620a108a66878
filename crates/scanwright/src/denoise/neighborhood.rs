//! Triangles that share a vertex or an edge, and what the filters need to know of them.

use crate::math::{Point3, Vec3};
use crate::mesh::{Adjacency, Mesh, TriId};
use crate::par;

/// Triangles handled by one task.
const CHUNK: usize = 2_048;

/// Which triangles are around a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Neighbors {
    /// Those that share a vertex with it: a dozen.
    #[default]
    Vertex,
    /// Those that share an edge with it: three.
    Edge,
}

/// The triangles around every triangle.
pub(super) struct Neighborhood {
    offsets: Vec<u32>,
    items: Vec<TriId>,
    /// Area of every triangle.
    pub areas: Vec<f64>,
    /// Centroid of every triangle.
    pub centers: Vec<Point3>,
    /// Mean distance of the centroids of triangles that share an edge.
    pub center_distance: f64,
}

impl Neighborhood {
    /// Neighbourhoods of `mesh`. O(n).
    pub fn new(mesh: &Mesh, adjacency: &Adjacency, neighbors: Neighbors) -> Self {
        let n = mesh.triangles.len();
        let starts: Vec<usize> = (0..n).step_by(CHUNK).collect();
        let parts = par::map(&starts, |&start| {
            let (mut counts, mut items) =
                (Vec::<u32>::with_capacity(CHUNK), Vec::<TriId>::with_capacity(14 * CHUNK));
            let mut row: Vec<TriId> = Vec::new();
            for t in start..n.min(start + CHUNK) {
                row.clear();
                match neighbors {
                    Neighbors::Vertex => {
                        for &v in &mesh.triangles[t] {
                            row.extend(adjacency.vertex_triangles.row(v as usize));
                        }
                    }
                    Neighbors::Edge => {
                        row.push(t as TriId);
                        row.extend(adjacency.across[t].iter().flatten());
                    }
                }
                row.sort_unstable();
                row.dedup();
                counts.push(row.len() as u32);
                items.extend(&row);
            }
            (counts, items)
        });
        let (mut offsets, mut items) = (vec![0], Vec::new());
        let mut end = 0;
        for (counts, part) in parts {
            for count in counts {
                end += count;
                offsets.push(end);
            }
            items.extend(part);
        }
        let mut found = Self { offsets, items, areas: Vec::new(), centers: Vec::new(), center_distance: 0.0 };
        found.measure(mesh, adjacency);
        found
    }

    /// Takes areas and centroids from `mesh`, whose vertices may have moved.
    pub fn measure(&mut self, mesh: &Mesh, adjacency: &Adjacency) {
        let n = mesh.triangles.len();
        self.areas = par::map_indices(n, |t| mesh.area(t));
        self.centers = par::map_indices(n, |t| mesh.triangle_center(t));
        let (mut sum, mut count) = (0.0, 0.0);
        for (t, across) in adjacency.across.iter().enumerate() {
            for u in across.iter().flatten() {
                sum += (self.centers[t] - self.centers[*u as usize]).norm();
                count += 1.0;
            }
        }
        self.center_distance = if count > 0.0 { sum / count } else { 0.0 };
    }

    /// The neighbours of triangle `t`, itself among them, ascending.
    pub fn around(&self, t: usize) -> &[TriId] {
        &self.items[self.offsets[t] as usize..self.offsets[t + 1] as usize]
    }

    /// Index of the first entry of `around(t)` in arrays that run parallel to all neighbourhoods.
    pub fn offset(&self, t: usize) -> usize {
        self.offsets[t] as usize
    }

    /// One weight per entry of every `around(t)`: area times a Gaussian of the centroids' distance, of standard
    /// deviation `reach` mean centroid distances.
    pub fn spatial_weights(&self, reach: f64) -> Vec<f64> {
        let deviation = reach * self.center_distance;
        let rows = par::map_indices(self.areas.len(), |t| {
            let weight = |&u: &TriId| {
                let distance = (self.centers[t] - self.centers[u as usize]).norm();
                // Without any extent (0 / 0) all triangles count alike.
                let relative = if deviation > 0.0 { distance / deviation } else { 0.0 };
                self.areas[u as usize] * (-0.5 * relative * relative).exp()
            };
            self.around(t).iter().map(weight).collect::<Vec<f64>>()
        });
        rows.into_iter().flatten().collect()
    }
}

/// Repeats `round`, from normals to normals, until their mean change is below `still` radians, at most
/// `max_rounds` times.
pub(super) fn repeat(
    mut normals: Vec<Vec3>,
    max_rounds: usize,
    still: f64,
    round: impl Fn(&[Vec3], usize) -> Vec3 + Sync + Send,
) -> Vec<Vec3> {
    for _ in 0..max_rounds {
        let next = par::map_indices(normals.len(), |t| round(&normals, t));
        let change: f64 = next.iter().zip(&normals).map(|(a, b)| (a - b).norm()).sum();
        let mean = change / (next.len().max(1) as f64);
        normals = next;
        if mean < still {
            break;
        }
    }
    normals
}
