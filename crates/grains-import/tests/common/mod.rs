//! Folders, random numbers and imports for tests.

#![allow(dead_code)] // each test program uses its own part

use grains_case::Case;
use grains_import::{Imported, Options, import};
use std::fs;
use std::path::{Path, PathBuf};

/// An empty folder of this name.
pub fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

/// A script of a folder, imported to its folder `case`.
pub fn imported(home: &Path, script: &str) -> (Case, Imported) {
    let path = home.join("in.script");
    fs::write(&path, script).unwrap();
    let done = import(&[path], &home.join("case"), &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    (Case::load(home.join("case/case.toml")).unwrap(), done)
}

/// Random numbers (Knuth's linear congruences of 64 bits, upper half).
pub struct Random(pub u64);

impl Random {
    /// One between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 32) as f64 / f64::from(u32::MAX)
    }

    /// One whose logarithm is even between those of two numbers.
    pub fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// A vector in a cube about the origin.
    pub fn vector(&mut self, half: f64) -> [f64; 3] {
        [0; 3].map(|_| self.between(-half, half))
    }
}
