//! Tables of particles in other units, falls and weights, funnels that nothing passes, and ends of what does not move.

use super::Oddity;

/// Tables of particles, by their names.
pub(super) const TABLES: &[(&str, &str)] = &[
    ("fast.csv", "x,y,z,vx,vy,vz\n0.03,0.03,0.03,0,0,0\n0.05,0.03,0.03,0,0,-300\n"),
    ("spin.csv", "x,y,z,wx,wy,wz\n0.03,0.03,0.03,0,0,30000\n"),
    ("degrees.csv", "x,y,z,qw,qx,qy,qz\n0.03,0.03,0.03,1,0,0,0\n0.05,0.03,0.03,90,0,0,1\n"),
    ("euler.csv", "x,y,z,qw,qx,qy,qz\n0.03,0.03,0.03,0,45,30,0\n"),
    ("empty.csv", "x,y,z,radius\n"),
    ("warm.csv", "x,y,z,temperature\n0.03,0.03,0.03,350\n"),
];

const LATTICE: &str =
    "{ kind = \"lattice\", lower = [0.02, 0.01, 0.02], upper = [0.07, 0.055, 0.05], spacing = 0.011 }";

const COUNTED: &str = "count = 16\nplace = { kind = \"lattice\", lower = [0.02, 0.01, 0.02], upper = [0.07, 0.055, 0.05], spacing = 0.011 }";

const FILE: &str = "insert[0].place.path";

const FUNNEL: &str = "[[wall]]\nname = \"funnel\"\nmaterial = \"wall\"\nkind = \"revolution\"\norigin = [0.04, 0.03, 0.008]\naxis = [0, 0, 1]\nprofile = [[0, 0.003], [0.008, 0.02]]\n\n[output]";

pub(super) const ODDITIES: &[Oddity] = &[
    (
        "velocities of a table in mm/s",
        "base.toml",
        &[(COUNTED, "place = { kind = \"file\", path = \"fast.csv\" }")],
        FILE,
        "line 3 moves at 300.0 m/s",
    ),
    (
        "velocities of a table in mm/s, and fine steps",
        "base.toml",
        &[(COUNTED, "place = { kind = \"file\", path = \"fast.csv\" }"), ("dt = 4e-5", "dt = 1e-6")],
        FILE,
        "times the speed of a fall",
    ),
    (
        "angular velocities of a table in revolutions per minute",
        "base.toml",
        &[(COUNTED, "place = { kind = \"file\", path = \"spin.csv\" }")],
        FILE,
        "a revolution per minute is 0.1047",
    ),
    (
        "degrees for a quaternion",
        "base.toml",
        &[(COUNTED, "place = { kind = \"file\", path = \"degrees.csv\" }")],
        FILE,
        "line 3 has a component of 90",
    ),
    (
        "Euler angles for a quaternion",
        "base.toml",
        &[(COUNTED, "place = { kind = \"file\", path = \"euler.csv\" }")],
        FILE,
        "90 degrees about z are 0.7071, 0, 0, 0.7071",
    ),
    (
        "a table without rows",
        "base.toml",
        &[(COUNTED, "place = { kind = \"file\", path = \"empty.csv\" }")],
        FILE,
        "only a header",
    ),
    (
        "temperatures of a table without heat",
        "base.toml",
        &[(COUNTED, "place = { kind = \"file\", path = \"warm.csv\" }")],
        FILE,
        "add [heat]",
    ),
    (
        "an impact speed below that of the fall",
        "base.toml",
        &[("dt = 4e-5", "dt = 4e-5\nimpact_speed = 0.01")],
        "time.impact_speed",
        "fall 0.020 m to the end of the domain",
    ),
    (
        "a bed too heavy for its contacts",
        "base.toml",
        &[
            ("upper = [0.08, 0.06, 0.06]", "upper = [0.08, 0.06, 0.3]"),
            ("upper = [0.075, 0.059, 0.059]", "upper = [0.075, 0.059, 0.299]"),
            ("count = 16", "count = 560"),
            (
                LATTICE,
                "{ kind = \"lattice\", lower = [0.006, 0.006, 0.02], upper = [0.074, 0.058, 0.29], spacing = 0.011 }",
            ),
            (
                "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
                "\"glass\", \"glass\"]\nnormal_stiffness = 100",
            ),
        ],
        "contact[0].normal_stiffness",
        "raise the stiffness by",
    ),
    (
        "a funnel narrower than a particle",
        "base.toml",
        &[("[output]", FUNNEL)],
        "wall[1].kind",
        "nothing passes",
    ),
    (
        "a rest of particles that are fixed",
        "base.toml",
        &[
            ("count = 16", "count = 16\nmotion = \"fixed\""),
            ("[output]", "[stop]\nkinetic_energy_below = 1e-9\nafter = 0.01\n\n[output]"),
        ],
        "stop.kinetic_energy_below",
        "no particle moves by the forces on it",
    ),
    (
        "a passage of particles that are fixed",
        "base.toml",
        &[
            ("count = 16", "count = 16\nmotion = \"fixed\""),
            (
                "[output]",
                "[[flow_plane]]\nname = \"low\"\npoint = [0, 0, 0.01]\nnormal = [0, 0, -1]\n\n[stop]\nall_passed = \"low\"\n\n[output]",
            ),
        ],
        "stop.all_passed",
        "none is to pass",
    ),
    (
        "an inlet in mm/s",
        "bed.toml",
        &[("velocity = [0, 0, 1.0]", "velocity = [0, 0, 120]"), ("dt = 1e-5", "dt = 1e-6")],
        "fluid.boundary[0].velocity",
        "1 mm/s is 1e-3",
    ),
    (
        "a mass flow in g/s",
        "bed.toml",
        &[
            ("kind = \"inlet\"\nvelocity = [0, 0, 1.0]", "kind = \"flow_inlet\"\nmass_flow = 0.05"),
            ("dt = 1e-5", "dt = 1e-6"),
        ],
        "fluid.boundary[0].mass_flow",
        "1 g/s is 1e-3",
    ),
];
