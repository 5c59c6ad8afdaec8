//! Liquid bridges against the Young-Laplace equation, their energy and their budget.

use crate::young_laplace::Bridges;
use grains_contact::{
    BridgeEnd, BridgeViscosity, Capillary, Film, FilmAmount, FilmShare, FilmSupply, Formation, LiquidBridge,
    Rabinovich, Rupture, Supply, Willett, WillettShort, film_thickness, halves, whole_quanta,
};
use std::f64::consts::PI;

const VISCOSITY: BridgeViscosity = BridgeViscosity { viscosity: 1e-3, min_gap: 0.01 };

fn water(contact_angle: f64, capillary: Capillary) -> LiquidBridge {
    LiquidBridge {
        surface_tension: 0.072,
        contact_angle,
        capillary,
        rupture: Rupture::Willett,
        viscosity: VISCOSITY,
        formation: Formation::Contact,
        supply: Supply::PerBridge(1e-12),
    }
}

fn laws(angle: f64) -> [Capillary; 3] {
    [
        Capillary::Willett(Willett::new(angle)),
        Capillary::WillettShort(WillettShort::new(angle)),
        Capillary::Rabinovich(Rabinovich::new(angle)),
    ]
}

/// Half a unit of the last digit given.
fn agrees(ours: f64, given: f64) -> bool {
    (ours - given).abs() <= 0.5e-4 * (1.0 + 1e-6)
}

/// θ = 0: reduced volume, gap in radii, Young-Laplace, full and short fit.
const TABLE: [[f64; 5]; 7] = [
    [0.001, 0.0, 0.9361, 0.9188, 1.0],
    [0.001, 0.02, 0.3888, 0.3875, 0.3754],
    [0.001, 0.05, 0.1283, 0.1295, 0.1122],
    [0.01, 0.0, 0.8844, 0.8715, 1.0],
    [0.01, 0.02, 0.7050, 0.7111, 0.7634],
    [0.01, 0.05, 0.4732, 0.4710, 0.4651],
    [0.01, 0.1, 0.2514, 0.2532, 0.2198],
];

#[test]
fn fits_and_the_young_laplace_equation_give_the_table() {
    let radius = 0.8e-3;
    for [volume, gap, exact, full, short] in TABLE {
        let ours = Bridges::new(0.0, volume).scaled_force(gap);
        assert!(agrees(ours, exact), "Young-Laplace V* {volume} h {gap}: {ours}, not {exact}");
        let [willett, simple, _] =
            laws(0.0).map(|law| law.scaled_force(gap * radius, volume * radius.powi(3), radius));
        assert!(agrees(willett, full), "V* {volume} h {gap}: {willett}, not {full}");
        assert!(agrees(simple, short), "V* {volume} h {gap}: {simple}, not {short}");
    }
}

/// The full fit over its range, and how far the two short forms are off.
#[test]
fn the_full_fit_is_close_to_the_young_laplace_equation() {
    let mut worst = [0.0_f64; 3];
    for degrees in [0.0_f64, 20.0, 40.0] {
        let angle = degrees.to_radians();
        for volume in [1e-4_f64, 1e-3, 1e-2, 1e-1] {
            let bridges = Bridges::new(angle, volume);
            for part in [0.0, 0.02, 0.1, 0.3, 0.6, 0.9] {
                let gap = part * bridges.rupture_distance();
                let exact = bridges.scaled_force(gap);
                for (worst, law) in worst.iter_mut().zip(laws(angle)) {
                    *worst = worst.max((law.scaled_force(gap, volume, 1.0) - exact).abs());
                }
            }
        }
    }
    println!("largest |F - F of Young-Laplace|/(2 pi R gamma): {worst:.4?}");
    assert!(worst[0] < 0.03, "{worst:?}");
}

#[test]
fn bridges_break_where_the_criteria_say_and_where_no_meridian_is_left() {
    let table = [
        [0.0, 1e-3, 0.1, 0.1010],
        [0.0, 1e-2, 0.2154, 0.2201],
        [30.0, 1e-3, 0.1262, 0.1274],
        [30.0, 1e-2, 0.2718, 0.2777],
    ];
    for [degrees, volume, lian, willett] in table {
        let angle = f64::to_radians(degrees);
        let distances = [Rupture::Lian, Rupture::Willett].map(|rule| rule.distance(angle, volume, 1.0));
        assert!(agrees(distances[0], lian) && agrees(distances[1], willett), "{distances:?}");
        let holds = Bridges::new(angle, volume).rupture_distance();
        println!("theta {degrees} V* {volume}: Young-Laplace {holds:.4}, Willett {willett}, Lian {lian}");
        assert!((holds / willett - 1.0).abs() < 0.05, "{holds} for {willett}");
    }
}

