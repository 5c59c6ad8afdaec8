//! What ends a run: each error names the particle and where it is.

use crate::common::{law, setup};
use grains_dem::{Dem, Failure, Kind, Motion, NewParticle, StepError, Surface};
use grains_domain::SerialTransport;
use grains_geometry::{Rotation, SMOOTH_ANGLE, Shape, TriMesh, Vec3, WallMesh};
use std::sync::Arc;

const RADIUS: f64 = 1.5e-3;

/// Two spheres with a gap (m) between them, the second (id 8) with a velocity (m/s).
fn pair(gap: f64, velocity: Vec3) -> Dem {
    let mut setup = setup([0.5; 3], [false; 3], vec![Shape::sphere(RADIUS).unwrap()], law(true));
    setup.parameters.gravity = Vec3::zeros();
    let mut dem = Dem::new(setup, 0).unwrap();
    for (id, x, velocity) in [(3, 0.2, Vec3::zeros()), (8, 0.2 + 2.0 * RADIUS + gap, velocity)] {
        let particle = NewParticle {
            id,
            kind: Kind { shape: 0, material: 0 },
            scale: 1.0,
            position: Vec3::new(x, 0.25, 0.25),
            orientation: Rotation::identity(),
            velocity,
            angular_velocity: Vec3::zeros(),
            temperature: 0.0,
        };
        let record = particle.record(&dem);
        dem.insert(&record);
    }
    dem
}

/// The error that ends the run within some steps.
fn error_of(mut dem: Dem, steps: u64) -> StepError {
    let failure = (0..steps).find_map(|_| dem.step(&SerialTransport).err());
    match failure {
        Some(Failure::Here { error, .. }) => error,
        other => panic!("{other:?} instead of an error"),
    }
}

#[test]
fn a_velocity_that_is_not_a_number_is_named() {
    let error = error_of(pair(1e-3, Vec3::new(f64::NAN, 0.0, 0.0)), 3);
    assert!(matches!(&error, StepError::NotANumber { id: 8, .. }), "{error}");
}

#[test]
fn a_particle_that_outruns_its_neighbours_is_named() {
    let error = error_of(pair(1e-3, Vec3::new(1e4, 0.0, 0.0)), 3);
    assert!(matches!(&error, StepError::Jump { id: 8, distance, .. } if *distance > 0.03), "{error}");
    assert!(error.to_string().contains("time step"), "{error}");
}

#[test]
fn a_particle_alone_may_go_as_far_as_it_likes() {
    let mut setup = setup([0.5; 3], [true; 3], vec![Shape::sphere(RADIUS).unwrap()], law(true));
    setup.parameters.gravity = Vec3::zeros();
    let mut dem = Dem::new(setup, 0).unwrap();
    let record = NewParticle {
        id: 0,
        kind: Kind { shape: 0, material: 0 },
        scale: 1.0,
        position: Vec3::repeat(0.25),
        orientation: Rotation::identity(),
        velocity: Vec3::new(1e3, 0.0, 0.0),
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    }
    .record(&dem);
    dem.insert(&record);
    (0..300).for_each(|_| dem.step(&SerialTransport).unwrap());
}

#[test]
fn a_particle_that_leaves_where_no_outlet_is_is_named() {
    let error = error_of(pair(1e-3, Vec3::new(100.0, 0.0, 0.0)), 1000);
    assert!(matches!(&error, StepError::Lost { id: 8, face, .. } if face == "+x"), "{error}");
}

#[test]
fn too_deep_an_overlap_is_named_with_both_particles() {
    let error = error_of(pair(-0.7 * RADIUS, Vec3::zeros()), 3);
    assert!(matches!(&error, StepError::Overlap { id: 3, other, .. } if other == "particle 8"), "{error}");
}

#[test]
fn a_load_beyond_what_sums_can_hold_is_named() {
    let error = error_of(pair(-1e-6, Vec3::new(-5e3, 0.0, 0.0)), 3);
    assert!(matches!(&error, StepError::Load { force, .. } if *force > 100.0), "{error}");
}

/// Drag, buoyancy and the like have no bound by stiffness: sums of contact forces are to be exact, others are added last.
#[test]
fn a_force_that_is_none_of_contacts_has_no_limit() {
    let pushed = |gap: f64, speed: f64| {
        let mut dem = pair(gap, Vec3::new(speed, 0.0, 0.0));
        dem.particles.carry();
        let results = (0..3).map(|_| {
            dem.refresh(&SerialTransport)?;
            dem.add_forces(&SerialTransport);
            dem.particles.loads.iter_mut().for_each(|load| load.force.y += 1e9);
            dem.advance(&SerialTransport)
        });
        results.collect::<Result<Vec<_>, _>>()
    };
    let failure = pushed(-1e-6, -5e3).unwrap_err();
    assert!(matches!(&failure, Failure::Here { error: StepError::Load { .. }, .. }), "{failure:?}");
    // Apart they fly off, which other checks may see, not this one.
    let found = pushed(0.1, 0.0);
    assert!(!matches!(&found, Err(Failure::Here { error: StepError::Load { .. }, .. })), "{found:?}");
}

