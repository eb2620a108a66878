//! Symmetric positive definite systems whose entries lie near the diagonal, by Cholesky.
//!
//! G. H. Golub and C. F. Van Loan, "Matrix Computations", 4th edition, Johns Hopkins University Press 2013, section
//! 4.3.5. Cost O(n * width^2), where the full factorization costs O(n^3).

/// The lower half of a banded matrix.
pub(super) struct Banded {
    n: usize,
    /// Entries of a row left of the diagonal.
    width: usize,
    /// Row by row, `width + 1` entries each, the diagonal last.
    entries: Vec<f64>,
}

impl Banded {
    /// A matrix of zeros.
    pub(super) fn zeros(n: usize, width: usize) -> Self {
        Self { n, width, entries: vec![0.0; n * (width + 1)] }
    }

    fn place(&self, row: usize, column: usize) -> usize {
        row * (self.width + 1) + column + self.width - row
    }

    /// Adds to an entry of the lower half, at most `width` left of the diagonal; the upper half is left out.
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        if column <= row {
            let place = self.place(row, column);
            self.entries[place] += value;
        }
    }

    /// The solutions for three right sides; `None` when the matrix is not positive definite.
    pub(super) fn solve(mut self, mut right: Vec<[f64; 3]>) -> Option<Vec<[f64; 3]>> {
        self.factorize()?;
        let (n, width) = (self.n, self.width);
        for i in 0..n {
            for j in i.saturating_sub(width)..i {
                let entry = self.entries[self.place(i, j)];
                let known = right[j];
                right[i].iter_mut().zip(known).for_each(|(v, x)| *v -= entry * x);
            }
            right[i] = right[i].map(|v| v / self.entries[self.place(i, i)]);
        }
        for i in (0..n).rev() {
            right[i] = right[i].map(|v| v / self.entries[self.place(i, i)]);
            for j in i.saturating_sub(width)..i {
                let entry = self.entries[self.place(i, j)];
                let known = right[i];
                right[j].iter_mut().zip(known).for_each(|(v, x)| *v -= entry * x);
            }
        }
        Some(right)
    }

    /// Replaces the matrix by its Cholesky factor.
    fn factorize(&mut self) -> Option<()> {
        let width = self.width;
        for i in 0..self.n {
            for j in i.saturating_sub(width)..=i {
                let from = i.saturating_sub(width).max(j.saturating_sub(width));
                let (a, b) = (self.place(i, from), self.place(j, from));
                let count = j - from;
                let rows = self.entries[a..a + count].iter().zip(&self.entries[b..b + count]);
                let dot: f64 = rows.map(|(x, y)| x * y).sum();
                let place = self.place(i, j);
                let value = self.entries[place] - dot;
                self.entries[place] = if i == j {
                    if value.is_nan() || value <= 0.0 {
                        return None;
                    }
                    value.sqrt()
                } else {
                    value / self.entries[self.place(j, j)]
                };
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solution_is_found_again() {
        let (n, width) = (9, 2);
        let entry = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 5.0 + i as f64,
            1 => -1.5,
            2 => 0.5,
            _ => 0.0,
        };
        let wanted: Vec<[f64; 3]> = (0..n).map(|i| [i as f64, 1.0, -(i as f64)]).collect();
        let mut matrix = Banded::zeros(n, width);
        let mut right = vec![[0.0; 3]; n];
        for (i, sums) in right.iter_mut().enumerate() {
            for (j, values) in wanted.iter().enumerate() {
                if i.abs_diff(j) <= width {
                    matrix.add(i, j, entry(i, j));
                }
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += entry(i, j) * value);
            }
        }
        let found = matrix.solve(right).expect("the matrix is positive definite");
        for (a, b) in found.iter().flatten().zip(wanted.iter().flatten()) {
            assert!((a - b).abs() < 1e-12, "{a} instead of {b}");
        }
    }

    #[test]
    fn an_indefinite_matrix_has_no_solution() {
        let mut matrix = Banded::zeros(2, 1);
        matrix.add(0, 0, 1.0);
        matrix.add(1, 0, 2.0);
        matrix.add(1, 1, 1.0);
        assert!(matrix.solve(vec![[1.0; 3]; 2]).is_none());
    }
}
