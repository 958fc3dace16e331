//! Second derivatives: contracted with a multiplier, times a direction, and as tensors.

use robot_dynamics::algorithms::ReferenceFrame;
use robot_dynamics::derivatives::{
    self, ForwardDirections, ForwardHessianProductMut, ForwardPullbackInputs, ForwardSecondDerivativesMut,
    FramePoseInputs, FrameVelocityInputs, InverseDirections, InverseHessianProductMut, InversePullbackInputs,
    InverseSecondDerivativesMut,
};

use super::table::{frame_rows, rows};
use crate::row::Work::Each;
use crate::row::{Work, of_frame};

rows! {
    /// Hessian H of λᵀτ(q, v, a) for multipliers λ (`cotangent`), symmetric, in the order q, v, a.
    ///
    /// H_αβ = ∂²/∂s∂t λᵀτ at (q, v, a) ⊕ (sα + tβ), with q ⊕ δ of `integrate`. It is symmetric also for
    /// joints with quaternions.
    inverse_dynamics_hessian(q, v, a, cotangent) => [Hessian "H in the order q, v, a."]
    /// >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> H = robot.inverse_dynamics_hessian(q, v, a, [1.0, 0.0])
    /// >>> second = robot.inverse_dynamics_second_derivatives(q, v, a)
    /// >>> bool(np.allclose(H[:2, 2:4], second.position_velocity[0]))
    /// True
    = Each(|m, s, x, _, [out, ..]| {
        let inputs = InversePullbackInputs { q: x[0], v: x[1], a: x[2], wrenches: &[], cotangent: x[3] };
        derivatives::inverse_dynamics_hessian(m, s.second_order(m), inputs, out);
    });

    /// Hessian H of λᵀa(q, v, τ) for multipliers λ (`cotangent`), symmetric, in the order q, v, τ.
    ///
    /// The definition is that of `inverse_dynamics_hessian`.
    forward_dynamics_hessian(q, v, tau, cotangent) => [Hessian "H in the order q, v, τ."]
        raises SingularMassError
    /// >>> robot, q, v, tau = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> H = robot.forward_dynamics_hessian(q, v, tau, [1.0, 0.0])
    /// >>> bool(np.array_equal(H, H.T))
    /// True
    = Each(|m, s, x, _, [out, ..]| {
        let inputs = ForwardPullbackInputs { q: x[0], v: x[1], tau: x[2], wrenches: &[], cotangent: x[3] };
        derivatives::forward_dynamics_hessian(m, s.second_order(m), inputs, out);
    });

    /// Derivative D of `inverse_dynamics_pullback`: row α has the change of its results along the direction
    /// α, in the order q, v, a. It differs from `inverse_dynamics_hessian` only for pairs of displacements of
    /// one joint with a quaternion, whose order matters.
    inverse_dynamics_pullback_derivative(q, v, a, cotangent) => [Hessian "D in the order q, v, a."]
    /// >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> D = robot.inverse_dynamics_pullback_derivative(q, v, a, [1.0, 0.0])
    /// >>> bool(np.allclose(D, robot.inverse_dynamics_hessian(q, v, a, [1.0, 0.0])))
    /// True
    = Each(|m, s, x, _, [out, ..]| {
        let inputs = InversePullbackInputs { q: x[0], v: x[1], a: x[2], wrenches: &[], cotangent: x[3] };
        derivatives::inverse_dynamics_pullback_derivative(m, s.second_order(m), inputs, out);
    });

    /// Derivative D of `forward_dynamics_pullback`: row α has the change of its results along the direction
    /// α, in the order q, v, τ. See `inverse_dynamics_pullback_derivative`.
    forward_dynamics_pullback_derivative(q, v, tau, cotangent) => [Hessian "D in the order q, v, τ."]
        raises SingularMassError
    /// >>> robot, q, v, tau = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> D = robot.forward_dynamics_pullback_derivative(q, v, tau, [1.0, 0.0])
    /// >>> bool(np.allclose(D, robot.forward_dynamics_hessian(q, v, tau, [1.0, 0.0])))
    /// True
    = Each(|m, s, x, _, [out, ..]| {
        let inputs = ForwardPullbackInputs { q: x[0], v: x[1], tau: x[2], wrenches: &[], cotangent: x[3] };
        derivatives::forward_dynamics_pullback_derivative(m, s.second_order(m), inputs, out);
    });

    /// Product H α of `inverse_dynamics_hessian` and a direction α = (δq, δv, δa), in O(n) without H.
    inverse_dynamics_hessian_product(q, v, a, cotangent, direction) => [Direction "H α in the order q, v, a."]
    /// >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> H, along = robot.inverse_dynamics_hessian(q, v, a, [1.0, 0.0]), np.arange(6.0)
    /// >>> bool(np.allclose(robot.inverse_dynamics_hessian_product(q, v, a, [1.0, 0.0], along), H @ along))
    /// True
    = Each(|m, s, x, _, [out, ..]| {
        let inputs = InversePullbackInputs { q: x[0], v: x[1], a: x[2], wrenches: &[], cotangent: x[3] };
        let ([position, velocity, acceleration], nv) = (thirds(x[4]), m.nv());
        let (by_position, rest) = out.split_at_mut(nv);
        let (by_velocity, by_acceleration) = rest.split_at_mut(nv);
        let directions = InverseDirections { position, velocity, acceleration };
        let results = InverseHessianProductMut { by_position, by_velocity, by_acceleration };
        derivatives::inverse_dynamics_hessian_product(m, s.second_order(m), inputs, directions, results);
    });

    /// Product H α of `forward_dynamics_hessian` and a direction α = (δq, δv, δτ), in O(n) without H.
    forward_dynamics_hessian_product(q, v, tau, cotangent, direction) => [Direction "H α in the order q, v, τ."]
        raises SingularMassError
    /// >>> robot, q, v, tau = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> H, along = robot.forward_dynamics_hessian(q, v, tau, [1.0, 0.0]), np.arange(6.0)
    /// >>> bool(np.allclose(robot.forward_dynamics_hessian_product(q, v, tau, [1.0, 0.0], along), H @ along))
    /// True
    = Each(|m, s, x, _, [out, ..]| {
        let inputs = ForwardPullbackInputs { q: x[0], v: x[1], tau: x[2], wrenches: &[], cotangent: x[3] };
        let ([position, velocity, force], nv) = (thirds(x[4]), m.nv());
        let (by_position, rest) = out.split_at_mut(nv);
        let (by_velocity, by_force) = rest.split_at_mut(nv);
        let directions = ForwardDirections { position, velocity, force };
        let results = ForwardHessianProductMut { by_position, by_velocity, by_force };
        derivatives::forward_dynamics_hessian_product(m, s.second_order(m), inputs, directions, results);
    });

    /// Second derivatives of τ(q, v, a) as tensors with the component of τ first. Those that are not listed
    /// are zero, and ∂²τ/∂q∂a is ∂M/∂q.
    inverse_dynamics_second_derivatives(q, v, a) => InverseDynamicsSecondDerivatives[
        Cube position_position "∂²τᵢ/∂qⱼ∂qₖ",
        Cube position_velocity "∂²τᵢ/∂qⱼ∂vₖ",
        Cube velocity_velocity "∂²τᵢ/∂vⱼ∂vₖ",
        Cube position_acceleration "∂²τᵢ/∂qⱼ∂aₖ",
    ]
    /// >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> second = robot.inverse_dynamics_second_derivatives(q, v, a)
    /// >>> twice = np.einsum("ijk,j,k", second.velocity_velocity, v, v)  # C v is quadratic in v
    /// >>> bool(np.allclose(twice, 2 * robot.velocity_product(q, v)))
    /// True
    = Each(|m, s, x, _, [qq, qv, vv, qx]| {
        let results = InverseSecondDerivativesMut {
            position_position: qq,
            position_velocity: qv,
            velocity_velocity: vv,
            position_acceleration: qx,
        };
        derivatives::inverse_dynamics_second_derivatives(m, s.second_order(m), x[0], x[1], x[2], &[], results);
    });

    /// Second derivatives of a(q, v, τ) as tensors with the component of a first. Those that are not listed
    /// are zero, and ∂²a/∂q∂τ is ∂(M⁻¹)/∂q.
    forward_dynamics_second_derivatives(q, v, tau) => ForwardDynamicsSecondDerivatives[
        Cube position_position "∂²aᵢ/∂qⱼ∂qₖ",
        Cube position_velocity "∂²aᵢ/∂qⱼ∂vₖ",
        Cube velocity_velocity "∂²aᵢ/∂vⱼ∂vₖ",
        Cube position_force "∂²aᵢ/∂qⱼ∂τₖ",
    ] raises SingularMassError
    /// >>> robot, q, v, tau = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> second = robot.forward_dynamics_second_derivatives(q, v, tau)
    /// >>> H = robot.forward_dynamics_hessian(q, v, tau, [0.0, 1.0])
    /// >>> bool(np.allclose(H[:2, :2], second.position_position[1]))
    /// True
    = Each(|m, s, x, _, [qq, qv, vv, qx]| {
        let results = ForwardSecondDerivativesMut {
            position_position: qq,
            position_velocity: qv,
            velocity_velocity: vv,
            position_force: qx,
        };
        derivatives::forward_dynamics_second_derivatives(m, s.second_order(m), x[0], x[1], x[2], &[], results);
    });
}

