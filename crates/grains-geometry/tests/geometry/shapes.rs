//! Shapes against closed forms.
use crate::support::{Random, close};
use grains_geometry::{
    Component, ConvexHull, Core, HullError, Lobes, MassProperties, PartFrame, RegularSolid, Rotation, Shape,
    ShapeError, Vec3, principal_axes,
};
use std::f64::consts::PI;

fn core_vertices(shape: &Shape) -> Vec<Vec3> {
    let part = &shape.parts[0];
    match &part.core {
        Core::Polyhedron(p) => p.vertices().iter().map(|v| part.rotation * v + part.center).collect(),
        Core::Box(h) => {
            (0..8).map(|i| Vec3::from_fn(|k, _| if i >> k & 1 == 1 { h[k] } else { -h[k] })).collect()
        }
        _ => panic!("no polyhedron"),
    }
}

/// The user's points in the body frame.
fn in_body_frame(shape: &Shape, points: &[Vec3]) -> Vec<Vec3> {
    let (rotation, center) = shape.user_to_body;
    points.iter().map(|p| rotation.inverse_transform_vector(&(p - center))).collect()
}

/// Checks the core of a hull against its faces moved inwards; returns the share of faces kept.
#[track_caller]
fn check_core(points: &[Vec3], crust_fraction: f64) -> f64 {
    let shape = Shape::hull(points, crust_fraction).unwrap();
    let body = ConvexHull::new(&in_body_frame(&shape, points)).unwrap();
    let (core, part) = (core_vertices(&shape), &shape.parts[0]);
    close(part.crust, crust_fraction * body.depth_of(&Vec3::zeros()), 1e-10);
    let mut kept = 0;
    for face in &body.faces {
        let reach = core.iter().map(|v| v.dot(&face.normal)).fold(f64::NEG_INFINITY, f64::max);
        let gap = face.offset - reach - part.crust;
        assert!(gap >= -1e-12 * shape.bounding_radius, "core beyond face: {gap:e}");
        kept += usize::from(gap <= 1e-12 * shape.bounding_radius);
    }
    for v in &core {
        let local = part.rotation.tr_mul(&(v - part.center));
        let room = part.half_extents - local.abs().add_scalar(part.crust);
        assert!(room.min() > -1e-12 * shape.bounding_radius);
        assert!(local.norm() + part.crust <= part.bounding_radius * (1.0 + 1e-12));
    }
    kept as f64 / body.faces.len() as f64
}

fn box_points(half: &Vec3) -> Vec<Vec3> {
    (0..8).map(|i| Vec3::from_fn(|k, _| if i >> k & 1 == 1 { half[k] } else { -half[k] })).collect()
}

fn random_hull(random: &mut Random, n: usize, stretch: &Vec3) -> Vec<Vec3> {
    (0..n).map(|_| random.direction().component_mul(stretch)).collect()
}

/// Places that are left out of the arithmetic of a part change no bit of a point; beams of crosses and lobes are such parts.
#[test]
fn frames_of_parts_say_what_their_places_leave_as_it_is() {
    let mut random = Random::new(12);
    let cross = Shape::cross(3, 1e-3, 5e-3, 0.05).unwrap();
    assert!(cross.parts.iter().all(|part| part.frame == PartFrame::OfBody));
    let lobes = Lobes::with_area_fraction(3, 1e-3, 0.69).unwrap();
    let lobes = Shape::lobes(lobes, 4e-3, 0.05).unwrap();
    assert!(lobes.parts[..3].iter().all(|part| part.frame == PartFrame::Shifted));
    let mut shapes = vec![cross, lobes];
    for _ in 0..50 {
        let edges = random.direction().abs().add_scalar(0.2);
        let beam = |random: &mut Random| {
            let turn = Rotation::from_scaled_axis(random.direction());
            Component::new(Shape::cuboid(edges, 0.05).unwrap(), random.direction() * 0.05).turned(turn)
        };
        let glued = Shape::glued(&[beam(&mut random), beam(&mut random)], 0.05).unwrap();
        assert!(glued.parts.iter().all(|part| part.frame == PartFrame::Turned));
        shapes.extend([glued, Shape::hull(&random_hull(&mut random, 12, &edges), 0.05).unwrap()]);
    }
    for part in shapes.iter().flat_map(|shape| &shape.parts) {
        let point = random.direction();
        let placed = part.rotation * point + part.center;
        match part.frame {
            PartFrame::OfBody => assert_eq!(placed, point),
            PartFrame::Shifted => assert_eq!(placed, point + part.center),
            PartFrame::Turned => assert_ne!(part.rotation * point, point),
        }
    }
}

