//! The target of code: instructions, arithmetic, and the number of states at once.

use robot_dynamics_expression::{Arithmetic, Precision};
use robot_dynamics_number::InstructionSet;

/// The number of states that one run of the code computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Width {
    /// One state, in the lowest lane of each register.
    One,
    /// As many states as a register has lanes; on ARM, as two registers have.
    Lanes,
}

/// Instructions, width and arithmetic of code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target {
    /// The instruction set.
    pub instructions: InstructionSet,
    /// The number of states at once.
    pub width: Width,
    /// The arithmetic of the graph.
    pub arithmetic: Arithmetic,
}

/// The newest instructions of this processor that this crate has an encoder for; [`InstructionSet::Portable`]
/// without such instructions.
///
/// ```
/// let best = robot_dynamics_native::best_instructions();
/// assert!(best.is_available());
/// ```
pub fn best_instructions() -> InstructionSet {
    let has_code = |set: &&InstructionSet| has_encoder(**set) && set.is_available();
    InstructionSet::ALL.iter().rev().find(has_code).copied().unwrap_or(InstructionSet::Portable)
}

/// Whether this crate has an encoder for these instructions.
pub(crate) fn has_encoder(instructions: InstructionSet) -> bool {
    matches!(instructions, InstructionSet::Avx2 | InstructionSet::Avx512 | InstructionSet::Neon)
}

impl Target {
    /// Bytes of a number.
    pub(crate) fn size(self) -> i32 {
        match self.arithmetic.precision {
            Precision::Double => 8,
            Precision::Single => 4,
        }
    }

    /// Bytes of the registers that hold a value's lanes.
    pub(crate) fn register_bytes(self) -> i32 {
        match self.instructions {
            InstructionSet::Avx512 => 64,
            _ => 32,
        }
    }

    /// Bytes of a value: of all lanes in a lane kernel, of one number otherwise.
    pub(crate) fn value_bytes(self) -> i32 {
        match self.width {
            Width::One => self.size(),
            Width::Lanes => self.register_bytes(),
        }
    }

    /// The number of states at once.
    pub(crate) fn lanes(self) -> usize {
        usize::try_from(self.value_bytes() / self.size()).expect("a few lanes")
    }
}
