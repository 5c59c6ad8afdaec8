//! Meshes cut into convex parts, and meshes that bound no solid.
use crate::support::{Random, close};
use grains_geometry::{DecompositionOptions, MassProperties, MassSource, Shape, ShapeError, TriMesh, Vec3};
use std::f64::consts::{PI, TAU};

fn options(max_parts: u32, resolution: u32) -> DecompositionOptions {
    DecompositionOptions { max_parts, resolution, cache: None }
}

/// An L of unit thickness: arms 3 and 2 long.
fn angle() -> TriMesh {
    let outline = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let n = outline.len();
    let at = |z: f64| outline.iter().map(move |[x, y]| Vec3::new(*x, *y, z));
    let vertices = at(0.0).chain(at(1.0)).collect();
    let mut faces: Vec<Vec<usize>> = vec![(0..n).rev().collect(), (n..2 * n).collect()];
    faces.extend((0..n).map(|i| vec![i, (i + 1) % n, n + (i + 1) % n, n + i]));
    TriMesh::from_polygons(vertices, &faces).unwrap()
}

/// A torus of radii 1 and r.
fn torus(r: f64, along: u32, around: u32) -> TriMesh {
    let point = |i: u32, j: u32| {
        let (u, v) = (TAU * f64::from(i) / f64::from(along), TAU * f64::from(j) / f64::from(around));
        Vec3::new((1.0 + r * v.cos()) * u.cos(), (1.0 + r * v.cos()) * u.sin(), r * v.sin())
    };
    let vertices = (0..along).flat_map(|i| (0..around).map(move |j| (i, j))).map(|(i, j)| point(i, j));
    let number = |i: u32, j: u32| (i % along * around + j % around) as usize;
    let faces: Vec<_> = (0..along)
        .flat_map(|i| (0..around).map(move |j| (i, j)))
        .map(|(i, j)| vec![number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)])
        .collect();
    TriMesh::from_polygons(vertices.collect(), &faces).unwrap()
}

#[test]
fn an_angle_is_cut_at_its_corner_at_any_size() {
    for scale in [1e-6, 1.0, 1e3] {
        let shape = Shape::of_mesh(&angle(), scale, &options(16, 64), 0.02).unwrap();
        let report = shape.report.decomposition.clone().unwrap();
        assert!((2..=3).contains(&shape.parts.len()), "{report:?}");
        assert_eq!(shape.report.mass, MassSource::ClosedMesh);
        close(shape.volume, 4.0 * scale.powi(3), 1e-12);
        assert!((shape.user_to_body.1 / scale - Vec3::new(1.25, 0.75, 0.5)).norm() < 1e-12);
        assert!(report.volume_error.abs() < 0.005, "{report:?}");
        assert!(!report.cached);
    }
}

#[test]
fn a_ring_keeps_its_hole() {
    let mesh = torus(0.3, 48, 16);
    for (most, error) in [(6, 0.2), (12, 0.06), (24, 0.03)] {
        let shape = Shape::of_mesh(&mesh, 1e-3, &options(most, 64), 0.02).unwrap();
        let report = shape.report.decomposition.clone().unwrap();
        assert!(shape.parts.len() <= most as usize);
        assert!(report.volume_error > 0.0 && report.volume_error < error, "{report:?}");
        assert!(!shape.contains(&Vec3::zeros()));
        let exact = MassProperties::of_closed_mesh(&mesh);
        close(shape.volume, exact.volume * 1e-9, 1e-12);
        close(shape.volume, 2.0 * PI * PI * 0.09 * 1e-9, 0.04);
    }
}

