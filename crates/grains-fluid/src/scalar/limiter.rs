//! Flux correction: what of the difference of high and low order each face may pass on (Zalesak 1979).

use super::advance::{CarrierFlow, for_faces, own_cells};
use super::solids::Barrier;
use super::{Scalar, Work};
use grains_domain::Transport;

/// Adds to the value of low order what keeps it within that of its neighbours, before the step and of low order; returns what of
/// the high order was refused at the faces of the box (unit m³/s, positive inwards). Collective.
pub(super) fn limit(
    work: &mut Work,
    (scalar, mut barrier): (&mut Scalar, Option<&mut Barrier>),
    carrier: &mut CarrierFlow<'_>,
    transport: &dyn Transport,
) -> f64 {
    let local = carrier.local;
    let (layout, strides) = (local.layout, local.layout.strides());
    let active = (0..3).filter(|&a| local.active[a]);
    for face in &scalar.conditions {
        face.set_beyond(scalar.value.data_mut(), strides);
        face.set_beyond(work.low.data_mut(), strides);
    }
    let (value, low, mass) = (scalar.value.data(), work.low.data_mut(), &work.mass);
    let [gains, losses] = &mut work.shares;
    for p in own_cells(layout) {
        let (mut range, mut wanted) = ([value[p].min(low[p]), value[p].max(low[p])], [0.0; 2]);
        for a in active.clone() {
            let (stride, correction) = (strides[a], work.high.component(a));
            for q in [p - stride, p + stride] {
                range = [range[0].min(value[q]).min(low[q]), range[1].max(value[q]).max(low[q])];
            }
            for inflow in [correction[p - stride], -correction[p]] {
                wanted = [wanted[0] + inflow.max(0.0), wanted[1] - inflow.min(0.0)];
            }
        }
        let share =
            |room: f64, wanted: f64| if wanted > 0.0 { (room * mass[p] / wanted).min(1.0) } else { 1.0 };
        if barrier.as_ref().is_some_and(|barrier| !barrier.is_free(p)) {
            (gains[p], losses[p]) = (1.0, 1.0);
            continue;
        }
        gains[p] = share(range[1] - low[p], wanted[0]);
        losses[p] = share(low[p] - range[0], wanted[1]);
    }
    for face in &scalar.conditions {
        for cell in &face.cells {
            let beyond = face.beyond(cell, strides);
            (gains[beyond], losses[beyond]) = (1.0, 1.0);
        }
    }
    carrier.halo.fill_to(1, &mut [gains.as_mut_slice(), losses.as_mut_slice()], transport);
    let mut refused = 0.0;
    for a in active {
        let (stride, correction) = (strides[a], work.high.component_mut(a));
        for face in scalar.conditions.iter().filter(|face| face.axis == a) {
            refused += face.entering(correction);
        }
        if let Some(barrier) = &mut barrier {
            barrier.ties[a].iter_mut().for_each(|tie| tie.carried -= correction[tie.face]);
        }
        for_faces(local, a, |p, _, _| {
            let (here, next) = (p, p + stride);
            let share = match correction[p] >= 0.0 {
                true => losses[here].min(gains[next]),
                false => gains[here].min(losses[next]),
            };
            correction[p] *= share;
        });
        if let Some(barrier) = &mut barrier {
            barrier.ties[a].iter_mut().for_each(|tie| tie.carried += correction[tie.face]);
        }
        for face in scalar.conditions.iter().filter(|face| face.axis == a) {
            refused -= face.entering(correction);
        }
        for p in own_cells(layout) {
            if mass[p] > 0.0 {
                low[p] -= (correction[p] - correction[p - stride]) / mass[p];
            }
        }
    }
    refused
}
