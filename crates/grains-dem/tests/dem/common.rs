//! Granular systems for tests.

use grains_contact::{ContactLaw, Rolling, Tangential};
use grains_dem::{
    BodyFilm, Catalogue, CollisionModel, ContactTable, Dem, DemSetup, FILM_LENGTH, FlowPlane, Kind,
    LiquidLedger, Motion, NewParticle, ParticleRecord, Skin, StepParameters, Surface, Wall,
};
use grains_domain::{GlobalBox, Transport};
use grains_geometry::{Lobes, RegularSolid, Rotation, Shape, Spacing, SphereArrangement, Vec3};
use grains_testing::on_ranks;

/// Numbers that look random.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Index below n.
    pub fn index(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    pub fn vector(&mut self) -> Vec3 {
        Vec3::from_fn(|_, _| 2.0 * self.unit() - 1.0)
    }

    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector();
            if (0.1..1.0).contains(&v.norm()) {
                return v.normalize();
            }
        }
    }
}

/// A particle's whole state, as bits.
pub type Bits = Vec<u64>;

/// States of all particles by id, and their contact history.
pub type State = Vec<(u64, Bits)>;

/// The state this rank holds.
pub fn state_of(dem: &Dem) -> State {
    let (lengths, packed) = dem.packed_history();
    let mut rest = &packed[..];
    let mut state = Vec::new();
    for (i, &length) in lengths.iter().enumerate() {
        let mut record = dem.particles.record(i);
        record.body.position = Vec3::from(dem.setup.global.wrap(record.body.position.into()));
        // Sides are brought up to date when crossings are counted, not in every step.
        record.sides = 0;
        let mut numbers = Vec::new();
        record.write(&mut numbers);
        let (history, after) = rest.split_at(length as usize);
        rest = after;
        let mut bits: Bits = numbers.iter().map(|x| x.to_bits()).collect();
        // The order of histories within a row follows the lists: compare them sorted.
        let mut history: Bits = history.iter().map(|x| x.to_bits()).collect();
        history.sort_unstable();
        bits.extend(history);
        let film = dem.particles.films.get(i).map(BodyFilm::numbers);
        bits.extend(film.into_iter().flatten().map(f64::to_bits));
        state.push((record.id, bits));
    }
    state
}

/// Asserts that two states agree bit for bit.
pub fn assert_same(a: &State, b: &State, what: &str) {
    assert_eq!(a.len(), b.len(), "{what}: number of particles");
    for (p, q) in a.iter().zip(b) {
        assert_eq!(p.0, q.0, "{what}: identities");
        let first = (0..p.1.len().max(q.1.len())).find(|&k| p.1.get(k) != q.1.get(k));
        assert_eq!(
            first,
            None,
            "{what}: particle {} differs first in word {first:?} of {} and {}",
            p.0,
            p.1.len(),
            q.1.len()
        );
    }
}

/// All ranks' states merged, by id.
pub fn merged(states: Vec<State>) -> State {
    let mut all: State = states.into_iter().flatten().collect();
    all.sort();
    all
}

/// A system for tests: its definition and its particles.
pub struct Scene {
    pub setup: DemSetup,
    pub particles: Vec<NewParticle>,
}

impl Scene {
    /// Runs `steps` steps on a grid of ranks and returns the final state.
    pub fn run(&self, ranks: [usize; 3], steps: u64) -> State {
        merged(on_ranks(ranks.iter().product(), |transport| {
            let mut dem = self.start(ranks, transport.rank());
            for _ in 0..steps {
                dem.step(&transport).unwrap();
            }
            assert!(dem.check_ledger(&transport).is_ok());
            state_of(&dem)
        }))
    }

    /// Contacts of all particles on one rank after a number of steps.
    pub fn contacts_after(&self, steps: u64) -> usize {
        on_ranks(1, |transport| {
            let mut dem = self.start([1; 3], 0);
            for _ in 0..steps {
                dem.step(&transport).unwrap();
            }
            let mut contacts = 0;
            dem.for_each_contact(|_| contacts += 1);
            contacts
        })
        .iter()
        .sum()
    }

    /// One rank's system at step 0.
    pub fn start(&self, ranks: [usize; 3], rank: usize) -> Dem {
        let mut dem = Dem::new(DemSetup { ranks, ..self.setup.clone() }, rank).unwrap();
        for particle in &self.particles {
            if dem.owns(&particle.position) {
                let record = particle.record(&dem);
                dem.insert(&record);
            }
        }
        dem.announce_insertion();
        dem
    }

