//! Eigenvalues of small symmetric matrices.

use nalgebra::SMatrix;

/// Most sweeps of Jacobi's method. A few are enough.
const SWEEPS: usize = 40;

/// Eigenvalues, smallest first, and the unit eigenvectors in the columns (cyclic Jacobi).
pub(super) fn eigen<const N: usize>(matrix: &SMatrix<f64, N, N>) -> ([f64; N], SMatrix<f64, N, N>) {
    let mut a = *matrix;
    let mut vectors = SMatrix::<f64, N, N>::identity();
    for _ in 0..SWEEPS {
        let mut turned = false;
        for i in 0..N {
            for j in i + 1..N {
                let off = a[(i, j)];
                // An element that no longer changes either diagonal is zero.
                if off.abs() <= f64::EPSILON * 1e-3 * (a[(i, i)].abs() * a[(j, j)].abs()).sqrt() {
                    continue;
                }
                turned = true;
                let ratio = (a[(j, j)] - a[(i, i)]) / (2.0 * off);
                let tangent = ratio.signum() / (ratio.abs() + (1.0 + ratio * ratio).sqrt());
                let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
                let sine = tangent * cosine;
                for k in 0..N {
                    let (x, y) = (a[(k, i)], a[(k, j)]);
                    a[(k, i)] = cosine * x - sine * y;
                    a[(k, j)] = sine * x + cosine * y;
                }
                for k in 0..N {
                    let (x, y) = (a[(i, k)], a[(j, k)]);
                    a[(i, k)] = cosine * x - sine * y;
                    a[(j, k)] = sine * x + cosine * y;
                    let (x, y) = (vectors[(k, i)], vectors[(k, j)]);
                    vectors[(k, i)] = cosine * x - sine * y;
                    vectors[(k, j)] = sine * x + cosine * y;
                }
            }
        }
        if !turned {
            break;
        }
    }
    let mut order: [usize; N] = std::array::from_fn(|k| k);
    order.sort_by(|&i, &j| a[(i, i)].total_cmp(&a[(j, j)]));
    let sorted = SMatrix::from_fn(|row, column| vectors[(row, order[column])]);
    (order.map(|k| a[(k, k)]), sorted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_symmetric_matrix_is_its_eigenvectors() {
        let half = SMatrix::<f64, 4, 4>::from_fn(|i, j| (i * 7 + j * 3 + i * j) as f64 - 9.0);
        let matrix = half.transpose() * half + SMatrix::identity();
        let (values, vectors) = eigen(&matrix);
        assert!(values.is_sorted());
        let diagonal = SMatrix::<f64, 4, 4>::from_fn(|i, j| if i == j { values[i] } else { 0.0 });
        assert!((vectors * diagonal * vectors.transpose() - matrix).norm() < 1e-12 * matrix.norm());
        assert!((vectors.transpose() * vectors - SMatrix::identity()).norm() < 1e-14);
    }
}
