//! The kinds of particles of a case: how each settles and fluidises.

use super::SETTLED;
use crate::population::KindRange;
use grains_case::{Case, Fluid};
use grains_coupling::{Bed, DragLaw, Flow, Fluid as Medium, ShapeFactors, ShapeProfile};
use grains_dem::{Catalogue, Kind};

/// Particles of one shape, material and size in the fluid.
#[derive(Clone, Debug)]
pub struct Settling {
    /// What they are.
    pub name: String,
    /// Diameter of the sphere of their volume (m).
    pub diameter: f64,
    /// Edges of the narrowest cells over the diameter (-).
    pub cells: [f64; 3],
    /// Speed and relaxation time, or why there is none.
    pub motion: Result<Motion, String>,
}

/// Speeds and times of particles in a fluid.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Speed at which one settles alone (m/s).
    pub terminal: f64,
    /// Whether the law is for beds only, and the terminal speed by that of Wen and Yu.
    pub is_by_wen_yu: bool,
    /// Relaxation time m/β at that slip (s).
    pub relaxation: f64,
    /// Minimum fluidisation velocity by the law at [`SETTLED`] (m/s).
    pub fluidisation: f64,
    /// The same by the correlation of Wen and Yu (m/s).
    pub correlation: f64,
    /// Relaxation time m/β in the bed at minimum fluidisation (s).
    pub relaxation_in_bed: f64,
}

impl Settling {
    /// The shortest relaxation time (s).
    pub fn shortest_relaxation(&self) -> f64 {
        self.motion.as_ref().map_or(f64::INFINITY, |m| m.relaxation.min(m.relaxation_in_bed))
    }

    /// Lines about these particles.
    pub fn lines(&self) -> Vec<String> {
        let [x, y, z] = self.cells;
        let mut lines = vec![format!(
            "  particles    {}: diameter {:.4e} m, cells of {x:.2} x {y:.2} x {z:.2} diameters",
            self.name, self.diameter
        )];
        match &self.motion {
            Ok(m) => {
                let by = if m.is_by_wen_yu { " by Wen and Yu, as Ergun's law is for beds" } else { "" };
                lines.push(format!(
                    "    alone      terminal velocity {:.4e} m/s{by}, relaxation time m/beta {:.3e} s",
                    m.terminal, m.relaxation
                ));
                lines.push(format!(
                    "    in a bed   minimum fluidisation at {:.4e} m/s by the law at void fraction {SETTLED}, at {:.4e} \
                     m/s by the correlation of Wen and Yu; relaxation time {:.3e} s",
                    m.fluidisation, m.correlation, m.relaxation_in_bed
                ));
            }
            Err(reason) => lines.push(format!("    neither settle nor fluidise: {reason}")),
        }
        lines
    }
}

/// All kinds of particles, the smallest and the largest of each.
///
/// # Errors
/// Shapes without a surface.
pub fn kinds(
    case: &Case,
    catalogue: &Catalogue,
    fluid: &Fluid,
    law: DragLaw,
    ranges: &[KindRange],
) -> Result<Vec<Settling>, String> {
    let mut sizes: Vec<(Kind, [f64; 2])> = Vec::new();
    for &KindRange { kind, smallest, largest, .. } in ranges {
        match sizes.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, [least, most])) => (*least, *most) = (least.min(smallest), most.max(largest)),
            None => sizes.push((kind, [smallest, largest])),
        }
    }
    let mut kinds = Vec::new();
    for (kind, scales) in sizes {
        let shape = shape_factors(catalogue, kind, law)
            .map_err(|reason| case.about(&format!("shape[{}]", kind.shape), reason))?;
        let count = if scales[0] < scales[1] { 2 } else { 1 };
        for scale in &scales[..count] {
            kinds.push(settling(case, catalogue, fluid, law, (kind, *scale, shape)));
        }
    }
    Ok(kinds)
}

/// Those of a body that lies any way, if the law looks at it.
fn shape_factors(catalogue: &Catalogue, kind: Kind, law: DragLaw) -> Result<ShapeFactors, String> {
    if !law.depends_on_shape() {
        return Ok(ShapeFactors::SPHERE);
    }
    let profile = ShapeProfile::new(catalogue.shape(kind)).map_err(|error| error.to_string())?;
    Ok(ShapeFactors::any_orientation(profile.sphericity))
}

fn settling(
    case: &Case,
    catalogue: &Catalogue,
    fluid: &Fluid,
    law: DragLaw,
    (kind, scale, shape): (Kind, f64, ShapeFactors),
) -> Settling {
    let diameter = catalogue.shape(kind).sphere_equivalent_diameter() * scale;
    let bed = Bed {
        fluid: Medium { density: fluid.density, viscosity: fluid.viscosity },
        solid_density: catalogue.densities[kind.material as usize],
        diameter,
        shape,
        void_fraction: SETTLED,
        gravity: case.gravity.iter().map(|g| g * g).sum::<f64>().sqrt(),
    };
    let names = (&case.shapes[kind.shape as usize].name, &case.materials[kind.material as usize].name);
    Settling {
        name: format!("{} of {}", names.0, names.1),
        diameter,
        cells: [0, 1, 2].map(|a| fluid.cell_widths(&case.domain, a)[0] / diameter),
        motion: motion(&bed, law, catalogue.mass(kind, scale)),
    }
}

/// Speeds and relaxation times of particles of a mass (kg).
fn motion(bed: &Bed, law: DragLaw, mass: f64) -> Result<Motion, String> {
    if bed.gravity == 0.0 {
        return Err("there is no gravity (gravity = [0, 0, 0])".into());
    }
    let is_by_wen_yu = law == DragLaw::Ergun;
    let alone = if is_by_wen_yu { DragLaw::WenYu } else { law };
    let terminal = bed.terminal_velocity(alone).map_err(|error| error.to_string())?;
    let fluidisation = bed.minimum_fluidisation_velocity(law).map_err(|error| error.to_string())?;
    let relaxation = |law: DragLaw, void_fraction: f64, superficial: f64| {
        let reynolds = bed.fluid.reynolds(bed.diameter, 1.0, superficial);
        let flow = Flow { reynolds, void_fraction, shape: bed.shape };
        mass / law.coefficient(&bed.fluid, bed.diameter, &flow)
    };
    Ok(Motion {
        terminal,
        is_by_wen_yu,
        relaxation: relaxation(alone, 1.0, terminal),
        fluidisation,
        correlation: bed.wen_yu_correlation(),
        relaxation_in_bed: relaxation(law, SETTLED, fluidisation),
    })
}
