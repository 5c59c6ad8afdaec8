//! Numbers of many queries, column by column, as the lanes of the processor read them.

use crate::{Mat3, Vec3};

/// `N` numbers of each of up to `M` queries.
pub(super) type Columns<const N: usize, const M: usize> = [[f64; M]; N];

/// The vector of query `k`.
#[inline(always)]
pub(super) fn vector<const M: usize>(columns: &Columns<3, M>, k: usize) -> Vec3 {
    Vec3::new(columns[0][k], columns[1][k], columns[2][k])
}

/// The matrix of query `k`, which was set column by column.
#[inline(always)]
pub(super) fn matrix<const M: usize>(columns: &Columns<9, M>, k: usize) -> Mat3 {
    Mat3::from_fn(|i, j| columns[i + 3 * j][k])
}

/// Sets the numbers of query `k`.
#[inline(always)]
pub(super) fn set<const N: usize, const M: usize>(columns: &mut Columns<N, M>, k: usize, row: &[f64]) {
    for (column, x) in columns.iter_mut().zip(row) {
        column[k] = *x;
    }
}
