//! Several states side by side: one number of each.
//!
//! A formula over [`Lanes`] is evaluated for L states by the same instructions. On a machine with AVX-512 or
//! AVX2 and FMA the hot algorithms run over [`Scalar::Fused`]: then the L numbers are one vector register,
//! [`F64x8`], [`F32x16`], [`F64x4`] or [`F32x8`]. Elsewhere they are an array, and each operation a loop for the
//! compiler to vectorise. Every lane's arithmetic is that of a lone number: what stands in one lane, be it
//! NaN, changes no bit of another.

mod sincos;

#[cfg(target_arch = "x86_64")]
mod registers;
#[cfg(target_arch = "x86_64")]
pub use registers::{F32x8, F32x16, F64x4, F64x8};

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::{Float, Scalar};

/// L numbers, one of each state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes<T, const L: usize>(pub [T; L]);

/// A number for several states, read from and written to tables that hold one state after the other.
pub trait StateLanes: Scalar {
    /// The number of one state.
    type Float: Float;

    /// L, how many states.
    const LANES: usize;

    /// Every lane `x`.
    fn splat(x: Self::Float) -> Self;

    /// The number of state `lane`.
    fn lane(&self, lane: usize) -> Self::Float;

    /// Another number for state `lane`.
    fn set_lane(&mut self, lane: usize, x: Self::Float);

    /// Whether each lane is finite, a bit each.
    fn finite(&self) -> u32;

    /// `to[k]` becomes column k of L rows, which start every `stride` numbers.
    ///
    /// `FUSED` promises what [`Scalar::Fused`] promises of the machine.
    ///
    /// # Panics
    /// If a row has fewer than `to.len()` numbers.
    fn gather<const FUSED: bool>(rows: &[Self::Float], stride: usize, to: &mut [Self]);

    /// Column k of L rows, which start every `stride` numbers, becomes `column(k)`, for k below `width`; as
    /// [`StateLanes::gather`].
    ///
    /// # Panics
    /// If a row has fewer than `width` numbers.
    fn scatter_columns<'a, const FUSED: bool>(
        width: usize,
        column: impl Fn(usize) -> &'a Self,
        rows: &mut [Self::Float],
        stride: usize,
    );

    /// The reverse of [`StateLanes::gather`].
    ///
    /// # Panics
    /// If a row has fewer than `from.len()` numbers.
    #[inline(always)]
    fn scatter<const FUSED: bool>(from: &[Self], rows: &mut [Self::Float], stride: usize) {
        Self::scatter_columns::<FUSED>(from.len(), |k| &from[k], rows, stride);
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $assign:ident, $assign_method:ident) => {
        impl<T: Float, const L: usize> $trait for Lanes<T, L> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for k in 0..L {
                    self.0[k] = self.0[k].$method(other.0[k]);
                }
                self
            }
        }
        impl<T: Float, const L: usize> $assign for Lanes<T, L> {
            #[inline(always)]
            fn $assign_method(&mut self, other: Self) {
                *self = (*self).$method(other);
            }
        }
    };
}
operator!(Add, add, AddAssign, add_assign);
operator!(Sub, sub, SubAssign, sub_assign);
operator!(Mul, mul, MulAssign, mul_assign);

impl<T: Float, const L: usize> Div for Lanes<T, L> {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, other: Self) -> Self {
        for k in 0..L {
            self.0[k] = self.0[k] / other.0[k];
        }
        self
    }
}

impl<T: Float, const L: usize> Neg for Lanes<T, L> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for k in 0..L {
            self.0[k] = -self.0[k];
        }
        self
    }
}

