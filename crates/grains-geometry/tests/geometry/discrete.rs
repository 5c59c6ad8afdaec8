//! Contacts found by surface vertices against the distance of the bodies and closed forms.
use crate::gjk_common::{Random, place};
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{DiscreteSurface, Placement, Rotation, Shape, Simplex, Spacing, Superellipsoid, Vec3};

fn surface(axes: [f64; 3], eps: [f64; 2], n: usize, spacing: Spacing) -> DiscreteSurface {
    DiscreteSurface::new(&Superellipsoid::new(Vec3::from(axes), eps).unwrap(), n, spacing).unwrap()
}

/// Overlap and normal of two ellipsoids 2:1:1 by their distance.
fn exact(placement: &Placement) -> Option<(f64, Vec3)> {
    let part = Shape::superellipsoid(Vec3::new(1.0, 0.5, 0.5), [1.0; 2], 0.2).unwrap().parts.remove(0);
    match distance(&part.core, &part.core, placement, 1.0, &mut Simplex::default()) {
        Ok(Separation::Apart { distance, normal, .. }) => Some((2.0 * part.crust - distance, normal)),
        _ => None,
    }
}

/// Mean error of overlap (of the exact overlap) and normal (rad), and the share of contacts missed.
fn errors(n: usize, overlap: f64) -> [f64; 3] {
    let ellipsoid = surface([1.0, 0.5, 0.5], [1.0; 2], n, Spacing::Linear);
    let mut random = Random(1);
    let (mut depth, mut turn, mut found, mut all) = (0.0, 0.0, 0.0, 0.0);
    for _ in 0..300 {
        let mut placement = place(&random.rotation(), 1.0, random.direction() * 1.9);
        let Some((o, normal)) = exact(&placement) else { continue };
        placement.translation += normal * (o - overlap);
        let Some((o, normal)) = exact(&placement) else { continue };
        all += 1.0;
        let Some(contact) = ellipsoid.contact(&ellipsoid, &placement) else { continue };
        found += 1.0;
        depth += (contact.overlap / o - 1.0).abs();
        turn += contact.normal.cross(&normal).norm().asin();
        let seen = Placement { matrix: placement.matrix, translation: placement.translation };
        assert!(contact.point.norm() < 1.0 && seen.inverse().apply(&contact.point).norm() < 1.0);
    }
    [depth / found, turn / found, 1.0 - found / all]
}

#[test]
fn contacts_approach_those_of_the_distance_with_more_vertices() {
    let table = [20, 30, 40, 80, 160].map(|n| (n, errors(n, 0.04)));
    for (n, [depth, turn, missed]) in table {
        println!("N = {n}: overlap off by {depth:.3}, normal by {turn:.4} rad, missed {missed:.3}");
    }
    let [(_, coarse), .., (_, fine)] = table;
    assert!(fine[0] < 0.1 * coarse[0] && fine[1] < 0.6 * coarse[1]);
    assert!(fine[0] < 0.01 && fine[2] == 0.0, "{fine:?}");
    // Averaged over a lens whose size goes with the root of the overlap, the normal keeps an error of its order.
    let shallow = errors(160, 0.01);
    assert!(shallow[1] < 0.6 * fine[1] && shallow[1] < 0.01, "{shallow:?}");
}

#[test]
fn spheres_have_their_closed_form() {
    let sphere = surface([0.5; 3], [1.0; 2], 100, Spacing::Linear);
    let placement = place(&Rotation::identity(), 1.0, Vec3::new(0.57, 0.76, 0.0));
    let contact = sphere.contact(&sphere, &placement).unwrap();
    assert!((contact.overlap - 0.05).abs() < 2e-3, "{contact:?}");
    assert!((contact.normal - Vec3::new(0.6, 0.8, 0.0)).norm() < 0.02);
    assert!((contact.point - Vec3::new(0.285, 0.38, 0.0)).norm() < 0.01);
    // A sphere of twice the size touches farther off.
    let larger = place(&Rotation::identity(), 2.0, Vec3::new(0.0, 0.0, 1.45));
    let contact = sphere.contact(&sphere, &larger).unwrap();
    assert!((contact.overlap - 0.05).abs() < 1e-3 && (contact.normal - Vec3::z()).norm() < 1e-2);
    assert!(sphere.contact(&sphere, &place(&Rotation::identity(), 1.0, Vec3::x() * 1.01)).is_none());
}

/// (S19-14): a vertex of one body inside the other is no contact by itself.
#[test]
fn no_contact_without_vertices_of_both() {
    let large = surface([1.0; 3], [1.0; 2], 8, Spacing::Linear);
    let small = surface([0.05; 3], [1.0; 2], 20, Spacing::Linear);
    // Between two vertices of the large sphere, 45° apart.
    let n = Vec3::new((std::f64::consts::PI / 8.0).cos(), (std::f64::consts::PI / 8.0).sin(), 0.0);
    let placement = place(&Rotation::identity(), 1.0, n * 1.04);
    assert!(large.contact(&small, &placement).is_none());
}

#[test]
fn walls_meet_the_lowest_vertices() {
    let ellipsoid = surface([1.0, 0.5, 0.25], [1.0; 2], 20, Spacing::Linear);
    // The south pole is a vertex.
    let wall = ellipsoid.contact_with_plane(&Vec3::new(3.0, 1.0, -0.24), &Vec3::z()).unwrap();
    assert!((wall.overlap - 0.01).abs() < 1e-15 && wall.normal == -Vec3::z());
    assert!(wall.point.xy().norm() < 1e-12 && wall.point.z < -0.24);
    assert!(ellipsoid.contact_with_plane(&Vec3::new(0.0, 0.0, -0.26), &Vec3::z()).is_none());
}

/// Figure 2-3: even latitudes leave the side of a cylinder bare.
#[test]
fn exponential_spacing_fills_the_side_of_a_cylinder() {
    let on_side = |spacing| {
        let cylinder = surface([1.0; 3], [0.1, 1.0], 20, spacing);
        cylinder.vertices().iter().filter(|v| v.z.abs() < 0.6).count()
    };
    assert_eq!(on_side(Spacing::Linear), 0);
    assert!(on_side(Spacing::Exponential) >= 200, "{}", on_side(Spacing::Exponential));
    let count = surface([1.0; 3], [0.1, 1.0], 20, Spacing::Exponential).vertices().len();
    assert_eq!(count, 18 * 20 + 2);
    let even = |spacing| {
        surface([1.0; 3], [1.0; 2], 21, spacing).vertices()[2..].iter().map(|v| v.z.abs()).fold(1.0, f64::min)
    };
    assert_eq!(even(Spacing::Linear), 0.0);
    assert!(
        DiscreteSurface::new(
            &Superellipsoid::new(Vec3::x().add_scalar(1.0), [1.0; 2]).unwrap(),
            3,
            Spacing::Linear
        )
        .is_err()
    );
}
