//! Kernels: exact sums, adjoint interpolation, walls, ranks.

use grains_coupling::{CouplingError, End, GridAxis, Kernel, Layout, MAX_CELLS, Site, SiteWeights, Stencil};
use grains_geometry::Vec3;
use std::f64::consts::PI;

/// Numbers in [0, 1) from a fixed sequence.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / 2f64.powi(53)
    }

    fn within(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.roll()
    }
}

fn uniform(axis: usize, lower: f64, upper: f64, cells: usize, end: End) -> GridAxis {
    let nodes = (0..=cells).map(|k| lower + (upper - lower) * k as f64 / cells as f64).collect();
    GridAxis::new(axis, nodes, [end; 2]).unwrap()
}

fn stretched(axis: usize, lower: f64, upper: f64, cells: usize, end: End) -> GridAxis {
    let at = |k: usize| {
        let t = 2.0 * k as f64 / cells as f64 - 1.0;
        lower + 0.5 * (upper - lower) * (1.0 + (1.2 * t).tanh() / 1.2f64.tanh())
    };
    GridAxis::new(axis, (0..=cells).map(at).collect(), [end; 2]).unwrap()
}

fn box_of(make: fn(usize, f64, f64, usize, End) -> GridAxis, cells: [usize; 3], end: End) -> [GridAxis; 3] {
    std::array::from_fn(|a| make(a, -0.01, 0.02, cells[a], end))
}

fn kernels() -> [Kernel; 4] {
    [
        Kernel::Cube,
        Kernel::Smooth { half_width: 2.291_287_847_477_92 },
        Kernel::Smooth { half_width: 0.5 },
        Kernel::Smooth { half_width: 4.0 },
    ]
}

fn counts(axes: &[GridAxis; 3], site: Site) -> [usize; 3] {
    std::array::from_fn(|a| {
        axes[a].cells() + usize::from(site == Site::Faces(a) || site == Site::InnerFaces(a))
    })
}

fn weights(stencil: &mut Stencil, site: Site, layout: &Layout) -> SiteWeights {
    let mut weights = SiteWeights::default();
    stencil.weigh(site, layout, &mut weights);
    weights
}

const SITES: [Site; 5] = [Site::Cells, Site::Faces(0), Site::Faces(1), Site::Faces(2), Site::InnerFaces(1)];

#[test]
fn weights_sum_up_to_one_anywhere() {
    let mut dice = Dice(1);
    let mut stencil = Stencil::default();
    let mut worst = 0.0f64;
    for axes in [
        box_of(uniform, [20, 30, 25], End::Boundary),
        box_of(stretched, [20, 30, 25], End::Boundary),
        box_of(uniform, [1, 7, 3], End::Boundary),
    ] {
        for kernel in kernels() {
            kernel.check(&axes, 1e-3).unwrap();
            for trial in 0..500 {
                // On walls and in corners too, and a little beyond.
                let place = |dice: &mut Dice| match trial % 5 {
                    0 => -0.01,
                    1 => 0.02 + 1e-6,
                    _ => dice.within(-0.01, 0.02),
                };
                let center = Vec3::new(place(&mut dice), dice.within(-0.01, 0.02), place(&mut dice));
                stencil.place(&kernel, &axes, &center, 1e-3).unwrap();
                for site in SITES {
                    let mut sum = 0.0;
                    let counts = counts(&axes, site);
                    weights(&mut stencil, site, &Layout::packed(counts)).for_each(|index, weight| {
                        assert!(weight >= 0.0 && (weight == 0.0 || index < counts.iter().product()));
                        sum += weight;
                    });
                    worst = worst.max((sum - 1.0).abs());
                }
            }
        }
    }
    println!("largest error of a sum of weights: {worst:e}");
    assert!(worst < 1e-14, "{worst:e}");
}

#[test]
fn a_thousand_particles_leave_exactly_their_volume() {
    let mut dice = Dice(7);
    let axes = box_of(stretched, [12, 14, 16], End::Boundary);
    let layout = Layout::packed(counts(&axes, Site::Cells));
    for kernel in kernels() {
        let mut solid = vec![0.0; 12 * 14 * 16];
        let (mut stencil, mut total) = (Stencil::default(), 0.0);
        for _ in 0..1000 {
            let diameter = dice.within(0.5e-3, 1e-3);
            let center = Vec3::from_fn(|_, _| dice.within(-0.01, 0.02));
            stencil.place(&kernel, &axes, &center, diameter).unwrap();
            let volume = PI / 6.0 * diameter.powi(3);
            weights(&mut stencil, Site::Cells, &layout).share([volume], [&mut solid]);
            total += volume;
        }
        let deposited: f64 = solid.iter().sum();
        assert!((deposited / total - 1.0).abs() < 1e-13, "{kernel:?}: {:e}", deposited / total - 1.0);
    }
}

