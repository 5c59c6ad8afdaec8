//! Which components of a composite touch or overlap.

use super::{Component, SHARP, label};
use crate::gjk::{Separation, distance};
use crate::{Part, Placement, ShapeError, Simplex};

/// Bodies closer than this touch (relative to the size of the composite): their places come from users,
/// who round them.
const TOUCHING: f64 = 1e-6;
/// Bodies that overlap by less only touch (relative to the size of the composite).
const OVERLAPPING: f64 = 4.0 * SHARP;
/// Components a message names before it only counts them.
const NAMED: usize = 10;

/// The components of a composite and what hangs together.
pub(super) struct Contacts<'a> {
    components: &'a [Component],
    /// Parts with sharp edges, in the frame of the composite.
    parts: &'a [Part],
    /// For each component, the lowest component it hangs together with.
    leader: Vec<usize>,
    /// Whether any two share more than their surface.
    overlapping: bool,
}

impl<'a> Contacts<'a> {
    /// Tests every pair.
    pub(super) fn of(components: &'a [Component], parts: &'a [Part], size: f64) -> Result<Self, ShapeError> {
        let mut contacts = Self { components, parts, leader: (0..parts.len()).collect(), overlapping: false };
        for (j, b) in parts.iter().enumerate() {
            for (i, a) in parts[..j].iter().enumerate() {
                let reach = a.bounding_radius + b.bounding_radius + TOUCHING * size;
                if (a.center - b.center).norm() <= reach {
                    let gap = gap(a, b)?;
                    contacts.overlapping |= gap < -OVERLAPPING * size;
                    if gap <= TOUCHING * size {
                        contacts.join(i, j);
                    }
                }
            }
        }
        Ok(contacts)
    }

    pub(super) fn are_overlapping(&self) -> bool {
        self.overlapping
    }

    fn join(&mut self, i: usize, j: usize) {
        let (a, b) = (self.leader[i], self.leader[j]);
        if a != b {
            self.leader.iter_mut().filter(|l| **l == a.max(b)).for_each(|l| *l = a.min(b));
        }
    }

    /// Refuses components that form several bodies, naming those of the first that hangs not together
    /// with component 0, and the gap to be closed.
    pub(super) fn check_connected(&self) -> Result<(), ShapeError> {
        let Some(outsider) = self.leader.iter().position(|&l| l != 0) else { return Ok(()) };
        let is_apart = |k: &usize| self.leader[*k] == outsider;
        let (apart, rest): (Vec<usize>, Vec<usize>) = (0..self.parts.len()).partition(is_apart);
        let mut nearest = (outsider, 0, f64::INFINITY);
        for &i in &apart {
            for &j in &rest {
                let gap = gap(&self.parts[i], &self.parts[j])?;
                if gap < nearest.2 {
                    nearest = (i, j, gap);
                }
            }
        }
        let name = |k: usize| label(self.components, k);
        let mut names: Vec<String> = apart.iter().take(NAMED).map(|&k| name(k)).collect();
        if apart.len() > NAMED {
            names.push(format!("{} more", apart.len() - NAMED));
        }
        let (inside, outside, gap) = nearest;
        Err(ShapeError::Apart { apart: names.join(", "), inside: name(inside), outside: name(outside), gap })
    }
}

/// Gap of two placed parts, −∞ if even their cores meet (m).
fn gap(a: &Part, b: &Part) -> Result<f64, ShapeError> {
    let placement = Placement {
        matrix: a.rotation.tr_mul(&b.rotation),
        translation: a.rotation.tr_mul(&(b.center - a.center)),
    };
    let cores = distance(&a.core, &b.core, &placement, f64::INFINITY, &mut Simplex::default())?;
    Ok(match cores {
        Separation::Apart { distance, .. } => distance - a.crust - b.crust,
        Separation::Beyond { .. } => f64::INFINITY,
        Separation::Meeting => f64::NEG_INFINITY,
    })
}
