//! Where particles and walls come from: files and windows.

#![allow(clippy::unwrap_used)]

mod common;

use common::results::{assert_same_state, checkpoints, series, state};
use common::{case, folder, replaced, run_case};
use hdf5::types::VarLenUnicode;
use std::fmt::Write;
use std::fs;

const LATTICE: &str =
    "{ kind = \"lattice\", lower = [0.02, 0.01, 0.02], upper = [0.07, 0.055, 0.05], spacing = 0.011 }";

/// Balls and cubes: x, y, z, vx, shape.
const LISTED: [([f64; 4], &str); 3] = [
    ([0.021, 0.02, 0.03, 0.1], "ball"),
    ([0.04, 0.021, 0.03, -0.05], "cube"),
    ([0.0605, 0.02, 0.031, 0.0], "ball"),
];

fn listed_in(file: &str) -> String {
    let text = replaced(&case("base.toml"), LATTICE, &format!("{{ kind = \"file\", path = \"{file}\" }}"));
    let cube = "[[shape]]\nname = \"cube\"\nkind = \"box\"\nedges = [8e-3, 8e-3, 8e-3]\n\n[[insert]]";
    // What is foretold of the surfaces asks every rank for its rows.
    let text = replaced(&text, "particles = 0.01\n", "particles = 0.01\nsurfaces = 0.02\n");
    replaced(&replaced(&text, "count = 16\n", ""), "[[insert]]", cube)
}

#[test]
fn particles_from_csv_and_hdf5_are_those_listed() {
    let home = folder("insertion_files");
    let mut text = String::from("# balls and a cube\nx,y,z,vx,vy,vz,shape\n");
    LISTED.iter().for_each(|([x, y, z, vx], shape)| {
        let _ = writeln!(text, "{x},{y},{z},{vx},0,0,{shape}");
    });
    fs::write(home.join("listed.csv"), text).unwrap();
    let file = hdf5::File::create(home.join("listed.h5")).unwrap();
    for (k, name) in ["x", "y", "z", "vx"].into_iter().enumerate() {
        let column: Vec<f64> = LISTED.iter().map(|(row, _)| row[k]).collect();
        file.new_dataset_builder().with_data(&column).create(name).unwrap();
    }
    for name in ["vy", "vz"] {
        file.new_dataset_builder().with_data(&[0.0; 3]).create(name).unwrap();
    }
    let shapes: Vec<VarLenUnicode> = LISTED.iter().map(|(_, shape)| shape.parse().unwrap()).collect();
    file.new_dataset_builder().with_data(&shapes).create("shape").unwrap();
    file.close().unwrap();
    let end = |file: &str, ranks: usize| {
        run_case(ranks, &home, &listed_in(file), &[]).succeeded();
        checkpoints(&home.join("results")).pop().unwrap()
    };
    let of_csv = home.join("of_csv.h5");
    fs::copy(end("listed.csv", 2), &of_csv).unwrap();
    // Of four ranks one has no row to read.
    [("listed.csv", 4), ("listed.h5", 2), ("listed.h5", 4)]
        .into_iter()
        .for_each(|(file, ranks)| assert_same_state(&of_csv, &end(file, ranks)));
    for (particle, ([_, y, _, vx], shape)) in state(&of_csv).iter().zip(LISTED) {
        // id shape material sides position*3 velocity*3
        let value = |k: usize| f64::from_bits(particle.state[k]);
        assert_eq!(value(1), if shape == "cube" { 1.0 } else { 0.0 });
        // They have only fallen.
        assert!((value(5) - y).abs() < 1e-12 && (value(7) - vx).abs() < 1e-12, "particle {}", particle.id);
    }
}

/// Balls of three sizes and two kinds of glass on a grid, in an order that is not that of their places; every fifth line
/// is a comment.
fn scattered() -> String {
    let mut text = String::from("\n# balls\nx,y,z,vx,vy,vz,scale,material\n");
    for k in 0..40 {
        let site = k * 17 % 40;
        let [x, y, z] = [site % 5, site / 5 % 4, site / 20].map(|n| 0.0125 * f64::from(n));
        let (scale, glass) = (0.8 + 0.1 * f64::from(k % 3), ["glass", "wall"][usize::from(k == 39)]);
        let _ = writeln!(text, "{},{},{},0.{k:02},0.1,-0.1,{scale},{glass}", 0.012 + x, 0.012 + y, 0.012 + z);
        if k % 5 == 4 {
            text += "# five more\n";
        }
    }
    text
}

