//! The exchange of momentum: steady states, stability, and the ledger, with real particles and a fluid of a few cells.

use grains_contact::{ContactLaw, Sharing, Tangential};
use grains_coupling::{
    Bed, Coefficient, Coupling, DragFields, DragLaw, DragLink, End, Fluid, FluidFields, Grid, GridAxis,
    Kernel, Layout, MomentumLedger, ShapeFactors, add_drag, impulse_taken, relaxation, unpaid_impulse,
    void_fractions,
};
use grains_dem::{
    Body, Catalogue, CollisionModel, ContactTable, Dem, DemSetup, FaceContact, Kind, ParticleRecord,
    Particles, Skin, StepParameters, half_step_back,
};
use grains_domain::{GlobalBox, SerialTransport};
use grains_fluid::MixtureModel;
use grains_geometry::{Rotation, Shape, Vec3};

const AIR: Fluid = Fluid { density: 1.2, viscosity: 1.8e-5 };
const GRAVITY: f64 = 9.81;

/// Grains that never touch, by the kick of the leap-frog without positions: however far they go in a step.
struct Grains {
    particles: Particles,
    catalogue: Catalogue,
    rates: StepParameters,
}

impl Grains {
    fn new(diameter: f64, density: f64, rates: StepParameters, places: &[Vec3]) -> Self {
        let shape = Shape::sphere(0.5 * diameter).unwrap();
        // Never met, but it bounds the loads.
        let mut contacts = ContactTable::new(1);
        contacts.set(0, 0, ContactLaw::linear(1e5, 0.9, 0.1, Tangential::Viscous { rate: 1.0 }));
        let catalogue = Catalogue {
            shapes: vec![shape],
            densities: vec![density],
            contacts,
            faces: FaceContact::Point,
            sharing: Sharing::default(),
        };
        let mut particles = Particles::new(true);
        particles.carry();
        places
            .iter()
            .enumerate()
            .for_each(|(id, place)| particles.push(&record(id, place, &catalogue, &rates)));
        Self { particles, catalogue, rates }
    }

    fn advance(&mut self) {
        let Particles { bodies, loads, half_velocity, .. } = &mut self.particles;
        for ((body, load), velocity) in bodies.iter_mut().zip(loads).zip(half_velocity) {
            let acceleration = std::mem::take(load).force / body.mass + self.rates.gravity;
            *velocity += acceleration * self.rates.dt;
            body.velocity = *velocity + acceleration * (0.5 * self.rates.dt);
        }
    }
}

fn record(id: usize, place: &Vec3, catalogue: &Catalogue, rates: &StepParameters) -> ParticleRecord {
    let kind = Kind { shape: 0, material: 0 };
    let body = Body {
        position: *place,
        radius: catalogue.shapes[0].bounding_radius,
        velocity: Vec3::zeros(),
        mass: catalogue.mass(kind, 1.0),
        angular_velocity: Vec3::zeros(),
        kind,
        prescribed: 0,
    };
    ParticleRecord {
        id: id as u64,
        body,
        orientation: Rotation::identity(),
        half_velocity: half_step_back(Vec3::zeros(), rates),
        half_spin: Vec3::zeros(),
        sides: 0,
        temperature: 0.0,
    }
}

fn falling(dt: f64) -> StepParameters {
    StepParameters { gravity: Vec3::new(0.0, 0.0, -GRAVITY), dt }
}

fn weightless(dt: f64) -> StepParameters {
    StepParameters { gravity: Vec3::zeros(), dt }
}

/// Periodic cells of a fluid without pressure and viscosity, with the halo folded back by hand.
struct Parcel {
    grid: Grid,
    cells: usize,
    halo: usize,
    length: f64,
    velocity: [Vec<f64>; 3],
    void_fraction: Vec<f64>,
    coefficient: [Vec<f64>; 3],
    explicit: [Vec<f64>; 3],
    zeros: Vec<f64>,
}

