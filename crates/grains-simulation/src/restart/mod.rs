//! The state of a run as the arrays of a checkpoint, and back.

mod check;
mod crossings;
mod exact;
mod remarks;
mod rows;
mod values;

pub use exact::{exact_sums, exact_words};
pub use remarks::suspects;

use crate::changes::{self, Change};
use crate::error::{RunError, agreed};
use crate::fluid::FluidPhase;
use crate::heat;
use crate::insertion::Insertions;
use crate::liquid;
use crate::numbering::Numbering;
use crate::species;
use crate::wear;
use check::check_state;
use grains_case::Case;
use grains_comm::MpiTransport;
use grains_dem::{
    BondLedger, CARGO_LENGTH, Crossings, Dem, FlowPlane, Origin, ParticleRecord, StressSums, Travel,
    WallPlace, half_step_back, other_half_step, renumber_walls, without_bridges,
};
use grains_domain::Transport;
use grains_geometry::Vec3;
use grains_output::{Array, CheckpointFile, FileError, Metadata, Values, agree, from_rank, latest_valid};
use grains_resolved::FlowLink;
use rows::owned_rows;
use std::ops::Range;
use std::path::Path;
use toml::Table;
use values::check_values;

/// Texts of a checkpoint: its input files, the walls' places, and what restarts have changed.
pub const INPUTS: &str = "inputs";
/// Text of files: SHA-256 of the case with its input files.
pub const IDENTITY: &str = "case_sha256";
pub const WALLS: &str = "walls";
pub const HISTORY: &str = "changes";
/// Text of a checkpoint at which the stop condition of the case has ended its run.
pub const STOP_MET: &str = "stop_met";
/// How far the insertions have come.
pub const INSERTIONS: &str = "insertions";
/// The offset of sliding images, and the sums for the stress since the last row.
pub const SHEAR: &str = "shear";

/// Arrays and texts of a checkpoint.
pub type State = (Vec<Array>, Metadata);

/// The state of this rank; the contact history is that before those of the present step are evaluated.
pub fn state(dem: &mut Dem, insertions: &Insertions, transport: &MpiTransport) -> State {
    // First: what is counted of a particle is in its record.
    let crossings = crossings::texts(dem, transport);
    let (lengths, history) = dem.packed_history();
    let mut records = Vec::new();
    for i in 0..dem.particles.owned {
        dem.saved_record(i).write(&mut records);
    }
    let array = |name, width, values| Array { name, unit: "SI", width, values };
    let mut arrays = vec![
        array("particle", ParticleRecord::LENGTH, Values::Real(records)),
        array("memory_length", 1, Values::Integer(lengths.iter().map(|&l| i64::from(l)).collect())),
        array("memory", 1, Values::Real(history)),
    ];
    if dem.particles.is_carrying() {
        arrays.push(array("cargo", CARGO_LENGTH, Values::Real(dem.particles.cargo.concat())));
    }
    let BondLedger { made, broken, left } = dem.bond_ledger;
    let mut ledger = [dem.ledger.inserted, dem.ledger.left, dem.report.deep_penetrations, made, broken, left];
    transport.sum_counts(&mut ledger);
    let list = |values: &[i64]| values.iter().map(i64::to_string).collect::<Vec<_>>().join(" ");
    let mut texts: Metadata = vec![
        ("step".into(), dem.step.to_string()),
        ("time".into(), format!("{:?}", dem.time())),
        ("dt".into(), format!("{:x}", dem.setup.parameters.dt.to_bits())),
        ("ledger".into(), list(&ledger.map(|n| n as i64))),
        (
            "origin".into(),
            format!("{} {:x}", dem.origin.step, dem.origin.time.to_bits()),
        ),
        (INSERTIONS.into(), insertions.progress()),
        (WALLS.into(), walls(dem)),
        ("made_bonds".into(), list(&dem.made_bonds.iter().map(|&is_made| i64::from(is_made)).collect::<Vec<_>>())),
        (
            "particle_columns".into(),
            "id; shape; material; sides; position*3 (m); velocity*3 (m/s); angular_velocity*3 (rad/s); half_velocity*3 (m/s); half_spin*3 (rad/s of a sphere, else kg m2/s); quaternion_wxyz*4; radius (m); mass (kg); temperature (K)".into(),
        ),
    ];
    texts.extend(crossings);
    if dem.setup.shear.is_some() {
        let sums = dem.stress_sums(transport).numbers();
        texts.push((SHEAR.into(), words(&[&[dem.shear_offset()][..], &sums].concat())));
    }
    let mut state = (arrays, texts);
    wear::save(dem, &mut state, transport);
    liquid::save(dem, &mut state, transport);
    heat::save(dem, &mut state, transport);
    species::save(dem, &mut state, transport);
    state
}

