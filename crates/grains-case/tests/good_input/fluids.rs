//! Fluids in good cases: defaults, and what is warned about.

use grains_case::{
    Advection, BoundaryKind, Case, DragLaw, Extrapolation, Face, FluidSide, Kernel, MixtureModel, OnFace,
    ResolvedMethod,
};
use std::path::Path;

use super::{folder, load};

const WALL: &str = "[[material]]\nname = \"steel\"\n[[wall]]\nname = \"floor\"\nmaterial = \"steel\"\nkind = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n[fluid]\n";

#[test]
fn a_fluid_alone_needs_no_particles() {
    let case = load("channel.toml");
    assert!(case.warnings.is_empty(), "{:?}", case.warnings);
    assert!(case.materials.is_empty() && case.shapes.is_empty() && case.inserts.is_empty());
    let empty = ["shape", "insert", "contact", "wall"].map(|key| format!("{key} = []\n")).concat();
    let with_empty_lists = format!("name = \"channel\"\nmaterial = []\n{empty}");
    let text = std::fs::read_to_string(folder().join("channel.toml")).expect("text");
    assert_eq!(Case::parse(&(with_empty_lists + &text), "channel.toml", &folder()), Ok(case.clone()));
    let fluid = case.fluid.expect("fluid");
    assert_eq!((fluid.advection, fluid.output.interval), (Some(Advection::Central), Some(0.1)));
    assert_eq!(fluid.on_face(Face::LowerY), OnFace { whole: None, patches: vec![3] });
    assert_eq!(fluid.on_face(Face::UpperY), OnFace { whole: Some(2), patches: vec![4] });
    let BoundaryKind::Inlet { velocity } = &fluid.boundary[3].kind else { panic!("inlet") };
    let blown = velocity[1].compile().expect("formula");
    assert!(blown.is_unsteady() && (blown.at([0.025, 0.0, 0.0], 1e9) - 0.01).abs() < 1e-17);
    let velocity = fluid.initial.velocity[0].compile().expect("formula");
    assert!((velocity.at([0.04, 0.01, 0.0], 0.0) - (0.05 - 1e-3 / std::f64::consts::E)).abs() < 1e-17);
}

#[test]
fn a_bed_takes_its_defaults_from_the_particles() {
    let case = load("bed.toml");
    assert!(case.warnings.is_empty(), "{:?}", case.warnings);
    let fluid = case.fluid.expect("fluid");
    assert_eq!((fluid.advection, fluid.output.interval), (Some(Advection::VanLeer), Some(0.1)));
    assert_eq!(fluid.max_dt, None, "it does not follow the end of the run");
    let coupling = fluid.coupling.expect("coupling");
    assert_eq!((coupling.drag, coupling.model), (DragLaw::Beetstra, MixtureModel::B));
    assert_eq!((coupling.kernel, coupling.particle_steps), (Kernel::Smooth { half_width: 2.0 }, Some(10)));
}

#[test]
fn a_case_may_choose_any_drag_law() {
    let text = std::fs::read_to_string(folder().join("bed.toml")).expect("text");
    for &law in DragLaw::ALL {
        let serde_json::Value::String(name) = serde_json::json!(law) else { panic!("{law:?} has no name") };
        let text = text.replace("\"beetstra\"", &format!("{name:?}"));
        let case = Case::parse(&text, "bed.toml", &folder()).expect("case");
        assert_eq!(case.fluid.and_then(|fluid| fluid.coupling).map(|coupling| coupling.drag), Some(law));
    }
}

/// What is odd about a fluid but no mistake.
#[test]
fn unlikely_fluids_are_warned_about() {
    let warnings = |name: &str, from: &str, to: &str| {
        let text = std::fs::read_to_string(folder().join(name)).expect("text");
        assert!(text.contains(from), "{from}");
        let case = Case::parse(&text.replace(from, to), name, &folder());
        let case = case.unwrap_or_else(|errors| panic!("{errors}"));
        let warnings: Vec<String> = case.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        warnings.concat()
    };
    let top = "[[fluid.boundary]]\nface = \"+z\"\nkind = \"symmetry\"\n";
    let cases = [
        (
            "channel.toml",
            "cells = [48, 32, 1]",
            "cells = [48, 2500, 1]",
            "some cells are 1042.4 times longer along x than along y",
        ),
        (
            "channel.toml",
            "[[fluid.profile]]\nname = \"middle\"",
            "[fluid.coupling]\ndrag = \"ergun\"\n[[fluid.profile]]\nname = \"middle\"",
            "fluid.coupling: without effect",
        ),
        (
            "channel.toml",
            "refinement = [0, 1.5, 0]",
            "refinement = [0, 1.5, 1]",
            "without effect on 1 cell(s)",
        ),
        (
            "channel.toml",
            "[fluid.drive]",
            &format!("{top}\n[fluid.drive]"),
            "without effect: fluid.boundary[5] holds",
        ),
        (
            "channel.toml",
            "method = \"petsc\"",
            "method = \"conjugate_gradients\"",
            "only PETSc reads options",
        ),
        ("channel.toml", "interval = 0.1", "interval = 3", "longer than the run (2 s)"),
        (
            "channel.toml",
            "\"-2 * cos(2*pi*x/0.06)\"",
            "\"ln(-x)\"",
            "fluid.initial.pressure = \"ln(-x)\": is NaN at",
        ),
        ("channel.toml", "[fluid]\n", WALL, "wall[0]: without effect"),
        (
            "bed.toml",
            "velocity = [0, 0, 0]",
            "velocity = [0, 1, 0]",
            "fluid.drive.velocity[1] = 1: without effect",
        ),
        (
            "bed.toml",
            "cells = [11, 3, 40]",
            "cells = [50000, 9000, 150000]",
            "times thinner than the smallest particle",
        ),
    ];
    for (name, from, to, expected) in cases {
        let warning = warnings(name, from, to);
        assert!(warning.contains(expected), "{warning}");
    }
}