impl Parcel {
    fn new(length: f64, cells: usize, halo: usize) -> Self {
        let h = length / cells as f64;
        let total = cells + 2 * halo;
        let nodes: Vec<f64> = (0..=total).map(|k| (k as f64 - halo as f64) * h).collect();
        let axes = std::array::from_fn(|a| GridAxis::new(a, nodes.clone(), [End::Halo; 2]).unwrap());
        // Arrays one longer than the cells, so that the last face has its place.
        let side = total + 1;
        let layout = Layout::packed([side; 3]);
        let zeros = vec![0.0; side.pow(3)];
        let three = || [zeros.clone(), zeros.clone(), zeros.clone()];
        Self {
            grid: Grid { axes, cells: layout, faces: [layout; 3], open: None },
            cells,
            halo,
            length,
            velocity: three(),
            void_fraction: zeros.clone(),
            coefficient: three(),
            explicit: three(),
            zeros,
        }
    }

    fn side(&self) -> usize {
        self.cells + 2 * self.halo + 1
    }

    /// Index of the own value that is the periodic image of another.
    fn home(&self, index: usize) -> usize {
        let side = self.side();
        let wrap = |k: usize| (k + self.cells - self.halo) % self.cells + self.halo;
        wrap(index % side) + side * (wrap(index / side % side) + side * wrap(index / side / side))
    }

    fn fold(&self, field: &mut [f64]) {
        for index in 0..field.len() {
            let home = self.home(index);
            if home != index {
                field[home] += std::mem::take(&mut field[index]);
            }
        }
    }

    fn fill(&self, field: &mut [f64]) {
        (0..field.len()).for_each(|index| field[index] = field[self.home(index)]);
    }

    fn set_velocity(&mut self, velocity: &Vec3) {
        (0..3).for_each(|a| self.velocity[a].fill(velocity[a]));
    }

    /// Volume of a cell (m³).
    fn cell(&self) -> f64 {
        (self.length / self.cells as f64).powi(3)
    }

    fn own(&self) -> Vec<usize> {
        (0..self.zeros.len()).filter(|&k| self.home(k) == k).collect()
    }

    /// One coupled step; `push` is a force per volume of fluid (N/m³); `frozen` keeps the velocity.
    fn step(&mut self, coupling: &Coupling, grains: &mut Grains, ledger: &mut MomentumLedger, run: &Run) {
        let dt = run.sub_steps as f64 * grains.rates.dt;
        let mut solid = self.zeros.clone();
        coupling.deposit_volume(&grains.particles, &self.grid, &mut solid).unwrap();
        self.fold(&mut solid);
        let own = self.halo..self.halo + self.cells;
        void_fractions(&self.grid, [own.clone(), own.clone(), own], 0.1, &mut solid).unwrap();
        self.fill(&mut solid);
        if run.frozen {
            // A lone grain in a sea of fluid.
            solid.fill(1.0);
        }
        self.void_fraction = solid;
        let mut velocity = std::mem::take(&mut self.velocity);
        let (mut coefficient, mut explicit) =
            (std::mem::take(&mut self.coefficient), std::mem::take(&mut self.explicit));
        coefficient.iter_mut().chain(&mut explicit).for_each(|f| f.fill(0.0));
        let zeros = [&self.zeros[..], &self.zeros[..], &self.zeros[..]];
        {
            let fluid = fields(&velocity, &self.void_fraction, zeros);
            let mut drag = DragFields {
                coefficient: coefficient.each_mut().map(|f| f.as_mut_slice()),
                explicit: explicit.each_mut().map(|f| f.as_mut_slice()),
            };
            coupling.deposit_drag(&mut grains.particles, (&self.grid, &fluid), &mut drag, dt, None).unwrap();
        }
        let own = self.own();
        for a in 0..3 {
            self.fold(&mut coefficient[a]);
            self.fold(&mut explicit[a]);
            for &k in &own {
                let inertia = coupling.fluid.density * self.void_fraction[k] * self.cell() / dt;
                if !run.frozen {
                    let push = run.push[a] * self.void_fraction[k] * self.cell();
                    velocity[a][k] =
                        (inertia * velocity[a][k] + explicit[a][k] + push) / (inertia + coefficient[a][k]);
                }
            }
            let pick = |f: &[f64]| own.iter().map(|&k| f[k]).collect::<Vec<_>>();
            ledger.taken[a] +=
                impulse_taken(&pick(&coefficient[a]), &pick(&explicit[a]), &pick(&velocity[a]), dt);
            self.fill(&mut velocity[a]);
        }
        let fluid = fields(&velocity, &self.void_fraction, zeros);
        coupling.set_fluid_velocities(&mut grains.particles, (&self.grid, &fluid), dt).unwrap();
        (self.velocity, self.coefficient, self.explicit) = (velocity, coefficient, explicit);
        for _ in 0..run.sub_steps {
            add_drag(&mut grains.particles, &grains.rates, ledger);
            grains.advance();
        }
    }

