//! Flat faces of wall meshes.
use crate::support::Random;
use crate::walls::tessellated_square;
use grains_geometry::{Rotation, SMOOTH_ANGLE, TriMesh, Vec3, WallMesh};
use std::sync::Arc;

/// A square tessellated at random, its normal before it was turned, and how it was turned and moved.
fn square(random: &mut Random, splits: usize, size: f64) -> (TriMesh, Rotation, Vec3) {
    let (rotation, offset) = (random.rotation(), random.vector() * size);
    let flat = tessellated_square(random, splits, 0.004);
    (flat.transformed(&rotation, size, &offset), rotation, offset)
}

fn in_single_precision(mesh: &TriMesh) -> TriMesh {
    let vertices = mesh.vertices.iter().map(|v| v.map(|x| f64::from(x as f32))).collect();
    TriMesh { vertices, triangles: mesh.triangles.clone() }
}

fn wall(mesh: &TriMesh) -> WallMesh {
    WallMesh::new(mesh, SMOOTH_ANGLE).unwrap()
}

#[test]
fn a_square_is_one_facet_however_it_is_cut_also_in_single_precision() {
    let mut random = Random::new(1);
    for round in 0..60 {
        let size = [1e-3, 1.0, 30.0][round % 3];
        let (mesh, rotation, offset) = square(&mut random, 2 + 8 * round, size);
        for (mesh, rounding) in [(mesh.clone(), 1e-13), (in_single_precision(&mesh), 3e-7)] {
            let wall = wall(&mesh);
            let facet = wall.facet(0);
            let count = wall.mesh().triangles.len() as u32;
            assert!((0..count).all(|t| wall.facet(t) == facet), "round {round}: {count}");
            assert_eq!(facet.first, 0);
            // Twice 4 over 8.
            assert!((facet.width / size - 1.0).abs() < 1e-4, "{}", facet.width);
            for _ in 0..20 {
                let local = Vec3::new(1.5, 1.5, 0.5).component_mul(&random.vector());
                let point = rotation * local * size + offset;
                let limit = 10.0 * rounding * (size + offset.norm());
                assert!((facet.height(&point).abs() - local.z.abs() * size).abs() < limit, "round {round}");
                let over = wall.over_facet(0, &point, 10.0 * size);
                let beyond = local.xy().map(|x| x.abs() - 1.0);
                let from_rim = match beyond.max() < 0.0 {
                    true => local.z.hypot(beyond.max()),
                    false => local.z.hypot(beyond.map(|x| x.max(0.0)).norm()),
                };
                if beyond.max().abs() > 1e-5 {
                    assert_eq!(over.is_inside, beyond.max() < 0.0, "round {round}: {local:?}");
                }
                assert!(
                    (over.from_rim - from_rim * size).abs() < limit,
                    "{} {from_rim}",
                    over.from_rim / size
                );
                if over.is_inside {
                    let below = wall.triangle_below(0, &point);
                    assert!(wall.over_triangle(below, &point).is_inside, "round {round}");
                }
            }
        }
    }
}

#[test]
fn facets_end_at_folds_holes_and_fins_and_go_on_where_the_sense_turns() {
    let corner = |k: u32| Vec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
    let cube = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let cube = cube.map(|face| face.to_vec());
    let mesh = TriMesh::from_polygons((0..8).map(corner).collect(), &cube).unwrap();
    let faces = wall(&mesh);
    let firsts: Vec<u32> = (0..12).map(|t| faces.facet(t).first).collect();
    assert_eq!(firsts, [0, 0, 2, 2, 4, 4, 6, 6, 8, 8, 10, 10]);
    // A floor of 3 x 3 squares: one is missing, on one edge stands a fin, one square has the other sense.
    let vertices = (0..16).map(|k| Vec3::new(f64::from(k % 4), f64::from(k / 4), 0.0));
    let vertices: Vec<Vec3> = vertices.chain([Vec3::new(2.0, 0.0, 1.0), Vec3::new(2.0, 1.0, 1.0)]).collect();
    let tile = |k: usize| [k, k + 1, k + 5, k + 4];
    let mut tiles: Vec<Vec<usize>> = [0, 1, 2, 4, 6, 8, 9, 10].map(|k| tile(k).to_vec()).to_vec();
    tiles[6].reverse();
    tiles.push(vec![2, 6, 17, 16]);
    let floor = wall(&TriMesh::from_polygons(vertices, &tiles).unwrap());
    let firsts: Vec<u32> = (0..18).step_by(2).map(|t| floor.facet(t).first).collect();
    // Both sides of the fin hang together around the hole, over the tile of the other sense.
    assert_eq!(firsts, [0, 0, 0, 0, 0, 0, 0, 0, 16]);
    let near = |x: f64, y: f64| floor.over_facet(0, &Vec3::new(x, y, 0.1), 2.0);
    assert!(near(1.9, 0.5).is_inside && (near(1.9, 0.5).from_rim - 0.02_f64.sqrt()).abs() < 1e-15, "the fin");
    assert!(
        near(0.9, 1.5).is_inside && (near(0.9, 1.5).from_rim - 0.02_f64.sqrt()).abs() < 1e-15,
        "the hole"
    );
    assert!(!near(1.5, 1.5).is_inside && near(2.5, 0.5).is_inside);
    // A sheet that is folded onto itself has a rim at the fold.
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.2, 0.9]].map(|[x, y]| Vec3::new(x, y, 0.0));
    for flap in [vec![0, 2, 3], vec![0, 3, 2]] {
        let folded = TriMesh::from_polygons(corners.to_vec(), &[vec![0, 1, 2], flap.clone()]).unwrap();
        assert_eq!(wall(&folded).facet(1).first, 0, "it goes on");
        let over: Vec<Vec3> = corners[..3].iter().copied().chain([Vec3::new(0.9, 0.2, 0.0)]).collect();
        let folded = TriMesh::from_polygons(over, &[vec![0, 1, 2], flap]).unwrap();
        assert_eq!(wall(&folded).facet(1).first, 1, "it is folded");
    }
}

