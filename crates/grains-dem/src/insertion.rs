//! New particles, and whether there is room for them.

use crate::catalogue::{Catalogue, FaceContact};
use crate::dem::Dem;
use crate::integrate::half_step_back;
use crate::narrow_phase::{PlacedPart, Pose, overlaps};
use crate::particles::{Body, Kind, ParticleRecord};
use crate::periodic_images as images;
use crate::rotation::frame;
use crate::walls::Surface;
use grains_domain::{SIZE_CLASSES, size_class};
use grains_geometry::{Mat3, Rotation, Shape, Simplex, Vec3};
use std::collections::HashMap;

/// A particle to be placed.
#[derive(Clone, Copy, Debug)]
pub struct NewParticle {
    /// Identity, unique in the case.
    pub id: u64,
    /// Shape and material.
    pub kind: Kind,
    /// Scale of its shape (-).
    pub scale: f64,
    /// Centre of mass (m).
    pub position: Vec3,
    /// Orientation, body to world.
    pub orientation: Rotation,
    /// Velocity (m/s).
    pub velocity: Vec3,
    /// Angular velocity (rad/s).
    pub angular_velocity: Vec3,
    /// Temperature (K), without effect where particles have none.
    pub temperature: f64,
}

impl NewParticle {
    /// The particle's state when it is placed, its velocity relative to the mean flow of a sheared box; it has flown freely until
    /// then.
    pub fn record(&self, dem: &Dem) -> ParticleRecord {
        let catalogue = &dem.setup.catalogue;
        let shape = catalogue.shape(self.kind);
        let velocity = self.velocity + dem.mean_flow(&self.position);
        let body = Body {
            position: self.position.map(|x| dem.setup.global.quantum.snap(x)),
            radius: shape.bounding_radius * self.scale,
            velocity,
            mass: catalogue.mass(self.kind, self.scale),
            angular_velocity: self.angular_velocity,
            kind: self.kind,
            prescribed: 0,
        };
        let half_spin = if shape.is_sphere() {
            self.angular_velocity
        } else {
            let frame = self.frame();
            frame * catalogue.inertia(&body).component_mul(&frame.tr_mul(&self.angular_velocity))
        };
        let half_velocity = half_step_back(velocity, &dem.setup.parameters);
        ParticleRecord {
            id: self.id,
            body,
            orientation: self.orientation,
            half_velocity,
            half_spin,
            sides: 0,
            temperature: self.temperature,
        }
    }

    /// Radius of the bounding sphere (m).
    pub fn radius(&self, catalogue: &Catalogue) -> f64 {
        catalogue.shape(self.kind).bounding_radius * self.scale
    }

    fn frame(&self) -> Mat3 {
        frame(&self.orientation)
    }

    /// Whether it overlaps another particle at `separation` (m) from it.
    pub fn overlaps(&self, other: &NewParticle, separation: &Vec3, catalogue: &Catalogue) -> bool {
        let (shape, other_shape) = (catalogue.shape(self.kind), catalogue.shape(other.kind));
        let sum = |radius: fn(&Shape) -> f64| radius(shape) * self.scale + radius(other_shape) * other.scale;
        let distance = separation.norm();
        if distance >= sum(|shape| shape.bounding_radius) {
            return false;
        }
        if distance < sum(|shape| shape.inscribed_radius) {
            return true;
        }
        let frames = [self.frame(), other.frame()];
        let pose = Pose { shape, frame: &frames[0], scale: self.scale };
        let other_pose = Pose { shape: other_shape, frame: &frames[1], scale: other.scale };
        (0..shape.parts.len() as u16).any(|a| {
            let part = PlacedPart::of(&pose, a);
            (0..other_shape.parts.len() as u16).any(|b| {
                let other = PlacedPart::of(&other_pose, b);
                let between = separation + other.offset - part.offset;
                between.norm() < part.bounding_radius + other.bounding_radius
                    && overlaps(&part, &other, &part.placement(&other.rotation, other.scale, &between))
            })
        })
    }
}

/// The owned particles of a rank by place, to ask what is in the way of new ones.
///
/// Build it once per batch; particles accepted meanwhile are added with [`Occupancy::add`].
pub struct Occupancy {
    /// Places in `particles` by class of sizes and cell; cells are as wide as the largest particles of their class.
    cells: HashMap<(usize, [i32; 3]), Vec<u32>>,
    /// Places in `particles` by class.
    members: [Vec<u32>; SIZE_CLASSES],
    largest_radius: f64,
    particles: Vec<NewParticle>,
    /// Corners (m) of the box around their centres.
    corners: [Vec3; 2],
}

impl Occupancy {
    /// One without particles, for some of a radius (m) up to `largest`.
    pub fn empty(largest: f64) -> Self {
        let nowhere = [f64::INFINITY, f64::NEG_INFINITY].map(Vec3::from_element);
        Self {
            cells: HashMap::new(),
            members: Default::default(),
            largest_radius: largest,
            particles: Vec::new(),
            corners: nowhere,
        }
    }

