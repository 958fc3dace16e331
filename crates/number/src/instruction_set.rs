//! The machine instructions that an algorithm runs on.

use core::fmt;

/// The machine instructions that algorithms run on, chosen when their memory is allocated.
///
/// Results of [`Portable`](Self::Portable) differ from those of the others by rounding. Only the others have
/// the project's own sine and cosine and, except [`Simd128`](Self::Simd128), a multiply-add that rounds once.
/// [`Avx2`](Self::Avx2) and [`Avx512`](Self::Avx512) give the same bits.
///
/// ```
/// use robot_dynamics_number::InstructionSet;
/// assert!(InstructionSet::Portable.is_available());
/// println!("this machine: {}", InstructionSet::best());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum InstructionSet {
    /// The instructions of the oldest machine that the program was built for.
    Portable,
    /// AVX2 and FMA of x86-64: 256-bit registers, fused multiply-add.
    Avx2,
    /// AVX-512 (F, VL and DQ) of x86-64: 512-bit registers, for batches and for derivatives.
    Avx512,
    /// NEON of 64-bit ARM: 128-bit registers in pairs, fused multiply-add. Every 64-bit ARM processor has it.
    Neon,
    /// simd128 of WebAssembly: 128-bit registers in pairs, no fused multiply-add. The module is compiled with
    /// it or without.
    Simd128,
}

impl InstructionSet {
    /// All sets that the library has code for on this architecture, oldest first.
    #[cfg(target_arch = "x86_64")]
    pub const ALL: &[Self] = &[Self::Portable, Self::Avx2, Self::Avx512];
    /// All sets that the library has code for on this architecture, oldest first.
    #[cfg(target_arch = "aarch64")]
    pub const ALL: &[Self] = &[Self::Portable, Self::Neon];
    /// All sets that the library has code for on this architecture, oldest first.
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    pub const ALL: &[Self] = &[Self::Portable, Self::Simd128];
    /// All sets that the library has code for on this architecture, oldest first.
    #[cfg(not(registers))]
    pub const ALL: &[Self] = &[Self::Portable];

    /// Whether this machine has the instructions and the library has code for them.
    pub fn is_available(self) -> bool {
        match self {
            Self::Portable => true,
            Self::Neon => cfg!(target_arch = "aarch64"),
            Self::Simd128 => cfg!(all(target_arch = "wasm32", target_feature = "simd128")),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.is_available()
                    && std::is_x86_feature_detected!("avx512f")
                    && std::is_x86_feature_detected!("avx512vl")
                    && std::is_x86_feature_detected!("avx512dq")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// The newest set that this machine has.
    pub fn best() -> Self {
        Self::best_up_to(Self::Simd128)
    }

    /// The newest set that this machine has and that is not newer than `limit` in the order of the variants.
    pub fn best_up_to(limit: Self) -> Self {
        let found = Self::ALL.iter().rev().find(|set| **set <= limit && set.is_available());
        *found.unwrap_or(&Self::Portable)
    }

    /// Whether this machine has registers that the library has code for.
    #[cfg(all(test, registers))]
    pub(crate) fn has_registers() -> bool {
        Self::best() != Self::Portable
    }
}

impl fmt::Display for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Portable => "portable",
            Self::Avx2 => "AVX2 and FMA",
            Self::Avx512 => "AVX-512",
            Self::Neon => "NEON",
            Self::Simd128 => "simd128",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_set_respects_the_limit() {
        assert_eq!(InstructionSet::best_up_to(InstructionSet::Portable), InstructionSet::Portable);
        for &limit in InstructionSet::ALL {
            let best = InstructionSet::best_up_to(limit);
            assert!(best <= limit && best.is_available(), "{best} for {limit}");
        }
    }
}
