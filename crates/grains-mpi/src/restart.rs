//! The state of a run as the arrays of a checkpoint, and back.

use crate::error::RunError;
use crate::fluid::FluidPhase;
use crate::population::Population;
use grains_case::Case;
use grains_comm::MpiTransport;
use grains_dem::{CARGO_LENGTH, Cargo, Dem, ParticleRecord};
use grains_domain::Transport;
use grains_geometry::Vec3;
use grains_output::{Array, CheckpointFile, Metadata, Values, latest_valid};
use std::collections::BTreeMap;
use std::path::Path;

/// Arrays and texts of a checkpoint.
pub type State = (Vec<Array>, Metadata);

/// The state of this rank; what contacts remember is that before those of the present step are evaluated.
pub fn state(dem: &mut Dem, population: &Population, transport: &MpiTransport) -> State {
    let crossings = dem.crossings(transport);
    let (lengths, memory) = dem.packed_memory();
    let mut records = Vec::new();
    for i in 0..dem.particles.owned {
        let mut record = dem.particles.record(i);
        record.body.position = Vec3::from(dem.setup.global.wrap(record.body.position.into()));
        record.write(&mut records);
    }
    let array = |name, width, values| Array { name, unit: "SI", width, values };
    let mut arrays = vec![
        array("particle", ParticleRecord::LENGTH, Values::Real(records)),
        array("memory_length", 1, Values::Integer(lengths.iter().map(|&l| i64::from(l)).collect())),
        array("memory", 1, Values::Real(memory)),
    ];
    if dem.particles.is_carrying() {
        arrays.push(array("cargo", CARGO_LENGTH, Values::Real(dem.particles.cargo.concat())));
    }
    let mut ledger = [dem.ledger.inserted, dem.ledger.left, dem.report.cores_met];
    transport.sum_counts(&mut ledger);
    let list = |values: &[i64]| values.iter().map(i64::to_string).collect::<Vec<_>>().join(" ");
    let passed: Vec<String> =
        crossings.iter().map(|(count, mass)| format!("{count} {:x}", mass.to_bits())).collect();
    let texts = vec![
        ("step".into(), dem.step.to_string()),
        ("time".into(), format!("{:?}", dem.time())),
        ("dt".into(), format!("{:x}", dem.setup.rates.dt.to_bits())),
        ("ledger".into(), list(&ledger.map(|n| n as i64))),
        ("inserted".into(), list(&population.done())),
        ("crossings".into(), passed.join(" ")),
        (
            "particle_columns".into(),
            "id; shape; material; sides; position*3 (m); velocity*3 (m/s); angular_velocity*3 (rad/s); half_velocity*3 (m/s); half_spin*3 (rad/s of a sphere, else kg m2/s); quaternion_wxyz*4; radius (m); mass (kg)".into(),
        ),
    ];
    (arrays, texts)
}

/// Takes the state of a checkpoint (`latest`: the newest valid one of the output directory).
///
/// # Errors
/// No valid checkpoint, or one of another case.
pub fn restore(
    case: &Case,
    transport: &MpiTransport,
    checkpoint: &Path,
    (dem, fluid): (&mut Dem, &mut Option<FluidPhase>),
    population: &mut Population,
) -> Result<(), RunError> {
    let communicator = transport.communicator();
    let file = if checkpoint == Path::new("latest") {
        let (file, refused) = latest_valid(&case.output.directory, communicator)?;
        if transport.rank() == 0 {
            refused.iter().for_each(|e| eprintln!("warning: {e}"));
        }
        file
    } else {
        CheckpointFile::read(checkpoint, communicator)?
    };
    if transport.rank() == 0 {
        say!("continuing from {}", file.path.display());
    }
    let numbers = |name: &str| -> Vec<i64> {
        file.text(name).unwrap_or("").split_whitespace().filter_map(|n| n.parse().ok()).collect()
    };
    same_case(case, dem, &file)?;
    dem.resume_at(numbers("step").first().map_or(0, |&s| s as u64));
    population.restore(&numbers("inserted"));
    for row in owned_rows(&file, dem, transport)? {
        dem.restore(&row.record, &row.memory);
        if let (Some(cargo), Some(place)) = (row.cargo, dem.particles.cargo.last_mut()) {
            *place = cargo;
        }
    }
    dem.announce_insertion();
    if let Some(fluid) = fluid {
        fluid.restore(&file, dem, transport)?;
    }
    if transport.rank() == 0 {
        let ledger = numbers("ledger");
        (dem.ledger.inserted, dem.ledger.left) = (ledger[0] as u64, ledger[1] as u64);
        dem.report.cores_met = ledger.get(2).map_or(0, |&count| count as u64);
        let words: Vec<&str> = file.text("crossings").unwrap_or("").split_whitespace().collect();
        let counts: Vec<(i64, f64)> = words
            .chunks_exact(2)
            .map(|w| (w[0].parse().unwrap_or(0), f64::from_bits(u64::from_str_radix(w[1], 16).unwrap_or(0))))
            .collect();
        dem.restore_crossings(&counts);
    }
    Ok(())
}

