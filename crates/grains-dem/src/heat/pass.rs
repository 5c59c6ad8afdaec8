//! One pass over contacts and gaps for the heat that flows through them.

use super::HeatedWalls;
use super::Thermal;
use super::flows::{between, from_wall};
use crate::bonds::{BondKind, ListedBond};
use crate::catalogue::Catalogue;
use crate::contact_history::LawHistory;
use crate::contacts::SpherePair;
use crate::error::StepError;
use crate::non_spherical;
use crate::particles::Particles;
use crate::verlet::RestingPairs;
use crate::walls::{self, WallHeat, WallList, WallScene, not_found};
use grains_contact::{Approach, patch_radius};
use grains_geometry::ContactPatch;

/// Parts of two bodies that touch, not both spheres, or of one and a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TouchingParts {
    particle: u32,
    other: Other,
    overlap: f64,
    /// Sum and product of the second moments of the patch (m², m⁴), zero of a point.
    moments: [f64; 2],
    memory: f64,
}

#[derive(Clone, Copy, Debug)]
enum Other {
    Particle(u32),
    Wall(u16),
}

impl TouchingParts {
    /// Parts of two particles that overlap (m) in a point, or over a patch.
    pub(crate) fn of_particles(
        [i, j]: [u32; 2],
        (overlap, patch): (f64, Option<&ContactPatch>),
        memory: f64,
    ) -> Self {
        Self { particle: i, other: Other::Particle(j), overlap, moments: moments(patch), memory }
    }

    /// A part that overlaps (m) with a wall.
    pub(crate) fn at_wall(
        (particle, wall): (u32, u16),
        (overlap, patch): (f64, Option<&ContactPatch>),
        memory: f64,
    ) -> Self {
        Self { particle, other: Other::Wall(wall), overlap, moments: moments(patch), memory }
    }
}

/// Sum and product of the second moments of a patch in its plane (m², m⁴).
fn moments(patch: Option<&ContactPatch>) -> [f64; 2] {
    // The moment about the normal is zero: both others make up the trace and the sum of the minors.
    patch.map_or([0.0; 2], |patch| {
        let (trace, second) = (patch.second.trace(), &patch.second);
        [trace, 0.5 * (trace * trace - second.component_mul(second).sum())]
    })
}

/// A pass that adds the heat flowing into particles.
pub(crate) struct HeatPass<'a> {
    pub(crate) thermal: &'a Thermal,
    pub(crate) catalogue: &'a Catalogue,
    /// Time step (s).
    pub(crate) dt: f64,
    /// Heat from each wall of a given temperature (W).
    pub(crate) of_walls: &'a mut [f64],
    /// Contacts with walls of a given heat, which come later.
    pub(crate) heated: &'a mut HeatedWalls,
}

