//! Euler's equation of a rigid body's rotation, in the world frame, the body frame and principal axes.
//!
//! L = 𝓘ω changes at the rate of the torque. In world axes 𝓘 turns with the body; in body axes 𝓘 is constant
//! and the axes turn. Both give the term ω × 𝓘ω, which causes tumbling.

use nalgebra::{UnitQuaternion, Vector3};
use robot_dynamics_description::RotationalInertia;

/// ω̇ in the world frame: 𝓘ω̇ + ω × 𝓘ω = τ with 𝓘 = R𝓘_bRᵀ. **(PRM 10.37–10.38)**
///
/// ω \[rad/s\] and τ \[N·m\] are about the centre of mass, in world axes, and so is the result \[rad/s²\].
///
/// ```
/// use dynamics::{euler_in_body, euler_in_world};
/// use nalgebra::{UnitQuaternion, Vector3};
/// use robot_dynamics_description::RotationalInertia;
/// // ω × ω = 0, so ω̇ is one vector: the body's components turned into the world's.
/// let inertia = RotationalInertia::from_moments(Vector3::new(1.0, 2.0, 2.5))?;
/// let r = UnitQuaternion::from_euler_angles(0.3, -0.8, 1.1);
/// let (omega, torque) = (Vector3::new(0.5, -1.0, 2.0), Vector3::new(0.1, 0.0, -0.3));
/// let in_world = euler_in_world(&inertia, &r, &(r * omega), &(r * torque));
/// assert!((in_world - r * euler_in_body(&inertia, &omega, &torque)).norm() < 1e-14);
/// # Ok::<(), robot_dynamics_description::InertiaError>(())
/// ```
pub fn euler_in_world(
    inertia: &RotationalInertia,
    world_from_body: &UnitQuaternion<f64>,
    omega_in_world: &Vector3<f64>,
    torque_in_world: &Vector3<f64>,
) -> Vector3<f64> {
    let momentum = inertia.in_world(world_from_body) * omega_in_world;
    let rate = torque_in_world - omega_in_world.cross(&momentum);
    // 𝓘⁻¹ = R𝓘_b⁻¹Rᵀ.
    world_from_body * inertia.angular_velocity(&(world_from_body.inverse() * rate))
}

/// ω̇ in the body frame: 𝓘ω̇ + ω × 𝓘ω = τ with 𝓘 constant. **(PRM 10.43–10.44)**
///
/// ω \[rad/s\] and τ \[N·m\] are about the centre of mass, in body axes, and so is the result \[rad/s²\].
///
/// ```
/// use dynamics::euler_in_body;
/// use nalgebra::Vector3;
/// use robot_dynamics_description::RotationalInertia;
/// // About x and y at once: I₃ω̇₃ = (I₁ − I₂)ω₁ω₂, though no torque acts.
/// let inertia = RotationalInertia::from_moments(Vector3::new(1.0, 2.0, 2.5))?;
/// let rate = euler_in_body(&inertia, &Vector3::new(3.0, 0.5, 0.0), &Vector3::zeros());
/// assert!((rate - Vector3::new(0.0, 0.0, -1.5 / 2.5)).norm() < 1e-15);
/// # Ok::<(), robot_dynamics_description::InertiaError>(())
/// ```
pub fn euler_in_body(
    inertia: &RotationalInertia,
    omega_in_body: &Vector3<f64>,
    torque_in_body: &Vector3<f64>,
) -> Vector3<f64> {
    let rate = torque_in_body - omega_in_body.cross(&inertia.momentum(omega_in_body));
    inertia.angular_velocity(&rate)
}

/// ω̇ in principal axes: I₁ω̇₁ = (I₂ − I₃)ω₂ω₃ + τ₁, and the cyclic permutations. **(PRM 10.45)**
///
/// `moments` \[kg·m²\] are those along the axes in which ω \[rad/s\] and τ \[N·m\] are given.
///
/// ```
/// use nalgebra::Vector3;
/// // A top symmetric about z keeps its spin about z.
/// let spin = Vector3::new(0.2, -0.1, 5.0);
/// let rate = dynamics::euler_in_principal_axes(&Vector3::new(1.0, 1.0, 1.5), &spin, &Vector3::zeros());
/// assert!(rate.z == 0.0 && rate.x != 0.0);
/// ```
///
/// # Panics
/// If a moment is not positive.
pub fn euler_in_principal_axes(
    moments: &Vector3<f64>,
    omega: &Vector3<f64>,
    torque: &Vector3<f64>,
) -> Vector3<f64> {
    assert!(
        moments.iter().all(|&moment| moment > 0.0),
        "principal moments must be positive, got {moments:?}"
    );
    Vector3::from_fn(|i, _| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        ((moments[j] - moments[k]) * omega[j] * omega[k] + torque[i]) / moments[i]
    })
}
