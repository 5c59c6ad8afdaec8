use super::*;
use crate::synthetic::{ball, case, lattice, particles, turns};
use grains_domain::SerialTransport;
use grains_geometry::RegularSolid;
use std::f64::consts::PI;

fn unit(axis: usize) -> Region {
    Region { lower: Vec3::zeros(), upper: Vec3::repeat(1.0), axis, cylinder: None }
}

fn solid(region: &Region, edge: f64, snapshot: &Snapshot, shapes: &[Shape], periodic: bool) -> f64 {
    let case = case([0.0; 3], [1.0; 3], [periodic; 3], "");
    let counted =
        count(region, &Grid::new(region, edge), None, (snapshot, shapes), &case.domain, &SerialTransport);
    let sum = |k: usize| counted.layers.iter().map(|l| l[k]).sum::<u64>() as f64;
    sum(1) / sum(0)
}

#[test]
fn a_cubic_lattice_of_touching_spheres_fills_a_sixth_of_pi() {
    // Moved by less than a spacing, so that spheres reach through all faces.
    let sites = lattice(Vec3::new(0.1, -0.07, 0.03), [4, 4, 4], 0.25);
    let snapshot = particles(sites.into_iter().map(|x| x.map(|c| c.rem_euclid(1.0))).collect());
    for axis in 0..3 {
        let found = solid(&unit(axis), 0.25 / 60.0, &snapshot, &ball(0.125), true);
        assert!((found - PI / 6.0).abs() < 1e-3 * PI / 6.0, "{axis}: {found}");
    }
}

#[test]
fn images_across_periodic_faces_are_counted() {
    let snapshot = particles(vec![Vec3::new(0.02, 0.5, 0.98)]);
    let wanted = 4.0 / 3.0 * PI * 0.2_f64.powi(3);
    let found = solid(&unit(2), 0.004, &snapshot, &ball(0.2), true);
    assert!((found / wanted - 1.0).abs() < 1e-3, "{found} {wanted}");
    assert!(solid(&unit(2), 0.004, &snapshot, &ball(0.2), false) < 0.7 * wanted);
    // A particle nearly as large as the box meets itself; what overlaps counts once.
    let large = particles(vec![Vec3::repeat(0.5)]);
    assert_eq!(solid(&unit(2), 0.02, &large, &ball(0.9), true), 1.0);
}

#[test]
fn boxes_that_fill_the_region_leave_no_void_and_twins_count_once() {
    let mut snapshot = particles(lattice(Vec3::zeros(), [4, 4, 4], 0.25));
    let shapes = vec![Shape::cuboid(Vec3::repeat(0.25), 0.02).unwrap()];
    // Cells whose middles lie on no face.
    assert_eq!(solid(&unit(2), 0.0125, &snapshot, &shapes, false), 1.0);
    snapshot.position.truncate(32);
    let half = solid(&unit(2), 0.0125, &snapshot, &shapes, false);
    assert!((half - 0.5).abs() < 1e-12, "{half}");
    let twins = particles([&snapshot.position[..], &snapshot.position].concat());
    assert_eq!(solid(&unit(2), 0.0125, &twins, &shapes, false), half);
}

#[test]
fn intervals_are_those_of_the_inside_test_for_every_shape() {
    let needle = [[0.0, 0.0, 0.0], [0.8, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1], [0.1, 0.1, 0.1]];
    let needle = needle.map(Vec3::from);
    let shapes = vec![
        Shape::sphere(0.2).unwrap(),
        // Thick crusts: the rounded bodies are much smaller than those with sharp edges.
        Shape::cuboid(Vec3::new(0.1, 0.3, 0.5), 0.4).unwrap(),
        Shape::cylinder(0.05, 0.5, 0.5).unwrap(),
        Shape::cylinder(0.25, 0.04, 0.5).unwrap(),
        Shape::regular(RegularSolid::Tetrahedron, 0.45, 0.5).unwrap(),
        Shape::regular(RegularSolid::Icosahedron, 0.25, 0.3).unwrap(),
        Shape::hull(&needle, 0.5).unwrap(),
    ];
    let case = case([0.0; 3], [1.0; 3], [false; 3], "");
    for (k, turn) in turns(70).into_iter().enumerate() {
        let mut snapshot = particles(vec![Vec3::new(0.5, 0.45, 0.55)]);
        (snapshot.shape[0], snapshot.orientation[0]) = (k % shapes.len(), turn);
        snapshot.scale[0] = 0.6 + 0.01 * k as f64;
        let region = unit(k % 3);
        let grid = Grid::new(&region, 0.021);
        let counted = count(&region, &grid, None, (&snapshot, &shapes), &case.domain, &SerialTransport);
        for (layer, &[all, found]) in counted.layers.iter().enumerate() {
            let cells = (0..grid.cells[0]).flat_map(|i| (0..grid.cells[1]).map(move |j| (i, j)));
            let is_in = |&(i, j): &(usize, usize)| {
                let mut x = Vec3::zeros();
                [i, j, layer].iter().enumerate().for_each(|(d, &c)| x[grid.axes[d]] = grid.middle(d, c));
                let local =
                    snapshot.orientation[0].inverse() * (x - snapshot.position[0]) / snapshot.scale[0];
                shapes[k % shapes.len()].contains(&local)
            };
            assert_eq!(found, cells.filter(is_in).count() as u64, "particle {k}, layer {layer}");
            assert_eq!(all as usize, grid.cells[0] * grid.cells[1]);
        }
    }
}