/// Numbers as the bits they are.
pub fn words(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!("{:x}", x.to_bits())).collect::<Vec<_>>().join(" ")
}

/// A line per wall: its pose, its place before it moves if it is not that of the case, and its travel under a load with the
/// axis, if it has one.
fn walls(dem: &Dem) -> String {
    let line = |k: usize| {
        let pose = words(&dem.wall_states()[k].pose().numbers());
        let place = dem.wall_places[k].map(|place| words(&place.numbers())).unwrap_or_default();
        let travel = dem.setup.walls[k].motion.loading().map(|loading| {
            let Travel { way, half_speed, speed } = dem.travels[k];
            words(&[way, half_speed, speed, loading.axis.x, loading.axis.y, loading.axis.z])
        });
        format!("{pose};{place};{}\n", travel.unwrap_or_default())
    };
    (0..dem.setup.walls.len()).map(line).collect()
}

/// Travel of a wall under its load at a checkpoint, and the axis of that load.
fn travel(words: &str) -> Option<(Travel, Vec3)> {
    let [way, half_speed, speed, x, y, z] = reals(words)?.try_into().ok()?;
    Some((Travel { way, half_speed, speed }, Vec3::new(x, y, z)))
}

/// Numbers written as the bits they are.
pub fn reals(words: &str) -> Option<Vec<f64>> {
    let bits = |word: &str| u64::from_str_radix(word, 16).ok().map(f64::from_bits);
    words.split_whitespace().map(bits).collect()
}

/// What a run that continues a checkpoint has found.
pub struct Continued {
    /// What differs from the case of the checkpoint.
    pub changes: Vec<String>,
    /// These and those of earlier restarts, with their steps; empty if there are none.
    pub history: String,
    /// Whether the checkpoint lies in the directory of this run, whose files it then continues.
    pub is_own: bool,
    /// Whether the fluid is new: the checkpoint holds particles alone.
    pub is_fluid_new: bool,
    /// Whether the checkpoint is the end of a run whose stop condition was met, and its case says the same but for its output.
    pub is_at_end: bool,
}

