//! Particles that go so far in one step that they may pass through another, or through a wall, between two looks.
//!
//! Two bodies that cross are seen on the wrong side of each other's middle, or not at all, once the way of one past the
//! other in a step, the turning of both included, is longer than their half thicknesses together.

use crate::catalogue::Catalogue;
use crate::error::{StepError, vector};
use crate::particles::{Body, Particles};
use crate::verlet::VerletLists;
use crate::walls::{Surface, WallScene};
use grains_geometry::{Shape, Vec3};

/// Half of the smallest thickness of a particle (m).
pub(crate) fn half_thickness(catalogue: &Catalogue, body: &Body) -> f64 {
    let shape = catalogue.shape(body.kind);
    half_thickness_of(shape) * (body.radius / shape.bounding_radius)
}

/// The same of a shape: that of its thinnest part (m).
fn half_thickness_of(shape: &Shape) -> f64 {
    shape.parts.iter().map(|part| part.half_extents.min()).fold(shape.inscribed_radius, f64::min)
}

/// Way that no point of a body exceeds by turning in a step (m).
fn turning(body: &Body, dt: f64) -> f64 {
    body.radius * body.angular_velocity.norm() * dt
}

/// Whether a body goes farther in a step than it is thick by half: without such a one no two pass.
#[inline(always)]
pub(crate) fn is_fast(catalogue: &Catalogue, body: &Body, dt: f64) -> bool {
    let shape = catalogue.shape(body.kind);
    let way = body.velocity.norm() * dt + turning(body, dt);
    // The thinnest part is looked at only where the largest ball says that it may matter.
    way > 0.1 * shape.inscribed_radius * (body.radius / shape.bounding_radius)
        && way > half_thickness(catalogue, body)
}

/// What a fast particle may have passed through in the step just made, of what is listed with it.
pub(crate) fn check(
    particles: &Particles,
    neighbours: &VerletLists,
    fast: &[usize],
    scene: &WallScene,
    catalogue: &Catalogue,
    step: u64,
) -> Option<StepError> {
    let found = |i: usize, other: String, way: f64, allowed: f64| StepError::Tunnelling {
        id: particles.ids[i],
        other,
        step,
        way,
        allowed,
        dt: scene.dt * allowed / way,
        place: vector(&particles.bodies[i].position),
    };
    let may_pass = |i: usize, j: usize| {
        let [a, b] = [i, j].map(|i| &particles.bodies[i]);
        let way = (a.velocity - b.velocity).norm() * scene.dt + turning(a, scene.dt) + turning(b, scene.dt);
        let allowed = half_thickness(catalogue, a) + half_thickness(catalogue, b);
        let is_near = (a.position - b.position).norm() < a.radius + b.radius + way;
        (way > allowed && is_near).then(|| {
            let (i, j) = if particles.ids[i] < particles.ids[j] { (i, j) } else { (j, i) };
            found(i, format!("particle {}", particles.ids[j]), way, allowed)
        })
    };
    let mut is_among = vec![false; particles.bodies.len()];
    fast.iter().for_each(|&i| is_among[i] = true);
    let spheres = neighbours.spheres.iter().map(|pair| (pair.a as usize, pair.b as usize));
    let bodies = neighbours.part_pairs.pairs.iter().map(|pair| (pair.a as usize, pair.b as usize));
    let pairs = spheres.chain(bodies).filter(|&(i, j)| is_among[i] || is_among[j]);
    if let Some(error) = pairs.into_iter().find_map(|(i, j)| may_pass(i, j)) {
        return Some(error);
    }
    let list = &neighbours.walls;
    list.pairs.iter().filter(|pair| is_among[pair.particle as usize]).find_map(|pair| {
        let i = pair.particle as usize;
        let body = &particles.bodies[i];
        let (wall, state) = (&scene.walls[pair.wall as usize], &scene.states[pair.wall as usize]);
        let surface = &wall.surfaces[pair.surface as usize];
        let thickness = wall_half_thickness(surface)?;
        let center = scene.center(pair, &body.position, &list.shifts);
        let way = (body.velocity - state.velocity_at(&center)).norm() * scene.dt + turning(body, scene.dt);
        let allowed = half_thickness(catalogue, body) + thickness;
        let is_near = || {
            let mut near = false;
            surface.for_each_near(&state.to_wall(&center), body.radius + way, |element| {
                near |= surface.is_of(element, pair.element);
            });
            near
        };
        (wall.exists_at(scene.time) && way > allowed && is_near())
            .then(|| found(i, format!("wall `{}`", wall.name), way, allowed))
    })
}

/// Half of the smallest thickness of a wall (m); none if it has no other side.
fn wall_half_thickness(surface: &Surface) -> Option<f64> {
    match surface {
        Surface::Plane { .. } => None,
        Surface::Tube { .. } | Surface::OpenTube(_) | Surface::Mesh(_) => Some(0.0),
        Surface::Solid { core, .. } => {
            let (lower, upper): (Vec3, Vec3) = core.bounds();
            Some(0.5 * (upper - lower).min())
        }
    }
}
