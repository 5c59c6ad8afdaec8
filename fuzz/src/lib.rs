//! A target of the fuzzer from a function of `grains_inputs`.

pub use grains_inputs::{Folders, LimitedAllocator};
pub use libfuzzer_sys::fuzz_target;
use std::panic::set_hook;
use std::path::PathBuf;

/// Makes a function of `grains_inputs` the target of a program.
#[macro_export]
macro_rules! target {
    ($function:path) => {
        #[global_allocator]
        static ALLOCATOR: $crate::LimitedAllocator = $crate::LimitedAllocator;

        $crate::fuzz_target!(init: $crate::begin(), |bytes: &[u8]| {
            $crate::folders(|folders| _ = $function(bytes, folders));
        });
    };
}

/// Lets panics pass that the program makes errors of; all others end the fuzzer with the input.
pub fn begin() {
    set_hook(Box::new(|info| {
        if !grains_geometry::catches_panics() {
            eprintln!("{info}");
            std::process::abort();
        }
    }));
}

/// Hands the folders of this process to a function.
pub fn folders(f: impl FnOnce(&Folders)) {
    use std::sync::OnceLock;
    static FOLDERS: OnceLock<Folders> = OnceLock::new();
    let temporary = || std::env::var_os("FUZZ_FOLDER").map_or_else(std::env::temp_dir, PathBuf::from);
    f(FOLDERS.get_or_init(|| Folders::below(&temporary()).expect("a folder to write to")));
}
