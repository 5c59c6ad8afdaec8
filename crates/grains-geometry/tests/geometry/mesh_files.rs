//! Mesh files, welding and the tree of boxes.
use crate::support::{Random, close};
use grains_geometry::{
    Aabb, Bvh, MassProperties, MeshError, ParseError, RegularSolid, Shape, TriMesh, Vec3, WELD_TOLERANCE,
    parse_obj, parse_stl, read_mesh, write_stl, write_stl_ascii,
};

fn dodecahedron() -> TriMesh {
    Shape::regular(RegularSolid::Dodecahedron, 1.5e-3, 0.02).unwrap().surface
}

fn binary(mesh: &TriMesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_stl(&mut bytes, mesh).unwrap();
    bytes
}

#[test]
fn binary_stl_round_trip_welds_to_the_same_mesh() {
    let mesh = dodecahedron();
    let bytes = binary(&mesh);
    assert_eq!(bytes.len(), 84 + 50 * mesh.triangles.len());
    let (back, weld) = parse_stl(&bytes).unwrap().welded(WELD_TOLERANCE).unwrap();
    assert_eq!(back.vertices.len(), 20);
    assert_eq!(weld.merged_vertices, 3 * mesh.triangles.len() - 20);
    assert_eq!(weld.degenerate_triangles, 0);
    let report = back.report();
    assert_eq!((report.open_edges, report.non_manifold_edges), (0, 0));
    for v in &back.vertices {
        assert!(mesh.vertices.iter().any(|w| (v - w).norm() < 1e-7 * 1.5e-3));
    }
    close(MassProperties::of_closed_mesh(&back).volume, MassProperties::of_closed_mesh(&mesh).volume, 1e-6);
}

#[test]
fn ascii_stl_round_trip_is_exact() {
    let mesh = dodecahedron();
    let mut text = Vec::new();
    write_stl_ascii(&mut text, &mesh, "dodecahedron").unwrap();
    let soup = parse_stl(&text).unwrap();
    for t in 0..mesh.triangles.len() {
        assert_eq!(soup.corners(t), mesh.corners(t));
    }
    let upper = String::from_utf8(text).unwrap().to_uppercase();
    assert_eq!(parse_stl(format!("  \n{upper}").as_bytes()).unwrap(), soup);
}

#[test]
fn binary_stl_whose_header_says_solid_is_binary() {
    let mesh = dodecahedron();
    let mut bytes = binary(&mesh);
    bytes[..12].copy_from_slice(b"solid of CAD");
    assert_eq!(parse_stl(&bytes).unwrap().triangles.len(), mesh.triangles.len());
    // A tail some programs append is ignored.
    let mut padded = binary(&mesh);
    padded.extend([0; 7]);
    assert_eq!(parse_stl(&padded).unwrap().triangles.len(), mesh.triangles.len());
}

#[test]
fn broken_stl_files_are_refused() {
    let bytes = binary(&dodecahedron());
    assert!(matches!(parse_stl(&bytes[..bytes.len() - 1]), Err(ParseError::Truncated { triangles: 36, .. })));
    assert!(matches!(parse_stl(b""), Err(ParseError::Truncated { .. })));
    let text = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 x\n";
    assert!(matches!(parse_stl(text), Err(ParseError::Line { line: 5, .. })));
    let text = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\n";
    assert!(matches!(parse_stl(text), Err(ParseError::Line { line: 7, .. })));
    let text = b"solid a\nendsolid a\n";
    assert!(matches!(parse_stl(text).unwrap().welded(1e-7), Err(MeshError::Empty { degenerate: 0 })));
}

#[test]
fn obj_polygons_become_triangles() {
    let text = "# a cube of edge 2\nv -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\n\
                v -1 1 1 1.0\nvt 0 0\nvn 0 0 1\no cube\nf 4 3 2 1\nf 5/1 6/1 7/1 8/1\nf 1//1 2//1 6//1 5//1\n\
                f 2 3 7 6 # side\nf 3 4 8 7\nf -8 -4 -1 -5\n";
    let mesh = parse_obj(text).unwrap();
    assert_eq!(mesh.triangles.len(), 12);
    let mass = MassProperties::of_closed_mesh(&mesh);
    close(mass.volume, 8.0, 1e-14);
    assert_eq!(mesh.report().open_edges, 0);
    assert!(matches!(parse_obj("v 0 0\n"), Err(ParseError::Line { line: 1, .. })));
    assert!(matches!(parse_obj("v 0 0 0\nf 1 0 1\n"), Err(ParseError::Line { line: 2, .. })));
    assert!(matches!(parse_obj("v 0 0 0\nf 1 2 3\n"), Err(ParseError::Mesh(MeshError::NoSuchVertex { .. }))));
    assert!(matches!(
        parse_obj("v 0 0 0\nv 1 0 0\nf 1 2\n"),
        Err(ParseError::Mesh(MeshError::TooFewCorners { .. }))
    ));
}

