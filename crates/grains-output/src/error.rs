//! Errors of files, agreed upon by all ranks.

use crate::parallel_file::close_no_file;
use mpi::collective::SystemOperation;
use mpi::request::{Request, Scope};
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Root};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use thiserror::Error;

/// A file that cannot be written or read.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FileError {
    /// This rank met the error.
    #[error("{path}: {problem}")]
    Here {
        /// The file.
        path: String,
        /// What went wrong and what to do.
        problem: String,
    },
    /// Rank 0 reports it.
    #[error("an error of a file, reported by rank 0")]
    Elsewhere,
}

impl FileError {
    /// Error of a file met on this rank.
    pub fn new(path: &Path, problem: impl ToString) -> Self {
        Self::Here { path: path.display().to_string(), problem: problem.to_string() }
    }
}

/// How long a rank with an error waits for the others.
const PATIENCE: Duration = Duration::from_secs(10);

/// Exit code of a job that a rank ends alone, because the others do not come to hear of its error.
pub(crate) const FAILED: i32 = 4;

/// Makes the outcome of all ranks an error if that of any is; rank 0 gets the text of the lowest rank that
/// failed, so that one rank can report it.
///
/// Where HDF5 or MPI lets other ranks wait for what this one could not do, they do not come here. Then this one tells
/// its error after a while, and ends the job.
///
/// # Errors
/// The error on rank 0, [`FileError::Elsewhere`] on the others.
pub fn agree<T>(communicator: &impl Communicator, outcome: Result<T, FileError>) -> Result<T, FileError> {
    let (rank, size) = (communicator.rank(), communicator.size());
    let mut lowest = size;
    let own = if outcome.is_err() { rank } else { size };
    mpi::request::scope(|scope| {
        let request =
            communicator.immediate_all_reduce_into(scope, &own, &mut lowest, SystemOperation::min());
        match &outcome {
            Ok(_) => drop(request.wait()),
            Err(error) => wait_for_others(request, communicator, error),
        }
    });
    if lowest == size {
        return outcome;
    }
    let mut texts = match outcome.err() {
        Some(FileError::Here { path, problem }) => [path, problem],
        _ => [String::new(), FileError::Elsewhere.to_string()],
    };
    for text in &mut texts {
        *text = from_rank(communicator, lowest, text);
    }
    let [path, problem] = texts;
    Err(if rank == 0 { FileError::Here { path, problem } } else { FileError::Elsewhere })
}

/// The same for what was written; after an error no file that is open for all ranks is closed any more.
///
/// # Errors
/// As for [`agree`].
pub fn agree_written<T>(
    communicator: &impl Communicator,
    outcome: Result<T, FileError>,
) -> Result<T, FileError> {
    let outcome = agree(communicator, outcome);
    if outcome.is_err() {
        close_no_file();
    }
    outcome
}

