//! The Laplacian spectrum: the smallest eigenvalues of the Laplace-Beltrami operator of a surface.
//!
//! M. Reuter, F.-E. Wolter, N. Peinecke, "Laplace-Beltrami spectra as 'Shape-DNA' of surfaces and solids", Computer-Aided
//! Design 38 (2006), 342-366. Linear elements (cotangents; U. Pinkall, K. Polthier, Experimental Mathematics 2 (1993),
//! 15-36) with lumped masses, where the source has elements of higher order; open borders are free (Neumann). Eigenvalues are multiplied
//! by the area, so that size does not matter.
//!
//! Eigenvalues come by subspace iteration (K.-J. Bathe, E. L. Wilson, International Journal for Numerical Methods in
//! Engineering 6 (1973), 213-226) on the inverse of the shifted matrix. A block finds eigenvalues that are equal, of which
//! symmetric models have many; a single Lanczos vector would only see one of each.
//! Cost: one sparse decomposition, and a solve of the block per step, a tenth of a second for a thousand vertices.

use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use scanwright::math::Point3;
use scanwright::mesh::Mesh;
use scanwright::random::Rng;

use super::SEED;

/// Row, column and value.
type Entry = Triplet<usize, usize, f64>;

/// Eigenvalues of the descriptor, beside the zero of constant functions.
const N_VALUES: usize = 20;
/// Vectors that are iterated. The error shrinks by the ratio of the last wanted eigenvalue to the last of the block,
/// about one half by Weyl's law, and the eigenvalues' error by its square.
const BLOCK: usize = 2 * (N_VALUES + 1);
/// Added to the matrix so that it can be inverted; eigenvalues times area begin at about two on the slenderest models.
const SHIFT: f64 = 1.0;
/// Relative change of the eigenvalues at which the iteration ends, far below what triangles leave of the surface.
const STILL: f64 = 1e-6;
const MAX_STEPS: usize = 60;

/// The smallest eigenvalues times the area, ascending, without the first, which is zero. Where there are fewer vertices,
/// the rest is zero. `None` for a mesh without area.
pub fn spectrum(mesh: &Mesh) -> Option<Vec<f64>> {
    let (n, triplets) = normalized_laplacian(mesh)?;
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &triplets).ok()?;
    let shifted: Vec<_> = triplets.into_iter().chain((0..n).map(|i| Triplet::new(i, i, SHIFT))).collect();
    let shifted = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &shifted).ok()?;
    let cholesky = shifted.sp_cholesky(Side::Lower).ok()?;
    let mut rng = Rng::for_task(SEED, "spectrum", 0);
    let mut block = Mat::from_fn(n, BLOCK.min(n), |_, _| rng.normal());
    let mut values = vec![0.0; N_VALUES];
    for _ in 0..MAX_STEPS {
        cholesky.solve_in_place(&mut block);
        let basis = block.qr().compute_thin_Q();
        let within = basis.transpose() * (&matrix * &basis);
        let eigen = within.self_adjoint_eigen(Side::Lower).ok()?;
        let found = eigen.S().column_vector();
        let at = |k: usize| if k + 1 < found.nrows() { found[k + 1] } else { 0.0 };
        let next: Vec<f64> = (0..N_VALUES).map(at).collect();
        let is_still = next.iter().zip(&values).all(|(a, b)| (a - b).abs() <= STILL * a.abs());
        values = next;
        if is_still {
            break;
        }
        block = &basis * eigen.U();
    }
    Some(values)
}

/// `area M^-1/2 K M^-1/2` of the stiffness `K` and the masses `M` of the vertices that have one: its size and entries,
/// of which those at one place add up.
fn normalized_laplacian(mesh: &Mesh) -> Option<(usize, Vec<Entry>)> {
    let area = mesh.total_area();
    if area <= 0.0 {
        return None;
    }
    let mut masses = vec![0.0; mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for &v in triangle {
            masses[v as usize] += mesh.area(t) / 3.0;
        }
    }
    let mut n = 0;
    let row_of: Vec<Option<usize>> = masses
        .iter()
        .map(|mass| {
            (*mass > 0.0).then(|| {
                n += 1;
                n - 1
            })
        })
        .collect();
    let mut triplets = Vec::new();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        // Slivers without area have no cotangents, and hold nothing.
        let corners = mesh.corners(t);
        for k in 0..3 {
            let (i, j) = (triangle[(k + 1) % 3] as usize, triangle[(k + 2) % 3] as usize);
            let Some(half_cotangent) = half_cotangent(corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3])
            else {
                continue;
            };
            let (Some(row), Some(column)) = (row_of[i], row_of[j]) else { continue };
            let weight = |a: usize, b: usize| area * half_cotangent / (masses[a] * masses[b]).sqrt();
            triplets.push(Triplet::new(row, row, weight(i, i)));
            triplets.push(Triplet::new(column, column, weight(j, j)));
            triplets.push(Triplet::new(row, column, -weight(i, j)));
            triplets.push(Triplet::new(column, row, -weight(i, j)));
        }
    }
    Some((n, triplets))
}

/// Half the cotangent of the angle at `apex`; `None` where the triangle has no area.
fn half_cotangent(apex: Point3, b: Point3, c: Point3) -> Option<f64> {
    let (to_b, to_c) = (b - apex, c - apex);
    let twice_area = to_b.cross(&to_c).norm();
    (twice_area > 0.0).then(|| 0.5 * to_b.dot(&to_c) / twice_area)
}
