//! Shear of the box: where its sliding images are, how long lists last, and the stress.

use super::state::Dem;
use crate::particles::ParticleRecord;
use crate::stress::{Stress, StressSums};
use grains_domain::Transport;
use grains_geometry::{Mat3, Vec3};

impl Dem {
    /// Offset (m) of the images above a sheared box now; 0 of one that is not sheared.
    pub fn shear_offset(&self) -> f64 {
        self.images.map_or(0.0, |images| images.nearest(self.shear_start + images.offset(self.time())))
    }

    /// Gives the images an offset (m) now, as after a restart with another rate.
    pub fn set_shear_offset(&mut self, offset: f64) {
        if let Some(images) = &self.images {
            self.shear_start = images.nearest(offset - images.offset(self.time()));
        }
    }

    /// Mean velocity (m/s) that the shear of the box has at a place (m).
    pub fn mean_flow(&self, position: &Vec3) -> Vec3 {
        self.images.map_or_else(Vec3::zeros, |images| images.mean_flow(position))
    }

    /// An owned particle as it is to be saved: inside the box.
    pub fn saved_record(&self, i: usize) -> ParticleRecord {
        let mut record = self.particles.record(i);
        if let Some(images) = &self.images {
            images.wrap_record(&mut record, self.shear_offset());
        }
        record.body.position = Vec3::from(self.setup.global.wrap(record.body.position.into()));
        record
    }

    /// Lets images slide to where they are now: on from where they were when the lists were built, or there anew.
    pub(super) fn slide_images(&mut self, is_rebuilt: bool) {
        let Some(images) = &self.images else { return };
        let now = self.shear_offset();
        if is_rebuilt {
            self.built_at = now;
        }
        self.exchange.slide(images, self.built_at + images.nearest(now - self.built_at));
    }

    /// How far (m) images may slide before the lists are rebuilt, and after how many steps that is due.
    pub(super) fn slide_allowance(&self) -> (f64, u64) {
        let Some(images) = &self.images else { return (0.0, u64::MAX) };
        let of_a_step = images.speed.abs() * self.setup.parameters.dt;
        let (skin, radius) = (&self.setup.skin, self.setup.largest_radius);
        let way = (of_a_step * skin.horizon).clamp(skin.min * radius, skin.max * radius);
        let steps = (way / of_a_step).max(1.0).floor();
        // Offsets are rounded: one step more than those that are made.
        (of_a_step * (steps + 1.0), steps as u64)
    }

    /// Begins the sum over the contacts of this step.
    pub(super) fn begin_virial(&mut self) {
        self.particles.virial = self.images.map(|_| Mat3::zeros());
    }

    /// Adds this step to the sums for the stress.
    pub(super) fn sum_stress(&mut self) {
        if let (Some(images), Some(virial)) = (&self.images, self.particles.virial.take()) {
            self.stress.add(&self.particles, &virial, images);
        }
    }

    /// Sums for the stress over all ranks.
    pub fn stress_sums(&self, transport: &impl Transport) -> StressSums {
        let mut numbers = self.stress.numbers();
        let (steps, sums) = numbers.split_at_mut(1);
        transport.max(steps);
        transport.sum(sums);
        StressSums::from_numbers(&numbers)
    }

    /// Mean stress of a sheared box since it was taken last, over all ranks.
    pub fn take_stress(&mut self, transport: &impl Transport) -> Option<Stress> {
        self.images?;
        let sums = self.stress_sums(transport);
        self.stress = StressSums::default();
        Some(sums.mean((0..3).map(|a| self.setup.global.length(a)).product()))
    }
}
