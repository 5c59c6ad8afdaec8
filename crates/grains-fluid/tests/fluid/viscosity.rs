//! Fluids whose viscosity varies, against closed profiles, manufactured flows and themselves on other ranks.

use crate::common::{difference, joined, order, partition, piece, refined_channel};
use grains_domain::{SerialTransport, Transport};
use grains_fluid::{
    Axis, Bingham, Boundaries, Condition, Drive, Faces, Flow, FlowSetup, Grid, HerschelBulkley, Immersed,
    MixtureModel, PowerLaw, Regularisation, Rheology, Side, Smagorinsky, Turbulence, ViscosityLaw, Wale,
};
use grains_testing::on_ranks;

/// Half height (m) and pressure gradient (Pa/m) of the channels.
const HALF: f64 = 0.5;
const GRADIENT: f64 = 8.0;

fn bingham(yield_stress: f64, exponent: f64) -> Rheology {
    Rheology::Bingham(Bingham {
        yield_stress,
        plastic_viscosity: 1.0,
        regularisation: Regularisation::Papanastasiou { exponent },
    })
}

fn herschel_bulkley(yield_stress: f64, index: f64, exponent: f64) -> Rheology {
    Rheology::HerschelBulkley(HerschelBulkley {
        yield_stress,
        consistency: 1.0,
        index,
        regularisation: Regularisation::Papanastasiou { exponent },
    })
}

fn power_law(index: f64) -> Rheology {
    Rheology::PowerLaw(PowerLaw { consistency: 1.0, index, max_viscosity: Some(1e4) })
}

/// Steady velocity (m/s) at a distance from the middle, of τ = τ_y + γ̇ⁿ: u = n/(n + 1) Gᵐ ((H − y_p)^(m + 1) −
/// (|y| − y_p)₊^(m + 1)), m = 1/n, y_p = τ_y/G (Bird, Dai and Yarusso 1983).
fn profile(yield_stress: f64, index: f64, y: f64) -> f64 {
    let (plug, power) = (yield_stress / GRADIENT, 1.0 / index + 1.0);
    let part = |y: f64| (y - plug).max(0.0).powf(power);
    index / (index + 1.0) * GRADIENT.powf(1.0 / index) * (part(HALF) - part(y.abs()))
}

/// Steady channel flow on `n` cells across y: velocities (m/s) by places (m) from the middle.
fn channel(rheology: Rheology, n: usize, steps: usize) -> Vec<[f64; 2]> {
    let axes = [
        Axis::uniform(0.0, 100.0, 2, true),
        Axis::uniform(-HALF, HALF, n, false),
        Axis::uniform(0.0, 1.0, 1, true),
    ];
    let drive = [Drive::PressureGradient(-GRADIENT), Drive::None, Drive::None];
    let grid = Grid::new(axes).unwrap();
    let law = Some(ViscosityLaw::Rheology(rheology));
    let setup = FlowSetup { drive, viscosity_law: law, ..FlowSetup::new(grid, 1.0, 1.0) };
    let mut flow = Flow::new(setup, &SerialTransport).unwrap();
    for _ in 0..steps {
        flow.step(0.5, &SerialTransport).unwrap();
    }
    let axis = flow.setup.grid.axis(1);
    (0..n as isize).map(|j| [axis.centre(j), flow.state.velocity.x.at(0, j, 0)]).collect()
}

/// Mean square difference from the closed profile over the largest velocity.
fn channel_error(index: f64, n: usize) -> f64 {
    let found = channel(power_law(index), n, 200);
    let squares = found.iter().map(|[y, u]| (u - profile(0.0, index, *y)).powi(2));
    (squares.sum::<f64>() / n as f64).sqrt() / profile(0.0, index, 0.0)
}

#[test]
fn power_law_fluids_flow_through_a_channel_at_order_two() {
    for index in [0.5, 0.8, 1.5] {
        let [coarse, fine] = [32, 64].map(|n| channel_error(index, n));
        let found = order(coarse, fine, 2.0);
        println!("n {index}: {coarse:.2e}, {fine:.2e}, order {found:.2}");
        assert!(fine < 1e-3 && found > 1.8, "n {index}: {coarse:.2e}, {fine:.2e}, order {found:.2}");
    }
}

