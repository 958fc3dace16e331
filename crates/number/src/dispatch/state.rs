//! Memory and kernels for one state, over floats whose multiply-add is one instruction.

use core::fmt;

#[cfg(registers)]
use super::Call;
use super::{Hardware, Storage};
#[cfg(registers)]
use crate::fma_float::FmaFloat;
use crate::{InstructionSet, Scalar, View};

/// A computation on memory over the machine's number for `T`.
pub trait Kernel<M: Storage, T: Scalar> {
    /// Whether AVX-512 makes the kernel faster: eight numbers a register, and twice the registers. The
    /// results have the same bits.
    const GAINS_BY_AVX512: bool = false;

    /// Runs the computation; must be `#[inline(always)]`.
    fn run<N: View<T>, H: Hardware>(self, memory: &mut M::Over<N>);
}

/// Memory over the machine's own number for `f64` or `f32`. It exists only on machines with such a number.
#[doc(alias = "OneState")]
pub struct StateMemory<M: Storage> {
    pub(crate) memory: StateVariants<M>,
    /// Detected on this machine before the memory was allocated.
    pub(crate) set: InstructionSet,
}

#[cfg(registers)]
pub(crate) enum StateVariants<M: Storage> {
    F64(Box<M::Over<FmaFloat<f64>>>),
    F32(Box<M::Over<FmaFloat<f32>>>),
}

#[cfg(not(registers))]
pub(crate) enum StateVariants<M: Storage> {
    /// The target has no such number.
    #[expect(dead_code, reason = "no value has this type")]
    Never(core::convert::Infallible, core::marker::PhantomData<fn() -> M>),
}

impl<M: Storage> StateMemory<M> {
    /// The newest instructions that a kernel may run on.
    pub fn instruction_set(&self) -> InstructionSet {
        self.set
    }
}

impl<M: Storage> Clone for StateMemory<M> {
    fn clone(&self) -> Self {
        #[cfg(registers)]
        return Self {
            memory: match &self.memory {
                StateVariants::F64(memory) => StateVariants::F64(memory.clone()),
                StateVariants::F32(memory) => StateVariants::F32(memory.clone()),
            },
            set: self.set,
        };
        #[cfg(not(registers))]
        match self.memory {
            StateVariants::Never(never, _) => match never {},
        }
    }
}

impl<M: Storage> fmt::Debug for StateMemory<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("StateMemory").field("instructions", &self.set).finish_non_exhaustive()
    }
}

/// A kernel for `T` and its memory over `N`.
#[cfg(registers)]
struct StateCall<'a, M: Storage, T, N: Scalar, K> {
    kernel: &'a mut Option<K>,
    memory: &'a mut M::Over<N>,
    of: core::marker::PhantomData<T>,
}

#[cfg(registers)]
impl<M: Storage, T: Scalar, N: View<T>, K: Kernel<M, T>> Call for StateCall<'_, M, T, N, K> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        if let Some(kernel) = self.kernel.take() {
            kernel.run::<N, H>(self.memory);
        }
    }
}

/// Runs a kernel on memory of a machine that has the instructions of `set`.
///
/// # Safety
/// `set` has been detected on this machine.
#[cfg(registers)]
#[inline(always)]
pub(crate) unsafe fn run_on<M: Storage, T: Scalar, N: View<T>, K: Kernel<M, T>>(
    set: InstructionSet,
    kernel: &mut Option<K>,
    memory: &mut M::Over<N>,
) {
    let call = StateCall::<M, T, N, K> { kernel, memory, of: core::marker::PhantomData };
    #[cfg(target_arch = "x86_64")]
    // SAFETY: this machine has `set`, and every machine with AVX-512 has AVX2.
    unsafe {
        if const { K::GAINS_BY_AVX512 } && set == InstructionSet::Avx512 {
            super::with_avx512(call);
        } else {
            super::with_avx2_fma(call);
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = set;
        super::as_function(call);
    }
}