#[test]
fn the_cube_is_cut_exactly() {
    // A cube of edge 0.8 about (1.1, 0.5, 0.5) on unit cells: x from 0.7 to 1.5, 3/8 of it in cell 0.
    let axes: [GridAxis; 3] = std::array::from_fn(|a| uniform(a, 0.0, 3.0, 3, End::Boundary));
    let diameter = 0.8 * (6.0 / PI).cbrt();
    let mut stencil = Stencil::default();
    stencil.place(&Kernel::Cube, &axes, &Vec3::new(1.1, 0.5, 0.5), diameter).unwrap();
    let mut shares = vec![0.0; 27];
    weights(&mut stencil, Site::Cells, &Layout::packed([3; 3])).share([1.0], [&mut shares]);
    assert!((shares[0] - 0.375).abs() < 1e-12 && (shares[1] - 0.625).abs() < 1e-12, "{shares:?}");
    assert!((Kernel::Cube.reach(diameter) - 0.4).abs() < 1e-15);
    // Beyond a wall at 0 the cube from −0.2 to 0.6 comes back.
    stencil.place(&Kernel::Cube, &axes, &Vec3::new(0.2, 1.5, 1.5), diameter).unwrap();
    let mut shares = vec![0.0; 27];
    weights(&mut stencil, Site::Cells, &Layout::packed([3; 3])).share([1.0], [&mut shares]);
    assert!((shares[13 - 1] - 1.0).abs() < 1e-12, "{shares:?}");
}

#[test]
fn a_smooth_kernel_has_its_shape_on_any_cells() {
    // Far from walls: mean at the particle, variance (half width)²/7 plus that of the cells, h²/12 for points.
    let half = 2.0;
    let kernel = Kernel::Smooth { half_width: half };
    for cells in [60, 100, 150] {
        let axes: [GridAxis; 3] = std::array::from_fn(|a| uniform(a, 0.0, 20.0, cells, End::Boundary));
        let h = 20.0 / cells as f64;
        let mut stencil = Stencil::default();
        stencil.place(&kernel, &axes, &Vec3::new(9.93, 10.31, 8.77), 1.0).unwrap();
        let (mut mean, mut square) = (0.0, 0.0);
        weights(&mut stencil, Site::Cells, &Layout::packed([cells; 3])).for_each(|index, weight| {
            let x = (index % cells) as f64 * h + 0.5 * h;
            mean += weight * x;
            square += weight * x * x;
        });
        let variance = square - mean * mean;
        assert!((mean - 9.93).abs() < 1e-3 * h, "{mean}");
        assert!((variance - half * half / 7.0 - h * h / 12.0).abs() < 1e-3, "{cells}: {variance}");
    }
}

#[test]
fn a_kernel_is_mirrored_at_a_wall() {
    let kernel = Kernel::Smooth { half_width: 3.0 };
    let wide: [GridAxis; 3] = std::array::from_fn(|a| uniform(a, -10.0, 10.0, 20, End::Boundary));
    let walled: [GridAxis; 3] = std::array::from_fn(|a| {
        uniform(a, if a == 0 { 0.0 } else { -10.0 }, 10.0, if a == 0 { 10 } else { 20 }, End::Boundary)
    });
    let center = Vec3::new(1.3, 0.2, 0.4);
    let (mut free, mut near) = (Stencil::default(), Stencil::default());
    free.place(&kernel, &wide, &center, 1.0).unwrap();
    near.place(&kernel, &walled, &center, 1.0).unwrap();
    let (mut all, mut half) = (vec![0.0; 8000], vec![0.0; 4000]);
    weights(&mut free, Site::Cells, &Layout::packed([20; 3])).share([1.0], [&mut all]);
    weights(&mut near, Site::Cells, &Layout::packed([10, 20, 20])).share([1.0], [&mut half]);
    for (n, share) in half.iter().enumerate() {
        let (i, row) = (n % 10, n / 10);
        let expected = all[row * 20 + 10 + i] + all[row * 20 + 9 - i];
        assert!((share - expected).abs() < 1e-15, "{i} {row}");
    }
}

