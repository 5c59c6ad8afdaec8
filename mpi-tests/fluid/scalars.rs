//! Temperature and concentrations that a flow carries among particles.

use super::{assert_close, continued, results_of};
use crate::common::results::{Series, series};
use crate::common::{case, folder, replaced, run, run_case};
use std::fs;
use std::path::Path;

#[test]
fn scalars_keep_their_sums_and_limits_on_any_ranks_and_wherever_a_run_stops() {
    let (home, text) = (folder("fluid_scalars"), case("heated.toml"));
    let one = results_of(&home, "1", 1, &text);
    let table = series(&one);
    let column = |name: &str| table.column(name);
    for name in ["temperature", "tracer"] {
        let (content, lost) = (column(&format!("{name}_content")), column(&format!("{name}_unaccounted")));
        assert!(content.windows(2).all(|w| w[1] > w[0]), "{name}: {content:?}");
        let largest = content.iter().fold(0.0_f64, |m, x| m.max(*x));
        assert!(lost.iter().all(|x| x.abs() < 1e-11 * largest), "{name}: {lost:?} of {largest}");
    }
    // The pressure solver leaves a little of the volume to the step after.
    let [low, high] = ["tracer_min", "tracer_max"].map(column);
    assert!(low.iter().all(|x| *x > -1e-12) && high.iter().all(|x| *x < 1.0 + 1e-12), "{low:?} {high:?}");
    assert!(*high.last().unwrap() > 0.9, "{high:?}");
    // The beads get what the air loses to them, and what the reaction releases.
    let [heat, from_fluid, produced, lost] = ["content", "from_fluid", "produced", "unaccounted"]
        .map(|name| column(&format!("particle_heat_{name}")));
    let last = |values: &[f64]| values.last().copied().unwrap();
    assert!(last(&from_fluid) > 0.0 && last(&produced) != 0.0);
    assert!(lost.iter().zip(&heat).all(|(lost, heat)| lost.abs() < 1e-12 * heat), "{lost:?}");
    let [liquid, given, lost] =
        ["content", "from_fluid", "unaccounted"].map(|name| column(&format!("particle_vapour_{name}")));
    assert!(last(&given) < 0.0 && last(&column("particle_vapour_min")) >= 0.0, "{liquid:?}");
    assert!(lost.iter().all(|lost| lost.abs() < 1e-12 * liquid[0]), "{lost:?}");
    let reactant = column("reactant_max");
    assert!(last(&reactant) <= 2.0 + 1e-12 && last(&column("reactant_mean")) < 2.0, "{reactant:?}");
    // What came in is what the inlet let in: the tracer through a disc, in the cells whose middle it covers.
    let inlet = 0.6 * 16.0 * (0.02 / 9.0) * (0.018 / 8.0);
    let (times, content) = (column("time"), column("tracer_content"));
    for (time, content) in times.iter().zip(content).skip(1) {
        assert!((content / (inlet * time) - 1.0).abs() < 1e-6, "{content} of {} at {time} s", inlet * time);
    }
    let mut others = [2, 4].map(|ranks| results_of(&home, &ranks.to_string(), ranks, &text)).to_vec();
    others.push(continued(&home, "2", 3, &text));
    let own = home.join("stops");
    fs::create_dir_all(&own).unwrap();
    run_case(2, &own, &text, &["--max-walltime", "0"]).succeeded();
    run_case(1, &own, &text, &["--restart", "latest", "--max-walltime", "0.3"]).succeeded();
    run_case(3, &own, &text, &["--restart", "latest"]).succeeded();
    others.push(own.join("results"));
    for other in &others {
        let found = series(other);
        let names = ["temperature_mean", "temperature_max", "tracer_content", "tracer_max", "fluid_kinetic"];
        let of_beads = [
            "particle_temperature_max",
            "particle_heat_produced",
            "reactant_mean",
            "particle_vapour_content",
        ];
        for name in names.into_iter().chain(of_beads) {
            let label = format!("{name} of {}", other.display());
            assert_close(&column(name), &found.column(name), 1e-7, &label);
        }
        for name in ["temperature", "tracer"] {
            let (content, lost) =
                (found.column(&format!("{name}_content")), found.column(&format!("{name}_unaccounted")));
            let largest = content.iter().fold(0.0_f64, |m, x| m.max(*x));
            assert!(lost.iter().all(|x| x.abs() < 1e-11 * largest), "{name}: {lost:?}");
        }
    }
}

