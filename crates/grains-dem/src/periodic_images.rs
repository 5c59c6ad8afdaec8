//! Periodic images of a particle, numbered 0 to 26 by steps of −1, 0 or 1 periods along x, y and z.

use grains_domain::GlobalBox;
use grains_geometry::Vec3;

/// The particle itself.
pub(crate) const HOME: u8 = 13;

/// Steps of an image along the axes (periods).
fn steps(image: u8) -> [i32; 3] {
    let code = i32::from(image);
    [code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1]
}

/// Shift (m) of each image.
pub(crate) fn shifts(global: &GlobalBox) -> Vec<Vec3> {
    let length = |a: usize| if global.periodic[a] { global.length(a) } else { 0.0 };
    (0..27).map(|image| Vec3::from_fn(|a, _| f64::from(steps(image)[a]) * length(a))).collect()
}

/// Images that may come within `range` (m) of something in the box, by steps along some periodic axes.
pub(crate) fn near_faces<'a>(
    global: &'a GlobalBox,
    position: &Vec3,
    range: f64,
    axes: [bool; 3],
) -> impl Iterator<Item = u8> + 'a {
    let near = std::array::from_fn::<_, 3, _>(|a| {
        let is_open = axes[a] && global.periodic[a];
        // Moved up it must be near the lower face, and the other way round.
        [
            is_open && global.upper[a] - position[a] < range,
            true,
            is_open && position[a] - global.lower[a] < range,
        ]
    });
    let home_only = near.iter().all(|[down, _, up]| !down && !up);
    let images = if home_only { HOME..HOME + 1 } else { 0..27 };
    images.filter(move |&image| {
        let steps = steps(image);
        (0..3).all(|a| near[a][(steps[a] + 1) as usize])
    })
}

/// The image as seen from the wrapped position, if it is one of its 27.
///
/// Along axes that are `wrapped` anyway an image has no step and keeps none.
pub(crate) fn seen_from_wrapped(
    image: u8,
    position: &Vec3,
    global: &GlobalBox,
    wrapped: [bool; 3],
) -> Option<u8> {
    let mut code = 0;
    for a in (0..3).rev() {
        let mut step = steps(image)[a];
        if !wrapped[a] && global.periodic[a] {
            let moved = position[a] - global.wrap_along(a, position[a]);
            step += (moved / global.length(a)).round() as i32;
        }
        if !(-1..=1).contains(&step) {
            return None;
        }
        code = 3 * code + (step + 1) as u8;
    }
    Some(code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_keeps_its_place_when_the_particle_is_wrapped() {
        let global = GlobalBox::new([0.0; 3], [1.0, 2.0, 3.0], [true, true, false]);
        let shifts = shifts(&global);
        let position = Vec3::new(1.1, -0.1, 1.0);
        let wrapped = Vec3::from(global.wrap(position.into()));
        for image in 0..27 {
            let Some(seen) = seen_from_wrapped(image, &position, &global, [false; 3]) else { continue };
            let (before, after) = (position + shifts[image as usize], wrapped + shifts[seen as usize]);
            assert!((before - after).norm() < 1e-12, "image {image}: {before} and {after}");
        }
        assert_eq!(seen_from_wrapped(HOME, &position, &global, [true; 3]), Some(HOME));
    }

    #[test]
    fn only_images_near_a_face_are_looked_for() {
        let global = GlobalBox::new([0.0; 3], [1.0; 3], [true, true, false]);
        let count = |x: f64, y: f64| near_faces(&global, &Vec3::new(x, y, 0.01), 0.1, [true; 3]).count();
        assert_eq!([count(0.5, 0.5), count(0.05, 0.5), count(0.05, 0.95)], [1, 2, 4]);
    }
}
