//! Memory that the ranks of a node share.

use memmap2::Mmap;
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Root};
use std::fs::{self, File};
use std::io::{self, Write};
use std::os::unix::ffi::OsStringExt;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

/// Where files are kept in memory.
const IN_MEMORY: &str = "/dev/shm";

/// The bytes of the first of the ranks of a node, as [`ranks_of_node`](crate::ranks_of_node) finds them, in memory that all of them read;
/// collective over these ranks.
///
/// `None` on all of them if the first has none, if there is no other rank, or if the node does not let them share memory.
pub fn share_on_node(
    node: &SimpleCommunicator,
    bytes: impl FnOnce() -> Option<Vec<u8>>,
) -> Option<Arc<Mmap>> {
    if node.size() == 1 {
        return None;
    }
    let is_first = node.rank() == 0;
    let written = if is_first { bytes().and_then(|bytes| write(&bytes).ok()) } else { None };
    if is_first {
        give_back();
    }
    let mut name = written.clone().map_or(Vec::new(), |path| path.into_os_string().into_vec());
    let first = node.process_at_rank(0);
    let mut length = name.len();
    first.broadcast_into(&mut length);
    if length == 0 {
        return None;
    }
    name.resize(length, 0);
    first.broadcast_into(&mut name[..]);
    let memory = map(&PathBuf::from(std::ffi::OsString::from_vec(name)));
    let mut all = 0;
    node.all_reduce_into(&i32::from(memory.is_ok()), &mut all, SystemOperation::min());
    if let Some(path) = written {
        // It stays in memory as long as it is read.
        let _ = fs::remove_file(path);
    }
    memory.ok().filter(|_| all == 1).map(Arc::new)
}

/// Writes a file that the other processes of this machine can read.
fn write(bytes: &[u8]) -> io::Result<PathBuf> {
    let folder = if Path::new(IN_MEMORY).is_dir() { IN_MEMORY.into() } else { std::env::temp_dir() };
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos());
    let path = folder.join(format!("grains-mpi-{}-{now}", std::process::id()));
    let mut file = File::options().write(true).create_new(true).mode(0o600).open(&path)?;
    let written = file.write_all(bytes);
    if written.is_err() {
        let _ = fs::remove_file(&path);
    }
    written.map(|()| path)
}

/// Gives what the process has freed back to the system: what the bytes were made from is several times as large as they.
fn give_back() {
    // SAFETY: the allocator may be asked for this at any time.
    #[cfg(target_env = "gnu")]
    #[allow(unsafe_code)]
    unsafe {
        libc::malloc_trim(0);
    }
}

fn map(path: &Path) -> io::Result<Mmap> {
    let file = File::open(path)?;
    // SAFETY: nobody writes to the file once its name is known to others, and it is removed as soon as all have mapped it.
    #[allow(unsafe_code)]
    unsafe {
        Mmap::map(&file)
    }
}
