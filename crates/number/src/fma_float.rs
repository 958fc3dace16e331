//! Floats whose multiply-add is one instruction.
//!
//! `a.mul_add(b, c)` rounds once. Only kernels on a machine that has the instruction use these numbers
//! ([`crate::dispatch`]); elsewhere each multiply-add would be a slow library call. WebAssembly has registers
//! without the instruction: there it is a product and a sum.

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::quad::Quad;
use crate::registers::F64x4;
use crate::scalar::check_lengths;
use crate::sine::{self, RANGE};
use crate::{Scalar, View};

/// A float on a machine with vector registers.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
#[repr(transparent)]
pub(crate) struct FmaFloat<T>(pub(crate) T);

macro_rules! operator {
    ($float:ty, $trait:ident, $method:ident, $assign:ident, $assign_method:ident) => {
        impl $trait for FmaFloat<$float> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
        impl $assign for FmaFloat<$float> {
            #[inline(always)]
            fn $assign_method(&mut self, other: Self) {
                self.0.$assign_method(other.0);
            }
        }
    };
}

/// a b + c by the machine's instruction.
macro_rules! multiply_add {
    ($a:expr, $b:expr, $c:expr) => {
        // WebAssembly has no such instruction.
        if cfg!(target_arch = "wasm32") { $a * $b + $c } else { $a.mul_add($b, $c) }
    };
}

macro_rules! fused {
    ($float:ty, $triple:ty, $symmetric:ty) => {
        operator!($float, Add, add, AddAssign, add_assign);
        operator!($float, Sub, sub, SubAssign, sub_assign);
        operator!($float, Mul, mul, MulAssign, mul_assign);

        impl Div for FmaFloat<$float> {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                Self(self.0 / other.0)
            }
        }

        impl Neg for FmaFloat<$float> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl Scalar for FmaFloat<$float> {
            type Triple = $triple;
            type Symmetric = $symmetric;
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                Self(<$float as Scalar>::from_f64(x))
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                let (sine, cosine) = Scalar::sin_cos(self.0);
                (Self(sine), Self(cosine))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(Scalar::sqrt(self.0))
            }
            #[inline(always)]
            fn signum0(self) -> Self {
                Self(self.0.signum0())
            }
            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                Self(multiply_add!(self.0, a.0, b.0))
            }
            #[inline(always)]
            fn sin_cos_each(angles: &[Self], sines: &mut [Self], cosines: &mut [Self]) {
                check_lengths(angles.len(), sines.len(), cosines.len());
                sin_cos_in_blocks(angles, sines, cosines);
            }
        }
    };
}
fused!(f64, Quad, [Quad; 3]);
fused!(f32, [Self; 3], [Self; 6]);

/// Angles in one block.
const BLOCK: usize = F64x4::LANES;

/// A float whose sine is computed four at a time in double precision. The sine of a single is exact to its
/// rounding.
trait SineInDouble: Scalar {
    /// Loads four of them.
    fn load(from: &[Self]) -> F64x4;
    /// Stores four of them.
    fn store(four: F64x4, to: &mut [Self]);
}

impl SineInDouble for FmaFloat<f64> {
    #[inline(always)]
    fn load(from: &[Self]) -> F64x4 {
        F64x4::load(View::<f64>::values(from))
    }
    #[inline(always)]
    fn store(four: F64x4, to: &mut [Self]) {
        four.store(View::<f64>::values_mut(to));
    }
}

impl SineInDouble for FmaFloat<f32> {
    #[inline(always)]
    fn load(from: &[Self]) -> F64x4 {
        let mut four = [0.0; BLOCK];
        for k in 0..BLOCK {
            four[k] = f64::from(from[k].0);
        }
        F64x4::from_array(&four)
    }
    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)]
    fn store(four: F64x4, to: &mut [Self]) {
        let four = four.to_array();
        for k in 0..BLOCK {
            to[k] = Self(four[k] as f32);
        }
    }
}

/// Sine and cosine of each angle, four at a time. The last block overlaps the one before: copying part of a
/// block takes longer than computing some of it twice.
#[inline(always)]
fn sin_cos_in_blocks<A: SineInDouble>(angles: &[A], sines: &mut [A], cosines: &mut [A]) {
    let count = angles.len();
    let (sines, cosines) = (&mut sines[..count], &mut cosines[..count]);
    if count < BLOCK {
        let (mut block, mut sine, mut cosine) = ([A::zero(); BLOCK], [A::zero(); BLOCK], [A::zero(); BLOCK]);
        block[..count].copy_from_slice(angles);
        sin_cos_of_block(&block, &mut sine, &mut cosine);
        sines.copy_from_slice(&sine[..count]);
        cosines.copy_from_slice(&cosine[..count]);
        return;
    }
    let mut start = 0;
    loop {
        let here = start..start + BLOCK;
        sin_cos_of_block(&angles[here.clone()], &mut sines[here.clone()], &mut cosines[here]);
        if start + BLOCK == count {
            return;
        }
        start = (start + BLOCK).min(count - BLOCK);
    }
}

