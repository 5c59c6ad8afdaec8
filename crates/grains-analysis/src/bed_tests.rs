use super::*;
use crate::layers::layers;
use crate::synthetic::{ball, case, lattice, particles};
use clap::Parser;
use grains_domain::SerialTransport;
use std::ops::Range;

#[derive(Parser)]
struct Arguments {
    #[command(flatten)]
    volume: ControlVolume,
}

fn options(words: &[&str]) -> ControlVolume {
    Arguments::try_parse_from([&["test"], words].concat()).unwrap_or_else(|e| panic!("{e}")).volume
}

/// Velocity (m/s), pressure (Pa) and void fraction (-) at a point.
type State = (Vec3, f64, f64);

/// A bed of touching balls of diameter 0.1 from 0.5 to 3.5 along an axis of a box from 0 to 4, other edges 0.3, in a fluid of
/// density 2 and viscosity 0.25 with fields of the point, on cells of unequal width.
fn bed(axis: usize, words: &[&str], at: impl Fn(Vec3) -> State) -> Result<Bed, RunError> {
    bed_between((axis, ""), words, at)
}

/// That bed between some `[[wall]]`s.
fn bed_between(
    (axis, walls): (usize, &str),
    words: &[&str],
    at: impl Fn(Vec3) -> State,
) -> Result<Bed, RunError> {
    let extent = |a: usize| if a == axis { 4.0 } else { 0.3 };
    let upper = [0, 1, 2].map(extent);
    let cells = [0, 1, 2].map(|a| if a == axis { 100 } else { 6 });
    let [x, y, z] = cells;
    let more = format!(
        "[fluid]\ndensity = 2\nviscosity = 0.25\ncells = [{x}, {y}, {z}]\nresolved = {{ motion = \"fixed\" }}\n{walls}"
    );
    let case = case([0.0; 3], upper, [0, 1, 2].map(|a| a != axis), &more);
    // Cells grow by a factor of three from end to end of the axis.
    let node = |a: usize, k: usize| {
        let s = k as f64 / cells[a] as f64;
        if a == axis { upper[a] * (0.5 * s + 0.5 * s * s) } else { upper[a] * s }
    };
    let nodes = [0, 1, 2].map(|a| (0..=cells[a]).map(|k| node(a, k)).collect::<Vec<f64>>());
    let middle = |a: usize, k: usize| 0.5 * (nodes[a][k] + nodes[a][k + 1]);
    let read = |field: &str, range: Range<usize>| {
        let mut values = Vec::new();
        for k in range {
            for j in 0..y {
                for i in 0..x {
                    let (u, p, void) = at(Vec3::new(middle(0, i), middle(1, j), middle(2, k)));
                    match field {
                        "velocity" => values.extend(u.iter()),
                        "pressure" => values.push(p),
                        _ => values.push(void),
                    }
                }
            }
        }
        Ok(values)
    };
    let mut number = [3; 3];
    number[axis] = 30;
    let mut lower = Vec3::zeros();
    lower[axis] = 0.5;
    let snapshot = particles(lattice(lower, number, 0.1));
    let (shapes, transport) = (ball(0.05), SerialTransport);
    let areas = [shapes[0].area()];
    let sums = |axis: usize| layers(&nodes, axis, read, &transport);
    measure(&case, (&snapshot, &shapes, &areas), &options(words), sums, &transport)
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} is not {b}");
}

#[test]
fn a_uniform_bed_has_its_exact_numbers_along_any_axis_either_way() {
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let (void, speed, slope) = (0.4, 0.1, 7.0);
            let found =
                bed(axis, &[], |x| (Vec3::ith(axis, sign * speed), 3.0 - sign * slope * x[axis], void));
            let found = found.unwrap();
            assert_eq!(found.axis, axis);
            // Two diameters below and three above are left out.
            close(found.ends[0], 0.7);
            close(found.ends[1], 3.2);
            close(found.void_fraction, void);
            close(found.pressure_gradient, slope);
            close(found.superficial_velocity, void * speed);
            close(found.tortuosity, 1.0);
            close(found.diameter, 0.1);
            close(found.sphericity, 1.0);
            close(found.reynolds, 2.0 * 0.04 * 0.1 / 0.25);
            close(found.ergun_reynolds(), found.reynolds / 0.6);
            close(found.alpha, slope * 0.064 * 0.01 / (0.36 * 0.25 * 0.04));
        }
    }
}

#[test]
fn the_section_is_that_of_the_walls_that_bound_the_fluid() {
    // Two cells of six at either side of x are solid.
    let wall = |name: &str, fluid: &str| {
        format!(
            "[[wall]]\nname = \"{name}\"\nmaterial = \"glass\"\nkind = \"box\"\nlower = [0.1, -1, -1]\nupper = [0.2, 1, 5]\n{fluid}"
        )
    };
    let duct = wall("duct", "fluid = \"inside\"\n");
    let uniform = |x: Vec3| (Vec3::z() * 0.1, -x.z, if (0.1..0.2).contains(&x.x) { 0.4 } else { 0.0 });
    let found = bed_between((2, &duct), &[], uniform).unwrap();
    close(found.void_fraction, 0.4);
    close(found.superficial_velocity, 0.04);
    close(found.layers[3].void_fraction(), 0.4);
    // To the fluid there is no wall that stops particles alone.
    close(bed_between((2, &wall("duct", "")), &[], uniform).unwrap().void_fraction, 0.4 / 3.0);
}

#[test]
fn a_flow_that_winds_has_its_tortuosity_and_clear_layers_give_the_velocity() {
    // In the bed half of the fluid goes straight on, half of it slanted at 3:4; around the bed there is only fluid.
    let found = bed(2, &["--crop", "0.1m"], |x| {
        let is_bed = (0.5..3.5).contains(&x.z);
        let slanted = if is_bed && x.y > 0.15 { 0.75 } else { 0.0 };
        let void = if is_bed { 0.5 } else { 1.0 };
        (Vec3::new(slanted, 0.0, 1.0) * 0.2, -x.z, void)
    })
    .unwrap();
    close(found.ends[0], 0.6);
    close(found.ends[1], 3.4);
    close(found.tortuosity, 1.125);
    close(found.superficial_velocity, 0.2);
    let layer = &found.layers[50];
    close(layer.flux.z / layer.volume, 0.1);
}

#[test]
fn the_pressure_is_that_of_the_fluid() {
    // What stands in the bodies' cells does not count.
    let found = bed(1, &["--crop", "0.1m"], |x| {
        let is_solid = x.x < 0.1;
        (Vec3::y(), if is_solid { 1e6 } else { 5.0 - 2.0 * x.y }, if is_solid { 0.0 } else { 1.0 })
    })
    .unwrap();
    close(found.pressure_gradient, 2.0);
    close(found.void_fraction, 2.0 / 3.0);
}

#[test]
fn what_has_no_answer_is_said() {
    let uniform = |_| (Vec3::x(), 0.0, 0.5);
    let refused = |words: &[&str], at: &dyn Fn(Vec3) -> State| bed(2, words, at).unwrap_err().message;
    assert!(refused(&["--axis", "z", "--crop", "20,20"], &uniform).contains("--crop: nothing is left"));
    assert!(refused(&[], &uniform).contains("periodic along x"));
    assert!(refused(&[], &|_| (Vec3::zeros(), 0.0, 0.5)).contains("at rest"));
}
