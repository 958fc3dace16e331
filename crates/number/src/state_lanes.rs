//! Several states side by side, one number of each.
//!
//! A formula over [`StateLanes`] is evaluated for L states by the same instructions. On machines with
//! AVX-512, AVX2, NEON or simd128 the L numbers are vector registers, and only kernels use them
//! ([`crate::dispatch`]). A single float is one lane. Every lane's arithmetic is that of a single number: the
//! value of one lane, even NaN, changes no bit of another.

use crate::Scalar;
use crate::sine::Quadrants;

/// A number for several states, read from and written to tables that store one state after the other.
pub trait StateLanes: Scalar + Quadrants {
    /// The number of one state.
    type Float: Scalar + PartialOrd;

    /// L, how many states.
    const LANES: usize;

    /// A number from its lanes.
    fn from_lanes(lane: impl Fn(usize) -> Self::Float) -> Self;

    /// The number of state `lane`.
    fn lane(&self, lane: usize) -> Self::Float;

    /// A bit for each lane, set if it is finite.
    fn finite(&self) -> u32;

    /// Whether |x| < `range` in every lane; false if a lane is NaN.
    fn all_within(&self, range: f64) -> bool;

    /// `to[k]` becomes column k of L rows, which start every `stride` numbers.
    ///
    /// # Panics
    /// If a row has fewer than `to.len()` numbers.
    fn gather(rows: &[Self::Float], stride: usize, to: &mut [Self]);

    /// For k below `width`, column k of L rows, which start every `stride` numbers, becomes `column(k)`: the
    /// reverse of [`StateLanes::gather`].
    ///
    /// # Panics
    /// If a row has fewer than `width` numbers.
    fn scatter<'a>(width: usize, column: impl Fn(usize) -> &'a Self, rows: &mut [Self::Float], stride: usize);

    /// [`StateLanes::gather`] of the first `states` rows, at most L. The other lanes repeat the last state,
    /// so that results do not depend on the number of states.
    ///
    /// # Panics
    /// If there is no state, or a row has fewer than `to.len()` numbers.
    #[inline(always)]
    fn gather_first(states: usize, rows: &[Self::Float], stride: usize, to: &mut [Self]) {
        if states < Self::LANES {
            for k in 0..to.len() {
                to[k] = Self::from_lanes(|lane| rows[lane.min(states - 1) * stride + k]);
            }
        } else {
            Self::gather(rows, stride, to);
        }
    }

    /// [`StateLanes::scatter`] of the first `states` lanes.
    ///
    /// # Panics
    /// If a row has fewer than `width` numbers.
    #[inline(always)]
    fn scatter_first<'a>(
        states: usize,
        width: usize,
        column: impl Fn(usize) -> &'a Self,
        rows: &mut [Self::Float],
        stride: usize,
    ) {
        if states < Self::LANES {
            for lane in 0..states {
                for k in 0..width {
                    rows[lane * stride + k] = column(k).lane(lane);
                }
            }
        } else {
            Self::scatter(width, column, rows, stride);
        }
    }
}

