//! Cases that change at a restart: walls, motions, steps, input files, a fluid.

use crate::common::files::{assert_same_rows, times};
use crate::common::results::{Series, assert_same_state, checkpoints, series, snapshots, state, step_of};
use crate::common::{Output, case, folder, often, replaced, run_case};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// Runs a case into the folder `results` named in it.
fn staged(ranks: usize, home: &Path, text: &str, from: &str) -> Output {
    run_case(ranks, home, text, &["--restart", from]).succeeded()
}

fn into(folder: &str, text: &str) -> String {
    replaced(text, "directory = \"results\"", &format!("directory = {folder:?}"))
}

#[test]
fn a_silo_that_is_opened_at_a_restart_is_the_one_that_opens_by_itself() {
    let home = folder("restarts_silo");
    let with = |end: f64, until: f64| {
        let text = replaced(&case("silo.toml"), "end = 0.24", &format!("end = {end}"));
        replaced(&text, "until = 0.1", &format!("until = {until}"))
    };
    // The walls come in another order, and there is one more.
    let opened = with(0.14, 0.1);
    let (before, walls) = opened.split_once("[[wall]]").unwrap();
    let (silo, rest) = walls.split_once("[[wall]]").unwrap();
    let (plate, after) = rest.split_once("[[flow_plane]]").unwrap();
    let lid = "\nname = \"lid\"\nmaterial = \"wall\"\nkind = \"plane\"\npoint = [0, 0, 0.13]\nnormal = [0, 0, -1]\n\n";
    let opened = format!("{before}[[wall]]{plate}[[wall]]{lid}[[wall]]{silo}[[flow_plane]]{after}");
    run_case(2, &home, &with(0.08, 0.3), &[]).succeeded();
    let output = staged(3, &home, &into("opened", &opened), "results");
    for words in
        ["differs", "wall.plate.until = 0.1, was 0.3", "wall.lid is new", "time.end = 0.14, was 0.08"]
    {
        assert!(output.stdout.contains(words), "{words}: {}", output.text());
    }
    let own = folder("restarts_silo_at_once");
    run_case(2, &own, &opened, &[]).succeeded();
    let last = |folder: &Path| checkpoints(folder).last().unwrap().clone();
    assert_same_state(&last(&own.join("results")), &last(&home.join("opened")));
    // The files of the new folder begin with the state of the checkpoint and tell where they come from.
    let [whole, stage] = [own.join("results"), home.join("opened")].map(|folder| series(&folder));
    assert_eq!(stage.column("step")[0], 2000.0);
    let later = whole.rows.iter().filter(|row| row[0] >= 2000.0);
    assert_same_rows(
        &Series { columns: whole.columns.clone(), rows: later.cloned().collect() },
        &stage,
        1e-12,
    );
    // Masses of grains of many sizes are the same to the bit.
    let [passed, at_once] = [&stage, &whole].map(|series| series.column("opening_mass"));
    assert!(passed.last().unwrap() > &0.0 && at_once.ends_with(&passed), "{passed:?} {at_once:?}");
    let text = fs::read_to_string(home.join("opened/series.csv")).unwrap();
    assert!(
        text.contains("# changes: from step 2000, t = 0.08 s: wall.plate.until = 0.1, was 0.3"),
        "{text}"
    );
    // The first run is as it was, and a checkpoint of the second one holds what was changed.
    assert_eq!(step_of(&last(&home.join("results"))), 2000);
    let history =
        hdf5::File::open(last(&home.join("opened"))).unwrap().dataset("grains-mpi/changes").unwrap();
    let history = String::from_utf8(history.read_raw::<u8>().unwrap()).unwrap();
    assert!(history.contains("wall.lid is new"), "{history}");
}