    /// Runs `before` steps on one grid of ranks, stops, and `after` more on another.
    pub fn run_with_restart(&self, first: [usize; 3], before: u64, second: [usize; 3], after: u64) -> State {
        self.go_on(second, &self.stop_after(first, before), after)
    }

    /// Where a run on a grid of ranks stops after some steps.
    pub fn stop_after(&self, ranks: [usize; 3], steps: u64) -> Stopped {
        let parts = on_ranks(ranks.iter().product(), |transport| {
            let mut dem = self.start(ranks, transport.rank());
            for _ in 0..steps {
                dem.step(&transport).unwrap();
            }
            dem.refresh(&transport).unwrap();
            Stopped::of(&dem)
        });
        Stopped::joined(parts)
    }

    /// Runs some more steps on a grid of ranks.
    pub fn go_on(&self, ranks: [usize; 3], from: &Stopped, steps: u64) -> State {
        merged(on_ranks(ranks.iter().product(), |transport| {
            let mut dem = self.resume(ranks, transport.rank(), from, |_| ());
            for _ in 0..steps {
                dem.step(&transport).unwrap();
            }
            state_of(&dem)
        }))
    }

    /// One rank's system where another stopped; `prepare` sets what walls are placed by.
    pub fn resume(
        &self,
        ranks: [usize; 3],
        rank: usize,
        from: &Stopped,
        prepare: impl FnOnce(&mut Dem),
    ) -> Dem {
        let mut dem = Dem::new(DemSetup { ranks, ..self.setup.clone() }, rank).unwrap();
        prepare(&mut dem);
        dem.resume_at(from.step);
        dem.made_bonds.clone_from(&from.made_bonds);
        for (k, (record, history)) in from.particles.iter().enumerate() {
            if dem.owns(&record.body.position) {
                dem.restore(record, history);
                if let Some(film) = from.films.get(k) {
                    dem.restore_film(Some(*film));
                }
            }
        }
        if rank == 0 {
            dem.liquid_ledger = LiquidLedger::from_numbers(from.liquid);
        }
        dem.announce_insertion();
        dem
    }
}

/// What a run continues from: particles with the history of their contacts and their films, the ledger of liquid, kinds of bonds
/// made, steps done.
pub struct Stopped {
    pub particles: Vec<(ParticleRecord, Vec<f64>)>,
    pub films: Vec<[f64; FILM_LENGTH]>,
    pub liquid: [u128; 6],
    pub made_bonds: Vec<bool>,
    pub step: u64,
}

impl Stopped {
    /// That of all ranks.
    pub fn joined(parts: Vec<Self>) -> Self {
        let mut parts = parts.into_iter();
        let mut all = parts.next().unwrap();
        for part in parts {
            all.particles.extend(part.particles);
            all.films.extend(part.films);
            all.liquid.iter_mut().zip(part.liquid).for_each(|(sum, own)| *sum += own);
        }
        all
    }

    /// That of a system whose lists are fresh.
    pub fn of(dem: &Dem) -> Self {
        let (lengths, packed) = dem.packed_history();
        let mut rest = &packed[..];
        let row = |(i, &length): (usize, &u32)| {
            let (own, after) = rest.split_at(length as usize);
            rest = after;
            (dem.saved_record(i), own.to_vec())
        };
        let particles = lengths.iter().enumerate().map(row).collect();
        Self {
            particles,
            films: dem.particles.films[..dem.particles.films.len().min(dem.particles.owned)]
                .iter()
                .map(BodyFilm::numbers)
                .collect(),
            liquid: dem.liquid_ledger.numbers(),
            made_bonds: dem.made_bonds.clone(),
            step: dem.step,
        }
    }
}

/// Laws used in the tests: springs, or viscous resistance, against sliding and rolling.
pub fn law(spring: bool) -> ContactLaw {
    let (tangential, rolling) = if spring {
        (Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 }, Rolling::spring(0.01))
    } else {
        (Tangential::Viscous { rate: 5e3 }, Rolling::Viscous { friction: 0.01 })
    };
    ContactLaw::linear(1e5, 0.75, 0.5, tangential).with_rolling(rolling)
}

pub fn wall(name: &str, surface: Surface, motion: Motion) -> Wall {
    Wall {
        name: name.into(),
        material: 1,
        surfaces: vec![surface],
        motion,
        from: 0.0,
        until: f64::INFINITY,
        spans: [false; 3],
        wear: None,
        heat: None,
    }
}