/// Refuses a checkpoint of a case that differs in more than its duration, output and limits.
fn same_case(case: &Case, dem: &Dem, file: &CheckpointFile) -> Result<(), RunError> {
    let text = file.text("case").unwrap_or("");
    let refuse = |why: &str| {
        RunError::case(format!(
            "{} belongs to another case ({why}): only time.end, stop, output, limits, neighbours, domain.ranks, domain.balance, domain.exchange and of the fluid its output, pressure solver and longest step may change at a restart",
            file.path.display()
        ))
    };
    let mut old = Case::parse(text, "checkpoint", Path::new("")).map_err(|e| refuse(&e.to_string()))?;
    old.name.clone_from(&case.name);
    old.time.end = case.time.end;
    old.stop.clone_from(&case.stop);
    old.output.clone_from(&case.output);
    old.limits.clone_from(&case.limits);
    old.neighbours.clone_from(&case.neighbours);
    old.domain.ranks = case.domain.ranks;
    old.domain.balance = case.domain.balance;
    old.domain.exchange = case.domain.exchange;
    if let (Some(old), Some(new)) = (&mut old.fluid, &case.fluid) {
        old.output.clone_from(&new.output);
        old.pressure.clone_from(&new.pressure);
        // A hundredth of the run unless given, so that it changes with time.end.
        old.longest_step = new.longest_step;
    }
    let what = [
        ("domain", old.domain == case.domain),
        ("time", old.time == case.time),
        ("material", old.materials == case.materials),
        ("collisions", old.collisions == case.collisions),
        ("contact", old.contacts == case.contacts),
        ("shape", old.shapes == case.shapes),
        ("insert", old.inserts == case.inserts),
        ("wall", old.walls == case.walls),
        ("flow_plane", old.flow_planes == case.flow_planes),
        ("fluid", old.fluid == case.fluid),
        ("gravity or seed", (old.gravity, old.seed) == (case.gravity, case.seed)),
    ];
    if let Some((section, _)) = what.iter().find(|(_, same)| !same) {
        return Err(refuse(&format!("[{section}] differs")));
    }
    let dt = file.text("dt").and_then(|t| u64::from_str_radix(t, 16).ok()).map(f64::from_bits);
    if dt != Some(dem.setup.rates.dt) {
        return Err(refuse("the time step differs"));
    }
    Ok(())
}

/// A particle of a checkpoint.
struct Row {
    record: ParticleRecord,
    /// What a coupling lets it carry.
    cargo: Option<Cargo>,
    /// What its contacts remember.
    memory: Vec<f64>,
}

/// The particles this rank owns.
fn owned_rows(file: &CheckpointFile, dem: &Dem, transport: &MpiTransport) -> Result<Vec<Row>, RunError> {
    let records = file.real("particle")?;
    let lengths = file.integer("memory_length")?;
    let remembered = lengths.iter().sum::<i64>() as usize;
    let memory = file.next_rows("memory", remembered, transport.communicator())?;
    // Rows of the same particles lie on the same ranks in all arrays.
    let is_coupled = dem.particles.is_carrying();
    let cargo = if is_coupled { file.real("cargo")? } else { &[] };
    let width = if is_coupled { CARGO_LENGTH } else { 0 };
    let mut sent: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    let mut rest = &memory[..];
    for (k, (row, &length)) in records.chunks_exact(ParticleRecord::LENGTH).zip(lengths).enumerate() {
        let (own, after) = rest.split_at(length as usize);
        rest = after;
        let record = ParticleRecord::read(row);
        let owner = dem.decomposition.owner(record.body.position.into());
        let message = sent.entry(owner).or_default();
        message.push(length as f64);
        message.extend_from_slice(row);
        message.extend_from_slice(&cargo[k * width..(k + 1) * width]);
        message.extend_from_slice(own);
    }
    let mut rows = Vec::new();
    for (_, message) in transport.exchange_sparse(sent.into_iter().collect()) {
        let mut rest = &message[..];
        while let Some((&length, after)) = rest.split_first() {
            let (row, after) = after.split_at(ParticleRecord::LENGTH);
            let (cargo, after) = after.split_at(width);
            let (memory, after) = after.split_at(length as usize);
            rows.push(Row {
                record: ParticleRecord::read(row),
                cargo: cargo.try_into().ok(),
                memory: memory.to_vec(),
            });
            rest = after;
        }
    }
    Ok(rows)
}