#[test]
fn round_shapes_have_their_closed_forms() {
    let sphere = Shape::sphere(2e-3).unwrap();
    assert!(sphere.is_sphere());
    close(sphere.volume, 4.0 / 3.0 * PI * 8e-9, 1e-14);
    close(sphere.inertia.x, 0.4 * sphere.volume * 4e-6, 1e-14);
    close(sphere.sphere_equivalent_diameter(), 4e-3, 1e-14);
    assert_eq!(sphere.parts[0].crust, 2e-3);

    let cuboid = Shape::cuboid(Vec3::new(1.0, 2.0, 3.0), 0.1).unwrap();
    close(cuboid.volume, 6.0, 1e-15);
    assert!((cuboid.inertia - Vec3::new(6.5, 5.0, 2.5)).norm() < 1e-14);
    assert!(matches!(cuboid.parts[0].core, Core::Box(h) if (h - Vec3::new(0.45, 0.95, 1.45)).norm() < 1e-15));

    let cylinder = Shape::cylinder(0.5, 3.0, 0.02).unwrap();
    close(cylinder.volume, PI * 0.75, 1e-15);
    close(cylinder.inertia.z, cylinder.volume * 0.125, 1e-15);
    close(cylinder.inertia.x, cylinder.volume * (0.75 + 9.0) / 12.0, 1e-15);
    assert_eq!((cylinder.inscribed_radius, cylinder.parts[0].crust), (0.5, 0.01));
}

#[test]
fn surfaces_are_closed_and_enclose_the_volume() {
    let shapes = [
        (Shape::sphere(1.0).unwrap(), 0.03),
        (Shape::cuboid(Vec3::new(1.0, 2.0, 3.0), 0.1).unwrap(), 1e-14),
        (Shape::cylinder(1.0, 2.0, 0.1).unwrap(), 0.01),
        (Shape::regular(RegularSolid::Dodecahedron, 1.0, 0.1).unwrap(), 1e-13),
    ];
    for (shape, tolerance) in shapes {
        let report = shape.surface.report();
        assert_eq!((report.open_edges, report.non_manifold_edges), (0, 0), "{}", shape.name);
        close(MassProperties::of_closed_mesh(&shape.surface).volume, shape.volume, tolerance);
    }
}

#[test]
fn regular_solids_have_their_known_volume_and_inertia() {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    // Solid, edge for unit circumradius, V/a³, I/(V a²).
    let known = [
        (RegularSolid::Tetrahedron, 4.0 / 6f64.sqrt(), 1.0 / 72f64.sqrt(), 0.05),
        (RegularSolid::Cube, 2.0 / 3f64.sqrt(), 1.0, 1.0 / 6.0),
        (RegularSolid::Octahedron, 2f64.sqrt(), 2f64.sqrt() / 3.0, 0.1),
        (
            RegularSolid::Dodecahedron,
            2.0 / (3f64.sqrt() * golden),
            (15.0 + 7.0 * 5f64.sqrt()) / 4.0,
            (39.0 * golden + 28.0) / 150.0,
        ),
        (
            RegularSolid::Icosahedron,
            4.0 / (10.0 + 20f64.sqrt()).sqrt(),
            5.0 * (3.0 + 5f64.sqrt()) / 12.0,
            golden * golden / 10.0,
        ),
    ];
    for (solid, edge, volume, inertia) in known {
        for size in [1e-6, 1e-3, 1.0] {
            let shape = Shape::regular(solid, size, 0.02).unwrap();
            let edge = edge * size;
            close(shape.volume, volume * edge.powi(3), 1e-13);
            shape.inertia.iter().for_each(|&i| close(i, inertia * shape.volume * edge * edge, 1e-13));
            // Symmetric inertia: the user's axes stay.
            assert_eq!(shape.user_to_body.0, Rotation::identity());
            assert!(shape.user_to_body.1.norm() < 1e-15 * size);
        }
    }
}

