"""Optimal control, against the Riccati recursion, numerical derivatives and the motions of the robots."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import robot_dynamics as rd
from robot_dynamics import optimal as oc

Array = NDArray[np.float64]

ROBOTS = Path(__file__).parents[2] / "robots"

A = np.array([[1.0, 0.1], [0.0, 1.0]])
B = np.array([[0.005], [0.1]])


def mass(nodes: int = 30) -> oc.Problem:
    """A mass of 1 kg that shall come to rest at the origin."""
    problem = oc.Problem(oc.LinearDynamics(A, B), [1.0, 0.0], nodes=nodes)
    problem.set_running_cost(
        oc.LeastSquares(oc.StateResidual([0.0, 0.0]), [1.0, 0.1]), oc.LeastSquares(oc.ControlResidual(), 0.01)
    )
    problem.set_terminal_cost(oc.LeastSquares(oc.StateResidual([0.0, 0.0]), [10.0, 10.0]))
    return problem


def test_linear_problem_is_solved_by_the_riccati_recursion() -> None:
    q, r, p = np.diag([1.0, 0.1]), np.array([[0.01]]), np.diag([10.0, 10.0])
    gains: list[Array] = []
    for _ in range(30):
        gain = -np.linalg.solve(r + B.T @ p @ B, B.T @ p @ A)
        p = q + A.T @ p @ (A + B @ gain)
        gains.insert(0, gain)
    solution = mass().solve()
    x, cost = np.array([1.0, 0.0]), 0.0
    for k, gain in enumerate(gains):
        u = gain @ x
        # The solver regularises by 1e-9, relative to Quu of about 0.02.
        assert np.allclose(solution.controls[k], u, atol=1e-6)
        assert np.allclose(solution.gains[k], gain, atol=1e-6)
        cost += 0.5 * float(x @ q @ x + u @ r @ u)
        x = A @ x + B @ u
    assert solution.is_solved
    assert np.isclose(solution.cost, cost + 5.0 * float(x @ x), rtol=1e-9)
    assert solution.states.shape == (31, 2) and solution.q.shape == (31, 0)


def test_controls_keep_their_bounds() -> None:
    problem = mass()
    problem.set_control_bounds(-0.5, 0.5)
    solution = problem.solve()
    controls, gains = np.asarray(solution.controls), np.asarray(solution.gains)
    assert solution.is_solved
    assert np.abs(controls).max() == 0.5
    assert np.all(gains[np.abs(controls[:, 0]) == 0.5] == 0.0)


def test_terminal_constraint_is_satisfied() -> None:
    problem = oc.Problem(oc.LinearDynamics(A, B), [0.0, 0.0], nodes=20)
    problem.set_running_cost(oc.LeastSquares(oc.ControlResidual()))
    problem.add_terminal_constraint(oc.StateResidual([1.0, 0.0]), 0.0, 0.0)
    solution = problem.solve()
    assert solution.is_solved and solution.violation < 1e-6
    u = np.asarray(solution.controls)[:, 0]
    # The least effort is linear in time and antisymmetric.
    assert np.allclose(u, -u[::-1], atol=1e-4)
    assert np.allclose(np.diff(u, 2), 0.0, atol=1e-4)


def reach() -> tuple[rd.Robot, oc.Problem, Array]:
    """A reach of a Panda's hand."""
    robot = rd.example("panda")
    q = np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6])
    goal = robot.frame_pose(q, "panda_link8")[:3, 3] + [0.1, 0.1, -0.1]
    problem = oc.Problem(oc.SmoothStep(robot, dt=0.01), (q, np.zeros(7)), nodes=50)
    problem.set_running_cost(
        oc.LeastSquares(oc.ControlResidual(robot.gravity(q)), 1e-4),
        oc.LeastSquares(oc.StateResidual((q, np.zeros(7))), [0.0] * 7 + [1e-2] * 7),
    )
    problem.set_terminal_cost(
        oc.LeastSquares(oc.FrameTranslationResidual("panda_link8", goal), 1e4),
        oc.LeastSquares(oc.FrameVelocityResidual("panda_link8"), 1.0),
    )
    return robot, problem, goal


