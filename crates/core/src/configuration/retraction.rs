//! q ⊕ δ for a block of states: the exponential map without branches.

use robot_dynamics_description::rotation_of;
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

use crate::Model;
use crate::configuration::displacement_rate::store;
use crate::configuration::manifold::{CoordinateRange, coordinate_ranges, vector_at};
use crate::joint::Chart;

/// `moved` = q ⊕ δ for rotations up to 12 rad; no integration step takes a larger one. The independent route
/// is [`integrate`](crate::integrate), which branches and takes any rotation.
#[inline(always)]
pub fn move_along<N: Scalar>(model: &Model, q: &[N], displacement: &[N], moved: &mut [N]) {
    for CoordinateRange { chart, q: i, v: k } in coordinate_ranges(model) {
        match chart {
            Chart::Line => moved[i] = q[i] + displacement[k],
            Chart::Rotation => {
                let turn = RotationVector::new(vector_at(displacement, k));
                turn_by(&q[i..], &turn, &mut moved[i..]);
            }
            Chart::Placement => {
                let linear = vector_at(displacement, k);
                let angular = vector_at(displacement, k + 3);
                let turn = RotationVector::new(angular);
                let (b, c) = turn.shift_coefficients();
                let once = angular.cross(linear);
                let shift = linear.add_scaled(b, once).add_scaled(c, angular.cross(once));
                let start = [q[i + 3], q[i + 4], q[i + 5], q[i + 6]];
                let start = [start[0], start[1], start[2], start[3]];
                let position = vector_at(q, i) + rotation_of(&start) * shift;
                store(position, &mut moved[i..]);
                turn_by(&q[i + 3..], &turn, &mut moved[i + 3..]);
            }
        }
    }
}

/// A rotation vector φ, θ = |φ|.
struct RotationVector<N: Scalar> {
    phi: V3<N>,
    theta: N,
    /// sin ½θ / ½θ.
    sinc: N,
    cosine: N,
}

impl<N: Scalar> RotationVector<N> {
    #[inline(always)]
    fn new(phi: V3<N>) -> Self {
        // 1e-30 keeps θ from being zero; sin x / x rounds to 1 at much larger x.
        let theta = (phi.dot(phi) + N::from_f64(1e-30)).sqrt();
        let half = theta.scale(0.5);
        let (sine, cosine) = half.sin_cos();
        Self { phi, theta, sinc: sine / half, cosine }
    }

    /// B = (1 − cos θ)/θ² and C = (θ − sin θ)/θ³.
    ///
    /// With s(x) = sin x / x: B(θ) = ½ s(½θ)² and C(θ) = ¼ C(½θ) + ¼ s(½θ) B(½θ), which are sums of positive
    /// numbers. After three halvings C is its power series Σ (−x²)ᵏ/(2k+3)!, whose tenth term is below 1e-17
    /// for x < 1.5.
    #[inline(always)]
    fn shift_coefficients(&self) -> (N, N) {
        let s1 = self.sinc;
        let s2 = sinc(self.theta.scale(0.25));
        let s3 = sinc(self.theta.scale(0.125));
        let s4 = sinc(self.theta.scale(0.0625));
        let x = self.theta.scale(0.125);
        let y = x * x;
        let mut sum = N::one();
        for k in (1..10u32).rev() {
            let n = f64::from(2 * k + 3);
            sum = N::one() - (sum * y).scale(1.0 / (n * (n - 1.0)));
        }
        let c = sum.scale(1.0 / 6.0);
        let c = (c + (s3 * s4 * s4).scale(0.5)).scale(0.25);
        let c = (c + (s2 * s3 * s3).scale(0.5)).scale(0.25);
        let c = (c + (s1 * s2 * s2).scale(0.5)).scale(0.25);
        ((s1 * s1).scale(0.5), c)
    }
}

/// q ⊗ (½φ s(½θ), cos ½θ), normalized; quaternions x y z w.
#[inline(always)]
fn turn_by<N: Scalar>(q: &[N], turn: &RotationVector<N>, to: &mut [N]) {
    let (a, w) = (vector_at(q, 0), q[3]);
    let b = turn.phi * turn.sinc.scale(0.5);
    let imaginary = a * turn.cosine + b * w + a.cross(b);
    let scalar = w * turn.cosine - a.dot(b);
    let inverse = N::one() / (imaginary.dot(imaginary) + scalar * scalar).sqrt();
    store(imaginary * inverse, to);
    to[3] = scalar * inverse;
}

/// sin x / x, x not zero.
#[inline(always)]
fn sinc<N: Scalar>(x: N) -> N {
    x.sin_cos().0 / x
}
