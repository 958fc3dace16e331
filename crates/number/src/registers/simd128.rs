//! simd128 of WebAssembly: 128-bit registers in pairs, like those of NEON.
//!
//! There is no multiply-add that rounds once: the product is rounded before the sum. An engine without
//! simd128 rejects a whole module that contains such an instruction, so these functions are safe, except
//! loads and stores.
#![allow(clippy::wildcard_imports)]
#![allow(unused_unsafe)] // instructions of other sets are unsafe functions

use core::arch::wasm32::*;
use core::fmt;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::{RANGE, copy_parts, operator, recompute_far_angles, register};
use crate::sine::{Quadrants, sin_cos_f64};
use crate::{Scalar, StateLanes};

/// Two registers: the first lanes, and the following ones.
#[derive(Clone, Copy)]
pub(crate) struct Pair(v128, v128);

/// Operations on pairs, from those on one register.
macro_rules! on_pairs {
    ($($name:ident($($x:ident),*) => $body:expr;)*) => {
        $(
            #[inline(always)]
            fn $name($($x: Pair),*) -> Pair {
                Pair({ $(let $x = $x.0;)* $body }, { $(let $x = $x.1;)* $body })
            }
        )*
    };
}
on_pairs! {
    add_f64(a, b) => f64x2_add(a, b);
    sub_f64(a, b) => f64x2_sub(a, b);
    mul_f64(a, b) => f64x2_mul(a, b);
    div_f64(a, b) => f64x2_div(a, b);
    mul_add_f64(a, b, c) => f64x2_add(f64x2_mul(a, b), c);
    mul_sub_f64(a, b, c) => f64x2_sub(f64x2_mul(a, b), c);
    neg_mul_add_f64(a, b, c) => f64x2_sub(c, f64x2_mul(a, b));
    sqrt_f64(a) => f64x2_sqrt(a);
    sign_f64(a) => {
        let size = v128_bitselect(a, f64x2_splat(1.0), u64x2_splat(1 << 63));
        let sign = v128_and(size, f64x2_ne(a, f64x2_splat(0.0)));
        v128_bitselect(sign, a, f64x2_eq(a, a))
    };
    add_f32(a, b) => f32x4_add(a, b);
    sub_f32(a, b) => f32x4_sub(a, b);
    mul_f32(a, b) => f32x4_mul(a, b);
    div_f32(a, b) => f32x4_div(a, b);
    mul_add_f32(a, b, c) => f32x4_add(f32x4_mul(a, b), c);
    sqrt_f32(a) => f32x4_sqrt(a);
    sign_f32(a) => {
        let size = v128_bitselect(a, f32x4_splat(1.0), u32x4_splat(1 << 31));
        let sign = v128_and(size, f32x4_ne(a, f32x4_splat(0.0)));
        v128_bitselect(sign, a, f32x4_eq(a, a))
    };
}

#[inline(always)]
fn splat_f64(x: f64) -> Pair {
    Pair(f64x2_splat(x), f64x2_splat(x))
}

#[inline(always)]
fn splat_f32(x: f32) -> Pair {
    Pair(f32x4_splat(x), f32x4_splat(x))
}

/// # Safety
/// `from` points at four doubles.
#[inline(always)]
unsafe fn load_f64(from: *const f64) -> Pair {
    // SAFETY: as the caller guarantees; a register is loaded from any address.
    unsafe { Pair(v128_load(from.cast()), v128_load(from.add(2).cast())) }
}

/// # Safety
/// `to` is valid for writes of four doubles.
#[inline(always)]
unsafe fn store_f64(to: *mut f64, pair: Pair) {
    // SAFETY: as the caller guarantees; a register is stored to any address.
    unsafe {
        v128_store(to.cast(), pair.0);
        v128_store(to.add(2).cast(), pair.1);
    }
}

/// # Safety
/// `from` points at eight singles.
#[inline(always)]
unsafe fn load_f32(from: *const f32) -> Pair {
    // SAFETY: as the caller guarantees; a register is loaded from any address.
    unsafe { Pair(v128_load(from.cast()), v128_load(from.add(4).cast())) }
}

/// # Safety
/// `to` is valid for writes of eight singles.
#[inline(always)]
unsafe fn store_f32(to: *mut f32, pair: Pair) {
    // SAFETY: as the caller guarantees; a register is stored to any address.
    unsafe {
        v128_store(to.cast(), pair.0);
        v128_store(to.add(4).cast(), pair.1);
    }
}

register!(
    /// Four doubles: two registers of simd128.
    F64x4(Pair), f64, 4,
    splat_f64, load_f64, store_f64, add_f64, sub_f64, mul_f64, div_f64, mul_add_f64, sqrt_f64, sin_cos_f64
);
register!(
    /// Eight singles: two registers of simd128.
    F32x8(Pair), f32, 8,
    splat_f32, load_f32, store_f32, add_f32, sub_f32, mul_f32, div_f32, mul_add_f32, sqrt_f32, sin_cos_in_double
);
copy_parts!(F64x4, f64, 4);
copy_parts!(F32x8, f32, 8);

