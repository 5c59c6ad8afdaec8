//! Files of meshes are read once for all ranks.

#![allow(clippy::unwrap_used)]

mod ranks;

use grains_domain::Transport;
use grains_geometry::{Rotation, SMOOTH_ANGLE, TriMesh, Vec3, WallMesh, write_stl};
use grains_simulation::{Case, catalogue, check, load};
use ranks::on_ranks;
use std::fs;
use std::path::Path;

/// A prism over an L, as long as wide.
fn angle() -> TriMesh {
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let vertices = [0.0, 1.0].iter().flat_map(|&z| corners.map(|[x, y]| Vec3::new(x, y, z))).collect();
    let sides = (0..6).map(|k| vec![k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6]);
    let faces: Vec<Vec<usize>> = sides.chain([(0..6).rev().collect(), (6..12).collect()]).collect();
    TriMesh::from_polygons(vertices, &faces).unwrap()
}

const CASE: &str = r#"
gravity = [0, 0, -9.81]
[domain]
lower = [0, 0, 0]
upper = [0.06, 0.03, 0.03]
[time]
end = 1e-3
dt = 1e-6
accept_coarse_dt = true
[[material]]
name = "glass"
density = 2500
[[contact]]
between = ["glass", "glass"]
normal_stiffness = 1e4
restitution = 0.8
friction = 0.3
[[shape]]
name = "angle"
kind = "mesh"
path = "angle.stl"
scale = 1e-3
max_parts = 4
[[shape]]
name = "hull"
kind = "hull_file"
path = "angle.stl"
scale = 1.5e-3
[[insert]]
name = "some"
particles = [{ shape = "angle", material = "glass" }, { shape = "hull", material = "glass" }]
count = 12
place = { kind = "lattice", lower = [0.005, 0.005, 0.015], upper = [0.055, 0.025, 0.028], spacing = 0.006 }
[[wall]]
name = "obstacle"
material = "glass"
kind = "mesh"
path = "obstacle.stl"
scale = 0.004
translate = [0.02, 0.01, 0.004]
fluid = "outside"
motion = { kind = "rotation", point = [0.024, 0.014, 0], axis = [0, 0, 1], angular_velocity = 2 }
[fluid]
density = 1.2
viscosity = 1.8e-5
cells = [24, 12, 12]
resolved = { motion = "free" }
[output]
directory = "results"
"#;

#[test]
fn after_the_case_is_loaded_nobody_reads_its_meshes_again() {
    on_ranks(&[1, 2, 3], "after_the_case_is_loaded_nobody_reads_its_meshes_again", |job| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("meshes-{}", job.size()));
        let (path, is_first) = (folder.join("case.toml"), job.transport().rank() == 0);
        let wait_for_all = || assert!(!job.transport().any(false));
        let meshes = ["angle.stl", "obstacle.stl"].map(|name| folder.join(name));
        if is_first {
            fs::create_dir_all(&folder).unwrap();
            fs::write(&path, CASE).unwrap();
            meshes.iter().for_each(|mesh| write_stl(&mut fs::File::create(mesh).unwrap(), &angle()).unwrap());
        }
        wait_for_all();
        let own = Case::load(&path).unwrap();
        let translate = Vec3::new(0.02, 0.01, 0.004);
        let wall = own.meshes.mesh(&meshes[1]).unwrap().transformed(&Rotation::identity(), 0.004, &translate);
        let wall = format!("{:?}", WallMesh::new(&wall, SMOOTH_ANGLE).unwrap());
        let alone = format!("{:?}", catalogue(&own).unwrap().shapes);
        let case = load(&path, job).unwrap();
        if is_first {
            meshes.iter().for_each(|mesh| fs::remove_file(mesh).unwrap());
        }
        wait_for_all();
        let of_node = case.meshes.wall(&own.walls[0].kind);
        assert_eq!(of_node.is_some(), job.size() > 1, "one copy per node");
        assert!(of_node.is_none_or(|of_node| format!("{of_node:?}") == wall), "the copy is the mesh");
        let shared = catalogue(&case).unwrap().shapes;
        assert!(shared[0].parts.len() > 1);
        // A shape says whether its parts were on disk: they were not when the first rank of all read them.
        let told = |text: &str| text.replace("cached: false", "cached: true");
        assert_eq!(told(&alone), told(&format!("{shared:?}")));
        let report = check::report_by(&case, job.size(), job).unwrap();
        assert!(report.fluid.unwrap().walls.is_some());
        wait_for_all();
        if is_first {
            fs::remove_dir_all(&folder).unwrap();
        }
    });
}
