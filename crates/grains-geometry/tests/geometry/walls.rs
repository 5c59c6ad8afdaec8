//! Contact of spheres with wall meshes: each place exactly once.
use crate::support::{Random, close};
use grains_geometry::{Rotation, SMOOTH_ANGLE, TriMesh, TriangleContact, Vec3, WallMesh};
use std::f64::consts::PI;

fn contacts(wall: &WallMesh, c: &Vec3, reach: f64) -> Vec<TriangleContact> {
    let mut ids = Vec::new();
    wall.for_each_in_box(&c.add_scalar(-reach), &c.add_scalar(reach), |t| ids.push(t));
    ids.sort_unstable();
    let all = ids.iter().filter_map(|&t| wall.closest_on_triangle(t, c));
    all.filter(|contact| contact.distance < reach).collect()
}

/// Height of a triangle over its longest edge.
fn height(p: &[Vec3; 3]) -> f64 {
    let longest = (0..3).map(|k| (p[(k + 1) % 3] - p[k]).norm()).fold(0.0, f64::max);
    (p[1] - p[0]).cross(&(p[2] - p[0])).norm() / longest
}

/// Triangles (x, y) of the square [-1, 1]², split at random; slivers have heights down to `thin`.
pub fn tessellated_square(random: &mut Random, splits: usize, thin: f64) -> TriMesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mut vertices: Vec<Vec3> = corners.iter().map(|p| Vec3::new(p[0], p[1], 0.0)).collect();
    let mut triangles = vec![[0u32, 1, 2], [0, 2, 3]];
    while triangles.len() < 2 * splits {
        let t = random.index(triangles.len());
        let [a, b, c] = triangles[t];
        let mut weights = [random.range(0.1, 1.0), random.range(0.1, 1.0), random.range(0.1, 1.0)];
        if random.unit() < 0.3 {
            // A point close to an edge makes slivers, and fans around it.
            weights[random.index(3)] = 3.0 * thin;
        }
        let sum: f64 = weights.iter().sum();
        let p = [a, b, c].iter().zip(weights).map(|(&v, w)| vertices[v as usize] * (w / sum)).sum();
        let v = vertices.len() as u32;
        vertices.push(p);
        let parts = [[a, b, v], [b, c, v], [c, a, v]];
        if parts.iter().any(|t| height(&t.map(|v| vertices[v as usize])) < thin) {
            vertices.pop();
            continue;
        }
        triangles[t] = [a, b, v];
        triangles.extend([[b, c, v], [c, a, v]]);
    }
    TriMesh { vertices, triangles }
}

/// Asserts that a sphere over the plane through `origin` touches it once, as it would the plane.
#[track_caller]
fn assert_one(wall: &WallMesh, c: &Vec3, origin: &Vec3, normal: &Vec3, tilt_limit: f64) {
    let found = contacts(wall, c, 0.4);
    assert_eq!(found.len(), 1, "{c:?}: {found:?}");
    let height = (c - origin).dot(normal);
    let side = if height < 0.0 { -normal } else { *normal };
    assert!((found[0].distance - height.abs()).abs() < 1e-12, "{:e}", found[0].distance - height.abs());
    let tilt = (found[0].normal - side).norm();
    assert!(tilt < tilt_limit, "{tilt:e}");
    assert!((found[0].point - (c - normal * height)).norm() < tilt_limit);
}

