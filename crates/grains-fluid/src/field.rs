//! Arrays of one subdomain, their place in the cell part of the type.

use std::fmt::Debug;
use std::marker::PhantomData;
use std::ops::{AddAssign, SubAssign};

/// Own cells and halo of the arrays of a subdomain: n + 2 h per axis, x fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Own cells per axis.
    pub cells: [usize; 3],
    /// Width of the halo (cells), the same on every side.
    pub halo: usize,
}

impl Layout {
    /// Extent of the arrays per axis.
    pub fn dims(&self) -> [usize; 3] {
        self.cells.map(|n| n + 2 * self.halo)
    }

    /// Length of the arrays.
    pub fn len(&self) -> usize {
        self.dims().iter().product()
    }

    /// Whether the subdomain has no cell.
    pub fn is_empty(&self) -> bool {
        self.cells.contains(&0)
    }

    /// Distance in the array of neighbours per axis.
    pub fn strides(&self) -> [usize; 3] {
        let [x, y, _] = self.dims();
        [1, x, x * y]
    }

    /// Place in the array of cell (i, j, k); own cells are 0..n, the halo reaches from −h to n + h.
    #[inline]
    pub fn index(&self, i: isize, j: isize, k: isize) -> usize {
        let ([_, sy, sz], h) = (self.strides(), self.halo as isize);
        (i + h) as usize + (j + h) as usize * sy + (k + h) as usize * sz
    }

    /// Place of the first own cell of row (j, k).
    #[inline]
    pub fn row(&self, j: usize, k: usize) -> usize {
        self.index(0, j as isize, k as isize)
    }

    /// Starts of all own rows, y faster than z.
    pub fn rows(&self) -> impl Iterator<Item = usize> + use<> {
        let layout = *self;
        (0..layout.cells[2]).flat_map(move |k| (0..layout.cells[1]).map(move |j| layout.row(j, k)))
    }
}

/// Where in a cell the values of a field lie.
pub trait Location: Copy + Clone + Debug + Default + PartialEq {
    /// Axis whose upper face carries the value, or none at the centre.
    const FACE: Option<usize>;
}

macro_rules! location {
    ($name:ident, $face:expr, $doc:literal) => {
        #[doc = $doc]
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $name;
        impl Location for $name {
            const FACE: Option<usize> = $face;
        }
    };
}
location!(Centre, None, "Centre of the cell.");
location!(FaceX, Some(0), "Centre of the cell's upper x-face.");
location!(FaceY, Some(1), "Centre of the cell's upper y-face.");
location!(FaceZ, Some(2), "Centre of the cell's upper z-face.");

/// A number of a field: double precision, or single for what need not be exact.
pub trait Real: Copy + Debug + Default + PartialEq + AddAssign + SubAssign + Into<f64> {
    /// The nearest number to a value.
    fn nearest(value: f64) -> Self;
}

impl Real for f64 {
    #[inline]
    fn nearest(value: f64) -> Self {
        value
    }
}

impl Real for f32 {
    #[inline]
    fn nearest(value: f64) -> Self {
        value as f32
    }
}

/// One quantity on a subdomain: `[nz + 2h][ny + 2h][nx + 2h]`, x fastest, at a place in the cell told by the type.
///
/// Fields add only to fields of the same place:
/// ```compile_fail
/// # use grains_fluid::{Centre, FaceX, Field, Layout};
/// let layout = Layout { cells: [4; 3], halo: 2 };
/// let mut pressure = Field::<Centre>::new(layout);
/// pressure += &Field::<FaceX>::new(layout);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Field<L: Location, T: Real = f64> {
    layout: Layout,
    data: Vec<T>,
    location: PhantomData<L>,
}

impl<L: Location, T: Real> Field<L, T> {
    /// Field of zeros.
    pub fn new(layout: Layout) -> Self {
        Self { layout, data: vec![T::default(); layout.len()], location: PhantomData }
    }

    /// Extent of the arrays.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// All values, halo included.
    #[inline]
    pub fn data(&self) -> &[T] {
        &self.data
    }

