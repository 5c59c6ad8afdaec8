//! Erosion of a hundred thousand random hulls, with sharp tips, edges and near-parallel faces, against the support
//! function of the half-spaces moved inwards, which linear programming bounds from both sides.
use crate::support::Random;
use grains_geometry::{ConvexHull, MassProperties, Mat3, Shape, Vec3};
use std::f64::consts::TAU;

const HULLS: usize = 100_000;

/// Largest error of the support function, relative to the size of the body.
const TOLERANCE: f64 = 1e-9;

/// Corners of a regular polygon in the plane z.
fn ring(sides: usize, radius: f64, z: f64) -> impl Iterator<Item = Vec3> {
    (0..sides).map(move |k| {
        let (s, c) = (TAU * k as f64 / sides as f64).sin_cos();
        Vec3::new(radius * c, radius * s, z)
    })
}

/// A body about as large as 1 of one of eight families.
fn points(random: &mut Random, family: usize) -> Vec<Vec3> {
    let sides = if random.index(10) == 0 { 3 + random.index(46) } else { 3 + random.index(14) };
    let height = 10f64.powf(random.range(-1.5, 1.5));
    let small = 10f64.powf(random.range(-13.0, 0.0));
    match family {
        // Cone, bipyramid, cone cut near its tip.
        0 => ring(sides, 1.0, 0.0).chain([Vec3::z() * height]).collect(),
        1 => ring(sides, 1.0, 0.0).chain([Vec3::z() * height, Vec3::z() * -random.unit()]).collect(),
        2 => {
            let top = small.max(1e-8);
            ring(sides, 1.0, 0.0).chain(ring(sides, top, height * (1.0 - top))).collect()
        }
        // Prism whose opposite faces are parallel but for a small taper.
        3 => ring(sides, 1.0, -0.5 * height).chain(ring(sides, 1.0 - 0.9 * small, 0.5 * height)).collect(),
        // Sphere of longitudes and latitudes.
        4 => {
            let rows = 2 + random.index(4);
            let row = |k: usize| {
                let (s, c) = (0.5 * TAU * k as f64 / rows as f64).sin_cos();
                ring(sides, s, c)
            };
            (1..rows).flat_map(row).chain([Vec3::z(), -Vec3::z()]).collect()
        }
        // Roof: a wedge with one sharp edge.
        5 => {
            let base = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            let ridge = [Vec3::new(-random.unit(), 0.0, height), Vec3::new(random.unit(), small, height)];
            base.iter().map(|(x, y)| Vec3::new(*x, *y, 0.0)).chain(ridge).collect()
        }
        // Box with its corners moved a little: faces nearly parallel, faces nearly flat.
        6 => (0..8)
            .map(|i| {
                Vec3::from_fn(|k, _| if i >> k & 1 == 1 { 1.0 } else { -1.0 })
                    + random.vector() * (0.3 * small)
            })
            .collect(),
        _ => (0..4 + random.index(20)).map(|_| random.direction()).collect(),
    }
}

/// A body stretched, turned, moved, magnified, and written with a number of digits, as files have them.
fn body(random: &mut Random, number: usize) -> Vec<Vec3> {
    let stretch = Vec3::from_fn(|_, _| 10f64.powf(random.range(-0.7, 0.0)));
    let stretch = if random.index(2) == 0 { Vec3::repeat(1.0) } else { stretch };
    let turn = random.rotation();
    let turned = random.index(2) == 0;
    let shift = random.vector() * random.index(2) as f64;
    let size = 10f64.powf(random.range(-6.0, 0.0));
    let digits = [1e6, 1e9, 1e11, 1e13, 0.0][random.index(5)];
    let place = |p: Vec3| {
        let p = p.component_mul(&stretch);
        let p = if turned { turn * p } else { p } + shift;
        if digits > 0.0 { p.map(|x| (x * digits).round() / digits) * size } else { p * size }
    };
    points(random, number % 8).into_iter().map(place).collect()
}

/// Least Σ yᵢ eᵢ with d = Σ yᵢ nᵢ, y ≥ 0, over triples of the given planes nᵢ·x ≤ eᵢ: an upper bound of the largest d·x.
fn upper_bound(planes: &[(Vec3, f64)], direction: &Vec3) -> f64 {
    let mut least = f64::INFINITY;
    for i in 0..planes.len() {
        for j in 0..i {
            for k in 0..j {
                let normals = Mat3::from_columns(&[i, j, k].map(|p| planes[p].0));
                let Some(inverse) = normals.try_inverse() else { continue };
                // Refined, for the normals may be nearly parallel.
                let y = (0..3).fold(Vec3::zeros(), |y, _| y + inverse * (direction - normals * y));
                // What rounding leaves of d is not held by the planes; it counts in full.
                let y = y.map(|y| if y < 0.0 && y > -1e-12 { 0.0 } else { y });
                let rest = (normals * y - direction).norm();
                if y.min() >= 0.0 && rest < 1e-10 {
                    least = least.min(y.x * planes[i].1 + y.y * planes[j].1 + y.z * planes[k].1 + rest);
                }
            }
        }
    }
    least
}

