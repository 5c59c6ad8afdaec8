//! Ranks as threads, and granular systems for tests.

use grains_contact::{ContactLaw, Tangential};
use grains_dem::{
    Catalogue, CollisionModel, ContactTable, Dem, DemSetup, FlowPlane, Kind, Motion, NewParticle,
    ParticleRecord, Skin, StepParameters, Surface, Wall,
};
use grains_domain::{GlobalBox, Transport};
use grains_geometry::{Lobes, RegularSolid, Rotation, Shape, Spacing, SphereArrangement, Vec3};
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex};

type Mailboxes = HashMap<(usize, usize), VecDeque<Vec<f64>>>;

/// A rank that is a thread of this process.
#[derive(Clone)]
pub struct ThreadTransport {
    rank: usize,
    size: usize,
    post: Arc<(Mutex<Mailboxes>, Condvar)>,
}

impl ThreadTransport {
    fn send(&self, to: usize, message: Vec<f64>) {
        self.post.0.lock().unwrap().entry((self.rank, to)).or_default().push_back(message);
        self.post.1.notify_all();
    }

    fn receive(&self, from: usize) -> Vec<f64> {
        let mut boxes = self.post.0.lock().unwrap();
        loop {
            if let Some(message) = boxes.get_mut(&(from, self.rank)).and_then(VecDeque::pop_front) {
                return message;
            }
            boxes = self.post.1.wait(boxes).unwrap();
        }
    }

    /// What all ranks send here, in rank order.
    fn all_to_all(&self, sent: &[Vec<f64>]) -> Vec<Vec<f64>> {
        (0..self.size).for_each(|r| self.send(r, sent[r].clone()));
        (0..self.size).map(|r| self.receive(r)).collect()
    }
}

impl Transport for ThreadTransport {
    fn rank(&self) -> usize {
        self.rank
    }
    fn size(&self) -> usize {
        self.size
    }
    fn exchange(&self, peers: &[usize], sent: &[Vec<f64>], received: &mut [Vec<f64>]) {
        peers.iter().zip(sent).for_each(|(&p, m)| self.send(p, m.clone()));
        for (&peer, buffer) in peers.iter().zip(received) {
            let message = self.receive(peer);
            assert_eq!(message.len(), buffer.len(), "rank {} expects another length from {peer}", self.rank);
            *buffer = message;
        }
    }
    fn exchange_unsized(&self, peers: &[usize], sent: &[Vec<f64>], received: &mut [Vec<f64>]) {
        peers.iter().zip(sent).for_each(|(&p, m)| self.send(p, m.clone()));
        peers.iter().zip(received).for_each(|(&p, buffer)| *buffer = self.receive(p));
    }
    fn exchange_sparse(&self, sent: Vec<(usize, Vec<f64>)>) -> Vec<(usize, Vec<f64>)> {
        let mut outgoing = vec![Vec::new(); self.size];
        sent.into_iter().for_each(|(rank, message)| outgoing[rank].extend(message));
        let received = self.all_to_all(&outgoing).into_iter().enumerate();
        received.filter(|(_, message)| !message.is_empty()).collect()
    }
    fn highest(&self, level: u8) -> u8 {
        self.gather(&[f64::from(level)]).iter().fold(0, |m, &l| m.max(l as u8))
    }
    fn max(&self, values: &mut [f64]) {
        let all = self.gather(values);
        for (k, v) in values.iter_mut().enumerate() {
            *v = all.iter().skip(k).step_by(all.len() / self.size).fold(f64::NEG_INFINITY, |m, &x| m.max(x));
        }
    }
    fn sum(&self, values: &mut [f64]) {
        let (all, n) = (self.gather(values), values.len());
        for (k, v) in values.iter_mut().enumerate() {
            *v = all.iter().skip(k).step_by(n).sum();
        }
    }
    fn sum_counts(&self, values: &mut [u64]) {
        let mut numbers: Vec<f64> = values.iter().map(|&v| v as f64).collect();
        self.sum(&mut numbers);
        values.iter_mut().zip(numbers).for_each(|(v, n)| *v = n as u64);
    }
    fn counts_before(&self, values: &mut [u64]) {
        let own: Vec<f64> = values.iter().map(|&v| v as f64).collect();
        let before = &self.gather(&own)[..self.rank * own.len()];
        for (k, v) in values.iter_mut().enumerate() {
            *v = before.iter().skip(k).step_by(own.len()).sum::<f64>() as u64;
        }
    }
    fn gather(&self, values: &[f64]) -> Vec<f64> {
        self.all_to_all(&vec![values.to_vec(); self.size]).concat()
    }
}

/// Runs `job` on `size` ranks and returns their results in rank order.
pub fn on_ranks<R: Send>(size: usize, job: impl Fn(ThreadTransport) -> R + Sync) -> Vec<R> {
    let post = Arc::new((Mutex::new(HashMap::new()), Condvar::new()));
    std::thread::scope(|scope| {
        let ranks: Vec<_> = (0..size)
            .map(|rank| {
                let (transport, job) = (ThreadTransport { rank, size, post: post.clone() }, &job);
                scope.spawn(move || job(transport))
            })
            .collect();
        ranks.into_iter().map(|r| r.join().unwrap()).collect()
    })
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
        state.push((record.id, bits));
    }
    state
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
        let saved: Vec<(ParticleRecord, Vec<f64>)> = on_ranks(first.iter().product(), |transport| {
            let mut dem = self.start(first, transport.rank());
            for _ in 0..before {
                dem.step(&transport).unwrap();
            }
            dem.refresh(&transport).unwrap();
            let (lengths, packed) = dem.packed_history();
            let mut rest = &packed[..];
            let mut saved = Vec::new();
            for (i, &length) in lengths.iter().enumerate() {
                let (history, after) = rest.split_at(length as usize);
                rest = after;
                let mut record = dem.particles.record(i);
                record.body.position = Vec3::from(dem.setup.global.wrap(record.body.position.into()));
                saved.push((record, history.to_vec()));
            }
            saved
        })
        .concat();
        merged(on_ranks(second.iter().product(), |transport| {
            let mut dem =
                Dem::new(DemSetup { ranks: second, ..self.setup.clone() }, transport.rank()).unwrap();
            dem.resume_at(before);
            for (record, history) in &saved {
                if dem.owns(&record.body.position) {
                    dem.restore(record, history);
                }
            }
            dem.announce_insertion();
            for _ in 0..after {
                dem.step(&transport).unwrap();
            }
            state_of(&dem)
        }))
    }
}

/// Laws used in the tests: spring or viscous tangential resistance.
pub fn law(spring: bool) -> ContactLaw {
    let tangential = if spring {
        Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 }
    } else {
        Tangential::Viscous { rate: 5e3 }
    };
    ContactLaw::new(1e5, 0.75, 0.5, tangential).with_rolling_friction(0.01)
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
        global: GlobalBox::new([0.0; 3], upper, periodic),
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
        lubrication: None,
        prescribed: Vec::new(),
        balance: None,
        exchange: Default::default(),
        collisions: CollisionModel::Soft,
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

/// A trilobe, a cross, nine spheres, an ellipsoid, a block and a superellipsoid met by its vertices, of like
/// size (m).
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
    ]
}
