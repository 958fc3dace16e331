//! Memory and kernels for one state, over floats whose multiply-add is one instruction.

use core::fmt;

#[cfg(registers)]
use super::Call;
use super::Hardware;
#[cfg(registers)]
use crate::fma_float::FmaFloat;
use crate::{Form, InstructionSet, Scalar, View};

/// A computation on memory over the machine's number for `T`.
pub trait Kernel<F: Form, T: Scalar> {
    /// Whether AVX-512 makes the kernel faster: eight numbers a register, and twice the registers. The
    /// results have the same bits.
    const GAINS_BY_AVX512: bool = false;

    /// Runs the computation; must be `#[inline(always)]`.
    fn run<N: View<T>, H: Hardware>(self, memory: &mut F::Over<N>);
}

/// A type family whose members can be cloned over every number.
pub trait CloneForm: Form {
    /// A clone of the member.
    fn copy<S: Scalar>(form: &Self::Over<S>) -> Self::Over<S>;
}

/// Memory over the machine's own number for `f64` or `f32`. It exists only on machines with such a number.
pub struct OneState<F: Form> {
    pub(crate) memory: Memory<F>,
    /// Detected on this machine before the memory was allocated.
    pub(crate) set: InstructionSet,
}

#[cfg(registers)]
pub(crate) enum Memory<F: Form> {
    F64(Box<F::Over<FmaFloat<f64>>>),
    F32(Box<F::Over<FmaFloat<f32>>>),
}

#[cfg(not(registers))]
pub(crate) enum Memory<F: Form> {
    /// The target has no such number.
    #[expect(dead_code, reason = "no value has this type")]
    Never(core::convert::Infallible, core::marker::PhantomData<fn() -> F>),
}

impl<F: Form> OneState<F> {
    /// The newest instructions that a kernel may run on.
    pub fn instruction_set(&self) -> InstructionSet {
        self.set
    }
}

impl<F: CloneForm> Clone for OneState<F> {
    fn clone(&self) -> Self {
        #[cfg(registers)]
        return Self {
            memory: match &self.memory {
                Memory::F64(memory) => Memory::F64(Box::new(F::copy(memory))),
                Memory::F32(memory) => Memory::F32(Box::new(F::copy(memory))),
            },
            set: self.set,
        };
        #[cfg(not(registers))]
        match self.memory {
            Memory::Never(never, _) => match never {},
        }
    }
}

impl<F: Form> fmt::Debug for OneState<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OneState").field("instructions", &self.set).finish_non_exhaustive()
    }
}

/// A kernel for `T` and its memory over `N`.
#[cfg(registers)]
struct StateCall<'a, F: Form, T, N: Scalar, K> {
    kernel: &'a mut Option<K>,
    memory: &'a mut F::Over<N>,
    of: core::marker::PhantomData<T>,
}

#[cfg(registers)]
impl<F: Form, T: Scalar, N: View<T>, K: Kernel<F, T>> Call for StateCall<'_, F, T, N, K> {
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
pub(crate) unsafe fn run_on<F: Form, T: Scalar, N: View<T>, K: Kernel<F, T>>(
    set: InstructionSet,
    kernel: &mut Option<K>,
    memory: &mut F::Over<N>,
) {
    let call = StateCall::<F, T, N, K> { kernel, memory, of: core::marker::PhantomData };
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
