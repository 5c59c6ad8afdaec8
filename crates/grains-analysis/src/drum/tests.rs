use super::*;
use crate::synthetic::{ball, case, lattice, particles};
use grains_dem::ContactTable;
use grains_domain::SerialTransport;
use grains_geometry::Vec3;

const RADIUS: f64 = 0.05;
const RATE: f64 = 2.0;

fn drum(rate: f64) -> Drum {
    Drum::new(Vec3::new(0.1, 0.0, 0.2), Vec3::y() * 3.0, RADIUS, rate, Vec3::new(0.0, 0.0, -9.81)).unwrap()
}

fn catalogue() -> Catalogue {
    Catalogue {
        shapes: ball(0.0015),
        densities: vec![2470.0],
        contacts: ContactTable::new(1),
        faces: Default::default(),
        sharing: Default::default(),
    }
}

/// Many small parts of balls, so that the planes of their lattice do not show, below a plane at an angle (rad) and a height (m) in the frame of the drum.
fn bed(drum: &Drum, angle: f64, height: f64) -> Snapshot {
    let corner = drum.center - Vec3::new(RADIUS, 0.0, RADIUS);
    let sites = lattice(corner, [91, 4, 91], 0.0011);
    let is_in = |x: &Vec3| {
        let [s, h] = drum.place(x);
        s.hypot(h) < RADIUS - 0.0015 && h * angle.cos() - s * angle.sin() < height - 0.0015
    };
    particles(sites.into_iter().filter(is_in).collect())
}

#[test]
fn a_bed_that_turns_with_the_drum_has_order_one() {
    let (drum, catalogue) = (drum(RATE), catalogue());
    let mut snapshot = bed(&drum, 0.0, -0.01);
    for i in 0..snapshot.len() {
        snapshot.velocity[i] = drum.velocity_at(&snapshot.position[i]);
        snapshot.angular_velocity[i] = drum.axis * RATE;
    }
    let found = measure(&drum, (&snapshot, &catalogue), &SerialTransport);
    assert_eq!(found.order, 1.0);
    let distances: Vec<f64> = snapshot
        .position
        .iter()
        .map(|x| {
            let [s, h] = drum.place(x);
            s.hypot(h)
        })
        .collect();
    let mean = distances.iter().sum::<f64>() / distances.len() as f64 / RADIUS;
    assert!((found.speed - mean).abs() < 1e-12, "{} {mean}", found.speed);
    // Translation m r²Ω²/2 against rotation (2/5) m a²Ω²/2.
    let squares: f64 = distances.iter().map(|r| r * r).sum();
    let ratio = squares / (0.4 * 0.0015 * 0.0015 * distances.len() as f64);
    assert!((found.energies[0] / found.energies[1] / ratio - 1.0).abs() < 1e-9);
    // Half of the particles at rest: half the order.
    let n = snapshot.len();
    snapshot.velocity[..n / 2].fill(Vec3::zeros());
    let found = measure(&drum, (&snapshot, &catalogue), &SerialTransport);
    assert!((found.order - (n - n / 2) as f64 / n as f64).abs() < 1e-12);
}

#[test]
fn a_plane_surface_has_its_angle_in_the_sense_of_rotation() {
    for rate in [RATE, -RATE] {
        let drum = drum(rate);
        assert!((drum.froude() - 4.0 * RADIUS / 9.81).abs() < 1e-12);
        for degrees in [0.0_f64, 25.0, -15.0, 60.0, 85.0] {
            for height in [-0.015, 0.0, 0.015] {
                let snapshot = bed(&drum, degrees.to_radians(), height);
                let surface = measure(&drum, (&snapshot, &catalogue()), &SerialTransport).surface.unwrap();
                let found = surface.angle.to_degrees();
                assert!((found - degrees).abs() < 1.0, "{degrees} at {height}: {found}");
                assert!((surface.height - height).abs() < 0.001, "{height}: {}", surface.height);
                assert!(surface.roughness < 0.03 && surface.thrown == 0.0, "{surface:?}");
            }
        }
    }
    // The lowest point of a drum that turns counter-clockwise about y moves along −x.
    assert!((drum(RATE).forward + Vec3::x()).norm() < 1e-12);
}