    fn momentum(&self, density: f64) -> Vec3 {
        let own = self.own();
        let sum = |a: usize| own.iter().map(|&k| self.velocity[a][k] * self.void_fraction[k]).sum::<f64>();
        Vec3::from_fn(|a, _| density * self.cell() * sum(a))
    }
}

struct Run {
    sub_steps: usize,
    push: Vec3,
    frozen: bool,
}

fn fields<'a>(
    velocity: &'a [Vec<f64>; 3],
    void_fraction: &'a [f64],
    zeros: [&'a [f64]; 3],
) -> FluidFields<'a> {
    FluidFields {
        velocity: [&velocity[0], &velocity[1], &velocity[2]],
        void_fraction,
        pressure_gradient: zeros,
    }
}

fn coupling(law: DragLaw, model: MixtureModel, fluid: Fluid, grains: &Grains) -> Coupling {
    Coupling::new(Kernel::Cube, law, model, fluid, grains.rates.gravity, &grains.catalogue).unwrap()
}

#[test]
fn relaxation_is_the_mean_of_an_exponential() {
    for k in -200..30 {
        let x = 10f64.powf(0.1 * f64::from(k));
        assert!((relaxation(x) + (-x).exp_m1() / x).abs() < 4e-16, "{x}");
    }
    assert_eq!(relaxation(0.0), 1.0);
}

/// m dv/dt = F + K (w − v) by any number of steps has the closed solution.
#[test]
fn drag_of_stokes_is_integrated_exactly() {
    let (mass, coefficient, other) = (2e-6, 3e-4, Vec3::new(1e-6, 0.0, -2e-5));
    let (start, fluid) = (Vec3::new(0.3, -0.1, 0.0), Vec3::new(0.0, 0.2, 0.5));
    let tau = mass / coefficient;
    for steps in [1, 7, 100] {
        for total in [0.01 * tau, tau, 30.0 * tau] {
            let mut link = DragLink::default();
            link.linearise(&Coefficient { value: coefficient, exponent: 0.0 }, &(fluid - start));
            link.set_fluid_velocity(&fluid, &start, total);
            let (dt, mut v) = (total / f64::from(steps), start);
            let before = link.unpaid;
            for _ in 0..steps {
                let drag = link.force(&v, &other, mass, dt);
                v += (drag + other) * (dt / mass);
            }
            let end = fluid + other / coefficient;
            let expected = end + (start - end) * (-total / tau).exp();
            assert!((v - expected).norm() < 1e-14, "{steps} {total}: {v} {expected}");
            let given = (v - start) * mass - other * total;
            let scale = coefficient * total + mass;
            assert!((link.unpaid - before - given).norm() < 1e-14 * scale);
            assert_eq!(DragLink::read(&link.write()), link);
        }
    }
}

