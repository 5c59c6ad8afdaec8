//! Walls around a flow averaged over particles: where they stand, and what they leave open of the cells.

use super::exchange::Exchange;
use super::walls::{BoundingWall, FluidWalls};
use crate::error::{RunError, agreed};
use grains_case::Case;
use grains_comm::MpiTransport;
use grains_dem::{Dem, WallState};
use grains_fluid::{Clearance, Enclosure, Flow, Grid};
use grains_geometry::Vec3;
use grains_resolved::{FlowOnWall, SolidSide};

/// Walls of a case around its averaged flow.
pub struct EnclosingWalls {
    walls: FluidWalls,
    /// Numbers of those that were there in the last step of the fluid.
    present: Vec<usize>,
    /// What the flow did to them in that step.
    pub on_walls: Vec<FlowOnWall>,
}

impl EnclosingWalls {
    /// The walls of a case, if some bound its fluid.
    ///
    /// # Errors
    /// Surfaces that are not closed, with the key.
    pub fn new(case: &Case) -> Result<Option<Self>, String> {
        let walls = FluidWalls::new(case)?;
        Ok((!walls.is_empty()).then_some(Self { walls, present: Vec::new(), on_walls: Vec::new() }))
    }

    /// Bounds the flow by the walls as they are at a time (s); collective.
    ///
    /// # Errors
    /// A closed box with an inlet.
    pub fn enclose(
        &mut self,
        case: &Case,
        (flow, exchange): (&mut Flow, &mut Exchange),
        (dem, time): (&Dem, f64),
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        let placed = self.place(dem, time, &flow.setup.grid);
        let about = |e: grains_fluid::SetupError| RunError::case(case.about("fluid", e.to_string()));
        agreed(transport, flow.enclose(&placed, transport).map_err(about))?;
        exchange.enclose(flow);
        self.note_loads(flow, transport);
        Ok(())
    }

    /// Moves the walls, if some move, to where they are at the beginning of a step of the fluid; collective.
    ///
    /// # Errors
    /// Walls that cover an inlet whose flow is stated.
    pub fn advance(
        &mut self,
        (flow, exchange): (&mut Flow, &mut Exchange),
        dem: &Dem,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        if self.walls.are_moving {
            let before = self.present.clone();
            let placed = self.place(dem, dem.time(), &flow.setup.grid);
            let failed =
                |e: grains_fluid::StepError| RunError::unphysical(format!("t = {:.6e} s: {e}", dem.time()));
            let moved = flow.move_walls(&placed, before != self.present, transport);
            agreed(transport, moved.map_err(failed))?;
            exchange.enclose(flow);
        }
        Ok(())
    }

    /// Puts the walls of a continued run where they were in the last step of the fluid; collective.
    pub fn resume(
        &mut self,
        (flow, exchange): (&mut Flow, &mut Exchange),
        dem: &Dem,
        transport: &MpiTransport,
    ) {
        if self.walls.are_moving {
            let began = flow.state.time - flow.state.last_dt;
            let placed =
                self.place(dem, if flow.state.step > 0 { began } else { dem.time() }, &flow.setup.grid);
            flow.resume_walls(&placed, transport);
            exchange.enclose(flow);
        }
    }

    /// Notes what the flow does to the walls, after its step; collective.
    pub fn note_loads(&mut self, flow: &Flow, transport: &MpiTransport) {
        let loads = flow.loads_on_walls(self.walls.all().len(), transport);
        self.on_walls.clear();
        let walls = self.walls.all().iter().zip(loads);
        self.on_walls.extend(walls.filter(|(wall, _)| self.present.contains(&wall.number)).map(
            |(wall, load)| {
                let [fx, fy, fz, tx, ty, tz] = load;
                FlowOnWall {
                    wall: wall.number as u64,
                    force: Vec3::new(fx, fy, fz),
                    torque: Vec3::new(tx, ty, tz),
                }
            },
        ));
    }

    /// Force and torque on each, in the order of the case, NaN for those that were not there.
    pub fn row(&self) -> Vec<f64> {
        self.walls.row(&self.on_walls)
    }

    fn place(&mut self, dem: &Dem, time: f64, grid: &Grid) -> PlacedWalls {
        let is_there = |wall: &BoundingWall| dem.setup.walls[wall.number].exists_at(time);
        self.present =
            self.walls.all().iter().filter(|wall| is_there(wall)).map(|wall| wall.number).collect();
        PlacedWalls::new(&self.walls, grid, |wall| {
            is_there(wall).then(|| dem.wall_state_at(wall.number, time))
        })
    }
}

/// Walls as they stand at one time.
pub struct PlacedWalls {
    walls: Vec<PlacedWall>,
    /// The axis along which nothing varies.
    flat: Option<usize>,
    is_moving: bool,
}

/// A wall, with its number among all that bound the fluid, and the shifts (m) of its periodic images.
struct PlacedWall {
    number: usize,
    wall: BoundingWall,
    state: WallState,
    shifts: Vec<Vec3>,
}

/// Farther than all walls.
const NO_WALL: Clearance = Clearance { distance: f64::INFINITY, direction: [1.0, 0.0, 0.0], wall: 0 };

impl PlacedWall {
    /// Takes where a point (m) lies seen from the image at a shift (m), if no wall is known that is closer to it.
    fn approach(&self, shift: &Vec3, flat: Option<usize>, at: [f64; 3], closest: &mut Clearance) {
        let found =
            self.wall.wall.surface.signed_distance(&self.state.to_wall(&(Vec3::from(at) - shift)), flat);
        let sign = if self.wall.wall.solid == SolidSide::Inside { 1.0 } else { -1.0 };
        if sign * found.distance < closest.distance {
            let direction = (self.state.to_world(&found.outward) * sign).into();
            *closest = Clearance { distance: sign * found.distance, direction, wall: self.number };
        }
    }
}

