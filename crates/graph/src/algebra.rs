//! Small linear systems.

/// Solves `matrix · x = right` by Gaussian elimination with pivots; a row without any leaves its
/// unknown at 0.
///
/// # Panics
///
/// When the matrix is not square or `right` is not as long as it is wide.
#[must_use]
pub fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    for column in 0..n {
        let pivot = (column..n)
            .max_by(|&a, &b| matrix[a][column].abs().total_cmp(&matrix[b][column].abs()))
            .unwrap_or(column);
        matrix.swap(column, pivot);
        right.swap(column, pivot);
        if matrix[column][column].abs() < 1e-12 {
            continue;
        }
        for row in column + 1..n {
            let factor = matrix[row][column] / matrix[column][column];
            let (above, below) = matrix.split_at_mut(row);
            for (x, pivot) in below[0].iter_mut().zip(&above[column]).skip(column) {
                *x -= factor * pivot;
            }
            right[row] -= factor * right[column];
        }
    }
    let mut x = vec![0.0; n];
    for row in (0..n).rev() {
        let rest: f64 = (row + 1..n).map(|k| matrix[row][k] * x[k]).sum();
        if matrix[row][row].abs() >= 1e-12 {
            x[row] = (right[row] - rest) / matrix[row][row];
        }
    }
    x
}

/// The lower triangle L with `L Lᵀ = matrix`, of a matrix without negative eigenvalues. What
/// follows from the numbers before it has no column of its own.
#[must_use]
pub fn cholesky<const N: usize>(matrix: &[[f64; N]; N]) -> [[f64; N]; N] {
    let mut l = [[0.0; N]; N];
    for j in 0..N {
        let own = matrix[j][j] - l[j][..j].iter().map(|x| x * x).sum::<f64>();
        if own <= 1e-9 * matrix[j][j] {
            continue;
        }
        l[j][j] = libm::sqrt(own);
        for i in j + 1..N {
            let shared: f64 = l[i][..j].iter().zip(&l[j][..j]).map(|(a, b)| a * b).sum();
            l[i][j] = (matrix[i][j] - shared) / l[j][j];
        }
    }
    l
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATES: usize = 8;

    #[test]
    fn elimination_solves_a_system_worked_out_by_hand() {
        // x + 2y = 5, 3x − y = 1
        let x = solve(vec![vec![1.0, 2.0], vec![3.0, -1.0]], vec![5.0, 1.0]);
        assert!((x[0] - 1.0).abs() < 1e-12 && (x[1] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_triangle_times_its_transpose_is_the_matrix() {
        // Sums of outer products have no negative eigenvalues; these have rank 5 of 8.
        let vectors: [[f64; STATES]; 5] = std::array::from_fn(|k| {
            std::array::from_fn(|i| ((3 * k * k + 5 * i * (k + 1)) % 7) as f64 - 3.0)
        });
        let matrix: [[f64; STATES]; STATES] = std::array::from_fn(|i| {
            std::array::from_fn(|j| vectors.iter().map(|v| v[i] * v[j]).sum())
        });
        let l = cholesky(&matrix);
        for i in 0..STATES {
            for j in 0..STATES {
                let product: f64 = l[i].iter().zip(&l[j]).map(|(a, b)| a * b).sum();
                assert!((product - matrix[i][j]).abs() < 1e-9, "{i} {j}");
            }
            assert!(l[i][i + 1..].iter().all(|x| *x == 0.0));
        }
        assert_eq!(cholesky(&[[0.0; STATES]; STATES]), [[0.0; STATES]; STATES]);
    }
}
