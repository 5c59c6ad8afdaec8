//! Boxes under simple shear: the same bits whatever the ranks, what is conserved, and the stress.

use crate::common::{
    Scene, State, Stopped, knobbly_shapes, lattice, law, merged, mixed_shapes, setup, state_of,
};
use crate::laws::bridge;
use grains_contact::{ContactLaw, Jkr, Linear, Tangential, Tear};
use grains_dem::{Dem, DemSetup, ExchangeStrategy, Kind, NewParticle, Partner, Shear, Skin, StressSums};
use grains_domain::{DecompositionError, SerialTransport, Transport};
use grains_geometry::{Rotation, Shape, Vec3};
use grains_testing::on_ranks;

const SIZE: f64 = 0.024;

/// Particles of some shapes that fill a box loosely, sheared along an axis across another.
fn scene(shapes: Vec<Shape>, law: ContactLaw, (flow, gradient): (usize, usize), rate: f64) -> Scene {
    let kinds = shapes.len() as u16;
    let mut setup = setup([SIZE; 3], [true; 3], shapes, law);
    setup.planes.clear();
    setup.parameters.gravity = Vec3::zeros();
    setup.shear = Some(Shear { flow, gradient, rate });
    let particles = lattice([0.0; 3], [SIZE; 3], 3e-3, kinds, 1.0);
    Scene { setup, particles }
}

fn smooth(restitution: f64) -> ContactLaw {
    let tangential = Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 };
    ContactLaw::new(Linear { stiffness: 1e5 }, restitution, 0.0, tangential)
}

/// A law whose forces act over a gap.
fn sticky() -> ContactLaw {
    let tangential = Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 };
    let normal = Jkr { modulus: 5e6, work: 0.5, tear: Tear::Displacement };
    ContactLaw::new(normal, 0.7, 0.5, tangential)
}

fn run(scene: &Scene, ranks: [usize; 3], from: Option<&Stopped>, steps: u64) -> State {
    merged(on_ranks(ranks.iter().product(), |transport| {
        let mut dem = match from {
            None => scene.start(ranks, transport.rank()),
            Some(stopped) => scene.resume(ranks, transport.rank(), stopped, |_| ()),
        };
        for _ in 0..steps {
            dem.step(&transport).unwrap();
        }
        dem.refresh(&transport).unwrap();
        assert!(from.is_some() || dem.check_ledger(&transport).is_ok());
        state_of(&dem)
    }))
}

#[test]
fn a_sheared_box_has_the_same_bits_on_any_ranks_with_any_skin_and_after_a_restart() {
    let cases = [
        (vec![Shape::sphere(1.2e-3).unwrap()], law(true), (0, 2)),
        (vec![Shape::sphere(1.2e-3).unwrap()], sticky(), (0, 1)),
        (vec![Shape::sphere(1.2e-3).unwrap()], law(true).with_attraction(bridge(1e-3, 2e-5)), (2, 0)),
        (mixed_shapes(1.1e-3), law(true), (1, 0)),
        (knobbly_shapes(1.0e-3), law(true), (2, 1)),
    ];
    for (shapes, law, (flow, gradient)) in cases {
        let (steps, before) = (2400, 1117);
        let mut scene = scene(shapes, law, (flow, gradient), -80.0);
        scene.setup.parameters.dt = 3e-6;
        // The images have gone on for more than half a turn.
        let turned = -80.0 * 3e-6 * steps as f64;
        assert!(turned < -0.5, "{turned}");
        let alone = run(&scene, [1; 3], None, steps);
        let across = |n: usize, m: usize| {
            let mut ranks = [n; 3];
            (ranks[flow], ranks[gradient]) = (1, m);
            ranks
        };
        for ranks in [across(2, 1), across(1, 2), across(2, 2), across(1, 3)] {
            assert!(run(&scene, ranks, None, steps) == alone, "{flow} {gradient} {ranks:?}");
        }
        let mut other = Scene { setup: scene.setup.clone(), particles: scene.particles.clone() };
        other.setup.skin = Skin { min: 0.01, max: 0.1, ..Skin::default() };
        assert!(run(&other, across(2, 2), None, steps) == alone, "{flow} {gradient}: skin");
        for exchange in [
            ExchangeStrategy::AllGatherGlobal,
            ExchangeStrategy::AllGatherLocal,
            ExchangeStrategy::SendRecvLocalGeoloc,
        ] {
            other.setup.exchange = exchange;
            assert!(run(&other, across(2, 2), None, 600) == run(&scene, [1; 3], None, 600), "{exchange:?}");
        }
        let mut dem = scene.start([1; 3], 0);
        (0..before).for_each(|_| dem.step(&SerialTransport).unwrap());
        let stopped = Stopped::of(&dem);
        assert!(run(&scene, across(2, 2), Some(&stopped), steps - before) == alone, "restart");
    }
}

