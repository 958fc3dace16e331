//! Dual numbers: a value with its N partial derivatives, exact to rounding.
//!
//! x = re + Σ εₖ dₖ with dⱼdₖ = 0, so f(x) = f(re) + f′(re) Σ εₖ dₖ. One evaluation of a formula yields its
//! value and its gradient, with no step size and no cancellation. Duals nest: `Dual<Dual<f64, N>, N>` carries
//! second derivatives.
//!
//! Source: Griewank, Walther, *Evaluating Derivatives* (2008), ch. 3.1 (forward mode).

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::Scalar;

/// re + Σ εₖ dₖ over `N` independent directions; `S` is the number underneath.
///
/// ```
/// use robot_dynamics_number::{Dual, Scalar};
/// // d/dx (x sin x) at x = 2 is sin 2 + 2 cos 2.
/// let x = Dual::<f64, 1>::variable(2.0, 0);
/// let y = x * x.sin_cos().0;
/// assert!((y.gradient[0] - (2f64.sin() + 2.0 * 2f64.cos())).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<S, const N: usize> {
    /// The value.
    pub value: S,
    /// The partial derivatives ∂/∂xₖ.
    pub gradient: [S; N],
}

impl<S: Scalar, const N: usize> Dual<S, N> {
    /// A constant: gradient zero.
    ///
    /// ```
    /// use robot_dynamics_number::Dual;
    /// let x = Dual::<f64, 1>::variable(3.0, 0);
    /// assert_eq!((x * Dual::constant(2.0)).gradient, [2.0]); // d(2 x)/dx
    /// ```
    #[inline(always)]
    pub fn constant(value: S) -> Self {
        Self { value, gradient: [S::zero(); N] }
    }

    /// The k-th independent variable: ∂/∂xₖ = 1.
    ///
    /// ```
    /// use robot_dynamics_number::Dual;
    /// let x = Dual::<f64, 1>::variable(3.0, 0);
    /// assert_eq!((x * x).gradient, [6.0]); // d(x²)/dx = 2 x
    /// ```
    ///
    /// # Panics
    /// If `k ≥ N`.
    #[inline(always)]
    pub fn variable(value: S, k: usize) -> Self {
        let mut x = Self::constant(value);
        x.gradient[k] = S::one();
        x
    }

    /// The coordinates q, each an independent variable.
    ///
    /// ```
    /// use robot_dynamics_number::Dual;
    /// let [x, y] = Dual::<f64, 2>::variables(&[3.0, 5.0]);
    /// assert_eq!((x * y).gradient, [5.0, 3.0]); // ∂(x y)/∂x = y, ∂(x y)/∂y = x
    /// ```
    #[inline(always)]
    pub fn variables(q: &[S; N]) -> [Self; N] {
        core::array::from_fn(|k| Self::variable(q[k], k))
    }

    /// The chain rule: f(re) + slope · gradient, with slope = f′(re).
    ///
    /// ```
    /// use robot_dynamics_number::Dual;
    /// let x = Dual::<f64, 1>::variable(3.0, 0);
    /// let exponential = x.chain(3.0_f64.exp(), 3.0_f64.exp()); // f and f′ at x
    /// assert_eq!(exponential.gradient, [3.0_f64.exp()]);
    /// ```
    #[inline(always)]
    #[must_use]
    pub fn chain(self, value: S, slope: S) -> Self {
        Self { value, gradient: self.gradient.map(|e| e * slope) }
    }
}

impl<S: Scalar, const N: usize> Add for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl<S: Scalar, const N: usize> Sub for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        self -= other;
        self
    }
}

impl<S: Scalar, const N: usize> Mul for Dual<S, N> {
    type Output = Self;
    /// (fg)′ = f′g + fg′.
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            gradient: core::array::from_fn(|k| {
                self.gradient[k].mul_add(other.value, self.value * other.gradient[k])
            }),
        }
    }
}

impl<S: Scalar, const N: usize> Div for Dual<S, N> {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl)] // the quotient rule subtracts and multiplies
    /// (f/g)′ = (f′ − (f/g) g′)/g.
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self {
            value,
            gradient: core::array::from_fn(|k| (self.gradient[k] - value * other.gradient[k]) / other.value),
        }
    }
}

impl<S: Scalar, const N: usize> Neg for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: -self.value, gradient: self.gradient.map(|e| -e) }
    }
}

impl<S: Scalar, const N: usize> AddAssign for Dual<S, N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        for k in 0..N {
            self.gradient[k] += other.gradient[k];
        }
    }
}

impl<S: Scalar, const N: usize> SubAssign for Dual<S, N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        self.value -= other.value;
        for k in 0..N {
            self.gradient[k] -= other.gradient[k];
        }
    }
}