#[test]
fn grains_in_flight_are_counted_and_do_not_turn_the_surface() {
    let drum = drum(RATE);
    let mut snapshot = bed(&drum, 0.4, -0.01);
    let n = snapshot.len();
    let flying: Vec<Vec3> = (0..n / 20)
        .map(|k| drum.center + drum.up * 0.02 + drum.forward * (0.0004 * k as f64 - 0.03))
        .collect();
    let number = flying
        .iter()
        .filter(|x| {
            let [s, h] = drum.place(x);
            h * 0.4_f64.cos() - s * 0.4_f64.sin() > -0.004
        })
        .count();
    snapshot.position.extend(flying);
    let snapshot = particles(snapshot.position);
    let surface = measure(&drum, (&snapshot, &catalogue()), &SerialTransport).surface.unwrap();
    assert!((surface.angle - 0.4).abs() < 0.06, "{surface:?}");
    let share = number as f64 / snapshot.len() as f64;
    assert!((surface.thrown - share).abs() < 0.01, "{} {share}", surface.thrown);
}

#[test]
fn a_ring_of_particles_has_no_surface() {
    let drum = drum(RATE);
    let ring = (0..300).map(|k| {
        let (sin, cos) = (k as f64 / 300.0 * TAU).sin_cos();
        drum.center + (drum.forward * cos + drum.up * sin) * 0.045
    });
    let found = measure(&drum, (&particles(ring.collect()), &catalogue()), &SerialTransport);
    assert!(found.surface.is_none() && found.offset < 1e-9);
    let nobody = measure(&drum, (&particles(vec![]), &catalogue()), &SerialTransport);
    assert!(nobody.surface.is_none() && nobody.speed.is_nan());
}

#[test]
fn the_drum_of_the_case_is_found_and_options_overrule_it() {
    let wall = |name: &str, radius: f64| {
        format!(
            "[[wall]]\nname = \"{name}\"\nmaterial = \"glass\"\nkind = \"cylinder\"\ncenter = [0.5, 0.5, 0.5]\naxis = [0, 1, 0]\nradius = {radius}\nmotion = {{ kind = \"rotation\", point = [0.5, 0.5, 0.5], axis = [0, 1, 0], angular_velocity = 12 }}\n"
        )
    };
    let one = case([0.0; 3], [1.0; 3], [false; 3], &wall("drum", 0.4));
    let found = Drum::chosen(&one, &DrumOptions::default()).unwrap();
    assert_eq!((found.radius, found.rate, found.center), (0.4, 12.0, Vec3::repeat(0.5)));
    let later =
        wall("drum", 0.4).replace("angular_velocity = 12", "angular_velocity = -12, start = 1, end = 3");
    let later = case([0.0; 3], [1.0; 3], [false; 3], &later);
    let found = Drum::chosen(&later, &DrumOptions::default()).unwrap();
    assert_eq!([0.5, 2.0, 4.0].map(|time| found.turned(time)), [0.0, 12.0, 24.0]);
    let two = case([0.0; 3], [1.0; 3], [false; 3], &(wall("drum", 0.4) + &wall("core", 0.1)));
    let error = Drum::chosen(&two, &DrumOptions::default()).unwrap_err();
    assert!(error.message.contains("--wall") && error.message.contains("drum, core"), "{}", error.message);
    let none = case([0.0; 3], [1.0; 3], [false; 3], "");
    assert!(Drum::chosen(&none, &DrumOptions::default()).unwrap_err().message.contains("--center"));
    assert!(Drum::new(Vec3::zeros(), Vec3::z(), 1.0, 1.0, -Vec3::z()).is_err());
    assert!(Drum::new(Vec3::zeros(), Vec3::y(), 1.0, 0.0, -Vec3::z()).is_err());
}
