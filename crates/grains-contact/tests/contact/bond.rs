//! Bonds against beams: statics, vibration, breakage, rigid rotation, and conservation.

use crate::chain::{Chain, Vec3};
use grains_contact::{BeamShear, Bond, BondLoad, BondState, BondedPair, Section, Strength};
use std::f64::consts::PI;

const RADIUS: f64 = 1e-3;
const DENSITY: f64 = 2500.0;
const TOUCHING: f64 = 2.0 * RADIUS;

fn bond(shear: BeamShear, damping: f64) -> Bond {
    let section = Section { radius: RADIUS, young: 1e9, shear_modulus: 0.4e9, shear };
    Bond { section, damping, strength: Strength::UNBREAKABLE }
}

fn random() -> impl FnMut() -> f64 {
    let mut seed = 11_u64;
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        2.0 * ((seed >> 11) as f64 / (1_u64 << 53) as f64) - 1.0
    }
}

fn random_vector(random: &mut impl FnMut() -> f64) -> Vec3 {
    Vec3::new(random(), random(), random())
}

/// A cantilever at rest under a force on each sphere but the first, half of it on the last: a load of `per_sphere`/`spacing`.
fn at_rest(shear: BeamShear, count: usize, spacing: f64, per_sphere: Vec3) -> Chain {
    let mut loads = vec![per_sphere; count];
    loads[count - 1] *= 0.5;
    at_rest_under(shear, spacing, loads)
}

fn at_rest_under(shear: BeamShear, spacing: f64, loads: Vec<Vec3>) -> Chain {
    let count = loads.len();
    let mut chain = Chain::new(bond(shear, 0.05), count, RADIUS, DENSITY, spacing);
    chain.is_clamped = true;
    chain.load = loads;
    let length = spacing * (count - 1) as f64;
    let section = chain.bond.section;
    let lowest =
        3.516 / length.powi(2) * (section.young * section.second_moment() / (chain.mass / spacing)).sqrt();
    let stiff = (section.stiffness(spacing).axial / chain.mass).sqrt();
    let dt = 0.15 / stiff;
    chain.drag = 2.0 * lowest;
    for _ in 0..(30.0 / lowest / dt) as usize {
        chain.step(dt);
    }
    chain
}

/// Deflections of the tip of a beam under point loads at the nodes, by bending and by shear with κ G A.
fn nodal_deflection(chain: &Chain, spacing: f64, factor: f64) -> [f64; 2] {
    let count = chain.load.len();
    let length = spacing * (count - 1) as f64;
    let section = chain.bond.section;
    let (bending, shearing) =
        (section.young * section.second_moment(), factor * section.shear_modulus * section.area());
    let mut sums = [0.0; 2];
    for (i, load) in chain.load.iter().enumerate().skip(1) {
        let at = spacing * i as f64;
        sums[0] += load.y * at * at * (3.0 * length - at) / (6.0 * bending);
        sums[1] += load.y * at / shearing;
    }
    sums
}

/// The Timoshenko element is exact at the nodes; q L⁴/(8 E I) is bending alone, under a load without lumps.
#[test]
fn a_cantilever_bends_as_a_beam() {
    for (count, spacing) in [(10, TOUCHING), (20, TOUCHING), (10, 2.0 * TOUCHING)] {
        let force = -1e-5 / (count as f64 / 10.0).powi(4);
        let length = spacing * (count - 1) as f64;
        for shear in [BeamShear::default(), BeamShear::ShearOnly, BeamShear::BendingOnly] {
            let chain = at_rest(shear, count, spacing, Vec3::y() * force);
            let ours = chain.position[count - 1].y;
            let euler = force / spacing * length.powi(4)
                / (8.0 * chain.bond.section.young * chain.bond.section.second_moment());
            let wanted = match shear {
                BeamShear::Timoshenko => nodal_deflection(&chain, spacing, BeamShear::FACTOR).iter().sum(),
                BeamShear::BendingOnly => nodal_deflection(&chain, spacing, 1.0)[0],
                // Each element bends in steps: the sum of the angles of the elements before it, turned at mid-length.
                BeamShear::ShearOnly => {
                    let cells: f64 = (1..count)
                        .map(|i| {
                            let arm = |k: usize| (i as f64 - k as f64 - 0.5) * spacing;
                            let square: f64 =
                                (0..i).map(|k| arm(k) * (arm(k) + spacing * (count - 1 - i) as f64)).sum();
                            chain.load[i].y * square * spacing
                        })
                        .sum();
                    cells / (chain.bond.section.young * chain.bond.section.second_moment())
                        + nodal_deflection(&chain, spacing, 1.0)[1]
                }
            };
            println!(
                "{count} spheres, spacing {:.0} r, {shear:?}: {ours:.5e} m, beam of point loads {:.6}, q L4/(8 E I) {:.4}",
                spacing / RADIUS,
                ours / wanted,
                ours / euler
            );
            assert!((ours / wanted - 1.0).abs() < 1e-5, "{ours} for {wanted}");
        }
    }
}