/// A single number is one lane, for batches on machines without registers.
macro_rules! one_lane {
    ($float:ty) => {
        impl StateLanes for $float {
            type Float = Self;
            const LANES: usize = 1;
            #[inline(always)]
            fn from_lanes(lane: impl Fn(usize) -> Self) -> Self {
                lane(0)
            }
            #[inline(always)]
            fn lane(&self, lane: usize) -> Self {
                debug_assert_eq!(lane, 0);
                *self
            }
            #[inline(always)]
            fn finite(&self) -> u32 {
                u32::from(self.is_finite())
            }
            #[inline(always)]
            #[allow(clippy::cast_possible_truncation, clippy::cast_lossless)]
            fn all_within(&self, range: f64) -> bool {
                self.abs() < range as $float
            }
            #[inline(always)]
            fn gather(rows: &[Self], _: usize, to: &mut [Self]) {
                to.copy_from_slice(&rows[..to.len()]);
            }
            #[inline(always)]
            fn scatter<'a>(width: usize, column: impl Fn(usize) -> &'a Self, rows: &mut [Self], _: usize) {
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

    /// A thousandth of the cases, at least two, under Miri, which checks memory, not rounding.
    fn few<T: core::ops::Div<Output = T> + From<u16> + Ord>(count: T) -> T {
        if cfg!(miri) { (count / T::from(1000)).max(T::from(2)) } else { count }
    }

    /// Lanes of random numbers of both signs.
    fn random_lanes<S: StateLanes>(random: &mut SplitMix64, scale: f64) -> S {
        let numbers: Vec<_> =
            (0..S::LANES).map(|_| <S::Float as Scalar>::from_f64(random.uniform(-scale, scale))).collect();
        S::from_lanes(|lane| numbers[lane])
    }

    /// Every operation on lanes agrees with that on single numbers.
    fn operations_are_the_lone_numbers<S: StateLanes>(
        multiply_add: fn(S::Float, S::Float, S::Float) -> S::Float,
    ) where
        S::Float: Quadrants,
        f64: From<S::Float>,
    {
        let mut random = SplitMix64::new(11);
        let lone = |operation: &str, found: S, expected: &dyn Fn(usize) -> S::Float| {
            for lane in 0..S::LANES {
                let (found, expected) = (found.lane(lane), expected(lane));
                assert!(found == expected, "{operation}: {found:?} for {expected:?} in lane {lane}");
            }
        };
        for _ in 0..few(200) {
            let (a, b): (S, S) = (random_lanes(&mut random, 3.0), random_lanes(&mut random, 3.0));
            lone("+", a + b, &|k| a.lane(k) + b.lane(k));
            lone("−", a - b, &|k| a.lane(k) - b.lane(k));
            lone("·", a * b, &|k| a.lane(k) * b.lane(k));
            lone("/", a / b, &|k| a.lane(k) / b.lane(k));
            lone("negation", -a, &|k| -a.lane(k));
            lone("sign", a.signum0(), &|k| a.lane(k).signum0());
            lone("√", (a * a).sqrt(), &|k| Scalar::sqrt(a.lane(k) * a.lane(k)));
            lone("multiply-add", a.mul_add(b, a), &|k| multiply_add(a.lane(k), b.lane(k), a.lane(k)));
            // The quadrant is in the lowest bits, whatever the other bits are.
            let turned = |k: usize| <S::Float as Quadrants>::turn(a.lane(k), b.lane(k), a.lane(k));
            lone("sine of the quadrant", S::turn(a, b, a).0, &|k| turned(k).0);
            lone("cosine of the quadrant", S::turn(a, b, a).1, &|k| turned(k).1);
            let mut sum = a;
            sum += b;
            lone("+=", sum, &|k| a.lane(k) + b.lane(k));
        }
        let values = [0.0, -0.0, f64::NAN, f64::INFINITY].map(<S::Float as Scalar>::from_f64);
        let special = S::from_lanes(|lane| values[lane % 4]);
        let sign = special.signum0();
        let expected = [0.0, 0.0, f64::NAN, 1.0];
        for lane in 0..S::LANES {
            let (found, expected) = (f64::from(sign.lane(lane)), expected[lane % 4]);
            assert!(found == expected || (found.is_nan() && expected.is_nan()), "{found} {expected}");
        }
        let lanes = (1 << S::LANES.min(4)) - 1;
        assert_eq!(special.finite() & lanes, 0b0011 & lanes);
        let size =
            |x: f64| S::from_lanes(|lane| <S::Float as Scalar>::from_f64(if lane == 0 { x } else { 0.5 }));
        for x in [0.5, -0.5, 2.0, -2.0, f64::INFINITY, f64::NAN] {
            assert_eq!(size(x).all_within(2.0), x.abs() < 2.0, "|{x}| < 2");
        }
    }

    /// Tables of every width, with gaps between rows, are transposed and transposed back.
    fn tables_are_transposed<S: StateLanes>() {
        let mut random = SplitMix64::new(12);
        for width in 0..if cfg!(miri) { 19 } else { 40 } {
            let stride = width + 3;
            let count = stride * (S::LANES - 1) + width;
            let table: Vec<S::Float> =
                (0..count).map(|_| <S::Float as Scalar>::from_f64(random.uniform(-1.0, 1.0))).collect();
            let mut lanes = vec![S::zero(); width];
            S::gather(&table, stride, &mut lanes);
            let nothing = <S::Float as Scalar>::zero();
            let mut back = vec![nothing; count];
            S::scatter(width, |k| &lanes[k], &mut back, stride);
            for lane in 0..S::LANES {
                for k in 0..width {
                    assert!(lanes[k].lane(lane) == table[lane * stride + k], "{width} {lane} {k}");
                    assert!(back[lane * stride + k] == table[lane * stride + k], "{width} {lane} {k}");
                }
                let between = back[lane * stride + width..].iter().take(3);
                assert!(between.into_iter().all(|&x| x == nothing), "written between rows");
            }
            // With fewer states the last one fills the other lanes, and no other row is written.
            for states in 1..=S::LANES {
                let (mut few, mut back) = (vec![S::zero(); width], vec![nothing; count]);
                S::gather_first(states, &table, stride, &mut few);
                S::scatter_first(states, width, |k| &few[k], &mut back, stride);
                for lane in 0..S::LANES {
                    let last = lane.min(states - 1);
                    assert!((0..width).all(|k| few[k].lane(lane) == table[last * stride + k]), "{width}");
                    let row = &back[lane * stride..lane * stride + width];
                    let expected = |k: usize| if lane < states { few[k].lane(lane) } else { nothing };
                    assert!((0..width).all(|k| row[k] == expected(k)), "{width} {states} {lane}");
                }
            }
        }
    }

    #[test]
    fn one_number() {
        operations_are_the_lone_numbers::<f64>(|a, b, c| a * b + c);
        operations_are_the_lone_numbers::<f32>(|a, b, c| a * b + c);
        tables_are_transposed::<f64>();
        tables_are_transposed::<f32>();
    }

    #[cfg(registers)]
    mod in_registers {
        use super::*;
        use crate::InstructionSet;
        use crate::fma_float::FmaFloat;
        use crate::registers::{F32x8, F64x4};
        #[cfg(target_arch = "x86_64")]
        use crate::registers::{F32x16, F64x8};

        /// The largest error of sine and cosine in units in the last place of f32, compared with the double's
        /// sine.
        #[allow(clippy::cast_possible_truncation)]
        fn single_precision_error<S: StateLanes<Float = f32>>(angles: impl Iterator<Item = f32>) -> f64 {
            let ulps = |found: f32, exact: f64| {
                let size = (exact.abs() as f32).max(f32::MIN_POSITIVE);
                (f64::from(found) - exact).abs() / f64::from(size.next_up() - size)
            };
            let mut worst: f64 = 0.0;
            for angle in angles {
                let (sine, cosine) = S::from_lanes(|_| angle).sin_cos();
                let (s, c) = f64::from(angle).sin_cos();
                let error = ulps(sine.lane(1), s).max(ulps(cosine.lane(1), c));
                assert!(error <= 2.0, "{angle:e}: {error} ulp");
                worst = worst.max(error);
            }
            worst
        }

        /// Lanes of doubles agree with the standard library, which is itself within 1 ulp.
        fn double_precision_is_near<S: StateLanes<Float = f64>>() {
            let mut random = SplitMix64::new(13);
            for scale in [1e-300, 1e-8, 1.0, 10.0, 1e3, 9.9e4, 1e8] {
                for _ in 0..few(3000) {
                    let angles: S = random_lanes(&mut random, scale);
                    let (sine, cosine) = angles.sin_cos();
                    for lane in 0..S::LANES {
                        let (s, c) = angles.lane(lane).sin_cos();
                        let near = |a: f64, b: f64| (a - b).abs() <= 2.0 * f64::EPSILON * b.abs().max(1e-300);
                        let is_near = near(sine.lane(lane), s) && near(cosine.lane(lane), c);
                        assert!(is_near, "{:e}", angles.lane(lane));
                    }
                }
            }
        }

        /// One angle far out of range and one NaN, beside ordinary angles.
        fn odd_angles_spoil_no_neighbour<S: StateLanes>() {
            let ordinary: S = random_lanes(&mut SplitMix64::new(14), 3.0);
            let odd = S::from_lanes(|lane| match lane {
                0 => <S::Float as Scalar>::from_f64(3e7),
                2 => <S::Float as Scalar>::from_f64(f64::NAN),
                _ => ordinary.lane(lane),
            });
            let (expected, found) = (ordinary.sin_cos(), odd.sin_cos());
            for lane in (0..S::LANES).filter(|lane| ![0, 2].contains(lane)) {
                assert!(expected.0.lane(lane) == found.0.lane(lane));
                assert!(expected.1.lane(lane) == found.1.lane(lane));
            }
            let far = Scalar::sin_cos(odd.lane(0));
            assert!((found.0.lane(0), found.1.lane(0)) == far);
            let nan = found.0.lane(2);
            assert!(nan.partial_cmp(&nan).is_none());
        }

        /// Random angles of every size, and angles near the multiples of π/2.
        #[allow(clippy::cast_possible_truncation)]
        fn angles() -> impl Iterator<Item = f32> {
            let mut random = SplitMix64::new(15);
            let scales = [1e-30, 1e-3, 1.0, 10.0, 1e3, 9.9e4];
            let random = (0..few(300_000)).map(move |k| {
                let scale = scales[k % scales.len()];
                random.uniform(-scale, scale) as f32
            });
            let near = (-few(60_000)..few(60_000))
                .map(|n| (f64::from(n) * core::f64::consts::FRAC_PI_2) as f32)
                .flat_map(|x| [x, x.next_up(), x.next_down()]);
            random.chain(near)
        }

        fn doubles<S: StateLanes<Float = f64>>() {
            operations_are_the_lone_numbers::<S>(|a, b, c| FmaFloat(a).mul_add(FmaFloat(b), FmaFloat(c)).0);
            tables_are_transposed::<S>();
            odd_angles_spoil_no_neighbour::<S>();
            double_precision_is_near::<S>();
        }

        fn singles<S: StateLanes<Float = f32>>() {
            operations_are_the_lone_numbers::<S>(|a, b, c| FmaFloat(a).mul_add(FmaFloat(b), FmaFloat(c)).0);
            tables_are_transposed::<S>();
            odd_angles_spoil_no_neighbour::<S>();
            println!("worst error {} ulp", single_precision_error::<S>(angles()));
        }

        #[test]
        fn four_doubles_and_eight_singles() {
            if InstructionSet::has_registers() {
                doubles::<F64x4>();
                singles::<F32x8>();
            }
        }

        #[cfg(target_arch = "x86_64")]
        #[test]
        fn eight_doubles_and_sixteen_singles() {
            if InstructionSet::Avx512.is_available() {
                doubles::<F64x8>();
                singles::<F32x16>();
            }
        }
    }
}