/// A dry drum is wetted at a restart, and its lifter taken out at the next, with the liquid of the bridges to it.
#[test]
fn a_drum_is_wetted_at_a_restart_and_loses_a_wall_at_the_next() {
    let home = folder("restarts_wet");
    let until = |end: f64, text: &str| replaced(text, "end = 0.24", &format!("end = {end}"));
    let dry = case("drum.toml");
    let damping = "tangential = { kind = \"viscous\", gamma_t = 300 }\n";
    let bridges = "attraction = { kind = \"film_bridge\", surface_tension = 0.05 }\n";
    let film = "density = 1200\nfilm = { kind = \"content\", content = 0.02 }\n";
    let wet = dry.replace(damping, &format!("{damping}{bridges}"));
    let wet = wet.replace("density = 1200\n", film);
    let (before, after) = wet.split_once("[[wall]]\nname = \"lifter\"").unwrap();
    let without = format!("{before}[output]{}", after.split_once("[output]").unwrap().1);
    run_case(2, &home, &until(0.08, &dry), &[]).succeeded();
    staged(3, &home, &into("wet", &until(0.16, &wet)), "results");
    staged(1, &home, &into("without", &until(0.2, &without)), "wet");
    let [wet, without] = ["wet", "without"].map(|name| series(&home.join(name)));
    let at = |series: &Series, name: &str, row: usize| series.column(&format!("liquid_{name}"))[row];
    // 40 balls and solids or so are there when it is wetted, with a fiftieth of their volume.
    let (first, last) = (0, wet.rows.len() - 1);
    assert!(at(&wet, "inserted", first) > 0.4 * at(&wet, "inserted", last));
    assert_eq!(at(&wet, "inserted", last), at(&without, "inserted", 0));
    for series in [&wet, &without] {
        for row in 0..series.rows.len() {
            let there = ["films", "bridges", "walls", "left"].map(|name| at(series, name, row));
            let (there, inserted) = (there.iter().sum::<f64>(), at(series, "inserted", row));
            assert!((there - inserted).abs() <= 1e-14 * inserted, "row {row}: {there} of {inserted}");
        }
    }
    let bridges = |series: &Series, row: usize| series.column("bridges")[row];
    assert!(bridges(&wet, last) > 10.0, "{} bridges", bridges(&wet, last));
    assert!(at(&without, "walls", 0) >= at(&wet, "walls", last));
}

/// Angle (rad) about y of the lifter of the drum in the last snapshot of its walls: that of its corners nearest to the axis.
fn lifter(folder: &Path) -> f64 {
    let file = hdf5::File::open(folder.join("walls.vtkhdf")).unwrap();
    let points = file.dataset("VTKHDF/Points").unwrap().read_raw::<f64>().unwrap();
    let count = *snapshots(&folder.join("walls.vtkhdf")).1.last().unwrap() as usize;
    let last = points[points.len() - 3 * count..].chunks(3).filter(|p| p[0].hypot(p[2]) < 0.032);
    let [x, z] = last.fold([0.0, 0.0], |sum, p| [sum[0] + p[0], sum[1] + p[2]]);
    f64::atan2(-z, x)
}

#[test]
fn a_drum_whose_speed_changes_goes_on_from_where_it_is() {
    let home = folder("restarts_drum");
    // The drum is hardened as well.
    let turning = |end: f64, rate: f64| {
        let text = replaced(&case("drum.toml"), "end = 0.24", &format!("end = {end}"));
        let hardness = if rate == 12.0 { 1e9 } else { 4e9 };
        let motion = format!(
            "angular_velocity = {rate} }}\nwear = {{ coefficient = 1e-3, hardness = {hardness:e} }}\n"
        );
        text.replace("angular_velocity = 12 }\n", &motion)
    };
    run_case(2, &home, &turning(0.08, 12.0), &[]).succeeded();
    assert!((lifter(&home.join("results")) - 12.0 * 0.08).abs() < 1e-9);
    let text = turning(0.16, -6.0);
    let output = staged(3, &home, &into("slower", &text), "results");
    assert!(output.stdout.contains("wall.lifter.motion.angular_velocity = -6"), "{}", output.text());
    let slower = home.join("slower");
    assert!((lifter(&slower) - (12.0 * 0.08 - 6.0 * 0.08)).abs() < 1e-9, "{}", lifter(&slower));
    // No particle is thrown by a wall that jumps.
    let speed = |folder: &Path| series(folder).column("max_speed").into_iter().fold(0.0, f64::max);
    assert!(speed(&slower) < 1.5 * speed(&home.join("results")), "{}", speed(&slower));
    // What has worn off stays, and a wall four times as hard wears a fourth.
    staged(2, &home, &into("softer", &text.replace("hardness = 4e9", "hardness = 1e9")), "results");
    let worn = |folder: &str| *series(&home.join(folder)).column("drum_worn_volume").last().unwrap();
    let [first, hard, soft] = ["results", "slower", "softer"].map(worn);
    assert!(
        first > 0.0 && ((soft - first) / (hard - first) - 4.0).abs() < 1e-9,
        "{first}, {hard}, {soft} m3"
    );
    // From there it is continued like any run: the places of its walls are in its checkpoints.
    let own = home.join("own");
    fs::create_dir(&own).unwrap();
    fs::copy(slower.join("checkpoint-000000003000.h5"), own.join("middle.h5")).unwrap();
    let output = staged(1, &own, &text, "middle.h5");
    assert!(!output.stdout.contains("wall."), "{}", output.text());
    let last = |folder: &Path| checkpoints(folder).last().unwrap().clone();
    assert_same_state(&last(&slower), &last(&own.join("results")));
    // Back to the first speed in the same folder: the rows go on.
    staged(2, &home, &into("slower", &turning(0.17, 12.0)), "latest");
    assert!((lifter(&slower) - (6.0 * 0.08 + 12.0 * 0.01)).abs() < 1e-9);
    let text = fs::read_to_string(slower.join("series.csv")).unwrap();
    assert!(
        text.contains("\n# from step 4000: wall.drum.motion.angular_velocity = 12.0, was -6.0\n"),
        "{text}"
    );
    assert_eq!(series(&slower).last_step(), 4250);
}

