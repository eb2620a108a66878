//! Whether features explain a solid: which of its faces they have, and how much volume they have too much or too little.

use super::body::Body;
use super::feature::Model;
use crate::math::Point3;
use crate::par;
use crate::random::Rng;

/// What the features have of a solid.
#[derive(Debug, Clone)]
pub(super) struct Verdict {
    /// Enclosed volume of the solid.
    pub(super) volume: f64,
    /// Volume of the features, expected from samples.
    pub(super) expected: f64,
    /// Volume that is in one of the two only.
    pub(super) differs: f64,
    /// One per face: whether the features have it.
    pub(super) expressed: Vec<bool>,
}

pub(super) fn judge(body: &Body, model: &Model, tolerance: f64, seed: u64) -> Verdict {
    const N: usize = 200_000;
    const CHUNK: usize = 2000;
    let (low, high) = body.bounds;
    let size = high - low;
    let box_volume = size.x * size.y * size.z;
    let counts = par::map_indices(N / CHUNK, |chunk| {
        let mut rng = Rng::for_task(seed, "script-judge", chunk as u64);
        let (mut more, mut less) = (0_usize, 0_usize);
        for _ in 0..CHUNK {
            let p = low
                + size.component_mul(&crate::math::Vec3::new(rng.uniform(), rng.uniform(), rng.uniform()));
            match (model.contains(&p), body.contains(&p)) {
                (true, false) => more += 1,
                (false, true) => less += 1,
                _ => {}
            }
        }
        (more, less)
    });
    let more: usize = counts.iter().map(|c| c.0).sum();
    let less: usize = counts.iter().map(|c| c.1).sum();
    let each = box_volume / N as f64;
    let volume = body.volume();
    Verdict {
        volume,
        expected: volume + (more as f64 - less as f64) * each,
        differs: (more + less) as f64 * each,
        expressed: par::map_indices(body.solid.faces.len(), |face| {
            is_expressed(body, model, face, tolerance)
        }),
    }
}

/// Whether the features end where the face is, on the same side, over most of its area.
fn is_expressed(body: &Body, model: &Model, face: usize, tolerance: f64) -> bool {
    /// Share of the area.
    const MOST: f64 = 0.9;
    let mesh = &body.tessellation.mesh;
    let (mut found, mut total) = (0.0, 0.0);
    for &t in &body.triangles[face] {
        let [a, b, c] = mesh.corners(t as usize);
        let cross = mesh.cross(t as usize);
        let double_area = cross.norm();
        if double_area <= 0.0 {
            continue;
        }
        let outward = cross / double_area;
        for (u, v) in [(1.0, 1.0), (4.0, 1.0), (1.0, 4.0), (1.0, 1.0 / 4.0)] {
            let sum = 1.0 + u + v;
            let p = Point3::from((a.coords + b.coords * u + c.coords * v) / sum);
            let p = p - outward * body.distance_to_surface(crate::brep::FaceId(face as u32), &p);
            total += double_area;
            let [inner, outer] = [-2.0 * tolerance, 2.0 * tolerance].map(|d| p + outward * d);
            // Beside an edge the solid itself is not what the face says; such points tell nothing.
            if !body.contains(&inner) || body.contains(&outer) {
                total -= double_area;
                continue;
            }
            if model.contains(&inner) && !model.contains(&outer) {
                found += double_area;
            }
        }
    }
    total > 0.0 && found >= MOST * total
}