/// The force is steady, falls with the gap, and stays below its bound, far outside the fit as well.
#[test]
fn the_pull_is_bounded_falls_with_the_gap_and_is_steady_at_contact() {
    for degrees in [0.0_f64, 15.0, 50.0] {
        for capillary in laws(degrees.to_radians()) {
            let bridge = water(degrees.to_radians(), capillary);
            let effective = 0.5e-3_f64;
            for reduced in [1e-9, 1e-6, 1e-3, 0.09, 0.5] {
                let volume = reduced * (2.0 * effective).powi(3);
                let end = bridge.rupture_distance(volume, effective);
                let mut last = bridge.pull(-1e-5, volume, effective);
                assert!(last <= bridge.force_bound(effective) && last == bridge.pull(0.0, volume, effective));
                for step in 0..=400 {
                    let gap = end * 1e-8 * 1e8_f64.powf(f64::from(step) / 400.0);
                    let pull = bridge.pull(gap, volume, effective);
                    assert!(
                        pull > 0.0 && pull <= last && pull > 0.85 * last,
                        "{reduced} {gap}: {pull} {last}"
                    );
                    last = pull;
                }
            }
        }
    }
}

/// Unequal spheres and walls take R = 2 R*: a wall pulls twice as much as an equal sphere in the limit of little liquid.
#[test]
fn a_wall_pulls_twice_as_much_as_an_equal_sphere() {
    for capillary in &laws(0.3)[1..] {
        let bridge = water(0.3, *capillary);
        let [sphere, wall] = [0.5e-3, 1e-3].map(|effective| bridge.pull(0.0, 1e-15, effective));
        assert!((wall / sphere - 2.0).abs() < 1e-12);
        assert!((sphere / (2.0 * PI * 1e-3 * 0.072 * 0.3_f64.cos()) - 1.0).abs() < 1e-12);
    }
}

/// Two spheres meet without damping, hold a bridge, part: the kinetic energy lost is the work from contact to rupture.
#[test]
fn a_bridge_that_forms_and_breaks_takes_its_work() {
    let (effective, mass, stiffness, dt) = (0.5e-3, 2e-6, 2e3, 2e-9);
    for capillary in laws(0.2) {
        let bridge = water(0.2, capillary);
        let volume = 1e-12;
        let (mut gap, mut speed, start) = (1e-7, -0.4_f64, 0.5 * mass * 0.4_f64.powi(2));
        let mut held = 0.0;
        let mut had_bridge = false;
        for _ in 0..1_000_000 {
            if had_bridge && held == 0.0 {
                break;
            }
            bridge.follow(&mut held, gap, effective, volume, 0.0);
            had_bridge |= held > 0.0;
            let push = if gap < 0.0 { -stiffness * gap } else { 0.0 };
            let pull = if held > 0.0 { bridge.pull(gap, held, effective) } else { 0.0 };
            speed += dt * (push - pull) / mass;
            gap += dt * speed;
        }
        assert!(had_bridge && held == 0.0);
        let lost = start - 0.5 * mass * speed * speed;
        let work = bridge.work(0.0, volume, effective);
        assert!((lost / work - 1.0).abs() < 2e-3, "lost {lost} J, work {work} J");
        // From a gap on, as of a bridge that formed where films touched.
        let part = 0.3 * bridge.rupture_distance(volume, effective);
        let steps = 200_000;
        let below: f64 = (0..steps)
            .map(|i| bridge.pull(part * (f64::from(i) + 0.5) / f64::from(steps), volume, effective))
            .sum();
        let rest = work - below * part / f64::from(steps);
        assert!((bridge.work(part, volume, effective) / rest - 1.0).abs() < 1e-5);
    }
}

#[test]
fn the_work_of_a_cylindrical_bridge_is_its_closed_form() {
    let (effective, volume, angle) = (0.4e-3, 3e-13, 0.4_f64);
    let bridge = water(angle, Capillary::Rabinovich(Rabinovich::new(angle)));
    let (radius, end) = (2.0 * effective, bridge.rupture_distance(volume, effective));
    let depth = 2.0 * volume / (PI * radius);
    let closed = 2.0 * PI * radius * 0.072 * angle.cos() * (end + depth.sqrt() - (end * end + depth).sqrt());
    assert!((bridge.work(0.0, volume, effective) / closed - 1.0).abs() < 1e-9);
}

