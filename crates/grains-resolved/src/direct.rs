//! Direct forcing: the bodies' velocities from the balance of their momentum, the fluid's from them.

use crate::body::{component_at, others};
use crate::node::{AHEAD, Node, prefetch_at};
use crate::wall_load::Stresses;
use crate::{Action, BodyMotion, FlowOnWall, Resolved};
use grains_domain::Transport;
use grains_fluid::Flow;
use grains_geometry::Vec3;
use nalgebra::{Matrix6, Vector6};

impl Resolved {
    /// Gives free bodies their new velocities, and the fluid inside all bodies what results from them; collective.
    pub(crate) fn set_velocities(
        &mut self,
        motions: Option<&[BodyMotion]>,
        flow: &mut Flow,
        dt: f64,
        transport: &dyn Transport,
    ) -> Vec<Action> {
        if motions.is_some() || self.first_moved.is_some() {
            self.release(flow, dt);
            flow.refresh_velocity(self.subgrid.layout.halo, transport);
        }
        if let Some(motions) = motions {
            self.move_bodies((motions, |_| true), flow, dt, transport);
        }
        let mut actions = vec![[0.0; 12]; self.bodies.len()];
        let (density, volume) = (flow.setup.density, self.subgrid.cell_volume());
        let strides = self.subgrid.layout.strides();
        if let Some(immersed) = &mut flow.immersed {
            for component in (0..3).filter(|&c| self.subgrid.active[c]) {
                let velocity = flow.state.velocity.component_mut(component);
                let force = immersed.force.component_mut(component);
                let mut extrapolated =
                    immersed.extrapolated.as_mut().map(|extrapolated| &mut extrapolated[component]);
                extrapolated.iter_mut().for_each(|values| values.clear());
                let nodes = &self.nodes.of[component];
                // All are found before any is set: extrapolations may read each other's places.
                let mut arms = self.nodes.arms(component, &self.bodies, &self.subgrid);
                let mut wanted = |(number, node)| {
                    let later = nodes.get(number + AHEAD);
                    let interface = later.and_then(|node| self.nodes.interface(component, node));
                    interface.into_iter().for_each(|interface| interface.prefetch(velocity, strides));
                    self.wanted((component, node), || arms.to(number, node), velocity, strides)
                };
                let wanted: Vec<f64> = nodes.iter().enumerate().map(&mut wanted).collect();
                let [b, c] = others(component);
                let (mut arms, mut numbers) =
                    (self.nodes.arms(component, &self.bodies, &self.subgrid), 0..nodes.len());
                for (group, wanted) in of_bodies(nodes, &wanted) {
                    let (body, number) = (&self.bodies[group[0].body as usize], group[0].body as usize);
                    // Force and momentum beyond rigid motion: along the component, and about the two other axes.
                    let (mut whole, mut excess) = ([0.0; 3], [0.0; 3]);
                    let by_contacts = self.change_by_contacts(group[0].body);
                    for ((node, &wanted), number) in group.iter().zip(wanted).zip(&mut numbers) {
                        let (place, arm) = (node.place as usize, arms.to(number, node));
                        prefetch_at(nodes, number, [force, velocity]);
                        let f = force[place] + density / dt * (wanted - velocity[place]);
                        let of_contacts = by_contacts
                            .map_or(0.0, |change| density / dt * component_at(change, component, &arm));
                        force[place] = self.forcing.explicit * (f - of_contacts);
                        velocity[place] = wanted;
                        let differs = wanted - body.component_at(component, &arm);
                        if let Some(extrapolated) = extrapolated.as_mut().filter(|_| differs != 0.0) {
                            extrapolated.push((node.place, differs));
                        }
                        let row = [1.0, arm[c], -arm[b]];
                        for a in 0..3 {
                            whole[a] += row[a] * f;
                            excess[a] += row[a] * differs;
                        }
                    }
                    let action = &mut actions[number];
                    for (a, k) in [component, 3 + b, 3 + c].into_iter().enumerate() {
                        action[k] += volume * whole[a];
                        action[6 + k] += volume * density * excess[a];
                    }
                }
                for &(place, body) in &self.outlets[component] {
                    let (place, body) = (place as usize, &self.bodies[body as usize]);
                    let arm = self.subgrid.position(component, place) - body.center;
                    let wanted = body.component_at(component, &arm);
                    let f = force[place] + density / dt * (wanted - velocity[place]);
                    force[place] = self.forcing.explicit * f;
                    velocity[place] = wanted;
                }
                self.forced[component].clear();
                self.forced[component].extend(nodes.iter().map(|node| node.place as usize));
                self.forced[component]
                    .extend(self.outlets[component].iter().map(|(place, _)| *place as usize));
            }
        }
        flow.refresh_velocity(flow.layers_of_step(), transport);
        self.nodes.cut_faces.note(&self.bodies, &self.subgrid, flow, transport);
        self.note_walls(flow, transport);
        self.first_moved = None;
        actions.truncate(self.first_wall());
        self.ghosts.gather(&mut actions, &self.subgrid, transport);
        actions.iter().take(self.owned).map(Action::read).collect()
    }

