//! What is asked of the solid itself: whether a point is inside, which face is nearest, how much it encloses.

use crate::brep::{FaceId, Geometry, Solid, Tessellation, tessellate};
use crate::deviation::Nearest;
use crate::math::Point3;

/// A solid that can be asked about points.
///
/// Far from the faces its triangles answer; within their sagitta of a face the face's own surface does, so that round
/// faces do not lose what chords cut off.
#[derive(Debug, Clone)]
pub(super) struct Body<'a> {
    pub(super) solid: &'a Solid,
    pub(super) tessellation: Tessellation,
    nearest: Nearest,
    /// Largest distance between a triangle and the surface of its face, length.
    sagitta: f64,
    /// Lowest and highest corner.
    pub(super) bounds: (Point3, Point3),
    /// One per face: the triangles of it.
    pub(super) triangles: Vec<Vec<u32>>,
}

impl<'a> Body<'a> {
    /// `None` when the solid has no triangle with an area.
    pub(super) fn new(solid: &'a Solid) -> Option<Self> {
        let tessellation = tessellate(solid);
        let nearest = Nearest::new(&tessellation.mesh)?;
        let bounds = tessellation.mesh.bounds()?;
        let mut triangles = vec![Vec::new(); solid.faces.len()];
        for (t, face) in tessellation.faces.iter().enumerate() {
            triangles[face.0 as usize].push(t as u32);
        }
        let mut body = Self { solid, tessellation, nearest, sagitta: 0.0, bounds, triangles };
        body.sagitta = (0..body.tessellation.faces.len())
            .map(|t| {
                let center = body.tessellation.mesh.triangle_center(t);
                body.distance_to_surface(body.tessellation.faces[t], &center).abs()
            })
            .fold(0.0, f64::max);
        Some(body)
    }

    /// Whether a point is inside the material.
    pub(super) fn contains(&self, point: &Point3) -> bool {
        /// The farthest points of a triangle from its surface are not only at its centre.
        const ROOM: f64 = 2.0;
        let (t, distance) = self.nearest.triangle_and_distance(point);
        if distance.abs() > ROOM * self.sagitta {
            return distance < 0.0;
        }
        let face = self.tessellation.faces[t];
        match self.solid.geometry(self.solid.face(face)) {
            Geometry::Analytic(_) => self.distance_to_surface(face, point) < 0.0,
            Geometry::Spline(_) => distance < 0.0,
        }
    }

    /// The face nearest to a point, and how far it is.
    pub(super) fn nearest_face(&self, point: &Point3) -> (FaceId, f64) {
        let (t, distance) = self.nearest.triangle_and_distance(point);
        let face = self.tessellation.faces[t];
        let exact = match self.solid.geometry(self.solid.face(face)) {
            Geometry::Analytic(_) => self.distance_to_surface(face, point).abs(),
            Geometry::Spline(_) => 0.0,
        };
        // A chord may be nearer than its surface, never by more than the sagitta.
        (face, if distance.abs() > self.sagitta { distance.abs() } else { exact })
    }

    /// Distance of a point to the unbounded surface of a face, positive outside the material; zero for a spline.
    pub(super) fn distance_to_surface(&self, face: FaceId, point: &Point3) -> f64 {
        let face = self.solid.face(face);
        match self.solid.geometry(face) {
            Geometry::Analytic(surface) => {
                let distance = surface.signed_distance(point);
                if face.same_sense { distance } else { -distance }
            }
            Geometry::Spline(_) => 0.0,
        }
    }

    /// Corners of the triangles of a face.
    pub(super) fn points(&self, face: usize) -> Vec<Point3> {
        let mesh = &self.tessellation.mesh;
        let mut ids: Vec<u32> =
            self.triangles[face].iter().flat_map(|t| mesh.triangles[*t as usize]).collect();
        ids.sort_unstable();
        ids.dedup();
        ids.into_iter().map(|v| mesh.vertices[v as usize]).collect()
    }

    /// Area of a face's triangles.
    pub(super) fn area(&self, face: usize) -> f64 {
        self.triangles[face].iter().map(|t| self.tessellation.mesh.area(*t as usize)).sum()
    }

    /// Enclosed volume: that of the triangles, and what lies between them and the surfaces.
    pub(super) fn volume(&self) -> f64 {
        let mesh = &self.tessellation.mesh;
        // The mean of a quadratic over a triangle is that at the middles of its sides.
        let beyond = |t: usize| -> f64 {
            let [a, b, c] = mesh.corners(t);
            let middles = [(a, b), (b, c), (c, a)].map(|(p, q)| nalgebra::center(&p, &q));
            let mean = middles.iter().map(|m| self.distance_to_surface(self.tessellation.faces[t], m));
            mesh.area(t) * mean.sum::<f64>() / 3.0
        };
        mesh.signed_volume() - (0..mesh.triangles.len()).map(beyond).sum::<f64>()
    }
}
