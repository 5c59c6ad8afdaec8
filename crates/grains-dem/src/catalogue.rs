//! What particles are made of: shapes, materials, and the law of every pair of materials.

use crate::films::MaterialFilms;
use crate::particles::{Body, Kind};
use grains_contact::{ContactLaw, PreparedLaw, Sharing, sphere_radius};
use grains_geometry::{Shape, Vec3};

/// The law of a pair of materials.
#[derive(Clone, Debug)]
struct PairLaws {
    law: ContactLaw,
    prepared: PreparedLaw,
    /// Largest gap (m) at which bodies that touched act on each other.
    reach: f64,
}

/// Contact laws by pair of materials, and the liquid on these.
#[derive(Clone, Debug)]
pub struct ContactTable {
    laws: Vec<Option<PairLaws>>,
    materials: usize,
    reach: f64,
    films: Option<MaterialFilms>,
}

impl ContactTable {
    /// Table without laws for a number of materials.
    pub fn new(materials: usize) -> Self {
        Self { laws: vec![None; materials * materials], materials, reach: 0.0, films: None }
    }

    /// Puts films of liquid on the materials.
    pub fn wet(&mut self, films: MaterialFilms) {
        self.films = Some(films);
    }

    /// The films on the materials, in runs of bridges that these feed.
    #[inline(always)]
    pub fn films(&self) -> Option<&MaterialFilms> {
        self.films.as_ref()
    }

    /// Sets the law between two materials, in either order.
    pub fn set(&mut self, a: usize, b: usize, law: ContactLaw) {
        for place in [a * self.materials + b, b * self.materials + a] {
            self.laws[place] = Some(PairLaws { law, prepared: law.prepared(), reach: 0.0 });
        }
    }

    /// Prepares the table for bodies up to this bounding radius (m).
    pub(crate) fn prepare(&mut self, largest_radius: f64) {
        for of in self.laws.iter_mut().flatten() {
            of.reach = of.law.reach(largest_radius);
        }
        self.reach = self.reach_up_to(largest_radius);
    }

    /// Largest gap (m) at which bodies of two materials that touched act on each other.
    #[inline(always)]
    pub(crate) fn reach_between(&self, a: u16, b: u16) -> f64 {
        if self.reach == 0.0 { 0.0 } else { self.laws_of(a, b).reach }
    }

    /// Largest gap (m) at which bodies of the run that touched act on each other.
    #[inline(always)]
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }

    /// The same for bodies up to a bounding radius (m).
    pub fn reach_up_to(&self, radius: f64) -> f64 {
        self.laws().map(|law| law.reach(radius)).fold(0.0, f64::max)
    }

    /// Largest force (N) of bodies up to this bounding radius (m) and overlap (m).
    pub(crate) fn force_bound(&self, radius: f64, overlap: f64) -> f64 {
        self.laws().map(|law| law.force_bound(radius, overlap)).fold(f64::MIN_POSITIVE, f64::max)
    }

    /// Law between two materials; the case guarantees one for every pair that can meet.
    #[inline(always)]
    pub fn law(&self, a: u16, b: u16) -> &ContactLaw {
        &self.laws_of(a, b).law
    }

    /// The same ready for any reduced mass.
    #[inline(always)]
    pub fn prepared(&self, a: u16, b: u16) -> &PreparedLaw {
        &self.laws_of(a, b).prepared
    }

    #[inline(always)]
    fn laws_of(&self, a: u16, b: u16) -> &PairLaws {
        match &self.laws[a as usize * self.materials + b as usize] {
            Some(laws) => laws,
            None => panic!("materials {a} and {b} touch but have no contact law"),
        }
    }

    /// Whether a law keeps more of a contact than its tangential displacement.
    pub(crate) fn keep_law_history(&self) -> bool {
        self.laws.iter().flatten().any(|of| of.prepared.keeps_more())
    }

    /// All laws.
    pub fn laws(&self) -> impl Iterator<Item = &ContactLaw> {
        self.laws.iter().flatten().map(|of| &of.law)
    }
}

/// How bodies touch whose nearest points are not unique: face on face, edge on face, side on side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaceContact {
    /// In one point of those nearest, as GJK finds it (thesis 3.3).
    #[default]
    Point,
    /// Multi-point: at the corners of their common face or line, which share the force.
    MultiPoint,
}

