//! The state is the same in every bit on any number of ranks, for any decomposition, and after a restart on
//! another number of ranks.

#![allow(clippy::unwrap_used)]

mod common;

use common::results::{
    Particle, assert_same_series, assert_same_state, checkpoints, series, snapshots, state, step_of,
};
use common::{Draw, case, folder, replaced, run_case, run_case_on_nodes};
use std::fs;
use std::path::Path;

/// Decompositions of a case: ranks chosen by the program, 2 and 4 among them for the restarts, then given ones.
struct Decompositions {
    chosen: &'static [usize],
    given: &'static [[usize; 3]],
}

/// Asserts that the files of two runs agree: all checkpoints, the series, the times of the snapshots.
fn assert_same_results(wanted: &Path, found: &Path) {
    let (a, b) = (checkpoints(wanted), checkpoints(found));
    let steps = |list: &[std::path::PathBuf]| list.iter().map(|p| step_of(p)).collect::<Vec<_>>();
    assert_eq!(steps(&a), steps(&b), "checkpoints in {}", found.display());
    a.iter().zip(&b).for_each(|(a, b)| assert_same_state(a, b));
    assert_same_series(&series(wanted), &series(found));
    let files = ["particles.vtkhdf", "walls.vtkhdf"].into_iter();
    for name in files.filter(|name| wanted.join(name).exists()) {
        assert_eq!(snapshots(&wanted.join(name)), snapshots(&found.join(name)), "{}", found.display());
    }
}

/// Runs a case on many decompositions and across restarts, and compares each with one rank.
fn compare(name: &str, decompositions: &Decompositions) -> std::path::PathBuf {
    compare_case(name, case(&format!("{name}.toml")), decompositions)
}

fn compare_case(name: &str, text: String, decompositions: &Decompositions) -> std::path::PathBuf {
    let home = folder(&format!("same_bits_{name}"));
    let place = |label: &str| {
        let place = home.join(label);
        fs::create_dir_all(&place).unwrap();
        place
    };
    let reference = place("1");
    run_case(1, &reference, &text, &[]).succeeded();
    let wanted = reference.join("results");
    assert!(checkpoints(&wanted).len() >= 2, "a checkpoint before the end");
    for &ranks in decompositions.chosen {
        let own = place(&ranks.to_string());
        run_case(ranks, &own, &text, &[]).succeeded();
        assert_same_results(&wanted, &own.join("results"));
    }
    for ranks in decompositions.given {
        let own = place(&ranks.map(|n| n.to_string()).join("x"));
        let text = replaced(&text, "[domain]\n", &format!("[domain]\nranks = {ranks:?}\n"));
        run_case(ranks.iter().product(), &own, &text, &[]).succeeded();
        assert_same_results(&wanted, &own.join("results"));
    }
    for (from, ranks) in [("1", 3), ("4", 1), ("2", 4)] {
        let own = place(&format!("from_{from}_on_{ranks}"));
        copy_folder(&home.join(from).join("results"), &own.join("results"));
        let saved = checkpoints(&own.join("results"));
        // The results after the checkpoint stay: the run must replace them.
        saved[1..].iter().for_each(|later| fs::remove_file(later).unwrap());
        let output = run_case(ranks, &own, &text, &["--restart", "latest"]).succeeded();
        assert!(output.stdout.contains("continuing from"), "{}", output.text());
        assert_same_results(&wanted, &own.join("results"));
    }
    wanted
}

fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().flatten().filter(|e| e.path().is_file()) {
        fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
    }
}

