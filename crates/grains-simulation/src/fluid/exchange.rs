//! Particles and fluid of one rank: what each tells the other in a step of the fluid.

use super::kernel_grid::kernel_grid;
use super::transfer::{Changed, Transfer};
use super::volumes::{inverse_volumes, volumes};
use crate::error::{RunError, agreed};
use grains_comm::MpiTransport;
use grains_coupling::{
    Coupling, CouplingError, DragFields, DragLink, FluidFields, Grid as KernelGrid, MomentumLedger,
    OpenShares, Site, SiteWeights, Stencil, boundary_gradient, impulse_taken, void_fractions,
};
use grains_dem::{Body, Dem, Particles, Passages, Thermal};
use grains_domain::Transport;
use grains_fluid::{
    CellPartition, Centre, Drive, Faces, Field, Flow, Grid, Halo, Layout, Mixture, MixtureModel, Scalars,
    SolidFlux,
};
use grains_geometry::Vec3;
use std::ops::Range;

/// The exchange between the particles and the fluid of one rank.
pub struct Exchange {
    /// Kernel, drag law, model.
    pub coupling: Coupling,
    /// What this rank knows of the last steps.
    pub account: Account,
    kernel_grid: KernelGrid,
    /// Own cells in the places of `kernel_grid`.
    own: [Range<usize>; 3],
    halo: Halo,
    coefficient: Faces,
    explicit: Faces,
    gradient: Faces,
    /// 1 over the volume of the faces' control volumes (1/m³), own faces.
    per_volume: Faces,
    /// Volume of the own cells (m³).
    volumes: Field<Centre>,
    /// Volume (m³ per cell, halo not added) inserted less that which left, of which the void fraction at the beginning of the
    /// coming step does not know yet.
    passed: Field<Centre>,
    /// Whether there is any, or why there is none.
    has_passed: Result<bool, CouplingError>,
    /// Whether the own cells reach the lower and upper boundary of the domain, per axis.
    ends: [[bool; 2]; 3],
    /// Cross-section of the domain normal to each axis (m²).
    section: [f64; 3],
    /// Volume of the domain (m³).
    box_volume: f64,
    /// What particles exchange with scalars.
    pub(super) transfers: Vec<Transfer>,
    /// Scratch: Reynolds number and void fraction of each particle in this step.
    passings: Vec<[f64; 2]>,
}

/// What a rank knows of the exchange in the last steps; sums over the ranks count, wherever borders are.
pub struct Account {
    /// What drag has moved from one to the other.
    pub ledger: MomentumLedger,
    /// Min. void fraction of the last step (-).
    pub min_void_fraction: f64,
    /// Part of the mean rise of the pressure over the half cells at the lower and upper boundary (Pa).
    pub rise: [[f64; 2]; 3],
}

impl Default for Account {
    fn default() -> Self {
        Self { ledger: MomentumLedger::default(), min_void_fraction: 1.0, rise: [[0.0; 2]; 3] }
    }
}

impl Exchange {
    /// Exchange on the cells of a rank.
    ///
    /// # Errors
    /// Nodes that do not ascend.
    pub fn new(
        coupling: Coupling,
        (grid, partition, halo): (&Grid, &CellPartition, usize),
    ) -> Result<Self, CouplingError> {
        let layout = Layout { cells: partition.cells(), halo };
        let (kernel_grid, own) = kernel_grid(grid, partition, layout)?;
        Ok(Self {
            coupling,
            account: Account::default(),
            kernel_grid,
            own,
            halo: Halo::new(grid, partition, layout),
            coefficient: Faces::new(layout),
            explicit: Faces::new(layout),
            gradient: Faces::new(layout),
            per_volume: inverse_volumes(grid, partition, layout),
            volumes: volumes(grid, partition, layout),
            passed: Field::new(layout),
            has_passed: Ok(false),
            ends: std::array::from_fn(|a| partition.touches(a).map(|t| t && !grid.axis(a).is_periodic())),
            section: std::array::from_fn(|a| grid.volume() / grid.axis(a).length()),
            box_volume: grid.volume(),
            transfers: Vec::new(),
            passings: Vec::new(),
        })
    }

