//! Runs kernels over the numbers that this machine has.
//!
//! # To write a kernel
//!
//! 1. Name the memory of the computation and implement [`Storage`] for the name. The recursions over a tree
//!    share one, `TreeStorage` of `robot_dynamics_core`.
//! 2. Put the arguments in a struct and implement [`Kernel`] for it, for one state. Its `run` receives the
//!    memory over a number `N` of the machine, and reads the caller's slices by [`View`](crate::View). For
//!    several states, implement [`LaneKernel`]. Its number is a register with a lane for each state
//!    ([`StateLanes`](crate::StateLanes)), which gathers rows of tables and scatters the results.
//! 3. Allocate the memory by [`StateMemory::new`] or [`LaneMemory::new`], which detect the machine's
//!    instructions. Their `run` is the only access of a kernel to that memory. It is inside a function
//!    compiled for those instructions.
//! 4. Mark a kernel's `run` and all that it calls `#[inline(always)]`. Other code is compiled for the oldest
//!    machine.
//!
//! A part of a kernel may be a function of its own, so that it is compiled once for several kernels. It is a
//! [`Call`], and [`Hardware::call`] runs it on the kernel's instructions. [`run_here`] runs a `Call` on plain
//! floats, without memory of its own.
#![allow(unsafe_code)]

pub(crate) mod lanes;
pub(crate) mod state;

pub use lanes::{LaneKernel, LaneMemory};
pub use state::{Kernel, StateMemory};

use crate::Scalar;

/// The memory of kernels, over any scalar type. The type that implements it is only a name.
#[doc(alias("Form", "Make", "CloneForm"))]
pub trait Storage {
    /// The memory over `S`.
    type Over<S: Scalar>: Clone;

    /// The input that decides the sizes, such as a model.
    type Input<'a>: Copy;

    /// Allocates the memory over `S`.
    fn new<S: Scalar>(input: Self::Input<'_>) -> Self::Over<S>;
}

mod sealed {
    pub trait Sealed {}
}

/// The instructions that code is compiled for. This is a type because they are chosen at compile time.
pub trait Hardware: sealed::Sealed {
    /// Whether the processor has 32 vector registers of the widest kind.
    const HAS_32_REGISTERS: bool;

    /// Runs code compiled for the same instructions, as a call where that code is a function of its own.
    fn call(call: impl Call);
}

/// Code without memory of its own, which [`Hardware::call`] and [`run_here`] run.
pub trait Call {
    /// Runs the code; must be `#[inline(always)]`.
    fn call<H: Hardware>(self);
}

/// The instructions of the oldest machine that the program was built for.
#[derive(Debug)]
pub enum Portable {}

impl sealed::Sealed for Portable {}

impl Hardware for Portable {
    const HAS_32_REGISTERS: bool = false;
    #[inline(always)]
    fn call(call: impl Call) {
        call.call::<Self>();
    }
}

/// Runs code on plain floats, compiled for the vector registers of this machine. The bits are those of any
/// machine, because only explicit multiply-adds are fused.
///
/// ```
/// use robot_dynamics_number::dispatch::{Call, Hardware, run_here};
/// struct Double<'a>(&'a mut [f64]);
/// impl Call for Double<'_> {
///     #[inline(always)]
///     fn call<H: Hardware>(self) {
///         self.0.iter_mut().for_each(|x| *x *= 2.0);
///     }
/// }
/// let mut x = [1.0, 2.5];
/// run_here(Double(&mut x));
/// assert_eq!(x, [2.0, 5.0]);
/// ```
#[inline(always)]
pub fn run_here(call: impl Call) {
    #[cfg(target_arch = "x86_64")]
    if crate::InstructionSet::Avx2.is_available() {
        // SAFETY: the instructions were just detected on this machine.
        return unsafe { with_avx2_fma(call) };
    }
    call.call::<Portable>();
}

/// AVX2 and FMA.
#[cfg(target_arch = "x86_64")]
enum Avx2 {}

#[cfg(target_arch = "x86_64")]
impl sealed::Sealed for Avx2 {}

#[cfg(target_arch = "x86_64")]
impl Hardware for Avx2 {
    const HAS_32_REGISTERS: bool = false;
    #[inline(always)]
    fn call(call: impl Call) {
        // SAFETY: code for `Avx2` runs only inside `with_avx2_fma`, so the machine has its instructions.
        unsafe { with_avx2_fma(call) }
    }
}

/// AVX-512.
#[cfg(target_arch = "x86_64")]
enum Avx512 {}

#[cfg(target_arch = "x86_64")]
impl sealed::Sealed for Avx512 {}

#[cfg(target_arch = "x86_64")]
impl Hardware for Avx512 {
    const HAS_32_REGISTERS: bool = true;
    #[inline(always)]
    fn call(call: impl Call) {
        // SAFETY: code for `Avx512` runs only inside `with_avx512`, so the machine has its instructions.
        unsafe { with_avx512(call) }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn with_avx2_fma(call: impl Call) {
    call.call::<Avx2>();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma")]
fn with_avx512(call: impl Call) {
    call.call::<Avx512>();
}

/// NEON, which every 64-bit ARM has.
#[cfg(target_arch = "aarch64")]
enum Neon {}

#[cfg(target_arch = "aarch64")]
impl sealed::Sealed for Neon {}

#[cfg(target_arch = "aarch64")]
impl Hardware for Neon {
    const HAS_32_REGISTERS: bool = true;
    #[inline(always)]
    fn call(call: impl Call) {
        as_function(call);
    }
}

#[cfg(target_arch = "aarch64")]
#[inline(never)]
fn as_function(call: impl Call) {
    call.call::<Neon>();
}

/// simd128, which every engine has that accepts a module compiled for it.
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
enum Simd128 {}

#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
impl sealed::Sealed for Simd128 {}

#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
impl Hardware for Simd128 {
    /// The module cannot determine the registers of the processor.
    const HAS_32_REGISTERS: bool = false;
    #[inline(always)]
    fn call(call: impl Call) {
        as_function(call);
    }
}

#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
#[inline(never)]
fn as_function(call: impl Call) {
    call.call::<Simd128>();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Float, InstructionSet, StateLanes, View};

    /// Memory of several numbers.
    struct Numbers;

    impl Storage for Numbers {
        type Over<S: Scalar> = Vec<S>;
        type Input<'a> = usize;
        fn new<S: Scalar>(count: usize) -> Vec<S> {
            vec![S::zero(); count]
        }
    }

    /// x² + x of each number, computed in the memory.
    struct Polynomial<'a, T> {
        x: &'a [T],
        y: &'a mut [T],
    }

    impl<T: Scalar> Kernel<Numbers, T> for Polynomial<'_, T> {
        #[inline(always)]
        fn run<N: View<T>, H: Hardware>(self, memory: &mut Vec<N>) {
            memory.copy_from_slice(N::view(self.x));
            H::call(InMemory { memory });
            N::view_mut(self.y).copy_from_slice(memory);
        }
    }

