//! Checks across sections: whether particles fit the domain and the fluid, and whether every pair has a contact law.

use crate::case::Case;
use crate::check::Checker;
use crate::diagnostic::rounded;
use crate::sections::fluid::{check_step, check_thickness, check_walls};
use crate::sections::insert::Component;
use crate::sections::size_distribution::SizeDistribution;
use crate::vector::norm;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Every particle must fit the domain, and a periodic axis must be longer than the particle.
pub(crate) fn check_sizes(case: &Case, checker: &mut Checker) {
    for (i, insert) in case.inserts.iter().enumerate() {
        for (j, component) in insert.particles.iter().enumerate() {
            let Some(message) = misfit(case, component) else { continue };
            let key = case.shapes[component.shape].kind.size_key();
            let key = match component.scale == SizeDistribution::default() {
                true => format!("shape[{}].{key}", component.shape),
                false => format!("insert[{i}].particles[{j}]"),
            };
            checker.error(&key, message);
        }
    }
}

/// A film must not be thicker than its particle.
pub(crate) fn check_films(case: &Case, checker: &mut Checker) {
    let mut refused = Vec::new();
    for component in case.inserts.iter().flat_map(|insert| &insert.particles) {
        let material = &case.materials[component.material];
        let radius = case.shapes[component.shape].inscribed_radius().map(|r| r * component.scale.smallest());
        let (Some(film), Some(radius)) = (material.film, radius) else { continue };
        let volume = film.on_sphere(radius, material.density.unwrap_or(0.0));
        let thickness = libm::cbrt(radius.powi(3) + 0.75 / std::f64::consts::PI * volume) - radius;
        if thickness > radius && !refused.contains(&component.material) {
            refused.push(component.material);
            checker.error(
                &format!("material[{}].film", component.material),
                format!(
                    "{} m3 of liquid would be a film of {} m on a particle with an inscribed radius of {} m, thicker than that: check the unit",
                    rounded(volume),
                    rounded(thickness),
                    rounded(radius)
                ),
            );
        }
    }
}

/// Why the largest particle of a component does not fit, if so.
fn misfit(case: &Case, component: &Component) -> Option<String> {
    let shape = &case.shapes[component.shape];
    let scale = component.scale.largest();
    let extents = case.domain.extents();
    let narrowest = (0..3).fold(0, |best, a| if extents[a] < extents[best] { a } else { best });
    let thickness = 2.0 * scale * shape.inscribed_radius().unwrap_or(0.0);
    let length = scale * shape.kind.diameter().unwrap_or(0.0);
    let (size, room, along) = if thickness > extents[narrowest] {
        (thickness, extents[narrowest], format!("along {}", AXES[narrowest]))
    } else if length > norm(extents) {
        (length, norm(extents), "across its diagonal".into())
    } else if case.holds_particles() {
        return None;
    } else {
        let axis = (0..3).find(|&a| case.domain.periodic[a] && length >= extents[a])?;
        return Some(format!(
            "a particle of {} m meets its own periodic image along {}, {} m long; lengthen the domain",
            rounded(length),
            AXES[axis],
            rounded(extents[axis])
        ));
    };
    let (size, room) = (rounded(size), rounded(room));
    let in_metres = rounded(size / 1000.0);
    let hint = if in_metres < 0.5 * room {
        format!("; lengths are in metres: {size} mm is {in_metres} m")
    } else {
        "; reduce the particle or its scale, or enlarge the domain".into()
    };
    Some(format!("a particle of {size} m does not fit the domain, {room} m {along}{hint}"))
}

/// Every pair of materials that can meet must have a contact law.
///
/// Two particles can meet if they come from two insertions, or from one of two particles and more; a particle and a wall if the
/// wall is there before the end. Whether they do is known only when they have: laws are asked for before the run begins.
pub(crate) fn check_pairs(case: &Case, checker: &mut Checker) {
    if case.holds_particles() {
        for i in 0..case.bonds.len() {
            let message = "without effect: all particles stay where they are inserted; remove it";
            checker.error(&format!("bond[{i}]"), message.into());
        }
        return;
    }
    let mut reported: Vec<[usize; 2]> = Vec::new();
    let mut require = |path: &str, a: usize, b: usize| {
        let pair = [a.min(b), a.max(b)];
        if case.contact(a, b).is_none() && !reported.contains(&pair) {
            reported.push(pair);
            checker.error(path, missing_contact(case, a, b));
        }
    };
    // Insertion and particle in it, and whether it moves freely; those without a count insert as many as a file has.
    let components: Vec<(usize, usize, &Component, bool)> = (case.inserts.iter().enumerate())
        .flat_map(|(i, insert)| {
            let is_free = !insert.is_prescribed();
            insert.particles.iter().enumerate().map(move |(j, c)| (i, j, c, is_free))
        })
        .collect();
    let is_single = |insert: usize| case.inserts[insert].count == Some(1);
    for (k, (i, j, later, is_free)) in components.iter().enumerate() {
        for (other, _, earlier, other_is_free) in &components[..=k] {
            // Two of prescribed motion exert nothing on each other.
            if (*is_free || *other_is_free) && (i != other || !is_single(*i)) {
                require(&format!("insert[{i}].particles[{j}].material"), earlier.material, later.material);
            }
        }
    }
    for (i, wall) in case.walls.iter().enumerate().filter(|(_, wall)| wall.from < case.time.end) {
        for (_, _, particle, _) in components.iter().filter(|component| component.3) {
            require(&format!("wall[{i}].material"), particle.material, wall.material);
        }
    }
}

/// Cells of the fluid should not be far smaller than particles, and walls without particles do nothing.
pub(crate) fn check_fluid(case: &Case, checker: &mut Checker) {
    check_walls(case, checker);
    let Some(fluid) = &case.fluid else { return };
    check_step(fluid, (&case.domain, &case.inserts), &case.time, checker);
    let components = case.inserts.iter().flat_map(|insert| &insert.particles);
    let smallest = components
        .filter_map(|c| Some(c.scale.smallest() * case.shapes[c.shape].kind.diameter()?))
        .reduce(f64::min);
    if let Some(diameter) = smallest.filter(|_| fluid.resolved.is_none()) {
        check_thickness(fluid, &case.domain, diameter, checker);
    }
    let idle = case.walls.iter().position(|wall| wall.fluid.is_none());
    if let Some(i) = idle.filter(|_| case.inserts.is_empty()) {
        checker.warn(
            &format!("wall[{i}]"),
            "without effect: a [[wall]] is for particles, and there are none; let it bound the fluid (fluid = \"particles\", \"inside\" or \"outside\"), or take [[fluid.boundary]]"
                .into(),
        );
    }
}

/// The message about a pair of materials without a law.
pub(crate) fn missing_contact(case: &Case, a: usize, b: usize) -> String {
    let (a, b) = (&case.materials[a].name, &case.materials[b].name);
    format!(
        "no contact law between \"{a}\" and \"{b}\"; add [[contact]] with between = [\"{a}\", \"{b}\"], \
         normal_stiffness (N/m), restitution and friction"
    )
}