/// However it is cut, a bowl has no facets wider than its seams are far apart.
#[test]
fn a_bowl_keeps_its_facets_apart() {
    let (rings, sides) = (12, 24);
    let at = |i: usize, j: usize| {
        let [polar, turn] = [0.1 * (i + 1) as f64, std::f64::consts::TAU * j as f64 / sides as f64];
        Vec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), -polar.cos())
    };
    let vertices = (0..rings * sides).map(|k| at(k / sides, k % sides)).collect();
    let face = |k: usize| {
        let (i, j, next) = (k / sides, k % sides, (k + 1) % sides);
        vec![i * sides + j, i * sides + next, (i + 1) * sides + next, (i + 1) * sides + j]
    };
    let faces: Vec<Vec<usize>> = (0..(rings - 1) * sides).map(face).collect();
    let wall = wall(&TriMesh::from_polygons(vertices, &faces).unwrap());
    for t in 0..wall.mesh().triangles.len() as u32 {
        // The two halves of a side lie in one plane.
        assert_eq!(wall.facet(t).first, t - t % 2);
        assert!(wall.facet(t).width < 0.27);
    }
}

#[test]
fn a_wall_read_from_shared_memory_is_the_one_that_was_written() {
    let mut random = Random::new(5);
    let in_memory = |bytes: &[u8]| {
        let mut memory = memmap2::MmapMut::map_anon(bytes.len().max(1)).unwrap();
        memory[..bytes.len()].copy_from_slice(bytes);
        WallMesh::in_memory(&Arc::new(memory.make_read_only().unwrap()))
    };
    for round in 0..40 {
        let (mut mesh, ..) = square(&mut random, 1 + 5 * round, 1.0);
        // Some are bent, some have a hole, some a triangle that is there twice.
        for vertex in mesh.vertices.iter_mut().skip(round) {
            vertex.z += 0.1 * vertex.x * vertex.x;
        }
        mesh.triangles.truncate(mesh.triangles.len() - round % 2);
        mesh.triangles.extend_from_within(..round % 3);
        let built = wall(&mesh);
        let bytes = built.bytes();
        let read = in_memory(&bytes).unwrap();
        assert_eq!(format!("{read:?}"), format!("{built:?}"), "round {round}");
        for _ in 0..100 {
            let (center, radius) = (random.vector() * 1.5, 0.6 * random.unit());
            let contacts = |wall: &WallMesh| {
                let mut found = Vec::new();
                let half = Vec3::repeat(radius);
                wall.for_each_in_box(&(center - half), &(center + half), |t| {
                    found.push((
                        t,
                        wall.closest_within(t, &center, radius),
                        wall.free_path(t, &center, radius),
                    ));
                });
                found
            };
            assert_eq!(contacts(&read), contacts(&built), "round {round}");
        }
        // The memory of a mapping ends at a whole page.
        assert!(in_memory(&bytes[..bytes.len() / 2]).is_none(), "half of it");
        assert!(in_memory(&bytes[8..]).is_none(), "shifted");
    }
    assert!(in_memory(&[]).is_none());
}
