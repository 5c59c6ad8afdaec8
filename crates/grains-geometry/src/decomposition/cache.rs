//! Decompositions kept on disk: a file for each mesh and set of options.

use super::DecompositionOptions;
use super::pieces::Pieces;
use crate::{TriMesh, Vec3};
use std::path::{Path, PathBuf};
use std::{env, fs, process};

/// First bytes of a file; the number changes with the format and with what a decomposition is.
const MAGIC: &[u8; 16] = b"convex parts 01\n";

/// Folder of the user's caches, if the environment names one.
pub(super) fn folder() -> Option<PathBuf> {
    let named = |key| env::var_os(key).filter(|v| !v.is_empty()).map(PathBuf::from);
    let base = named("XDG_CACHE_HOME").or_else(|| Some(named("HOME")?.join(".cache")))?;
    base.is_absolute().then(|| base.join("grains-mpi"))
}

/// Name of the file of a mesh of unit size: a hash of mesh, options and version.
pub(super) fn file_name(unit: &TriMesh, options: &DecompositionOptions) -> String {
    let mut hash = Hash::new();
    hash.add(MAGIC);
    hash.add(env!("CARGO_PKG_VERSION").as_bytes());
    hash.add(&options.max_parts.to_le_bytes());
    hash.add(&options.resolution.to_le_bytes());
    hash.add(&(unit.vertices.len() as u64).to_le_bytes());
    unit.vertices.iter().flatten().for_each(|x| hash.add(&x.to_le_bytes()));
    unit.triangles.iter().flatten().for_each(|v| hash.add(&v.to_le_bytes()));
    format!("parts-{:032x}.bin", hash.0)
}

/// The pieces of a file; `None` if it is missing or not whole.
pub(super) fn load(path: &Path) -> Option<Pieces> {
    decode(&fs::read(path).ok()?)
}

/// The pieces that [`encode`] made bytes of; `None` of others.
pub(super) fn decode(bytes: &[u8]) -> Option<Pieces> {
    let (content, sum) = bytes.split_last_chunk::<16>()?;
    let body = content.strip_prefix(MAGIC)?;
    if Hash::of(content).0.to_le_bytes() != *sum {
        return None;
    }
    let mut words = body.as_chunks::<8>().0.iter().copied();
    let mut count = || usize::try_from(u64::from_le_bytes(words.next()?)).ok();
    let (found, merged, dropped, hulls) = (count()?, count()?, count()?, count()?);
    let lengths = (0..hulls).map(|_| count()).collect::<Option<Vec<_>>>()?;
    let mut number = || words.next().map(f64::from_le_bytes);
    let mut corner = || Some(Vec3::new(number()?, number()?, number()?));
    let mut hull = |length: usize| (0..length).map(|_| corner()).collect::<Option<Vec<_>>>();
    let hulls = lengths.into_iter().map(&mut hull).collect::<Option<Vec<_>>>()?;
    Some(Pieces { hulls, found, merged, dropped })
}

/// The pieces as the bytes of a file.
pub(super) fn encode(pieces: &Pieces) -> Vec<u8> {
    let counts = [pieces.found, pieces.merged, pieces.dropped, pieces.hulls.len()];
    let lengths = pieces.hulls.iter().map(Vec::len);
    let mut bytes = MAGIC.to_vec();
    bytes.extend(counts.into_iter().chain(lengths).flat_map(|n| (n as u64).to_le_bytes()));
    bytes.extend(pieces.hulls.iter().flatten().flatten().flat_map(|x| x.to_le_bytes()));
    bytes.extend(Hash::of(&bytes).0.to_le_bytes());
    bytes
}

/// Writes the pieces aside and renames the file, so that nobody reads half of it; whoever cannot write
/// computes again.
pub(super) fn store(path: &Path, pieces: &Pieces) {
    let bytes = encode(pieces);
    let aside = path.with_extension(format!("{}.tmp", process::id()));
    let written = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&aside, bytes));
    if written.and_then(|()| fs::rename(&aside, path)).is_err() {
        // Nothing depends on the file but the time the next set-up takes.
        let _ = fs::remove_file(&aside);
    }
}

/// The hash function FNV-1a of 128 bits (Fowler, Noll and Vo).
struct Hash(u128);

impl Hash {
    fn new() -> Self {
        Self(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d)
    }

    fn of(bytes: &[u8]) -> Self {
        let mut hash = Self::new();
        hash.add(bytes);
        hash
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u128::from(*byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_fnv_1a() {
        assert_eq!(Hash::of(b"").0, 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d);
        assert_eq!(Hash::of(b"foobar").0, 0x343e_1662_793c_64bf_6f0d_3597_ba44_6f18);
    }

    #[test]
    fn a_damaged_file_is_not_read() {
        let folder = env::temp_dir().join(format!("grains-parts-{}", process::id()));
        let path = folder.join("a.bin");
        let corners: Vec<Vec3> = (0..5).map(|i| Vec3::new(0.1 * f64::from(i), -1e-300, 1.0 / 3.0)).collect();
        let pieces = Pieces { hulls: vec![corners.clone(), corners], found: 7, merged: 4, dropped: 1 };
        store(&path, &pieces);
        assert_eq!(load(&path), Some(pieces));
        let mut bytes = fs::read(&path).unwrap();
        bytes[60] ^= 1;
        fs::write(&path, &bytes).unwrap();
        assert_eq!(load(&path), None);
        fs::write(&path, &bytes[..40]).unwrap();
        assert_eq!(load(&path), None);
        assert_eq!(load(&folder.join("b.bin")), None);
        fs::remove_dir_all(&folder).unwrap();
        store(Path::new("/proc/no/such/folder/a.bin"), &Pieces::default());
    }
}
