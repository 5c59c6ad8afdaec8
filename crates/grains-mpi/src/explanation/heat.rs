//! What the terminal shows of the temperatures of particles.

use grains_case::{Case, Radiation};
use grains_simulation::check::HeatReport;

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
            "  gas          {} W/(m K) around contacts and in gaps of spheres, in layers of {} radii, over at least {:e} m",
            gas.conductivity,
            gas.thickness,
            gas.smallest_gap
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
             follow these; Fourier number of the time step {:.2e} (1 at most)",
            found.fourier
        );
        if found.fourier > 1.0 {
            say!(
                "  warning: contacts as wide as that let temperatures grow without bound, which ends the run; lower time.dt to {:.1e} s",
                0.5 * relaxation
            );
        }
    }
}
