//! Algorithms compiled once, in this library, for the instructions of the machine.
//!
//! The hot algorithms are kernels ([`robot_dynamics_number::dispatch`]). Each is compiled for the plain
//! scalar type and for the machine's vector types. A generic function is compiled again in every program that
//! calls it, and these take seconds. So over `f64` and `f32` they are functions of this library, and over
//! other scalar types, such as dual numbers, they are generic.

use core::marker::PhantomData;

use robot_dynamics_number::dispatch::{Kernel, Portable};
use robot_dynamics_number::{AsFloat, Float, Form, Scalar};

use crate::workspace::tree::{OverNumber, TreeMemory};

/// A kind of kernel whose forms over floats are compiled in this library. See [`compiled_once`].
pub trait Kind {
    type Over<S: Scalar>: Kernel<OverNumber, S>;
    fn f64(memory: &mut TreeMemory<f64>, kernel: &mut Option<Self::Over<f64>>);
    fn f32(memory: &mut TreeMemory<f32>, kernel: &mut Option<Self::Over<f32>>);
}

/// A kernel of a [`Kind`].
pub trait CompiledKernel<S: Scalar>: Kernel<OverNumber, S> {
    type Kind: Kind<Over<S> = Self>;
}

/// A kernel with its memory.
struct WithMemory<'a, K>(PhantomData<(&'a (), K)>);

impl<'a, K: Kind> Form for WithMemory<'a, K> {
    type Over<S: Scalar> = (&'a mut TreeMemory<S>, Option<K::Over<S>>);
}

/// Makes `$kernel<'a, S>` a [`CompiledKernel`] of the kind `$kind`.
#[doc(hidden)]
#[macro_export]
macro_rules! compiled_once {
    ($visibility:vis $kind:ident, $kernel:ident) => {
        /// See [`compiled_once`](crate::workspace::compiled_once).
        $visibility struct $kind<'a>(core::marker::PhantomData<&'a ()>);

        impl<'a> $crate::workspace::compiled_once::Kind for $kind<'a> {
            type Over<S: Scalar> = $kernel<'a, S>;
            fn f64(memory: &mut TreeMemory<f64>, kernel: &mut Option<$kernel<'a, f64>>) {
                $crate::workspace::compiled_once::run_on_machine(memory, kernel);
            }
            fn f32(memory: &mut TreeMemory<f32>, kernel: &mut Option<$kernel<'a, f32>>) {
                $crate::workspace::compiled_once::run_on_machine(memory, kernel);
            }
        }

        impl<'a, S: Scalar> $crate::workspace::compiled_once::CompiledKernel<S> for $kernel<'a, S> {
            type Kind = $kind<'a>;
        }
    };
}
pub use compiled_once;

/// Runs a kernel on the instructions that its memory was allocated for; for floats it calls code compiled in
/// this library.
#[inline(always)]
pub fn run<S: Scalar, K: CompiledKernel<S>>(memory: &mut TreeMemory<S>, kernel: K) {
    // A branch on a constant: for floats no other code is compiled.
    if const { S::IS_FLOAT } {
        match S::as_float::<WithMemory<'_, K::Kind>>((memory, Some(kernel))) {
            AsFloat::F64((memory, mut kernel)) => K::Kind::f64(memory, &mut kernel),
            AsFloat::F32((memory, mut kernel)) => K::Kind::f32(memory, &mut kernel),
            AsFloat::Other(_) => unreachable!("a float says which one it is"),
        }
    } else {
        kernel.run::<S, Portable>(memory);
    }
}

/// Runs a kernel over a float on the instructions that its memory was allocated for.
#[inline(always)]
pub fn run_on_machine<T: Float, K: Kernel<OverNumber, T>>(
    memory: &mut TreeMemory<T>,
    kernel: &mut Option<K>,
) {
    if let Some(fast) = &mut memory.fast {
        fast.run(kernel);
    } else if let Some(kernel) = kernel.take() {
        kernel.run::<T, Portable>(memory);
    }
}