#[test]
fn tessellated_plane_equals_the_plane() {
    let mut random = Random::new(1);
    for (case, thin) in [1e-2, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6].into_iter().enumerate() {
        let flat = tessellated_square(&mut random, 60, thin);
        let (turn, offset) = if case == 0 {
            (Rotation::identity(), Vec3::zeros())
        } else {
            (random.rotation(), random.vector())
        };
        let mesh = flat.transformed(&turn, 1.0, &offset);
        let wall = WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap();
        let normal = turn * Vec3::z();
        // The rounded corners of a sliver define its own plane no better than rounding / height.
        let tilt_limit = 1e-12_f64.max(1e-14 / thin);
        let place = |x: f64, y: f64, z: f64| turn * Vec3::new(x, y, z) + offset;
        for _ in 0..20_000 {
            let h = random.range(0.01, 0.3) * if random.unit() < 0.3 { -1.0 } else { 1.0 };
            let c = place(random.range(-1.0, 1.0), random.range(-1.0, 1.0), h);
            assert_one(&wall, &c, &offset, &normal, tilt_limit);
        }
        for t in 0..mesh.triangles.len() {
            let p = mesh.corners(t);
            for k in 0..3 {
                let h = random.range(0.01, 0.3);
                for share in [0.0, 1.0, 0.5, random.unit(), 1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-6] {
                    let c = p[k] * (1.0 - share) + p[(k + 1) % 3] * share + normal * h;
                    // Within 3e-11 of a vertex, it may stand for its faces.
                    assert_one(&wall, &c, &offset, &normal, tilt_limit + 3e-11 / h);
                }
            }
        }
    }
}

#[test]
fn micrometre_and_kilometre_walls_behave_alike() {
    for size in [1e-6, 1e3] {
        let mut random = Random::new(12);
        let mesh =
            tessellated_square(&mut random, 40, 1e-2).transformed(&random.rotation(), size, &Vec3::zeros());
        let wall = WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap();
        let p = mesh.corners(0);
        let normal = (p[1] - p[0]).cross(&(p[2] - p[0])).normalize();
        for t in 0..mesh.triangles.len() {
            let p = mesh.corners(t);
            for share in [0.0, 0.3, 1.0] {
                let c = p[0] * (1.0 - share) + p[1] * share + normal * (0.1 * size);
                let found = contacts(&wall, &c, 0.4 * size);
                assert_eq!(found.len(), 1);
                close(found[0].distance, 0.1 * size, 1e-12);
            }
        }
    }
}

#[test]
fn rounded_coordinates_neither_lose_nor_double_contacts() {
    // Vertices as a binary STL gives them: the plane is flat to 1e-7 only.
    let mut random = Random::new(2);
    for _ in 0..10 {
        let turn = random.rotation();
        let mut mesh = tessellated_square(&mut random, 60, 1e-2).transformed(&turn, 1.0, &random.vector());
        mesh.vertices.iter_mut().for_each(|v| *v = v.map(|x| f64::from(x as f32)));
        let wall = WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap();
        let normal = turn * Vec3::z();
        let origin = mesh.vertices[0];
        let check = |c: Vec3| {
            let found = contacts(&wall, &c, 0.4);
            assert_eq!(found.len(), 1, "{found:?}");
            assert!((found[0].distance - (c - origin).dot(&normal)).abs() < 1e-6);
        };
        for t in 0..mesh.triangles.len() {
            let p = mesh.corners(t);
            for _ in 0..30 {
                let (a, b) = (random.unit(), random.unit());
                let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
                check(p[0] + (p[1] - p[0]) * a + (p[2] - p[0]) * b + normal * random.range(0.02, 0.3));
                check(p[0] + (p[1] - p[0]) * a + normal * 0.1 + random.vector() * 1e-8);
                check(p[0] + normal * 0.1 + random.vector() * 10f64.powf(random.range(-16.0, -6.0)));
            }
        }
    }
}

