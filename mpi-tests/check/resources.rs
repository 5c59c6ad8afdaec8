//! Time, memory and disk that `check` foretells.

use super::check;
use crate::common::{folder, replaced, run};
use std::fs;
use std::path::Path;

/// A bed of 64,000 beads or, with `edits`, something else.
fn bed(edits: &[(&str, &str)]) -> String {
    let text = "[domain]
lower = [0, 0, 0]
upper = [0.084, 0.084, 0.1]
periodic = [true, true, false]

[time]
end = 1e-3
dt = 1e-4
accept_coarse_dt = true

[[material]]
name = \"glass\"
density = 2500

[[contact]]
between = [\"glass\", \"glass\"]
normal_stiffness = 1000
restitution = 0.9
friction = 0.1

[[shape]]
name = \"bead\"
kind = \"sphere\"
radius = 1e-3

[[insert]]
name = \"beads\"
particles = [{ shape = \"bead\", material = \"glass\" }]
count = 64000
orientation = \"aligned\"
place = { kind = \"lattice\", lower = [0, 0, 0], upper = [0.084, 0.084, 0.09], spacing = 0.00205 }

[[wall]]
name = \"floor\"
material = \"glass\"
kind = \"plane\"
point = [0, 0, 0]
normal = [0, 0, 1]

[output]
directory = \"results\"
particles = 5e-4
series = 1e-4
checkpoint = 5e-4
";
    edits.iter().fold(text.to_string(), |text, (old, new)| replaced(&text, old, new))
}

const LATTICE: &str =
    "{ kind = \"lattice\", lower = [0, 0, 0], upper = [0.084, 0.084, 0.09], spacing = 0.00205 }";

/// The number before a unit in the line of a text that begins with `start`.
fn number(text: &str, start: &str, unit: &str) -> f64 {
    let line = text.lines().find(|line| line.starts_with(start));
    let line = line.unwrap_or_else(|| panic!("no line `{start}`: {text}"));
    let before = line.split(unit).next().unwrap().trim_end();
    before.rsplit(' ').next().unwrap().parse().unwrap_or_else(|e| panic!("{line}: {e}"))
}

fn bytes_below(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    entries
        .map(|e| if e.path().is_dir() { bytes_below(&e.path()) } else { e.metadata().unwrap().len() })
        .sum()
}

/// Memory within a factor of 1.5, disk within 1.4, steps exactly.
#[test]
fn a_run_takes_what_check_says() {
    let air = "[fluid]\ndensity = 1.2\nviscosity = 1.8e-5\ncells = [40, 40, 48]\n";
    let (coupled, means) = (
        format!("{air}coupling = {{ drag = \"beetstra\" }}\n\n[output]"),
        format!("{air}output = {{ mean_from = 0 }}\n\n[output]"),
    );
    let resolved = format!(
        "{}resolved = {{ motion = \"fixed\" }}\n\n[output]",
        air.replace("[40, 40, 48]", "[84, 84, 100]")
    );
    let cube = ("kind = \"sphere\"\nradius = 1e-3", "kind = \"box\"\nedges = [2.04e-3, 2.04e-3, 2.04e-3]");
    let few = ("count = 64000", "count = 3000");
    let surfaces = ("series = 1e-4", "series = 1e-4\nsurfaces = 5e-4");
    let small = ("[output]", "[output]\nprecision = \"f32\"");
    let cases: [(&str, usize, String); 8] = [
        ("beads", 1, bed(&[])),
        ("beads on two ranks", 2, bed(&[])),
        (
            "touching cubes",
            1,
            bed(&[
                cube,
                ("count = 64000\n", ""),
                (LATTICE, "{ kind = \"file\", path = \"../cubes.csv\" }"),
                ("end = 1e-3\ndt = 1e-4", "end = 5e-5\ndt = 5e-6"),
                ("series = 1e-4", "series = 5e-6"),
                ("particles = 5e-4", "particles = 2.5e-5"),
                ("checkpoint = 5e-4", "checkpoint = 2.5e-5"),
            ]),
        ),
        ("surfaces of beads", 1, bed(&[few, surfaces])),
        ("surfaces of cubes in 32 bits", 2, bed(&[cube, few, surfaces, small])),
        ("beads in air", 1, bed(&[("[output]", &coupled)])),
        (
            "means of air",
            1,
            bed(&[
                few,
                ("[output]", &means.replace("output = ", "coupling = { drag = \"beetstra\" }\noutput = ")),
            ]),
        ),
        (
            "air around fixed beads",
            1,
            bed(&[
                ("count = 64000", "count = 300"),
                ("radius = 1e-3", "radius = 4e-3"),
                ("spacing = 0.00205", "spacing = 0.0082"),
                ("[output]", &resolved),
            ]),
        ),
    ];
    let home = folder("check_cost");
    let mut rows = String::from("x,y,z\n");
    for k in 0..20_000 {
        let [x, y, z] = [k % 40, k / 40 % 40, k / 1600].map(|n| 1.1e-3 + 2.0395e-3 * f64::from(n));
        rows += &format!("{x},{y},{z}\n");
    }
    fs::write(home.join("cubes.csv"), rows).unwrap();
    let mut wrong = Vec::new();
    println!("| case | memory of the run over that of check | disk | steps |\n|---|---|---|---|");
    for (name, ranks, text) in cases {
        let home = home.join(name.replace(' ', "_"));
        fs::create_dir(&home).unwrap();
        let said = check(&home, &text, &["--ranks", &ranks.to_string()]).succeeded().stdout;
        let ran = run(ranks, &home, &["case.toml"]).succeeded().stdout;
        let memory = number(&ran, "memory:", "MB") / number(&said, "memory  ", "MB");
        let disk = bytes_below(&home.join("results")) as f64 / 1e6 / number(&said, "disk", "MB");
        let last = ran.lines().rfind(|line| line.starts_with("step ")).unwrap();
        let steps =
            last.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() / number(&said, "steps", "to t");
        println!("| {name} | {memory:.2} | {disk:.2} | {steps} |");
        let is_near = |ratio: f64, factor: f64| (1.0 / factor..=factor).contains(&ratio);
        if !is_near(memory, 1.5) || !is_near(disk, 1.4) || !is_near(steps, 1.000_001) {
            wrong.push(name);
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}
