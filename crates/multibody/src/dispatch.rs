//! Runs an algorithm compiled for what this machine can do.
//!
//! A default build targets the oldest machine of its kind. The hot algorithms are therefore compiled twice: as
//! they are, and over [`Scalar::Fused`] inside a function that may use AVX2 and FMA, or AVX-512 where the
//! scalar is made of it. Which one runs is decided when a [`Workspace`] is made ([`InstructionSet`]). This file is the only one
//! with `unsafe` code.

use dynamics::Scalar;

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
}

/// An algorithm with its arguments, ready to run by either route.
pub(crate) trait Task<S: Scalar> {
    /// Whether AVX-512 makes it faster where its numbers need only AVX2: eight numbers a register, and twice the
    /// registers. The results are the same bits.
    const GAINS_BY_AVX512: bool = false;

    /// Must be `#[inline(always)]`, or it is compiled for the oldest machine.
    fn run<R: Route<S>>(self, workspace: &mut Workspace<R::Number>);
}

/// Runs a task by the route its workspace was made for.
#[inline(always)]
pub(crate) fn run<S: Scalar, T: Task<S>>(workspace: &mut Workspace<S>, task: T) {
    #[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
    let has_avx512 = workspace.has_avx512;
    #[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
    if let Some(fused) = workspace.fused.as_deref_mut() {
        #[allow(unsafe_code)]
        // SAFETY: `fused` is made only where `has_fused` found what its scalar needs, and `has_avx512` is set only
        // where this machine has AVX-512.
        // Branches on constants of the types: only the forms that can run are compiled.
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
    task.run::<Plain>(workspace);
}

#[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
#[target_feature(enable = "avx2,fma")]
fn with_avx2_fma<S: Scalar>(workspace: &mut Workspace<S::Fused>, task: impl Task<S>) {
    task.run::<Fast<false>>(workspace);
}

#[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma")]
fn with_avx512<S: Scalar>(workspace: &mut Workspace<S::Fused>, task: impl Task<S>) {
    task.run::<Fast<true>>(workspace);
}

/// The instructions that the fused route of a scalar takes.
pub(crate) fn needed<S: Scalar>() -> InstructionSet {
    if S::Fused::NEEDS_AVX512 { InstructionSet::Avx512 } else { InstructionSet::Avx2 }
}

/// Whether this machine runs the fused route of a scalar.
pub(crate) fn has_fused<S: Scalar>() -> bool {
    needed::<S>().is_available()
}