#[test]
fn deposit_and_interpolation_are_adjoint() {
    let mut dice = Dice(3);
    let axes = box_of(stretched, [9, 11, 13], End::Boundary);
    for kernel in kernels() {
        for site in SITES {
            let layout = Layout::packed(counts(&axes, site));
            let length: usize = counts(&axes, site).iter().product();
            let field: Vec<f64> = (0..length).map(|_| dice.within(-1.0, 1.0)).collect();
            let mut stencil = Stencil::default();
            for _ in 0..20 {
                let center = Vec3::from_fn(|_, _| dice.within(-0.01, 0.02));
                stencil.place(&kernel, &axes, &center, 1e-3).unwrap();
                let amount = dice.within(1.0, 2.0);
                let mut shares = vec![0.0; length];
                weights(&mut stencil, site, &layout).share([amount], [&mut shares]);
                let left: f64 = shares.iter().zip(&field).map(|(s, f)| s * f).sum();
                let right = amount * weights(&mut stencil, site, &layout).means([&field])[0];
                assert!((left - right).abs() < 1e-14, "{left} {right}");
                let constant = vec![0.7; length];
                assert!((weights(&mut stencil, site, &layout).means([&constant])[0] - 0.7).abs() < 1e-14);
            }
        }
    }
}

/// What walls close takes nothing and is not read; the rest stays adjoint and of sum 1, whatever the weights were used for before.
#[test]
fn what_is_closed_takes_no_share() {
    let mut dice = Dice(4);
    let (mut stencil, mut reused) = (Stencil::default(), SiteWeights::default());
    for axes in [
        box_of(stretched, [9, 11, 13], End::Boundary),
        box_of(uniform, [1, 7, 3], End::Boundary),
        box_of(uniform, [6, 2, 5], End::Boundary),
    ] {
        for (kernel, site) in kernels().into_iter().flat_map(|kernel| SITES.map(|site| (kernel, site))) {
            let layout = Layout::packed(counts(&axes, site));
            let length: usize = counts(&axes, site).iter().product();
            for _ in 0..20 {
                let open: Vec<f64> = (0..length).map(|_| (2.0 * dice.roll() - 1.0).max(0.0)).collect();
                let field: Vec<f64> =
                    open.iter().map(|o| if *o > 0.0 { dice.within(-1.0, 1.0) } else { f64::NAN }).collect();
                let center = Vec3::from_fn(|_, _| dice.within(-0.01, 0.02));
                stencil.place(&kernel, &axes, &center, 1e-3).unwrap();
                stencil.weigh(site, &layout, &mut reused);
                let before = reused.clone();
                reused.restrict(&open);
                let mut shares = vec![0.0; length];
                reused.share([2.0], [&mut shares]);
                assert!((shares.iter().sum::<f64>() - 2.0).abs() < 1e-13);
                if before.means([&open])[0] == 0.0 {
                    before.for_each(|index, weight| {
                        assert!(weight == 0.0 || (shares[index] - 2.0 * weight).abs() < 1e-15);
                    });
                    continue;
                }
                let by_hand = |value: &dyn Fn(usize) -> f64| {
                    let mut sum = 0.0;
                    before.for_each(|index, w| {
                        if w > 0.0 && open[index] > 0.0 {
                            sum += w * open[index] * value(index);
                        }
                    });
                    sum
                };
                let mean = by_hand(&|index| field[index]) / by_hand(&|_| 1.0);
                assert!(
                    (reused.means([&field])[0] - mean).abs() < 1e-13,
                    "{} {mean}",
                    reused.means([&field])[0]
                );
                let adjoint: f64 =
                    shares.iter().zip(&field).filter(|(s, _)| **s > 0.0).map(|(s, f)| s * f).sum();
                assert!((adjoint - 2.0 * mean).abs() < 1e-13);
            }
        }
    }
}

#[test]
fn boundary_faces_take_no_share_of_the_velocity() {
    let axes = box_of(uniform, [5, 6, 7], End::Boundary);
    let mut dice = Dice(5);
    let mut stencil = Stencil::default();
    for kernel in kernels() {
        for _ in 0..200 {
            let center = Vec3::from_fn(|_, _| dice.within(-0.01, 0.02));
            stencil.place(&kernel, &axes, &center, 1e-3).unwrap();
            for a in 0..3 {
                let counts = counts(&axes, Site::InnerFaces(a));
                weights(&mut stencil, Site::InnerFaces(a), &Layout::packed(counts)).for_each(
                    |index, weight| {
                        let place = [
                            index % counts[0],
                            index / counts[0] % counts[1],
                            index / (counts[0] * counts[1]),
                        ];
                        assert!(weight == 0.0 || (place[a] > 0 && place[a] + 1 < counts[a]));
                    },
                );
            }
        }
    }
}