    /// All values, halo included.
    #[inline]
    pub fn data_mut(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// Value of cell (i, j, k), own cells from 0.
    #[inline]
    pub fn at(&self, i: isize, j: isize, k: isize) -> T {
        self.data[self.layout.index(i, j, k)]
    }

    /// Sets the value of cell (i, j, k).
    #[inline]
    pub fn set(&mut self, i: isize, j: isize, k: isize, value: T) {
        let at = self.layout.index(i, j, k);
        self.data[at] = value;
    }

    /// Sets every value, halo included.
    pub fn fill(&mut self, value: T) {
        self.data.fill(value);
    }

    /// Own values of row (j, k).
    pub fn row(&self, j: usize, k: usize) -> &[T] {
        &self.data[self.layout.row(j, k)..][..self.layout.cells[0]]
    }

    /// Own values, x fastest, without halo.
    pub fn own(&self) -> impl Iterator<Item = T> + '_ {
        self.layout.rows().flat_map(|p| self.data[p..p + self.layout.cells[0]].iter().copied())
    }
}

impl<L: Location, T: Real> AddAssign<&Self> for Field<L, T> {
    fn add_assign(&mut self, other: &Self) {
        self.data.iter_mut().zip(&other.data).for_each(|(a, b)| *a += *b);
    }
}

impl<L: Location, T: Real> SubAssign<&Self> for Field<L, T> {
    fn sub_assign(&mut self, other: &Self) {
        self.data.iter_mut().zip(&other.data).for_each(|(a, b)| *a -= *b);
    }
}

/// A vector quantity or a coefficient on the faces: one field per axis, each at the upper faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Faces {
    /// At the upper x-faces.
    pub x: Field<FaceX>,
    /// At the upper y-faces.
    pub y: Field<FaceY>,
    /// At the upper z-faces.
    pub z: Field<FaceZ>,
}

impl Faces {
    /// Zeros.
    pub fn new(layout: Layout) -> Self {
        Self { x: Field::new(layout), y: Field::new(layout), z: Field::new(layout) }
    }

    /// Extent of the arrays.
    pub fn layout(&self) -> Layout {
        self.x.layout
    }

    /// Values of one axis, halo included.
    #[inline]
    pub fn component(&self, axis: usize) -> &[f64] {
        match axis {
            0 => &self.x.data,
            1 => &self.y.data,
            _ => &self.z.data,
        }
    }

    /// Values of one axis, halo included.
    #[inline]
    pub fn component_mut(&mut self, axis: usize) -> &mut [f64] {
        match axis {
            0 => &mut self.x.data,
            1 => &mut self.y.data,
            _ => &mut self.z.data,
        }
    }

    /// Adds a multiple of other values, halo included.
    pub(crate) fn add(&mut self, share: f64, other: &Self) {
        for axis in 0..3 {
            let pairs = self.component_mut(axis).iter_mut().zip(other.component(axis));
            pairs.for_each(|(to, from)| *to += share * from);
        }
    }

    /// Values of axis `a` to change and of another axis `b` to read, halo included.
    pub(crate) fn two_components(&mut self, a: usize, b: usize) -> (&mut [f64], &[f64]) {
        debug_assert_ne!(a, b);
        let Self { x, y, z } = self;
        let (x, y, z) = (&mut x.data, &mut y.data, &mut z.data);
        match (a, b) {
            (0, 1) => (x, y),
            (0, _) => (x, z),
            (1, 0) => (y, x),
            (1, _) => (y, z),
            (_, 0) => (z, x),
            (_, _) => (z, y),
        }
    }

    /// Values of the three axes, halo included.
    pub fn components(&self) -> [&[f64]; 3] {
        [&self.x.data, &self.y.data, &self.z.data]
    }

    /// Values of the three axes, halo included.
    pub fn components_mut(&mut self) -> [&mut [f64]; 3] {
        [&mut self.x.data, &mut self.y.data, &mut self.z.data]
    }

    /// Sets every value, halo included.
    pub fn fill(&mut self, value: f64) {
        self.components_mut().into_iter().for_each(|c| c.fill(value));
    }
}