/// Two bodies that fall and spin freely for `end` (s) in steps of `dt` (s).
fn falling(end: f64, dt: f64) -> String {
    format!(
        r#"
[domain]
lower = [0, 0, 0]
upper = [0.4, 0.4, 1]
[time]
end = {end}
dt = {dt}
accept_coarse_dt = true
[[material]]
name = "m"
density = 1000
[[contact]]
between = ["m", "m"]
normal_stiffness = 1e2
restitution = 0.8
friction = 0.3
[[shape]]
name = "ball"
kind = "sphere"
radius = 0.02
[[shape]]
name = "brick"
kind = "box"
edges = [0.03, 0.04, 0.05]
[[insert]]
name = "two"
particles = [{{ shape = "ball", material = "m" }}, {{ shape = "brick", material = "m" }}]
count = 6
place = {{ kind = "lattice", lower = [0.05, 0.05, 0.8], upper = [0.35, 0.35, 0.9], spacing = 0.1, noise = 0 }}
angular_velocity = [3, 5, -2]
[output]
directory = "results"
series = 0.01
checkpoint = 0.05
"#
    )
}

#[test]
fn another_time_step_goes_on_at_the_same_time_and_to_second_order() {
    let home = folder("restarts_time_step");
    run_case(1, &home, &falling(0.1, 1e-3), &[]).succeeded();
    let output = staged(2, &home, &falling(0.2, 3.7e-4), "latest");
    assert!(output.stdout.contains("time step 3.7e-4 s, was 1e-3 s"), "{}", output.text());
    // And once more, from a step that is no multiple of the new one.
    staged(1, &home, &falling(0.3, 7e-4), "latest");
    let table = series(&home.join("results"));
    let (times, steps) = (table.column("time"), table.column("step"));
    assert!(times.windows(2).all(|t| t[0] < t[1]) && steps.windows(2).all(|s| s[0] < s[1]), "{times:?}");
    for (number, time) in (0..=10).map(|k: usize| (k, 0.01 * k as f64)) {
        assert!((times[number] - time).abs() < 1e-9, "{times:?}");
    }
    assert!((times.last().unwrap() - 0.3).abs() <= 7e-4 && times.len() >= 31, "{times:?}");
    // A leap-frog falls without an error, if its velocities are those of half a step of its own before.
    let [potential, momentum] = ["potential", "momentum_z"].map(|name| table.column(name));
    let mass = -momentum[10] / (9.81 * times[10]);
    for (k, t) in times.iter().enumerate() {
        let fallen = (potential[0] - potential[k]) / (mass * 9.81);
        assert!((fallen - 0.5 * 9.81 * t * t).abs() < 1e-9, "fallen {fallen} at {t}");
        assert!((momentum[k] + mass * 9.81 * t).abs() < 1e-9 * mass, "momentum {} at {t}", momentum[k]);
    }
    let turning = table.column("kinetic_rotation");
    assert!(turning.iter().all(|e| (e / turning[0] - 1.0).abs() < 1e-6), "{turning:?}");
}

