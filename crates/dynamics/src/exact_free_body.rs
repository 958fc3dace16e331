//! The free rotation of a rigid body in closed form, by Jacobi's elliptic functions.
//!
//! Source: Landau, Lifshitz, *Mechanics* (3rd ed. 1976), §37. A reference for the integrators, with which it
//! shares no code.

mod jacobi;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

pub use jacobi::{complete_elliptic_k, incomplete_elliptic_f, jacobi_sn_cn_dn};

use robot_dynamics_description::RotationalInertia;

use self::jacobi::Parameter;

/// Gauss's five-point rule on \[−1, 1\]: exact for polynomials of degree 9.
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// The motion of a free body from a given orientation and angular velocity, at any time.
///
/// The principal axes 1, 2, 3 are numbered so that the motion circles axis 3, and axis 2 is the middle one.
/// Axis 3 has the largest moment if |L|² ≥ 2K I₂, and the smallest if |L|² < 2K I₂. Then
///
/// ω₁ = A₁ cn u, ω₂ = A₂ sn u, ω₃ = A₃ dn u, u = λt + u₀, m = (I₂−I₁)(2KI₃−L²)/((I₃−I₂)(L²−2KI₁)).
///
/// ```
/// use dynamics::FreeRotation;
/// use nalgebra::{UnitQuaternion, Vector3};
/// use robot_dynamics_description::MassProperties;
/// let brick = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1))?.rotational()?;
/// let spin = Vector3::new(0.01, 5.0, 0.01);
/// let motion = FreeRotation::new(&brick, &UnitQuaternion::identity(), &spin);
/// // Spun about its middle axis, the brick turns over: half a period later ω₂ has changed sign.
/// let flipped = motion.omega_in_body(motion.period() / 2.0);
/// assert!((flipped.y + 5.0).abs() < 1e-4);
/// # Ok::<(), robot_dynamics_description::InertiaError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeRotation {
    /// Columns: the axes 1, 2, 3 in body coordinates; left-handed if the numbering is an odd permutation.
    body_from_axes: Matrix3<f64>,
    moments: Vector3<f64>,
    amplitudes: Vector3<f64>,
    rate: f64,
    phase: f64,
    parameter: Parameter,
    omega_at_start: Vector3<f64>,
    world_from_body_at_start: UnitQuaternion<f64>,
    momentum_in_body_at_start: Vector3<f64>,
    kinetic_energy: f64,
}

impl FreeRotation {
    /// From the orientation and ω \[rad/s\] (body frame) at t = 0.
    pub fn new(
        inertia: &RotationalInertia,
        world_from_body: &UnitQuaternion<f64>,
        omega_in_body: &Vector3<f64>,
    ) -> Self {
        let principal = inertia.principal();
        let ascending = principal.body_from_principal.inverse() * omega_in_body;
        let [i1, i2, i3]: [f64; 3] = principal.moments.into();
        // L² − 2K I₂ = I₃(I₃−I₂)ω₃² − I₁(I₂−I₁)ω₁², without cancellation at spins about one axis.
        let surplus = i3 * (i3 - i2) * ascending.z.powi(2) - i1 * (i2 - i1) * ascending.x.powi(2);
        let circles_largest = surplus > 0.0 || (surplus == 0.0 && i3 > i2);
        let order = if circles_largest { [0, 1, 2] } else { [2, 1, 0] };
        let parity = if circles_largest { 1.0 } else { -1.0 };

        let axes = principal.body_from_principal.matrix();
        let w = Vector3::from(order.map(|k| ascending[k]));
        let i = Vector3::from(order.map(|k| principal.moments[k]));
        let (d21, d31, d32) = (i[1] - i[0], i[2] - i[0], i[2] - i[1]);
        // 2K I₃ − L² and L² − 2K I₁, divided by I₃ − I₁ so that both are sums of squares.
        let below = (i[0] * w[0] * w[0] * d31 + i[1] * w[1] * w[1] * d32) / d31;
        let above = (i[1] * w[1] * w[1] * d21 + i[2] * w[2] * w[2] * d31) / d31;
        let speed = (d32 * d31 * above / i.product()).sqrt();
        let mut motion = Self {
            body_from_axes: Matrix3::from_columns(&order.map(|k| axes.column(k).into_owned())),
            moments: i,
            amplitudes: Vector3::zeros(),
            rate: 0.0,
            phase: 0.0,
            parameter: Parameter { complement: 1.0 },
            omega_at_start: *omega_in_body,
            world_from_body_at_start: *world_from_body,
            momentum_in_body_at_start: inertia.momentum(omega_in_body),
            kinetic_energy: inertia.kinetic_energy(omega_in_body),
        };
        // λ = 0: a ball, or a symmetric top that spins across its axis. ω is constant.
        if speed > 0.0 && speed.is_finite() {
            let (first, second) = ((below / i[0]).sqrt(), (d31 * below / (i[1] * d32)).sqrt());
            let third = (above / i[2]).sqrt();
            motion.amplitudes = Vector3::new(first.copysign(w[0]), second, third.copysign(w[2]));
            // 1 − m = (I₃−I₁)(L²−2KI₂)/((I₃−I₂)(L²−2KI₁)): as accurate as L² − 2K I₂.
            motion.parameter.complement = (surplus / (d32 * above)).abs().min(1.0);
            // cn ≥ 0 at the start, since A₁ has the sign of ω₁.
            let angle = if below > 0.0 { (w[1] / second).atan2(w[0].abs() / first) } else { 0.0 };
            motion.phase = motion.parameter.incomplete(angle);
            // I₁ω̇₁ = ±(I₂−I₃)ω₂ω₃ with cn′ = −sn dn determines the sign of λ.
            motion.rate = speed * parity * (d32 * motion.amplitudes[2]).signum() * 1f64.copysign(w[0]);
        }
        motion
    }

