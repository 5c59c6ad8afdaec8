//! Points on the surfaces of bodies.

use grains_geometry::{Lobes, RegularSolid, Shape, Vec3};
use grains_resolved::{SurfacePoint, surface_points};

/// Asserts that points lie on the surface with normals outwards; returns the distances of each to its nearest.
fn distances(shape: &Shape, points: &[SurfacePoint]) -> Vec<f64> {
    let step = 1e-6 * shape.bounding_radius;
    for SurfacePoint { place, normal } in points {
        assert!((normal.norm() - 1.0).abs() < 1e-9, "{}", shape.name);
        assert!(!shape.contains(&(place + normal * step)), "{} {place:?} {normal:?}", shape.name);
        assert!(shape.contains(&(place - normal * step)), "{} {place:?} {normal:?}", shape.name);
    }
    let nearest = |k: usize| {
        let others = points.iter().enumerate().filter(|(m, _)| *m != k);
        others.map(|(_, p)| (p.place - points[k].place).norm()).fold(f64::INFINITY, f64::min)
    };
    (0..points.len()).map(nearest).collect()
}

#[test]
fn points_cover_any_surface_about_a_spacing_apart() {
    let lobes = Lobes::with_area_fraction(3, 0.5, 0.7).unwrap();
    let shapes = [
        Shape::sphere(0.5).unwrap(),
        Shape::cuboid(Vec3::new(1.0, 0.7, 0.5), 0.02).unwrap(),
        Shape::cylinder(0.4, 1.1, 0.02).unwrap(),
        Shape::regular(RegularSolid::Icosahedron, 0.6, 0.02).unwrap(),
        Shape::superellipsoid(Vec3::new(0.6, 0.5, 0.4), [0.4, 0.7], 0.02).unwrap(),
        Shape::lobes(lobes, 1.2, 0.02).unwrap(),
        Shape::cross(3, 0.25, 1.0, 0.02).unwrap(),
    ];
    let spacing = 0.08;
    for shape in shapes {
        let points = surface_points(&shape, spacing, None);
        let distances = distances(&shape, &points);
        let mean = distances.iter().sum::<f64>() / distances.len() as f64;
        let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(mean > 0.75 * spacing && mean < 1.25 * spacing, "{}: mean {mean}", shape.name);
        assert!(least >= 0.599 * spacing, "{}: least {least}", shape.name);
        // No hole: from any vertex of the surface there is a point within a spacing and a bit.
        for vertex in &shape.surface.vertices {
            let gap = points.iter().map(|p| (p.place - vertex).norm()).fold(f64::INFINITY, f64::min);
            assert!(gap < 1.3 * spacing, "{}: {gap} at {vertex:?}", shape.name);
        }
    }
}

#[test]
fn corners_and_edges_are_kept() {
    let cube = Shape::cuboid(Vec3::repeat(1.0), 0.02).unwrap();
    let points = surface_points(&cube, 0.1, None);
    let on = |count: usize| {
        let is = |p: &&SurfacePoint| p.place.iter().filter(|x| (x.abs() - 0.5).abs() < 1e-9).count() == count;
        points.iter().filter(is).count()
    };
    assert_eq!((on(3), on(2), on(1)), (8, 12 * 9, 6 * 81));
    let corner = points.iter().find(|p| p.place.min() > 0.499).unwrap();
    assert!((corner.normal - Vec3::repeat(1.0).normalize()).norm() < 1e-9, "{corner:?}");
}

#[test]
fn outlines_lie_in_their_plane() {
    let disc = Shape::cylinder(0.5, 0.05, 0.02).unwrap();
    let ring = surface_points(&disc, 0.1, Some(&Vec3::z()));
    assert_eq!(ring.len(), 31);
    assert!(ring.iter().all(|p| p.place.z == 0.0 && (p.place.norm() - 0.5).abs() < 1e-12));
    let square = Shape::cuboid(Vec3::new(1.0, 1.0, 0.05), 0.02).unwrap();
    // The thin axis of the body, whichever that is in its frame of principal axes.
    let thin = square.parts[0].rotation * {
        let mut axis = Vec3::zeros();
        axis[square.parts[0].half_extents.imin()] = 1.0;
        axis
    };
    let outline = surface_points(&square, 0.1, Some(&thin));
    assert_eq!(outline.len(), 40);
    assert!(outline.iter().all(|p| p.place.dot(&thin).abs() < 1e-12 && (p.place.amax() - 0.5).abs() < 1e-9));
}