/// A grain falls through resting air: its speed after long, for steps from a hundredth to ten relaxation times.
#[test]
fn a_grain_reaches_its_terminal_velocity_with_any_step() {
    let worst = std::cell::Cell::new(0.0f64);
    for (law, diameter, model) in [
        (DragLaw::SchillerNaumann, 50e-6, MixtureModel::A),
        (DragLaw::Beetstra, 300e-6, MixtureModel::A),
        (DragLaw::DiFelice, 2e-3, MixtureModel::B),
        (DragLaw::HoelzerSommerfeld, 2e-2, MixtureModel::B),
    ] {
        let length = 30.0 * diameter;
        let bed = Bed {
            fluid: AIR,
            solid_density: 2500.0,
            diameter,
            shape: ShapeFactors::SPHERE,
            void_fraction: 1.0,
            gravity: GRAVITY,
        };
        let terminal = bed.terminal_velocity(law).unwrap();
        let tau = terminal / GRAVITY;
        for (ratio, sub_steps) in [(0.01, 1), (0.1, 4), (1.0, 1), (1.0, 10), (10.0, 1), (10.0, 20)] {
            let dt = ratio * tau / sub_steps as f64;
            let mut grains = Grains::new(diameter, 2500.0, falling(dt), &[Vec3::repeat(0.4 * length)]);
            let coupling = coupling(law, model, AIR, &grains);
            let mut parcel = Parcel::new(length, 2, 1);
            let mut ledger = MomentumLedger::default();
            let run = Run { sub_steps, push: Vec3::zeros(), frozen: true };
            for _ in 0..((20.0 / ratio) as usize).max(40) {
                parcel.step(&coupling, &mut grains, &mut ledger, &run);
            }
            let error = (-grains.particles.bodies[0].velocity.z / terminal - 1.0).abs();
            assert!(error < 1e-3, "{law:?} at dt = {ratio} tau in {sub_steps}: {error:e}");
            worst.set(worst.get().max(error));
            let rest = ledger.imbalance(&grains.particles).norm();
            assert!(rest < 1e-12 * ledger.given.norm(), "{rest:e}");
        }
    }
    println!("largest error of a terminal velocity: {:e}", worst.get());
}

/// The transient of a grain from rest is that of the equation of motion, first order in the fluid's step.
#[test]
fn a_grain_speeds_up_as_its_law_wants() {
    let diameter: f64 = 300e-6;
    let law = DragLaw::Beetstra;
    let mass = 2500.0 * std::f64::consts::PI / 6.0 * diameter.powi(3);
    let weight = mass * GRAVITY * (1.0 - AIR.density / 2500.0);
    let end = 0.2;
    // Reference by many midpoint steps.
    let acceleration = |v: f64| {
        let flow = grains_coupling::Flow {
            reynolds: AIR.reynolds(diameter, 1.0, v),
            void_fraction: 1.0,
            shape: ShapeFactors::SPHERE,
        };
        (weight - law.coefficient(&AIR, diameter, &flow) * v) / mass
    };
    let steps = 20000;
    let h = end / f64::from(steps);
    let exact = (0..steps).fold(0.0, |v: f64, _| v + h * acceleration(v + 0.5 * h * acceleration(v)));
    let mut errors = Vec::new();
    for n in [50, 100, 200] {
        let dt = end / f64::from(n);
        let length = 30.0 * diameter;
        let mut grains = Grains::new(diameter, 2500.0, falling(dt), &[Vec3::repeat(0.4 * length)]);
        let coupling = coupling(law, MixtureModel::A, AIR, &grains);
        let mut parcel = Parcel::new(length, 2, 1);
        let mut ledger = MomentumLedger::default();
        let run = Run { sub_steps: 1, push: Vec3::zeros(), frozen: true };
        for _ in 0..n {
            parcel.step(&coupling, &mut grains, &mut ledger, &run);
        }
        errors.push((-grains.particles.bodies[0].velocity.z - exact).abs() / exact);
    }
    println!("transient: {errors:?}");
    assert!(errors[2] < 2e-3 && errors[2] < 0.6 * errors[1] && errors[1] < 0.6 * errors[0], "{errors:?}");
}