    /// ω in the body frame at time t \[s\].
    pub fn omega_in_body(&self, t: f64) -> Vector3<f64> {
        if self.rate == 0.0 {
            return self.omega_at_start;
        }
        self.body_from_axes * self.omega_along_axes(t)
    }

    /// (ω₁, ω₂, ω₃) = (A₁ cn, A₂ sn, A₃ dn).
    fn omega_along_axes(&self, t: f64) -> Vector3<f64> {
        let (sn, cn, dn) = self.parameter.sn_cn_dn(self.rate * t + self.phase);
        self.amplitudes.component_mul(&Vector3::new(cn, sn, dn))
    }

    /// The period of ω in the body frame, 4K(m)/|λ| \[s\]: infinite on the separatrix and if ω is constant.
    pub fn period(&self) -> f64 {
        4.0 * self.parameter.complete() / self.rate.abs()
    }

    /// The orientation at time t \[s\].
    ///
    /// L̂ is fixed in the world. Axis 1 of the body circles L̂ at the rate L(2K − L₁ω₁)/(L² − L₁²). Gauss's
    /// rule on 64 panels a period integrates that rate. The axis never coincides with L̂, so the rate is
    /// never singular.
    pub fn world_from_body(&self, t: f64) -> UnitQuaternion<f64> {
        let size = self.momentum_in_body_at_start.norm();
        if size == 0.0 {
            return self.world_from_body_at_start;
        }
        if self.rate == 0.0 {
            return self.world_from_body_at_start * UnitQuaternion::from_scaled_axis(self.omega_at_start * t);
        }
        // A panel that is short relative to the tumbling and to one turn.
        let pace = (self.rate.abs() / 4.0).max(self.omega_at_start.norm() / 8.0);
        let panels = (t.abs() * pace * 16.0).ceil().max(1.0);
        let width = t / panels;
        let mut angle = 0.0;
        let mut panel = 0.0;
        while panel < panels {
            for (node, weight) in GAUSS {
                let w = self.omega_along_axes((panel + 0.5 + 0.5 * node) * width);
                let l = self.moments.component_mul(&w);
                // L² − L₁² = L₂² + L₃².
                let across = l[1] * l[1] + l[2] * l[2];
                angle += 0.5 * width * weight * size * (2.0 * self.kinetic_energy - l[0] * w[0]) / across;
            }
            panel += 1.0;
        }
        // The frame of L̂ and axis 1 in body coordinates, at the start and at t.
        let then = self.frame_of_momentum(0.0);
        let now = self.frame_of_momentum(t);
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
        let in_body = then * turn * now.inverse();
        self.world_from_body_at_start * UnitQuaternion::from_rotation_matrix(&in_body)
    }

    /// The rotation to the body from (x: axis 1 made perpendicular to L, z: L̂) at time t.
    fn frame_of_momentum(&self, t: f64) -> Rotation3<f64> {
        let along = self.body_from_axes * self.moments.component_mul(&self.omega_along_axes(t));
        let z = along.normalize();
        let axis: Vector3<f64> = self.body_from_axes.column(0).into_owned();
        let y = z.cross(&axis).normalize();
        Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[y.cross(&z), y, z]))
    }
}
