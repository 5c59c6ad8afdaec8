//! The particles of a checkpoint, each with all that is its own, on the ranks that own them.

use crate::error::RunError;
use crate::numbering::Numbering;
use crate::{liquid, species};
use grains_comm::MpiTransport;
use grains_dem::{CARGO_LENGTH, Cargo, Dem, FILM_LENGTH, HistoryBounds, ParticleRecord};
use grains_domain::Transport;
use grains_output::{CheckpointFile, FileError, agree};
use std::collections::BTreeMap;

/// A particle of a checkpoint.
pub(super) struct Row {
    pub(super) record: ParticleRecord,
    /// What a coupling lets it carry.
    pub(super) cargo: Option<Cargo>,
    /// Its film.
    pub(super) film: Option<[f64; FILM_LENGTH]>,
    /// Amounts of the species of the checkpoint.
    pub(super) amounts: Vec<f64>,
    /// The history of its contacts.
    pub(super) history: Vec<f64>,
}

/// The particles this rank owns.
pub(super) fn owned_rows(
    file: &CheckpointFile,
    dem: &mut Dem,
    numbering: &Numbering,
    transport: &MpiTransport,
) -> Result<Vec<Row>, RunError> {
    let records = file.real("particle")?;
    let lengths = file.integer("memory_length")?;
    let history = file.next_rows("memory", lengths.iter().sum::<i64>() as usize, transport.communicator())?;
    let known = known_histories(&history, lengths, dem, numbering);
    agree(transport.communicator(), known.map_err(|why| FileError::new(&file.path, why)))?;
    // Rows of the same particles lie on the same ranks in all arrays.
    let is_coupled = dem.particles.is_carrying() && file.has("cargo");
    let cargo = if is_coupled { file.real("cargo")? } else { &[] };
    let width = if is_coupled { CARGO_LENGTH } else { 0 };
    let films = liquid::films(file, dem);
    let of_film = if films.is_some() { FILM_LENGTH } else { 0 };
    let films = films.unwrap_or_default();
    let (amounts, species) = (species::amounts(file), species::known(file).len());
    let mut sent: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    let mut rest = &history[..];
    for (k, (row, &length)) in records.chunks_exact(ParticleRecord::LENGTH).zip(lengths).enumerate() {
        let (own, after) = rest.split_at(length as usize);
        rest = after;
        let record = ParticleRecord::read(row);
        let owner = dem.decomposition.owner(record.body.position.into());
        let message = sent.entry(owner).or_default();
        message.push(length as f64);
        message.extend_from_slice(row);
        message.extend_from_slice(&cargo[k * width..(k + 1) * width]);
        message.extend_from_slice(&films[k * of_film..(k + 1) * of_film]);
        message.extend_from_slice(amounts.get(k * species..(k + 1) * species).unwrap_or_default());
        message.extend_from_slice(own);
    }
    let mut rows = Vec::new();
    for (_, message) in transport.exchange_sparse(sent.into_iter().collect()) {
        let mut rest = &message[..];
        while let Some((&length, after)) = rest.split_first() {
            let (row, after) = after.split_at(ParticleRecord::LENGTH);
            let (cargo, after) = after.split_at(width);
            let (film, after) = after.split_at(of_film);
            let (amounts, after) = after.split_at(species);
            let (history, after) = after.split_at(length as usize);
            rows.push(Row {
                record: ParticleRecord::read(row),
                cargo: cargo.try_into().ok(),
                film: film.try_into().ok(),
                amounts: amounts.to_vec(),
                history: history.to_vec(),
            });
            rest = after;
        }
    }
    Ok(rows)
}

/// Refuses contact histories that refer to what there is not, or that are none.
fn known_histories(history: &[f64], lengths: &[i64], dem: &Dem, numbering: &Numbering) -> Result<(), String> {
    let wall = |old: u16| Some(&dem.setup.walls[usize::from(numbering.wall(old)?)]);
    let bounds = HistoryBounds { wall, walls: numbering.walls(), bonds: &dem.setup.bonds };
    let mut rest = history;
    for (row, &length) in lengths.iter().enumerate() {
        let own;
        (own, rest) = rest.split_at(length as usize);
        if !bounds.admit(own) {
            return Err(format!("`memory` of particle {row} on a rank is no contact history"));
        }
    }
    Ok(())
}
