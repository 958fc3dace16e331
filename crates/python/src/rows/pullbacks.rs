//! Vector-Jacobian products: the gradient by a result becomes the gradients by its arguments, without a
//! Jacobian.

use super::table::rows;
use crate::pullback::Pullback;
use crate::row::Work::{Each, Pullback as Of};

rows! {
    /// λᵀ ∂τ/∂q, λᵀ ∂τ/∂v and λᵀ ∂τ/∂a of τ(q, v, a) for a cotangent λ of τ, as reverse differentiation needs
    /// them. The cost is O(n); no Jacobian is formed.
    ///
    /// Gradients by q are by displacements q ⊕ δq; `cotangent_to_coordinates` gives them by the numbers of q.
    inverse_dynamics_pullback(q, v, a, cotangent) => InverseDynamicsPullback[
        Vector by_position "λᵀ ∂τ/∂q",
        Vector by_velocity "λᵀ ∂τ/∂v",
        Vector by_acceleration "λᵀ M",
    ]
    /// >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> gradient = robot.inverse_dynamics_pullback(q, v, a, [1.0, 0.0])  # of the first joint's torque
    /// >>> bool(np.allclose(gradient.by_position, robot.inverse_dynamics_derivatives(q, v, a).by_position[0]))
    /// True
    = Of(Pullback::InverseDynamics);

    /// λᵀ ∂a/∂q, λᵀ ∂a/∂v and λᵀ ∂a/∂τ of a(q, v, τ) for a cotangent λ of a. The cost is O(n); neither M nor
    /// a Jacobian is formed.
    ///
    /// Gradients by q are those of `inverse_dynamics_pullback`.
    forward_dynamics_pullback(q, v, tau, cotangent) => ForwardDynamicsPullback[
        Vector by_position "λᵀ ∂a/∂q",
        Vector by_velocity "λᵀ ∂a/∂v",
        Vector by_force "λᵀ M⁻¹",
    ] raises SingularMassError
    /// >>> robot, q, v, tau = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> gradient = robot.forward_dynamics_pullback(q, v, tau, [1.0, 0.0])
    /// >>> bool(np.allclose(gradient.by_force, robot.inverse_mass_matrix(q)[0]))
    /// True
    = Of(Pullback::ForwardDynamics);

    /// `inverse_dynamics_pullback` with λᵀ ∂τ/∂p for the `parameters()` p, too. For the inertial ones it is
    /// λᵀY with the `joint_torque_regressor` Y, which is not formed.
    ///
    /// Damping and friction are not in τ, so their gradients are 0. Those of `dissipation` are λ v and λ sign
    /// v.
    inverse_dynamics_pullback_with_parameters(q, v, a, cotangent) => InverseDynamicsPullbackWithParameters[
        Vector by_position "λᵀ ∂τ/∂q",
        Vector by_velocity "λᵀ ∂τ/∂v",
        Vector by_acceleration "λᵀ M",
        AllParameters by_parameters "λᵀ ∂τ/∂p, named by `parameter_names`",
    ]
    /// >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> gradient = robot.inverse_dynamics_pullback_with_parameters(q, v, a, [1.0, 0.0])
    /// >>> bool(np.allclose(gradient.by_parameters[:20], robot.joint_torque_regressor(q, v, a)[0]))
    /// True
    = Of(Pullback::InverseDynamics);

    /// `forward_dynamics_pullback` with λᵀ ∂a/∂p for the `parameters()` p, too. For the inertial ones it is
    /// −(M⁻¹λ)ᵀY with the `joint_torque_regressor` Y, which is not formed.
    forward_dynamics_pullback_with_parameters(q, v, tau, cotangent) => ForwardDynamicsPullbackWithParameters[
        Vector by_position "λᵀ ∂a/∂q",
        Vector by_velocity "λᵀ ∂a/∂v",
        Vector by_force "λᵀ M⁻¹",
        AllParameters by_parameters "λᵀ ∂a/∂p, named by `parameter_names`",
    ] raises SingularMassError
    /// >>> robot, q, v, tau = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> gradient = robot.forward_dynamics_pullback_with_parameters(q, v, tau, [1.0, 0.0])
    /// >>> Y = robot.joint_torque_regressor(q, v, robot.forward_dynamics(q, v, tau))
    /// >>> bool(np.allclose(gradient.by_parameters[:20], -gradient.by_force @ Y))
    /// True
    = Of(Pullback::ForwardDynamics);

    /// λᵀ ∂b/∂v and λᵀ ∂b/∂p of `dissipation` b(v) for a cotangent λ of b, where p are the `parameters()`.
    /// For each joint they are λ v by its damping and λ sign v by its friction; the sign is held constant.
    dissipation_pullback(v, cotangent) => DissipationPullback[
        Vector by_velocity "λᵀ ∂b/∂v",
        AllParameters by_parameters "λᵀ ∂b/∂p, named by `parameter_names`",
    ]
    /// >>> robot = rd.example("two_r")
    /// >>> gradient = robot.dissipation_pullback([1.0, -2.0], [0.0, 5.0])
    /// >>> gradient.by_parameters[robot.parameter_names.index("elbow.damping")]
    /// np.float64(-10.0)
    = Each(|m, _, x, _, [by_v, by_parameters, ..]| {
        by_parameters.fill(0.0);
        robot_dynamics::derivatives::dissipation_pullback(m, x[0], x[1], by_v, by_parameters);
    });

    /// Converts a gradient by displacements q ⊕ δ to the gradient by the numbers of q. The function must
    /// depend only on the direction of each quaternion, as those of this package do. Then x̄ = R ū and q̄ = 2
    /// q ⊗ (w̄, 0)/|q|²; for other coordinates the numbers are the same.
    cotangent_to_coordinates(q, cotangent) => [Configuration "Gradient by the numbers of q."]
    /// >>> robot = rd.example("quadruped", floating_base=True)
    /// >>> cotangent = np.arange(robot.nv) + 1.0
    /// >>> robot.cotangent_to_coordinates(robot.neutral(), cotangent)[:6]
    /// array([ 1.,  2.,  3.,  8., 10., 12.])
    = Each(|m, _, x, _, [out, ..]| robot_dynamics::model::cotangent_to_coordinates(m, x[0], x[1], out));

    /// Converts a gradient by the numbers of q to the gradient by displacements q ⊕ δ. This is right for any
    /// function, whatever it does with quaternions that are not of length 1.
    cotangent_from_coordinates(q, coordinates) => [Vector "Gradient by displacements."]
    /// >>> robot = rd.example("two_r")
    /// >>> robot.cotangent_from_coordinates([0.3, 1.2], [5.0, 6.0])
    /// array([5., 6.])
    = Each(|m, _, x, _, [out, ..]| robot_dynamics::model::cotangent_from_coordinates(m, x[0], x[1], out));
}