/// A scalar that a continued run has and its state has not begins there, with its account; the other ones go on.
#[test]
fn a_scalar_that_is_new_in_a_continued_run_begins_with_its_account() {
    let (home, text) = (folder("fluid_new_scalar"), case("heated.toml"));
    let text = replaced(&text, "end = 0.015", "end = 0.006");
    let text = replaced(&text, "checkpoint = 0.005", "checkpoint = 0.003");
    let whole = series(&results_of(&home, "whole", 2, &text));
    let half = results_of(&home, "half", 2, &replaced(&text, "end = 0.006", "end = 0.003"));
    let dye = "[[fluid.scalar]]\nname = \"dye\"\nkind = \"concentration\"\ndiffusivity = 1e-5\ninitial = \"1 + 20*z\"\n\n\
               [[fluid.scalar.boundary]]\nface = \"-z\"\nkind = \"value\"\nvalue = 1\n\n[output]";
    let own = home.join("dyed");
    fs::create_dir_all(&own).unwrap();
    run_case(3, &own, &replaced(&text, "[output]", dye), &["--restart", half.to_str().unwrap()]).succeeded();
    let dyed = series(&own.join("results"));
    let last = |table: &Series, name: &str| *table.column(name).last().unwrap();
    let (content, lost) = (last(&dyed, "dye_content"), last(&dyed, "dye_unaccounted"));
    assert!(content > 0.0 && lost.abs() < 1e-11 * content, "{lost} of {content}");
    assert!(last(&dyed, "dye_min") > 1.0 - 1e-12 && last(&dyed, "dye_max") < 1.8 + 1e-12);
    for name in ["temperature_content", "tracer_content", "temperature_max"] {
        let (there, here) = (last(&whole, name), last(&dyed, name));
        assert!((here / there - 1.0).abs() < 1e-7, "{name}: {here} instead of {there}");
    }
    assert!(last(&dyed, "temperature_unaccounted").abs() < 1e-11 * last(&dyed, "temperature_content"));
}