macro_rules! lanes {
    ($float:ty, $lanes:literal, $register:ident) => {
        impl Scalar for Lanes<$float, $lanes> {
            const HAS_FUSED: bool = cfg!(target_arch = "x86_64");
            #[cfg(target_arch = "x86_64")]
            type Fused = $register;
            #[cfg(not(target_arch = "x86_64"))]
            type Fused = Self;
            type Triple = [Self; 3];
            type Symmetric = [Self; 6];
            #[inline(always)]
            fn fuse(self) -> Self::Fused {
                #[cfg(target_arch = "x86_64")]
                return $register::from_array(&self.0);
                #[cfg(not(target_arch = "x86_64"))]
                return self;
            }
            #[inline(always)]
            fn unfuse(fused: Self::Fused) -> Self {
                #[cfg(target_arch = "x86_64")]
                return Self(fused.to_array());
                #[cfg(not(target_arch = "x86_64"))]
                return fused;
            }
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                Self([<$float as Scalar>::from_f64(x); $lanes])
            }
            fn sin_cos(self) -> (Self, Self) {
                let (mut sine, mut cosine) = (self, self);
                for k in 0..$lanes {
                    (sine.0[k], cosine.0[k]) = self.0[k].sin_cos();
                }
                (sine, cosine)
            }
            #[inline(always)]
            fn sqrt(mut self) -> Self {
                for k in 0..$lanes {
                    self.0[k] = self.0[k].sqrt();
                }
                self
            }
            #[inline(always)]
            fn signum0(mut self) -> Self {
                for k in 0..$lanes {
                    self.0[k] = self.0[k].signum0();
                }
                self
            }
        }

        impl StateLanes for Lanes<$float, $lanes> {
            type Float = $float;
            const LANES: usize = $lanes;
            #[inline(always)]
            fn splat(x: $float) -> Self {
                Self([x; $lanes])
            }
            #[inline(always)]
            fn lane(&self, lane: usize) -> $float {
                self.0[lane]
            }
            #[inline(always)]
            fn set_lane(&mut self, lane: usize, x: $float) {
                self.0[lane] = x;
            }
            #[inline(always)]
            fn finite(&self) -> u32 {
                let mut bits = 0;
                for k in 0..$lanes {
                    bits |= u32::from(self.0[k].is_finite()) << k;
                }
                bits
            }
            #[inline(always)]
            fn gather<const FUSED: bool>(rows: &[$float], stride: usize, to: &mut [Self]) {
                #[cfg(target_arch = "x86_64")]
                if FUSED {
                    return $register::gather(rows, stride, to);
                }
                for (k, to) in to.iter_mut().enumerate() {
                    for lane in 0..$lanes {
                        to.0[lane] = rows[lane * stride + k];
                    }
                }
            }
            #[inline(always)]
            fn scatter_columns<'a, const FUSED: bool>(
                width: usize,
                column: impl Fn(usize) -> &'a Self,
                rows: &mut [$float],
                stride: usize,
            ) {
                #[cfg(target_arch = "x86_64")]
                if FUSED {
                    return $register::scatter(width, column, rows, stride);
                }
                for k in 0..width {
                    for lane in 0..$lanes {
                        rows[lane * stride + k] = column(k).0[lane];
                    }
                }
            }
        }
    };
}
lanes!(f64, 4, F64x4);
lanes!(f64, 8, F64x8);
lanes!(f32, 8, F32x8);
lanes!(f32, 16, F32x16);

