//! Signed distances from closed surfaces: against each other, and against what a distance is.

use grains_geometry::{ClosedMesh, ClosedSurface, Revolution, SolidError, TriMesh, Vec3};
use std::sync::Arc;

/// A cuboid as a closed mesh of outward triangles.
fn mesh_of_box(lower: Vec3, upper: Vec3) -> TriMesh {
    let corner = |i: usize| Vec3::from_fn(|a, _| if i >> a & 1 == 1 { upper[a] } else { lower[a] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces: Vec<Vec<usize>> = faces.iter().map(|face| face.to_vec()).collect();
    TriMesh::from_polygons((0..8).map(corner).collect(), &faces).unwrap()
}

/// Points of a box about the origin, the same in every run.
fn points(half: f64, count: usize) -> impl Iterator<Item = Vec3> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count).map(move |_| Vec3::from_fn(|_, _| half * (2.0 * random() - 1.0)))
}

#[test]
fn a_box_is_as_far_as_its_mesh() {
    let (lower, upper) = (Vec3::new(-0.5, -0.3, -0.7), Vec3::new(0.4, 0.6, 0.2));
    let cuboid = ClosedSurface::Box { lower, upper };
    let mesh = ClosedSurface::Mesh(Arc::new(ClosedMesh::new(mesh_of_box(lower, upper)).unwrap()));
    let mut inside = 0;
    for point in points(1.2, 20_000) {
        let [a, b] = [&cuboid, &mesh].map(|surface| surface.signed_distance(&point, None));
        assert!((a.distance - b.distance).abs() < 1e-14, "{point:?}: {a:?} {b:?}");
        // From the midst of edges and corners several ways are as short.
        let onto = point - b.outward * b.distance;
        assert!(cuboid.signed_distance(&onto, None).distance.abs() < 1e-14, "{point:?}: {b:?}");
        inside += usize::from(b.distance < 0.0);
    }
    assert!(inside > 500);
}

#[test]
fn distances_grow_by_the_way_along_their_directions() {
    let cylinder = ClosedSurface::Cylinder {
        center: Vec3::new(0.1, 0.0, -0.1),
        axis: Vec3::new(0.0, 0.6, 0.8),
        radius: 0.4,
        half_length: 0.5,
    };
    let normal = Vec3::new(0.48, -0.6, 0.64);
    let plane = ClosedSurface::Plane { point: Vec3::x() * 0.2, normal };
    let revolutions = profiles().map(|profile| ClosedSurface::Revolution(turned(&profile)));
    for surface in [cylinder, plane].into_iter().chain(revolutions) {
        for point in points(1.0, 5000) {
            let here = surface.signed_distance(&point, None);
            assert!((here.outward.norm() - 1.0).abs() < 1e-12);
            let onto = point - here.outward * here.distance;
            assert!(surface.signed_distance(&onto, None).distance.abs() < 1e-12, "{surface:?} {point:?}");
            // No way is shorter.
            for step in points(0.3, 5) {
                let there = surface.signed_distance(&(point + step), None);
                assert!((there.distance - here.distance).abs() <= step.norm() * (1.0 + 1e-12));
            }
        }
    }
}

#[test]
fn holes_are_told_with_their_place_and_meshes_inside_out_are_refused() {
    let mesh = mesh_of_box(Vec3::zeros(), Vec3::repeat(1.0));
    let mut open = mesh.clone();
    let lost = open.triangles.remove(3);
    let Err(SolidError::Open { open: 3, edges: 18, place }) = ClosedMesh::new(open) else { panic!("closed") };
    let middle =
        |k: usize| (mesh.vertices[lost[k] as usize] + mesh.vertices[lost[(k + 1) % 3] as usize]) * 0.5;
    assert!((0..3).any(|k| (middle(k) - Vec3::from(place)).norm() < 1e-12), "{place:?}");
    let mut turned = mesh;
    turned.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(matches!(ClosedMesh::new(turned), Err(SolidError::Inverted { .. })));
}

/// Profiles: a cone with caps, a funnel, a ring, a body with a waist, given downwards.
fn profiles() -> [Vec<[f64; 2]>; 4] {
    [
        vec![[-0.5, 0.0], [-0.5, 0.2], [0.6, 0.5], [0.6, 0.0]],
        vec![[-0.6, 0.0], [0.1, 0.5], [0.5, 0.45], [0.5, 0.0]],
        vec![[-0.3, 0.2], [-0.2, 0.5], [0.4, 0.3], [-0.3, 0.2]],
        vec![[0.6, 0.0], [0.5, 0.4], [0.0, 0.1], [-0.5, 0.3], [-0.4, 0.0]],
    ]
}