#[test]
fn what_is_inserted_is_known_by_its_name() {
    let home = folder("restarts_insertion");
    run_case(2, &home, &falling(0.02, 1e-3), &[]).succeeded();
    // The first one gets two more where they have room by now, the other is new and comes before it in the case.
    let text = replaced(&falling(0.1, 1e-3), "count = 6", "count = 8\nstart = 0.09");
    let text = replaced(
        &text,
        "lower = [0.05, 0.05, 0.8], upper = [0.35, 0.35, 0.9]",
        "lower = [0.05, 0.05, 0.88], upper = [0.35, 0.35, 0.98]",
    );
    let more = r#"[[insert]]
name = "more"
particles = [{ shape = "ball", material = "m" }]
count = 4
batch = 2
interval = 0.02
velocity = [0, 0, -3]
place = { kind = "lattice", lower = [0.05, 0.05, 0.5], upper = [0.35, 0.35, 0.6], spacing = 0.1, noise = 0 }
[[insert]]
name = "two"
"#;
    let text = replaced(&text, "[[insert]]\nname = \"two\"\n", more);
    let output = staged(1, &home, &text, "latest");
    assert!(output.stdout.contains("insert.two.count = 8, was 6"), "{}", output.text());
    let count =
        |table: &Series| table.column("time").into_iter().zip(table.column("particles")).collect::<Vec<_>>();
    let results = home.join("results");
    let found = count(&series(&results));
    let wanted = [6, 6, 6, 8, 10, 10, 10, 10, 10, 12, 12];
    assert_eq!(found.iter().map(|(_, n)| *n as u64).collect::<Vec<_>>(), wanted, "{found:?}");
    let ids: Vec<u64> = state(checkpoints(&results).last().unwrap()).iter().map(|p| p.id).collect();
    assert_eq!(ids, (0..12).collect::<Vec<_>>());
    // The same again from between two of its batches, on other ranks.
    let middle = checkpoints(&results).into_iter().find(|path| step_of(path) == 50).unwrap();
    let end = home.join("end.h5");
    fs::copy(checkpoints(&results).last().unwrap(), &end).unwrap();
    staged(3, &home, &text, middle.to_str().unwrap());
    assert_same_state(&end, checkpoints(&results).last().unwrap());
}

/// Particles are let go, held, and driven from where they are, at one restart after the other.
#[test]
fn the_motion_of_particles_may_change_at_a_restart() {
    let home = folder("restarts_motion");
    let stage = |end: f64, motion: &str| {
        replaced(&falling(end, 1e-3), "angular_velocity = [3, 5, -2]", &format!("motion = {motion}"))
    };
    let swings = "{ kind = \"oscillation\", amplitude = [0, 0, 0.01], frequency = 5 }";
    run_case(2, &home, &stage(0.05, "\"fixed\""), &[]).succeeded();
    // Loads on what is held are columns of the series: with others begins another folder.
    let output = staged(1, &home, &into("free", &stage(0.1, "\"free\"")), "results");
    assert!(output.stdout.contains("insert.two.motion"), "{}", output.text());
    staged(3, &home, &into("driven", &stage(0.15, swings)), "free");
    let driven = into("driven", &stage(0.2, "{ kind = \"translation\", velocity = [0, 0, 0.5] }"));
    staged(2, &home, &driven, "latest");
    // Time, height and momentum of the particles' mass.
    let read = |folder: &str| {
        let table = series(&home.join(folder));
        ["time", "potential", "momentum_z"].map(|name| table.column(name))
    };
    let at = |[times, potential, momentum]: &[Vec<f64>; 3], time: f64| {
        let row = times.iter().position(|t| (t - time).abs() < 1e-9).unwrap();
        (potential[row], momentum[row])
    };
    let [held, free, driven] = ["results", "free", "driven"].map(read);
    let mass = -at(&free, 0.1).1 / (9.81 * 0.05);
    let first = held[1][0];
    let height = |(potential, _): (f64, f64)| (potential - first) / (9.81 * mass);
    assert!(held[1].iter().all(|p| *p == first) && held[2].iter().all(|p| *p == 0.0), "{held:?}");
    let fallen = -0.5 * 9.81 * 0.05_f64.powi(2);
    let found = height(at(&free, 0.1));
    assert!((found - fallen).abs() < 1e-9, "{found} for {fallen}");
    // The swing goes on from there, wherever it is in its period.
    let swing = |time: f64| 0.01 * (std::f64::consts::TAU * 5.0 * time).sin();
    let swung = |time: f64| fallen + swing(time) - swing(0.1);
    for (time, wanted) in [(0.12, swung(0.12)), (0.15, swung(0.15)), (0.2, swung(0.15) + 0.5 * 0.05)] {
        let found = height(at(&driven, time));
        assert!((found - wanted).abs() < 1e-9, "{time}: {found} for {wanted}");
    }
    assert!((at(&driven, 0.2).1 / mass - 0.5).abs() < 1e-9, "{driven:?}");
    // Who is held stays known.
    for (old, new, reason) in [
        ("count = 6", "count = 8", "add another [[insert]]"),
        ("name = \"two\"", "name = \"three\"", "insert.two is gone"),
    ] {
        let text = replaced(&stage(0.3, "\"fixed\""), old, new);
        let refused = run_case(2, &home, &text, &["--restart", "results"]);
        let message = refused.only_error(2);
        assert!(message.contains(reason) && message.contains("cannot be continued"), "{new}: {message}");
    }
}

