//! Kinds of bonds.

use crate::particles::Body;
use grains_contact::Bond;
use std::sync::Arc;

/// Bonds of one kind: of what, between whom, and when they are made.
#[derive(Clone, Debug)]
pub struct BondKind {
    /// Constants; the radius of the section is that of `radius`.
    pub bond: Bond,
    /// Radius of the section.
    pub radius: BondRadius,
    /// Time (s) at which they are made.
    pub time: f64,
    /// Largest gap (m) between the bounding spheres of two particles that get one.
    pub distance: f64,
    /// Whom they join.
    pub bonded: Bonded,
}

/// Radius of a bond's section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BondRadius {
    /// In metres.
    Length(f64),
    /// Over that of the smaller of both particles' bounding spheres (-).
    OverSmaller(f64),
}

/// Whom bonds of a kind join.
#[derive(Clone, Debug)]
pub enum Bonded {
    /// All near pairs of two materials.
    Materials([u16; 2]),
    /// Pairs of ids, the lower one first, sorted.
    Pairs(Arc<[[u64; 2]]>),
}

impl BondKind {
    /// A bond of this kind between two bodies.
    #[inline(always)]
    pub(crate) fn between(&self, [a, b]: [&Body; 2]) -> Bond {
        let mut bond = self.bond;
        bond.section.radius = self.section_radius(a.radius.min(b.radius));
        bond
    }

    /// Radius (m) of the section where the smaller of both particles has this bounding radius (m).
    pub fn section_radius(&self, smaller: f64) -> f64 {
        match self.radius {
            BondRadius::Length(length) => length,
            BondRadius::OverSmaller(ratio) => ratio * smaller,
        }
    }

    /// How many times its first length a bond may have (-): at σc/E it breaks, and beyond twice nothing is a beam.
    pub fn longest_stretch(&self) -> f64 {
        1.0 + (self.bond.strength.tensile / self.bond.section.young).min(1.0)
    }

    /// Largest length (m) of bonds of particles up to this bounding radius (m).
    pub fn longest(&self, largest_radius: f64) -> f64 {
        (2.0 * largest_radius + self.distance) * self.longest_stretch()
    }

    /// Tension (N) of bonds of particles up to this bounding radius (m) at a tenth of strain: the largest that sums allow for.
    pub fn force_bound(&self, largest_radius: f64) -> f64 {
        let mut section = self.bond.section;
        section.radius = self.section_radius(largest_radius);
        0.1 * section.young * section.area()
    }

    /// Whether it joins particles of these ids and materials.
    pub(crate) fn joins(&self, [id, other]: [u64; 2], [material, of_other]: [u16; 2]) -> bool {
        match &self.bonded {
            Bonded::Materials([a, b]) => (material, of_other) == (*a, *b) || (of_other, material) == (*a, *b),
            Bonded::Pairs(pairs) => pairs.binary_search(&[id.min(other), id.max(other)]).is_ok(),
        }
    }
}