/// Plug and profile to 1 %; what the regularisation lets creep is what it says.
#[test]
fn yield_stress_fluids_flow_through_a_channel_as_a_plug() {
    for (rheology, stress, index) in [
        (bingham(1.0, 1000.0), 1.0, 1.0),
        (bingham(2.5, 1000.0), 2.5, 1.0),
        (herschel_bulkley(1.0, 0.6, 1000.0), 1.0, 0.6),
        (herschel_bulkley(1.0, 1.3, 1000.0), 1.0, 1.3),
    ] {
        let found = channel(rheology, 48, 400);
        let largest = profile(stress, index, 0.0);
        let errors = found.iter().map(|[y, u]| (u - profile(stress, index, *y)).abs());
        let error = errors.fold(0.0, f64::max) / largest;
        println!("{rheology:?}: {error:.2e} of {largest:.3}");
        assert!(error < 0.01, "{rheology:?}: {error:.2e} of {largest}");
        // Within the plug the fluid shears no faster than it creeps under its yield stress.
        let plug = stress / GRADIENT;
        for pair in found.windows(2).filter(|pair| pair.iter().all(|[y, _]| y.abs() < plug)) {
            let rate = (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
            assert!(rate.abs() <= 1.001 * rheology.creep_rate(), "{rate} of {}", rheology.creep_rate());
        }
    }
}

/// Below its yield stress the fluid creeps, no faster than by the rate of that stress over the half height.
#[test]
fn below_the_yield_stress_nothing_flows() {
    for regularisation in
        [Regularisation::Papanastasiou { exponent: 1e4 }, Regularisation::BiViscosity { max_viscosity: 1e4 }]
    {
        let law = Bingham { yield_stress: 1.05 * GRADIENT * HALF, plastic_viscosity: 1.0, regularisation };
        let rheology = Rheology::Bingham(law);
        let fastest = channel(rheology, 16, 100).iter().map(|[_, u]| u.abs()).fold(0.0, f64::max);
        assert!(fastest <= rheology.creep_rate() * HALF, "{fastest}");
        assert!(fastest < 2e-3 * profile(0.0, 1.0, 0.0), "{fastest}");
    }
}

type Vector = [f64; 3];

/// ∂f_a/∂x_b by central differences.
fn gradient(f: &dyn Fn(Vector) -> Vector, x: Vector, step: f64) -> [Vector; 3] {
    let mut out = [[0.0; 3]; 3];
    for b in 0..3 {
        let [low, high] = [-step, step].map(|d| {
            let mut at = x;
            at[b] += d;
            f(at)
        });
        (0..3).for_each(|a| out[a][b] = (high[a] - low[a]) / (2.0 * step));
    }
    out
}

/// 2 μ D at a point.
fn stress(rheology: &Rheology, velocity: &dyn Fn(Vector) -> Vector, x: Vector) -> [Vector; 3] {
    let g = gradient(velocity, x, 1e-4);
    let pairs = (0..3).flat_map(|a| (0..3).map(move |b| (a, b)));
    let rate: f64 = pairs.map(|(a, b)| 0.5 * (g[a][b] + g[b][a]).powi(2)).sum();
    let viscosity = rheology.viscosity(rate.sqrt());
    std::array::from_fn(|a| std::array::from_fn(|b| viscosity * (g[a][b] + g[b][a])))
}

/// The force that makes a steady flow of a velocity without pressure: u·∇u − ∇·τ.
fn manufactured_force(rheology: &Rheology, velocity: &dyn Fn(Vector) -> Vector, x: Vector) -> Vector {
    let (u, g) = (velocity(x), gradient(velocity, x, 1e-4));
    std::array::from_fn(|a| {
        let row = |x: Vector| stress(rheology, velocity, x)[a];
        let divergence: f64 = (0..3).map(|b| gradient(&row, x, 1e-3)[b][b]).sum();
        (0..3).map(|b| u[b] * g[a][b]).sum::<f64>() - divergence
    })
}

/// Mean square error of a steady flow between walls on n × n cells, of the manufactured one.
fn manufactured_error(n: usize, stretching: f64) -> f64 {
    use std::f64::consts::PI;
    let rheology = herschel_bulkley(1.0, 1.0, 0.5);
    let velocity = |[x, y, _]: Vector| {
        let (sx, sy) = ((PI * x).sin(), (PI * y).sin());
        [sx * sx * (2.0 * PI * y).sin(), -(2.0 * PI * x).sin() * sy * sy, 0.0]
    };
    let axis = || match stretching > 0.0 {
        true => Axis::clustered(0.0, 1.0, n, stretching),
        false => Axis::uniform(0.0, 1.0, n, false),
    };
    let grid = Grid::new([axis(), axis(), Axis::uniform(0.0, 1.0, 1, true)]).unwrap();
    let law = Some(ViscosityLaw::Rheology(rheology));
    let mut flow =
        Flow::new(FlowSetup { viscosity_law: law, ..FlowSetup::new(grid, 1.0, 1.0) }, &SerialTransport)
            .unwrap();
    flow.initialise(velocity, |_| 0.0, &SerialTransport);
    let exact = flow.state.velocity.clone();
    let mut immersed = Immersed::new(flow.layout());
    let grid = flow.setup.grid.clone();
    for k in 0..n as isize {
        for j in 0..n as isize {
            let (x, y) = (grid.axis(0), grid.axis(1));
            let force = |at| manufactured_force(&rheology, &velocity, at);
            immersed.force.x.set(j, k, 0, force([x.node(j + 1), y.centre(k), 0.0])[0]);
            immersed.force.y.set(j, k, 0, force([x.centre(j), y.node(k + 1), 0.0])[1]);
        }
    }
    flow.immersed = Some(immersed);
    for _ in 0..250 {
        flow.step(4e-3, &SerialTransport).unwrap();
    }
    mean_square(&flow.state.velocity, &exact, &grid)
}

fn mean_square(found: &Faces, exact: &Faces, grid: &Grid) -> f64 {
    let [nx, ny, _] = grid.cells().map(|n| n as isize);
    let mut sum = 0.0;
    for j in 0..ny {
        for i in 0..nx {
            let area = grid.axis(0).width(i) * grid.axis(1).width(j);
            sum += area * (found.x.at(i, j, 0) - exact.x.at(i, j, 0)).powi(2);
            sum += area * (found.y.at(i, j, 0) - exact.y.at(i, j, 0)).powi(2);
        }
    }
    sum.sqrt()
}

#[test]
fn a_manufactured_flow_is_of_order_two() {
    for stretching in [0.0, 1.2] {
        let [coarse, fine] = [12, 24].map(|n| manufactured_error(n, stretching));
        let found = order(coarse, fine, 2.0);
        println!("stretching {stretching}: {coarse:.2e}, {fine:.2e}, order {found:.2}");
        assert!(found > 1.8 && fine < 0.02, "{stretching}: {coarse:.2e}, {fine:.2e}, order {found:.2}");
    }
}

/// Whatever the viscosity does, a large step does not blow up, and a stirred box comes to rest.
#[test]
fn large_steps_of_uneven_viscosity_are_stable() {
    for (rheology, dt) in [(bingham(5.0, 1e3), 0.05), (bingham(0.1, 1e5), 1.0), (power_law(0.3), 0.2)] {
        let grid = Grid::uniform([0.0; 3], [1.0; 3], [10, 12, 8], [false, false, true]).unwrap();
        let law = Some(ViscosityLaw::Rheology(rheology));
        let setup = FlowSetup { viscosity_law: law, ..FlowSetup::new(grid, 1.0, 1.0) };
        let mut flow = Flow::new(setup, &SerialTransport).unwrap();
        let wave = |x: f64, y: f64, z: f64| 0.1 * (9.0 * x + 1.0).sin() * (7.0 * y).cos() * (6.3 * z).sin();
        let start = |[x, y, z]: Vector| [wave(x, y, z), wave(y, z, x), wave(z, x, y)];
        flow.initialise(start, |_| 0.0, &SerialTransport);
        let mut energy = flow.kinetic_energy(&SerialTransport);
        let first = energy;
        for _ in 0..60 {
            flow.step(dt, &SerialTransport).unwrap();
            energy = flow.kinetic_energy(&SerialTransport);
            assert!(energy <= first, "{rheology:?}: {energy:e} of {first:e}");
        }
        println!("{rheology:?}: {energy:.2e} of {first:.2e}");
        assert!(energy < 0.5 * first, "{rheology:?}: {energy:e} of {first:e}");
    }
}

/// Velocity and pressure after some steps on so many ranks.
fn run(setup: &FlowSetup, ranks: [usize; 3]) -> Vec<Vec<f64>> {
    let results = on_ranks(ranks.iter().product(), |transport| {
        let own = partition(&setup.grid, ranks, transport.rank());
        let mut flow = Flow::new(FlowSetup { partition: own, ..setup.clone() }, &transport).unwrap();
        let wave =
            |x: f64, y: f64, z: f64| 0.3 * (6.0 * x + 1.0).sin() * (5.0 * y).cos() * (4.0 * z + 0.5).sin();
        flow.initialise(|[x, y, z]| [wave(x, y, z), wave(y, z, x), wave(z, x, y)], |[x, ..]| x, &transport);
        for _ in 0..5 {
            flow.step(0.01, &transport).unwrap();
        }
        let viscosity = flow.dynamic_viscosity();
        let (layout, first) = (flow.layout(), flow.first_cell());
        let [u, v, w] = flow.state.velocity.components();
        [u, v, w, flow.state.pressure.data(), viscosity.data()].map(|data| piece(data, layout, first))
    });
    (0..5).map(|field| joined(results.iter().map(|r| r[field].clone()).collect())).collect()
}

const LAWS: [ViscosityLaw; 4] = [
    ViscosityLaw::Rheology(Rheology::Bingham(Bingham {
        yield_stress: 0.1,
        plastic_viscosity: 0.02,
        regularisation: Regularisation::Papanastasiou { exponent: 10.0 },
    })),
    ViscosityLaw::Rheology(Rheology::PowerLaw(PowerLaw {
        consistency: 0.03,
        index: 0.7,
        max_viscosity: Some(1.0),
    })),
    ViscosityLaw::Turbulence(Turbulence::Smagorinsky(Smagorinsky { constant: 0.17 })),
    ViscosityLaw::Turbulence(Turbulence::Wale(Wale { constant: 0.5 })),
];

/// Periodic, stretched, with a moving wall; in a box with inlet and outlet; among particles.
#[test]
fn any_number_of_ranks_gives_the_same_flow() {
    let stretched = refined_channel(Axis::uniform(0.0, 1.0, 8, false));
    let lid = Condition::Wall { velocity: [1.0, 0.0, 0.0] };
    let channel = FlowSetup {
        boundaries: Boundaries::default().with(2, Side::High, lid).with(1, Side::Low, Condition::Symmetry),
        drive: [Drive::MeanVelocity(0.5), Drive::None, Drive::None],
        ..FlowSetup::new(stretched, 1.0, 0.02)
    };
    let grid = Grid::uniform([0.0; 3], [1.0, 1.0, 1.5], [8, 8, 12], [false, true, false]).unwrap();
    let inlet = Condition::Inlet {
        profile: grains_fluid::Profile::Function(std::sync::Arc::new(|[x, ..], t| {
            [0.1 * t, 0.1, 0.5 + x * t]
        })),
    };
    let boundaries = Boundaries::default().with(2, Side::Low, inlet).with(
        2,
        Side::High,
        Condition::Outlet { pressure: 1.0 },
    );
    let open = FlowSetup { boundaries, ..FlowSetup::new(grid, 1.2, 0.02) };
    let bed = FlowSetup { mixture: Some(MixtureModel::A), ..open.clone() };
    for (number, setup) in [channel, open, bed].into_iter().enumerate() {
        for law in LAWS {
            let setup = FlowSetup { viscosity_law: Some(law), ..setup.clone() };
            let serial = run(&setup, [1; 3]);
            for ranks in [[2, 1, 1], [1, 2, 2]] {
                let split = run(&setup, ranks);
                for (name, (a, b)) in ["u", "v", "w", "p", "mu"].iter().zip(serial.iter().zip(&split)) {
                    let error = difference(a, b);
                    assert!(error < 1e-9, "{number} {law:?} {ranks:?} {name}: {error:.2e}");
                }
            }
        }
    }
}

/// A law whose viscosity is constant makes the flow of a constant viscosity.
#[test]
fn a_constant_viscosity_by_a_law_is_that_viscosity() {
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [12, 10, 8], [false; 3]).unwrap();
    let lid = Condition::Wall { velocity: [1.0, 0.0, 0.3] };
    let boundaries = Boundaries::default().with(1, Side::High, lid);
    let plain = FlowSetup { boundaries, ..FlowSetup::new(grid, 1.0, 0.1) };
    let law = Rheology::PowerLaw(PowerLaw { consistency: 0.1, index: 1.0, max_viscosity: None });
    let by_law = FlowSetup { viscosity_law: Some(ViscosityLaw::Rheology(law)), ..plain.clone() };
    let [a, b] = [plain, by_law].map(|setup| {
        let mut flow = Flow::new(setup, &SerialTransport).unwrap();
        for _ in 0..400 {
            flow.step(0.02, &SerialTransport).unwrap();
        }
        let [u, v, w] = flow.state.velocity.components();
        [u, v, w].map(|data| joined(vec![piece(data, flow.layout(), [0; 3])]))
    });
    for (axis, (a, b)) in a.iter().zip(&b).enumerate() {
        let error = difference(a, b);
        println!("{axis}: {error:.1e}");
        assert!(error < 1e-9, "{axis}: {error:e}");
    }
}