/// Ten spheres of a radius of 1 mm under their weight: 9.54e-7 m by q L⁴/(8 E I) with the weight of all ten spread over the
/// nine gaps; the last one, whose whole weight hangs at the tip, adds 4.5 %.
#[test]
fn a_cantilever_of_ten_spheres_bends_under_its_weight() {
    let weight = DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3) * 9.81;
    let chain = at_rest_under(BeamShear::default(), TOUCHING, vec![Vec3::y() * -weight; 10]);
    let ours = chain.position[9].y;
    let wanted: f64 = nodal_deflection(&chain, TOUCHING, 0.9).iter().sum();
    println!("ten spheres under their weight: {ours:.4e} m, over 9.54e-7 m {:.4}", -ours / 9.54e-7);
    assert!((ours / wanted - 1.0).abs() < 1e-5 && (-ours / 9.54e-7 - 1.045).abs() < 1e-3);
}

#[test]
fn a_chain_under_its_weight_stretches_as_a_rod() {
    for count in [10, 20] {
        let chain = at_rest(BeamShear::default(), count, TOUCHING, Vec3::x() * 1e-3);
        let length = TOUCHING * (count - 1) as f64;
        let ours = chain.position[count - 1].x - length;
        // q L²/(2 E A), exact at the nodes for lumps with half a lump at the end.
        let exact = 1e-3 / TOUCHING * length * length / (2.0 * 1e9 * chain.bond.section.area());
        println!("{count} spheres, axial: {ours:.6e} m, over q L2/(2 E A) {:.8}", ours / exact);
        assert!((ours / exact - 1.0).abs() < 1e-5, "{ours} {exact}");
    }
}

/// 2π/3.516 L² √(ρ/E I) is the period of a slender beam; lumps, turning spheres and shear make it longer.
#[test]
fn a_cantilever_vibrates_as_a_beam() {
    let mut errors = Vec::new();
    for count in [10, 20] {
        let mut chain = at_rest(BeamShear::default(), count, TOUCHING, Vec3::y() * -1e-6);
        // The last sphere as half a lump is not what vibrates; the beam ends half a sphere on.
        chain.load.fill(Vec3::zeros());
        chain.drag = 0.0;
        chain.bond.damping = 0.0;
        let length = TOUCHING * (count as f64 - 0.5);
        let section = chain.bond.section;
        let period = 1.787
            * length.powi(2)
            * (chain.mass / TOUCHING / (section.young * section.second_moment())).sqrt();
        let dt = 0.1 / (section.stiffness(TOUCHING).axial / chain.mass).sqrt();
        let (mut crossings, mut last) = (Vec::new(), chain.position[count - 1].y);
        for step in 0..(6.0 * period / dt) as usize {
            chain.step(dt);
            let now = chain.position[count - 1].y;
            if last < 0.0 && now >= 0.0 {
                crossings.push((step as f64 - now / (now - last)) * dt);
            }
            last = now;
        }
        let measured = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
        println!(
            "{count} spheres: period {measured:.5e} s, over that of a slender beam {:.4}",
            measured / period
        );
        errors.push((measured / period - 1.0).abs());
    }
    assert!(errors[0] < 0.005 && errors[1] < 0.6 * errors[0], "{errors:?}");
}