fn wait_for_others<'a, D: ?Sized, S: Scope<'a>>(
    mut request: Request<'a, D, S>,
    communicator: &impl Communicator,
    error: &FileError,
) {
    let begun = Instant::now();
    loop {
        request = match request.test() {
            Ok(_) => return,
            Err(request) => request,
        };
        if begun.elapsed() > PATIENCE {
            eprintln!("error: {error}");
            communicator.abort(FAILED);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A text of one rank on all ranks.
pub fn from_rank(communicator: &impl Communicator, rank: i32, text: &str) -> String {
    let root = communicator.process_at_rank(rank);
    let mut length = text.len() as u64;
    root.broadcast_into(&mut length);
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(length as usize, 0);
    // Open MPI refuses to broadcast nothing.
    if length > 0 {
        root.broadcast_into(&mut bytes[..]);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Ranks up to which each writes for itself.
const FEW: i32 = 64;

/// All ranks of a communicator at work on one file.
///
/// Every collective call ends in [`Shared::all`]: were a rank to leave alone, the others would wait in the
/// next call for ever.
pub(crate) struct Shared {
    pub communicator: SimpleCommunicator,
    /// The ranks of the node, if the first of them writes for all.
    pub node: Option<SimpleCommunicator>,
    pub path: PathBuf,
}

impl Shared {
    pub fn new(path: &Path, communicator: &SimpleCommunicator) -> Self {
        let communicator = communicator.duplicate();
        let is_many = communicator.size() > FEW || grains_comm::are_nodes_given();
        let node = is_many.then(|| grains_comm::ranks_of_node(&communicator));
        Self { communicator, node, path: path.to_path_buf() }
    }

    pub fn is_first(&self) -> bool {
        self.communicator.rank() == 0
    }

    /// The outcome all ranks agree on; `what` failed if it is an error.
    pub fn all<T>(&self, what: &str, outcome: hdf5::Result<T>) -> Result<T, FileError> {
        let error = |error| FileError::new(&self.path, format!("{what}: {}", brief(&error)));
        agree(&self.communicator, outcome.map_err(error))
    }

    /// The verdict all ranks come to; a problem of any is one of all.
    pub fn agree(&self, outcome: Result<(), String>) -> Result<(), FileError> {
        agree(&self.communicator, outcome.map_err(|problem| FileError::new(&self.path, problem)))
    }

    /// The outcome of a write all ranks agree on.
    pub fn written<T>(&self, outcome: hdf5::Result<T>) -> Result<T, FileError> {
        self.written_or("cannot be written", outcome)
    }

    /// The same, where `what` failed if it is an error. The operating system says better than HDF5 why.
    pub fn written_or<T>(&self, what: &str, outcome: hdf5::Result<T>) -> Result<T, FileError> {
        let error = |error| {
            let reason = unwritable_now(&self.path).unwrap_or_else(|| unexplained(&error));
            FileError::new(&self.path, format!("{what}: {reason}"))
        };
        agree_written(&self.communicator, outcome.map_err(error))
    }

    /// Refuses to begin a write on a disk that is full already: HDF5 hangs if it cannot write its own
    /// structures, while it reports data that it cannot write.
    pub fn has_room(&self) -> Result<(), FileError> {
        self.first(|| match unwritable(&self.path, Durability::Cached) {
            Some(problem) => Err(FileError::new(&self.path, format!("cannot be written: {problem}"))),
            None => Ok(()),
        })
    }

    /// Does something on rank 0 alone; its error is that of all.
    pub fn first(&self, work: impl FnOnce() -> Result<(), FileError>) -> Result<(), FileError> {
        let outcome = if self.is_first() { work() } else { Ok(()) };
        agree_written(&self.communicator, outcome)
    }

    /// Makes the file empty on rank 0: the operating system says better than HDF5 why it cannot be written.
    pub fn create_empty(&self) -> Result<(), FileError> {
        self.first(|| {
            fs::File::create(&self.path).map(drop).map_err(|error| {
                FileError::new(
                    &self.path,
                    format!("cannot be created: {error}; {}", remedy(&self.path, &error)),
                )
            })
        })
    }
}

/// What the operating system knows a file by, whatever its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Identity([u64; 2]);

impl Identity {
    /// That of the file which has a name now.
    pub fn of(path: &Path) -> Option<Self> {
        use std::os::unix::fs::MetadataExt;
        let metadata = fs::metadata(path).ok()?;
        Some(Self([metadata.dev(), metadata.ino()]))
    }

    /// Refuses to write on into a file that has no longer its name: nobody would find what is written.
    pub fn require(file: Option<Self>, path: &Path) -> Result<(), FileError> {
        match Self::of(path) {
            now if now == file => Ok(()),
            now => {
                let what = if now.is_some() { "replaced" } else { "removed or renamed" };
                let problem = format!(
                    "was {what} while this run writes it; put it back, then --restart latest, or begin it anew from there"
                );
                Err(FileError::new(path, problem))
            }
        }
    }
}

fn remedy(path: &Path, error: &std::io::Error) -> String {
    let folder = path.parent().unwrap_or(Path::new(".")).display();
    match error.kind() {
        std::io::ErrorKind::NotFound => format!("the folder {folder} does not exist: create it"),
        std::io::ErrorKind::PermissionDenied => format!("get the right to write into {folder}"),
        std::io::ErrorKind::StorageFull => "free space".into(),
        _ => "choose another output.directory".into(),
    }
}

/// What the operating system says to a write beside the file that must reach the disk, if it refuses it.
pub(crate) fn unwritable_now(path: &Path) -> Option<String> {
    unwritable(path, Durability::Synced)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Durability {
    Cached,
    Synced,
}

/// What the operating system says to half a megabyte more beside the file, if it refuses it.
fn unwritable(path: &Path, durability: Durability) -> Option<String> {
    let probe = path.with_extension(format!("probe-{}", std::process::id()));
    let outcome = fs::File::create(&probe).and_then(|mut file| {
        file.write_all(&vec![0_u8; 1 << 19])?;
        if durability == Durability::Synced { file.sync_all() } else { Ok(()) }
    });
    let _ = fs::remove_file(&probe);
    outcome.err().map(|error| format!("{error}; {}", remedy(path, &error)))
}

/// A failed write that works now: the disk was full for a moment, or its device fails.
fn unexplained(error: &hdf5::Error) -> String {
    format!("{}; look for a full disk, a quota or a failing device, then --restart latest", brief(error))
}

/// The innermost cause in HDF5's words, without the chain of its functions.
fn brief(error: &hdf5::Error) -> String {
    let text = error.to_string();
    text.lines().next().unwrap_or("HDF5 gives no reason").to_string()
}
