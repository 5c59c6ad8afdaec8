//! Walls that bound the fluid.

use super::enclosure::PlacedWalls;
use super::setup;
use grains_case::{BoundaryKind, Case, Face, Fluid, FluidSide, Meshes, Side, Wall, WallKind};
use grains_dem::{Dem, Surface};
use grains_fluid::{Enclosure, Grid};
use grains_geometry::{ClosedMesh, ClosedSurface, Vec3};
use grains_resolved::{FlowOnWall, FluidWall, Form, RigidBody, SolidSide};
use std::sync::Arc;

/// Columns of the flow's action on a wall: force, and torque about the origin.
pub const COLUMNS: [(&str, &str); 6] =
    [("fx", "N"), ("fy", "N"), ("fz", "N"), ("tx", "N m"), ("ty", "N m"), ("tz", "N m")];

/// Depth (cells) in a wall from which an inlet blows into it.
const IN_WALL: f64 = 1e-6;

/// A wall of a case that bounds its fluid.
#[derive(Clone, Debug)]
pub struct BoundingWall {
    /// Its number in the case.
    pub number: usize,
    /// Surface and solid side.
    pub wall: FluidWall,
    /// Whether the fluid slips along it.
    pub slips: bool,
}

/// Walls of a case that bound its fluid.
#[derive(Clone, Debug, Default)]
pub struct FluidWalls {
    walls: Vec<BoundingWall>,
    /// Whether one of them moves, comes or goes.
    pub are_moving: bool,
}

impl FluidWalls {
    /// The walls of a case.
    ///
    /// # Errors
    /// Surfaces that are not closed, with the key.
    pub fn new(case: &Case) -> Result<Self, String> {
        let wall = |(number, wall): (usize, &Wall)| {
            let surface =
                surface(wall, &case.meshes).map_err(|e| case.about(&format!("wall[{number}]"), e))?;
            let solid = solid_side(wall);
            Ok(BoundingWall { number, wall: FluidWall { surface, solid }, slips: wall.slip })
        };
        let walls = case.walls_of_fluid().map(wall).collect::<Result<_, String>>()?;
        Ok(Self { walls, are_moving: case.walls.iter().any(Wall::moves_fluid) })
    }

    /// Those that are there now, with pose and velocity.
    pub fn placed(&self, dem: &Dem) -> Vec<(FluidWall, RigidBody)> {
        let time = dem.time();
        let there = self.walls.iter().filter(|wall| dem.setup.walls[wall.number].exists_at(time));
        let placed = there.map(|BoundingWall { number, wall, .. }| {
            let state = &dem.wall_states()[*number];
            let body = RigidBody {
                id: *number as u64,
                form: Form::Wall(0),
                scale: 1.0,
                center: state.translation,
                rotation: state.rotation,
                velocity: state.velocity_at(&state.translation),
                spin: state.angular_velocity,
            };
            (wall.clone(), body)
        });
        placed.collect()
    }

    /// Force and torque on each, in the order of the case; NaN for those that are not there.
    pub fn row(&self, on_walls: &[FlowOnWall]) -> Vec<f64> {
        let of_wall = |wall: &BoundingWall| match on_walls.iter().find(|on| on.wall == wall.number as u64) {
            Some(FlowOnWall { force, torque, .. }) => {
                [force.x, force.y, force.z, torque.x, torque.y, torque.z]
            }
            None => [f64::NAN; 6],
        };
        self.walls.iter().flat_map(of_wall).collect()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.walls.is_empty()
    }

    /// All of them, in the order of the case.
    pub fn all(&self) -> &[BoundingWall] {
        &self.walls
    }

