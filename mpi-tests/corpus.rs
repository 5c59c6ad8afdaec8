//! The inputs that the fuzzer has kept, and changes of them, through all that the program reads: no panic, no endless loop, no
//! allocation that only a wrong input asks for. `scripts/fuzz` makes many more.

#![allow(clippy::unwrap_used)]

use grains_inputs::{Folders, LimitedAllocator, TARGETS};
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

#[global_allocator]
static ALLOCATOR: LimitedAllocator = LimitedAllocator;

/// Time for the changed inputs of a target.
const SHARE: Duration = Duration::from_secs(2);
/// Changed inputs of a target at most.
const CHANGED: usize = 2000;
/// No input of some kilobytes may take longer, on a busy machine either.
const LONGEST: Duration = Duration::from_secs(10);

/// Random numbers (Knuth's linear congruences of 64 bits, upper half).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end.max(1)
    }

    /// An input with bytes of another in it, bytes doubled, lost or changed.
    fn changed(&mut self, input: &[u8], other: &[u8]) -> Vec<u8> {
        let mut bytes = input.to_vec();
        for _ in 0..=self.below(4) {
            let begin = self.below(bytes.len() + 1);
            let end = (begin + self.below(16)).min(bytes.len());
            match self.below(4) {
                0 => drop(bytes.drain(begin..end)),
                1 => {
                    let part = bytes[begin..end].to_vec();
                    bytes.splice(begin..begin, part);
                }
                2 => {
                    let from = self.below(other.len() + 1);
                    let part = &other[from..(from + self.below(32)).min(other.len())];
                    bytes.splice(begin..end, part.iter().copied());
                }
                _ => bytes.iter_mut().skip(begin).take(1).for_each(|byte| *byte = self.below(256) as u8),
            }
        }
        bytes
    }
}

#[test]
fn no_kept_or_changed_input_ends_the_program() {
    let folders = Folders::below(Path::new(env!("CARGO_TARGET_TMPDIR"))).unwrap();
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    for (name, target) in TARGETS {
        let mut files: Vec<_> =
            fs::read_dir(corpus.join(name)).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        let inputs: Vec<Vec<u8>> = files.iter().map(|file| fs::read(file).unwrap()).collect();
        let fed = |bytes: &[u8]| {
            let begun = Instant::now();
            let is_accepted = target(bytes, &folders);
            assert!(begun.elapsed() < LONGEST, "{name}: {:?}", String::from_utf8_lossy(bytes));
            is_accepted
        };
        let accepted = inputs.iter().filter(|input| fed(input)).count();
        assert!(accepted > 0 && accepted < inputs.len(), "{name}: {accepted} of {} accepted", inputs.len());
        let (mut random, begun) = (Random(1), Instant::now());
        for _ in (0..CHANGED).take_while(|_| begun.elapsed() < SHARE) {
            let [input, other] = [0; 2].map(|_| &inputs[random.below(inputs.len())]);
            fed(&random.changed(input, other));
        }
    }
    fs::remove_dir_all(&folders.own).unwrap();
}