/// Definition without particles and walls in a box of a size (m).
pub fn setup(upper: [f64; 3], periodic: [bool; 3], shapes: Vec<Shape>, law: ContactLaw) -> DemSetup {
    let mut contacts = ContactTable::new(2);
    contacts.set(0, 0, law);
    let mut wall_law = law;
    wall_law.friction = 0.3;
    contacts.set(0, 1, wall_law);
    let largest_radius = 1.1 * shapes.iter().map(|s| s.bounding_radius).fold(0.0, f64::max);
    DemSetup {
        rebuilds_together: false,
        global: GlobalBox::new([0.0; 3], upper, periodic),
        shear: None,
        outlets: [false; 6],
        ranks: [1; 3],
        catalogue: Catalogue {
            shapes,
            densities: vec![2500.0, f64::NAN],
            contacts,
            faces: Default::default(),
            sharing: Default::default(),
        },
        walls: Vec::new(),
        planes: vec![FlowPlane {
            name: "middle".into(),
            point: Vec3::repeat(0.5 * upper[0]),
            normal: Vec3::x(),
        }],
        parameters: StepParameters { gravity: Vec3::new(0.0, 0.0, -9.81), dt: 4e-6 },
        largest_radius,
        overlap_limit: 0.3,
        skin: Skin::default(),
        bonds: Vec::new(),
        lubrication: None,
        prescribed: Vec::new(),
        balance: None,
        exchange: Default::default(),
        collisions: CollisionModel::Soft,
        thermal: None,
        species: Vec::new(),
    }
}

/// Particles on a lattice filling a region, with sizes, velocities and orientations that vary.
pub fn lattice(lower: [f64; 3], upper: [f64; 3], spacing: f64, kinds: u16, speed: f64) -> Vec<NewParticle> {
    let n: [usize; 3] = std::array::from_fn(|a| ((upper[a] - lower[a]) / spacing) as usize);
    let mut particles = Vec::new();
    let mut state = 12345_u64;
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    for k in 0..n[0] * n[1] * n[2] {
        let place = [k % n[0], k / n[0] % n[1], k / (n[0] * n[1])];
        let mut vector = |size: f64| Vec3::new(random(), random(), random()) * size;
        let (noise, velocity, spin, axis) =
            (vector(0.02 * spacing), vector(speed), vector(50.0), vector(6.0));
        particles.push(NewParticle {
            // ids in no spatial order
            id: ((k * 7919) % (n[0] * n[1] * n[2])) as u64,
            kind: Kind { shape: k as u16 % kinds, material: 0 },
            scale: 0.9 + 0.1 * random().abs(),
            position: Vec3::from_fn(|a, _| lower[a] + (place[a] as f64 + 0.5) * spacing) + noise,
            orientation: Rotation::new(axis),
            velocity,
            angular_velocity: spin,
            temperature: 0.0,
        });
    }
    let count = particles.len();
    let mut ids: Vec<u64> = particles.iter().map(|p| p.id).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count, "identities must be unique");
    particles
}

/// Spheres, cubes, cylinders and icosahedra of like size (m).
pub fn mixed_shapes(radius: f64) -> Vec<Shape> {
    vec![
        Shape::sphere(radius).unwrap(),
        Shape::cuboid(Vec3::new(1.1, 1.0, 0.9) * radius, 0.05).unwrap(),
        Shape::cylinder(0.6 * radius, 1.3 * radius, 0.05).unwrap(),
        Shape::regular(RegularSolid::Icosahedron, radius, 0.05).unwrap(),
    ]
}

/// A trilobe, a cross, nine spheres, an ellipsoid, a block, a superellipsoid met by its vertices, a capsule and a
/// frustum, of like size (m).
pub fn knobbly_shapes(radius: f64) -> Vec<Shape> {
    let lobes = Lobes::with_area_fraction(3, 0.6 * radius, 0.69).unwrap();
    let nine = SphereArrangement::touching(1, vec![1, 8], 0.8 * radius);
    let vertices = Shape::superellipsoid(Vec3::new(0.6, 0.7, 0.9) * radius, [1.0, 0.8], 0.05).unwrap();
    vec![
        Shape::lobes(lobes, 1.5 * radius, 0.05).unwrap(),
        Shape::cross(3, 0.38 * radius, 1.9 * radius, 0.05).unwrap(),
        Shape::spheres_of_cylinder(0.8 * radius, 0.8 * radius, &nine).unwrap(),
        Shape::superellipsoid(Vec3::new(1.0, 0.5, 0.5) * radius, [1.0, 1.0], 0.05).unwrap(),
        Shape::superellipsoid(Vec3::repeat(0.6 * radius), [0.25, 0.25], 0.05).unwrap(),
        vertices.with_surface_vertices(20, Spacing::Linear).unwrap(),
        Shape::capsule(0.5 * radius, 1.8 * radius).unwrap(),
        Shape::cone([0.7 * radius, 0.2 * radius], 1.3 * radius, 0.05).unwrap(),
    ]
}
