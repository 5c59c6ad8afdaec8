//! Arrays that are read alone, in memory of their own or in memory that the processes of a node share.

use bytemuck::{AnyBitPattern, NoUninit};
use memmap2::Mmap;
use std::any::Any;
use std::ops::Deref;
use std::sync::Arc;

/// Bytes at multiples of which arrays begin in shared memory.
const ALIGNMENT: usize = 8;

/// An array that is read alone.
pub(crate) struct Table<T> {
    values: *const [T],
    /// Where they are.
    memory: Arc<dyn Any + Send + Sync>,
}

impl<T: Send + Sync + 'static> From<Vec<T>> for Table<T> {
    fn from(values: Vec<T>) -> Self {
        let memory = Arc::new(values);
        Self { values: memory.as_slice(), memory }
    }
}

impl<T: Send + Sync + 'static> Default for Table<T> {
    fn default() -> Self {
        Vec::new().into()
    }
}

impl<T> Clone for Table<T> {
    fn clone(&self) -> Self {
        Self { values: self.values, memory: Arc::clone(&self.memory) }
    }
}

impl<T> Deref for Table<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: the values lie in `memory`, a vector or a mapping that nothing changes and that is kept as long as this is.
        #[allow(unsafe_code)]
        unsafe {
            &*self.values
        }
    }
}

impl<T: std::fmt::Debug> std::fmt::Debug for Table<T> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        self.deref().fmt(formatter)
    }
}

// SAFETY: a table is a shared reference to values that are kept by a reference-counted owner, itself `Send` and `Sync`.
#[allow(unsafe_code)]
unsafe impl<T: Sync> Send for Table<T> {}
// SAFETY: as above.
#[allow(unsafe_code)]
unsafe impl<T: Sync> Sync for Table<T> {}

/// Appends an array to bytes that [`TableReader`] reads.
pub(crate) fn write_table<T: NoUninit>(values: &[T], bytes: &mut Vec<u8>) {
    const { assert!(align_of::<T>() <= ALIGNMENT) };
    let values: &[u8] = bytemuck::cast_slice(values);
    bytes.extend((values.len() as u64).to_ne_bytes());
    bytes.extend(values);
    bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
}

/// Reads arrays of shared memory in the order in which they were written.
pub(crate) struct TableReader<'a> {
    memory: &'a Arc<Mmap>,
    at: usize,
}

impl<'a> TableReader<'a> {
    pub fn new(memory: &'a Arc<Mmap>) -> Self {
        Self { memory, at: 0 }
    }

    /// The next array, where it lies; none if it is not one of these values.
    pub fn next<T: AnyBitPattern + Send + Sync>(&mut self) -> Option<Table<T>> {
        let length = self.memory.get(self.at..self.at + 8)?;
        let begin = self.at + 8;
        let end = begin.checked_add(u64::from_ne_bytes(length.try_into().ok()?) as usize)?;
        let values: &[T] = bytemuck::try_cast_slice(self.memory.get(begin..end)?).ok()?;
        self.at = end.next_multiple_of(ALIGNMENT);
        Some(Table { values, memory: Arc::clone(self.memory) as Arc<dyn Any + Send + Sync> })
    }
}
