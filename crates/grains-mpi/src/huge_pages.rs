//! Memory in huge pages, of 2 MB instead of 4 kB: the processor keeps the addresses of far more of it at hand.
//!
//! Where Linux gives them to those that ask, glibc 2.35 and later asks for all that it allocates, if the environment tells it before the
//! program begins. A fluid of 128³ cells takes 0.93 of the time, 100,000 spheres 0.96 (`scaling/README.md`).

use std::os::unix::process::CommandExt;
use std::process::Command;

/// Whether Linux gives huge pages: always, to those that ask, or never.
const MODE: &str = "/sys/kernel/mm/transparent_hugepage/enabled";
/// What is told to glibc.
const TUNABLES: &str = "GLIBC_TUNABLES";
const TUNABLE: &str = "glibc.malloc.hugetlb";

/// Begins the program anew in this process, told to ask for huge pages; where this is of no use or fails, nothing happens.
///
/// To be called before anything is done that would be lost.
pub fn ask() {
    let mode = std::fs::read_to_string(MODE).unwrap_or_default();
    let tunables = std::env::var(TUNABLES).unwrap_or_default();
    let (Some(told), Ok(program)) = (told(&mode, &tunables), std::env::current_exe()) else { return };
    let mut words = std::env::args_os();
    let mut anew = Command::new(program);
    if let Some(name) = words.next() {
        anew.arg0(name);
    }
    let _ = anew.args(words).env(TUNABLES, told).exec();
}

/// The tunables that ask for huge pages, if there are such for those that ask; none if somebody has chosen already.
fn told(mode: &str, tunables: &str) -> Option<String> {
    if !mode.contains("[madvise]") || tunables.contains(TUNABLE) {
        return None;
    }
    let before = if tunables.is_empty() { String::new() } else { format!("{tunables}:") };
    Some(format!("{before}{TUNABLE}=1"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What was told is not told again: the program begins anew once.
    #[test]
    fn huge_pages_are_asked_for_once_where_that_is_of_use() {
        let asking = "always [madvise] never\n";
        for others in ["", "glibc.malloc.arena_max=1", "glibc.malloc.check=3:glibc.malloc.arena_max=1"] {
            let once = told(asking, others).unwrap();
            assert!(once.starts_with(others) && once.ends_with("glibc.malloc.hugetlb=1"), "{once}");
            assert_eq!(
                once.split(':').filter(|tunable| !tunable.is_empty()).count(),
                1 + others.matches('=').count()
            );
            assert_eq!(told(asking, &once), None);
        }
        assert_eq!(told(asking, "glibc.malloc.hugetlb=0"), None, "the user does not want them");
        for mode in ["[always] madvise never\n", "always madvise [never]\n", ""] {
            assert_eq!(told(mode, ""), None);
        }
    }
}
