//! The numbers of a page: arrays one after the other in one block, deflated, as text.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use serde::Serialize;
use std::io::Write;

/// Where an array lies in the block.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Array {
    /// First byte, a multiple of 4.
    at: usize,
    /// Numbers.
    length: usize,
    /// What they are: `u8`, `u16`, `u32`, `f32`; little-endian.
    kind: &'static str,
}

/// Arrays in the order in which they were added.
#[derive(Debug, Default)]
pub struct Block(Vec<u8>);

impl Block {
    /// Adds bytes.
    pub fn bytes(&mut self, values: &[u8]) -> Array {
        self.add(values.len(), "u8", |all| all.extend_from_slice(values))
    }

    /// Adds whole numbers of 16 bits.
    pub fn shorts(&mut self, values: impl ExactSizeIterator<Item = u16>) -> Array {
        self.add(values.len(), "u16", |all| values.for_each(|x| all.extend(x.to_le_bytes())))
    }

    /// Adds whole numbers of 32 bits.
    pub fn integers(&mut self, values: impl ExactSizeIterator<Item = u32>) -> Array {
        self.add(values.len(), "u32", |all| values.for_each(|x| all.extend(x.to_le_bytes())))
    }

    /// Adds real numbers, stored in 32 bits.
    pub fn reals(&mut self, values: impl ExactSizeIterator<Item = f64>) -> Array {
        self.add(values.len(), "f32", |all| values.for_each(|x| all.extend((x as f32).to_le_bytes())))
    }

    fn add(&mut self, length: usize, kind: &'static str, write: impl FnOnce(&mut Vec<u8>)) -> Array {
        let at = self.0.len();
        write(&mut self.0);
        self.0.resize(self.0.len().next_multiple_of(4), 0);
        Array { at, length, kind }
    }

    /// The deflated block as text.
    pub fn text(&self) -> String {
        let mut encoder = DeflateEncoder::new(Vec::with_capacity(self.0.len() / 2), Compression::fast());
        // Writing to memory does not fail.
        let deflated = encoder.write_all(&self.0).and_then(|()| encoder.finish()).unwrap_or_default();
        STANDARD.encode(deflated)
    }
}
