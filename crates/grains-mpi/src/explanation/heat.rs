//! What the terminal shows of the temperatures of particles.

use grains_case::{Case, Fluid, ParticleTransfer, Radiation, Scalar, ScalarKind};
use grains_simulation::check::{CouplingReport, HeatReport, Passing, ResolvedReport, effectiveness};

/// Prints how particles exchange heat.
pub fn tell(case: &Case, found: &HeatReport) {
    let Some(heat) = &case.heat else { return };
    say!(
        "heat           particles of {} K unless their insertion or its file says otherwise",
        heat.temperature
    );
    for ([a, b], conductivity, modulus) in &found.pairs {
        let radius = match modulus {
            Some(modulus) => {
                format!("that of elastic bodies, E* = {modulus:.4e} Pa, under the force of the law")
            }
            None => "that of the law".to_string(),
        };
        say!(
            "  contacts     {a} - {b}: Q = {conductivity:.4e} W/(m K) x a x difference, contact radius a {radius}"
        );
    }
    if found.pairs.is_empty() {
        say!("  contacts     conduct nothing: no two materials that touch have a conductivity");
    }
    if let Some(gas) = heat.gas {
        say!(
            "  gas          {} W/(m K) around contacts and in gaps of spheres, in layers of {} radii, over at least {:e} m{}",
            gas.conductivity,
            gas.thickness,
            gas.smallest_gap,
            if gas.through_solid { ", and on through the spheres" } else { "" }
        );
    }
    if let Some(Radiation { surroundings }) = heat.radiation {
        say!("  radiation    of the surface of each particle with surroundings of {surroundings} K");
    }
    for wall in &case.walls {
        if let Some(temperature) = wall.temperature {
            say!("  wall         {}: {temperature} K", wall.name);
        }
    }
    if let Some(relaxation) = found.relaxation {
        say!(
            "  time scale   with twelve contacts as wide as limits.overlap allows particles take {relaxation:.3e} s or longer to \
             follow these; heat is evaluated every {} step(s), a Fourier number of {:.2e} (1 at most)",
            found.every,
            found.fourier
        );
        if found.fourier > 1.0 {
            say!(
                "  warning: contacts as wide as that let temperatures grow without bound, which ends the run; lower time.dt to {:.1e} s",
                0.5 * relaxation / found.every as f64
            );
        }
    }
}

/// Largest Biot number at which a particle has one temperature (-).
const ONE_TEMPERATURE: f64 = 0.1;

/// Prints what particles exchange with a scalar of the fluid.
pub fn of_transfer(
    case: &Case,
    (fluid, scalar): (&Fluid, &Scalar),
    transfer: &ParticleTransfer,
    found: &CouplingReport,
) {
    let diameters = found.kinds.iter().map(|kind| kind.diameter);
    let [smallest, largest] =
        [diameters.clone().fold(f64::INFINITY, f64::min), diameters.fold(0.0, f64::max)];
    let diffusivity = scalar.diffusivity(fluid.density);
    let prandtl = fluid.viscosity / fluid.density / diffusivity;
    let still = Passing { reynolds: 0.0, prandtl, void_fraction: found.void_fraction };
    let Some(law) = transfer.law else { return };
    let number = law.nusselt(&still);
    let name = if matches!(scalar.kind, ScalarKind::Temperature { .. }) { "Nusselt" } else { "Sherwood" };
    say!(
        "    particles  exchange it by {law:?}, {name} number {number:.3} in still fluid at void fraction {}",
        found.void_fraction
    );
    let used =
        |k: usize| case.inserts.iter().flat_map(|insert| &insert.particles).any(|part| part.material == k);
    if let ScalarKind::Temperature { conductivity, .. } = scalar.kind {
        for (_, material) in case.materials.iter().enumerate().filter(|(k, _)| used(*k)) {
            let (Some(density), Some(capacity)) = (material.density, material.heat_capacity) else {
                continue;
            };
            let time = density * capacity * smallest * smallest / (6.0 * number * conductivity);
            let biot = material.conductivity.map(|inside| 0.5 * number * conductivity / inside);
            let told = biot.map_or(String::new(), |biot| {
                let warning = match biot > ONE_TEMPERATURE {
                    true => "; warning: above 0.1 the temperature varies inside, which one per particle does not show",
                    false => "",
                };
                format!(", Biot number {biot:.2e}{warning}")
            });
            say!("    follow     the smallest of {} in {time:.3e} s of still fluid{told}", material.name);
        }
    }
    if let Some(uptake) = &transfer.uptake {
        let time = uptake.partition * smallest * smallest / (6.0 * number * diffusivity);
        say!(
            "    uptake     {} times the concentration outside; the smallest follow in {time:.3e} s of still fluid",
            uptake.partition
        );
    }
    if let (Some(evaporation), Some(heat)) = (&transfer.evaporation, &case.heat) {
        let saturation = evaporation.saturation(heat.temperature);
        let time = evaporation.initial * smallest * smallest / (6.0 * number * diffusivity * saturation);
        say!(
            "    evaporates {:.4e} kg/m3 at saturation at {} K; the smallest are dry after {time:.3e} s in still dry gas of this temperature",
            saturation,
            heat.temperature
        );
    }
    if let Some(reaction) = &transfer.reaction {
        let of = |diameter: f64| {
            let modulus =
                reaction.diffusivity.map_or(0.0, |inside| diameter / 6.0 * (reaction.rate / inside).sqrt());
            (modulus, effectiveness(modulus))
        };
        let [(small, of_small), (large, of_large)] = [smallest, largest].map(of);
        say!(
            "    reaction   {} 1/s; Thiele modulus V/A sqrt(k/D) {small:.3e} to {large:.3e}, effectiveness {of_small:.3} to {of_large:.3}",
            reaction.rate
        );
    }
}