#[test]
fn silo_with_a_plate_that_moves_away_and_an_outlet() {
    let decompositions = Decompositions { chosen: &[2, 3, 4, 8], given: &[[1, 1, 3], [2, 2, 2], [5, 1, 1]] };
    let wears = "wear = { coefficient = 1e-4, hardness = 1e9 }\n\n[[wall]]\nname = \"plate\"";
    let text = replaced(&case("silo.toml"), "[[wall]]\nname = \"plate\"", wears);
    let results = compare_case("silo", text, &decompositions);
    let series = series(&results);
    // The case does what it is for: beads pass the opening and leave, the plate is gone.
    let last = |name: &str| series.column(name).last().copied().unwrap();
    assert!(last("opening_count") > last("left") && last("left") > 0.0, "beads left");
    assert_eq!(last("inserted"), 180.0);
    assert!(series.column("plate_fz").iter().any(|&f| f != 0.0) && last("plate_fz") == 0.0, "the plate");
    let worn = last("silo_worn_volume");
    assert!(worn > 0.0 && series.column("silo_sliding_power").iter().any(|&power| power > 0.0));
    let [of_triangles, hopper] = worn_volumes(&results);
    assert!(
        (of_triangles / worn - 1.0).abs() < 1e-12,
        "{of_triangles} m3 in the field, {worn} m3 in the series"
    );
    assert!(0.0 < hopper && hopper < worn, "{hopper} m3 of {worn} m3 are worn off the hopper");
}

/// Volumes (m³) worn off all walls, and off their triangles below z = 3 cm, in the last snapshot: depth times area.
fn worn_volumes(results: &Path) -> [f64; 2] {
    let path = results.join("walls.vtkhdf");
    let root = hdf5::File::open(&path).unwrap().group("VTKHDF").unwrap();
    let points = root.dataset("Points").unwrap().read_raw::<f64>().unwrap();
    let corners = root.dataset("Polygons/Connectivity").unwrap().read_raw::<i64>().unwrap();
    let depths = root.dataset("CellData/worn_depth").unwrap().read_raw::<f64>().unwrap();
    let cells =
        *root.dataset("Polygons/NumberOfCells").unwrap().read_raw::<i64>().unwrap().last().unwrap() as usize;
    let points = &points[points.len() - 3 * *snapshots(&path).1.last().unwrap() as usize..];
    let corners = &corners[corners.len() - 3 * cells..];
    let mut sums = [0.0; 2];
    for (triangle, depth) in corners.chunks(3).zip(&depths[depths.len() - cells..]) {
        let place = |corner: usize, axis: usize| points[3 * triangle[corner] as usize + axis];
        let edge = |corner: usize, axis: usize| place(corner, axis) - place(0, axis);
        let normal = |[a, b]: [usize; 2]| edge(1, a) * edge(2, b) - edge(1, b) * edge(2, a);
        let area = 0.5 * [[0, 1], [1, 2], [2, 0]].map(|axes| normal(axes).powi(2)).iter().sum::<f64>().sqrt();
        let volume = area * depth;
        let is_hopper = (0..3).all(|corner| place(corner, 2) < 0.0301);
        sums[0] += volume;
        sums[1] += if is_hopper { volume } else { 0.0 };
    }
    sums
}

#[test]
fn silo_with_a_plate_that_a_table_swings_away() {
    let table = Path::new(env!("CARGO_TARGET_TMPDIR")).join("same_bits_swing.csv");
    let rows =
        "time,x,z,angle\n0.03,0,0,0\n0.05,0.002,-0.001,0.2\n0.07,0.001,-0.004,0.3\n0.12,0.002,-0.006,-0.2\n";
    fs::write(&table, rows).unwrap();
    let swing = format!("{{ kind = \"table\", path = {table:?}, point = [0, 0, 0], axis = [0, 0, 2] }}");
    let push = "{ kind = \"translation\", velocity = [1, 0, 0], start = 0.07, end = 0.1 }";
    let text = replaced(&case("silo.toml"), push, &swing);
    let decompositions = Decompositions { chosen: &[2, 4], given: &[[1, 1, 3]] };
    let series = series(&compare_case("silo_swing", text, &decompositions));
    let last = |name: &str| series.column(name).last().copied().unwrap();
    assert!(last("left") > 0.0, "beads left");
}

#[test]
fn periodic_shear_of_cubes_cylinders_icosahedra_and_spheres() {
    let decompositions = Decompositions { chosen: &[2, 3, 4, 8], given: &[[1, 1, 3], [3, 1, 2], [1, 2, 1]] };
    let series = series(&compare("shear", &decompositions));
    let last = |name: &str| series.column(name).last().copied().unwrap();
    let most = series.column("contacts").iter().copied().fold(0.0, f64::max);
    // By the seed 116 to 146 contacts at most, 100 by this one.
    assert!(
        most > 80.0 && last("contacts") > 50.0,
        "a dense bed: {most} contacts, {} at the end",
        last("contacts")
    );
    assert!(last("wall_contacts") > 10.0, "both planes are touched");
}

