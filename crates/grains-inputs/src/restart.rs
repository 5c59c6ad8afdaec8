//! Checkpoints with texts and values that no run has written.

use crate::Folders;
use grains_output::{CheckpointFile, Values};
use grains_simulation::{Case, Job, Options, Simulation};
use std::cell::OnceCell;
use std::mem::ManuallyDrop;

/// Cases with a checkpoint each: wet warm spheres between walls, and bonded bodies in a sheared box.
const CASES: [&str; 2] = [SPHERES, BODIES];

const SPHERES: &str = include_str!("spheres.toml");
const BODIES: &str = include_str!("bodies.toml");

/// A case and its state after some steps.
struct Known {
    case: Case,
    checkpoint: CheckpointFile,
}

struct Runs {
    /// MPI ends with the process.
    job: ManuallyDrop<Job>,
    known: Vec<Known>,
}

thread_local! {
    static RUNS: OnceCell<Runs> = const { OnceCell::new() };
}

/// A checkpoint that differs from a right one by the edits that the bytes say.
pub fn restart(bytes: &[u8], folders: &Folders) -> bool {
    let Some((&first, edits)) = bytes.split_first() else { return false };
    RUNS.with(|runs| {
        let runs = runs.get_or_init(|| Runs::begin(folders));
        let known = &runs.known[usize::from(first) % runs.known.len()];
        let checkpoint = altered(known.checkpoint.clone(), edits);
        let options = Options { writes_files: false, ..Options::default() };
        match Simulation::continued(&known.case, &runs.job, options, checkpoint) {
            Ok(mut simulation) => simulation.step().is_ok(),
            Err(error) => {
                assert!(!error.to_string().is_empty());
                false
            }
        }
    })
}

/// Values that are wrong in most places.
const VALUES: [f64; 12] = [
    0.0,
    -1.0,
    1.0,
    -0.5,
    1e3,
    65_536.0,
    4_294_967_296.0,
    1e16,
    1e300,
    f64::NAN,
    f64::INFINITY,
    f64::MIN_POSITIVE,
];

/// Bytes of an edit: what it does, in which text or array, where (two), a value, and how many characters or values.
const EDIT: usize = 6;

/// A checkpoint with the edits that the bytes say, each of [`EDIT`] bytes and of the characters it puts into a text.
fn altered(mut checkpoint: CheckpointFile, mut edits: &[u8]) -> CheckpointFile {
    while let Some((&[what, which, high, low, value, count], rest)) = edits.split_first_chunk::<EDIT>() {
        let place = usize::from(u16::from_be_bytes([high, low]));
        let (inserted, rest) =
            rest.split_at(if what % 2 == 0 { usize::from(count).min(rest.len()) } else { 0 });
        edits = rest;
        let mut number = [0_u8; 2];
        let mut is_meant = |kind: usize| {
            number[kind] = number[kind].wrapping_add(1);
            number[kind] - 1 == which
        };
        checkpoint = match what % 2 {
            0 => checkpoint.altered(
                |_, text| {
                    if is_meant(0) {
                        edit_text(text, (place, value.into()), inserted);
                    }
                },
                |_, _| (),
            ),
            _ => checkpoint.altered(
                |_, _| (),
                |_, values| {
                    if is_meant(1) {
                        edit_values(values, what, (place, value.into()), count.into());
                    }
                },
            ),
        };
    }
    checkpoint
}

/// Puts characters in the place of some others.
fn edit_text(text: &mut String, (place, gone): (usize, usize), inserted: &[u8]) {
    let begin = boundary(text, place);
    let end = boundary(text, begin + gone).max(begin);
    text.replace_range(begin..end, &String::from_utf8_lossy(inserted));
}

/// The last place up to `place` where a character begins.
fn boundary(text: &str, place: usize) -> usize {
    (0..=place.min(text.len())).rev().find(|&k| text.is_char_boundary(k)).unwrap_or(0)
}

/// Gives some values another one, or takes the last ones away.
fn edit_values(values: &mut Values, what: u8, (place, value): (usize, usize), count: usize) {
    let value = VALUES[value % VALUES.len()];
    match (values, what & 2) {
        (Values::Real(list), 0) => list.iter_mut().skip(place).take(count).for_each(|x| *x = value),
        (Values::Integer(list), 0) => list.iter_mut().skip(place).take(count).for_each(|x| *x = value as i64),
        (Values::Real(list), _) => list.resize(place.min(2 * list.len()), value),
        (Values::Integer(list), _) => list.resize(place.min(2 * list.len()), value as i64),
    }
}

impl Runs {
    fn begin(folders: &Folders) -> Self {
        let job = grains_simulation::start().expect("MPI that nobody else has begun");
        let known = CASES.iter().enumerate().map(|(k, text)| {
            let folder = folders.own.join(format!("case-{k}"));
            let mut case = Case::parse(text, "case.toml", &folders.given).unwrap_or_else(|e| panic!("{e}"));
            case.output.directory = folder.clone();
            let mut run = Simulation::new(&case, &job, Options::default()).unwrap_or_else(|e| panic!("{e}"));
            while run.step().unwrap_or_else(|e| panic!("{e}")) == grains_simulation::Status::Running {}
            run.close().unwrap_or_else(|e| panic!("{e}"));
            let communicator = job.transport().communicator();
            let checkpoint =
                grains_output::latest_valid(&folder, communicator).unwrap_or_else(|e| panic!("{e}")).0;
            Known { case, checkpoint }
        });
        Self { known: known.collect(), job: ManuallyDrop::new(job) }
    }
}
