//! Weighted graphs, and the eigenvectors of their normalized Laplacians.
//!
//! The smallest eigenvectors of `L = I - D^-1/2 W D^-1/2` are found as the largest of the inverse of `L + s I`, by Lanczos'
//! method with full reorthogonalization: C. Lanczos, Journal of Research of the National Bureau of Standards 45 (1950),
//! 255-282. The shift `s` makes the matrix definite; a sparse Cholesky decomposition inverts it. Residuals are verified,
//! and the basis grows until they are small.
//!
//! Of a graph in which most are joined with most, whose decomposition would be full, the largest of `I - L` itself are found:
//! there the wanted ones stand apart, as long as far nodes are joined weakly.
//!
//! Cost: one decomposition, then one solve and one orthogonalization per vector of the basis, of which there are a few
//! times as many as eigenvectors are asked for. Memory: the basis.

use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::mesh::{Csr, connected};
use crate::random::Rng;

/// Added to the Laplacian so that it can be inverted. Eigenvalues below it, of groups that sharp creases part, are told
/// apart less quickly; residuals say whether they were.
const SHIFT: f64 = 1e-4;
/// Largest residual of an eigenpair: groups are told apart by entries of about a hundredth.
const RESIDUAL: f64 = 1e-8;

/// Most vectors of the basis in which `k` eigenpairs are looked for.
pub(super) fn most_in_basis(k: usize) -> usize {
    6 * k + 60
}

/// A symmetric graph: edges with positive weights.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::segment) struct Graph {
    pub n: usize,
    /// Both ends, the lower first, and the weight; each pair once.
    pub edges: Vec<(u32, u32, f64)>,
}

/// Eigenvalues, ascending, and their vectors.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::segment) struct Eigen {
    pub values: Vec<f64>,
    /// One per eigenvalue: a unit vector over the nodes.
    pub vectors: Vec<DVector<f64>>,
}

impl Graph {
    /// Sum of the weights at each node.
    pub fn degrees(&self) -> Vec<f64> {
        let mut degrees = vec![0.0; self.n];
        for &(a, b, weight) in &self.edges {
            degrees[a as usize] += weight;
            degrees[b as usize] += weight;
        }
        degrees
    }

    /// The connected parts, in the order of their first nodes: their nodes, ascending, and their graphs, whose nodes are
    /// numbered by their places among those.
    pub fn parts(&self) -> Vec<(Vec<u32>, Self)> {
        let both_ways = self.edges.iter().flat_map(|&(a, b, _)| [(a, b), (b, a)]);
        let beside = Csr::from_pairs(self.n, both_ways);
        let sets = connected(self.n, |_| Some(()), |k| beside.row(k as usize).iter().copied());
        let (mut part_of, mut place) = (vec![0; self.n], vec![0; self.n]);
        let mut parts = Vec::with_capacity(sets.len());
        for ((), mut nodes) in sets {
            nodes.sort_unstable();
            for (i, &k) in nodes.iter().enumerate() {
                part_of[k as usize] = parts.len();
                place[k as usize] = i as u32;
            }
            let graph = Self { n: nodes.len(), edges: Vec::new() };
            parts.push((nodes, graph));
        }
        for &(a, b, weight) in &self.edges {
            let (a, b) = (a as usize, b as usize);
            parts[part_of[a]].1.edges.push((place[a], place[b], weight));
        }
        parts
    }

    /// `D^-1/2 W D^-1/2` times a vector.
    pub fn normalized_times(&self, scale: &[f64], x: &DVector<f64>) -> DVector<f64> {
        let mut y = DVector::zeros(self.n);
        for &(a, b, weight) in &self.edges {
            let (a, b) = (a as usize, b as usize);
            let w = weight * scale[a] * scale[b];
            y[a] += w * x[b];
            y[b] += w * x[a];
        }
        y
    }

