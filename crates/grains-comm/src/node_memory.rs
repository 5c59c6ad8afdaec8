//! Memory that the ranks of a node share.

use memmap2::Mmap;
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Root};
use std::fs::File;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::sync::Arc;

/// Where other processes find a file in memory: process, descriptor, device and inode; zeros where there is none.
type Place = [u64; 4];

/// The bytes of the first of the ranks of a node, as [`ranks_of_node`](crate::ranks_of_node) finds them, in memory that all of them read;
/// collective over these ranks. The memory has no name, and nothing of it is left however the processes end.
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
    let mut place = written.as_ref().map_or([0; 4], |(_, place)| *place);
    node.process_at_rank(0).broadcast_into(&mut place[..]);
    if place == [0; 4] {
        return None;
    }
    let memory = map(place);
    let mut all = 0;
    // The descriptor is open until all have found it.
    node.all_reduce_into(&i32::from(memory.is_ok()), &mut all, SystemOperation::min());
    drop(written);
    memory.ok().filter(|_| all == 1).map(Arc::new)
}

/// Writes a file in memory, and says where the other processes of this machine find it.
#[cfg(target_os = "linux")]
fn write(bytes: &[u8]) -> io::Result<(File, Place)> {
    use std::io::Write;
    use std::os::fd::{AsRawFd, FromRawFd};
    // SAFETY: the name ends with a zero, and nobody else has the descriptor.
    #[allow(unsafe_code)]
    let mut file = unsafe {
        match libc::memfd_create(c"grains-mpi".as_ptr(), libc::MFD_CLOEXEC) {
            -1 => return Err(io::Error::last_os_error()),
            descriptor => File::from_raw_fd(descriptor),
        }
    };
    file.write_all(bytes)?;
    let metadata = file.metadata()?;
    let (process, descriptor) = (u64::from(std::process::id()), file.as_raw_fd() as u64);
    Ok((file, [process, descriptor, metadata.dev(), metadata.ino()]))
}

/// Other systems have no such files.
#[cfg(not(target_os = "linux"))]
fn write(_: &[u8]) -> io::Result<(File, Place)> {
    Err(io::ErrorKind::Unsupported.into())
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

/// The memory at a place. In a container of its own a process may see another one by this number: then it is another file.
fn map([process, descriptor, device, inode]: Place) -> io::Result<Mmap> {
    let file = File::open(format!("/proc/{process}/fd/{descriptor}"))?;
    let metadata = file.metadata()?;
    if (metadata.dev(), metadata.ino()) != (device, inode) {
        return Err(io::ErrorKind::NotFound.into());
    }
    // SAFETY: nobody writes to the file once others know of it, and it is closed as soon as all have mapped it.
    #[allow(unsafe_code)]
    unsafe {
        Mmap::map(&file)
    }
}