    /// Refuses inlets that blow into a wall.
    ///
    /// # Errors
    /// The inlet, with a place and a remedy.
    pub fn check_inlets(&self, case: &Case, fluid: &Fluid, grid: &Grid) -> Result<(), String> {
        let placed = PlacedWalls::at_beginning(self, grid);
        let width = setup::narrowest(case, fluid);
        for face in Face::ALL.into_iter().filter(|face| !self.walls.is_empty() && grid.is_active(face.axis()))
        {
            let places = places_on(face, grid);
            let on_face = fluid.on_face(face);
            for k in on_face.whole.into_iter().chain(on_face.patches.iter().copied()) {
                let boundary = &fluid.boundary[k];
                let Some(speed) = normal_speed(&boundary.kind, face.axis()) else { continue };
                let is_of = |place: &&[f64; 3]| fluid.boundary_at(face, **place) == Some(k);
                let blows = |place: &&[f64; 3]| {
                    -placed.clearance(**place).distance > IN_WALL * width && speed(**place) != 0.0
                };
                if let Some(place) = places.iter().filter(is_of).find(blows) {
                    let message = format!(
                        "the inlet blows into a wall, at {place:?} m among others: give it a part of the face that lies in the fluid (lower and upper, center and radius, or corners), or a formula of the velocity that is 0 there, such as 0.1 * step(0.05^2 - y^2 - z^2)"
                    );
                    return Err(case.about(&format!("fluid.boundary[{k}]"), message));
                }
            }
        }
        Ok(())
    }

    /// What they make of the cells of a grid at the beginning; none if there are none.
    pub fn report(&self, grid: &Grid) -> Option<WallsReport> {
        if self.walls.is_empty() {
            return None;
        }
        let placed = PlacedWalls::at_beginning(self, grid);
        let [nx, ny, nz] = grid.cells();
        let center = |cell: [usize; 3]| Vec3::from_fn(|a, _| grid.axis(a).centre(cell[a] as isize));
        let mut solid = vec![false; nx * ny * nz];
        let index = |[i, j, k]: [usize; 3]| (k * ny + j) * nx + i;
        let cells = || (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
        cells().for_each(|cell| solid[index(cell)] = placed.clearance(center(cell).into()).distance < 0.0);
        let is_narrow = |cell: &[usize; 3]| {
            let beside = |a: usize| {
                let mut beside = [*cell; 2];
                (cell[a] > 0 && cell[a] + 1 < grid.cells()[a]).then(|| {
                    (beside[0][a], beside[1][a]) = (cell[a] - 1, cell[a] + 1);
                    beside.iter().all(|&cell| solid[index(cell)])
                })
            };
            !solid[index(*cell)] && (0..3).filter_map(beside).any(|narrow| narrow)
        };
        let mut narrow = cells().filter(is_narrow);
        let first = narrow.next().map(|cell| center(cell).into());
        Some(WallsReport {
            solid: solid.iter().filter(|solid| **solid).count() as f64 / solid.len() as f64,
            narrow: first.map(|place| (1 + narrow.count(), place)),
        })
    }
}

/// What walls make of the cells of a fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallsReport {
    /// Share of the cells whose centres are solid (-).
    pub solid: f64,
    /// Cells between two walls that are no wider than they, and the centre of the first (m).
    pub narrow: Option<(usize, [f64; 3])>,
}

/// Middles (m) of the faces of cells on a face of the box.
fn places_on(face: Face, grid: &Grid) -> Vec<[f64; 3]> {
    let normal = face.axis();
    let [b, c] = [(normal + 1) % 3, (normal + 2) % 3];
    let end = if face.is_upper() { grid.cells()[normal] } else { 0 };
    let mut places = Vec::new();
    for i in 0..grid.cells()[b] {
        for j in 0..grid.cells()[c] {
            let mut place = [0.0; 3];
            place[normal] = grid.axis(normal).node(end as isize);
            (place[b], place[c]) = (grid.axis(b).centre(i as isize), grid.axis(c).centre(j as isize));
            places.push(place);
        }
    }
    places
}