    /// The `k` smallest eigenpairs of the normalized Laplacian of a connected graph; fewer when it has fewer nodes.
    /// `None` when the decomposition fails, which takes weights that are not positive numbers.
    pub fn smallest_eigenpairs(&self, k: usize, seed: u64) -> Option<Eigen> {
        /// Below so many nodes the dense matrix is solved as a whole.
        const DENSE: usize = 200;
        let k = k.min(self.n);
        let scale: Vec<f64> =
            self.degrees().iter().map(|d| if *d > 0.0 { 1.0 / d.sqrt() } else { 0.0 }).collect();
        if self.n <= DENSE {
            return Some(self.dense(k, &scale));
        }
        /// Edges per node beyond which the graph is no sparse one.
        const SPARSE: usize = 30;
        if self.edges.len() > SPARSE * self.n {
            let times = |x: &DVector<f64>| self.normalized_times(&scale, x);
            return Some(self.lanczos(k, &scale, seed, times, |largest| 1.0 - largest));
        }
        let inverse_times = self.inverse(&scale)?;
        Some(self.lanczos(k, &scale, seed, inverse_times, |largest| 1.0 / largest - SHIFT))
    }

    fn dense(&self, k: usize, scale: &[f64]) -> Eigen {
        // A node without edges is a part of its own, whose eigenvalue is zero.
        let diagonal = |i: usize| if scale[i] > 0.0 { 1.0 } else { 0.0 };
        let mut laplacian =
            DMatrix::<f64>::from_fn(self.n, self.n, |i, j| if i == j { diagonal(i) } else { 0.0 });
        for &(a, b, weight) in &self.edges {
            let (a, b) = (a as usize, b as usize);
            laplacian[(a, b)] -= weight * scale[a] * scale[b];
            laplacian[(b, a)] = laplacian[(a, b)];
        }
        let eigen = SymmetricEigen::new(laplacian);
        let mut order: Vec<usize> = (0..self.n).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        order.truncate(k);
        Eigen {
            values: order.iter().map(|&i| eigen.eigenvalues[i]).collect(),
            vectors: order.iter().map(|&i| eigen.eigenvectors.column(i).into_owned()).collect(),
        }
    }

    /// The inverse of `L + s I`, times a vector.
    fn inverse(&self, scale: &[f64]) -> Option<impl Fn(&DVector<f64>) -> DVector<f64>> {
        let n = self.n;
        let mut triplets: Vec<Triplet<usize, usize, f64>> =
            (0..n).map(|i| Triplet::new(i, i, 1.0 + SHIFT)).collect();
        for &(a, b, weight) in &self.edges {
            let (a, b) = (a as usize, b as usize);
            let w = -weight * scale[a] * scale[b];
            triplets.push(Triplet::new(a, b, w));
            triplets.push(Triplet::new(b, a, w));
        }
        let shifted = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &triplets).ok()?;
        let cholesky = shifted.sp_cholesky(faer::Side::Lower).ok()?;
        Some(move |x: &DVector<f64>| {
            let mut y = faer::Mat::from_fn(n, 1, |i, _| x[i]);
            cholesky.solve_in_place(&mut y);
            DVector::from_fn(n, |i, _| y[(i, 0)])
        })
    }

    /// The eigenpairs of the Laplacian that are the largest ones of `operator`; `value`: theirs from the operator's.
    fn lanczos(
        &self,
        k: usize,
        scale: &[f64],
        seed: u64,
        operator: impl Fn(&DVector<f64>) -> DVector<f64>,
        value: impl Fn(f64) -> f64,
    ) -> Eigen {
        let mut rng = Rng::for_task(seed, "lanczos", self.n as u64);
        let mut basis = Basis::start(&DVector::from_fn(self.n, |_, _| rng.normal()));
        let most = most_in_basis(k).min(self.n);
        let mut size = (2 * k + 20).min(most);
        loop {
            while basis.len() < size && basis.extend(&operator) {}
            let eigen = basis.eigenpairs(k, &value);
            let worst = eigen.values.iter().zip(&eigen.vectors).map(|(value, vector)| {
                let off = vector - self.normalized_times(scale, vector) - vector * *value;
                off.norm()
            });
            if worst.fold(0.0, f64::max) < RESIDUAL || size >= most || basis.len() < size {
                return eigen;
            }
            size = (size + k + 20).min(most);
        }
    }
}