/// Largest error of the support function of the eroded vertices over some directions, relative to the size.
fn error(hull: &ConvexHull, centre: &Vec3, depth: f64, random: &mut Random) -> f64 {
    let eroded = hull.eroded_vertices(centre, depth).unwrap();
    let size = hull.vertices.iter().map(|v| (v - centre).norm()).fold(0.0, f64::max);
    // About the centre and in units of the size.
    let planes: Vec<(Vec3, f64)> =
        hull.faces.iter().map(|f| (f.normal, (f.offset - depth - f.normal.dot(centre)) / size)).collect();
    let eroded: Vec<Vec3> = eroded.iter().map(|v| (v - centre) / size).collect();
    let outside = |v: &Vec3| planes.iter().map(|(n, e)| n.dot(v) - e).fold(0.0, f64::max);
    let mut worst = eroded.iter().map(outside).fold(0.0, f64::max);
    let corner = |k: usize| (hull.vertices[k] - centre).normalize();
    let face = random.index(hull.faces.len());
    let directions = [
        random.direction(),
        corner(random.index(hull.vertices.len())),
        // The corner farthest away: a tip, if there is one.
        corner(
            (0..hull.vertices.len())
                .max_by_key(|k| ((hull.vertices[*k] - centre).norm() / size * 1e9) as u64)
                .unwrap(),
        ),
        (hull.faces[face].normal + random.direction() * 1e-3).normalize(),
    ];
    for d in directions {
        let best = *eroded.iter().max_by(|a, b| a.dot(&d).total_cmp(&b.dot(&d))).unwrap();
        let mut near: Vec<(f64, (Vec3, f64))> = planes.iter().map(|p| (p.1 - p.0.dot(&best), *p)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let close: Vec<_> = near.iter().take_while(|p| p.0 < 1e-7).map(|p| p.1).collect();
        let mut bound = upper_bound(&close, &d);
        if bound - best.dot(&d) > TOLERANCE {
            // Planes that miss the point, as after a lost corner, or by near-parallel others.
            let more: Vec<_> = near.iter().take(60).map(|p| p.1).collect();
            bound = bound.min(upper_bound(&more, &d));
        }
        worst = worst.max(bound - best.dot(&d));
    }
    worst
}

#[test]
fn eroded_hulls_have_the_support_function_of_their_half_spaces() {
    let mut random = Random::new(17);
    let mut refused = 0;
    for number in 0..HULLS {
        let points = body(&mut random, number);
        let fraction = [0.02, 1e-3, 0.3][random.index(3)];
        // Digits may make two corners one or the body flat.
        let Ok(hull) = ConvexHull::new(&points) else {
            refused += 1;
            continue;
        };
        let mass = MassProperties::of_closed_mesh(&hull.triangles());
        let inscribed = hull.depth_of(&mass.center);
        let worst = error(&hull, &mass.center, fraction * inscribed, &mut random);
        assert!(worst < TOLERANCE, "{number}: support off by {worst:e} of the size, {fraction}: {points:?}");
        // Grown again, the core has the body's corners: what the body with sharp edges is taken from.
        let grown = error(&hull, &mass.center, -fraction * inscribed, &mut random);
        assert!(grown < TOLERANCE, "{number}: grown, off by {grown:e} of the size: {points:?}");
    }
    assert!(refused < HULLS / 10, "{refused} of {HULLS} are no bodies");
}

/// Cones as a file gives them, with eleven digits: the tip of the core is as far from that of the body as the crust over
/// the sine of half the opening angle.
#[test]
fn cones_of_any_number_of_sides_keep_their_tips() {
    for sides in 3..=64 {
        let rounded = |x: f64| (x * 1e11).round() / 1e11;
        let points: Vec<Vec3> =
            ring(sides, 0.01, -0.01).chain([Vec3::z() * 0.02]).map(|p| p.map(rounded)).collect();
        let shape = Shape::hull(&points, 0.02).unwrap();
        let part = &shape.parts[0];
        let up = shape.user_to_body.0.inverse_transform_vector(&Vec3::z());
        let tip = part.center + part.rotation * part.core.support(&part.rotation.tr_mul(&up));
        let height = up.dot(&tip) + shape.user_to_body.1.z;
        let apothem = 0.01 * (0.5 * TAU / sides as f64).cos();
        let expected = 0.02 - part.crust * apothem.hypot(0.03) / apothem;
        assert!((height - expected).abs() < 1e-11, "{sides} sides: tip at {height}, not {expected}");
        assert!(shape.volume.is_finite() && shape.mass_report().volume_difference.abs() < 1e-4, "{sides}");
    }
}
