//! Scripts become cases that hold.

#![allow(clippy::unwrap_used)]

mod common;

use common::{folder, imported};
use grains_case::{Motion, Place, ShapeKind, WallKind};
use grains_geometry::mesh_file::read_mesh;
use grains_import::{Options, Outcome, import};
use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::Path;

/// Elastic constants and other properties of one type.
const MATERIAL: &str = "fix m1 all property/global youngsModulus peratomtype 5.e6
fix m2 all property/global poissonsRatio peratomtype 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.3
fix m4 all property/global coefficientFriction peratomtypepair 1 0.5
fix m5 all property/global characteristicVelocity scalar 2.
fix g all gravity 9.81 vector 0 0 -1
timestep 1e-5
";

/// A plate of two triangles at a height of 1, four wide.
fn plate(home: &Path) {
    let corners = [[-2, -2, 1], [2, -2, 1], [2, 2, 1], [-2, 2, 1]];
    let facet = |three: [usize; 3]| {
        let vertex = |k: usize| format!("vertex {} {} {}\n", corners[k][0], corners[k][1], corners[k][2]);
        format!("facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n", three.map(vertex).concat())
    };
    let text = format!("solid plate\n{}{}endsolid\n", facet([0, 1, 2]), facet([0, 2, 3]));
    fs::write(home.join("plate.stl"), text).unwrap();
}

fn insertion(region: &str, how: &str) -> String {
    format!(
        "fix p1 all particletemplate/sphere 1 atom_type 1 density constant 2500 radius constant 0.002
fix p2 all particletemplate/sphere 1 atom_type 1 density constant 2500 radius constant 0.003
fix pd all particledistribution/discrete 1 2 p1 0.3 p2 0.7
region in {region} units box
fix ins all insert/pack seed 1 distributiontemplate pd insert_every once overlapcheck yes all_in yes {how} region in
"
    )
}

#[test]
fn shares_by_mass_become_shares_by_number_and_fractions_of_volume_counts() {
    let home = folder("scripts_shares");
    let script = format!(
        "units si\nboundary f f f\nregion r block -.1 .1 -.1 .1 0 .2 units box\ncreate_box 1 r\npair_style gran model hertz tangential history\n{MATERIAL}{}fix w all wall/gran model hertz tangential history primitive type 1 zcylinder 0.1 0.01 0.02\nrun 1000\n",
        insertion("cylinder z 0 0 0.08 0.02 0.18", "volumefraction_region 0.15")
    );
    let (case, _) = imported(&home, &script);
    let insert = &case.inserts[0];
    let [small, large] = [0, 1].map(|k| insert.particles[k].share);
    // Masses go with the cube of the radius.
    assert!((small * 8.0 / (large * 27.0) - 3.0 / 7.0).abs() < 1e-9, "{small} {large}");
    let volume = 4.0 / 3.0 * PI * (small * 8e-9 + large * 27e-9) / (small + large);
    // Centres keep the largest radius from the surface.
    let room = PI * 0.077 * 0.077 * (0.16 - 0.006);
    assert_eq!(insert.count, Some((0.15 * room / volume) as u64));
    // Places lie inside the cylinder.
    let [lower, upper] = insert.place.extents().unwrap();
    assert!(lower[0].hypot(lower[1]) < 0.0771 && upper[0].hypot(upper[1]) < 0.0771);
    let WallKind::Cylinder { center, radius, .. } = &case.walls[0].kind else { panic!("{:?}", case.walls) };
    assert_eq!((*radius, center[0], center[1]), (0.1, 0.01, 0.02));
}

#[test]
fn a_mesh_goes_on_from_where_its_first_motion_has_left_it() {
    let home = folder("scripts_motion");
    plate(&home);
    let script = format!(
        "units si\nboundary f f f\nregion r block -1 1 -1 1 -1 1 units box\ncreate_box 1 r\npair_style gran model hooke tangential history\n{MATERIAL}{}
fix cad all mesh/surface file plate.stl type 1 scale 0.1 rotate axis 0 1 0 angle 90
fix w all wall/gran model hooke tangential history mesh n_meshes 1 meshes cad
run 1000\nfix one all move/mesh mesh cad linear 0.5 0 -1\nrun 1000\nunfix one\nrun 500
fix two all move/mesh mesh cad rotate origin 0 0 0.2 axis 0 0 1 period 2\nrun 1500\n",
        insertion("block -.1 .1 -.1 .1 .5 .6", "particles_in_region 20")
    );
    let (case, _) = imported(&home, &script);
    let [first, second] = &case.walls[..] else { panic!("{:?}", case.walls) };
    assert_eq!((first.from, first.until, second.from), (0.0, 0.025, 0.025));
    let Some(Motion::Translation { velocity, start, end }) = &first.motion else {
        panic!("{:?}", first.motion)
    };
    assert_eq!((*velocity, *start, *end), ([0.5, 0.0, -1.0], 0.01, 0.02));
    let Some(Motion::Rotation { angular_velocity, start, .. }) = &second.motion else {
        panic!("{:?}", second.motion)
    };
    assert!((angular_velocity / (0.5 * TAU) - 1.0).abs() < 1e-11 && *start == 0.025);
    // The plate stands at x = 0.1 after its turn, and at 0.105 after its way.
    for (wall, x, z) in [(first, 0.1, 0.0), (second, 0.105, -0.01)] {
        let WallKind::Mesh { path, scale, translate } = &wall.kind else { panic!("{:?}", wall.kind) };
        assert_eq!((*scale, *translate), (1.0, [0.0; 3]));
        let (lower, upper) = read_mesh(path).unwrap().mesh.extents();
        assert!((lower.x - x).abs() < 1e-6 && (upper.x - x).abs() < 1e-6, "{lower} {upper}");
        assert!((upper.z - 0.2 - z).abs() < 1e-6 && (lower.z + 0.2 - z).abs() < 1e-6, "{lower} {upper}");
    }
}

