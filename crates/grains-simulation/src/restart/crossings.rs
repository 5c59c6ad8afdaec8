//! What crossed the flow planes, in a checkpoint.

use grains_comm::MpiTransport;
use grains_dem::{Crossings, Dem};
use grains_output::{CheckpointFile, Metadata};

/// Net number and mass (kg, its bits) through each plane.
const COUNTS: &str = "crossings";
/// The same masses in quanta, and the quantum (kg, its bits): sums of them are exact.
const QUANTA: &str = "crossings_in_quanta";

/// The texts of a checkpoint; collective.
pub fn texts(dem: &mut Dem, transport: &MpiTransport) -> Metadata {
    let (crossings, quantum) = (dem.crossings(transport), dem.mass_quantum());
    let each =
        |words: &dyn Fn(&Crossings) -> String| crossings.iter().map(words).collect::<Vec<_>>().join(" ");
    vec![
        (COUNTS.into(), each(&|c| format!("{} {:x}", c.count, c.mass(quantum).to_bits()))),
        (QUANTA.into(), each(&|c| format!("{} {:x}", c.quanta, quantum.to_bits()))),
    ]
}

/// What a checkpoint holds of each plane it had, for a run that counts masses in this quantum (kg).
pub fn read(file: &CheckpointFile, quantum: f64) -> Vec<Crossings> {
    let real = |bits: &str| f64::from_bits(u64::from_str_radix(bits, 16).unwrap_or(0));
    let words = |name: &str| file.text(name).unwrap_or("").split_whitespace().collect::<Vec<_>>();
    let (counts, exact) = (words(COUNTS), words(QUANTA));
    let of_plane = |(k, of_plane): (usize, &[&str])| {
        let (count, mass) = (of_plane[0].parse().unwrap_or(0), real(of_plane[1]));
        let of_same_quantum = exact.chunks_exact(2).nth(k).filter(|words| real(words[1]) == quantum);
        let quanta = of_same_quantum.and_then(|words| words[0].parse::<i128>().ok());
        let exact = quanta.filter(|quanta| Crossings { count, quanta: *quanta }.mass(quantum) == mass);
        Crossings { count, quanta: exact.unwrap_or((mass / quantum) as i128) }
    };
    counts.chunks_exact(2).enumerate().map(of_plane).collect()
}
