//! Small scans made from signed distances: surface nets on a grid, noise along the normal.

use scanwright::math::{Point3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::random::Rng;

/// The zero surface of `distance` (negative inside) over the box from `lo` to `hi`, meshed at `spacing`. The mesh is
/// open where the surface leaves the box. Vertices are drawn onto the surface.
pub fn scan(distance: impl Fn(&Point3) -> f64, lo: [f64; 3], hi: [f64; 3], spacing: f64) -> Mesh {
    let n: [usize; 3] = std::array::from_fn(|a| ((hi[a] - lo[a]) / spacing).round() as usize);
    let at = |i: [usize; 3]| -> Point3 {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|a| lo[a] + i[a] as f64 * spacing);
        Point3::new(x, y, z)
    };
    let nodes = [n[0] + 1, n[1] + 1, n[2] + 1];
    let index = |i: [usize; 3]| (i[0] * nodes[1] + i[1]) * nodes[2] + i[2];
    let mut values = vec![0.0; nodes[0] * nodes[1] * nodes[2]];
    for_each(nodes, |i| values[index(i)] = distance(&at(i)));
    let mut mesh = Mesh::default();
    let mut vertex_of_cell = vec![u32::MAX; values.len()];
    for_each(n, |i| {
        let corners: Vec<([usize; 3], f64)> = (0..8)
            .map(|c| [i[0] + (c & 1), i[1] + (c >> 1 & 1), i[2] + (c >> 2)])
            .map(|j| (j, values[index(j)]))
            .collect();
        let (mut sum, mut count) = (Vec3::zeros(), 0.0);
        for (k, (a, va)) in corners.iter().enumerate() {
            for (b, vb) in &corners[k + 1..] {
                let is_edge = (0..3).filter(|&d| a[d] != b[d]).count() == 1;
                if is_edge && (*va < 0.0) != (*vb < 0.0) {
                    sum += at(*a).coords.lerp(&at(*b).coords, va / (va - vb));
                    count += 1.0;
                }
            }
        }
        if count > 0.0 {
            vertex_of_cell[index(i)] = mesh.vertices.len() as u32;
            mesh.vertices.push(Point3::from(sum / count));
        }
    });
    add_quads(&mut mesh, n, &index, &values, &vertex_of_cell);
    for p in &mut mesh.vertices {
        draw_onto(&distance, p, spacing);
    }
    let n_triangles = mesh.triangles.len();
    mesh.submesh(|t| t < n_triangles).0
}

/// One quad around every grid edge that the surface crosses and that has four cells.
fn add_quads(
    mesh: &mut Mesh,
    n: [usize; 3],
    index: &impl Fn([usize; 3]) -> usize,
    values: &[f64],
    vertex_of_cell: &[u32],
) {
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for_each(n, |i| {
            let mut end = i;
            end[axis] += 1;
            let inside = (values[index(i)] < 0.0, values[index(end)] < 0.0);
            if inside.0 == inside.1 || i[u] == 0 || i[v] == 0 {
                return;
            }
            let cell = |du: usize, dv: usize| {
                let mut c = i;
                c[u] -= du;
                c[v] -= dv;
                vertex_of_cell[index(c)]
            };
            let mut quad = [cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)];
            if !inside.0 {
                quad.reverse();
            }
            mesh.triangles.push([quad[0], quad[1], quad[2]]);
            mesh.triangles.push([quad[0], quad[2], quad[3]]);
        });
    }
}

/// A few Newton steps along the numerical gradient.
fn draw_onto(distance: &impl Fn(&Point3) -> f64, p: &mut Point3, spacing: f64) {
    let step = 1e-4 * spacing;
    for _ in 0..4 {
        let d = |offset: Vec3| distance(&(*p + offset * step));
        let gradient = Vec3::new(
            d(Vec3::x()) - d(-Vec3::x()),
            d(Vec3::y()) - d(-Vec3::y()),
            d(Vec3::z()) - d(-Vec3::z()),
        ) / (2.0 * step);
        let square = gradient.norm_squared();
        if square > 0.25 {
            *p -= gradient * (distance(p) / square);
        }
    }
}

fn for_each(n: [usize; 3], mut f: impl FnMut([usize; 3])) {
    for x in 0..n[0] {
        for y in 0..n[1] {
            for z in 0..n[2] {
                f([x, y, z]);
            }
        }
    }
}

/// `mesh` with white noise of standard deviation `sigma` along its vertex normals.
pub fn with_noise(mesh: &Mesh, sigma: f64, seed: u64) -> Mesh {
    let mut random = Rng::for_task(seed, "scanned", 0);
    let normals = mesh.vertex_normals();
    let vertices =
        mesh.vertices.iter().zip(normals).map(|(p, n)| p + n * (sigma * random.normal())).collect();
    Mesh { vertices, triangles: mesh.triangles.clone() }
}

/// Signed distance of an axis-parallel box.
pub fn box_distance(p: &Point3, center: [f64; 3], half: [f64; 3]) -> f64 {
    let q: [f64; 3] = std::array::from_fn(|a| (p[a] - center[a]).abs() - half[a]);
    let outside = Vec3::new(q[0].max(0.0), q[1].max(0.0), q[2].max(0.0)).norm();
    outside + q[0].max(q[1]).max(q[2]).min(0.0)
}

/// Union of two distances, blended over about `reach` as fusion does: never farther than either.
pub fn blend(a: f64, b: f64, reach: f64) -> f64 {
    let h = (reach - (a - b).abs()).max(0.0) / reach;
    a.min(b) - 0.25 * h * h * reach
}

/// `distance` blurred by a Gaussian spot. Exact for fields of second degree, within 6 % of a kink's rounding; outside
/// three spots and `reach` of the surface the distance as it is, which no vertex sees.
pub fn blurred(distance: impl Fn(&Point3) -> f64, spot: f64, reach: f64) -> impl Fn(&Point3) -> f64 {
    // Medians of the sixths of a normal distribution, scaled to unit variance.
    const NODES: [f64; 6] = [-1.5424, -0.7522, -0.2347, 0.2347, 0.7522, 1.5424];
    move |p| {
        let sharp = distance(p);
        if sharp.abs() > 3.0 * spot + reach {
            return sharp;
        }
        let mut sum = 0.0;
        for x in NODES {
            for y in NODES {
                for z in NODES {
                    sum += distance(&(p + Vec3::new(x, y, z) * spot));
                }
            }
        }
        sum / 216.0
    }
}