/// Beads and gas of many temperatures in a closed box that nothing enters: what one loses the other gets, and none is hotter or colder
/// than the hottest and the coldest were, however long the steps of the fluid are.
#[test]
fn beads_and_gas_in_a_closed_box_keep_their_heat_and_overshoot_nothing() {
    let home = folder("fluid_closed_heat");
    let open = case("heated.toml");
    let end = open.find("[[fluid.boundary]]").unwrap();
    let closed = &open[..end];
    let scalar = "[[fluid.scalar]]\nname = \"temperature\"\nkind = \"temperature\"\nconductivity = 0.0255\n\
                  heat_capacity = 1005\ninitial = \"300 + 90*cos(300*x)\"\nparticles = { law = \"gunn\" }\n\n\
                  [[fluid.scalar]]\nname = \"dye\"\nkind = \"concentration\"\ndiffusivity = 1e-5\ninitial = 3\n\
                  particles = { law = \"sun\", uptake = { partition = 0.02, initial = 0.01 } }\n\n\
                  [[fluid.scalar]]\nname = \"vapour\"\nkind = \"concentration\"\ndiffusivity = 2e-5\ninitial = 0\n\
                  particles = { law = \"gunn\", evaporation = { latent_heat = 2e2, molar_mass = 200, \
                  boiling_point = 373.15, initial = 1 } }\n\n\
                  [output]\ndirectory = \"results\"\nseries = 0.001\n";
    let text = format!("{closed}{scalar}");
    let text = replaced(&text, "heat_capacity = 840", "heat_capacity = 0.05");
    let text = replaced(&text, "end = 0.015", "end = 0.006");
    let text = replaced(&text, "count = 700\n", "count = 700\ntemperature = 500\n");
    let text = replaced(&text, "count = 60\nstart = 0.003\n", "count = 60\ntemperature = 200\n");
    for ranks in [1, 3] {
        let table = series(&results_of(&home, &ranks.to_string(), ranks, &text));
        let column = |name: &str| table.column(name);
        let is_kept = |name: &str, of_beads: &str| {
            let [gas, beads] =
                [format!("{name}_content"), format!("particle_{of_beads}_content")].map(|n| column(&n));
            let whole: Vec<f64> = gas.iter().zip(&beads).map(|(a, b)| a + b).collect();
            assert!(whole.iter().all(|x| (x / whole[0] - 1.0).abs() < 1e-12), "{name}: {whole:?}");
            assert!((beads.last().unwrap() / beads[0] - 1.0).abs() > 1e-3, "{name} is exchanged: {beads:?}");
        };
        is_kept("dye", "dye");
        is_kept("vapour", "vapour");
        // What evaporates takes its latent heat along.
        let [gas, beads, produced] =
            ["temperature_content", "particle_heat_content", "particle_heat_produced"].map(column);
        for (k, produced) in produced.iter().enumerate() {
            let whole = gas[k] + beads[k] - produced;
            assert!((whole / (gas[0] + beads[0]) - 1.0).abs() < 1e-12, "{whole} J");
        }
        assert!(
            column("dye_max").iter().all(|x| *x < 3.0 + 1e-12) && column("dye_min").iter().all(|x| *x > 0.5)
        );
        assert!(column("particle_vapour_min").iter().all(|x| *x >= 0.0));
        let hottest = column("particle_temperature_max");
        assert!(*hottest.last().unwrap() < 0.99 * hottest[0], "heat is exchanged: {hottest:?}");
        for name in ["temperature", "particle_temperature"] {
            let [low, high] = ["min", "max"].map(|end| column(&format!("{name}_{end}")));
            assert!(low.iter().all(|x| *x > 150.0) && high.iter().all(|x| *x < 500.0 + 1e-9));
        }
    }
}

