//! The fluid in the states of a page, of fewer cells if there are many.

use crate::block::{Array, Block};
use crate::channel::Range;
use crate::fields::{Field, Shown, magnitudes, shown};
use crate::frames::evenly;
use crate::walls::nearest;
use grains_output::{FileError, GridBlock, GridSnapshotFile};
use serde::Serialize;
use std::path::Path;

/// Bytes of all fields and states, one per number.
const BYTES: usize = 1_600_000;
/// States at most, and at least as long as cells have to be joined for more.
const STATES: [usize; 2] = [60, 12];
/// Fields at most.
const FIELDS: usize = 4;
/// Numbers that are read at most: a bound of the time that a page takes.
const NUMBERS: usize = 150_000_000;
/// Numbers that are read at once.
const AT_ONCE: usize = 1 << 20;

/// The fluid as the page reads it.
#[derive(Debug, Serialize)]
pub struct Fluid {
    /// Corners of the grid (m).
    lower: [f64; 3],
    upper: [f64; 3],
    /// Cells along x, y and z on the page, and stored.
    cells: [usize; 3],
    stored: [usize; 3],
    /// Its states (s), of which each state of the page takes the nearest.
    times: Vec<f64>,
    of_frame: Vec<usize>,
    /// Fields, in 8 bits per number, `[states][z][y][x]`, each state as what differs from the one before.
    fields: Vec<Field>,
    values: Vec<Array>,
}

/// Times of the states that a fluid without particles has (s).
///
/// # Errors
/// A file that cannot be read.
pub fn times(path: &Path) -> Result<Vec<f64>, FileError> {
    let file = GridSnapshotFile::open_alone(path)?;
    Ok(evenly(file.times().len(), STATES[0]).into_iter().map(|k| file.times()[k]).collect())
}

/// Reads the fluid for the states of a page at some times (s); what is left out goes to the notes.
///
/// # Errors
/// A file that cannot be read.
pub fn read(
    path: &Path,
    frames: &[f64],
    (block, notes): (&mut Block, &mut Vec<String>),
) -> Result<Option<Fluid>, FileError> {
    let file = GridSnapshotFile::open_alone(path)?;
    let nodes = file.nodes();
    let stored = nodes.each_ref().map(|nodes| nodes.len().saturating_sub(1));
    let mut fields = shown(file.fields());
    fields.truncate(FIELDS);
    if file.times().is_empty() || fields.is_empty() || stored.contains(&0) {
        return Ok(None);
    }
    let mut wanted: Vec<usize> = frames.iter().filter_map(|&time| nearest(file.times(), time)).collect();
    wanted.dedup();
    let all: usize = stored.iter().product();
    let fitting = BYTES / (fields.len() * all).max(1);
    let readable = NUMBERS / (fields.len() * all).max(1);
    let count = fitting.clamp(STATES[1], STATES[0]).min(readable.max(2));
    let states: Vec<usize> = evenly(wanted.len(), count).into_iter().map(|k| wanted[k]).collect();
    let cells = joined(stored, BYTES / (fields.len() * states.len()));
    if cells != stored {
        let [[a, b, c], [x, y, z]] = [cells, stored];
        notes.push(format!("The fluid is shown on {a} × {b} × {c} cells instead of {x} × {y} × {z}."));
    }
    if states.len() < wanted.len() {
        notes.push(format!("{} states of the fluid are here; others show the nearest.", states.len()));
    }
    let takes: [Vec<Vec<usize>>; 3] = std::array::from_fn(|a| sources(&nodes[a], cells[a]));
    let (mut of_fields, mut values) = (Vec::new(), Vec::new());
    for field in &fields {
        let read = states.iter().map(|&step| means(&file, step, field, (&takes, stored)));
        let read = read.collect::<Result<Vec<Vec<f64>>, _>>()?;
        let described = Field::of(&field.name, file.unit(&field.stored), read.concat());
        values.push(block.bytes(&changes(&read, described.range())));
        of_fields.push(described);
    }
    let times: Vec<f64> = states.iter().map(|&k| file.times()[k]).collect();
    Ok(Some(Fluid {
        lower: nodes.each_ref().map(|nodes| nodes[0]),
        upper: nodes.each_ref().map(|nodes| nodes[nodes.len() - 1]),
        cells,
        stored,
        of_frame: frames.iter().filter_map(|&time| nearest(&times, time)).collect(),
        times,
        fields: of_fields,
        values,
    }))
}