#[test]
fn icosahedron_of_three_millimetres() {
    let shape = Shape::regular(RegularSolid::Icosahedron, 1.77308e-3, 0.02).unwrap();
    close(shape.sphere_equivalent_diameter(), 3e-3, 1e-5);
    let v = &shape.surface.vertices;
    let edge = v[1..].iter().map(|p| (p - v[0]).norm()).fold(f64::INFINITY, f64::min);
    close(edge, 1.86433e-3, 1e-5);
}

#[test]
fn eroded_regular_solids_keep_all_faces_in_place() {
    let corners = [4, 8, 6, 20, 12];
    let all = [
        RegularSolid::Tetrahedron,
        RegularSolid::Cube,
        RegularSolid::Octahedron,
        RegularSolid::Dodecahedron,
        RegularSolid::Icosahedron,
    ];
    let mut random = Random::new(3);
    for (solid, corners) in all.into_iter().zip(corners) {
        for size in [1e-6, 1e-3, 1.0] {
            for fraction in [1e-4, 0.02, 0.5] {
                let turn = random.rotation();
                let offset = random.vector() * size;
                let points: Vec<Vec3> = solid.vertices().iter().map(|v| turn * v * size + offset).collect();
                assert_eq!(check_core(&points, fraction), 1.0);
                let shape = Shape::hull(&points, fraction).unwrap();
                assert_eq!(core_vertices(&shape).len(), corners, "{solid:?}");
                // A regular solid shrinks towards its centre.
                close(shape.bounding_radius, size * (1.0 - fraction) + shape.parts[0].crust, 1e-12);
            }
        }
    }
}

#[test]
fn eroded_irregular_hulls_and_plates_are_exact() {
    let mut random = Random::new(5);
    let mut kept = Vec::new();
    for stretch in [[1.0, 1.0, 1.0], [1.0, 1.0, 0.01], [1.0, 0.01, 0.01], [1.0, 0.5, 0.1]] {
        for n in [5, 8, 12, 30, 100, 300] {
            for size in [1e-6, 1e-3, 1.0] {
                let turn = random.rotation();
                let stretch = Vec3::from(stretch) * size;
                let points: Vec<Vec3> =
                    random_hull(&mut random, n, &stretch).iter().map(|p| turn * p).collect();
                match Shape::hull(&points, 0.02) {
                    Ok(_) => kept.push(check_core(&points, 0.02)),
                    Err(error) => panic!("{n} {stretch:?}: {error}"),
                }
            }
        }
    }
    let mean = kept.iter().sum::<f64>() / kept.len() as f64;
    assert!(mean > 0.8, "{mean}");
}

