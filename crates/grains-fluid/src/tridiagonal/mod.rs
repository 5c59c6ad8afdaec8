//! Tridiagonal systems along lines that lie side by side: the sweeps of Thomas elimination, vectorised over the lines.

mod couplings;
mod lines;
mod shared;

pub(crate) use couplings::Couplings;
pub(crate) use lines::{Conduction, ConductionLines};
pub(crate) use shared::SharedLines;

/// Lines side by side: unknown i of line l lies at start + i stride + l.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Panel {
    pub start: usize,
    pub stride: usize,
    pub lines: usize,
}

impl Panel {
    /// Row i, and another one, j, beside it.
    #[inline(always)]
    pub fn rows(self, x: &mut [f64], i: usize, j: usize) -> (&mut [f64], &[f64]) {
        let [at_i, at_j] = [i, j].map(|i| self.start + i * self.stride);
        let (before, from) = x.split_at_mut(at_i.max(at_j));
        match j < i {
            true => (&mut from[..self.lines], &before[at_j..][..self.lines]),
            false => (&mut before[at_i..][..self.lines], &from[..self.lines]),
        }
    }

    /// Row i of the forward sweep: x_i = (x_i + low x_{i−1}) pivot, with low and the inverse pivot of line l from `row(l)`.
    #[inline(always)]
    pub fn forward(self, x: &mut [f64], i: usize, mut row: impl FnMut(usize) -> [f64; 2]) {
        if i == 0 {
            let first = &mut x[self.start..][..self.lines];
            first.iter_mut().enumerate().for_each(|(l, x)| *x *= row(l)[1]);
        } else {
            let (current, previous) = self.rows(x, i, i - 1);
            for l in 0..self.lines {
                let [low, pivot] = row(l);
                current[l] = (current[l] + low * previous[l]) * pivot;
            }
        }
    }

    /// Row i of the backward sweep: x_i = x_i + high x_{i+1}, with high over the pivot of line l from `high(l)`.
    #[inline(always)]
    pub fn backward(self, x: &mut [f64], i: usize, high: impl Fn(usize) -> f64) {
        let (current, next) = self.rows(x, i, i + 1);
        for l in 0..self.lines {
            current[l] += high(l) * next[l];
        }
    }
}
