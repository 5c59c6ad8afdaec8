//! Advective and viscous terms of one row of faces.

use super::Advection;
use crate::metrics::Local;
use multiversion::multiversion;

/// Fields the explicit terms are made of; all halos filled.
///
/// The terms are those of ∂(εu)/∂t + ∇·(εu u) = ∇·(ν w (∇u + ∇uᵀ)) + …, divided by the density (m/s²).
/// The weights w are the void fraction ε, or with ν = 1 a viscosity that varies, or both.
#[derive(Clone, Copy)]
pub(crate) struct Explicit<'a> {
    pub local: &'a Local,
    /// Velocity u (m/s).
    pub velocity: [&'a [f64]; 3],
    /// What carries momentum: ε u on the faces (m/s), the velocity itself where ε = 1.
    pub flux: [&'a [f64]; 3],
    /// Kinematic viscosity ν (m²/s).
    pub viscosity: f64,
    /// Weights w of the stresses; none where they are 1.
    pub weights: Option<StressWeights<'a>>,
    /// Whether the whole stress counts as viscous, not only that of ∇u.
    pub is_full: bool,
    pub advection: Advection,
}

/// What the stresses are weighed with, where they act: void fraction (-), viscosity (m²/s) or both.
#[derive(Clone, Copy)]
pub(crate) struct StressWeights<'a> {
    /// At the centres, across which a component is stretched, with ghosts.
    pub centres: [&'a [f64]; 3],
    /// On the edges across which a component (first) is sheared along an axis (second): of a cell, those at its upper faces.
    pub edges: [[&'a [f64]; 3]; 3],
}

/// Row (j, k) of a component's faces.
#[derive(Clone, Copy)]
pub(crate) struct RowPlace {
    pub component: usize,
    pub j: usize,
    pub k: usize,
}

impl Explicit<'_> {
    /// ∇·(εu u) − ∇·(ν w ∇uᵀ) and ∇·(ν w ∇u) of a row, or ∇·(εu u) and ∇·(ν w (∇u + ∇uᵀ)); both buffers are as long as the row
    /// has unknowns.
    ///
    /// ∇·∇uᵀ vanishes, so the transposed half of the stress counts only where w varies.
    pub fn row(&self, place: RowPlace, advective: &mut [f64], viscous: &mut [f64]) {
        set_row(self, place, advective, viscous);
    }

    #[inline(always)]
    fn row_with(
        &self,
        place: RowPlace,
        advective: &mut [f64],
        viscous: &mut [f64],
        scheme: impl Fn(f64, [f64; 4]) -> f64 + Copy,
    ) {
        let a = place.component;
        for b in (0..3).filter(|&b| self.local.active[b]) {
            let pair = Pair::new(self, place, b, advective.len());
            let Some(weights) = self.weights else {
                pair.add::<false, false>(advective, viscous, scheme, |_| [1.0; 2]);
                continue;
            };
            let (low, high) = match b == a {
                true => (pair.at(weights.centres[a], 0), pair.at(weights.centres[a], pair.along as isize)),
                false => {
                    (pair.at(weights.edges[a][b], -(pair.across as isize)), pair.at(weights.edges[a][b], 0))
                }
            };
            match self.is_full {
                true => pair.add::<true, true>(advective, viscous, scheme, |i| [low[i], high[i]]),
                false => pair.add::<true, false>(advective, viscous, scheme, |i| [low[i], high[i]]),
            }
        }
    }
}

/// See [`Explicit::row`].
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn set_row(terms: &Explicit<'_>, place: RowPlace, advective: &mut [f64], viscous: &mut [f64]) {
    advective.fill(0.0);
    viscous.fill(0.0);
    match terms.advection {
        Advection::Central => terms.row_with(place, advective, viscous, central),
        Advection::VanLeer => terms.row_with(place, advective, viscous, van_leer),
    }
}

/// Mean of both sides.
#[inline(always)]
fn central(_: f64, [_, lower, upper, _]: [f64; 4]) -> f64 {
    0.5 * (lower + upper)
}

/// Upstream value and half the harmonic mean of the slopes about it.
#[inline(always)]
fn van_leer(flux: f64, [far_lower, lower, upper, far_upper]: [f64; 4]) -> f64 {
    let middle = upper - lower;
    let (value, slope, sign) =
        if flux >= 0.0 { (lower, lower - far_lower, 1.0) } else { (upper, far_upper - upper, -1.0) };
    let product = slope * middle;
    if product > 0.0 { value + sign * product / (slope + middle) } else { value }
}

/// Inverse lengths (1/m) about one face of a component, for the fluxes along an axis.
#[derive(Clone, Copy)]
struct Metrics {
    /// Of the control volume.
    inverse: f64,
    /// Between the face and its neighbours below and above.
    low: f64,
    high: f64,
    /// Between the two cells of the face.
    slope: f64,
    /// Shares of these cells in the control volume.
    shares: [f64; 2],
}

/// Fluxes of one component through the faces of its control volumes normal to one axis.
struct Pair<'a> {
    component: usize,
    b: usize,
    start: usize,
    length: usize,
    along: usize,
    across: usize,
    place: RowPlace,
    terms: &'a Explicit<'a>,
}

impl<'a> Pair<'a> {
    fn new(terms: &'a Explicit<'a>, place: RowPlace, b: usize, length: usize) -> Self {
        let (layout, strides) = (terms.local.layout, terms.local.layout.strides());
        Self {
            component: place.component,
            b,
            start: layout.row(place.j, place.k),
            length,
            along: strides[place.component],
            across: strides[b],
            place,
            terms,
        }
    }

    /// The row shifted by an offset in the array.
    #[inline(always)]
    fn at(&self, data: &'a [f64], offset: isize) -> &'a [f64] {
        &data[(self.start as isize + offset) as usize..][..self.length]
    }

    /// Metrics entry of the row along an axis other than x.
    fn entry(&self, axis: usize) -> usize {
        self.terms.local.entry(if axis == 1 { self.place.j } else { self.place.k })
    }

    /// Metrics of the row, those along x taken from its first face.
    fn metrics(&self) -> Metrics {
        let axes = &self.terms.local.axes;
        let entry = |axis: usize| if axis == 0 { self.terms.local.layout.halo } else { self.entry(axis) };
        let (ma, ea) = (&axes[self.component], entry(self.component));
        let (mb, eb) = (&axes[self.b], entry(self.b));
        let is_own = self.component == self.b;
        Metrics {
            inverse: if is_own { mb.inverse_distance[eb] } else { mb.inverse_width[eb] },
            low: if is_own { mb.inverse_width[eb] } else { mb.inverse_distance[eb - 1] },
            high: if is_own { mb.inverse_width[eb + 1] } else { mb.inverse_distance[eb] },
            slope: ma.inverse_distance[ea],
            shares: [ma.lower_share[ea], ma.upper_share[ea]],
        }
    }

    /// Adds the terms; `eps` holds the weights on the lower and upper face of the control volume. The transposed half of the
    /// stress is left out, or (`WEIGHED`) taken off the advective terms, or (`FULL`) added to the viscous ones.
    #[inline(always)]
    fn add<const WEIGHED: bool, const FULL: bool>(
        &self,
        advective: &mut [f64],
        viscous: &mut [f64],
        scheme: impl Fn(f64, [f64; 4]) -> f64 + Copy,
        eps: impl Fn(usize) -> [f64; 2],
    ) {
        let (h, n, axes, row) =
            (self.terms.local.layout.halo, self.length, &self.terms.local.axes, self.metrics());
        let window = |data: &'a [f64], offset: usize| &data[h + offset - 1..][..n];
        let x = &axes[0];
        let (width, next_width) = (window(&x.inverse_width, 1), window(&x.inverse_width, 2));
        let (before, distance) = (window(&x.inverse_distance, 0), window(&x.inverse_distance, 1));
        match (self.component, self.b) {
            (0, 0) => {
                let metrics =
                    |i: usize| Metrics { inverse: distance[i], low: width[i], high: next_width[i], ..row };
                self.own::<WEIGHED, FULL>(advective, viscous, scheme, metrics, eps);
            }
            (a, b) if a == b => self.own::<WEIGHED, FULL>(advective, viscous, scheme, |_| row, eps),
            (0, _) => {
                let (low, high) = (window(&x.lower_share, 1), window(&x.upper_share, 1));
                let metrics = |i: usize| Metrics { slope: distance[i], shares: [low[i], high[i]], ..row };
                self.cross::<WEIGHED, FULL>(advective, viscous, scheme, metrics, eps);
            }
            (_, 0) => {
                let metrics =
                    |i: usize| Metrics { inverse: width[i], low: before[i], high: distance[i], ..row };
                self.cross::<WEIGHED, FULL>(advective, viscous, scheme, metrics, eps);
            }
            _ => self.cross::<WEIGHED, FULL>(advective, viscous, scheme, |_| row, eps),
        }
    }

    /// Through the faces normal to the component: the centres of the cells.
    #[inline(always)]
    fn own<const WEIGHED: bool, const FULL: bool>(
        &self,
        advective: &mut [f64],
        viscous: &mut [f64],
        scheme: impl Fn(f64, [f64; 4]) -> f64,
        metrics: impl Fn(usize) -> Metrics,
        eps: impl Fn(usize) -> [f64; 2],
    ) {
        let (s, nu) = (self.along as isize, self.terms.viscosity);
        let [u0, u1, u2, u3, u4] = [-2 * s, -s, 0, s, 2 * s].map(|o| self.at(self.terms.velocity[self.b], o));
        let [q1, q2, q3] = [-s, 0, s].map(|o| self.at(self.terms.flux[self.b], o));
        let (advective, viscous) = (&mut advective[..self.length], &mut viscous[..self.length]);
        for i in 0..self.length {
            let (m, [e_low, e_high]) = (metrics(i), eps(i));
            let (m_high, m_low) = (0.5 * (q2[i] + q3[i]), 0.5 * (q1[i] + q2[i]));
            let f_high = m_high * scheme(m_high, [u1[i], u2[i], u3[i], u4[i]]);
            let f_low = m_low * scheme(m_low, [u0[i], u1[i], u2[i], u3[i]]);
            let stress = (u3[i] - u2[i]) * (m.high * e_high) - (u2[i] - u1[i]) * (m.low * e_low);
            let term = nu * stress * m.inverse;
            // The normal stress is its own transpose.
            advective[i] += (f_high - f_low) * m.inverse - if WEIGHED && !FULL { term } else { 0.0 };
            viscous[i] += if FULL { 2.0 * term } else { term };
        }
    }

    /// Through the faces parallel to the component: the edges of the cells.
    #[inline(always)]
    fn cross<const WEIGHED: bool, const FULL: bool>(
        &self,
        advective: &mut [f64],
        viscous: &mut [f64],
        scheme: impl Fn(f64, [f64; 4]) -> f64,
        metrics: impl Fn(usize) -> Metrics,
        eps: impl Fn(usize) -> [f64; 2],
    ) {
        let (sa, sb, nu) = (self.along as isize, self.across as isize, self.terms.viscosity);
        let velocity = self.terms.velocity[self.component];
        let [u0, u1, u2, u3, u4] = [-2 * sb, -sb, 0, sb, 2 * sb].map(|o| self.at(velocity, o));
        let [q0, q1, q2, q3] = [0, sa, -sb, sa - sb].map(|o| self.at(self.terms.flux[self.b], o));
        let [v0, v1, v2, v3] = [0, sa, -sb, sa - sb].map(|o| self.at(self.terms.velocity[self.b], o));
        let (advective, viscous) = (&mut advective[..self.length], &mut viscous[..self.length]);
        for i in 0..self.length {
            let (m, [e_low, e_high]) = (metrics(i), eps(i));
            let [wl, wh] = m.shares;
            let (m_high, m_low) = (wl * q0[i] + wh * q1[i], wl * q2[i] + wh * q3[i]);
            let f_high = m_high * scheme(m_high, [u1[i], u2[i], u3[i], u4[i]]);
            let f_low = m_low * scheme(m_low, [u0[i], u1[i], u2[i], u3[i]]);
            let transposed = if WEIGHED {
                nu * m.slope * (e_high * (v1[i] - v0[i]) - e_low * (v3[i] - v2[i]))
            } else {
                0.0
            };
            advective[i] += (f_high - f_low - if FULL { 0.0 } else { transposed }) * m.inverse;
            let stress = (u3[i] - u2[i]) * (m.high * e_high) - (u2[i] - u1[i]) * (m.low * e_low);
            let term = nu * stress * m.inverse;
            viscous[i] += if FULL { term + transposed * m.inverse } else { term };
        }
    }
}