#[test]
fn eroded_plates_with_parallel_faces_are_exact() {
    let mut random = Random::new(6);
    for half in [[1.0, 1.0, 0.01], [1.0, 0.01, 0.01], [1.0, 0.7, 0.4]] {
        for size in [1e-6, 1e-3, 1.0] {
            let turn = random.rotation();
            let points: Vec<Vec3> = box_points(&(Vec3::from(half) * size)).iter().map(|p| turn * p).collect();
            assert_eq!(check_core(&points, 0.3), 1.0);
        }
    }
    // Hexagonal and 40-sided plates of aspect 100: corners of degree 3 on big faces.
    for sides in [6, 40] {
        let ring = |z: f64| {
            (0..sides).map(move |i| {
                let (s, c) = (2.0 * PI * i as f64 / sides as f64).sin_cos();
                Vec3::new(c, s, z)
            })
        };
        let points: Vec<Vec3> = ring(-0.01).chain(ring(0.01)).collect();
        assert_eq!(check_core(&points, 0.2), 1.0);
        assert_eq!(core_vertices(&Shape::hull(&points, 0.2).unwrap()).len(), 2 * sides);
    }
}

#[test]
fn eroded_core_has_every_corner_of_the_shifted_half_spaces() {
    let mut random = Random::new(8);
    for n in [5, 8, 14, 20] {
        let points = random_hull(&mut random, n, &Vec3::new(1.0, 0.8, 0.6));
        let shape = Shape::hull(&points, 0.3).unwrap();
        let body = ConvexHull::new(&in_body_frame(&shape, &points)).unwrap();
        let core = core_vertices(&shape);
        let planes: Vec<(Vec3, f64)> =
            body.faces.iter().map(|f| (f.normal, f.offset - shape.parts[0].crust)).collect();
        // Brute force: every triple of planes whose meeting point violates no other.
        let mut found = vec![false; core.len()];
        for i in 0..planes.len() {
            for j in 0..i {
                for k in 0..j {
                    let m = nalgebra::Matrix3::from_rows(&[i, j, k].map(|p| planes[p].0.transpose()));
                    let Some(inverse) = m.try_inverse().filter(|m| m.norm() < 1e6) else { continue };
                    let x = inverse * Vec3::new(planes[i].1, planes[j].1, planes[k].1);
                    if planes.iter().all(|(n, d)| n.dot(&x) <= d + 1e-11) {
                        let near = core.iter().position(|v| (v - x).norm() < 1e-8).expect("missing corner");
                        found[near] = true;
                    }
                }
            }
        }
        assert!(found.iter().all(|f| *f));
    }
}

#[test]
fn points_inside_faces_and_edges_are_dropped() {
    for n in [2usize, 3, 5, 9] {
        for turned in [false, true] {
            let turn = if turned { Random::new(n as u64).rotation() } else { Rotation::identity() };
            let at = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
            let mut points = Vec::new();
            for i in 0..=n {
                for j in 0..=n {
                    for k in 0..=n {
                        points.push(turn * Vec3::new(at(i), at(j), at(k)));
                    }
                }
            }
            let hull = ConvexHull::new(&points).unwrap_or_else(|e| panic!("{n} {turned} {e}"));
            assert_eq!((hull.vertices.len(), hull.faces.len()), (8, 6));
            close(Shape::hull(&points, 0.02).unwrap().volume, 8.0, 1e-13);
        }
    }
}

#[test]
fn many_sided_bodies_have_closed_hulls() {
    // Latitudes and longitudes: planar quadrangles and fans of many triangles at the poles.
    for (rings, sides) in [(4, 8), (10, 20), (20, 40)] {
        for turned in [false, true] {
            let turn = if turned { Random::new(rings).rotation() } else { Rotation::identity() };
            let mut points = vec![turn * Vec3::z(), turn * -Vec3::z()];
            for i in 1..rings {
                for j in 0..sides {
                    let (s, c) = (PI * i as f64 / rings as f64).sin_cos();
                    let (y, x) = (2.0 * PI * f64::from(j) / f64::from(sides)).sin_cos();
                    points.push(turn * Vec3::new(s * x, s * y, c));
                }
            }
            let hull = ConvexHull::new(&points).unwrap();
            assert_eq!(hull.vertices.len(), points.len());
            assert_eq!(hull.faces.len(), rings as usize * sides as usize);
            assert_eq!(check_core(&points, 0.02), 1.0);
            // The same through 32-bit coordinates: faces are no longer flat.
            let rounded: Vec<Vec3> = points.iter().map(|p| p.map(|x| f64::from(x as f32))).collect();
            check_core(&rounded, 0.02);
        }
    }
}