/// A lone number is one lane: what batches take where no register holds more.
macro_rules! one_lane {
    ($float:ty) => {
        impl StateLanes for $float {
            type Float = Self;
            const LANES: usize = 1;
            #[inline(always)]
            fn splat(x: Self) -> Self {
                x
            }
            #[inline(always)]
            fn lane(&self, lane: usize) -> Self {
                debug_assert_eq!(lane, 0);
                *self
            }
            #[inline(always)]
            fn set_lane(&mut self, lane: usize, x: Self) {
                debug_assert_eq!(lane, 0);
                *self = x;
            }
            #[inline(always)]
            fn finite(&self) -> u32 {
                u32::from(self.is_finite())
            }
            #[inline(always)]
            fn gather<const FUSED: bool>(rows: &[Self], _: usize, to: &mut [Self]) {
                to.copy_from_slice(&rows[..to.len()]);
            }
            #[inline(always)]
            fn scatter_columns<'a, const FUSED: bool>(
                width: usize,
                column: impl Fn(usize) -> &'a Self,
                rows: &mut [Self],
                _: usize,
            ) {
                for (k, number) in rows[..width].iter_mut().enumerate() {
                    *number = *column(k);
                }
            }
        }
    };
}
one_lane!(f64);
one_lane!(f32);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;

    /// Lanes of random numbers of both signs.
    fn random_lanes<S: StateLanes>(random: &mut SplitMix64, scale: f64) -> S {
        let mut lanes = S::zero();
        for lane in 0..S::LANES {
            lanes.set_lane(lane, <S::Float as Scalar>::from_f64(random.uniform(-scale, scale)));
        }
        lanes
    }

    /// Every operation, by lanes and by the lone number; a fused multiply-add may round once less.
    fn operations_are_the_lone_numbers<S: StateLanes>(fuse: bool)
    where
        f64: From<S::Float>,
    {
        let mut random = SplitMix64::new(11);
        let lone = |operation: &str, found: S, expected: &dyn Fn(usize) -> S::Float| {
            for lane in 0..S::LANES {
                let (found, expected) = (found.lane(lane), expected(lane));
                assert!(found == expected, "{operation}: {found:?} for {expected:?} in lane {lane}");
            }
        };
        let through = |f: fn(S::Fused, S::Fused) -> S::Fused, plain: fn(S, S) -> S, a: S, b: S| {
            if fuse { S::unfuse(f(a.fuse(), b.fuse())) } else { plain(a, b) }
        };
        for _ in 0..200 {
            let (a, b): (S, S) = (random_lanes(&mut random, 3.0), random_lanes(&mut random, 3.0));
            lone("+", through(|a, b| a + b, |a, b| a + b, a, b), &|k| a.lane(k) + b.lane(k));
            lone("−", through(|a, b| a - b, |a, b| a - b, a, b), &|k| a.lane(k) - b.lane(k));
            lone("·", through(|a, b| a * b, |a, b| a * b, a, b), &|k| a.lane(k) * b.lane(k));
            lone("/", through(|a, b| a / b, |a, b| a / b, a, b), &|k| a.lane(k) / b.lane(k));
            lone("negation", through(|a, _| -a, |a, _| -a, a, b), &|k| -a.lane(k));
            lone("sign", through(|a, _| a.signum0(), |a, _| a.signum0(), a, b), &|k| a.lane(k).signum0());
            let root = through(|a, _| (a * a).sqrt(), |a, _| (a * a).sqrt(), a, b);
            lone("√", root, &|k| Scalar::sqrt(a.lane(k) * a.lane(k)));
            let product = through(|a, b| a.mul_add(b, a), |a, b| a.mul_add(b, a), a, b);
            lone("multiply-add", product, &|k| {
                let (a, b) = (a.lane(k), b.lane(k));
                if fuse { a.fused_mul_add(b, a) } else { a * b + a }
            });
        }
        let mut special = S::zero();
        let values = [0.0, -0.0, f64::NAN, f64::INFINITY];
        for (lane, &x) in values.iter().cycle().take(S::LANES).enumerate() {
            special.set_lane(lane, <S::Float as Scalar>::from_f64(x));
        }
        let sign = through(|a, _| a.signum0(), |a, _| a.signum0(), special, special);
        let expected = [0.0, 0.0, f64::NAN, 1.0];
        for (lane, &expected) in expected.iter().cycle().take(S::LANES).enumerate() {
            let found = f64::from(sign.lane(lane));
            assert!(found == expected || (found.is_nan() && expected.is_nan()), "{found} {expected}");
        }
        let lanes = (1 << S::LANES.min(4)) - 1;
        assert_eq!(special.finite() & lanes, 0b0011 & lanes);
    }

    /// Tables of every width, with rows apart, there and back.
    fn tables_are_transposed<S: StateLanes, const FUSED: bool>() {
        let mut random = SplitMix64::new(12);
        for width in 0..40 {
            let stride = width + 3;
            let count = stride * (S::LANES - 1) + width;
            let table: Vec<S::Float> =
                (0..count).map(|_| <S::Float as Scalar>::from_f64(random.uniform(-1.0, 1.0))).collect();
            let mut lanes = vec![S::zero(); width];
            S::gather::<FUSED>(&table, stride, &mut lanes);
            let nothing = <S::Float as Scalar>::zero();
            let mut back = vec![nothing; count];
            S::scatter::<FUSED>(&lanes, &mut back, stride);
            for lane in 0..S::LANES {
                for k in 0..width {
                    assert!(lanes[k].lane(lane) == table[lane * stride + k], "{width} {lane} {k}");
                    assert!(back[lane * stride + k] == table[lane * stride + k], "{width} {lane} {k}");
                }
                let between = back[lane * stride + width..].iter().take(3);
                assert!(between.into_iter().all(|&x| x == nothing), "written between rows");
            }
        }
    }

    /// The largest error of sine and cosine in units in the last place of f32, by the double's sine.
    #[allow(clippy::cast_possible_truncation)]
    fn single_precision_error<S: StateLanes<Float = f32>>(angles: impl Iterator<Item = f32>) -> f64 {
        let ulps = |found: f32, exact: f64| {
            let size = (exact.abs() as f32).max(f32::MIN_POSITIVE);
            (f64::from(found) - exact).abs() / f64::from(size.next_up() - size)
        };
        let mut worst: f64 = 0.0;
        for angle in angles {
            let (sine, cosine) = S::splat(angle).fuse().sin_cos();
            let (s, c) = f64::from(angle).sin_cos();
            let error = ulps(S::unfuse(sine).lane(1), s).max(ulps(S::unfuse(cosine).lane(1), c));
            assert!(error <= 2.0, "{angle:e}: {error} ulp");
            worst = worst.max(error);
        }
        worst
    }

    /// The double's lanes against the standard library, which is itself within 1 ulp.
    fn double_precision_is_near<S: StateLanes<Float = f64>>() {
        let mut random = SplitMix64::new(13);
        for scale in [1e-300, 1e-8, 1.0, 10.0, 1e3, 9.9e4, 1e8] {
            for _ in 0..3000 {
                let angles: S = random_lanes(&mut random, scale);
                let (sine, cosine) = angles.fuse().sin_cos();
                for lane in 0..S::LANES {
                    let (s, c) = angles.lane(lane).sin_cos();
                    let (sine, cosine) = (S::unfuse(sine).lane(lane), S::unfuse(cosine).lane(lane));
                    let near = |a: f64, b: f64| (a - b).abs() <= 2.0 * f64::EPSILON * b.abs().max(1e-300);
                    assert!(near(sine, s) && near(cosine, c), "{:e}", angles.lane(lane));
                }
            }
        }
    }

    /// One angle far out of range, and one that is none, beside ordinary ones.
    fn odd_angles_spoil_no_neighbour<S: StateLanes>() {
        let ordinary: S = random_lanes(&mut SplitMix64::new(14), 3.0);
        let mut odd = ordinary;
        odd.set_lane(0, <S::Float as Scalar>::from_f64(3e7));
        odd.set_lane(2, <S::Float as Scalar>::from_f64(f64::NAN));
        let (expected, found) = (ordinary.fuse().sin_cos(), odd.fuse().sin_cos());
        for lane in (0..S::LANES).filter(|lane| ![0, 2].contains(lane)) {
            assert!(S::unfuse(expected.0).lane(lane) == S::unfuse(found.0).lane(lane));
            assert!(S::unfuse(expected.1).lane(lane) == S::unfuse(found.1).lane(lane));
        }
        let far = Scalar::sin_cos(odd.lane(0));
        assert!((S::unfuse(found.0).lane(0), S::unfuse(found.1).lane(0)) == far);
        let nan = S::unfuse(found.0).lane(2);
        assert!(nan.partial_cmp(&nan).is_none());
    }

    fn has_avx2() -> bool {
        cfg!(target_arch = "x86_64") && {
            #[cfg(target_arch = "x86_64")]
            return std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma");
            #[allow(unreachable_code)]
            false
        }
    }

    fn has_avx512() -> bool {
        has_avx2() && {
            #[cfg(target_arch = "x86_64")]
            return std::is_x86_feature_detected!("avx512f") && std::is_x86_feature_detected!("avx512dq");
            #[allow(unreachable_code)]
            false
        }
    }

    /// All checks on one type of lanes.
    macro_rules! check {
        ($lanes:ty, $machine:expr, $precise:expr) => {
            operations_are_the_lone_numbers::<$lanes>(false);
            tables_are_transposed::<$lanes, false>();
            if $machine {
                operations_are_the_lone_numbers::<$lanes>(true);
                tables_are_transposed::<$lanes, true>();
                odd_angles_spoil_no_neighbour::<$lanes>();
                $precise;
            }
        };
    }

    #[test]
    fn one_number() {
        operations_are_the_lone_numbers::<f64>(false);
        tables_are_transposed::<f64, false>();
        tables_are_transposed::<f32, false>();
    }

    #[test]
    fn four_doubles() {
        check!(Lanes<f64, 4>, has_avx2(), double_precision_is_near::<Lanes<f64, 4>>());
    }

    #[test]
    fn eight_doubles() {
        check!(Lanes<f64, 8>, has_avx512(), double_precision_is_near::<Lanes<f64, 8>>());
    }

    /// Random angles of every size, and those beside the multiples of π/2.
    #[allow(clippy::cast_possible_truncation)]
    fn angles() -> impl Iterator<Item = f32> {
        let mut random = SplitMix64::new(15);
        let scales = [1e-30, 1e-3, 1.0, 10.0, 1e3, 9.9e4];
        let random = (0..300_000).map(move |k| {
            let scale = scales[k % scales.len()];
            random.uniform(-scale, scale) as f32
        });
        let near = (-60_000..60_000)
            .map(|n| (f64::from(n) * core::f64::consts::FRAC_PI_2) as f32)
            .flat_map(|x| [x, x.next_up(), x.next_down()]);
        random.chain(near)
    }

    #[test]
    fn eight_singles() {
        check!(Lanes<f32, 8>, has_avx2(), {
            let worst = single_precision_error::<Lanes<f32, 8>>(angles());
            println!("worst error {worst} ulp");
        });
    }

    #[test]
    fn sixteen_singles() {
        check!(Lanes<f32, 16>, has_avx512(), {
            let worst = single_precision_error::<Lanes<f32, 16>>(angles());
            println!("worst error {worst} ulp");
        });
    }
}