#[test]
fn a_state_without_meaning_in_the_case_is_refused_with_the_reason() {
    let home = folder("restarts_refused");
    run_case(2, &home, &falling(0.02, 1e-3), &[]).succeeded();
    let unused = "[[shape]]\nname = \"pebble\"\nkind = \"sphere\"\nradius = 0.01\n[[insert]]\n";
    let base = falling(0.03, 1e-3);
    for (old, new, reason) in [
        ("upper = [0.4, 0.4, 1]", "upper = [0.4, 0.4, 1.1]", "domain.upper"),
        ("lower = [0, 0, 0]", "lower = [0, 0, 0]\nperiodic = [true, false, false]", "domain.periodic"),
        ("density = 1000", "density = 1001", "material.m.density"),
        ("radius = 0.02", "radius = 0.021", "shape.ball.radius"),
        ("{ shape = \"ball\", material = \"m\" }, ", "", "shape `ball`"),
    ] {
        let refused = run_case(2, &home, &replaced(&base, old, new), &["--restart", "latest"]);
        let message = refused.only_error(2);
        assert!(message.contains(reason) && message.contains("cannot be continued"), "{new}: {message}");
    }
    // Others are no part of the state.
    for (old, new) in [
        ("restitution = 0.8", "restitution = 0.5"),
        ("normal_stiffness = 1e2", "normal_stiffness = 2e2"),
        ("[domain]\n", "gravity = [0, 0, -5]\n[domain]\n"),
        ("[domain]\n", "seed = 9\n[domain]\n"),
        ("upper = [0.4, 0.4, 1]", "upper = [0.4, 0.4, 1]\noutlets = [\"-z\"]"),
        ("[[insert]]\n", unused),
    ] {
        let own = folder("restarts_accepted");
        fs::copy(checkpoints(&home.join("results")).last().unwrap(), own.join("from.h5")).unwrap();
        let output = staged(1, &own, &replaced(&base, old, new), "from.h5");
        assert!(output.stdout.contains("differs"), "{new}: {}", output.text());
    }
}

/// A triangle mesh of two triangles, a floor of height z that reaches over the box of [`falling`].
fn floor(z: f64) -> String {
    let corner = |x: f64, y: f64| format!("vertex {x} {y} {z}\n");
    let (a, b, c, d) = (corner(-0.1, -0.1), corner(0.5, -0.1), corner(0.5, 0.5), corner(-0.1, 0.5));
    let facet =
        |p: &str, q: &str, r: &str| format!("facet normal 0 0 1\nouter loop\n{p}{q}{r}endloop\nendfacet\n");
    format!("solid floor\n{}{}endsolid floor\n", facet(&a, &b, &c), facet(&a, &c, &d))
}