/// An orthonormal basis of a Krylov space, with the tridiagonal matrix of the operator in it.
struct Basis {
    vectors: Vec<DVector<f64>>,
    diagonal: Vec<f64>,
    beside: Vec<f64>,
}

impl Basis {
    fn start(first: &DVector<f64>) -> Self {
        Self { vectors: vec![first.normalize()], diagonal: Vec::new(), beside: Vec::new() }
    }

    fn len(&self) -> usize {
        self.diagonal.len()
    }

    /// One more vector; whether the space could grow.
    fn extend(&mut self, operator: &impl Fn(&DVector<f64>) -> DVector<f64>) -> bool {
        let last = &self.vectors[self.len()];
        let mut next = operator(last);
        self.diagonal.push(next.dot(last));
        // Twice is enough to be orthogonal to rounding.
        for _ in 0..2 {
            for vector in &self.vectors {
                let share = next.dot(vector);
                next.axpy(-share, vector, 1.0);
            }
        }
        let length = next.norm();
        self.beside.push(length);
        // The space is invariant: its eigenvectors are exact.
        if length <= f64::EPSILON * self.diagonal[0].abs() {
            return false;
        }
        self.vectors.push(next / length);
        true
    }

    /// The `k` largest of the operator; `value`: what is wanted of each eigenvalue.
    fn eigenpairs(&self, k: usize, value: impl Fn(f64) -> f64) -> Eigen {
        let m = self.len();
        let mut tridiagonal = DMatrix::<f64>::zeros(m, m);
        for i in 0..m {
            tridiagonal[(i, i)] = self.diagonal[i];
            if i + 1 < m {
                tridiagonal[(i, i + 1)] = self.beside[i];
                tridiagonal[(i + 1, i)] = self.beside[i];
            }
        }
        let eigen = SymmetricEigen::new(tridiagonal);
        let mut order: Vec<usize> = (0..m).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        order.truncate(k);
        let vector = |i: &usize| {
            let mut sum = DVector::zeros(self.vectors[0].len());
            for (share, vector) in eigen.eigenvectors.column(*i).iter().zip(&self.vectors) {
                sum.axpy(*share, vector, 1.0);
            }
            sum.normalize()
        };
        Eigen {
            values: order.iter().map(|&i| value(eigen.eigenvalues[i])).collect(),
            vectors: order.iter().map(vector).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ring of `n` nodes: its normalized Laplacian has the eigenvalues `1 - cos(2 pi j / n)`, each but the first twice.
    #[test]
    fn eigenpairs_of_a_ring_are_those_of_theory() {
        for n in [60_u32, 1500] {
            let edges = (0..n).map(|k| (k.min((k + 1) % n), k.max((k + 1) % n), 2.5)).collect();
            let graph = Graph { n: n as usize, edges };
            let eigen = graph.smallest_eigenpairs(6, 1).expect("weights are positive");
            for (i, value) in eigen.values.iter().enumerate() {
                let j = i.div_ceil(2) as f64;
                let expected = 1.0 - (std::f64::consts::TAU * j / f64::from(n)).cos();
                assert!((value - expected).abs() < 1e-9, "{n}: {i} is {value}, not {expected}");
            }
            for (i, a) in eigen.vectors.iter().enumerate() {
                for b in &eigen.vectors[..i] {
                    assert!(a.dot(b).abs() < 1e-9, "{n}: vector {i} is not orthogonal");
                }
            }
        }
    }

    #[test]
    fn parts_are_found_in_order() {
        let parts = Graph { n: 5, edges: vec![(0, 3, 1.0), (1, 4, 2.0)] }.parts();
        let of = |n, edges: &[(u32, u32, f64)]| Graph { n, edges: edges.to_vec() };
        let expected =
            [(vec![0, 3], of(2, &[(0, 1, 1.0)])), (vec![1, 4], of(2, &[(0, 1, 2.0)])), (vec![2], of(1, &[]))];
        assert_eq!(parts, expected);
    }
}
