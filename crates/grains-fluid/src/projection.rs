//! Divergence of the predicted velocity, and its removal.

use crate::boundary::{BoundaryData, Kind};
use crate::metrics::Local;
use crate::mixture::Mixture;
use crate::mixture_model::MixtureModel;
use crate::{Centre, Faces, Field};
use multiversion::multiversion;

/// f = Σ_faces ± A ε u + V ∂ε/∂t of every own cell (m³/s); returns its sum and that of the fluxes' sizes.
///
/// `porous` holds ε on the faces and ∂ε/∂t at the centres; none where ε = 1.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
pub(crate) fn divergence(
    local: &Local,
    velocity: &Faces,
    porous: Option<([&[f64]; 3], &[f64])>,
    rhs: &mut Field<Centre>,
) -> [f64; 2] {
    let (layout, strides) = (local.layout, local.layout.strides());
    let [nx, ny, nz] = layout.cells;
    let widths = local.row_widths();
    let (mut sum, mut size) = (0.0, 0.0);
    for k in 0..nz {
        for j in 0..ny {
            let start = layout.row(j, k);
            let (wy, wz) = (local.axes[1].width[local.entry(j)], local.axes[2].width[local.entry(k)]);
            let row = &mut rhs.data_mut()[start..][..nx];
            match porous {
                None => row.fill(0.0),
                Some((_, rate)) => {
                    let cells = row.iter_mut().zip(&rate[start..][..nx]).zip(widths);
                    cells.for_each(|((f, rate), width)| *f = rate * width * wy * wz);
                }
            }
            for axis in (0..3).filter(|&a| local.active[a]) {
                let (u, s) = (velocity.component(axis), strides[axis]);
                let (high, low) = (&u[start..][..nx], &u[start - s..][..nx]);
                let areas = |i: usize| [wy * wz, widths[i] * wz, widths[i] * wy][axis];
                match porous {
                    None => {
                        for i in 0..nx {
                            row[i] += areas(i) * (high[i] - low[i]);
                        }
                    }
                    Some((eps, _)) => {
                        let (e_high, e_low) = (&eps[axis][start..][..nx], &eps[axis][start - s..][..nx]);
                        for i in 0..nx {
                            row[i] += areas(i) * (e_high[i] * high[i] - e_low[i] * low[i]);
                        }
                    }
                }
                size += match axis {
                    0 => wy * wz * weighted_sum(high, None, f64::abs),
                    1 => wz * weighted_sum(high, Some(widths), f64::abs),
                    _ => wy * weighted_sum(high, Some(widths), f64::abs),
                };
            }
            sum += weighted_sum(row, None, |f| f);
        }
    }
    [sum, size]
}

/// Adds ∫∇·c of a one-phase flow to the right-hand side, c (m/s) what passes the faces beyond the velocity; returns its sum over the
/// own cells and Σ |c| over their upper faces (m³/s).
pub(crate) fn add_divergence(local: &Local, passing: &Faces, rhs: &mut Field<Centre>) -> [f64; 2] {
    let (layout, strides, widths) = (local.layout, local.layout.strides(), local.row_widths());
    let [nx, ny, nz] = layout.cells;
    let mut sums = [0.0; 2];
    for k in 0..nz {
        for j in 0..ny {
            let start = layout.row(j, k);
            let (wy, wz) = (local.axes[1].width[local.entry(j)], local.axes[2].width[local.entry(k)]);
            let row = &mut rhs.data_mut()[start..][..nx];
            for axis in (0..3).filter(|&a| local.active[a]) {
                let c = passing.component(axis);
                let (high, low) = (&c[start..][..nx], &c[start - strides[axis]..][..nx]);
                for i in 0..nx {
                    let area = [wy * wz, widths[i] * wz, widths[i] * wy][axis];
                    let through = area * (high[i] - low[i]);
                    row[i] += through;
                    sums[0] += through;
                    sums[1] += area * high[i].abs();
                }
            }
        }
    }
    sums
}

/// Partial sums kept apart, so that additions need not wait for one another.
const LANES: usize = 8;

/// Σ w f(x), w = 1 if none are given.
#[inline(always)]
fn weighted_sum(values: &[f64], weights: Option<&[f64]>, f: impl Fn(f64) -> f64) -> f64 {
    let mut lanes = [0.0; LANES];
    let whole = values.len() / LANES * LANES;
    let weight = |i: usize| weights.map_or(1.0, |w| w[i]);
    for first in (0..whole).step_by(LANES) {
        let chunk = &values[first..first + LANES];
        match weights {
            None => lanes.iter_mut().zip(chunk).for_each(|(lane, x)| *lane += f(*x)),
            Some(w) => {
                let w = &w[first..first + LANES];
                lanes.iter_mut().zip(chunk).zip(w).for_each(|((lane, x), w)| *lane += w * f(*x));
            }
        }
    }
    let rest: f64 = (whole..values.len()).map(|i| weight(i) * f(values[i])).sum();
    lanes.iter().sum::<f64>() + rest
}

/// What drives a row of faces: pressures below and above, the inverse distances between them (one for all, or one for
/// each), and a force besides (Pa/m).
pub(crate) struct ForceRow<'a> {
    pub pressures: [&'a [f64]; 2],
    pub distances: &'a [f64],
    pub drive: f64,
}