#[test]
fn a_file_brings_the_same_particles_on_any_number_of_ranks_also_in_batches() {
    let home = folder("insertion_shares");
    fs::write(home.join("balls.csv"), scattered()).unwrap();
    let text = listed_in("balls.csv");
    let text = replaced(&text, "name = \"wall\"\n", "name = \"wall\"\ndensity = 2000\n");
    let text = text
        + "\n[[contact]]\nbetween = [\"wall\", \"wall\"]\nnormal_stiffness = 1e4\nrestitution = 0.7\nfriction = 0.3\n";
    let batches = replaced(
        &text,
        "[{ shape = \"ball\", material = \"glass\" }]",
        "[{ shape = \"ball\", material = \"glass\" }]\nbatch = 16\ninterval = 3e-3",
    );
    let end = |text: &str, ranks: usize, arguments: &[&str]| {
        run_case(ranks, &home, text, arguments).succeeded();
        let kept = home.join(format!("{ranks}.h5"));
        fs::rename(checkpoints(&home.join("results")).pop().unwrap(), &kept).unwrap();
        kept
    };
    for text in [&text, &batches] {
        let wanted = end(text, 1, &[]);
        assert_eq!(state(&wanted).len(), 40);
        [2, 4].into_iter().for_each(|ranks| assert_same_state(&wanted, &end(text, ranks, &[])));
    }
    // The batch that a restart finds due comes from the rows of other ranks.
    let short = replaced(&batches, "end = 0.02", "end = 0.004");
    run_case(2, &home, &short, &[]).succeeded();
    assert_same_state(&home.join("1.h5"), &end(&batches, 3, &["--restart", "latest"]));
    // The last snapshot of a run is as good as a table.
    let next = replaced(&text, "balls.csv", "results/particles.vtkhdf");
    let next = replaced(&next, "directory = \"results\"", "directory = \"next\"");
    for ranks in [1, 3] {
        run_case(ranks, &home, &next, &[]).succeeded();
        fs::rename(checkpoints(&home.join("next")).pop().unwrap(), home.join(format!("next-{ranks}.h5")))
            .unwrap();
    }
    assert_same_state(&home.join("next-1.h5"), &home.join("next-3.h5"));
}

/// Sizes depend on the seed and the identity of a particle alone: not on ranks, and not on where a restart begins.
#[test]
fn sizes_by_mass_are_the_same_on_any_number_of_ranks_and_after_a_restart() {
    let home = folder("insertion_sizes");
    let text = case("gravel.toml");
    let end = |name: &str, text: &str, ranks: usize, arguments: &[&str]| {
        run_case(ranks, &home, text, arguments).succeeded();
        let kept = home.join(format!("{name}.h5"));
        fs::rename(checkpoints(&home.join("results")).pop().unwrap(), &kept).unwrap();
        kept
    };
    let wanted = end("serial", &text, 1, &[]);
    [2, 4].into_iter().for_each(|ranks| assert_same_state(&wanted, &end("parallel", &text, ranks, &[])));
    let snapshot = home.join("results/particles.vtkhdf");
    let [ids, scales] = ["id", "scale"].map(|name| last(&snapshot, &format!("PointData/{name}"), 200));
    let of_gravel = ids.iter().zip(scales).filter(|(id, _)| **id < 120.0);
    let diameters: Vec<f64> = of_gravel.map(|(_, scale)| 4e-3 * scale).collect();
    assert!(diameters.len() == 120 && diameters.iter().all(|d| (2e-3..=8e-3).contains(d)), "{diameters:?}");
    // A tenth of the mass, and 32.5 % of the number: 39 with a standard deviation of 5.
    let fine = diameters.iter().filter(|d| **d < 2.8e-3).count();
    assert!((19..=59).contains(&fine), "{fine}");
    let short = replaced(&text, "end = 0.02", "end = 0.004");
    run_case(2, &home, &short, &[]).succeeded();
    assert_same_state(&wanted, &end("restarted", &text, 3, &["--restart", "latest"]));
}