/// Many grains and a fluid that they drag along: momentum to rounding, and no oscillation, from loads of a thousandth
/// to ten thousand times the fluid's mass and steps from a hundredth to ten times the relaxation time.
#[test]
fn momentum_is_kept_and_stiff_drag_stays_quiet() {
    let diameter: f64 = 1e-3;
    let length = 8e-3;
    let places: Vec<Vec3> = (0..64)
        .map(|k| Vec3::new((k % 4) as f64, (k / 4 % 4) as f64, (k / 16) as f64) * 2e-3 + Vec3::repeat(0.7e-3))
        .collect();
    let mut worst = 0.0f64;
    for density in [1.0, 2500.0, 2.5e7] {
        for ratio in [0.01, 1.0, 10.0] {
            let fluid = Fluid { density: 1.2, viscosity: 1.8e-3 };
            let slow = DragLaw::Beetstra.coefficient(
                &fluid,
                diameter,
                &grains_coupling::Flow { reynolds: 0.0, void_fraction: 0.93, shape: ShapeFactors::SPHERE },
            );
            let mass = density * std::f64::consts::PI / 6.0 * diameter.powi(3);
            let sub_steps = 5;
            let dt = ratio * mass / slow / sub_steps as f64;
            let mut grains = Grains::new(diameter, density, weightless(dt), &places);
            let coupling = coupling(DragLaw::Beetstra, MixtureModel::B, fluid, &grains);
            let mut parcel = Parcel::new(length, 4, 1);
            let start = Vec3::new(1e-8, 0.0, 0.0);
            parcel.set_velocity(&start);
            let mut ledger = MomentumLedger::default();
            let run = Run { sub_steps, push: Vec3::zeros(), frozen: false };
            let mut slip = 1.0;
            let before = fluid.density * start.x * (length.powi(3) - 64.0 * mass / density);
            for _ in 0..60 {
                parcel.step(&coupling, &mut grains, &mut ledger, &run);
                let velocity = &grains.particles.half_velocity[0];
                let now = (parcel.velocity[0][parcel.own()[0]] - velocity.x) / start.x;
                assert!(
                    now > -1e-9 && now <= slip + 1e-9,
                    "density {density}, dt {ratio} tau: {now} after {slip}"
                );
                slip = now;
                let rest = ledger.imbalance(&grains.particles).norm() / ledger.given.norm();
                worst = worst.max(rest);
            }
            let given: Vec3 = grains.particles.half_velocity.iter().sum::<Vec3>() * mass;
            let after = parcel.momentum(fluid.density) + given - unpaid_impulse(&grains.particles);
            assert!((after.x / before - 1.0).abs() < 1e-11, "{} of {before}", after.x);
            let expected = (-60.0 * ratio).exp();
            assert!(slip < 0.2 + expected, "density {density}, dt {ratio} tau: {slip}");
        }
    }
    println!("largest imbalance of the ledger: {worst:e}");
    assert!(worst < 1e-11, "{worst:e}");
}