#[test]
fn volumes_of_bodies_by_cells_are_those_of_their_shapes() {
    let shapes = vec![
        Shape::regular(RegularSolid::Tetrahedron, 0.5, 0.02).unwrap(),
        Shape::cylinder(0.2, 0.5, 0.02).unwrap(),
    ];
    for shape in 0..2 {
        let mut snapshot = particles(vec![Vec3::repeat(0.5)]);
        (snapshot.shape[0], snapshot.orientation[0]) = (shape, turns(5)[4]);
        let found = solid(&unit(2), 0.004, &snapshot, &shapes, false);
        assert!((found / shapes[shape].volume - 1.0).abs() < 3e-4, "{found} {}", shapes[shape].volume);
    }
}

#[test]
fn rings_see_a_tube_within_a_tube() {
    // A cylinder that stands in a cylindrical vessel: full up to its radius, empty beyond.
    let snapshot = particles(vec![Vec3::repeat(0.5)]);
    let shapes = vec![Shape::cylinder(0.2, 1.0, 0.02).unwrap()];
    let region = Region { cylinder: Some(([0.5, 0.5], 0.4)), ..unit(2) };
    let region = Region { lower: Vec3::new(0.1, 0.1, 0.0), upper: Vec3::new(0.9, 0.9, 1.0), ..region };
    let rings = Rings { center: [0.5, 0.5], edges: vec![0.1, 0.2, 0.3, 0.41] };
    let grid = Grid::new(&region, 0.005);
    let case = case([0.0; 3], [1.0; 3], [false; 3], "");
    let counted = count(&region, &grid, Some(&rings), (&snapshot, &shapes), &case.domain, &SerialTransport);
    let shares: Vec<f64> = counted.rings.iter().map(|r| r[1] as f64 / r[0] as f64).collect();
    assert_eq!((shares[0], shares[3]), (1.0, 0.0));
    assert!(shares[1] > 0.99 && shares[2] < 0.01, "{shares:?}");
    let cells = |list: &[[u64; 2]], k: usize| list.iter().map(|c| c[k]).sum::<u64>();
    assert_eq!(cells(&counted.rings, 0), cells(&counted.layers, 0), "the rings hold the whole vessel");
    assert_eq!(cells(&counted.rings, 1), cells(&counted.layers, 1));
    let area = counted.rings[1][0] as f64 / cells(&counted.layers, 0) as f64;
    assert!((area - 0.03 / 0.16).abs() < 2e-3, "{area}");
}

#[test]
fn bits_are_set_and_counted_across_words() {
    let mut row = vec![0_u64; 4];
    set(&mut row, 60, 130);
    set(&mut row, 5, 5);
    set(&mut row, 255, 255);
    assert_eq!(ones(&row, &(0..256)), 73);
    assert_eq!(ones(&row, &(61..130)), 69);
    assert_eq!(ones(&row, &(128..128)), 0);
    assert_eq!(ones(&row, &(64..128)), 64);
    assert_eq!(Line::search(0, 37, |k| k == 23), Some(23));
    assert_eq!(Line::search(3, 5, |k| k == 4), Some(4));
    assert_eq!((1..36).filter(|&m| Line::search(0, 36, |k| k == m) == Some(m)).count(), 35);
}