    /// Finds what the flow does to the walls; collective.
    fn note_walls(&mut self, flow: &Flow, transport: &dyn Transport) {
        if self.walls.is_empty() {
            return;
        }
        let (first_wall, nodes) = (self.first_wall(), &self.nodes);
        let holder = |component: usize, place: usize| nodes.holder(component, place);
        let stresses = Stresses { flow, subgrid: &self.subgrid, holder: &holder, first_wall };
        for on_wall in &mut self.on_walls {
            *on_wall = FlowOnWall { wall: on_wall.wall, ..FlowOnWall::default() };
        }
        for component in (0..3).filter(|&c| self.subgrid.active[c]) {
            let (nodes, arms) = nodes.in_walls(component);
            for (node, arm) in nodes.iter().zip(arms).filter(|(node, _)| !node.is_deep()) {
                let wall = node.body as usize - first_wall;
                let place = node.place as usize;
                self.on_walls[wall].add(&self.walls[wall].body, (component, place), arm, &stresses);
            }
        }
        FlowOnWall::gather(&mut self.on_walls, transport);
    }

    /// The velocity that a body imposes on a node: that of its surface and the fluid's, or its own.
    #[inline]
    fn wanted(
        &self,
        (component, node): (usize, &Node),
        arm: impl FnOnce() -> Vec3,
        velocity: &[f64],
        strides: [usize; 3],
    ) -> f64 {
        let body = &self.bodies[node.body as usize];
        match self.nodes.interface(component, node) {
            None => body.component_at(component, &arm()),
            Some(interface) => {
                let surface = body.component_at(component, &interface.foot);
                let opposite = interface.opposite().map(|opposite| {
                    let body = &self.bodies[opposite.body as usize];
                    (opposite.weight, body.component_at(component, &opposite.foot))
                });
                interface.extrapolated(surface, opposite, velocity, strides)
            }
        }
    }

    /// Takes back the explicit force where no body is any more.
    fn release(&mut self, flow: &mut Flow, dt: f64) {
        let Some(immersed) = &mut flow.immersed else { return };
        let density = flow.setup.density;
        for component in 0..3 {
            let velocity = flow.state.velocity.component_mut(component);
            let force = immersed.force.component_mut(component);
            for &place in &self.forced[component] {
                if !self.nodes.holds(component, place) {
                    velocity[place] -= dt / density * force[place];
                    force[place] = 0.0;
                }
            }
        }
    }