/// A fixed lattice in a driven fluid: steady slip where drag balances the push, in one very long step and in many.
#[test]
fn a_fixed_lattice_has_the_pressure_drop_of_its_law() {
    let diameter: f64 = 1e-3;
    // 27 cells of one sphere each: ε = 0.4764 for touching spheres; a little looser here, so that none touch.
    let spacing = 1.02e-3;
    let length = 3.0 * spacing;
    let places: Vec<Vec3> = (0..27)
        .map(|k| {
            (Vec3::new((k % 3) as f64, (k / 3 % 3) as f64, (k / 9) as f64) + Vec3::repeat(0.4)) * spacing
        })
        .collect();
    let void_fraction = 1.0 - std::f64::consts::PI / 6.0 * (diameter / spacing).powi(3);
    let bed = Bed {
        fluid: AIR,
        solid_density: 2500.0,
        diameter,
        shape: ShapeFactors::SPHERE,
        void_fraction,
        gravity: GRAVITY,
    };
    for law in [DragLaw::Beetstra, DragLaw::Ergun, DragLaw::Gidaspow, DragLaw::DiFelice] {
        for model in [MixtureModel::A, MixtureModel::B] {
            for (dt, steps) in [(1e-5, 4000), (1.0, 60)] {
                let superficial = 0.3;
                let mut grains = Grains::new(diameter, 1e12, weightless(dt), &places);
                let coupling = coupling(law, model, AIR, &grains);
                let mut parcel = Parcel::new(length, 3, 1);
                // The push per volume of fluid that model A's ε (−∇p), or model B's −∇p, makes.
                let gradient = bed.pressure_gradient(law, superficial);
                let push = gradient * model.fluid_pressure_factor(void_fraction) / void_fraction;
                let run = Run { sub_steps: 1, push: Vec3::new(push, 0.0, 0.0), frozen: false };
                let mut ledger = MomentumLedger::default();
                for _ in 0..steps {
                    parcel.step(&coupling, &mut grains, &mut ledger, &run);
                }
                let reached = parcel.velocity[0][parcel.own()[0]] * void_fraction;
                let error = (reached / superficial - 1.0).abs();
                assert!(error < 1e-6, "{law:?} {model:?} dt {dt}: {reached} ({error:e})");
            }
        }
    }
}

/// In the pressure gradient that a homogeneous bed makes, both models push the grains alike.
#[test]
fn both_models_push_grains_alike() {
    let diameter: f64 = 1e-3;
    let length = 6e-3;
    let places: Vec<Vec3> = (0..27)
        .map(|k| (Vec3::new((k % 3) as f64, (k / 3 % 3) as f64, (k / 9) as f64) + Vec3::repeat(0.4)) * 2e-3)
        .collect();
    let forces = [MixtureModel::A, MixtureModel::B].map(|model| {
        let mut grains = Grains::new(diameter, 2500.0, falling(1e-6), &places);
        let coupling = coupling(DragLaw::Beetstra, model, AIR, &grains);
        let mut parcel = Parcel::new(length, 3, 1);
        parcel.set_velocity(&Vec3::new(0.0, 0.0, 0.7));
        let void_fraction = 1.0 - std::f64::consts::PI / 6.0 / 8.0;
        parcel.void_fraction.fill(void_fraction);
        let slip = Vec3::new(0.0, 0.0, 0.7);
        let drag = coupling.drag(&grains.particles, 0, &slip, void_fraction).value * 0.7;
        let gradient = -27.0 * drag / length.powi(3) / model.fluid_pressure_factor(void_fraction);
        let (zeros, gradients) = (parcel.zeros.clone(), vec![gradient; parcel.zeros.len()]);
        let fluid = fields(&parcel.velocity, &parcel.void_fraction, [&zeros, &zeros, &gradients]);
        grains.particles.cargo.iter_mut().for_each(|cargo| {
            let mut link = DragLink::read(cargo);
            link.linearise(&Coefficient { value: drag / 0.7, exponent: 0.3 }, &slip);
            *cargo = link.write();
        });
        coupling.set_fluid_velocities(&mut grains.particles, (&parcel.grid, &fluid), 1e-6).unwrap();
        let link = DragLink::read(&grains.particles.cargo[0]);
        link.pressure.z + link.coefficient * link.target.z
    });
    assert!((forces[0] / forces[1] - 1.0).abs() < 1e-12, "{forces:?}");
}