#[test]
fn a_free_particle_goes_straight_on_through_the_images() {
    let mut scene = scene(vec![Shape::sphere(1.2e-3).unwrap()], law(true), (0, 2), 40.0);
    let start = Vec3::new(0.003, 0.004, 0.02);
    let peculiar = Vec3::new(0.7, -1.1, 5.0);
    scene.particles = vec![NewParticle {
        id: 0,
        kind: Kind { shape: 0, material: 0 },
        scale: 1.0,
        position: start,
        orientation: Rotation::identity(),
        velocity: peculiar,
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    }];
    let mut dem = scene.start([1; 3], 0);
    let velocity = dem.particles.bodies[0].velocity;
    assert!((velocity - peculiar - dem.mean_flow(&start)).norm() < 1e-12);
    let (speed, mut crossings) = (40.0 * SIZE, 0.0);
    for step in 1..=6000 {
        dem.step(&SerialTransport).unwrap();
        let record = dem.saved_record(0);
        let (position, time) = (record.body.position, dem.time());
        let free = start + velocity * time;
        // The image of the particle that lies where it would be without faces.
        let layer = ((free.z - position.z) / SIZE).round();
        crossings = f64::max(crossings, layer);
        assert!((record.body.velocity - velocity + Vec3::x() * speed * layer).norm() < 1e-10);
        let image = position + Vec3::new(layer * dem.shear_offset(), 0.0, layer * SIZE);
        let miss = (image - free).map(|x| x - SIZE * (x / SIZE).round());
        assert!(miss.norm() < 1e-9, "step {step}: {miss}");
    }
    assert!(crossings >= 4.0, "{crossings}");
}

#[test]
fn momentum_changes_by_the_crossings_alone() {
    let mut scene = scene(vec![Shape::sphere(1.3e-3).unwrap()], law(true), (0, 2), 200.0);
    scene.particles.iter_mut().for_each(|particle| particle.scale = 1.0);
    let mut dem = scene.start([1; 3], 0);
    dem.refresh(&SerialTransport).unwrap();
    let momentum = |dem: &Dem| {
        let all = 0..dem.particles.owned;
        let half = |i: usize| dem.particles.half_velocity[i] * dem.particles.bodies[i].mass;
        all.map(half).fold(Vec3::zeros(), |sum, p| sum + p)
    };
    let (start, unit) = (momentum(&dem), dem.particles.bodies[0].mass * 200.0 * SIZE);
    let (mut max_crossings, scale) = (0.0_f64, unit * dem.particles.owned as f64);
    for _ in 0..3000 {
        dem.step(&SerialTransport).unwrap();
        dem.refresh(&SerialTransport).unwrap();
        let change = momentum(&dem) - start;
        let crossings = change.x / unit;
        max_crossings = max_crossings.max(crossings.abs());
        let miss = Vec3::new((crossings - crossings.round()) * unit, change.y, change.z);
        assert!(miss.norm() < 1e-11 * scale, "{miss} beside {scale}");
    }
    assert!(max_crossings >= 3.0, "particles cross: {max_crossings}");
}

