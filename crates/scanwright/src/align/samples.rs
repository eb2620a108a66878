//! Small models for tests.

use crate::math::{Axis, Point3, Vec3};
use crate::mesh::Mesh;
use crate::prior::{PriorFace, PriorModel};
use crate::surface::{Cylinder, Plane, Surface};

/// A closed cylinder about z, its middle in the origin, drawn with `n` flats.
pub fn drum(radius: f64, height: f64, n: u32) -> PriorModel {
    let mut vertices = vec![Point3::new(0.0, 0.0, -height / 2.0), Point3::new(0.0, 0.0, height / 2.0)];
    for k in 0..n {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(n)).sin_cos();
        vertices.extend([-1.0, 1.0].map(|s| Point3::new(radius * cos, radius * sin, s * height / 2.0)));
    }
    let (mut triangles, mut face_of) = (Vec::new(), Vec::new());
    for k in 0..n {
        let [low, high] = [2 + 2 * k, 3 + 2 * k];
        let [next_low, next_high] = [2 + 2 * ((k + 1) % n), 3 + 2 * ((k + 1) % n)];
        triangles.extend([
            [low, next_low, next_high],
            [low, next_high, high],
            [0, next_low, low],
            [1, high, next_high],
        ]);
        face_of.extend([0, 0, 1, 2]);
    }
    let axis = Axis { origin: Point3::origin(), direction: Vec3::z_axis() };
    let lid = |z: f64| {
        let normal = if z > 0.0 { Vec3::z_axis() } else { -Vec3::z_axis() };
        Surface::Plane(Plane { point: Point3::new(0.0, 0.0, z), normal })
    };
    let surfaces = [Surface::Cylinder(Cylinder { axis, radius }), lid(-height / 2.0), lid(height / 2.0)];
    let faces = surfaces.into_iter().enumerate().map(|(k, surface)| PriorFace {
        name: format!("face {}", k + 1),
        surface: Some(surface),
        outward: true,
    });
    PriorModel {
        mesh: Mesh { vertices, triangles },
        face_of,
        faces: faces.collect(),
        ..PriorModel::default()
    }
}