/// Takes the state of a checkpoint.
///
/// The case may differ where the state has a meaning in it; all that differs is said. Walls, insertions, shapes, materials and
/// flow planes are known by their names:
/// - A wall of the same form keeps the history of its contacts. If its motion differs it stays where it is, and goes on from there
///   as the new motion does. One of another form or name is where the case says, and its contacts begin anew.
/// - An insertion goes on after the particles it has inserted; one with a new name begins, now at the earliest.
///
/// # Errors
/// A checkpoint whose particles or fluid do not fit the case.
pub fn restore(
    case: &Case,
    transport: &MpiTransport,
    file: &CheckpointFile,
    (dem, fluid): (&mut Dem, &mut Option<FluidPhase>),
    insertions: &mut Insertions,
) -> Result<Continued, RunError> {
    let is_first = transport.rank() == 0;
    let refuse = |why: String| RunError::case(format!("{} cannot be continued: {why}", file.path.display()));
    let [before, now] = known_cases(case, file, transport).map_err(refuse)?;
    let changes = changes::changes(&before, &now);
    let step = numbers(file, "step").first().map_or(0, |&s| s as u64);
    let numbering = Numbering::new(&before, &now, &changes);
    let values = check_values(file, dem, &numbering);
    agree(transport.communicator(), values.map_err(|why| FileError::new(&file.path, why)))?;
    let (time, ratio) =
        continue_clock(dem, file, step).ok_or_else(|| refuse("its clock is missing or wrong".into()))?;
    check_state(file, dem, (&before, &now, &changes), &numbering, insertions, transport).map_err(refuse)?;
    restore_shear(dem, file, is_first);
    place_walls(dem, file, &changes, (&numbering, ratio));
    wear::restore(dem, file, |wall| numbering.wall(wall))?;
    let progress = file.text(INSERTIONS).ok_or_else(|| refuse("it is of an earlier version".into()))?;
    let released = insertions.restore(&before, progress, &changes, time).map_err(refuse)?;
    dem.prescribe(insertions.prescribed_motions(case));
    restore_particles(case, file, (dem, fluid.as_ref()), (&numbering, &released, ratio), transport)?;
    dem.announce_insertion();
    let has_fluid = before.contains_key("fluid");
    if let Some(fluid) = fluid {
        match has_fluid {
            true => fluid.restore(file, dem, transport)?,
            false => fluid.begin_at(dem),
        }
        fluid.change_step(dem.step, ratio);
    }
    if is_first {
        restore_ledger(file, dem, &numbering, (&before, &changes));
    }
    let mut told: Vec<String> = changes.iter().map(ToString::to_string).collect();
    if ratio != 1.0 {
        told.push(format!(
            "time step {:e} s, was {:e} s",
            dem.setup.parameters.dt,
            dem.setup.parameters.dt / ratio
        ));
    }
    if is_first {
        log::info!("continuing from {}", file.path.display());
        if !told.is_empty() {
            log::info!("its case differs from this one:");
            told.iter().for_each(|change| log::info!("  {change}"));
        }
        let remarks = remarks::remarks(case, file, (step, time), (&before, &now, &changes), insertions);
        remarks.iter().for_each(|remark| log::warn!("{remark}"));
    }
    let mut history = file.text(HISTORY).unwrap_or("").to_string();
    told.iter().for_each(|change| history += &format!("from step {step}, t = {time:?} s: {change}\n"));
    let is_own = transport.any(is_first && lies_in(&file.path, &case.output.directory));
    let is_same = changes.iter().all(|change| change.is_within(&["output"]));
    let is_at_end = is_same && file.text(STOP_MET).is_some();
    Ok(Continued { changes: told, history, is_own, is_fluid_new: fluid.is_some() && !has_fluid, is_at_end })
}

/// Gives this rank the particles of a checkpoint that lie in its subdomain; `ratio` is the time step over that of the
/// checkpoint.
fn restore_particles(
    case: &Case,
    file: &CheckpointFile,
    (dem, fluid): (&mut Dem, Option<&FluidPhase>),
    (numbering, released, ratio): (&Numbering, &[Range<u64>], f64),
    transport: &MpiTransport,
) -> Result<(), RunError> {
    let (was_warm, known) = (heat::ledger(file).is_some(), species::known(file));
    for row in owned_rows(file, dem, numbering, transport)? {
        let mut record = row.record;
        let kind = record.body.kind;
        record.body.kind = numbering.kind(kind).unwrap_or(kind);
        if ratio != 1.0 {
            change_step(&mut record, dem, ratio);
        }
        if !was_warm {
            record.temperature = heat::initial(case, None);
        }
        let is_released = released.iter().any(|ids| ids.contains(&record.id));
        if is_released {
            record.half_velocity = half_step_back(record.body.velocity, &dem.setup.parameters);
        }
        // Bridges that no films fed have no part in their liquid.
        let was_dry = dem.particles.is_wet() && row.film.is_none();
        let history = if was_dry { without_bridges(&row.history) } else { row.history };
        match numbering.keeps_walls() {
            true => dem.restore(&record, &history),
            false => {
                let renumbered = renumber_walls(&history, |wall| numbering.wall(wall));
                dem.leave_on_walls(&history, record.body.kind, |wall| numbering.wall(wall));
                dem.restore(&record, &renumbered);
            }
        }
        if !was_warm {
            dem.account_heat_of_last();
        }
        species::restore_last(dem, &known, &row.amounts);
        if let (Some(cargo), Some(place)) = (row.cargo, dem.particles.cargo.last_mut()) {
            let is_resolved = fluid.is_some_and(|fluid| fluid.resolved.is_some());
            *place = if is_released && is_resolved { FlowLink::released(&cargo) } else { cargo };
        }
        if dem.particles.is_wet() {
            dem.restore_film(row.film);
        }
    }
    Ok(())
}

