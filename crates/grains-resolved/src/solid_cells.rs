//! The middles of cells that bodies and walls hold, which is how scalars see them.

use crate::nodes::ball_indices;
use crate::wall::{Solids, WallRun};
use crate::{Resolved, RigidBody, Subgrid};
use grains_domain::Transport;
use grains_fluid::{Flow, SolidCellsBuilder, SurfacePoint};
use grains_geometry::{Shape, Vec3};

/// The component whose velocities would lie in the middles of cells.
const MIDDLES: usize = 3;

/// Distance (widths of a cell) up to which a middle tells of a surface.
const NEAR: f64 = 2.0;

impl Resolved {
    /// Tells the scalars of the flow where bodies and walls are, to be followed by [`Flow::pass_solids`]; collective.
    ///
    /// `of_bodies` has the value of every own body for each scalar, `numbers` those of the walls that are there in
    /// [`grains_fluid::SolidConditions::walls`].
    pub fn place_for_scalars(
        &self,
        (shapes, numbers): (&[Shape], &[usize]),
        of_bodies: &[Vec<f64>],
        flow: &mut Flow,
        transport: &dyn Transport,
    ) {
        let solids = Solids { bodies: &self.bodies, shapes, walls: &self.walls, subgrid: &self.subgrid };
        let first_wall = self.first_wall();
        let has_shares = flow.scalars_need_shares(true) || flow.scalars_need_shares(false);
        let walls = numbers.iter().max().map_or(0, |last| last + 1);
        let counts = [first_wall, first_wall + walls];
        let mut builder = SolidCellsBuilder::new(self.subgrid.layout.len(), counts, has_shares);
        for (wall, number) in numbers.iter().enumerate() {
            solids.for_each_run(MIDDLES, wall, |run| {
                hold_run(&run, (first_wall + number) as u32, &self.subgrid, &mut builder);
            });
        }
        for body in 0..first_wall {
            claim_middles(body, &solids, &mut builder);
        }
        let of_solids = of_bodies.iter().map(|values| self.of_all_bodies(values, transport)).collect();
        flow.place_solids(builder, of_solids);
    }

    /// Tells a scalar of the flow the values of the own bodies, which stay where they are; collective.
    pub fn tell_scalar(&self, number: usize, own: &[f64], flow: &mut Flow, transport: &dyn Transport) {
        let values = self.of_all_bodies(own, transport);
        if let Some(scalars) = &mut flow.scalars {
            scalars.all[number].of_solids = values;
        }
    }

    /// Values of own bodies and their ghosts; collective.
    fn of_all_bodies(&self, own: &[f64], transport: &dyn Transport) -> Vec<f64> {
        let mut values = vec![[0.0]; self.first_wall()];
        values.iter_mut().zip(own).for_each(|(value, own)| value[0] = *own);
        self.ghosts.scatter(&mut values, &self.subgrid, transport);
        values.into_iter().map(|[value]| value).collect()
    }

    /// Sums over all ranks of what each has for its bodies, of the own ones. Collective.
    pub fn sum_over_bodies<const N: usize>(
        &self,
        mut parts: Vec<[f64; N]>,
        transport: &dyn Transport,
    ) -> Vec<[f64; N]> {
        parts.resize(self.first_wall(), [0.0; N]);
        self.ghosts.gather(&mut parts, &self.subgrid, transport);
        parts.truncate(self.owned);
        parts
    }
}

/// Gives middles of a run to a wall.
fn hold_run(run: &WallRun, wall: u32, subgrid: &Subgrid, builder: &mut SolidCellsBuilder) {
    let [first, j, k] = run.first;
    let near = NEAR * subgrid.spacing.max();
    let surface = &run.out.surface;
    if surface.distance.abs() < near {
        builder.note(SurfacePoint {
            place: subgrid.layout.index(first, j, k),
            solid: wall,
            distance: -surface.distance,
            normal: surface.direction.into(),
        });
    }
    if !run.is_solid {
        return;
    }
    for i in first..first + run.count as isize {
        let place = subgrid.layout.index(i, j, k);
        if builder.holder(place).is_none() {
            builder.hold(place, wall);
        }
    }
}

/// Gives the middles in a body to it, but those that walls have, or bodies with a nearer centre.
fn claim_middles(number: usize, solids: &Solids, builder: &mut SolidCellsBuilder) {
    let (body, subgrid): (&RigidBody, &Subgrid) = (&solids.bodies[number], solids.subgrid);
    let radius = body.radius(solids.shapes);
    let near = NEAR * subgrid.spacing.max();
    let [x, y, z] = ball_indices(subgrid, MIDDLES, &body.center, radius);
    for k in z {
        for j in y.clone() {
            for i in x.clone() {
                let at = Vec3::from_fn(|a, _| subgrid.coordinate(MIDDLES, a, [i, j, k][a]));
                let square = (at - body.center).norm_squared();
                if square >= radius * radius {
                    continue;
                }
                let Some(out) = solids.closest_point(number, &at) else { continue };
                let place = subgrid.layout.index(i, j, k);
                let distance = -out.surface.distance.max(0.0);
                if -distance < near {
                    let normal = out.surface.direction.into();
                    builder.note(SurfacePoint { place, solid: number as u32, distance, normal });
                }
                let first_wall = solids.bodies.len() - solids.walls.len();
                let is_taken = builder.holder(place).is_some_and(|other| {
                    let is_wall = other as usize >= first_wall;
                    let nearer = |other: &RigidBody| {
                        ((at - other.center).norm_squared(), other.id) <= (square, body.id)
                    };
                    is_wall || nearer(&solids.bodies[other as usize])
                });
                if !is_taken {
                    builder.hold(place, number as u32);
                }
            }
        }
    }
}