#[test]
fn concave_polygons_keep_their_area() {
    // An L, a star, and a comb with collinear corners.
    let star = (0..14).map(|i| {
        let (s, c) = (std::f64::consts::TAU * f64::from(i) / 14.0).sin_cos();
        [c, s].map(|x| if i % 2 == 0 { x } else { 0.3 * x })
    });
    let outlines: [Vec<[f64; 2]>; 3] = [
        vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]],
        star.collect(),
        vec![
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [3.0, 0.0],
            [3.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ],
    ];
    let turn = Random::new(1).rotation();
    for outline in outlines {
        let n = outline.len();
        let twice: f64 = (0..n)
            .map(|i| outline[i][0] * outline[(i + 1) % n][1] - outline[i][1] * outline[(i + 1) % n][0])
            .sum();
        let vertices = outline.iter().map(|p| turn * Vec3::new(p[0], p[1], 0.5)).collect();
        let mesh = TriMesh::from_polygons(vertices, &[(0..n).collect()]).unwrap();
        assert_eq!(mesh.triangles.len(), n - 2);
        // The sum of areas equals the signed area only if no triangle lies outside.
        close(mesh.report().area, twice.abs() / 2.0, 1e-13);
    }
}

#[test]
fn welding_drops_degenerate_triangles_and_unused_vertices() {
    for size in [1e-6, 1.0, 1e3] {
        let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1e-9, 0.0], [0.5, 0.0], [5.0, 5.0], [1.0, 1.0]];
        let vertices = points.iter().map(|p| Vec3::new(p[0], p[1], 0.0) * size).collect();
        let triangles = vec![[0, 1, 2], [3, 1, 2], [0, 3, 1], [0, 4, 1], [1, 6, 2]];
        let (mesh, weld) = TriMesh { vertices, triangles }.welded(1e-7).unwrap();
        assert_eq!(weld.merged_vertices, 1);
        assert_eq!(weld.degenerate_triangles, 2);
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4, 3));
        let report = mesh.report();
        close(report.smallest_area, 0.5 * size * size, 1e-12);
        close(report.area, 1.5 * size * size, 1e-12);
        // Two copies of one triangle and a neighbour: three triangles at the diagonal.
        assert_eq!((report.open_edges, report.non_manifold_edges), (2, 1));
    }
}

#[test]
fn files_are_read_by_their_extension() {
    let directory = std::env::temp_dir().join(format!("grains-geometry-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    let path = directory.join("Particle.STL");
    let mesh = dodecahedron();
    std::fs::write(&path, binary(&mesh)).unwrap();
    let shape = Shape::hull_of_mesh(&read_mesh(&path).unwrap().mesh, 2.0, 0.02).unwrap();
    close(shape.volume, 8.0 * MassProperties::of_closed_mesh(&mesh).volume, 1e-6);
    let wrong = directory.join("particle.ply");
    std::fs::write(&wrong, b"ply").unwrap();
    assert!(read_mesh(&wrong).unwrap_err().to_string().contains(".stl"));
    assert!(read_mesh(&directory.join("absent.stl")).unwrap_err().to_string().contains("absent.stl"));
    std::fs::remove_dir_all(&directory).unwrap();
}

#[test]
fn tree_finds_what_brute_force_finds() {
    let mut random = Random::new(9);
    for n in [0, 1, 3, 5, 17, 500, 3000] {
        let boxes: Vec<Aabb> = (0..n)
            .map(|i| {
                let centre = if i % 5 == 0 { Vec3::zeros() } else { random.vector() };
                let half = random.vector().abs() * 0.1;
                Aabb { lower: centre - half, upper: centre + half }
            })
            .collect();
        let tree = Bvh::new(&boxes);
        for _ in 0..200 {
            let centre = random.vector() * 1.2;
            let half = random.vector().abs() * random.range(0.0, 0.5);
            let (lower, upper) = (centre - half, centre + half);
            let mut found = Vec::new();
            tree.for_each_in_box(&lower, &upper, |i| found.push(i));
            let again = {
                let mut again = Vec::new();
                Bvh::new(&boxes).for_each_in_box(&lower, &upper, |i| again.push(i));
                again
            };
            assert!(n > 100 || found == again);
            found.sort_unstable();
            let meets = |b: &Aabb| (0..3).all(|k| b.lower[k] <= upper[k] && b.upper[k] >= lower[k]);
            let expected: Vec<u32> = (0..n as u32).filter(|&i| meets(&boxes[i as usize])).collect();
            assert_eq!(found, expected);
        }
    }
}
