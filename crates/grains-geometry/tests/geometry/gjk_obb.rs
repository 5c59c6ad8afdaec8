//! The separating axis test of boxes against their distance.

use crate::gjk_common::{Kind, Pair, Random};
use grains_geometry::obb::axis_of_widest_gap;
use grains_geometry::{Core, Simplex, Vec3};

const PAIRS: usize = if cfg!(debug_assertions) { 50_000 } else { 500_000 };

fn random_pair(random: &mut Random) -> (Pair, Vec3, Vec3) {
    let (aligned, size) = (random.below(2) == 0, random.log(1e-6, 1.0));
    let pair = Pair::random(random, [Kind::Box; 2], 100.0, aligned, size);
    let (Core::Box(a), Core::Box(b)) = (&pair.a, &pair.b) else { unreachable!() };
    let (a, b) = (*a, *b);
    (pair, a, b)
}

#[test]
fn no_axis_is_a_proof_and_one_without_margin_means_meeting() {
    let mut random = Random(1);
    let mut apart = 0;
    for _ in 0..PAIRS {
        let (pair, a, b) = random_pair(&mut random);
        let exact = pair.distance(&mut Simplex::default());
        let margin = pair.size * random.log(1e-4, 1.0);
        let proven = axis_of_widest_gap(&a, &b, &pair.placement, margin).is_none();
        assert!(!proven || exact > margin * (1.0 - 1e-12), "gap {exact} against {margin}");
        let met = axis_of_widest_gap(&a, &b, &pair.placement, 0.0).is_some();
        // Edges parallel to 1e-6 are no axis; the faces they make are within that of one.
        assert!(!met || exact < 3e-6 * pair.size, "gap {exact} at size {}", pair.size);
        apart += usize::from(proven);
    }
    assert!(apart > PAIRS / 20);
}

/// Along the axis the boxes are as far apart as their support functions say, no farther than they are, and not much less: the 15 axes miss
/// corners before corners alone, which are up to √3 farther apart than the planes of a face see.
#[test]
fn boxes_are_apart_along_the_axis_of_the_widest_gap() {
    let mut random = Random(2);
    let (mut apart, mut met) = (0, 0);
    for _ in 0..PAIRS / 5 {
        let (pair, a, b) = random_pair(&mut random);
        let exact = pair.distance(&mut Simplex::default());
        let axis = axis_of_widest_gap(&a, &b, &pair.placement, f64::INFINITY).unwrap().normalize();
        let along = axis.dot(&pair.placement.translation);
        let gap =
            along - pair.a.support_value(&axis) - pair.b.support_value(&pair.placement.matrix.tr_mul(&-axis));
        assert!(along >= 0.0 && gap <= exact + 1e-12 * pair.size, "gap {gap} of {exact}");
        if exact > 1e-5 * pair.size {
            assert!(gap > 0.5 * exact, "gap {gap} of {exact} at size {}", pair.size);
            apart += 1;
        } else {
            met += 1;
        }
    }
    assert!(apart.min(met) > PAIRS / 100, "{apart} {met}");
}
