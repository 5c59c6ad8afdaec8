//! Transforms that diagonalise the second difference along one axis.

use crate::Axis;
use nalgebra::{DMatrix, SymmetricEigen};
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use std::f64::consts::PI;
use std::sync::Arc;

/// Functions that solve D v = λ W v on an axis, D the second difference and W the widths of the cells.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Basis {
    /// One cell: nothing to do.
    One,
    /// Periodic: sines and cosines.
    Fourier,
    /// No gradient at both ends: cosines (DCT-II).
    Cosine,
    /// Zero at both ends: sines (DST-II).
    Sine,
    /// Anything else (stretched, mixed ends): eigenvectors as a matrix.
    Matrix,
}

/// A transform of lines of one axis, there and back.
#[derive(Clone)]
pub(crate) struct Transform {
    basis: Basis,
    n: usize,
    /// λ per mode (1/m²), none positive.
    pub eigenvalues: Vec<f64>,
    /// What a line must be multiplied with for there and back, with the weights of the cells, to be right.
    pub scale: f64,
    forward: Option<Arc<dyn RealToComplex<f64>>>,
    backward: Option<Arc<dyn ComplexToReal<f64>>>,
    twiddles: Vec<Complex<f64>>,
    real: Vec<f64>,
    complex: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
    /// Eigenvectors V, V[i][m] at i n + m.
    vectors: Vec<f64>,
}

impl Transform {
    /// Whether an axis with these ends (true: zero imposed) has a fast transform.
    pub fn is_fast(axis: &Axis, imposed: [bool; 2]) -> bool {
        axis.cells() == 1 && imposed == [false; 2]
            || axis.is_uniform() && (axis.is_periodic() || imposed[0] == imposed[1])
    }

    /// Transform of an axis with these ends (true: zero imposed).
    pub fn new(axis: &Axis, imposed: [bool; 2]) -> Self {
        let n = axis.cells();
        let basis = match imposed {
            _ if n == 1 && imposed == [false; 2] => Basis::One,
            _ if !Self::is_fast(axis, imposed) => Basis::Matrix,
            _ if axis.is_periodic() => Basis::Fourier,
            [true, true] => Basis::Sine,
            _ => Basis::Cosine,
        };
        let mut transform = Self {
            basis,
            n,
            eigenvalues: Vec::new(),
            scale: 1.0,
            forward: None,
            backward: None,
            twiddles: Vec::new(),
            real: vec![0.0; n],
            complex: Vec::new(),
            scratch: Vec::new(),
            vectors: Vec::new(),
        };
        match basis {
            Basis::One => {
                transform.eigenvalues = vec![0.0];
                transform.scale = 1.0 / axis.length();
            }
            Basis::Matrix => transform.diagonalise(axis, imposed),
            _ => transform.plan(axis),
        }
        transform
    }

    fn plan(&mut self, axis: &Axis) {
        let (n, width) = (self.n, axis.length() / self.n as f64);
        let mut planner = RealFftPlanner::new();
        let (forward, backward) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
        self.complex = forward.make_output_vec();
        let longest = forward.get_scratch_len().max(backward.get_scratch_len());
        self.scratch = vec![Complex::default(); longest];
        (self.forward, self.backward) = (Some(forward), Some(backward));
        self.twiddles =
            (0..=n / 2).map(|k| Complex::from_polar(1.0, -PI * k as f64 / (2 * n) as f64)).collect();
        self.scale = 1.0 / (n as f64 * width);
        let angle = |mode: usize| match self.basis {
            Basis::Fourier => 2.0 * PI * mode.div_ceil(2) as f64 / n as f64,
            Basis::Sine => PI * (mode + 1) as f64 / n as f64,
            _ => PI * mode as f64 / n as f64,
        };
        self.eigenvalues = (0..n).map(|mode| -(2.0 / width * (0.5 * angle(mode)).sin()).powi(2)).collect();
    }

