//! A scalar type that counts arithmetic operations.
//!
//! In the recursions it counts their operations for a robot, and those of a program for that robot alone.
//! Such a program omits an operation on a known constant 0 or 1, and computes one of two constants in
//! advance.

use core::cell::Cell;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use robot_dynamics_number::Scalar;

/// Numbers of operations; sign changes do not count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// a + b and a − b.
    pub additions: u64,
    /// a b.
    pub multiplications: u64,
    /// a b + c as one operation.
    pub fused: u64,
    /// a / b.
    pub divisions: u64,
    /// √a.
    pub roots: u64,
    /// sin a and cos a as one operation.
    pub sines: u64,
}

impl Counts {
    /// Additions and multiplications, where a fused one counts twice; divisions count as one.
    pub fn arithmetic(&self) -> u64 {
        self.additions + self.multiplications + 2 * self.fused + self.divisions + self.roots
    }

    /// Instructions of a machine with fused multiply-add.
    pub fn instructions(&self) -> u64 {
        self.additions + self.multiplications + self.fused + self.divisions + self.roots
    }
}

/// The counts of the recursions, and of a program for one robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Every operation.
    pub done: Counts,
    /// Operations that no known constant saves.
    pub left: Counts,
}

thread_local! {
    static TALLY: Cell<Tally> = Cell::new(Tally::default());
}

/// The operations of this thread's [`Counted`] numbers during the call.
pub fn tally(call: impl FnOnce()) -> Tally {
    TALLY.set(Tally::default());
    call();
    TALLY.get()
}

/// A number known only as a constant of the robot or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Counted(Option<f64>);

impl Counted {
    /// A number of the state, unknown in advance.
    pub const UNKNOWN: Self = Self(None);

    fn is(self, x: f64) -> bool {
        self.0 == Some(x)
    }

    fn is_unit(self) -> bool {
        self.is(1.0) || self.is(-1.0)
    }
}

fn count(done: impl FnOnce(&mut Counts)) {
    let mut tally = TALLY.get();
    done(&mut tally.done);
    TALLY.set(tally);
}

fn leave(left: impl FnOnce(&mut Counts)) -> Counted {
    let mut tally = TALLY.get();
    left(&mut tally.left);
    TALLY.set(tally);
    Counted::UNKNOWN
}

/// a + b in a program for one robot.
fn sum(a: Counted, b: Counted) -> Counted {
    match (a.0, b.0) {
        (Some(a), Some(b)) => Counted(Some(a + b)),
        (Some(0.0), None) => b,
        (None, Some(0.0)) => a,
        _ => leave(|left| left.additions += 1),
    }
}

/// a b in a program for one robot.
fn product(a: Counted, b: Counted) -> Counted {
    match (a.0, b.0) {
        (Some(a), Some(b)) => Counted(Some(a * b)),
        _ if a.is(0.0) || b.is(0.0) => Counted(Some(0.0)),
        _ if a.is_unit() || b.is_unit() => Counted::UNKNOWN,
        _ => leave(|left| left.multiplications += 1),
    }
}

impl Add for Counted {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        count(|done| done.additions += 1);
        sum(self, other)
    }
}

impl Sub for Counted {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl)] // it counts
    fn sub(self, other: Self) -> Self {
        count(|done| done.additions += 1);
        sum(self, -other)
    }
}

impl Mul for Counted {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        count(|done| done.multiplications += 1);
        product(self, other)
    }
}

impl Div for Counted {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        count(|done| done.divisions += 1);
        match (self.0, other.0) {
            (Some(a), Some(b)) => Self(Some(a / b)),
            (Some(0.0), None) => self,
            // The inverse of a constant is a constant.
            (None, Some(b)) => product(self, Self(Some(1.0 / b))),
            _ => leave(|left| left.divisions += 1),
        }
    }
}

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl AddAssign for Counted {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Counted {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl MulAssign for Counted {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl Scalar for Counted {
    type Triple = [Self; 3];
    type Symmetric = [Self; 6];

    fn from_f64(x: f64) -> Self {
        Self(Some(x))
    }

    fn sin_cos(self) -> (Self, Self) {
        count(|done| done.sines += 1);
        if let Some(x) = self.0 {
            return (Self(Some(x.sin())), Self(Some(x.cos())));
        }
        leave(|left| left.sines += 1);
        (Self::UNKNOWN, Self::UNKNOWN)
    }

    fn sqrt(self) -> Self {
        count(|done| done.roots += 1);
        match self.0 {
            Some(x) => Self(Some(x.sqrt())),
            None => leave(|left| left.roots += 1),
        }
    }

    fn signum0(self) -> Self {
        Self(self.0.map(Scalar::signum0))
    }

    fn mul_add(self, a: Self, b: Self) -> Self {
        count(|done| done.fused += 1);
        let needs_product = self.0.is_none() || a.0.is_none();
        let is_lone = [self, a].iter().any(|x| x.is(0.0) || x.is_unit());
        if needs_product && !is_lone && !b.is(0.0) {
            return leave(|left| left.fused += 1);
        }
        sum(product(self, a), b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Counted = Counted::UNKNOWN;

    type Case = (&'static str, fn() -> Counted, u64, u64);

    fn constant(x: f64) -> Counted {
        Counted::from_f64(x)
    }

    /// Constants save operations of the program, but not of the recursions.
    #[test]
    fn constants_save_operations() {
        let cases: [Case; 9] = [
            ("x + x", || X + X, 1, 1),
            ("x + 0", || X + constant(0.0), 1, 0),
            ("0 − x", || constant(0.0) - X, 1, 0),
            ("x · 2", || X * constant(2.0), 1, 1),
            ("x · −1", || X * constant(-1.0), 1, 0),
            ("2 + 3", || constant(2.0) + constant(3.0), 1, 0),
            ("x x + 0", || X.mul_add(X, constant(0.0)), 2, 1),
            ("1 x + x", || constant(1.0).mul_add(X, X), 2, 1),
            ("0 x + x", || constant(0.0).mul_add(X, X), 2, 0),
        ];
        for (text, call, done, left) in cases {
            let tally = tally(|| {
                call();
            });
            assert_eq!((tally.done.arithmetic(), tally.left.arithmetic()), (done, left), "{text}");
        }
        assert_eq!((X * constant(0.0)).0, Some(0.0));
        assert_eq!(X.mul_add(constant(2.0), X).0, None);
    }

    /// A polynomial by Horner's rule: a multiplication and an addition per degree; its sine is one pair.
    #[test]
    fn a_formula_is_counted() {
        let found = tally(|| {
            let y = [3.0, 2.0, 5.0].into_iter().fold(constant(7.0), |y, c| y.mul_add(X, constant(c)));
            let _ = (y / X).sqrt().sin_cos();
        });
        let expected =
            Counts { additions: 0, multiplications: 0, fused: 3, divisions: 1, roots: 1, sines: 1 };
        assert_eq!((found.done, found.left), (expected, expected));
        assert_eq!((expected.arithmetic(), expected.instructions()), (8, 5));
    }
}