#[test]
fn input_files_are_known_by_their_content_wherever_they_lie() {
    let wall =
        "[[wall]]\nname = \"floor\"\nmaterial = \"m\"\nkind = \"mesh\"\npath = \"floor.stl\"\n[output]\n";
    let text = |end: f64| replaced(&falling(end, 1e-3), "[output]\n", wall);
    let home = folder("restarts_inputs");
    let here = home.join("here");
    fs::create_dir(&here).unwrap();
    fs::write(here.join("floor.stl"), floor(0.1)).unwrap();
    run_case(2, &here, &text(0.02), &[]).succeeded();
    // The folder moves.
    let there = home.join("there");
    fs::rename(&here, &there).unwrap();
    let output = staged(1, &there, &text(0.03), "latest");
    assert!(!output.stdout.contains("wall.floor"), "{}", output.text());
    // The mesh is another one: it is said, and holds from here on.
    fs::write(there.join("floor.stl"), floor(0.2)).unwrap();
    let output = staged(2, &there, &text(0.04), "latest");
    assert!(output.stdout.contains("wall.floor.path"), "{}", output.text());
    // So is a table of an insertion to come.
    let table = "[[insert]]\nname = \"later\"\nparticles = [{ shape = \"ball\", material = \"m\" }]\nstart = 0.06\nplace = { kind = \"file\", path = \"later.csv\" }\n[output]\n";
    let text = |end: f64| replaced(&replaced(&falling(end, 1e-3), "[output]\n", wall), "[output]\n", table);
    fs::write(there.join("later.csv"), "x,y,z\n0.1,0.1,0.5\n").unwrap();
    staged(2, &there, &text(0.05), "latest");
    fs::write(there.join("later.csv"), "x,y,z\n0.1,0.1,0.5\n0.3,0.3,0.5\n").unwrap();
    let output = staged(2, &there, &text(0.07), "latest");
    assert!(output.stdout.contains("insert.later.place.path"), "{}", output.text());
    assert_eq!(series(&there.join("results")).column("particles").last(), Some(&8.0));
}

#[test]
fn results_name_the_case_and_the_files_they_are_of() {
    let wall =
        "[[wall]]\nname = \"floor\"\nmaterial = \"m\"\nkind = \"mesh\"\npath = \"floor.stl\"\n[output]\n";
    let text = replaced(&falling(0.02, 1e-3), "[output]\n", wall);
    let traced = |name: &str, ranks: usize, height: f64| {
        let home = folder(&format!("restarts_origin_{name}"));
        fs::write(home.join("floor.stl"), floor(height)).unwrap();
        run_case(ranks, &home, &text, &[]).succeeded();
        let record: serde_json::Value =
            serde_json::from_slice(&fs::read(home.join("results/run.json")).unwrap()).unwrap();
        let part = record["parts"][0].clone();
        let file = hdf5::File::open(checkpoints(&home.join("results")).last().unwrap()).unwrap();
        let text = |name: &str| {
            let bytes = file.dataset(&format!("grains-mpi/{name}")).unwrap().read_raw::<u8>().unwrap();
            String::from_utf8(bytes).unwrap()
        };
        assert_eq!(part["case_sha256"], text("case_sha256"));
        // What the checkpoint names is what there is.
        let mut check = Command::new("sha256sum").arg("-c").stdin(Stdio::piped()).spawn().unwrap();
        check.stdin.take().unwrap().write_all(text("inputs").as_bytes()).unwrap();
        assert!(check.wait().unwrap().success());
        let [input] = &part["inputs"].as_array().unwrap()[..] else { panic!("one input") };
        assert!(text("inputs").starts_with(input["sha256"].as_str().unwrap()));
        (part["case_sha256"].as_str().unwrap().to_string(), input["sha256"].clone())
    };
    let first = traced("first", 2, 0.1);
    assert_eq!(traced("elsewhere", 1, 0.1), first);
    let other = traced("other", 2, 0.2);
    assert!(other.0 != first.0 && other.1 != first.1);
}

