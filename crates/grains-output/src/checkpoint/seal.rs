//! The first bytes of a checkpoint: what it is, and the checksum of all that follows.
//!
//! ```text
//! grains-mpi checkpoint
//! format 3
//! bytes 81920
//! checksum 0123456789abcdef
//! ```
//!
//! HDF5 calls these bytes the user block, and leaves them alone. They are filled up with NUL. The checksum is that of [`checksum`] over the
//! bytes behind the block, taken as words of eight, little end first, the last filled up with NUL: ranks add up their shares.
//! It is compared before HDF5 opens the file, so that HDF5 meets no damaged one.

use super::{FORMAT, checksum};
use crate::error::{FileError, Shared, agree};
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// Bytes of the block, the smallest that HDF5 allows.
pub(super) const BLOCK: u64 = 512;
/// Bytes of a word.
const WORD: u64 = 8;
/// Bytes read at once.
const BUFFER: u64 = 1 << 20;
/// First bytes of a file of HDF5 without a block: one of an earlier format.
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";

/// The block of a file.
fn block(bytes: u64, checksum: u64) -> [u8; BLOCK as usize] {
    let text = format!("grains-mpi checkpoint\nformat {FORMAT}\nbytes {bytes}\nchecksum {checksum:016x}\n");
    let mut block = [0; BLOCK as usize];
    block[..text.len()].copy_from_slice(text.as_bytes());
    block
}

/// Bytes behind the block, and the checksum of the share of this rank of them.
fn share(path: &Path, (rank, size): (u64, u64)) -> io::Result<(u64, u64)> {
    let mut file = File::open(path)?;
    let bytes = file.metadata()?.len().saturating_sub(BLOCK);
    let words = bytes.div_ceil(WORD);
    let (first, end) = (words * rank / size, words * (rank + 1) / size);
    file.seek(SeekFrom::Start(BLOCK + WORD * first))?;
    let (mut sum, mut word, mut buffer) = (0_u64, first, Vec::new());
    while word < end {
        buffer.clear();
        let wanted = BUFFER.min(WORD * (end - word));
        (&mut file).take(wanted).read_to_end(&mut buffer)?;
        buffer.resize(buffer.len().next_multiple_of(WORD as usize), 0);
        if buffer.is_empty() {
            break;
        }
        let words = buffer
            .chunks_exact(WORD as usize)
            .map(|word| word.iter().rev().fold(0_u64, |value, &byte| (value << 8) | u64::from(byte)));
        sum = sum.wrapping_add(checksum(word as usize, words));
        word += buffer.len() as u64 / WORD;
    }
    Ok((bytes, sum))
}

/// Bytes behind the block, and their checksum; all ranks take part.
fn sum_up(
    path: &Path,
    communicator: &SimpleCommunicator,
    failed: impl FnOnce(io::Error) -> FileError,
) -> Result<(u64, u64), FileError> {
    let own = share(path, (communicator.rank() as u64, communicator.size() as u64)).map_err(failed);
    let (bytes, own) = agree(communicator, own)?;
    let mut all = 0_u64;
    communicator.all_reduce_into(&own, &mut all, SystemOperation::sum());
    Ok((bytes, all))
}

/// Writes the block of a file that is complete; all ranks take part.
///
/// # Errors
/// A file that cannot be read again, or a full disk.
pub(super) fn seal(shared: &Shared) -> Result<(), FileError> {
    let path = &shared.path;
    let failed = |e: io::Error| FileError::new(path, format!("{}: {e}", super::dataset::FAILED));
    let (bytes, sum) = sum_up(path, &shared.communicator, failed)?;
    shared.first(|| {
        let mut file = OpenOptions::new().write(true).open(path).map_err(failed)?;
        file.write_all(&block(bytes, sum)).map_err(failed)
    })
}

