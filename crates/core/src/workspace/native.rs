//! Calls of a model's machine code.

use robot_dynamics_number::Scalar;

use crate::model::native::NativeTask;
use crate::{InstructionSet, Model};

#[cfg(feature = "native")]
pub use self::call::{NativeScratch, computed_natively};

/// Without machine code the recursions compute everything.
#[cfg(not(feature = "native"))]
pub use self::absent::{NativeScratch, computed_natively};

/// Calls a function with one number as its result; `None` if machine code did not compute it.
#[inline]
pub fn native_number<S: Scalar>(
    model: &Model,
    scratch: &mut NativeScratch<S>,
    task: impl Into<NativeTask>,
    arguments: &[&[S]],
) -> Option<S> {
    let mut number = S::zero();
    let result = core::slice::from_mut(&mut number);
    computed_natively(model, scratch, task, arguments, &mut [result]).then_some(number)
}

#[cfg(feature = "native")]
mod call {
    use core::marker::PhantomData;

    use robot_dynamics_native::best_instructions;
    use robot_dynamics_number::{Specialization, TypeFamily};

    use super::{InstructionSet, Model, NativeTask, Scalar};
    use crate::model::native::Number;

    /// The memory of machine code.
    #[derive(Clone, Debug)]
    pub struct NativeScratch<S> {
        /// Whether the workspace allows the instructions that the code uses.
        is_admitted: bool,
        numbers: Vec<S>,
    }

    impl<S> NativeScratch<S> {
        /// For a workspace limited to these instructions.
        pub fn new(instructions: InstructionSet) -> Self {
            let best = best_instructions();
            let is_admitted = instructions == best && best != InstructionSet::Portable;
            Self { is_admitted, numbers: Vec::new() }
        }
    }

    /// The inputs of a call: memory, arguments, results.
    struct Given<'a>(PhantomData<&'a ()>);

    impl<'a> TypeFamily for Given<'a> {
        type Over<S: Scalar> = (&'a mut NativeScratch<S>, &'a [&'a [S]], &'a mut [&'a mut [S]]);
    }

    /// Whether machine code has computed the function. The result is false without code, for scalar types
    /// other than floats, and for an angle out of the range of its sine.
    #[inline]
    pub fn computed_natively<'a, S: Scalar>(
        model: &Model,
        scratch: &'a mut NativeScratch<S>,
        task: impl Into<NativeTask>,
        arguments: &'a [&'a [S]],
        results: &'a mut [&'a mut [S]],
    ) -> bool {
        if !const { S::IS_FLOAT } || !scratch.is_admitted || model.native.code().is_none() {
            return false;
        }
        let task = task.into();
        match S::specialize::<Given<'_>>((scratch, arguments, results)) {
            Specialization::F64(given) => call_f64(model, task, given),
            Specialization::F32(given) => call_f32(model, task, given),
            Specialization::Other(_) => false,
        }
    }

    type Over<'a, T> = (&'a mut NativeScratch<T>, &'a [&'a [T]], &'a mut [&'a mut [T]]);

    fn call_f64(model: &Model, task: NativeTask, given: Over<'_, f64>) -> bool {
        call(model, task, given)
    }

    fn call_f32(model: &Model, task: NativeTask, given: Over<'_, f32>) -> bool {
        call(model, task, given)
    }

    #[inline(always)]
    fn call<T: Number + Scalar>(
        model: &Model,
        task: NativeTask,
        (scratch, arguments, results): Over<'_, T>,
    ) -> bool {
        let Some(kernel) = model.native.code().and_then(|code| code.one::<T>(model, task)) else {
            return false;
        };
        if scratch.numbers.len() < kernel.scratch_len() {
            scratch.numbers.resize(kernel.scratch_len(), T::zero());
        }
        kernel.call(arguments, results, &mut scratch.numbers).is_ok()
    }
}

#[cfg(not(feature = "native"))]
mod absent {
    use core::marker::PhantomData;

    use super::{InstructionSet, Model, NativeTask, Scalar};

    #[derive(Clone, Debug)]
    pub struct NativeScratch<S>(PhantomData<S>);

    impl<S> NativeScratch<S> {
        pub fn new(_: InstructionSet) -> Self {
            Self(PhantomData)
        }
    }

    #[inline(always)]
    pub fn computed_natively<S: Scalar>(
        _: &Model,
        _: &mut NativeScratch<S>,
        _: impl Into<NativeTask>,
        _: &[&[S]],
        _: &mut [&mut [S]],
    ) -> bool {
        false
    }
}
