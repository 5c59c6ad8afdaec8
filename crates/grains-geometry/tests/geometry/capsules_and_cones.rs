//! Capsules and cones: mass properties, surfaces and distances against closed forms and other routes.

use crate::gjk_common::{Kind, Pair, Random, place};
use crate::support::close;
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{
    Component, Cone, ContactPatch, Core, MassProperties, Nearest, Placement, Rotation, Shape, Simplex,
    TriMesh, Vec3,
};
use std::f64::consts::{PI, TAU};

/// Cones upright, upside down and cut, a disc and a needle.
fn cones() -> Vec<Shape> {
    [
        ([1.0, 0.0], 2.0),
        ([0.0, 0.5], 1.0),
        ([1.0, 0.4], 1.5),
        ([0.7, 0.7], 1.0),
        ([1.0, 0.0], 0.1),
        ([0.1, 0.05], 2.0),
    ]
    .into_iter()
    .map(|(radii, height)| Shape::cone(radii, height, 0.05).unwrap())
    .collect()
}

fn capsules() -> Vec<Shape> {
    [(0.5, 3.0), (1.0, 2.1), (0.1, 4.0)].map(|(r, l)| Shape::capsule(r, l).unwrap()).into_iter().collect()
}

#[test]
fn mass_properties_are_those_of_chords() {
    for shape in cones().into_iter().chain(capsules()) {
        let report = shape.mass_report();
        assert!(report.volume_difference.abs() < 1e-4, "{}: {report:?}", shape.name);
        assert!(report.inertia_difference.abs() < 2e-4, "{}: {report:?}", shape.name);
    }
}

#[test]
fn a_cone_of_equal_radii_is_a_cylinder_and_one_with_an_apex_has_its_moments() {
    let (cone, cylinder) =
        (Shape::cone([0.7; 2], 1.3, 0.02).unwrap(), Shape::cylinder(0.7, 1.3, 0.02).unwrap());
    close(cone.volume, cylinder.volume, 1e-14);
    (0..3).for_each(|a| close(cone.inertia[a], cylinder.inertia[a], 1e-14));
    let cone = Shape::cone([1.0, 0.0], 2.0, 0.02).unwrap();
    let volume = TAU / 3.0;
    close(cone.volume, volume, 1e-14);
    close(cone.inertia.z, 0.3 * volume, 1e-14);
    close(cone.inertia.x, volume * (0.15 + 3.0 / 80.0 * 4.0), 1e-14);
    close(cone.user_to_body.1.z, -0.5, 1e-14);
}

#[test]
fn surfaces_are_closed_and_their_areas_exact() {
    for shape in cones().into_iter().chain(capsules()) {
        let mass = MassProperties::of_closed_mesh(&shape.surface);
        assert!(mass.volume > 0.97 * shape.volume && mass.volume < shape.volume, "{}", shape.name);
        assert!(mass.center.norm() < 2e-2 * shape.bounding_radius, "{}: {}", shape.name, mass.center);
    }
    let cone = Shape::cone([1.0, 0.4], 1.5, 0.05).unwrap();
    close(cone.area(), PI * (1.0 + 0.16) + PI * 1.4 * 0.6f64.hypot(1.5), 1e-12);
    close(Shape::capsule(0.5, 3.0).unwrap().area(), TAU * 0.5 * 3.0, 1e-12);
}

#[test]
fn points_are_inside_where_rays_enter_and_leave() {
    let mut random = Random(3);
    for shape in cones().into_iter().chain(capsules()) {
        let part = &shape.parts[0];
        for _ in 0..2_000 {
            let direction = random.direction();
            let (point, normal) = part.surface_along(&direction).expect("the centre is inside");
            assert!(part.contains(&(point * (1.0 - 1e-9))) && !part.contains(&(point * (1.0 + 1e-9))));
            assert!(normal.dot(&direction) > 0.0 && (normal.norm() - 1.0).abs() < 1e-12);
            assert!(
                point.norm() <= shape.bounding_radius * 1.3
                    && point.norm() >= shape.inscribed_radius * (1.0 - 1e-9)
            );
        }
    }
}

#[test]
fn capsules_are_as_far_apart_as_their_axes() {
    let core = |half_length| Core::Segment { half_length };
    let across = Rotation::from_scaled_axis(Vec3::x() * (0.5 * PI));
    let cases = [
        // Crossed, side by side, end to end, and end over side.
        (across, Vec3::new(3.0, 0.2, 0.4), 3.0),
        (Rotation::identity(), Vec3::new(0.0, 2.0, 0.7), 2.0),
        (Rotation::identity(), Vec3::new(0.0, 0.0, 5.0), 2.0),
        (across, Vec3::new(0.0, 2.5, 0.0), 0.5),
    ];
    for (rotation, translation, expected) in cases {
        let found = distance(
            &core(1.0),
            &core(2.0),
            &place(&rotation, 1.0, translation),
            9.0,
            &mut Simplex::default(),
        );
        let Ok(Separation::Apart { distance, .. }) = found else { panic!("{found:?}") };
        close(distance, expected, 1e-14);
    }
}

/// The hull of many points of the rims.
fn hull_of(cone: &Cone, sides: u32) -> Core {
    let ring = |k: usize| {
        (0..sides).map(move |i| {
            let (y, x) = (TAU * f64::from(i) / f64::from(sides)).sin_cos();
            Vec3::new(cone.radii[k] * x, cone.radii[k] * y, cone.heights[k])
        })
    };
    Core::polyhedron(ring(0).chain(ring(1)).collect())
}

