//! The equation of motion: its terms, its solutions, their derivatives; energies, momenta, regressors.

use robot_dynamics::quantity::Quantity;

use super::table::rows;
use crate::row::Work::{Each, Quantity as Of};

rows! {
    /// M(q), the mass matrix: K = ½ vᵀM v.
    mass_matrix(q) => [Square "Symmetric [kg·m², kg·m, kg]."]
    /// >>> robot = rd.example("two_r")
    /// >>> M = robot.mass_matrix([0.3, 1.2])
    /// >>> bool(np.all(np.linalg.eigvalsh(M) > 0)), bool(np.allclose(M, M.T))
    /// (True, True)
    = Of(Quantity::MassMatrix);

    /// C(q, v) v + g(q): everything of the equation of motion but inertia and dissipation.
    bias(q, v) => [Vector "C v + g [N·m or N]."]
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
    /// >>> bool(np.allclose(robot.bias(q, v), robot.coriolis_matrix(q, v) @ v + robot.gravity(q)))
    /// True
    = Of(Quantity::Bias);

    /// g(q) = ∂V/∂q: the forces that hold it still, springs of the joints included. `gravity_vector` is the
    /// field's acceleration.
    gravity(q) => [Vector "g(q) [N·m or N]."]
    /// >>> robot = rd.example("two_r")  # two rods of 1 m, 2 kg and 1 kg
    /// >>> robot.gravity([np.pi / 4, np.pi / 2]).round(4)
    /// array([10.4051, -3.4684])
    = Of(Quantity::Gravity);

    /// C(q, v) of the Christoffel symbols: Ṁ − 2C is skew-symmetric.
    ///
    /// C v are the centrifugal and Coriolis forces.
    coriolis_matrix(q, v) => [Square "C(q, v)."]
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
    /// >>> S = robot.mass_matrix_rate(q, v) - 2 * robot.coriolis_matrix(q, v)
    /// >>> bool(np.allclose(S, -S.T))
    /// True
    = Of(Quantity::CoriolisMatrix);

    /// C(q, v) v: centrifugal and Coriolis forces.
    velocity_product(q, v) => [Vector "C(q, v) v [N·m or N]."]
    /// >>> robot = rd.example("two_r")
    /// >>> robot.velocity_product([0.3, 1.2], [0.0, 0.0])
    /// array([0., 0.])
    = Of(Quantity::VelocityProduct);

    /// τ = M(q) a + C(q, v) v + g(q): the generalized forces of a motion (recursive Newton–Euler).
    ///
    /// Damping and friction are not in it: see `dissipation`.
    inverse_dynamics(q, v, a) => [Vector "Generalized forces τ [N·m or N]."]
    /// >>> robot, q, v = rd.example("panda"), np.zeros((1000, 7)), np.zeros(7)
    /// >>> robot.inverse_dynamics(q, v, v).shape
    /// (1000, 7)
    = Of(Quantity::InverseDynamics);

    /// a = M⁻¹(τ − C v − g): the acceleration under generalized forces (articulated bodies).
    forward_dynamics(q, v, tau) => [Vector "Acceleration a [rad/s² or m/s²]."] raises SingularMassError
    /// >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> robot.forward_dynamics(q, v, robot.inverse_dynamics(q, v, a)).round(9)
    /// array([3., 4.])
    = Of(Quantity::ForwardDynamics);

    /// M(q)⁻¹, the inverse of the mass matrix.
    inverse_mass_matrix(q) => [Square "Symmetric."] raises SingularMassError
    /// >>> robot, q = rd.example("two_r"), [0.3, 1.2]
    /// >>> bool(np.allclose(robot.inverse_mass_matrix(q) @ robot.mass_matrix(q), np.eye(2)))
    /// True
    = Of(Quantity::InverseMassMatrix);

    /// The factor of M(q) = LᵀDL: L below the diagonal (its own diagonal is 1), D on the diagonal, zeros
    /// above it.
    ///
    /// L is zero where M is zero because neither of two degrees of freedom moves the other. The cost of
    /// solving therefore grows with nv times the depth of the tree. The product of the diagonal is det M.
    mass_matrix_factor(q) => [Square "L below the diagonal, D on it."] raises SingularMassError
    /// >>> factor = rd.example("two_r").mass_matrix_factor([0.3, 1.2])
    /// >>> l, d = np.tril(factor, -1) + np.eye(2), np.diag(factor.diagonal())
    /// >>> bool(np.allclose(l.T @ d @ l, rd.example("two_r").mass_matrix([0.3, 1.2])))
    /// True
    = Of(Quantity::MassMatrixFactor);

    /// ∂τ/∂q and ∂τ/∂v of τ(q, v, a); ∂τ/∂a is M.
    ///
    /// Derivatives by q are by displacements q ⊕ δq: the same as by q for joints of one coordinate, in nv
    /// numbers for quaternions.
    inverse_dynamics_derivatives(q, v, a) => InverseDynamicsDerivatives[
        Square by_position "∂τ/∂q",
        Square by_velocity "∂τ/∂v",
    ]
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [0.0, 0.0]
    /// >>> derivatives = robot.inverse_dynamics_derivatives(q, v, v)
    /// >>> bool(np.allclose(derivatives.by_position, robot.gravity_derivative(q)))  # at rest
    /// True
    = Of(Quantity::InverseDynamicsDerivatives);

    /// ∂a/∂q, ∂a/∂v and ∂a/∂τ = M⁻¹ of a(q, v, τ).
    ///
    /// Derivatives by q are those of `inverse_dynamics_derivatives`.
    forward_dynamics_derivatives(q, v, tau) => ForwardDynamicsDerivatives[
        Square by_position "∂a/∂q",
        Square by_velocity "∂a/∂v",
        Square by_force "∂a/∂τ",
    ] raises SingularMassError
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [0.0, 0.0]
    /// >>> derivatives = robot.forward_dynamics_derivatives(q, v, v)
    /// >>> bool(np.allclose(derivatives.by_force, robot.inverse_mass_matrix(q)))
    /// True
    = Of(Quantity::ForwardDynamicsDerivatives);

    /// ∂g/∂q, the Hessian of V.
    ///
    /// Derivatives by q are those of `inverse_dynamics_derivatives`.
    gravity_derivative(q) => [Square "Symmetric for joints of one coordinate."]
    /// >>> rd.example("two_r").gravity_derivative([np.pi / 2, 0.0]).round(3)  # upright
    /// array([[-24.525,  -4.905],
    ///        [ -4.905,  -4.905]])
    = Of(Quantity::GravityDerivative);

    /// K = ½ vᵀM(q) v, the kinetic energy.
    kinetic_energy(q, v) => [Scalar "K [J]."]
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], np.array([1.0, -2.0])
    /// >>> bool(np.isclose(robot.kinetic_energy(q, v), 0.5 * v @ robot.mass_matrix(q) @ v))
    /// True
    = Of(Quantity::KineticEnergy);

    /// V(q), the potential energy of gravity and of the joints' springs; 0 where all masses are at the
    /// world's origin.
    potential_energy(q) => [Scalar "V [J]."]
    /// >>> float(rd.example("two_r").potential_energy([np.pi / 2, 0.0]).round(4))  # upright: 9.81 (2 · 0.5 + 1 · 1.5)
    /// 24.525
    = Of(Quantity::PotentialEnergy);

    /// p = M(q) v, the generalized momentum.
    momentum(q, v) => [Vector "p [kg·m²/s or kg·m/s]."]
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
    /// >>> bool(np.allclose(robot.momentum(q, v), robot.mass_matrix(q) @ v))
    /// True
    = Of(Quantity::Momentum);

    /// ∂K/∂q at constant v.
    ///
    /// Derivatives by q are those of `inverse_dynamics_derivatives`.
    kinetic_energy_gradient(q, v) => [Vector "∂K/∂q [N·m or N]."]
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
    /// >>> float(robot.kinetic_energy_gradient(q, v)[0].round(12))  # nothing depends on where the first rod points
    /// 0.0
    = Each(|m, s, x, _, [out, ..]| robot_dynamics::algorithms::kinetic_energy_gradient(m, &mut s.workspace, x[0], x[1], out));

    /// b(v) = damping · v + friction · sign v of the joints, which resists the motion: M a + C v + g + b = τ.
    dissipation(v) => [Vector "b(v) [N·m or N]."]
    /// >>> rd.example("two_r").dissipation([1.0, -2.0]).shape
    /// (2,)
    = Each(|m, _, x, _, [out, ..]| robot_dynamics::algorithms::dissipation(m, x[0], out));

    /// Ṁ: the rate of M(q) along a motion.
    mass_matrix_rate(q, v) => [Square "Ṁ [kg·m²/s, kg·m/s, kg/s]."]
    /// >>> robot, q, v = rd.example("two_r"), np.array([0.3, 1.2]), np.array([1.0, -2.0])
    /// >>> ahead, behind = robot.mass_matrix(q + 1e-6 * v), robot.mass_matrix(q - 1e-6 * v)
    /// >>> bool(np.allclose(robot.mass_matrix_rate(q, v), (ahead - behind) / 2e-6, atol=1e-8))
    /// True
    = Each(|m, s, x, _, [out, ..]| robot_dynamics::algorithms::mass_matrix_rate(m, s.dual(m), x[0], x[1], out));

    /// Γⁱⱼₖ = ½(∂M_ij/∂qₖ + ∂M_ik/∂qⱼ − ∂M_jk/∂qᵢ), the Christoffel symbols of the first kind.
    ///
    /// C_ij = Σₖ Γⁱⱼₖ vₖ.
    christoffel_symbols(q) => [Cube "Γ with the indices i, j, k."]
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
    /// >>> bool(np.allclose(robot.christoffel_symbols(q) @ v, robot.coriolis_matrix(q, v)))
    /// True
    = Each(|m, s, x, _, [out, ..]| robot_dynamics::algorithms::christoffel_symbols(m, &mut s.workspace, x[0], out));

    /// Y of τ = Y(q, v, a) π, π being the `inertial_parameters`, ten for each link that moves.
    joint_torque_regressor(q, v, a) => [Regressor "Y, ten columns for each moving link."]
    /// >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    /// >>> Y = robot.joint_torque_regressor(q, v, a)
    /// >>> bool(np.allclose(Y @ robot.inertial_parameters, robot.inverse_dynamics(q, v, a)))
    /// True
    = Each(|m, s, x, _, [out, ..]| {
        robot_dynamics::algorithms::joint_torque_regressor(m, &mut s.workspace, x[0], x[1], x[2], out);
    });

    /// The row y of K = y(q, v) π.
    kinetic_energy_regressor(q, v) => [Parameters "y, ten numbers for each moving link."]
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
    /// >>> y = robot.kinetic_energy_regressor(q, v)
    /// >>> bool(np.isclose(y @ robot.inertial_parameters, robot.kinetic_energy(q, v)))
    /// True
    = Each(|m, s, x, _, [out, ..]| robot_dynamics::algorithms::kinetic_energy_regressor(m, &mut s.workspace, x[0], x[1], out));

    /// The row y of V = y(q) π, gravity's part of the potential energy.
    potential_energy_regressor(q) => [Parameters "y, ten numbers for each moving link."]
    /// >>> robot, q = rd.example("two_r"), [0.3, 1.2]
    /// >>> y = robot.potential_energy_regressor(q)
    /// >>> bool(np.isclose(y @ robot.inertial_parameters, robot.potential_energy(q)))
    /// True
    = Each(|m, s, x, _, [out, ..]| robot_dynamics::algorithms::potential_energy_regressor(m, &mut s.workspace, x[0], out));

    /// The matrix A_G of h = A_G(q) v, the momentum about the centre of mass along the world's axes.
    centroidal_momentum_matrix(q) => [Rows(6) "A_G, linear rows, then angular rows."]
    /// >>> robot, q, v = rd.example("panda"), np.zeros(7), np.ones(7)
    /// >>> bool(np.allclose(robot.centroidal_momentum_matrix(q) @ v, robot.centroidal_momentum(q, v)))
    /// True
    = Of(Quantity::CentroidalMomentumMatrix);

    /// h = A_G v: linear momentum, and angular momentum about the centre of mass, along the world's axes.
    centroidal_momentum(q, v) => [Six "Linear [kg·m/s], then angular [kg·m²/s], along the world's axes."]
    /// >>> robot = rd.example("quadruped", floating_base=True)
    /// >>> v = np.zeros(robot.nv); v[0] = 2.0  # forward along x
    /// >>> bool(np.isclose(robot.centroidal_momentum(robot.neutral(), v)[0], 2.0 * robot.mass))
    /// True
    = Each(|m, s, x, _, [out, ..]| {
        let h = robot_dynamics::algorithms::centroidal_momentum(m, &mut s.workspace, x[0], x[1]);
        crate::rows::table::six(out, h.linear, h.angular);
    });

    /// ḣ, the rate of the centroidal momentum: gravity and all forces from outside.
    centroidal_momentum_rate(q, v, a) => [Six "Linear [N], then angular [N·m], along the world's axes."]
    /// >>> robot, q, v = rd.example("panda"), np.zeros(7), np.ones(7)
    /// >>> rate = robot.centroidal_momentum_rate(q, v, np.zeros(7))
    /// >>> bool(np.allclose(rate, robot.centroidal_momentum_bias_rate(q, v)))
    /// True
    = Each(|m, s, x, _, [out, ..]| {
        let h = robot_dynamics::algorithms::centroidal_momentum_rate(m, &mut s.workspace, x[0], x[1], x[2]);
        crate::rows::table::six(out, h.linear, h.angular);
    });

    /// Ȧ_G v: the rate of the centroidal momentum without accelerations.
    centroidal_momentum_bias_rate(q, v) => [Six "Linear [N], then angular [N·m], along the world's axes."]
    /// >>> robot = rd.example("panda")
    /// >>> robot.centroidal_momentum_bias_rate(np.zeros(7), np.zeros(7)) @ np.ones(6)
    /// np.float64(0.0)
    = Each(|m, s, x, _, [out, ..]| {
        let h = robot_dynamics::algorithms::centroidal_momentum_bias_rate(m, &mut s.workspace, x[0], x[1]);
        crate::rows::table::six(out, h.linear, h.angular);
    });
}
