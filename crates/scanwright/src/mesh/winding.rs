//! Inside or outside of a mesh that need not be closed.

use crate::math::Point3;

use super::Mesh;

/// Generalized winding number of `mesh` about `point`: the solid angle of all triangles over the full one. One inside
/// a closed mesh, zero outside, one half on a surface; across a hole it passes smoothly from one to the other.
///
/// A. Jacobson, L. Kavan, O. Sorkine-Hornung, "Robust Inside-Outside Segmentation using Generalized Winding Numbers"
/// (2013); solid angle of a triangle after A. van Oosterom, J. Strackee (1983). Linear in the number of triangles.
pub fn winding_number(mesh: &Mesh, point: &Point3) -> f64 {
    let solid_angle = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| mesh.vertices[v as usize] - point);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let determinant = a.dot(&b.cross(&c));
        2.0 * determinant.atan2(la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb)
    };
    mesh.triangles.iter().map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_box_winds_once_inside_and_by_half_across_its_hole() {
        let corner = |i: u32| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let quads = [[0, 2, 3, 1], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [4, 5, 7, 6]];
        let mut mesh = Mesh {
            vertices: (0..8).map(corner).collect(),
            triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
        };
        let center = Point3::new(0.5, 0.5, 0.5);
        assert!((winding_number(&mesh, &center) - 1.0).abs() < 1e-12);
        assert!(winding_number(&mesh, &Point3::new(3.0, 1.0, 1.0)).abs() < 1e-12);
        mesh.triangles.truncate(10);
        assert!((winding_number(&mesh, &center) - 5.0 / 6.0).abs() < 1e-12);
        assert!((winding_number(&mesh, &Point3::new(0.5, 0.5, 1.0)) - 0.5).abs() < 1e-12);
    }
}