#[test]
fn a_box_and_two_of_them_side_by_side_do_the_same() {
    for twice in 0..3 {
        let single = scene(vec![Shape::sphere(1.2e-3).unwrap()], law(true), (0, 2), 300.0);
        let mut double = scene(vec![Shape::sphere(1.2e-3).unwrap()], law(true), (0, 2), 300.0);
        let mut upper = [SIZE; 3];
        upper[twice] = 2.0 * SIZE;
        double.setup.global = grains_domain::GlobalBox::new([0.0; 3], upper, [true; 3]);
        let count = single.particles.len() as u64;
        for particle in &single.particles {
            let mut copy = *particle;
            copy.id += count;
            copy.position[twice] += SIZE;
            double.particles.push(copy);
        }
        let [a, b] = [&single, &double].map(|scene| {
            let mut dem = scene.start([1; 3], 0);
            (0..1200).for_each(|_| dem.step(&SerialTransport).unwrap());
            let records = (0..dem.particles.owned).map(|i| dem.saved_record(i));
            let mut records: Vec<_> =
                records.map(|record| (record.id, record, dem.mean_flow(&record.body.position))).collect();
            records.sort_by_key(|(id, ..)| *id);
            records
        });
        for k in 0..count as usize {
            let (one, same, copy) = (&a[k], &b[k], &b[k + count as usize]);
            for other in [same, copy] {
                let peculiar = [one, other].map(|(_, record, flow)| record.body.velocity - flow);
                let spins = [one, other].map(|(_, record, _)| record.body.angular_velocity);
                assert!((peculiar[0] - peculiar[1]).norm() < 1e-6, "{twice} {k}: {peculiar:?}");
                assert!((spins[0] - spins[1]).norm() < 1e-3, "{twice} {k}: {spins:?}");
            }
        }
    }
}

#[test]
fn the_work_of_the_stress_is_the_energy_that_elastic_spheres_gain() {
    let (rate, stiffness) = (150.0, 1e5);
    let mut scene = scene(vec![Shape::sphere(1.3e-3).unwrap()], smooth(1.0), (0, 2), rate);
    scene.setup.parameters.dt = 1e-6;
    let energy = |dem: &Dem| {
        let bodies = &dem.particles.bodies[..dem.particles.owned];
        let kinetic: f64 = bodies
            .iter()
            .map(|body| 0.5 * body.mass * (body.velocity - dem.mean_flow(&body.position)).norm_squared())
            .sum();
        let mut elastic = 0.0;
        dem.for_each_contact(|touch| {
            let is_clone = matches!(touch.other, Partner::Particle(j) if j >= dem.particles.owned);
            elastic += 0.5 * stiffness * touch.overlap * touch.overlap * if is_clone { 0.5 } else { 1.0 };
        });
        kinetic + elastic
    };
    let mut dem = scene.start([1; 3], 0);
    dem.refresh(&SerialTransport).unwrap();
    let before = energy(&dem);
    let steps = 20_000;
    (0..steps).for_each(|_| dem.step(&SerialTransport).unwrap());
    dem.refresh(&SerialTransport).unwrap();
    let gained = energy(&dem) - before;
    let stress = dem.take_stress(&SerialTransport).unwrap();
    let time = f64::from(steps) * dem.setup.parameters.dt;
    let work = -rate * stress.total[4] * SIZE.powi(3) * time;
    assert!(gained > 0.3 * before && (work / gained - 1.0).abs() < 2e-3, "{gained} J by {work} J");
    assert_eq!(dem.stress, StressSums::default(), "it begins anew");
}

#[test]
fn stress_and_linear_profile_are_the_same_on_any_ranks() {
    let (rate, steps) = (150.0, 6000);
    let scene = scene(vec![Shape::sphere(1.3e-3).unwrap()], smooth(0.8), (0, 2), rate);
    let on = |ranks: [usize; 3]| {
        on_ranks(ranks.iter().product(), |transport| {
            let mut dem = scene.start(ranks, transport.rank());
            // Mean velocities to the flow in ten layers.
            let mut layers = [[0.0; 2]; 10];
            for _ in 0..steps {
                dem.step(&transport).unwrap();
                for i in 0..dem.particles.owned {
                    let body = dem.saved_record(i).body;
                    let layer = &mut layers[(10.0 * body.position.z / SIZE) as usize];
                    layer[0] += (body.velocity - dem.mean_flow(&body.position)).x;
                    layer[1] += 1.0;
                }
            }
            transport.sum(layers.as_flattened_mut());
            (dem.take_stress(&transport).unwrap(), layers)
        })
        .remove(0)
    };
    let (stress, layers) = on([1; 3]);
    let (same, _) = on([1, 2, 2]);
    let difference = |a: &[f64; 6], b: &[f64; 6]| (0..6).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    assert!(difference(&stress.total, &same.total) < 1e-10 * stress.total[0], "{stress:?} {same:?}");
    assert!((stress.temperature / same.temperature - 1.0).abs() < 1e-10);
    assert!(stress.total[..3].iter().all(|&p| p > 0.0) && stress.total[4] < 0.0, "{stress:?}");
    // Away from the mean profile by no more than the agitation leaves of so few particles.
    for (k, [sum, count]) in layers.iter().enumerate() {
        let away = sum / count;
        assert!(away.abs() < 0.15 * rate * SIZE, "layer {k}: {away} m/s beside {} m/s", rate * SIZE);
    }
}