#[test]
fn box_as_hull_equals_box() {
    let edges = Vec3::new(1e-3, 2e-3, 4e-3);
    let exact = Shape::cuboid(edges, 0.05).unwrap();
    let mut random = Random::new(11);
    for k in 0..20 {
        let (turn, offset) = if k == 0 {
            (Rotation::identity(), Vec3::zeros())
        } else {
            (random.rotation(), random.vector() * 5e-3)
        };
        let points: Vec<Vec3> = box_points(&(edges / 2.0)).iter().map(|p| turn * p + offset).collect();
        let hull = Shape::hull(&points, 0.05).unwrap();
        close(hull.volume, exact.volume, 1e-13);
        close(hull.bounding_radius, exact.bounding_radius, 1e-13);
        close(hull.inscribed_radius, exact.inscribed_radius, 1e-13);
        assert!((hull.user_to_body.1 - offset).norm() < 1e-17 + 1e-15 * offset.norm());
        let sorted = |v: &Vec3| {
            let mut s = [v.x, v.y, v.z];
            s.sort_by(f64::total_cmp);
            Vec3::from(s)
        };
        assert!((sorted(&hull.inertia) - sorted(&exact.inertia)).norm() < 1e-12 * exact.inertia.norm());
        let extents = sorted(&hull.parts[0].half_extents);
        assert!((extents - sorted(&exact.parts[0].half_extents)).norm() < 1e-12 * edges.norm());
        if k == 0 {
            assert_eq!(hull.user_to_body.0, Rotation::identity());
        }
        // User to body and back: the surface is the given box.
        let (rotation, center) = hull.user_to_body;
        for v in &hull.surface.vertices {
            let user = rotation * v + center;
            assert!(points.iter().any(|p| (p - user).norm() < 1e-17));
        }
    }
}

#[test]
fn turned_cube_is_boxed_along_its_faces() {
    let turn = Random::new(2).rotation();
    let points: Vec<Vec3> = box_points(&Vec3::repeat(1.0)).iter().map(|p| turn * p).collect();
    let shape = Shape::hull(&points, 0.02).unwrap();
    assert!((shape.parts[0].half_extents - Vec3::repeat(1.0)).norm() < 1e-12);
}

#[test]
fn random_hull_agrees_with_sampled_integrals() {
    let mut random = Random::new(17);
    let points: Vec<Vec3> =
        random_hull(&mut random, 15, &Vec3::new(1.0, 0.7, 0.4)).iter().map(|p| p.add_scalar(0.3)).collect();
    let shape = Shape::hull(&points, 0.02).unwrap();
    let hull = ConvexHull::new(&points).unwrap();
    let mass = MassProperties::of_closed_mesh(&hull.triangles());
    let lower = points.iter().fold(points[0], |a, p| a.inf(p));
    let upper = points.iter().fold(points[0], |a, p| a.sup(p));
    let n = 120;
    let cell = (upper - lower) / n as f64;
    let (mut volume, mut first, mut second) = (0.0, Vec3::zeros(), nalgebra::Matrix3::zeros());
    for i in 0..n * n * n {
        let index = Vec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64);
        let x = lower + cell.component_mul(&index.add_scalar(0.5));
        if hull.depth_of(&x) > 0.0 {
            volume += cell.product();
            first += x * cell.product();
            second += x * x.transpose() * cell.product();
        }
    }
    let center = first / volume;
    let second = second - center * center.transpose() * volume;
    let inertia = nalgebra::Matrix3::identity() * second.trace() - second;
    close(mass.volume, volume, 1e-3);
    assert!((mass.center - center).norm() < 1e-3);
    assert!((mass.inertia - inertia).norm() < 2e-3 * inertia.norm());
    // R diag(I) Rᵀ is the tensor in the user's frame.
    let r = shape.user_to_body.0.to_rotation_matrix();
    let rebuilt = r.matrix() * nalgebra::Matrix3::from_diagonal(&shape.inertia) * r.matrix().transpose();
    assert!((rebuilt - mass.inertia).norm() < 1e-12 * inertia.norm());
    assert!(core_vertices(&shape).len() >= 4);
}