/// Gives the first rank what the checkpoint counted: particles inserted and left, and crossings of the flow planes.
fn restore_ledger(
    file: &CheckpointFile,
    dem: &mut Dem,
    numbering: &Numbering,
    (before, changes): (&Table, &[Change]),
) {
    let ledger = numbers(file, "ledger");
    (dem.ledger.inserted, dem.ledger.left) = (ledger[0] as u64, ledger[1] as u64);
    let later = |k: usize| ledger.get(k).map_or(0, |&count| count as u64);
    dem.report.deep_penetrations = later(2);
    if let (Some(ledger), true) = (liquid::ledger(file), dem.particles.is_wet()) {
        dem.liquid_ledger.add(&ledger);
    }
    species::restore_ledgers(dem, &species::known(file));
    if let (Some((ledger, of_walls)), Some(_)) = (heat::ledger(file), &dem.setup.thermal) {
        dem.heat_ledger = ledger;
        let numbered = of_walls.into_iter().enumerate();
        for (number, flow) in numbered.filter_map(|(old, flow)| Some((numbering.wall(old as u16)?, flow))) {
            dem.wall_heat[usize::from(number)] = flow;
        }
        let numbered = heat::wall_temperatures(file).into_iter().enumerate();
        for (number, kelvin) in numbered.filter_map(|(old, t)| Some((numbering.wall(old as u16)?, t))) {
            dem.set_wall_temperature(usize::from(number), kelvin);
        }
    }
    dem.bond_ledger = BondLedger { made: later(3), broken: later(4), left: later(5) };
    let counts = crossings::read(file, dem.mass_quantum());
    // A plane that lies elsewhere counts anew.
    let planes = changes::names(before, "flow_plane");
    let counted = |plane: &FlowPlane| {
        let is_moved = changes.iter().any(|change| change.is_within(&["flow_plane", &plane.name]));
        let old = planes.iter().position(|name| *name == plane.name).filter(|_| !is_moved);
        old.and_then(|old| counts.get(old).copied()).unwrap_or_default()
    };
    let counts: Vec<Crossings> = dem.setup.planes.iter().map(counted).collect();
    dem.restore_crossings(&counts);
}

/// The whole numbers of a text of a checkpoint.
pub fn numbers(file: &CheckpointFile, name: &str) -> Vec<i64> {
    file.text(name).unwrap_or("").split_whitespace().filter_map(|n| n.parse().ok()).collect()
}

/// Whether a file lies in a folder, by whatever paths both are named.
fn lies_in(file: &Path, folder: &Path) -> bool {
    let parent = file.canonicalize().ok().and_then(|path| Some(path.parent()?.to_path_buf()));
    parent.is_some() && parent == folder.canonicalize().ok()
}

/// Reads a checkpoint: a file, or the newest valid one of a folder (`latest`: of the output directory).
///
/// # Errors
/// No valid checkpoint.
pub fn open(case: &Case, transport: &MpiTransport, checkpoint: &Path) -> Result<CheckpointFile, RunError> {
    let communicator = transport.communicator();
    let folder = match checkpoint {
        latest if latest == Path::new("latest") => Some(case.output.directory.as_path()),
        folder => transport.any(transport.rank() == 0 && folder.is_dir()).then_some(folder),
    };
    let Some(folder) = folder else {
        let is_first = transport.rank() == 0;
        let problem = is_first.then(|| remarks::no_checkpoint(case, checkpoint)).flatten();
        agreed(transport, problem.map_or(Ok(()), |problem| Err(RunError::files(problem))))?;
        return Ok(CheckpointFile::read(checkpoint, communicator)?);
    };
    let (file, refused) = latest_valid(folder, communicator)?;
    if transport.rank() == 0 {
        refused.iter().for_each(|e| log::warn!("{e}"));
    }
    Ok(file)
}

/// The case of the checkpoint and that of the run, their files known by content; rank 0 alone reads these.
fn known_cases(case: &Case, file: &CheckpointFile, transport: &MpiTransport) -> Result<[Table; 2], String> {
    let text = case.to_toml();
    let own = if transport.rank() == 0 { changes::inputs(&text).unwrap_or_default() } else { String::new() };
    let inputs = from_rank(transport.communicator(), 0, &own);
    let before = changes::known(file.text("case").unwrap_or(""), file.text(INPUTS).unwrap_or(""))?;
    Ok([before, changes::known(&text, &inputs)?])
}

