//! Glued bodies against the wholes they make, closed forms and random points.
use crate::support::{Random, close};
use grains_geometry::{
    Component, ConvexHull, Core, Lobes, MassSource, RegularSolid, Rotation, Shape, ShapeError,
    SphereArrangement, Vec3,
};
use std::f64::consts::PI;

/// Radius and height of the cylinder of Kodam et al. (2010), and its density (m, kg/m³).
const KODAM: (f64, f64, f64) = (4e-3, 5.3e-3, 1163.63);

/// Volume and second moments about the origin from random points of the bounding ball's box.
fn monte_carlo(shape: &Shape, points: usize) -> (f64, Vec3) {
    let mut random = Random::new(3);
    let (r, mut hits, mut squares) = (shape.bounding_radius, 0.0, Vec3::zeros());
    for _ in 0..points {
        let p = random.vector() * r;
        if shape.contains(&p) {
            hits += 1.0;
            squares += p.component_mul(&p);
        }
    }
    let share = (2.0 * r).powi(3) / points as f64;
    (hits * share, (Vec3::repeat(squares.sum()) - squares) * share)
}

/// Volume and inertia of two shapes, and the parts' crust and bounds.
#[track_caller]
fn same_mass(a: &Shape, b: &Shape, tolerance: f64) {
    close(a.volume, b.volume, tolerance);
    let (mut p, mut q) = (a.inertia, b.inertia);
    p.as_mut_slice().sort_by(f64::total_cmp);
    q.as_mut_slice().sort_by(f64::total_cmp);
    assert!((p - q).norm() <= tolerance * q.norm(), "{p:?} {q:?}");
}

#[test]
fn a_cut_cylinder_has_the_mass_of_the_whole() {
    let (radius, height, density) = KODAM;
    let whole = Shape::cylinder(radius, height, 0.02).unwrap();
    for slices in [1, 2, 7, 30] {
        let cut = Shape::sliced_cylinder(radius, height, slices, 0.02).unwrap();
        assert_eq!(cut.parts.len(), slices as usize);
        same_mass(&cut, &whole, 1e-12);
        assert!(cut.user_to_body.1.norm() < 1e-15);
        let source = if slices == 1 { MassSource::ClosedForm } else { MassSource::Parts };
        assert_eq!(cut.report.mass, source);
        close(cut.bounding_radius, radius.hypot(height / 2.0), 0.01);
        let thinnest = radius.min(height / f64::from(2 * slices));
        assert_eq!(cut.inscribed_radius, thinnest);
        assert!(cut.parts.iter().all(|p| (p.crust / (0.02 * thinnest) - 1.0).abs() < 1e-12));
    }
    // Thesis table 3.1.
    close(whole.volume, 2.664071e-7, 1e-6);
    close(density * whole.inertia.x, 1.966e-9, 2e-4);
    close(density * whole.inertia.z, 2.480e-9, 2e-4);
    let chords = Shape::sliced_cylinder(radius, height, 10, 0.02).unwrap().mass_report();
    assert!(chords.volume_difference.abs() < 5e-5 && chords.inertia_difference.abs() < 1e-4, "{chords:?}");
}

#[test]
fn a_box_cut_in_eight_has_the_mass_of_the_whole_and_no_seams() {
    let edges = Vec3::new(2e-3, 1e-3, 3e-3);
    let whole = Shape::cuboid(edges, 0.02).unwrap();
    let cut = Shape::sliced_cuboid(edges, 2, 0.04).unwrap();
    assert_eq!(cut.parts.len(), 8);
    same_mass(&cut, &whole, 1e-12);
    // Two triangles on each of the 4 quarters of 6 faces; those inside are gone.
    assert_eq!(cut.surface.triangles.len(), 48);
    close(cut.surface.report().area, whole.surface.report().area, 1e-9);
    close(cut.bounding_radius, whole.bounding_radius, 1e-12);
}

/// Balls outside each other are summed exactly, those that overlap by chords.
#[test]
fn two_balls_have_the_volume_of_their_union() {
    let ball = Shape::sphere(1.0).unwrap();
    let pair = |d: f64| {
        let at = |x: f64| Component::new(ball.clone(), Vec3::new(x, 3.0, 4.0));
        Shape::glued(&[at(5.0), at(5.0 + d)], 0.02).unwrap()
    };
    let touching = pair(2.0);
    assert_eq!(touching.report.mass, MassSource::Parts);
    close(touching.volume, 2.0 * ball.volume, 1e-15);
    close(touching.inertia.x, 2.0 * ball.inertia.x, 1e-14);
    close(touching.inertia.y, 2.0 * (ball.inertia.x + ball.volume), 1e-14);
    assert!((touching.user_to_body.1 - Vec3::new(6.0, 3.0, 4.0)).norm() < 1e-14);
    assert_eq!(touching.bounding_radius, 2.0);
    let overlapping = pair(1.0);
    assert!(matches!(overlapping.report.mass, MassSource::Chords { .. }));
    let lens = PI / 12.0 * (4.0 + 1.0) * (2.0 - 1.0) * (2.0 - 1.0);
    close(overlapping.volume, 2.0 * ball.volume - lens, 1e-4);
    close(overlapping.bounding_radius, 1.5, 1e-4);
}