/// The same scene in cgs and in SI units is the same case.
#[test]
fn a_script_in_cgs_is_that_in_si() {
    let script = |[l, m, p, s]: [f64; 4], units: &str| {
        // Lengths, masses, pressures and springs in units of the script.
        format!(
            "units {units}\natom_style sphere\nboundary p p f\nregion r block 0 {} 0 {} 0 {} units box\ncreate_box 1 r\ntimestep 1e-6
pair_style gran/hooke/history {} NULL 2000 NULL 0.5 1\npair_coeff * *\nfix g all gravity {} chute 20
fix w all wall/gran hertz/history {} NULL {} NULL 0.4 1 zplane 0 NULL wiggle z {} 0.01\nregion i block {} {} {} {} {} {} units box
fix i all pour 100 1 7 region i diam one {} dens {} {} vol 0.1 50\nrun 5000\n",
            0.02 * l, 0.02 * l, 0.06 * l, 1e5 * s, 9.81 * l, 1e8 * p, 1e8 / l, 1e-4 * l,
            0.002 * l, 0.018 * l, 0.002 * l, 0.018 * l, 0.03 * l, 0.05 * l,
            0.001 * l, 2500.0 * m / l.powi(3), 2500.0 * m / l.powi(3)
        )
    };
    let of = |name: &str, text: String| imported(&folder(name), &text).0;
    let si = of("scripts_si", script([1.0; 4], "si"));
    let cgs = of("scripts_cgs", script([100.0, 1e3, 10.0, 1e3], "cgs"));
    assert_eq!(si.domain, cgs.domain);
    let rounded = |case: &grains_case::Case| {
        let numbers = |text: String| {
            let words =
                text.split_whitespace().map(|w| match w.trim_end_matches([',', ']']).parse::<f64>() {
                    Ok(x) => format!("{x:.8e}"),
                    Err(_) => w.to_owned(),
                });
            words.collect::<Vec<_>>().join(" ")
        };
        numbers(format!("{:?} {:?} {:?} {:?}", case.contacts, case.materials, case.walls, case.inserts))
    };
    assert_eq!(rounded(&si), rounded(&cgs));
}

#[test]
fn superquadrics_and_multispheres_keep_their_form() {
    let home = folder("scripts_shapes");
    let common = "units si\nboundary f f f\nregion r block -.1 .1 -.1 .1 0 .2 units box\ncreate_box 1 r\npair_style gran model hertz tangential history\n";
    let script = format!(
        "{common}{MATERIAL}fix p all particletemplate/superquadric 1 atom_type 1 density constant 2500 shape constant 0.002 0.003 0.004 blockiness constant 8 4
fix q all particletemplate/multisphere 1 atom_type 1 density constant 2000 nspheres 2 ntry 1000 spheres 0 0 0 0.002 0.002 0 0 0.002 type 1
fix pd all particledistribution/discrete/numberbased 1 2 p 1 q 3\nregion in block -.09 .09 -.09 .09 .01 .19
fix ins all insert/pack seed 1 distributiontemplate pd insert_every once particles_in_region 50 region in\nrun 10\n"
    );
    let (case, _) = imported(&home, &script);
    let shape = |name: &str| &case.shapes[case.shape_index(name).unwrap()].kind;
    let ShapeKind::Superellipsoid { semi_axes, eps, .. } = shape("p") else { panic!("{:?}", shape("p")) };
    assert_eq!((*semi_axes, *eps), ([0.002, 0.003, 0.004], [0.25, 0.5]));
    let ShapeKind::Glued { parts } = shape("q") else { panic!("{:?}", shape("q")) };
    assert_eq!((parts.len(), parts[1].at), (2, [0.002, 0.0, 0.0]));
    assert_eq!(case.inserts[0].particles.iter().map(|c| c.share).collect::<Vec<_>>(), [0.25, 0.75]);
    // Single superquadrics at places, turned.
    let script = format!(
        "{common}atom_style superquadric\n{MATERIAL}create_atoms 1 single 0 0 0.05
set atom 1 shape 0.002 0.002 0.004 blockiness 4 2 density 2500 vz 0.1 quat 0 1 0 90\nrun 10\n"
    );
    let (case, _) = imported(&home, &script);
    let Place::File { path } = &case.inserts[0].place else { panic!("{:?}", case.inserts) };
    let table = grains_case::ParticleColumns::read_csv(path).unwrap();
    let half = 0.5_f64.sqrt();
    let [w, x, y, z] = table.orientation.unwrap()[0];
    assert!((w - half).abs() + x.abs() + (y - half).abs() + z.abs() < 1e-12);
    assert_eq!(table.velocity.unwrap()[0], [0.0, 0.0, 0.1]);
}