/// A hot sphere in a wide stream cools as exp(−h A t/(m c)), the case of MFiX: 366.8414 K after 0.1 s.
#[test]
fn a_sphere_in_a_stream_cools_as_the_closed_form() {
    let home = folder("fluid_one_hot_sphere");
    let (density, capacity, diameter, speed) = (8850.0, 55.0, 3.6e-3, 6.0);
    let [gas, viscosity, gas_capacity] = [1.2, 1.8e-5, 1005.0];
    // The conductivity with which Ranz and Marshall's law cools it at the rate of the case.
    let rate = |conductivity: f64| {
        let reynolds: f64 = gas * speed * diameter / viscosity;
        let nusselt = 2.0 + 0.6 * reynolds.sqrt() * (viscosity * gas_capacity / conductivity).cbrt();
        6.0 * nusselt * conductivity / (density * capacity * diameter * diameter)
    };
    let (mut low, mut high) = (1e-4, 1.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if rate(middle) < 0.878629815377096 { low = middle } else { high = middle }
    }
    let text = format!(
        "gravity = [0, 0, 0]\n[domain]\nlower = [0, 0, 0]\nupper = [1.2, 1.2, 1.2]\nperiodic = [true, true, false]\n\
         [time]\nend = 0.1\ndt = 0.005\naccept_coarse_dt = true\n[heat]\ntemperature = 373.14994357\n\
         [[material]]\nname = \"metal\"\ndensity = {density}\nheat_capacity = {capacity}\n\
         [[contact]]\nbetween = [\"metal\", \"metal\"]\nnormal_stiffness = 1e3\nrestitution = 0.5\nfriction = 0\n\
         [[shape]]\nname = \"ball\"\nkind = \"sphere\"\nradius = {}\n\
         [[insert]]\nname = \"one\"\nparticles = [{{ shape = \"ball\", material = \"metal\" }}]\nmotion = \"fixed\"\ncount = 1\n\
         place = {{ kind = \"lattice\", lower = [0.5, 0.5, 0.5], upper = [0.7, 0.7, 0.7], spacing = 0.2 }}\n\
         [fluid]\ndensity = {gas}\nviscosity = {viscosity}\ncells = [4, 4, 4]\ninitial = {{ velocity = [0, 0, 6] }}\n\
         coupling = {{ drag = \"schiller_naumann\", kernel = {{ kind = \"smooth\", half_width = 1.5 }} }}\n\
         [[fluid.boundary]]\nface = \"-z\"\nkind = \"inlet\"\nvelocity = [0, 0, {speed}]\n\
         [[fluid.boundary]]\nface = \"+z\"\nkind = \"outlet\"\n\
         [[fluid.scalar]]\nname = \"temperature\"\nkind = \"temperature\"\nconductivity = {low}\n\
         heat_capacity = {gas_capacity}\ninitial = 298.15\nparticles = {{ law = \"ranz_marshall\" }}\n\
         [[fluid.scalar.boundary]]\nface = \"-z\"\nkind = \"value\"\nvalue = 298.15\n\
         [output]\ndirectory = \"results\"\nseries = 0.05\n",
        0.5 * diameter
    );
    let table = series(&results_of(&home, "one", 1, &text));
    let found = *table.column("particle_temperature_mean").last().unwrap();
    println!("{found} K");
    assert!((found - 366.8414).abs() < 1e-3, "{found} K");
}

/// Bodies that have temperatures of their own in a flow that these move, and a dye that walls give off.
#[test]
fn warm_bodies_and_the_fluid_they_move_in_keep_their_sums_on_any_ranks_and_wherever_a_run_stops() {
    let (home, text) = (folder("fluid_warm_bodies"), case("resolved_heat.toml"));
    let text = replaced(&text, "end = 0.12", "end = 0.06");
    let text = replaced(&text, "checkpoint = 0.04", "checkpoint = 0.02");
    let one = results_of(&home, "1", 1, &text);
    let table = series(&one);
    let column = |name: &str| table.column(name);
    for name in ["temperature", "dye"] {
        let (content, lost) = (column(&format!("{name}_content")), column(&format!("{name}_unaccounted")));
        assert!(lost.iter().zip(&content).all(|(lost, c)| lost.abs() < 1e-12 * c), "{name}: {lost:?}");
    }
    let last = |name: &str| *column(name).last().unwrap();
    // The hot bodies cool, the fluid gets warmer, and nothing overshoots.
    assert!(last("particle_temperature_max") < 349.0 && last("temperature_max") < 350.0);
    assert!(column("temperature_min").iter().all(|t| *t > 299.9), "{:?}", column("temperature_min"));
    assert!(last("particle_heat_from_fluid") < 0.0 && last("temperature_mean") > 300.01);
    let (heat, lost) = (column("particle_heat_content"), column("particle_heat_unaccounted"));
    assert!(lost.iter().zip(&heat).all(|(lost, heat)| lost.abs() < 1e-12 * heat), "{lost:?}");
    assert!(column("dye_max").iter().all(|x| *x < 1.0 + 1e-12) && last("dye_from_particles") != 0.0);
    let mut others = vec![results_of(&home, "2", 2, &text), results_of(&home, "4", 4, &text)];
    others.push(continued(&home, "2", 1, &text));
    for other in &others {
        let found = series(other);
        for name in ["temperature_mean", "temperature_max", "particle_temperature_min", "dye_mean"] {
            let label = format!("{name} of {}", other.display());
            assert_close(&column(name), &found.column(name), 1e-6, &label);
        }
        let lost = found.column("temperature_unaccounted");
        assert!(lost.iter().all(|x| x.abs() < 1e-12 * last("temperature_content")), "{lost:?}");
    }
}