/// Components keep their place: points of the composite in user coordinates are those of the components.
#[test]
fn parts_lie_where_the_user_put_them() {
    let mut random = Random::new(5);
    for size in [1e-6, 1.0] {
        let hull: Vec<Vec3> = (0..12).map(|_| random.direction() * size).collect();
        let shapes = [
            Shape::hull(&hull, 0.1).unwrap(),
            Shape::cuboid(Vec3::new(1.0, 0.5, 2.0) * size, 0.02).unwrap(),
            Shape::cylinder(0.4 * size, 1.5 * size, 0.05).unwrap(),
            Shape::regular(RegularSolid::Octahedron, size, 0.02).unwrap(),
        ];
        let components: Vec<Component> = (shapes.iter())
            .map(|s| {
                let position = (random.vector() * 0.5).add_scalar(2.0) * size;
                Component::new(s.clone(), position).turned(random.rotation())
            })
            .collect();
        let whole = Shape::glued(&components, 0.02).unwrap();
        let crust = 0.02 * whole.inscribed_radius;
        assert!(whole.parts.iter().all(|p| (p.crust / crust - 1.0).abs() < 1e-9));
        let (turn, center) = whole.user_to_body;
        for _ in 0..20_000 {
            let x = (random.vector() * 2.0).add_scalar(2.0) * size;
            let in_component = |c: &Component| {
                let user = c.rotation.inverse_transform_vector(&(x - c.position));
                let (r, o) = &c.shape.user_to_body;
                c.shape.contains(&r.inverse_transform_vector(&(user - o)))
            };
            let body = turn.inverse_transform_vector(&(x - center));
            assert_eq!(whole.contains(&body), components.iter().any(in_component), "{x}");
            assert!(!whole.contains(&body) || body.norm() < 1.02 * whole.bounding_radius);
        }
        // No part reaches beyond the bounding ball, and one reaches it.
        let directions: Vec<Vec3> = (0..5000).map(|_| random.direction()).collect();
        let reach = whole.parts.iter().flat_map(|p| {
            directions.iter().map(|d| {
                let tip = p.rotation * p.core.support(&p.rotation.tr_mul(d)) + p.center;
                tip.norm() + p.crust
            })
        });
        let farthest = reach.fold(0.0, f64::max);
        assert!(farthest <= whole.bounding_radius * (1.0 + 1e-12) && farthest > 0.99 * whole.bounding_radius);
    }
}

#[test]
fn one_component_stays_what_it_is() {
    let turn = Rotation::from_axis_angle(&Vec3::x_axis(), 0.7);
    let bodies = [Shape::sphere(2.0).unwrap(), Shape::cuboid(Vec3::new(1.0, 2.0, 3.0), 0.1).unwrap()];
    for body in bodies {
        let glued = Shape::glued(&[Component::new(body.clone(), Vec3::x()).turned(turn)], 0.1).unwrap();
        assert_eq!(glued.is_sphere(), body.is_sphere());
        assert_eq!((glued.volume, glued.inertia), (body.volume, body.inertia));
        assert_eq!((glued.user_to_body.1, glued.parts[0].center), (Vec3::x(), Vec3::zeros()));
        assert_eq!(glued.user_to_body.0, turn);
    }
}

#[test]
fn pieces_that_lie_apart_are_named() {
    let ball = Shape::sphere(1e-3).unwrap();
    let rod = Shape::cylinder(1e-3, 4e-3, 0.02).unwrap();
    let at = |s: &Shape, x: f64| Component::new(s.clone(), Vec3::new(x, 0.0, 0.0));
    let parts = [at(&ball, 0.0), at(&rod, 5e-3), at(&ball, 1e-3), at(&ball, 6e-3)];
    let message = Shape::glued(&parts, 0.02).unwrap_err().to_string();
    let expected = "parts[1] (cylinder), parts[3] (sphere) lie apart, for the gap between parts[1] (cylinder) \
                    and parts[2] (sphere) is 2.0000e-3 m";
    assert!(message.contains(expected), "{message}");
    // Edges that touch hold bodies together, whatever their crust.
    let brick =
        |x: f64, y: f64| Component::new(Shape::cuboid(Vec3::repeat(1.0), 0.5).unwrap(), Vec3::new(x, y, 0.0));
    assert!(Shape::glued(&[brick(0.0, 0.0), brick(1.0, 1.0)], 0.5).is_ok());
    assert!(Shape::glued(&[brick(0.0, 0.0), brick(1.0, 1.0001)], 0.5).is_err());
    assert!(matches!(Shape::glued(&[], 0.02), Err(ShapeError::NoComponents)));
    let pair = Shape::glued(&parts[2..3], 0.6);
    assert!(matches!(pair, Err(ShapeError::OutOfRange { .. })));
    let nested = Shape::sliced_cylinder(1.0, 1.0, 2, 0.02).unwrap();
    let message = Shape::glued(&[at(&nested, 0.0), at(&ball, 0.0)], 0.02).unwrap_err().to_string();
    assert!(message.contains("parts[0] (sliced_cylinder) is a composite itself"), "{message}");
}

