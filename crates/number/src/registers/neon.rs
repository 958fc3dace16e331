//! NEON of 64-bit ARM: 128-bit registers in pairs, so that operations need not wait for each other.
#![allow(clippy::wildcard_imports)]
#![allow(unused_unsafe)] // operations on pairs are safe functions, instructions of other sets are not

use core::arch::aarch64::*;
use core::fmt;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::{RANGE, copy_parts, operator, recompute_far_angles, register};
use crate::sine::{Quadrants, sin_cos_f32, sin_cos_f64};
use crate::{Scalar, StateLanes};

/// Two registers: the first lanes, and the following ones.
#[derive(Clone, Copy)]
pub(crate) struct Pair<R>(R, R);

/// Operations on pairs, from those on one register.
macro_rules! on_pairs {
    ($($name:ident($register:ty: $($x:ident),*) => $body:expr;)*) => {
        $(
            #[inline(always)]
            fn $name($($x: Pair<$register>),*) -> Pair<$register> {
                // SAFETY: every 64-bit ARM has NEON.
                unsafe { Pair({ $(let $x = $x.0;)* $body }, { $(let $x = $x.1;)* $body }) }
            }
        )*
    };
}
on_pairs! {
    add_f64(float64x2_t: a, b) => vaddq_f64(a, b);
    sub_f64(float64x2_t: a, b) => vsubq_f64(a, b);
    mul_f64(float64x2_t: a, b) => vmulq_f64(a, b);
    div_f64(float64x2_t: a, b) => vdivq_f64(a, b);
    mul_add_f64(float64x2_t: a, b, c) => vfmaq_f64(c, a, b);
    mul_sub_f64(float64x2_t: a, b, c) => vfmaq_f64(vnegq_f64(c), a, b);
    neg_mul_add_f64(float64x2_t: a, b, c) => vfmsq_f64(c, a, b);
    sqrt_f64(float64x2_t: a) => vsqrtq_f64(a);
    sign_f64(float64x2_t: a) => {
        let size = vbslq_f64(vdupq_n_u64(1 << 63), a, vdupq_n_f64(1.0));
        let sign = vbicq_u64(vreinterpretq_u64_f64(size), vceqzq_f64(a));
        vbslq_f64(vceqq_f64(a, a), vreinterpretq_f64_u64(sign), a)
    };
    add_f32(float32x4_t: a, b) => vaddq_f32(a, b);
    sub_f32(float32x4_t: a, b) => vsubq_f32(a, b);
    mul_f32(float32x4_t: a, b) => vmulq_f32(a, b);
    div_f32(float32x4_t: a, b) => vdivq_f32(a, b);
    mul_add_f32(float32x4_t: a, b, c) => vfmaq_f32(c, a, b);
    sqrt_f32(float32x4_t: a) => vsqrtq_f32(a);
    sign_f32(float32x4_t: a) => {
        let size = vbslq_f32(vdupq_n_u32(1 << 31), a, vdupq_n_f32(1.0));
        let sign = vbicq_u32(vreinterpretq_u32_f32(size), vceqzq_f32(a));
        vbslq_f32(vceqq_f32(a, a), vreinterpretq_f32_u32(sign), a)
    };
}

#[inline(always)]
fn splat_f64(x: f64) -> Pair<float64x2_t> {
    // SAFETY: every 64-bit ARM has NEON.
    unsafe { Pair(vdupq_n_f64(x), vdupq_n_f64(x)) }
}

#[inline(always)]
fn splat_f32(x: f32) -> Pair<float32x4_t> {
    // SAFETY: every 64-bit ARM has NEON.
    unsafe { Pair(vdupq_n_f32(x), vdupq_n_f32(x)) }
}

/// # Safety
/// `from` points at four doubles.
#[inline(always)]
unsafe fn load_f64(from: *const f64) -> Pair<float64x2_t> {
    // SAFETY: as the caller guarantees; the loads and stores need the alignment of a double only.
    unsafe { Pair(vld1q_f64(from), vld1q_f64(from.add(2))) }
}

/// # Safety
/// `to` is valid for writes of four doubles.
#[inline(always)]
unsafe fn store_f64(to: *mut f64, pair: Pair<float64x2_t>) {
    // SAFETY: as the caller guarantees; the loads and stores need the alignment of a double only.
    unsafe {
        vst1q_f64(to, pair.0);
        vst1q_f64(to.add(2), pair.1);
    }
}

