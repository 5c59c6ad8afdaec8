//! The operator ∇·2μD on fields of any kind.

use super::{Bingham, Regularisation, Rheology, Turbulence, TurbulenceModel, ViscosityLaw, Wale};
use crate::momentum::RowPlace;
use crate::{Axis, Flow, FlowSetup, Grid};
use grains_domain::SerialTransport;

type Vector = [f64; 3];

/// Bounded law of a smooth viscosity.
fn law() -> Rheology {
    Rheology::Bingham(Bingham {
        yield_stress: 3.0,
        plastic_viscosity: 1.0,
        regularisation: Regularisation::Papanastasiou { exponent: 0.4 },
    })
}

/// A periodic flow, stretched along x and z.
fn periodic(n: usize, velocity: &dyn Fn(Vector) -> Vector) -> Flow {
    use std::f64::consts::TAU;
    let wavy = |n: usize, amplitude: f64| {
        let at = |k: usize| k as f64 / n as f64;
        Axis::stretched((0..=n).map(|k| at(k) + amplitude * (TAU * at(k)).sin() / TAU).collect(), true)
    };
    let grid = Grid::new([wavy(n, 0.3), wavy(n, 0.0), wavy(n, -0.2)]).unwrap();
    let law = Some(ViscosityLaw::Rheology(law()));
    let setup = FlowSetup { viscosity_law: law, ..FlowSetup::new(grid, 1.0, 1.0) };
    let mut flow = Flow::new(setup, &SerialTransport).unwrap();
    flow.initialise(velocity, |_| 0.0, &SerialTransport);
    flow
}

/// Viscous terms (m/s²) of all faces of a component, with the volumes of their control volumes, positions and velocities.
fn viscous(flow: &mut Flow, component: usize) -> Vec<(f64, f64, Vector, f64)> {
    flow.set_viscosity();
    let [nx, ny, nz] = flow.layout().cells;
    let mut all = Vec::new();
    let (mut advective, mut viscous) = (vec![0.0; nx], vec![0.0; nx]);
    for k in 0..nz {
        for j in 0..ny {
            flow.explicit_terms().row(RowPlace { component, j, k }, &mut advective, &mut viscous);
            for (i, value) in viscous.iter().enumerate() {
                let cell = [i, j, k].map(|m| m as isize);
                let at: Vector = std::array::from_fn(|a| {
                    let axis = flow.setup.grid.axis(a);
                    if a == component { axis.node(cell[a] + 1) } else { axis.centre(cell[a]) }
                });
                let width = |a: usize| {
                    let axis = flow.setup.grid.axis(a);
                    match a == component {
                        true => axis.centre(cell[a] + 1) - axis.centre(cell[a]),
                        false => axis.width(cell[a]),
                    }
                };
                let u = flow.state.velocity.component(component)[flow.layout().row(j, k) + i];
                all.push((*value, width(0) * width(1) * width(2), at, u));
            }
        }
    }
    all
}

/// Numbers that look random.
fn scattered([x, y, z]: Vector) -> Vector {
    [0.0, 1.0, 2.0].map(|c| {
        let s = (x * 127.1 + y * 311.7 + z * 74.7 + c * 29.3).sin() * 43758.5453;
        s - s.floor() - 0.5
    })
}

#[test]
fn stresses_keep_momentum_and_take_energy() {
    let mut flow = periodic(7, &|x| scattered(x.map(|x| x.rem_euclid(1.0 - 1e-12))));
    let mut power = 0.0;
    for component in 0..3 {
        let (mut sum, mut size) = (0.0, 0.0);
        for (value, volume, _, u) in viscous(&mut flow, component) {
            sum += value * volume;
            size += (value * volume).abs();
            power += value * volume * u;
        }
        assert!(sum.abs() < 1e-13 * size, "{component}: {sum:e} of {size:e}");
    }
    assert!(power < 0.0, "{power}");
}

/// A turning fluid has no stress.
#[test]
fn the_operator_is_of_order_two() {
    use std::f64::consts::TAU;
    let velocity = |[x, y, z]: Vector| {
        let [x, y, z] = [x, y, z].map(|x| TAU * x);
        [z.sin() + 0.5 * y.cos(), x.sin() + 0.7 * z.cos(), 0.4 * y.sin() + x.cos()]
    };
    let gradient = |f: &dyn Fn(Vector) -> Vector, x: Vector, step: f64| -> [Vector; 3] {
        let shifted = |b: usize, d: f64| {
            let mut at = x;
            at[b] += d;
            f(at)
        };
        let pairs: [[Vector; 2]; 3] = std::array::from_fn(|b| [shifted(b, -step), shifted(b, step)]);
        std::array::from_fn(|a| std::array::from_fn(|b| (pairs[b][1][a] - pairs[b][0][a]) / (2.0 * step)))
    };
    let stress = |x: Vector| -> [Vector; 3] {
        let g = gradient(&velocity, x, 1e-4);
        let square: f64 = (0..9).map(|m| 0.5 * (g[m / 3][m % 3] + g[m % 3][m / 3]).powi(2)).sum();
        let viscosity = law().viscosity(square.sqrt());
        std::array::from_fn(|a| std::array::from_fn(|b| viscosity * (g[a][b] + g[b][a])))
    };
    for component in 0..3 {
        let errors = [20, 40].map(|n| {
            let mut flow = periodic(n, &velocity);
            let all = viscous(&mut flow, component);
            let squares = all.iter().map(|(value, volume, at, _)| {
                let row = |x: Vector| stress(x)[component];
                let exact: f64 = (0..3).map(|b| gradient(&row, *at, 1e-3)[b][b]).sum();
                volume * (value - exact).powi(2)
            });
            squares.sum::<f64>().sqrt()
        });
        let order = (errors[0] / errors[1]).log2();
        println!("{component}: {errors:?} order {order:.2}");
        assert!(order > 1.8, "{component}: {errors:?}, order {order}");
    }
}

/// Nothing in plane shear, something in eddies, and the third power of the distance beside a wall.
#[test]
fn wale_falls_with_the_cube_of_the_distance_from_a_wall() {
    let model = Wale { constant: 0.325 };
    assert_eq!(model.eddy_viscosity(&[[0.0, 5.0, 0.0], [0.0; 3], [0.0; 3]], 0.1, 1.0), 0.0);
    // u = y + x y, w = 2 y + z y, and v = −y² by continuity.
    let near = |y: f64| [[y, 1.0 + 0.3, 0.0], [0.0, -2.0 * y, 0.0], [0.0, 2.0 + 0.4, y]];
    let [far, close] = [1e-2, 5e-3].map(|y| model.eddy_viscosity(&near(y), 0.1, y));
    let power = (far / close).log2();
    assert!((power - 3.0).abs() < 0.05, "{power}");
    assert!(Turbulence::Wale(Wale { constant: 0.0 }).check().is_err());
}
