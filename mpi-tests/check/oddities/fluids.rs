//! Units of fluids and temperatures, and flows that carry nothing or carry particles off.

use super::Oddity;

pub(super) const ODDITIES: &[Oddity] = &[
    (
        "a gas in mPa s",
        "bed.toml",
        &[("viscosity = 1.8e-5", "viscosity = 0.018")],
        "fluid.viscosity",
        "0.018 mPa s are 1.8e-5",
    ),
    (
        "a kinematic viscosity of water",
        "duct.toml",
        &[("viscosity = 0.5", "viscosity = 1e-6")],
        "fluid.viscosity",
        "times the density is 1.0e-3 Pa s",
    ),
    (
        "air of the density of water",
        "bed.toml",
        &[("density = 1.2", "density = 1200")],
        "fluid.viscosity",
        "mend fluid.density",
    ),
    (
        "hot particles in degrees Celsius",
        "base.toml",
        &[
            ("density = 2500", "density = 2500\nheat_capacity = 840\nconductivity = 1"),
            ("count = 16", "count = 16\ntemperature = 80"),
            ("[output]", "[heat]\ntemperature = 300\n\n[output]"),
        ],
        "insert[0].temperature",
        "80 degrees Celsius are 353.15",
    ),
    (
        "cold particles in degrees Celsius",
        "heated.toml",
        &[("[heat]\ntemperature = 300", "[heat]\ntemperature = 27")],
        "heat.temperature",
        "27 degrees Celsius are 300.15",
    ),
    (
        "a boiling point in degrees Celsius",
        "heated.toml",
        &[("boiling_point = 373.15", "boiling_point = 100")],
        "fluid.scalar[3].particles.evaporation.boiling_point",
        "100 degrees Celsius are 373.15",
    ),
    (
        "an inlet at rest",
        "bed.toml",
        &[("velocity = [0, 0, 1.0]", "velocity = [0, 0, 0]")],
        "fluid.boundary[0].velocity",
        "nothing comes in",
    ),
    (
        "an inlet along its face",
        "bed.toml",
        &[("velocity = [0, 0, 1.0]", "velocity = [1.0, 0, 0]")],
        "fluid.boundary[0].velocity",
        "take kind = \"wall\"",
    ),
    (
        "two cells for a bed",
        "bed.toml",
        &[("cells = [12, 4, 16]", "cells = [2, 1, 2]")],
        "fluid.cells",
        "no profile of the flow is resolved",
    ),
    (
        "particles lighter than the fluid",
        "bed.toml",
        &[("density = 1.2", "density = 3000"), ("viscosity = 1.8e-5", "viscosity = 1e-3")],
        "fluid.density",
        "they rise",
    ),
];