#[test]
fn roof_has_one_contact_in_the_right_direction() {
    // Two planes falling away from the y axis at 45°.
    let vertices = [
        [-1.0, -1.0, -1.0],
        [0.0, -1.0, 0.0],
        [1.0, -1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, -1.0],
    ];
    let quads = [vec![0, 1, 4, 3], vec![1, 2, 5, 4]];
    let mesh = TriMesh::from_polygons(vertices.map(Vec3::from).to_vec(), &quads).unwrap();
    let wall = WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap();
    assert_eq!((wall.report().mesh.open_edges, wall.report().mesh.non_manifold_edges), (6, 0));
    let mut random = Random::new(3);
    for _ in 0..20_000 {
        let angle = random.range(-PI / 2.0, PI / 2.0);
        let y = random.range(-0.9, 0.9);
        let c = Vec3::new(0.2 * angle.sin(), y, 0.2 * angle.cos());
        let found = contacts(&wall, &c, 0.3);
        assert_eq!(found.len(), 1);
        let tilt = angle.abs() - PI / 4.0;
        let expected = if tilt <= 0.0 {
            (0.2, Vec3::new(angle.sin(), 0.0, angle.cos()))
        } else {
            (0.2 * tilt.cos(), Vec3::new(angle.signum(), 0.0, 1.0).normalize())
        };
        assert!((found[0].distance - expected.0).abs() < 1e-14);
        assert!((found[0].normal - expected.1).norm() < 1e-13);
    }
    // Off the ends of the ridge: an edge's end, then nothing below.
    let end = contacts(&wall, &Vec3::new(0.0, 1.1, 0.1), 0.3);
    assert_eq!(end.len(), 1);
    assert!((end[0].point - Vec3::new(0.0, 1.0, 0.0)).norm() < 1e-15);
}

fn box_mesh(half: f64) -> TriMesh {
    let sign = |i: usize, k: usize| if i >> k & 1 == 1 { half } else { -half };
    let vertices = (0..8).map(|i| Vec3::from_fn(|k, _| sign(i, k))).collect();
    let quads: Vec<Vec<usize>> =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
            .map(|q| q.to_vec())
            .to_vec();
    TriMesh::from_polygons(vertices, &quads).unwrap()
}

#[test]
fn inside_a_box_each_wall_touches_once() {
    let wall = WallMesh::new(&box_mesh(1.0), SMOOTH_ANGLE).unwrap();
    let mut random = Random::new(4);
    let mut seen = [0; 4];
    for i in 0..100_000 {
        let mut c = random.vector();
        if i % 4 == 0 {
            // Where diagonals of the faces, and the bisecting planes of the corners, meet.
            c.y = c.x.abs();
            c.z = if i % 8 == 0 { -c.x } else { c.z };
        }
        let reach = 0.5;
        let expected = (0..3).flat_map(|k| [1.0 - c[k], 1.0 + c[k]]).filter(|d| *d < reach).count();
        let found = contacts(&wall, &c, reach);
        assert_eq!(found.len(), expected, "{c:?} {found:?}");
        for contact in &found {
            let k = contact.normal.iamax();
            assert!((contact.normal[k].abs() - 1.0).abs() < 1e-15);
            assert!((contact.distance - (1.0 - c[k].abs())).abs() < 1e-15);
        }
        seen[found.len()] += 1;
    }
    assert!(seen.iter().all(|&n| n > 1000), "{seen:?}");
}

#[test]
fn outside_a_box_there_is_one_contact_with_face_edge_or_vertex() {
    let turn = Random::new(6).rotation();
    let wall = WallMesh::new(&box_mesh(1.0).transformed(&turn, 1.0, &Vec3::zeros()), SMOOTH_ANGLE).unwrap();
    let mut random = Random::new(5);
    for _ in 0..50_000 {
        let c = random.vector() * 1.6;
        let closest = c.map(|x| x.clamp(-1.0, 1.0));
        if closest == c {
            continue;
        }
        let found = contacts(&wall, &(turn * c), 0.6);
        let distance = (c - closest).norm();
        assert_eq!(found.len(), usize::from(distance < 0.6));
        for contact in found {
            assert!((contact.distance - distance).abs() < 1e-14);
            assert!((turn.inverse() * contact.point - closest).norm() < 1e-14);
        }
    }
}

/// Half pipe along y, seen from inside, of radius 1.
fn half_pipe(facets: usize) -> TriMesh {
    let mut vertices = Vec::new();
    let mut quads = Vec::new();
    for i in 0..=facets {
        let (s, c) = (PI * i as f64 / facets as f64).sin_cos();
        vertices.extend([Vec3::new(c, -1.0, -s), Vec3::new(c, 1.0, -s)]);
        if i > 0 {
            quads.push(vec![2 * i - 2, 2 * i - 1, 2 * i + 1, 2 * i]);
        }
    }
    TriMesh::from_polygons(vertices, &quads).unwrap()
}