/// What of the speed (m/s) through an inlet normal to an axis is known at a place (m) from the start; none of other boundaries.
fn normal_speed(kind: &BoundaryKind, axis: usize) -> Option<Box<dyn Fn([f64; 3]) -> f64>> {
    match kind {
        BoundaryKind::Inlet { velocity } => {
            let formula = velocity[axis].compile().ok()?;
            Some(Box::new(move |at| formula.at(at, 0.0)))
        }
        BoundaryKind::ParabolicInlet { mean } => {
            let mean = *mean;
            Some(Box::new(move |_| mean))
        }
        BoundaryKind::FlowInlet { .. } => Some(Box::new(|_| 1.0)),
        BoundaryKind::Wall { .. }
        | BoundaryKind::Outlet { .. }
        | BoundaryKind::PressureInlet { .. }
        | BoundaryKind::Symmetry => None,
    }
}

/// The closed surface of a wall.
fn surface(wall: &Wall, meshes: &Meshes) -> Result<ClosedSurface, String> {
    Ok(match &wall.kind {
        WallKind::Plane { point, normal } => {
            ClosedSurface::Plane { point: Vec3::from(*point), normal: Vec3::from(*normal) }
        }
        WallKind::Box { lower, upper, .. } => {
            ClosedSurface::Box { lower: Vec3::from(*lower), upper: Vec3::from(*upper) }
        }
        WallKind::Cylinder { center, axis, radius, height, .. } => ClosedSurface::Cylinder {
            center: Vec3::from(*center),
            axis: Vec3::from(*axis),
            radius: *radius,
            half_length: 0.5 * height,
        },
        WallKind::Cone { .. } | WallKind::Revolution { .. } => {
            ClosedSurface::Revolution(crate::wall_surfaces::revolution(&wall.kind).ok_or("has no profile")?)
        }
        WallKind::Mesh { .. } | WallKind::Polygons { .. } => {
            let (surfaces, _) = crate::wall_surfaces::surfaces(&wall.kind, meshes)?;
            let [Surface::Mesh(mesh)] = &surfaces[..] else { return Err("is no mesh".into()) };
            let closed = ClosedMesh::new(mesh.mesh().clone()).map_err(|e| e.to_string())?;
            ClosedSurface::Mesh(Arc::new(closed))
        }
    })
}

/// Corners (m) of a box about a wall with fluid all around it; none of what has no end, is not closed, or holds the fluid.
pub fn obstacle(wall: &Wall, meshes: &Meshes) -> Option<[Vec3; 2]> {
    (solid_side(wall) == SolidSide::Inside).then(|| surface(wall, meshes).ok()?.extents()).flatten()
}

/// Where a wall is solid. What is before a plane is outside the half space behind it.
fn solid_side(wall: &Wall) -> SolidSide {
    let fluid_inside = match (wall.fluid, &wall.kind) {
        (Some(FluidSide::Inside), _) => true,
        (Some(FluidSide::Particles), kind) => kind.side() == Some(Side::Inside),
        _ => false,
    };
    if fluid_inside { SolidSide::Outside } else { SolidSide::Inside }
}

/// Numbers of the action of a flow on a wall, but for that of the wall.
const NUMBERS: usize = 6;

/// The flow's action on walls as a text of a checkpoint.
pub fn text(on_walls: &[FlowOnWall]) -> String {
    let numbers = |on_wall: &FlowOnWall| {
        let FlowOnWall { wall, force, torque } = on_wall;
        let reals = force.iter().chain(torque).map(|x| format!("{:x}", x.to_bits()));
        std::iter::once(wall.to_string()).chain(reals).collect::<Vec<_>>().join(" ")
    };
    on_walls.iter().map(numbers).collect::<Vec<_>>().join("\n")
}

/// Reads what [`text`] wrote.
pub fn parse(text: &str) -> Option<Vec<FlowOnWall>> {
    let of_line = |line: &str| {
        let mut words = line.split_whitespace();
        let wall = words.next()?.parse().ok()?;
        let real = |word: &str| u64::from_str_radix(word, 16).ok().map(f64::from_bits);
        let x: Vec<f64> = words.map(real).collect::<Option<_>>()?;
        let x = x.get(..NUMBERS)?;
        let [force, torque] = [0, 3].map(|k| Vec3::from_column_slice(&x[k..k + 3]));
        Some(FlowOnWall { wall, force, torque })
    };
    text.lines().map(of_line).collect()
}
