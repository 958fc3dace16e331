//! Every operation contains the exact result, by integers of any size.

use std::cmp::Ordering;

use num_bigint::BigInt;
use robot_dynamics::number::{Scalar, SplitMix64};
use robot_dynamics_certified::Interval;

/// A dyadic number, m 2ᵉ.
#[derive(Clone)]
struct Exact {
    m: BigInt,
    e: i64,
}

impl Exact {
    fn of(x: f64) -> Self {
        assert!(x.is_finite());
        let bits = x.to_bits();
        let (exponent, fraction) = ((bits >> 52) & 0x7ff, bits & ((1 << 52) - 1));
        let m = if exponent == 0 { fraction } else { fraction | 1 << 52 };
        let m = BigInt::from(m) * if x < 0.0 { -1 } else { 1 };
        Self { m, e: i64::try_from(exponent.max(1)).expect("11 bits") - 1075 }
    }

    /// Both with one exponent.
    fn aligned(&self, other: &Self) -> (BigInt, BigInt, i64) {
        let e = self.e.min(other.e);
        let shifted = |x: &Self| &x.m << usize::try_from(x.e - e).expect("not negative");
        (shifted(self), shifted(other), e)
    }

    fn plus(&self, other: &Self) -> Self {
        let (a, b, e) = self.aligned(other);
        Self { m: a + b, e }
    }

    fn times(&self, other: &Self) -> Self {
        Self { m: &self.m * &other.m, e: self.e + other.e }
    }

    fn compare(&self, other: &Self) -> Ordering {
        let (a, b, _) = self.aligned(other);
        a.cmp(&b)
    }
}

/// Whether a bound from below or above holds. Infinite bounds hold on their side.
fn is_below(bound: f64, x: &Exact) -> bool {
    if bound.is_finite() { Exact::of(bound).compare(x) != Ordering::Greater } else { bound < 0.0 }
}

fn is_above(bound: f64, x: &Exact) -> bool {
    if bound.is_finite() { Exact::of(bound).compare(x) != Ordering::Less } else { bound > 0.0 }
}

#[track_caller]
fn check(name: &str, [a, b]: [f64; 2], found: Interval, exact: &Exact) {
    let holds = is_below(found.lower(), exact) && is_above(found.upper(), exact);
    assert!(holds, "{name} of {a:e} and {b:e}: {found:?}");
}

/// a/b lies in the interval: with b > 0, lower · b ≤ a ≤ upper · b.
#[track_caller]
fn check_quotient([a, b]: [f64; 2], found: Interval) {
    let (sign, scale) = (b.signum(), Exact::of(b.abs()));
    let a = Exact::of(a * sign);
    for (bound, wrong) in [(found.lower(), Ordering::Greater), (found.upper(), Ordering::Less)] {
        if bound.is_finite() {
            assert_ne!(
                Exact::of(bound).times(&scale).compare(&a),
                wrong,
                "{a:?} / {b:e}: {found:?}",
                a = a.m
            );
        }
    }
}

#[track_caller]
fn check_root(x: f64, found: Interval) {
    let exact = Exact::of(x);
    let square = |x: f64| Exact::of(x).times(&Exact::of(x));
    assert!(
        found.lower() >= 0.0 && square(found.lower()).compare(&exact) != Ordering::Greater,
        "√{x:e}: {found:?}"
    );
    assert!(square(found.upper()).compare(&exact) != Ordering::Less, "√{x:e}: {found:?}");
}

fn check_all([a, b]: [f64; 2]) {
    let (x, y) = (Interval::from(a), Interval::from(b));
    let (exact_a, exact_b) = (Exact::of(a), Exact::of(b));
    check("the sum", [a, b], x + y, &exact_a.plus(&exact_b));
    check("the difference", [a, b], x - y, &exact_a.plus(&Exact::of(-b)));
    check("the product", [a, b], x * y, &exact_a.times(&exact_b));
    if b == 0.0 {
        assert_eq!(x / y, Interval::ENTIRE);
    } else {
        check_quotient([a, b], x / y);
    }
    check_root(a.abs(), Interval::from(a.abs()).sqrt());
}

/// A number with any bits, or of moderate size, often near another one.
fn random_number(random: &mut SplitMix64, near: f64) -> f64 {
    let x = match random.next_u64() % 4 {
        0 => f64::from_bits(random.next_u64()),
        1 => near * random.uniform(-1.1, 1.1),
        2 => -near + near * random.uniform(-1e-15, 1e-15),
        _ => random.uniform(-10.0, 10.0),
    };
    if x.is_finite() { x } else { 1.0 }
}

fn check_random(cases: usize) {
    let mut random = SplitMix64::new(7);
    let mut a = 1.0;
    for _ in 0..cases {
        let b = random_number(&mut random, a);
        check_all([a, b]);
        a = random_number(&mut random, b);
    }
}

#[test]
fn operations_on_random_numbers_contain_the_exact_results() {
    check_random(200_000);
}

/// The same with ten million numbers: minutes.
#[test]
#[ignore = "it takes minutes"]
fn operations_on_ten_million_numbers_contain_the_exact_results() {
    check_random(10_000_000);
}

#[test]
fn operations_on_numbers_at_the_ends_of_the_range_contain_the_exact_results() {
    let tiny = f64::from_bits(1);
    let ends = [0.0, tiny, 3.0 * tiny, f64::MIN_POSITIVE, f64::MIN_POSITIVE.next_down(), f64::EPSILON, 1.0];
    let more = [1.0_f64.next_up(), 1.0_f64.next_down(), 3.0, 1e154, 1e200, f64::MAX, f64::MAX.next_down()];
    let all: Vec<f64> = ends.into_iter().chain(more).flat_map(|x| [x, -x]).collect();
    for &a in &all {
        for &b in &all {
            check_all([a, b]);
        }
    }
}

/// Results of intervals contain the results of numbers in them.
#[test]
fn operations_on_intervals_contain_the_results_of_their_numbers() {
    let mut random = SplitMix64::new(3);
    for _ in 0..100_000 {
        let mut interval = || {
            let (a, b) = (random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0));
            let x = Interval::new(a, b);
            let s = random.uniform(0.0, 1.0);
            (x, (a + s * (b - a)).clamp(x.lower(), x.upper()))
        };
        let ((x, a), (y, b)) = (interval(), interval());
        check("the sum", [a, b], x + y, &Exact::of(a).plus(&Exact::of(b)));
        check("the product", [a, b], x * y, &Exact::of(a).times(&Exact::of(b)));
        if !y.contains(0.0) {
            check_quotient([a, b], x / y);
        }
        let (sine, cosine) = x.sin_cos();
        assert!(sine.contains(a.sin()) && cosine.contains(a.cos()), "{a} in {x}: {sine}, {cosine}");
    }
}

#[test]
fn sums_that_are_exact_stay_numbers() {
    let sum = Interval::from(0.25) + Interval::from(3.0);
    assert_eq!((sum.lower(), sum.upper()), (3.25, 3.25));
    let product = Interval::from(0.0) * Interval::ENTIRE;
    assert_eq!((product.lower(), product.upper()), (0.0, 0.0));
}
