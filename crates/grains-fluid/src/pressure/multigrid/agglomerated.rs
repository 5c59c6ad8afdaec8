//! The coarsest problem of several ranks: the cells of all ranks gathered on each, and a multigrid over them.

use super::dense::{Dense, SOLVED_DIRECTLY};
use super::hierarchy::Hierarchy;
use super::level::Level;
use crate::CellPartition;
use grains_domain::{SerialTransport, Transport};

/// The cells of all ranks on every rank, and a multigrid over them.
pub(crate) struct Agglomerated {
    inner: Hierarchy,
    dense: Dense,
    /// Place in the inner arrays of every cell as the ranks send them, and the own ones among them.
    places: Vec<usize>,
    own: std::ops::Range<usize>,
    sent: Vec<f64>,
}

impl Agglomerated {
    /// Of a level whose cells are shared among ranks.
    pub fn new(level: &Level, is_singular: bool, imposed: [[bool; 2]; 3]) -> Self {
        let (grid, partition) = (&level.grid, &level.partition);
        let inner = Hierarchy::new(grid, &CellPartition::serial(grid), SOLVED_DIRECTLY, imposed);
        let dense = Dense::new(inner.coarsest(), is_singular);
        let (layout, [px, py, pz]) = (inner.finest().operator.layout(), partition.ranks);
        let (mut places, mut own) = (Vec::new(), 0..0);
        for rank in 0..px * py * pz {
            let at = [rank % px, rank / px % py, rank / (px * py)];
            let [x, y, z] = [0, 1, 2].map(|a| partition.starts[a][at[a]]..partition.starts[a][at[a] + 1]);
            let begin = places.len();
            for k in z {
                for j in y.clone() {
                    places.extend(x.clone().map(|i| layout.row(j, k) + i));
                }
            }
            if at == partition.coordinates {
                own = begin..places.len();
            }
        }
        Self { inner, dense, places, own, sent: Vec::new() }
    }

    /// Takes the conductances of a level; collective.
    pub fn set(&mut self, level: &Level, transport: &dyn Transport) {
        let operator = &level.operator;
        let (layout, strides) = (operator.layout(), operator.layout().strides());
        let inner_strides = self.inner.finest().operator.layout().strides();
        for axis in 0..3 {
            let from = operator.conductances.component(axis);
            let own = layout.rows().flat_map(|start| start..start + layout.cells[0]);
            self.sent.clear();
            self.sent.extend(own.flat_map(|p| [from[p - strides[axis]], from[p]]));
            let all = transport.gather(&self.sent);
            let to = self.inner.finest_mut().operator.conductances.component_mut(axis);
            for (&p, faces) in self.places.iter().zip(all.as_chunks::<2>().0) {
                to[p - inner_strides[axis]] = faces[0];
                to[p] = faces[1];
            }
        }
        self.inner.finest_mut().operator.set_diagonal();
        self.inner.refresh();
        self.dense.set(self.inner.coarsest());
    }

    /// One cycle for the right-hand side of a level; collective.
    pub fn solve(&mut self, level: &mut Level, transport: &dyn Transport) {
        let (layout, nx) = (level.operator.layout(), level.operator.layout().cells[0]);
        self.sent.clear();
        for start in layout.rows() {
            self.sent.extend_from_slice(&level.rhs.data()[start..start + nx]);
        }
        let all = transport.gather(&self.sent);
        let rhs = self.inner.finest_mut().rhs.data_mut();
        self.places.iter().zip(&all).for_each(|(&p, value)| rhs[p] = *value);
        self.inner.cycle(&SerialTransport, |coarsest| self.dense.solve(coarsest));
        let solution = self.inner.finest().solution.data();
        let own = layout.rows().flat_map(|start| start..start + nx);
        for (p, &place) in own.zip(&self.places[self.own.clone()]) {
            level.solution.data_mut()[p] = solution[place];
        }
    }
}
