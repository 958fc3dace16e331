//! Which machine instructions an algorithm runs on.

use core::fmt;

/// The machine instructions that the algorithms run on: chosen when a workspace is made.
///
/// Results differ by rounding between [`Portable`](Self::Portable) and the others, as only those have a multiply-add
/// that rounds once and the project's own sine and cosine. [`Avx2`](Self::Avx2) and [`Avx512`](Self::Avx512)
/// give the same bits.
///
/// ```
/// use multibody::{InstructionSet, Model, RandomRobotOptions, Workspace, random_robot};
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// assert_eq!(Workspace::<f64>::portable(&model).instruction_set(), InstructionSet::Portable);
/// println!("one state: {}", Workspace::<f64>::new(&model).instruction_set());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum InstructionSet {
    /// Those of the oldest machine that the program was built for.
    Portable,
    /// AVX2 and FMA: 256-bit registers, fused multiply-add.
    Avx2,
    /// AVX-512 (F, VL and DQ): 512-bit registers, for batches and for derivatives.
    Avx512,
}

impl InstructionSet {
    /// All, from the oldest.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// Whether this machine has it, and the project code for it.
    pub fn is_available(self) -> bool {
        #[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
        {
            let avx2 = || std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma");
            match self {
                Self::Portable => true,
                Self::Avx2 => avx2(),
                Self::Avx512 => {
                    avx2()
                        && std::is_x86_feature_detected!("avx512f")
                        && std::is_x86_feature_detected!("avx512vl")
                        && std::is_x86_feature_detected!("avx512dq")
                }
            }
        }
        #[cfg(not(any(target_arch = "x86_64", target_arch = "x86")))]
        {
            self == Self::Portable
        }
    }
}

impl fmt::Display for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Portable => "portable",
            Self::Avx2 => "AVX2 and FMA",
            Self::Avx512 => "AVX-512",
        })
    }
}
