//! Where inputs find the files that they name, and where they write.

use std::io;
use std::path::{Path, PathBuf};

/// A folder to read from, whose files are few and small, and one to write to.
#[derive(Clone, Debug)]
pub struct Folders {
    /// Files that inputs may name.
    pub given: PathBuf,
    /// Folder of this process alone.
    pub own: PathBuf,
}

/// A data file of LAMMPS.
const DATA: &str =
    "two spheres\n\n2 atoms\n1 atom types\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\nAtoms # sphere\n
1 1 0.1 2500 0.2 0.5 0.5\n2 1 0.1 2500 0.6 0.5 0.5\n";

impl Folders {
    /// The files that the cases of the tests name, and a folder below `temporary` with files that scripts may name.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn below(temporary: &Path) -> io::Result<Self> {
        let given = Path::new(env!("CARGO_MANIFEST_DIR")).join("../grains-case/tests/data").canonicalize()?;
        let own = temporary.join(format!("grains-inputs-{}", std::process::id()));
        std::fs::create_dir_all(&own)?;
        std::fs::copy(given.join("rock.stl"), own.join("rock.stl"))?;
        std::fs::write(own.join("data.two"), DATA)?;
        Ok(Self { given, own })
    }
}
