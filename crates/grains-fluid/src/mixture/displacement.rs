//! What walls that move displace of the fluid, and where it goes.

use super::Mixture;
use crate::metrics::Local;
use grains_domain::Transport;

/// Open share (-) of cells that take what walls displace from those beside them.
const WIDE: f64 = 0.5;

impl Mixture {
    /// Hands ∂ψ/∂t of cells that walls close for the most part to those beside them that are mostly open, evenly: through the slits
    /// of a cell that a wall sweeps what it displaces would flow at any speed.
    pub(super) fn share_rates(&mut self, local: &Local) {
        let Some(openings) = &self.openings else { return };
        let (layout, strides, open) = (local.layout, local.layout.strides(), openings.cells.data());
        let place = |p: usize| [p % strides[1], p % strides[2] / strides[1], p / strides[2]];
        let volume = |p: usize| (0..3).map(|a| local.axes[a].width[place(p)[a]]).product::<f64>();
        let is_in_box = |p: usize| {
            let (place, h) = (place(p), layout.halo);
            (0..3).all(|a| {
                let [low, high] = local.ends[a];
                (!low || place[a] >= h) && (!high || place[a] < h + layout.cells[a])
            })
        };
        let beside = |p: usize| {
            let cells = strides.into_iter().flat_map(move |stride| [p - stride, p + stride]);
            cells.filter(|&q| is_in_box(q)).collect::<Vec<_>>().into_iter()
        };
        // What a cell needs to be handed something by one beside it.
        let wanted = |p: usize| {
            let largest = beside(p).map(|q| open[q]).fold(0.0, f64::max);
            if largest >= WIDE { WIDE } else { f64::MIN_POSITIVE }
        };
        let gives = |p: usize| {
            (open[p] == 0.0 && beside(p).any(|q| open[q] > 0.0))
                || (open[p] < WIDE && beside(p).any(|q| open[q] >= WIDE))
        };
        let mut rates = Vec::new();
        for p in layout.rows().flat_map(|row| row..row + layout.cells[0]) {
            let mut rate = if gives(p) { 0.0 } else { self.rate.data()[p] };
            for q in beside(p).filter(|&q| gives(q) && open[p] >= wanted(q)) {
                let receivers = beside(q).filter(|&r| open[r] >= wanted(q)).count();
                rate += self.rate.data()[q] * volume(q) / volume(p) / receivers as f64;
            }
            rates.push(rate);
        }
        let own = layout.rows().flat_map(|row| row..row + layout.cells[0]);
        own.zip(rates).for_each(|(p, rate)| self.rate.data_mut()[p] = rate);
    }

    /// Takes what walls that move seem to free or fill in a closed box, by rounding and by how they are sampled, evenly out of the
    /// rate of change; collective.
    pub(super) fn keep_volume(&mut self, local: &Local, transport: &dyn Transport) {
        let Some(openings) = &self.openings else { return };
        let [nx, ny, nz] = local.layout.cells;
        let cells =
            move || (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
        let place = |[i, j, k]: [usize; 3]| local.layout.row(j, k) + i;
        let mut sums = [0.0; 2];
        for cell in cells() {
            let (p, volume) = (place(cell), local.volume(cell));
            sums[0] += self.rate.data()[p] * volume;
            sums[1] += openings.cells.data()[p] * volume;
        }
        transport.sum(&mut sums);
        let excess = sums[0] / sums[1];
        let open = openings.cells.data();
        cells().map(place).for_each(|p| self.rate.data_mut()[p] -= excess * open[p]);
    }
}
