//! A model known before the scan: the faces of a CAD file, or a mesh.

use crate::math::{Point3, Vec3};
use crate::mesh::Mesh;
use crate::surface::Surface;

/// Triangles of a model, and the faces they belong to.
#[derive(Debug, Clone, Default)]
pub struct PriorModel {
    /// Triangles of all faces, outward; vertices on a common edge of two faces are shared where the file shares it.
    pub mesh: Mesh,
    /// One per triangle: the face it belongs to, an index into `faces`.
    pub face_of: Vec<u32>,
    /// Faces, in the order of the file. A mesh without faces is one face.
    pub faces: Vec<PriorFace>,
    /// Solids and shells of a CAD file, in the order in which its assemblies place them; none of a mesh.
    pub parts: Vec<PriorPart>,
    /// Length of the file's unit in millimetres, when it says so.
    pub millimetres: Option<f64>,
    /// What could not be read, one sentence each with its place; faces left out are among them.
    pub unread: Vec<String>,
}

/// A face of a prior model.
#[derive(Debug, Clone, PartialEq)]
pub struct PriorFace {
    /// Its name in the file, or `face N`, from 1.
    pub name: String,
    /// Its surface, when that is one of the five analytic ones.
    pub surface: Option<Surface>,
    /// Whether the surface's natural normal points out of the material.
    pub outward: bool,
}

/// A solid or shell of a prior model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PriorPart {
    /// Name of its product; empty when the file has none.
    pub name: String,
    /// Its first face.
    pub first_face: u32,
    /// How many faces from there are its own.
    pub n_faces: u32,
}

impl PriorModel {
    /// A mesh as one face without a surface.
    pub fn from_mesh(mesh: Mesh) -> Self {
        let face = PriorFace { name: "face 1".to_owned(), surface: None, outward: true };
        Self { face_of: vec![0; mesh.triangles.len()], mesh, faces: vec![face], ..Self::default() }
    }

    /// The model in another unit: lengths times `factor`.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        let still = nalgebra::Rotation3::identity();
        for vertex in &mut self.mesh.vertices {
            *vertex = Point3::from(vertex.coords * factor);
        }
        for face in &mut self.faces {
            face.surface = face.surface.map(|s| s.transformed(&still, factor, &Vec3::zeros()));
        }
        self.millimetres = self.millimetres.map(|length| length / factor);
        self
    }
}
