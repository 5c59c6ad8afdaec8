//! Memory that a rank holds.

/// Memory of one rank between two rebuilds of its lists (B).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryUse {
    /// Owned particles and clones.
    pub particles: usize,
    /// Pairs, contact history, and the cells of ranks that rebuild their lists apart.
    pub lists: usize,
    /// Messages.
    pub messages: usize,
}

impl MemoryUse {
    /// All of it (B).
    pub fn total(&self) -> usize {
        self.particles + self.lists + self.messages
    }
}

/// Makes room for more items by an eighth where an array is too short: lists of pairs are much of all memory and do not double.
pub(crate) fn make_room<T>(items: &mut Vec<T>, more: usize) {
    if items.capacity() - items.len() < more {
        items.reserve_exact(items.len() / 8 + more.max(64));
    }
}

/// Memory (B) of an array.
pub(crate) fn heap_bytes<T>(items: &Vec<T>) -> usize {
    items.capacity() * size_of::<T>()
}
