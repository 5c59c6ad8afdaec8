//! Advective and viscous terms of one row of faces.

use super::Advection;
use crate::metrics::Local;

/// Fields the explicit terms are made of; all halos filled.
///
/// The terms are those of ∂(εu)/∂t + ∇·(εu u) = ν ∇·(ε ∇u) + …, divided by the density (m/s²).
#[derive(Clone, Copy)]
pub(crate) struct Explicit<'a> {
    pub local: &'a Local,
    /// Velocity u (m/s).
    pub velocity: [&'a [f64]; 3],
    /// What carries momentum: ε u on the faces (m/s), the velocity itself where ε = 1.
    pub flux: [&'a [f64]; 3],
    /// Kinematic viscosity ν (m²/s).
    pub viscosity: f64,
    /// Void fraction at the centres, none for a single phase.
    pub void_fraction: Option<&'a [f64]>,
    pub advection: Advection,
}

/// Row (j, k) of a component's faces.
#[derive(Clone, Copy)]
pub(crate) struct RowPlace {
    pub component: usize,
    pub j: usize,
    pub k: usize,
}

impl Explicit<'_> {
    /// ∇·(εu u) and ν ∇·(ε ∇u) of a row; both buffers are as long as the row has unknowns.
    pub fn row(&self, place: RowPlace, advective: &mut [f64], viscous: &mut [f64]) {
        advective.fill(0.0);
        viscous.fill(0.0);
        match self.advection {
            Advection::Central => self.row_with(place, advective, viscous, central),
            Advection::VanLeer => self.row_with(place, advective, viscous, van_leer),
        }
    }

    fn row_with(
        &self,
        place: RowPlace,
        advective: &mut [f64],
        viscous: &mut [f64],
        scheme: impl Fn(f64, [f64; 4]) -> f64 + Copy,
    ) {
        for b in (0..3).filter(|&b| self.local.active[b]) {
            let pair = Pair::new(self, place, b, advective.len());
            let out = (&mut *advective, &mut *viscous);
            match self.void_fraction {
                None => pair.add(out, scheme, |_| 1.0, |_| 1.0),
                Some(eps) if b == place.component => {
                    let (here, next) = (pair.at(eps, 0), pair.at(eps, pair.along as isize));
                    pair.add(out, scheme, |i| here[i], |i| next[i]);
                }
                Some(eps) => {
                    let (sa, sb) = (pair.along as isize, pair.across as isize);
                    let [e0, ea, eb, eab] = [0, sa, sb, sa + sb].map(|o| pair.at(eps, o));
                    let [em, eam] = [-sb, sa - sb].map(|o| pair.at(eps, o));
                    pair.add(
                        out,
                        scheme,
                        |i| 0.25 * (e0[i] + ea[i] + em[i] + eam[i]),
                        |i| 0.25 * (e0[i] + ea[i] + eb[i] + eab[i]),
                    );
                }
            }
        }
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

    /// Adds the terms; `eps_low`, `eps_high` are the void fractions on the two faces of the control volume.
    #[inline(always)]
    fn add(
        &self,
        out: (&mut [f64], &mut [f64]),
        scheme: impl Fn(f64, [f64; 4]) -> f64 + Copy,
        eps_low: impl Fn(usize) -> f64,
        eps_high: impl Fn(usize) -> f64,
    ) {
        let (a, b, h, n) = (self.component, self.b, self.terms.local.layout.halo, self.length);
        let axes = &self.terms.local.axes;
        let window = |data: &'a [f64], offset: usize| &data[h + offset - 1..][..n];
        if a == b {
            let m = &axes[a];
            if a == 0 {
                let (inverse, low, high) = (
                    window(&m.inverse_distance, 1),
                    window(&m.inverse_width, 1),
                    window(&m.inverse_width, 2),
                );
                self.own(out, scheme, |i| inverse[i], |i| low[i] * eps_low(i), |i| high[i] * eps_high(i));
            } else {
                let e = self.entry(a);
                let (inverse, low, high) =
                    (m.inverse_distance[e], m.inverse_width[e], m.inverse_width[e + 1]);
                self.own(out, scheme, |_| inverse, |i| low * eps_low(i), |i| high * eps_high(i));
            }
        } else if a == 0 {
            let (wl, wh) = (window(&axes[0].lower_share, 1), window(&axes[0].upper_share, 1));
            let (m, e) = (&axes[b], self.entry(b));
            let (inverse, low, high) = (m.inverse_width[e], m.inverse_distance[e - 1], m.inverse_distance[e]);
            let shares = |i: usize| [wl[i], wh[i]];
            self.cross(out, scheme, shares, |_| inverse, |i| low * eps_low(i), |i| high * eps_high(i));
        } else {
            let e = self.entry(a);
            let share = [axes[a].lower_share[e], axes[a].upper_share[e]];
            let m = &axes[b];
            if b == 0 {
                let (inverse, low, high) = (
                    window(&m.inverse_width, 1),
                    window(&m.inverse_distance, 0),
                    window(&m.inverse_distance, 1),
                );
                let (low, high) = (|i: usize| low[i] * eps_low(i), |i: usize| high[i] * eps_high(i));
                self.cross(out, scheme, |_| share, |i| inverse[i], low, high);
            } else {
                let e = self.entry(b);
                let (inverse, low, high) =
                    (m.inverse_width[e], m.inverse_distance[e - 1], m.inverse_distance[e]);
                self.cross(out, scheme, |_| share, |_| inverse, |i| low * eps_low(i), |i| high * eps_high(i));
            }
        }
    }

    /// Through the faces normal to the component: the centres of the cells.
    #[inline(always)]
    fn own(
        &self,
        (advective, viscous): (&mut [f64], &mut [f64]),
        scheme: impl Fn(f64, [f64; 4]) -> f64,
        inverse: impl Fn(usize) -> f64,
        low: impl Fn(usize) -> f64,
        high: impl Fn(usize) -> f64,
    ) {
        let (s, nu) = (self.along as isize, self.terms.viscosity);
        let [u0, u1, u2, u3, u4] = [-2 * s, -s, 0, s, 2 * s].map(|o| self.at(self.terms.velocity[self.b], o));
        let [q1, q2, q3] = [-s, 0, s].map(|o| self.at(self.terms.flux[self.b], o));
        let (advective, viscous) = (&mut advective[..self.length], &mut viscous[..self.length]);
        for i in 0..self.length {
            let (m_high, m_low) = (0.5 * (q2[i] + q3[i]), 0.5 * (q1[i] + q2[i]));
            let f_high = m_high * scheme(m_high, [u1[i], u2[i], u3[i], u4[i]]);
            let f_low = m_low * scheme(m_low, [u0[i], u1[i], u2[i], u3[i]]);
            advective[i] += (f_high - f_low) * inverse(i);
            viscous[i] += nu * ((u3[i] - u2[i]) * high(i) - (u2[i] - u1[i]) * low(i)) * inverse(i);
        }
    }

    /// Through the faces parallel to the component: the edges of the cells.
    #[inline(always)]
    fn cross(
        &self,
        (advective, viscous): (&mut [f64], &mut [f64]),
        scheme: impl Fn(f64, [f64; 4]) -> f64,
        shares: impl Fn(usize) -> [f64; 2],
        inverse: impl Fn(usize) -> f64,
        low: impl Fn(usize) -> f64,
        high: impl Fn(usize) -> f64,
    ) {
        let (sa, sb, nu) = (self.along as isize, self.across as isize, self.terms.viscosity);
        let velocity = self.terms.velocity[self.component];
        let [u0, u1, u2, u3, u4] = [-2 * sb, -sb, 0, sb, 2 * sb].map(|o| self.at(velocity, o));
        let [q0, q1, q2, q3] = [0, sa, -sb, sa - sb].map(|o| self.at(self.terms.flux[self.b], o));
        let (advective, viscous) = (&mut advective[..self.length], &mut viscous[..self.length]);
        for i in 0..self.length {
            let [wl, wh] = shares(i);
            let (m_high, m_low) = (wl * q0[i] + wh * q1[i], wl * q2[i] + wh * q3[i]);
            let f_high = m_high * scheme(m_high, [u1[i], u2[i], u3[i], u4[i]]);
            let f_low = m_low * scheme(m_low, [u0[i], u1[i], u2[i], u3[i]]);
            advective[i] += (f_high - f_low) * inverse(i);
            viscous[i] += nu * ((u3[i] - u2[i]) * high(i) - (u2[i] - u1[i]) * low(i)) * inverse(i);
        }
    }
}

/// The transposed half of the viscous stress, ν ∇·(ε (∇u)ᵀ), which vanishes only where ε is uniform.
pub(crate) struct Transposed<'a> {
    pub local: &'a Local,
    pub velocity: [&'a [f64]; 3],
    pub viscosity: f64,
    pub void_fraction: &'a [f64],
}

impl Transposed<'_> {
    /// Takes the term of a row off `advective`.
    pub fn subtract_row(&self, place: RowPlace, advective: &mut [f64]) {
        let (layout, a) = (self.local.layout, place.component);
        let (strides, start) = (layout.strides(), layout.row(place.j, place.k));
        let (sa, eps, h) = (strides[a], self.void_fraction, layout.halo);
        let entry = |axis: usize, i: usize| match axis {
            0 => i + h,
            1 => place.j + h,
            _ => place.k + h,
        };
        for b in (0..3).filter(|&b| self.local.active[b]) {
            let (sb, u) = (strides[b], self.velocity[b]);
            for (i, value) in advective.iter_mut().enumerate() {
                let (p, ea, eb) = (start + i, entry(a, i), entry(b, i));
                let (ma, mb) = (&self.local.axes[a], &self.local.axes[b]);
                let term = if a == b {
                    let stress = |p: usize, e: usize| eps[p] * (u[p] - u[p - sa]) * ma.inverse_width[e];
                    (stress(p + sa, ea + 1) - stress(p, ea)) * ma.inverse_distance[ea]
                } else {
                    let stress = |p: usize| {
                        let mean = 0.25 * (eps[p] + eps[p + sa] + eps[p + sb] + eps[p + sa + sb]);
                        mean * (u[p + sa] - u[p]) * ma.inverse_distance[ea]
                    };
                    (stress(p) - stress(p - sb)) * mb.inverse_width[eb]
                };
                *value -= self.viscosity * term;
            }
        }
    }
}
