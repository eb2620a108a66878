//! Filtered normals and positions for decisions of topology; parameters are fitted to the raw points.
//!
//! Two steps, as all methods here share: the triangle normals are filtered, then the vertices are moved to agree with
//! them; `Guided` takes both in turns. Every method takes its strength from the measured noise, so there is nothing to
//! tune per scan, and a mesh without noise comes back as it was. Rounds are Jacobi: each reads only the result of the
//! last, so the result does not depend on the number of threads.

mod bilateral;
mod guided;
mod neighborhood;
mod random_walk;
mod ring;
mod sun2007;
mod vertices;

pub use bilateral::Bilateral;
pub use guided::Guided;
pub use neighborhood::Neighbors;
pub use ring::ring_filtered_normals;
pub use sun2007::{Sun2007, Weighting};

use crate::math::{Point3, Vec3};
use crate::mesh::{Adjacency, Mesh};
use crate::tolerance::Tolerances;

use neighborhood::Neighborhood;
use vertices::follow_normals;

/// A filtered copy of a mesh's geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct Denoised {
    /// One unit normal per triangle.
    pub triangle_normals: Vec<Vec3>,
    /// One position per vertex.
    pub vertices: Vec<Point3>,
}

/// How normals are filtered.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum DenoiseMethod {
    /// Bilateral where the noise is weak, guided where it is strong: guidance finds creases under noise that the
    /// bilateral filter crosses, but sharpens edges that are round and facets surfaces that are curved, which weak noise
    /// does not excuse.
    #[default]
    Adaptive,
    /// Thresholded mean of the neighbours' normals.
    Sun2007(Sun2007),
    /// Mean weighted by distance and by difference of the normals.
    Bilateral(Bilateral),
    /// The same, with the difference taken from a smoother guidance.
    Guided(Guided),
}

/// Deviation of normals, radians, from which the adaptive method is the guided one: between noise of 0.1 edge lengths,
/// where the bilateral filter leaves less on curved and blunt meshes, and of 0.2, where the guided one does
/// (`docs/denoising.md`).
const GUIDED_FROM: f64 = 0.2;

impl DenoiseMethod {
    /// Every method with its default options.
    pub fn all_defaults() -> [Self; 4] {
        [
            Self::Adaptive,
            Self::Sun2007(Sun2007::default()),
            Self::Bilateral(Bilateral::default()),
            Self::Guided(Guided::default()),
        ]
    }

    /// Name for people and tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Adaptive => "adaptive",
            Self::Sun2007(_) => "sun2007",
            Self::Bilateral(_) => "bilateral",
            Self::Guided(_) => "guided",
        }
    }
}

/// Filters normals and positions of `mesh`. Without measured noise both come back unchanged.
pub fn denoise(
    mesh: &Mesh,
    adjacency: &Adjacency,
    tolerances: &Tolerances,
    method: &DenoiseMethod,
) -> Denoised {
    let raw = mesh.triangle_normals();
    let noise = tolerances.normal_noise();
    if noise.is_nan() || noise <= 0.0 {
        return Denoised { triangle_normals: raw, vertices: mesh.vertices.clone() };
    }
    let around = |neighbors| Neighborhood::new(mesh, adjacency, neighbors);
    let triangle_normals = match *method {
        DenoiseMethod::Sun2007(options) => {
            sun2007::run(&around(options.neighbors), adjacency, raw, noise, &options)
        }
        DenoiseMethod::Bilateral(options) => bilateral::run(&around(Neighbors::Vertex), raw, noise, &options),
        DenoiseMethod::Guided(options) => return guided::run(mesh, adjacency, tolerances, &options),
        DenoiseMethod::Adaptive if noise < GUIDED_FROM => {
            bilateral::run(&around(Neighbors::Vertex), raw, noise, &Bilateral::default())
        }
        DenoiseMethod::Adaptive => return guided::run(mesh, adjacency, tolerances, &Guided::default()),
    };
    let start = mesh.vertices.clone();
    let vertices =
        follow_normals(mesh, adjacency, start, &triangle_normals, tolerances.noise(), vertices::ROUNDS);
    Denoised { triangle_normals, vertices }
}

/// Area-weighted unit vertex normals made of the filtered triangle normals; zero where no triangle gives one.
pub fn vertex_normals(mesh: &Mesh, denoised: &Denoised) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        // Areas of the raw mesh: the filtered one has the same triangles, and slivers stay slivers.
        let share = denoised.triangle_normals[t] * mesh.area(t);
        for &v in triangle {
            normals[v as usize] += share;
        }
    }
    normals.into_iter().map(|n| n.try_normalize(0.0).unwrap_or_else(Vec3::zeros)).collect()
}
