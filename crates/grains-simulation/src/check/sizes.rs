//! What `check` finds of size distributions.

use crate::insertion::Insertions;
use crate::sizes::Sizes;
use grains_case::{Basis, Case, Component, Insert};
use grains_dem::Catalogue;

/// The sizes of one kind of particle of an insertion: diameters (m) of the spheres of the same volume.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeReport {
    /// Name of the insertion.
    pub insert: String,
    /// Names of shape and material.
    pub kind: [String; 2],
    /// What the distribution is called.
    pub name: &'static str,
    /// What its fractions are fractions of.
    pub basis: Basis,
    /// Fraction of the uncut distribution between the cut-offs (-), where there is an uncut one.
    pub kept: Option<f64>,
    /// Smallest and largest.
    pub range: [f64; 2],
    /// Mean by number and mean by mass.
    pub means: [f64; 2],
    /// Diameters below which 10, 50 and 90 % of the mass are.
    pub by_mass: [f64; 3],
}

impl SizeReport {
    /// Those of all insertions that draw different sizes.
    pub(super) fn of_all(case: &Case, catalogue: &Catalogue, insertions: &Insertions) -> Vec<Self> {
        let drawn = insertions.drawn_sizes();
        let drawn = drawn.filter(|(_, component, _)| component.scale.smallest() < component.scale.largest());
        drawn
            .map(|(insert, component, sizes)| Self::of(case, catalogue, (insert, component, sizes)))
            .collect()
    }

    fn of(
        case: &Case,
        catalogue: &Catalogue,
        (insert, component, sizes): (&Insert, &Component, &Sizes),
    ) -> Self {
        let given = &component.scale;
        let unit = catalogue.shapes[component.shape].sphere_equivalent_diameter();
        Self {
            insert: insert.name.clone(),
            kind: [&case.shapes[component.shape].name, &case.materials[component.material].name]
                .map(String::clone),
            name: given.name(),
            basis: given.basis(),
            kept: sizes.kept,
            range: [given.smallest(), given.largest()].map(|size| unit * size),
            means: [Basis::Number, Basis::Mass].map(|basis| unit * sizes.mean(basis)),
            by_mass: [0.1, 0.5, 0.9].map(|fraction| unit * sizes.quantile(Basis::Mass, fraction)),
        }
    }
}
