//! Pairs with walls that are left alone for a while, as they cannot touch so soon, change no bit.

use crate::common::{
    Random, Scene, knobbly_shapes, lattice, law, merged, mixed_shapes, setup, state_of, wall,
};
use grains_contact::Sharing;
use grains_dem::{FaceContact, Failure, Motion, OpenTube, Skin, StepError, Surface};
use grains_domain::SerialTransport;
use grains_geometry::{Core, Mat3, Rotation, SMOOTH_ANGLE, Shape, TriMesh, Vec3, WallMesh};
use std::sync::Arc;

/// A skin with which lists are rebuilt in every step: all that is near is looked at, every time.
const NONE: Skin = Skin { min: 0.0, max: 0.0, horizon: 0.0 };

/// A tray whose floor is cut into tiles, flat or bumpy, with rims on all sides.
fn tray(random: &mut Random, edge: f64, bump: f64) -> Surface {
    let cells = 4 + random.index(12);
    let side = cells + 1;
    let vertices = (0..side * side).map(|n| {
        let [x, y] = [n % side, n / side].map(|k| edge * k as f64 / cells as f64);
        let is_rim = [n % side, n / side].iter().any(|&k| k == 0 || k == cells);
        Vec3::new(x, y, if is_rim { 0.3 * edge } else { bump * random.unit() })
    });
    let corner = |n: usize| n / cells * side + n % cells;
    let faces = (0..cells * cells).map(corner).map(|n| vec![n, n + 1, n + side + 1, n + side]);
    let mesh = TriMesh::from_polygons(vertices.collect(), &faces.collect::<Vec<_>>()).unwrap();
    Surface::Mesh(Arc::new(WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap()))
}

/// A motion of a tray of a size (m) that keeps what lies in it moving.
fn motion(random: &mut Random, edge: f64) -> Motion {
    let (start, end) = (random.range(0.0, 1e-3), f64::INFINITY);
    match random.index(4) {
        0 => Motion::Fixed,
        1 => Motion::Translation { velocity: random.vector() * 0.1, start, end: 3e-3 },
        2 => {
            let amplitude = random.vector() * 0.02 * edge;
            Motion::Oscillation { amplitude, frequency: 80.0, phase: random.unit(), start, end }
        }
        _ => {
            let point = Vec3::new(0.5, 0.5, 0.1) * edge;
            Motion::Rotation { point, axis: random.direction(), rate: random.range(-20.0, 20.0), start, end }
        }
    }
}

/// Bodies that fall into a moving tray, onto a bar and a tube that stand in it.
fn scene(random: &mut Random, shapes: Vec<Shape>, periodic: bool) -> Scene {
    let (edge, kinds) = (0.02, shapes.len() as u16);
    let mut setup = setup([edge, edge, 1.5 * edge], [periodic, periodic, false], shapes, law(true));
    setup.parameters = grains_dem::StepParameters { gravity: Vec3::new(30.0, 10.0, -500.0), dt: 5e-6 };
    let bump = if random.unit() < 0.5 { 0.0 } else { 0.02 * edge };
    let mut tray = wall("tray", tray(random, edge, bump), motion(random, edge));
    tray.spans = [periodic, periodic, false];
    let (half, axis) = (Vec3::new(0.1, 0.1, 0.3) * edge, random.direction());
    let rotation: Mat3 = Rotation::new(random.vector()).to_rotation_matrix().into_inner();
    let at = |x: f64, y: f64, z: f64| Vec3::new(x, y, z) * edge;
    let bar = Surface::Solid {
        core: Core::Box(half),
        rotation,
        center: at(0.3, 0.4, 0.2),
        bounding_radius: half.norm(),
    };
    let tube = OpenTube { center: at(0.7, 0.6, 0.3), axis, radius: 0.15 * edge, half_length: 0.2 * edge };
    let floor = Surface::Plane { point: at(0.0, 0.0, 0.01), normal: Vec3::z() };
    setup.walls = vec![
        tray,
        wall("bar", bar, motion(random, edge)),
        wall("tube", Surface::OpenTube(tube), motion(random, edge)),
        wall("floor", floor, Motion::Fixed),
    ];
    for (a, normal) in [Vec3::x(), Vec3::y()].into_iter().enumerate().filter(|_| !periodic) {
        let side = |normal, point| wall("side", Surface::Plane { point, normal }, Motion::Fixed);
        setup.walls.extend([side(normal, Vec3::zeros()), side(-normal, Vec3::ith(a, edge))]);
    }
    let [lower, upper] = [0.08, 0.92].map(|share| share * edge);
    let mut particles = lattice([lower, lower, 0.55 * edge], [upper, upper, edge], 2.9e-3, kinds, 0.5);
    particles.iter_mut().for_each(|p| p.velocity.z -= 2.0);
    Scene { setup, particles }
}

#[test]
fn pairs_with_walls_left_alone_change_no_bit() {
    const STEPS: u64 = 2000;
    let mut random = Random(26);
    let kinds: [fn() -> Vec<Shape>; 3] =
        [|| vec![Shape::sphere(1.3e-3).unwrap()], || mixed_shapes(1.3e-3), || knobbly_shapes(1.3e-3)];
    let mut touching = [0; 3];
    for round in 0..18 {
        let mut scene = scene(&mut random, kinds[round % 3](), round % 2 == 1);
        scene.setup.overlap_limit = 0.9;
        scene.setup.catalogue.faces = [FaceContact::Point, FaceContact::MultiPoint][round / 3 % 2];
        scene.setup.catalogue.sharing = Sharing::Potential;
        scene.setup.skin = Skin { min: 0.4, max: 0.4, horizon: 60.0 };
        let (mut left_alone, mut looked_at) = (scene.start([1; 3], 0), {
            let mut other = Scene { setup: scene.setup.clone(), particles: scene.particles.clone() };
            other.setup.skin = NONE;
            other.start([1; 3], 0)
        });
        for step in 0..STEPS {
            let ends = [&mut left_alone, &mut looked_at].map(|dem| dem.step(&SerialTransport).err());
            // A body squeezed between walls may be shot out: through a wall that only lists with a skin hold already, or, without a skin,
            // farther than lists allow.
            let error = |end: &Option<Failure>| match end {
                Some(Failure::Here { error, .. }) => Some(error.clone()),
                _ => None,
            };
            let errors = ends.each_ref().map(error);
            let tunnels = |error: &Option<StepError>| matches!(error, Some(StepError::Tunnelling { .. }));
            if errors.iter().any(tunnels) || matches!(errors[1], Some(StepError::Jump { .. })) {
                break;
            }
            let [is_ended, also_ended] = ends.each_ref().map(|end| end.is_some());
            assert_eq!(is_ended, also_ended, "round {round}: one fails in step {step}: {ends:?}");
            if is_ended {
                break;
            }
            if step % 10 == 0 {
                let states = [&left_alone, &looked_at].map(|dem| merged(vec![state_of(dem)]));
                assert!(states[0] == states[1], "round {round}: they differ in step {step}");
                touching[round % 3] += left_alone.coordination().1.iter().sum::<u32>();
            }
        }
        let rebuilds = [&left_alone, &looked_at].map(|dem| dem.report.rebuilds);
        assert!(5 * rebuilds[0] < rebuilds[1], "round {round}: {rebuilds:?}");
    }
    assert!(touching.iter().all(|&n| n > 150), "few touch walls: {touching:?}");
}
