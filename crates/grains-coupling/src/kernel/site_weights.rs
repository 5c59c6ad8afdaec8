//! The weights of one particle on the values at one site.

use super::axis::{LANES, Weights};

/// Where the values of a field lie in its array: that of cell or face (i, j, k) of the [`crate::GridAxis`] triple at
/// `offset + i + j stride[0] + k stride[1]`.
///
/// Where arrays hold the *upper* faces of their cells, the axes leave out the lowest halo cell of the array, so that its
/// upper face is face 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Index of the value of cell or face (0, 0, 0).
    pub offset: usize,
    /// Distance of neighbours along y and z.
    pub stride: [usize; 2],
}

impl Layout {
    /// An array of exactly the given numbers of values along x, y, z, x fastest.
    pub fn packed(counts: [usize; 3]) -> Self {
        Self { offset: 0, stride: [counts[0], counts[0] * counts[1]] }
    }
}

/// Weights of one particle on the values at a site, whose sum is 1.
#[derive(Clone, Debug, Default)]
pub struct SiteWeights {
    /// Values that are neighbours along x; those beyond the kernel have the weight 0. No more than `len` count.
    groups: Vec<Group>,
    len: usize,
}

/// Weights of neighbours along x.
#[derive(Clone, Copy, Debug, Default)]
struct Group {
    first: usize,
    weights: [f64; LANES],
}

impl SiteWeights {
    /// Takes the products of weights along x, y, z.
    #[inline(always)]
    pub(super) fn multiply(&mut self, [x, y, z]: [&Weights; 3], layout: &Layout) {
        let along = x.groups();
        self.len = along.len() * y.count * z.count;
        if self.groups.len() < self.len {
            self.groups.resize(self.len, Group::default());
        }
        let mut rows = self.groups.chunks_exact_mut(along.len());
        let first = layout.offset + x.first + y.first * layout.stride[0] + z.first * layout.stride[1];
        for (k, wz) in z.slice().iter().enumerate() {
            let first = first + k * layout.stride[1];
            for ((j, wy), row) in y.slice().iter().enumerate().zip(&mut rows) {
                let (first, weight) = (first + j * layout.stride[0], wy * wz);
                for (n, (group, along)) in row.iter_mut().zip(along).enumerate() {
                    *group = Group { first: first + n * LANES, weights: along.map(|wx| weight * wx) };
                }
            }
        }
    }

    #[inline(always)]
    fn groups(&self) -> &[Group] {
        &self.groups[..self.len]
    }

    /// Visits the index and weight of every value, and some of weight 0.
    pub fn for_each(&self, mut visit: impl FnMut(usize, f64)) {
        for Group { first, weights } in self.groups() {
            weights.iter().enumerate().for_each(|(lane, w)| visit(first + lane, *w));
        }
    }

    /// Means of fields of one length: Σ w f; what has no weight may have no value.
    #[inline(always)]
    pub fn means<const N: usize>(&self, fields: [&[f64]; N]) -> [f64; N] {
        let weighted = |w: f64, f: f64| if w > 0.0 { w * f } else { 0.0 };
        let mut sums = [[0.0; LANES]; N];
        for group in self.groups() {
            for (sums, field) in sums.iter_mut().zip(fields) {
                let (before, values) = (*sums, group.values(field));
                *sums =
                    std::array::from_fn(|lane| before[lane] + weighted(group.weights[lane], values[lane]));
            }
        }
        sums.map(|[a, b, c, d]| (a + b) + (c + d))
    }

    /// Shares amounts (of volume, force, momentum …) among the values of as many fields: f += w · amount.
    #[inline(always)]
    pub fn share<const N: usize>(&self, amounts: [f64; N], mut fields: [&mut [f64]; N]) {
        for Group { first, weights } in self.groups() {
            for (amount, field) in amounts.iter().zip(&mut fields) {
                let values = &mut field[*first..];
                match values.first_chunk_mut::<LANES>() {
                    Some(values) => {
                        let before = *values;
                        *values = std::array::from_fn(|lane| before[lane] + amount * weights[lane]);
                    }
                    // The last values of an array may be fewer.
                    None => values.iter_mut().zip(weights).for_each(|(f, w)| *f += amount * w),
                }
            }
        }
    }

    /// Leaves out what is closed, by open shares o: w o/Σ w o; where nothing is open, nothing changes.
    #[inline(always)]
    pub fn restrict(&mut self, open: &[f64]) {
        let [share] = self.means([open]);
        if share > 0.0 {
            let per_share = 1.0 / share;
            for group in &mut self.groups[..self.len] {
                let (before, open) = (group.weights, group.values(open));
                group.weights = std::array::from_fn(|lane| before[lane] * (open[lane] * per_share));
            }
        }
    }
}

impl Group {
    /// Its values of a field; those beyond the end of the array are 0.
    #[inline(always)]
    fn values(&self, field: &[f64]) -> [f64; LANES] {
        match field.get(self.first..self.first + LANES).and_then(|values| values.first_chunk()) {
            Some(values) => *values,
            None => std::array::from_fn(|lane| field.get(self.first + lane).copied().unwrap_or(0.0)),
        }
    }
}
