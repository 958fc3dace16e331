//! Sine and cosine of several angles at once.
//!
//! x is brought to r = x − n π/2, |r| ≤ π/4, with π/2 in three parts whose products with n are exact for
//! |n| < 2²⁰ (Cody and Waite, *Software Manual for the Elementary Functions*, 1980), then sin r and cos r are
//! the minimax polynomials of FDLIBM's `k_sin.c` and `k_cos.c` (Sun Microsystems, 1993). There is no
//! branch, so the lanes compile to vector instructions. Within 1 ulp for |x| < 1e5 (tested); larger and
//! non-finite angles go to the standard library one by one.

use crate::{Fused, Quad, Scalar, Symmetric, Triple};

/// The largest |x| \[rad\] that the reduction takes.
pub(crate) const RANGE: f64 = 1e5;

/// Angles handled at once.
const LANES: usize = 4;

/// A hardware float.
pub trait Float: Scalar + PartialOrd {
    /// [`Scalar::Triple`] of `Fused<Self>`.
    type FusedTriple: Triple<Fused<Self>>;
    /// [`Scalar::Symmetric`] of `Fused<Self>`.
    type FusedSymmetric: Symmetric<Fused<Self>, Self::FusedTriple>;
    /// `self · a + b`, rounded once.
    fn fused_mul_add(self, a: Self, b: Self) -> Self;
    /// Sine and cosine of four angles, each below 1e5 in size.
    fn sin_cos_lanes(angles: &[Fused<Self>; LANES]) -> ([Fused<Self>; LANES], [Fused<Self>; LANES]);
    /// |x| < 1e5; false for NaN.
    fn in_range(self) -> bool;
}

impl Float for f64 {
    type FusedTriple = Quad;
    type FusedSymmetric = [Quad; 3];
    #[inline(always)]
    fn fused_mul_add(self, a: Self, b: Self) -> Self {
        f64::mul_add(self, a, b)
    }
    #[inline(always)]
    fn sin_cos_lanes(angles: &[Fused<Self>; LANES]) -> ([Fused<Self>; LANES], [Fused<Self>; LANES]) {
        lanes_f64(angles)
    }
    #[inline(always)]
    fn in_range(self) -> bool {
        self.abs() < RANGE
    }
}

/// Sine and cosine of each angle, in blocks of lanes. The last block overlaps the one before it: copying part of
/// a block takes longer than computing some of it twice.
#[inline(always)]
pub(crate) fn sin_cos_each<T: Float, A: Scalar<Fused = Fused<T>>>(
    angles: &[A],
    sines: &mut [Fused<T>],
    cosines: &mut [Fused<T>],
) {
    let count = angles.len();
    assert!(count == sines.len() && count == cosines.len());
    if count < LANES {
        let mut block = [<Fused<T> as Scalar>::zero(); LANES];
        for (k, angle) in angles.iter().enumerate() {
            block[k] = angle.fuse();
        }
        let (sine, cosine) = sin_cos_block(&block);
        for k in 0..count {
            (sines[k], cosines[k]) = (sine[k], cosine[k]);
        }
        return;
    }
    let mut start = 0;
    loop {
        let angles = &angles[start..start + LANES];
        let mut block = [<Fused<T> as Scalar>::zero(); LANES];
        for k in 0..LANES {
            block[k] = angles[k].fuse();
        }
        let (sine, cosine) = sin_cos_block(&block);
        sines[start..start + LANES].copy_from_slice(&sine);
        cosines[start..start + LANES].copy_from_slice(&cosine);
        if start + LANES == count {
            return;
        }
        start = (start + LANES).min(count - LANES);
    }
}

/// Sine and cosine of one block of angles.
#[inline(always)]
fn sin_cos_block<T: Float>(block: &[Fused<T>; LANES]) -> ([Fused<T>; LANES], [Fused<T>; LANES]) {
    let mut all_in_range = true;
    for angle in block {
        all_in_range &= angle.0.in_range();
    }
    if all_in_range { T::sin_cos_lanes(block) } else { one_by_one(block) }
}

/// For angles beyond the reduction's range.
#[cold]
fn one_by_one<T: Float>(block: &[Fused<T>; LANES]) -> ([Fused<T>; LANES], [Fused<T>; LANES]) {
    let pairs = block.map(Scalar::sin_cos);
    (pairs.map(|(sine, _)| sine), pairs.map(|(_, cosine)| cosine))
}

