//! Analyses a stored run through the library: `mixing RESULTS`, the mixing index of Lacey over time.

use grains_analysis::{Analysis, Common, Times, analyse, mixing, region};
use grains_simulation::{ErrorKind, Job, RunError, abort, start};

fn run(job: &Job, results: &str) -> Result<(), RunError> {
    let common = Common { run: results.into(), time: Times::All, output: None, case: None };
    let region = region::RegionOptions::default();
    let options = mixing::Options { common, region, by: None, diameter: None, cell: None, min: 5 };
    let findings = analyse(&Analysis::Mixing(options), "mixing 1.0", job)?;
    findings.lines.iter().for_each(|line| println!("{line}"));
    println!("{} in {}", findings.files.join(", "), findings.folder.display());
    Ok(())
}

fn main() {
    let results = std::env::args().nth(1).expect("usage: mixing RESULTS");
    let job = start().unwrap_or_else(|error| panic!("{error}"));
    if let Err(error) = run(&job, &results) {
        eprintln!("{error}");
        abort(if error.kind == ErrorKind::Case { 2 } else { 1 });
    }
}
