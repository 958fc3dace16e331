//! The rate Θ̇ of q = q₀ ⊕ Θ, for any scalar type.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

use crate::Model;
use crate::configuration::manifold::{CoordinateRange, coordinate_ranges, vector_at};
use crate::joint::Chart;

/// Θ̇ of q = q₀ ⊕ Θ at velocity v: Θ̇ = v + ½\[Θ,v\] + ¹⁄₁₂\[Θ,\[Θ,v\]\] + O(|Θ|⁴). **(HLW §IV.8)**
#[inline(always)]
pub fn displacement_rate<N: Scalar>(model: &Model, theta: &[N], v: &[N], rate: &mut [N]) {
    // A mimic joint repeats its leader's segment; the leader is a plain coordinate, where Θ̇ = v for any Θ.
    for CoordinateRange { chart, v: k, .. } in coordinate_ranges(model) {
        match chart {
            Chart::Line => rate[k] = v[k],
            Chart::Rotation => {
                let (t, w) = (vector_at(theta, k), vector_at(v, k));
                let once = t.cross(w);
                store(corrected(w, once, t.cross(once)), &mut rate[k..]);
            }
            Chart::Placement => {
                let t = (vector_at(theta, k), vector_at(theta, k + 3));
                let w = (vector_at(v, k), vector_at(v, k + 3));
                let once = bracket(t, w);
                let twice = bracket(t, once);
                store(corrected(w.0, once.0, twice.0), &mut rate[k..]);
                store(corrected(w.1, once.1, twice.1), &mut rate[k + 3..]);
            }
        }
    }
}

/// w + ½a + ¹⁄₁₂b.
#[inline(always)]
fn corrected<N: Scalar>(w: V3<N>, a: V3<N>, b: V3<N>) -> V3<N> {
    w.add_scaled(N::from_f64(0.5), a).add_scaled(N::from_f64(1.0 / 12.0), b)
}

/// The Lie bracket of se(3), linear part first: \[(u,ω),(u′,ω′)\] = (ω × u′ + u × ω′, ω × ω′). **(MR
/// §8.2.2)**
#[inline(always)]
pub fn bracket<N: Scalar>(a: (V3<N>, V3<N>), b: (V3<N>, V3<N>)) -> (V3<N>, V3<N>) {
    (a.1.cross(b.0) + a.0.cross(b.1), a.1.cross(b.1))
}

/// The inverse of [`vector_at`].
#[inline(always)]
pub fn store<N: Scalar>(x: V3<N>, to: &mut [N]) {
    let [x, y, z] = x.array();
    (to[0], to[1], to[2]) = (x, y, z);
}