impl ForceRow<'_> {
    /// Adds the force less the pressure gradient, times the factor of the pressure gradient, to a row of velocities.
    #[inline(always)]
    pub fn add(&self, out: &mut [f64], gradient_factor: impl Fn(usize) -> f64) {
        let n = out.len();
        let ([below, above], drive) = (self.pressures.map(|p| &p[..n]), self.drive);
        match self.distances {
            [distance] => {
                for i in 0..n {
                    out[i] += gradient_factor(i) * (drive - (above[i] - below[i]) * distance);
                }
            }
            distances => {
                let distances = &distances[..n];
                for i in 0..n {
                    out[i] += gradient_factor(i) * (drive - (above[i] - below[i]) * distances[i]);
                }
            }
        }
    }
}

/// What the solved potential φ does to velocity and pressure.
pub(crate) struct Correction<'a> {
    pub local: &'a Local,
    /// φ with ghosts: Pa for mixtures, else φ Δt/ρ (m²/s).
    pub potential: &'a [f64],
    pub coefficients: Option<&'a Mixture>,
    /// Pa per unit of φ.
    pub scale: f64,
    /// Dynamic viscosity of implicit diffusion (Pa s), zero if explicit.
    pub viscosity: f64,
}

impl Correction<'_> {
    /// What multiplies ∇φ on a face.
    fn gradient_factor(&self, component: usize, p: usize) -> f64 {
        self.coefficients.map_or(1.0, |m| m.gradient_factor.component(component)[p])
    }

    /// Corrects all faces but those of the box.
    pub fn velocity(&self, velocity: &mut Faces) {
        correct_velocity(self, velocity);
    }

    /// Corrects the normal velocities of outlets.
    pub fn outlets(&self, boundary_data: &[BoundaryData], velocity: &mut Faces) {
        let layout = self.local.layout;
        for face_data in boundary_data.iter().filter(|t| t.has_outlet) {
            let axis = face_data.face.axis;
            let outward = face_data.face.outward();
            let step = outward as isize * layout.strides()[axis] as isize;
            let cell = if outward > 0.0 { layout.cells[axis] - 1 } else { 0 };
            let inverse = self.local.axes[axis].inverse_width[self.local.entry(cell)];
            for m2 in layout.halo..face_data.extents[1] - layout.halo {
                for m1 in layout.halo..face_data.extents[0] - layout.halo {
                    if face_data.kinds[axis][m2 * face_data.extents[0] + m1] == Kind::Free {
                        let inside = face_data.inside(layout, m1, m2);
                        let b = face_data.boundary(layout, inside);
                        let rise = self.potential[(inside as isize + step) as usize] - self.potential[inside];
                        velocity.component_mut(axis)[b] -=
                            self.gradient_factor(axis, b) * outward * rise * inverse;
                    }
                }
            }
        }
    }

    /// Adds φ to the pressure, less what the implicit diffusion of ∇φ took.
    pub fn pressure(&self, rhs: &Field<Centre>, pressure: &mut Field<Centre>) {
        let layout = self.local.layout;
        let [nx, ny, nz] = layout.cells;
        let inverse_widths = &self.local.axes[0].inverse_width[layout.halo..][..nx];
        for k in 0..nz {
            for j in 0..ny {
                let start = layout.row(j, k);
                let [y, z] =
                    [(1, j), (2, k)].map(|(a, m)| self.local.axes[a].inverse_width[self.local.entry(m)]);
                let half = 0.5 * self.viscosity * y * z;
                let row = &mut pressure.data_mut()[start..][..nx];
                let (potential, f) = (&self.potential[start..][..nx], &rhs.data()[start..][..nx]);
                match self.coefficients {
                    // Diffusion weighs ε, and so does the pressure gradient of model A.
                    Some(mixture) if mixture.model == MixtureModel::A => {
                        let eps = &mixture.middle.data()[start..][..nx];
                        for i in 0..nx {
                            row[i] += self.scale * potential[i]
                                - half * inverse_widths[i] * f[i] / eps[i].max(f64::MIN_POSITIVE);
                        }
                    }
                    _ => {
                        for i in 0..nx {
                            row[i] += self.scale * potential[i] - half * inverse_widths[i] * f[i];
                        }
                    }
                }
            }
        }
    }
}

/// See [`Correction::velocity`].
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn correct_velocity(correction: &Correction<'_>, velocity: &mut Faces) {
    let (layout, strides) = (correction.local.layout, correction.local.layout.strides());
    for component in 0..3 {
        let n = correction.local.unknowns(component);
        let distances = &correction.local.axes[component].inverse_distance;
        for k in 0..n[2] {
            for j in 0..n[1] {
                let start = layout.row(j, k);
                let here = &correction.potential[start..][..n[0]];
                let next = &correction.potential[start + strides[component]..][..n[0]];
                let row = &mut velocity.component_mut(component)[start..][..n[0]];
                let e = correction.local.entry([0, j, k][component]);
                let distances = &distances[e..][..if component == 0 { n[0] } else { 1 }];
                let force = ForceRow { pressures: [here, next], distances, drive: 0.0 };
                match correction.coefficients {
                    None => force.add(row, |_| 1.0),
                    Some(mixture) => {
                        let gradient_factor = &mixture.gradient_factor.component(component)[start..][..n[0]];
                        force.add(row, |i| gradient_factor[i]);
                    }
                }
            }
        }
    }
}
