//! One step of a rotating body: Runge–Kutta on the quaternion, and a step that conserves L and K.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use robot_dynamics_description::RotationalInertia;
use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::{InvalidInput, check_finite};

use crate::euler_in_body;

/// Orientation and angular velocity of a body: (world from body, ω in the body frame \[rad/s\]).
pub type Attitude = (UnitQuaternion<f64>, Vector3<f64>);

/// One RK4 step of Ṙ = Rω̂, 𝓘ω̇ = τ − ω × 𝓘ω on the quaternion, renormalised. **(PRM 10.43–10.44)**
///
/// With q the quaternion of R, q̇ = ½ q ω. Order 4; L and K are conserved only to the accuracy of the step.
/// The torque \[N·m\], about the centre of mass in body axes, is held over the step of `h` \[s\].
///
/// # Errors
/// [`IntegratorError::Input`] if an input is not finite.
///
/// # Panics
/// If `h` is not positive and finite.
///
/// ```
/// use dynamics::euler_body_step;
/// use nalgebra::{UnitQuaternion, Vector3};
/// use robot_dynamics_description::MassProperties;
/// let brick = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1))?.rotational()?;
/// let (r, omega) = (UnitQuaternion::identity(), Vector3::new(0.01, 5.0, 0.0));
/// let (r1, omega1) = euler_body_step(&r, &omega, &Vector3::zeros(), &brick, 1e-3)?;
/// let change = brick.momentum_in_world(&r1, &omega1) - brick.momentum_in_world(&r, &omega);
/// assert!(change.norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn euler_body_step(
    world_from_body: &UnitQuaternion<f64>,
    omega_in_body: &Vector3<f64>,
    torque_in_body: &Vector3<f64>,
    inertia: &RotationalInertia,
    h: f64,
) -> Result<Attitude, IntegratorError> {
    check_inputs(world_from_body, omega_in_body, torque_in_body, h)?;
    let rate = |q: &Quaternion<f64>, omega: &Vector3<f64>| {
        (q * Quaternion::from_imag(*omega) * 0.5, euler_in_body(inertia, omega, torque_in_body))
    };
    let (q, omega) = (world_from_body.quaternion(), omega_in_body);
    let (q1, a1) = rate(q, omega);
    let (q2, a2) = rate(&(q + q1 * (h / 2.0)), &(omega + a1 * (h / 2.0)));
    let (q3, a3) = rate(&(q + q2 * (h / 2.0)), &(omega + a2 * (h / 2.0)));
    let (q4, a4) = rate(&(q + q3 * h), &(omega + a3 * h));
    let q_next = q + (q1 + (q2 + q3) * 2.0 + q4) * (h / 6.0);
    let omega_next = omega + (a1 + (a2 + a3) * 2.0 + a4) * (h / 6.0);
    Ok((UnitQuaternion::from_quaternion(q_next), omega_next))
}

