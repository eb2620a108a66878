//! Scans for the tests of whole runs: closed meshes of known parts with noise, the same every time.

use scanwright::math::{Point3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::random::Rng;
use std::collections::BTreeMap;

/// Standard deviation of the noise as a share of the vertex spacing, that of a good desktop scanner.
pub const NOISE_PER_SPACING: f64 = 0.06;

/// A box with one corner in the origin, vertices `spacing` apart.
pub fn block(size: [f64; 3], spacing: f64) -> Mesh {
    let n = size.map(|s| (s / spacing).round().max(1.0) as usize);
    let mut index = BTreeMap::new();
    let mut mesh = Mesh::default();
    let mut vertex = |p: [usize; 3], mesh: &mut Mesh| {
        *index.entry(p).or_insert_with(|| {
            let at = |k: usize| size[k] * p[k] as f64 / n[k] as f64;
            mesh.vertices.push(Point3::new(at(0), at(1), at(2)));
            mesh.vertices.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0, n[axis]] {
            for (i, j) in (0..n[u]).flat_map(|i| (0..n[v]).map(move |j| (i, j))) {
                let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| {
                    let mut p = [0; 3];
                    (p[axis], p[u], p[v]) = (side, i + di, j + dj);
                    vertex(p, &mut mesh)
                });
                // Counter-clockwise seen from outside.
                let [a, b, c, d] = if side == 0 { [a, d, c, b] } else { [a, b, c, d] };
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    with_noise(mesh, NOISE_PER_SPACING * spacing, 1)
}

/// A closed outline of (radius, height) corners, counter-clockwise, turned about z; vertices `spacing` apart.
pub fn turned(outline: &[(f64, f64)], spacing: f64) -> Mesh {
    let mut profile = Vec::new();
    for (k, &(r0, z0)) in outline.iter().enumerate() {
        let (r1, z1) = outline[(k + 1) % outline.len()];
        let n = ((r1 - r0).hypot(z1 - z0) / spacing).round().max(1.0) as usize;
        profile.extend((0..n).map(|i| i as f64 / n as f64).map(|t| (r0 + t * (r1 - r0), z0 + t * (z1 - z0))));
    }
    let widest = profile.iter().fold(0.0, |w: f64, p| w.max(p.0));
    let n_turns = (std::f64::consts::TAU * widest / spacing).round() as usize;
    let mut mesh = Mesh::default();
    for j in 0..n_turns {
        let (sin, cos) = (std::f64::consts::TAU * j as f64 / n_turns as f64).sin_cos();
        mesh.vertices.extend(profile.iter().map(|&(r, z)| Point3::new(r * cos, r * sin, z)));
    }
    let at = |j: usize, i: usize| ((j % n_turns) * profile.len() + i % profile.len()) as u32;
    for (j, i) in (0..n_turns).flat_map(|j| (0..profile.len()).map(move |i| (j, i))) {
        let [a, b, c, d] = [at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1)];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    with_noise(mesh, NOISE_PER_SPACING * spacing, 2)
}

/// A flanged bushing: planes, cylinders and a cone.
pub fn bushing(spacing: f64) -> Mesh {
    let outline =
        [(8.0, 0.0), (22.0, 0.0), (22.0, 8.0), (16.0, 8.0), (16.0, 18.0), (11.0, 28.0), (8.0, 28.0)];
    turned(&outline, spacing)
}

/// Both meshes as one, sharing nothing.
pub fn together(mut a: Mesh, b: &Mesh) -> Mesh {
    let shift = a.vertices.len() as u32;
    a.vertices.extend(&b.vertices);
    a.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + shift)));
    a
}

/// The mesh moved.
pub fn moved(mut mesh: Mesh, by: Vec3) -> Mesh {
    for vertex in &mut mesh.vertices {
        *vertex += by;
    }
    mesh
}

/// Normal noise of deviation `sigma` on every coordinate.
pub fn with_noise(mut mesh: Mesh, sigma: f64, seed: u64) -> Mesh {
    let mut rng = Rng::for_task(seed, "scans", 0);
    for vertex in &mut mesh.vertices {
        *vertex += Vec3::new(rng.normal(), rng.normal(), rng.normal()) * sigma;
    }
    mesh
}