#[test]
fn bodies_that_are_held_need_no_contacts() {
    let case = load("bodies.toml");
    assert!(case.warnings.is_empty() && case.holds_particles(), "{:?}", case.warnings);
    let resolved = case.fluid.as_ref().and_then(|f| f.resolved.clone()).expect("resolved");
    assert_eq!((resolved.method, resolved.iterations), (ResolvedMethod::Multiplier, 200));
    let text = case.to_toml();
    let refused = |old: &str, new: &str| {
        let changed = text.replace(old, new);
        assert_ne!(changed, text, "{old}");
        Case::parse(&changed, "bodies.toml", Path::new("")).expect_err("refused").to_string()
    };
    let message = refused("motion = \"fixed\"", "motion = \"free\"");
    assert!(message.contains("no contact law between \"nylon\" and \"nylon\""), "{message}");
    let message = refused("refinement = [0.0, 0.0, 0.0]", "refinement = [0.0, 1.0, 0.0]");
    assert!(message.contains("fluid.refinement") && message.contains("equal cells"), "{message}");
    let message = refused("[fluid.resolved]", "[fluid.coupling]\ndrag = \"ganser\"\n[fluid.resolved]");
    assert!(message.contains("either resolved or coupled"), "{message}");
    let message = refused("cells = [64, 32, 32]", "cells = [64, 32, 128]");
    assert!(message.contains("fluid.cells") && message.contains("do not resolve particles"), "{message}");
    let message = refused("point_spacing = 1.2", "point_spacing = 0.2");
    assert!(message.contains("point_spacing"), "{message}");
    let message = refused("diffusion_number = 2.0", "diffusion_number = 2.01");
    assert!(message.contains("fluid.resolved.diffusion_number") && message.contains("beyond 2"), "{message}");
    let message = refused("bodies = [0, 1]", "bodies = [1, 0, 1]");
    assert!(message.contains("fluid.output.bodies") && message.contains("1 is there twice"), "{message}");
    // ν Δt/Δx² of 2 with ν = 1e-5 m²/s on cells of 1/320 m.
    let message = refused("end = 1.0\ndt = \"auto\"", "end = 10.0\ndt = 1.96");
    assert!(message.contains("time.dt") && message.contains("1.953"), "{message}");
    let parabolas = text.replace("method = \"multiplier\"", "method = \"direct\"");
    let parabolas = parabolas.replace("diffusion_number = 2.0", "diffusion_number = 20.0");
    assert!(Case::parse(&parabolas, "bodies.toml", Path::new("")).is_ok(), "{parabolas}");
}

/// Fixed and free particles and ones of prescribed motion in one case, which needs laws only for those that meet.
#[test]
fn walls_of_a_fluid_alone_resolve_it() {
    let case = load("pipe.toml");
    assert!(case.warnings.is_empty(), "{:?}", case.warnings);
    let sides: Vec<Option<FluidSide>> = case.walls.iter().map(|wall| wall.fluid).collect();
    let [particles, outside] = [FluidSide::Particles, FluidSide::Outside].map(Some);
    assert_eq!(sides, [particles, outside, particles, outside]);
    let extrapolation = |case: &Case| case.resolved().map(|r| r.extrapolation(&case.inserts));
    // Parabolas where a wall moves, cubics where none does.
    assert_eq!(extrapolation(&case), Some(Extrapolation::Quadratic));
    let text = std::fs::read_to_string(folder().join("pipe.toml")).expect("text");
    let motion = text.lines().find(|line| line.starts_with("motion")).expect("a motion");
    let still = Case::parse(&text.replace(motion, ""), "pipe.toml", &folder()).expect("case");
    assert_eq!(extrapolation(&still), Some(Extrapolation::Cubic));
    let unbounded = text.replace("fluid = \"particles\"", "").replace("fluid = \"outside\"", "");
    let unbounded = Case::parse(&unbounded, "pipe.toml", &folder()).expect("case");
    assert!(unbounded.resolved().is_none() && unbounded.warnings.len() == 1, "{:?}", unbounded.warnings);
}
