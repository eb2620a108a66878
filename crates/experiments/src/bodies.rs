//! Bodies to put noise on: a machined part with sharp edges and a fillet, and a wavy one without any.

use std::collections::BTreeMap;

use scanwright::math::{Point3, Vec3};
use scanwright::mesh::Mesh;

/// Vertices closer than this, lengths of the bodies being about 30, are one.
const WELD: f64 = 1e-6;

/// A mesh made of grids whose borders fall together.
#[derive(Default)]
struct Grids {
    mesh: Mesh,
    known: BTreeMap<[i64; 3], u32>,
}

impl Grids {
    /// Adds `at(i, j)` for `i` up to `n_u` and `j` up to `n_v`; the outside is where `i` cross `j` points. Diagonals
    /// alternate.
    fn add(&mut self, n_u: usize, n_v: usize, at: impl Fn(usize, usize) -> Point3) {
        for i in 0..n_u {
            for j in 0..n_v {
                let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                let [a, b, c, d] = corners.map(|(i, j)| self.vertex(at(i, j)));
                let halves = if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                self.mesh.triangles.extend(halves);
            }
        }
    }

    fn vertex(&mut self, p: Point3) -> u32 {
        let key = [p.x, p.y, p.z].map(|c| (c / WELD).round() as i64);
        *self.known.entry(key).or_insert_with(|| {
            self.mesh.vertices.push(p);
            self.mesh.vertices.len() as u32 - 1
        })
    }
}

/// A block of 30 by 20 by up to 12 with a stepped top: a plane, a fillet of radius 6 that runs tangentially into a slope,
/// a sharp valley, a plane; all other edges are sharp. About 6 500 vertices.
pub fn part() -> Mesh {
    let edge = 0.6;
    let (length, depth) = (30.0, 20.0);
    let profile = profile(edge);
    let n_x = profile.len() - 1;
    let (n_y, n_z) = ((depth / edge) as usize, (9.0 / edge) as usize);
    let y = |j: usize| depth * j as f64 / n_y as f64;
    let at = |i: usize, y: f64, k: usize| {
        let [x, top] = profile[i];
        Point3::new(x, y, top * k as f64 / n_z as f64)
    };
    debug_assert!((profile[n_x][0] - length).abs() < WELD, "the profile ends at the block's end");
    let mut grids = Grids::default();
    grids.add(n_x, n_y, |i, j| at(i, y(j), n_z));
    grids.add(n_y, n_x, |j, i| at(i, y(j), 0));
    grids.add(n_x, n_z, |i, k| at(i, 0.0, k));
    grids.add(n_z, n_x, |k, i| at(i, depth, k));
    grids.add(n_z, n_y, |k, j| at(0, y(j), k));
    grids.add(n_y, n_z, |j, k| at(n_x, y(j), k));
    grids.mesh
}

/// Points (x, height) of the part's top, about `edge` apart.
fn profile(edge: f64) -> Vec<[f64; 2]> {
    let (radius, slope) = (6.0, std::f64::consts::FRAC_PI_4);
    let fillet_end = [10.0 + radius * slope.sin(), 12.0 - radius * (1.0 - slope.cos())];
    let valley = [fillet_end[0] + (fillet_end[1] - 6.0), 6.0];
    let line = |from: [f64; 2], to: [f64; 2]| {
        let n = ((to[0] - from[0]).hypot(to[1] - from[1]) / edge).round();
        (1..=n as usize).map(move |k| {
            let s = k as f64 / n;
            [0, 1].map(|a| from[a] + (to[a] - from[a]) * s)
        })
    };
    let n_arc = (radius * slope / edge).round();
    let arc = (1..=n_arc as usize).map(|k| {
        let turn = slope * k as f64 / n_arc;
        [10.0 + radius * turn.sin(), 12.0 - radius * (1.0 - turn.cos())]
    });
    let mut points = vec![[0.0, 12.0]];
    points.extend(line([0.0, 12.0], [10.0, 12.0]));
    points.extend(arc);
    points.extend(line(fillet_end, valley));
    points.extend(line(valley, [30.0, 6.0]));
    points
}

/// A ball of radius 12 with waves of a tenth of it. About 6 900 vertices.
pub fn wavy() -> Mesh {
    let n = 34;
    let mut grids = Grids::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            grids.add(n, n, |i, j| {
                // Tangents of even steps of angle make the cells of a cube's face about even on the ball.
                let of = |k: usize| (std::f64::consts::FRAC_PI_4 * (2.0 * k as f64 / n as f64 - 1.0)).tan();
                let mut direction = Vec3::zeros();
                direction[axis] = side;
                direction[(axis + 1) % 3] = of(i) * side;
                direction[(axis + 2) % 3] = of(j);
                let d = direction.normalize();
                let waves = 0.12 * (5.0 * d.x).sin() * (4.0 * d.y).sin() + 0.08 * (6.0 * d.z).sin();
                Point3::from(d * (12.0 * (1.0 + waves)))
            });
        }
    }
    grids.mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanwright::mesh::Adjacency;

    #[test]
    fn bodies_are_closed_face_outwards_and_have_even_triangles() {
        for (name, mesh) in [("part", part()), ("wavy", wavy())] {
            let adjacency = Adjacency::new(&mesh);
            assert!(adjacency.across.iter().flatten().all(Option::is_some), "{name} is open");
            let euler = mesh.vertices.len() as i64 - mesh.triangles.len() as i64 / 2;
            assert_eq!(euler, 2, "{name}");
            let inverted = Mesh {
                vertices: mesh.vertices.clone(),
                triangles: mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect(),
            };
            assert!(mesh.signed_volume() > 0.0 && inverted.signed_volume() < 0.0, "{name}");
            let mean = mesh.total_area() / mesh.triangles.len() as f64;
            let slivers = (0..mesh.triangles.len()).filter(|t| mesh.area(*t) < 0.4 * mean).count();
            assert!(slivers == 0, "{name}: {slivers} of {}", mesh.triangles.len());
        }
    }
}