#[test]
fn lobes_have_the_area_of_the_thesis_and_their_closed_moments() {
    // Errata R16-31; the last two are three and four discs that just touch.
    let touching = |n: f64| 1.0 / (1.0 + (PI / n).sin());
    let cases =
        [(3, 0.5136, 0.690), (4, 0.5813, 0.740), (3, touching(3.0), 0.6572), (4, touching(4.0), 0.7332)];
    for (count, offset, fraction) in cases {
        let lobes = Lobes { count, radius: 1.0, offset };
        assert!((lobes.area_fraction() - fraction).abs() < 1e-4, "{}", lobes.area_fraction());
        let again = Lobes::with_area_fraction(count, 1.0, lobes.area_fraction()).unwrap();
        close(again.offset, offset, 1e-9);
    }
    for (count, fraction, length) in [(3, 0.69, 2.0), (4, 0.74, 3.5), (5, 0.9, 0.3)] {
        let lobes = Lobes::with_area_fraction(count, 0.8e-3, fraction).unwrap();
        let shape = Shape::lobes(lobes, length * 1e-3, 0.02).unwrap();
        assert_eq!((shape.parts.len(), shape.report.mass), (count as usize + 1, MassSource::ClosedForm));
        let chords = shape.mass_report();
        assert!(
            chords.volume_difference.abs() < 5e-5 && chords.inertia_difference.abs() < 1e-4,
            "{chords:?}"
        );
        let (volume, inertia) = monte_carlo(&shape, 400_000);
        close(volume, shape.volume, 0.01);
        assert!((inertia - shape.inertia).norm() < 0.02 * shape.inertia.norm());
        close(shape.bounding_radius, 0.8e-3f64.hypot(length * 0.5e-3), 0.01);
    }
    // Without offset all lobes are the circumscribed cylinder.
    let lobes = Lobes { count: 3, radius: 1.0, offset: 1e-6 };
    let round = Shape::lobes(lobes, 1.0, 0.02);
    same_mass(&round.unwrap(), &Shape::cylinder(1.0, 1.0, 0.02).unwrap(), 1e-5);
}

#[test]
fn lobes_that_do_not_close_are_refused_with_the_range() {
    let open = Lobes { count: 3, radius: 1e-3, offset: 0.6e-3 };
    let message = Shape::lobes(open, 3e-3, 0.02).unwrap_err().to_string();
    for part in ["6.0000e-4 m from the axis", "lobe radius of 4.0000e-4", "below 5.3590e-4 m", "0.6572 to 1"]
    {
        assert!(message.contains(part), "{message}");
    }
    let message = Lobes::with_area_fraction(4, 1e-3, 0.7).unwrap_err().to_string();
    assert!(message.contains("area_fraction = 0.7") && message.contains("at least 0.7332"), "{message}");
    assert!(Lobes::with_area_fraction(3, 1e-3, f64::NAN).is_err());
    assert!(Lobes::with_area_fraction(2, 1e-3, 0.9).is_err());
}

/// Square-beam crosses of the volume of a sphere of radius 1.5 mm (errata R16-24).
#[test]
fn crosses_have_their_closed_forms() {
    let sphere = Shape::sphere(1.5e-3).unwrap();
    for (beams, width, inertia, sphericity) in [
        (2, 1.1624e-3, [1.72664e-6, 1.72664e-6, 3.22807e-6], 0.5506),
        (3, 1.0283e-3, [1.80317e-6; 3], 0.4951),
    ] {
        let w = (sphere.volume / (4.0 * f64::from(beams) + 1.0)).cbrt();
        close(w, width, 5e-5);
        let cross = Shape::cross(beams, w, 5.0 * w, 0.02).unwrap();
        close(cross.volume, sphere.volume, 1e-12);
        close(cross.volume, w.powi(3) * (4.0 * f64::from(beams) + 1.0), 1e-12);
        for (found, wanted) in cross.inertia.iter().zip(inertia) {
            close(found / cross.volume, wanted, 1e-5);
        }
        assert_eq!(cross.parts.len(), beams as usize);
        assert!(cross.parts.iter().all(|p| matches!(p.core, Core::Box(_))));
        // Each beam end shows five faces' worth: 4 sides of (q - 1)/2 squares and the end itself.
        let ends = 2.0 * f64::from(beams);
        let bare = 6.0 - ends;
        let surface = w * w * (ends * (4.0 * 2.0 + 1.0) + bare);
        let round = PI.cbrt() * (6.0 * cross.volume).powf(2.0 / 3.0);
        close(round / surface, sphericity, 1e-4);
        let chords = cross.mass_report();
        assert!(chords.volume_difference.abs() < 5e-5, "{chords:?}");
        close(cross.bounding_radius, w * (2.5f64.powi(2) + 0.5).sqrt(), 0.01);
    }
    assert!(Shape::cross(4, 1.0, 5.0, 0.02).is_err() && Shape::cross(2, 1.0, 1.0, 0.02).is_err());
}