#[test]
fn dashpots_are_those_of_lubrication() {
    let radius = 0.5e-3;
    // Two equal spheres of radius a: 3/2 π μ a²/h; a sphere on a wall four times as much.
    let (a, gap) = (1e-3, 2e-5);
    let dashpot = VISCOSITY.normal_dashpot(gap, radius);
    assert!((dashpot / (1.5 * PI * 1e-3 * a * a / gap) - 1.0).abs() < 1e-14);
    assert!((VISCOSITY.normal_dashpot(gap, a) / (4.0 * dashpot) - 1.0).abs() < 1e-14);
    let stokes = 6.0 * PI * 1e-3 * radius;
    for gap in [-1e-5, 0.0, 0.0099 * radius] {
        assert!((VISCOSITY.normal_dashpot(gap, radius) / (100.0 * stokes) - 1.0).abs() < 1e-14);
        let shearing = stokes * (8.0 / 15.0 * 100.0_f64.ln() + 0.9588);
        assert!((VISCOSITY.tangential_dashpot(gap, radius) / shearing - 1.0).abs() < 1e-14);
    }
    assert!((VISCOSITY.tangential_dashpot(5.0 * radius, radius) / (0.9588 * stokes) - 1.0).abs() < 1e-14);
}

#[test]
fn films_have_the_thickness_of_their_volume() {
    for relative in [1e-12, 1e-6, 1e-2, 1.0] {
        let radius = 1.3e-3;
        let thickness = relative * radius;
        let shell = (3.0 * radius * radius + (3.0 * radius + thickness) * thickness) * thickness;
        let volume = 4.0 / 3.0 * PI * shell;
        assert!((film_thickness(volume, radius) / thickness - 1.0).abs() < 1e-12);
        let body = 4.0 / 3.0 * PI * radius.powi(3);
        assert!((FilmAmount::Thickness(thickness).volume(body) / volume - 1.0).abs() < 1e-12);
    }
    assert_eq!(film_thickness(0.0, 1e-3), 0.0);
}

/// A supply that never runs into its bound.
fn films(share: FilmShare) -> FilmSupply {
    FilmSupply { share, largest: 1e-11, wall_share: 0.25 }
}

/// Bodies exchange liquid by bridges that come and go: none has less than nothing, and the sum stays to the last bit, in whatever
/// order the bridges of a step are looked at.
#[test]
fn liquid_is_conserved_exactly_and_in_any_order() {
    const QUANTUM: f64 = 1.0 / (1_u64 << 50) as f64 / (1_u64 << 27) as f64;
    let radius = 1e-3;
    for (share, formation) in [
        (FilmShare::Cap, Formation::Contact),
        (FilmShare::Constant(0.4), Formation::Films),
        (FilmShare::Constant(1.0), Formation::Films),
    ] {
        let supply = films(share);
        let bridge = LiquidBridge {
            formation,
            supply: Supply::Films(supply),
            ..water(0.1, Capillary::Willett(Willett::new(0.1)))
        };
        let mut random = random();
        let pairs: Vec<[usize; 2]> =
            (0..900).map(|k| [k % 300, (k % 300 + 1 + (299.0 * random()) as usize) % 300]).collect();
        let start: Vec<f64> = (0..300).map(|_| whole_quanta(5e-12 * random(), QUANTUM)).collect();
        let gaps: Vec<f64> = (0..900 * 200).map(|_| 4e-4 * (random() - 0.5)).collect();
        let run = |order: &dyn Fn(usize) -> usize| {
            let mut now: Vec<Film> =
                start.iter().map(|&volume| Film { volume, claimed: 0.0, offered: volume }).collect();
            let mut bridges = vec![0.0; pairs.len()];
            let (mut formed, mut broken, mut short) = (0, 0, 0);
            for step in 0..200 {
                let mut gained = vec![[0.0_f64; 2]; now.len()];
                for k in (0..pairs.len()).map(order) {
                    let end = |i: usize| BridgeEnd::Particle {
                        film: now[i],
                        share: share.of(radius, radius),
                        radius,
                    };
                    let ends = pairs[k].map(end);
                    let gap = gaps[900 * step + k];
                    let before: f64 = bridges[k];
                    let change =
                        bridge.exchange(&supply, &mut bridges[k], gap, 0.5 * radius, (&ends, QUANTUM));
                    let back = halves(change.broken, QUANTUM);
                    for (side, i) in pairs[k].into_iter().enumerate() {
                        gained[i][0] += back[side] - change.taken[side];
                        gained[i][1] += change.claimed[side];
                    }
                    formed += usize::from(bridges[k] < 0.0);
                    broken += usize::from(change.broken > 0.0);
                    short += usize::from(before < 0.0 && bridges[k] > 0.0 && bridges[k] < -before);
                }
                for (film, [gained, claimed]) in now.iter_mut().zip(gained) {
                    *film = Film { volume: film.volume + gained, claimed, offered: film.free() };
                }
                let there = now.iter().map(|film| film.volume).sum::<f64>()
                    + bridges.iter().map(|bridge| bridge.max(0.0)).sum::<f64>();
                assert_eq!(there, start.iter().sum::<f64>(), "step {step}");
                assert!(now.iter().all(|film| film.volume >= 0.0));
            }
            assert!(formed > 1000 && broken > 1000, "{formed} {broken}");
            // Where bridges take all there is, two that form at once get what they can.
            assert!(share != FilmShare::Constant(1.0) || short > 50, "{short}");
            (now, bridges)
        };
        assert_eq!(run(&|k| k), run(&|k| (k * 7 + 13) % 900));
    }
}