#[inline(always)]
#[allow(clippy::excessive_precision)] // as published
fn lanes_f64(angles: &[Fused<f64>; LANES]) -> ([Fused<f64>; LANES], [Fused<f64>; LANES]) {
    // π/2 = P1 + P2 + P3 with 33 bits in each of the first two.
    const P1: f64 = 1.570_796_326_734_125_614_17;
    const P2: f64 = 6.077_100_506_303_965_976_60e-11;
    const P3: f64 = 2.022_266_248_795_950_631_54e-21;
    // Adding 1.5·2⁵² rounds to an integer and leaves it in the low bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const SIN: [f64; 6] = [
        -1.666_666_666_666_663_243_48e-1,
        8.333_333_333_322_489_461_24e-3,
        -1.984_126_982_985_794_931_34e-4,
        2.755_731_370_707_006_767_89e-6,
        -2.505_076_025_340_686_341_95e-8,
        1.589_690_995_211_550_102_21e-10,
    ];
    const COS: [f64; 6] = [
        4.166_666_666_666_660_190_37e-2,
        -1.388_888_888_887_410_957_49e-3,
        2.480_158_728_947_672_941_78e-5,
        -2.755_731_435_139_066_330_35e-7,
        2.087_572_321_298_174_827_90e-9,
        -1.135_964_755_778_819_482_65e-11,
    ];
    // In loops, not by iterators' adapters: what is not inlined is compiled without fused multiply-adds.
    #[inline(always)]
    fn fma(a: f64, b: f64, c: f64) -> f64 {
        f64::mul_add(a, b, c)
    }
    let mut sines = [Fused(0.0); LANES];
    let mut cosines = [Fused(0.0); LANES];
    for k in 0..LANES {
        let x = angles[k].0;
        let shifted = fma(x, core::f64::consts::FRAC_2_PI, ROUND);
        let n = shifted - ROUND;
        let quadrant = shifted.to_bits();
        let r = fma(-n, P3, fma(-n, P2, fma(-n, P1, x)));
        let z = r * r;
        let mut s = SIN[5];
        for i in (1..5).rev() {
            s = fma(s, z, SIN[i]);
        }
        let sine = fma(r * z, fma(s, z, SIN[0]), r);
        let mut c = COS[5];
        for i in (0..5).rev() {
            c = fma(c, z, COS[i]);
        }
        let half = 0.5 * z;
        let w = 1.0 - half;
        let cosine = w + ((1.0 - w) - half + z * z * c);
        // Odd quadrants swap the two; the sign of each follows from the quadrant's two bits.
        let swap = (quadrant & 1).wrapping_neg();
        let (s, c) = (sine.to_bits(), cosine.to_bits());
        let sine = (s & !swap) | (c & swap);
        let cosine = (c & !swap) | (s & swap);
        sines[k] = Fused(f64::from_bits(sine ^ ((quadrant & 2) << 62)));
        cosines[k] = Fused(f64::from_bits(cosine ^ ((quadrant.wrapping_add(1) & 2) << 62)));
    }
    (sines, cosines)
}

impl Float for f32 {
    type FusedTriple = [Fused<f32>; 3];
    type FusedSymmetric = [Fused<f32>; 6];
    #[inline(always)]
    fn fused_mul_add(self, a: Self, b: Self) -> Self {
        f32::mul_add(self, a, b)
    }
    /// In double precision: exact to f32's rounding, at half the lanes.
    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)]
    fn sin_cos_lanes(angles: &[Fused<Self>; LANES]) -> ([Fused<Self>; LANES], [Fused<Self>; LANES]) {
        let (sine, cosine) = lanes_f64(&angles.map(|x| Fused(f64::from(x.0))));
        (sine.map(|x| Fused(x.0 as f32)), cosine.map(|x| Fused(x.0 as f32)))
    }
    #[inline(always)]
    fn in_range(self) -> bool {
        f64::from(self).abs() < RANGE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;

    /// Units in the last place between two doubles of like size.
    fn ulps(a: f64, b: f64) -> f64 {
        (a - b).abs() / (f64::EPSILON * b.abs().max(f64::MIN_POSITIVE))
    }

    /// Against the standard library, which is itself within 1 ulp: 2 in all.
    fn check(angle: f64) {
        let (mut sine, mut cosine) = ([Fused(0.0)], [Fused(0.0)]);
        sin_cos_each(&[angle], &mut sine, &mut cosine);
        let (s, c) = angle.sin_cos();
        assert!(ulps(sine[0].0, s) <= 2.0, "sin {angle:e}: {:e}, not {s:e}", sine[0].0);
        assert!(ulps(cosine[0].0, c) <= 2.0, "cos {angle:e}: {:e}, not {c:e}", cosine[0].0);
    }

    #[test]
    fn sine_and_cosine_agree_with_the_standard_library() {
        let mut random = SplitMix64::new(7);
        for scale in [1e-300, 1e-8, 1e-3, 1.0, 10.0, 1e3, 9.9e4, 1e8] {
            (0..20_000).for_each(|_| check(random.uniform(-scale, scale)));
        }
        // Beside the multiples of π/2, where the reduction cancels most.
        for n in -2000..2000 {
            let near = f64::from(n) * core::f64::consts::FRAC_PI_2;
            [near, near.next_up(), near.next_down(), near + 1e-9].into_iter().for_each(check);
        }
        [0.0, -0.0, 1e5, -1e5, f64::MAX].into_iter().for_each(check);
    }

    /// One angle out of range changes neither its neighbours nor their number.
    #[test]
    fn blocks_of_any_length_are_handled() {
        let angles: Vec<Fused<f64>> =
            (0..19).map(|k| Fused(if k == 11 { 1e9 } else { f64::from(k) - 8.5 })).collect();
        let (mut sines, mut cosines) = (angles.clone(), angles.clone());
        sin_cos_each(&angles, &mut sines, &mut cosines);
        for ((x, s), c) in angles.iter().zip(&sines).zip(&cosines) {
            assert!((s.0 - x.0.sin()).abs() < 1e-15 && (c.0 - x.0.cos()).abs() < 1e-15, "{x:?} {s:?} {c:?}");
        }
        sin_cos_each(&[Fused(f64::NAN)], &mut sines[..1], &mut cosines[..1]);
        assert!(sines[0].0.is_nan() && cosines[0].0.is_nan());
    }

    /// Double precision rounded once is within half an ulp of f32.
    #[test]
    fn single_precision_is_rounded_once() {
        let (mut sine, mut cosine) = ([Fused(0.0f32)], [Fused(0.0f32)]);
        for k in -1000i16..1000 {
            let angle = f32::from(k) * 0.37;
            sin_cos_each(&[angle], &mut sine, &mut cosine);
            let exact = f64::from(angle).sin_cos();
            assert!((f64::from(sine[0].0) - exact.0).abs() <= 0.5 * f64::from(f32::EPSILON), "{angle}");
            assert!((f64::from(cosine[0].0) - exact.1).abs() <= 0.5 * f64::from(f32::EPSILON), "{angle}");
        }
    }
}
