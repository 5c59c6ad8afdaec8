//! The operator of the pressure equation.

use crate::ffi::{Matrix, Rows, Session, Vector};
use crate::levels::{CENTRE, Layout, Stencil};
use crate::{Grid, PetscError};
use std::rc::Rc;

/// The scale of the matrix is chosen anew when coefficients have changed by more than this.
const SCALE_RANGE: f64 = 1e6;

/// What holds on a face of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// No gradient: coefficients on the face do not matter.
    Neumann,
    /// Zero on the face, half a cell from the centre; a part of the face whose coefficients are zero is
    /// as one without gradient.
    Dirichlet,
    /// The opposite face is the same; the grid must be periodic there.
    Periodic,
}

/// Coefficients on the faces of the own cells: of each axis arrays that begin with the lower and the upper
/// face of the first cell.
pub(crate) struct Faces<'a> {
    pub lower: [&'a [f64]; 3],
    pub upper: [&'a [f64]; 3],
    /// Steps between lines of x, and between planes, per axis.
    pub strides: [[usize; 2]; 3],
}

/// Geometry of a level: areas over distances, factor by factor.
pub(crate) struct Geometry {
    /// Inverse distance (1/m) of the points on both sides of each own face, zero on closed ends.
    inverse: [Vec<f64>; 3],
    /// Widths (m) of the own cells.
    pub widths: [Vec<f64>; 3],
}

/// The finite-volume form of div(c grad p) on seven points, integrated over the cells.
pub struct PressureMatrix {
    pub(crate) session: Rc<Session>,
    pub(crate) layout: Layout,
    pub(crate) matrix: Matrix,
    pub(crate) boundaries: [[Boundary; 2]; 3],
    /// Divides the matrix, so that its entries are near 1: m, by the unit of the coefficient.
    pub(crate) scale: f64,
    /// Whether constants are mapped to zero.
    pub(crate) is_singular: bool,
    pub(crate) faces: [Vec<f64>; 3],
    pub(crate) geometry: Geometry,
    stencil: Stencil,
    /// What the matrix is applied to, and the result: stand-ins for arrays of the caller.
    pub(crate) input: Vector,
    pub(crate) output: Vector,
    has_coefficients: bool,
}

impl<'a> Faces<'a> {
    /// From arrays of all faces normal to each axis, one more along it than there are cells.
    pub fn shared(n: [usize; 3], [x, y, z]: [&'a [f64]; 3]) -> Self {
        let strides = [[n[0] + 1, (n[0] + 1) * n[1]], [n[0], n[0] * (n[1] + 1)], [n[0], n[0] * n[1]]];
        Self { lower: [x, y, z], upper: [&x[1..], &y[n[0]..], &z[n[0] * n[1]..]], strides }
    }

    /// From arrays of the lower and of the upper face of each cell.
    pub fn per_cell(n: [usize; 3], faces: &'a [[Vec<f64>; 2]; 3]) -> Self {
        let side = |s: usize| std::array::from_fn(|a| &faces[a][s][..]);
        Self { lower: side(0), upper: side(1), strides: [[n[0], n[0] * n[1]]; 3] }
    }

    /// The line of cells at (j, k), of one axis and side.
    pub fn line(&self, axis: usize, side: usize, [j, k]: [usize; 2], length: usize) -> &'a [f64] {
        let at = j * self.strides[axis][0] + k * self.strides[axis][1];
        &[self.lower, self.upper][side][axis][at..at + length]
    }
}

impl Geometry {
    /// Of the own cells of a layout.
    pub fn new(layout: &Layout, boundaries: [[Boundary; 2]; 3]) -> Self {
        let (lower, n) = (layout.lower(), layout.counts());
        let inverse = std::array::from_fn(|a| {
            let mut inverse: Vec<f64> = layout.axes[a].distances().iter().map(|d| 1.0 / d).collect();
            let last = inverse.len() - 1;
            for (end, boundary) in [0, last].into_iter().zip(boundaries[a]) {
                if boundary == Boundary::Neumann {
                    inverse[end] = 0.0;
                }
            }
            inverse[lower[a]..=lower[a] + n[a]].to_vec()
        });
        Self { inverse, widths: std::array::from_fn(|a| layout.widths(a).to_vec()) }
    }

    /// Fills the values of the matrix -div(c grad) / scale in the order of the stencil's rows.
    pub fn fill(&self, stencil: &Stencil, faces: &Faces, scale: f64, values: &mut [f64]) {
        let [nx, ny, nz] = self.widths.each_ref().map(Vec::len);
        let [ix, iy, iz] = &self.inverse;
        let [wx, wy, wz] = &self.widths;
        for k in 0..nz {
            for j in 0..ny {
                let line = |axis, side| faces.line(axis, side, [j, k], nx);
                let [[xl, xu], [yl, yu], [zl, zu]] = [0, 1, 2].map(|axis| [line(axis, 0), line(axis, 1)]);
                let across = wy[j] * wz[k] / scale;
                let [yl_factor, yu_factor] = [iy[j] * wz[k] / scale, iy[j + 1] * wz[k] / scale];
                let [zl_factor, zu_factor] = [iz[k] * wy[j] / scale, iz[k + 1] * wy[j] / scale];
                let first = (k * ny + j) * nx;
                for i in 0..nx {
                    let conductances = [
                        zl[i] * zl_factor * wx[i],
                        yl[i] * yl_factor * wx[i],
                        xl[i] * ix[i] * across,
                        0.0,
                        xu[i] * ix[i + 1] * across,
                        yu[i] * yu_factor * wx[i],
                        zu[i] * zu_factor * wx[i],
                    ];
                    stencil.put(first + i, conductances, values);
                }
            }
        }
    }

    /// Calls `visit` with the first own index and the area of a section normal to x (m²) of every line.
    pub fn for_each_line(&self, mut visit: impl FnMut(usize, f64)) {
        let nx = self.widths[0].len();
        let mut first = 0;
        for wz in &self.widths[2] {
            for wy in &self.widths[1] {
                visit(first, wy * wz);
                first += nx;
            }
        }
    }
}

impl Stencil {
    /// Writes the row of a cell: minus each conductance in its column, their sum in the diagonal; 1 for a cell closed all around,
    /// whose pressure stays 0.
    #[inline]
    fn put(&self, cell: usize, conductances: [f64; 7], values: &mut [f64]) {
        let row = &mut values[self.starts[cell] as usize..self.starts[cell + 1] as usize];
        let sum: f64 = conductances.iter().sum();
        let sum = if sum == 0.0 { 1.0 } else { sum };
        if let (0, Ok(row)) = (self.kinds[cell], <&mut [f64; 7]>::try_from(&mut *row)) {
            *row = conductances.map(|conductance| -conductance);
            row[CENTRE] = sum;
            return;
        }
        let positions = &self.positions[self.kinds[cell] as usize];
        row.fill(0.0);
        for (position, conductance) in positions.iter().zip(conductances) {
            if let Some(position) = position {
                row[*position as usize] -= conductance;
            }
        }
        if let Some(centre) = positions[CENTRE] {
            row[centre as usize] += sum;
        }
    }
}

impl PressureMatrix {
    /// The operator on a grid whose cells measure `widths[axis][i]` (m, all cells of each axis), with
    /// `boundaries[axis]` on the lower and upper face of the box. Collective.
    ///
    /// Errors if widths are not positive or not as many as cells, or if the boundaries do not fit the grid.
    pub fn new(grid: &Grid, widths: [&[f64]; 3], boundaries: [[Boundary; 2]; 3]) -> Result<Self, PetscError> {
        let mut layout = grid.layout.clone();
        for (a, name) in ["x", "y", "z"].into_iter().enumerate() {
            check_axis(name, layout.axes[a].cells(), layout.axes[a].is_periodic, widths[a], boundaries[a])?;
            layout.axes[a].widths = widths[a].to_vec();
        }
        let ((columns, stencil), geometry) = (layout.stencil(), Geometry::new(&layout, boundaries));
        let local_columns = layout.counts().iter().product();
        let rows = Rows { local_columns, starts: &stencil.starts, columns: &columns };
        let mut matrix = Matrix::new(&grid.session, &rows, 0.0)?;
        matrix.set_symmetric()?;
        let faces = face_counts(layout.counts()).map(|n| vec![0.0; n]);
        let (input, output) = (grid.vector()?, grid.vector()?);
        let session = Rc::clone(&grid.session);
        let (scale, is_singular, has_coefficients) = (0.0, false, false);
        Ok(Self {
            session,
            layout,
            matrix,
            boundaries,
            scale,
            is_singular,
            faces,
            geometry,
            stencil,
            input,
            output,
            has_coefficients,
        })
    }

    /// Number of own cells.
    pub fn cells(&self) -> usize {
        self.layout.counts().iter().product()
    }

    /// Number of faces of the own cells normal to x, y, z: (nx + 1) ny nz and so on.
    pub fn face_counts(&self) -> [usize; 3] {
        face_counts(self.layout.counts())
    }

    /// Whether the operator maps constants to zero, as it does without Dirichlet faces of positive
    /// coefficient: pressure is then known up to a constant.
    pub fn is_singular(&self) -> bool {
        self.is_singular
    }

    /// Sets the coefficient c on the faces normal to x, y, z (x fastest, the upper faces of the last own
    /// cells included; a face between two ranks or periodic images has the same value on both). Collective.
    ///
    /// Errors, on all ranks alike, if an array has the wrong length or a coefficient is negative or not
    /// finite.
    pub fn set_coefficients(&mut self, faces: [&[f64]; 3]) -> Result<(), PetscError> {
        let wrong = self.first_wrong(faces);
        let ends = if wrong.is_none() { self.largest_on_open_ends(faces) } else { 0.0 };
        let largest = if wrong.is_none() { self.largest_conductance(faces) } else { 0.0 };
        let [some_wrong, ends, largest] =
            self.session.max([f64::from(u8::from(wrong.is_some())), ends, largest]);
        if some_wrong > 0.0 {
            let elsewhere = || PetscError::Coefficient("another rank has one that is not".into());
            return Err(wrong.unwrap_or_else(elsewhere));
        }
        if largest == 0.0 {
            return Err(PetscError::Coefficient("all of them are zero".into()));
        }
        // A power of two leaves all digits as they are.
        let scale = largest.log2().round().exp2();
        if !(self.scale / SCALE_RANGE..=self.scale * SCALE_RANGE).contains(&scale) {
            self.scale = scale;
        }
        if !self.has_coefficients || self.is_singular != (ends == 0.0) {
            self.is_singular = ends == 0.0;
            self.matrix.set_constant_null_space(self.is_singular)?;
        }
        for (kept, given) in self.faces.iter_mut().zip(faces) {
            kept.copy_from_slice(given);
        }
        let (stencil, geometry, scale) = (&self.stencil, &self.geometry, self.scale);
        let shared = Faces::shared(self.layout.counts(), self.faces.each_ref().map(|list| &list[..]));
        self.matrix.update(|values| geometry.fill(stencil, &shared, scale, values))?;
        self.has_coefficients = true;
        Ok(())
    }

    /// result = div(c grad p) of the own cells, with zero on Dirichlet faces. Collective.
    pub fn apply(&self, pressure: &mut [f64], result: &mut [f64]) -> Result<(), PetscError> {
        self.check_ready()?;
        for (what, found) in [("the pressure", pressure.len()), ("the result", result.len())] {
            check_length(what, self.cells(), found)?;
        }
        self.input
            .with_array(pressure, |x| self.output.with_array(result, |y| self.matrix.multiply(x, y)))?;
        self.divide_by_volumes(result);
        Ok(())
    }

    pub(crate) fn check_ready(&self) -> Result<(), PetscError> {
        if self.has_coefficients { Ok(()) } else { Err(PetscError::NoCoefficients) }
    }

    /// b = -f V / scale: the right-hand side as the matrix wants it.
    pub(crate) fn integrate(&self, rhs: &[f64], b: &mut [f64]) {
        let widths = &self.geometry.widths[0];
        self.geometry.for_each_line(|first, area| {
            let factor = -area / self.scale;
            let line = first..first + widths.len();
            for ((b, f), width) in b[line.clone()].iter_mut().zip(&rhs[line]).zip(widths) {
                *b = f * width * factor;
            }
        });
    }

    /// The inverse of [`Self::integrate`], in place.
    pub(crate) fn divide_by_volumes(&self, values: &mut [f64]) {
        let widths = &self.geometry.widths[0];
        self.geometry.for_each_line(|first, area| {
            let factor = -self.scale / area;
            for (value, width) in values[first..first + widths.len()].iter_mut().zip(widths) {
                *value *= factor / width;
            }
        });
    }

    /// The first thing wrong with the arrays on this rank.
    fn first_wrong(&self, faces: [&[f64]; 3]) -> Option<PetscError> {
        const NAMES: [&str; 3] =
            ["the coefficients on faces normal to x", "those normal to y", "those normal to z"];
        for (axis, list) in faces.iter().enumerate() {
            if let Err(wrong) = check_length(NAMES[axis], self.faces[axis].len(), list.len()) {
                return Some(wrong);
            }
            let is_wrong = |c: f64| !(0.0..f64::INFINITY).contains(&c);
            // Without an early end the loop is vectorised.
            if list.iter().fold(false, |wrong, &c| wrong | is_wrong(c)) {
                let at = list.iter().position(|&c| is_wrong(c)).unwrap_or(0);
                let mut extent = self.layout.counts();
                extent[axis] += 1;
                let own = [at % extent[0], at / extent[0] % extent[1], at / (extent[0] * extent[1])];
                let lower = self.layout.lower();
                let [i, j, k] = [0, 1, 2].map(|a| own[a] + lower[a]);
                let name = ["x", "y", "z"][axis];
                let text =
                    format!("it is {} on the lower face normal to {name} of cell ({i}, {j}, {k})", list[at]);
                return Some(PetscError::Coefficient(text));
            }
        }
        None
    }

    /// Largest coefficient on own Dirichlet faces.
    fn largest_on_open_ends(&self, faces: [&[f64]; 3]) -> f64 {
        let (lower, n) = (self.layout.lower(), self.layout.counts());
        let shared = Faces::shared(n, faces);
        let mut largest = 0.0_f64;
        for axis in 0..3 {
            let touches = [lower[axis] == 0, lower[axis] + n[axis] == self.layout.axes[axis].cells()];
            for (side, touches) in touches.into_iter().enumerate() {
                if !touches || self.boundaries[axis][side] != Boundary::Dirichlet {
                    continue;
                }
                let end = side * (n[axis] - 1);
                let range = |a: usize| if a == axis { end..end + 1 } else { 0..n[a] };
                for (k, j) in range(2).flat_map(|k| range(1).map(move |j| (k, j))) {
                    let line = &shared.line(axis, side, [j, k], n[0])[range(0)];
                    largest = line.iter().fold(largest, |m, c| m.max(*c));
                }
            }
        }
        largest
    }

    /// Largest coefficient times a typical area over distance, of the axes along which there are neighbours.
    fn largest_conductance(&self, faces: [&[f64]; 3]) -> f64 {
        let mean = self.layout.axes.each_ref().map(|axis| axis.mean_width());
        let volume: f64 = mean.iter().product();
        let largest = |list: &[f64]| list.iter().fold(0.0_f64, |m, c| m.max(*c));
        let long = (0..3).filter(|&a| {
            self.layout.axes[a].cells() > 1 || self.boundaries[a].contains(&Boundary::Dirichlet)
        });
        long.map(|a| largest(faces[a]) * volume / (mean[a] * mean[a])).fold(0.0, f64::max)
    }
}

fn face_counts(n: [usize; 3]) -> [usize; 3] {
    std::array::from_fn(|a| (0..3).map(|b| n[b] + usize::from(a == b)).product())
}

pub(crate) fn check_length(what: &'static str, expected: usize, found: usize) -> Result<(), PetscError> {
    if expected == found { Ok(()) } else { Err(PetscError::Length { what, expected, found }) }
}

fn check_axis(
    name: &str,
    cells: usize,
    is_periodic: bool,
    widths: &[f64],
    boundaries: [Boundary; 2],
) -> Result<(), PetscError> {
    let wrong = |text: String| Err(PetscError::Grid(text));
    if widths.len() != cells {
        return wrong(format!("{} widths were given for the {cells} cells along {name}", widths.len()));
    }
    if let Some(k) = widths.iter().position(|w| !(f64::MIN_POSITIVE..f64::INFINITY).contains(w)) {
        return wrong(format!("cell {k} along {name} is {} m wide: widths are positive", widths[k]));
    }
    if boundaries.iter().any(|b| (*b == Boundary::Periodic) != is_periodic) {
        let kind = if is_periodic { "periodic" } else { "not periodic" };
        return wrong(format!(
            "the boundaries along {name} are {boundaries:?}, but the grid is {kind} there"
        ));
    }
    Ok(())
}
