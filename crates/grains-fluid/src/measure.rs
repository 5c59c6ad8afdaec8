//! What can be asked of a flow; all collective.

use crate::flow::Flow;
use crate::momentum::RowPlace;
use crate::projection::divergence;
use crate::{Centre, Faces, Field, Halo};
use grains_domain::Transport;
use multiversion::multiversion;

impl Flow {
    /// What passes cut faces beyond the velocity, if there are any.
    fn passing(&self) -> Option<&Faces> {
        self.immersed.as_ref().and_then(|bodies| bodies.passing.as_ref())
    }

    /// Places of own faces of a component with extrapolated velocities, by which nothing flows, and what these are beyond those of
    /// the bodies (m/s).
    fn extrapolated(&self, component: usize) -> &[(u32, f64)] {
        let extrapolated = self.immersed.as_ref().and_then(|bodies| bodies.extrapolated.as_ref());
        extrapolated.map_or(&[], |extrapolated| &extrapolated[component])
    }

    /// Extrapolated velocities less those of the bodies (m/s) on all faces, with one layer of the halo; none if none are
    /// extrapolated.
    pub fn extrapolated_faces(&self, transport: &dyn Transport) -> Option<Faces> {
        self.immersed.as_ref()?.extrapolated.as_ref()?;
        let mut faces = Faces::new(self.local.layout);
        for component in 0..3 {
            let to = faces.component_mut(component);
            self.extrapolated(component).iter().for_each(|&(place, value)| to[place as usize] = value);
        }
        let mut halo = Halo::new(&self.setup.grid, &self.setup.partition, self.local.layout);
        let [x, y, z] = faces.components_mut();
        halo.fill_to(1, &mut [x, y, z], transport);
        Some(faces)
    }

    /// Largest |∂ε/∂t + ∇·(ε u)| over all cells (1/s), and the largest Σ |u|/Δx (1/s) to compare it with.
    pub fn divergence(&self, transport: &dyn Transport) -> [f64; 2] {
        let mut rhs = Field::<Centre>::new(self.local.layout);
        let porous = self.mixture.as_ref().map(|m| (m.open_faces().components(), m.rate.data()));
        divergence(&self.local, &self.state.velocity, porous, &mut rhs);
        let extrapolated = self.extrapolated_faces(transport);
        for (factor, faces) in extrapolated.iter().map(|e| (-1.0, e)).chain(self.passing().map(|p| (1.0, p)))
        {
            let mut beyond = Field::<Centre>::new(self.local.layout);
            divergence(&self.local, faces, None, &mut beyond);
            rhs.data_mut().iter_mut().zip(beyond.data()).for_each(|(f, g)| *f += factor * g);
        }
        let mut largest = [0.0, self.rates_of_own_cells()];
        self.for_cells(|cell, p| {
            largest[0] = f64::max(largest[0], (rhs.data()[p] / self.local.volume(cell)).abs());
        });
        transport.max(&mut largest);
        largest
    }

    /// Pressure gradient with the imposed mean one (Pa/m) on every face of the arrays that has a cell on either side; not
    /// collective, the halo of the pressure is filled.
    pub fn pressure_gradient(&self, gradient: &mut Faces) {
        let (dims, strides) = (self.local.layout.dims(), self.local.layout.strides());
        let pressure = self.state.pressure.data();
        for axis in 0..3 {
            let (stride, force) = (strides[axis], self.state.force[axis]);
            let distances = &self.local.axes[axis].inverse_distance;
            let out = gradient.component_mut(axis);
            for k in 0..dims[2] - usize::from(axis == 2) {
                for j in 0..dims[1] - usize::from(axis == 1) {
                    let start = j * strides[1] + k * strides[2];
                    for i in 0..dims[0] - usize::from(axis == 0) {
                        let p = start + i;
                        out[p] = (pressure[p + stride] - pressure[p]) * distances[[i, j, k][axis]] - force;
                    }
                }
            }
        }
    }