#[test]
fn cones_are_as_far_from_others_as_their_hulls() {
    let mut random = Random(7);
    for number in 0..400 {
        let kind =
            [Kind::Point, Kind::Box, Kind::Cylinder, Kind::Hull, Kind::Triangle, Kind::Segment][number % 6];
        let pair = Pair::random(&mut random, [Kind::Cone, kind], 3.0, false, 1.0);
        let Core::Cone(cone) = &pair.a else { panic!("no cone") };
        let hull = Pair::new(hull_of(cone, 400), pair.b.clone(), pair.placement);
        let (exact, near) = (pair.distance(&mut Simplex::default()), hull.distance(&mut Simplex::default()));
        // The sagitta of a side of 400 is 3e-5 of the radius.
        assert!(exact <= near + 1e-9 && near <= exact + 5e-5, "{kind:?}: {exact}, {near}");
    }
}

#[test]
fn superellipsoids_find_their_distance_from_cones_and_segments() {
    let mut random = Random(9);
    let body = Shape::superellipsoid(Vec3::new(0.6, 0.5, 0.4), [0.5, 1.0], 0.05).unwrap();
    for number in 0..2_000 {
        let kind = [Kind::Cone, Kind::Segment][number % 2];
        let other = random.core(kind, 5.0);
        let translation = random.direction() * 3.0;
        let pair = Pair::new(body.parts[0].core.clone(), other, place(&random.rotation(), 1.0, translation));
        let gap = pair.certify(&pair.query(&mut Simplex::default()));
        assert!(gap < 1e-9, "{kind:?}: {gap:e}");
    }
}

#[test]
fn a_capsule_and_a_cone_lie_on_lines_and_a_cone_stands_on_its_base() {
    let capsule = Core::Segment { half_length: 2.0 };
    let side = ContactPatch::on_plane(&capsule, &Vec3::x(), 0.495, 0.5).unwrap();
    assert!(
        (side.center - Vec3::zeros()).norm() < 1e-15
            && (side.overlap - 0.005 * 2f64.sqrt().sqrt().sqrt()).abs() < 1e-15
    );
    assert!((side.second[(1, 1)] - 4.0).abs() < 1e-14);
    assert!(ContactPatch::on_plane(&capsule, &Vec3::z(), 2.495, 0.5).is_none(), "a cap touches in a point");
    let cone = Cone { heights: [-1.0, 1.0], radii: [1.0, 0.0] };
    let base = ContactPatch::on_plane(&Core::Cone(cone), &-Vec3::z(), 1.0, 0.01).unwrap();
    assert!((base.center + Vec3::z()).norm() < 1e-14 && (base.second.trace() - 1.0).abs() < 1e-14);
    let normal = Vec3::new(2.0, 0.0, 1.0).normalize();
    let line = ContactPatch::on_plane(&Core::Cone(cone), &normal, 1.0 / 5f64.sqrt(), 0.01).unwrap();
    assert!((line.center - Vec3::new(0.5, 0.0, 0.0)).norm() < 1e-14);
    // Two tips side by side share nothing.
    let beside =
        Placement { matrix: grains_geometry::Mat3::identity(), translation: Vec3::new(0.0, 0.0, 2.5) };
    let nearest = Nearest { normal: Vec3::z(), point: Vec3::z() * 1.25, gap: 0.9, crusts: 1.0 };
    assert!(ContactPatch::of_cores(&capsule, &capsule, &beside, &nearest).is_none());
}

#[test]
fn composites_are_made_of_capsules_and_cones_too() {
    // A cone on a cylinder: a bullet, whose parts only touch.
    let parts = [
        Component::new(Shape::cylinder(0.5, 2.0, 0.02).unwrap(), Vec3::zeros()),
        Component::new(Shape::cone([0.5, 0.0], 1.0, 0.02).unwrap(), Vec3::new(0.0, 0.0, 1.5)),
    ];
    let bullet = Shape::glued(&parts, 0.02).unwrap();
    close(bullet.volume, PI * 0.25 * (2.0 + 1.0 / 3.0), 1e-12);
    // The centre of the cone is a quarter of its height over its base.
    close(bullet.user_to_body.1.z, 1.25 / 3.0 / (2.0 + 1.0 / 3.0), 1e-12);
    let cross = [Rotation::identity(), Rotation::from_scaled_axis(Vec3::x() * (0.5 * PI))];
    let arms =
        cross.map(|turn| Component::new(Shape::capsule(0.2, 2.0).unwrap(), Vec3::zeros()).turned(turn));
    let cross = Shape::glued(&arms, 0.02).unwrap();
    let whole = 2.0 * arms[0].shape.volume;
    // Less the Steinmetz solid 16/3 r³ that they share.
    close(cross.volume, whole - 16.0 / 3.0 * 0.008, 1e-4);
    close(cross.bounding_radius, 1.0, 1e-12);
    let surface: &TriMesh = &cross.surface;
    assert!(!surface.triangles.is_empty());
}

#[test]
fn impossible_capsules_and_cones_are_refused() {
    let message =
        |shape: Result<Shape, _>| shape.map(|_| ()).map_err(|e: grains_geometry::ShapeError| e.to_string());
    assert!(message(Shape::capsule(0.5, 0.9)).unwrap_err().contains("tip to tip"));
    assert!(Shape::cone([0.0, 0.0], 1.0, 0.02).is_err() && Shape::cone([-1.0, 1.0], 1.0, 0.02).is_err());
    assert!(Shape::cone([1.0, 0.0], 1.0, 0.7).is_err());
}