    /// New velocities of the bodies from the balance of momentum of each and of the fluid that turns with it, at nodes that count;
    /// returns the inertia of the own ones with that fluid. Collective.
    ///
    /// (m − m_f)(U − Uⁿ) + C m_f (ΔU − ΔUⁿ) = −J + E − Eⁿ + K,   ΔU = U − Uⁿ − K_c/m
    ///
    /// with K the impulse of all but the flow, K_c that of contacts, J that on the fluid, C the virtual mass, and E the momentum of
    /// the fluid inside beyond that of rigid motion, which jumps when nodes come and go; likewise for the angular momentum.
    pub(crate) fn move_bodies(
        &mut self,
        (motions, counts): (&[BodyMotion], impl Fn(&Node) -> bool),
        flow: &Flow,
        dt: f64,
        transport: &dyn Transport,
    ) -> Vec<Matrix6<f64>> {
        let Some(immersed) = &flow.immersed else { return Vec::new() };
        let (density, volume) = (flow.setup.density, self.subgrid.cell_volume());
        // Per body: the 6 x 6 response of the impulse to the velocities, and the impulse at rest.
        let mut sums = vec![[0.0; 42]; self.bodies.len()];
        for component in (0..3).filter(|&c| self.subgrid.active[c]) {
            let velocity = flow.state.velocity.component(component);
            let force = immersed.force.component(component);
            let [b, c] = others(component);
            let mass = density * volume;
            let nodes = &self.nodes.of[component];
            let (mut arms, mut numbers) =
                (self.nodes.arms(component, &self.bodies, &self.subgrid), 0..nodes.len());
            for group in nodes.chunk_by(|n, m| n.body == m.body) {
                // Impulse on the fluid along e: V (f Δt + ρ (e·(U + ω × r) − u)), with e·(ω × r) = ω_b r_c − ω_c r_b.
                let (mut squares, mut at_rest) = ([0.0; 6], [0.0; 3]);
                for (node, number) in group.iter().zip(&mut numbers).filter(|(node, _)| counts(node)) {
                    let (place, arm) = (node.place as usize, arms.to(number, node));
                    prefetch_at(nodes, number, [force, velocity]);
                    let (p, q) = (arm[c], -arm[b]);
                    let impulse = dt * force[place] - density * velocity[place];
                    for (sum, x) in squares.iter_mut().zip([1.0, p, q, p * p, p * q, q * q]) {
                        *sum += x;
                    }
                    for (sum, x) in at_rest.iter_mut().zip([1.0, p, q]) {
                        *sum += x * impulse;
                    }
                }
                let sum = &mut sums[group[0].body as usize];
                let axes = [component, 3 + b, 3 + c];
                let matrix = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];
                for (row, &k) in matrix.iter().zip(&axes) {
                    row.iter().zip(&axes).for_each(|(&s, l)| sum[6 * k + l] += mass * squares[s]);
                }
                axes.iter().zip(at_rest).for_each(|(k, x)| sum[36 + k] += volume * x);
            }
        }
        self.ghosts.gather(&mut sums, &self.subgrid, transport);
        let mut values = vec![[0.0; 6]; self.bodies.len()];
        let mut inertia = Vec::with_capacity(motions.len());
        for ((value, sum), motion) in values.iter_mut().zip(&sums).zip(motions) {
            let (matrix, right) = motion.balance(self.virtual_mass(motion));
            let matrix = matrix + Matrix6::from_row_slice(&sum[..36]);
            let right = right - Vector6::from_column_slice(&sum[36..]);
            *value = motion.solved(matrix, right).into();
            inertia.push(matrix);
        }
        values.truncate(self.first_wall());
        self.ghosts.scatter(&mut values, &self.subgrid, transport);
        for (body, value) in self.bodies.iter_mut().zip(&values) {
            body.velocity = Vec3::from_column_slice(&value[..3]);
            body.spin = Vec3::from_column_slice(&value[3..]);
        }
        inertia
    }
}

/// Nodes body by body, with their values.
fn of_bodies<'a>(nodes: &'a [Node], values: &'a [f64]) -> impl Iterator<Item = (&'a [Node], &'a [f64])> {
    let mut start = 0;
    nodes.chunk_by(|n, m| n.body == m.body).map(move |group| {
        let own = start..start + group.len();
        start = own.end;
        (group, &values[own])
    })
}