    fn diagonalise(&mut self, axis: &Axis, imposed: [bool; 2]) {
        let n = self.n;
        let root = |i: usize| axis.width(i as isize).sqrt();
        let mut matrix = DMatrix::<f64>::zeros(n, n);
        let mut couple = |i: usize, j: usize, conductance: f64| {
            matrix[(i, i)] -= conductance / (root(i) * root(i));
            matrix[(j, j)] -= conductance / (root(j) * root(j));
            matrix[(i, j)] += conductance / (root(i) * root(j));
            matrix[(j, i)] += conductance / (root(i) * root(j));
        };
        let distance = |i: isize| axis.centre(i + 1) - axis.centre(i);
        (0..n - 1).for_each(|i| couple(i, i + 1, 1.0 / distance(i as isize)));
        if axis.is_periodic() && n > 1 {
            couple(n - 1, 0, 1.0 / distance(n as isize - 1));
        }
        for (end, cell) in [(0, 0), (1, n - 1)] {
            if imposed[end] && !axis.is_periodic() {
                let width = axis.width(cell as isize);
                matrix[(cell, cell)] -= 2.0 / (width * width);
            }
        }
        let eigen = SymmetricEigen::new(matrix);
        let values: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
        self.eigenvalues = values.iter().map(|l| l.min(0.0)).collect();
        let singular = axis.is_periodic() || imposed == [false; 2];
        if singular && let Some(smallest) = (0..n).max_by(|&a, &b| values[a].total_cmp(&values[b])) {
            // The constant's eigenvalue is zero but for rounding; exactly zero tells the null space.
            self.eigenvalues[smallest] = 0.0;
        }
        self.vectors = (0..n * n).map(|at| eigen.eigenvectors[(at / n, at % n)] / root(at / n)).collect();
    }

    /// Coefficients of a line, Vᵀ x, in place.
    pub fn forward(&mut self, line: &mut [f64]) {
        let n = self.n;
        match self.basis {
            Basis::One => {}
            Basis::Matrix => {
                self.real.fill(0.0);
                for (value, row) in line.iter().zip(self.vectors.chunks_exact(n)) {
                    self.real.iter_mut().zip(row).for_each(|(sum, v)| *sum += v * value);
                }
                line.copy_from_slice(&self.real);
            }
            Basis::Fourier => {
                self.load_and_transform(line);
                line[0] = self.complex[0].re;
                for (pair, c) in line[1..].chunks_mut(2).zip(&self.complex[1..]) {
                    pair[0] = c.re;
                    if let Some(imaginary) = pair.get_mut(1) {
                        *imaginary = c.im;
                    }
                }
            }
            Basis::Cosine | Basis::Sine => self.cosine_forward(line),
        }
    }

    /// The line of given coefficients, V x, in place.
    pub fn backward(&mut self, line: &mut [f64]) {
        let n = self.n;
        match self.basis {
            Basis::One => {}
            Basis::Matrix => {
                for (sum, row) in self.real.iter_mut().zip(self.vectors.chunks_exact(n)) {
                    *sum = row.iter().zip(&*line).map(|(v, x)| v * x).sum();
                }
                line.copy_from_slice(&self.real);
            }
            Basis::Fourier => {
                self.complex[0] = Complex::new(line[0], 0.0);
                for (c, pair) in self.complex[1..].iter_mut().zip(line[1..].chunks(2)) {
                    *c = Complex::new(pair[0], pair.get(1).copied().unwrap_or(0.0));
                }
                self.transform_complex();
                line.copy_from_slice(&self.real);
            }
            Basis::Cosine | Basis::Sine => self.cosine_backward(line),
        }
    }

    fn load_and_transform(&mut self, line: &[f64]) {
        self.real.copy_from_slice(line);
        self.transform_real();
    }

    /// Transform of `real` into `complex`. Lengths are those of the plan, so the transform cannot fail.
    fn transform_real(&mut self) {
        if let Some(plan) = &self.forward {
            let done = plan.process_with_scratch(&mut self.real, &mut self.complex, &mut self.scratch);
            debug_assert!(done.is_ok());
        }
    }

    /// Transform of `complex` into `real`, n times the inverse.
    fn transform_complex(&mut self) {
        if let Some(plan) = &self.backward {
            let done = plan.process_with_scratch(&mut self.complex, &mut self.real, &mut self.scratch);
            debug_assert!(done.is_ok());
        }
    }