def test_hand_reaches_its_target_within_the_effort_limits() -> None:
    robot, problem, goal = reach()
    problem.set_effort_limits()
    seen: list[oc.Iteration] = []
    solution = problem.solve(callback=seen.append)
    assert solution.is_solved
    assert np.linalg.norm(robot.frame_pose(solution.q[-1], "panda_link8")[:3, 3] - goal) < 5e-3
    assert [one.iteration for one in seen] == list(range(len(seen)))
    assert seen == solution.log
    # The trajectory is a motion of the robot.
    q, v = solution.q[0], solution.v[0]
    for k in range(50):
        q, v = robot.step(q, v, solution.controls[k], dt=0.01, integrator="semi-implicit-euler", stops=False)
        assert np.allclose(np.concatenate([q, v]), solution.states[k + 1], atol=1e-8)


def test_solution_is_a_start() -> None:
    _, problem, _ = reach()
    first = problem.solve()
    again = problem.solve(first)
    assert len(again.log) <= 2 < len(first.log)
    assert np.isclose(again.cost, first.cost, rtol=1e-9)
    rolled = problem.solve(controls=first.controls)
    assert np.isclose(rolled.cost, first.cost, rtol=1e-9)


def test_callback_ends_the_solver() -> None:
    _, problem, _ = reach()
    solution = problem.solve(callback=lambda one: one.iteration == 1)
    assert solution.termination == "interrupted" and len(solution.log) == 2 and not solution.is_solved


@pytest.mark.parametrize("has_derivatives", [False, True])
def test_function_of_python_is_a_residual(has_derivatives: bool) -> None:
    """At the solution, the cost by the robot's own steps is stationary."""
    robot = rd.example("quadruped", floating_base=True)
    q = robot.neutral()
    target = robot.integrate(q, np.linspace(-0.05, 0.05, robot.nv))

    def position(q: Array, v: Array, u: Array) -> Array:
        # The height of the base, the numbers x y z of its quaternion, and the legs.
        return np.concatenate([q[2:6] - target[2:6], q[7:] - target[7:]])

    def derivatives(q: Array, v: Array, u: Array) -> tuple[Array, Array]:
        rows = np.delete(np.eye(robot.nq), [0, 1, 6], axis=0)
        return np.hstack([rows, np.zeros((len(rows), robot.nv))]), np.zeros((len(rows), len(u)))

    given = derivatives if has_derivatives else None
    residual = oc.FunctionResidual(position, robot.nq - 3, derivatives=given)
    step = oc.SmoothStep(robot, dt=0.02, dissipation=False)
    problem = oc.Problem(step, (q, np.zeros(robot.nv)), nodes=5)
    problem.set_running_cost(oc.LeastSquares(oc.ControlResidual(), 1e-4))
    problem.set_terminal_cost(oc.LeastSquares(residual, 100.0))
    solution = problem.solve()
    assert solution.is_solved
    u = np.array(solution.controls)

    def cost(u: Array) -> float:
        q, v = solution.q[0], solution.v[0]
        for one in u:
            q, v = robot.step(q, v, one, dt=0.02, integrator="semi-implicit-euler", conservative=True)
        return 5e-5 * float(np.sum(u**2)) + 50.0 * float(np.sum(position(q, v, u[-1]) ** 2))

    assert np.isclose(cost(u), solution.cost, rtol=1e-8)
    for node, k in [(0, 3), (2, 10), (4, 17)]:
        moved = np.zeros_like(u)
        moved[node, k] = 1e-3
        # The tolerance of the gradient is 1e-6. The difference adds its third derivative and rounding.
        assert abs(cost(u + moved) - cost(u - moved)) / 2e-3 < 1e-5


def test_function_of_jax_is_a_residual() -> None:
    jax = pytest.importorskip("jax")
    before = jax.config.jax_enable_x64
    try:
        jax.config.update("jax_enable_x64", False)
        with pytest.raises(ValueError, match="64-bit"):
            oc.FunctionResidual.of_jax(lambda x, u: x, 2)
        jax.config.update("jax_enable_x64", True)
        problem, same = mass(), mass()
        problem.set_terminal_cost(oc.LeastSquares(oc.FunctionResidual.of_jax(lambda x, u: jax.numpy.sin(x), 2), 10.0))
        same.set_terminal_cost(oc.LeastSquares(oc.FunctionResidual(lambda x, u: np.sin(x), 2), 10.0))
        first, second = problem.solve(), same.solve()
        assert np.allclose(first.controls, second.controls, atol=1e-6)
    finally:
        jax.config.update("jax_enable_x64", before)


def test_errors_of_functions_are_raised_as_they_are() -> None:
    def missing(x: Array, u: Array) -> Array:
        raise KeyError("missing")

    problem = mass()
    problem.set_terminal_cost(oc.LeastSquares(oc.FunctionResidual(missing, 1)))
    with pytest.raises(KeyError):
        problem.solve()

    def ended(one: oc.Iteration) -> bool:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        mass().solve(callback=ended)


