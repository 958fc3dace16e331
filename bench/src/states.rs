//! Random states in one block of memory, so that a call does not find its inputs in the cache.

use std::fmt;
use std::path::Path;

use robot_dynamics::model::{Model, random_state};
use robot_dynamics_number::SplitMix64;

/// States of one robot: q, v, a and tau, one state after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct StateTable {
    count: usize,
    nq: usize,
    nv: usize,
    tip: usize,
    numbers: Vec<f64>,
}

/// The error of a file without valid states.
#[derive(Debug)]
pub enum StateTableError {
    /// The file cannot be read.
    Unreadable(std::io::Error),
    /// The header gives another number of bytes.
    WrongSize {
        /// Bytes in the file.
        found: usize,
        /// Bytes according to the header.
        expected: usize,
    },
}

impl fmt::Display for StateTableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(cause) => write!(f, "cannot read the states: {cause}"),
            Self::WrongSize { found, expected } => {
                write!(f, "the file of states has {found} bytes, its header announces {expected}")
            }
        }
    }
}

impl std::error::Error for StateTableError {}

/// Count, nq, nv and tip, eight bytes each.
const HEADER: usize = 32;

impl StateTable {
    /// `count` random states, the same for the same seed.
    pub fn random(model: &Model, count: usize, seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let mut numbers = Vec::with_capacity(count * (model.nq() + 3 * model.nv()));
        for _ in 0..count {
            let state = random_state(model, &mut random);
            for part in [state.q, state.v, state.a, state.tau] {
                numbers.extend(part);
            }
        }
        Self { count, nq: model.nq(), nv: model.nv(), tip: model.joints().len() - 1, numbers }
    }

    /// Reads a file: count, nq, nv and tip as 64-bit integers, then each state's q v a tau, little-endian.
    ///
    /// # Errors
    /// [`StateTableError`] with the fault of the file.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, StateTableError> {
        let bytes = std::fs::read(path).map_err(StateTableError::Unreadable)?;
        let words: Vec<u64> = bytes.as_chunks::<8>().0.iter().map(|word| u64::from_le_bytes(*word)).collect();
        let wrong_size = |expected| StateTableError::WrongSize { found: bytes.len(), expected };
        let header = words.first_chunk::<4>().ok_or(wrong_size(HEADER))?;
        let [count, nq, nv, tip] = header.map(|word| usize::try_from(word).unwrap_or(usize::MAX));
        let stride = nv.saturating_mul(3).saturating_add(nq);
        let expected = count.saturating_mul(stride).saturating_mul(8).saturating_add(HEADER);
        if expected != bytes.len() {
            return Err(wrong_size(expected));
        }
        let numbers = words[HEADER / 8..].iter().map(|word| f64::from_bits(*word)).collect();
        Ok(Self { count, nq, nv, tip, numbers })
    }

    /// The first states, at most all.
    pub fn first(&self, count: usize) -> Self {
        let count = count.min(self.count);
        let numbers = self.numbers[..count * (self.nq + 3 * self.nv)].to_vec();
        Self { count, numbers, ..*self }
    }

    /// The number of states.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Entries of q and of v.
    pub fn dimensions(&self) -> (usize, usize) {
        (self.nq, self.nv)
    }

    /// The joint whose link's Jacobian is requested: its index among the model's moving joints, not counting
    /// the base.
    pub fn tip(&self) -> usize {
        self.tip
    }

    /// (q, v, a, tau) of a state.
    ///
    /// Panics if there is no such state.
    /// If there is no such state.
    #[inline]
    pub fn get(&self, state: usize) -> [&[f64]; 4] {
        let stride = self.nq + 3 * self.nv;
        let (q, rest) = self.numbers[state * stride..(state + 1) * stride].split_at(self.nq);
        let (v, rest) = rest.split_at(self.nv);
        let (a, tau) = rest.split_at(self.nv);
        [q, v, a, tau]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot_by_name;

    /// A table survives a round trip through a file; a truncated file is rejected with both sizes.
    #[test]
    fn reads_what_the_format_says() {
        let model = robot_by_name("two_r").expect("two_r");
        let table = StateTable { tip: 1, ..StateTable::random(&model, 3, 1) };
        let mut bytes: Vec<u8> = [3_u64, 2, 2, 1].into_iter().flat_map(u64::to_le_bytes).collect();
        bytes.extend(table.numbers.iter().flat_map(|x| x.to_le_bytes()));
        let path = std::env::temp_dir().join(format!("state_table_{}.bin", std::process::id()));
        std::fs::write(&path, &bytes).expect("a writable folder");
        assert_eq!(StateTable::read(&path).expect("a table"), table);
        std::fs::write(&path, &bytes[..bytes.len() - 8]).expect("a writable folder");
        let refused = StateTable::read(&path).expect_err("cut short").to_string();
        assert!(refused.contains("216 bytes") && refused.contains("224"), "{refused}");
        std::fs::remove_file(path).expect("the file just written");
    }
}