/// A fibre that turns, or a ball that flies, beside a thin plate or towards a sheet, for a quarter of a turn or 20 mm.
fn sweeping(dt: f64, fibre: bool, sheet: bool) -> Result<(), StepError> {
    let shapes = vec![
        Shape::cylinder(0.5e-3, 0.03, 0.02).unwrap(),
        Shape::cuboid(Vec3::new(0.01, 0.001, 0.01), 0.02).unwrap(),
        Shape::sphere(0.5e-3).unwrap(),
    ];
    let mut setup = setup([0.2; 3], [false; 3], shapes, law(true));
    setup.parameters.gravity = Vec3::zeros();
    setup.parameters.dt = dt;
    let middle = Vec3::repeat(0.1);
    // The fibre lies along z and turns about x: its upper end goes towards -y, the ball flies there.
    let aside = Vec3::new(0.0, -8e-3, 8e-3);
    if sheet {
        let corner = |x: f64, z: f64| middle + Vec3::new(x, aside.y, z);
        let corners =
            vec![corner(-0.05, -0.05), corner(0.05, -0.05), corner(0.05, 0.05), corner(-0.05, 0.05)];
        let mesh = TriMesh::from_polygons(corners, &[vec![0, 1, 2, 3]]).unwrap();
        let mesh = Surface::Mesh(Arc::new(WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap()));
        setup.walls = vec![crate::common::wall("sheet", mesh, Motion::Fixed)];
    }
    let mut dem = Dem::new(setup, 0).unwrap();
    let body = |id: u64, shape: u16, position: Vec3| NewParticle {
        id,
        kind: Kind { shape, material: 0 },
        scale: 1.0,
        position,
        orientation: Rotation::identity(),
        velocity: Vec3::zeros(),
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    };
    let mut first = body(0, if fibre { 0 } else { 2 }, middle);
    let duration = 2e-3;
    match fibre {
        true => first.angular_velocity.x = 1.5 / duration,
        false => {
            first.position.z += aside.z;
            first.velocity.y = -0.015 / duration;
        }
    }
    let plate = body(1, 1, middle + aside);
    for particle in [Some(first), (!sheet).then_some(plate)].into_iter().flatten() {
        let record = particle.record(&dem);
        dem.insert(&record);
    }
    for _ in 0..(duration / dt) as u64 {
        dem.step(&SerialTransport).map_err(|failure| match failure {
            Failure::Here { error, .. } => error,
            Failure::Elsewhere => panic!("there is one rank"),
        })?;
        let speed = dem.particles.bodies.iter().map(|b| b.velocity.y + b.angular_velocity.x).sum::<f64>();
        if (speed - first.velocity.y - first.angular_velocity.x).abs() > 0.1 {
            // It was met.
            return Ok(());
        }
    }
    panic!("dt {dt}: passed through unseen, fibre {fibre}, sheet {sheet}")
}

#[test]
fn what_may_pass_through_thin_bodies_or_sheets_is_named() {
    for (fibre, sheet) in [(true, false), (false, false), (true, true), (false, true)] {
        for dt in (0..55).map(|k| 2e-6 * 1.11_f64.powi(k)) {
            let found = sweeping(dt, fibre, sheet);
            let way_per_step = 0.02 * dt / 2e-3;
            match found {
                Ok(()) => assert!(way_per_step < 2e-3, "fibre {fibre}, sheet {sheet}, dt {dt}"),
                Err(error) => {
                    let is_named = matches!(
                        error,
                        StepError::Tunnelling { .. }
                            | StepError::Jump { .. }
                            | StepError::Overlap { .. }
                            | StepError::Load { .. }
                    );
                    assert!(is_named && dt > 1e-5, "fibre {fibre}, sheet {sheet}, dt {dt}: {error}");
                    assert!(error.to_string().contains("time"), "{error}");
                }
            }
        }
    }
}

#[test]
fn a_ledger_that_does_not_close_is_an_error() {
    let mut dem = pair(1e-3, Vec3::zeros());
    assert_eq!(dem.check_ledger(&SerialTransport).unwrap().inserted, 2);
    dem.ledger.inserted += 1;
    let error = dem.check_ledger(&SerialTransport).unwrap_err();
    assert!(matches!(error, StepError::Ledger { inserted: 3, inside: 2, left: 0, missing: 1 }), "{error}");
}
