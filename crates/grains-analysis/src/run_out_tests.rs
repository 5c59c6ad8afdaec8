use super::*;
use crate::synthetic::{ball, case, lattice, particles};
use clap::Parser;
use grains_domain::SerialTransport;
use std::f64::consts::PI;

#[derive(Parser)]
struct Arguments {
    #[command(flatten)]
    options: Options,
}

fn options(words: &[&str]) -> Options {
    Arguments::try_parse_from([&["test", "run"], words].concat()).unwrap_or_else(|e| panic!("{e}")).options
}

/// Touching balls of diameter 0.01 under a plane that falls from 0.3 at the wall to 0 at 0.6, and one far away.
fn wedge(mirrored: bool) -> Snapshot {
    let sites = lattice(Vec3::zeros(), [60, 10, 30], 0.01);
    let mut pile: Vec<Vec3> = sites.into_iter().filter(|x| x.z < 0.3 - 0.5 * x.x).collect();
    pile.push(Vec3::new(0.9, 0.05, 0.005));
    // Off the borders of the slices, where rounding would decide.
    pile.iter_mut().for_each(|x| x.x += 0.0003);
    if mirrored {
        pile.iter_mut().for_each(|x| x.x = 1.0 - x.x);
    }
    particles(pile)
}

#[test]
fn a_wedge_has_its_length_and_height() {
    let case = case([0.0; 3], [1.0, 0.1, 1.0], [false, true, false], "");
    for (direction, mirrored) in [("+x", false), ("-x", true)] {
        let (snapshot, shapes) = (wedge(mirrored), ball(0.005));
        let options = options(&["--direction", direction, "--packing", &format!("{}", PI / 6.0)]);
        let channel = channel(&case, (&snapshot, &shapes), &options, &SerialTransport).unwrap();
        assert!((channel.diameter - 0.01).abs() < 1e-12 && (channel.width - 0.1).abs() < 1e-12);
        let found = measure(&channel, (&snapshot, &shapes), &SerialTransport);
        // The lowest layer ends where the plane is half a diameter high.
        for length in found.lengths {
            assert!((length - 0.59).abs() < 0.011, "{direction}: {length}");
        }
        assert!((found.tip - 0.9003).abs() < 1e-12);
        let inside = found.layer.iter().filter(|p| p[0] > 0.01 && p[0] < 0.57);
        assert!(inside.clone().count() > 1000);
        assert!(inside.clone().all(|p| (p[1] - PI / 6.0).abs() < 1e-9), "a full layer");
        for &[x, height, top] in found.profile.iter().filter(|p| p[0] < 0.57) {
            let plane = 0.3 - 0.5 * x;
            assert!((height - plane).abs() < 0.007, "{x}: {height}, {plane}");
            assert!((top - plane).abs() < 0.011, "{x}: {top}, {plane}");
        }
        assert!((found.height() - 0.295).abs() < 0.006, "{}", found.height());
    }
}

#[test]
fn the_front_is_where_the_layer_first_thins_out() {
    let layer = [[0.1, 0.0], [0.2, 0.5], [0.3, 0.11], [0.4, 0.1], [0.5, 0.4], [0.6, 0.0]];
    assert_eq!(front(&layer, 0.1), 0.4);
    assert_eq!(front(&layer, 0.05), 0.6);
    assert_eq!(front(&layer, 0.7), 0.0);
    assert_eq!(front(&layer[..3], 0.1), 0.3);
    assert_eq!("-y".parse::<Direction>(), Ok(Direction(1, -1.0)));
    assert!("up".parse::<Direction>().is_err());
}

#[test]
fn options_that_make_no_channel_are_refused() {
    let case = case([0.0; 3], [1.0, 0.1, 1.0], [false, true, false], "");
    for (words, part) in [
        (&["--direction", "+z"][..], "along gravity"),
        (&["--origin", "2"], "--origin"),
        (&["--width", "0"], "--width"),
        (&["--length", "0"], "--length"),
        (&["--diameter", "1e-12"], "too fine"),
    ] {
        let error =
            channel(&case, (&wedge(false), &ball(0.005)), &options(words), &SerialTransport).unwrap_err();
        assert!(error.message.contains(part), "{}", error.message);
    }
    let nobody = channel(&case, (&particles(vec![]), &ball(0.005)), &options(&[]), &SerialTransport);
    assert!(nobody.unwrap_err().message.contains("particles"));
}
