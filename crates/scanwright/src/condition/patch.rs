//! Small neighbourhoods on the mesh and the quadric that fits them.

use nalgebra::{SMatrix, SVector};

use crate::math::least_squares::solve_spd;
use crate::math::{Frame, Point3, UnitVec3, Vec3};
use crate::mesh::{Adjacency, Mesh, VertId};

/// Unknowns of a quadric height function.
pub(super) const N_QUADRIC: usize = 6;

/// The vertices at most `n_rings` edges from `start` for which `keep` holds, reached through such vertices; `start`
/// first, then ring by ring, ascending within a ring.
pub(super) fn rings(
    adjacency: &Adjacency,
    start: VertId,
    n_rings: usize,
    keep: impl Fn(VertId) -> bool,
) -> Vec<VertId> {
    let mut found = vec![start];
    let (mut before, mut last) = (Vec::new(), vec![start]);
    for _ in 0..n_rings {
        let mut next: Vec<VertId> = Vec::with_capacity(6 * last.len());
        for &v in &last {
            next.extend(adjacency.vertex_vertices.row(v as usize));
        }
        next.sort_unstable();
        next.dedup();
        // Neighbours of a ring lie in the ring itself or in the ones beside it.
        next.retain(|v| {
            last.binary_search(v).is_err() && before.binary_search(v).is_err() && keep(*v)
        });
        if next.is_empty() {
            break;
        }
        found.extend(&next);
        before = std::mem::replace(&mut last, next);
    }
    found
}

/// A height function `h(x, y)` of degree two over a frame, in units of `scale`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quadric {
    /// Frame whose third direction the heights follow.
    pub frame: Frame,
    /// Length of one unit.
    pub scale: f64,
    /// Coefficients of 1, x, y, x^2, xy, y^2.
    pub coefficients: SVector<f64, N_QUADRIC>,
    /// Sum of the squared height residuals, length squared.
    pub residual_sq: f64,
}

impl Quadric {
    /// Least-squares quadric through the `vertices` of `mesh` about the first of them; `None` when they do not
    /// determine it.
    pub fn fit(mesh: &Mesh, vertices: &[VertId], normal: UnitVec3, scale: f64) -> Option<Self> {
        if vertices.len() <= N_QUADRIC {
            return None;
        }
        let frame = Frame::from_z(mesh.vertices[vertices[0] as usize], normal);
        let mut a = SMatrix::<f64, N_QUADRIC, N_QUADRIC>::zeros();
        let mut b = SVector::<f64, N_QUADRIC>::zeros();
        let local = |v: VertId| frame.local(&mesh.vertices[v as usize]) / scale;
        for &v in vertices {
            let p = local(v);
            let row = monomials(p.x, p.y);
            a += row * row.transpose();
            b += row * p.z;
        }
        let coefficients = solve_spd(a, b)?;
        let residual_sq: f64 = vertices
            .iter()
            .map(|&v| {
                let p = local(v);
                (p.z - coefficients.dot(&monomials(p.x, p.y))).powi(2)
            })
            .sum();
        (residual_sq.is_finite()).then_some(Self {
            frame,
            scale,
            coefficients,
            residual_sq: residual_sq * scale * scale,
        })
    }

    /// Unit normal of the quadric over `point`.
    pub fn normal_over(&self, point: &Point3) -> Vec3 {
        let p = self.frame.local(point) / self.scale;
        let c = &self.coefficients;
        let dx = c[1] + 2.0 * c[3] * p.x + c[4] * p.y;
        let dy = c[2] + c[4] * p.x + 2.0 * c[5] * p.y;
        (self.frame.z.into_inner() - self.frame.x.into_inner() * dx - self.frame.y.into_inner() * dy).normalize()
    }

    /// The second derivative of largest magnitude, per length, and the direction it is taken in.
    pub fn strongest_bend(&self) -> (f64, Vec3) {
        let c = &self.coefficients;
        let (mean, half, mixed) = (c[3] + c[5], c[3] - c[5], c[4]);
        let radius = half.hypot(mixed);
        let bend = if mean >= 0.0 { mean + radius } else { mean - radius };
        // Angle of the eigenvector of the larger (smaller) eigenvalue.
        let larger = 0.5 * mixed.atan2(half);
        let angle = if mean >= 0.0 { larger } else { larger + std::f64::consts::FRAC_PI_2 };
        let direction = self.frame.x.into_inner() * angle.cos() + self.frame.y.into_inner() * angle.sin();
        (bend / self.scale, direction)
    }
}

fn monomials(x: f64, y: f64) -> SVector<f64, N_QUADRIC> {
    SVector::<f64, N_QUADRIC>::from([1.0, x, y, x * x, x * y, y * y])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strongest_bend_of_a_saddle_is_found() {
        let quadric = |c: [f64; 6]| Quadric {
            frame: Frame::from_z(Point3::origin(), UnitVec3::new_unchecked(Vec3::z())),
            scale: 1.0,
            coefficients: c.into(),
            residual_sq: 0.0,
        };
        let along_x = quadric([0.0, 0.0, 0.0, -3.0, 0.0, 1.0]);
        let (bend, direction) = along_x.strongest_bend();
        assert!((bend + 6.0).abs() < 1e-12);
        assert!((direction.dot(&along_x.frame.x).abs() - 1.0).abs() < 1e-12);
        // z = xy bends by +1 along the diagonal x = y.
        let (bend, direction) = quadric([0.0, 0.0, 0.0, 2.0, 2.0, 2.0]).strongest_bend();
        assert!((bend - 6.0).abs() < 1e-12, "{bend}");
        assert!(direction.dot(&along_x.frame.x).abs() > 0.7);
    }
}
