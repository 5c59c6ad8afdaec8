//! What a coupling lets particles carry stays with them on their way through ranks.

use crate::common::{Scene, lattice, law, setup};
use grains_geometry::{Shape, Vec3};
use grains_testing::on_ranks;

/// Grains that fly through a periodic box so that all of them change ranks and places in memory several times.
#[test]
fn cargo_travels_with_its_particle() {
    let mut setup = setup([0.02; 3], [true; 3], vec![Shape::sphere(0.5e-3).unwrap()], law(false));
    setup.parameters.gravity = Vec3::zeros();
    let particles = lattice([1e-3; 3], [19e-3; 3], 3e-3, 1, 10.0);
    let scene = Scene { setup, particles };
    for ranks in [[1, 1, 1], [2, 1, 1], [2, 2, 2]] {
        let moved = on_ranks(ranks.iter().product(), |transport| {
            use grains_domain::Transport;
            let mut dem = scene.start(ranks, transport.rank());
            dem.particles.carry();
            let owned = dem.particles.owned;
            for i in 0..owned {
                let id = dem.particles.ids[i] as f64;
                dem.particles.cargo[i] = std::array::from_fn(|k| 1e3 * id + k as f64);
            }
            let first: Vec<u64> = dem.particles.ids[..owned].to_vec();
            (0..400).for_each(|_| dem.step(&transport).unwrap());
            assert_eq!(dem.particles.cargo.len(), dem.particles.owned);
            for (id, cargo) in dem.particles.ids.iter().zip(&dem.particles.cargo) {
                assert_eq!(*cargo, std::array::from_fn(|k| 1e3 * *id as f64 + k as f64));
            }
            dem.particles.ids[..dem.particles.owned].iter().filter(|id| !first.contains(id)).count()
        });
        assert!(ranks == [1, 1, 1] || moved.iter().sum::<usize>() > 20, "{moved:?}");
    }
}
