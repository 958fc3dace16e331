"""Gradients through time, against derivatives of each step and differences of rollouts."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import load, states
from test_motion import pendulum

H = 1e-3
EXPLICIT: dict[str, Any] = {"integrator": "rk4", "without": ["effort-limits"]}
"""The motion that a pullback with dissipation differentiates."""


def cotangents(robot: rd.Robot, *lead: int, seed: int = 5) -> tuple[Any, Any]:
    """Random gradients of a loss by q and v."""
    by_position, by_velocity = np.random.default_rng(seed).uniform(-1.0, 1.0, (2, *lead, robot.nv))
    return by_position, by_velocity


def close(found: Any, expected: Any, robot: rd.Robot, q: Any, digits: float = 1e-12) -> None:
    """Assert equality up to rounding, which solving with M amplifies by κ(M), in about a hundred products."""
    condition = np.linalg.cond(robot.mass_matrix(q)).max()
    scale = max(1.0, np.abs(expected).max())
    assert_allclose(found, expected, rtol=0, atol=digits * max(1.0, condition * 1e-2) * scale)


def test_a_step_is_its_derivatives_transposed(robot: rd.Robot) -> None:
    s, (by_q, by_v) = states(robot, 5), cotangents(robot, 5)
    many = robot.step_pullback(s.q, s.v, s.tau, by_position=by_q, by_velocity=by_v, dt=H, **EXPLICIT)
    assert many.by_parameters is None and many.by_force is not None
    for k in range(5):
        a, b = robot.linearize_step(s.q[k], s.v[k], s.tau[k], dt=H, **EXPLICIT)
        given = np.concatenate([by_q[k], by_v[k]])
        expected = [*np.split(given @ a, 2), given @ b]
        one = robot.step_pullback(
            s.q[k], s.v[k], s.tau[k], by_position=by_q[k], by_velocity=by_v[k], dt=H, **EXPLICIT
        )
        for own, batch, slope in zip(one, many, expected, strict=False):
            close(own, slope, robot, s.q[k])
            assert batch is not None
            close(batch[k], slope, robot, s.q[k])


@pytest.mark.parametrize("name", ["panda", "gripper", "quadruped"])
@pytest.mark.parametrize("integrator", ["rk4", "semi-implicit-euler"])
def test_a_rollout_is_its_steps_one_after_the_other(name: str, integrator: str) -> None:
    robot = load(name)
    options: dict[str, Any] = {"dt": H, "integrator": integrator, "conservative": True}
    steps, stride = 6, 2
    s, (by_q, by_v) = states(robot, 2), cotangents(robot, 2)
    on_q, on_v = cotangents(robot, 2, steps // stride, seed=6)
    tau = np.random.default_rng(7).uniform(-1.0, 1.0, (2, steps, robot.nv))
    found = robot.rollout_pullback(
        s.q, s.v, tau, by_position=by_q, by_velocity=by_v, by_position_trajectory=on_q, by_velocity_trajectory=on_v,
        steps=steps, stride=stride, **options,
    )  # fmt: skip
    assert found.by_force is not None and found.by_force.shape == tau.shape
    for k in range(2):
        q, v, derivatives = s.q[k], s.v[k], []
        for j in range(steps):
            derivatives.append(robot.linearize_step(q, v, tau[k, j], **options))
            q, v = robot.step(q, v, tau[k, j], **options)
        given = np.concatenate([by_q[k], by_v[k]])
        for j in reversed(range(steps)):
            if (j + 1) % stride == 0:
                given = given + np.concatenate([on_q[k, j // stride], on_v[k, j // stride]])
            close(found.by_force[k, j], given @ derivatives[j].by_force, robot, s.q[k])
            given = given @ derivatives[j].by_state
        close(np.concatenate([found.by_position[k], found.by_velocity[k]]), given, robot, s.q[k])


def test_a_rollout_is_differences_of_rollouts(panda: rd.Robot) -> None:
    # For central differences of 1e-5 the truncation is about 1e-10 and the rounding 1e-16/1e-5, both times
    # the size of the derivatives.
    options: dict[str, Any] = {"steps": 20, "dt": H, "conservative": True}
    s, (by_q, by_v), d = states(panda, 3), cotangents(panda, 3), 1e-5

    def loss(q: Any, v: Any, tau: Any) -> Any:
        end = panda.rollout(q, v, tau, **options, integrator="rk4")
        return (end.q * by_q + end.v * by_v).sum(axis=-1)

    found = panda.rollout_pullback(s.q, s.v, s.tau, by_position=by_q, by_velocity=by_v, **options)
    for which, gradient in enumerate(found[:3]):
        assert gradient is not None
        for j in range(7):
            state, moved = [s.q, s.v, s.tau], np.eye(7)[j] * d
            sides = []
            for side in (1, -1):
                q, v, tau = (x + side * moved if k == which else x for k, x in enumerate(state))
                sides.append(loss(q, v, tau))
            assert_allclose(gradient[:, j], (sides[0] - sides[1]) / (2 * d), rtol=1e-6, atol=1e-7)


def test_parameters_have_gradients_through_time() -> None:
    options: dict[str, Any] = {"steps": 50, "dt": H, "integrator": "rk4", "dissipation": True}
    robot = load("two_r")
    values, names = robot.parameters(), robot.parameter_names
    values[names.index("shoulder.damping")] = 0.4
    values[names.index("elbow.stiffness")] = 2.0
    robot = robot.with_parameters(values)
    q, v, tau = np.array([0.3, 1.2]), np.array([1.0, -2.0]), np.array([0.5, -0.1])
    found = robot.rollout_pullback(q, v, tau, by_velocity=[1.0, 2.0], parameters=True, **options)
    assert found.by_parameters is not None and found.by_parameters.shape == values.shape
    seen = 0
    for k, name in enumerate(names):
        d, sides = 1e-4, []
        # A coefficient of 0 cannot decrease, so the differences are one-sided, of second order.
        is_least = values[k] == 0.0 and name.endswith(("armature", "damping", "friction", "stiffness"))
        at, weights = ((0, 1, 2), (-1.5, 2.0, -0.5)) if is_least else ((-1, 1), (-0.5, 0.5))
        for side in at:
            changed = values.copy()
            changed[k] += side * d
            sides.append(robot.with_parameters(changed, as_written=True).rollout(q, v, tau, **options).v @ [1.0, 2.0])
        # Truncation is d² times a third derivative, which for an inertia of 0.01 is about a hundred times the
        # first.
        assert_allclose(found.by_parameters[k], np.dot(weights, sides) / d, rtol=1e-4, atol=1e-5, err_msg=name)
        seen += found.by_parameters[k] != 0.0
    assert seen >= 12
    many = robot.rollout_pullback([q, q], v, tau, by_velocity=[1.0, 2.0], parameters=True, **options)
    assert many.by_parameters is not None
    for row in many.by_parameters:
        assert_allclose(row, found.by_parameters, rtol=1e-9, atol=1e-12)


def test_a_robot_with_its_own_parameters_is_itself(robot: rd.Robot) -> None:
    same = robot.with_parameters(robot.parameters())
    s = states(robot, 3)
    # Bodies fixed to a link are added once in either case.
    assert_allclose(same.parameters(), robot.parameters(), rtol=1e-13, atol=1e-13)
    assert_allclose(same.inverse_dynamics(s.q, s.v, s.a), robot.inverse_dynamics(s.q, s.v, s.a), rtol=1e-10, atol=1e-10)
    assert same.coordinate_names == robot.coordinate_names and len(robot.parameter_names) == len(robot.parameters())


def test_neither_checkpoints_nor_threads_change_a_bit(panda: rd.Robot) -> None:
    s, (by_q, by_v) = states(panda, 20), cotangents(panda, 20)
    hows: list[dict[str, Any]] = [{}, {"spacing": 1}, {"spacing": 30}, {"threads": 1}, {"threads": 3}]
    runs = [
        panda.rollout_pullback(
            s.q, s.v, s.tau, by_position=by_q, by_velocity=by_v, steps=30, dt=H, parameters=True, **how
        )
        for how in hows
    ]
    for run in runs[1:]:
        for name in ("by_position", "by_velocity", "by_force", "by_parameters"):
            own, first = getattr(run, name), getattr(runs[0], name)
            assert own is not None and np.array_equal(own, first)


def test_float32_is_computed_in_float32(panda: rd.Robot) -> None:
    s, (_, by_v) = states(panda, 3), cotangents(panda, 3)
    exact = panda.rollout_pullback(s.q, s.v, s.tau, by_velocity=by_v, steps=10)
    single = [each.astype(np.float32) for each in (s.q, s.v, s.tau, by_v)]
    for pick in (slice(None), 1):
        q, v, tau, given = (each[pick] for each in single)
        found = panda.rollout_pullback(q, v, tau, by_velocity=given, steps=10)
        for own, double in zip(found[:3], exact[:3], strict=True):
            assert own is not None and double is not None and own.dtype == np.float32
            assert_allclose(own, double[pick], rtol=0, atol=1e-3 * np.abs(double).max())


def test_unsupported_pullbacks_raise_errors(panda: rd.Robot) -> None:
    s = states(panda, 4)
    with pytest.raises(rd.SimulationError, match="variational-midpoint solves an equation at each step"):
        panda.step_pullback(s.q[0], s.v[0], dt=H, integrator="variational-midpoint")
    with pytest.raises(rd.SimulationError, match="variational-midpoint solves an equation at each step"):
        panda.step_pullback(s.q, s.v, dt=H, integrator="variational-midpoint")
    with pytest.raises(rd.ShapeError, match=r"by_velocity has shape \(6,\), it must broadcast to \(4, 7\)"):
        panda.step_pullback(s.q, s.v, by_velocity=np.zeros(6), dt=H)
    with pytest.raises(ValueError, match="need the stride"):
        panda.rollout_pullback(s.q, steps=3, by_velocity_trajectory=np.zeros((3, 7)))
    with pytest.raises(rd.DTypeError, match="nothing is converted silently"):
        panda.step_pullback(s.q, s.v, by_velocity=np.zeros(7, np.float32), dt=H)
    v = s.v.copy()
    v[2, 0] = np.inf
    with pytest.raises(rd.BadStatesError, match="1 of 4 states is bad, the first is state 2") as error:
        panda.step_pullback(s.q, v, by_velocity=np.ones(7), dt=H)
    assert error.value.indices.tolist() == [2]
    good = panda.step_pullback(s.q, s.v, by_velocity=np.ones(7), dt=H)
    assert np.array_equal(error.value.result.by_position[[0, 1, 3]], good.by_position[[0, 1, 3]])
    assert np.isnan(error.value.result.by_position[2]).all()
    massless = pendulum().parameters()
    massless[:10] = 0.0
    with pytest.raises(rd.SingularMassError, match="hinge"):
        pendulum().with_parameters(massless).step_pullback([0.1], [0.0], by_velocity=[1.0], dt=H)
    massless[1] = 1.0
    with pytest.raises(rd.DescriptionError, match="first moment"):
        pendulum().with_parameters(massless)
    with pytest.raises(rd.DescriptionError, match="parameters has 2 numbers, robot `pendulum` needs 18"):
        pendulum().with_parameters([1.0, 2.0])
    with pytest.raises(rd.DescriptionError, match=r"`floating_base` is the floating base"):
        quadruped = load("quadruped")
        quadruped.with_parameters(quadruped.parameters() + 1.0)


@pytest.mark.parametrize("solution", ["inverse_dynamics", "forward_dynamics"])
def test_solutions_have_gradients_by_parameters(robot: rd.Robot, solution: str) -> None:
    s = states(robot, 5)
    third = s.a if solution == "inverse_dynamics" else s.tau
    pullback = getattr(robot, f"{solution}_pullback_with_parameters")
    many = pullback(s.q, s.v, third, s.cotangent)
    assert many.by_parameters.shape == (5, len(robot.parameter_names))
    # Inertial parameters by the regressor: λᵀY, and −(M⁻¹λ)ᵀY at the acceleration.
    a = s.a if solution == "inverse_dynamics" else robot.forward_dynamics(s.q, s.v, s.tau)
    weights = s.cotangent if solution == "inverse_dynamics" else -many.by_force
    expected = np.einsum("ki,kij->kj", weights, robot.joint_torque_regressor(s.q, s.v, a))
    close(many.by_parameters[:, : expected.shape[1]], expected, robot, s.q)
    plain = getattr(robot, f"{solution}_pullback")(s.q, s.v, third, s.cotangent)
    for own, other in zip(many, plain, strict=False):
        close(own, other, robot, s.q)
    for k in range(5):
        one = pullback(s.q[k], s.v[k], third[k], s.cotangent[k])
        for own, batch in zip(one, many, strict=True):
            close(own, batch[k], robot, s.q[k])
    out = tuple(np.empty_like(each) for each in many)
    assert pullback(s.q, s.v, third, s.cotangent, out=out) is out
    assert all(np.array_equal(own, other) for own, other in zip(out, many, strict=True))


def test_bodies_are_judged_as_by_physical_consistency(panda: rd.Robot) -> None:
    values, names = panda.parameters(), panda.parameter_names
    thin = names.index("panda_link3.Iyy")
    values[thin] *= 0.01  # the other two moments cannot differ by so much
    inertial = panda.inertial_parameter_names
    verdicts = panda.physical_consistency(values[: len(inertial)])
    assert [link.link for link in verdicts if not link.is_consistent] == ["panda_link3"]
    with pytest.raises(rd.DescriptionError, match=r"link `panda_link3`: no body has these parameters: .*as_written=True"):
        panda.with_parameters(values)
    odd = panda.with_parameters(values, as_written=True)
    assert odd.parameters()[thin] == pytest.approx(values[thin])
    # Unchanged links keep the values of their file.
    again = odd.parameters()
    again[names.index("panda_joint1.damping")] = 2.0
    assert odd.with_parameters(again).dissipation([1.0] * 7)[0] == 2.0


def test_parameters_are_those_of_what_moves(panda: rd.Robot) -> None:
    fixed = [joint.name for joint in panda.joints if joint.kind == "fixed"]
    assert fixed and not [name for name in panda.parameter_names if name.rpartition(".")[0] in fixed]
    links, joints = len(panda.inertial_parameter_names), sum(joint.kind != "fixed" for joint in panda.joints)
    assert len(panda.parameters()) == links + 5 * joints + 3
    # Changing one number of each moving joint gives another robot.
    for name in ("armature", "damping", "friction", "stiffness"):
        for joint in panda.joint_names:
            values = panda.parameters()
            values[panda.parameter_names.index(f"{joint}.{name}")] += 0.1
            changed = panda.with_parameters(values).joints
            assert [own.name for own, old in zip(changed, panda.joints, strict=True) if own.passive != old.passive] == [joint]


@pytest.mark.parametrize("solution", ["inverse_dynamics", "forward_dynamics"])
@pytest.mark.parametrize("name", ["two_r", "gripper"])
def test_gradients_by_each_parameter_are_differences(name: str, solution: str) -> None:
    robot = load(name)
    values, names = robot.parameters(), robot.parameter_names
    for k, each in enumerate(names):
        values[k] += 0.3 * each.endswith((".armature", ".stiffness")) - 0.2 * each.endswith(".rest")
    robot = robot.with_parameters(values)
    s, d, seen = states(robot, 3), 1e-5, 0
    state = (s.q, s.v, s.a if solution == "inverse_dynamics" else s.tau)
    found = getattr(robot, f"{solution}_pullback_with_parameters")(*state, s.cotangent).by_parameters
    for k, each in enumerate(names):
        if each.endswith((".damping", ".friction")):  # absent from these equations
            assert not found[:, k].any(), each
            continue
        sides = []
        for side in (1, -1):
            changed = values.copy()
            changed[k] += side * d
            solved = getattr(robot.with_parameters(changed, as_written=True), solution)(*state)
            sides.append((solved * s.cotangent).sum(axis=-1))
        difference = (sides[0] - sides[1]) / (2 * d)
        # Rounding is 1e-16/1e-5 of the values. Truncation is d² times a third derivative, which is large for
        # a small inertia.
        assert_allclose(found[:, k], difference, rtol=1e-5, atol=1e-5 * max(1.0, np.abs(found).max()), err_msg=each)
        seen += bool(found[:, k].any())
    assert seen > len(names) // 3


def test_dissipation_has_gradients(panda: rd.Robot) -> None:
    values, names = panda.parameters(), panda.parameter_names
    for k, name in enumerate(names):
        values[k] += 0.5 * name.endswith(".damping") + 0.2 * name.endswith(".friction")
    robot, s = panda.with_parameters(values), states(panda, 4)
    found = robot.dissipation_pullback(s.v, s.cotangent)
    assert_allclose(found.by_velocity, s.cotangent * np.array([joint.passive.damping for joint in robot.joints if joint.v.stop > joint.v.start]))
    # b is linear in these parameters.
    assert_allclose(found.by_parameters @ values, (robot.dissipation(s.v) * s.cotangent).sum(axis=-1), rtol=1e-12)
    assert np.count_nonzero(found.by_parameters[0]) == 14


def test_derivatives_under_wrenches_are_differences(panda: rd.Robot) -> None:
    s, push = states(panda, 2), {"panda_link8": np.array([10.0, -5.0, 3.0, 0.5, 0.2, -0.4])}
    d = 1e-6
    for solution, third in (("inverse_dynamics", s.a), ("forward_dynamics", s.tau)):
        derivatives = getattr(panda, f"{solution}_derivatives_with_wrenches")(s.q, s.v, third, push)
        call = getattr(panda, f"{solution}_with_wrenches")
        for which, slope in enumerate(derivatives):
            for j in range(7):
                state, moved = [s.q, s.v, third], np.eye(7)[j] * d
                sides = [call(*(x + side * moved if k == which else x for k, x in enumerate(state)), push) for side in (1, -1)]
                assert_allclose(slope[:, :, j], (sides[0] - sides[1]) / (2 * d), rtol=1e-5, atol=1e-5)
        assert len(derivatives) == (2 if solution == "inverse_dynamics" else 3)


SLIDER = """<robot name="slider">
  <link name="rail"/>
  <link name="block"><inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="block"/><axis xyz="1 0 0"/>
    <limit lower="-10" upper="10" effort="100" velocity="100"/><dynamics friction="3"/></joint>
