//! Inlets on discs, annuli and polygons: their flow is that of their area, wherever their edges lie among the cells.

use grains_domain::SerialTransport as SERIAL;
use grains_fluid::{
    Axis, Boundaries, BoxFace, Clearance, Condition, Flow, FlowRate, FlowSetup, Grid, MixtureModel, Outline,
    Patch, Profile, Side,
};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Random numbers in [0, 1), the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / 2.0_f64.powi(53)
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// A disc, an annulus or a polygon within the unit square about its middle, and its area.
    fn outline(&mut self, kind: usize) -> (Outline, f64) {
        let center = [0; 3].map(|_| self.within(0.4, 0.6));
        let radius = if kind.is_multiple_of(4) { self.within(0.01, 0.06) } else { self.within(0.1, 0.39) };
        let inner_radius = if kind % 2 == 1 { radius * self.within(0.1, 0.95) } else { 0.0 };
        if !kind.is_multiple_of(3) {
            let disc = Outline::Disc { center, radius, inner_radius };
            return (disc, PI * (radius * radius - inner_radius * inner_radius));
        }
        // A star is no convex polygon; its corners lie on the face, whatever its axis.
        let count = 3 + kind % 6;
        let mut area = 0.0;
        let radii: Vec<f64> = (0..count).map(|_| radius * self.within(0.3, 1.0)).collect();
        let angle = TAU / count as f64;
        (0..count).for_each(|k| area += 0.5 * radii[k] * radii[(k + 1) % count] * angle.sin());
        let corners = (0..count).map(|k| {
            let (sin, cos) = (angle * k as f64 + 0.3).sin_cos();
            [0.5 + radii[k] * cos, 0.5 + radii[k] * sin]
        });
        let corners: Vec<[f64; 2]> = corners.collect();
        (Outline::Polygon { corners: corners.iter().map(|[x, y]| [*x, *y, 0.0]).collect() }, area)
    }
}

/// Puts the corners of a polygon along x and y on a face normal to an axis.
fn on_face(outline: Outline, axis: usize) -> Outline {
    let [first, second] = [[1, 2], [0, 2], [0, 1]][axis];
    match outline {
        Outline::Polygon { corners } => {
            let placed = |[x, y, _]: [f64; 3]| {
                let mut at = [7.0; 3];
                (at[first], at[second]) = (x, y);
                at
            };
            Outline::Polygon { corners: corners.into_iter().map(placed).collect() }
        }
        other => other,
    }
}

fn inwards(face: BoxFace, speed: f64) -> [f64; 3] {
    let mut velocity = [0.0; 3];
    velocity[face.axis] = if face.side == Side::Low { speed } else { -speed };
    velocity
}

/// A box of 1 m with inlets on one face, and the opposite one an outlet.
fn flow(face: BoxFace, is_stretched: bool, patches: Vec<Patch>) -> Flow {
    let line = |n: usize| match is_stretched {
        true => Axis::clustered(0.0, 1.0, n, 1.5),
        false => Axis::uniform(0.0, 1.0, n, false),
    };
    let grid = Grid::new([line(9), line(12), line(10)]).unwrap();
    let side = if face.side == Side::Low { Side::High } else { Side::Low };
    let mut boundaries = Boundaries::default().with(face.axis, side, Condition::Outlet { pressure: 0.0 });
    boundaries.patches = patches;
    Flow::new(FlowSetup { boundaries, ..FlowSetup::new(grid, 1.0, 0.01) }, &SERIAL).unwrap()
}

/// Flow into the box through a face, and out of it through the opposite one.
fn flows(flow: &Flow, face: BoxFace) -> [f64; 2] {
    let last = flow.setup.grid.cells()[face.axis];
    let (sign, nodes) = if face.side == Side::Low { (1.0, [0, last]) } else { (-1.0, [last, 0]) };
    nodes.map(|node| sign * flow.flow_rate(face.axis, node, &SERIAL))
}