/// One step that conserves the free body's world momentum L, |L| and K to round-off: order 2, reversible.
///
/// The implicit midpoint rule on the body momentum Π, with the Cayley map for the orientation:
///
/// ω_m = 𝓘⁻¹(Π₀+Π₁)/2,   Π₁ = cay(hω_m)ᵀΠ₀,   R₁ = R₀ cay(hω_m),   cay(a) = (1 − â/2)⁻¹(1 + â/2).
///
/// The first two give Π₁ − Π₀ = hΠ_m × ω_m, and midpoint rules conserve the quadratic |Π|² and ½Πᵀ𝓘⁻¹Π **(HLW
/// §IV.2)**; the last two give R₁Π₁ = R₀Π₀. Half of the impulse of a torque acts before the step and half
/// after it.
///
/// ```
/// use dynamics::cayley_body_step;
/// use nalgebra::{UnitQuaternion, Vector3};
/// use robot_dynamics_description::MassProperties;
/// let brick = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1))?.rotational()?;
/// let (start, spin, free) = (UnitQuaternion::identity(), Vector3::new(0.1, 5.0, 0.2), Vector3::zeros());
/// let (mut r, mut omega) = (start, spin);
/// for _ in 0..100 {
///     (r, omega) = cayley_body_step(&r, &omega, &free, &brick, 0.02)?; // 0.1 rad a step
/// }
/// let momentum = brick.momentum_in_world(&start, &spin);
/// assert!((brick.momentum_in_world(&r, &omega) - momentum).norm() < 1e-13 * momentum.norm());
/// assert!((brick.kinetic_energy(&omega) / brick.kinetic_energy(&spin) - 1.0).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IntegratorError::NotConverged`] if the body turns by radians in one step, too far for the solver;
/// [`IntegratorError::Input`] if an input is not finite.
///
/// # Panics
/// If `h` \[s\] is not positive and finite.
#[doc(alias = "Lie group")]
pub fn cayley_body_step(
    world_from_body: &UnitQuaternion<f64>,
    omega_in_body: &Vector3<f64>,
    torque_in_body: &Vector3<f64>,
    inertia: &RotationalInertia,
    h: f64,
) -> Result<Attitude, IntegratorError> {
    check_inputs(world_from_body, omega_in_body, torque_in_body, h)?;
    let kick = torque_in_body * (h / 2.0);
    let momentum = inertia.momentum(omega_in_body) + kick;
    let (momentum_middle, omega_middle) = middle(inertia, &momentum, h)?;
    // The quaternion (1, a/2), normalised, is the rotation cay(a).
    let turn = Quaternion::from_parts(1.0, omega_middle * (h / 2.0));
    let orientation = UnitQuaternion::from_quaternion(world_from_body.quaternion() * turn);
    // As an increment of ω₀: a round trip ω → Π → ω would round with the same sign in every step.
    let change = momentum_middle.cross(&omega_middle) * h + kick * 2.0;
    Ok((orientation, omega_in_body + inertia.angular_velocity(&change)))
}

/// The limit of Newton's method, which needs five or six iterations.
const MAX_ITERATIONS: usize = 20;

/// (Π_m, ω_m = 𝓘⁻¹Π_m) with Π_m − (h/2) Π_m × ω_m = Π₀, by Newton's method.
fn middle(
    inertia: &RotationalInertia,
    momentum: &Vector3<f64>,
    h: f64,
) -> Result<(Vector3<f64>, Vector3<f64>), IntegratorError> {
    let size = momentum.norm();
    let inverse = Matrix3::from_columns(&[0, 1, 2].map(|k| inertia.angular_velocity(&Vector3::ith(k, 1.0))));
    let mut middle = *momentum;
    let mut last_change = f64::INFINITY;
    // Newton's method converges quadratically: five or six iterations reach round-off, or the step is too
    // long.
    for _ in 0..MAX_ITERATIONS {
        let omega = inertia.angular_velocity(&middle);
        let defect = middle - middle.cross(&omega) * (h / 2.0) - momentum;
        let slope =
            Matrix3::identity() - (middle.cross_matrix() * inverse - omega.cross_matrix()) * (h / 2.0);
        let Some(step) = slope.lu().solve(&defect) else { break };
        middle -= step;
        let change = step.norm();
        // At round-off the changes stop shrinking.
        if change == 0.0 || (change >= last_change && change <= 100.0 * f64::EPSILON * size) {
            return Ok((middle, inertia.angular_velocity(&middle)));
        }
        last_change = change;
    }
    let residual = last_change / size;
    Err(IntegratorError::NotConverged { residual, iterations: MAX_ITERATIONS, step: h })
}

fn check_inputs(
    world_from_body: &UnitQuaternion<f64>,
    omega_in_body: &Vector3<f64>,
    torque_in_body: &Vector3<f64>,
    h: f64,
) -> Result<(), InvalidInput> {
    assert!(h > 0.0 && h.is_finite(), "the step must be positive and finite, got {h} s");
    check_finite("orientation", world_from_body.coords.as_slice())?;
    check_finite("omega", omega_in_body.as_slice())?;
    check_finite("torque", torque_in_body.as_slice())
}
