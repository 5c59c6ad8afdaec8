//! `analyse orientation`: how far a body axis points the same way in all particles.

use super::Common;
use super::picture::{Curve, Picture, Style};
use super::region::{Region, RegionOptions};
use super::report::{Report, Table, seconds};
use super::snapshots::{Snapshot, StoredRun};
use super::sums::{counts, exact_sums};
use grains_case::Case;
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_geometry::{Mat3, Shape, Vec3};
use grains_simulation::RunError;
use std::f64::consts::FRAC_PI_2;

/// Options of `analyse orientation`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Where particles count.
    pub region: RegionOptions,
    /// Axis of the body.
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t = BodyAxis::Main))]
    pub body_axis: BodyAxis,
    /// Only particles of this shape.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub shape: Option<String>,
    /// Bins of the angle to gravity, from 0 to 90 degrees.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 18, value_parser = clap::value_parser!(u64).range(1..=9000)))]
    pub bins: u64,
}

/// An axis of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum BodyAxis {
    /// The principal axis whose moment of inertia differs most from the other two: that of a cylinder, the
    /// long one of a rod, the short one of a plate.
    Main,
    /// The x axis of the shape as the case gives it.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

impl BodyAxis {
    /// The axis in the body frame of a shape (-).
    fn of(self, shape: &Shape) -> Vec3 {
        let user = |axis: Vec3| shape.user_to_body.0.inverse() * axis;
        match self {
            Self::X => user(Vec3::x()),
            Self::Y => user(Vec3::y()),
            Self::Z => user(Vec3::z()),
            Self::Main => {
                let moment = |a: usize| shape.inertia[a];
                let apart = |a: usize| {
                    let [b, c] = super::region::across(a);
                    (moment(a) - 0.5 * (moment(b) + moment(c))).abs()
                };
                // The last of equals: bodies of revolution have their axis along z.
                let main = (0..3).max_by(|&a, &b| apart(a).total_cmp(&apart(b))).unwrap_or(2);
                let mut axis = Vec3::zeros();
                axis[main] = 1.0;
                axis
            }
        }
    }
}

/// Order of the axes n of some particles.
#[derive(Clone, Debug)]
pub struct Found {
    /// Particles (-).
    pub particles: u64,
    /// Nematic tensor Q = ⟨3 n n − 1⟩/2.
    pub tensor: Mat3,
    /// Its eigenvalues, falling; the first is the order parameter: 1 aligned, 0 isotropic.
    pub eigenvalues: [f64; 3],
    /// Eigenvector of the first.
    pub director: Vec3,
    /// Order with respect to gravity, ⟨3 cos² − 1⟩/2: 1 along it, −1/2 across it.
    pub along_gravity: f64,
    /// Particles per bin of the angle to gravity from 0 to 90°.
    pub angles: Vec<u64>,
}

/// Order of this and all other ranks' axes with respect to a direction of unit length.
pub fn measure(axes: &[Vec3], gravity: &Vec3, bins: usize, transport: &impl Transport) -> Found {
    let mut number = [axes.len() as u64];
    transport.sum_counts(&mut number);
    let sums = exact_sums(transport, 7, |add| {
        for n in axes {
            let terms = [n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.x * n.z, n.y * n.z];
            terms.into_iter().enumerate().for_each(|(k, term)| add(k, term));
            add(6, n.dot(gravity).powi(2));
        }
    });
    let mean: Vec<f64> = sums.iter().map(|sum| sum / number[0] as f64).collect();
    let second = Mat3::new(mean[0], mean[3], mean[4], mean[3], mean[1], mean[5], mean[4], mean[5], mean[2]);
    let tensor = 1.5 * second - 0.5 * Mat3::identity();
    let (eigenvalues, directions) = sorted_eigen(&tensor);
    let bin = |n: &Vec3| {
        let angle = n.dot(gravity).abs().min(1.0).acos();
        ((angle / FRAC_PI_2 * bins as f64) as usize).min(bins - 1)
    };
    Found {
        particles: number[0],
        tensor,
        eigenvalues,
        director: directions,
        along_gravity: 1.5 * mean[6] - 0.5,
        angles: counts(transport, bins, axes.iter().map(bin)),
    }
}