/// Sets the clock of the checkpoint, from which time goes on with the time step of the case; returns the time (s) and the ratio of
/// the time step to that before; `None` if the checkpoint has no clock, or one that no run could have.
fn continue_clock(dem: &mut Dem, file: &CheckpointFile, step: u64) -> Option<(f64, f64)> {
    let real = |word: &str| u64::from_str_radix(word, 16).ok().map(f64::from_bits);
    let (before, now) = (file.text("dt").and_then(real)?, dem.setup.parameters.dt);
    let origin = match file.text("origin") {
        None => Origin::default(),
        Some(text) => {
            let (step, time) = text.split_once(' ')?;
            Origin { step: step.parse().ok()?, time: real(time)? }
        }
    };
    if !(before > 0.0
        && before.is_finite()
        && origin.time >= 0.0
        && origin.time.is_finite()
        && origin.step <= step)
    {
        return None;
    }
    let time = origin.time_of(step, before);
    dem.dt_before = (before != now).then_some(before);
    // Kinds that are new are made as soon as their time has come.
    for (is_made, saved) in dem.made_bonds.iter_mut().zip(numbers(file, "made_bonds")) {
        *is_made = saved != 0;
    }
    dem.origin = if before == now { origin } else { Origin { step, time } };
    dem.resume_at(step);
    Some((time, if before == now { 1.0 } else { now / before }))
}

/// Velocities half a step before the present, for a time step that is `ratio` times that before.
fn change_step(record: &mut ParticleRecord, dem: &Dem, ratio: f64) {
    let body = &record.body;
    let spin = match dem.setup.catalogue.shape(body.kind).is_sphere() {
        true => body.angular_velocity,
        false => {
            let turn = &record.orientation;
            let own = turn.inverse_transform_vector(&body.angular_velocity);
            turn.transform_vector(&own.component_mul(&dem.setup.catalogue.inertia(body)))
        }
    };
    record.half_velocity = other_half_step(body.velocity, record.half_velocity, ratio);
    record.half_spin = other_half_step(spin, record.half_spin, ratio);
}

/// Lets the images of a sheared box go on from where they were; the first rank takes the sums for the stress.
fn restore_shear(dem: &mut Dem, file: &CheckpointFile, is_first: bool) {
    let Some(numbers) = file.text(SHEAR).and_then(reals) else { return };
    let Some((offset, sums)) = numbers.split_first() else { return };
    dem.set_shear_offset(*offset);
    if let (true, Ok(sums)) = (is_first, sums.try_into()) {
        dem.stress = StressSums::from_numbers(sums);
    }
}

/// Gives the walls the places they had; one whose motion differs stays where it is.
fn place_walls(
    dem: &mut Dem,
    file: &CheckpointFile,
    changes: &[Change],
    (numbering, ratio): (&Numbering, f64),
) {
    let place = |words: &str| Some(WallPlace::from_numbers(&reals(words)?.try_into().ok()?));
    let time = dem.time();
    for (old, line) in file.text(WALLS).unwrap_or("").lines().enumerate() {
        let Some(number) = numbering.wall(old as u16).map(usize::from) else { continue };
        let wall = &dem.setup.walls[number];
        let is_moved = changes.iter().any(|change| change.is_within(&["wall", &wall.name, "motion"]));
        let mut parts = line.split(';');
        let [pose, own, travelled] = std::array::from_fn(|_| parts.next().unwrap_or(""));
        dem.wall_places[number] = match (is_moved, place(pose)) {
            (true, Some(pose)) => WallPlace::between(&wall.motion.at(time), &pose),
            _ => place(own),
        };
        if let (Some(loading), Some((travel, axis))) = (wall.motion.loading(), travel(travelled)) {
            let travel = if is_moved { travel.along(axis.dot(&loading.axis)) } else { travel };
            dem.travels[number] = if ratio == 1.0 { travel } else { travel.with_other_step(ratio) };
        }
    }
    dem.resume_at(dem.step);
}
