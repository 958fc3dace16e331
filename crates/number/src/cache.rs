//! What the processor is told of memory.
#![allow(unsafe_code)]

use core::ops::Range;

use crate::Float;

/// Bytes that stay in a core's own cache; a larger table's rows are somewhere else when they are written.
const OWN: usize = 1 << 20;

/// Bytes that may come at a time without driving out what is computed with.
const AT_A_TIME: usize = 24 << 10;

/// Bytes of a line of the cache.
#[cfg(all(target_arch = "x86_64", not(miri)))]
const LINE: usize = 64;

/// Asks for rows of a table that are about to be written, where that helps, so that they come while what goes there is computed. No number is read or changed.
///
/// ```
/// let (mut table, rows) = (vec![0.0; 1 << 20], 1000..2000);
/// number::cache::fetch(&table, rows.clone());
/// let result = (2.0_f64).sqrt(); // what takes time
/// table[rows].fill(result);
/// ```
///
/// # Panics
/// If the rows are not all of the table.
#[inline(always)]
pub fn fetch<T: Float>(table: &[T], rows: Range<usize>) {
    let memory = &table[rows];
    if size_of_val(table) <= OWN || size_of_val(memory) > AT_A_TIME {
        return;
    }
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    for line in memory.chunks(LINE / size_of::<T>()) {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 has the instruction, which is a hint about an address, and this one is of a slice.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(line.as_ptr().cast()) };
    }
}

#[cfg(test)]
mod tests {
    use super::{AT_A_TIME, OWN, fetch};

    /// Small tables and large ones, few rows and many, at any place.
    #[test]
    fn nothing_changes() {
        // An interpreter fetches nothing, and takes half a minute for the large table.
        let large = if cfg!(miri) { 100 } else { OWN / 8 + 100 };
        for size in [0, 1, 7, large] {
            let table: Vec<f64> = (0..size).map(|k| k as f64).collect();
            for rows in [0..0, 0..size, size / 3..size / 2, 0..size.min(AT_A_TIME / 8)] {
                fetch(&table, rows);
            }
            assert!(table.iter().enumerate().all(|(k, &x)| x == k as f64));
        }
    }

    #[test]
    #[should_panic(expected = "out of range")]
    fn rows_are_of_the_table() {
        fetch(&[0.0; 3], 2..4);
    }
}
