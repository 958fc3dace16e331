//! A multiplicative hash of operations.
//!
//! A trace looks up each of its operations, which consist of a few small numbers. The standard library's
//! hash, which resists chosen keys, would take half of its time.

use core::hash::{BuildHasherDefault, Hasher};
use std::collections::HashMap;

/// A map with this hash.
pub(crate) type Map<K, V> = HashMap<K, V, BuildHasherDefault<MultiplicativeHasher>>;

/// The fraction of the golden ratio, an odd number with as many ones as zeros. Its multiples are spread
/// evenly (D. E. Knuth, *The Art of Computer Programming*, volume 3, section 6.4).
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// Each word is mixed with the state and multiplied; both halves of the product are kept.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MultiplicativeHasher(u64);

impl MultiplicativeHasher {
    fn mix(&mut self, word: u64) {
        let product = u128::from(self.0.rotate_left(23) ^ word ^ GOLDEN) * u128::from(GOLDEN);
        #[allow(clippy::cast_possible_truncation)] // the halves
        let (low, high) = (product as u64, (product >> 64) as u64);
        self.0 = low ^ high;
    }
}

impl Hasher for MultiplicativeHasher {
    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.mix(u64::from_le_bytes(word));
        }
    }
    fn write_u32(&mut self, word: u32) {
        self.mix(word.into());
    }
    fn write_u64(&mut self, word: u64) {
        self.mix(word);
    }
    fn write_usize(&mut self, word: usize) {
        self.mix(word as u64);
    }
    /// Hashes the discriminant of a variant.
    fn write_isize(&mut self, word: isize) {
        self.mix(word.cast_unsigned() as u64);
    }
    fn finish(&self) -> u64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use core::hash::BuildHasher;
    use std::collections::HashSet;

    use super::*;
    use crate::graph::{Operand, Operation};

    /// Hashes of all operations of small numbers are distinct: 64-bit hashes of 10⁶ keys collide with a
    /// probability of 10¹² / 2 / 2⁶⁴. The map uses the lowest 20 bits and the 7 highest. Each of them is set
    /// in half of the hashes, to eight standard deviations of a fair coin.
    #[test]
    fn hashes_of_operations_are_spread() {
        let build = BuildHasherDefault::<MultiplicativeHasher>::default();
        let mut hashes = HashSet::new();
        let mut set = [0_u32; 64];
        let numbers = || {
            (0..300_u32).flat_map(|node| {
                [Operand::Plus(node), Operand::Minus(node), Operand::constant(f64::from(node))]
            })
        };
        let mut count = 0_u32;
        for a in numbers() {
            for b in numbers() {
                for operation in [Operation::Sum(a, b), Operation::Product(a, b)] {
                    let hash = build.hash_one(operation);
                    assert!(hashes.insert(hash), "{operation:?} has the hash of another operation");
                    (0..64).for_each(|bit| set[bit] += u32::from(hash >> bit & 1 == 1));
                    count += 1;
                }
            }
        }
        let (half, deviation) = (f64::from(count) / 2.0, f64::from(count).sqrt() / 2.0);
        for bit in (0..20).chain(57..64) {
            assert!(
                (f64::from(set[bit]) - half).abs() < 8.0 * deviation,
                "bit {bit}: {} of {count}",
                set[bit]
            );
        }
    }
}
