//! Superellipsoids against closed forms, and their distances against certificates and an independent solution.
use crate::gjk_common::{KINDS, Kind, Pair, Random, place};
use grains_geometry::epa::penetration;
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{
    Core, MassProperties, Placement, Rotation, Shape, ShapeError, Simplex, Superellipsoid, Vec3,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Semi-axes, ε₁, ε₂, volume, moments of inertia of unit density, by quadrature.
type Row = ([f64; 3], [f64; 2], f64, [f64; 3]);

const TABLE: [Row; 10] = [
    ([1.0, 1.0, 1.0], [1.0, 1.0], 4.1887902048, [1.6755160819; 3]),
    ([1.0, 2.0, 3.0], [1.0, 1.0], 25.1327412287, [65.3451271947, 50.2654824574, 25.1327412287]),
    ([2.0, 0.5, 0.5], [1.0, 1.0], 2.0943951024, [0.2094395102, 1.7802358370, 1.7802358370]),
    ([1.0, 1.0, 1.0], [0.5, 0.5], 6.4819873518, [3.5543063505; 3]),
    ([1.0, 1.0, 1.0], [0.2, 0.2], 7.6752358866, [4.8882725493; 3]),
    ([1.0, 1.0, 1.0], [0.1, 1.0], 6.2367409439, [3.6000901260, 3.6000901260, 3.0980551999]),
    ([1.0, 1.0, 2.0], [0.5, 1.0], 10.9832489998, [14.5582935130, 14.5582935130, 5.0265482457]),
    ([1.0, 0.8, 0.6], [1.0, 0.5], 2.3732155869, [0.5348324926, 0.7395605383, 0.9326499864]),
    ([1.0, 1.0, 1.0], [2.0, 2.0], 4.0 / 3.0, [4.0 / 15.0; 3]),
    ([1.0, 2.0, 0.5], [1.5, 0.8], 3.2406677511, [2.5401341054, 0.7213809982, 3.0312551787]),
];

/// Random exponents: round, square, with edges.
fn eps(random: &mut Random) -> [f64; 2] {
    let one = |random: &mut Random| match random.below(6) {
        0 => 1.0,
        1 => [0.1, 0.2, 0.25, 0.5][random.below(4)],
        2 => random.log(0.05, 0.3),
        3 | 4 => 0.3 + 0.7 * random.unit(),
        _ => 1.0 + random.unit(),
    };
    let first = one(random);
    [first, if random.below(2) == 0 { first } else { one(random) }]
}

/// The core of a random shape, of longest semi-axis `size`.
fn core(random: &mut Random, slenderness: f64, size: f64) -> Core {
    let mut axes = Vec3::from_fn(|_, _| random.log(1.0 / slenderness, 1.0));
    axes[random.below(3)] = 1.0;
    let shape = Shape::superellipsoid(axes * size, eps(random), random.log(1e-3, 0.2)).unwrap();
    shape.parts[0].core.clone()
}

fn body(core: &Core) -> &Superellipsoid {
    let Core::Superellipsoid(body) = core else { panic!("no superellipsoid") };
    body
}

#[test]
fn volume_and_inertia_agree_with_quadrature() {
    for (axes, eps, volume, inertia) in TABLE {
        let shape = Shape::superellipsoid(Vec3::from(axes), eps, 0.02).unwrap();
        assert!((shape.volume / volume - 1.0).abs() < 1e-9, "{axes:?} {eps:?}");
        let off = shape.inertia.component_div(&Vec3::from(inertia)).add_scalar(-1.0);
        assert!(off.amax() < 1e-9, "{axes:?} {eps:?}");
    }
    let box_like = Shape::superellipsoid(Vec3::repeat(1.0), [0.05; 2], 0.02).unwrap();
    assert!((box_like.volume / 8.0 - 1.0).abs() < 0.01);
}

#[test]
fn eps_out_of_range_is_refused() {
    for eps in [[0.01, 1.0], [1.0, 2.1], [f64::NAN, 1.0]] {
        let error = Shape::superellipsoid(Vec3::repeat(1.0), eps, 0.02).unwrap_err();
        assert!(matches!(error, ShapeError::OutOfRange { quantity: "eps", .. }));
        assert!(error.to_string().contains("[0.05, 2]"));
    }
}

#[test]
fn surfaces_are_closed_and_near_the_volume() {
    for eps in [[0.1, 0.1], [0.1, 1.0], [1.0, 0.1], [0.25, 0.25], [1.0, 1.0], [1.5, 0.8], [2.0, 2.0]] {
        let shape = Shape::superellipsoid(Vec3::new(1.0, 0.7, 0.5), eps, 0.02).unwrap();
        let report = shape.surface.report();
        assert_eq!((report.open_edges, report.non_manifold_edges), (0, 0));
        let ratio = MassProperties::of_closed_mesh(&shape.surface).volume / shape.volume;
        assert!((0.97..1.0 + 1e-12).contains(&ratio), "{eps:?}: {ratio}");
    }
}

#[test]
fn radii_hold_what_they_say() {
    let mut random = Random(1);
    for _ in 0..200 {
        let axes = Vec3::from_fn(|_, _| random.log(0.1, 1.0));
        let eps = eps(&mut random);
        let shape = Shape::superellipsoid(axes, eps, 0.05).unwrap();
        let part = &shape.parts[0];
        let whole = Superellipsoid::new(axes, eps).unwrap();
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        for i in 0..=60 {
            for k in 0..=60 {
                let point =
                    whole.surface_point(f64::from(i) * FRAC_PI_2 / 60.0, f64::from(k) * FRAC_PI_2 / 60.0);
                assert!((whole.inside_outside(&point) - 1.0).abs() < 1e-11);
                assert!(part.contains(&(point * (1.0 - 1e-9))) && !part.contains(&(point * (1.0 + 1e-9))));
                least = least.min(point.norm());
                most = most.max(point.norm());
            }
        }
        // The core swept by the crust stays within the body; without edges it is the body.
        for k in 0..400 {
            let n = if k % 2 == 0 {
                random.direction()
            } else {
                let [azimuth, latitude] = [0, 1].map(|_| FRAC_PI_2 * random.unit());
                whole.gauge(&whole.surface_point(azimuth, latitude)).1.normalize()
            };
            let reach = n.dot(&part.core.support(&n)) + part.crust;
            let sharp = n.dot(&Core::superellipsoid(whole).support(&n));
            assert!(reach <= sharp * (1.0 + 1e-8), "{axes:?} {eps:?} along {n:?}: {:e}", reach / sharp - 1.0);
            assert!(eps[0] > 1.0 || eps[1] > 1.0 || (reach - sharp).abs() < 1e-12);
        }
        assert!(least >= shape.inscribed_radius * (1.0 - 1e-12) && least < shape.inscribed_radius * 1.05);
        assert!(most <= shape.bounding_radius * (1.0 + 1e-12) && most > shape.bounding_radius * 0.95);
    }
}

/// Bodies with edges: what the crust takes from their tips, and from any other place. Half axes of 1 and 2 with eps 1.5 lost
/// 1.2 to 2.2 % to cores of the body's own eps.
#[test]
fn the_crust_takes_little_of_bodies_with_edges() {
    let rows: [([f64; 3], [f64; 2], f64); 8] = [
        ([1.0, 1.0, 1.0], [1.5, 1.5], 2e-3),
        ([1.0, 1.0, 1.0], [1.2, 1.2], 4e-4),
        ([1.0, 1.0, 2.0], [1.5, 1.5], 4e-3),
        ([1.0, 2.0, 0.5], [1.5, 0.8], 5.5e-3),
        ([1.0, 1.0, 1.0], [1.5, 1.0], 1e-3),
        ([1.0, 0.7, 0.5], [0.5, 1.5], 2e-3),
        ([1.0, 1.0, 1.0], [1.5, 0.2], 2e-3),
        // An octahedron loses as much as any polyhedron.
        ([1.0, 1.0, 1.0], [2.0, 2.0], 9e-3),
    ];
    let mut random = Random(21);
    for (axes, eps, bound) in rows {
        let axes = Vec3::from(axes);
        let shape = Shape::superellipsoid(axes, eps, 0.02).unwrap();
        let part = &shape.parts[0];
        let whole = Core::superellipsoid(Superellipsoid::new(axes, eps).unwrap());
        let tips = (0..3).map(|k| Vec3::ith(k, 1.0));
        for n in tips.chain((0..2000).map(|_| random.direction())) {
            let gap = 1.0 - (part.core.support_value(&n) + part.crust) / whole.support_value(&n);
            assert!(gap > -1e-8 && gap < bound, "{axes:?} {eps:?}: {gap:e} along {n:?}");
        }
    }
}

#[test]
fn ellipsoids_have_the_support_of_their_matrix_and_the_crust_their_curvature() {
    let mut random = Random(2);
    for _ in 0..1000 {
        let axes = Vec3::from_fn(|_, _| random.log(0.1, 1.0));
        let ellipsoid = Superellipsoid::new(axes, [1.0; 2]).unwrap();
        let n = random.direction();
        let exact = n.component_mul(&axes).norm();
        assert!((n.dot(&Core::superellipsoid(ellipsoid).support(&n)) - exact).abs() < 1e-15);
        let radius = axes.min() * axes.min() / axes.max();
        assert!((ellipsoid.min_curvature_radius() - radius).abs() < 1e-15);
    }
    // A circular bar is as curved as a circle of its radius at the equator, at the edge far more.
    let bar = Superellipsoid::new(Vec3::new(1.0, 1.0, 1.0), [0.5, 1.0]).unwrap();
    // m⁴ + z⁴ = 1 at m = z: curvature 3·2^(1/4)/√2.
    let edge = 2f64.sqrt() / (3.0 * 2f64.powf(0.25));
    assert!((bar.min_curvature_radius() / edge - 1.0).abs() < 1e-3, "{}", bar.min_curvature_radius());
}

/// A sphere outside an ellipsoid's pole, and one off a block's flat face.
#[test]
fn spheres_meet_superellipsoids_at_the_right_distance() {
    let mut random = Random(3);
    for size in [1e-6, 1.0, 1e3] {
        for _ in 0..250 {
            let core = core(&mut random, 10.0, size);
            let n = random.direction();
            let foot = core.support(&n);
            let gap = size * random.log(1e-6, 1.0);
            let place = place(&random.rotation(), 1.0, foot + n * gap);
            let answer =
                distance(&core, &Core::Point, &place, f64::INFINITY, &mut Simplex::default()).unwrap();
            let Separation::Apart { distance, normal, .. } = answer else { panic!("apart") };
            assert!((distance - gap).abs() < 1e-13 * size, "{distance} {gap}");
            assert!(
                (normal - n).norm() < 2e-7 * (size / gap).sqrt().max(1.0),
                "{core:?} {gap:e} {:e}",
                (normal - n).norm()
            );
        }
    }
}

/// Calls `check` with random pairs of a superellipsoid and any core, some near.
fn for_all_pairs(seed: u64, pairs: usize, mut check: impl FnMut(&mut Random, usize, Pair)) {
    let mut random = Random(seed);
    let pool: Vec<Core> =
        (0..400).map(|k| core(&mut random, if k % 2 == 0 { 2.0 } else { 20.0 }, 1.0)).collect();
    let any = |random: &mut Random, size: f64| {
        let Core::Superellipsoid(body) = &pool[random.below(pool.len())] else { panic!("no superellipsoid") };
        Core::superellipsoid(body.magnified(size))
    };
    for number in 0..pairs {
        let size = [1e-6, 1.0, 1e3][random.below(3)];
        let slenderness = if random.below(2) == 0 { 2.0 } else { 20.0 };
        let partner = number % 12;
        let other = match KINDS.get(partner) {
            Some(kind) => crate::gjk_common::scaled(&random.core(*kind, slenderness), size),
            None => any(&mut random, size),
        };
        let own = any(&mut random, size);
        let (a, b) = if random.below(2) == 0 { (own, other) } else { (other, own) };
        let rotation = if random.below(2) == 0 { random.aligned() } else { random.rotation() };
        let scale = random.log(0.5, 2.0);
        let reach = a.radius() + b.radius() * scale;
        let translation = random.direction() * (reach * (0.2 + random.unit()));
        let pair = Pair::new(a, b, place(&rotation, scale, translation));
        let near = random.below(2) == 0;
        let target = pair.size * random.log(1e-5, 1.0);
        check(&mut random, partner, if near { pair.at_distance(target) } else { pair });
    }
}

#[test]
fn random_pairs_are_certified_warm_and_cold() {
    let mut worst = 0.0f64;
    for_all_pairs(4, 100_000, |random, partner, pair| {
        let mut simplex = Simplex::default();
        let gap = pair.certify(&pair.query(&mut simplex));
        assert!(gap < 1e-9, "{:?}: gap {gap:e}", KINDS.get(partner));
        let motion = random.log(1e-7, 1e-1);
        let moved = pair.moved(random, motion);
        let gap = moved.certify(&moved.query(&mut simplex));
        assert!(gap < 1e-9, "{:?}: gap {gap:e}", KINDS.get(partner));
        let (warm, cold) = (moved.distance(&mut simplex), moved.distance(&mut Simplex::default()));
        worst = worst.max((warm - cold).abs() / pair.size);
        assert!((warm - cold).abs() <= 1e-9 * pair.size, "{warm} {cold}");
    });
    println!("warm and cold differ by {worst:e}");
}

/// Slender and flat cylinders on an axis of a superellipsoid, or off it by next to nothing: components of directions of 1e-160,
/// whose squares lose their digits, must not move support points off the rim. Far apart and near, turned and not.
#[test]
fn cylinders_on_an_axis_are_certified() {
    let mut random = Random(12);
    let mut pool: Vec<Core> =
        (0..300).map(|k| core(&mut random, if k % 2 == 0 { 1.1 } else { 5.0 }, 1.0)).collect();
    for eps in [[1.816, 0.748], [1.3, 1.9], [1.98, 0.07]] {
        let shape = Shape::superellipsoid(Vec3::new(0.98, 0.95, 1.0), eps, 0.02).unwrap();
        pool.push(shape.parts[0].core.clone());
    }
    for number in 0..150_000 {
        let a = pool[random.below(pool.len())].clone();
        let b = Core::Cylinder { radius: random.log(0.003, 1.0), half_height: random.log(0.003, 1.0) };
        let rotation = if random.below(4) == 0 { random.rotation() } else { random.aligned() };
        let axis = Vec3::ith(random.below(3), if random.below(2) == 0 { 1.0 } else { -1.0 });
        let off = if random.below(2) == 0 { random.log(1e-16, 1e-2) } else { 0.0 };
        let direction = (axis + random.direction() * off).normalize();
        let apart = direction * ((a.radius() + b.radius()) * random.log(0.5, 5.0));
        let pair = Pair::new(a, b, place(&rotation, 1.0, apart));
        let pair = if number % 2 == 0 { pair } else { pair.exchanged() };
        let mut simplex = Simplex::default();
        let gap = pair.certify(&pair.query(&mut simplex));
        assert!(gap < 1e-9, "{number}: gap {gap:e}");
        let gap = pair.certify(&pair.query(&mut simplex));
        assert!(gap < 1e-9, "{number}: gap {gap:e} warm");
    }
}

#[test]
fn distances_are_symmetric_and_turn_with_the_bodies() {
    for_all_pairs(5, 20_000, |_, partner, pair| {
        if KINDS.get(partner) == Some(&Kind::Cylinder) {
            return;
        }
        let exchanged = pair.exchanged();
        let scale = pair.placement.matrix.column(0).norm();
        let (ab, ba) =
            (pair.distance(&mut Simplex::default()), exchanged.distance(&mut Simplex::default()) * scale);
        assert!(
            (ab - ba).abs() <= 1e-12 * pair.size,
            "{:?} {:e}",
            KINDS.get(partner),
            (ab - ba).abs() / pair.size
        );
    });
}

/// Least distance of two surfaces over their parameters by a random search: no use is made of support points
/// or normals. Nearly flat faces would need more patience of it.
#[test]
fn no_points_of_the_surfaces_are_nearer() {
    let mut random = Random(6);
    for _ in 0..30 {
        let bodies = [0; 2].map(|_| {
            let axes = Vec3::from_fn(|_, _| random.log(0.5, 1.0));
            Superellipsoid::new(axes, [0.6 + 0.6 * random.unit(), 0.6 + 0.6 * random.unit()]).unwrap()
        });
        let placement = place(&random.rotation(), 1.0, random.direction() * 2.5);
        let [a, b] = bodies.map(Core::superellipsoid);
        let pair = Pair::new(a, b, placement);
        let answer = pair.query(&mut Simplex::default());
        let Separation::Apart { distance, .. } = answer else { continue };
        let sampled = nearest_by_search(&bodies, &placement);
        assert!(distance <= sampled + 1e-12, "{distance} {sampled}");
        assert!(sampled - distance < 1e-7, "{distance} {sampled} {bodies:?}");
    }
}

fn nearest_by_search([a, b]: &[Superellipsoid; 2], placement: &Placement) -> f64 {
    let at =
        |x: [f64; 4]| (placement.apply(&b.surface_point(x[2], x[3])) - a.surface_point(x[0], x[1])).norm();
    let points = |body: &Superellipsoid| {
        let angles =
            (0..512).map(|k| [TAU * f64::from(k % 32) / 32.0, PI * (f64::from(k / 32) + 0.5) / 16.0]);
        angles.map(|[l, m]| ([l, m - FRAC_PI_2], body.surface_point(l, m - FRAC_PI_2))).collect::<Vec<_>>()
    };
    let mut best = ([0.0; 4], f64::INFINITY);
    for (y, q) in points(b) {
        let q = placement.apply(&q);
        for (x, p) in points(a) {
            if (q - p).norm() < best.1 {
                best = ([x[0], x[1], y[0], y[1]], (q - p).norm());
            }
        }
    }
    let (mut random, mut step) = (Random(7), 0.2);
    while step > 1e-9 {
        let mut improved = false;
        for _ in 0..60 {
            let x = best.0.map(|x| x + step * (2.0 * random.unit() - 1.0));
            if at(x) < best.1 {
                (best, improved) = ((x, at(x)), true);
            }
        }
        step *= if improved { 1.0 } else { 0.7 };
    }
    best.1
}

/// Blocks face to face: parallel, tilted by little, shifted at random.
#[test]
fn blocks_face_to_face_converge_from_step_to_step() {
    let mut random = Random(8);
    for number in 0..1500 {
        let eps = [0.25, 0.1, 0.5, 0.33, 0.05][number % 5];
        let shape = Shape::superellipsoid(Vec3::new(0.5, 0.6, 0.7), [eps; 2], 0.02).unwrap();
        let core = shape.parts[0].core.clone();
        let tilt = if number % 3 == 0 { 0.0 } else { random.log(1e-12, 1e-2) };
        let axis = random.direction();
        let turn = Rotation::from_scaled_axis(axis * tilt);
        let gap = random.log(1e-4, 0.04);
        let reach = 2.0 * body(&core).semi_axes().z - 2.0 * body(&core).inset();
        let shift = Vec3::new(random.unit() - 0.5, random.unit() - 0.5, reach + gap);
        let mut pair = Pair::new(core.clone(), core.clone(), place(&turn, 1.0, shift));
        let mut simplex = Simplex::default();
        for _ in 0..20 {
            let answer = pair.query(&mut simplex);
            assert!(pair.certify(&answer) < 1e-12, "{eps} {tilt:e}: {:e}", pair.certify(&answer));
            let motion = random.log(1e-8, 1e-3) * gap;
            pair = pair.moved(&mut random, motion);
        }
    }
}

#[test]
fn cores_that_meet_are_separated_by_the_least_translation() {
    let mut met = 0;
    for_all_pairs(9, 2_000, |random, partner, pair| {
        let mut simplex = Simplex::default();
        if pair.query(&mut simplex) != Separation::Meeting {
            return;
        }
        met += 1;
        let p = penetration(&pair.a, &pair.b, &pair.placement, &simplex).unwrap();
        assert!(p.depth >= -2e-12 * pair.size);
        assert!((p.depth + pair.lower_bound(&p.normal)).abs() <= 1e-12 * pair.size);
        for _ in 0..10 {
            let far = random.direction();
            let near = (p.normal + far * random.log(1e-6, 1.0)).normalize();
            for direction in [far, near] {
                let depth = -pair.lower_bound(&direction);
                let more = (p.depth - depth) / pair.size;
                assert!(more < 1e-8, "{:?}: {more:e} less", KINDS.get(partner));
            }
        }
    });
    assert!(met > 200, "{met}");
}

/// Pushed together by little, along the normal, cores are no deeper in each other than that.
#[test]
fn cores_pushed_together_are_no_deeper_than_pushed() {
    let mut met = [0; 12];
    for_all_pairs(10, 20_000, |random, partner, pair| {
        let gap = pair.size * random.log(1e-5, 1e-2);
        let pair = pair.at_distance(gap);
        let mut simplex = Simplex::default();
        let Separation::Apart { normal, .. } = pair.query(&mut simplex) else { return };
        let push = pair.size * random.log(1e-6, 1e-2);
        let mut placement = pair.placement;
        placement.translation -= normal * (gap + push);
        let pushed = Pair::new(pair.a.clone(), pair.b.clone(), placement);
        for mut start in [Simplex::default(), simplex] {
            let answer = pushed.query(&mut start);
            // An acute edge may pass by a corner.
            if answer != Separation::Meeting {
                assert!(pushed.certify(&answer) < 1e-9);
                continue;
            }
            met[partner] += 1;
            let p = penetration(&pushed.a, &pushed.b, &pushed.placement, &start).unwrap();
            let more = (p.depth - push) / pair.size;
            assert!(more < 1e-10, "{:?} {:e}: {more:e} {pushed:?}", KINDS.get(partner), push / pair.size);
            // Newton's method from the points of the last step finds what the polytope finds from nothing.
            let cold = penetration(&pushed.a, &pushed.b, &pushed.placement, &Simplex::default()).unwrap();
            let apart = (p.depth - cold.depth).abs() / pair.size;
            assert!(apart < 1e-8, "{:?} {:e}: {apart:e} {pushed:?}", KINDS.get(partner), push / pair.size);
        }
    });
    assert!(met.iter().all(|met| *met > 500), "{met:?}");
}

/// Whatever points the simplex holds, `Beyond` is a proof and a distance is certified.
#[test]
fn any_points_of_the_bodies_are_a_valid_start() {
    for_all_pairs(11, 20_000, |random, partner, pair| {
        let cold = pair.distance(&mut Simplex::default());
        let mut start = Simplex { len: 1 + random.below(4) as u8, ..Simplex::default() };
        for i in 0..start.len as usize {
            start.a[i] = pair.a.support(&random.direction());
            start.b[i] = pair.b.support(&random.direction());
        }
        let cutoff = cold * (1.0 + 1e-3) + 1e-9 * pair.size;
        let answer = distance(&pair.a, &pair.b, &pair.placement, cutoff, &mut start).unwrap();
        match answer {
            Separation::Beyond { .. } => panic!("{:?} is not beyond {cutoff}: {cold}", KINDS.get(partner)),
            Separation::Apart { distance, .. } => assert!((distance - cold).abs() <= 1e-9 * pair.size),
            Separation::Meeting => assert!(cold <= 1e-11 * pair.size, "{:?} {cold}", KINDS.get(partner)),
        }
        let near = 0.99 * cold;
        if near > 1e-9 * pair.size {
            let answer = distance(&pair.a, &pair.b, &pair.placement, near, &mut start).unwrap();
            let Separation::Beyond { axis } = answer else { panic!("{answer:?} within {near}") };
            let gap = pair.gap_across(&axis);
            assert!(gap > near - 1e-12 * pair.size && gap < cold + 1e-9 * pair.size, "{gap} of {cold}");
        }
    });
}

/// The direction of the widest gap against the nearest points, from starts up to 0.1 rad off.
#[test]
fn ellipsoids_are_as_far_apart_as_by_the_search() {
    let mut random = Random(12);
    let mut compared = 0;
    for _ in 0..20_000 {
        let ellipsoid = |random: &mut Random| {
            let axes = Vec3::from_fn(|_, _| random.log(0.2, 1.0));
            Shape::superellipsoid(axes, [1.0, 1.0], random.log(1e-3, 0.2)).unwrap().parts[0].core.clone()
        };
        let (a, b) = (ellipsoid(&mut random), ellipsoid(&mut random));
        let placement = place(&random.rotation(), random.log(0.5, 2.0), random.direction());
        let pair = Pair::new(a, b, placement).at_distance(random.log(1e-4, 1.0));
        let mut simplex = Simplex::default();
        let Separation::Apart { .. } = pair.query(&mut simplex) else { continue };
        let motion = random.log(1e-8, 0.1);
        let moved = pair.moved(&mut random, motion);
        let (warm, cold) = (moved.query(&mut simplex), moved.query(&mut Simplex::default()));
        assert!(moved.certify(&warm) < 1e-13);
        let (
            Separation::Apart { distance: d, normal: n, .. },
            Separation::Apart { distance: e, normal: m, .. },
        ) = (warm, cold)
        else {
            continue;
        };
        assert!((d - e).abs() < 1e-13 * moved.size && (n - m).norm() < 1e-5, "{d} {e}, {n} {m}");
        compared += 1;
    }
    assert!(compared > 5_000, "{compared}");
}