#[test]
fn principal_axes_form_a_right_handed_frame_near_the_given_one() {
    let mut random = Random::new(23);
    for _ in 0..1000 {
        let moments = random.vector().add_scalar(2.0);
        let r = random.rotation().to_rotation_matrix();
        let tensor = r.matrix() * nalgebra::Matrix3::from_diagonal(&moments) * r.matrix().transpose();
        let (axes, found) = principal_axes(&tensor);
        assert!((axes.determinant() - 1.0).abs() < 1e-13);
        let rebuilt = axes * nalgebra::Matrix3::from_diagonal(&found) * axes.transpose();
        assert!((rebuilt - tensor).norm() < 1e-12);
    }
    let noisy = nalgebra::Matrix3::new(1.0, 1e-15, 0.0, 1e-15, 1.0, -1e-16, 0.0, -1e-16, 1.0);
    assert_eq!(principal_axes(&noisy).0, nalgebra::Matrix3::identity());
}

#[test]
fn degenerate_vertices_are_refused() {
    let hull = |points: &[Vec3]| match Shape::hull(points, 0.02) {
        Err(ShapeError::Hull(error)) => error,
        other => panic!("{other:?}"),
    };
    let corners = RegularSolid::Tetrahedron.vertices();
    assert_eq!(hull(&corners[..3]), HullError::TooFewPoints { count: 3 });
    let mut twice = corners.clone();
    twice.push(corners[1] + Vec3::repeat(1e-11));
    assert!(matches!(hull(&twice), HullError::Duplicate { first: 1, second: 4, .. }));
    let mut broken = corners.clone();
    broken[2].y = f64::NAN;
    assert!(matches!(hull(&broken), HullError::NotFinite { index: 2, .. }));
    let mut random = Random::new(4);
    let turn = random.rotation();
    for size in [1e-6, 1.0] {
        let flat: Vec<Vec3> = (0..10)
            .map(|_| turn * Vec3::new(random.unit() * size, random.unit() * size, 0.2 * size))
            .collect();
        assert!(matches!(hull(&flat), HullError::Coplanar { .. }));
        let line: Vec<Vec3> = (0..5).map(|i| turn * Vec3::x() * size * f64::from(i)).collect();
        assert!(matches!(hull(&line), HullError::Coplanar { .. }));
    }
    assert!(matches!(hull(&[Vec3::zeros(); 5]), HullError::Duplicate { .. }));
}

#[test]
fn dimensions_out_of_range_are_refused_with_a_remedy() {
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = Shape::sphere(radius).unwrap_err().to_string();
        assert!(message.contains("sphere radius") && message.contains("positive and finite"), "{message}");
    }
    for fraction in [0.0, -0.1, 0.51, f64::NAN] {
        let message = Shape::cuboid(Vec3::repeat(1.0), fraction).unwrap_err().to_string();
        assert!(message.contains("(0, 0.5]") && message.contains("try 0.02"), "{message}");
    }
    assert!(Shape::cylinder(1.0, 0.0, 0.02).is_err());
    assert!(Shape::cuboid(Vec3::new(1.0, 0.0, 1.0), 0.02).is_err());
    assert!(Shape::regular(RegularSolid::Cube, -1.0, 0.02).is_err());
}