/// Bonds hold just below the strength and break just above it: tension, shear, bending and torsion by hand.
#[test]
fn a_bond_breaks_at_its_stress() {
    let (area, arm) = (PI * RADIUS * RADIUS, 4.0 / (PI * RADIUS.powi(3)));
    let pair = BondedPair {
        normal: Vec3::x(),
        distance: TOUCHING,
        velocity: Vec3::zeros(),
        spins: [Vec3::zeros(); 2],
        mass: 1e-5,
        inverse_inertia: 1e12,
    };
    let of = |distance: f64, lean: f64, turn: Vec3, strength: Strength| {
        let mut state = BondState::new(&pair, 1e-7);
        state.turn = turn;
        let normal = Vec3::new((1.0 - lean * lean).sqrt(), lean, 0.0);
        let bond = Bond { strength, ..bond(BeamShear::default(), 0.0) };
        bond.load(&mut state, &BondedPair { normal, distance, ..pair }, 1e-7)
    };
    let stiffness = bond(BeamShear::default(), 0.0).section.stiffness(TOUCHING);
    let cases = [
        (TOUCHING * 1.001, 0.0, Vec3::zeros(), stiffness.axial * 0.001 * TOUCHING / area, 0.0),
        (TOUCHING, 1e-3, Vec3::zeros(), 0.0, stiffness.shear * 1e-3 * TOUCHING / area),
        (TOUCHING, 0.0, Vec3::new(0.0, 3e-3, 4e-3), stiffness.bending * 5e-3 * arm, 0.0),
        (TOUCHING, 0.0, Vec3::new(2e-3, 0.0, 0.0), 0.0, stiffness.torsion * 2e-3 * 0.5 * arm),
        (TOUCHING * 1.001, 0.0, Vec3::y() * 2e-3, 1e6 + stiffness.bending * 2e-3 * arm, 0.0),
        // Pressed: bending must first make up for the pressure.
        (TOUCHING * 0.999, 0.0, Vec3::y() * 3e-3, stiffness.bending * 3e-3 * arm - 1e6, 0.0),
    ];
    for (distance, lean, turn, tensile, shear) in cases {
        assert!(tensile.max(shear) > 1e5);
        for (factor, holds) in [(1.0 + 1e-9, true), (1.0 - 1e-9, false)] {
            let weaker = |stress: f64| if stress > 0.0 { factor * stress } else { 1e3 };
            let strength = Strength { tensile: weaker(tensile), shear: weaker(shear) };
            assert_eq!(of(distance, lean, turn, strength).is_some(), holds, "{tensile} {shear} {factor}");
        }
    }
}

/// A cantilever loaded more and more at its tip breaks first at its root, at P (L − l/2) r/I = σ.
#[test]
fn a_cantilever_breaks_at_its_root() {
    let (count, tensile) = (10, 2e6);
    let length = TOUCHING * 9.0;
    let force = tensile * PI * RADIUS.powi(3) / 4.0 / (length - RADIUS);
    for (factor, broken) in [(0.99, 0), (1.01, 1)] {
        let mut chain = at_rest(BeamShear::default(), count, TOUCHING, Vec3::zeros());
        chain.bond.strength.tensile = tensile;
        let dt = 0.15 / (chain.bond.section.stiffness(TOUCHING).axial / chain.mass).sqrt();
        let ramp = (60.0 / chain.drag / dt) as usize;
        for step in 0..2 * ramp {
            chain.load[count - 1] = Vec3::y() * (factor * force * (step as f64 / ramp as f64).min(1.0));
            chain.step(dt);
            if chain.broken > 0 {
                break;
            }
        }
        assert_eq!(chain.broken, broken);
        assert!(broken == 0 || chain.states[0].length == 0.0);
    }
}

