//! Normal velocity of outlets and pressure inlets: its own momentum equation, explicit, on the face.

use super::StressWeights;
use crate::boundary::{BoundaryData, Kind};
use crate::metrics::Local;

/// Fields the equation of an outlet is made of; all halos filled.
pub(crate) struct OutletTerms<'a> {
    pub local: &'a Local,
    pub velocity: [&'a [f64]; 3],
    pub flux: [&'a [f64]; 3],
    /// Pressure over density, with ghosts (m²/s²).
    pub pressure: &'a [f64],
    pub inverse_density: f64,
    pub viscosity: f64,
    /// Weights of the stresses where the viscosity varies.
    pub stress_weights: Option<StressWeights<'a>>,
    /// Per face of the axis: ε on the face, factor of the pressure gradient, diagonal (1/s), source (m/s²) and
    /// what multiplies u of the old step (1/s).
    pub face: &'a dyn Fn(usize, usize) -> FaceTerms,
    /// Adams–Bashforth weights of the new and the old advective term.
    pub weights: [f64; 2],
}

/// Local coefficients of one outlet face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceTerms {
    pub void_fraction: f64,
    pub gradient: f64,
    pub diagonal: f64,
    pub source: f64,
    pub friction: f64,
}

/// By how much of the diagonal of its viscous term a face resists a change (-). 1 would turn the sign of what changes from face to
/// face in long steps, and with the implicit diffusion beside it that grows.
const DAMPING: f64 = 2.0;

/// Sets the increments of the normal velocities of outlets, and their new advective terms.
///
/// The tangential and normal viscous terms enter by twice their diagonal: unconditionally stable, first order in time
/// on this face only. Fluid that comes in through an outlet carries no momentum.
pub(crate) fn advance_outlets(
    boundary_data: &[BoundaryData],
    terms: &OutletTerms<'_>,
    increments: &mut [&mut [f64]; 3],
    advective: &mut [&mut [f64]; 3],
) {
    let layout = terms.local.layout;
    for face_data in boundary_data.iter().filter(|t| t.has_outlet) {
        let axis = face_data.face.axis;
        for m2 in layout.halo..face_data.extents[1] - layout.halo {
            for m1 in layout.halo..face_data.extents[0] - layout.halo {
                if face_data.kinds[axis][m2 * face_data.extents[0] + m1] != Kind::Free {
                    continue;
                }
                let inside = face_data.inside(layout, m1, m2);
                let b = face_data.boundary(layout, inside);
                let face = (terms.face)(axis, b);
                let (advection, viscous, damping) =
                    face_balance(face_data, terms, [m1, m2], face.void_fraction);
                let step = face_data.face.outward() as isize * layout.strides()[axis] as isize;
                let e = terms.local.entry(if step > 0 { layout.cells[axis] - 1 } else { 0 });
                let rise = terms.pressure[(inside as isize + step) as usize] - terms.pressure[inside];
                let gradient = face_data.face.outward() * rise * terms.local.axes[axis].inverse_width[e];
                // In pseudo-time none are kept.
                let kept = advective[axis].get_mut(b);
                let old = kept.map_or(0.0, |kept| std::mem::replace(kept, advection));
                let force = viscous + face.source
                    - terms.weights[0] * advection
                    - terms.weights[1] * old
                    - face.gradient * gradient * terms.inverse_density
                    - face.friction * terms.velocity[axis][b];
                increments[axis][b] = force / (face.diagonal + DAMPING * damping);
            }
        }
    }
}

/// Advective and viscous term of one outlet face and the diagonal of the viscous one.
fn face_balance(
    face_data: &BoundaryData,
    terms: &OutletTerms<'_>,
    m: [usize; 2],
    eps: f64,
) -> (f64, f64, f64) {
    let (local, layout, axis) = (terms.local, terms.local.layout, face_data.face.axis);
    let (u, q, strides) = (terms.velocity[axis], terms.flux[axis], layout.strides());
    let inside = face_data.inside(layout, m[0], m[1]);
    let b = face_data.boundary(layout, inside);
    let outward = face_data.face.outward();
    let inner = (b as isize - outward as isize * strides[axis] as isize) as usize;
    let e = local.entry(if outward > 0.0 { layout.cells[axis] - 1 } else { 0 });
    let inverse = local.axes[axis].inverse_width[e];
    let e_face = m[1] * face_data.extents[0] + m[0];
    let carries = outward * q[b] > 0.0 || face_data.brings_momentum(e_face);
    let flux_out = if carries { q[b] * u[b] } else { 0.0 };
    let flux_in = 0.25 * (q[b] + q[inner]) * (u[b] + u[inner]);
    let mut advection = outward * (flux_out - flux_in) * inverse;
    let nu = terms.viscosity * terms.stress_weights.map_or(eps, |weights| weights.centres[axis][inside]);
    let mut viscous = -nu * (u[b] - u[inner]) * inverse * inverse;
    let mut damping = nu * inverse * inverse;
    for (t, place) in face_data.tangents.into_iter().zip(m).filter(|(t, _)| local.active[*t]) {
        let (s, axes) = (strides[t], &local.axes[t]);
        let flux = |face: usize, at: usize| terms.flux[t][face] * 0.5 * (u[at] + u[at + s]);
        advection += (flux(inside, b) - flux(inside - s, b - s)) * axes.inverse_width[place];
        let (low, high) = (axes.inverse_distance[place - 1], axes.inverse_distance[place]);
        if let Some(weights) = terms.stress_weights {
            let edges = weights.edges[axis][t];
            let (low, high) = (low * edges[b - s], high * edges[b]);
            viscous += ((u[b + s] - u[b]) * high - (u[b] - u[b - s]) * low)
                * terms.viscosity
                * axes.inverse_width[place];
            damping += terms.viscosity * (low + high) * axes.inverse_width[place];
            continue;
        }
        viscous += nu * ((u[b + s] - u[b]) * high - (u[b] - u[b - s]) * low) * axes.inverse_width[place];
        damping += nu * (low + high) * axes.inverse_width[place];
    }
    (advection, viscous, damping)
}