/// A steady flow carries a reactant to catalysts and heat from others to the wall: what comes in leaves or reacts.
#[test]
fn a_steady_flow_brings_catalysts_what_reacts_in_them() {
    let (home, text) = (folder("fluid_catalyst"), case("catalyst.toml"));
    let text = replaced(&text, "tolerance = 1e-4", "tolerance = 3e-3");
    // The temperature less 290 K: a flow with sources in its cells would not carry both alike.
    let excess = r#"[[fluid.scalar]]
name = "excess"
kind = "concentration"
diffusivity = 0.1
initial = 10
particles = { flux = 50 }

[[fluid.scalar.boundary]]
face = "-x"
kind = "value"
value = 10

[[fluid.scalar.boundary]]
wall = "pipe"
kind = "transfer"
coefficient = 0.5
ambient = 0

[output]"#;
    let text = replaced(&text, "[output]", excess);
    let one = results_of(&home, "1", 1, &text);
    let table = series(&one);
    let column = |table: &Series, name: &str| *table.column(name).last().unwrap();
    for what in ["min", "mean", "max"] {
        let of = |name: &str| column(&table, &format!("{name}_{what}"));
        assert!((of("temperature") - of("excess") - 290.0).abs() < 1e-8, "{what}: {}", of("temperature"));
    }
    assert!(column(&table, "unsettled_scalars") < 3e-3);
    let (reacted, mean) = (column(&table, "reactant_reaction"), column(&table, "reactant_mean"));
    assert!(reacted > 0.05 && mean > 0.5 && mean < 0.95, "{reacted} {mean}");
    for name in ["reactant", "temperature"] {
        let lost = column(&table, &format!("{name}_unaccounted"));
        assert!(lost.abs() < 1e-11 * column(&table, &format!("{name}_content")), "{name}: {lost}");
    }
    // Heat of the bricks: 5e4 W/m2 of 2.24 m2, of which cells as wide as an eighth of them see most.
    let heat = column(&table, "temperature_from_particles");
    assert!((heat / 1.12e5 - 1.0).abs() < 0.1, "{heat}");
    assert!(column(&table, "temperature_from_walls") < 0.0);
    let found = analysed(&one, "effectiveness", &["--axis", "x"]);
    assert!(found > 0.1 && found < 1.0, "{found}");
    for other in [results_of(&home, "2", 2, &text), results_of(&home, "4", 4, &text)] {
        let table_of = series(&other);
        for name in ["reactant_reaction", "reactant_mean", "temperature_from_walls"] {
            let (there, here) = (column(&table, name), column(&table_of, name));
            assert!((here / there - 1.0).abs() < 1e-6, "{name}: {here} {there}");
        }
        assert!((analysed(&other, "effectiveness", &["--axis", "x"]) / found - 1.0).abs() < 1e-6);
    }
}

/// Catalysts that stick out through the wall leave slivers of themselves in cells beside it: these hold up no step, and scalars keep
/// sums and limits on any ranks.
#[test]
fn catalysts_that_reach_into_a_wall_hold_up_no_step() {
    let (home, text) = (folder("fluid_catalyst_in_wall"), case("catalyst.toml"));
    let text = replaced(&text, "tolerance = 1e-4", "tolerance = 3e-3").replace("0.57", "0.34");
    let [one, two] = [1, 2].map(|ranks| series(&results_of(&home, &ranks.to_string(), ranks, &text)));
    let last = |table: &Series, name: &str| *table.column(name).last().unwrap();
    assert!(last(&one, "unsettled_scalars") < 3e-3 && last(&one, "reactant_reaction") > 0.01);
    assert!(last(&one, "reactant_min") >= 0.0 && last(&one, "reactant_max") <= 1.0 + 1e-12);
    for name in ["reactant", "temperature"] {
        let lost = last(&one, &format!("{name}_unaccounted"));
        assert!(lost.abs() < 1e-11 * last(&one, &format!("{name}_content")), "{name}: {lost}");
    }
    for name in ["reactant_reaction", "reactant_mean", "temperature_mean"] {
        let (there, here) = (last(&one, name), last(&two, name));
        assert!((here / there - 1.0).abs() < 1e-6, "{name}: {here} {there}");
    }
}