#[test]
fn what_is_wrong_in_a_share_of_a_file_is_told_by_its_line() {
    let home = folder("insertion_wrong_lines");
    let text = listed_in("balls.csv");
    let message = |file: &str, ranks: usize| {
        fs::write(home.join("balls.csv"), file).unwrap();
        run_case(ranks, &home, &text, &[]).only_error(2).to_string()
    };
    for ranks in [1, 3] {
        let outside = message(&scattered().replace("0.39,0.1,-0.1", "0.39,0.1,nan"), ranks);
        assert!(outside.contains("balls.csv:50: vx, vy, vz"), "{ranks} ranks: {outside}");
        let material = message(&scattered(), ranks);
        assert!(
            material.contains("balls.csv:50: material = wall: has no density"),
            "{ranks} ranks: {material}"
        );
        let header = message(&scattered().replace("scale", "size"), ranks);
        assert!(header.contains("balls.csv:3: size: unknown column"), "{ranks} ranks: {header}");
    }
}

/// Spheres that stay where they are meet nobody later, but find room like all others, also where they lie on a periodic face.
#[test]
fn fixed_spheres_at_random_do_not_overlap() {
    let home = folder("insertion_fixed");
    let text = r#"[domain]
lower = [0, 0, 0]
upper = [4, 3, 3]
periodic = [true, true, false]

[time]
end = 0.001
dt = 0.001

[[material]]
name = "solid"
density = 1000

[[shape]]
name = "ball"
kind = "sphere"
radius = 0.5

[[insert]]
name = "bed"
particles = [{ shape = "ball", material = "solid", scale = { kind = "uniform", min = 0.6, max = 1 } }]
count = 24
motion = "fixed"
place = { kind = "window", window = { kind = "box", lower = [0, 0, 0.5], upper = [4, 3, 2.5] }, attempts = 100000 }

[fluid]
density = 1
viscosity = 1
cells = [16, 12, 12]
resolved = { motion = "fixed" }

[output]
directory = "results"
"#;
    let mut known = None;
    for ranks in [1, 2] {
        let own = home.join(ranks.to_string());
        fs::create_dir_all(&own).unwrap();
        run_case(ranks, &own, text, &[]).succeeded();
        let file = hdf5::File::open(own.join("results/particles.vtkhdf")).unwrap();
        let read = |name: &str| file.dataset(&format!("VTKHDF/{name}")).unwrap().read_raw::<f64>().unwrap();
        let (points, radii) = (read("Points"), read("PointData/radius"));
        let balls: Vec<([f64; 3], f64)> = points
            .chunks_exact(3)
            .zip(&radii)
            .take(24)
            .map(|(at, radius)| ([at[0], at[1], at[2]], *radius))
            .collect();
        for (k, (a, r)) in balls.iter().enumerate() {
            for (b, s) in &balls[..k] {
                let apart = |i: usize| {
                    let d = (a[i] - b[i]).abs();
                    if i < 2 { d.min([4.0, 3.0][i] - d) } else { d }
                };
                let distance = (0..3).map(|i| apart(i).powi(2)).sum::<f64>().sqrt();
                assert!(distance > r + s - 1e-9, "{a:?} {b:?} are {distance} apart");
            }
        }
        let mut sorted: Vec<[u64; 3]> = balls.iter().map(|(at, _)| at.map(f64::to_bits)).collect();
        sorted.sort_unstable();
        let first = known.get_or_insert_with(|| sorted.clone());
        assert_eq!(*first, sorted, "on {ranks} ranks");
    }
}