fn random() -> impl FnMut() -> f64 {
    let mut seed = 7_u64;
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// The cap that a body sees of another, by quadrature over its surface; of a wall, half.
#[test]
fn a_bridge_takes_the_cap_that_the_other_body_sees() {
    for [radius, other] in [[1.0_f64, 1.0], [1.0, 3.0], [1.0, 0.2], [1.0, 1e6]] {
        // Seen are places whose direction is less than asin(R2/(R1 + R2)) off the line of centres.
        let widest = (other / (radius + other)).asin();
        let steps = 20_000;
        let width = widest / f64::from(steps);
        let area: f64 = (0..steps).map(|k| ((f64::from(k) + 0.5) * width).sin() * width).sum();
        assert!((FilmShare::Cap.of(radius, other) / (0.5 * area) - 1.0).abs() < 1e-6, "{other}");
    }
    assert_eq!(FilmShare::Cap.of(1.0, f64::INFINITY), 0.5);
    // The cap of a film on ever flatter bodies is that of a wall.
    let (radius, thickness, flat) = (1e-3, 1e-6, 1e3_f64);
    let film = FilmAmount::Thickness(thickness).volume(4.0 / 3.0 * PI * flat.powi(3));
    let sine = radius / (flat + radius);
    let BridgeEnd::Wall { volume, .. } = films(FilmShare::Cap).wall(thickness, radius) else { panic!() };
    assert!((film * 0.25 * sine * sine / volume - 1.0).abs() < 1e-5);
}

#[test]
fn the_bridge_does_not_depend_on_which_body_is_first() {
    let q = 2.0_f64.powi(-80);
    let supply = films(FilmShare::Constant(0.5));
    let bridge =
        LiquidBridge { supply: Supply::Films(supply), ..water(0.0, Capillary::Willett(Willett::new(0.0))) };
    let end = |volume: f64, claimed: f64, share: f64| BridgeEnd::Particle {
        film: Film { volume: whole_quanta(volume, q), claimed: whole_quanta(claimed, q), offered: 4e-12 },
        share,
        radius: 1e-3,
    };
    let ends = [end(1e-13, 0.0, 0.5), end(4e-12, 8e-12, 0.3)];
    let swapped = [ends[1], ends[0]];
    for (start, gap) in [(0.0, -1e-7), (-1e-12, -1e-7), (-1e-12, 1e-3), (3e-12, 1e-3)] {
        let (mut one, mut two) = (start, start);
        let change = bridge.exchange(&supply, &mut one, gap, 5e-4, (&ends, q));
        let other = bridge.exchange(&supply, &mut two, gap, 5e-4, (&swapped, q));
        assert_eq!(one, two);
        let mirrored = |pair: [f64; 2]| [pair[1], pair[0]];
        assert_eq!(
            (change.claimed, change.taken, change.broken),
            (mirrored(other.claimed), mirrored(other.taken), other.broken)
        );
    }
}
