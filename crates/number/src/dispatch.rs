//! Running a kernel over the numbers that this machine has.
//!
//! Memory over such numbers is made by [`OneState::new`] or [`LaneMemory::new`], which look at the machine, and a
//! kernel reaches it by their `run` alone, inside a function compiled for those instructions. A kernel's `run` and
//! all it calls must be `#[inline(always)]`, or it is compiled for the oldest machine.
#![allow(unsafe_code)]

pub(crate) mod lanes;
pub(crate) mod one_state;

pub use lanes::{LaneKernel, LaneMemory};
pub use one_state::{CloneForm, Kernel, OneState};

use crate::{Form, Scalar};

/// Makes a form over whichever number it is asked for.
pub trait Make<F: Form> {
    /// The form over `S`.
    fn make<S: Scalar>(&self) -> F::Over<S>;
}

mod sealed {
    pub trait Sealed {}
}

/// The instructions that the code at hand is compiled for; a type, as they are chosen when the program is compiled.
pub trait Hardware: sealed::Sealed {
    /// Whether there are 32 vector registers of the widest kind.
    const HAS_32_REGISTERS: bool;

    /// Runs more code compiled for the same instructions, as a call where that is a function of its own.
    fn call(call: impl Call);
}

/// What [`Hardware::call`] calls.
pub trait Call {
    /// Runs it; must be `#[inline(always)]`.
    fn call<H: Hardware>(self);
}

/// Any machine's instructions.
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
        // SAFETY: code for `Avx2` runs inside `with_avx2_fma` alone, so its instructions are there.
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
        // SAFETY: code for `Avx512` runs inside `with_avx512` alone, so its instructions are there.
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
