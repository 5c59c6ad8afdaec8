//! The kinds of particles of a case and their sizes: what time step, neighbours and fluid ask before there are any.

use super::rows::{FileRows, component_kind};
use crate::sizes::Sizes;
use grains_case::{Basis, Case, Component};
use grains_dem::{Catalogue, Kind};
use grains_domain::Transport;

/// A kind of particle that a case can insert.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KindRange {
    /// Shape and material.
    pub kind: Kind,
    /// Smallest scale (-).
    pub smallest: f64,
    /// Largest scale (-).
    pub largest: f64,
    /// Scale below which a tenth of the mass is (-).
    pub tenth: f64,
    /// Whether only one particle of the case moves freely: it meets walls and particles of prescribed motion at most.
    pub is_alone: bool,
    /// Whether its motion is prescribed: contacts feel no mass of it.
    pub is_prescribed: bool,
}

/// The kind of a component, by the distribution of its sizes.
pub fn of_component(component: &Component, sizes: &Sizes) -> KindRange {
    let scale = &component.scale;
    let (smallest, largest) = (scale.smallest(), scale.largest());
    KindRange {
        kind: component_kind(component),
        smallest,
        largest,
        tenth: sizes.quantile(Basis::Mass, 0.1),
        is_alone: false,
        is_prescribed: false,
    }
}

/// The kinds among the rows of a file that a component completes, in the order of the rows; collective.
pub fn of_rows(
    case: &Case,
    catalogue: &Catalogue,
    (rows, component, sizes): (&FileRows, &Component, &Sizes),
    transport: &impl Transport,
) -> Vec<KindRange> {
    let drawn = of_component(component, sizes);
    let (shapes, materials) = (case.shapes.len(), case.materials.len());
    // Of each kind the negative smallest and the largest scale, and the negative first row.
    let mut table = vec![[f64::NEG_INFINITY; 3]; shapes * materials];
    for row in rows.own() {
        let (kind, scale) = rows.kind(case, catalogue, row, component);
        let (smallest, largest) = scale.map_or((drawn.smallest, drawn.largest), |scale| (scale, scale));
        let found = [-smallest, largest, -(row as f64)];
        let entry = &mut table[usize::from(kind.shape) * materials + usize::from(kind.material)];
        entry.iter_mut().zip(found).for_each(|(known, new)| *known = known.max(new));
    }
    transport.max(table.as_flattened_mut());
    let mut found: Vec<(f64, KindRange)> = Vec::new();
    for (place, &[smallest, largest, first]) in table.iter().enumerate() {
        let kind = Kind { shape: (place / materials) as u16, material: (place % materials) as u16 };
        if largest.is_finite() {
            let tenth = if rows.has_sizes() { -smallest } else { drawn.tenth };
            found.push((-first, KindRange { kind, smallest: -smallest, largest, tenth, ..drawn }));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, range)| range).collect()
}
