//! Walls that loads move: their step, and how far they may go before the lists are rebuilt.

use super::state::Dem;
use crate::error::StepError;
use crate::walls::{Loading, Travel};
use grains_domain::Transport;
use grains_geometry::Vec3;

impl Dem {
    /// The walls that loads move, with their numbers.
    fn loaded_walls(&self) -> impl Iterator<Item = (usize, Loading)> + '_ {
        let walls = self.setup.walls.iter().enumerate();
        walls.filter_map(|(k, wall)| Some((k, *wall.motion.loading()?)))
    }

    /// Moves the walls that are under a load through the step by the forces on them, summed over the ranks.
    pub(super) fn move_loaded_walls(&mut self, transport: &impl Transport) {
        if self.loaded_walls().next().is_none() {
            return;
        }
        let mut forces = std::mem::take(&mut self.loaded_forces);
        forces.clear();
        forces.extend(self.loaded_walls().flat_map(|(k, _)| <[f64; 3]>::from(self.wall_loads[k].force)));
        transport.sum(&mut forces);
        let mut longest = 0.0_f64;
        let mut sums = forces.chunks_exact(3).map(Vec3::from_column_slice);
        for k in 0..self.setup.walls.len() {
            let Some(loading) = self.setup.walls[k].motion.loading().copied() else { continue };
            let way = self.travels[k].way;
            sums.next().iter().for_each(|force| self.move_loaded_wall(k, &loading, force));
            longest = longest.max((self.travels[k].way - way).abs());
        }
        self.way_left -= longest;
        self.loaded_forces = forces;
    }

    /// Moves one of them through the step, by the force (N) of all particles on it.
    fn move_loaded_wall(&mut self, k: usize, loading: &Loading, force: &Vec3) {
        let (wall, time) = (&self.setup.walls[k], self.time());
        let (largest, dt) = (self.quanta.largest_force, self.setup.parameters.dt);
        if force.amax() > largest {
            let error = StepError::WallLoad { wall: wall.name.clone(), force: force.norm(), largest };
            self.error = self.error.take().or(Some(error));
        }
        let travel = &mut self.travels[k];
        *travel = match loading.acts_at(time) && wall.exists_at(time) {
            true => loading.advance(travel, loading.axis.dot(force), dt),
            false => Travel { way: travel.way, ..Travel::default() },
        };
    }

    /// Looks for a wall that its load has moved out of the box.
    pub(super) fn check_loaded_walls(&mut self) {
        let global = &self.setup.global;
        let is_outside = |k: usize| {
            let state = &self.states[k];
            let corners = global.corners().map(|corner| state.to_wall(&Vec3::from(corner)));
            !self.setup.walls[k].surfaces.iter().any(|surface| surface.meets_box(&corners))
        };
        let Some((k, loading)) = self.loaded_walls().find(|&(k, _)| is_outside(k)) else { return };
        let (step, wall) = (self.step, self.setup.walls[k].name.clone());
        let way = loading.axis.dot(&self.states[k].translation);
        self.error = self.error.take().or(Some(StepError::WallOutside { wall, step, way }));
    }

    /// How far (m) loads may move walls before the lists are rebuilt: as particles may go.
    pub(super) fn loaded_allowance(&self) -> f64 {
        let (skin, radius) = (&self.setup.skin, self.setup.largest_radius);
        let way = |k: usize| self.travels[k].speed.abs() * skin.horizon * self.setup.parameters.dt;
        let ways = self.loaded_walls().map(|(k, _)| way(k).clamp(skin.min * radius, skin.max * radius));
        ways.fold(0.0, f64::max)
    }
}
