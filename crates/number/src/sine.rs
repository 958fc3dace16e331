//! Sine and cosine of the angles in one vector register, without a branch.
//!
//! x is reduced to r = x − n π/2, |r| ≤ π/4, with π/2 in three parts. In double precision the first two parts
//! have 33 bits. Their products with n are exact for |n| < 2²⁰ (Cody and Waite, *Software Manual for the
//! Elementary Functions*, 1980). sin r and cos r are the minimax polynomials of FDLIBM's `k_sin.c` and
//! `k_cos.c` (Sun Microsystems, 1993), within 1 ulp. In single precision the parts have 24 bits, and the
//! first product and difference are exact in a fused multiply-add. The polynomials are those of the Cephes
//! library's `sinf.c` (S. L. Moshier, 1992), within 2 ulp. Both hold for |x| < 1e5 (tested); larger and
//! non-finite angles are passed to the standard library one by one. WebAssembly has no fused multiply-add:
//! its singles are computed as doubles. Machines without fused multiply-add whose doubles are slow use
//! [`sin_cos_f32_in_short_parts`], whose products with n are exact without it for |x| < 8192.

use crate::Scalar;

/// The bound on |x| \[rad\] of the reduction.
pub const RANGE: f64 = 1e5;

/// The operation that the polynomials need besides arithmetic.
pub trait Quadrants: Scalar {
    /// Sine and cosine of r + n π/2 from those of r; the lowest bits of `shifted` are n.
    fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self);
}

macro_rules! quadrants_of_float {
    ($float:ty) => {
        impl Quadrants for $float {
            #[inline(always)]
            fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self) {
                let n = shifted.to_bits();
                let (sine, cosine) = if n & 1 == 1 { (cosine, sine) } else { (sine, cosine) };
                (if n & 2 == 0 { sine } else { -sine }, if (n + 1) & 2 == 0 { cosine } else { -cosine })
            }
        }
    };
}
quadrants_of_float!(f64);
quadrants_of_float!(f32);

/// (sin x, cos x) in double precision for |x| < [`RANGE`].
///
/// ```
/// let (sine, cosine) = robot_dynamics_number::sine::sin_cos_f64(2.0_f64);
/// assert!((sine - 2.0_f64.sin()).abs() < 2e-16 && (cosine - 2.0_f64.cos()).abs() < 2e-16);
/// ```
#[inline(always)]
#[allow(clippy::excessive_precision)] // as published
pub fn sin_cos_f64<V: Quadrants>(x: V) -> (V, V) {
    let k = V::from_f64;
    // Adding 1.5·2⁵² rounds to an integer and leaves it in the low bits.
    let round = k(6_755_399_441_055_744.0);
    let shifted = x.mul_add(k(core::f64::consts::FRAC_2_PI), round);
    let n = -(shifted - round);
    let r = n.mul_add(k(1.570_796_326_734_125_614_17), x);
    let r = n.mul_add(k(6.077_100_506_303_965_976_60e-11), r);
    let r = n.mul_add(k(2.022_266_248_795_950_631_54e-21), r);
    let z = r * r;
    let s = k(1.589_690_995_211_550_102_21e-10);
    let s = s.mul_add(z, k(-2.505_076_025_340_686_341_95e-8));
    let s = s.mul_add(z, k(2.755_731_370_707_006_767_89e-6));
    let s = s.mul_add(z, k(-1.984_126_982_985_794_931_34e-4));
    let s = s.mul_add(z, k(8.333_333_333_322_489_461_24e-3));
    let s = s.mul_add(z, k(-1.666_666_666_666_663_243_48e-1));
    let sine = (r * z).mul_add(s, r);
    let c = k(-1.135_964_755_778_819_482_65e-11);
    let c = c.mul_add(z, k(2.087_572_321_298_174_827_90e-9));
    let c = c.mul_add(z, k(-2.755_731_435_139_066_330_35e-7));
    let c = c.mul_add(z, k(2.480_158_728_947_672_941_78e-5));
    let c = c.mul_add(z, k(-1.388_888_888_887_410_957_49e-3));
    let c = c.mul_add(z, k(4.166_666_666_666_660_190_37e-2));
    let half = z * k(0.5);
    let w = k(1.0) - half;
    let cosine = w + ((k(1.0) - w) - half + z * z * c);
    V::turn(shifted, sine, cosine)
}

