//! Chosen states of the particles of a run.

use crate::block::{Array, Block};
use crate::channel::{Channel, Range};
use crate::fields::{Field, Shown, magnitudes, shown};
use crate::frames::{choose, is_taken};
use grains_output::{FileError, SnapshotFile};
use serde::Serialize;
use std::path::Path;

/// Bytes of the position of a particle, of its orientation, of a field, and of what is told once.
const BYTES: [usize; 4] = [6, 8, 2, 4];
/// Fields of a page of not too many particles.
const FIELDS: usize = 5;

/// Particles as the page reads them.
#[derive(Debug, Serialize)]
pub struct Particles {
    /// Corners of the box that positions are quantised over (m).
    lower: [f64; 3],
    upper: [f64; 3],
    /// Particles shown in each state, and stored in it.
    shown: Vec<usize>,
    stored: Vec<usize>,
    /// Of each particle, by shape and id: first and last state that it is in, id, scale, material.
    first: Array,
    last: Array,
    id: Array,
    scale: Array,
    material: Array,
    /// Particles of each shape.
    of_shape: Vec<usize>,
    /// Channels of x, y and z, of w, x, y and z, and of each field.
    position: Vec<Array>,
    orientation: Vec<Array>,
    fields: Vec<Field>,
    values: Vec<Array>,
}

/// The particles of a state that are taken, by shape and id.
#[derive(Default)]
struct State {
    keys: Vec<(u32, u64)>,
    scale: Vec<f64>,
    material: Vec<u8>,
    position: Vec<[f64; 3]>,
    orientation: Vec<[f64; 4]>,
    values: Vec<Vec<f64>>,
}

/// What was taken: times (s) of the states, the particles, and what was left out.
pub struct Taken {
    /// Times of the states (s).
    pub times: Vec<f64>,
    /// The particles.
    pub particles: Particles,
    /// What was left out, in sentences.
    pub notes: Vec<String>,
}

/// Takes states of a `particles.vtkhdf` within a budget of bytes; `round` tells the shapes without orientation.
///
/// # Errors
/// A file that cannot be read.
pub fn take(
    path: &Path,
    round: &[bool],
    budget: usize,
    block: &mut Block,
) -> Result<Option<Taken>, FileError> {
    let file = SnapshotFile::open_share(path, (0, 1))?;
    let (times, counts) = (file.times(), file.counts());
    if times.is_empty() {
        return Ok(None);
    }
    let turns = round.iter().any(|is_round| !is_round);
    let mut fields = shown(file.fields());
    fields.truncate(FIELDS);
    let bytes = |fields: usize| BYTES[0] + usize::from(turns) * BYTES[1] + fields * BYTES[2] + BYTES[3];
    let mut choice = choose(&counts, budget / bytes(fields.len()));
    let mut notes = Vec::new();
    if choice.states.len() < 16.min(times.len()) && fields.len() > 1 {
        notes.push(format!("Of the fields only {} is here, as there are many particles.", fields[0].name));
        fields.truncate(1);
        choice = choose(&counts, budget / bytes(1));
    }
    if choice.states.len() < times.len() {
        notes.push(format!("{} of {} stored states are here.", choice.states.len(), times.len()));
    }
    if choice.one_of > 1 {
        notes.push(format!("One of {} particles is shown.", choice.one_of));
    }
    let states = choice.states.iter().map(|&k| State::read(&file, k, &fields, (turns, choice.one_of)));
    let states = states.collect::<Result<Vec<_>, _>>()?;
    let stored = choice.states.iter().map(|&k| counts[k]).collect();
    let units = fields.iter().map(|field| file.unit(&field.stored)).collect();
    let particles = assemble(&states, (&fields, units), (stored, turns), block);
    Ok(Some(Taken { times: choice.states.iter().map(|&k| times[k]).collect(), particles, notes }))
}

impl State {
    fn read(
        file: &SnapshotFile,
        step: usize,
        fields: &[Shown],
        (turns, one_of): (bool, usize),
    ) -> Result<Self, FileError> {
        let ids = file.integer(step, "id")?;
        let shapes = file.integer(step, "shape")?;
        let key = |k: usize| (shapes[k].clamp(0, 65_535) as u32, ids[k] as u64);
        let mut order: Vec<usize> = (0..ids.len()).filter(|&k| is_taken(ids[k] as u64, one_of)).collect();
        order.sort_unstable_by_key(|&k| key(k));
        let points = file.points(step)?;
        let scale = file.real(step, "scale")?;
        let turned = if turns { file.real(step, "orientation_wxyz")? } else { Vec::new() };
        let has_material = file.fields().iter().any(|field| field == "material");
        let material = if has_material { file.integer(step, "material")? } else { vec![0; ids.len()] };
        let mut values = Vec::new();
        for field in fields {
            let all = match field.is_integer {
                true => file.integer(step, &field.stored)?.into_iter().map(|x| x as f64).collect(),
                false => magnitudes(&file.real(step, &field.stored)?, ids.len()),
            };
            values.push(order.iter().map(|&k| all[k]).collect());
        }
        Ok(Self {
            keys: order.iter().map(|&k| key(k)).collect(),
            scale: order.iter().map(|&k| scale[k]).collect(),
            material: order.iter().map(|&k| material[k].clamp(0, 255) as u8).collect(),
            position: order.iter().map(|&k| [0, 1, 2].map(|a| points[3 * k + a])).collect(),
            orientation: match turns {
                true => order.iter().map(|&k| [0, 1, 2, 3].map(|a| turned[4 * k + a])).collect(),
                false => Vec::new(),
            },
            values,
        })
    }
}

