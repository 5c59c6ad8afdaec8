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
    /// Row i of the forward sweep: x_i = (x_i + low x_{i−1}) pivot, with low and the inverse pivot of line l from `row(l)`.
    #[inline(always)]
    pub fn forward(self, x: &mut [f64], i: usize, mut row: impl FnMut(usize) -> [f64; 2]) {
        let Self { start, stride, lines } = self;
        let (done, ahead) = x.split_at_mut(start + i * stride);
        let current = &mut ahead[..lines];
        if i == 0 {
            current.iter_mut().enumerate().for_each(|(l, x)| *x *= row(l)[1]);
        } else {
            let previous = &done[start + (i - 1) * stride..][..lines];
            for l in 0..lines {
                let [low, pivot] = row(l);
                current[l] = (current[l] + low * previous[l]) * pivot;
            }
        }
    }

    /// Row i of the backward sweep: x_i = x_i + high x_{i+1}, with high over the pivot of line l from `high(l)`.
    #[inline(always)]
    pub fn backward(self, x: &mut [f64], i: usize, high: impl Fn(usize) -> f64) {
        let Self { start, stride, lines } = self;
        let (done, ahead) = x.split_at_mut(start + (i + 1) * stride);
        let (current, next) = (&mut done[start + i * stride..][..lines], &ahead[..lines]);
        for l in 0..lines {
            current[l] += high(l) * next[l];
        }
    }
}
