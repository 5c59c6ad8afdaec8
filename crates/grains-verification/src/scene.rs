//! A sphere on a plane, or two spheres.

use grains_contact::ContactLaw;
use grains_dem::{
    Body, Catalogue, CollisionModel, ContactTable, Dem, DemSetup, Kind, Motion, NewParticle, Skin,
    StepParameters, Surface, Wall,
};
use grains_domain::{GlobalBox, SerialTransport};
use grains_geometry::{Rotation, Shape, Vec3};

/// A ball and how it meets the plane z = 0, or another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    /// Radius (m).
    pub(crate) radius: f64,
    /// Density (kg/m³).
    pub(crate) density: f64,
    /// Gap before it (m); negative where it begins in contact.
    pub(crate) gap: f64,
    /// Velocity (m/s).
    pub(crate) velocity: Vec3,
    /// Angular velocity (rad/s).
    pub(crate) spin: Vec3,
}

impl Ball {
    /// Mass (kg).
    pub(crate) fn mass(&self) -> f64 {
        self.density * 4.0 / 3.0 * std::f64::consts::PI * self.radius.powi(3)
    }
}

/// What a ball meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Against {
    /// The plane z = 0.
    Plane,
    /// Its mirror image in the plane z = 0.
    Twin,
}

impl Against {
    /// Reduced mass (kg) and effective radius (m) of a ball.
    pub(crate) fn reduced(self, ball: &Ball) -> (f64, f64) {
        match self {
            Self::Plane => (ball.mass(), ball.radius),
            Self::Twin => (0.5 * ball.mass(), 0.5 * ball.radius),
        }
    }
}

/// A running encounter.
pub(crate) struct Scene {
    dem: Dem,
    radius: f64,
    middle: Vec3,
    against: Against,
}

impl Scene {
    /// A ball before a plane or its twin, under gravity (m/s²), in steps of `dt` (s).
    pub(crate) fn new(law: ContactLaw, ball: &Ball, against: Against, gravity: Vec3, dt: f64) -> Self {
        let mut contacts = ContactTable::new(2);
        contacts.set(0, 0, law);
        contacts.set(0, 1, law);
        // Wide enough for whatever slides and rolls.
        let half = 400.0 * ball.radius;
        let middle = Vec3::repeat(half);
        let shape = Shape::sphere(ball.radius).unwrap_or_else(|error| panic!("{error}"));
        let plane = Wall {
            name: "plane".into(),
            material: 1,
            surfaces: vec![Surface::Plane { point: middle, normal: Vec3::z() }],
            motion: Motion::Fixed,
            from: 0.0,
            until: f64::INFINITY,
            spans: [false; 3],
            wear: None,
            heat: None,
        };
        let setup = DemSetup {
            rebuilds_together: false,
            global: GlobalBox::new([0.0; 3], [2.0 * half; 3], [false; 3]),
            shear: None,
            outlets: [false; 6],
            ranks: [1; 3],
            catalogue: Catalogue {
                shapes: vec![shape],
                densities: vec![ball.density, f64::NAN],
                contacts,
                faces: Default::default(),
                sharing: Default::default(),
            },
            walls: if against == Against::Plane { vec![plane] } else { Vec::new() },
            planes: Vec::new(),
            parameters: StepParameters { gravity, dt },
            largest_radius: ball.radius,
            overlap_limit: 0.99,
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
        let dem = Dem::new(setup, 0).unwrap_or_else(|error| panic!("{error}"));
        let mut scene = Self { dem, radius: ball.radius, middle, against };
        let share = if against == Against::Plane { 1.0 } else { 0.5 };
        scene.insert(0, Vec3::z() * (ball.radius + share * ball.gap), ball.velocity, ball.spin);
        if against == Against::Twin {
            let mirror = |v: Vec3| Vec3::new(v.x, v.y, -v.z);
            let spin = Vec3::new(-ball.spin.x, -ball.spin.y, ball.spin.z);
            scene.insert(
                1,
                mirror(Vec3::z() * (ball.radius + share * ball.gap)),
                mirror(ball.velocity),
                spin,
            );
        }
        scene
    }

    fn insert(&mut self, id: u64, at: Vec3, velocity: Vec3, angular_velocity: Vec3) {
        let record = NewParticle {
            id,
            kind: Kind::default(),
            scale: 1.0,
            position: self.middle + at,
            orientation: Rotation::identity(),
            velocity,
            angular_velocity,
            temperature: 0.0,
        }
        .record(&self.dem);
        self.dem.insert(&record);
    }

    /// Takes one step.
    pub(crate) fn step(&mut self) {
        self.dem.step(&SerialTransport).unwrap_or_else(|error| panic!("{error:?}"));
    }

    /// The ball.
    pub(crate) fn ball(&self) -> &Body {
        let first = self.dem.particles.ids.iter().position(|&id| id == 0).unwrap_or(0);
        &self.dem.particles.bodies[first]
    }

    /// Overlap with what it meets (m).
    pub(crate) fn overlap(&self) -> f64 {
        let height = self.ball().position.z - self.middle.z;
        match self.against {
            Against::Plane => self.radius - height,
            Against::Twin => 2.0 * (self.radius - height),
        }
    }

    /// Way from where it began (m).
    pub(crate) fn way(&self) -> Vec3 {
        let at = self.ball().position - self.middle;
        Vec3::new(at.x, at.y, 0.0)
    }
}
