//! Penetration depths.

mod gjk_common;

use gjk_common::{KINDS, Kind, Pair, Random};
use grains_geometry::epa::penetration;
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{Simplex, Placement};

#[test]
fn stats() {
    let n: usize = std::env::var("N").map_or(2000, |n| n.parse().unwrap());
    let mut random = Random(1);
    for (i, ka) in KINDS.into_iter().enumerate() {
        for kb in &KINDS[i..] {
            for aligned in [false, true] {
                for slender in [1.0, 100.0] {
                    let (mut worst, mut errors, mut meets) = (0.0f64, 0, 0);
                    let (mut low, mut neg) = (0.0f64, 0.0f64);
                    let mut werr = String::new();
                    let t = std::time::Instant::now();
                    let mut el = 0.0;
                    for _ in 0..n {
                        let size = random.log(1e-6, 1.0);
                        let pair = Pair::random(&mut random, [ka, *kb], slender, aligned, size);
                        let mut simplex = Simplex::default();
                        if !matches!(distance(&pair.a, &pair.b, &pair.placement, f64::INFINITY, &mut simplex), Ok(Separation::Meeting)) {
                            continue;
                        }
                        meets += 1;
                        let s = t.elapsed().as_secs_f64();
                        let r = penetration(&pair.a, &pair.b, &pair.placement, &simplex);
                        el += t.elapsed().as_secs_f64() - s;
                        match r {
                            Err(e) => { errors += 1; werr = format!("{:e} {}", e.gap / pair.size, e.iterations); }
                            Ok(p) => {
                                neg = neg.min(p.depth / pair.size);
                                let moved = Pair::new(pair.a.clone(), pair.b.clone(), Placement { matrix: pair.placement.matrix, translation: pair.placement.translation + p.normal * p.depth });
                                worst = worst.max(match moved.query(&mut Simplex::default()) {
                                    Separation::Apart { distance, .. } => distance / pair.size,
                                    _ => 0.0,
                                });
                                worst = worst.max(-moved.lower_bound(&p.normal) / pair.size);
                                for _ in 0..20 {
                                    let d = random.direction();
                                    low = low.max((p.depth + pair.lower_bound(&d)) / pair.size);
                                    let d = (p.normal + d * random.log(1e-6, 1.0)).normalize();
                                    low = low.max((p.depth + pair.lower_bound(&d)) / pair.size);
                                }
                            }
                        }
                    }
                    if meets > 0 { println!("{ka:?}-{kb:?} aligned {aligned} slender {slender}: worst {worst:.1e} excess {low:.1e} neg {neg:.1e} meets {meets} errors {errors} {werr} us {:.1}", el*1e6/meets as f64); }
                }
            }
        }
    }
}
