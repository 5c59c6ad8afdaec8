//! What is odd about the sizes of particles.

use super::setting::{Remark, Setting};
use crate::insertion::KindRange;
use crate::timestep::recommended_without_fines;
use grains_case::{Component, Insert};

/// Fraction of an uncut distribution (-) that cut-offs usually keep.
const USUALLY_KEPT: f64 = 0.8;

/// Diameter of the largest over that of the smallest particle (-) beyond which the smallest decide the run.
const USUAL_RATIO: f64 = 20.0;

/// Sizes so different that a few of the mass decide the time step.
pub(super) fn wide_sizes(s: &Setting) -> Vec<Remark> {
    let free: Vec<&KindRange> = s.insertions.kinds().iter().filter(|kind| !kind.is_prescribed).collect();
    let unit = |kind: &KindRange| s.catalogue.shape(kind.kind).sphere_equivalent_diameter();
    let smallest = free.iter().map(|kind| unit(kind) * kind.smallest).fold(f64::INFINITY, f64::min);
    let largest = free.iter().map(|kind| unit(kind) * kind.largest).fold(0.0, f64::max);
    if largest <= USUAL_RATIO * smallest {
        return Vec::new();
    }
    let coarser = recommended_without_fines(s.case, s.catalogue, s.insertions.kinds());
    let gain = coarser.map_or(1.0, |dt| dt / s.steps[1]);
    let remedy = match gain > 1.05 {
        true => format!(
            "; without the finest tenth of the mass of each kind it would be {gain:.1} times longer: raise min"
        ),
        false => "; leave out the smallest, or take fewer sizes".into(),
    };
    let message = format!(
        "diameters from {smallest:.3e} to {largest:.3e} m, a ratio of {:.0}: the smallest decide the time step, {:.2e} s{remedy}",
        largest / smallest,
        s.steps[1]
    );
    vec![(key_of(s, smallest), message)]
}

/// The component that can be as small as a diameter (m).
fn key_of(s: &Setting, diameter: f64) -> String {
    let is_meant = |insert: &Insert, component: &Component| {
        let unit = s.catalogue.shapes[component.shape].sphere_equivalent_diameter();
        !insert.is_prescribed() && unit * component.scale.smallest() <= diameter * (1.0 + 1e-9)
    };
    let components = s.case.inserts.iter().enumerate().flat_map(|(i, insert)| {
        insert.particles.iter().enumerate().map(move |(j, component)| (i, j, insert, component))
    });
    let mut meant = components.filter(|&(_, _, insert, component)| is_meant(insert, component));
    meant.next().map_or("insert".into(), |(i, j, _, _)| format!("insert[{i}].particles[{j}]"))
}

/// Cut-offs that leave out much of what was measured.
pub(super) fn deep_cut_offs(s: &Setting) -> Vec<Remark> {
    let components = s.case.inserts.iter().enumerate().flat_map(|(i, insert)| {
        insert
            .particles
            .iter()
            .enumerate()
            .map(move |(j, component)| (format!("insert[{i}].particles[{j}]"), component))
    });
    let remark = |(key, component): (String, &Component)| {
        let kept = crate::sizes::kept(&component.scale).filter(|kept| *kept < USUALLY_KEPT)?;
        let message = format!(
            "the cut-offs keep {:.1} % of the {} distribution: means and quantiles are far from those given; widen min and max",
            100.0 * kept,
            component.scale.name()
        );
        Some((key, message))
    };
    components.filter_map(remark).collect()
}
