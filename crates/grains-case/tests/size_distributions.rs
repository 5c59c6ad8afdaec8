//! Size distributions in the case file: what is read, and what is refused.

use std::path::Path;

use grains_case::{Case, SizeDistribution};

/// Case text with pebbles of 4 mm and chips of other shape; one of them with sizes as given.
fn text(shape: &str, sizes: &str) -> String {
    let good = std::fs::read_to_string(folder().join("gravel.toml")).expect("text");
    let begin = good.find("particles = [").expect("mixture");
    let end = good.find("count = 100").expect("count");
    let particles = format!("particles = [{{ shape = \"{shape}\", material = \"stone\", {sizes} }}]\n");
    format!("{}{particles}{}", &good[..begin], &good[end..])
}

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/good")
}

fn read(shape: &str, sizes: &str) -> Result<Case, String> {
    Case::parse(&text(shape, sizes), "gravel.toml", &folder()).map_err(|errors| errors.to_string())
}

fn scale(case: &Case) -> &SizeDistribution {
    &case.inserts[0].particles[0].scale
}

#[test]
fn a_file_and_rows_in_the_case_are_the_same_curve() {
    let rows = "[[2e-3, 0], [2.8e-3, 0.12], [4e-3, 0.55], [5.6e-3, 0.55], [8e-3, 1]]";
    let [of_file, of_rows] =
        ["path = \"../data/sieve.csv\"".into(), format!("passing = {rows}")].map(|curve: String| {
            read("pebble", &format!("diameter = {{ kind = \"sieve\", by = \"mass\", {curve} }}"))
                .expect("right")
        });
    assert_eq!(scale(&of_file), scale(&of_rows));
    assert_eq!([scale(&of_file).smallest(), scale(&of_file).largest()], [0.5, 2.0]);
}

/// Factors are diameters over that of the shape, whatever this is.
#[test]
fn diameters_and_factors_are_the_same_sizes() {
    for (diameter, factor) in [
        ("kind = \"uniform\", min = 2e-3, max = 8e-3", "kind = \"uniform\", min = 0.5, max = 2"),
        (
            "kind = \"normal\", mean = 4e-3, deviation = 1e-3, min = 2e-3, max = 8e-3",
            "kind = \"normal\", mean = 1, deviation = 0.25, min = 0.5, max = 2",
        ),
        (
            "kind = \"log_normal\", by = \"mass\", median = 4e-3, geometric_deviation = 1.5, min = 2e-3, max = 8e-3",
            "kind = \"log_normal\", by = \"mass\", median = 1, geometric_deviation = 1.5, min = 0.5, max = 2",
        ),
        (
            "kind = \"weibull\", by = \"mass\", characteristic = 4e-3, exponent = 3, min = 2e-3, max = 8e-3",
            "kind = \"weibull\", by = \"mass\", characteristic = 1, exponent = 3, min = 0.5, max = 2",
        ),
        (
            "kind = \"sieve\", by = \"mass\", passing = [[2e-3, 0], [8e-3, 1]], max = 4e-3",
            "kind = \"sieve\", by = \"mass\", passing = [[0.5, 0], [2, 1]], max = 1",
        ),
        (
            "kind = \"table\", values = [2e-3, 4e-3], shares = [1, 2]",
            "kind = \"table\", values = [0.5, 1], shares = [1, 2]",
        ),
    ] {
        let of_diameter = read("pebble", &format!("diameter = {{ {diameter} }}")).expect("right");
        let of_factor = read("pebble", &format!("scale = {{ {factor} }}")).expect("right");
        assert_eq!(scale(&of_diameter), scale(&of_factor));
        assert!(of_diameter.warnings.is_empty(), "{:?}", of_diameter.warnings);
    }
}

