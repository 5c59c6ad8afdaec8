//! A coarse level of several ranks: the cells of each group of ranks on one of them, and a multigrid over these.

use super::hierarchy::Hierarchy;
use super::leaders::{Leaders, grouped, members};
use super::level::Level;
use crate::{CellPartition, Layout};
use grains_domain::Transport;

/// What a leader has of its group.
struct Gathered {
    hierarchy: Hierarchy,
    /// Places in the arrays of its finest level of the cells of each member, the own ones first.
    places: Vec<Vec<usize>>,
}

/// The way of a level's cells to the leaders of groups of ranks and back.
pub(crate) struct Agglomerated {
    /// The leader, or of a leader the other members.
    peers: Vec<usize>,
    /// Messages with the values of a member's cells.
    values: Vec<Vec<f64>>,
    /// Messages the other way, which are empty.
    nothing: Vec<Vec<f64>>,
    gathered: Option<Gathered>,
}

/// Array places of the own cells of a layout, x fastest.
fn own_cells(layout: Layout) -> impl Iterator<Item = usize> {
    layout.rows().flat_map(move |start| start..start + layout.cells[0])
}

/// Array places at the leader of the cells of a member at a place.
fn places_of(member: [usize; 3], partition: &CellPartition, layout: Layout, first: [usize; 3]) -> Vec<usize> {
    let [x, y, z] = [0, 1, 2].map(|a| {
        let starts = &partition.starts[a];
        starts[member[a]] - first[a]..starts[member[a] + 1] - first[a]
    });
    let rows = z.flat_map(|k| y.clone().map(move |j| layout.row(j, k)));
    rows.flat_map(|start| x.clone().map(move |i| start + i)).collect()
}

impl Agglomerated {
    /// Of a level whose cells `leaders` have, for groups of so many ranks along each axis.
    pub fn new(
        level: &Level,
        leaders: Leaders,
        group: [usize; 3],
        is_singular: bool,
        imposed: [[bool; 2]; 3],
    ) -> Self {
        let partition = &level.partition;
        let all = members(partition, group);
        let count = |member: [usize; 3]| -> usize {
            (0..3).map(|a| partition.starts[a][member[a] + 1] - partition.starts[a][member[a]]).product()
        };
        let is_leader = all[0] == partition.coordinates;
        let (others, sizes): (Vec<_>, Vec<_>) = match is_leader {
            true => (all[1..].to_vec(), all[1..].iter().map(|&member| count(member)).collect()),
            false => (vec![all[0]], vec![count(partition.coordinates)]),
        };
        let gathered = is_leader.then(|| {
            let of_groups = grouped(partition, group);
            let first = of_groups.first();
            let hierarchy =
                Hierarchy::new(&level.grid, &of_groups, leaders.of_groups(group), is_singular, imposed);
            let layout = hierarchy.finest().operator.layout();
            let places = all.iter().map(|&member| places_of(member, partition, layout, first)).collect();
            Gathered { hierarchy, places }
        });
        Self {
            peers: others.iter().map(|&member| leaders.rank(member)).collect(),
            values: sizes.iter().map(|&size| vec![0.0; size]).collect(),
            nothing: vec![Vec::new(); others.len()],
            gathered,
        }
    }

    /// Sends values of members to their leaders.
    fn gather(&mut self, transport: &dyn Transport) {
        let Self { peers, values, nothing, gathered } = self;
        match gathered {
            Some(_) => transport.exchange(peers, nothing, values),
            None => transport.exchange(peers, values, nothing),
        }
    }

    /// Sends values of leaders to their members.
    fn scatter(&mut self, transport: &dyn Transport) {
        let Self { peers, values, nothing, gathered } = self;
        match gathered {
            Some(_) => transport.exchange(peers, values, nothing),
            None => transport.exchange(peers, nothing, values),
        }
    }

    /// Takes the conductances of a level; its ranks do so together.
    pub fn set(&mut self, level: &Level, transport: &dyn Transport) {
        let (layout, strides) = (level.operator.layout(), level.operator.layout().strides());
        for axis in 0..3 {
            let from = &level.operator.conductances[axis];
            let mut faces = own_cells(layout).flat_map(|p| [from[p - strides[axis]], from[p]].map(f64::from));
            self.values.iter_mut().for_each(|message| message.resize(2 * message.len(), 0.0));
            if self.gathered.is_none() {
                self.values[0].iter_mut().zip(&mut faces).for_each(|(value, face)| *value = face);
            }
            self.gather(transport);
            if let Some(Gathered { hierarchy, places }) = &mut self.gathered {
                let operator = &mut hierarchy.finest_mut().operator;
                let stride = operator.layout().strides()[axis];
                let to = &mut operator.conductances[axis];
                let mut store = |places: &[usize], faces: &mut dyn Iterator<Item = f64>| {
                    for &p in places {
                        for face in [p - stride, p] {
                            to[face] = faces.next().unwrap_or(0.0) as f32;
                        }
                    }
                };
                store(&places[0], &mut faces);
                for (places, message) in places[1..].iter().zip(&self.values) {
                    store(places, &mut message.iter().copied());
                }
            }
            self.values.iter_mut().for_each(|message| message.truncate(message.len() / 2));
        }
        if let Some(Gathered { hierarchy, .. }) = &mut self.gathered {
            hierarchy.refresh(transport);
        }
    }

    /// One cycle for the right-hand side of a level; its ranks do so together.
    pub fn solve(&mut self, level: &mut Level, transport: &dyn Transport) {
        let layout = level.operator.layout();
        if self.gathered.is_none() {
            let rhs = level.rhs.data();
            self.values[0]
                .iter_mut()
                .zip(own_cells(layout))
                .for_each(|(value, p)| *value = f64::from(rhs[p]));
        }
        self.gather(transport);
        if let Some(Gathered { hierarchy, places }) = &mut self.gathered {
            let rhs = hierarchy.finest_mut().rhs.data_mut();
            places[0].iter().zip(level.rhs.own()).for_each(|(&p, value)| rhs[p] = value);
            for (places, message) in places[1..].iter().zip(&self.values) {
                places.iter().zip(message).for_each(|(&p, value)| rhs[p] = *value as f32);
            }
            hierarchy.cycle(transport);
            let solution = hierarchy.finest().solution.data();
            let own = level.solution.data_mut();
            own_cells(layout).zip(&places[0]).for_each(|(to, &p)| own[to] = solution[p]);
            for (places, message) in places[1..].iter().zip(&mut self.values) {
                message.iter_mut().zip(places).for_each(|(value, &p)| *value = f64::from(solution[p]));
            }
        }
        self.scatter(transport);
        if self.gathered.is_none() {
            let solution = level.solution.data_mut();
            own_cells(layout).zip(&self.values[0]).for_each(|(p, value)| solution[p] = *value as f32);
        }
    }
}