#[test]
fn forces_and_torques_balance_and_do_not_depend_on_which_body_is_first() {
    let mut random = random();
    let dt = 1e-6;
    for _ in 0..200 {
        let pair = |random: &mut _| {
            let apart = Vec3::x() + random_vector(random) * 0.3;
            BondedPair {
                normal: apart.normalize(),
                distance: TOUCHING * apart.norm(),
                velocity: random_vector(random),
                spins: [random_vector(random) * 1e3, random_vector(random) * 1e3],
                mass: 5e-6,
                inverse_inertia: 5e11,
            }
        };
        let bond = bond(BeamShear::default(), 0.3);
        let mut state = BondState::new(&pair(&mut random), dt);
        state.turn = random_vector(&mut random) * 0.1;
        let now = pair(&mut random);
        let mut other_state = state.reversed();
        let other = BondedPair {
            normal: -now.normal,
            velocity: -now.velocity,
            spins: [now.spins[1], now.spins[0]],
            ..now
        };
        let BondLoad { force, torques } = bond.load(&mut state, &now, dt).unwrap();
        let reversed = bond.load(&mut other_state, &other, dt).unwrap();
        let moment = torques[0] + torques[1] - now.normal.cross(&force) * now.distance;
        assert!(moment.norm() < 1e-14 * (torques[0].norm() + torques[1].norm()), "{moment}");
        assert_eq!(reversed.force, -force);
        assert_eq!(reversed.torques, [torques[1], torques[0]]);
        assert_eq!(other_state, state.reversed());
        assert_eq!(BondState::from(<[f64; BondState::NUMBERS]>::from(state)), state);
    }
}

/// A shaken chain without damping keeps momentum and angular momentum to rounding and, to second order in dt, its energy.
#[test]
fn a_shaken_chain_conserves() {
    let mut drifts = Vec::new();
    for refinement in [1.0, 2.0] {
        let mut random = random();
        let mut chain = Chain::new(bond(BeamShear::default(), 0.0), 6, RADIUS, DENSITY, TOUCHING);
        for i in 0..6 {
            chain.velocity[i] = random_vector(&mut random) * 0.05;
            chain.spin[i] = random_vector(&mut random) * 50.0;
        }
        let stiff = (chain.bond.section.stiffness(TOUCHING).axial / chain.mass).sqrt();
        let dt = 0.04 / stiff / refinement;
        chain.make_bonds(dt);
        let before = (chain.momentum(), chain.angular_momentum(dt), chain.energy(dt));
        let mut worst = 0.0_f64;
        for _ in 0..(2000.0 * refinement) as usize {
            chain.step(dt);
            worst = worst.max((chain.energy(dt) / before.2 - 1.0).abs());
        }
        drifts.push(worst);
        let linear = (chain.momentum() - before.0).norm() / before.0.norm();
        let angular = (chain.angular_momentum(dt) - before.1).norm() / before.1.norm();
        println!("dt {dt:.3e}: energy {worst:.2e}, momentum {linear:.1e}, angular momentum {angular:.1e}");
        assert!(linear < 1e-12 && angular < 1e-12);
    }
    assert!(drifts[0] < 0.1 && drifts[1] < 0.4 * drifts[0], "{drifts:?}");
}

/// Without damping a block of 64 spheres loses energy and gains none: velocities at the time of positions are extrapolated.
#[test]
fn an_undamped_lattice_does_not_gain_energy() {
    for part in [0.05, 0.1, 0.2, 0.4] {
        let mut random = random();
        let mut block = Chain::cubic(bond(BeamShear::default(), 0.0), 4, RADIUS, DENSITY);
        for i in 0..64 {
            block.velocity[i] = random_vector(&mut random) * 1e-3;
            block.spin[i] = random_vector(&mut random);
        }
        let dt = part / (block.bond.section.stiffness(TOUCHING).axial / block.mass).sqrt();
        block.make_bonds(dt);
        let start = block.energy(dt);
        for _ in 0..10 {
            (0..1000).for_each(|_| block.step(dt));
            assert!(block.energy(dt) < 1.02 * start, "{part}: {} of {start} J", block.energy(dt));
        }
        println!("dt {part} sqrt(m/Kn), left after 10,000 steps: {:.3}", block.energy(dt) / start);
    }
}

