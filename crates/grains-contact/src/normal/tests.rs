//! Laws against their closed forms.

use super::*;
use crate::{ContactLaw, Tangential};

const MODULUS: f64 = 1e7;
const WORK: f64 = 0.1;
const RADIUS: f64 = 2.5e-3;

fn approach(overlap: f64) -> Approach {
    Approach { overlap, opening: 0.0, radius: RADIUS, dt: 0.0 }
}

fn jkr(tear: Tear) -> Jkr {
    Jkr { modulus: MODULUS, work: WORK, tear }
}

/// Gaps are multiples of (R* γ²/E*²)^(1/3) with γ = w/2.
fn unit_gap() -> f64 {
    (RADIUS * 0.25 * WORK * WORK / (MODULUS * MODULUS)).cbrt()
}

fn is_close(got: f64, wanted: f64, tolerance: f64) {
    assert!((got / wanted - 1.0).abs() < tolerance, "{got} instead of {wanted}");
}

#[test]
fn jkr_has_the_numbers_of_its_closed_forms() {
    let law = jkr(Tear::Displacement);
    is_close(law.pull_off(RADIUS), 1.178097e-3, 1e-6);
    is_close(law.reach(RADIUS), 2.5540 * unit_gap(), 1e-4);
    is_close(jkr(Tear::Load).reach(RADIUS), 1.22772 * unit_gap(), 1e-5);
    is_close(jkr(Tear::Load).reach(RADIUS), 4.87222e-7, 1e-5);
    let mut adhered = 1.0;
    let at_load = law.respond(&approach(-jkr(Tear::Load).reach(RADIUS)), &mut adhered);
    is_close(at_load.elastic, -law.pull_off(RADIUS), 1e-12);
    let at_end = law.respond(&approach(-law.reach(RADIUS) * (1.0 - 1e-9)), &mut adhered);
    is_close(at_end.elastic, -5.0 / 9.0 * law.pull_off(RADIUS), 1e-3);
    let touch = law.respond(&approach(1e-15), &mut 0.0);
    is_close(touch.elastic, -8.0 / 9.0 * law.pull_off(RADIUS), 1e-6);
    let a0 = (9.0 * std::f64::consts::PI * 0.5 * WORK * RADIUS * RADIUS / MODULUS).cbrt();
    is_close(a0, 9.59579e-5, 1e-6);
    let at_rest = law.respond(&approach(a0 * a0 / (3.0 * RADIUS)), &mut 0.0);
    is_close(at_rest.contact_radius, a0, 1e-12);
    assert!(at_rest.elastic.abs() < 1e-12 * law.pull_off(RADIUS), "{}", at_rest.elastic);
}

/// a of the answer solves δ = a²/R − √(2π w a/E), over eight orders of magnitude of overlap and down to the end.
#[test]
fn jkr_solves_its_equation() {
    let law = jkr(Tear::Displacement);
    let solves = |overlap: f64| {
        let found = law.respond(&approach(overlap), &mut 1.0);
        let a = found.contact_radius;
        let (push, pull) = (a * a / RADIUS, (2.0 * std::f64::consts::PI * WORK * a / MODULUS).sqrt());
        assert!((push - pull - overlap).abs() < 1e-14 * (push + pull), "{overlap}");
        let force = 4.0 * MODULUS * a.powi(3) / (3.0 * RADIUS)
            - (8.0 * std::f64::consts::PI * WORK * MODULUS * a.powi(3)).sqrt();
        assert!((found.elastic - force).abs() < 1e-12 * (force.abs() + law.pull_off(RADIUS)));
    };
    let mut overlap = 1e-10;
    while overlap < 1e-2 {
        solves(overlap);
        overlap *= 1.07;
    }
    (0..1000).for_each(|k| solves(-law.reach(RADIUS) * f64::from(k) / 1001.0));
}

#[test]
fn jkr_holds_what_touched_and_lets_go_of_what_did_not() {
    let law = jkr(Tear::Load);
    let end = law.reach(RADIUS);
    let mut memory = 0.0;
    assert!(!law.respond(&approach(-0.5 * end), &mut memory).is_contact && memory == 0.0);
    assert!(law.respond(&approach(0.1 * end), &mut memory).is_contact && memory == 1.0);
    assert!(law.respond(&approach(-0.99 * end), &mut memory).is_contact && memory == 1.0);
    assert!(!law.respond(&approach(-1.01 * end), &mut memory).is_contact && memory == 0.0);
}

