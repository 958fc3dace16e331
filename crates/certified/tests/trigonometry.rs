//! Sine and cosine contain the exact values, by a series in integers with 400 binary digits.

use num_bigint::BigInt;
use robot_dynamics::number::{Scalar, SplitMix64};
use robot_dynamics_certified::Interval;

const DIGITS: usize = 400;

/// π · 2⁴⁰⁰, rounded down, by Machin's formula.
fn pi() -> BigInt {
    let inverse_tangent = |n: i32| {
        let mut power = (BigInt::from(1) << (DIGITS + 32)) / n;
        let (mut sum, mut k) = (power.clone(), 1);
        while power != BigInt::from(0) {
            power = -power / (n * n);
            k += 2;
            sum += &power / k;
        }
        sum
    };
    (4 * (4 * inverse_tangent(5) - inverse_tangent(239))) >> 32
}

/// x · 2⁴⁰⁰, exact for the numbers of these tests.
fn fixed(x: f64) -> BigInt {
    let bits = x.abs().to_bits();
    let (exponent, fraction) = (i64::try_from(bits >> 52).expect("11 bits"), bits & ((1 << 52) - 1));
    let m = BigInt::from(if exponent == 0 { fraction } else { fraction | 1 << 52 });
    let shift = i64::try_from(DIGITS).expect("small") + exponent.max(1) - 1075;
    let sign = if x < 0.0 { -1 } else { 1 };
    let size = usize::try_from(shift.unsigned_abs()).expect("small");
    sign * if shift >= 0 { m << size } else { m >> size }
}

/// sin x · 2⁴⁰⁰ and cos x · 2⁴⁰⁰, to a few units of 2⁻³⁸⁰.
fn sin_cos(x: f64, pi: &BigInt) -> (BigInt, BigInt) {
    let half: BigInt = pi >> 1;
    let turns = (x / core::f64::consts::FRAC_PI_2).round();
    #[allow(clippy::cast_possible_truncation)] // below 2²²
    let k = turns as i64;
    let r = fixed(x) - k * half;
    let series = |first: BigInt, start: i64| {
        let (mut sum, mut term, mut n) = (first.clone(), first, start);
        while term.magnitude().bits() > 0 {
            let product: BigInt = (&term * &r) >> DIGITS;
            term = -((product * &r) >> DIGITS) / ((n + 1) * (n + 2));
            n += 2;
            sum += &term;
            if term == BigInt::from(0) || term == BigInt::from(-1) {
                break;
            }
        }
        sum
    };
    let (sine, cosine) = (series(r.clone(), 1), series(BigInt::from(1) << DIGITS, 0));
    match k.rem_euclid(4) {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// Whether the interval contains the number, to the error of the series.
#[track_caller]
fn check(name: &str, x: f64, found: Interval, exact: &BigInt) {
    let slack = BigInt::from(1) << 40;
    let holds = fixed(found.lower()) <= exact + &slack && fixed(found.upper()) + &slack >= *exact;
    assert!(holds, "{name} {x:e}: {found:?}");
}

#[test]
fn sine_and_cosine_contain_the_exact_values() {
    let (pi, mut random) = (pi(), SplitMix64::new(5));
    let quarters = (-40..40).map(|k| f64::from(k) * core::f64::consts::FRAC_PI_4);
    let special = [0.0, 1e-300, -1e-20, 4_194_304.0, -4_194_303.9, 3_000_000.5].into_iter().chain(quarters);
    let many: Vec<f64> = (0..20_000)
        .map(|k| match k % 3 {
            0 => random.uniform(-7.0, 7.0),
            1 => random.uniform(-4.0e6, 4.0e6),
            _ => random.uniform(-1.0, 1.0) * 2.0_f64.powi(-(k % 60)),
        })
        .collect();
    let mut widest = 0.0_f64;
    for x in special.chain(many) {
        for near in [x.next_down(), x, x.next_up()] {
            let near = near.clamp(-4_194_304.0, 4_194_304.0);
            let (sine, cosine) = Interval::from(near).sin_cos();
            let (exact_sine, exact_cosine) = sin_cos(near, &pi);
            check("sin", near, sine, &exact_sine);
            check("cos", near, cosine, &exact_cosine);
            widest = widest.max(sine.width()).max(cosine.width());
        }
    }
    // A few roundings of numbers up to 1.
    assert!(widest < 12.0 * f64::EPSILON, "the widest has {:.1} roundings", widest / f64::EPSILON);
}

#[test]
fn wide_intervals_contain_their_extrema() {
    use core::f64::consts::{FRAC_PI_2, PI};
    let (sine, cosine) = Interval::new(0.1, 3.0).sin_cos();
    assert!(sine.upper() == 1.0 && sine.lower() > 0.09 && cosine.upper() < 1.0 && cosine.lower() > -1.0);
    let (sine, cosine) = Interval::new(-FRAC_PI_2 - 0.1, 0.1).sin_cos();
    assert!(sine.lower() == -1.0 && sine.upper() < 0.1 && cosine.upper() == 1.0 && cosine.lower() > -0.1);
    let (_, cosine) = Interval::new(PI - 0.1, PI + 0.1).sin_cos();
    assert!(cosine.lower() == -1.0 && cosine.upper() < -0.99);
    for x in [Interval::new(0.0, 10.0), Interval::ENTIRE, Interval::from(1e9), Interval::new(-1e9, 1e9)] {
        assert_eq!(x.sin_cos(), (Interval::new(-1.0, 1.0), Interval::new(-1.0, 1.0)));
    }
}