impl F64x4 {
    #[inline(always)]
    pub(crate) fn all_within(self, range: f64) -> bool {
        let within = |x| f64x2_lt(f64x2_abs(x), f64x2_splat(range));
        i64x2_all_true(v128_and(within(self.0.0), within(self.0.1)))
    }

    #[inline(always)]
    pub(crate) fn sign(self) -> Self {
        Self(sign_f64(self.0))
    }

    #[inline(always)]
    pub(crate) fn transpose(rows: [Self; 4]) -> [Self; 4] {
        let [a, b, c, d] = rows.map(|row| row.0);
        [
            Self(Pair(i64x2_shuffle::<0, 2>(a.0, b.0), i64x2_shuffle::<0, 2>(c.0, d.0))),
            Self(Pair(i64x2_shuffle::<1, 3>(a.0, b.0), i64x2_shuffle::<1, 3>(c.0, d.0))),
            Self(Pair(i64x2_shuffle::<0, 2>(a.1, b.1), i64x2_shuffle::<0, 2>(c.1, d.1))),
            Self(Pair(i64x2_shuffle::<1, 3>(a.1, b.1), i64x2_shuffle::<1, 3>(c.1, d.1))),
        ]
    }
}

/// [`Quadrants::turn`] for one register.
#[inline(always)]
fn turn_f64(n: v128, sine: v128, cosine: v128) -> (v128, v128) {
    // Bit 0 of n selects the swap, bit 1 of n (of n + 1) the sign of the sine (cosine).
    let (one, sign) = (u64x2_splat(1), u64x2_splat(1 << 63));
    let odd = i64x2_eq(v128_and(n, one), one);
    let sine_sign = v128_and(i64x2_shl(n, 62), sign);
    let cosine_sign = v128_and(i64x2_shl(i64x2_add(n, one), 62), sign);
    (
        v128_xor(v128_bitselect(cosine, sine, odd), sine_sign),
        v128_xor(v128_bitselect(sine, cosine, odd), cosine_sign),
    )
}

impl Quadrants for F64x4 {
    #[inline(always)]
    fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self) {
        let first = turn_f64(shifted.0.0, sine.0.0, cosine.0.0);
        let second = turn_f64(shifted.0.1, sine.0.1, cosine.0.1);
        (Self(Pair(first.0, second.0)), Self(Pair(first.1, second.1)))
    }
}

/// The steps of [`turn_f64`].
#[inline(always)]
fn turn_f32(n: v128, sine: v128, cosine: v128) -> (v128, v128) {
    let (one, sign) = (u32x4_splat(1), u32x4_splat(1 << 31));
    let odd = i32x4_eq(v128_and(n, one), one);
    let sine_sign = v128_and(i32x4_shl(n, 30), sign);
    let cosine_sign = v128_and(i32x4_shl(i32x4_add(n, one), 30), sign);
    (
        v128_xor(v128_bitselect(cosine, sine, odd), sine_sign),
        v128_xor(v128_bitselect(sine, cosine, odd), cosine_sign),
    )
}

impl Quadrants for F32x8 {
    #[inline(always)]
    fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self) {
        let first = turn_f32(shifted.0.0, sine.0.0, cosine.0.0);
        let second = turn_f32(shifted.0.1, sine.0.1, cosine.0.1);
        (Self(Pair(first.0, second.0)), Self(Pair(first.1, second.1)))
    }
}

/// The columns of four rows of four.
#[inline(always)]
fn transpose_f32([a, b, c, d]: [v128; 4]) -> [v128; 4] {
    let pairs = |x, y| (i32x4_shuffle::<0, 4, 1, 5>(x, y), i32x4_shuffle::<2, 6, 3, 7>(x, y));
    let ((ab, ba), (cd, dc)) = (pairs(a, b), pairs(c, d));
    [
        i64x2_shuffle::<0, 2>(ab, cd),
        i64x2_shuffle::<1, 3>(ab, cd),
        i64x2_shuffle::<0, 2>(ba, dc),
        i64x2_shuffle::<1, 3>(ba, dc),
    ]
}

impl F32x8 {
    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn all_within(self, range: f64) -> bool {
        let within = |x| f32x4_lt(f32x4_abs(x), f32x4_splat(range as f32));
        i32x4_all_true(v128_and(within(self.0.0), within(self.0.1)))
    }

    #[inline(always)]
    pub(crate) fn sign(self) -> Self {
        Self(sign_f32(self.0))
    }

    /// By quarters of four rows and four columns.
    #[inline(always)]
    pub(crate) fn transpose(rows: [Self; 8]) -> [Self; 8] {
        let [a, b, c, d, e, f, g, h] = rows.map(|row| row.0);
        let (above, below) = (transpose_f32([a.0, b.0, c.0, d.0]), transpose_f32([e.0, f.0, g.0, h.0]));
        let left = [0, 1, 2, 3].map(|k| Self(Pair(above[k], below[k])));
        let (above, below) = (transpose_f32([a.1, b.1, c.1, d.1]), transpose_f32([e.1, f.1, g.1, h.1]));
        let right = [0, 1, 2, 3].map(|k| Self(Pair(above[k], below[k])));
        [left[0], left[1], left[2], left[3], right[0], right[1], right[2], right[3]]
    }
}

