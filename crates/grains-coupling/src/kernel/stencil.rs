//! The weights of one particle on the cells and faces around it.

use super::axis::{GridAxis, Weights};
use super::function::Kernel;
use crate::CouplingError;
use grains_geometry::Vec3;

/// Where a field lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Site {
    /// Centres of cells.
    Cells,
    /// Faces normal to an axis (0, 1, 2); face i is the lower one of cell i.
    Faces(usize),
    /// The same without those on a boundary of the domain, whose shares the next ones within take.
    InnerFaces(usize),
}

/// Where the values of a field lie in its array: that of cell or face (i, j, k) of the [`GridAxis`] triple at
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

/// Weights of one particle: three short lists, whose products are those of the cells.
#[derive(Clone, Debug)]
pub struct Stencil {
    cells: [Weights; 3],
    faces: [Weights; 3],
    inner: [Weights; 3],
}

impl Default for Stencil {
    fn default() -> Self {
        Self { cells: [Weights::NONE; 3], faces: [Weights::NONE; 3], inner: [Weights::NONE; 3] }
    }
}

impl Stencil {
    /// Takes the place of a particle at `center` (m) of equivalent diameter `diameter` (m); allocates nothing.
    ///
    /// Errors: a kernel that leaves the cells and their halo.
    #[inline]
    pub fn place(
        &mut self,
        kernel: &Kernel,
        axes: &[GridAxis; 3],
        center: &Vec3,
        diameter: f64,
    ) -> Result<(), CouplingError> {
        let reach = kernel.reach(diameter);
        for a in 0..3 {
            axes[a].spread(kernel, a, center[a], reach, &mut self.cells[a])?;
            GridAxis::faces(&self.cells[a], &mut self.faces[a]);
            axes[a].inner_faces(&self.cells[a], &self.faces[a], &mut self.inner[a]);
        }
        Ok(())
    }

    /// Weights along the three axes at a site.
    #[inline(always)]
    fn at(&self, site: Site) -> [&Weights; 3] {
        std::array::from_fn(|a| match site {
            Site::Faces(axis) if axis == a => &self.faces[a],
            Site::InnerFaces(axis) if axis == a => &self.inner[a],
            _ => &self.cells[a],
        })
    }

    /// Visits every run of values that are neighbours along x: the index of the first, the weight of the run, and the
    /// weights along it.
    #[inline(always)]
    fn for_each_run(&self, site: Site, layout: &Layout, mut visit: impl FnMut(usize, f64, &[f64])) {
        let [x, y, z] = self.at(site);
        for (k, wz) in z.slice().iter().enumerate() {
            for (j, wy) in y.slice().iter().enumerate() {
                let row = (y.first + j) * layout.stride[0] + (z.first + k) * layout.stride[1];
                visit(layout.offset + x.first + row, wy * wz, x.slice());
            }
        }
    }

    /// Visits the index and weight of every value; the weights sum up to 1.
    pub fn for_each(&self, site: Site, layout: &Layout, mut visit: impl FnMut(usize, f64)) {
        self.for_each_run(site, layout, |first, weight, along| {
            along.iter().enumerate().for_each(|(i, w)| visit(first + i, weight * w));
        });
    }

    /// Number of values that [`Stencil::for_each`] visits.
    pub fn len(&self, site: Site) -> usize {
        self.at(site).iter().map(|w| w.count).product()
    }

    /// Whether no particle has been placed.
    pub fn is_empty(&self) -> bool {
        self.len(Site::Cells) == 0
    }

    /// Mean of a field under the kernel: Σ w f.
    #[inline]
    pub fn interpolate(&self, site: Site, layout: &Layout, field: &[f64]) -> f64 {
        let mut sum = 0.0;
        self.for_each_run(site, layout, |first, weight, along| {
            let values = &field[first..first + along.len()];
            sum += weight * along.iter().zip(values).map(|(w, f)| w * f).sum::<f64>();
        });
        sum
    }

    /// Σ w o and Σ w o f of open shares o and a field f.
    #[inline]
    pub fn open_sums(&self, site: Site, layout: &Layout, open: &[f64], field: &[f64]) -> [f64; 2] {
        let mut sums = [0.0; 2];
        self.for_each(site, layout, |at, w| {
            sums[0] += w * open[at];
            // What is closed may have no value.
            sums[1] += if open[at] > 0.0 { w * open[at] * field[at] } else { 0.0 };
        });
        sums
    }

    /// Shares an amount (of volume, force, momentum …) among the values of a field: f += w · amount.
    #[inline]
    pub fn deposit(&self, site: Site, layout: &Layout, amount: f64, field: &mut [f64]) {
        self.for_each_run(site, layout, |first, weight, along| {
            let values = &mut field[first..first + along.len()];
            let share = weight * amount;
            values.iter_mut().zip(along).for_each(|(f, w)| *f += share * w);
        });
    }
}