/// Eigenvalues of a symmetric matrix, falling, and the eigenvector of the first.
fn sorted_eigen(tensor: &Mat3) -> ([f64; 3], Vec3) {
    if !tensor.iter().all(|x| x.is_finite()) {
        return ([f64::NAN; 3], Vec3::repeat(f64::NAN));
    }
    let eigen = tensor.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let mut director: Vec3 = eigen.eigenvectors.column(order[0]).into();
    // Both signs are right; take the one whose largest component is positive.
    if director[director.iamax()] < 0.0 {
        director = -director;
    }
    (order.map(|k| eigen.eigenvalues[k]), director)
}

/// Axes of this rank's particles in a region; spheres have none.
fn axes_of(
    case: &Case,
    shapes: &[Shape],
    snapshot: &Snapshot,
    (region, options): (&Region, &Options),
) -> Vec<Vec3> {
    let axes: Vec<Vec3> = shapes.iter().map(|shape| options.body_axis.of(shape)).collect();
    let wanted = options.shape.as_ref().and_then(|name| case.shape_index(name));
    (0..snapshot.len())
        .filter(|&i| !shapes[snapshot.shape[i]].is_sphere())
        .filter(|&i| wanted.is_none_or(|shape| shape == snapshot.shape[i]))
        .filter(|&i| options.region.is_empty() || region.contains(&snapshot.position[i]))
        .map(|i| snapshot.orientation[i] * axes[snapshot.shape[i]])
        .collect()
}

/// Order of the chosen states.
///
/// # Errors
/// Options that do not fit, only spheres, or a file that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    options: &Options,
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let (case, shapes) = (&run.case, &run.catalogue.shapes);
    check(case, shapes, options)?;
    let [mut table, mut angles] = tables();
    let mut report = Report::default();
    let bins = options.bins as usize;
    let width = 90.0 / bins as f64;
    for &state in states {
        let snapshot = run.read(transport, state, &[], "orientation")?;
        let region = Region::of_state(case, (&snapshot, shapes), &options.region, transport)?;
        let axes = axes_of(case, shapes, &snapshot, (&region, options));
        let found = measure(&axes, &down(case), bins, transport);
        let (time, q, e, d) = (snapshot.time, found.tensor, found.eigenvalues, found.director);
        let (n, along) = (found.particles as f64, found.along_gravity);
        let tensor = [q[(0, 0)], q[(1, 1)], q[(2, 2)], q[(0, 1)], q[(0, 2)], q[(1, 2)]];
        table.push([&[time, n, e[0], e[1], e[2], d.x, d.y, d.z, along], &tensor[..]].concat());
        for (k, &count) in found.angles.iter().enumerate() {
            let edge = |k: usize| (k as f64 * width).to_radians().cos();
            let isotropic = (edge(k) - edge(k + 1)) / width;
            angles.push(vec![time, (k as f64 + 0.5) * width, count as f64 / n / width, isotropic]);
        }
        report.lines.push(format!(
            "t = {}: order {:.4} about ({:.3}, {:.3}, {:.3}), {along:.4} along gravity; {} particles (without order they would show about {:.3})",
            seconds(time),
            e[0],
            d.x,
            d.y,
            d.z,
            found.particles,
            n.sqrt().recip()
        ));
    }
    let last = angles.rows[angles.rows.len() - bins..].to_vec();
    let column = |k: usize| last.iter().map(|row| [row[1], row[k]]).collect::<Vec<_>>();
    let curves = vec![
        Curve { label: "particles".into(), points: column(2), style: Style::Bars(0.95 * width) },
        Curve::line("without order", column(3)),
    ];
    let title =
        format!("Angle of the body axis to gravity, t = {}", seconds(run.time(states[states.len() - 1])));
    let axes = ["angle (degrees)", "density (1/degree)"];
    report.pictures.push(Picture::new("orientation-angles", title, axes, curves));
    report.tables.extend([table, angles]);
    Ok(report)
}

/// Tensor, eigenvalues and director of each state, and its histogram of angles.
fn tables() -> [Table; 2] {
    let names = [
        ("time", "s"),
        ("particles", "-"),
        ("order", "-"),
        ("eigenvalue_2", "-"),
        ("eigenvalue_3", "-"),
        ("director_x", "-"),
        ("director_y", "-"),
        ("director_z", "-"),
        ("order_along_gravity", "-"),
        ("q_xx", "-"),
        ("q_yy", "-"),
        ("q_zz", "-"),
        ("q_xy", "-"),
        ("q_xz", "-"),
        ("q_yz", "-"),
    ];
    let what = "Nematic tensor Q = <3 n n - 1>/2 of the body axis n, its eigenvalues (the first is the order parameter) and its first eigenvector.";
    let table = Table::new("orientation", what, &names);
    let what =
        "Density per degree of the angle between body axis and gravity, and that of axes without order.";
    let columns = [("time", "s"), ("angle", "deg"), ("density", "1/deg"), ("isotropic", "1/deg")];
    let angles = Table::new("orientation-angles", what, &columns);
    [table, angles]
}