#[test]
fn counts_beyond_all_numbers_are_told() {
    let home = folder("scripts_counts");
    let sphere = "atom_type 1 density constant 2000";
    let commands = [
        ("fix f all property/global coefficientFriction peratomtypepair 7e99 0.5", "types have"),
        (
            &format!(
                "fix p all particletemplate/multisphere 1 {sphere} nspheres 7e99 ntry 9 spheres 0 0 0 1 type 1"
            ),
            "spheres have four numbers each",
        ),
        (
            "region r block 0 1 0 1 0 1\ncreate_box 7e99 r\ngroup g subtract all all",
            "types of particles are more than 10000",
        ),
    ];
    for (command, told) in commands {
        let script = home.join("in.script");
        fs::write(&script, format!("units si\n{command}\n")).unwrap();
        assert!(import(&[script], &home.join("case"), &Options::default()).is_err());
        let report = fs::read_to_string(home.join("case/import.txt")).unwrap();
        assert!(report.contains(told), "{command}: {report}");
    }
}

/// Every command is accounted for; what is not translated is said with its line, and the rest makes a case.
#[test]
fn what_is_not_translated_is_listed_with_its_line() {
    let home = folder("scripts_listed");
    let script = format!(
        "units si\nboundary m m m\nregion r block -.1 .1 -.1 .1 0 .2 units box\ncreate_box 1 r\npair_style gran model hertz tangential history cohesion easo/capillary/viscous\n{MATERIAL}{}
fix grow all adapt 1 atom diameter v_d\nfix w all wall/gran model hertz tangential history primitive type 1 zplane 0.0
if \"${{a}} == 1\" then \"run 1\"\nfix nobody all frobnicate 1 2\nrun ${{steps}}\nrun 100\n",
        insertion("block -.05 .05 -.05 .05 .05 .1", "particles_in_region 30")
    );
    let (case, done) = imported(&home, &script);
    let count = script.lines().filter(|line| !line.is_empty()).count();
    assert_eq!(done.report.commands.len(), count);
    assert_eq!(done.report.counts().iter().sum::<usize>(), count);
    let untranslated: Vec<(usize, &str)> = done
        .report
        .commands
        .iter()
        .filter(|(_, outcome)| matches!(outcome, Outcome::Untranslated(_)))
        .map(|(source, _)| (source.line, source.text.split(' ').next().unwrap()))
        .collect();
    let lines: Vec<&str> = script.lines().collect();
    assert_eq!(untranslated.len(), 4, "{untranslated:?}");
    assert!(untranslated.iter().all(|(line, word)| lines[line - 1].starts_with(word)), "{untranslated:?}");
    let partly =
        done.report.commands.iter().any(|(_, o)| matches!(o, Outcome::Partly(but) if but.contains("easo")));
    assert!(partly, "{}", done.report);
    assert!((case.time.end - 1e-3).abs() < 1e-15);
    assert!(done.report.to_string().contains("give --var steps=VALUE"));
}

#[test]
fn variables_of_the_user_and_included_scripts_count() {
    let home = folder("scripts_variables");
    fs::write(home.join("material.inc"), MATERIAL).unwrap();
    let script = format!(
        "units si\nboundary f f f\nvariable d index 1\nregion r block -$d $d -$d $d 0 $(2*v_d)\ncreate_box 1 r\ninclude material.inc\npair_style gran model hertz tangential history\n{}run 100\n",
        insertion("block -.05 .05 -.05 .05 .05 .1", "particles_in_region 30")
    );
    let path = home.join("in.script");
    fs::write(&path, script).unwrap();
    let options = Options { variables: vec![("d".into(), "0.25".into())], ..Options::default() };
    import(&[path], &home.join("case"), &options).unwrap();
    let case = grains_case::Case::load(home.join("case/case.toml")).unwrap();
    assert_eq!((case.domain.lower, case.domain.upper), ([-0.25, -0.25, 0.0], [0.25, 0.25, 0.5]));
    assert_eq!(case.materials[0].youngs_modulus, Some(5e6));
}