#[test]
fn shapes_scale_with_their_dimensions() {
    let mut random = Random::new(31);
    let points = random_hull(&mut random, 20, &Vec3::new(1.0, 0.6, 0.3));
    let unit = Shape::hull(&points, 0.05).unwrap();
    for size in [1e-6, 1e-3, 1e3] {
        let scaled: Vec<Vec3> = points.iter().map(|p| p * size).collect();
        let shape = Shape::hull(&scaled, 0.05).unwrap();
        close(shape.volume, unit.volume * size.powi(3), 1e-12);
        close(shape.inertia.x, unit.inertia.x * size.powi(5), 1e-12);
        close(shape.parts[0].crust, unit.parts[0].crust * size, 1e-12);
        assert!(shape.user_to_body.0.angle_to(&unit.user_to_body.0) < 1e-7);
        assert_eq!(core_vertices(&shape).len(), core_vertices(&unit).len());
    }
}

#[test]
fn the_inside_test_agrees_with_the_faces_of_the_body() {
    let mut random = Random::new(11);
    let points = random_hull(&mut random, 14, &Vec3::new(1e-3, 2e-3, 1.5e-3));
    let shape = Shape::hull(&points, 0.02).unwrap();
    let body = ConvexHull::new(&in_body_frame(&shape, &points)).unwrap();
    // Faces that the erosion has kept bound the body.
    let kept: f64 = check_core(&points, 0.02);
    assert_eq!(kept, 1.0);
    let mut inside = 0;
    for _ in 0..2000 {
        let point = random.direction().component_mul(&Vec3::new(1e-3, 2e-3, 1.5e-3));
        assert_eq!(shape.contains(&point), body.depth_of(&point) >= 0.0);
        inside += usize::from(shape.contains(&(point * 0.5)));
    }
    assert!(inside > 1000);
    let rod = Shape::cylinder(1.0, 4.0, 0.02).unwrap();
    assert!(rod.contains(&Vec3::new(0.7, 0.7, 1.99)) && !rod.contains(&Vec3::new(0.7, 0.75, 0.0)));
}

/// The farthest point from an axis beside the largest reach over directions all around it.
#[test]
fn no_point_of_a_body_is_farther_from_an_axis_than_the_farthest() {
    let mut random = Random::new(11);
    let tetrahedron = Shape::regular(RegularSolid::Tetrahedron, 1.5, 0.01).unwrap().parts[0].core.clone();
    let icosahedron = Shape::regular(RegularSolid::Icosahedron, 1.0, 0.01).unwrap().parts[0].core.clone();
    let block =
        Shape::superellipsoid(Vec3::new(1.0, 0.7, 0.5), [0.2, 0.3], 0.01).unwrap().parts[0].core.clone();
    let needle =
        Shape::superellipsoid(Vec3::new(0.3, 0.3, 1.5), [1.0, 1.0], 0.01).unwrap().parts[0].core.clone();
    let rod = Core::Cylinder { radius: 0.3, half_height: 1.2 };
    let coin = Core::Cylinder { radius: 1.0, half_height: 0.2 };
    let cores = [tetrahedron, icosahedron, block, needle, rod, coin, Core::Box(Vec3::new(1.0, 0.6, 0.8))];
    for trial in 0..3000 {
        let core = &cores[trial % cores.len()];
        let (axis, center) = (random.direction(), random.direction() * random.range(0.0, 9.0));
        let found = center + core.farthest_from_axis(&center, &axis);
        let found = (found - axis * found.dot(&axis)).norm();
        let start = axis.cross(&random.direction()).normalize();
        let most = (0..3600)
            .map(|k| {
                let (sin, cos) = (PI * k as f64 / 1800.0).sin_cos();
                let direction = start * cos + axis.cross(&start) * sin;
                center.dot(&direction) + core.support_value(&direction)
            })
            .fold(0.0, f64::max);
        assert!(
            found > most * (1.0 - 1e-12),
            "{core:?} at {center:?}: {found}, but {most} along some direction"
        );
        assert!(found < most * (1.0 + 1e-6) + 1e-12, "{found} {most}");
    }
}
