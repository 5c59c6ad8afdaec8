//! Good cases parse, keep their values through the resolved file, and agree with the schema.

#[path = "good_input/fluids.rs"]
mod fluids;

use std::path::{Path, PathBuf};

use grains_case::{
    Case, Motion, Orientation, ParticleColumns, ParticleMotion, Place, Precision, ShapeKind, Side,
    Tangential, TimeStep, WallKind, schema,
};
use serde_json::Value;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/good")
}

fn load(name: &str) -> Case {
    Case::load(folder().join(name)).unwrap_or_else(|errors| panic!("{errors}"))
}

const GOOD: [&str; 28] = [
    "catalyst.toml",
    "warm_bodies.toml",
    "warm.toml",
    "heated.toml",
    "inlets.toml",
    "mud.toml",
    "thinning.toml",
    "array.toml",
    "eddies.toml",
    "yielding.toml",
    "adhesive.toml",
    "bonded.toml",
    "gravel.toml",
    "silo.toml",
    "mixture.toml",
    "composites.toml",
    "press.toml",
    "sheared.toml",
    "single.toml",
    "channel.toml",
    "bed.toml",
    "bodies.toml",
    "suspension.toml",
    "pipe.toml",
    "wet.toml",
    "gates.toml",
    "plates.toml",
    "smagorinsky.toml",
];

#[test]
fn the_silo_is_resolved_to_indices_units_and_defaults() {
    let case = load("silo.toml");
    assert!(case.warnings.is_empty(), "{:?}", case.warnings);
    assert_eq!((case.name.as_str(), case.seed, case.gravity), ("silo discharge", 7, [0.0, 0.0, -9.81]));
    assert_eq!((case.time.dt, case.time.end, case.time.steps_per_contact), (TimeStep::Auto, 32.0, 25.0));
    assert_eq!(case.domain.ranks, Some([1, 1, 2]));
    assert!(!case.domain.outlets[0].is_upper() && case.domain.outlets[0].axis() == 2);
    let (glass, steel) =
        (case.material_index("glass").expect("glass"), case.material_index("steel").expect("steel"));
    assert_eq!(case.contact(steel, glass), Some(1));
    assert_eq!(case.contact(steel, steel), None);
    assert_eq!(
        case.contacts[0].tangential(),
        Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 }
    );
    assert_eq!(case.contacts[1].tangential(), Tangential::Viscous { gamma_t: 1e5 });
    let beads = &case.inserts[0];
    assert_eq!((beads.particles[0].shape, beads.particles[0].material), (0, glass));
    assert_eq!(
        (beads.count, beads.batch, beads.orientation.unwrap()),
        (Some(10_000), Some(10_000), Orientation::Random)
    );
    let Place::Lattice { spacing: Some(spacing), noise, .. } = beads.place else { panic!("lattice") };
    assert!(spacing * (1.0 - 2.0 * noise) > 2.0 * 0.0069);
    assert_eq!(case.walls[1].kind, WallKind::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] });
    assert_eq!((case.walls[1].from, case.walls[1].until, case.walls[0].until), (0.0, 2.0, f64::INFINITY));
    assert_eq!((case.output.precision, case.output.particles), (Precision::F32, 0.1));
    assert_eq!(case.stop.all_passed, Some(0));
}

