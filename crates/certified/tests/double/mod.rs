//! A number of two floats, 106 bits, as an independent route to the digits.

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use robot_dynamics::number::Scalar;

/// The sum of two floats, of which the second is at most half a rounding of the first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Double(f64, f64);

fn sum(a: f64, b: f64) -> Double {
    let s = a + b;
    let part = s - a;
    Double(s, (a - (s - part)) + (b - part))
}

impl Double {
    /// The number in one float.
    pub(crate) fn value(self) -> f64 {
        self.0 + self.1
    }

    /// Whether the number lies between two floats, to a slack.
    pub(crate) fn is_within(self, lower: f64, upper: f64, slack: f64) -> bool {
        (self - Self(lower, 0.0)).value() >= -slack && (Self(upper, 0.0) - self).value() >= -slack
    }
}

impl Add for Double {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, low) = (sum(self.0, other.0), sum(self.1, other.1));
        let first = sum(high.0, high.1 + low.0);
        sum(first.0, first.1 + low.1)
    }
}

impl Neg for Double {
    type Output = Self;

    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Sub for Double {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Double {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let rest = self.0.mul_add(other.0, -product);
        sum(product, rest + (self.0 * other.1 + self.1 * other.0))
    }
}

impl Div for Double {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let first = self.0 / other.0;
        let rest = self - other * Self(first, 0.0);
        let second = rest.0 / other.0;
        let rest = rest - other * Self(second, 0.0);
        sum(first, second) + Self(rest.0 / other.0, 0.0)
    }
}

impl AddAssign for Double {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Double {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl MulAssign for Double {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl Scalar for Double {
    type Triple = [Self; 3];
    type Symmetric = [Self; 6];

    fn from_f64(x: f64) -> Self {
        Self(x, 0.0)
    }

    /// By the series of x/2¹², and twelve doublings.
    fn sin_cos(self) -> (Self, Self) {
        const DOUBLINGS: i32 = 12;
        let x = self * Self(2.0_f64.powi(-DOUBLINGS), 0.0);
        let square = x * x;
        let (mut sine, mut versine) = (x, Self(0.0, 0.0));
        let (mut term, mut even) = (x, Self(-1.0, 0.0));
        for k in 1..12 {
            let k = f64::from(2 * k);
            even = -(even * square) / Self(k * (k - 1.0), 0.0);
            term = -(term * square) / Self(k * (k + 1.0), 0.0);
            versine += even;
            sine += term;
        }
        // 1 − cos keeps the digits of small angles.
        for _ in 0..DOUBLINGS {
            let cosine = Self(1.0, 0.0) - versine;
            versine = Self(2.0, 0.0) * sine * sine;
            sine = Self(2.0, 0.0) * sine * cosine;
        }
        (sine, Self(1.0, 0.0) - versine)
    }

    fn sqrt(self) -> Self {
        let root = self.0.sqrt();
        if root == 0.0 {
            return self;
        }
        let rest = self - Self(root, 0.0) * Self(root, 0.0);
        sum(root, rest.value() / (2.0 * root))
    }

    fn signum0(self) -> Self {
        Self(self.0.signum0(), 0.0)
    }
}