    /// Velocity at the centres of the own cells along an axis (m/s), x fastest; not collective.
    pub fn centre_velocity(&self, axis: usize) -> impl Iterator<Item = f64> + '_ {
        let (layout, u) = (self.local.layout, self.state.velocity.component(axis));
        let stride = layout.strides()[axis];
        layout
            .rows()
            .flat_map(move |row| (row..row + layout.cells[0]).map(move |p| 0.5 * (u[p] + u[p - stride])))
    }

    /// ½ ρ ∫ ε u² dV (J), with the means of squares of opposite faces.
    pub fn kinetic_energy(&self, transport: &dyn Transport) -> f64 {
        let strides = self.local.layout.strides();
        let mut energy = [0.0];
        self.for_cells(|cell, p| {
            let squares: f64 = (0..3)
                .filter(|&a| self.local.active[a])
                .map(|a| {
                    let u = self.state.velocity.component(a);
                    0.5 * (u[p].powi(2) + u[p - strides[a]].powi(2))
                })
                .sum();
            let eps = self.mixture.as_ref().map_or(1.0, |m| m.void_fraction.data()[p]);
            energy[0] += 0.5 * self.setup.density * eps * squares * self.local.volume(cell);
        });
        transport.sum(&mut energy);
        energy[0]
    }

    /// Volume rate ∫ ε u dA (m³/s) through the faces normal to `axis` at node `node` (0 to cells).
    pub fn flow_rate(&self, axis: usize, node: usize, transport: &dyn Transport) -> f64 {
        let mut rate = [0.0];
        let stride = self.local.layout.strides()[axis];
        let axis_of_grid = self.setup.grid.axis(axis);
        // Both ends of a periodic axis are one face.
        let node = if node == 0 && axis_of_grid.is_periodic() { axis_of_grid.cells() } else { node };
        let (velocity, passing) = (self.state.velocity.component(axis), self.passing());
        self.for_cells(|cell, p| {
            let global = cell[axis] + self.local.first[axis];
            // Every node belongs to the cell below it; node 0 to the first cell.
            let face = if global + 1 == node {
                p
            } else if node == 0 && global == 0 {
                p - stride
            } else {
                return;
            };
            let area =
                self.local.volume(cell) * self.local.axes[axis].inverse_width[self.local.entry(cell[axis])];
            let eps = self.mixture.as_ref().map_or(1.0, |m| m.open_faces().component(axis)[face]);
            let beyond = passing.map_or(0.0, |passing| passing.component(axis)[face]);
            rate[0] += eps * (velocity[face] + beyond) * area;
        });
        for &(place, value) in self.extrapolated(axis) {
            let cell = self.cell_at(place as usize);
            if cell[axis] + self.local.first[axis] + 1 == node {
                let inverse = self.local.axes[axis].inverse_width[self.local.entry(cell[axis])];
                rate[0] -= value * self.local.volume(cell) * inverse;
            }
        }
        transport.sum(&mut rate);
        rate[0]
    }

    /// What enters and what leaves (m³/s) through outlets.
    pub fn outlet_flows(&self, transport: &dyn Transport) -> [f64; 2] {
        let open = self.mixture.as_ref().map(|mixture| mixture.open_faces());
        let mut flows = [0.0; 2];
        for face in &self.boundary_data {
            let [entering, leaving] =
                face.outlet_flows(&self.local, &self.setup.boundaries, &self.state.velocity, open);
            flows = [flows[0] + entering, flows[1] + leaving];
        }
        transport.sum(&mut flows);
        flows
    }

    /// Dynamic viscosity (Pa s) of the last step, where a component is strained along an axis between its velocity at a place and the
    /// next one along the axis; none where it is the same everywhere.
    pub fn viscosity_of_stress(&self, component: usize, axis: usize, place: usize) -> Option<f64> {
        let weights = self.viscosity.as_ref()?.weights();
        let viscosity = match component == axis {
            true => weights.centres[axis][place + self.local.layout.strides()[axis]],
            false => weights.edges[component][axis][place],
        };
        Some(viscosity * self.setup.density)
    }

    /// Mean of ε u over the box along an axis (m/s), the superficial velocity; inside bodies u is theirs.
    pub fn mean_velocity(&self, axis: usize, transport: &dyn Transport) -> f64 {
        self.mean_and_response(axis, 0.0, transport)[0]
    }

    /// Mean pressure over what is open of the cells of a plane normal to `axis` (Pa), `cell` its global number; what is inside
    /// bodies counts, what is inside walls does not.
    pub fn mean_pressure(&self, axis: usize, cell: usize, transport: &dyn Transport) -> f64 {
        let mut sums = [0.0, 0.0];
        let sealed = self.immersed.as_ref().map_or(&[][..], |bodies| &bodies.sealed);
        self.for_cells(|place, p| {
            let is_on_plane = place[axis] + self.local.first[axis] == cell;
            if is_on_plane && sealed.binary_search(&(p as u32)).is_err() {
                let open = self.mixture.as_ref().and_then(|mixture| mixture.openings.as_ref());
                let volume = self.local.volume(place) * open.map_or(1.0, |open| open.cells.data()[p]);
                sums[0] += volume * self.state.pressure.data()[p];
                sums[1] += volume;
            }
        });
        transport.sum(&mut sums);
        if sums[1] > 0.0 { sums[0] / sums[1] } else { 0.0 }
    }

    /// Mean of ε u (m/s) along an axis, velocities inside bodies as those of the bodies, and its rise per force (m/s per Pa/m) in a step of `dt`.
    pub(crate) fn mean_and_response(&self, axis: usize, dt: f64, transport: &dyn Transport) -> [f64; 2] {
        let mut sums = [0.0, 0.0];
        // The control volume of the face, not of the cell.
        let volume_about = |cell: [usize; 3]| {
            let (m, e) = (&self.local.axes[axis], self.local.entry(cell[axis]));
            self.local.volume(cell) * m.inverse_width[e] / m.inverse_distance[e]
        };
        let (velocity, passing) = (self.state.velocity.component(axis), self.passing());
        self.for_cells(|cell, p| {
            let volume = volume_about(cell);
            let (eps, gradient_factor) = match &self.mixture {
                Some(m) => (m.open_faces().component(axis)[p], m.gradient_factor.component(axis)[p]),
                None => (1.0, dt / self.setup.density),
            };
            let beyond = passing.map_or(0.0, |passing| passing.component(axis)[p]);
            sums[0] += eps * (velocity[p] + beyond) * volume;
            sums[1] += eps * gradient_factor * volume;
        });
        for &(place, value) in self.extrapolated(axis) {
            sums[0] -= value * volume_about(self.cell_at(place as usize));
        }
        transport.sum(&mut sums);
        sums.map(|s| s / self.setup.grid.volume())
    }

    /// Force (N) and torque about the origin (N m) of a mixture on each of `count` walls in it, as x, y, z of both; collective.
    ///
    /// The pressure, without its hydrostatic part, acts on the wall of a cell as the open share V_f changes over it,
    /// F = −p (V_f₊ − V_f₋) A. The wall bears all that acts on closed faces, as nothing moves there: drive, ∇p, and momentum that
    /// flows to them. With the friction this is the momentum that the fluid and its particles lose to walls.
    pub fn loads_on_walls(&self, count: usize, transport: &dyn Transport) -> Vec<[f64; 6]> {
        let mut loads = vec![[0.0; 6]; count];
        let Some((mixture, openings)) = self.mixture.as_ref().and_then(|m| Some((m, m.openings.as_ref()?)))
        else {
            return loads;
        };
        let (local, grid, pressure) = (&self.local, &self.setup.grid, self.state.pressure.data());
        let mut add = |wall: u32, axis: usize, at: [f64; 3], force: f64| {
            let Some(load) = loads.get_mut(wall as usize) else { return };
            let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
            load[axis] += force;
            load[3 + b] += at[c] * force;
            load[3 + c] -= at[b] * force;
        };
        let explicit = self.explicit_terms();
        let [mut advective, mut viscous] =
            [vec![0.0; local.layout.cells[0]], vec![0.0; local.layout.cells[0]]];
        for axis in (0..3).filter(|&a| local.active[a]) {
            let (m, stride) = (&local.axes[axis], local.layout.strides()[axis]);
            let (volumes, unknowns) = (openings.volumes.component(axis), local.unknowns(axis));
            self.for_cells(|cell, p| {
                let [i, j, k] = cell;
                let (is_unknown, e) = (cell[axis] < unknowns[axis], local.entry(cell[axis]));
                if i == 0 && is_unknown {
                    let n = unknowns[0];
                    explicit.row(RowPlace { component: axis, j, k }, &mut advective[..n], &mut viscous[..n]);
                }
                let place: [usize; 3] = std::array::from_fn(|a| cell[a] + local.first[a]);
                let mut at: [f64; 3] = std::array::from_fn(|a| grid.axis(a).centre(place[a] as isize));
                let volume = local.volume(cell);
                let rise = (volumes[p] - volumes[p - stride]) * volume * m.inverse_width[e];
                add(openings.closest[3][p], axis, at, -pressure[p] * rise);
                if !is_unknown {
                    return;
                }
                at[axis] = grid.axis(axis).node(place[axis] as isize + 1);
                let density = if openings.ratios.component(axis)[p] > 0.0 {
                    let [friction, wall] = mixture.wall_friction(axis, p);
                    friction * (self.state.velocity.component(axis)[p] - wall)
                } else {
                    let gradient = (pressure[p + stride] - pressure[p]) * m.inverse_distance[e];
                    volumes[p] * (self.state.force[axis] - gradient)
                        + self.setup.density * (viscous[i] - advective[i])
                };
                let volume = volume * m.inverse_width[e] / m.inverse_distance[e];
                add(openings.closest[axis][p], axis, at, density * volume);
            });
        }
        transport.sum(loads.as_flattened_mut());
        loads
    }

    /// Largest Σ max(|u₋|, |u₊|)/Δx of the own cells (1/s).
    pub(crate) fn rates_of_own_cells(&self) -> f64 {
        largest_rate(self)
    }

    /// Courant number of the own cells with a step (s).
    pub(crate) fn own_cfl_number(&self, dt: f64) -> f64 {
        self.rates_of_own_cells() * dt
    }

    /// The own cell at a place in the arrays.
    fn cell_at(&self, place: usize) -> [usize; 3] {
        let layout = self.local.layout;
        let [_, sy, sz] = layout.strides();
        [place % sy, place % sz / sy, place / sz].map(|m| m - layout.halo)
    }

    /// All own cells with their places in the arrays.
    fn for_cells(&self, mut job: impl FnMut([usize; 3], usize)) {
        let layout = self.local.layout;
        let [nx, ny, nz] = layout.cells;
        for k in 0..nz {
            for j in 0..ny {
                let start = layout.row(j, k);
                (0..nx).for_each(|i| job([i, j, k], start + i));
            }
        }
    }
}