#[test]
fn the_mixture_has_every_kind_with_its_defaults() {
    let case = load("mixture.toml");
    assert_eq!(case.name, "mixture");
    assert_eq!(case.output.directory, Path::new("results/mixture"));
    assert_eq!(case.shapes[0].crust, Some(0.05));
    assert_eq!(case.shapes[1].crust, Some(0.02));
    assert!(
        matches!(&case.shapes[4].kind, ShapeKind::HullFile { path, .. } if path.is_absolute() && path.is_file())
    );
    let Orientation::Quaternion(q) = case.inserts[0].orientation.unwrap() else { panic!("quaternion") };
    assert!((q.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-15);
    assert_eq!(case.inserts[0].particles[2].scale.largest(), 2.0);
    let WallKind::Cylinder { axis, height, side, .. } = case.walls[0].kind else { panic!("cylinder") };
    assert_eq!((axis, height, side), ([0.0, 1.0, 0.0], 0.9, Side::Inside));
    assert!(matches!(case.walls[1].motion, Some(Motion::Oscillation { end: 0.5, .. })));
}

#[test]
fn the_resolved_case_parses_to_the_same_case() {
    for name in GOOD {
        let case = load(name);
        let resolved = case.to_toml();
        let again = Case::parse(&resolved, "anything.toml", Path::new("/nowhere"));
        let again = again.unwrap_or_else(|errors| panic!("{errors}"));
        assert_eq!(case, again);
        assert_eq!(resolved, again.to_toml());
    }
}

#[test]
fn unlikely_values_are_warned_about_with_their_place() {
    let text = std::fs::read_to_string(folder().join("silo.toml")).expect("text");
    let text =
        text.replace("density = 2500.0", "density = 2.5e6").replace("1e6", "10").replace("-9.81", "9.81");
    let case = Case::parse(&text, "odd.toml", &folder()).expect("allowed");
    let warnings: Vec<String> = case.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(warnings.len(), 4, "{warnings:?}");
    assert!(warnings[0].starts_with("odd.toml:4:11: gravity = [0, 0, 9.81]: points up"), "{}", warnings[0]);
    assert!(warnings[1].contains("material[0].density = 2.5e6: unusual, mostly between 1.0 and 30000.0"));
    assert!(warnings[2].contains("contact[0].normal_stiffness = 10: unusual"));
}

/// A particle alone meets no other: its law is only needed with the walls.
#[test]
fn a_single_particle_needs_no_law_with_itself() {
    assert_eq!(load("single.toml").contacts.len(), 1);
}

#[test]
fn particle_files_are_checked_against_the_case() {
    let case = load("mixture.toml");
    let insert = &case.inserts[1];
    let Place::File { path } = &insert.place else { panic!("file") };
    let columns = ParticleColumns::read_csv(path).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!((columns.len(), columns.lines.as_slice()), (3, [3, 4, 6].as_slice()));
    assert_eq!(columns.scale, Some(vec![1.0, 0.5, 1.0]));
    assert_eq!(columns.velocity.as_ref().expect("velocity")[0], [0.0, 0.0, -1.0]);
    assert_eq!(columns.check("beads.csv", &case, insert), Ok(()));
    assert_eq!(columns.shape_indices(&case), Some(vec![3, 3, 4]));
    let text = "x,y,z,shape,material,scale\n0.1,0.1,3,wege,rock,1\n0.1,0.1,0.1,wedge,rok,0\n";
    let columns = ParticleColumns::parse_csv(text, "b.csv").expect("numbers");
    let errors = columns.check("b.csv", &case, insert).expect_err("bad").to_string();
    let expected = [
        "b.csv:2: x, y, z = [0.1, 0.1, 3.0]: outside the domain",
        "b.csv:2: shape = wege: unknown shape; did you mean `wedge`?",
        "b.csv:3: scale = 0: must be above 0",
        "b.csv:3: material = rok: unknown material; did you mean `rock`?",
    ];
    expected.iter().for_each(|part| assert!(errors.contains(part), "{part}\n{errors}"));
}

#[test]
fn broken_particle_files_are_refused_by_line() {
    let message = |text: &str| ParticleColumns::parse_csv(text, "b.csv").expect_err(text).to_string();
    assert!(message("x,y,z\n1,2,3\n1,two,3\n").contains("b.csv:3: y = two: must be a number"));
    assert!(message("x,y,z\n1,2\n").contains("b.csv:2: 2 fields, but the header names 3 columns"));
    assert!(message("x,y\n1,2\n").contains("b.csv:1: z: missing column"));
    assert!(message("x,y,z,raduis\n").contains("b.csv:1: raduis: unknown column; did you mean `radius`?"));
    assert!(message("x,y,z,vx\n").contains("b.csv:1: vy: missing column"));
    assert!(message("x,y,z,x\n").contains("appears twice"));
    assert!(message("").contains("missing column"));
    let many = "x,y,z\n".to_owned() + &"a,b,c\n".repeat(50);
    assert!(message(&many).ends_with("and 130 more like these"));
}

#[test]
fn composites_keep_their_parts_and_fill_in_what_is_not_said() {
    let case = load("composites.toml");
    assert!(case.warnings.is_empty(), "{:?}", case.warnings);
    let ShapeKind::Glued { parts } = &case.shapes[0].kind else { panic!("glued") };
    assert_eq!((parts.len(), parts[0].at, parts[1].orientation), (6, [0.0, 0.0, 0.03], [1.0, 0.0, 0.0, 0.0]));
    assert!(matches!(&parts[5].kind, ShapeKind::HullFile { path, .. } if path.is_file()));
    assert_eq!(
        (case.shapes[0].crust, case.shapes[1].crust, case.shapes[5].crust),
        (Some(0.05), Some(0.02), None)
    );
    let ShapeKind::Cross { aspect_ratio, .. } = &case.shapes[4].kind else { panic!("cross") };
    assert_eq!(*aspect_ratio, Some(5.0));
    let ShapeKind::Mesh { resolution, max_parts, .. } = &case.shapes[8].kind else { panic!("mesh") };
    assert_eq!((*resolution, *max_parts), (64, 8));
    assert!(case.shapes[..8].iter().skip(1).all(|s| s.bounding_radius().is_some()));
}
/// Every key of the schema has a description, and every number in it a unit.
#[test]
fn the_schema_describes_every_key_with_its_unit() {
    let schema = schema();
    let mut keys = Vec::new();
    collect_keys(&schema, "", &mut keys);
    assert!(keys.len() > 100, "{}", keys.len());
    for (path, key) in &keys {
        let description = key.get("description").and_then(Value::as_str).unwrap_or_default();
        let kind = &key["type"];
        if !path.ends_with(".kind") {
            assert!(!description.is_empty(), "{path} has no description");
        }
        let is_number =
            [kind, &kind[0], &key["items"]["type"]].iter().any(|t| **t == "number" || **t == "integer");
        assert!(!is_number || description.contains('('), "{path}: no unit in `{description}`");
    }
}
#[test]
fn every_insertion_has_a_motion_of_its_own() {
    let text = r#"
        [domain]
        lower = [0, 0, 0]
        upper = [1, 1, 1]
        [time]
        end = 1
        [[material]]
        name = "glass"
        density = 2500
        [[material]]
        name = "steel"
        density = 7800
        [[contact]]
        between = ["glass", "glass"]
        normal_stiffness = 1e5
        restitution = 0.9
        friction = 0.3
        [[contact]]
        between = ["glass", "steel"]
        normal_stiffness = 1e5
        restitution = 0.9
        friction = 0.3
        [[shape]]
        name = "bead"
        kind = "sphere"
        radius = 0.02
        [[insert]]
        name = "bed"
        particles = [{ shape = "bead", material = "glass" }]
        count = 8
        place = { kind = "lattice", lower = [0, 0, 0], upper = [1, 1, 0.3] }
        [[insert]]
        name = "tubes"
        motion = "fixed"
        particles = [{ shape = "bead", material = "steel" }]
        count = 8
        place = { kind = "lattice", lower = [0, 0, 0.3], upper = [1, 1, 0.6] }
        [[insert]]
        name = "stirrer"
        motion = { kind = "rotation", axis = [0, 0, 2], angular_velocity = 3, start = 0.1 }
        particles = [{ shape = "bead", material = "steel" }]
        count = 8
        place = { kind = "lattice", lower = [0, 0, 0.6], upper = [1, 1, 0.9] }
    "#;
    let parse = |text: &str| Case::parse(text, "stirred.toml", Path::new(""));
    let case = parse(text).unwrap_or_else(|errors| panic!("{errors}"));
    assert!(!case.holds_particles() && case.warnings.is_empty(), "{:?}", case.warnings);
    let rotation = Motion::Rotation {
        point: None,
        axis: [0.0, 0.0, 1.0],
        angular_velocity: 3.0,
        start: 0.1,
        end: f64::INFINITY,
    };
    let wanted = [ParticleMotion::Free, ParticleMotion::Fixed, ParticleMotion::Prescribed(rotation)];
    assert_eq!(case.inserts.iter().map(|i| i.motion.clone().unwrap()).collect::<Vec<_>>(), wanted);
    assert_eq!(parse(&case.to_toml()).unwrap_or_else(|errors| panic!("{errors}")), case);
    // With a flow the default for all is its own.
    let flow =
        "[fluid]\ndensity = 1\nviscosity = 1e-5\ncells = [50, 50, 50]\nresolved = { motion = \"fixed\" }\n";
    let resolved = parse(&(text.to_owned() + flow)).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(resolved.inserts[0].motion, Some(ParticleMotion::Fixed));
    assert!(!resolved.holds_particles());
    // Who moves needs a law with everybody.
    let changed = text.replace("motion = \"fixed\"", "motion = \"free\"");
    let message = parse(&changed).expect_err("refused").to_string();
    assert!(message.contains("no contact law between \"steel\" and \"steel\""), "{message}");
    let warned = parse(&text.replace("motion = \"fixed\"", "motion = \"fixed\"\nvelocity = [1, 0, 0]"));
    let warned = warned.unwrap_or_else(|errors| panic!("{errors}")).warnings;
    assert!(warned.len() == 1 && warned[0].key == "insert[1].velocity", "{warned:?}");
}

/// The good files together use every key but the few that exclude each other.
#[test]
fn the_schema_has_every_key_of_the_resolved_cases() {
    let mut keys = Vec::new();
    collect_keys(&schema(), "", &mut keys);
    let known: Vec<&str> = keys.iter().filter_map(|(path, _)| path.rsplit('.').next()).collect();
    let resolved = GOOD.map(|name| load(name).to_toml()).concat();
    let used: Vec<&str> = resolved.lines().filter_map(|l| Some(l.split_once(" = ")?.0)).collect();
    used.iter().for_each(|key| assert!(known.contains(key), "{key} is not in the schema"));
    for key in known {
        let is_section = resolved.contains(&format!("[{key}]")) || resolved.contains(&format!(".{key}]"));
        assert!(is_section || used.contains(&key), "{key} is in no good case");
    }
}

fn collect_keys(schema: &Value, path: &str, keys: &mut Vec<(String, Value)>) {
    match schema {
        Value::Object(map) => {
            if let Some(properties) = map.get("properties").and_then(Value::as_object) {
                // `true` stands for a key that is described where it is common to all kinds.
                let own = properties.iter().filter(|(_, value)| value.is_object());
                keys.extend(own.map(|(key, value)| (format!("{path}.{key}"), value.clone())));
            }
            map.iter().for_each(|(key, value)| collect_keys(value, &format!("{path}.{key}"), keys));
        }
        Value::Array(list) => list.iter().for_each(|value| collect_keys(value, path, keys)),
        _ => {}
    }
}

#[test]
fn films_are_between_spheres_only() {
    let text = load("suspension.toml").to_toml();
    let parse = |text: &str| Case::parse(text, "suspension.toml", Path::new(""));
    let rods =
        text.replace("kind = \"sphere\"\nradius = 0.02", "kind = \"cylinder\"\nradius = 0.02\nheight = 0.04");
    assert_ne!(rods, text);
    let error = parse(&rods).expect_err("refused").to_string();
    assert!(error.contains("fluid.resolved.lubrication") && error.contains("`ball`"), "{error}");
    let held = text.replace("motion = \"free\"", "motion = \"fixed\"");
    let warnings = parse(&held).expect("held spheres").warnings;
    assert!(warnings.iter().any(|w| w.key == "fluid.resolved.lubrication"), "{warnings:?}");
}

/// A ball above the floor of a box, with some passages replaced.
fn impact_speed(edits: &[(&str, &str)]) -> f64 {
    let text = "gravity = [0, 0, -10]
domain = { lower = [0, 0, -1], upper = [2, 2, 3] }
time = { end = 1 }

[[material]]
name = \"glass\"
density = 2500

[[shape]]
name = \"ball\"
kind = \"sphere\"
radius = 0.01

[[insert]]
name = \"one\"
particles = [{ shape = \"ball\", material = \"glass\" }]
count = 1
place = { kind = \"window\", window = { kind = \"box\", lower = [1, 1, 1], upper = [1.5, 1.5, 1.8] } }
";
    let text = edits.iter().fold(text.to_string(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new)
    });
    Case::parse(&text, "fall.toml", Path::new(""))
        .unwrap_or_else(|errors| panic!("{errors}"))
        .time
        .impact_speed
}

#[test]
fn the_impact_speed_is_that_of_the_longest_fall_and_the_fastest_wall() {
    let close =
        |found: f64, wanted: f64| assert!((found / wanted - 1.0).abs() < 1e-5, "{found} for {wanted}");
    let count = |more: &'static str| ("count = 1", more);
    // From z = 1.8 to -1 m.
    close(impact_speed(&[]), 56.0_f64.sqrt());
    close(impact_speed(&[count("count = 1\nvelocity = [3, 0, 4]")]), 81.0_f64.sqrt());
    // Along x too, from x = 1 to 2 m.
    close(impact_speed(&[("[0, 0, -10]", "[5, 0, -10]")]), 66.0_f64.sqrt());
    let none = ("[0, 0, -10]", "[0, 0, 0]");
    close(impact_speed(&[none]), 1.0);
    close(impact_speed(&[none, count("count = 1\nvelocity = [0.1, 0, 0]")]), 0.1);
    close(impact_speed(&[("end = 1", "end = 1, impact_speed = 7")]), 7.0);
    let wall = |motion: &str| {
        let contact = "[[contact]]\nbetween = [\"glass\", \"glass\"]\nnormal_stiffness = 1e4\nrestitution = 0.9\nfriction = 0\n";
        let wall = "[[wall]]\nname = \"w\"\nmaterial = \"glass\"\nkind = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n";
        impact_speed(&[none, ("[[shape]]", &format!("{contact}{wall}motion = {{ {motion} }}\n\n[[shape]]"))])
    };
    close(wall("kind = \"translation\", velocity = [0, 3, 4]"), 5.0);
    let tau = std::f64::consts::TAU;
    close(wall("kind = \"oscillation\", amplitude = [0, 0, 0.02], frequency = 50"), tau);
    // To the corner that is farthest from the axis.
    let turning = "kind = \"rotation\", point = [0, 0, 0], axis = [0, 0, 2], angular_velocity = -3";
    close(wall(turning), 3.0 * 8.0_f64.sqrt());
}

/// Laws are asked for where two particles, or a particle and a wall, can be there together, and nowhere else.
#[test]
fn contact_laws_are_asked_for_where_pairs_can_meet() {
    let asked = |inserts: &[(&[&str], u64)], walls: &[(&str, f64)]| -> Vec<String> {
        let mut text = "[domain]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\n[time]\nend = 2\n".to_owned();
        text += "[[shape]]\nname = \"ball\"\nkind = \"sphere\"\nradius = 0.01\n";
        for name in ["a", "b", "c"] {
            text += &format!("[[material]]\nname = \"{name}\"\ndensity = 1000\n");
        }
        for (i, (materials, count)) in inserts.iter().enumerate() {
            let particles: Vec<String> =
                materials.iter().map(|m| format!("{{ shape = \"ball\", material = \"{m}\" }}")).collect();
            text += &format!(
                "[[insert]]\nname = \"i{i}\"\nparticles = [{}]\ncount = {count}\nplace = {{ kind = \"lattice\", lower = [0, 0, {}], \
                 upper = [1, 1, {}] }}\n",
                particles.join(", "),
                0.3 * i as f64,
                0.3 * i as f64 + 0.25
            );
        }
        for (i, (material, from)) in walls.iter().enumerate() {
            text += &format!(
                "[[wall]]\nname = \"w{i}\"\nmaterial = \"{material}\"\nkind = \"plane\"\npoint = [0, 0, 0]\n\
                 normal = [0, 0, 1]\nfrom = {from}\n"
            );
        }
        let Err(errors) = Case::parse(&text, "pairs.toml", Path::new("")) else { return Vec::new() };
        let mut pairs = Vec::new();
        for error in errors.0 {
            let message = error.to_string();
            let (_, rest) =
                message.split_once("no contact law between ").unwrap_or_else(|| panic!("{message}"));
            let mut quoted = rest.split('"').skip(1).step_by(2);
            let pair: [&str; 2] = std::array::from_fn(|_| quoted.next().unwrap_or_default());
            pairs.push(pair.concat());
        }
        pairs.sort();
        pairs
    };
    let none: [&str; 0] = [];
    assert_eq!(asked(&[(&["a"], 1)], &[]), none, "one alone");
    assert_eq!(asked(&[(&["a"], 2)], &[]), ["aa"]);
    assert_eq!(asked(&[(&["a"], 1), (&["a"], 1)], &[]), ["aa"], "two of one material");
    assert_eq!(asked(&[(&["a"], 9), (&["b"], 1)], &[]), ["aa", "ab"], "a single intruder");
    assert_eq!(asked(&[(&["a"], 1), (&["b"], 1), (&["c"], 1)], &[]), ["ab", "ac", "bc"]);
    assert_eq!(asked(&[(&["a", "b"], 1)], &[]), none, "one of either");
    assert_eq!(asked(&[(&["a", "b"], 2)], &[]), ["aa", "ab", "bb"]);
    assert_eq!(
        asked(&[(&["a"], 1)], &[("b", 0.0), ("c", 1.5)]),
        ["ab", "ac"],
        "walls, and none between them"
    );
    assert_eq!(asked(&[(&["a"], 1)], &[("b", 2.0)]), none, "a wall that never is");
}

#[test]
fn a_pressure_acts_on_the_face_across_its_axis_and_a_force_as_it_is() {
    let case = load("press.toml");
    let loads: Vec<_> = case.walls.iter().map(|wall| wall.motion.as_ref().and_then(Motion::load)).collect();
    assert_eq!(loads, [Some(100.0), Some(20.0)]);
    let Some(Motion::Load { axis, area, max_speed, .. }) = case.walls[0].motion else { panic!("lid") };
    assert_eq!((axis, area, max_speed), ([0.0, 0.0, -1.0], Some(1.0), f64::INFINITY));
}