#[test]
fn spheres_of_a_cylinder() {
    let (radius, height, density) = KODAM;
    let nine = SphereArrangement::touching(1, vec![1, 8], height);
    let nine = Shape::spheres_of_cylinder(radius, height, &nine).unwrap();
    assert_eq!((nine.parts.len(), nine.inscribed_radius), (9, height / 2.0));
    // Thesis table 3.2; its moments are those of a density 1.1867 times that of the table.
    close(nine.volume, 1.948e-7, 1e-3);
    close(density * nine.inertia.x * 1.1867, 1.320e-9, 1e-3);
    close(density * nine.inertia.z * 1.1867, 1.738e-9, 1e-3);
    // Of the arrangements tried, this one comes nearest to the 54 spheres; their transverse moment, above
    // that of the full cylinder, is impossible (errata R16-18).
    let rings = SphereArrangement { layers: 3, rings: vec![1, 17], sphere_radius: 0.36 * height };
    let many = Shape::spheres_of_cylinder(radius, height, &rings).unwrap();
    assert_eq!(many.parts.len(), 54);
    close(many.volume, 2.244e-7, 1e-3);
    close(density * many.inertia.z, 1.871e-9, 3e-3);
    assert!(density * many.inertia.x < 1.966e-9);
    for shape in [&nine, &many] {
        assert!((shape.inertia.x / shape.inertia.y - 1.0).abs() < 2e-2, "{:?}", shape.inertia);
        assert!(shape.user_to_body.1.norm() < 1e-4 * radius);
        assert!(shape.parts.iter().all(|p| matches!(p.core, Core::Point)));
    }
    let layers = SphereArrangement::touching(2, vec![1, 8, 18], height);
    close(layers.sphere_radius, height / 4.0, 1e-15);
    assert_eq!(Shape::spheres_of_cylinder(radius, height, &layers).unwrap().parts.len(), 54);
    // Too large for the cylinder, none, and too far apart.
    for (layers, rings, sphere_radius) in [(1, vec![4], 3e-3), (0, vec![1], 1e-3), (1, vec![1, 3], 1e-4)] {
        let wrong = SphereArrangement { layers, rings, sphere_radius };
        assert!(Shape::spheres_of_cylinder(radius, height, &wrong).is_err(), "{wrong:?}");
    }
}

/// Erosion splits corners of more than three faces, for a thin crust by less than a hull can tell apart; a
/// point outside must stay outside.
#[test]
fn hulls_of_thin_crust_know_what_is_outside() {
    let mut random = Random::new(21);
    for crust in [1e-2, 1e-4, 1e-6, 1e-7, 1e-8] {
        let corners: Vec<Vec3> = (0..14).map(|_| random.direction()).collect();
        let shape = Shape::hull(&corners, crust).unwrap();
        let exact = ConvexHull::new(&corners).unwrap();
        let (body, center) = shape.user_to_body;
        let mut outside = 0;
        for _ in 0..2000 {
            let x = random.vector();
            let depth = exact.depth_of(&x);
            // Small faces are rounded away with the crust, and corners reach a little farther without them.
            if depth.abs() > 1e-6 + 0.1 * crust {
                outside += usize::from(depth < 0.0);
                assert_eq!(
                    shape.contains(&body.inverse_transform_vector(&(x - center))),
                    depth > 0.0,
                    "{crust}"
                );
            }
        }
        assert!(outside > 100);
        let Core::Polyhedron(core) = &shape.parts[0].core else { panic!("polyhedron") };
        for face in core.faces() {
            // Counter-clockwise seen from outside.
            let corners: Vec<Vec3> = face.vertices.iter().map(|&v| core.vertices()[v as usize]).collect();
            let n = corners.len();
            let area: Vec3 = (0..n).map(|k| corners[k].cross(&corners[(k + 1) % n])).sum();
            assert!(area.normalize().dot(&face.normal) > 1.0 - 1e-6 || area.norm() < 1e-6);
        }
    }
}