#[test]
fn a_point_feeds_particles_one_by_one_as_soon_as_there_is_room() {
    let home = folder("insertion_point");
    let place =
        "{ kind = \"window\", attempts = 1, window = { kind = \"point\", at = [0.04, 0.03, 0.045] } }";
    let text = replaced(&case("base.toml"), LATTICE, place);
    let text = replaced(&text, "count = 16", "count = 16\nbatch = 1\ninterval = 1e-3\nvelocity = [0, 0, -1]");
    let output = run_case(2, &home, &text, &[]).succeeded();
    let inserted = series(&home.join("results")).column("inserted");
    // At 1 m/s a ball of 1 cm clears the point in 10 ms; the millisecond of the interval has to wait.
    let waiting = inserted.windows(2).filter(|w| w[0] == w[1]).count();
    assert!(inserted[0] == 1.0 && *inserted.last().unwrap() == 3.0 && waiting > 15, "{inserted:?}");
    assert!(output.stdout.contains("13 particles of insert `balls` were not inserted"), "{}", output.text());
}

/// The polygons of the test silo, as in its case file, and the vertices.
fn polygons() -> (String, Vec<[f64; 3]>, Vec<[usize; 4]>) {
    let text = case("silo.toml");
    let begin = text.find("kind = \"polygons\"").unwrap();
    let passage = &text[begin..text[begin..].find("\n\n").unwrap() + begin];
    let table: toml::Table = toml::from_str(passage).unwrap();
    let numbers = |value: &toml::Value| -> Vec<f64> {
        let list = value.as_array().unwrap().iter();
        list.map(|x| x.as_float().or(x.as_integer().map(|i| i as f64)).unwrap()).collect()
    };
    let rows = |key: &str| table[key].as_array().unwrap().iter().map(numbers).collect::<Vec<_>>();
    let vertices = rows("vertices").iter().map(|v| [v[0], v[1], v[2]]).collect();
    let faces = rows("faces").iter().map(|f| [0, 1, 2, 3].map(|k| f[k] as usize)).collect();
    (passage.to_string(), vertices, faces)
}

#[test]
fn a_silo_from_stl_is_the_silo_of_polygons() {
    let home = folder("insertion_stl");
    let (passage, vertices, faces) = polygons();
    let mut stl = String::from("solid silo\n");
    for [a, b, c, d] in faces {
        for triangle in [[a, b, c], [a, c, d]] {
            stl += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in triangle.map(|k| vertices[k]) {
                let _ = writeln!(stl, "vertex {x:?} {y:?} {z:?}");
            }
            stl += "endloop\nendfacet\n";
        }
    }
    fs::write(home.join("silo.stl"), stl + "endsolid silo\n").unwrap();
    let text = case("silo.toml");
    let end = |text: &str| {
        run_case(2, &home, text, &[]).succeeded();
        checkpoints(&home.join("results")).pop().unwrap()
    };
    let of_polygons = home.join("polygons.h5");
    fs::copy(end(&text), &of_polygons).unwrap();
    let of_stl = end(&replaced(&text, &passage, "kind = \"mesh\"\npath = \"silo.stl\""));
    assert_same_state(&of_polygons, &of_stl);
    // No bead is between the walls and the box, where only a leak would bring it.
    for particle in state(&of_stl) {
        let [x, y, z] = [4, 5, 6].map(|k| f64::from_bits(particle.state[k]));
        let half_width = if z < 0.03 { 0.015 + z / 0.03 * 0.02 } else { 0.035 };
        assert!(z < 0.0 || x.abs().max(y.abs()) < half_width, "particle {} at {x} {y} {z}", particle.id);
    }
}

