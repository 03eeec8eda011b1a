//! Covariances as triangles.

use crate::state::{STATES, State};

/// The lower triangle L with `L Lᵀ = matrix`, of a matrix without negative eigenvalues. What
/// follows from the numbers before it has no column of its own.
pub(crate) fn cholesky(matrix: &[State; STATES]) -> [State; STATES] {
    let mut l = [[0.0; STATES]; STATES];
    for j in 0..STATES {
        let own = matrix[j][j] - l[j][..j].iter().map(|x| x * x).sum::<f64>();
        if own <= 1e-9 * matrix[j][j] {
            continue;
        }
        l[j][j] = libm::sqrt(own);
        for i in j + 1..STATES {
            let shared: f64 = l[i][..j].iter().zip(&l[j][..j]).map(|(a, b)| a * b).sum();
            l[i][j] = (matrix[i][j] - shared) / l[j][j];
        }
    }
    l
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_times_its_transpose_is_the_matrix() {
        // Sums of outer products have no negative eigenvalues; these have rank 5 of 8.
        let vectors: [State; 5] = std::array::from_fn(|k| {
            std::array::from_fn(|i| ((3 * k * k + 5 * i * (k + 1)) % 7) as f64 - 3.0)
        });
        let matrix: [State; STATES] = std::array::from_fn(|i| {
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