/// (sin x, cos x) in single precision for |x| < [`RANGE`], with fused multiply-adds.
///
/// ```
/// let (sine, cosine) = robot_dynamics_number::sine::sin_cos_f32(0.5_f32); // no reduction is needed
/// assert!((sine - 0.5_f32.sin()).abs() < 1e-7 && (cosine - 0.5_f32.cos()).abs() < 1e-7);
/// ```
#[inline(always)]
pub fn sin_cos_f32<V: Quadrants>(x: V) -> (V, V) {
    let k = V::from_f64;
    // 1.5·2²³.
    let round = k(12_582_912.0);
    let shifted = x.mul_add(k(core::f64::consts::FRAC_2_PI), round);
    let n = -(shifted - round);
    // π/2 = 1.570_796_326_794_896_619_231...
    let r = n.mul_add(k(1.570_796_370_506_286_6), x);
    let r = n.mul_add(k(-4.371_138_828_673_793e-8), r);
    let r = n.mul_add(k(-1.715_124_510_005_881_9e-15), r);
    of_reduced_f32(shifted, r)
}

/// The bound on |x| \[rad\] of [`sin_cos_f32_in_short_parts`].
pub const SHORT_RANGE: f64 = 8192.0;

/// (sin x, cos x) in single precision for |x| < [`SHORT_RANGE`], multiply-adds fused or not. The first two
/// parts of π/2 have 8 and 11 bits, so that their products with n, of at most 13 bits, are exact.
///
/// ```
/// let (sine, cosine) = robot_dynamics_number::sine::sin_cos_f32_in_short_parts(8000.0_f32);
/// assert!((sine - 8000.0_f32.sin()).abs() < 1e-7 && (cosine - 8000.0_f32.cos()).abs() < 1e-7);
/// ```
#[inline(always)]
pub fn sin_cos_f32_in_short_parts<V: Quadrants>(x: V) -> (V, V) {
    let k = V::from_f64;
    let round = k(12_582_912.0);
    let shifted = x.mul_add(k(core::f64::consts::FRAC_2_PI), round);
    let n = -(shifted - round);
    let r = SHORT_PARTS.iter().fold(x, |r, &part| n.mul_add(k(part), r));
    of_reduced_f32(shifted, r)
}

/// π/2 in parts of 8, 11 and 24 bits.
pub const SHORT_PARTS: [f64; 3] = [1.570_312_5, 4.837_512_969_970_703e-4, 7.549_790_126_404_332e-8];

/// Sine and cosine of r + n π/2 for |r| ≤ π/4 by the polynomials of single precision.
///
/// ```
/// let (sine, cosine) = robot_dynamics_number::sine::of_reduced_f32(12_582_912.0 + 1.0, 0.5_f32); // n = 1 in the lowest bits
/// assert!((sine - 0.5_f32.cos()).abs() < 1e-7 && (cosine + 0.5_f32.sin()).abs() < 1e-7);
/// ```
#[inline(always)]
pub fn of_reduced_f32<V: Quadrants>(shifted: V, r: V) -> (V, V) {
    let k = V::from_f64;
    let z = r * r;
    let s = k(-1.951_529_589_1e-4).mul_add(z, k(8.332_160_873_6e-3)).mul_add(z, k(-1.666_665_461_1e-1));
    let sine = (r * z).mul_add(s, r);
    let c = k(2.443_315_711_809_948e-5)
        .mul_add(z, k(-1.388_731_625_493_765e-3))
        .mul_add(z, k(4.166_664_568_298_827e-2));
    let cosine = (z * z).mul_add(c, z.mul_add(k(-0.5), k(1.0)));
    V::turn(shifted, sine, cosine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;

    /// Without fused multiply-adds, over the whole range, the sine is within a unit in the last place of 1 of
    /// the standard library. Where the result is small, it is within two of its own units, so the reduction
    /// loses no accuracy.
    #[test]
    fn portable_sines_agree_with_the_standard_library() {
        let mut random = SplitMix64::new(11);
        for scale in [1e-30, 1e-4, 1.0, 20.0, 1e3, 8000.0, 9e4] {
            for _ in 0..if cfg!(miri) { 20 } else { 20_000 } {
                let x = random.uniform(-scale, scale);
                let (sine, cosine) = sin_cos_f64(x);
                for (found, expected) in [(sine, x.sin()), (cosine, x.cos())] {
                    assert!(
                        (found - expected).abs() <= 2.0 * f64::EPSILON * expected.abs(),
                        "{x:e}: {found:e}"
                    );
                }
                if scale < SHORT_RANGE {
                    single(x);
                }
            }
        }
    }

    #[allow(clippy::cast_possible_truncation)]
    fn single(x: f64) {
        let x = x as f32;
        let (sine, cosine) = sin_cos_f32_in_short_parts(x);
        let exact = f64::from(x).sin_cos();
        for (found, exact) in [(sine, exact.0), (cosine, exact.1)] {
            let off = (f64::from(found) - exact).abs();
            assert!(off <= 2.0 * f64::from(f32::EPSILON) * exact.abs() + 2e-11, "{x:e}: {found:e}");
        }
    }
}
