//! A cylinder hits a plane at all angles (Park 2003, Kodam et al. 2010; thesis eqs 3.37-3.38 as corrected): the
//! short form of cases/cylinder-impact.

use crate::common::{setup, wall};
use grains_contact::{ContactLaw, Sharing, Tangential};
use grains_dem::{Dem, FaceContact, Kind, Motion, NewParticle, Surface};
use grains_domain::SerialTransport;
use grains_geometry::{Rotation, Shape, Vec3};

const RADIUS: f64 = 4e-3;
const HEIGHT: f64 = 5.3e-3;
const RESTITUTION: f64 = 0.85;
/// Crust over inscribed radius: edges rounded by 5 micrometres.
const CRUST: f64 = 0.002;
const FLOOR: f64 = 0.05;

/// What an impact leaves: velocity of the centre away from the wall (m/s), angular velocity (rad/s), and
/// duration of the contact (s).
#[derive(Debug)]
struct Rebound {
    velocity: f64,
    omega: f64,
    duration: f64,
}

/// The rebound of a rigid cylinder that meets the wall at 1 m/s, its axis `angle` (rad) off the normal, and
/// the lever of its contact point (m).
fn rigid(angle: f64) -> (Rebound, f64) {
    let lever = RADIUS * angle.cos() - 0.5 * HEIGHT * angle.sin();
    // M l²/I, with I = M (3 R² + L²)/12.
    let ratio = lever * lever * 12.0 / (3.0 * RADIUS * RADIUS + HEIGHT * HEIGHT);
    let push = (1.0 + RESTITUTION) / (1.0 + ratio);
    let omega = push * ratio / lever;
    (Rebound { velocity: push - 1.0, omega, duration: 0.0 }, lever)
}

fn drop(shape: Shape, angle: f64, faces: FaceContact, sharing: Sharing) -> Rebound {
    let law = ContactLaw::linear(1e8, RESTITUTION, 0.0, Tangential::Viscous { rate: 0.0 });
    let mut setup = setup([0.1; 3], [false; 3], vec![shape], law);
    (setup.catalogue.faces, setup.catalogue.sharing) = (faces, sharing);
    setup.catalogue.contacts.set(0, 1, law);
    setup.parameters.gravity = Vec3::zeros();
    setup.parameters.dt = 1e-8;
    let floor = Surface::Plane { point: Vec3::new(0.0, 0.0, FLOOR), normal: Vec3::z() };
    setup.walls = vec![wall("floor", floor, Motion::Fixed)];
    let mut dem = Dem::new(setup, 0).unwrap();
    let lowest = RADIUS * angle.sin() + 0.5 * HEIGHT * angle.cos();
    let new = NewParticle {
        id: 0,
        kind: Kind { shape: 0, material: 0 },
        scale: 1.0,
        position: Vec3::new(0.05, 0.05, FLOOR + lowest + 1e-6),
        orientation: Rotation::from_axis_angle(&Vec3::y_axis(), -angle),
        velocity: -Vec3::z(),
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    };
    let record = new.record(&dem);
    dem.insert(&record);
    let (mut begun, mut step) = (None, 0);
    loop {
        dem.step(&SerialTransport).unwrap();
        step += 1;
        let touches = dem.wall_loads(&SerialTransport)[0].force.z != 0.0;
        match begun {
            None if touches => begun = Some(step),
            Some(first) if !touches => {
                let body = &dem.particles.bodies[0];
                let duration = (step - first) as f64 * 1e-8;
                return Rebound { velocity: body.velocity.z, omega: body.angular_velocity.y, duration };
            }
            _ => assert!(step < 10_000, "no rebound"),
        }
    }
}

#[test]
fn the_cylinder_and_its_slices_rebound_as_a_rigid_body() {
    let whole = || Shape::cylinder(RADIUS, HEIGHT, CRUST).unwrap();
    let sliced = || Shape::sliced_cylinder(RADIUS, HEIGHT, 10, CRUST).unwrap();
    for degrees in [10.0, 30.0, 45.0, 60.0, 80.0_f64] {
        let angle = degrees.to_radians();
        let (exact, lever) = rigid(angle);
        for (shape, sharing) in [
            (whole(), Sharing::Potential),
            (sliced(), Sharing::Potential),
            (sliced(), Sharing::Mean),
            (sliced(), Sharing::Sum),
        ] {
            let found = drop(shape, angle, FaceContact::Point, sharing);
            let what = format!("{degrees} degrees, {sharing:?}: {found:?} instead of {exact:?}");
            assert!((found.velocity - exact.velocity).abs() < 0.01, "{what}");
            assert!((found.omega - exact.omega).abs() < 0.01 * 366.8, "{what}");
            let leaving = found.velocity + found.omega * lever;
            assert!((leaving / RESTITUTION - 1.0).abs() < 0.01, "contact point at {leaving} m/s, {what}");
        }
    }
}

#[test]
fn lines_and_faces_rebound_without_spin() {
    for degrees in [0.0, 90.0_f64] {
        let whole = Shape::cylinder(RADIUS, HEIGHT, CRUST).unwrap();
        let found = drop(whole, degrees.to_radians(), FaceContact::MultiPoint, Sharing::Mean);
        assert!((found.velocity / RESTITUTION - 1.0).abs() < 1e-3 && found.omega.abs() < 1e-3, "{found:?}");
    }
}

#[test]
fn contacts_shorten_with_the_root_of_their_number_in_model_a_and_stay_in_model_b() {
    let lying = 90.0_f64.to_radians();
    let slices = |n| Shape::sliced_cylinder(RADIUS, HEIGHT, n, CRUST).unwrap();
    let one = drop(slices(1), lying, FaceContact::MultiPoint, Sharing::Mean).duration;
    for n in [4, 16] {
        let sum = drop(slices(n), lying, FaceContact::MultiPoint, Sharing::Sum);
        let mean = drop(slices(n), lying, FaceContact::MultiPoint, Sharing::Mean);
        assert!(
            (sum.duration * f64::from(n).sqrt() / one - 1.0).abs() < 0.02,
            "{sum:?} of {n}, one {one:e} s"
        );
        assert!((mean.duration / one - 1.0).abs() < 0.01, "{mean:?} of {n}, one {one:e} s");
        for found in [sum, mean] {
            assert!(
                (found.velocity / RESTITUTION - 1.0).abs() < 0.005 && found.omega.abs() < 1.0,
                "{found:?}"
            );
        }
    }
}