#[test]
fn a_bed_that_a_lid_presses_and_shears_under_a_load() {
    let moved = "{ kind = \"translation\", velocity = [-0.4, 0, -0.6], end = 0.095 }";
    let load = "{ kind = \"load\", axis = [0, 0, -2], pressure = 300, mass = 0.02, damping = 0.3, velocity = [-0.4, 0, 0] }";
    let text = replaced(&case("shear.toml"), moved, load);
    let decompositions = Decompositions { chosen: &[2, 4], given: &[[1, 1, 3]] };
    let series = series(&compare_case("lid", text, &decompositions));
    let last = |name: &str| series.column(name).last().copied().unwrap();
    // Means from when the lid, which rocks on the bed, has come down to it.
    let late_mean = |name: &str| {
        let column = series.column(name);
        let late = &column[column.len() * 3 / 4..];
        late.iter().sum::<f64>() / late.len() as f64
    };
    let (displacement, contacts) = (last("upper_displacement"), late_mean("contacts"));
    assert!(displacement > 0.02 && contacts > 50.0, "{displacement} m, {contacts} contacts");
    let mean = late_mean("upper_fz");
    let load = 300.0 * 0.045 * 0.045;
    assert!((mean / load - 1.0).abs() < 0.3, "{mean} N on the lid under {load} N");
}

#[test]
fn balls_and_cubes_in_a_sheared_box() {
    // Four ranks are found without cuts along the flow.
    let decompositions = Decompositions { chosen: &[2, 4], given: &[[1, 1, 3]] };
    let series = series(&compare("sheared", &decompositions));
    let mean = |name: &str| series.column(name).iter().sum::<f64>() / series.column(name).len() as f64;
    let [contacts, xz, zz] = ["contacts", "stress_xz", "stress_zz"].map(mean);
    assert!(contacts > 0.5 && xz < 0.0 && zz > 0.0, "{contacts} contacts, {xz} and {zz} Pa");
    assert!(mean("granular_temperature") > 0.0);
}

#[test]
fn drum_with_batches_of_insertion_and_a_lifter() {
    let decompositions = Decompositions { chosen: &[2, 3, 4, 8], given: &[[1, 2, 3], [4, 1, 1], [1, 1, 4]] };
    // Both walls turn, and wear.
    let turning = "angular_velocity = 12 }\n";
    let wears = format!("{turning}wear = {{ coefficient = 1e-4, hardness = 1e9 }}\n");
    let series = series(&compare_case("drum", case("drum.toml").replace(turning, &wears), &decompositions));
    let inserted = series.column("inserted");
    assert_eq!((inserted[0], *inserted.last().unwrap()), (0.0, 64.0));
    // The restarts from the first checkpoint, at 0.04 s, come in the middle of the batches.
    let at_checkpoint = series.column("time").iter().position(|&t| t > 0.04).unwrap();
    assert!((1.0..64.0).contains(&inserted[at_checkpoint]), "{} inserted", inserted[at_checkpoint]);
    for wall in ["drum_fz", "lifter_fz"] {
        assert!(series.column(wall).iter().any(|&f| f != 0.0), "the {wall} is touched");
    }
    for wall in ["drum_worn_volume", "lifter_worn_volume"] {
        let volumes = series.column(wall);
        assert!(
            volumes.is_sorted() && volumes.last().is_some_and(|&volume| volume > 0.0),
            "{wall}: {volumes:?}"
        );
    }
}

#[test]
fn a_silo_on_nodes_whose_ranks_lie_as_bricks() {
    let home = folder("same_bits_bricks");
    let text = case("silo.toml");
    let place = |label: &str| {
        let place = home.join(label);
        fs::create_dir_all(&place).unwrap();
        place
    };
    run_case(1, &place("1"), &text, &[]).succeeded();
    for (ranks, per_node) in [([4, 2, 1], 4), ([2, 2, 2], 4), ([1, 2, 3], 3), ([2, 2, 1], 2)] {
        let own = place(&format!("{ranks:?}-{per_node}"));
        let text = replaced(&text, "[domain]\n", &format!("[domain]\nranks = {ranks:?}\n"));
        run_case_on_nodes(ranks.iter().product(), per_node, &own, &text).succeeded();
        assert_same_results(&home.join("1/results"), &own.join("results"));
    }
}

