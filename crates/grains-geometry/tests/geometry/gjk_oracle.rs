//! Distances and depths of bodies of 1e-6 to 1 m against those of parry, which gets them at unit size, as its
//! tolerances are absolute.

use crate::gjk_common::{Kind, Pair, Random};
use grains_geometry::epa::penetration;
use grains_geometry::gjk::Separation;
use grains_geometry::{Core, Rotation, Simplex, Vec3};
use nalgebra::Rotation3;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::details::{contact_support_map_support_map, distance_support_map_support_map};
use parry3d_f64::shape::{ConvexPolyhedron, Cuboid, Cylinder, SupportMap, Triangle};
use std::f64::consts::FRAC_PI_2;

const PAIRS: usize = 400_000;

/// Longest extent over the shortest; gjk_random goes to 100, where parry no longer is an oracle.
const SLENDERNESS: f64 = 4.0;

fn vector(v: &Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// Parry's shape, and its frame in ours: parry's cylinder stands along y.
fn oracle(core: &Core) -> Option<(Box<dyn SupportMap>, Rotation)> {
    let none = Rotation::identity();
    Some(match core {
        Core::Point | Core::Segment { .. } | Core::Cone(_) | Core::Superellipsoid(_) => return None,
        Core::Box(half) => (Box::new(Cuboid::new(vector(half))), none),
        Core::Cylinder { radius, half_height } => (
            Box::new(Cylinder::new(*half_height, *radius)),
            Rotation::from_scaled_axis(Vec3::x() * FRAC_PI_2),
        ),
        Core::Polyhedron(hull) => {
            let points: Vec<Vector> = hull.vertices().iter().map(vector).collect();
            (Box::new(ConvexPolyhedron::from_convex_hull(&points)?), none)
        }
        Core::Triangle([p, q, r]) => (Box::new(Triangle::new(vector(p), vector(q), vector(r))), none),
    })
}

/// Calls `check` with random pairs, their size (m), and parry's shapes and pose, of size 1.
fn for_all_pairs(
    seed: u64,
    kinds: &[Kind],
    mut check: impl FnMut(&Pair, f64, &Pose, &dyn SupportMap, &dyn SupportMap),
) {
    let mut random = Random(seed);
    for number in 0..PAIRS {
        let pair = [kinds[number % kinds.len()], kinds[number / kinds.len() % kinds.len()]];
        let aligned = random.below(4) == 0;
        let mut pair = Pair::random(&mut random, pair, SLENDERNESS, aligned, 1.0);
        pair.placement.matrix /= pair.placement.matrix.column(0).norm();
        let (Some((a, frame_a)), Some((b, frame_b))) = (oracle(&pair.a), oracle(&pair.b)) else { continue };
        let rotation =
            Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(pair.placement.matrix));
        let turn = (frame_a.inverse() * rotation * frame_b).scaled_axis();
        let shift = frame_a.inverse() * pair.placement.translation;
        let size = random.log(1e-6, 1.0);
        check(&pair.magnified(size), size, &Pose::new(vector(&shift), vector(&turn)), a.as_ref(), b.as_ref());
    }
}

#[test]
fn distances_of_polyhedra_agree() {
    let kinds = [Kind::Box, Kind::Icosahedron, Kind::Hull, Kind::Triangle];
    for_all_pairs(1, &kinds, |pair, size, pose, a, b| {
        let ours = pair.distance(&mut Simplex::default()) / size;
        let theirs = distance_support_map_support_map(pose, a, b);
        assert!((ours - theirs).abs() < 1e-7, "{ours} {theirs}");
    });
}

/// Parry ends on curved shapes at some 1e-6; our answers carry their own proof.
#[test]
fn distances_of_cylinders_agree() {
    for_all_pairs(2, &[Kind::Cylinder, Kind::Box, Kind::Cylinder], |pair, size, pose, a, b| {
        let answer = pair.query(&mut Simplex::default());
        assert!(pair.certify(&answer) < 1e-12);
        let ours = pair.distance(&mut Simplex::default()) / size;
        let theirs = distance_support_map_support_map(pose, a, b);
        assert!((ours - theirs).abs() < 5e-5, "{ours} {theirs}");
    });
}

/// Parry's depth is now and then less than the overlap along its own normal, hence no depth at all: it is
/// that overlap which must not be less than ours.
#[test]
fn depths_agree() {
    let kinds = [Kind::Box, Kind::Icosahedron, Kind::Hull, Kind::Cylinder];
    let (mut agree, mut differ) = (0, 0);
    for_all_pairs(3, &kinds, |pair, size, pose, a, b| {
        let mut simplex = Simplex::default();
        if pair.query(&mut simplex) != Separation::Meeting {
            return;
        }
        let ours = penetration(&pair.a, &pair.b, &pair.placement, &simplex).expect("converges");
        let Some(contact) = contact_support_map_support_map(pose, a, b, 0.0) else { return };
        let (_, frame) = oracle(&pair.a).expect("has been found before");
        let normal = frame * Vec3::new(contact.normal1.x, contact.normal1.y, contact.normal1.z);
        assert!(
            -pair.lower_bound(&normal) > ours.depth - 1e-8 * size,
            "{} {:?} {} {normal:?} {:?} {:?} {:?}",
            -pair.lower_bound(&normal),
            ours,
            contact.dist,
            pair.a,
            pair.b,
            pair.placement
        );
        *(if (ours.depth / size + contact.dist).abs() < 1e-5 { &mut agree } else { &mut differ }) += 1;
    });
    assert!(agree > PAIRS / 4 && differ < agree / 1000, "{agree} agree, {differ} differ");
}
