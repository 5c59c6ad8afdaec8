//! Numbers of many contacts side by side, for loops whose iterations go through the lanes of the processor.

use grains_geometry::Vec3;

/// Contacts taken at a time: what is known of them stays in the first-level cache.
pub(crate) const BLOCK: usize = 64;

/// Contacts evaluated together at least; those beyond the last are waste.
const LANES: usize = 8;

/// Numbers of the contacts of a block, column by column.
pub(crate) type Columns<const N: usize> = [[f64; BLOCK]; N];

/// The contacts to evaluate for `len` of them.
#[inline(always)]
pub(crate) fn whole_lanes(len: usize) -> std::ops::Range<usize> {
    0..len.next_multiple_of(LANES).min(BLOCK)
}

/// The vector of a contact.
#[inline(always)]
pub(crate) fn vector_at<const N: usize>(columns: &Columns<N>, k: usize) -> Vec3 {
    Vec3::new(columns[0][k], columns[1][k], columns[2][k])
}

/// Sets the row of a contact.
#[inline(always)]
pub(crate) fn set<const N: usize>(columns: &mut Columns<N>, k: usize, row: [f64; N]) {
    for (column, x) in columns.iter_mut().zip(row) {
        column[k] = x;
    }
}
