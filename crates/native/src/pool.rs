//! The pool of constants behind the code.

use std::collections::HashMap;

use crate::list::{Address, Base, LoadExtent};

/// Constants, each once, in the order of their first use.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pool {
    pub(crate) bytes: Vec<u8>,
    places: HashMap<(u64, usize), i32>,
}

impl Pool {
    /// A constant of `size` bytes, given by its bits and repeated `count` times.
    pub(crate) fn repeated(&mut self, bits: u64, size: usize, count: usize, extent: LoadExtent) -> Address {
        let bytes = &mut self.bytes;
        let offset = *self.places.entry((bits, count)).or_insert_with(|| {
            let offset = offset(bytes);
            (0..count).for_each(|_| bytes.extend_from_slice(&bits.to_le_bytes()[..size]));
            offset
        });
        Address::new(Base::Constants, offset, extent)
    }

    /// Adjacent constants, one for each lane.
    pub(crate) fn pattern(&mut self, lanes: impl Iterator<Item = u64>, size: usize) -> Address {
        let offset = offset(&self.bytes);
        lanes.for_each(|bits| self.bytes.extend_from_slice(&bits.to_le_bytes()[..size]));
        Address::new(Base::Constants, offset, LoadExtent::Register)
    }
}

fn offset(bytes: &[u8]) -> i32 {
    i32::try_from(bytes.len()).expect("constants of a graph of fewer than 2²⁴ operations")
}
