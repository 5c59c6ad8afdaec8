//! The separating axis test of boxes against their distance.

use crate::gjk_common::{Kind, Pair, Random};
use grains_geometry::obb::boxes_apart;
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
fn true_is_a_proof_and_false_without_margin_means_meeting() {
    let mut random = Random(1);
    let mut apart = 0;
    for _ in 0..PAIRS {
        let (pair, a, b) = random_pair(&mut random);
        let exact = pair.distance(&mut Simplex::default());
        let margin = pair.size * random.log(1e-4, 1.0);
        let proven = boxes_apart(&a, &b, &pair.placement, margin);
        assert!(!proven || exact > margin * (1.0 - 1e-12), "gap {exact} against {margin}");
        let met = !boxes_apart(&a, &b, &pair.placement, 0.0);
        // Edges parallel to 1e-6 are no axis; the faces they make are within that of one.
        assert!(!met || exact < 3e-6 * pair.size, "gap {exact} at size {}", pair.size);
        apart += usize::from(proven);
    }
    assert!(apart > PAIRS / 20);
}