/// Compares a file with its block; all ranks take part.
///
/// # Errors
/// What differs, as `refuse` words it.
pub(super) fn verify(
    path: &Path,
    communicator: &SimpleCommunicator,
    refuse: impl Fn(String) -> FileError,
) -> Result<(), FileError> {
    let (bytes, sum) = sum_up(path, communicator, |e| refuse(e.to_string()))?;
    let verdict = first_bytes(path).and_then(|found| compare(&found, bytes, sum));
    agree(communicator, verdict.map_err(refuse))
}

fn first_bytes(path: &Path) -> Result<Vec<u8>, String> {
    let mut found = Vec::new();
    let file = File::open(path).map_err(|e| e.to_string())?;
    file.take(BLOCK).read_to_end(&mut found).map_err(|e| e.to_string())?;
    Ok(found)
}

/// Compares the block found with that of the bytes found.
fn compare(found: &[u8], bytes: u64, sum: u64) -> Result<(), String> {
    if found == block(bytes, sum) {
        return Ok(());
    }
    if found.starts_with(HDF5) {
        return Err(format!("its format is of an earlier version, this program reads {FORMAT}"));
    }
    let text = String::from_utf8_lossy(found);
    let value = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(' '));
    match (value("format"), value("bytes").and_then(|n| n.parse::<u64>().ok())) {
        (Some(format), _) if format != FORMAT.to_string() => {
            Err(format!("its format is {format}, this program reads {FORMAT}"))
        }
        (Some(_), Some(wanted)) if wanted != bytes => {
            let whole = wanted.saturating_add(BLOCK);
            Err(format!("it has {} bytes of {whole}: it is truncated or damaged", bytes + found.len() as u64))
        }
        (Some(_), Some(_)) => Err("its checksum is wrong: it is damaged".into()),
        _ => Err("it is no checkpoint, or its first bytes are damaged".into()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{BLOCK, block, compare, first_bytes, share};
    use std::fs;

    #[test]
    fn the_checksum_of_a_file_does_not_depend_on_the_shares() {
        let path = std::env::temp_dir().join(format!("grains-seal-{}", std::process::id()));
        for bytes in [0, 1, 7, 8, 9, 64, 1001, 3_000_001] {
            let content: Vec<u8> = (0..BLOCK + bytes).map(|k| (k * k % 251) as u8).collect();
            fs::write(&path, &content).unwrap();
            let whole = share(&path, (0, 1)).unwrap();
            assert_eq!(whole.0, bytes);
            for size in [2, 3, 64] {
                let parts = (0..size).map(|rank| share(&path, (rank, size)).unwrap().1);
                assert_eq!(whole.1, parts.fold(0, u64::wrapping_add), "{bytes} bytes on {size} ranks");
            }
        }
        fs::remove_file(&path).unwrap();
    }

    #[test]
    fn every_flipped_bit_and_every_truncation_is_told() {
        let path = std::env::temp_dir().join(format!("grains-flips-{}", std::process::id()));
        let verdict = |content: &[u8]| {
            fs::write(&path, content).unwrap();
            let (bytes, sum) = share(&path, (0, 1)).unwrap();
            compare(&first_bytes(&path).unwrap(), bytes, sum)
        };
        let mut content: Vec<u8> = (0..BLOCK + 205).map(|k| (k * k % 251) as u8).collect();
        fs::write(&path, &content).unwrap();
        let (bytes, sum) = share(&path, (0, 1)).unwrap();
        content[..BLOCK as usize].copy_from_slice(&block(bytes, sum));
        assert_eq!(verdict(&content), Ok(()));
        for bit in 0..8 * content.len() {
            let mut damaged = content.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(verdict(&damaged).is_err(), "bit {bit}");
        }
        for length in 0..content.len() {
            assert!(verdict(&content[..length]).is_err(), "{length} bytes");
        }
        content.push(0);
        assert!(verdict(&content).unwrap_err().contains("bytes"));
        fs::remove_file(&path).unwrap();
    }
}