#[test]
fn fixed_and_driven_particles_among_free_ones() {
    let decompositions = Decompositions { chosen: &[2, 3, 4], given: &[[1, 1, 3], [2, 2, 1]] };
    let series = series(&compare("fixed_and_driven", &decompositions));
    for name in ["pins", "shaker", "stirrer", "late"] {
        let loads = series.column(&format!("insert_{name}_fz"));
        assert!(loads.iter().any(|&f| f != 0.0), "{name} are touched");
    }
    assert_eq!((series.column("inserted")[0], *series.column("inserted").last().unwrap()), (88.0, 92.0));
}

/// A case whose particles have temperatures, with gas, radiation, a warm and a heated wall.
fn warmed(text: &str) -> String {
    let text = replaced(
        text,
        "[[contact]]",
        "[heat]\ntemperature = 300\ngas = { conductivity = 0.03, thickness = 0.05, smallest_gap = 1e-8 }\nradiation = { surroundings = 900 }\n\n[[contact]]",
    );
    let of_material = "heat_capacity = 20\nconductivity = 5\nemissivity = 0.7\nheat_source = 2\n";
    let of_stone = "youngs_modulus = 5e10\npoissons_ratio = 0.25\n";
    let text = replaced(&text, "density = 2500\n", &format!("density = 2500\n{of_material}{of_stone}"));
    let text = replaced(&text, "point = [0, 0, 0.085]\n", "point = [0, 0, 0.085]\nheating = 2e-3\n");
    replaced(&text, "point = [0, 0, 0.005]\n", "point = [0, 0, 0.005]\ntemperature = 600\n")
}

#[test]
fn particles_that_get_warm_on_a_hot_wall() {
    let decompositions = Decompositions { chosen: &[2, 4], given: &[[1, 1, 3], [2, 2, 1]] };
    let text = warmed(&case("shear.toml"));
    let series = series(&compare_case("warm", text, &decompositions));
    let column = |name: &str| series.column(&format!("particle_{name}"));
    let unaccounted = column("heat_unaccounted");
    for (missing, content) in unaccounted.iter().zip(column("heat_content")) {
        assert!(missing.abs() < 1e-12 * content, "{missing} J of {content} J");
    }
    let last = |name: &str| column(name).last().copied().unwrap();
    let inserted = last("heat_inserted");
    let [walls, radiation] = ["heat_from_walls", "heat_from_radiation"].map(last);
    assert!(
        walls > 1e-9 * inserted && radiation > 1e-9 * inserted,
        "{walls} J, {radiation} J of {inserted} J"
    );
    assert!(last("temperature_min") >= 300.0 && last("temperature_max") < 601.0);
}

#[test]
fn funnel_with_a_cone_and_a_ring_that_turns() {
    let decompositions = Decompositions { chosen: &[2, 4, 8], given: &[[1, 1, 3], [2, 2, 1]] };
    let series = series(&compare("funnel", &decompositions));
    for name in ["funnel", "deflector", "ring"] {
        assert!(series.column(&format!("{name}_fz")).iter().any(|&f| f != 0.0), "{name} is touched");
    }
    let counts = series.column("particles");
    let last = *counts.last().unwrap();
    assert!(last < 440.0 && last > 20.0, "{counts:?} particles");
}

#[test]
fn bonded_block_that_breaks_and_leaves() {
    let decompositions = Decompositions { chosen: &[2, 3, 4], given: &[[1, 1, 3], [2, 2, 1]] };
    let clamps = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../mpi-tests/cases/clamps.csv");
    let text = replaced(&case("bonded.toml"), "\"clamps.csv\"", &format!("{clamps:?}"));
    let results = compare_case("bonded", text, &decompositions);
    let series = series(&results);
    let last = |name: &str| series.column(name).last().copied().unwrap();
    let max = series.column("bonds").into_iter().fold(0.0, f64::max);
    assert!(max > 50.0 && last("broken_bonds") > 10.0 && last("left") > 10.0, "{max} bonds");
    assert!(max - last("broken_bonds") > last("bonds"), "some left with their particles");
    assert!(last("bonds") > 0.0 && series.column("bonds")[0] == 0.0);
}