impl PlacedWalls {
    /// The walls with the shifts of their images.
    fn images(&self) -> impl Iterator<Item = (&PlacedWall, &Vec3)> {
        self.walls.iter().flat_map(|wall| wall.shifts.iter().map(move |shift| (wall, shift)))
    }

    /// Walls in the states that are given of them; those without are not there.
    pub fn new(walls: &FluidWalls, grid: &Grid, state: impl Fn(&BoundingWall) -> Option<WallState>) -> Self {
        let placed = |(number, wall): (usize, &BoundingWall)| {
            let state = state(wall)?;
            Some(PlacedWall { number, shifts: images(wall, &state, grid), wall: wall.clone(), state })
        };
        Self {
            walls: walls.all().iter().enumerate().filter_map(placed).collect(),
            flat: (0..3).find(|&a| !grid.is_active(a)),
            is_moving: walls.are_moving,
        }
    }

    /// All walls as they are at the beginning.
    pub fn at_beginning(walls: &FluidWalls, grid: &Grid) -> Self {
        Self::new(walls, grid, |_| Some(WallState::at_rest()))
    }

    /// Largest area (m²) that the walls leave open of the layers of cells normal to an axis.
    pub fn open_section(&self, axis: usize, grid: &Grid) -> f64 {
        let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
        let of_layer = |layer: usize| {
            let mut open = 0.0;
            for i in 0..grid.cells()[b] {
                for j in 0..grid.cells()[c] {
                    let mut cell = [0; 3];
                    (cell[axis], cell[b], cell[c]) = (layer, i, j);
                    let at = self.clearance(std::array::from_fn(|a| grid.axis(a).centre(cell[a] as isize)));
                    let widths = [b, c].map(|a| grid.axis(a).width(cell[a] as isize));
                    let across = at.direction[b].abs() * widths[0] + at.direction[c].abs() * widths[1];
                    let share = if across > 0.0 {
                        0.5 + at.distance / across
                    } else {
                        f64::from(u8::from(at.distance > 0.0))
                    };
                    open += share.clamp(0.0, 1.0) * widths[0] * widths[1];
                }
            }
            open
        };
        (0..grid.cells()[axis]).map(of_layer).fold(0.0, f64::max)
    }
}

impl Enclosure for PlacedWalls {
    fn clearance(&self, at: [f64; 3]) -> Clearance {
        let mut closest = NO_WALL;
        self.images().for_each(|(wall, shift)| wall.approach(shift, self.flat, at, &mut closest));
        closest
    }

    fn clearances(&self, center: [f64; 3], distance: f64, reach: f64, at: &[[f64; 3]]) -> Vec<Clearance> {
        let mut closest = vec![NO_WALL; at.len()];
        for (wall, shift) in self.images() {
            let mut from_center = NO_WALL;
            wall.approach(shift, self.flat, center, &mut from_center);
            // What is so much farther there is nowhere the closest.
            if from_center.distance <= distance + 2.0 * reach {
                at.iter()
                    .zip(&mut closest)
                    .for_each(|(&at, closest)| wall.approach(shift, self.flat, at, closest));
            }
        }
        // The first and the last are the farthest from the centre.
        let mut ends = at.iter().zip(&closest);
        debug_assert!(
            ends.next().into_iter().chain(ends.next_back()).all(|(&at, one)| self.clearance(at) == *one)
        );
        closest
    }

    fn is_moving(&self) -> bool {
        self.is_moving
    }

    fn velocity(&self, wall: usize, at: [f64; 3]) -> [f64; 3] {
        let placed = self.walls.iter().find(|placed| placed.number == wall);
        let Some(PlacedWall { state, shifts, .. }) = placed else { return [0.0; 3] };
        // Of images that turn, the closest to the axis is that which is there.
        let from_pivot = |shift: &Vec3| (Vec3::from(at) - shift - state.pivot).norm_squared();
        let shift = shifts.iter().min_by(|a, b| from_pivot(a).total_cmp(&from_pivot(b)));
        state.velocity_at(&(Vec3::from(at) - shift.copied().unwrap_or_default())).into()
    }

    fn slips(&self, wall: usize) -> bool {
        self.walls.iter().any(|placed| placed.number == wall && placed.wall.slips)
    }
}

/// Shifts (m) of the images of an obstacle along periodic axes that it does not span.
fn images(wall: &BoundingWall, state: &WallState, grid: &Grid) -> Vec<Vec3> {
    let mut shifts = vec![Vec3::zeros()];
    let extents = wall.wall.surface.extents().filter(|_| wall.wall.solid == SolidSide::Inside);
    let Some([lower, upper]) = extents else { return shifts };
    for a in (0..3).filter(|&a| grid.axis(a).is_periodic()) {
        let length = grid.axis(a).length();
        if upper[a] - lower[a] < length {
            let periods = (state.translation[a] / length).round();
            let beside = |k: f64| move |shift: &Vec3| shift + Vec3::ith(a, (k - periods) * length);
            let around = [-1.0, 0.0, 1.0].into_iter();
            shifts = around.flat_map(|k| shifts.iter().map(beside(k)).collect::<Vec<_>>()).collect();
        }
    }
    shifts
}