/// Cells across the layer in which a reaction takes place, below which its rate is off by a twentieth and more (-).
const THIN_LAYER: f64 = 0.5;

/// Prints what resolved particles exchange with a scalar of the fluid, with cells of a width (m).
pub fn of_resolved(
    (fluid, scalar): (&Fluid, &Scalar),
    transfer: &ParticleTransfer,
    found: &ResolvedReport,
    width: f64,
) {
    let diameters = found.cells_across.map(|cells| cells * width);
    let diffusivity = scalar.diffusivity(fluid.density);
    if transfer.value.is_some() {
        say!("    particles  have a given value on their surfaces");
    }
    if transfer.flux.is_some() {
        say!("    particles  give off a given flux");
    }
    if transfer.uniform {
        say!("    particles  have one temperature each, which follows what the fluid and [heat] bring");
    }
    let Some(inside) = &transfer.inside else { return };
    let capacity = scalar.capacity(fluid.density);
    let (within, ratio) = match inside.conductivity.zip(inside.volumetric_heat_capacity) {
        Some((conductivity, of_volume)) => {
            (conductivity / of_volume, conductivity / (capacity * diffusivity))
        }
        None => {
            let within = inside.diffusivity.unwrap_or_default();
            (within, within * inside.partition.unwrap_or(1.0) / diffusivity)
        }
    };
    let times = diameters.map(|diameter| diameter * diameter / (4.0 * within));
    say!(
        "    particles  diffuse it inside, {ratio:.3e} times as well as the fluid; through the smallest and largest in {:.3e} and {:.3e} s",
        times[0],
        times[1]
    );
    let Some(reaction) = &transfer.reaction else { return };
    if reaction.order != 1.0 {
        say!("    reaction   of order {}, {:.4e} in SI units", reaction.order, reaction.rate);
        return;
    }
    let of = |diameter: f64| {
        let modulus = diameter / 6.0 * (reaction.rate / within).sqrt();
        (modulus, effectiveness(modulus))
    };
    let [(small, of_small), (large, of_large)] = diameters.map(of);
    let cells = (within / reaction.rate).sqrt() / width;
    let warning = match cells < THIN_LAYER {
        true => "; warning: with fewer than 0.5 its rate is off by 5 % and more, take narrower cells",
        false => "",
    };
    say!(
        "    reaction   {} 1/s; Thiele modulus d/6 sqrt(k/D) {small:.3e} to {large:.3e}, effectiveness of spheres {of_small:.3} to \
         {of_large:.3}; {cells:.1} cells across the layer sqrt(D/k){warning}",
        reaction.rate
    );
}
