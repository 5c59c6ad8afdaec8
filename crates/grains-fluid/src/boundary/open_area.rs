//! Profiles whose size depends on the area that patches and walls leave open.

use super::data::BoundaryData;
use super::{Boundaries, Condition, Profile};
use crate::metrics::Local;
use crate::openings::Openings;
use grains_domain::Transport;

impl BoundaryData {
    /// Takes what walls leave open of the inlets, and sizes parabolas and flow rates to it, on all faces; collective if there are
    /// such. To be called before imposed velocities are evaluated, and when walls have moved.
    ///
    /// Of a face of a cell of which walls leave a share o open and inlets cover a share s, fluid flows through min(s, o): the
    /// edges of an inlet and of the tube it feeds are one line. The velocity u on the open part then carries
    /// o A m Σ sₖ uₖ with m = min(s, o)/(s o).
    ///
    /// Returns the number of a condition that states a flow rate through nothing.
    pub fn weigh(
        all: &mut [BoundaryData],
        (local, boundaries): (&Local, &Boundaries),
        openings: Option<&Openings>,
        transport: &dyn Transport,
    ) -> Option<usize> {
        if let Some(openings) = openings {
            all.iter_mut().for_each(|face_data| face_data.mask(local, boundaries, openings));
        }
        let profile = |number: usize| match boundaries.condition(number) {
            Condition::Inlet { profile } if profile.is_of_open_area() => Some(profile),
            _ => None,
        };
        let count = boundaries.conditions().count();
        if (0..count).all(|number| profile(number).is_none()) {
            return None;
        }
        // Open area of each (m²), and the integral of its parabola over that.
        let mut sums = vec![[0.0; 2]; count];
        for face_data in all.iter() {
            for (e, m) in face_data.own_entries(local.layout) {
                let open = openings.map_or(1.0, |openings| face_data.open_share(local, openings, m));
                let area = face_data.area(local, m) * open * face_data.masks[e];
                for piece in face_data.pieces_of(e) {
                    let [open, flow] = &mut sums[piece.condition];
                    *open += area * piece.share;
                    *flow += area * piece.share * piece.parabola;
                }
            }
        }
        transport.sum(sums.as_flattened_mut());
        let mut covered = None;
        for (number, [open, flow]) in sums.into_iter().enumerate() {
            let scale = match profile(number) {
                None => continue,
                Some(_) if flow == 0.0 => 0.0,
                Some(Profile::FlowRate { .. }) => 1.0 / flow,
                Some(_) => open / flow,
            };
            if flow == 0.0 && matches!(profile(number), Some(Profile::FlowRate { .. })) {
                covered.get_or_insert(number);
            }
            all.iter_mut().for_each(|face_data| face_data.scales[number] = scale);
        }
        covered
    }

    fn mask(&mut self, local: &Local, boundaries: &Boundaries, openings: &Openings) {
        for (e, m) in self.entries() {
            let is_inlet = |number| matches!(boundaries.condition(number), Condition::Inlet { .. });
            let pieces = self.pieces_of(e).iter().filter(|piece| is_inlet(piece.condition));
            let covered: f64 = pieces.map(|piece| piece.share).sum();
            let open = self.open_share(local, openings, m);
            self.masks[e] =
                if covered > 0.0 && open > 0.0 { covered.min(open) / (covered * open) } else { 1.0 };
        }
    }

    /// What walls leave open of the face of a cell (-).
    fn open_share(&self, local: &Local, openings: &Openings, [m1, m2]: [usize; 2]) -> f64 {
        let face = self.boundary(local.layout, self.inside(local.layout, m1, m2));
        openings.faces.component(self.face.axis)[face]
    }
}