#[test]
fn images_go_on_from_where_they_are_when_the_rate_changes() {
    let start = |rate: f64| {
        let mut scene = scene(vec![Shape::sphere(1.2e-3).unwrap()], law(true), (0, 2), rate);
        scene.particles.clear();
        Dem::new(scene.setup, 0).unwrap()
    };
    let (mut before, mut after) = (start(70.0), start(-31.0));
    for step in [0, 1000, 123_457] {
        before.resume_at(step);
        after.resume_at(step);
        after.set_shear_offset(before.shear_offset());
        assert_eq!(after.shear_offset(), before.shear_offset());
        after.resume_at(step + 10);
        let way = after.shear_offset() - before.shear_offset();
        assert!((way + 31.0 * SIZE * 10.0 * after.setup.parameters.dt).abs() < 1e-12, "{way} m");
    }
}

#[test]
fn the_flow_axis_must_not_be_divided() {
    let scene = scene(vec![Shape::sphere(1.2e-3).unwrap()], law(true), (1, 2), 1.0);
    let refused = Dem::new(DemSetup { ranks: [1, 2, 1], ..scene.setup.clone() }, 0);
    assert_eq!(refused.err(), Some(DecompositionError::FlowDivided { axis: 'y', ranks: 2 }));
    assert!(Dem::new(DemSetup { ranks: [2, 1, 2], ..scene.setup }, 0).is_ok());
}

/// Smooth spheres with e = 0.9 at a solid fraction of 0.3, beside Garzó and Dufty, Phys. Rev. E 59, 5895 (1999).
#[test]
fn stress_and_temperature_of_smooth_spheres_are_those_of_kinetic_theory() {
    let (radius, count, rate) = (5e-4, 216_u32, 10.0);
    let volume = 4.0 / 3.0 * std::f64::consts::PI * f64::powi(radius, 3);
    let edge = (f64::from(count) * volume / 0.3).cbrt();
    let mut setup = setup([edge; 3], [true; 3], vec![Shape::sphere(radius).unwrap()], smooth(0.9));
    setup.planes.clear();
    setup.largest_radius = radius;
    setup.parameters.gravity = Vec3::zeros();
    // A contact lasts for a thousandth of the time of a unit of shear, and for 20 steps.
    let time = 1e-3 / rate;
    let mass = 2500.0 * volume;
    let stiffness = 0.5 * mass * (std::f64::consts::PI / time).powi(2);
    let tangential = Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 };
    setup.catalogue.contacts.set(0, 0, ContactLaw::new(Linear { stiffness }, 0.9, 0.0, tangential));
    setup.parameters.dt = time / 20.0;
    setup.skin.horizon = 300.0;
    setup.shear = Some(Shear { flow: 0, gradient: 2, rate });
    let mut particles = lattice([0.0; 3], [edge * 1.000001; 3], edge / 6.0, 1, 0.05);
    particles.iter_mut().for_each(|particle| {
        particle.scale = 1.0;
        particle.angular_velocity = Vec3::zeros();
    });
    assert_eq!(particles.len(), count as usize);
    let mut dem = Scene { setup, particles }.start([1; 3], 0);
    let steps_of = |strain: f64| (strain / rate / dem.setup.parameters.dt) as u64;
    let [start, measured] = [6.0, 14.0].map(steps_of);
    (0..start).for_each(|_| dem.step(&SerialTransport).unwrap());
    dem.take_stress(&SerialTransport);
    (0..measured).for_each(|_| dem.step(&SerialTransport).unwrap());
    let stress = dem.take_stress(&SerialTransport).unwrap();
    let unit = (2.0 * radius * rate).powi(2);
    let pressure = stress.total[..3].iter().sum::<f64>() / 3.0;
    let found = [stress.temperature / unit, pressure / (2500.0 * unit), -stress.total[4] / (2500.0 * unit)];
    for (found, expected) in found.into_iter().zip([1.236, 1.419, 0.393]) {
        assert!((found / expected - 1.0).abs() < 0.15, "{found:.3} for {expected}");
    }
}
