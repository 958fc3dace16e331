//! Hardware floats, and the memory and kernels over the machine's numbers for each.
#![allow(unsafe_code)]

use crate::dispatch::{Kernel, LaneKernel, LaneMemory, StateMemory, Storage, lanes, state};
use crate::{InstructionSet, Scalar};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl Sealed for f32 {}
}

/// A hardware float: `f64` or `f32`.
pub trait Float: Scalar + PartialOrd + sealed::Sealed {
    /// Whether the number is neither infinite nor NaN.
    fn is_finite(self) -> bool;

    /// See [`StateMemory::new`].
    #[doc(hidden)]
    fn new_state<M: Storage>(limit: InstructionSet, input: M::Input<'_>) -> Option<StateMemory<M>>;

    /// See [`StateMemory::run`].
    #[doc(hidden)]
    fn run_state<M: Storage, K: Kernel<M, Self>>(memory: &mut StateMemory<M>, kernel: &mut Option<K>);

    /// See [`LaneMemory::new`].
    #[doc(hidden)]
    fn new_lanes<M: Storage>(limit: InstructionSet, input: M::Input<'_>) -> LaneMemory<M>;

    /// See [`LaneMemory::run`].
    #[doc(hidden)]
    fn run_lanes<M: Storage, K: LaneKernel<M, Self>>(memory: &mut LaneMemory<M>, kernel: K);
}

impl<M: Storage> StateMemory<M> {
    /// Memory for the machine's number, or `None` where `limit` leaves only the portable instructions.
    #[inline(always)]
    pub fn new<T: Float>(limit: InstructionSet, input: M::Input<'_>) -> Option<Self> {
        T::new_state(limit, input)
    }

    /// Runs a kernel and takes it from the option. The kernel is passed in place: moving its arguments from
    /// call to call costs a short algorithm a tenth of its time.
    ///
    /// # Panics
    /// If the memory was made for the other float.
    #[inline(always)]
    pub fn run<T: Float, K: Kernel<M, T>>(&mut self, kernel: &mut Option<K>) {
        T::run_state(self, kernel);
    }
}

impl<M: Storage> LaneMemory<M> {
    /// Memory for the widest registers up to `limit` that this machine has.
    pub fn new<T: Float>(limit: InstructionSet, input: M::Input<'_>) -> Self {
        T::new_lanes(limit, input)
    }

    /// Runs a kernel.
    ///
    /// # Panics
    /// If the memory was made for the other float.
    #[inline(always)]
    pub fn run<T: Float, K: LaneKernel<M, T>>(&mut self, kernel: K) {
        T::run_lanes(self, kernel);
    }
}

/// Panics for memory that was made for the other float.
#[cold]
#[inline(never)]
#[track_caller]
fn panic_for_other_float<T>() -> ! {
    panic!("the kernel computes in {}; this memory was made for the other float", core::any::type_name::<T>())
}

macro_rules! float {
    ($float:ident, $variant:ident, $narrow:ident, $wide:ident) => {
        impl Float for $float {
            #[inline(always)]
            fn is_finite(self) -> bool {
                <$float>::is_finite(self)
            }

            #[inline(always)]
            fn new_state<M: Storage>(limit: InstructionSet, input: M::Input<'_>) -> Option<StateMemory<M>> {
                let set = InstructionSet::best_up_to(limit);
                if set == InstructionSet::Portable {
                    return None;
                }
                #[cfg(registers)]
                return Some(StateMemory {
                    memory: state::StateVariants::$variant(Box::new(M::new(input))),
                    set,
                });
                #[cfg(not(registers))]
                {
                    let _ = input;
                    None
                }
            }

            #[inline(always)]
            fn run_state<M: Storage, K: Kernel<M, Self>>(state: &mut StateMemory<M>, kernel: &mut Option<K>) {
                #[cfg(registers)]
                match &mut state.memory {
                    // SAFETY: the set was detected on this machine before the memory was allocated.
                    state::StateVariants::$variant(memory) => unsafe {
                        state::run_on::<M, Self, _, K>(state.set, kernel, memory);
                    },
                    _ => panic_for_other_float::<Self>(),
                }
                #[cfg(not(registers))]
                match state.memory {
                    state::StateVariants::Never(never, _) => {
                        let _ = kernel;
                        match never {}
                    }
                }
            }

            #[inline(always)]
            fn new_lanes<M: Storage>(limit: InstructionSet, input: M::Input<'_>) -> LaneMemory<M> {
                LaneMemory(match InstructionSet::best_up_to(limit) {
                    #[cfg(target_arch = "x86_64")]
                    InstructionSet::Avx512 => lanes::LaneVariants::$wide(Box::new(M::new(input))),
                    #[cfg(target_arch = "x86_64")]
                    InstructionSet::Avx2 => lanes::LaneVariants::$narrow(Box::new(M::new(input))),
                    #[cfg(target_arch = "aarch64")]
                    InstructionSet::Neon => lanes::LaneVariants::$narrow(Box::new(M::new(input))),
                    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
                    InstructionSet::Simd128 => lanes::LaneVariants::$narrow(Box::new(M::new(input))),
                    _ => lanes::LaneVariants::$variant(Box::new(M::new(input))),
                })
            }

            #[inline(always)]
            fn run_lanes<M: Storage, K: LaneKernel<M, Self>>(memory: &mut LaneMemory<M>, kernel: K) {
                match &mut memory.0 {
                    lanes::LaneVariants::$variant(memory) => lanes::run_portable::<M, Self>(memory, kernel),
                    // SAFETY: `new_lanes` detected these instructions on this machine.
                    #[cfg(registers)]
                    lanes::LaneVariants::$narrow(memory) => unsafe {
                        lanes::run_narrow::<M, _>(memory, kernel)
                    },
                    // SAFETY: as above.
                    #[cfg(target_arch = "x86_64")]
                    lanes::LaneVariants::$wide(memory) => unsafe { lanes::run_wide::<M, _>(memory, kernel) },
                    _ => panic_for_other_float::<Self>(),
                }
            }
        }
    };
}
float!(f64, F64, F64x4, F64x8);
float!(f32, F32, F32x8, F32x16);
