//! Memory and kernels for several states at once.

use core::fmt;

use super::{Call, Hardware, Portable};
#[cfg(registers)]
use crate::registers::{F32x8, F64x4};
#[cfg(target_arch = "x86_64")]
use crate::registers::{F32x16, F64x8};
use crate::{Form, InstructionSet, Scalar, StateLanes};

/// A computation on memory over a register of states of `T`.
pub trait LaneKernel<F: Form, T: Scalar> {
    /// Runs the computation; must be `#[inline(always)]`.
    fn run<N: StateLanes<Float = T>, H: Hardware>(self, memory: &mut F::Over<N>);
}

/// Memory over as many states as a register of this machine holds, or over one state where it has no
/// registers.
pub struct LaneMemory<F: Form>(pub(crate) Memory<F>);

/// Variants with registers exist only on machines that have them.
pub(crate) enum Memory<F: Form> {
    F64(Box<F::Over<f64>>),
    F32(Box<F::Over<f32>>),
    #[cfg(registers)]
    F64x4(Box<F::Over<F64x4>>),
    #[cfg(registers)]
    F32x8(Box<F::Over<F32x8>>),
    #[cfg(target_arch = "x86_64")]
    F64x8(Box<F::Over<F64x8>>),
    #[cfg(target_arch = "x86_64")]
    F32x16(Box<F::Over<F32x16>>),
}

impl<F: Form> LaneMemory<F> {
    /// The instructions that kernels run on.
    pub fn instruction_set(&self) -> InstructionSet {
        match &self.0 {
            Memory::F64(_) | Memory::F32(_) => InstructionSet::Portable,
            #[cfg(target_arch = "x86_64")]
            Memory::F64x4(_) | Memory::F32x8(_) => InstructionSet::Avx2,
            #[cfg(target_arch = "aarch64")]
            Memory::F64x4(_) | Memory::F32x8(_) => InstructionSet::Neon,
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Memory::F64x4(_) | Memory::F32x8(_) => InstructionSet::Simd128,
            #[cfg(target_arch = "x86_64")]
            Memory::F64x8(_) | Memory::F32x16(_) => InstructionSet::Avx512,
        }
    }

    /// The number of states.
    pub fn lanes(&self) -> usize {
        match &self.0 {
            Memory::F64(_) | Memory::F32(_) => 1,
            #[cfg(registers)]
            Memory::F64x4(_) => F64x4::LANES,
            #[cfg(registers)]
            Memory::F32x8(_) => F32x8::LANES,
            #[cfg(target_arch = "x86_64")]
            Memory::F64x8(_) => F64x8::LANES,
            #[cfg(target_arch = "x86_64")]
            Memory::F32x16(_) => F32x16::LANES,
        }
    }
}

impl<F: Form> fmt::Debug for LaneMemory<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LaneMemory").field("instructions", &self.instruction_set()).finish_non_exhaustive()
    }
}

/// A kernel and its memory.
struct LaneCall<'a, F: Form, N: StateLanes, K> {
    kernel: K,
    memory: &'a mut F::Over<N>,
}

impl<F: Form, N: StateLanes, K: LaneKernel<F, N::Float>> Call for LaneCall<'_, F, N, K> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        self.kernel.run::<N, H>(self.memory);
    }
}

/// Runs a kernel over one number at a time.
#[inline(always)]
pub(crate) fn run_portable<F: Form, T: StateLanes<Float = T>>(
    memory: &mut F::Over<T>,
    kernel: impl LaneKernel<F, T>,
) {
    Portable::call(LaneCall::<F, T, _> { kernel, memory });
}

/// Runs a kernel over registers of AVX2, of NEON, or of simd128.
///
/// # Safety
/// The machine has those instructions.
#[cfg(registers)]
#[inline(always)]
pub(crate) unsafe fn run_narrow<F: Form, N: StateLanes>(
    memory: &mut F::Over<N>,
    kernel: impl LaneKernel<F, N::Float>,
) {
    let call = LaneCall::<F, N, _> { kernel, memory };
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
pub(crate) unsafe fn run_wide<F: Form, N: StateLanes>(
    memory: &mut F::Over<N>,
    kernel: impl LaneKernel<F, N::Float>,
) {
    // SAFETY: as the caller guarantees.
    unsafe { super::with_avx512(LaneCall::<F, N, _> { kernel, memory }) }
}
