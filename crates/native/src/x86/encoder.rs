//! The state of the encoder: the code so far, and the lanes that instructions work on.

use robot_dynamics_number::InstructionSet;

use crate::target::{Target, Width};

/// The lanes of a register that instructions work on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lanes {
    Lowest,
    /// All of 256 bits.
    Half,
    /// All of 512 bits.
    All,
}

impl Lanes {
    /// The lanes of a target.
    pub(super) fn of(target: Target) -> Self {
        match (target.width, target.instructions) {
            (Width::One, _) => Self::Lowest,
            (Width::Lanes, InstructionSet::Avx512) => Self::All,
            (Width::Lanes, _) => Self::Half,
        }
    }

    /// The length field of a prefix.
    pub(super) fn length(self) -> u8 {
        match self {
            Self::Lowest => 0,
            Self::Half => 1,
            Self::All => 2,
        }
    }
}

/// The state of the encoder.
#[derive(Clone, Debug)]
pub(super) struct Encoder {
    pub(super) code: Vec<u8>,
    pub(super) lanes: Lanes,
    pub(super) is_double: bool,
    pub(super) has_evex: bool,
    /// The position behind the distance to the constants, which is known at the end.
    pub(super) constants: usize,
    pub(super) changes_upper_halves: bool,
}

impl Encoder {
    /// An encoder for this target with room for this number of instructions.
    pub(super) fn new(target: Target, steps: usize) -> Self {
        Self {
            code: Vec::with_capacity(8 * steps + 64),
            lanes: Lanes::Lowest,
            is_double: target.size() == 8,
            has_evex: target.instructions == InstructionSet::Avx512,
            constants: 0,
            changes_upper_halves: false,
        }
    }

    /// The bytes of one number.
    pub(super) fn number_bytes(&self) -> i32 {
        if self.is_double { 8 } else { 4 }
    }
}