/// A mistake: the distribution, the key named, and words of the message.
const MISTAKES: [(&str, &str, &str); 24] = [
    ("kind = \"uniform\", min = 2, max = 1", "max = 1", "must not be below min = 2"),
    (
        "kind = \"normal\", mean = 1, deviation = 0.1, min = 2, max = 0.5",
        "max = 0.5",
        "must be above min = 2",
    ),
    ("kind = \"normal\", mean = 3, deviation = 5, min = 0.5, max = 2", "mean = 3", "outside the cut-offs"),
    ("kind = \"normal\", mean = 1, deviation = 0.1, max = 2", "min", "missing key"),
    (
        "kind = \"log_normal\", by = \"mass\", median = 0.1, geometric_deviation = 1.5, min = 0.5, max = 2",
        "median = 0.1",
        "move these to either side",
    ),
    (
        "kind = \"log_normal\", by = \"mass\", median = 1, geometric_deviation = 1, min = 0.5, max = 2",
        "geometric_deviation = 1",
        "must be above 1",
    ),
    (
        "kind = \"log_normal\", by = \"mass\", median = 1, geometric_deviation = 1.5, min = 0.5",
        "max",
        "missing key",
    ),
    ("kind = \"log_normal\", median = 1, geometric_deviation = 1.5, min = 0.5, max = 2", "by", "missing key"),
    (
        "kind = \"weibull\", by = \"mass\", characteristic = 1, exponent = 0, min = 0.5, max = 2",
        "exponent = 0",
        "must be above 0",
    ),
    (
        "kind = \"weibull\", by = \"mass\", characteristic = 1, exponent = -3, min = 0.5, max = 2",
        "exponent = -3",
        "must be above 0",
    ),
    (
        "kind = \"weibull\", by = \"mass\", characteristic = 4, exponent = 3, min = 0.5, max = 2",
        "characteristic = 4",
        "outside the cut-offs",
    ),
    (
        "kind = \"weibull\", by = \"volume\", characteristic = 1, exponent = 3, min = 0.5, max = 2",
        "by = \"volume\"",
        "`number`, `mass`",
    ),
    ("kind = \"sieve\", by = \"mass\"", "passing", "missing key"),
    ("kind = \"sieve\", by = \"mass\", passing = [[1, 0], [0.5, 1]]", "passing", "0.5 comes after 1"),
    (
        "kind = \"sieve\", by = \"mass\", passing = [[0.5, 0], [1, 0.7], [2, 0.3], [3, 1]]",
        "passing",
        "not those left on the sieve",
    ),
    (
        "kind = \"sieve\", by = \"mass\", passing = [[0.5, 0], [1, 50], [2, 100]]",
        "passing",
        "divide per cent by 100",
    ),
    (
        "kind = \"sieve\", by = \"mass\", passing = [[0.5, 0], [1, 0.7]]",
        "passing",
        "add the size that all pass",
    ),
    ("kind = \"sieve\", by = \"mass\", passing = [[0.5, 0.2], [1, 1]]", "passing", "add the smallest size"),
    ("kind = \"sieve\", by = \"mass\", passing = [[0, 0], [1, 1]]", "passing", "sizes are above 0"),
    ("kind = \"sieve\", by = \"mass\", passing = [[0.5, 0], [1, 1]], min = 2", "min = 2", "leaves nothing"),
    (
        "kind = \"sieve\", by = \"mass\", passing = [[0.5, 0], [1, 1]], min = 0.9, max = 0.8",
        "max = 0.8",
        "above min = 0.9",
    ),
    ("kind = \"sieve\", by = \"mass\", path = \"../data/siev.csv\"", "path", "did you mean `sieve.csv`"),
    ("kind = \"sieve\", by = \"mass\", path = \"../data/beads.csv\"", "path", "unknown column"),
    ("kind = \"uniform\", by = \"mass\", min = 1e-7, max = 1", "scale", "leave out the smallest"),
];

#[test]
fn every_mistake_is_one_error_that_names_key_value_and_remedy() {
    for (sizes, key, words) in MISTAKES {
        let error = read("chip", &format!("scale = {{ {sizes} }}")).expect_err(sizes);
        println!("{error}");
        let key =
            if key == "scale" { "particles[0].scale".into() } else { format!("particles[0].scale.{key}") };
        assert!(error.contains(&format!("insert[0].{key}")) && error.contains(words), "{sizes}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[test]
fn diameters_are_of_spheres_and_exclude_factors() {
    let uniform = "{ kind = \"uniform\", min = 2e-3, max = 4e-3 }";
    let of_chip = read("chip", &format!("diameter = {uniform}")).expect_err("chip");
    assert!(
        of_chip.contains("diameter") && of_chip.contains("only spheres have a diameter; give scale"),
        "{of_chip}"
    );
    let both = read("pebble", &format!("scale = {uniform}, diameter = {uniform}")).expect_err("both");
    assert!(both.contains("excludes scale"), "{both}");
    let millimetres = read("pebble", "diameter = { kind = \"uniform\", min = 2, max = 4 }").expect_err("mm");
    assert!(
        millimetres.contains("insert[0].particles[0]") && millimetres.contains("4 mm is 0.004 m"),
        "{millimetres}"
    );
    let dust = read("pebble", "diameter = { kind = \"uniform\", min = 1e-9, max = 4e-9 }").expect("allowed");
    assert!(dust.warnings.iter().any(|w| w.to_string().contains("check its unit")), "{:?}", dust.warnings);
}