/// Shapes, densities and contact laws of a case.
#[derive(Clone, Debug)]
pub struct Catalogue {
    /// Particle shapes at scale 1.
    pub shapes: Vec<Shape>,
    /// Density of each material (kg/m³).
    pub densities: Vec<f64>,
    /// Contact laws.
    pub contacts: ContactTable,
    /// How touching faces and lines act.
    pub faces: FaceContact,
    /// What several contacts of one pair of bodies do together.
    pub sharing: Sharing,
}

impl Catalogue {
    /// Whether every shape is a sphere, so that no orientation is needed.
    pub fn all_spheres(&self) -> bool {
        self.shapes.iter().all(Shape::is_sphere)
    }

    /// Shape of a kind.
    #[inline(always)]
    pub fn shape(&self, kind: Kind) -> &Shape {
        &self.shapes[kind.shape as usize]
    }

    /// Inscribed radius of a particle (m).
    #[inline]
    pub fn inscribed_radius(&self, body: &Body) -> f64 {
        let shape = self.shape(body.kind);
        shape.inscribed_radius * (body.radius / shape.bounding_radius)
    }

    /// Smaller inscribed radius of two particles (m).
    #[inline]
    pub fn smaller_inscribed_radius(&self, [a, b]: [&Body; 2]) -> f64 {
        self.inscribed_radius(a).min(self.inscribed_radius(b))
    }

    /// Mass ρ V s³ (kg) of a kind at scale s.
    pub fn mass(&self, kind: Kind, scale: f64) -> f64 {
        self.densities[kind.material as usize] * self.shape(kind).volume * scale.powi(3)
    }

    /// Sum of the largest inverse moments of inertia (1/(kg m²)) of bodies under a law that asks for it, else 0.
    #[inline]
    pub(crate) fn inverse_inertia<const N: usize>(&self, bodies: [&Body; N], law: &PreparedLaw) -> f64 {
        if law.has_couples() { self.largest_inverse_inertia(bodies) } else { 0.0 }
    }

    /// Sum of the largest inverse moments of inertia (1/(kg m²)) of bodies that move freely.
    #[inline]
    pub(crate) fn largest_inverse_inertia<const N: usize>(&self, bodies: [&Body; N]) -> f64 {
        let free = bodies.into_iter().filter(|body| !body.is_prescribed());
        free.map(|body| 1.0 / self.inertia(body).min()).sum()
    }

    /// Radius R (m) that laws take for a body, the ball of the mean volume of its parts, if they take one, else 1.
    ///
    /// It does not depend on where a body is touched, so that forces have a potential: faces, edges and corners are as round as the
    /// ball.
    #[inline]
    pub(crate) fn contact_radius(&self, body: &Body, law: &PreparedLaw) -> f64 {
        if law.takes_radius() { self.part_radius(body) } else { 1.0 }
    }

    /// Radius (m) of the ball of the mean volume of a body's parts.
    #[inline]
    pub(crate) fn part_radius(&self, body: &Body) -> f64 {
        let shape = self.shape(body.kind);
        shape.part_radius() * (body.radius / shape.bounding_radius)
    }

    /// Radius (m) of the sphere of a body's volume.
    pub(crate) fn solid_radius(&self, body: &Body) -> f64 {
        let shape = self.shape(body.kind);
        if shape.is_sphere() {
            return body.radius;
        }
        sphere_radius(shape.volume) * (body.radius / shape.bounding_radius)
    }

    /// Volume (m³) of a body.
    pub(crate) fn volume(&self, body: &Body) -> f64 {
        let shape = self.shape(body.kind);
        shape.volume * (body.radius / shape.bounding_radius).powi(3)
    }

    /// R1 R2/(R1 + R2) (m) of the radii that the law takes, 1/2 if it takes none.
    #[inline]
    pub(crate) fn effective_radius(&self, bodies: [&Body; 2], law: &PreparedLaw) -> f64 {
        if !law.takes_radius() {
            return 0.5;
        }
        let [a, b] = bodies.map(|body| self.part_radius(body));
        a * b / (a + b)
    }

    /// Principal moments of inertia (kg m²) of a particle: ρ s⁵ ∫ …, from its mass m = ρ V s³.
    #[inline]
    pub fn inertia(&self, body: &Body) -> Vec3 {
        let shape = self.shape(body.kind);
        let scale = body.radius / shape.bounding_radius;
        shape.inertia * (body.mass / shape.volume * (scale * scale))
    }
}