/// Mean of the number that an analysis finds.
fn analysed(results: &Path, what: &str, options: &[&str]) -> f64 {
    let out = results.join("analysis");
    let mut args = vec!["analyse", what, results.to_str().unwrap(), "--output", out.to_str().unwrap()];
    args.extend(options);
    run(1, results, &args).succeeded();
    let text = fs::read_to_string(out.join(format!("{what}.csv"))).unwrap();
    let mut rows = text.lines().filter(|line| !line.starts_with('#'));
    let head: Vec<&str> = rows.next().unwrap().split(',').collect();
    let mean = head.iter().position(|name| *name == "mean").unwrap();
    rows.next_back().unwrap().split(',').nth(mean).unwrap().parse().unwrap()
}

/// An averaged flow among walls: a funnel whose wall is hot and a ring in it that turns and gives off a dye; beads take heat up.
#[test]
fn walls_of_averaged_flows_give_what_fluid_and_beads_get() {
    let home = folder("fluid_hot_funnel");
    let mut text = replaced(&case("funnel.toml"), "[0.04, 0.0095]]", "[0.04, 0.0095]]\nfluid = \"inside\"");
    text = replaced(&text, "[-0.001, 0.006]]\n", "[-0.001, 0.006]]\nfluid = \"outside\"\n");
    text = replaced(&text, "density = 2500\n", "density = 2500\nheat_capacity = 100\nconductivity = 1\n");
    text = replaced(&text, "end = 0.05", "end = 0.004");
    let fluid = r#"[fluid]
density = 1.2
viscosity = 1.8e-5
cells = [14, 15, 22]
coupling = { drag = "beetstra", kernel = { kind = "smooth" } }

[[fluid.boundary]]
face = "+z"
kind = "outlet"

[[fluid.boundary]]
face = "-z"
kind = "outlet"

[[fluid.scalar]]
name = "temperature"
kind = "temperature"
conductivity = 0.0255
heat_capacity = 1005
initial = 300
particles = { law = "gunn" }

[[fluid.scalar.boundary]]
wall = "funnel"
kind = "value"
value = 350

[[fluid.scalar]]
name = "dye"
kind = "concentration"
diffusivity = 2e-5
initial = 0

[[fluid.scalar.boundary]]
wall = "ring"
kind = "value"
value = 1

[heat]
temperature = 300

[output]"#;
    let text = replaced(&text, "[output]", fluid);
    let one = series(&results_of(&home, "1", 1, &text));
    let column = |name: &str| one.column(name);
    let last = |name: &str| *column(name).last().unwrap();
    for name in ["temperature", "dye"] {
        let (lost, content) = (column(&format!("{name}_unaccounted")), last(&format!("{name}_content")));
        assert!(lost.iter().all(|x| x.abs() < 1e-11 * content), "{name}: {lost:?} of {content}");
    }
    assert!(last("temperature_mean") > 300.2 && last("temperature_max") < 350.0 + 1e-9);
    assert!(column("temperature_min").iter().all(|t| *t > 300.0 - 1e-9));
    assert!(last("dye_mean") > 3e-4 && last("dye_max") < 1.0 + 1e-9 && last("dye_min") > -1e-12);
    assert!(last("particle_heat_from_fluid") > 0.0);
    for (label, ranks) in [("2", 2), ("4", 4)] {
        let other = series(&results_of(&home, label, ranks, &text));
        for name in ["temperature_mean", "dye_mean", "particle_heat_from_fluid"] {
            // Beads that bounce make more of what the pressure solver leaves undone.
            assert_close(&column(name), &other.column(name), 1e-5, name);
        }
    }
}