    /// Takes what walls leave open of the cells of a flow.
    pub fn enclose(&mut self, flow: &Flow) {
        let Some(openings) = flow.mixture.as_ref().and_then(|mixture| mixture.openings.as_ref()) else {
            return;
        };
        self.kernel_grid.open = Some(OpenShares {
            cells: openings.cells.data().to_vec(),
            faces: openings.faces.components().map(<[f64]>::to_vec),
        });
    }

    /// Notes particles that came or went, where they did.
    ///
    /// What is inserted or removed is no motion of solid: ∂ε/∂t is that of the others, and of these while they are inside. The
    /// fluid in their place goes and comes with its own velocity, so that no velocity jumps. What a particle that leaves owes
    /// the fluid, or the fluid it, leaves with it.
    pub fn note(&mut self, passages: Passages) {
        let Passages { inserted, left } = passages;
        if inserted.is_empty() && left.is_empty() {
            return;
        }
        let Self { coupling, kernel_grid, passed, .. } = self;
        let mut add = |bodies: &mut dyn Iterator<Item = &Body>, sign| {
            coupling.deposit_volumes(bodies, sign, kernel_grid, passed.data_mut())
        };
        let added =
            add(&mut inserted.iter(), 1.0).and_then(|()| add(&mut left.iter().map(|(body, _)| body), -1.0));
        if self.has_passed.is_ok() {
            self.has_passed = added.map(|()| true);
        }
        for (_, cargo) in &left {
            self.account.ledger.given -= DragLink::read(cargo).unpaid;
        }
    }

    /// Forgets the volumes of [`Exchange::note`].
    pub fn forget_passages(&mut self) {
        self.passed.fill(0.0);
        self.has_passed = Ok(false);
    }

    /// Gives the void fraction at the beginning of the coming step what was inserted, and takes what left out of it;
    /// collective.
    ///
    /// # Errors
    /// A particle that came or went beyond the halo.
    pub fn settle_passages(
        &mut self,
        mixture: &mut Mixture,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        let has_passed = agree(transport, std::mem::replace(&mut self.has_passed, Ok(false)))?;
        if !transport.any(has_passed) {
            return Ok(());
        }
        self.halo.add(&mut [self.passed.data_mut()], transport);
        let layout = self.passed.layout();
        let void_fraction = mixture.previous_void_fraction_mut().data_mut();
        for start in layout.rows() {
            let row = start..start + layout.cells[0];
            let amounts = self.passed.data()[row.clone()].iter().zip(&self.volumes.data()[row.clone()]);
            void_fraction[row]
                .iter_mut()
                .zip(amounts)
                .for_each(|(eps, (passed, volume))| *eps -= passed / volume);
        }
        self.forget_passages();
        Ok(())
    }

    /// Gives the fluid the void fraction of the particles where they are; collective.
    ///
    /// # Errors
    /// A particle beyond the halo, a cell too full.
    pub fn fill_void_fraction(
        &mut self,
        particles: &Particles,
        void_fraction: &mut Field<Centre>,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        void_fraction.fill(0.0);
        let data = void_fraction.data_mut();
        let deposited = self.coupling.deposit_volume(particles, &self.kernel_grid, data);
        agree(transport, deposited)?;
        self.halo.add(&mut [data], transport);
        let checked =
            void_fractions(&self.kernel_grid, self.own.clone(), self.coupling.min_void_fraction, data);
        agree(transport, checked)?;
        self.halo.fill(&mut [data], transport);
        let of_open = |(p, eps): (usize, f64)| match &self.kernel_grid.open {
            None => eps,
            Some(open) if open.cells[p] > 0.0 => eps / open.cells[p],
            Some(_) => 1.0,
        };
        let layout = void_fraction.layout();
        let own = layout.rows().flat_map(|row| row..row + layout.cells[0]);
        self.account.min_void_fraction =
            own.map(|p| of_open((p, void_fraction.data()[p]))).fold(1.0, f64::min);
        Ok(())
    }

