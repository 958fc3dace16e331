//! Sine and cosine of the angles in one vector register, without a branch.
//!
//! x is brought to r = x − n π/2, |r| ≤ π/4, with π/2 in three parts. In double precision the first two parts have 33
//! bits, so that their products with n are exact for |n| < 2²⁰ (Cody and Waite, *Software Manual for the Elementary
//! Functions*, 1980), and sin r and cos r are the minimax polynomials of FDLIBM's `k_sin.c` and `k_cos.c` (Sun
//! Microsystems, 1993): within 1 ulp. In single precision the parts have 24 bits (the first product and difference are
//! exact in a fused multiply-add), and the polynomials are those of the Cephes library's `sinf.c` (S. L. Moshier,
//! 1992): within 2 ulp. Both for |x| < 1e5 (tested); larger and non-finite angles go to the standard library one by
//! one. WebAssembly has no fused multiply-add: its singles take the way of the doubles.

use crate::Scalar;

/// The largest |x| \[rad\] that the reduction takes.
pub(crate) const RANGE: f64 = 1e5;

/// What the two polynomials need besides arithmetic.
pub(crate) trait Quadrants: Scalar {
    /// Sine and cosine of r + n π/2 from those of r; the lowest bits of `shifted` hold n.
    fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self);
}

/// (sin x, cos x) in double precision for |x| < [`RANGE`].
#[inline(always)]
#[allow(clippy::excessive_precision)] // as published
pub(crate) fn sin_cos_f64<V: Quadrants>(x: V) -> (V, V) {
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

/// (sin x, cos x) in single precision for |x| < [`RANGE`].
#[cfg(not(target_arch = "wasm32"))]
#[inline(always)]
pub(crate) fn sin_cos_f32<V: Quadrants>(x: V) -> (V, V) {
    let k = V::from_f64;
    // 1.5·2²³.
    let round = k(12_582_912.0);
    let shifted = x.mul_add(k(core::f64::consts::FRAC_2_PI), round);
    let n = -(shifted - round);
    // π/2 = 1.570_796_326_794_896_619_231...
    let r = n.mul_add(k(1.570_796_370_506_286_6), x);
    let r = n.mul_add(k(-4.371_138_828_673_793e-8), r);
    let r = n.mul_add(k(-1.715_124_510_005_881_9e-15), r);
    let z = r * r;
    let s = k(-1.951_529_589_1e-4).mul_add(z, k(8.332_160_873_6e-3)).mul_add(z, k(-1.666_665_461_1e-1));
    let sine = (r * z).mul_add(s, r);
    let c = k(2.443_315_711_809_948e-5)
        .mul_add(z, k(-1.388_731_625_493_765e-3))
        .mul_add(z, k(4.166_664_568_298_827e-2));
    let cosine = (z * z).mul_add(c, z.mul_add(k(-0.5), k(1.0)));
    V::turn(shifted, sine, cosine)
}