impl<S: Scalar, const N: usize> MulAssign for Dual<S, N> {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl<S: Scalar, const N: usize> Scalar for Dual<S, N> {
    type Triple = [Self; 3];
    type Symmetric = [Self; 6];
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Self::constant(S::from_f64(x))
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = self.value.sin_cos();
        (self.chain(sine, cosine), self.chain(cosine, -sine))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, S::from_f64(0.5) / root)
    }
    #[inline(always)]
    fn signum0(self) -> Self {
        Self::constant(self.value.signum0())
    }
    #[inline(always)]
    fn scale(self, k: f64) -> Self {
        self.chain(self.value.scale(k), S::from_f64(k))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation against its textbook derivative, at a point with no symmetry.
    #[test]
    fn derivatives_match_calculus() {
        let (x, y) = (0.7_f64, -1.3_f64);
        let [a, b] = Dual::variables(&[x, y]);
        let cases: [(Dual<f64, 2>, f64, [f64; 2]); 6] = [
            (a + b, x + y, [1.0, 1.0]),
            (a - b, x - y, [1.0, -1.0]),
            (a * b, x * y, [y, x]),
            (a / b, x / y, [1.0 / y, -x / (y * y)]),
            (a.sqrt(), x.sqrt(), [0.5 / x.sqrt(), 0.0]),
            (Scalar::sin_cos(b).1, y.cos(), [0.0, -y.sin()]),
        ];
        for (dual, value, gradient) in cases {
            assert!((dual.value - value).abs() < 1e-15);
            for k in 0..2 {
                assert!((dual.gradient[k] - gradient[k]).abs() < 1e-15, "{dual:?} {gradient:?}");
            }
        }
    }

    /// d²/dx² (x³) = 6x through nesting.
    #[test]
    fn nested_duals_carry_second_derivatives() {
        let inner = Dual::<f64, 1>::variable(1.5, 0);
        let x = Dual::<Dual<f64, 1>, 1>::variable(inner, 0);
        let cube = x * x * x;
        assert!((cube.gradient[0].gradient[0] - 9.0).abs() < 1e-14);
    }

    /// The derivatives of constants and of signs are zero, and scaling scales both parts.
    #[test]
    fn derivatives_of_constants_and_signs_are_zero() {
        let x = Dual::<f64, 2>::variable(-0.5, 1);
        assert_eq!(Dual::<f64, 2>::from_f64(3.0), Dual { value: 3.0, gradient: [0.0; 2] });
        assert_eq!(x.signum0(), Dual::constant(-1.0));
        assert_eq!(x.scale(4.0), Dual { value: -2.0, gradient: [0.0, 4.0] });
        assert_eq!(-x, Dual { value: 0.5, gradient: [0.0, -1.0] });
        assert_eq!(x.mul_add(x, x), Dual { value: -0.25, gradient: [0.0, 0.0] }); // (x² + x)′ = 0 at −½
    }

    #[test]
    #[should_panic(expected = "index out of bounds")]
    fn a_variable_out_of_range_panics() {
        let _ = Dual::<f64, 2>::variable(1.0, 2);
    }

    /// A formula with every operation.
    #[cfg(not(target_family = "wasm"))] // like proptest
    fn formula<S: Scalar>(x: S, y: S) -> S {
        let (sine, cosine) = (x * y).sin_cos();
        let mut sum = sine / (x * x + y * y + S::one()).sqrt();
        sum -= cosine.scale(0.3);
        sum *= y - x;
        sum
    }

    #[cfg(not(target_family = "wasm"))]
    proptest::proptest! {
        #![proptest_config(proptest::test_runner::Config { cases: if cfg!(miri) { 2 } else { 256 }, ..Default::default() })]
        /// The gradient agrees with fourth-order differences. The Hessian by nested duals is symmetric and
        /// agrees with differences of gradients.
        #[test]
        fn derivatives_match_differences(x in -3.0..3.0_f64, y in -3.0..3.0_f64) {
            type First = Dual<f64, 2>;
            let h = 1e-3;
            // f′ ≈ (8(f₁ − f₋₁) − (f₂ − f₋₂))/12h; truncation h⁴f⁽⁵⁾/30 with f⁽⁵⁾ up to 10⁵: 4e-9.
            let slope = |f: &dyn Fn(f64) -> f64| (8.0 * (f(h) - f(-h)) - f(2.0 * h) + f(-2.0 * h)) / (12.0 * h);
            let gradient = |x: f64, y: f64| {
                let [a, b] = First::variables(&[x, y]);
                formula(a, b).gradient
            };
            let found = gradient(x, y);
            let expected = [slope(&|s| formula(x + s, y)), slope(&|s| formula(x, y + s))];
            let [a, b] = First::variables(&[x, y]);
            let [a, b] = Dual::<First, 2>::variables(&[a, b]);
            let hessian = formula(a, b).gradient.map(|row| row.gradient);
            proptest::prop_assert!((hessian[0][1] - hessian[1][0]).abs() < 1e-13, "{hessian:?}");
            for i in 0..2 {
                proptest::prop_assert!((found[i] - expected[i]).abs() < 1e-8, "{found:?} {expected:?}");
                let rows = [slope(&|s| gradient(x + s, y)[i]), slope(&|s| gradient(x, y + s)[i])];
                for j in 0..2 {
                    proptest::prop_assert!((hessian[i][j] - rows[j]).abs() < 1e-7, "{hessian:?} {rows:?}");
                }
            }
        }
    }
}
