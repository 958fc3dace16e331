//! Sine and cosine of intervals.

use core::f64::consts::FRAC_2_PI;

use crate::Interval;

/// π/2 = HIGH + MIDDLE + a number in LOW. The first two have 30 bits.
const HIGH: f64 = f64::from_bits(0x3ff9_21fb_5400_0000);
const MIDDLE: f64 = f64::from_bits(0x3e11_0b46_1180_0000);
const LOW: Interval =
    Interval::new(f64::from_bits(0x3c23_1319_8a2e_0370), f64::from_bits(0x3c23_1319_8a2e_0371));

/// Above this |x| the multiple of π/2 has more than 22 bits, and the result is \[−1, 1\].
const LARGEST: f64 = 4_194_304.0; // 2²²

/// All values of sine and cosine.
const UNIT: Interval = Interval::new(-1.0, 1.0);

/// Enclosures of sin x and cos x for all x of an interval.
pub(crate) fn sin_cos(x: Interval) -> (Interval, Interval) {
    let is_small = x.magnitude() <= LARGEST;
    if !is_small || x.width() >= 6.2 {
        return (UNIT, UNIT);
    }
    let (sine, cosine) = of_number(x.lower());
    if x.lower() == x.upper() {
        return (sine, cosine);
    }
    let (other_sine, other_cosine) = of_number(x.upper());
    let (mut sine, mut cosine) = (sine.hull(other_sine), cosine.hull(other_cosine));
    // Extrema are at integers of x/(π/2). More integers than lie there only widen the result.
    let quarters = x / quarter_turn();
    let (mut integer, last) = (quarters.lower().floor(), quarters.upper().ceil());
    while integer <= last {
        if quarters.contains(integer) {
            match integer.rem_euclid(4.0) {
                0.0 => cosine = cosine.hull(Interval::from(1.0)),
                1.0 => sine = sine.hull(Interval::from(1.0)),
                2.0 => cosine = cosine.hull(Interval::from(-1.0)),
                _ => sine = sine.hull(Interval::from(-1.0)),
            }
        }
        integer += 1.0;
    }
    (sine, cosine)
}

/// An enclosure of π/2.
fn quarter_turn() -> Interval {
    Interval::from(HIGH) + Interval::from(MIDDLE) + LOW
}

/// Enclosures of sin x and cos x for a number, |x| ≤ 2²².
fn of_number(x: f64) -> (Interval, Interval) {
    let turns = (x * FRAC_2_PI).round();
    // The products with 30 bits are exact. A rounded `turns` that is one off only makes the rest larger.
    let rest = Interval::from(x)
        - Interval::from(turns * HIGH)
        - Interval::from(turns * MIDDLE)
        - Interval::from(turns) * LOW;
    let (sine, cosine) = (sine_series(rest), cosine_series(rest));
    let (sine, cosine) = match turns.rem_euclid(4.0) {
        0.0 => (sine, cosine),
        1.0 => (cosine, -sine),
        2.0 => (-sine, -cosine),
        _ => (-cosine, sine),
    };
    (within_unit(sine), within_unit(cosine))
}

fn within_unit(x: Interval) -> Interval {
    Interval::new(x.lower().max(-1.0), x.upper().min(1.0))
}

/// 1 − z/(m(m+1)) (1 − z/((m+2)(m+3)) (…)) with eight such terms; the innermost factor is \[0, 1\] less its
/// next term, which bounds the rest of the alternating series.
fn nested(square: Interval, first: f64) -> Interval {
    let divided = |k: i32| {
        let m = first + 2.0 * f64::from(k);
        square / Interval::from(m * (m + 1.0))
    };
    // For |r| ≤ 1 the terms decrease, so the rest of the series lies between 0 and its first term.
    let mut sum = Interval::from(1.0) - divided(8) * Interval::new(0.0, 1.0);
    for k in (0..8).rev() {
        sum = Interval::from(1.0) - divided(k) * sum;
    }
    sum
}

/// sin r for |r| ≤ 1.
fn sine_series(r: Interval) -> Interval {
    r * nested(square(r), 2.0)
}

/// cos r for |r| ≤ 1.
fn cosine_series(r: Interval) -> Interval {
    nested(square(r), 1.0)
}

/// r², which is not negative.
fn square(r: Interval) -> Interval {
    let all = r * r;
    let least = if r.contains(0.0) { 0.0 } else { all.lower().max(0.0) };
    Interval::new(least, all.upper())
}