    /// Tells the fluid of the drag in its coming step `dt` (s); collective.
    ///
    /// # Errors
    /// A particle beyond the halo.
    pub fn before_step(
        &mut self,
        (particles, thermal): (&mut Particles, Option<&Thermal>),
        flow: &mut Flow,
        dt: f64,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        let Some(mixture) = flow.mixture.as_mut() else { return Ok(()) };
        self.settle_passages(mixture, transport)?;
        self.fill_void_fraction(particles, &mut mixture.void_fraction, transport)?;
        self.coefficient.fill(0.0);
        self.explicit.fill(0.0);
        let fluid = FluidFields {
            velocity: flow.state.velocity.components(),
            void_fraction: mixture.void_fraction.data(),
            pressure_gradient: self.gradient.components(),
        };
        let mut drag = DragFields {
            coefficient: self.coefficient.components_mut(),
            explicit: self.explicit.components_mut(),
        };
        let passings = (!self.transfers.is_empty()).then_some(&mut self.passings);
        let of_fluid = (&self.kernel_grid, &fluid);
        let deposited = self.coupling.deposit_drag(particles, of_fluid, &mut drag, dt, passings);
        agree(transport, deposited)?;
        if flow.setup.drive.iter().any(|drive| matches!(drive, Drive::MeanFlux(_))) {
            mixture.solid = self.solid_flux_of_box(particles, dt, transport);
        }
        let [a, b, c] = self.coefficient.components_mut();
        let [d, e, f] = self.explicit.components_mut();
        self.halo.add(&mut [a, b, c, d, e, f], transport);
        let deposited = self.deposit_transfers((particles, thermal), flow.scalars.as_mut(), dt, transport);
        deposited?;
        let Some(mixture) = flow.mixture.as_mut() else { return Ok(()) };
        for axis in 0..3 {
            let scale = self.per_volume.component(axis);
            scaled(mixture.drag.component_mut(axis), self.coefficient.component(axis), scale);
            scaled(mixture.source.component_mut(axis), self.explicit.component(axis), scale);
        }
        Ok(())
    }

    /// Tells the scalars of the fluid what particles exchange with them; collective.
    fn deposit_transfers(
        &mut self,
        (particles, thermal): (&Particles, Option<&Thermal>),
        scalars: Option<&mut Scalars>,
        dt: f64,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        let Some(scalars) = scalars else { return Ok(()) };
        let Self { coupling, kernel_grid, transfers, passings, halo, volumes, .. } = self;
        for transfer in transfers {
            transfer.link(coupling, (particles, thermal), passings, dt);
            let scalar = &mut scalars.all[transfer.scalar];
            let layout = scalar.value.layout();
            let mut fields = [&mut scalar.exchange, &mut scalar.source]
                .map(|field| field.get_or_insert_with(|| Field::new(layout)).data_mut());
            fields.iter_mut().for_each(|field| field.fill(0.0));
            let [coefficient, explicit] = fields;
            let amounts = [&mut *coefficient, &mut *explicit];
            let deposited = coupling.deposit_transfer(particles, kernel_grid, &transfer.links, amounts);
            agree(transport, deposited)?;
            halo.add(&mut [coefficient, explicit], transport);
            for p in layout.rows().flat_map(|row| row..row + layout.cells[0]) {
                coefficient[p] /= volumes.data()[p];
                explicit[p] /= volumes.data()[p];
            }
        }
        Ok(())
    }

    /// Gives the particles what they got of the scalars of the fluid in its step `dt` (s); collective.
    ///
    /// # Errors
    /// A particle beyond the halo.
    pub fn after_scalars(
        &mut self,
        dem: &mut Dem,
        flow: &Flow,
        dt: f64,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        let Some(scalars) = &flow.scalars else { return Ok(()) };
        for transfer in &self.transfers {
            let mean = scalars.all[transfer.scalar].exchanged_at().data();
            let Dem { particles, setup, heat_ledger, species_ledgers, .. } = &mut *dem;
            let Particles { bodies, temperatures, amounts, owned, .. } = particles;
            let mut changed = Changed {
                bodies,
                temperatures,
                thermal: setup.thermal.as_ref(),
                heat_ledger,
                amounts,
                species_ledgers,
            };
            let gained =
                self.coupling.for_each_mean(&bodies[..*owned], &self.kernel_grid, mean, |i, mean| {
                    transfer.give(i, mean, &mut changed, dt)
                });
            agree(transport, gained)?;
        }
        Ok(())
    }