/// Every kind of shape, off their origins and turned in their own coordinates where they can be.
const SHAPES: [(&str, &str); 13] = [
    ("sphere", "kind = \"sphere\"\nradius = 2e-3"),
    ("box", "kind = \"box\"\nedges = [3e-3, 4e-3, 5e-3]"),
    ("cylinder", "kind = \"cylinder\"\nradius = 1.5e-3\nheight = 4e-3"),
    ("regular", "kind = \"regular\"\nsolid = \"tetrahedron\"\ncircumradius = 2e-3"),
    ("superellipsoid", "kind = \"superellipsoid\"\nsemi_axes = [1e-3, 3e-3, 2e-3]\neps = [0.5, 0.8]"),
    (
        "hull",
        "kind = \"hull\"\nvertices = [[0, 0, 0], [3e-3, 0, 0], [3e-3, 2e-3, 0], [0, 2e-3, 1e-3], [1e-3, 1e-3, 4e-3]]",
    ),
    ("hull_file", "kind = \"hull_file\"\npath = \"tetrahedron.stl\"\nscale = 1e-3"),
    (
        "glued",
        "kind = \"glued\"\nparts = [{ kind = \"sphere\", radius = 1e-3, at = [2e-3, 1e-3, 0] }, { kind = \"box\", edges = [4e-3, 1e-3, 2e-3], orientation = [0.9, 0.1, 0.2, 0.3] }]",
    ),
    ("lobes", "kind = \"lobes\"\nlobes = 3\ndiameter = 3e-3\nlength = 4e-3\narea_fraction = 0.69"),
    ("cross", "kind = \"cross\"\nbeams = 2\nbeam_width = 1e-3\nbeam_length = 4e-3"),
    ("spheres", "kind = \"sphere_cylinder\"\nradius = 2e-3\nheight = 4e-3\nlayers = 2\nrings = [1, 6]"),
    ("slices", "kind = \"sliced_cylinder\"\nradius = 1e-3\nheight = 4e-3\nslices = 3"),
    ("mesh", "kind = \"mesh\"\npath = \"tetrahedron.stl\"\nscale = 1e-3"),
];

/// Corners of the file of a shape (mm).
const TETRAHEDRON: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [4.0, 1.0, 1.0], [1.0, 3.5, 1.0], [1.5, 1.0, 3.0]];