</robot>"""


def test_friction_holds_or_slides_in_a_gradient() -> None:
    # A block of 2 kg that friction of 3 N holds against 2 N, and that slides under 5 N: x = t²/2m (F − 3).
    robot = rd.loads(SLIDER)
    for force, expected in [(2.0, 0.0), (5.0, 0.25)]:
        found = robot.rollout_pullback(
            [0.0], [0.0], [force], by_position=[1.0], steps=100, dt=0.01, integrator="implicit"
        )
        assert found.steps == rd.LinearizedSteps(100, 0, 0, None)
        assert found.by_force is not None
        assert_allclose(found.by_force, [expected], rtol=0, atol=1e-9)


def test_gradients_through_contact_have_the_bits_of_single_states() -> None:
    dog = load("quadruped")
    q = np.tile(dog.neutral(), (3, 1))
    q[:, 2] += [0.0, 0.05, 0.1]
    by_q, by_v = cotangents(dog, 3)
    how: dict[str, Any] = {"steps": 20, "dt": H, "integrator": "implicit", "ground": rd.Ground()}
    many = dog.rollout_pullback(q, by_position=by_q, by_velocity=by_v, threads=2, **how)
    assert many.steps is not None and many.steps.analytic + many.steps.differences == 60
    for k in range(3):
        one = dog.rollout_pullback(q[k], by_position=by_q[k], by_velocity=by_v[k], spacing=7, **how)
        assert (one.by_position == many.by_position[k]).all() and (one.by_velocity == many.by_velocity[k]).all()


def test_options_without_gradients_are_named() -> None:
    robot = rd.loads(SLIDER)
    with pytest.raises(ValueError, match="has no contact"):
        robot.rollout_pullback([0.0], steps=1, ground=rd.Ground())
    with pytest.raises(ValueError, match="gradients by parameters need an explicit integrator"):
        robot.rollout_pullback([0.0], steps=1, integrator="implicit", parameters=True)
    with pytest.raises(TypeError, match="float64"):
        robot.rollout_pullback(np.zeros(1, np.float32), steps=1, integrator="implicit")