    /// Gives the particles the fluid's new velocity and pressure gradient, after its step `dt` (s); collective.
    ///
    /// # Errors
    /// A particle beyond the halo.
    pub fn after_step(
        &mut self,
        particles: &mut Particles,
        flow: &Flow,
        dt: f64,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        let Some(mixture) = &flow.mixture else { return Ok(()) };
        flow.pressure_gradient(&mut self.gradient);
        self.settle(flow, dt);
        let [x, y, z] = self.gradient.components_mut();
        self.halo.fill(&mut [x, y, z], transport);
        let fluid = FluidFields {
            velocity: flow.state.velocity.components(),
            void_fraction: mixture.void_fraction.data(),
            pressure_gradient: self.gradient.components(),
        };
        let outcome = self.coupling.set_fluid_velocities(particles, (&self.kernel_grid, &fluid), dt);
        agree(transport, outcome)
    }

    /// Books the impulse the fluid has lost, and finds the pressure gradient at the boundaries of the domain that balances the
    /// drag there.
    fn settle(&mut self, flow: &Flow, dt: f64) {
        let (layout, velocity) = (flow.layout(), &flow.state.velocity);
        let Some(mixture) = &flow.mixture else { return };
        self.account.rise = [[0.0; 2]; 3];
        for axis in 0..3 {
            let [b, s, u] = [&self.coefficient, &self.explicit, velocity].map(|f| f.component(axis));
            let mut unknown = layout.cells;
            unknown[axis] -= usize::from(self.ends[axis][1]);
            for k in 0..unknown[2] {
                for j in 0..unknown[1] {
                    let row = layout.row(j, k);
                    let own = row..row + unknown[0];
                    self.account.ledger.taken[axis] +=
                        impulse_taken(&b[own.clone()], &s[own.clone()], &u[own], dt);
                }
            }
            for face in boundary_faces(layout, axis, self.ends[axis]) {
                let force = s[face.place] - b[face.place] * u[face.next];
                self.account.ledger.taken[axis] -= force * dt;
                let void_fraction = mixture.void_fraction.data()[face.cell];
                let factor = self.coupling.model.fluid_pressure_factor(void_fraction);
                let half_volume = 0.5 * self.volumes.data()[face.cell];
                // Between walls nothing acts on the faces of the boundary, and a cell may be solid.
                let gradient = if force == 0.0 { 0.0 } else { boundary_gradient(force, factor, half_volume) };
                self.gradient.component_mut(axis)[face.place] = gradient;
                // ∇p times half a cell's height, weighted by its area.
                self.account.rise[axis][face.side] += gradient * half_volume / self.section[axis];
            }
        }
    }

    /// Mean drop of the pressure (Pa) along an axis over the half cells at both boundaries of the domain; collective.
    pub fn drop_at_boundaries(&self, axis: usize, transport: &MpiTransport) -> f64 {
        let mut rises = self.account.rise[axis];
        transport.sum(&mut rises);
        -(rises[0] + rises[1])
    }

    /// Mean flux of the particles over the box, and what it follows of the fluid's in a step `dt` (s); collective, before the
    /// halos of the drag are added.
    ///
    /// With volumes V, masses m and drag coefficients K of all, φ = ΣV/V_box: in a step particles follow a change of u by the
    /// share w = K Δt/(m + K Δt) of it, so that κ = w φ/(1 − φ). Where they feel the pressure gradient, one of the force f per
    /// volume moves them by w V/K of it, φ times which is their flux. λ is w V/K: with stiff drag what they owe the fluid for
    /// it brings the rest a step later, and by φ w V/K the force would alternate from step to step near φ = ½.
    fn solid_flux_of_box(&self, particles: &Particles, dt: f64, transport: &MpiTransport) -> SolidFlux {
        // Flux along x, y, z, volume, mass, and drag coefficients along x, y, z.
        let mut sums = [0.0; 8];
        for body in &particles.bodies[..particles.owned] {
            let volume = self.coupling.volume(body);
            for (sum, u) in sums.iter_mut().zip(body.velocity.iter()) {
                *sum += volume * u;
            }
            sums[3] += volume;
            sums[4] += body.mass;
        }
        for axis in 0..3 {
            sums[5 + axis] = self.coefficient.component(axis).iter().sum();
        }
        transport.sum(&mut sums);
        let [volume, mass] = [sums[3], sums[4]];
        let share = volume / self.box_volume;
        let mut flux = SolidFlux::default();
        for axis in (0..3).filter(|_| mass > 0.0) {
            let drag = sums[5 + axis] * dt;
            flux.mean[axis] = sums[axis] / self.box_volume;
            flux.drag_response[axis] = drag / (mass + drag) * share / (1.0 - share);
            if self.coupling.model == MixtureModel::A {
                flux.gradient_response[axis] = dt * volume / (mass + drag);
            }
        }
        flux
    }