/// A bonded pair turns a hundred times as a rigid body, about its axis, across it and askew: no stress but that of centrifugal force.
#[test]
fn a_hundred_rigid_turns_leave_no_stress() {
    for axis in [Vec3::x(), Vec3::z(), Vec3::new(1.0, 0.5, -0.7).normalize()] {
        let bond = bond(BeamShear::default(), 0.0);
        let steps_per_turn = 400;
        let (rate, dt) = (10.0, 2.0 * PI / 10.0 / f64::from(steps_per_turn));
        let spin = axis * rate;
        let at = |step: i32| {
            let angle = 2.0 * PI * f64::from(step % steps_per_turn) / f64::from(steps_per_turn);
            let normal = nalgebra::Rotation3::new(axis * angle) * Vec3::x();
            let distance = TOUCHING;
            let velocity = spin.cross(&normal) * distance;
            BondedPair { normal, distance, velocity, spins: [spin; 2], mass: 5e-6, inverse_inertia: 5e11 }
        };
        let mut state = BondState::new(&at(0), dt);
        // A stress that turns with the bodies: it must come back as it was.
        let turn = Vec3::new(1e-3, -2e-3, 0.5e-3);
        state.turn += turn;
        let before = state.turn;
        let first = bond.load(&mut state, &at(0), dt).unwrap();
        let mut worst = 0.0_f64;
        for step in 1..100 * steps_per_turn {
            let load = bond.load(&mut state, &at(step), dt).unwrap();
            let pair = at(step);
            let moment = (load.torques[0] - load.torques[1]).norm();
            let wanted = (first.torques[0] - first.torques[1]).norm();
            worst = worst.max((moment / wanted - 1.0).abs());
            let lean = load.force.norm() / bond.section.stiffness(TOUCHING).shear / pair.distance;
            worst = worst.max(lean);
        }
        let drift = (state.turn - before).norm() / turn.norm();
        println!("axis {:.2?}: stress {worst:.1e}, moment after 100 turns {drift:.1e}", axis.as_slice());
        assert!(worst < 1e-9 && drift < 1e-9, "{worst} {drift}");
    }
}

/// The same by its own motion: a free chain of five that spins a hundred times keeps its shape to what the step allows.
#[test]
fn a_spinning_chain_keeps_its_shape() {
    let mut chain = Chain::new(bond(BeamShear::default(), 0.02), 5, RADIUS, DENSITY, TOUCHING);
    let spin = Vec3::z() * 200.0;
    let middle = Vec3::x() * (2.0 * TOUCHING);
    for i in 0..5 {
        chain.spin[i] = spin;
        chain.velocity[i] = spin.cross(&(chain.position[i] - middle));
    }
    let dt = 0.1 / (chain.bond.section.stiffness(TOUCHING).axial / chain.mass).sqrt();
    chain.make_bonds(dt);
    let before = chain.angular_momentum(dt);
    for _ in 0..(100.0 * 2.0 * PI / spin.z / dt) as usize {
        chain.step(dt);
    }
    let straight = (chain.position[4] - chain.position[0]).normalize();
    let bent = (chain.position[2] - chain.position[0]).cross(&straight).norm() / TOUCHING;
    let stretch = (chain.position[4] - chain.position[0]).norm() / (4.0 * TOUCHING) - 1.0;
    let lost = (chain.angular_momentum(dt) - before).norm() / before.norm();
    println!("100 turns: bent {bent:.1e}, stretched {stretch:.2e}, angular momentum {lost:.1e}");
    assert!(bent < 1e-6 && stretch > 0.0 && stretch < 1e-4 && lost < 1e-10);
}

/// A bond that goes on with another time step has turned by what its ends have.
#[test]
fn the_turn_of_a_bond_follows_its_ends_through_a_change_of_the_time_step() {
    let bond = bond(BeamShear::default(), 0.1);
    let spins = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(-4.0, 0.0, 0.0)];
    let (normal, velocity) = (Vec3::x(), Vec3::zeros());
    let pair = BondedPair { normal, distance: 2e-3, velocity, spins, mass: 1e-5, inverse_inertia: 1e12 };
    let (long, short) = (1e-5, 4e-6);
    let mut state = BondState::new(&pair, long);
    for [before, dt] in [[long, long], [long, long], [long, long], [long, short], [short, short]] {
        bond.load_after(&mut state, &pair, [before, dt]).unwrap();
    }
    // Three long steps, a short one, and half of the next.
    let turned = (spins[1] - spins[0]) * (3.0 * long + 1.5 * short);
    assert!((state.turn - turned).norm() < 1e-12 * turned.norm(), "{} {turned}", state.turn);
}
