//! Faces of any size, checked and cut into triangles.

use super::error::{Place, ReadError};
use super::text::Item;
use crate::mesh::VertId;

/// Collects faces corner by corner. A face of more than three corners becomes a fan about its first corner, which is
/// right for convex faces only.
#[derive(Debug)]
pub(super) struct Polygons {
    pub triangles: Vec<[VertId; 3]>,
    /// Faces of more than three corners.
    pub n_larger: usize,
    n_vertices: usize,
    /// Index of the first vertex in this format: 0 or 1.
    first: i64,
    corners: Vec<VertId>,
}

impl Polygons {
    pub fn new(n_vertices: usize, first: i64) -> Self {
        Self { triangles: Vec::new(), n_larger: 0, n_vertices, first, corners: Vec::new() }
    }

    /// Changes how many vertices there are.
    pub fn set_n_vertices(&mut self, n_vertices: usize) {
        self.n_vertices = n_vertices;
    }

    /// Adds a corner to the present face.
    pub fn corner(
        &mut self,
        vertex: i64,
        item: Item,
        place: impl FnOnce() -> Place,
    ) -> Result<(), ReadError> {
        let last = self.n_vertices as i64 - 1 + self.first;
        if vertex < self.first || vertex > last {
            let (element, first) = (item.to_string(), self.first);
            return Err(ReadError::Index { place: place(), element, index: vertex, first, last });
        }
        self.corners.push((vertex - self.first) as VertId);
        Ok(())
    }

    /// Ends the present face.
    pub fn finish(&mut self, item: Item, place: impl FnOnce() -> Place) -> Result<(), ReadError> {
        let n = self.corners.len();
        if n < 3 {
            return Err(ReadError::Value {
                place: place(),
                element: item.to_string(),
                value: format!("of {n} corners"),
                expected: "of three or more",
            });
        }
        for pair in self.corners[1..].windows(2) {
            self.triangles.push([self.corners[0], pair[0], pair[1]]);
        }
        self.n_larger += usize::from(n > 3);
        self.corners.clear();
        Ok(())
    }
}
