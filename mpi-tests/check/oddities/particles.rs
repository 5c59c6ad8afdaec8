//! What has no effect or comes twice, ends that come at once or never, and room that there is not.

use super::Oddity;

pub(super) const ODDITIES: &[Oddity] = &[
    (
        "a material of nothing",
        "base.toml",
        &[(
            "[[material]]\nname = \"wall\"",
            "[[material]]\nname = \"steel\"\ndensity = 7800\n\n[[material]]\nname = \"wall\"",
        )],
        "material[1].name",
        "neither particles nor walls",
    ),
    (
        "a shape of nothing",
        "base.toml",
        &[(
            "[[insert]]",
            "[[shape]]\nname = \"cube\"\nkind = \"box\"\nedges = [4e-3, 4e-3, 4e-3]\n\n[[insert]]",
        )],
        "shape[1].name",
        "name it in insert.particles",
    ),
    (
        "heat capacities without temperatures",
        "base.toml",
        &[("density = 2500", "density = 2500\nheat_capacity = 840\nconductivity = 1")],
        "material[0].heat_capacity",
        "add [heat]",
    ),
    (
        "a conductivity without temperatures",
        "base.toml",
        &[("density = 2500", "density = 2500\nconductivity = 1")],
        "material[0].conductivity",
        "add [heat]",
    ),
    (
        "a rolling law without friction",
        "base.toml",
        &[(
            "\"glass\", \"glass\"]\nnormal_stiffness",
            "\"glass\", \"glass\"]\nrolling = { kind = \"constant\" }\nnormal_stiffness",
        )],
        "contact[0].rolling",
        "give rolling_friction",
    ),
    (
        "steps per contact beside a step",
        "base.toml",
        &[("dt = 4e-5", "dt = 4e-5\nsteps_per_contact = 100")],
        "time.steps_per_contact",
        "take dt = \"auto\"",
    ),
    (
        "faces counted from 1",
        "silo.toml",
        &[
            (
                "vertices = [[-0.018, -0.018, -0.001], [0.018",
                "vertices = [[0, 0, 0.05], [-0.018, -0.018, -0.001], [0.018",
            ),
            ("faces = [[0, 1, 2, 3]]", "faces = [[1, 2, 3, 4]]"),
        ],
        "wall[1].vertices",
        "count vertices from 0",
    ),
    (
        "a wall twice",
        "base.toml",
        &[(
            "[output]",
            "[[wall]]\nname = \"extra\"\nmaterial = \"wall\"\nkind = \"box\"\nlower = [0.005, 0.005, 0.005]\nupper = [0.075, 0.059, 0.059]\n\n[output]",
        )],
        "wall[1].name",
        "pushed back twice as hard",
    ),
    (
        "a gate gone before it moves",
        "silo.toml",
        &[("until = 0.1", "until = 0.05")],
        "wall[1].motion.start",
        "raise wall.until",
    ),
    (
        "a phase of a wall in degrees",
        "base.toml",
        &[(
            "kind = \"box\"\nlower = [0.005, 0.005, 0.005]\nupper = [0.075, 0.059, 0.059]",
            "kind = \"box\"\nlower = [0.005, 0.005, 0.005]\nupper = [0.075, 0.059, 0.059]\nmotion = { kind = \"oscillation\", amplitude = [0, 0, 1e-5], frequency = 10, phase = 90 }",
        )],
        "wall[0].motion.phase",
        "90 degrees are 1.5708",
    ),
    (
        "a phase of particles in degrees",
        "fixed_and_driven.toml",
        &[("phase = 0.5", "phase = 45")],
        "insert[2].motion.phase",
        "45 degrees are 0.7854",
    ),
    (
        "a time of no stop",
        "base.toml",
        &[("[output]", "[stop]\nafter = 0.01\n\n[output]")],
        "stop.after",
        "nothing ends it",
    ),
    (
        "a stop without a time series",
        "base.toml",
        &[
            ("[output]", "[stop]\nkinetic_energy_below = 1e-6\nafter = 0.01\n\n[output]"),
            ("series = 0.001", "series = 0"),
        ],
        "stop.kinetic_energy_below",
        "give output.series",
    ),
    (
        "a passage without a time series",
        "silo.toml",
        &[("[output]", "[stop]\nall_passed = \"opening\"\n\n[output]"), ("series = 0.004", "series = 0")],
        "stop.all_passed",
        "give output.series",
    ),
    (
        "a plane that counts upwards",
        "silo.toml",
        &[
            ("normal = [0, 0, -1]", "normal = [0, 0, 1]"),
            ("[output]", "[stop]\nall_passed = \"opening\"\n\n[output]"),
        ],
        "stop.all_passed",
        "turn flow_plane.normal",
    ),
    (
        "a plane above the particles",
        "silo.toml",
        &[
            ("point = [0, 0, 0]", "point = [0, 0, 0.125]"),
            ("[output]", "[stop]\nall_passed = \"opening\"\n\n[output]"),
        ],
        "stop.all_passed",
        "move flow_plane.point",
    ),
    (
        "an energy in mJ",
        "base.toml",
        &[("[output]", "[stop]\nkinetic_energy_below = 5\nafter = 0.01\n\n[output]")],
        "stop.kinetic_energy_below",
        "lower it",
    ),
    (
        "rows of each step",
        "base.toml",
        &[("series = 0.001", "series = 1e-6")],
        "output.series",
        "written at every step",
    ),
    (
        "snapshots finer than steps",
        "base.toml",
        &[("particles = 0.01", "particles = 1e-5")],
        "output.particles",
        "written at every step",
    ),
    (
        "more than the domain holds",
        "base.toml",
        &[(
            "\n\n[[wall]]",
            "\n\n[[insert]]\nname = \"more\"\nparticles = [{ shape = \"ball\", material = \"glass\" }]\ncount = 5000\nplace = { kind = \"window\", window = { kind = \"box\", lower = [0.02, 0.02, 0.053], upper = [0.06, 0.05, 0.054] }, retry = 1e-3 }\n\n[[wall]]",
        )],
        "insert[1].count",
        "no room for the last",
    ),
    (
        "a batch that its window does not hold",
        "base.toml",
        &[(
            "\n\n[[wall]]",
            "\n\n[[insert]]\nname = \"more\"\nparticles = [{ shape = \"ball\", material = \"glass\" }]\ncount = 60\nstart = 0.01\nplace = { kind = \"window\", window = { kind = \"box\", lower = [0.02, 0.02, 0.053], upper = [0.06, 0.05, 0.054] } }\n\n[[wall]]",
        )],
        "insert[1].count",
        "give place.retry",
    ),
    (
        "a spin in revolutions per minute",
        "base.toml",
        &[("count = 16", "count = 16\nangular_velocity = [0, 0, 30000]")],
        "insert[0].angular_velocity",
        "a revolution per minute is 0.1047",
    ),
    (
        "a skin in mm",
        "base.toml",
        &[("[output]", "[neighbours]\nskin = 1\n\n[output]")],
        "neighbours.skin",
        "a tenth of a diameter is usual",
    ),
    (
        "a plane that passes through the domain",
        "base.toml",
        &[
            ("end = 0.02", "end = 1"),
            (
                "[output]",
                "[[wall]]\nname = \"extra\"\nmaterial = \"wall\"\nkind = \"plane\"\npoint = [0, 0, 0.055]\nnormal = [0, 0, -1]\nmotion = { kind = \"translation\", velocity = [0, 0, -0.1] }\n\n[output]",
            ),
        ],
        "wall[1].motion.velocity",
        "end the motion before",
    ),
];
