//! Triangles that show the walls in a viewer.

use grains_dem::{Dem, Surface, WallState};
use grains_domain::GlobalBox;
use grains_geometry::{Core, Rotation, Shape, TriMesh, Vec3};
use grains_output::FieldSpec;
use nalgebra::Rotation3;
use std::f64::consts::TAU;

/// Fields of the triangles of walls, of which some wear or none.
pub fn wall_fields(has_wear: bool) -> Vec<FieldSpec> {
    let mut fields = vec![FieldSpec::integer("wall"), FieldSpec::real("velocity", "m/s", 3)];
    if has_wear {
        fields.push(FieldSpec::real("worn_depth", "m", 1));
    }
    fields
}

/// Triangles of all walls that exist now.
#[derive(Clone, Debug, Default)]
pub struct WallTriangles {
    /// Positions (m), `[points][3]`.
    pub points: Vec<f64>,
    /// Point numbers, `[triangles][3]`.
    pub triangles: Vec<i64>,
    /// Wall number of each triangle.
    pub walls: Vec<i64>,
    /// Velocity of each triangle's middle (m/s), `[triangles][3]`.
    pub velocities: Vec<f64>,
    /// Mean depth (m) to which each triangle is worn.
    pub worn_depths: Vec<f64>,
}

/// The triangles of the walls of a system, where they are now; of each surface of each wall that wears with the volumes (m³) of
/// its elements, as of [`Dem::worn_volumes`].
pub fn triangles_of(dem: &Dem, worn: &[Vec<Vec<f64>>]) -> WallTriangles {
    let mut all = WallTriangles::default();
    for (index, (wall, state)) in dem.setup.walls.iter().zip(dem.wall_states()).enumerate() {
        if !wall.exists_at(dem.time()) {
            continue;
        }
        for (k, surface) in wall.surfaces.iter().enumerate() {
            let mesh = tessellated(surface, &dem.setup.global);
            all.add(&mesh, state, index);
            let volumes = worn[index].get(k).map_or(&[][..], Vec::as_slice);
            all.worn_depths.extend(worn_depths(&mesh, volumes));
        }
    }
    all
}

impl WallTriangles {
    fn add(&mut self, mesh: &TriMesh, state: &WallState, wall: usize) {
        let first = (self.points.len() / 3) as i64;
        let place = |p: &Vec3| state.rotation * p + state.translation;
        self.points.extend(mesh.vertices.iter().flat_map(|v| <[f64; 3]>::from(place(v))));
        for triangle in &mesh.triangles {
            self.triangles.extend(triangle.iter().map(|&k| first + i64::from(k)));
            self.walls.push(wall as i64);
            let middle = triangle.iter().map(|&k| place(&mesh.vertices[k as usize])).sum::<Vec3>() / 3.0;
            self.velocities.extend(<[f64; 3]>::from(state.velocity_at(&middle)));
        }
    }
}

/// Worn depth (m) of each triangle: its volume over its area, or that of the whole surface where its volume alone is known.
fn worn_depths(mesh: &TriMesh, volumes: &[f64]) -> Vec<f64> {
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|k| mesh.vertices[k as usize]);
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    let areas = mesh.triangles.iter().map(area);
    match *volumes {
        [] => areas.map(|_| 0.0).collect(),
        [volume] => {
            let whole: f64 = areas.clone().sum();
            areas.map(|_| volume / whole).collect()
        }
        _ => areas.zip(volumes).map(|(area, volume)| volume / area).collect(),
    }
}

fn tessellated(surface: &Surface, global: &GlobalBox) -> TriMesh {
    match surface {
        Surface::Mesh(mesh) => mesh.mesh().clone(),
        Surface::Plane { point, normal } => plane_in_box(point, normal, global),
        Surface::Tube { center, axis, radius, half_length } => {
            tube(center, axis, *radius, *half_length, global)
        }
        Surface::OpenTube(sheet) => tube(&sheet.center, &sheet.axis, sheet.radius, sheet.half_length, global),
        Surface::Solid { core, rotation, center, .. } => {
            let shape = match core {
                Core::Box(half) => Shape::cuboid(half * 2.0, 1e-6),
                Core::Cylinder { radius, half_height } => Shape::cylinder(*radius, 2.0 * half_height, 1e-6),
                Core::Point
                | Core::Segment { .. }
                | Core::Cone(_)
                | Core::Polyhedron(_)
                | Core::Triangle(_)
                | Core::Superellipsoid(_) => return TriMesh::default(),
            };
            let rotation = Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
            shape.map_or_else(|_| TriMesh::default(), |s| s.surface.transformed(&rotation, 1.0, center))
        }
    }
}

/// The part of a plane inside the box: a square as large as the box, cut by its six faces.
fn plane_in_box(point: &Vec3, normal: &Vec3, global: &GlobalBox) -> TriMesh {
    let (lower, upper) = (Vec3::from(global.lower), Vec3::from(global.upper));
    let middle = (lower + upper) * 0.5;
    let foot = middle - normal * (middle - point).dot(normal);
    let helper = if normal.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
    let (u, v) = (normal.cross(&helper).normalize(), normal.cross(&normal.cross(&helper)).normalize());
    let half = (upper - lower).norm();
    let mut polygon: Vec<Vec3> = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
        .map(|(a, b)| foot + (u * a + v * b) * half)
        .to_vec();
    // A sheet lying in a face of the box must survive the cut.
    let margin = 1e-9 * half;
    for axis in 0..3 {
        for (sign, bound) in [(1.0, upper[axis] + margin), (-1.0, -(lower[axis] - margin))] {
            polygon = cut(&polygon, |p| bound - sign * p[axis]);
        }
    }
    fan(polygon)
}

/// The part of a convex polygon where `inside` is not negative.
fn cut(polygon: &[Vec3], inside: impl Fn(&Vec3) -> f64) -> Vec<Vec3> {
    let mut kept = Vec::new();
    for (k, p) in polygon.iter().enumerate() {
        let next = &polygon[(k + 1) % polygon.len()];
        let (a, b) = (inside(p), inside(next));
        if a >= 0.0 {
            kept.push(*p);
        }
        if (a < 0.0) != (b < 0.0) {
            kept.push(p + (next - p) * (a / (a - b)));
        }
    }
    kept
}

fn fan(polygon: Vec<Vec3>) -> TriMesh {
    let triangles = (2..polygon.len() as u32).map(|k| [0, k - 1, k]).collect();
    TriMesh { vertices: polygon, triangles }
}

fn tube(center: &Vec3, axis: &Vec3, radius: f64, half_length: f64, global: &GlobalBox) -> TriMesh {
    const SIDES: u32 = 64;
    let half = half_length.min((Vec3::from(global.upper) - Vec3::from(global.lower)).norm());
    let helper = if axis.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
    let u = axis.cross(&helper).normalize();
    let v = axis.cross(&u);
    let mut mesh = TriMesh::default();
    for k in 0..SIDES {
        let angle = TAU * f64::from(k) / f64::from(SIDES);
        let rim = center + (u * libm::cos(angle) + v * libm::sin(angle)) * radius;
        mesh.vertices.extend([rim - axis * half, rim + axis * half]);
        let (a, b) = (2 * k, 2 * ((k + 1) % SIDES));
        mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
    }
    mesh
}
