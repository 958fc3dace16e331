//! Prefetch hints for memory that is written soon.
#![allow(unsafe_code)]

use core::ops::Range;

use crate::Float;

/// Bytes that stay in a core's private cache. Rows of a larger table are elsewhere when they are written.
const PRIVATE_CACHE: usize = 1 << 20;

/// Bytes that one call prefetches at most, so that the working set stays in the cache.
const MOST_BYTES: usize = 24 << 10;

/// Bytes of a cache line.
#[cfg(all(target_arch = "x86_64", not(miri)))]
const LINE: usize = 64;

/// Prefetches rows of a table that are written soon, so that they arrive while their values are computed. No
/// number is read or changed.
///
/// ```
/// let (mut table, rows) = (vec![0.0; 1 << 20], 1000..2000);
/// robot_dynamics_number::cache::fetch(&table, rows.clone());
/// let result = (2.0_f64).sqrt(); // a long computation
/// table[rows].fill(result);
/// ```
///
/// # Panics
/// If the rows are not within the table.
#[inline(always)]
pub fn fetch<T: Float>(table: &[T], rows: Range<usize>) {
    let memory = &table[rows];
    if size_of_val(table) <= PRIVATE_CACHE || size_of_val(memory) > MOST_BYTES {
        return;
    }
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    for line in memory.chunks(LINE / size_of::<T>()) {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 processor has the instruction. It is a hint about an address, here one within
        // a slice.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(line.as_ptr().cast()) };
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST_BYTES, PRIVATE_CACHE, fetch};

    /// Small and large tables, few and many rows, at any offset.
    #[test]
    fn prefetching_changes_no_number() {
        // Miri prefetches nothing and takes half a minute for the large table.
        let large = if cfg!(miri) { 100 } else { PRIVATE_CACHE / 8 + 100 };
        for size in [0, 1, 7, large] {
            let table: Vec<f64> = (0..size).map(|k| k as f64).collect();
            for rows in [0..0, 0..size, size / 3..size / 2, 0..size.min(MOST_BYTES / 8)] {
                fetch(&table, rows);
            }
            assert!(table.iter().enumerate().all(|(k, &x)| x == k as f64));
        }
    }

    #[test]
    #[should_panic(expected = "out of range")]
    fn rows_outside_the_table_panic() {
        fetch(&[0.0; 3], 2..4);
    }
}