#[test]
fn smooth_valleys_give_one_contact_with_the_nearest_face() {
    let fine = WallMesh::new(&half_pipe(360), 1.1f64.to_radians()).unwrap();
    let exact = WallMesh::new(&half_pipe(360), 0.0).unwrap();
    let mut random = Random::new(7);
    let mut double = 0;
    for _ in 0..20_000 {
        let angle = random.range(0.3, PI - 0.3);
        let c = Vec3::new(angle.cos(), random.range(-0.9, 0.9), -angle.sin()) * 0.8;
        let found = contacts(&fine, &c, 0.25);
        assert_eq!(found.len(), 1);
        let all = contacts(&exact, &c, 0.25);
        double += usize::from(all.len() > 1);
        let nearest = all.iter().map(|k| k.distance).fold(f64::INFINITY, f64::min);
        assert_eq!(found[0].distance, nearest);
    }
    assert!(double > 100, "{double}");
}

#[test]
fn finely_curved_bowl_never_loses_a_sphere() {
    // A paraboloid of small facets, its vertices disturbed: valleys, ridges and saddles.
    let n = 40;
    let mut random = Random::new(8);
    let at = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
    let mut vertices = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            let (x, y) = (at(i), at(j));
            vertices.push(Vec3::new(x, y, 0.3 * (x * x + y * y) + random.range(0.0, 1e-3)));
        }
    }
    let mut quads = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j;
            quads.push(vec![a, a + n + 1, a + n + 2, a + 1]);
        }
    }
    let wall = WallMesh::new(&TriMesh::from_polygons(vertices, &quads).unwrap(), 5f64.to_radians()).unwrap();
    for k in 0..20_000 {
        let mut c = Vec3::new(random.range(-0.7, 0.7), random.range(-0.7, 0.7), 0.0);
        if k % 3 == 0 {
            c = wall.mesh().vertices[random.index(wall.mesh().vertices.len())] * 0.7;
        }
        c.z = 0.3 * (c.x * c.x + c.y * c.y) + 0.1;
        let found = contacts(&wall, &c, 0.2);
        let brute = (0..wall.mesh().triangles.len())
            .map(|t| (closest_point(&wall.mesh().corners(t), &c) - c).norm())
            .fold(f64::INFINITY, f64::min);
        let nearest = found.iter().map(|k| k.distance).fold(f64::INFINITY, f64::min);
        assert!((nearest - brute).abs() < 1e-13, "{nearest} {brute}");
    }
}

/// Closest point of a triangle, by brute force over its faces, edges and corners.
fn closest_point(p: &[Vec3; 3], c: &Vec3) -> Vec3 {
    let n = (p[1] - p[0]).cross(&(p[2] - p[0])).normalize();
    let inside = (0..3).all(|k| n.cross(&(p[(k + 1) % 3] - p[k])).dot(&(c - p[k])) >= 0.0);
    if inside {
        return c - n * n.dot(&(c - p[0]));
    }
    let on_edge = (0..3).map(|k| {
        let e = p[(k + 1) % 3] - p[k];
        p[k] + e * (e.dot(&(c - p[k])) / e.norm_squared()).clamp(0.0, 1.0)
    });
    on_edge.min_by(|a, b| (a - c).norm().total_cmp(&(b - c).norm())).unwrap()
}

#[test]
fn random_closed_surfaces_keep_their_nearest_contact() {
    let mut random = Random::new(10);
    for _ in 0..20 {
        let points: Vec<Vec3> = (0..25).map(|_| random.vector()).collect();
        let mesh = grains_geometry::ConvexHull::new(&points).unwrap().triangles();
        let wall = WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap();
        for _ in 0..2000 {
            let c = random.vector() * 2.0;
            let all: Vec<TriangleContact> =
                (0..mesh.triangles.len() as u32).filter_map(|t| wall.closest_on_triangle(t, &c)).collect();
            let brute = (0..mesh.triangles.len())
                .map(|t| (closest_point(&mesh.corners(t), &c) - c).norm())
                .fold(f64::INFINITY, f64::min);
            let nearest = all.iter().map(|k| k.distance).fold(f64::INFINITY, f64::min);
            assert!((nearest - brute).abs() < 1e-13);
        }
    }
}

