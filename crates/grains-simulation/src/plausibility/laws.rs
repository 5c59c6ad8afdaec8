//! Contact laws: what has no effect, or more of it than is seldom meant.

use super::setting::{Remark, Setting};
use grains_case::{Attraction, Material, Normal};
use grains_contact::Damping;

/// Properties of materials that no contact law takes.
pub(super) fn properties_without_effect(s: &Setting) -> Vec<Remark> {
    let taken_by = |material: usize, takes: fn(&Normal) -> bool| {
        s.case.contacts.iter().any(|c| c.between.contains(&material) && takes(&c.normal))
    };
    type Property = (&'static str, fn(&Material) -> bool, fn(&Normal) -> bool, &'static str);
    let properties: [Property; 2] = [
        ("youngs_modulus", |m| m.youngs_modulus.is_some(), Normal::is_hertzian, "\"hertz\""),
        ("surface_energy", |m| m.surface_energy.is_some(), Normal::takes_work, "\"jkr\" or \"dmt\""),
    ];
    let mut remarks = Vec::new();
    for (k, material) in s.case.materials.iter().enumerate() {
        for (key, is_given, takes, kind) in properties {
            let widens_contacts =
                key == "youngs_modulus" && s.case.heat.is_some() && material.conductivity.is_some();
            if is_given(material) && !taken_by(k, takes) && !widens_contacts {
                let message = format!(
                    "without effect: no contact of \"{}\" has a law that takes it; set normal = {{ kind = {kind} }} in its [[contact]]",
                    material.name
                );
                remarks.push((format!("material[{k}].{key}"), message));
            }
        }
    }
    remarks
}

/// Steps that a Rayleigh wave outruns: Hertzian contacts get stiffer than an impact at `time.impact_speed` makes them.
pub(super) fn rayleigh_outrun(s: &Setting) -> Vec<Remark> {
    /// Usual largest share of the Rayleigh time (-).
    const SHARE: f64 = 0.4;
    let times = s.laws.iter().filter(|law| law.modulus.is_some()).filter_map(|law| law.rayleigh_time);
    let shortest = times.fold(f64::INFINITY, f64::min);
    if s.steps[0] <= SHARE * shortest {
        return Vec::new();
    }
    let message = format!(
        "the step of {:.2e} s is {:.0} % of the Rayleigh time {shortest:.2e} s, above the usual {:.0} %: contacts pressed harder than by time.impact_speed may become unstable; raise time.impact_speed or lower the step",
        s.steps[0],
        100.0 * s.steps[0] / shortest,
        100.0 * SHARE
    );
    vec![("time.dt".into(), message)]
}

/// Adhesion that holds thousands of weights.
pub(super) fn glued(s: &Setting) -> Vec<Remark> {
    /// Bond number above which nothing flows (-).
    const GLUED: f64 = 1e4;
    let strongest = s.laws.iter().filter_map(|law| law.bond_number).fold(0.0, f64::max);
    if strongest < GLUED {
        return Vec::new();
    }
    let message = format!(
        "the pull-off force is {strongest:.1e} weights of the smallest particle: all that touches stays together; check the unit of surface_energy (J/m2), work_of_adhesion (J/m2) or energy_density (J/m3)"
    );
    vec![("contact".into(), message)]
}

/// Softening that changes how much energy adhesion takes.
pub(super) fn softened_adhesion(s: &Setting) -> Vec<Remark> {
    let contacts = s.case.contacts.iter().enumerate();
    let softened = contacts.filter(|(_, c)| c.softening > 1.0 && c.normal.takes_work());
    let remark = |(k, contact): (usize, &grains_case::Contact)| {
        let message = format!(
            "pull-off force and Bond number stay those of the materials, but the energy to part grows {:.1} times and bodies stick at speeds {:.1} times higher; scale work_of_adhesion by softening^(-2/5) to keep these instead",
            libm::pow(contact.softening, 2.0 / 3.0),
            libm::cbrt(contact.softening)
        );
        (format!("contact[{k}].softening"), message)
    };
    softened.map(remark).collect()
}

/// A restitution that another damping leaves without effect.
pub(super) fn restitution_without_effect(s: &Setting) -> Vec<Remark> {
    let contacts = s.case.contacts.iter().enumerate();
    let other = contacts.filter(|(_, c)| matches!(c.damping, Damping::Viscoelastic { .. }));
    let remark = |(k, _): (usize, &grains_case::Contact)| {
        let message = "acts on tangential damping alone: the normal direction is damped by damping.time";
        (format!("contact[{k}].restitution"), message.to_string())
    };
    other.map(remark).collect()
}

/// Bridges of volumes for which no law of their force is known.
pub(super) fn odd_bridges(s: &Setting) -> Vec<Remark> {
    /// Volumes over R³ of the fits (-).
    const KNOWN: [f64; 2] = [1e-5, 0.1];
    let odd = s.laws.iter().filter_map(|law| law.bridge_volume).find(|v| !(KNOWN[0]..=KNOWN[1]).contains(v));
    let is_bridge = |c: &grains_case::Contact| {
        matches!(c.attraction, Attraction::LiquidBridge { .. } | Attraction::FilmBridge { .. })
    };
    let place = s.case.contacts.iter().position(is_bridge);
    let (Some(volume), Some(place)) = (odd, place) else { return Vec::new() };
    let message = format!(
        "{volume:.1e} of the cube of the radius of the smallest bodies, outside {:.0e} to {}, for which the force of bridges is known: check the unit (m3; a microlitre is 1e-9)",
        KNOWN[0], KNOWN[1]
    );
    let key = match s.case.contacts[place].attraction {
        Attraction::FilmBridge { .. } => "kind",
        _ => "volume",
    };
    vec![(format!("contact[{place}].attraction.{key}"), message)]
}

/// Films that no bridge takes from.
pub(super) fn films_without_effect(s: &Setting) -> Vec<Remark> {
    let is_fed = |material: usize| {
        let mut contacts = s.case.contacts.iter();
        contacts
            .any(|c| c.between.contains(&material) && matches!(c.attraction, Attraction::FilmBridge { .. }))
    };
    let wet = s.case.materials.iter().enumerate().filter(|(_, material)| material.film.is_some());
    let remark = |(k, material): (usize, &Material)| {
        let message = format!(
            "without effect: no contact of \"{}\" has bridges that take liquid from it; set attraction = {{ kind = \"film_bridge\", surface_tension = ... }} in its [[contact]]",
            material.name
        );
        (format!("material[{k}].film"), message)
    };
    wet.filter(|(k, _)| !is_fed(*k)).map(remark).collect()
}
