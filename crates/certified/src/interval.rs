//! A closed interval of real numbers.

use core::fmt;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// A closed interval \[lower, upper\] of real numbers. Bounds may be infinite; they are never NaN.
///
/// An operation contains the results for all numbers of its arguments. Where a result is undefined (division
/// by an interval with 0, the difference of infinities), it is the whole line.
///
/// ```
/// use robot_dynamics_certified::Interval;
/// let third = Interval::from(1.0) / Interval::from(3.0);
/// assert!(third.lower() < third.upper() && third.width() < 2e-16);
/// let x = Interval::new(-1.0, 2.0);
/// assert_eq!((x + x, x * x), (Interval::new(-2.0, 4.0), Interval::new(-2.0000000000000004, 4.000000000000001)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    lower: f64,
    upper: f64,
}

impl Interval {
    /// The whole line.
    pub const ENTIRE: Self = Self { lower: f64::NEG_INFINITY, upper: f64::INFINITY };

    /// The interval between two numbers, in any order. A NaN gives the whole line.
    ///
    /// ```
    /// use robot_dynamics_certified::Interval;
    /// assert_eq!(Interval::new(2.0, 1.0), Interval::new(1.0, 2.0));
    /// assert_eq!(Interval::new(f64::NAN, 1.0), Interval::ENTIRE);
    /// ```
    pub const fn new(a: f64, b: f64) -> Self {
        if a <= b {
            Self { lower: a, upper: b }
        } else if b < a {
            Self { lower: b, upper: a }
        } else {
            Self::ENTIRE
        }
    }

    /// The interval around a number, at most `radius` away from it.
    ///
    /// ```
    /// use robot_dynamics_certified::Interval;
    /// let x = Interval::around(0.1, 0.2);
    /// assert!(x.contains(-0.1) && x.contains(0.3) && x.width() < 0.4 + 1e-15);
    /// ```
    pub fn around(middle: f64, radius: f64) -> Self {
        Self::from(middle) + Self::new(-radius, radius)
    }

    /// The smallest interval that contains both.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        Self { lower: self.lower.min(other.lower), upper: self.upper.max(other.upper) }
    }

    /// The numbers that are in both, or `None` if the intervals are disjoint.
    ///
    /// ```
    /// use robot_dynamics_certified::Interval;
    /// let x = Interval::new(0.0, 2.0).intersection(Interval::new(1.0, 3.0));
    /// assert_eq!(x, Some(Interval::new(1.0, 2.0)));
    /// assert_eq!(Interval::from(0.0).intersection(Interval::from(1.0)), None);
    /// ```
    pub fn intersection(self, other: Self) -> Option<Self> {
        let (lower, upper) = (self.lower.max(other.lower), self.upper.min(other.upper));
        (lower <= upper).then_some(Self { lower, upper })
    }

    /// Both halves, which share the middle.
    pub fn halves(self) -> [Self; 2] {
        let middle = self.middle();
        [Self { lower: self.lower, upper: middle }, Self { lower: middle, upper: self.upper }]
    }

    /// The least number.
    pub const fn lower(self) -> f64 {
        self.lower
    }

    /// The greatest number.
    pub const fn upper(self) -> f64 {
        self.upper
    }

    /// An upper bound of `upper − lower`.
    pub fn width(self) -> f64 {
        (Self::from(self.upper) - Self::from(self.lower)).upper
    }

    /// A number near the middle, in the interval.
    pub fn middle(self) -> f64 {
        let middle = 0.5 * self.lower + 0.5 * self.upper;
        if middle.is_nan() { 0.0 } else { middle.clamp(self.lower, self.upper) }
    }

    /// The largest absolute value.
    pub fn magnitude(self) -> f64 {
        self.lower.abs().max(self.upper.abs())
    }

    /// Whether a number lies in the interval.
    pub fn contains(self, x: f64) -> bool {
        self.lower <= x && x <= self.upper
    }

    /// Whether all numbers of another interval lie in this one.
    pub fn encloses(self, other: Self) -> bool {
        self.lower <= other.lower && other.upper <= self.upper
    }

    /// Whether both bounds are finite.
    pub fn is_bounded(self) -> bool {
        self.lower.is_finite() && self.upper.is_finite()
    }

    /// The neighbours of results that are rounded to nearest.
    fn widened(lower: f64, upper: f64) -> Self {
        Self { lower: lower.next_down(), upper: upper.next_up() }
    }

    fn is_zero(self) -> bool {
        self.lower == 0.0 && self.upper == 0.0
    }
}

impl From<f64> for Interval {
    /// The interval of one number. A NaN gives the whole line.
    fn from(x: f64) -> Self {
        Self::new(x, x)
    }
}

impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}, {}]", self.lower, self.upper)
    }
}

/// a + b to nearest, and the rest of the exact sum. The rest is NaN if the sum overflows.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// a + b rounded down.
fn add_down(a: f64, b: f64) -> f64 {
    let (sum, rest) = two_sum(a, b);
    if rest >= 0.0 {
        sum
    } else if sum.is_nan() {
        f64::NEG_INFINITY
    } else {
        // The rest is negative, or unknown since the sum overflows.
        sum.next_down()
    }
}

/// a + b rounded up.
fn add_up(a: f64, b: f64) -> f64 {
    -add_down(-a, -b)
}

/// a b to nearest; 0 if a factor is 0, also if the other is infinite.
fn product(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

/// The least and the greatest of four numbers.
fn extremes([a, b, c, d]: [f64; 4]) -> (f64, f64) {
    (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
}

impl Add for Interval {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { lower: add_down(self.lower, other.lower), upper: add_up(self.upper, other.upper) }
    }
}

impl Sub for Interval {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Interval {
    type Output = Self;

    fn neg(self) -> Self {
        Self { lower: -self.upper, upper: -self.lower }
    }
}

impl Mul for Interval {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        for (one, factor) in [(self, other), (other, self)] {
            if one.is_zero() {
                return Self::from(0.0);
            }
            if one.lower == one.upper && one.lower.abs() == 1.0 {
                return if one.lower > 0.0 { factor } else { -factor };
            }
        }
        let (a, b) = (self, other);
        let (lower, upper) = extremes([
            product(a.lower, b.lower),
            product(a.lower, b.upper),
            product(a.upper, b.lower),
            product(a.upper, b.upper),
        ]);
        Self::widened(lower, upper)
    }
}

impl Div for Interval {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        if other.contains(0.0) {
            return Self::ENTIRE;
        }
        if self.is_zero() {
            return self;
        }
        let (a, b) = (self, other);
        let quotients = [a.lower / b.lower, a.lower / b.upper, a.upper / b.lower, a.upper / b.upper];
        // ∞/∞ is undefined.
        if quotients.iter().any(|x| x.is_nan()) {
            return Self::ENTIRE;
        }
        let (lower, upper) = extremes(quotients);
        Self::widened(lower, upper)
    }
}

impl AddAssign for Interval {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Interval {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl MulAssign for Interval {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}