    /// X_k = Σ x_i cos(π k (i + ½)/n) by a Fourier transform of the even entries followed by the odd ones
    /// backwards; sines are the cosines of the line with alternating signs, backwards.
    fn cosine_forward(&mut self, line: &mut [f64]) {
        let (n, sign) = (self.n, self.sign_of_odd());
        let (even, odd) = self.real.split_at_mut(n.div_ceil(2));
        even.iter_mut().zip(line.iter().step_by(2)).for_each(|(even, x)| *even = *x);
        odd.iter_mut().rev().zip(line.iter().skip(1).step_by(2)).for_each(|(odd, x)| *odd = sign * x);
        self.transform_real();
        let (low, high) = line.split_at_mut(n / 2 + 1);
        let turned = |(twiddle, c): (&Complex<f64>, &Complex<f64>)| twiddle * c;
        let turned = self.twiddles[1..].iter().zip(&self.complex[1..]).map(turned);
        low[0] = self.complex[0].re;
        low[1..].iter_mut().zip(turned.clone()).for_each(|(x, turned)| *x = turned.re);
        high.iter_mut().rev().zip(turned).for_each(|(x, turned)| *x = -turned.im);
        if self.basis == Basis::Sine {
            line.reverse();
        }
    }

    fn cosine_backward(&mut self, line: &mut [f64]) {
        let (n, sign) = (self.n, self.sign_of_odd());
        if self.basis == Basis::Sine {
            line.reverse();
        }
        let (low, high) = line.split_at(n / 2 + 1);
        self.complex[0] = Complex::new(low[0], 0.0);
        // The middle one of an even number is its own partner.
        let partners = high.iter().rev().chain(low.last());
        let pairs = low[1..].iter().zip(partners).zip(&self.twiddles[1..]);
        for (c, ((x, partner), twiddle)) in self.complex[1..].iter_mut().zip(pairs) {
            *c = twiddle.conj() * Complex::new(*x, -partner);
        }
        if n.is_multiple_of(2) {
            // Real but for rounding, as the inverse transform demands.
            self.complex[n / 2].im = 0.0;
        }
        self.transform_complex();
        let (even, odd) = self.real.split_at(n.div_ceil(2));
        line.iter_mut().step_by(2).zip(even).for_each(|(x, even)| *x = *even);
        line.iter_mut().skip(1).step_by(2).zip(odd.iter().rev()).for_each(|(x, odd)| *x = sign * odd);
    }

    /// What the odd entries of a line are multiplied with for its sines to be cosines.
    fn sign_of_odd(&self) -> f64 {
        if self.basis == Basis::Sine { -1.0 } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// There, multiplied by λ, and back is the second difference over the width, for every kind of axis.
    #[test]
    fn transforms_diagonalise_the_second_difference() {
        let nodes = |n: usize| (0..=n).map(|k| (k as f64 * 0.3).exp()).collect::<Vec<_>>();
        for n in [2, 3, 5, 8, 9] {
            for (imposed, periodic) in
                [([false; 2], false), ([true; 2], false), ([true, false], false), ([false; 2], true)]
            {
                for axis in [Axis::uniform(0.0, 2.0, n, periodic), Axis::stretched(nodes(n), periodic)] {
                    check(&axis, imposed);
                }
            }
        }
    }

    fn check(axis: &Axis, imposed: [bool; 2]) {
        let n = axis.cells();
        let x: Vec<f64> = (0..n).map(|i| ((i * i) as f64 * 0.7).sin() + 0.1).collect();
        let at = |i: isize| match i {
            i if axis.is_periodic() => x[i.rem_euclid(n as isize) as usize],
            -1 => x[0] * if imposed[0] { -1.0 } else { 1.0 },
            i if i == n as isize => x[n - 1] * if imposed[1] { -1.0 } else { 1.0 },
            i => x[i as usize],
        };
        let gradient = |i: isize| (at(i + 1) - at(i)) / (axis.centre(i + 1) - axis.centre(i));
        let mut transform = Transform::new(axis, imposed);
        let mut line: Vec<f64> = (0..n as isize).map(|i| gradient(i) - gradient(i - 1)).collect();
        transform.forward(&mut line);
        let mut expected = x.clone();
        expected.iter_mut().enumerate().for_each(|(i, v)| *v *= axis.width(i as isize));
        transform.forward(&mut expected);
        for (m, (a, b)) in line.iter().zip(&expected).enumerate() {
            let b = b * transform.eigenvalues[m];
            let size = 1.0 + transform.eigenvalues[m].abs();
            assert!((a - b).abs() < 1e-12 * size, "{axis:?} {imposed:?} mode {m}: {a} {b}");
        }
        let mut back = x.clone();
        back.iter_mut().enumerate().for_each(|(i, v)| *v *= transform.scale * axis.width(i as isize));
        transform.forward(&mut back);
        transform.backward(&mut back);
        for (a, b) in back.iter().zip(&x) {
            assert!((a - b).abs() < 1e-12, "{axis:?} {imposed:?}: {a} {b}");
        }
    }
}