/// Direction of gravity; along −z without gravity.
fn down(case: &Case) -> Vec3 {
    Vec3::from(case.gravity).try_normalize(0.0).unwrap_or(-Vec3::z())
}

fn check(case: &Case, shapes: &[Shape], options: &Options) -> Result<(), RunError> {
    let names = case.shapes.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join(", ");
    let wanted: Vec<&Shape> = match &options.shape {
        None => shapes.iter().collect(),
        Some(name) => match case.shape_index(name) {
            Some(index) => vec![&shapes[index]],
            None => {
                return Err(RunError::case(format!(
                    "--shape {name}: the case has no such shape; it has {names}"
                )));
            }
        },
    };
    if wanted.iter().all(|shape| shape.is_sphere()) {
        let message = "analyse orientation: spheres have no orientation; this needs a case with other shapes";
        return Err(RunError::case(message));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::turns;
    use grains_domain::SerialTransport;

    #[test]
    fn aligned_crossed_and_disordered_axes() {
        let down = -Vec3::z();
        let one = measure(&vec![Vec3::new(0.6, 0.0, -0.8); 10], &down, 18, &SerialTransport);
        assert!((one.eigenvalues[0] - 1.0).abs() < 1e-12 && (one.eigenvalues[2] + 0.5).abs() < 1e-12);
        assert!((one.director - Vec3::new(-0.6, 0.0, 0.8)).norm() < 1e-9, "{}", one.director);
        assert!((one.along_gravity - 0.5 * (3.0 * 0.64 - 1.0)).abs() < 1e-12);
        // acos 0.8 is 36.87 degrees.
        assert_eq!(one.angles.iter().position(|&n| n == 10), Some(7));
        let axes = [Vec3::x(), -Vec3::y(), Vec3::z()];
        let three = measure(&axes, &down, 18, &SerialTransport);
        assert!(three.tensor.norm() < 1e-12 && three.along_gravity.abs() < 1e-12);
        let plane = measure(&axes[..2], &down, 18, &SerialTransport);
        assert!((plane.along_gravity + 0.5).abs() < 1e-12 && (plane.eigenvalues[0] - 0.25).abs() < 1e-12);
        assert!(measure(&[], &down, 18, &SerialTransport).eigenvalues[0].is_nan());
    }

    #[test]
    fn the_main_axis_is_that_of_the_body() {
        for (shape, wanted) in [
            (Shape::cylinder(1.0, 5.0, 0.02).unwrap(), Vec3::z()),
            (Shape::cylinder(1.0, 0.2, 0.02).unwrap(), Vec3::z()),
            (Shape::cuboid(Vec3::new(5.0, 1.0, 1.1), 0.02).unwrap(), Vec3::x()),
            (Shape::cuboid(Vec3::new(4.0, 0.3, 4.0), 0.02).unwrap(), Vec3::y()),
        ] {
            // The user's frame is the body frame turned by `user_to_body`.
            let user = shape.user_to_body.0 * BodyAxis::Main.of(&shape);
            assert!(user.dot(&wanted).abs() > 1.0 - 1e-9, "{user}");
        }
        let rod = Shape::cuboid(Vec3::new(5.0, 1.0, 1.1), 0.02).unwrap();
        assert!((rod.user_to_body.0 * BodyAxis::Y.of(&rod) - Vec3::y()).norm() < 1e-12);
    }

    #[test]
    fn many_random_axes_show_no_order() {
        let axes: Vec<Vec3> = turns(4000).iter().map(|turn| turn * Vec3::x()).collect();
        let count = axes.len() as f64;
        let gravity = Vec3::new(0.0, 0.0, -1.0);
        let found = measure(&axes, &gravity, 9, &SerialTransport);
        assert_eq!(found.angles.iter().sum::<u64>() as f64, count);
        assert!(found.tensor.trace().abs() < 1e-12);
    }
}
