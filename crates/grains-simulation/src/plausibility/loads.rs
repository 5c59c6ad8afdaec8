//! Falls and weights that contacts are too soft for, or that the time step does not expect.

use super::setting::{Remark, Setting};
use crate::law_report::LawReport;
use crate::timestep::Partner;
use grains_case::{Case, Insert};
use grains_geometry::Vec3;

/// Axis of the largest component of gravity, and its sign; none if it is oblique or there is none.
fn down(case: &Case) -> Option<(usize, f64)> {
    let gravity = Vec3::from(case.gravity);
    let axis = gravity.iamax();
    let is_along = gravity[axis].abs() > 0.99 * gravity.norm();
    (is_along && gravity[axis] != 0.0).then(|| (axis, gravity[axis].signum()))
}

/// A given impact speed far below that of the fall to the end of the domain.
pub(super) fn slow_fall(s: &Setting) -> Vec<Remark> {
    /// Speed given over that of the fall: what lies between may stop most falls.
    const USUAL: f64 = 0.1;
    let case = s.case;
    let Some((axis, sign)) = down(case) else { return Vec::new() };
    if case.fluid.is_some() || case.domain.periodic[axis] || !s.has_contacts {
        return Vec::new();
    }
    let end = if sign < 0.0 { case.domain.lower[axis] } else { case.domain.upper[axis] };
    // From the end of the region that is nearest to where particles fall to.
    let height = |insert: &Insert| {
        let extents = insert.place.extents()?;
        Some(extents.map(|corner| (corner[axis] - end).abs()).into_iter().fold(f64::INFINITY, f64::min))
    };
    let inserts = case.inserts.iter().enumerate().filter(|(_, insert)| !insert.is_prescribed());
    let falls = inserts.filter_map(|(i, insert)| Some((height(insert)?, i)));
    let (height, index) = falls.fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a });
    let speed = (2.0 * case.gravity[axis].abs() * height).sqrt();
    let given = case.time.impact_speed;
    if given >= USUAL * speed {
        return Vec::new();
    }
    let message = format!(
        "particles of insert[{index}] fall {height:.3} m to the end of the domain, and come there with {speed:.3} m/s: overlaps may be {:.0} times those that check foresees; raise it (m/s), or leave it out",
        speed / given
    );
    vec![("time.impact_speed".into(), message)]
}

/// Contacts so soft that the weight of the bed alone presses particles into each other farther than allowed.
pub(super) fn soft_bed(s: &Setting) -> Vec<Remark> {
    /// Share of space of a loose bed (-).
    const FILLED: f64 = 0.6;
    /// Widths of the bed beyond which its walls carry the rest (-).
    const CARRIED: f64 = 2.0;
    let case = s.case;
    let Some((axis, _)) = down(case) else { return Vec::new() };
    // What leaves, or floats, lies on nothing.
    if case.fluid.is_some() || !case.domain.outlets.is_empty() || case.domain.periodic[axis] {
        return Vec::new();
    }
    let extents = case.domain.extents();
    let across = (0..3).filter(|&a| a != axis);
    let area: f64 = across.clone().map(|a| extents[a]).product();
    let narrowest =
        across.filter(|&a| !case.domain.periodic[a]).map(|a| extents[a]).fold(f64::INFINITY, f64::min);
    let free = case.inserts.iter().filter(|insert| !insert.is_prescribed());
    let volume: f64 = free.map(|insert| insert.count.unwrap_or(0) as f64 * s.volumes(insert)[0]).sum();
    let height = (volume / (FILLED * area)).min(extents[axis]).min(CARRIED * narrowest);
    let of_law = |(place, law): (usize, &LawReport)| {
        let density = case.materials.iter().find(|m| m.name == law.materials[0])?.density?;
        let (radius, diameter) = (s.smallest_radius(), 2.0 * s.smallest_radius());
        // The weight of the column above a particle, which contacts below it carry.
        let weight = density * FILLED * height * case.gravity[axis].abs() * diameter * diameter;
        let limit = case.limits.overlap * radius;
        let effective = if law.partner == Partner::Wall { radius } else { 0.5 * radius };
        let carried = law.law.force_bound(effective, limit);
        (height > 2.0 * diameter && weight > carried).then_some((weight, carried, place))
    };
    let found =
        s.laws.iter().enumerate().filter_map(of_law).max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    let Some((weight, carried, place)) = found else { return Vec::new() };
    let law = &s.laws[place];
    let key = contact_key(case, law);
    let message = format!(
        "a bed of {height:.3} m presses with {weight:.2e} N on a particle of {} at its bottom, and {carried:.2e} N bring it to limits.overlap = {}: the run will end there; raise the stiffness by {:.0} or more",
        law.materials[0],
        case.limits.overlap,
        (10.0 * weight / carried).ceil()
    );
    vec![(key, message)]
}

/// The key that says how stiff a contact is.
fn contact_key(case: &Case, law: &LawReport) -> String {
    let numbers = law.materials.each_ref().map(|name| case.material_index(name).unwrap_or(0));
    let number = case.contact(numbers[0], numbers[1]).unwrap_or(0);
    match case.contacts[number].normal_stiffness {
        Some(_) => format!("contact[{number}].normal_stiffness"),
        None => format!("contact[{number}]"),
    }
}