impl HeatPass<'_> {
    /// Conductance (W/K) of a contact of two materials, of bodies of an effective radius (m) that overlap (m), and its radius (m).
    fn contact(
        &self,
        materials: [u16; 2],
        (overlap, radius): (f64, f64),
        memory: f64,
        moments: [f64; 2],
    ) -> [f64; 2] {
        let Some(conduction) = self.thermal.conduction(materials[0], materials[1]) else { return [0.0; 2] };
        let law = self.catalogue.contacts.prepared(materials[0], materials[1]);
        let Some(response) = law.at_rest(&Approach { overlap, opening: 0.0, radius, dt: self.dt }, memory)
        else {
            return [0.0; 2];
        };
        let mut contact_radius = conduction.contact_radius(&response, radius);
        if moments[0] > 0.0 {
            contact_radius = patch_radius(contact_radius, moments[0], moments[1]);
        }
        [conduction.conductance(contact_radius), contact_radius]
    }

    /// The same of two spheres or a sphere and a wall, with the gas around.
    #[inline]
    fn of_spheres(&self, materials: [u16; 2], overlap: f64, radii: [f64; 2], memory: f64) -> f64 {
        let [a, b] = radii;
        let radius = if b.is_finite() { a * b / (a + b) } else { a };
        let [contact, contact_radius] = self.contact(materials, (overlap, radius), memory, [0.0; 2]);
        let lens =
            self.thermal.lens.filter(|_| self.thermal.conduction(materials[0], materials[1]).is_some());
        // A softened contact is not as deep as its overlap says.
        let gap = if overlap > 0.0 { -contact_radius * contact_radius / radius } else { -overlap };
        contact
            + lens.map_or(0.0, |lens| {
                lens.conductance(
                    gap,
                    radii,
                    contact_radius,
                    self.thermal.resistivity(materials, b.is_infinite()),
                )
            })
    }

    /// Lets heat flow between spheres.
    pub(crate) fn between_spheres(
        &mut self,
        particles: &mut Particles,
        pairs: &[SpherePair],
        laws: &[LawHistory],
        reach: f64,
    ) {
        for (k, pair) in pairs.iter().enumerate() {
            let (i, j) = (pair.a as usize, pair.b as usize);
            let (a, b) = (&particles.bodies[i], &particles.bodies[j]);
            let between_centres = b.position - a.position;
            let (square, range) = (between_centres.norm_squared(), a.radius + b.radius + reach);
            if square >= range * range {
                continue;
            }
            let overlap = a.radius + b.radius - square.sqrt();
            let materials = [a, b].map(|body| body.kind.material);
            let memory = laws.get(k).map_or(0.0, |law| law.memory);
            let conductance = self.of_spheres(materials, overlap, [a.radius, b.radius], memory);
            if conductance > 0.0 {
                between(particles, [i, j], conductance, self.thermal);
            }
        }
    }

    /// Lets heat flow along bonds: k_m A/L (W/K), with their section A (m²) and first length L (m).
    pub(crate) fn along_bonds(
        &mut self,
        particles: &mut Particles,
        bonds: &[ListedBond],
        kinds: &[BondKind],
    ) {
        for bond in bonds.iter().filter(|bond| !bond.is_broken) {
            let ends = bond.ends.map(|end| end as usize);
            let bodies = ends.map(|end| &particles.bodies[end]);
            let [a, b] = bodies.map(|body| body.kind.material);
            let Some(conduction) = self.thermal.conduction(a, b) else { continue };
            let section = kinds[usize::from(bond.kind)].between(bodies).section;
            let conductance = 0.5 * conduction.conductivity * section.area() / bond.state.length;
            between(particles, ends, conductance, self.thermal);
        }
    }

    /// Lets heat flow through the contacts of other bodies, also with walls.
    pub(crate) fn through_parts(
        &mut self,
        particles: &mut Particles,
        touching: &[TouchingParts],
        scene: &WallScene,
    ) {
        for touch in touching {
            let i = touch.particle as usize;
            let body = &particles.bodies[i];
            let own = body.kind.material;
            match touch.other {
                Other::Particle(j) => {
                    let other = &particles.bodies[j as usize];
                    let materials = [own, other.kind.material];
                    let [a, b] = [body, other].map(|body| self.catalogue.part_radius(body));
                    let radius = a * b / (a + b);
                    let place = (touch.overlap, radius);
                    let [conductance, _] = self.contact(materials, place, touch.memory, touch.moments);
                    between(particles, [i, j as usize], conductance, self.thermal);
                }
                Other::Wall(wall) => {
                    let met = &scene.walls[usize::from(wall)];
                    let Some(heat) = met.heat else { continue };
                    let radius = self.catalogue.part_radius(body);
                    let place = (touch.overlap, radius);
                    let [conductance, _] =
                        self.contact([own, met.material], place, touch.memory, touch.moments);
                    self.at_wall(particles, i, (wall, heat), conductance);
                }
            }
        }
    }

    /// Lets heat flow between bodies of prescribed motion, and between these and walls.
    ///
    /// # Errors
    /// A distance that could not be found.
    pub(crate) fn of_resting(
        &mut self,
        particles: &mut Particles,
        resting: &mut RestingPairs,
        (touching, scene): (&mut Vec<TouchingParts>, &WallScene),
        reach: f64,
    ) -> Result<(), StepError> {
        touching.clear();
        self.between_spheres(particles, &resting.spheres, &[], reach);
        non_spherical::meet(particles, &mut resting.part_pairs, self.catalogue, |pair, contact, patch| {
            touching.push(TouchingParts::of_particles([pair.a, pair.b], (contact.overlap, patch), 0.0));
        })?;
        let has_heat = scene.walls.iter().any(|wall| wall.heat.is_some());
        if has_heat && particles.has_orientations() {
            walls::meet(particles, &mut resting.walls, scene, self.catalogue, |found| {
                let body = &particles.bodies[found.pair.particle as usize];
                if !self.catalogue.shape(body.kind).is_sphere() {
                    let place = (found.overlap, found.footprint.as_ref());
                    touching.push(TouchingParts::at_wall((found.pair.particle, found.pair.wall), place, 0.0));
                }
            })?;
        }
        self.through_parts(particles, touching, scene);
        self.at_walls(particles, &resting.walls, scene, reach)
    }

    /// Lets heat flow from a wall into an owned particle through a conductance (W/K); that of walls of a given heat is noted for later.
    #[inline(always)]
    fn at_wall(
        &mut self,
        particles: &mut Particles,
        i: usize,
        (wall, heat): (u16, WallHeat),
        conductance: f64,
    ) {
        match heat {
            WallHeat::Temperature(temperature) => {
                self.of_walls[usize::from(wall)] +=
                    from_wall(particles, i, (temperature, conductance), self.thermal);
            }
            WallHeat::Power(_) if conductance > 0.0 => self.heated.note(wall, i, conductance),
            WallHeat::Power(_) => {}
        }
    }

    /// Lets heat flow between spheres and walls.
    ///
    /// # Errors
    /// A distance that could not be found.
    pub(crate) fn at_walls(
        &mut self,
        particles: &mut Particles,
        list: &WallList,
        scene: &WallScene,
        reach: f64,
    ) -> Result<(), StepError> {
        for (k, pair) in list.pairs.iter().enumerate() {
            let (wall, state) = (&scene.walls[usize::from(pair.wall)], &scene.states[usize::from(pair.wall)]);
            let (Some(heat), true) = (wall.heat, wall.exists_at(scene.time)) else { continue };
            let (i, body) = (pair.particle as usize, &particles.bodies[pair.particle as usize]);
            if !self.catalogue.shape(body.kind).is_sphere() {
                continue;
            }
            let center = state.to_wall(&scene.center(pair, &body.position, &list.shifts));
            let surface = &wall.surfaces[usize::from(pair.surface)];
            let met = surface.meets_sphere(pair.element, &center, body.radius + reach);
            let Some(met) = met.map_err(|reason| not_found(particles, pair, scene, &reason))? else {
                continue;
            };
            let materials = [body.kind.material, wall.material];
            let memory = list.laws.get(k).map_or(0.0, |law| law.memory);
            let radii = [body.radius, f64::INFINITY];
            let conductance = self.of_spheres(materials, met.overlap - reach, radii, memory);
            if conductance > 0.0 {
                self.at_wall(particles, i, (pair.wall, heat), conductance);
            }
        }
        Ok(())
    }
}
