//! What has worn off the walls.

use super::state::Dem;
use crate::walls::{Wear, WornElement, WornWall};
use grains_domain::Transport;

impl Dem {
    /// Whether some wall wears.
    pub fn has_wear(&self) -> bool {
        self.setup.walls.iter().any(|wall| wall.wear.is_some())
    }

    /// Volume (m³) of one quantum of a [`WornElement`] of each wall that wears.
    pub fn worn_quanta(&self) -> Vec<Option<f64>> {
        let volume = |wear: Wear| wear.volume_per_work() * self.sliding.quantum;
        self.setup.walls.iter().map(|wall| wall.wear.map(volume)).collect()
    }

    /// What has worn off each wall that wears, over all ranks.
    pub fn worn_walls(&self, transport: &impl Transport) -> Vec<Option<WornWall>> {
        let sums = self.sliding.of_walls(transport);
        let per_step = self.sliding.quantum / self.setup.parameters.dt;
        let worn = |([last, done], volume): ([u128; 2], Option<f64>)| {
            Some(WornWall { volume: done as f64 * volume?, sliding_power: last as f64 * per_step })
        };
        // There are no sums if no wall wears.
        let none = std::iter::repeat([0; 2]);
        sums.into_iter().chain(none).zip(self.worn_quanta()).map(worn).collect()
    }

    /// Volume (m³) that has worn off each element of each surface of each wall, over all ranks: the triangles of meshes, else the
    /// whole; no surfaces of walls that do not wear.
    pub fn worn_volumes(&self, transport: &impl Transport) -> Vec<Vec<Vec<f64>>> {
        let mut volumes = vec![Vec::new(); self.setup.walls.len()];
        let quanta = self.worn_quanta();
        for (k, surfaces) in self.sliding.of_elements(transport).into_iter().enumerate() {
            let volume = quanta[k].unwrap_or(0.0);
            let of_surface = |elements: Vec<u128>| elements.iter().map(|&n| n as f64 * volume).collect();
            volumes[k] = surfaces.into_iter().map(of_surface).collect();
        }
        volumes
    }

    /// The elements of walls that have worn, over all ranks.
    pub fn worn_elements(&self, transport: &impl Transport) -> Vec<WornElement> {
        let mut worn = Vec::new();
        for (wall, surfaces) in self.sliding.of_elements(transport).iter().enumerate() {
            for (surface, elements) in surfaces.iter().enumerate() {
                let count = |(element, &quanta): (usize, &u128)| {
                    let (wall, surface, element) = (wall as u16, surface as u16, element as u32);
                    (quanta > 0).then_some(WornElement { wall, surface, element, quanta })
                };
                worn.extend(elements.iter().enumerate().filter_map(count));
            }
        }
        worn
    }

    /// Whether a wall has an element (0 of a surface that is no mesh) that can wear off.
    pub fn has_element(&self, wall: u16, surface: u16, element: u32) -> bool {
        let surface = self.setup.walls[usize::from(wall)].surfaces.get(usize::from(surface));
        surface.is_some_and(|surface| surface.has_worn_element(element))
    }

    /// Adds what had worn off an element of a wall (on one rank; nothing on the others), as after a restart.
    pub fn restore_worn(&mut self, worn: WornElement) {
        self.sliding.restore(worn);
    }
}