/// All particles that are in any state.
struct Table {
    keys: Vec<(u32, u64)>,
    first: Vec<u16>,
    last: Vec<u16>,
    scale: Vec<f64>,
    material: Vec<u8>,
    /// Of each state the particles in it, and their row there; none for one that is only before and after.
    present: Vec<Vec<(usize, Option<usize>)>>,
}

impl Table {
    fn of(states: &[State]) -> Self {
        let mut keys: Vec<(u32, u64)> = states.iter().flat_map(|state| &state.keys).copied().collect();
        keys.sort_unstable();
        keys.dedup();
        let count = keys.len();
        let (mut first, mut last) = (vec![u16::MAX; count], vec![0; count]);
        let (mut scale, mut material) = (vec![1.0; count], vec![0; count]);
        let mut places = Vec::new();
        for (frame, state) in states.iter().enumerate() {
            // Both are sorted.
            let mut at = 0;
            let of_rows = state.keys.iter().map(|key| {
                at += keys[at..].iter().take_while(|other| *other < key).count();
                at
            });
            let of_rows: Vec<usize> = of_rows.collect();
            for (row, &thing) in of_rows.iter().enumerate() {
                first[thing] = first[thing].min(frame as u16);
                last[thing] = frame as u16;
                (scale[thing], material[thing]) = (state.scale[row], state.material[row]);
            }
            places.push(of_rows);
        }
        let present = places.into_iter().enumerate().map(|(frame, of_rows)| {
            let mut rows = of_rows.into_iter().enumerate().peekable();
            let is_there = |&thing: &usize| (first[thing]..=last[thing]).contains(&(frame as u16));
            (0..count)
                .filter(is_there)
                .map(|thing| (thing, rows.next_if(|(_, other)| *other == thing).map(|(row, _)| row)))
                .collect()
        });
        let present = present.collect();
        Self { keys, first, last, scale, material, present }
    }

    /// A channel of what each row of each state has.
    fn channel(&self, value: impl Fn(usize, usize) -> u16, block: &mut Block) -> Array {
        let mut channel = Channel::new(self.keys.len());
        for (frame, present) in self.present.iter().enumerate() {
            channel.push(present.iter().map(|&(thing, row)| (thing, row.map(|row| value(frame, row)))));
        }
        block.bytes(&channel.into_bytes())
    }
}

fn assemble(
    states: &[State],
    (fields, units): (&[Shown], Vec<Option<String>>),
    (stored, turns): (Vec<usize>, bool),
    block: &mut Block,
) -> Particles {
    let table = Table::of(states);
    let axis = |a: usize| states.iter().flat_map(move |state| state.position.iter().map(move |p| p[a]));
    let ranges = [0, 1, 2].map(|a| Range::of(axis(a)));
    let position = (0..3)
        .map(|a| table.channel(|k, row| ranges[a].quantised(states[k].position[row][a], 65_535), block))
        .collect();
    let orientation = match turns {
        true => {
            let turns = continuous(states, &table);
            (0..4).map(|a| table.channel(|k, row| signed(turns[k][row][a]), block)).collect()
        }
        false => Vec::new(),
    };
    let (mut of_fields, mut values) = (Vec::new(), Vec::new());
    for (k, (shown, unit)) in fields.iter().zip(units).enumerate() {
        let all: Vec<f64> = states.iter().flat_map(|state| &state.values[k]).copied().collect();
        let field = Field::of(&shown.name, unit, all);
        let range = field.range();
        values.push(table.channel(|s, row| range.quantised(states[s].values[k][row], 65_535), block));
        of_fields.push(field);
    }
    let shapes = table.keys.last().map_or(0, |key| key.0 as usize + 1);
    let mut of_shape = vec![0; shapes];
    table.keys.iter().for_each(|key| of_shape[key.0 as usize] += 1);
    Particles {
        lower: ranges.map(|range| range.min),
        upper: ranges.map(|range| range.max),
        shown: table.present.iter().map(Vec::len).collect(),
        stored,
        first: block.shorts(table.first.iter().copied()),
        last: block.shorts(table.last.iter().copied()),
        id: block.integers(table.keys.iter().map(|key| key.1 as u32)),
        scale: block.reals(table.scale.iter().copied()),
        material: block.bytes(&table.material),
        of_shape,
        position,
        orientation,
        fields: of_fields,
        values,
    }
}

/// Orientations of which each is nearer to that of the state before than its opposite, which turns alike.
fn continuous(states: &[State], table: &Table) -> Vec<Vec<[f64; 4]>> {
    let mut before = vec![[1.0, 0.0, 0.0, 0.0]; table.keys.len()];
    let turned = states.iter().zip(&table.present).map(|(state, present)| {
        let mut turns = state.orientation.clone();
        for (thing, row) in present {
            let Some(turn) = row.map(|row| &mut turns[row]) else { continue };
            if turn.iter().zip(&before[*thing]).map(|(a, b)| a * b).sum::<f64>() < 0.0 {
                *turn = turn.map(|x| -x);
            }
            before[*thing] = *turn;
        }
        turns
    });
    turned.collect()
}

/// A number from −1 to 1 in 16 bits.
fn signed(value: f64) -> u16 {
    (value.clamp(-1.0, 1.0) * 32_767.0).round() as i16 as u16
}