/// # Safety
/// `from` points at eight singles.
#[inline(always)]
unsafe fn load_f32(from: *const f32) -> Pair<float32x4_t> {
    // SAFETY: as the caller guarantees; the loads and stores need the alignment of a single only.
    unsafe { Pair(vld1q_f32(from), vld1q_f32(from.add(4))) }
}

/// # Safety
/// `to` is valid for writes of eight singles.
#[inline(always)]
unsafe fn store_f32(to: *mut f32, pair: Pair<float32x4_t>) {
    // SAFETY: as the caller guarantees; the loads and stores need the alignment of a single only.
    unsafe {
        vst1q_f32(to, pair.0);
        vst1q_f32(to.add(4), pair.1);
    }
}

register!(
    /// Four doubles: two NEON registers.
    F64x4(Pair<float64x2_t>), f64, 4,
    splat_f64, load_f64, store_f64, add_f64, sub_f64, mul_f64, div_f64, mul_add_f64, sqrt_f64, sin_cos_f64
);
register!(
    /// Eight singles: two NEON registers.
    F32x8(Pair<float32x4_t>), f32, 8,
    splat_f32, load_f32, store_f32, add_f32, sub_f32, mul_f32, div_f32, mul_add_f32, sqrt_f32, sin_cos_f32
);
copy_parts!(F64x4, f64, 4);
copy_parts!(F32x8, f32, 8);

impl F64x4 {
    #[inline(always)]
    pub(crate) fn all_within(self, range: f64) -> bool {
        // SAFETY: every 64-bit ARM has NEON.
        unsafe {
            let range = vdupq_n_f64(range);
            let within = |x| vcltq_f64(vabsq_f64(x), range);
            let both = vandq_u64(within(self.0.0), within(self.0.1));
            vgetq_lane_u64::<0>(both) & vgetq_lane_u64::<1>(both) == u64::MAX
        }
    }

    #[inline(always)]
    pub(crate) fn sign(self) -> Self {
        Self(sign_f64(self.0))
    }

    #[inline(always)]
    pub(crate) fn transpose(rows: [Self; 4]) -> [Self; 4] {
        let [a, b, c, d] = rows.map(|row| row.0);
        // SAFETY: every 64-bit ARM has NEON.
        unsafe {
            [
                Self(Pair(vtrn1q_f64(a.0, b.0), vtrn1q_f64(c.0, d.0))),
                Self(Pair(vtrn2q_f64(a.0, b.0), vtrn2q_f64(c.0, d.0))),
                Self(Pair(vtrn1q_f64(a.1, b.1), vtrn1q_f64(c.1, d.1))),
                Self(Pair(vtrn2q_f64(a.1, b.1), vtrn2q_f64(c.1, d.1))),
            ]
        }
    }
}

/// [`Quadrants::turn`] for one register.
#[inline(always)]
fn turn_f64(shifted: float64x2_t, sine: float64x2_t, cosine: float64x2_t) -> (float64x2_t, float64x2_t) {
    // SAFETY: every 64-bit ARM has NEON.
    unsafe {
        let n = vreinterpretq_u64_f64(shifted);
        // Bit 0 of n selects the swap, bit 1 of n (of n + 1) the sign of the sine (cosine).
        let odd = vtstq_u64(n, vdupq_n_u64(1));
        let sign = vdupq_n_u64(1 << 63);
        let sine_sign = vandq_u64(vshlq_n_u64::<62>(n), sign);
        let cosine_sign = vandq_u64(vshlq_n_u64::<62>(vaddq_u64(n, vdupq_n_u64(1))), sign);
        let with = |x, sign| vreinterpretq_f64_u64(veorq_u64(vreinterpretq_u64_f64(x), sign));
        (with(vbslq_f64(odd, cosine, sine), sine_sign), with(vbslq_f64(odd, sine, cosine), cosine_sign))
    }
}

impl Quadrants for F64x4 {
    #[inline(always)]
    fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self) {
        let first = turn_f64(shifted.0.0, sine.0.0, cosine.0.0);
        let second = turn_f64(shifted.0.1, sine.0.1, cosine.0.1);
        (Self(Pair(first.0, second.0)), Self(Pair(first.1, second.1)))
    }
}

/// The columns of four rows of four.
#[inline(always)]
fn transpose_f32([a, b, c, d]: [float32x4_t; 4]) -> [float32x4_t; 4] {
    // SAFETY: every 64-bit ARM has NEON.
    unsafe {
        let pairs = |x, y| (vreinterpretq_f64_f32(vtrn1q_f32(x, y)), vreinterpretq_f64_f32(vtrn2q_f32(x, y)));
        let ((ab, ba), (cd, dc)) = (pairs(a, b), pairs(c, d));
        [
            vreinterpretq_f32_f64(vtrn1q_f64(ab, cd)),
            vreinterpretq_f32_f64(vtrn1q_f64(ba, dc)),
            vreinterpretq_f32_f64(vtrn2q_f64(ab, cd)),
            vreinterpretq_f32_f64(vtrn2q_f64(ba, dc)),
        ]
    }
}

