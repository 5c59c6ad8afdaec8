use super::*;
use crate::region::Triple;
use crate::synthetic::{ball, case, lattice, particles};
use crate::{ranking, region};
use clap::Parser;
use grains_domain::SerialTransport;
use grains_geometry::Vec3;
use std::f64::consts::PI;

#[derive(Parser)]
struct Arguments {
    #[command(flatten)]
    options: Options,
}

fn options(words: &[&str]) -> Options {
    Arguments::try_parse_from([&["test", "run"], words].concat()).unwrap_or_else(|e| panic!("{e}")).options
}

/// A column of touching balls of diameter 0.1, three by three by forty, in a box of its size.
fn column() -> (Case, Snapshot, Vec<Shape>) {
    let walls = r#"
[[contact]]
between = ["glass", "wall"]
normal_stiffness = 1e5
restitution = 0.7
friction = 0.5
[[material]]
name = "wall"
[[wall]]
name = "floor"
material = "wall"
kind = "plane"
point = [0, 0, 0]
normal = [0, 0, 1]
"#;
    let case = case([0.0, 0.0, -1.0], [0.3, 0.3, 5.0], [true, true, false], walls);
    (case, particles(lattice(Vec3::zeros(), [3, 3, 40], 0.1)), ball(0.05))
}

#[test]
fn the_bed_is_found_cropped_and_measured() {
    let (case, snapshot, shapes) = column();
    let options = options(&["--cell", "0.0025", "--crop", "3", "--refine", "--bins", "34"]);
    let found = measure(&case, (&snapshot, &shapes), &options, &SerialTransport).unwrap();
    assert!((found.region.lower.z - 0.3).abs() < 1e-12 && (found.region.upper.z - 3.7).abs() < 1e-12);
    assert!((found.mean - (1.0 - PI / 6.0)).abs() < 1e-3, "{}", found.mean);
    assert!(found.error < 5e-3, "{}", found.error);
    // Every bin is a layer of balls.
    assert!(found.axial.iter().all(|p| (p[1] - found.mean).abs() < 1e-3), "{:?}", found.axial);
}

#[test]
fn ranking_agrees_with_counting() {
    let (case, snapshot, shapes) = column();
    let crop = region::RegionOptions { crop: "0".parse().ok(), ..Default::default() };
    let found = ranking::measure(&case, (&snapshot, &shapes), &crop, &SerialTransport).unwrap().unwrap();
    // The staircase of 40 steps is 1 - 1/40^2 times as steep as its line.
    let slope = 0.1 / 9.0 * (1.0 - 1.0 / 1600.0);
    assert!((found.fit.slope / slope - 1.0).abs() < 1e-4, "{} {slope}", found.fit.slope);
    assert!((found.void_fraction - (1.0 - PI / 6.0)).abs() < 1e-3, "{}", found.void_fraction);
}

#[test]
fn ranking_of_a_mixture_takes_volumes() {
    // Heights spread evenly, every other ball twice as large.
    let n = 2000;
    let position = |k: usize| Vec3::new(0.1, 0.1, 1e-3 * (k as f64 + 0.5));
    let mut snapshot = particles((0..n).map(position).collect());
    snapshot.scale = (0..n).map(|k| if k % 2 == 0 { 1.0 } else { 2.0 }).collect();
    let (case, shapes) = (column().0, ball(0.01));
    let found = ranking::measure(&case, (&snapshot, &shapes), &Default::default(), &SerialTransport)
        .unwrap()
        .unwrap();
    let wanted = 1.0 - 4.5 * shapes[0].volume / (0.09 * 1e-3);
    assert!((found.void_fraction - wanted).abs() < 1e-3 * (1.0 - wanted), "{} {wanted}", found.void_fraction);
}

#[test]
fn the_cross_section_of_a_tube_counts() {
    let (case, snapshot, shapes) = column();
    let tube =
        options(&["--cylinder", "0.15,0.15,0.14", "--cell", "0.004", "--crop", "5", "--radial", "axis"]);
    let found = measure(&case, (&snapshot, &shapes), &tube, &SerialTransport).unwrap();
    assert!((found.region.cross_section() - PI * 0.14 * 0.14).abs() < 1e-12);
    assert_eq!(found.region.cylinder, Some(([0.15, 0.15], 0.14)));
    // On the axis are the middles of balls: half of the height of a ball's equator is solid.
    assert!(found.radial[0][1] < 0.05, "{:?}", found.radial[0]);
    assert!(found.radial.iter().all(|p| p[0] < 0.141 && p[1] <= 1.0));
}

#[test]
fn regions_that_make_no_sense_are_refused_with_the_option() {
    let (case, snapshot, shapes) = column();
    for (words, part) in [
        (&["--lower", "0,0,2", "--upper", "0.3,0.3,1"][..], "--lower"),
        (&["--upper", "0.3,0.3,9"], "leaves the domain"),
        (&["--cylinder", "0.15,0.15,-1"], "--cylinder"),
        (&["--crop", "30"], "--crop"),
        (&["--cell", "0"], "--cell"),
        (&["--cell", "1e-9"], "--cell"),
    ] {
        let error = measure(&case, (&snapshot, &shapes), &options(words), &SerialTransport).unwrap_err();
        assert!(error.message.contains(part), "{words:?}: {}", error.message);
    }
    assert!("1,2".parse::<Triple>().is_err() && "1,2,x".parse::<Triple>().is_err());
    assert!("x".parse::<Crop>().is_err() && "-1".parse::<Crop>().is_err());
    assert!("10%,0.02m".parse::<Crop>().is_ok());
}

#[test]
fn a_standing_vessel_of_the_case_is_the_region() {
    let wall = r#"
[[contact]]
between = ["glass", "wall"]
normal_stiffness = 1e5
restitution = 0.7
friction = 0.5
[[material]]
name = "wall"
[[wall]]
name = "vessel"
material = "wall"
kind = "cylinder"
center = [0.5, 0.4, 1.0]
axis = [0, 0, 1]
radius = 0.3
height = 1.8
"#;
    let case = case([0.0; 3], [1.0, 1.0, 2.0], [false; 3], wall);
    let region = Region::chosen(&case, 0.0, &Default::default()).unwrap();
    assert_eq!(region.cylinder, Some(([0.5, 0.4], 0.3)));
    assert!((region.lower - Vec3::new(0.2, 0.1, 0.1)).norm() < 1e-12, "{region}");
    assert!((region.upper - Vec3::new(0.8, 0.7, 1.9)).norm() < 1e-12, "{region}");
    assert!(region.contains(&Vec3::new(0.5, 0.69, 1.0)) && !region.contains(&Vec3::new(0.75, 0.65, 1.0)));
}
