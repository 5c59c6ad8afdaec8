//! What has worn off the walls, in a checkpoint and back.

use crate::restart::{State, reals, words};
use grains_comm::MpiTransport;
use grains_dem::{Dem, WornElement};
use grains_domain::Transport;
use grains_output::{Array, CheckpointFile, FileError, Values};

/// Array of a checkpoint: a row of wall, surface, element, and the upper and lower half of the number of quanta.
const WORN: &str = "worn";
const WIDTH: usize = 5;

/// Text of a checkpoint: the volume (m³) of a quantum of each wall, 0 of one that does not wear.
pub const QUANTA: &str = "worn_quanta";

/// Adds what has worn off the walls to a checkpoint, if some wear.
pub fn save(dem: &Dem, (arrays, texts): &mut State, transport: &MpiTransport) {
    if !dem.has_wear() {
        return;
    }
    let is_first = transport.rank() == 0;
    let worn = dem.worn_elements(transport).into_iter().filter(|_| is_first).flat_map(row);
    arrays.push(Array { name: WORN, unit: "-", width: WIDTH, values: Values::Integer(worn.collect()) });
    let quanta: Vec<f64> = dem.worn_quanta().into_iter().map(|volume| volume.unwrap_or(0.0)).collect();
    texts.push((QUANTA.into(), words(&quanta)));
}

fn row(worn: WornElement) -> [i64; WIDTH] {
    let WornElement { wall, surface, element, quanta } = worn;
    [wall.into(), surface.into(), element.into(), (quanta >> 64) as i64, quanta as i64]
}

/// Refuses what has worn off elements that there are not; `number` as of [`restore`].
pub fn check(dem: &Dem, file: &CheckpointFile, number: impl Fn(u16) -> Option<u16>) -> Result<(), String> {
    let Some(before) = file.text(QUANTA).and_then(reals) else { return Ok(()) };
    let rows = file.integer(WORN).map_err(|e| e.to_string())?;
    let is_there = |row: &[i64]| {
        let wall = u16::try_from(row[0]).ok().filter(|&wall| usize::from(wall) < before.len())?;
        let surface = u16::try_from(row[1]).ok()?;
        let element = u32::try_from(row[2]).ok()?;
        // Room for what wears off later.
        let is_counted = row[3] >= 0 && row[3] < i64::MAX / 2;
        let is_worn = number(wall).is_none_or(|wall| dem.has_element(wall, surface, element));
        (is_counted && is_worn).then_some(())
    };
    match rows.len().is_multiple_of(WIDTH) && rows.chunks_exact(WIDTH).all(|row| is_there(row).is_some()) {
        true => Ok(()),
        false => Err(format!("`{WORN}` has elements of walls that there are not")),
    }
}

/// Gives the walls what has worn off them; `number` is that of a wall of the checkpoint in the case, if it has the same form.
///
/// The volume stays where the restart changes the wear, or the stiffness, which the quanta follow.
pub fn restore(
    dem: &mut Dem,
    file: &CheckpointFile,
    number: impl Fn(u16) -> Option<u16>,
) -> Result<(), FileError> {
    let Some(before) = file.text(QUANTA).and_then(reals) else { return Ok(()) };
    let now = dem.worn_quanta();
    for row in file.integer(WORN)?.chunks_exact(WIDTH) {
        let &[old, surface, element, high, low] = row else { continue };
        let Some(wall) = number(old as u16) else { continue };
        let Some(new_volume) = now[usize::from(wall)] else { continue };
        let quanta = (u128::from(high as u64) << 64) | u128::from(low as u64);
        let ratio = before[old as usize] / new_volume;
        let quanta = if ratio == 1.0 { quanta } else { (quanta as f64 * ratio).round() as u128 };
        dem.restore_worn(WornElement { wall, surface: surface as u16, element: element as u32, quanta });
    }
    Ok(())
}
