//! The combinations of unknowns that the rows determine: singular values of the columns at unit length.

use nalgebra::{DMatrix, DMatrixView, SVD};

/// A singular value below this part of the largest counts as zero (shared notation §5 "Rank").
const RANK_THRESHOLD: f64 = 1e-9;
/// A column shorter than this \[mm per mm or rad, root of the sum over rows\] is rounding of an effect that does
/// not exist.
const NO_EFFECT: f64 = 1e-10;
/// Number of passes after which the decomposition of a small triangle has long converged.
const MAX_PASSES: usize = 1000;

/// The space of unknowns, split into its determined and undetermined parts.
#[derive(Debug, Clone)]
pub(super) struct Decomposition {
    /// Length of each column; 1 for a column without length.
    scales: Vec<f64>,
    /// The determined part: one column of unknowns, times their scales, for each singular value kept.
    seen: DMatrix<f64>,
    /// The undetermined part in the same form, orthonormal.
    blind: DMatrix<f64>,
    /// Largest kept singular value over the smallest.
    pub(super) condition: f64,
}

impl Decomposition {
    /// The decomposition of these columns, which are already projected and weighted. `None` only if the iteration
    /// fails.
    pub(super) fn new(mut columns: DMatrix<f64>) -> Option<Self> {
        let count = columns.ncols();
        let scales: Vec<f64> = columns
            .column_iter()
            .map(|column| column.norm())
            .map(|norm| if norm > NO_EFFECT { norm } else { 0.0 })
            .collect();
        for (mut column, scale) in columns.column_iter_mut().zip(&scales) {
            if *scale > 0.0 { column /= *scale } else { column.fill(0.0) }
        }
        // With fewer rows than columns, null directions would be hidden. Rows of zeros change nothing else.
        if columns.nrows() < count {
            let rows = columns.nrows();
            columns = columns.insert_rows(rows, count - rows, 0.0);
        }
        let triangle = columns.qr().r();
        let svd = SVD::try_new(triangle, false, true, f64::EPSILON, MAX_PASSES)?;
        let rows = svd.v_t.as_ref()?;
        let largest = svd.singular_values.max();
        let (mut seen, mut blind) = (Vec::new(), Vec::new());
        let mut smallest = largest;
        for (index, value) in svd.singular_values.iter().copied().enumerate() {
            let direction = rows.row(index).transpose();
            if value > RANK_THRESHOLD * largest {
                smallest = smallest.min(value);
                seen.push(direction);
            } else {
                blind.push(direction);
            }
        }
        let gather = |columns: &[nalgebra::DVector<f64>]| {
            DMatrix::from_fn(count, columns.len(), |row, column| columns[column][row])
        };
        let condition = if smallest > 0.0 { largest / smallest } else { 1.0 };
        let scales = scales.into_iter().map(|scale| if scale > 0.0 { scale } else { 1.0 }).collect();
        Some(Self { scales, seen: gather(&seen), blind: gather(&blind), condition })
    }

    /// Number of determined combinations.
    pub(super) fn rank(&self) -> usize {
        self.seen.ncols()
    }

    /// Which unknowns are part of an undetermined combination.
    pub(super) fn touched(&self) -> Vec<bool> {
        /// Parts below this (of unit vectors) are rounding.
        const PART: f64 = 1e-6;
        self.blind.row_iter().map(|row| row.norm() > PART).collect()
    }

    /// The unknowns' change, in their own units, for each column of the determined ones.
    pub(super) fn unscaled_seen(&self) -> DMatrix<f64> {
        unscaled(&self.seen, &self.scales)
    }

    /// The combinations that change no reading, in the unknowns' own units.
    pub(super) fn unscaled_blind(&self) -> DMatrix<f64> {
        unscaled(&self.blind, &self.scales)
    }
}

fn unscaled(directions: &DMatrix<f64>, scales: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(directions.nrows(), directions.ncols(), |row, column| {
        directions[(row, column)] / scales[row]
    })
}

/// `a · b`, summed in the order of the rows. For larger matrices the library's own product uses instructions that
/// depend on the processor, and with them the last digit.
pub(super) fn product<'a>(a: impl Into<DMatrixView<'a, f64>>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let a = a.into();
    let mut result = DMatrix::zeros(a.nrows(), b.ncols());
    for (mut out, factors) in result.column_iter_mut().zip(b.column_iter()) {
        for (column, factor) in a.column_iter().zip(factors.iter()) {
            out.axpy(*factor, &column, 1.0);
        }
    }
    result
}
