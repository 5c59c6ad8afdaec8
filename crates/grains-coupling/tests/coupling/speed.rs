//! Time per call, by hand: `cargo test --release -p grains-coupling --test coupling speed -- --ignored --nocapture`.

use grains_coupling::{
    DragLaw, End, Flow, Fluid, GridAxis, Kernel, Layout, ShapeFactors, ShapeProfile, Site, SiteWeights,
    Stencil,
};
use grains_geometry::{Lobes, RegularSolid, Shape, Vec3};
use std::hint::black_box;
use std::time::Instant;

const CALLS: usize = 200_000;

fn time(name: &str, mut call: impl FnMut(usize) -> f64) {
    let start = Instant::now();
    let sum: f64 = (0..CALLS).map(&mut call).sum();
    let each = start.elapsed().as_secs_f64() / CALLS as f64 * 1e9;
    println!("{name}: {each:.1} ns ({sum:.3e})");
}

#[test]
#[ignore = "measures, asserts nothing"]
fn calls() {
    let shape = ShapeFactors { sphericity: 0.8, crosswise: 0.7, lengthwise: 0.9 };
    let fluid = Fluid { density: 1.2, viscosity: 1.8e-5 };
    for &law in DragLaw::ALL {
        time(&format!("{law:?}, drag and slope"), |k| {
            let flow = Flow { reynolds: 1.0 + 1e-3 * k as f64, void_fraction: 0.5, shape };
            law.growing_coefficient(&fluid, 1e-3, black_box(&flow)).value
        });
    }
    let lobes = Shape::lobes(Lobes::with_area_fraction(3, 1.0, 0.75).unwrap(), 4.0, 0.02).unwrap();
    for body in [
        Shape::cuboid(Vec3::new(1.0, 2.0, 3.0), 0.02).unwrap(),
        Shape::cylinder(1.0, 3.0, 0.02).unwrap(),
        Shape::superellipsoid(Vec3::new(1.0, 2.0, 3.0), [1.0; 2], 0.02).unwrap(),
        Shape::regular(RegularSolid::Icosahedron, 1.0, 0.02).unwrap(),
        Shape::superellipsoid(Vec3::new(1.0, 2.0, 3.0), [0.5; 2], 0.02).unwrap(),
        lobes,
    ] {
        let start = Instant::now();
        let profile = ShapeProfile::new(&body).unwrap();
        println!("{} measured in {:.3} s", body.name, start.elapsed().as_secs_f64());
        time(&format!("{}, shape factors", body.name), |k| {
            let (z, x) = (1e-4 * k as f64).sin_cos();
            let factors = profile.factors(black_box(&Vec3::new(0.6 * x, 0.8 * x, z)));
            factors.crosswise + factors.lengthwise
        });
    }
    kernels();
}

fn kernels() {
    for (kernel, cell) in [(Kernel::Cube, 3.0), (Kernel::Smooth { half_width: 2.291_287_847_477_92 }, 1.5)] {
        let axes: [GridAxis; 3] = std::array::from_fn(|a| {
            GridAxis::new(a, (0..=40).map(|k| f64::from(k) * cell).collect(), [End::Boundary; 2]).unwrap()
        });
        let place =
            |k: usize| Vec3::new(10.0 + 1e-4 * k as f64, 20.0 + 7e-5 * k as f64, 15.0 + 3e-5 * k as f64);
        let (mut stencil, mut weights) = (Stencil::default(), SiteWeights::default());
        let (layout, mut field) = (Layout::packed([41; 3]), vec![0.3; 41 * 41 * 41]);
        let put = |k: usize, stencil: &mut Stencil| stencil.place(&kernel, &axes, &place(k), 1.0).unwrap();
        time(&format!("{kernel:?}, place"), |k| {
            put(k, &mut stencil);
            f64::from(u8::from(stencil.has_boundary_faces(0)))
        });
        time(&format!("{kernel:?}, place and velocity"), |k| {
            put(k, &mut stencil);
            let of_axis = |a| {
                stencil.weigh(Site::Faces(a), &layout, &mut weights);
                weights.means([&field])[0]
            };
            (0..3).map(of_axis).sum()
        });
        time(&format!("{kernel:?}, place and deposit on cells"), |k| {
            put(k, &mut stencil);
            stencil.weigh(Site::Cells, &layout, &mut weights);
            weights.share([1e-9], [&mut field]);
            0.0
        });
    }
}