fn stl() -> String {
    let facet = |[a, b, c]: [usize; 3]| {
        let vertex = |k: usize| TETRAHEDRON[k].map(|x| x.to_string()).join(" ");
        format!(
            "facet normal 0 0 0\nouter loop\nvertex {}\nvertex {}\nvertex {}\nendloop\nendfacet\n",
            vertex(a),
            vertex(b),
            vertex(c)
        )
    };
    format!("solid t\n{}endsolid t\n", [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(facet).concat())
}

/// Bodies of all kinds, at rest and apart, put where `place` says.
fn assortment(place: &str, directory: &str) -> String {
    let text = replaced(&case("base.toml"), LATTICE, place);
    let shapes = SHAPES.map(|(name, keys)| format!("[[shape]]\nname = \"{name}\"\n{keys}\n\n")).concat();
    let mixture =
        SHAPES.map(|(name, _)| format!("{{ shape = \"{name}\", material = \"glass\" }}")).join(", ");
    let edits = [
        ("name = \"base\"", "name = \"all\"\ngravity = [0, 0, 0]"),
        ("[[shape]]\nname = \"ball\"\nkind = \"sphere\"\nradius = 5e-3\n\n", &*shapes),
        ("[{ shape = \"ball\", material = \"glass\" }]", &*format!("[{mixture}]")),
        ("count = 16\n", if place.contains("file") { "" } else { "count = 100\n" }),
        ("dt = 4e-5", "dt = 1e-6\naccept_coarse_dt = true"),
        ("end = 0.02", "end = 2e-6"),
        ("particles = 0.01", "particles = 1\nsurfaces = 1"),
        ("directory = \"results\"", &*format!("directory = \"{directory}\"")),
    ];
    edits.iter().fold(text, |text, (old, new)| replaced(&text, old, new))
}

/// The arrays of the only or last state of a file, of rows of so many numbers.
fn last(path: &std::path::Path, array: &str, count: usize) -> Vec<f64> {
    let file = hdf5::File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let values = file.dataset(&format!("VTKHDF/{array}")).unwrap().read_raw::<f64>().unwrap();
    values[values.len() - count..].to_vec()
}

/// Corners of the triangles of each body (m), by its id.
fn surfaces(folder: &std::path::Path) -> Vec<Vec<[f64; 3]>> {
    let file = hdf5::File::open(folder.join("surfaces.vtkhdf")).unwrap();
    let numbers = |array: &str| file.dataset(&format!("VTKHDF/{array}")).unwrap().read_raw::<f64>().unwrap();
    let points = numbers("Points");
    let mut bodies: Vec<Vec<[f64; 3]>> = vec![Vec::new(); 100];
    for (id, corners) in numbers("CellData/id").iter().zip(numbers("Polygons/Connectivity").chunks_exact(3)) {
        let corner = |k: &f64| std::array::from_fn(|a| points[3 * *k as usize + a]);
        bodies[*id as usize].extend(corners.iter().map(corner));
    }
    bodies
}

/// A snapshot, and a table made of its arrays, give the bodies that wrote it, of every kind of shape.
#[test]
fn what_a_run_writes_of_its_bodies_places_the_same_bodies() {
    let home = folder("insertion_again");
    fs::write(home.join("tetrahedron.stl"), stl()).unwrap();
    let lattice = "{ kind = \"lattice\", lower = [0.01, 0.007, 0.01], upper = [0.075, 0.059, 0.055], spacing = 0.0089 }";
    run_case(1, &home, &assortment(lattice, "first"), &[]).succeeded();
    let wanted = surfaces(&home.join("first"));
    let snapshot = home.join("first/particles.vtkhdf");
    let column = |name: &str, width: usize| last(&snapshot, &format!("PointData/{name}"), 100 * width);
    let (ids, shapes, turns) = (column("id", 1), column("shape", 1), column("orientation_wxyz", 4));
    let places = last(&snapshot, "Points", 300);
    let mut table = String::from("shape,x,y,z,qw,qx,qy,qz\n");
    for k in 0..100 {
        let name = SHAPES[shapes[k] as usize].0;
        let numbers = places[3 * k..3 * k + 3].iter().chain(&turns[4 * k..4 * k + 4]);
        let _ = writeln!(table, "{name},{}", numbers.map(f64::to_string).collect::<Vec<_>>().join(","));
    }
    fs::write(home.join("table.csv"), table).unwrap();
    let mut wrong = std::collections::BTreeSet::new();
    for (file, directory) in [("first/particles.vtkhdf", "second"), ("table.csv", "third")] {
        let text = assortment(&format!("{{ kind = \"file\", path = \"{file}\" }}"), directory);
        run_case(1, &home, &text, &[]).succeeded();
        for (row, found) in surfaces(&home.join(directory)).iter().enumerate() {
            let wanted = &wanted[ids[row] as usize];
            assert!(!wanted.is_empty() && wanted.len() == found.len(), "{file}, row {row}");
            let apart = wanted.iter().zip(found).flat_map(|(p, q)| (0..3).map(|a| (p[a] - q[a]).abs()));
            let apart = apart.fold(0.0, f64::max);
            if apart > 1e-15 {
                wrong.insert(format!("{file}: {} is {apart:.1e} m off", SHAPES[shapes[row] as usize].0));
            }
        }
    }
    assert_eq!(
        shapes.iter().map(|&s| s as usize).collect::<std::collections::BTreeSet<_>>().len(),
        SHAPES.len()
    );
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Without quaternions bodies lie as the case gives their shape, with the centre of mass at the place of the file.
#[test]
fn a_hull_without_quaternions_lies_as_its_vertices_do() {
    let home = folder("insertion_hull");
    fs::write(home.join("tetrahedron.stl"), stl()).unwrap();
    fs::write(home.join("table.csv"), "shape,x,y,z,wx,wy,wz\nhull_file,0.03,0.02,0.025,0,0,0\n").unwrap();
    run_case(1, &home, &assortment("{ kind = \"file\", path = \"table.csv\" }", "out"), &[]).succeeded();
    let found = &surfaces(&home.join("out"))[0];
    let centre: [f64; 3] = std::array::from_fn(|a| TETRAHEDRON.iter().map(|v| v[a]).sum::<f64>() / 4.0);
    for vertex in TETRAHEDRON {
        let wanted: [f64; 3] =
            std::array::from_fn(|a| [0.03, 0.02, 0.025][a] + 1e-3 * (vertex[a] - centre[a]));
        let nearest = found.iter().map(|p| (0..3).map(|a| (p[a] - wanted[a]).abs()).fold(0.0, f64::max));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-9, "{wanted:?} is {nearest:.1e} m off");
    }
}
