//! Runs an algorithm compiled for what this machine can do.
//!
//! A default build targets the oldest machine of its kind. The hot algorithms are therefore compiled twice: as
//! they are, and over [`Scalar::Fused`] inside a function that may use AVX2 and FMA, or AVX-512 where the
//! scalar is made of it. Which one runs is decided when a [`Workspace`] is made ([`InstructionSet`]). This file is this
//! crate's only one with `unsafe` code.

use core::marker::PhantomData;

use dynamics::{AsFloat, Form, Scalar};

use crate::{InstructionSet, Workspace};

/// Which form of a scalar an algorithm computes with.
pub(crate) trait Route<S: Scalar> {
    type Number: Scalar;
    /// Whether `Number` is the fused form.
    const FUSED: bool;
    /// Whether there are 32 vector registers of the widest kind.
    const HAS_32_REGISTERS: bool;
    fn load(x: S) -> Self::Number;
    fn store(x: Self::Number) -> S;
    /// Sine and cosine of each angle.
    fn sin_cos_each(angles: &[S], sines: &mut [Self::Number], cosines: &mut [Self::Number]);
    /// Another task by this route, as a call: what several tasks begin with is compiled once for all of them.
    fn call<T: CompiledTask<S>>(workspace: &mut Workspace<Self::Number>, task: T);
    /// The same for a task of one kind of numbers alone.
    fn share<T: Task<S>>(workspace: &mut Workspace<Self::Number>, task: T);
}

/// The scalar itself.
pub(crate) struct Plain;

impl<S: Scalar> Route<S> for Plain {
    type Number = S;
    const FUSED: bool = false;
    const HAS_32_REGISTERS: bool = false;
    #[inline(always)]
    fn load(x: S) -> S {
        x
    }
    #[inline(always)]
    fn store(x: S) -> S {
        x
    }
    #[inline(always)]
    fn sin_cos_each(angles: &[S], sines: &mut [S], cosines: &mut [S]) {
        S::sin_cos_each(angles, sines, cosines);
    }
    #[inline(always)]
    fn call<T: CompiledTask<S>>(workspace: &mut Workspace<S>, task: T) {
        run_compiled(workspace, task);
    }
    #[inline(always)]
    fn share<T: Task<S>>(workspace: &mut Workspace<S>, task: T) {
        task.run::<Self>(workspace);
    }
}

/// The form whose multiply-add is one instruction.
pub(crate) struct Fast<const AVX512: bool>;

impl<S: Scalar, const AVX512: bool> Route<S> for Fast<AVX512> {
    type Number = S::Fused;
    const FUSED: bool = true;
    const HAS_32_REGISTERS: bool = AVX512;
    #[inline(always)]
    fn load(x: S) -> S::Fused {
        x.fuse()
    }
    #[inline(always)]
    fn store(x: S::Fused) -> S {
        S::unfuse(x)
    }
    #[inline(always)]
    fn sin_cos_each(angles: &[S], sines: &mut [S::Fused], cosines: &mut [S::Fused]) {
        S::fused_sin_cos_each(angles, sines, cosines);
    }
    #[inline(always)]
    fn call<T: CompiledTask<S>>(workspace: &mut Workspace<S::Fused>, task: T) {
        <Self as Route<S>>::share(workspace, task);
    }
    #[inline(always)]
    fn share<T: Task<S>>(workspace: &mut Workspace<S::Fused>, task: T) {
        #[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
        #[allow(unsafe_code)]
        // SAFETY: this route is taken inside `with_avx512` and `with_avx2_fma` alone, so its instructions are there.
        unsafe {
            if const { AVX512 } {
                with_avx512(workspace, &mut Some(task));
            } else {
                with_avx2_fma(workspace, &mut Some(task));
            }
        }
        #[cfg(not(any(target_arch = "x86_64", target_arch = "x86")))]
        task.run::<Self>(workspace);
    }
}

/// An algorithm with its arguments, ready to run by either route.
pub(crate) trait Task<S: Scalar> {
    /// Whether AVX-512 makes it faster where its numbers need only AVX2: eight numbers a register, and twice the
    /// registers. The results are the same bits.
    const GAINS_BY_AVX512: bool = false;

    /// Must be `#[inline(always)]`, or it is compiled for the oldest machine.
    fn run<R: Route<S>>(self, workspace: &mut Workspace<R::Number>);
}

/// A kind of task over any number, whose forms over floats are compiled in this library and nowhere else: a generic
/// function is compiled anew in every program that calls it, and these take seconds. See [`compiled_once`].
pub(crate) trait Kind {
    type Over<S: Scalar>: Task<S>;
    fn f64(workspace: &mut Workspace<f64>, task: &mut Option<Self::Over<f64>>);
    fn f32(workspace: &mut Workspace<f32>, task: &mut Option<Self::Over<f32>>);
}