/// Sine and cosine of singles in double precision: the reduction of singles needs a multiply-add that rounds
/// once.
#[inline(always)]
fn sin_cos_in_double(x: F32x8) -> (F32x8, F32x8) {
    let four = |x| {
        let high = i64x2_shuffle::<1, 1>(x, x);
        let (sine, cosine) =
            sin_cos_f64(F64x4(Pair(f64x2_promote_low_f32x4(x), f64x2_promote_low_f32x4(high))));
        (demote(sine), demote(cosine))
    };
    let (first, second) = (four(x.0.0), four(x.0.1));
    (F32x8(Pair(first.0, second.0)), F32x8(Pair(first.1, second.1)))
}

/// Four doubles as singles.
#[inline(always)]
fn demote(F64x4(four): F64x4) -> v128 {
    i64x2_shuffle::<0, 2>(f32x4_demote_f64x2_zero(four.0), f32x4_demote_f64x2_zero(four.1))
}

/// Three doubles, padded to four, of one state.
pub(crate) mod four {
    use core::arch::wasm32::*;
    use core::fmt;

    use super::{
        Pair, add_f64, load_f64, mul_add_f64, mul_f64, mul_sub_f64, neg_mul_add_f64, splat_f64, store_f64,
        sub_f64,
    };

    /// Four doubles: (x, y) and (z, w).
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub(crate) struct Quad(Pair);

    impl fmt::Debug for Quad {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            store(*self).fmt(f)
        }
    }

    macro_rules! operations {
        ($($name:ident($($x:ident),*) => $body:expr;)*) => {
            $(
                #[inline(always)]
                pub(crate) fn $name($(Quad($x): Quad),*) -> Quad {
                    Quad($body)
                }
            )*
        };
    }
    operations! {
        add(a, b) => add_f64(a, b);
        sub(a, b) => sub_f64(a, b);
        mul(a, b) => mul_f64(a, b);
        mul_add(a, b, c) => mul_add_f64(a, b, c);
        mul_sub(a, b, c) => mul_sub_f64(a, b, c);
        neg_mul_add(a, b, c) => neg_mul_add_f64(a, b, c);
        zero() => splat_f64(0.0);
        yzx(a) => Pair(i64x2_shuffle::<1, 2>(a.0, a.1), i64x2_shuffle::<0, 3>(a.0, a.1));
        yxww(a) => Pair(i64x2_shuffle::<1, 0>(a.0, a.0), i64x2_shuffle::<1, 1>(a.1, a.1));
        wzyw(a) => Pair(i64x2_shuffle::<1, 0>(a.1, a.1), i64x2_shuffle::<1, 3>(a.0, a.1));
        zwxw(a) => Pair(a.1, i64x2_shuffle::<0, 3>(a.0, a.1));
        evens(a, b) => Pair(i64x2_shuffle::<0, 2>(a.0, b.0), i64x2_shuffle::<0, 2>(a.1, b.1));
        odds(a, b) => Pair(i64x2_shuffle::<1, 3>(a.0, b.0), i64x2_shuffle::<1, 3>(a.1, b.1));
        low_halves(a, b) => Pair(a.0, b.0);
        high_halves(a, b) => Pair(a.1, b.1);
    }

    #[inline(always)]
    pub(crate) fn splat(x: f64) -> Quad {
        Quad(splat_f64(x))
    }

    #[inline(always)]
    pub(crate) fn lane<const I: usize>(Quad(a): Quad) -> Quad {
        let lane = match I {
            0 => i64x2_shuffle::<0, 0>(a.0, a.0),
            1 => i64x2_shuffle::<1, 1>(a.0, a.0),
            _ => i64x2_shuffle::<0, 0>(a.1, a.1),
        };
        Quad(Pair(lane, lane))
    }

    #[inline(always)]
    pub(crate) fn new([x, y, z]: [f64; 3]) -> Quad {
        Quad(Pair(f64x2(x, y), f64x2(z, 0.0)))
    }

    #[inline(always)]
    pub(crate) fn load(x: &[f64; 4]) -> Quad {
        // SAFETY: `x` points at four doubles.
        unsafe { Quad(load_f64(x.as_ptr())) }
    }

    #[inline(always)]
    pub(crate) fn store(a: Quad) -> [f64; 4] {
        let mut x = [0.0; 4];
        // SAFETY: `x` holds four doubles.
        unsafe { store_f64(x.as_mut_ptr(), a.0) };
        x
    }

    /// x + y + z.
    #[inline(always)]
    pub(crate) fn sum(Quad(a): Quad) -> f64 {
        f64x2_extract_lane::<0>(a.0) + f64x2_extract_lane::<1>(a.0) + f64x2_extract_lane::<0>(a.1)
    }
}