#[test]
fn wet_drum_whose_films_feed_bridges() {
    let attraction = "attraction = { kind = \"film_bridge\", share = 0.3, formation = \"films\", surface_tension = 0.02, viscosity = 0.01 }\n";
    let damping = "tangential = { kind = \"viscous\", gamma_t = 300 }\n";
    let text = case("drum.toml")
        .replace(damping, &format!("{damping}{attraction}"))
        .replace("density = 1200\n", "density = 1200\nfilm = { kind = \"content\", content = 0.01 }\n")
        .replace(
            "name = \"steel\"\n\n",
            "name = \"steel\"\nfilm = { kind = \"thickness\", thickness = 1e-6 }\n\n",
        );
    // Balls that fall faster than bridges pull leave through the bottom.
    let text = replaced(&text, "[domain]\n", "[domain]\noutlets = [\"+x\", \"-x\", \"-z\"]\n");
    let decompositions = Decompositions { chosen: &[2, 3, 4, 8], given: &[[1, 2, 3]] };
    let results = compare_case("wet", text, &decompositions);
    let series = series(&results);
    let last = |name: &str| series.column(name).last().copied().unwrap();
    let column = |name: &str| series.column(&format!("liquid_{name}"));
    let [films, bridges, walls, inserted, left] =
        ["films", "bridges", "walls", "inserted", "left"].map(column);
    for k in 0..films.len() {
        let there = films[k] + bridges[k] + walls[k] + left[k];
        assert!((there - inserted[k]).abs() <= 1e-14 * inserted[k], "row {k}: {there} of {}", inserted[k]);
    }
    let (there, broken) = (last("bridges"), last("broken_bridges"));
    assert!(there > 20.0 && broken > 50.0, "{there} bridges, {broken} broken");
    assert!(walls.last().is_some_and(|&volume| volume != 0.0) && last("liquid_bridges") > 0.0);
}

#[test]
fn drum_with_hard_collisions() {
    let text = replaced(
        &case("drum.toml"),
        "[[material]]\nname = \"plastic\"",
        "[collisions]\nmodel = \"hard\"\nsweeps = 2\n\n[[material]]\nname = \"plastic\"",
    );
    let decompositions = Decompositions { chosen: &[2, 4], given: &[[1, 2, 3]] };
    let results = compare_case("hard", text, &decompositions);
    let series = series(&results);
    assert_eq!(*series.column("inserted").last().unwrap(), 64.0);
    assert!(series.column("drum_fz").iter().any(|&f| f != 0.0), "the drum is touched");
    let kinetic = series.column("kinetic_translation");
    assert!(kinetic.iter().all(|&k| k < 0.01), "{kinetic:?}");
}

#[test]
fn every_strategy_of_exchange() {
    let (home, text) = (folder("same_bits_exchange"), case("shear.toml"));
    let reference = home.join("1");
    fs::create_dir_all(&reference).unwrap();
    run_case(1, &reference, &text, &[]).succeeded();
    for strategy in [
        "all_gather_global",
        "all_gather_local",
        "all_gather_local_nonblocking",
        "send_recv_local_geoloc",
        "persistent",
    ] {
        let own = home.join(strategy);
        fs::create_dir_all(&own).unwrap();
        let text = replaced(&text, "[domain]\n", &format!("[domain]\nexchange = \"{strategy}\"\n"));
        run_case(4, &own, &text, &[]).succeeded();
        assert_same_results(&reference.join("results"), &own.join("results"));
    }
}

/// What the memory of a contact with a sphere begins with; its partner follows.
const WITH_SPHERE: u64 = 0;