    /// Particles owned by this rank that could touch one placed between two corners (m), of a radius (m) up to `largest`.
    pub fn near(dem: &Dem, [lower, upper]: [&Vec3; 2], largest: f64) -> Self {
        // Particles that stay where they are have no width to the search for contacts.
        let owned = &dem.particles.bodies[..dem.particles.owned];
        let largest_radius = owned.iter().map(|body| body.radius).fold(largest, f64::max);
        let width = 2.0 * largest_radius;
        let mut occupancy = Self::empty(largest_radius);
        let (particles, global) = (&dem.particles, &dem.setup.global);
        let is_near = |position: &Vec3| {
            (0..3).all(|a| {
                let x = if global.periodic[a] { global.wrap_along(a, position[a]) } else { position[a] };
                let within = |x: f64| (lower[a] - width..=upper[a] + width).contains(&x);
                let period = global.length(a);
                within(x) || (global.periodic[a] && (within(x - period) || within(x + period)))
            })
        };
        for i in (0..particles.owned).filter(|&i| is_near(&particles.bodies[i].position)) {
            let body = &particles.bodies[i];
            let new = NewParticle {
                id: particles.ids[i],
                kind: body.kind,
                scale: body.radius / dem.setup.catalogue.shape(body.kind).bounding_radius,
                position: Vec3::from(dem.setup.global.wrap(body.position.into())),
                orientation: particles.orientations.get(i).copied().unwrap_or_else(Rotation::identity),
                velocity: body.velocity,
                angular_velocity: body.angular_velocity,
                temperature: 0.0,
            };
            occupancy.add(new, &dem.setup.catalogue);
        }
        occupancy
    }

    /// Adds a particle.
    pub fn add(&mut self, particle: NewParticle, catalogue: &Catalogue) {
        let class = size_class(particle.radius(catalogue), self.largest_radius);
        let key = (class, self.cell(class, &particle.position));
        let place = self.particles.len() as u32;
        self.members[class].push(place);
        self.cells.entry(key).or_default().push(place);
        let [lower, upper] = self.corners;
        self.corners = [lower.inf(&particle.position), upper.sup(&particle.position)];
        self.particles.push(particle);
    }

    /// Largest radius in a class (m).
    fn radius_of(&self, class: usize) -> f64 {
        self.largest_radius / (1_u64 << class) as f64
    }

    fn cell(&self, class: usize, position: &Vec3) -> [i32; 3] {
        let width = 2.0 * self.radius_of(class);
        std::array::from_fn(|a| (position[a] / width).floor() as i32)
    }

    /// Whether something is true of one of those of a class that could be within a range (m) of a position.
    fn any_near(
        &self,
        class: usize,
        position: &Vec3,
        range: f64,
        is_true: impl Fn(&NewParticle) -> bool,
    ) -> bool {
        let is_true = |place: &u32| is_true(&self.particles[*place as usize]);
        let [low, high] = [-range, range].map(|range| self.cell(class, &position.add_scalar(range)));
        let count: f64 = (0..3).map(|a| f64::from(high[a] - low[a] + 1)).product();
        if count > self.members[class].len() as f64 {
            return self.members[class].iter().any(is_true);
        }
        let cells = (low[2]..=high[2]).flat_map(move |z| {
            (low[1]..=high[1]).flat_map(move |y| (low[0]..=high[0]).map(move |x| [x, y, z]))
        });
        cells.filter_map(|cell| self.cells.get(&(class, cell))).flatten().any(is_true)
    }

    /// Whether a new particle would overlap one of these.
    pub fn is_in_the_way(&self, new: &NewParticle, dem: &Dem) -> bool {
        let global = &dem.setup.global;
        let (catalogue, radius) = (&dem.setup.catalogue, new.radius(&dem.setup.catalogue));
        let range = radius + self.largest_radius;
        (0..27).any(|code| {
            let step = [code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1];
            if (0..3).any(|a| step[a] != 0 && !global.periodic[a]) {
                return false;
            }
            let shift = Vec3::from_fn(|a, _| f64::from(step[a]) * global.length(a));
            let image = new.position + shift;
            let [lower, upper] = &self.corners;
            if (0..3).any(|a| image[a] < lower[a] - range || image[a] > upper[a] + range) {
                return false;
            }
            (0..SIZE_CLASSES).filter(|&class| !self.members[class].is_empty()).any(|class| {
                self.any_near(class, &image, radius + self.radius_of(class), |other| {
                    new.overlaps(other, &(other.position - image), catalogue)
                })
            })
        })
    }
}

/// Whether a new particle would overlap a wall.
pub fn is_wall_in_the_way(new: &NewParticle, dem: &Dem) -> bool {
    let shape = dem.setup.catalogue.shape(new.kind);
    let radius = shape.bounding_radius * new.scale;
    let global = &dem.setup.global;
    let shifts = images::shifts(global);
    let frame = new.frame();
    let present =
        dem.setup.walls.iter().zip(dem.wall_states()).filter(|(wall, _)| wall.exists_at(dem.time()));
    for (wall, state) in present {
        let seen = state.rotation.tr_mul(&frame);
        let pose = Pose { shape, frame: &seen, scale: new.scale };
        for surface in &wall.surfaces {
            let axes = wall.wrapped_axes(surface).map(|w| !w);
            let mut near = Vec::new();
            for image in images::near_faces(global, &new.position, radius, axes) {
                let center = state.to_wall(&(new.position + shifts[image as usize]));
                surface.for_each_near(&center, radius, |e| near.push((center, e)));
            }
            if near.iter().any(|(center, e)| overlaps_element(surface, *e, center, radius, &pose)) {
                return true;
            }
        }
    }
    false
}

/// Whether a particle at `center` (m), in the wall's frame, overlaps an element of a surface; where that cannot be found it is taken to.
fn overlaps_element(surface: &Surface, element: u32, center: &Vec3, radius: f64, pose: &Pose) -> bool {
    if pose.shape.is_sphere() {
        let met = surface.meets_sphere(element, center, radius);
        return met.map_or(true, |met| met.is_some_and(|touch| touch.overlap > 0.0));
    }
    (0..pose.shape.parts.len() as u16).any(|part| {
        let placed = PlacedPart::of(pose, part);
        let (mut cold, at) = (Simplex::default(), center + placed.offset);
        let met = surface.meets_part(element, &at, &placed, &mut cold, FaceContact::Point);
        met.map_or(true, |met| met.contact().is_some_and(|contact| contact.overlap > 0.0))
    })
}
