//! Algorithms compiled once, in this library, for the instructions of the machine.
//!
//! The hot algorithms are kernels ([`robot_dynamics_number::dispatch`]). Each is compiled for the plain
//! scalar type and for the machine's vector types. A generic function is compiled again in every program that
//! calls it, and these take seconds. So over `f64` and `f32` they are functions of this library, and over
//! other scalar types, such as dual numbers, they are generic.

use robot_dynamics_number::dispatch::{Kernel, Portable};
use robot_dynamics_number::{Float, Scalar};

use crate::workspace::tree::{TreeMemory, TreeStorage};

/// A kernel whose code over floats is compiled once, in the library that defines it. Only [`compiled_once`]
/// implements it.
#[doc(alias("CompiledKernel", "Kind"))]
pub trait TreeKernel<S: Scalar>: Kernel<TreeStorage, S> + Sized {
    /// Runs the kernel over a float, in the code of its library.
    fn run_float(memory: &mut TreeMemory<S>, kernel: &mut Option<Self>);
}

/// Makes `$kernel<'a, S>` a [`TreeKernel`].
#[doc(hidden)]
#[macro_export]
macro_rules! compiled_once {
    ($kernel:ident) => {
        impl<'a, S: Scalar> $crate::workspace::compiled_once::TreeKernel<S> for $kernel<'a, S> {
            #[inline(always)]
            fn run_float(
                memory: &mut $crate::workspace::tree::TreeMemory<S>,
                kernel: &mut Option<$kernel<'a, S>>,
            ) {
                use robot_dynamics_number::Specialization;
                use $crate::workspace::compiled_once::run_on_machine;
                use $crate::workspace::tree::TreeMemory;

                /// The memory and the kernel.
                struct Arguments<'m, 'a>(core::marker::PhantomData<(&'m (), &'a ())>);

                impl<'m, 'a: 'm> robot_dynamics_number::TypeFamily for Arguments<'m, 'a> {
                    type Over<S: Scalar> = (&'m mut TreeMemory<S>, &'m mut Option<$kernel<'a, S>>);
                }

                fn run_f64(memory: &mut TreeMemory<f64>, kernel: &mut Option<$kernel<'_, f64>>) {
                    run_on_machine(memory, kernel);
                }

                fn run_f32(memory: &mut TreeMemory<f32>, kernel: &mut Option<$kernel<'_, f32>>) {
                    run_on_machine(memory, kernel);
                }

                match S::specialize::<Arguments<'_, 'a>>((memory, kernel)) {
                    Specialization::F64((memory, kernel)) => run_f64(memory, kernel),
                    Specialization::F32((memory, kernel)) => run_f32(memory, kernel),
                    Specialization::Other(_) => unreachable!("a float says which one it is"),
                }
            }
        }
    };
}
pub use compiled_once;

/// Runs a kernel on the instructions that its memory was allocated for; for floats it calls code compiled in
/// this library.
#[inline(always)]
pub fn run<S: Scalar, K: TreeKernel<S>>(memory: &mut TreeMemory<S>, kernel: K) {
    // A branch on a constant: for floats no other code is compiled.
    if const { S::IS_FLOAT } {
        K::run_float(memory, &mut Some(kernel));
    } else {
        kernel.run::<S, Portable>(memory);
    }
}

/// Runs a kernel over a float on the instructions that its memory was allocated for.
#[inline(always)]
pub fn run_on_machine<T: Float, K: Kernel<TreeStorage, T>>(
    memory: &mut TreeMemory<T>,
    kernel: &mut Option<K>,
) {
    if let Some(fast) = &mut memory.fast {
        fast.run(kernel);
    } else if let Some(kernel) = kernel.take() {
        kernel.run::<T, Portable>(memory);
    }
}