    struct InMemory<'a, N> {
        memory: &'a mut [N],
    }

    impl<N: Scalar> Call for InMemory<'_, N> {
        #[inline(always)]
        fn call<H: Hardware>(self) {
            for x in self.memory {
                *x = x.mul_add(*x, *x);
            }
        }
    }

    fn one_state_is_run<T: Float + View<T>>() {
        let x = [1.0, -2.0, 0.5, 3.0, 8.0].map(T::from_f64);
        for &limit in InstructionSet::ALL {
            let mut y = [T::zero(); 5];
            let kernel = Polynomial { x: &x, y: &mut y };
            match StateMemory::new::<T>(limit, 5) {
                None => kernel.run::<T, Portable>(&mut vec![T::zero(); 5]),
                Some(memory) => {
                    assert!(memory.instruction_set() <= limit && memory.instruction_set().is_available());
                    let mut kernel = Some(kernel);
                    memory.clone().run(&mut kernel);
                    assert!(kernel.is_none());
                }
            }
            assert!(y == [2.0, 2.0, 0.75, 12.0, 72.0].map(T::from_f64), "{y:?} up to {limit}");
        }
    }

    #[test]
    fn kernels_run_on_every_set_that_is_here() {
        one_state_is_run::<f64>();
        one_state_is_run::<f32>();
    }

    /// The same for one column of as many states as there are lanes.
    struct Column<'a, T> {
        x: &'a [T],
        y: &'a mut [T],
    }

    impl<T: Float> LaneKernel<Numbers, T> for Column<'_, T> {
        #[inline(always)]
        fn run<N: StateLanes<Float = T>, H: Hardware>(self, memory: &mut Vec<N>) {
            N::gather(self.x, 1, memory);
            H::call(InMemory { memory });
            N::scatter(1, |_| &memory[0], self.y, 1);
        }
    }

    fn lanes_are_run<T: Float>() {
        for &limit in InstructionSet::ALL {
            let mut memory = LaneMemory::<Numbers>::new::<T>(limit, 1);
            assert!(memory.instruction_set() <= limit && memory.instruction_set().is_available());
            let x: Vec<T> = (0..memory.lanes()).map(|k| T::from_f64(k as f64)).collect();
            let mut y = vec![T::zero(); memory.lanes()];
            memory.run(Column { x: &x, y: &mut y });
            assert!((0..x.len()).all(|k| y[k] == x[k] * x[k] + x[k]), "{y:?} up to {limit}");
        }
    }

    #[test]
    fn lanes_run_on_every_set_that_is_here() {
        lanes_are_run::<f64>();
        lanes_are_run::<f32>();
    }

    #[test]
    #[should_panic(expected = "f32")]
    fn memory_of_another_float_is_refused() {
        let mut memory = LaneMemory::<Numbers>::new::<f64>(InstructionSet::best(), 1);
        memory.run(Column { x: &[1.0f32; 16], y: &mut [0.0; 16] });
    }
}