#[test]
fn walls_of_plasticity_are_kept() {
    let law = ElasticPlastic { loading: 1e4, unloading: 4e4, adhesion: 1e4 };
    let mut memory = 0.0;
    let mut force = |overlap: f64| law.respond(&approach(overlap), &mut memory).elastic;
    is_close(force(1e-5), 0.1, 1e-12);
    is_close(force(2e-5), 0.2, 1e-12);
    is_close(force(1.8e-5), 0.2 - 0.08, 1e-12);
    is_close(force(1.9e-5), 0.2 - 0.04, 1e-12);
    // δ0 = 1.5e-5; the line of adhesion is met at 1.2e-5.
    assert!(force(1.5e-5).abs() < 1e-15);
    is_close(force(1.2e-5), -0.12, 1e-12);
    is_close(force(1e-5), -0.1, 1e-12);
    // Loaded again it follows the line of unloading from there.
    is_close(force(1.1e-5), -0.1 + 0.04, 1e-12);
}

/// Restitution of head-on collisions under every law where nothing adheres, and the energy of adhesion where it does.
#[test]
fn bodies_part_with_the_restitution_asked_for() {
    let hertz = Hertz { modulus: MODULUS };
    let none = Tangential::Viscous { rate: 0.0 };
    let (mass, speed) = (6e-5, 0.7);
    for e in [0.1, 0.3, 0.5, 0.73, 0.9, 1.0] {
        let laws: [Normal; 6] = [
            Linear { stiffness: 1e4 }.into(),
            hertz.into(),
            Dmt { hertz, work: 1e-9 }.into(),
            jkr_of(1e-9),
            Sjkr { hertz, energy_density: 1e-3, area: CohesionArea::Lens }.into(),
            ElasticPlastic::with_restitution(1e4, e, 0.0).into(),
        ];
        for normal in laws {
            let found = ContactLaw::new(normal, e, 0.0, none).collision(mass, RADIUS, speed);
            assert!((found.restitution / e - 1.0).abs() < 5e-3, "{}: {found:?} for {e}", normal.name());
        }
    }
    // What JKR keeps: ∫ F dδ over the loop from 0 to the end, 7.09 (w⁵ R⁴/E²)^(1/3) at the displacement it tears at.
    let law = ContactLaw::new(jkr(Tear::Displacement), 1.0, 0.0, none);
    let energy = jkr_loop_energy();
    let speed = (2.0 * 3.0 * energy / mass).sqrt();
    let found = law.collision(mass, RADIUS, speed);
    is_close(found.restitution, (2.0_f64 / 3.0).sqrt(), 5e-3);
    let slow = law.collision(mass, RADIUS, (2.0 * 0.9 * energy / mass).sqrt());
    assert!(slow.restitution == 0.0, "{slow:?}");
}

fn jkr_of(work: f64) -> Normal {
    Jkr { modulus: MODULUS, work, tear: Tear::Displacement }.into()
}

/// Energy that bodies at δ = 0 still need to part: −∫ F dδ = (E* a0⁵/R*²) ∫ (2 t³ − 4/3 t⁶)(4 t³ − 1) dt from the end to t = 1.
fn jkr_loop_energy() -> f64 {
    let whole = |t: f64| -> f64 {
        // 8 t⁶ − 2 t³ − 16/3 t⁹ + 4/3 t⁶.
        (8.0 + 4.0 / 3.0) / 7.0 * t.powi(7) - 0.5 * t.powi(4) - 16.0 / 30.0 * t.powi(10)
    };
    let a0 = (2.0 * std::f64::consts::PI * WORK * RADIUS * RADIUS / MODULUS).cbrt();
    MODULUS * a0.powi(5) / (RADIUS * RADIUS) * (whole(1.0) - whole(SMALLEST_T_OF_TEST))
}

const SMALLEST_T_OF_TEST: f64 = 0.629_960_524_947_436_6;

#[test]
fn adhesion_of_dmt_takes_no_energy() {
    let law = ContactLaw::new(
        Dmt { hertz: Hertz { modulus: MODULUS }, work: WORK },
        1.0,
        0.0,
        Tangential::Viscous { rate: 0.0 },
    );
    for speed in [0.01, 0.1, 1.0] {
        is_close(law.collision(6e-5, RADIUS, speed).restitution, 1.0, 5e-3);
    }
}