#[test]
fn decompositions_are_read_back_as_they_were() {
    let folder = std::env::temp_dir().join(format!("grains-decomposition-{}", std::process::id()));
    let kept = DecompositionOptions { cache: Some(folder.clone()), ..options(8, 32) };
    let mesh = torus(0.4, 24, 12);
    let first = Shape::of_mesh(&mesh, 2.0, &kept, 0.02).unwrap();
    let again = Shape::of_mesh(&mesh, 2.0, &kept, 0.02).unwrap();
    let alone = Shape::of_mesh(&mesh, 2.0, &options(8, 32), 0.02).unwrap();
    let cached = |s: &Shape| s.report.decomposition.as_ref().unwrap().cached;
    assert_eq!([cached(&first), cached(&again), cached(&alone)], [false, true, false]);
    for other in [&again, &alone] {
        assert_eq!(format!("{:?}", first.parts), format!("{:?}", other.parts));
    }
    let finer = DecompositionOptions { resolution: 33, ..kept.clone() };
    assert!(!cached(&Shape::of_mesh(&mesh, 2.0, &finer, 0.02).unwrap()));
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn meshes_that_bound_no_solid_are_refused_with_counts() {
    let message = |mesh: &TriMesh| {
        let error = Shape::of_mesh(mesh, 1.0, &options(8, 32), 0.02).unwrap_err();
        assert!(matches!(error, ShapeError::Solid(_)), "{error}");
        error.to_string()
    };
    let mut open = angle();
    open.triangles.pop();
    assert!(message(&open).contains("not closed: 3 of 30 edges"), "{}", message(&open));
    let mut turned = angle();
    turned.triangles[0].swap(0, 1);
    assert!(message(&turned).contains("3 of 30 edges are run through"), "{}", message(&turned));
    let mut inverted = angle();
    inverted.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(message(&inverted).contains("20 triangles is inside out"), "{}", message(&inverted));
    let mut flat = angle();
    flat.vertices.iter_mut().for_each(|v| v.z = 0.0);
    assert!(message(&flat).contains("flat or overlaps itself"), "{}", message(&flat));
    // Twice the same body, once inside out.
    let (mut doubled, n) = (angle(), 12);
    doubled.vertices.extend(angle().vertices);
    doubled.triangles.extend(angle().triangles.iter().map(|t| [t[0] + n, t[2] + n, t[1] + n]));
    assert!(message(&doubled).contains("flat or overlaps itself"), "{}", message(&doubled));
    // Three times the same body: more volume than its box has.
    let mut thrice = angle();
    for k in 1..3 {
        thrice.vertices.extend(angle().vertices);
        thrice.triangles.extend(angle().triangles.iter().map(|t| t.map(|v| v + k * n)));
    }
    assert!(message(&thrice).contains("overlaps itself"), "{}", message(&thrice));
}

#[test]
fn a_convex_mesh_stays_whole() {
    let stone = Shape::sphere(1.0).unwrap().surface;
    let shape = Shape::of_mesh(&stone, 0.01, &options(16, 64), 0.02).unwrap();
    let hull = Shape::hull_of_mesh(&stone, 0.01, 0.02).unwrap();
    assert_eq!(shape.parts.len(), 1);
    close(shape.volume, hull.volume, 1e-12);
    close(shape.bounding_radius, hull.bounding_radius, 1e-9);
    assert!(shape.report.decomposition.unwrap().volume_error.abs() < 1e-3);
}

#[test]
fn two_bodies_in_one_mesh_are_named_as_apart() {
    let mut two = angle();
    let shifted: Vec<Vec3> = two.vertices.iter().map(|v| v + Vec3::new(5.0, 0.0, 0.0)).collect();
    let n = two.vertices.len() as u32;
    two.vertices.extend(shifted);
    two.triangles.extend(angle().triangles.iter().map(|t| t.map(|v| v + n)));
    let error = Shape::of_mesh(&two, 1.0, &options(16, 64), 0.02).unwrap_err();
    assert!(matches!(error, ShapeError::Apart { .. }), "{error}");
}

#[test]
fn options_out_of_range_are_refused() {
    for (parts, voxels) in [(0, 64), (2000, 64), (8, 8), (8, 1000)] {
        let error = Shape::of_mesh(&angle(), 1.0, &options(parts, voxels), 0.02).unwrap_err();
        assert!(matches!(error, ShapeError::OutOfRange { .. }), "{error}");
    }
}

/// A bumpy blob of many triangles: its parts stay few and near its surface.
#[test]
fn a_rough_stone_is_cut_within_its_volume_error() {
    let mut random = Random::new(9);
    let mut mesh = Shape::sphere(1.0).unwrap().surface;
    for v in &mut mesh.vertices {
        *v *= 1.0 + 0.25 * (3.0 * v.x).sin() * (2.0 * v.y).cos() + random.range(-0.02, 0.02);
    }
    let shape = Shape::of_mesh(&mesh, 1e-2, &options(16, 64), 0.02).unwrap();
    let report = shape.report.decomposition.clone().unwrap();
    assert!(shape.parts.len() <= 16 && report.volume_error.abs() < 0.03, "{report:?}");
    assert!(shape.mass_report().volume_difference.abs() < 0.03);
}