/// The parts of a direction.
fn thirds(direction: &[f64]) -> [&[f64]; 3] {
    let nv = direction.len() / 3;
    [&direction[..nv], &direction[nv..2 * nv], &direction[2 * nv..]]
}

frame_rows! {
    /// Derivative ∂J/∂q of `frame_jacobian`: at (r, j, k) that of J_rj by q_k, along `integrate(q, δ e_k)`.
    frame_jacobian_derivative(q) => [SixSquares "∂J/∂q."]
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], np.array([1.0, -2.0])
    /// >>> rate = robot.frame_jacobian_derivative(q, "tip") @ v
    /// >>> bool(np.allclose(rate @ v, robot.frame_acceleration(q, v, [0.0, 0.0], "tip")))
    /// True
    = of_frame(|m, s, x, frame, seen, [out, ..]| {
        derivatives::frame_jacobian_derivative(m, &mut s.workspace, x[0], frame, seen, out);
    });

    /// Second derivative Σ λᵣ ∂²ξᵣ/∂q² of a frame's pose for multipliers λ (`weights`), symmetric.
    ///
    /// ξ is the displacement of the frame that q ⊕ x causes; its first derivative is the Jacobian. For
    /// ``local_world_aligned`` its linear part is the displacement of the origin.
    frame_pose_hessian(q, weights) => [Square "Σ λᵣ ∂²ξᵣ/∂q²."]
    /// >>> robot, q = rd.example("two_r"), [0.3, 1.2]
    /// >>> H = robot.frame_pose_hessian(q, [1.0, 0, 0, 0, 0, 0], "tip")
    /// >>> bool(np.allclose(H, robot.frame_jacobian_derivative(q, "tip")[0]))
    /// True
    = of_frame(|m, s, x, frame, reference_frame, [out, ..]| {
        let inputs = FramePoseInputs { q: x[0], frame, reference_frame, cotangent: six(x[1]) };
        derivatives::frame_pose_hessian(m, &mut s.workspace, inputs, out);
    });

    /// Hessian of λᵀV for the velocity V(q, v) of `frame_velocity` and multipliers λ (`weights`), symmetric,
    /// in the order q, v.
    frame_velocity_hessian(q, v, weights) => [StateHessian "H in the order q, v."]
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
    /// >>> H = robot.frame_velocity_hessian(q, v, [1.0, 0, 0, 0, 0, 0], "tip")
    /// >>> bool(np.allclose(H[2:, :2], robot.frame_jacobian_derivative(q, "tip")[0]))
    /// True
    = of_frame(|m, s, x, frame, reference_frame, [out, ..]| {
        let (q, v, cotangent) = (x[0], x[1], six(x[2]));
        let inputs = FrameVelocityInputs { q, v, frame, reference_frame, cotangent };
        derivatives::frame_velocity_hessian(m, s.second_order(m), inputs, out);
    });
}

/// Six numbers as an array.
fn six(numbers: &[f64]) -> [f64; 6] {
    core::array::from_fn(|k| numbers[k])
}
