//! The knife edge: a planar body that cannot slip sideways, also a wheeled chassis, "Rusty".

use nalgebra::{RowSVector, SMatrix, SVector, Vector2, matrix, vector};
use robot_dynamics_number::Scalar;

use crate::{Pfaffian, PfaffianOver, PlanarBody};

/// A planar body on a blade, or on two wheels with one axle through its centre of mass.
///
/// q = (x, y, θ) as in [`PlanarBody`]; the heading is (cos θ, sin θ). Without side slip A = \[sin θ, −cos θ,
/// 0\] and Ȧ = θ̇ \[cos θ, sin θ, 0\]. λ \[N\] is the side force of the floor on the blade. It is positive to
/// the right of the heading, since Aᵀλ = λ (sin θ, −cos θ, 0).
///
/// On a level floor `body.a_g` is 0; on a slope it is the component of gravity along the floor, down −y. With
/// u2′ = u2 − m a_g the methods are closed forms, for comparison with
/// [`constrained_forward_dynamics`](crate::constrained_forward_dynamics).
///
/// ```
/// use dynamics::KnifeEdge;
/// use nalgebra::vector;
/// let rusty = KnifeEdge::new(2.0, 0.5);
/// // Forward at 3 m/s along x and turning left at 1.5 rad/s: the floor pushes left with m v θ̇ = 9 N.
/// let lambda = rusty.side_force(&vector![0.0, 0.0, 0.0], &vector![3.0, 0.0, 1.5], &vector![0.0, 0.0, 0.0]);
/// assert!((lambda + 9.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnifeEdge {
    /// The body without the blade.
    pub body: PlanarBody,
}

impl KnifeEdge {
    /// A body of mass `m` \[kg\] and moment of inertia `i_zz` \[kg·m²\] on a level floor.
    pub fn new(m: f64, i_zz: f64) -> Self {
        Self { body: PlanarBody { m, i_zz, a_g: 0.0 } }
    }

    /// λ = (u2′ − m q̇1 q̇3) cos q3 − (u1 + m q̇2 q̇3) sin q3 \[N\].
    pub fn side_force(&self, q: &SVector<f64, 3>, qd: &SVector<f64, 3>, u: &SVector<f64, 3>) -> f64 {
        let (sine, cosine) = q[2].sin_cos();
        let PlanarBody { m, a_g, .. } = self.body;
        (u[1] - m * a_g - m * qd[0] * qd[2]) * cosine - (u[0] + m * qd[1] * qd[2]) * sine
    }

    /// q̈ = ((u1 + λ sin q3)/m, (u2′ − λ cos q3)/m, u3/I).
    pub fn acceleration(
        &self,
        q: &SVector<f64, 3>,
        qd: &SVector<f64, 3>,
        u: &SVector<f64, 3>,
    ) -> SVector<f64, 3> {
        let (sine, cosine) = q[2].sin_cos();
        let lambda = self.side_force(q, qd, u);
        let PlanarBody { m, i_zz, a_g } = self.body;
        vector![(u[0] + lambda * sine) / m, (u[1] - lambda * cosine) / m - a_g, u[2] / i_zz]
    }

    /// P = \[\[c², sc, 0\], \[sc, s², 0\], \[0, 0, 1\]\] with s = sin q3, c = cos q3: keeps the forward
    /// velocity and the rotation.
    pub fn projection(q: &SVector<f64, 3>) -> SMatrix<f64, 3, 3> {
        let (s, c) = q[2].sin_cos();
        matrix![c * c, s * c, 0.0; s * c, s * s, 0.0; 0.0, 0.0, 1.0]
    }

    /// The reduced pair, free of λ: (q̈1 c + q̈2 s, q̈3) = ((u1 c + u2′ s)/m, u3/I) \[m/s², rad/s²\].
    ///
    /// On A q̇ = 0 the first entry is v̇, the rate of the forward speed.
    pub fn reduced_acceleration(&self, q: &SVector<f64, 3>, u: &SVector<f64, 3>) -> Vector2<f64> {
        let (sine, cosine) = q[2].sin_cos();
        let PlanarBody { m, i_zz, a_g } = self.body;
        vector![(u[0] * cosine + u[1] * sine) / m - a_g * sine, u[2] / i_zz]
    }

    /// T(q), 3×2: u = T (F_left, F_right) for wheels at ∓`half_track` \[m\] that push forward. **(PRM
    /// 10.12)**
    ///
    /// T = \[\[c, c\], \[s, s\], \[−w, w\]\]; Tᵀq̇ are the speeds of the two wheel hubs. Wheel forces cause
    /// no side force of the floor: A M⁻¹ T = 0.
    pub fn wheel_map(q: &SVector<f64, 3>, half_track: f64) -> SMatrix<f64, 3, 2> {
        let (s, c) = q[2].sin_cos();
        matrix![c, c; s, s; -half_track, half_track]
    }

    /// v = q̇1 cos q3 + q̇2 sin q3 \[m/s\].
    pub fn forward_speed(q: &SVector<f64, 3>, qd: &SVector<f64, 3>) -> f64 {
        let (sine, cosine) = q[2].sin_cos();
        qd[0] * cosine + qd[1] * sine
    }

    /// q̇ = (v cos q3, v sin q3, ω): the allowed velocity with forward speed v and turning rate ω.
    pub fn velocity(q: &SVector<f64, 3>, v: f64, omega: f64) -> SVector<f64, 3> {
        let (sine, cosine) = q[2].sin_cos();
        vector![v * cosine, v * sine, omega]
    }
}

impl Pfaffian<1, 3> for KnifeEdge {
    fn rows(&self, q: &SVector<f64, 3>) -> RowSVector<f64, 3> {
        let (sine, cosine) = q[2].sin_cos();
        matrix![sine, -cosine, 0.0]
    }

    fn rows_rate(&self, q: &SVector<f64, 3>, qd: &SVector<f64, 3>) -> RowSVector<f64, 3> {
        let (sine, cosine) = q[2].sin_cos();
        matrix![qd[2] * cosine, qd[2] * sine, 0.0]
    }
}

impl PfaffianOver<1, 3> for KnifeEdge {
    fn rows_over<S: Scalar>(&self, q: &[S; 3]) -> [[S; 3]; 1] {
        let (sine, cosine) = q[2].sin_cos();
        [[sine, -cosine, S::zero()]]
    }
}
