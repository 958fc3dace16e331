//! An algorithm compiled for what this machine can do, in this library and nowhere else.
//!
//! The hot algorithms are kernels ([`number::dispatch`]): compiled as they are, and over the machine's own number. A
//! generic function is compiled anew in every program that calls it, and these take seconds; so over `f64` and `f32`
//! they are functions of this library, and over any other number, dual numbers for one, generic ones.

use core::marker::PhantomData;

use number::dispatch::{CloneForm, Kernel, Portable};
use number::{AsFloat, Float, Form, Scalar};

use crate::scratch::tree::TreeMemory;

/// The recursions' memory over each number.
#[derive(Debug)]
pub(crate) struct OverNumber;

impl Form for OverNumber {
    type Over<S: Scalar> = TreeMemory<S>;
}

impl CloneForm for OverNumber {
    fn copy<S: Scalar>(memory: &TreeMemory<S>) -> TreeMemory<S> {
        memory.clone()
    }
}

/// A kind of kernel, whose forms over floats are compiled in this library. See [`compiled_once`].
pub(crate) trait Kind {
    type Over<S: Scalar>: Kernel<OverNumber, S>;
    fn f64(memory: &mut TreeMemory<f64>, kernel: &mut Option<Self::Over<f64>>);
    fn f32(memory: &mut TreeMemory<f32>, kernel: &mut Option<Self::Over<f32>>);
}

/// A kernel of such a kind.
pub(crate) trait CompiledKernel<S: Scalar>: Kernel<OverNumber, S> {
    type Kind: Kind<Over<S> = Self>;
}

/// A kernel with the memory it runs on.
struct WithMemory<'a, K>(PhantomData<(&'a (), K)>);

impl<'a, K: Kind> Form for WithMemory<'a, K> {
    type Over<S: Scalar> = (&'a mut TreeMemory<S>, Option<K::Over<S>>);
}

/// Makes `$kernel<'a, S>` a [`CompiledKernel`] of the kind `$kind`.
macro_rules! compiled_once {
    ($kind:ident, $kernel:ident) => {
        /// See [`compiled_once`](crate::scratch::compiled_once).
        pub(crate) struct $kind<'a>(core::marker::PhantomData<&'a ()>);

        impl<'a> crate::scratch::compiled_once::Kind for $kind<'a> {
            type Over<S: Scalar> = $kernel<'a, S>;
            fn f64(memory: &mut TreeMemory<f64>, kernel: &mut Option<$kernel<'a, f64>>) {
                crate::scratch::compiled_once::run_on_machine(memory, kernel);
            }
            fn f32(memory: &mut TreeMemory<f32>, kernel: &mut Option<$kernel<'a, f32>>) {
                crate::scratch::compiled_once::run_on_machine(memory, kernel);
            }
        }

        impl<'a, S: Scalar> crate::scratch::compiled_once::CompiledKernel<S> for $kernel<'a, S> {
            type Kind = $kind<'a>;
        }
    };
}
pub(crate) use compiled_once;

/// Runs a kernel on the instructions its memory was made for; over floats by a call of what is compiled here.
#[inline(always)]
pub(crate) fn run<S: Scalar, K: CompiledKernel<S>>(memory: &mut TreeMemory<S>, kernel: K) {
    // A branch on a constant: for floats nothing else is compiled.
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

/// Runs a kernel over a float on the instructions its memory was made for.
#[inline(always)]
pub(crate) fn run_on_machine<T: Float, K: Kernel<OverNumber, T>>(
    memory: &mut TreeMemory<T>,
    kernel: &mut Option<K>,
) {
    if let Some(fast) = &mut memory.fast {
        fast.run(kernel);
    } else if let Some(kernel) = kernel.take() {
        kernel.run::<T, Portable>(memory);
    }
}