/// See [`Flow::rates_of_own_cells`].
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn largest_rate(flow: &Flow) -> f64 {
    let (layout, strides) = (flow.local.layout, flow.local.layout.strides());
    let [nx, ny, nz] = layout.cells;
    let (mut rates, mut largest, mut sums) = (vec![0.0; nx], vec![0.0; nx], vec![0.0; nx]);
    for (k, j) in (0..nz).flat_map(|k| (0..ny).map(move |j| (k, j))) {
        let start = layout.row(j, k);
        rates.fill(0.0);
        for a in (0..3).filter(|&a| flow.local.active[a]) {
            let u = flow.state.velocity.component(a);
            let (below, above) = (&u[start - strides[a]..][..nx], &u[start..][..nx]);
            let inverse = &flow.local.axes[a].inverse_width;
            let speed = |(below, above): (&f64, &f64)| {
                let [below, above] = [below.abs(), above.abs()];
                if below > above { below } else { above }
            };
            let speeds = below.iter().zip(above).map(speed);
            if a == 0 {
                let inverse = &inverse[flow.local.entry(0)..][..nx];
                let terms = speeds.zip(inverse).map(|(speed, inverse)| speed * inverse);
                rates.iter_mut().zip(terms).for_each(|(rate, term)| *rate += term);
            } else {
                let inverse = inverse[flow.local.entry([0, j, k][a])];
                rates.iter_mut().zip(speeds).for_each(|(rate, speed)| *rate += speed * inverse);
            }
        }
        for ((rate, largest), sum) in rates.iter().zip(&mut largest).zip(&mut sums) {
            *largest = if *rate > *largest { *rate } else { *largest };
            *sum += rate;
        }
    }
    // A velocity that is no number must not pass for the smallest.
    match sums.iter().any(|sum: &f64| sum.is_nan()) {
        true => f64::INFINITY,
        false => largest.into_iter().fold(0.0, f64::max),
    }
}