#[test]
fn a_fluid_comes_to_particles_at_rest_and_goes() {
    let home = folder("restarts_fluid");
    let flowing = |end: u32| {
        let text = replaced(&often("bed.toml", (end, 5)), "checkpoint = 1e3", "checkpoint = 1e-4");
        replaced(&text, "velocity = [0, 0, 1.0]", "velocity = [0, 0, 0.5]")
    };
    let still = |end: u32| {
        let text = flowing(end);
        let (before, fluid) = text.split_once("[fluid]\n").unwrap();
        format!("{before}[output]\n{}", fluid.split_once("[output]\n").unwrap().1)
    };
    run_case(2, &home, &still(20), &[]).succeeded();
    let output = staged(1, &home, &into("flow", &flowing(40)), "results");
    assert!(output.stdout.contains("fluid is new"), "{}", output.text());
    let flow = home.join("flow");
    let table = series(&flow);
    assert_eq!(table.column("step"), [20.0, 25.0, 30.0, 35.0, 40.0]);
    assert!(table.column("superficial_z").iter().skip(1).all(|u| (u - 0.5).abs() < 0.05));
    assert!(*table.column("pressure_drop").last().unwrap() > 0.0);
    assert_eq!(times(&flow.join("fluid.vtkhdf")).len(), 5);
    // It is continued as any, also from its first checkpoint, with another inlet; and then the fluid goes.
    let faster = replaced(&flowing(45), "velocity = [0, 0, 0.5]", "velocity = [0, 0, 0.6]");
    staged(2, &home, &into("flow", &faster), "latest");
    let table = series(&flow);
    assert!((table.column("superficial_z").last().unwrap() - 0.6).abs() < 0.06);
    let output = staged(2, &home, &into("rest", &still(50)), "flow");
    assert!(output.stdout.contains("fluid is gone"), "{}", output.text());
    assert_eq!(series(&home.join("rest")).column("step"), [45.0, 50.0]);
    // Another grid is refused.
    let other = replaced(&into("flow", &flowing(60)), "cells = [12, 4, 16]", "cells = [12, 4, 18]");
    let refused = run_case(2, &home, &other, &["--restart", "latest"]);
    assert!(refused.only_error(2).contains("fluid.cells"), "{}", refused.text());
}

/// A staged case of the repository with some passages replaced.
fn stage(name: &str, changes: &[(&str, &str)]) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/staged").join(name);
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    changes.iter().fold(text, |text, (old, new)| replaced(&text, old, new))
}

#[test]
fn staged_cases_go_from_stage_to_stage() {
    let home = folder("restarts_staged");
    let staged_from = |first: &str, second: &str, from: &str| {
        run_case(2, &home, first, &[]).succeeded();
        staged(2, &home, second, from)
    };
    let fewer = ("count = 1500", "count = 60");
    let settle =
        stage("silo-settle.toml", &[fewer, ("end = 1.5", "end = 0.5"), ("after = 0.5", "after = 0.45")]);
    let open = stage("silo-open.toml", &[fewer, ("end = 6", "end = 1.2")]);
    let output = staged_from(&settle, &open, "results/staged/silo-settled");
    assert!(output.stdout.contains("wall.plate is gone"), "{}", output.text());
    let [settled, opened] =
        ["settled", "opened"].map(|name| series(&home.join("results/staged/silo-".to_string() + name)));
    assert_eq!(settled.column("outlet_count").last(), Some(&0.0));
    assert_eq!(opened.column("outlet_count").last(), Some(&60.0));
    let (end, few) = (("end = 3", "end = 0.3"), ("count = 800", "count = 40"));
    let slow = stage("drum-slow.toml", &[end, few]);
    let fast = stage("drum-fast.toml", &[few, ("end = 6", "end = 0.4")]);
    let output = staged_from(&slow, &fast, "results/staged/drum-slow");
    assert!(
        output.stdout.contains("wall.drum.motion.angular_velocity = 4.1887902, was 1.0471976"),
        "{}",
        output.text()
    );
    let load = stage("bed-load.toml", &[("end = 0.15", "end = 0.01")]);
    let flow = stage("bed-flow.toml", &[("end = 0.25", "end = 0.012")]);
    let output = staged_from(&load, &flow, "results/staged/bed-loaded");
    assert!(output.stdout.contains("fluid is new"), "{}", output.text());
    assert!(*series(&home.join("results/staged/bed-flow")).column("pressure_drop").last().unwrap() > 0.0);
}