def test_block_is_pushed_by_contact() -> None:
    """The derivatives through friction find the push that leaves a sliding block at its goal."""
    robot = rd.loads(
        '<mujoco><worldbody><geom type="plane" size="5 5 1" friction="0.3"/><body pos="0 0 0.1"><freejoint/>'
        '<geom type="box" size="0.1 0.1 0.1" mass="1" friction="0.3"/></body></worldbody></mujoco>'
    )
    simulation = rd.Simulation(robot, dt=0.01, integrator="implicit", ground="file")
    push = np.eye(6)[:, :1]
    problem = oc.Problem(oc.SimulationStep(simulation, actuation=push), (simulation.q, np.zeros(6)), nodes=40)
    goal = simulation.q + np.array([0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    weights = [1e3] + [0.0] * 5 + [10.0] + [0.0] * 5
    problem.set_running_cost(oc.LeastSquares(oc.ControlResidual(), 1e-4))
    problem.set_terminal_cost(oc.LeastSquares(oc.StateResidual((goal, np.zeros(6))), weights))
    # A start that moves the block, because a block at rest has no slope.
    solution = problem.solve(controls=np.full((40, 1), 6.0))
    assert abs(solution.q[-1, 0] - goal[0]) < 0.01
    # The simulation takes the same way.
    simulation.reset()
    for u in solution.controls:
        simulation.torques = push @ u
        simulation.step()
    assert abs(simulation.q[0] - goal[0]) < 0.011


def test_controller_brings_the_mass_to_rest_and_follows_a_new_target() -> None:
    problem = mass()
    problem.set_control_bounds(-0.5, 0.5)
    mpc, x = oc.Mpc(problem, time_budget=60.0), np.array([1.0, 0.0])
    with pytest.raises(rd.ControlError, match="first step"):
        _ = mpc.plan
    for _ in range(100):
        u = mpc.step(x)
        assert abs(u[0]) <= 0.5
        x = A @ x + B @ u
    assert np.linalg.norm(x) < 1e-2
    target = oc.LeastSquares(oc.StateResidual([0.5, 0.0]), [1.0, 0.1])
    mpc.set_running_cost(target, oc.LeastSquares(oc.ControlResidual(), 0.01))
    mpc.set_terminal_cost(oc.LeastSquares(oc.StateResidual([0.5, 0.0]), 10.0))
    for _ in range(100):
        x = A @ x + B @ mpc.step(x)
    assert np.abs(x - [0.5, 0.0]).max() < 1e-2
    assert mpc.times.periods == 199 and mpc.times.over_budget == 0
    assert 0.0 < mpc.times.median <= mpc.times.percentile_99_9 <= mpc.times.longest
    assert mpc.plan.states.shape == (31, 2)


def test_wrong_parts_are_refused() -> None:
    robot = rd.example("panda")
    step = oc.SmoothStep(robot)
    with pytest.raises(TypeError, match="ImpactStep or LinearDynamics"):
        oc.Problem(robot, np.zeros(14), nodes=5)  # type: ignore[arg-type]
    with pytest.raises(rd.ShapeError, match=r"\(14,\), or be a pair \(q, v\)"):
        oc.Problem(step, np.zeros(7), nodes=5)
    with pytest.raises(rd.ControlError, match="needs a node"):
        oc.Problem(step, np.zeros(14), nodes=0)
    with pytest.raises(rd.SimulationInputError, match="SimulationStep"):
        oc.Problem(oc.SmoothStep(robot, integrator="implicit"), np.zeros(14), nodes=5)
    with pytest.raises(ValueError, match="motors"):
        oc.Problem(oc.SmoothStep(robot, actuation="all"), np.zeros(14), nodes=5)
    problem = oc.Problem(step, np.zeros(14), nodes=5)
    with pytest.raises(rd.FrameError):
        problem.set_terminal_cost(oc.LeastSquares(oc.FrameTranslationResidual("wrist", np.zeros(3))))
    with pytest.raises(rd.ShapeError, match="target position"):
        problem.set_terminal_cost(oc.LeastSquares(oc.FrameTranslationResidual("panda_link8", np.zeros(2))))
    with pytest.raises(rd.ShapeError, match="target controls"):
        problem.set_terminal_cost(oc.LeastSquares(oc.ControlResidual([1.0])))
    with pytest.raises(rd.ControlError, match="weight 0"):
        problem.set_running_cost(oc.LeastSquares(oc.ControlResidual(), -1.0))
    with pytest.raises(IndexError, match="0 to 4"):
        problem.set_running_cost(nodes=5)
    with pytest.raises(TypeError, match="LeastSquares"):
        problem.set_running_cost(oc.ControlResidual())  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="states need controls"):
        problem.solve(states=np.zeros((6, 14)))
    with pytest.raises(rd.ControlError, match="needs a robot"):
        mass().set_terminal_cost(oc.LeastSquares(oc.CenterOfMassResidual(np.zeros(3))))
    floating = rd.example("quadruped", floating_base=True)
    start = (floating.neutral(), np.zeros(floating.nv))
    with pytest.raises(rd.ControlError, match="12 motors"):
        oc.Problem(oc.SmoothStep(floating), start, nodes=2).set_effort_limits()
    oc.Problem(oc.SmoothStep(floating, actuation="motors"), start, nodes=2).set_effort_limits()


def test_nodes_may_have_different_controls() -> None:
    problem = mass(10)
    problem.set_dynamics(oc.LinearDynamics(A, np.eye(2)), nodes=slice(5, None))
    assert problem.controls == [1] * 5 + [2] * 5
    problem.set_running_cost(oc.LeastSquares(oc.ControlResidual([0.0, 0.0]), [1.0, 2.0]), nodes=range(5, 10))
    with pytest.raises(rd.ControlError, match="different numbers of controls"):
        problem.set_running_cost(oc.LeastSquares(oc.ControlResidual()))
    solution = problem.solve()
    assert [u.shape for u in solution.controls] == [(1,)] * 5 + [(2,)] * 5
    assert solution.is_solved


FEET = ("front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot")


def standing() -> tuple[rd.Robot, Array, rd.Constraints]:
    """A quadruped that stands on its four feet, which are held as points."""
    robot = rd.example("quadruped", floating_base=True)
    q = robot.neutral()
    for joint in robot.joints:
        if joint.name.endswith(("hip_pitch", "knee")):
            q[joint.q] = 0.6 if joint.name.endswith("hip_pitch") else -1.2
    points = {foot: rd.PointContact(foot, robot.frame_pose(q, foot)[:3, 3]) for foot in FEET}
    return robot, q, robot.constraints(points)


def test_held_step_follows_the_constrained_dynamics() -> None:
    robot, q, feet = standing()
    # Baumgarte's stabilisation with the rate 10.
    step = oc.HeldContactStep(robot, feet, dt=0.01, damping=20.0, stiffness=100.0, actuation="motors")
    problem = oc.Problem(step, (q, np.zeros(robot.nv)), nodes=20)
    problem.set_running_cost(oc.LeastSquares(oc.ControlResidual(), 1e-4))
    target = robot.center_of_mass(q) + [0.02, 0.0, -0.03]
    rest = [0.0] * robot.nv + [1.0] * robot.nv
    problem.set_terminal_cost(
        oc.LeastSquares(oc.CenterOfMassResidual(target), 1e5),
        oc.LeastSquares(oc.StateResidual((q, np.zeros(robot.nv))), rest),
    )
    solution = problem.solve()
    assert solution.is_solved
    assert np.linalg.norm(robot.center_of_mass(solution.q[-1]) - target) < 2e-3
    motors = np.asarray(robot.actuated_dofs)
    for k in range(20):
        tau = np.zeros(robot.nv)
        tau[motors] = solution.controls[k]
        q, v = solution.q[k], solution.v[k]
        held = robot.constrained_forward_dynamics(feet, q, v, tau, stabilization=10.0)
        # Rounding, with torques of 10 N·m on legs of 0.1 kg.
        assert np.allclose(solution.v[k + 1], v + 0.01 * held.acceleration, atol=1e-9)


def test_forces_stay_within_friction() -> None:
    robot, q, feet = standing()
    step = oc.HeldContactStep(robot, feet, dt=0.01, actuation="motors")
    solutions = []
    for weight in (0.0, 1.0):
        problem = oc.Problem(step, (q, np.zeros(robot.nv)), nodes=20)
        pyramids = [
            oc.LeastSquares(oc.FrictionPyramidResidual(step, foot, 0.3), weight, lower=0.0)
            for foot in FEET
        ]
        problem.set_running_cost(oc.LeastSquares(oc.ControlResidual(), 1e-4), *pyramids)
        target = robot.center_of_mass(q) + [0.05, 0.0, 0.0]
        problem.set_terminal_cost(oc.LeastSquares(oc.CenterOfMassResidual(target), 1e5))
        solutions.append(problem.solve())

    def excess(solution: oc.Solution) -> float:
        worst = 0.0
        for k in range(20):
            tau = np.zeros(robot.nv)
            tau[np.asarray(robot.actuated_dofs)] = solution.controls[k]
            held = robot.constrained_forward_dynamics(feet, solution.q[k], solution.v[k], tau)
            for x, y, z in np.asarray(held.multipliers).reshape(4, 3):
                worst = max(worst, abs(x) - 0.3 * z, abs(y) - 0.3 * z)
        return worst

    assert excess(solutions[1]) < 0.1 * excess(solutions[0])
    with pytest.raises(rd.ConstraintError, match="front_left_foot.x"):
        wrong = oc.LeastSquares(oc.FrictionPyramidResidual(step, "tail", 0.3))
        oc.Problem(step, (q, np.zeros(robot.nv)), nodes=2).set_running_cost(wrong)


def test_impact_stops_the_contact() -> None:
    robot, q, feet = standing()
    problem = oc.Problem(oc.SmoothStep(robot, dt=0.01, actuation="motors"), (q, np.full(robot.nv, -0.1)), nodes=4)
    problem.set_dynamics(oc.ImpactStep(robot, feet), nodes=2)
    assert problem.controls == [12, 12, 0, 12]
    problem.set_running_cost(oc.LeastSquares(oc.ControlResidual(), 1e-3), nodes=slice(0, 2))
    problem.set_running_cost(oc.LeastSquares(oc.ControlResidual(), 1e-3), nodes=3)
    solution = problem.solve()
    rows = robot.constraint_rows(feet, solution.q[3]).matrix
    assert np.abs(rows @ solution.v[2]).max() > 0.05
    assert np.abs(rows @ solution.v[3]).max() < 1e-10
    assert np.array_equal(solution.q[2], solution.q[3])


@pytest.mark.parametrize("law", ["mppi", "cross_entropy"])
def test_sampling_approaches_the_solution(law: str) -> None:
    problem = mass(20)
    problem.set_control_bounds(-1.0, 1.0)
    best = problem.solve()
    options = {"law": law, "temperature": 0.05, "iterations": 60, "correlation": 0.5}
    found = problem.sample(0.5, **options)  # type: ignore[arg-type]
    assert best.cost <= found.cost < 1.05 * best.cost < found.initial_cost
    assert np.abs(found.controls).max() <= 1.0
    # The states are those of the controls.
    x = np.array([1.0, 0.0])
    for k, u in enumerate(found.controls):
        x = A @ x + B @ u
        assert np.allclose(found.states[k + 1], x, atol=1e-12)
    again = problem.sample(0.5, threads=2, **options)  # type: ignore[arg-type]
    assert np.array_equal(found.controls, again.controls)
    with pytest.raises(ValueError, match="mppi"):
        problem.sample(0.5, law="random")  # type: ignore[arg-type]


def test_actuators_are_controls_of_a_step() -> None:
    arm = rd.example("two_r")
    motor: dict[str, Any] = {"rotor_inertia": 0.0, "resistance": 1.6, "constant": 0.08}
    geared = arm.with_motor("shoulder", gear=20.0, **motor).with_motor("elbow", gear=8.0, **motor)

    def least_cost(robot: rd.Robot, actuation: str | None, weights: list[float]) -> tuple[float, Array]:
        simulation = rd.Simulation(robot, dt=0.01, integrator="implicit")
        problem = oc.Problem(oc.SimulationStep(simulation, actuation=actuation), [0.2, 0.4, 0.0, 0.0], nodes=20)
        goal = oc.LeastSquares(oc.StateResidual([0.9, -0.3, 0.0, 0.0]), [100.0] * 4)
        problem.set_running_cost(oc.LeastSquares(oc.ControlResidual(), weights))
        problem.set_terminal_cost(goal)
        solution = problem.solve()
        return solution.cost, solution.controls[0]

    cost, tau = least_cost(arm, None, [1e-4, 1e-4])
    other, u = least_cost(geared, "actuators", [1e-4 * 20.0**2, 1e-4 * 8.0**2])
    assert other == pytest.approx(cost, rel=1e-6)
    np.testing.assert_allclose(u * [20.0, 8.0], tau, rtol=1e-3)
    with pytest.raises(rd.ControlError, match="no actuator"):
        least_cost(arm, "actuators", [1.0, 1.0])
