//! Scripts of other codes become cases that run.

#![allow(clippy::unwrap_used)]

mod common;

use common::results::series;
use common::{ENVIRONMENT, Output, folder, run};
use std::fs;
use std::path::Path;
use std::process::Command;

/// What the program says of an import, without mpirun, in a folder.
fn import(home: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_grains-mpi");
    let mut command = Command::new(program);
    let output = command.arg("import").args(arguments).current_dir(home).envs(ENVIRONMENT).output().unwrap();
    let [stdout, stderr] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    Output { code: output.status.code(), stdout, stderr }
}

/// A square funnel in millimetres, closed at its lower end, as ascii STL.
fn funnel() -> String {
    let ring = |half: i32, z: i32| [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
    let (low, high) = (ring(6, 0), ring(24, 30));
    let mut triangles = vec![[low[0], low[1], low[2]], [low[0], low[2], low[3]]];
    for k in 0..4 {
        let next = (k + 1) % 4;
        triangles.push([low[k], low[next], high[next]]);
        triangles.push([low[k], high[next], high[k]]);
    }
    let vertex = |[x, y, z]: [i32; 3]| format!("vertex {x} {y} {z}\n");
    let facet = |corners: [[i32; 3]; 3]| {
        let corners: String = corners.into_iter().map(vertex).collect();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    format!("solid funnel\n{}endsolid\n", triangles.into_iter().map(facet).collect::<String>())
}

const SCRIPT: &str = "\
units si
atom_style granular
boundary f f f
variable d equal 4e-3
region box block -0.03 0.03 -0.03 0.03 -0.01 0.08 units box
create_box 1 box
fix m1 all property/global youngsModulus peratomtype 5.e6
fix m2 all property/global poissonsRatio peratomtype 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.4
fix m4 all property/global coefficientFriction peratomtypepair 1 0.5
fix m5 all property/global coefficientRollingFriction peratomtypepair 1 0.1
pair_style gran model hertz tangential history rolling_friction epsd2
pair_coeff * *
timestep 2e-5
fix g all gravity 9.81 vector 0 0 -1
fix funnel all mesh/surface file funnel.stl type 1 scale 0.001 &
    rotate axis 0 0 1 angle 45
fix walls all wall/gran model hertz tangential history mesh n_meshes 1 meshes funnel
fix grain all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant $(v_d/2)
fix grains all particledistribution/discrete 32452843 1 grain 1.0
region above block -0.012 0.012 -0.012 0.012 0.032 0.078 units box
fix ins all insert/pack seed 49979693 distributiontemplate grains vel constant 0 0 -0.5 &
    insert_every once overlapcheck yes all_in yes particles_in_region 60 region above
fix move all nve/sphere
fix flow all ave/time 1 1 100 f_walls file load.txt
thermo 100
dump d all custom 1000 post/*.dump id type x y z radius
run 1
unfix ins
run 3000 upto
";

/// A small hopper of LIGGGHTS passes the check without a remark and runs; what was left out is said.
#[test]
fn a_hopper_of_liggghts_runs() {
    let home = folder("import");
    fs::write(home.join("in.hopper"), SCRIPT).unwrap();
    fs::write(home.join("funnel.stl"), funnel()).unwrap();
    let told = import(&home, &["in.hopper", "--to", "hopper"]).succeeded().stdout;
    assert!(told.contains("1 not translated") && told.contains("fix flow all ave/time"), "{told}");
    assert!(told.contains("grains-mpi check hopper/case.toml"), "{told}");
    let checked = run(1, &home, &["check", "hopper/case.toml"]).succeeded();
    assert_eq!(checked.stderr, "");
    run(2, &home, &["hopper/case.toml"]).succeeded();
    let series = series(&home.join("results/hopper"));
    let times = series.column("time");
    assert!((times[times.len() - 1] - 0.06).abs() < 1e-9, "{times:?}");
    assert!(series.column("particles").iter().all(|count| *count == 60.0));
    // They have come to rest on the funnel, which bears some of their weight already.
    let load = series.column("funnel_fz");
    assert!(load[load.len() - 1] < 0.0, "{load:?}");
}

/// A script that makes no case ends with one message that names what is missing, and the report all the same.
#[test]
fn a_script_without_particles_says_so() {
    let home = folder("import_nothing");
    let text = SCRIPT.replace("fix ins all insert/pack", "fix ins all insert/none");
    fs::write(home.join("in.empty"), text).unwrap();
    fs::write(home.join("funnel.stl"), funnel()).unwrap();
    let output = import(&home, &["in.empty", "--to", "empty"]);
    let message = output.only_error(2);
    assert!(message.starts_with("no case: the script has no particles"), "{message}");
    let report = fs::read_to_string(home.join("empty/import.txt")).unwrap();
    assert!(report.contains("no word of a case is fix insert/none"), "{report}");
    let output = import(&home, &["nowhere"]);
    let message = output.only_error(4);
    assert!(message.starts_with("nowhere: "), "{message}");
}