#[test]
fn a_run_killed_after_a_restart_does_not_go_on_from_a_later_checkpoint() {
    let home = folder("restarts_abandoned");
    let text = replaced(&falling(0.2, 1e-3), "checkpoint = 0.05", "checkpoint = 0.05\nkeep_checkpoints = 9");
    run_case(1, &home, &text, &[]).succeeded();
    let results = home.join("results");
    // The rows after step 50 are cut off; until the next checkpoint it is the newest one.
    let from = "results/checkpoint-000000000050.h5";
    let stop = run_case(2, &home, &text, &["--restart", from, "--max-walltime", "0"]).succeeded();
    let steps: Vec<u64> = checkpoints(&results).iter().map(|p| step_of(p)).collect();
    // All ranks hear of the stop within eight steps.
    assert!(steps.len() == 2 && steps[0] == 50 && (51..=58).contains(&steps[1]), "{steps:?}");
    assert!(stop.stdout.contains(&format!("stopped at step {}", steps[1])), "{}", stop.text());
    run_case(2, &home, &text, &["--restart", "latest"]).succeeded();
    assert_eq!(series(&results).column("step"), (0..=20).map(|k| 10.0 * f64::from(k)).collect::<Vec<_>>());
}

#[test]
fn the_rate_of_a_shear_may_change_at_a_restart_and_nothing_else_of_it() {
    let home = folder("restarts_shear");
    let stage = |end: f64, rate: f64| {
        let text = replaced(&case("sheared.toml"), "rate = 20", &format!("rate = {rate}"));
        replaced(&text, "end = 0.12", &format!("end = {end}"))
    };
    run_case(1, &home, &stage(0.05, 20.0), &[]).succeeded();
    let output = run_case(2, &home, &stage(0.1, -12.0), &["--restart", "latest"]).succeeded();
    assert!(output.stdout.contains("domain.shear.rate = -12"), "{}", output.text());
    // Agitation is now that to another mean flow.
    let series = series(&home.join("results"));
    let agitation = series.column("granular_temperature");
    let restarted = series.column("time").iter().position(|&time| time > 0.051).unwrap();
    assert!(agitation[restarted] > 5.0 * agitation[restarted - 2], "{agitation:?}");
    let other = replaced(&stage(0.12, -12.0), "gradient = \"z\"", "gradient = \"y\"");
    let refused = run_case(1, &home, &other, &["--restart", "latest"]);
    assert_ne!(refused.code, Some(0));
    assert!(refused.text().contains("change its rate alone"), "{}", refused.text());
}

#[test]
fn a_lid_whose_load_changes_goes_on_from_where_it_is() {
    let home = folder("restarts_load");
    let stage = |end: f64, motion: &str| {
        let moved = "{ kind = \"translation\", velocity = [-0.4, 0, -0.6], end = 0.095 }";
        let text = replaced(&case("shear.toml"), moved, motion);
        replaced(&text, "end = 0.16", &format!("end = {end}"))
    };
    let load = |force: f64| {
        format!("{{ kind = \"load\", axis = [0, 0, -1], force = {force}, mass = 0.05, damping = 1 }}")
    };
    run_case(1, &home, &stage(0.02, &load(0.6)), &[]).succeeded();
    run_case(2, &home, &stage(0.04, &load(0.2)), &["--restart", "latest"]).succeeded();
    let series = series(&home.join("results"));
    let (ways, speeds) = (series.column("upper_displacement"), series.column("upper_speed"));
    // Nothing touches it yet: v' = (F − c v)/m, without a jump of place or speed.
    let (mut speed, mut way) = (0.0, 0.0);
    for (k, (found, found_speed)) in ways.iter().zip(&speeds).enumerate() {
        assert!((found - way).abs() < 1e-3 * (way + 1e-3), "row {k}: {found} m for {way} m");
        assert!(
            (found_speed - speed).abs() < 0.02 * (speed + 0.01),
            "row {k}: {found_speed} m/s for {speed} m/s"
        );
        let force = if k < 10 { 0.6 } else { 0.2 };
        let decay = (-1.0 / 0.05 * 2e-3_f64).exp();
        way += force * 2e-3 + (speed - force) * 0.05 * (1.0 - decay);
        speed = force + (speed - force) * decay;
    }
}