/// The particles of a run whose rows came in another order, as they would be in that of `rows`: the k-th of a run was row
/// `rows[k]`. The ids are all that may differ.
fn as_in_order(found: &[Particle], rows: &[usize]) -> Vec<Particle> {
    // Ids are those of the rows.
    let id_of = |row: usize| found[row].id;
    let renamed = |id: u64| id_of(rows[found.iter().position(|p| p.id == id).unwrap()]);
    let bits = |id: u64| (id as f64).to_bits();
    let mut particles: Vec<Particle> = found
        .iter()
        .cloned()
        .map(|mut particle| {
            particle.id = renamed(particle.id);
            particle.state[0] = bits(particle.id);
            for contact in particle.memory.iter_mut().filter(|contact| contact[0] == WITH_SPHERE) {
                contact[1] = bits(renamed(f64::from_bits(contact[1]) as u64));
            }
            particle.memory.sort();
            particle
        })
        .collect();
    particles.sort_by_key(|particle| particle.id);
    particles
}

/// Balls in a box, their rows shuffled, on random ranks with and without borders that move: forces between spheres are the
/// same whichever is the first, and their sums have no order, so that ids decide nothing. Of other bodies that of the
/// lower id is the first, in whose frame their contact is computed, and collisions of the hard model are solved in the
/// order of the ids: there another order is another rounding.
#[test]
fn balls_in_any_order_on_random_decompositions() {
    let (home, mut draw) = (folder("same_bits_any_order"), Draw(3));
    let mut row = |k: usize| {
        let place = [k % 5, k / 5 % 4, k / 20].map(|n| 0.012 + 0.0125 * n as f64);
        let velocity = [0; 3].map(|_| 1.2 * (draw.next() - 0.5));
        let numbers = [place, velocity].concat().iter().map(f64::to_string).collect::<Vec<_>>();
        format!("{},{}\n", numbers.join(","), 0.8 + 0.3 * draw.next())
    };
    let balls: Vec<String> = (0..60).map(&mut row).collect();
    let place =
        "{ kind = \"lattice\", lower = [0.02, 0.01, 0.02], upper = [0.07, 0.055, 0.05], spacing = 0.011 }";
    let text = replaced(&case("base.toml"), place, "{ kind = \"file\", path = \"balls.csv\" }");
    let text = replaced(&text, "count = 16\n", "").replace("end = 0.02\n", "end = 0.15\n");
    let text = text.replace("friction = 0.3\n", "friction = 0.3\ntangential = { kind = \"spring\" }\n");
    let text = replaced(&text, "checkpoint = 0.01\n", "checkpoint = 0.05\n");
    let run = |rows: &[usize], ranks: [usize; 3], balance: bool| {
        let listed: String = rows.iter().map(|&k| balls[k].as_str()).collect();
        fs::write(home.join("balls.csv"), format!("x,y,z,vx,vy,vz,scale\n{listed}")).unwrap();
        let domain = format!("[domain]\nranks = {ranks:?}\nbalance = {balance}\n");
        run_case(ranks.iter().product(), &home, &replaced(&text, "[domain]\n", &domain), &[]).succeeded();
        let saved = checkpoints(&home.join("results"));
        saved.iter().map(|checkpoint| as_in_order(&state(checkpoint), rows)).collect::<Vec<_>>()
    };
    let mut rows: Vec<usize> = (0..balls.len()).collect();
    let wanted = run(&rows, [1; 3], true);
    let touching =
        |particles: &[Particle]| particles.iter().map(|particle| particle.memory.len()).sum::<usize>();
    let contacts = wanted.iter().map(|particles| touching(particles)).max();
    assert!(wanted.len() >= 2 && contacts > Some(30), "{contacts:?} contacts");
    // Subdomains that are wider than the largest ball reaches.
    let all = (0..45).map(|k| [k % 5 + 1, k / 5 % 3 + 1, k / 15 + 1]);
    let few: Vec<[usize; 3]> = all.filter(|ranks| ranks.iter().product::<usize>() <= 6).collect();
    for _ in 0..5 {
        (1..rows.len()).rev().for_each(|k| rows.swap(k, draw.of(k + 1)));
        let (ranks, balance) = (few[draw.of(few.len())], draw.of(2) == 0);
        let found = run(&rows, ranks, balance);
        assert!(found == wanted, "on {ranks:?} ranks, balance {balance}, rows {rows:?}");
    }
}