/// Numbers of cells that are at most so many in all: the longest axis is halved as often as it takes.
fn joined(mut cells: [usize; 3], max: usize) -> [usize; 3] {
    while cells.iter().product::<usize>() > max.max(1) {
        let longest = (0..3).max_by_key(|&a| cells[a]).unwrap_or(0);
        cells[longest] = cells[longest].div_ceil(2);
    }
    cells
}

/// Of each of so many equal cells along an axis those of a grid whose middles lie in it, or the one around its own middle.
fn sources(nodes: &[f64], cells: usize) -> Vec<Vec<usize>> {
    let (begin, end) = (nodes[0], nodes[nodes.len() - 1]);
    let width = (end - begin) / cells as f64;
    let mut of_cells = vec![Vec::new(); cells];
    for (k, ends) in nodes.windows(2).enumerate() {
        let place = ((0.5 * (ends[0] + ends[1]) - begin) / width) as usize;
        of_cells[place.min(cells - 1)].push(k);
    }
    for (k, sources) in of_cells.iter_mut().enumerate().filter(|(_, sources)| sources.is_empty()) {
        let middle = begin + (k as f64 + 0.5) * width;
        sources.push(nodes.partition_point(|&x| x <= middle).clamp(1, nodes.len() - 1) - 1);
    }
    of_cells
}

/// Means of a field over the cells that are joined; layers are read a few at a time.
fn means(
    file: &GridSnapshotFile,
    step: usize,
    field: &Shown,
    (takes, all): (&[Vec<Vec<usize>>; 3], [usize; 3]),
) -> Result<Vec<f64>, FileError> {
    let [columns, rows, layers] = takes;
    let mut means = Vec::with_capacity(columns.len() * rows.len() * layers.len());
    let per_layer = all[0] * all[1];
    let ahead = (AT_ONCE / per_layer.max(1)).max(1);
    let (mut first, mut kept): (usize, Vec<f64>) = (0, Vec::new());
    for layer in layers {
        let (begin, end) = (layer[0], layer[layer.len() - 1] + 1);
        if kept.is_empty() || begin < first || end > first + kept.len() / per_layer {
            first = begin;
            let count = (end - begin).max(ahead).min(all[2] - begin);
            let part = GridBlock { all, first: [0, 0, first], own: [all[0], all[1], count] };
            kept = magnitudes(&file.block(step, &field.stored, &part)?, part.count());
        }
        for row in rows {
            for column in columns {
                let mut sum = [0.0, 0.0];
                for (z, y, x) in layer
                    .iter()
                    .flat_map(|z| row.iter().flat_map(move |y| column.iter().map(move |x| (z, y, x))))
                {
                    let value = kept[((z - first) * all[1] + y) * all[0] + x];
                    if value.is_finite() {
                        sum = [sum[0] + value, sum[1] + 1.0];
                    }
                }
                means.push(sum[0] / sum[1]);
            }
        }
    }
    Ok(means)
}

/// Numbers in 8 bits, each state as what differs from the one before.
fn changes(states: &[Vec<f64>], range: Range) -> Vec<u8> {
    let mut last = vec![0_u8; states.first().map_or(0, Vec::len)];
    let mut bytes = Vec::with_capacity(states.len() * last.len());
    for state in states {
        for (last, &value) in last.iter_mut().zip(state) {
            let value = range.quantised(value, 255) as u8;
            bytes.push(value.wrapping_sub(std::mem::replace(last, value)));
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_joined_along_the_longest_axis() {
        assert_eq!(joined([8, 4, 4], 128), [8, 4, 4]);
        assert_eq!(joined([100, 4, 1], 200), [50, 4, 1]);
        assert_eq!(joined([3, 3, 3], 1), [1, 1, 1]);
    }

    #[test]
    fn every_cell_of_the_page_has_one_of_the_grid_also_where_it_is_stretched() {
        assert_eq!(sources(&[0.0, 1.0, 2.0, 3.0, 4.0], 2), [[0, 1], [2, 3]]);
        let stretched = [0.0, 0.1, 0.2, 0.4, 1.0];
        let of_cells = sources(&stretched, 4);
        assert!(of_cells.iter().all(|cells| !cells.is_empty()), "{of_cells:?}");
        assert_eq!(of_cells[3], [3], "{of_cells:?}");
        assert_eq!(of_cells[0], [0, 1], "{of_cells:?}");
    }
}