impl F32x8 {
    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn all_within(self, range: f64) -> bool {
        // SAFETY: every 64-bit ARM has NEON.
        unsafe {
            let range = vdupq_n_f32(range as f32);
            let within = |x| vcltq_f32(vabsq_f32(x), range);
            vminvq_u32(vandq_u32(within(self.0.0), within(self.0.1))) == u32::MAX
        }
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

/// [`Quadrants::turn`] for one register, by the steps of `turn_f64`.
#[inline(always)]
fn turn_f32(shifted: float32x4_t, sine: float32x4_t, cosine: float32x4_t) -> (float32x4_t, float32x4_t) {
    // SAFETY: every 64-bit ARM has NEON.
    unsafe {
        let n = vreinterpretq_u32_f32(shifted);
        let odd = vtstq_u32(n, vdupq_n_u32(1));
        let sign = vdupq_n_u32(1 << 31);
        let sine_sign = vandq_u32(vshlq_n_u32::<30>(n), sign);
        let cosine_sign = vandq_u32(vshlq_n_u32::<30>(vaddq_u32(n, vdupq_n_u32(1))), sign);
        let with = |x, sign| vreinterpretq_f32_u32(veorq_u32(vreinterpretq_u32_f32(x), sign));
        (with(vbslq_f32(odd, cosine, sine), sine_sign), with(vbslq_f32(odd, sine, cosine), cosine_sign))
    }
}

impl Quadrants for F32x8 {
    #[inline(always)]
    fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self) {
        let first = turn_f32(shifted.0.0, sine.0.0, cosine.0.0);
        let second = turn_f32(shifted.0.1, sine.0.1, cosine.0.1);
        (Self(Pair(first.0, second.0)), Self(Pair(first.1, second.1)))
    }
}

/// Three doubles, padded to four, of one state.
pub(crate) mod four {
    use core::arch::aarch64::*;
    use core::fmt;

    use super::{
        Pair, add_f64, load_f64, mul_add_f64, mul_f64, mul_sub_f64, neg_mul_add_f64, splat_f64, store_f64,
        sub_f64,
    };

    /// Four doubles: (x, y) and (z, w).
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub(crate) struct Quad(Pair<float64x2_t>);

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
                    // SAFETY: every 64-bit ARM has NEON.
                    unsafe { Quad($body) }
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
        yzx(a) => Pair(vextq_f64::<1>(a.0, a.1), vcopyq_laneq_f64::<0, 0>(a.1, a.0));
        yxww(a) => Pair(vextq_f64::<1>(a.0, a.0), vdupq_laneq_f64::<1>(a.1));
        wzyw(a) => Pair(vextq_f64::<1>(a.1, a.1), vtrn2q_f64(a.0, a.1));
        zwxw(a) => Pair(a.1, vcopyq_laneq_f64::<0, 0>(a.1, a.0));
        evens(a, b) => Pair(vtrn1q_f64(a.0, b.0), vtrn1q_f64(a.1, b.1));
        odds(a, b) => Pair(vtrn2q_f64(a.0, b.0), vtrn2q_f64(a.1, b.1));
        low_halves(a, b) => Pair(a.0, b.0);
        high_halves(a, b) => Pair(a.1, b.1);
    }

    #[inline(always)]
    pub(crate) fn splat(x: f64) -> Quad {
        Quad(splat_f64(x))
    }

    #[inline(always)]
    pub(crate) fn lane<const I: usize>(Quad(a): Quad) -> Quad {
        // SAFETY: every 64-bit ARM has NEON.
        let lane = unsafe {
            match I {
                0 => vdupq_laneq_f64::<0>(a.0),
                1 => vdupq_laneq_f64::<1>(a.0),
                _ => vdupq_laneq_f64::<0>(a.1),
            }
        };
        Quad(Pair(lane, lane))
    }

    #[inline(always)]
    pub(crate) fn new([x, y, z]: [f64; 3]) -> Quad {
        load(&[x, y, z, 0.0])
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
        // SAFETY: every 64-bit ARM has NEON.
        unsafe { vaddvq_f64(a.0) + vgetq_lane_f64::<0>(a.1) }
    }
}
