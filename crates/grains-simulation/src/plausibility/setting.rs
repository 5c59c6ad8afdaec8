//! What the rules look at.

use crate::insertion::{Insertions, KindRange};
use crate::law_report::LawReport;
use grains_case::{Case, Component, Domain, Insert};
use grains_dem::{Catalogue, Wall};
use grains_geometry::Vec3;

/// Displacement per step over the smallest radius (-) beyond which contacts begin deep.
pub const LONG_DISPLACEMENT: f64 = 0.2;

/// A key such as `wall[0].scale`, and what is odd about its value.
pub type Remark = (String, String);

/// A case as it is set up.
pub struct Setting<'a> {
    pub case: &'a Case,
    pub walls: &'a [Wall],
    pub catalogue: &'a Catalogue,
    pub insertions: &'a Insertions,
    /// Time step, and the one that "auto" would take (s).
    pub steps: [f64; 2],
    /// Whether anything can touch anything.
    pub has_contacts: bool,
    /// What the contact laws come to.
    pub laws: &'a [LawReport],
}

impl Setting<'_> {
    pub fn domain(&self) -> &Domain {
        &self.case.domain
    }

    /// Length of the diagonal of the domain (m).
    pub fn diagonal(&self) -> f64 {
        let [lower, upper] = self.corners();
        (upper - lower).norm()
    }

    pub fn corners(&self) -> [Vec3; 2] {
        [Vec3::from(self.domain().lower), Vec3::from(self.domain().upper)]
    }

    /// Whether there are particles that move.
    pub fn has_moving_particles(&self) -> bool {
        !self.case.inserts.iter().all(Insert::is_fixed)
    }

    /// Whether there are particles that move by the forces on them.
    pub fn has_free_particles(&self) -> bool {
        !self.case.inserts.iter().all(Insert::is_prescribed)
    }

    /// Particles in all (-).
    pub fn count(&self) -> u64 {
        self.insertions.total()
    }

    /// Diameter (m) of the spheres of the volumes of the smallest and the largest particle.
    pub fn diameters(&self) -> [f64; 2] {
        let kinds = self.insertions.kinds().iter();
        let of = |k: &KindRange| {
            let diameter = self.catalogue.shape(k.kind).sphere_equivalent_diameter();
            [k.smallest * diameter, k.largest * diameter]
        };
        kinds.map(of).fold([f64::INFINITY, 0.0], |[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    /// Radius (m) of the largest ball in the smallest particle.
    pub fn smallest_radius(&self) -> f64 {
        let kinds = self.insertions.kinds().iter();
        kinds
            .map(|k| k.smallest * self.catalogue.shape(k.kind).inscribed_radius)
            .fold(f64::INFINITY, f64::min)
    }

    /// Volumes (m³) of the smallest and the largest particle of an insertion.
    pub fn volumes(&self, insert: &Insert) -> [f64; 2] {
        let of = |component: &Component| {
            let volume = self.catalogue.shapes[component.shape].volume;
            [component.scale.smallest(), component.scale.largest()].map(|scale| volume * scale.powi(3))
        };
        insert.particles.iter().map(of).fold([f64::INFINITY, 0.0], |[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    /// Speed (m/s) and index of the fastest insertion.
    pub fn fastest_insertion(&self) -> (f64, usize) {
        let inserts = self.case.inserts.iter().enumerate();
        let free = inserts.filter(|(_, insert)| !insert.is_prescribed());
        free.map(|(i, insert)| (Vec3::from(insert.velocity).norm(), i))
            .fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a })
    }
}