#[test]
fn what_flows_in_is_velocity_times_area() {
    let mut random = Random(3);
    for trial in 0..72 {
        let face = BoxFace { axis: trial % 3, side: if trial % 2 == 0 { Side::Low } else { Side::High } };
        let (outline, area) = random.outline(trial / 2);
        let outline = on_face(outline, face.axis);
        assert!((outline.area(face.axis) / area - 1.0).abs() < 1e-12);
        let (speed, rate) = (random.within(0.5, 1.5), random.within(-0.1, 0.1));
        let is_polygon = matches!(outline, Outline::Polygon { .. });
        let velocity = inwards(face, speed);
        let (profile, wanted) = match trial % 5 {
            0 => (Profile::Uniform(velocity), speed * area),
            1 => (Profile::Function(Arc::new(move |_, _| velocity)), speed * area),
            2 if !is_polygon => (Profile::Parabolic { mean: speed }, speed * area),
            kind => {
                let is_parabolic = kind == 3 && !is_polygon;
                (Profile::FlowRate { rate: FlowRate::Constant(rate), is_parabolic }, rate)
            }
        };
        let name = format!("{trial}: {profile:?} through {outline:?}");
        let inlet = Patch { face, outline, condition: Condition::Inlet { profile } };
        let mut flow = flow(face, trial % 4 == 0, vec![inlet]);
        let [entering, _] = flows(&flow, face);
        assert!((entering / wanted - 1.0).abs() < 1e-12, "{name}: {entering} for {wanted}");
        (0..2).for_each(|_| {
            let _ = flow.step(1e-3, &SERIAL).unwrap();
        });
        let [entering, leaving] = flows(&flow, face);
        assert!((entering / wanted - 1.0).abs() < 1e-12, "{name}: {entering} for {wanted}");
        assert!((leaving / wanted - 1.0).abs() < 1e-9, "{name}: {leaving} leaves");
    }
}

#[test]
fn a_flow_rate_follows_its_function() {
    let face = BoxFace { axis: 1, side: Side::High };
    let outline = Outline::Disc { center: [0.47, 0.0, 0.55], radius: 0.31, inner_radius: 0.1 };
    let rate = FlowRate::Function(Arc::new(|time: f64| 0.02 * (1.0 + (30.0 * time).sin())));
    let profile = Profile::FlowRate { rate: rate.clone(), is_parabolic: true };
    let mut flow = flow(face, true, vec![Patch { face, outline, condition: Condition::Inlet { profile } }]);
    for _ in 0..5 {
        flow.step(0.01, &SERIAL).unwrap();
        let wanted = rate.at(flow.state.time);
        let [entering, leaving] = flows(&flow, face);
        assert!((entering / wanted - 1.0).abs() < 1e-12 && (leaving / wanted - 1.0).abs() < 1e-9);
    }
}

/// Normal velocities through the cells of a face.
fn velocities(flow: &Flow, face: BoxFace) -> Vec<f64> {
    let (layout, field) = (flow.layout(), flow.state.velocity.component(face.axis));
    let end = if face.side == Side::Low { -1 } else { layout.cells[face.axis] as isize - 1 };
    let [n, m] = [[1, 2], [0, 2], [0, 1]][face.axis].map(|t| layout.cells[t] as isize);
    let place = |i: isize, j: isize| match face.axis {
        0 => layout.index(end, i, j),
        1 => layout.index(i, end, j),
        _ => layout.index(i, j, end),
    };
    (0..m).flat_map(|j| (0..n).map(move |i| (i, j))).map(|(i, j)| field[place(i, j)]).collect()
}

