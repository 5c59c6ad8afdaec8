//! Items of arrays that are asked for before they are needed.

/// Asks the memory for an item that will soon be needed; nothing happens if there is none.
#[inline(always)]
pub fn prefetch<T>(items: &[T], i: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(item) = items.get(i) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let first = std::ptr::from_ref(item).cast::<i8>();
        // SAFETY: a prefetch reads nothing; both addresses are of the item.
        #[allow(unsafe_code)]
        unsafe {
            _mm_prefetch(first, _MM_HINT_T0);
            _mm_prefetch(first.add(size_of::<T>() - 1), _MM_HINT_T0);
        }
    }
}
