//! Contacts that go on from one element of a wall to the next.

use super::pairs::{WallPair, WallScene};
use crate::contact_history::LawHistory;
use grains_geometry::Vec3;

/// Gives the history of a contact that ended to one that began beside it on the same surface, as when a
/// ball rolls from one triangle of a flat floor to the next.
///
/// `normal` is that of the contact of a pair, in the wall's frame, if it touches.
pub(super) fn hand_over_history(
    (pairs, laws): (&mut [WallPair], &mut [LawHistory]),
    normal: impl Fn(usize) -> Option<Vec3>,
    scene: &WallScene,
) {
    let surface = &scene.walls[pairs[0].wall as usize].surfaces[pairs[0].surface as usize];
    for k in 0..pairs.len() {
        let has_history =
            |l: usize| pairs[l].is_stretched() || laws.get(l).is_some_and(|law| !law.is_empty());
        let Some(direction) = normal(k) else { continue };
        if has_history(k) {
            continue;
        }
        let orphan = (0..pairs.len()).find(|&l| {
            normal(l).is_none()
                && has_history(l)
                && surface.goes_on(pairs[l].element, pairs[k].element, &direction)
        });
        if let Some(l) = orphan {
            (pairs[k].tangential_displacement, pairs[k].torsional_angle) =
                (pairs[l].tangential_displacement, pairs[l].torsional_angle);
            pairs[l].reset_displacements();
            if let Some(law) = laws.get_mut(l).map(std::mem::take) {
                laws[k] = law;
            }
        }
    }
}