#[test]
fn vertices_on_edges_of_others_are_joined() {
    // One long edge along y = 0 against a comb of triangles on the other side, twice over.
    let mut vertices = vec![Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    let mut triangles = vec![[0, 1, 2]];
    let n = 7;
    for i in 0..n {
        let x = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
        let first = vertices.len() as u32;
        vertices.extend([Vec3::new(x(i), 0.0, 0.0), Vec3::new(x(i + 1), 0.0, 0.0)]);
        vertices.extend([Vec3::new(x(i), -1.0, 0.0), Vec3::new(x(i + 1), -1.0, 0.0)]);
        triangles.extend([[first, first + 2, first + 3], [first, first + 3, first + 1]]);
    }
    let turn = Random::new(1).rotation();
    let mesh = TriMesh { vertices, triangles }.transformed(&turn, 2.0, &Vec3::repeat(0.3));
    let wall = WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap();
    assert_eq!(wall.report().split_triangles, n - 1);
    assert_eq!(wall.report().mesh.open_edges, 2 + 2 + n);
    let mut random = Random::new(2);
    for i in 0..20_000 {
        let y = if i % 3 == 0 { 0.0 } else { random.range(-0.1, 0.1) };
        let local = Vec3::new(random.range(-0.8, 0.8), y, random.range(0.01, 0.1));
        let c = turn * local * 2.0 + Vec3::repeat(0.3);
        let found = contacts(&wall, &c, 0.4);
        assert_eq!(found.len(), 1);
        assert!((found[0].distance - 2.0 * local.z).abs() < 1e-12);
    }
}

#[test]
fn non_manifold_edges_and_doubled_faces_count_once() {
    // Three planes around the y axis, one of them given twice, once turned over.
    let mut vertices = vec![Vec3::new(0.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    let mut triangles = Vec::new();
    for i in 0..3 {
        let (s, c) = (2.0 * PI * f64::from(i) / 3.0).sin_cos();
        let first = vertices.len() as u32;
        vertices.extend([Vec3::new(c, -1.0, s), Vec3::new(c, 1.0, s)]);
        triangles.extend([[0, first, first + 1], [0, first + 1, 1]]);
        if i == 0 {
            triangles.extend([[first + 1, first, 0], [1, first + 1, 0]]);
        }
    }
    let wall = WallMesh::new(&TriMesh { vertices, triangles }, SMOOTH_ANGLE).unwrap();
    assert_eq!((wall.report().mesh.non_manifold_edges, wall.report().duplicate_triangles), (1, 2));
    let mut random = Random::new(3);
    for _ in 0..5000 {
        // Between two planes at 120°: both are touched; the edge never.
        let (s, c) = random.range(0.0, 2.0 * PI).sin_cos();
        let centre = Vec3::new(0.3 * c, random.range(-0.8, 0.8), 0.3 * s);
        let planes = (0..3).filter(|&i| {
            let (s, c) = (2.0 * PI * f64::from(i) / 3.0).sin_cos();
            let along = centre.x * c + centre.z * s;
            along > 0.0 && (centre.x * s - centre.z * c).abs() < 0.5
        });
        assert_eq!(contacts(&wall, &centre, 0.5).len(), planes.count());
    }
}

#[test]
fn convex_bodies_own_minima_by_the_same_rule() {
    let mut random = Random::new(14);
    let wall = WallMesh::new(&box_mesh(1.0), SMOOTH_ANGLE).unwrap();
    let n = wall.mesh().triangles.len() as u32;
    for _ in 0..5000 {
        // A ball outside: closest points as an iteration would give them, with its noise.
        let c = random.vector() * 1.5;
        let closest = c.map(|x| x.clamp(-1.0, 1.0));
        if (c - closest).norm() < 0.01 {
            continue;
        }
        let owners = (0..n).filter(|&t| {
            let p = closest_point(&wall.mesh().corners(t as usize), &c) + random.vector() * 1e-9;
            let near = (c - p).norm() < 1.0;
            near && wall.owns_local_minimum(t, &p, &((c - p) + random.vector() * 1e-8))
        });
        assert_eq!(owners.count(), 1, "{c:?}");
    }
    // Exactly over the diagonal of a face and over a vertex.
    for c in [
        Vec3::new(0.3, 0.3, 1.2),
        Vec3::new(0.3, -0.3, 1.2),
        Vec3::new(1.0, 1.0, 1.2),
        Vec3::new(1.0, 0.2, 1.1),
    ] {
        let owns = |&t: &u32| {
            let p = closest_point(&wall.mesh().corners(t as usize), &c);
            (c - p).norm() < 1.0 && wall.owns_local_minimum(t, &p, &(c - p))
        };
        assert_eq!((0..n).filter(owns).count(), 1);
    }
}

#[test]
fn tree_of_a_wall_equals_brute_force() {
    let wall = WallMesh::new(&half_pipe(200), SMOOTH_ANGLE).unwrap();
    let mut random = Random::new(15);
    for _ in 0..500 {
        let c = random.vector();
        let reach = random.range(0.0, 0.5);
        let (lower, upper) = (c.add_scalar(-reach), c.add_scalar(reach));
        let mut found = Vec::new();
        wall.for_each_in_box(&lower, &upper, |t| found.push(t));
        found.sort_unstable();
        let meets = |&t: &u32| {
            let p = wall.mesh().corners(t as usize);
            (0..3).all(|k| {
                p.iter().map(|v| v[k]).fold(f64::INFINITY, f64::min) <= upper[k]
                    && p.iter().map(|v| v[k]).fold(f64::NEG_INFINITY, f64::max) >= lower[k]
            })
        };
        assert_eq!(found, (0..wall.mesh().triangles.len() as u32).filter(meets).collect::<Vec<_>>());
    }
}

/// Balls go less far than their free path in any direction, half of them straight to where the triangle may be met.
#[test]
fn no_ball_touches_a_triangle_within_its_free_path() {
    let mut random = Random::new(16);
    let turn = random.rotation();
    let tiles = tessellated_square(&mut random, 60, 0.01);
    let meshes = [
        tiles.transformed(&turn, 1.0, &Vec3::new(0.3, -2.0, 1.0)),
        half_pipe(40),
        box_mesh(0.8),
        TriMesh { vertices: tiles.vertices.iter().map(|v| v + random.vector() * 0.02).collect(), ..tiles },
    ];
    let (mut came_near, mut freed, mut near) = (0, 0, 0);
    for mesh in meshes {
        let wall = WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap();
        let count = wall.mesh().triangles.len();
        for _ in 0..20_000 {
            let t = random.index(count);
            let corners = wall.mesh().corners(t);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let (c, radius) = (middle + random.vector() * random.range(0.0, 0.5), random.range(0.01, 0.3));
            let (t, before) = (t as u32, wall.closest_within(t as u32, &c, radius));
            let free = wall.free_path(t, &c, radius);
            assert!(before.is_none() || free <= 0.0, "touches with a free path of {free}");
            near += usize::from(before.is_none() && wall.distance_bound(t, &c) < radius);
            if free <= 0.0 {
                continue;
            }
            freed += usize::from(wall.distance_bound(t, &c) < radius);
            let way = if random.unit() < 0.5 { middle - c } else { random.vector() };
            let step = way * (free * random.unit() / way.norm().max(1e-9)).min(1.0);
            assert_eq!(wall.closest_within(t, &(c + step * 0.999), radius), None, "{c} {step} {free}");
            // It is no less than needed either: a little farther some do touch.
            came_near += usize::from(wall.closest_within(t, &(c + step * 1.5), radius).is_some());
        }
    }
    assert!(came_near > 100 && 10 * freed > 9 * near && near > 1000, "{came_near} {freed} {near}");
}