/// A face's share of the particles' volume is the mean of those of its cells, so their void fractions belong together.
#[test]
fn the_solid_of_a_face_is_half_that_of_its_cells() {
    let axes = box_of(stretched, [8, 8, 8], End::Boundary);
    let kernel = Kernel::Smooth { half_width: 2.0 };
    let mut dice = Dice(11);
    let (mut cells, mut faces) = (vec![0.0; 512], vec![0.0; 8 * 8 * 9]);
    let mut stencil = Stencil::default();
    for _ in 0..100 {
        let center = Vec3::from_fn(|_, _| dice.within(-0.01, 0.02));
        stencil.place(&kernel, &axes, &center, 1e-3).unwrap();
        weights(&mut stencil, Site::Cells, &Layout::packed([8; 3])).share([1.0], [&mut cells]);
        weights(&mut stencil, Site::Faces(1), &Layout::packed([8, 9, 8])).share([1.0], [&mut faces]);
    }
    for (k, i) in (0..8).flat_map(|k| (0..8).map(move |i| (k, i))) {
        for j in 2..7 {
            let cell = |j: usize| cells[(k * 8 + j) * 8 + i];
            let face = faces[(k * 9 + j) * 8 + i];
            assert!((face - 0.5 * (cell(j - 1) + cell(j))).abs() < 1e-14);
        }
    }
}

/// Two ranks with two halo cells each, the sum over their common cells, against one rank.
#[test]
fn halos_added_up_give_the_field_of_one_rank() {
    let (cells, cut, halo) = (16, 8, 3);
    let h = 1.0 / cells as f64;
    let part = |from: usize, to: usize, ends: [End; 2]| {
        GridAxis::new(0, (from..=to).map(|k| k as f64 * h).collect(), ends).unwrap()
    };
    let others = |a: usize| uniform(a, 0.0, 1.0, 4, End::Boundary);
    let whole = [part(0, cells, [End::Boundary; 2]), others(1), others(2)];
    let low = [part(0, cut + halo, [End::Boundary, End::Halo]), others(1), others(2)];
    let high = [part(cut - halo, cells, [End::Halo, End::Boundary]), others(1), others(2)];
    let kernel = Kernel::Smooth { half_width: 2.0 };
    let diameter = 0.06;
    assert!(kernel.halo(diameter, 0.06, h) <= halo);
    let mut dice = Dice(9);
    let mut sums = [vec![0.0; 16 * 16], vec![0.0; 11 * 16], vec![0.0; 11 * 16]];
    let mut stencil = Stencil::default();
    let mut add = |axes: &[GridAxis; 3], center: &Vec3, sum: &mut [f64]| {
        stencil.place(&kernel, axes, center, diameter).unwrap();
        weights(&mut stencil, Site::Cells, &Layout::packed(counts(axes, Site::Cells))).share([1.0], [sum]);
    };
    for _ in 0..300 {
        let center = Vec3::from_fn(|_, _| dice.roll());
        add(&whole, &center, &mut sums[0]);
        // Owners may have wandered a little beyond the cut.
        let owner = usize::from(center.x + dice.within(-0.05, 0.05) > 0.5);
        add([&low, &high][owner], &center, &mut sums[1 + owner]);
    }
    for (row, i) in (0..16).flat_map(|row| (0..16).map(move |i| (row, i))) {
        let left = if i < 11 { sums[1][row * 11 + i] } else { 0.0 };
        let right = if i >= 5 { sums[2][row * 11 + i - 5] } else { 0.0 };
        assert!((left + right - sums[0][row * 16 + i]).abs() < 1e-13);
    }
}

#[test]
fn what_does_not_fit_is_refused_with_the_remedy() {
    let fine = box_of(uniform, [300, 300, 300], End::Boundary);
    let error = Kernel::Smooth { half_width: 4.0 }.check(&fine, 1e-3).unwrap_err();
    assert!(matches!(error, CouplingError::TooManyCells { axis: 'x', max: MAX_CELLS, .. }), "{error}");
    let open = box_of(uniform, [30, 30, 30], End::Halo);
    let outside = Vec3::new(0.0, 0.0199, 0.0);
    let error = Stencil::default().place(&Kernel::Cube, &open, &outside, 1e-3).unwrap_err();
    assert!(error.to_string().contains("at y = 1.99"), "{error}");
    let lost = Stencil::default().place(&Kernel::Cube, &fine, &Vec3::new(f64::NAN, 0.0, 0.0), 1e-3);
    assert!(lost.is_err());
    assert!(
        GridAxis::new(2, vec![0.0, 1.0, 1.0], [End::Halo; 2]).unwrap_err().to_string().contains("along z")
    );
    assert!(
        Kernel::Smooth { half_width: 0.1 }.check(&fine, 1e-3).unwrap_err().to_string().contains("[0.5, 20]")
    );
}