/// A task of such a kind.
pub(crate) trait CompiledTask<S: Scalar>: Task<S> {
    type Kind: Kind<Over<S> = Self>;
}

/// A task with its workspace.
struct Call<'a, K>(PhantomData<(&'a (), K)>);

impl<'a, K: Kind> Form for Call<'a, K> {
    type Over<S: Scalar> = (&'a mut Workspace<S>, Option<K::Over<S>>);
}

/// Makes `$task<'a, S>` a [`CompiledTask`] of the kind `$kind`.
macro_rules! compiled_once {
    ($kind:ident, $task:ident) => {
        /// See [`compiled_once`](crate::dispatch).
        pub(crate) struct $kind<'a>(core::marker::PhantomData<&'a ()>);

        impl<'a> crate::dispatch::Kind for $kind<'a> {
            type Over<S: Scalar> = $task<'a, S>;
            fn f64(workspace: &mut Workspace<f64>, task: &mut Option<$task<'a, f64>>) {
                crate::dispatch::run_in_place(workspace, task);
            }
            fn f32(workspace: &mut Workspace<f32>, task: &mut Option<$task<'a, f32>>) {
                crate::dispatch::run_in_place(workspace, task);
            }
        }

        impl<'a, S: Scalar> crate::dispatch::CompiledTask<S> for $task<'a, S> {
            type Kind = $kind<'a>;
        }
    };
}
pub(crate) use compiled_once;

/// Runs a task by the route its workspace was made for; over floats by a call of what is compiled here.
#[inline(always)]
pub(crate) fn run_compiled<S: Scalar, T: CompiledTask<S>>(workspace: &mut Workspace<S>, task: T) {
    // A branch on a constant: for floats nothing else is compiled.
    if const { S::IS_FLOAT } {
        match S::as_float::<Call<'_, T::Kind>>((workspace, Some(task))) {
            AsFloat::F64((workspace, mut task)) => T::Kind::f64(workspace, &mut task),
            AsFloat::F32((workspace, mut task)) => T::Kind::f32(workspace, &mut task),
            AsFloat::Other(_) => unreachable!("a float says which one it is"),
        }
    } else {
        run(workspace, task);
    }
}

/// Runs a task by the route its workspace was made for.
#[inline(always)]
pub(crate) fn run<S: Scalar, T: Task<S>>(workspace: &mut Workspace<S>, task: T) {
    run_in_place(workspace, &mut Some(task));
}

/// The same. The arguments stay where they were written: moved from call to call, they would cost a short algorithm a
/// tenth of its time.
#[inline(always)]
pub(crate) fn run_in_place<S: Scalar, T: Task<S>>(workspace: &mut Workspace<S>, task: &mut Option<T>) {
    // Branches on constants of the types: only the forms that can run are compiled.
    #[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
    let has_avx512 = workspace.has_avx512;
    #[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
    if const { S::HAS_FUSED }
        && let Some(fused) = workspace.fused.as_deref_mut()
    {
        #[allow(unsafe_code)]
        // SAFETY: `fused` is made only where `has_fused` found what its scalar needs, and `has_avx512` is set only
        // where this machine has AVX-512.
        unsafe {
            if const { S::Fused::NEEDS_AVX512 } {
                with_avx512(fused, task);
            } else if const { T::GAINS_BY_AVX512 } {
                if has_avx512 {
                    with_avx512(fused, task);
                } else {
                    with_avx2_fma(fused, task);
                }
            } else {
                with_avx2_fma(fused, task);
            }
        }
        return;
    }
    if let Some(task) = task.take() {
        task.run::<Plain>(workspace);
    }
}

#[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
#[target_feature(enable = "avx2,fma")]
fn with_avx2_fma<S: Scalar>(workspace: &mut Workspace<S::Fused>, task: &mut Option<impl Task<S>>) {
    if let Some(task) = task.take() {
        task.run::<Fast<false>>(workspace);
    }
}

#[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma")]
fn with_avx512<S: Scalar>(workspace: &mut Workspace<S::Fused>, task: &mut Option<impl Task<S>>) {
    if let Some(task) = task.take() {
        task.run::<Fast<true>>(workspace);
    }
}

/// The instructions that the fused route of a scalar takes.
pub(crate) fn needed<S: Scalar>() -> InstructionSet {
    if S::Fused::NEEDS_AVX512 { InstructionSet::Avx512 } else { InstructionSet::Avx2 }
}

/// Whether this machine runs the fused route of a scalar.
pub(crate) fn has_fused<S: Scalar>() -> bool {
    S::HAS_FUSED && needed::<S>().is_available()
}
