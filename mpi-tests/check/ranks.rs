//! `check` by several ranks, each of which holds its share of the particles.

use super::check;
use crate::common::{case, folder, replaced, run};
use std::fs;

/// What `check` says of a case, by one process and by so many ranks, for a job of two.
fn alone_and_by(ranks: usize, name: &str, text: &str, files: &[(&str, String)]) -> [String; 2] {
    let home = folder(&format!("check_by_{name}"));
    for (file, text) in files {
        fs::write(home.join(file), text).unwrap();
    }
    let alone = check(&home, text, &["--ranks", "2"]).text();
    [alone, run(ranks, &home, &["check", "case.toml", "--ranks", "2"]).text()]
}

#[test]
fn any_number_of_ranks_say_the_same() {
    // The resolved bodies leave room for two subdomains.
    let cases = ["drum", "gravel", "sheared", "rain", "bonded", "packed", "walls_of_fluid", "catalyst"];
    let by_three = cases.iter().map(|name| (name, 3));
    for (name, ranks) in cases.iter().chain(&["resolved_heat"]).map(|name| (name, 2)).chain(by_three) {
        let file = (*name == "bonded").then(|| ("clamps.csv", case("clamps.csv")));
        let [alone, by_all] = alone_and_by(ranks, name, &case(&format!("{name}.toml")), file.as_slice());
        assert!(alone.contains("decomposition"), "{name}: {alone}");
        assert_eq!(alone, by_all, "{name} on {ranks} ranks");
    }
}

#[test]
fn rows_of_a_file_are_shared_out_and_their_faults_told_once() {
    let rows = |radius: &dyn Fn(u32) -> f64| {
        let row = |k: u32| {
            let at = |k: u32| 0.009 * f64::from(k) + 0.01;
            format!("{},{},{},{}\n", at(k % 5), at(k / 5 % 5), at(k / 25), radius(k))
        };
        format!("x,y,z,radius\n{}", (0..125).map(row).collect::<String>())
    };
    let text = case("base.toml");
    let lattice = text.lines().find(|line| line.starts_with("place")).unwrap();
    let text = replaced(&text, lattice, "place = { kind = \"file\", path = \"balls.csv\" }");
    let text = replaced(&replaced(&text, "count = 16\n", ""), "dt = 4e-5", "dt = 2e-6");
    let mixed = rows(&|k| 0.001 + 1e-5 * f64::from(k));
    let [alone, by_all] = alone_and_by(3, "rows", &text, &[("balls.csv", mixed)]);
    assert!(alone.contains("particles      125"), "{alone}");
    assert_eq!(alone, by_all);
    // The last ones are so large that they overlap.
    let overlapping = rows(&|k| if k < 120 { 0.001 } else { 0.0056 });
    let [alone, by_all] = alone_and_by(3, "overlapping_rows", &text, &[("balls.csv", overlapping)]);
    for said in [alone, by_all] {
        assert_eq!(said.matches("error:").count(), 1, "{said}");
        assert!(said.contains("starts") && said.contains("inside particle"), "{said}");
    }
}
