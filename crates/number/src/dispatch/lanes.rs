//! Memory and kernels for several states at once.

use core::fmt;

use super::{Call, Hardware, Portable, Storage};
#[cfg(registers)]
use crate::registers::{F32x8, F64x4};
#[cfg(target_arch = "x86_64")]
use crate::registers::{F32x16, F64x8};
use crate::{InstructionSet, Scalar, StateLanes};

/// A computation on memory over a register of states of `T`.
pub trait LaneKernel<M: Storage, T: Scalar> {
    /// Runs the computation; must be `#[inline(always)]`.
    fn run<N: StateLanes<Float = T>, H: Hardware>(self, memory: &mut M::Over<N>);
}

/// Memory over as many states as a register of this machine holds, or over one state where it has no
/// registers.
pub struct LaneMemory<M: Storage>(pub(crate) LaneVariants<M>);

/// Variants with registers exist only on machines that have them.
pub(crate) enum LaneVariants<M: Storage> {
    F64(Box<M::Over<f64>>),
    F32(Box<M::Over<f32>>),
    #[cfg(registers)]
    F64x4(Box<M::Over<F64x4>>),
    #[cfg(registers)]
    F32x8(Box<M::Over<F32x8>>),
    #[cfg(target_arch = "x86_64")]
    F64x8(Box<M::Over<F64x8>>),
    #[cfg(target_arch = "x86_64")]
    F32x16(Box<M::Over<F32x16>>),
}

impl<M: Storage> LaneMemory<M> {
    /// The instructions that kernels run on.
    pub fn instruction_set(&self) -> InstructionSet {
        match &self.0 {
            LaneVariants::F64(_) | LaneVariants::F32(_) => InstructionSet::Portable,
            #[cfg(target_arch = "x86_64")]
            LaneVariants::F64x4(_) | LaneVariants::F32x8(_) => InstructionSet::Avx2,
            #[cfg(target_arch = "aarch64")]
            LaneVariants::F64x4(_) | LaneVariants::F32x8(_) => InstructionSet::Neon,
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            LaneVariants::F64x4(_) | LaneVariants::F32x8(_) => InstructionSet::Simd128,
            #[cfg(target_arch = "x86_64")]
            LaneVariants::F64x8(_) | LaneVariants::F32x16(_) => InstructionSet::Avx512,
        }
    }

    /// The number of states.
    pub fn lanes(&self) -> usize {
        match &self.0 {
            LaneVariants::F64(_) | LaneVariants::F32(_) => 1,
            #[cfg(registers)]
            LaneVariants::F64x4(_) => F64x4::LANES,
            #[cfg(registers)]
            LaneVariants::F32x8(_) => F32x8::LANES,
            #[cfg(target_arch = "x86_64")]
            LaneVariants::F64x8(_) => F64x8::LANES,
            #[cfg(target_arch = "x86_64")]
            LaneVariants::F32x16(_) => F32x16::LANES,
        }
    }
}

impl<M: Storage> fmt::Debug for LaneMemory<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LaneMemory").field("instructions", &self.instruction_set()).finish_non_exhaustive()
    }
}

/// A kernel and its memory.
struct LaneCall<'a, M: Storage, N: StateLanes, K> {
    kernel: K,
    memory: &'a mut M::Over<N>,
}

impl<M: Storage, N: StateLanes, K: LaneKernel<M, N::Float>> Call for LaneCall<'_, M, N, K> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        self.kernel.run::<N, H>(self.memory);
    }
}

/// Runs a kernel over one number at a time.
#[inline(always)]
pub(crate) fn run_portable<M: Storage, T: StateLanes<Float = T>>(
    memory: &mut M::Over<T>,
    kernel: impl LaneKernel<M, T>,
) {
    Portable::call(LaneCall::<M, T, _> { kernel, memory });
}

/// Runs a kernel over registers of AVX2, of NEON, or of simd128.
///
/// # Safety
/// The machine has those instructions.
#[cfg(registers)]
#[inline(always)]
pub(crate) unsafe fn run_narrow<M: Storage, N: StateLanes>(
    memory: &mut M::Over<N>,
    kernel: impl LaneKernel<M, N::Float>,
) {
    let call = LaneCall::<M, N, _> { kernel, memory };
    #[cfg(target_arch = "x86_64")]
    // SAFETY: as the caller guarantees.
    unsafe {
        super::with_avx2_fma(call);
    }
    #[cfg(not(target_arch = "x86_64"))]
    super::as_function(call);
}

/// Runs a kernel over registers of AVX-512.
///
/// # Safety
/// The machine has those instructions.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(crate) unsafe fn run_wide<M: Storage, N: StateLanes>(
    memory: &mut M::Over<N>,
    kernel: impl LaneKernel<M, N::Float>,
) {
    // SAFETY: as the caller guarantees.
    unsafe { super::with_avx512(LaneCall::<M, N, _> { kernel, memory }) }
}