    /// Velocity of the particles times their volume (m⁴/s) in every own cell, and their volume (m³); collective.
    ///
    /// # Errors
    /// A particle beyond the halo.
    pub fn solid_flux(
        &mut self,
        particles: &Particles,
        layout: Layout,
        transport: &MpiTransport,
    ) -> Result<[Field<Centre>; 4], RunError> {
        let mut fields: [Field<Centre>; 4] = std::array::from_fn(|_| Field::new(layout));
        let (mut stencil, mut cells) = (Stencil::default(), SiteWeights::default());
        let mut deposit = || {
            for body in &particles.bodies[..particles.owned] {
                let diameter = self.coupling.equivalent_diameter(body);
                stencil.place(&self.coupling.kernel, &self.kernel_grid.axes, &body.position, diameter)?;
                self.kernel_grid.weigh(&mut stencil, Site::Cells, &mut cells);
                let (volume, v) = (self.coupling.volume(body), &body.velocity);
                let amounts = [v.x * volume, v.y * volume, v.z * volume, volume];
                cells.share(amounts, fields.each_mut().map(|field| field.data_mut()));
            }
            Ok(())
        };
        let deposited = deposit();
        agree(transport, deposited)?;
        let [x, y, z, v] = &mut fields;
        self.halo.add(&mut [x.data_mut(), y.data_mut(), z.data_mut(), v.data_mut()], transport);
        Ok(fields)
    }

    /// What of the momentum between particles and fluid is not accounted for (N s), rounding; collective.
    pub fn imbalance(&self, particles: &Particles, transport: &MpiTransport) -> Vec3 {
        let mut sums: [f64; 3] = self.account.ledger.imbalance(particles).into();
        transport.sum(&mut sums);
        sums.into()
    }
}

/// The same outcome on all ranks.
fn agree<T>(transport: &MpiTransport, outcome: Result<T, CouplingError>) -> Result<T, RunError> {
    agreed(transport, outcome.map_err(|e| RunError::unphysical(e.to_string())))
}

fn scaled(to: &mut [f64], from: &[f64], by: &[f64]) {
    to.iter_mut().zip(from).zip(by).for_each(|((t, f), b)| *t = f * b);
}

/// A face on a boundary of the domain.
struct BoundaryFace {
    /// 0 for the lower boundary, 1 for the upper one.
    side: usize,
    /// Place of the face in the arrays, of the next one within, and of its cell.
    place: usize,
    next: usize,
    cell: usize,
}

/// The own faces on the boundaries normal to an axis.
fn boundary_faces(layout: Layout, axis: usize, ends: [bool; 2]) -> impl Iterator<Item = BoundaryFace> {
    let (stride, n) = (layout.strides()[axis], layout.cells[axis]);
    // A single cell between two boundaries has nothing within.
    let inwards = if n > 1 { stride } else { 0 };
    let mut layer = layout.cells;
    layer[axis] = 1;
    (0..2).filter(move |&side| ends[side]).flat_map(move |side| {
        let rows = (0..layer[2]).flat_map(move |k| (0..layer[1]).map(move |j| layout.row(j, k)));
        rows.flat_map(move |row| row..row + layer[0]).map(move |first| match side {
            0 => BoundaryFace { side, place: first - stride, next: first - stride + inwards, cell: first },
            _ => {
                let cell = first + (n - 1) * stride;
                BoundaryFace { side, place: cell, next: cell - inwards, cell }
            }
        })
    })
}