fn turned(profile: &[[f64; 2]]) -> Revolution {
    Revolution::new(Vec3::new(0.1, -0.05, 0.02), Vec3::new(0.48, -0.6, 0.64), profile.to_vec())
}

#[test]
fn a_surface_of_revolution_is_as_far_as_its_mesh() {
    const FACETS: u32 = 200;
    for profile in profiles() {
        let mesh = turned(&profile).mesh(FACETS);
        // Pappus: a piece of the profile sweeps a frustum.
        let frustum = |[a, b]: [[f64; 2]; 2]| {
            std::f64::consts::PI / 3.0 * (b[0] - a[0]) * (a[1] * a[1] + a[1] * b[1] + b[1] * b[1])
        };
        let volume = profile.windows(2).map(|p| frustum([p[0], p[1]])).sum::<f64>().abs();
        let six = |t: usize| {
            let [a, b, c] = mesh.corners(t);
            a.dot(&b.cross(&c))
        };
        let of_mesh = (0..mesh.triangles.len()).map(six).sum::<f64>() / 6.0;
        assert!((of_mesh - volume).abs() < 1e-12, "{of_mesh} {volume} {profile:?}");
        let mesh = ClosedMesh::new(mesh).unwrap();
        let exact = ClosedSurface::Revolution(turned(&profile));
        // The facets depart by so much.
        let sag = 0.5 * (1.0 - (std::f64::consts::PI / f64::from(FACETS)).cos()) * 2.0;
        for point in points(1.0, 3000) {
            let (a, b) = (exact.signed_distance(&point, None), mesh.signed_distance(&point));
            assert!((a.distance - b.distance).abs() < sag, "{profile:?} {point:?} {a:?} {b:?}");
        }
        let [lower, upper] = exact.extents().unwrap();
        assert!(
            mesh.mesh()
                .vertices
                .iter()
                .all(|v| (0..3).all(|a| v[a] > lower[a] - sag && v[a] < upper[a] + sag))
        );
    }
}

#[test]
fn open_ends_of_a_profile_go_on_as_tubes() {
    let mut open: Vec<Vec<[f64; 2]>> =
        vec![vec![[-0.4, 0.1], [0.2, 0.5]], vec![[-0.4, 0.0], [0.2, 0.5]], vec![[0.1, 0.3], [-0.5, 0.0]]];
    open.extend(open.clone().into_iter().map(|mut profile| {
        profile.reverse();
        profile
    }));
    for profile in open {
        let surface = ClosedSurface::Revolution(turned(&profile));
        assert!(surface.extents().is_none());
        // The same with tubes as long as the points are far.
        let (first, last) = (profile[0], profile[profile.len() - 1]);
        let up = 50.0_f64.copysign(last[0] - first[0]);
        let mut closed = profile.clone();
        if first[1] > 0.0 {
            closed.splice(0..0, [[-up, 0.0], [-up, first[1]]]);
        }
        if last[1] > 0.0 {
            closed.extend([[up, last[1]], [up, 0.0]]);
        }
        let closed = ClosedSurface::Revolution(turned(&closed));
        for point in points(1.5, 3000) {
            let [a, b] = [&surface, &closed].map(|s| s.signed_distance(&point, None));
            assert!(
                (a.distance - b.distance).abs() < 1e-12 && (a.outward - b.outward).norm() < 1e-9,
                "{a:?} {b:?}"
            );
        }
    }
}

#[test]
fn a_cone_of_one_radius_is_a_cylinder() {
    let (center, axis) = (Vec3::new(0.1, 0.0, -0.1), Vec3::new(0.0, 0.6, 0.8));
    let profile = vec![[-0.5, 0.0], [-0.5, 0.4], [0.5, 0.4], [0.5, 0.0]];
    let cone = ClosedSurface::Revolution(Revolution::new(center, axis, profile));
    let cylinder = ClosedSurface::Cylinder { center, axis, radius: 0.4, half_length: 0.5 };
    for point in points(1.0, 5000) {
        let [a, b] = [&cone, &cylinder].map(|s| s.signed_distance(&point, None));
        assert!(
            (a.distance - b.distance).abs() < 1e-13 && (a.outward - b.outward).norm() < 1e-9,
            "{a:?} {b:?}"
        );
    }
}
