//! The cells of the fluid: where they lie, and whether they make sense.

use super::{BoundaryKind, Fluid};
use crate::check::Checker;
use crate::diagnostic::rounded;
use crate::sections::domain::{Domain, Face};
use grains_fluid::clustered;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Longest over shortest edge of a cell beyond which flows are seldom meant to be computed so.
const LONGEST: f64 = 100.0;

/// Shortest edge over the diameter of the particles below which no cell is meant.
const THINNEST: f64 = 1e-3;

impl Fluid {
    /// Node k of n + 1 along an axis (m).
    fn node(&self, domain: &Domain, axis: usize, k: u64) -> f64 {
        let (share, s) = (k as f64 / self.cells[axis] as f64, self.refinement[axis]);
        let share = if s > 0.0 { clustered(share, s) } else { share };
        domain.lower[axis] + share * domain.extents()[axis]
    }

    /// Edge of the narrowest and of the widest cell along an axis (m): the last and the middle one.
    pub fn cell_widths(&self, domain: &Domain, axis: usize) -> [f64; 2] {
        let n = self.cells[axis];
        [n, n / 2 + n % 2].map(|k| self.node(domain, axis, k) - self.node(domain, axis, k - 1))
    }

    /// Whether the centre of a cell lies between two places (m) along an axis.
    pub(super) fn has_centre_in(&self, domain: &Domain, axis: usize, [lower, upper]: [f64; 2]) -> bool {
        let centre = |k: u64| 0.5 * (self.node(domain, axis, k) + self.node(domain, axis, k + 1));
        let (mut below, mut beyond) = (0, self.cells[axis]);
        // Centres ascend: halve until the first that is not below.
        while below < beyond {
            let middle = below + (beyond - below) / 2;
            if centre(middle) < lower { below = middle + 1 } else { beyond = middle }
        }
        below < self.cells[axis] && centre(below) <= upper
    }

    /// Axes along which the flow varies.
    fn active_axes(&self) -> impl Iterator<Item = usize> + use<> {
        let cells = self.cells;
        (0..3).filter(move |a| cells[*a] > 1)
    }
}

/// Refuses refinement and single cells where they have no meaning; warns of cells of odd shape.
pub(super) fn check(fluid: &Fluid, domain: &Domain, checker: &mut Checker) {
    for (a, axis) in AXES.into_iter().enumerate() {
        let path = format!("fluid.refinement[{a}]");
        if fluid.refinement[a] > 0.0 && domain.periodic[a] {
            let message = format!("{axis} is periodic and has no ends to refine towards; set it to 0");
            checker.error(&path, message);
        } else if fluid.refinement[a] > 0.0 && fluid.cells[a] < 3 {
            checker.warn(&path, format!("without effect on {} cell(s)", fluid.cells[a]));
        }
        if fluid.cells[a] == 1 && !domain.periodic[a] {
            check_one_cell(fluid, a, checker);
        }
    }
    if domain.is_upright() {
        check_aspect_ratio(fluid, domain, checker);
    }
}

/// With one cell nothing varies along the axis: walls and inlets at its ends would.
fn check_one_cell(fluid: &Fluid, axis: usize, checker: &mut Checker) {
    let remedy =
        "an axis of one cell makes the flow two-dimensional, so both its faces must be symmetry planes";
    let faces = [Face::ALL[2 * axis], Face::ALL[2 * axis + 1]];
    if let Some(bare) = faces.into_iter().find(|face| fluid.on_face(*face).whole.is_none()) {
        return checker.error(
            &format!("fluid.cells[{axis}]"),
            format!(
                "{remedy}; add [[fluid.boundary]] with face = \"{}\" and kind = \"symmetry\", or make {} periodic",
                bare.name(),
                AXES[axis]
            ),
        );
    }
    let conditions: Vec<usize> =
        faces.iter().flat_map(|face| fluid.on_face(*face).all().collect::<Vec<_>>()).collect();
    let is_other = |i: &&usize| fluid.boundary[**i].kind != BoundaryKind::Symmetry;
    for i in conditions.iter().filter(is_other) {
        checker.error(&format!("fluid.boundary[{i}].kind"), format!("{remedy}; take \"symmetry\""));
    }
}

fn check_aspect_ratio(fluid: &Fluid, domain: &Domain, checker: &mut Checker) {
    let ratio =
        |long: usize, short: usize| fluid.cell_widths(domain, long)[1] / fluid.cell_widths(domain, short)[0];
    let pairs = fluid.active_axes().flat_map(|long| fluid.active_axes().map(move |short| (long, short)));
    let worst = pairs
        .filter(|(long, short)| long != short)
        .max_by(|a, b| ratio(a.0, a.1).total_cmp(&ratio(b.0, b.1)));
    if let Some((long, short)) = worst
        && ratio(long, short) > LONGEST
    {
        checker.warn(
            "fluid.cells",
            format!(
                "some cells are {} times longer along {} than along {}; is that meant?",
                rounded(ratio(long, short)),
                AXES[long],
                AXES[short]
            ),
        );
    }
}

/// Warns of cells much thinner than the smallest particle, `diameter` (m).
pub(crate) fn check_thickness(fluid: &Fluid, domain: &Domain, diameter: f64, checker: &mut Checker) {
    let width = |axis: &usize| fluid.cell_widths(domain, *axis)[0];
    let Some(axis) = fluid.active_axes().min_by(|a, b| width(a).total_cmp(&width(b))) else { return };
    if width(&axis) < THINNEST * diameter {
        checker.warn(
            &format!("fluid.cells[{axis}]"),
            format!(
                "cells of {:.3e} m are {:.0} times thinner than the smallest particle; is that meant?",
                width(&axis),
                diameter / width(&axis)
            ),
        );
    }
}
