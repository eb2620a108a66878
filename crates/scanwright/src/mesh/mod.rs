//! The scan: an indexed triangle mesh, its adjacency and its boundary.

mod adjacency;
mod boundary;
mod connected;
mod winding;

pub use adjacency::{Adjacency, Csr};
pub use boundary::boundary_loops;
pub use connected::connected;
pub use winding::winding_number;

use crate::math::{Point3, Pose, Vec3};

/// Index of a triangle of a [`Mesh`].
pub type TriId = u32;
/// Index of a vertex of a [`Mesh`].
pub type VertId = u32;

/// An indexed triangle mesh. Nothing is promised about it: it may be open, non-manifold, inconsistently oriented.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Positions, in the scan's unit.
    pub vertices: Vec<Point3>,
    /// Three vertex indices each, counter-clockwise seen from outside.
    pub triangles: Vec<[VertId; 3]>,
}

impl Mesh {
    /// Corner positions of a triangle.
    pub fn corners(&self, triangle: usize) -> [Point3; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// Twice the vector area of a triangle: along its normal, as long as twice its area.
    pub fn cross(&self, triangle: usize) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(&(c - a))
    }

    /// Area of a triangle.
    pub fn area(&self, triangle: usize) -> f64 {
        0.5 * self.cross(triangle).norm()
    }

    /// Unit normal of every triangle; zero where the area is zero.
    pub fn triangle_normals(&self) -> Vec<Vec3> {
        (0..self.triangles.len())
            .map(|t| self.cross(t).try_normalize(0.0).unwrap_or_else(Vec3::zeros))
            .collect()
    }

    /// Area-weighted unit normal of every vertex; zero where no triangle gives one.
    pub fn vertex_normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::zeros(); self.vertices.len()];
        for (t, triangle) in self.triangles.iter().enumerate() {
            let cross = self.cross(t);
            for &v in triangle {
                normals[v as usize] += cross;
            }
        }
        normals.into_iter().map(|n| n.try_normalize(0.0).unwrap_or_else(Vec3::zeros)).collect()
    }

    /// Centroid of a triangle.
    pub fn triangle_center(&self, triangle: usize) -> Point3 {
        let [a, b, c] = self.corners(triangle);
        Point3::from((a.coords + b.coords + c.coords) / 3.0)
    }

    /// Total area.
    pub fn total_area(&self) -> f64 {
        (0..self.triangles.len()).map(|t| self.area(t)).sum()
    }

    /// Volume enclosed by the triangles, signed; meaningful when the mesh is closed and oriented.
    pub fn signed_volume(&self) -> f64 {
        let Some(base) = self.vertices.first() else { return 0.0 };
        let six_fold: f64 = (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t).map(|p| p - base);
                a.dot(&b.cross(&c))
            })
            .sum();
        six_fold / 6.0
    }

    /// Lowest and highest corner of the bounding box; `None` without vertices.
    pub fn bounds(&self) -> Option<(Point3, Point3)> {
        let first = *self.vertices.first()?;
        Some(self.vertices.iter().fold((first, first), |(lo, hi), p| (lo.inf(p), hi.sup(p))))
    }

    /// Length of the bounding box's diagonal; zero without vertices.
    pub fn diagonal(&self) -> f64 {
        self.bounds().map_or(0.0, |(lo, hi)| (hi - lo).norm())
    }

    /// Largest absolute coordinate.
    pub fn largest_coordinate(&self) -> f64 {
        self.vertices.iter().fold(0.0, |m, p| m.max(p.coords.amax()))
    }

    /// The mesh after a rigid motion.
    #[must_use]
    pub fn moved(&self, pose: &Pose) -> Self {
        Self {
            vertices: self.vertices.iter().map(|p| pose.point(p)).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// The triangles for which `keep` holds, without unused vertices. Also returns, per new triangle, its old index,
    /// and, per new vertex, its old index.
    pub fn submesh(&self, keep: impl Fn(usize) -> bool) -> (Self, Vec<TriId>, Vec<VertId>) {
        let mut new_of_old = vec![VertId::MAX; self.vertices.len()];
        let (mut mesh, mut old_triangles, mut old_vertices) = (Self::default(), Vec::new(), Vec::new());
        for (t, triangle) in self.triangles.iter().enumerate().filter(|(t, _)| keep(*t)) {
            let renamed = triangle.map(|v| {
                let new = &mut new_of_old[v as usize];
                if *new == VertId::MAX {
                    *new = mesh.vertices.len() as VertId;
                    mesh.vertices.push(self.vertices[v as usize]);
                    old_vertices.push(v);
                }
                *new
            });
            mesh.triangles.push(renamed);
            old_triangles.push(t as TriId);
        }
        (mesh, old_triangles, old_vertices)
    }
}