/// Two ways to the same inlet let the same flow through every cell.
#[test]
fn parts_make_the_whole() {
    let mut random = Random(9);
    for trial in 0..30 {
        let face = BoxFace { axis: trial % 3, side: if trial % 2 == 0 { Side::Low } else { Side::High } };
        let condition = Condition::Inlet { profile: Profile::Uniform(inwards(face, 0.7)) };
        let inlet = |outline: Outline| Patch { face, outline, condition: condition.clone() };
        let center = [0; 3].map(|_| random.within(0.3, 0.7));
        let (radius, inner) = (random.within(0.2, 0.45), random.within(0.1, 0.19));
        let disc = |radius, inner_radius| Outline::Disc { center, radius, inner_radius };
        let ends: [[f64; 2]; 2] =
            [[random.within(0.0, 0.4), random.within(0.6, 1.0)], [random.within(0.1, 0.5), 0.8]];
        let corner = |x: usize, y: usize| [ends[0][x], ends[1][y], 0.0];
        let rectangle = |[x, y]: [[f64; 2]; 2]| {
            let [first, second] = [[1, 2], [0, 2], [0, 1]][face.axis];
            let (mut lower, mut upper) = ([0.0; 3], [0.0; 3]);
            (lower[first], lower[second], upper[first], upper[second]) = (x[0], y[0], x[1], y[1]);
            Outline::Rectangle { lower, upper }
        };
        let polygon = on_face(
            Outline::Polygon { corners: vec![corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)] },
            face.axis,
        );
        let middle = random.within(0.45, 0.55);
        let pairs = [
            // An annulus and what is in its hole; one in the other's place; a disc over a wall.
            (vec![inlet(disc(radius, 0.0))], vec![inlet(disc(radius, inner)), inlet(disc(inner, 0.0))]),
            (vec![inlet(rectangle(ends))], vec![inlet(polygon)]),
            (
                vec![inlet(rectangle(ends))],
                vec![
                    inlet(rectangle([[ends[0][0], middle], ends[1]])),
                    inlet(rectangle([[middle, ends[0][1]], ends[1]])),
                ],
            ),
            (
                vec![inlet(disc(radius, inner))],
                vec![
                    inlet(disc(radius, 0.0)),
                    Patch { face, outline: disc(inner, 0.0), condition: Condition::WALL },
                ],
            ),
        ];
        for (case, (one, other)) in pairs.into_iter().enumerate() {
            let [one, other] =
                [one, other].map(|patches| velocities(&flow(face, trial % 3 == 0, patches), face));
            assert!(one.iter().any(|u| u.abs() > 0.1));
            for (a, b) in one.iter().zip(&other) {
                assert!((a - b).abs() < 1e-12, "{trial} {case}: {a} and {b}");
            }
        }
    }
}

#[test]
fn what_is_no_outline_is_refused() {
    let face = BoxFace { axis: 0, side: Side::Low };
    let polygon = |points: &[[f64; 2]]| Outline::Polygon {
        corners: points.iter().map(|[y, z]| [0.0, *y, *z]).collect(),
    };
    let disc = |y: f64, radius, inner_radius| Outline::Disc { center: [0.0, y, 0.5], radius, inner_radius };
    let uniform = Profile::Uniform([1.0, 0.0, 0.0]);
    let parabolic = Profile::Parabolic { mean: 1.0 };
    let cases = [
        (polygon(&[[0.1, 0.1], [0.9, 0.9], [0.9, 0.1], [0.1, 0.9]]), uniform.clone(), "edges cross"),
        (polygon(&[[0.1, 0.1], [0.9, 0.9]]), uniform.clone(), "three corners"),
        (polygon(&[[0.1, 0.1], [0.9, 0.1], [0.5, 0.9]]), parabolic, "no parabola"),
        (disc(0.5, 0.2, 0.2), uniform.clone(), "inner radius"),
        (disc(1.5, 0.2, 0.1), uniform, "no part of the face"),
    ];
    for (outline, profile, wanted) in cases {
        let patch = Patch { face, outline, condition: Condition::Inlet { profile } };
        let boundaries = Boundaries::default().with(0, Side::High, Condition::Outlet { pressure: 0.0 });
        let grid = Grid::uniform([0.0; 3], [1.0; 3], [4; 3], [false; 3]).unwrap();
        let setup = FlowSetup { boundaries: boundaries.with_patch(patch), ..FlowSetup::new(grid, 1.0, 0.01) };
        let error = Flow::new(setup, &SERIAL).map(drop).unwrap_err().to_string();
        assert!(error.contains(wanted), "{error}");
    }
}

