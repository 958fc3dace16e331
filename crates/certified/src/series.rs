//! Truncated power series in time as numbers of the recursions.

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use robot_dynamics_number::Scalar;

/// The number of coefficients.
pub(crate) const TERMS: usize = 7;

/// c₀ + c₁ t + … up to t⁶. Operations are those of power series, truncated. Source: Griewank, Walther,
/// *Evaluating Derivatives* (2008), ch. 13.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Series<S>(pub(crate) [S; TERMS]);

impl<S: Scalar> Series<S> {
    pub(crate) fn constant(x: S) -> Self {
        let mut series = [S::zero(); TERMS];
        series[0] = x;
        Self(series)
    }
}

impl<S: Scalar> Add for Series<S> {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl<S: Scalar> Sub for Series<S> {
    type Output = Self;

    fn sub(mut self, other: Self) -> Self {
        self -= other;
        self
    }
}

impl<S: Scalar> Neg for Series<S> {
    type Output = Self;

    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl<S: Scalar> Mul for Series<S> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self(core::array::from_fn(|k| {
            (1..=k).fold(self.0[0] * other.0[k], |sum, i| sum + self.0[i] * other.0[k - i])
        }))
    }
}

impl<S: Scalar> Div for Series<S> {
    type Output = Self;

    /// From q · other = self, coefficient by coefficient.
    #[allow(clippy::suspicious_arithmetic_impl)] // the recurrence of a quotient
    fn div(self, other: Self) -> Self {
        let mut quotient = [S::zero(); TERMS];
        for k in 0..TERMS {
            let known = (0..k).fold(self.0[k], |rest, i| rest - quotient[i] * other.0[k - i]);
            quotient[k] = known / other.0[0];
        }
        Self(quotient)
    }
}

impl<S: Scalar> AddAssign for Series<S> {
    fn add_assign(&mut self, other: Self) {
        for (x, y) in self.0.iter_mut().zip(other.0) {
            *x += y;
        }
    }
}

impl<S: Scalar> SubAssign for Series<S> {
    fn sub_assign(&mut self, other: Self) {
        for (x, y) in self.0.iter_mut().zip(other.0) {
            *x -= y;
        }
    }
}

impl<S: Scalar> MulAssign for Series<S> {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl<S: Scalar> Scalar for Series<S> {
    type Triple = [Self; 3];
    type Symmetric = [Self; 6];

    fn from_f64(x: f64) -> Self {
        Self::constant(S::from_f64(x))
    }

    /// From s′ = c x′ and c′ = −s x′.
    fn sin_cos(self) -> (Self, Self) {
        let (mut sine, mut cosine) = ([S::zero(); TERMS], [S::zero(); TERMS]);
        (sine[0], cosine[0]) = self.0[0].sin_cos();
        for k in 1..TERMS {
            let (mut s, mut c) = (S::zero(), S::zero());
            for i in 1..=k {
                let rate = self.0[i].scale(i as f64);
                s += cosine[k - i] * rate;
                c -= sine[k - i] * rate;
            }
            let order = S::from_f64(k as f64);
            (sine[k], cosine[k]) = (s / order, c / order);
        }
        (Self(sine), Self(cosine))
    }

    /// From r · r = self.
    fn sqrt(self) -> Self {
        let mut root = [S::zero(); TERMS];
        root[0] = self.0[0].sqrt();
        for k in 1..TERMS {
            let rest = (1..k).fold(self.0[k], |rest, i| rest - root[i] * root[k - i]);
            root[k] = rest / root[0].scale(2.0);
        }
        Self(root)
    }

    fn signum0(self) -> Self {
        Self::constant(self.0[0].signum0())
    }
}