/// Sine and cosine of four angles.
#[inline(always)]
fn sin_cos_of_block<A: SineInDouble>(angles: &[A], sines: &mut [A], cosines: &mut [A]) {
    let block = A::load(angles);
    if block.all_within(RANGE) {
        let (sine, cosine) = sine::sin_cos_f64(block);
        A::store(sine, sines);
        A::store(cosine, cosines);
    } else {
        sin_cos_one_by_one(angles, sines, cosines);
    }
}

/// Handles angles beyond the range of the reduction.
#[cold]
#[inline(never)]
fn sin_cos_one_by_one<A: SineInDouble>(angles: &[A], sines: &mut [A], cosines: &mut [A]) {
    for ((angle, sine), cosine) in angles.iter().zip(sines).zip(cosines) {
        (*sine, *cosine) = angle.sin_cos();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{InstructionSet, SplitMix64};

    /// The difference of two doubles of similar size, in units in the last place.
    fn ulps(a: f64, b: f64) -> f64 {
        (a - b).abs() / (f64::EPSILON * b.abs().max(f64::MIN_POSITIVE))
    }

    /// Compares with the standard library, which is itself within 1 ulp: 2 in all.
    fn check(angle: f64) {
        let (mut sine, mut cosine) = ([FmaFloat(0.0)], [FmaFloat(0.0)]);
        FmaFloat::sin_cos_each(&[FmaFloat(angle)], &mut sine, &mut cosine);
        let (s, c) = angle.sin_cos();
        assert!(ulps(sine[0].0, s) <= 2.0, "sin {angle:e}: {:e}, not {s:e}", sine[0].0);
        assert!(ulps(cosine[0].0, c) <= 2.0, "cos {angle:e}: {:e}, not {c:e}", cosine[0].0);
    }

    #[test]
    fn sine_and_cosine_agree_with_the_standard_library() {
        if !InstructionSet::has_registers() {
            return;
        }
        let mut random = SplitMix64::new(7);
        for scale in [1e-300, 1e-8, 1e-3, 1.0, 10.0, 1e3, 9.9e4, 1e8] {
            (0..if cfg!(miri) { 20 } else { 20_000 }).for_each(|_| check(random.uniform(-scale, scale)));
        }
        // Near multiples of π/2, where the reduction cancels most.
        for n in if cfg!(miri) { -9..9 } else { -2000..2000 } {
            let near = f64::from(n) * core::f64::consts::FRAC_PI_2;
            [near, near.next_up(), near.next_down(), near + 1e-9].into_iter().for_each(check);
        }
        [0.0, -0.0, 1e5, -1e5, f64::MAX].into_iter().for_each(check);
    }

    /// One angle out of range changes neither the other results nor their number.
    #[test]
    fn blocks_of_any_length_are_handled() {
        if !InstructionSet::has_registers() {
            return;
        }
        for count in 0..20 {
            let angles: Vec<FmaFloat<f64>> =
                (0..count).map(|k| FmaFloat(if k == 11 { 1e9 } else { f64::from(k) - 8.5 })).collect();
            let (mut sines, mut cosines) = (angles.clone(), angles.clone());
            FmaFloat::sin_cos_each(&angles, &mut sines, &mut cosines);
            for ((x, s), c) in angles.iter().zip(&sines).zip(&cosines) {
                let near = (s.0 - x.0.sin()).abs() < 1e-15 && (c.0 - x.0.cos()).abs() < 1e-15;
                assert!(near, "{x:?} {s:?} {c:?}");
            }
        }
        let (mut sine, mut cosine) = ([FmaFloat(0.0)], [FmaFloat(0.0)]);
        FmaFloat::sin_cos_each(&[FmaFloat(f64::NAN)], &mut sine, &mut cosine);
        assert!(sine[0].0.is_nan() && cosine[0].0.is_nan());
    }

    /// Double precision rounded once is within half an ulp of f32.
    #[test]
    fn single_precision_is_rounded_once() {
        if !InstructionSet::has_registers() {
            return;
        }
        let (mut sine, mut cosine) = ([FmaFloat(0.0f32)], [FmaFloat(0.0f32)]);
        for k in if cfg!(miri) { -9i16..9 } else { -1000..1000 } {
            let angle = f32::from(k) * 0.37;
            FmaFloat::sin_cos_each(&[FmaFloat(angle)], &mut sine, &mut cosine);
            let exact = f64::from(angle).sin_cos();
            assert!((f64::from(sine[0].0) - exact.0).abs() <= 0.5 * f64::from(f32::EPSILON), "{angle}");
            assert!((f64::from(cosine[0].0) - exact.1).abs() <= 0.5 * f64::from(f32::EPSILON), "{angle}");
        }
    }
}