/// A round tube in a box, and its inlet: all of the face, a disc as wide as the tube, a wider one, a narrower one.
#[test]
fn a_tube_gets_the_flow_of_its_inlet() {
    let (radius, speed) = (0.367, 0.8);
    let tube = move |[_, y, z]: [f64; 3]| {
        let distance = (y - 0.5).hypot(z - 0.48);
        let direction =
            if distance > 0.0 { [0.0, (0.5 - y) / distance, (0.48 - z) / distance] } else { [1.0, 0.0, 0.0] };
        Clearance { distance: radius - distance, direction, wall: 0 }
    };
    let face = BoxFace { axis: 0, side: Side::Low };
    let disc = |radius| Outline::Disc { center: [0.0, 0.5, 0.48], radius, inner_radius: 0.0 };
    let flow_of = |outline: Option<Outline>, profile: Profile| {
        let grid = Grid::uniform([0.0; 3], [1.0; 3], [5, 14, 14], [false; 3]).unwrap();
        let mut boundaries = Boundaries::default().with(0, Side::High, Condition::Outlet { pressure: 0.0 });
        let condition = Condition::Inlet { profile };
        match outline {
            Some(outline) => boundaries.patches = vec![Patch { face, outline, condition }],
            None => boundaries.faces[0] = condition,
        }
        let setup =
            FlowSetup { boundaries, mixture: Some(MixtureModel::A), ..FlowSetup::new(grid, 1.0, 0.01) };
        let mut flow = Flow::new(setup, &SERIAL).unwrap();
        flow.enclose(&tube, &SERIAL).unwrap();
        (0..2).for_each(|_| {
            let _ = flow.step(1e-3, &SERIAL).unwrap();
        });
        let [entering, leaving] = flows(&flow, face);
        assert!((leaving / entering - 1.0).abs() < 1e-7, "{entering} and {leaving}");
        (entering, flow.mixture.as_ref().unwrap().openings.as_ref().unwrap().clone())
    };
    let uniform = || Profile::Uniform([speed, 0.0, 0.0]);
    let (whole, openings) = flow_of(None, uniform());
    let layout = openings.cells.layout();
    let shares = (0..14).flat_map(|k| (0..14).map(move |j| (j, k)));
    let open: f64 = shares.map(|(j, k)| openings.faces.x.data()[layout.index(-1, j, k)] / 196.0).sum();
    assert!((open / (PI * radius * radius) - 1.0).abs() < 5e-3, "{open}");
    assert!((whole / (speed * open) - 1.0).abs() < 1e-12);
    for wide in [radius, 0.4, 0.6] {
        for profile in [uniform(), Profile::Parabolic { mean: speed }] {
            let (found, _) = flow_of(Some(disc(wide)), profile.clone());
            assert!((found / whole - 1.0).abs() < 3e-3, "{wide} {profile:?}: {found} for {whole}");
        }
    }
    let (narrow, _) = flow_of(Some(disc(0.2)), uniform());
    assert!((narrow / (speed * PI * 0.04) - 1.0).abs() < 1e-12, "{narrow}");
    for outline in [None, Some(disc(radius)), Some(disc(0.3))] {
        for is_parabolic in [false, true] {
            let (found, _) =
                flow_of(outline.clone(), Profile::FlowRate { rate: FlowRate::Constant(0.123), is_parabolic });
            assert!((found / 0.123 - 1.0).abs() < 1e-12, "{outline:?}: {found}");
        }
    }
}
