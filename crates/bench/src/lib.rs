//! The scan that the benches in `benches/` work on; this crate is never published.

use scanwright::math::{Point3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::random::Rng;

/// Outline of a flanged bushing, (radius, height) of its corners: planes, cylinders and a cone when turned.
const OUTLINE: [(f64, f64); 9] = [
    (8.0, 0.0),
    (20.0, 0.0),
    (20.0, 6.0),
    (13.0, 6.0),
    (13.0, 30.0),
    (11.0, 32.0),
    (8.0, 32.0),
    (8.0, 20.0),
    (8.0, 10.0),
];
/// Standard deviation of the noise as a share of the vertex spacing, that of a good desktop scanner.
const NOISE_PER_SPACING: f64 = 0.08;

/// A noisy closed scan of the bushing with about `n_triangles` triangles, counter-clockwise seen from outside.
pub fn bushing(n_triangles: usize) -> Mesh {
    let corner = |k: usize| OUTLINE[k % OUTLINE.len()];
    let sides: Vec<_> = (0..OUTLINE.len()).map(|k| (corner(k), corner(k + 1))).collect();
    let length_of = |((r0, z0), (r1, z1)): ((f64, f64), (f64, f64))| (r1 - r0).hypot(z1 - z0);
    let area: f64 =
        sides.iter().map(|&side| length_of(side) * std::f64::consts::PI * (side.0.0 + side.1.0)).sum();
    let spacing = (2.0 * area / n_triangles as f64).sqrt();
    let mut profile = Vec::new();
    for &side in &sides {
        let ((r0, z0), (r1, z1)) = side;
        let n = (length_of(side) / spacing).round().max(1.0) as usize;
        profile.extend((0..n).map(|i| {
            let t = i as f64 / n as f64;
            (r0 + t * (r1 - r0), z0 + t * (z1 - z0))
        }));
    }
    // The mean radius gives square cells on average.
    let mean_radius = profile.iter().map(|p| p.0).sum::<f64>() / profile.len() as f64;
    let n_turns = ((std::f64::consts::TAU * mean_radius / spacing).round() as usize).max(3);
    turned(&profile, n_turns, NOISE_PER_SPACING * spacing)
}

/// A closed profile turned about z, with `noise` in all directions.
fn turned(profile: &[(f64, f64)], n_turns: usize, noise: f64) -> Mesh {
    let mut rng = Rng::for_task(1, "bench", profile.len() as u64);
    let mut mesh = Mesh::default();
    for j in 0..n_turns {
        let (sin, cos) = (std::f64::consts::TAU * j as f64 / n_turns as f64).sin_cos();
        for &(r, z) in profile {
            let jitter = Vec3::new(rng.normal(), rng.normal(), rng.normal()) * noise;
            mesh.vertices.push(Point3::new(r * cos, r * sin, z) + jitter);
        }
    }
    let at = |j: usize, i: usize| ((j % n_turns) * profile.len() + i % profile.len()) as u32;
    for j in 0..n_turns {
        for i in 0..profile.len() {
            let [a, b, c, d] = [at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanwright::mesh::Adjacency;

    #[test]
    fn the_bushing_is_closed_and_as_large_as_its_outline_says() {
        let mesh = bushing(20_000);
        let n = mesh.triangles.len();
        assert!((15_000..25_000).contains(&n), "{n} triangles");
        assert!(Adjacency::new(&mesh).across.iter().flatten().all(Option::is_some), "there is a boundary");
        // Flange, sleeve and the frustum of the chamfer, less the bore.
        let pi = std::f64::consts::PI;
        let frustum = pi * 2.0 / 3.0 * (13.0_f64.powi(2) + 13.0 * 11.0 + 11.0_f64.powi(2));
        let expected = pi * (400.0 * 6.0 + 169.0 * 24.0 - 64.0 * 32.0) + frustum;
        let volume = mesh.signed_volume();
        assert!((volume / expected - 1.0).abs() < 0.02, "volume {volume}, expected {expected}");
    }
}
