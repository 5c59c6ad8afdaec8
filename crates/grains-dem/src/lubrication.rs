//! Films of fluid between spheres, and between spheres and walls, that its grid does not resolve.

use crate::contacts::{ContactPass, LoadQuanta, SpherePair};
use crate::particles::{Load, Particles};
use crate::walls::{WallList, WallLoad, WallScene, not_found};
use grains_contact::Lubrication;

/// Adds the lubrication forces between spheres; antisymmetric in the two, operation by operation.
pub(crate) fn add_between_spheres(
    particles: &mut Particles,
    pairs: &[SpherePair],
    lubrication: &Lubrication,
    quanta: &LoadQuanta,
    dt: f64,
) {
    let owned = particles.owned;
    let Particles { bodies, loads, .. } = particles;
    for pair in pairs {
        let (i, j) = (pair.a as usize, pair.b as usize);
        let (a, b) = (&bodies[i], &bodies[j]);
        let separation = b.position - a.position;
        let (distance, radii) = (separation.norm(), a.radius + b.radius);
        if distance >= radii + lubrication.range || distance <= radii {
            continue;
        }
        let normal = separation / distance;
        let approach = (a.velocity - b.velocity).dot(&normal);
        let radius = a.radius * b.radius / radii;
        let inverse_mass = 1.0 / a.contact_mass() + 1.0 / b.contact_mass();
        let size = lubrication.force(distance - radii, approach, radius, inverse_mass, dt);
        let force = quanta.force(&(normal * size));
        loads[i].force -= force;
        if j < owned {
            loads[j].force += force;
        }
    }
}

/// Adds the lubrication forces between spheres and walls.
pub(crate) fn add_at_walls(
    particles: &mut Particles,
    list: &WallList,
    scene: &WallScene,
    lubrication: &Lubrication,
    wall_loads: &mut [WallLoad],
    pass: ContactPass,
) {
    let ContactPass { catalogue, quanta, statistics, .. } = pass;
    for pair in &list.pairs {
        let (wall, state) = (&scene.walls[pair.wall as usize], &scene.states[pair.wall as usize]);
        if !wall.exists_at(scene.time) {
            continue;
        }
        let body = &particles.bodies[pair.particle as usize];
        if !catalogue.shape(body.kind).is_sphere() {
            continue;
        }
        let position = scene.center(pair, &body.position, &list.shifts);
        let (surface, center) = (&wall.surfaces[pair.surface as usize], state.to_wall(&position));
        // A sphere larger by the range meets the wall where this one is lubricated.
        let met = surface.meets_sphere(pair.element, &center, body.radius + lubrication.range);
        let met = match met {
            Ok(Some(met)) => met,
            Ok(None) => continue,
            Err(reason) => {
                let error = not_found(particles, pair, scene, &reason);
                statistics.error = statistics.error.take().or(Some(error));
                return;
            }
        };
        let normal = state.to_world(&met.normal);
        let point = position + normal * body.radius;
        let approach = (body.velocity - state.velocity_at(&point)).dot(&normal);
        let size = lubrication.force(
            lubrication.range - met.overlap,
            approach,
            body.radius,
            1.0 / body.mass,
            scene.dt,
        );
        let force = quanta.force(&(normal * size));
        let load: &mut Load = &mut particles.loads[pair.particle as usize];
        load.force -= force;
        wall_loads[pair.wall as usize].force += force;
        wall_loads[pair.wall as usize].torque += quanta.torque(&point.cross(&force));
    }
}