/// The loads make `Dem::advance` do the same as the kick above, to its rounding of forces.
#[test]
fn a_dem_step_relaxes_its_grains_exactly() {
    let (diameter, dt) = (300e-6, 2e-4);
    let place = Vec3::repeat(4e-3);
    let mut grains = Grains::new(diameter, 2500.0, falling(dt), &[place]);
    let setup = DemSetup {
        rebuilds_together: false,
        global: GlobalBox::new([0.0; 3], [8e-3; 3], [true; 3]),
        shear: None,
        outlets: [false; 6],
        ranks: [1; 3],
        catalogue: grains.catalogue.clone(),
        walls: Vec::new(),
        planes: Vec::new(),
        parameters: falling(dt),
        largest_radius: 0.5 * diameter,
        overlap_limit: 0.5,
        skin: Skin::default(),
        bonds: Vec::new(),
        lubrication: None,
        prescribed: Vec::new(),
        balance: None,
        exchange: Default::default(),
        collisions: CollisionModel::Soft,
        thermal: None,
        species: Vec::new(),
    };
    let mut dem = Dem::new(setup, 0).unwrap();
    dem.insert(&record(0, &place, &grains.catalogue, &falling(dt)));
    let mass = dem.particles.bodies[0].mass;
    let drag = Coefficient { value: 2.0 * mass / dt, exponent: 0.0 };
    let fluid = Vec3::new(0.02, 0.0, 0.03);
    let mut ledger = MomentumLedger::default();
    let mut link = DragLink::default();
    link.linearise(&drag, &fluid);
    link.set_fluid_velocity(&fluid, &Vec3::zeros(), dt);
    dem.particles.carry();
    dem.particles.cargo[0] = link.write();
    grains.particles.cargo[0] = link.write();
    for _ in 0..20 {
        dem.refresh(&SerialTransport).unwrap();
        dem.add_forces(&SerialTransport);
        add_drag(&mut dem.particles, &falling(dt), &mut ledger);
        dem.advance(&SerialTransport).unwrap();
        add_drag(&mut grains.particles, &falling(dt), &mut ledger);
        grains.advance();
        let difference = dem.particles.half_velocity[0] - grains.particles.half_velocity[0];
        assert!(difference.norm() < 1e-13, "{difference}");
    }
    let terminal = fluid - Vec3::new(0.0, 0.0, GRAVITY * dt / 2.0);
    assert!((dem.particles.half_velocity[0] - terminal).norm() < 1e-12);
}

/// The law for any shape sees how a body lies: a rod resists more across the flow, in the world's frame.
#[test]
fn a_rod_is_dragged_as_it_lies() {
    let rates = weightless(1e-5);
    let mut grains = Grains::new(1e-3, 2500.0, rates, &[]);
    grains.catalogue.shapes[0] = Shape::cylinder(0.5e-3, 4e-3, 0.02).unwrap();
    grains.particles = Particles::new(false);
    for (id, turn) in [Rotation::identity(), Rotation::from_euler_angles(1.0, 0.0, 0.0)].iter().enumerate() {
        let upright = record(id, &Vec3::repeat(5e-3), &grains.catalogue, &rates);
        grains.particles.push(&ParticleRecord { orientation: *turn, ..upright });
    }
    let fluid = Fluid { density: 1000.0, viscosity: 1e-3 };
    let coupling = coupling(DragLaw::HoelzerSommerfeld, MixtureModel::A, fluid, &grains);
    let drag = |i: usize, flow: Vec3| coupling.drag(&grains.particles, i, &(flow * 0.2), 0.9).value;
    let (along, across) = (drag(0, Vec3::z()), drag(0, Vec3::x()));
    assert!(across > 1.5 * along, "{across} {along}");
    // Turned by a radian about x, its axis is (0, −sin 1, cos 1).
    let axis = Vec3::new(0.0, -1f64.sin(), 1f64.cos());
    assert!((drag(1, axis) / along - 1.0).abs() < 1e-12);
    assert!((drag(1, Vec3::x()) / across - 1.0).abs() < 1e-12);
    let volume = std::f64::consts::PI * 1e-9;
    assert!((coupling.volume(&grains.particles.bodies[0]) / volume - 1.0).abs() < 1e-12);
    assert!(drag(0, Vec3::zeros()) > 0.0);
}
