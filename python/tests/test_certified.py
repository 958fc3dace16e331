"""Proven bounds contain sampled torques, positions and exact numbers."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from conftest import ROBOTS, interrupted, load
from numpy.testing import assert_allclose

import robot_dynamics as rd
from robot_dynamics.certified import Motion, Payload

START = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8])

ROUNDING = 1e-12
"""Error of torques and positions in double precision, relative to the largest."""


def edited(robot: rd.Robot, factors: dict[str, float], ball: tuple[float, Any, float], gravity: Any) -> rd.Robot:
    """A robot with other masses, a ball at its flange, and other gravity."""
    for link, factor in factors.items():
        robot = robot.with_mass_scaled(factor, link)
    mass, center, radius = ball
    robot = robot.with_payload("panda_link8", mass, center, np.eye(3) * mass * radius**2)
    description = robot.describe()
    description["gravity"] = [float(x) for x in gravity]
    return rd.Robot.from_description(description)


def test_torque_bounds_contain_the_torques_of_edited_robots(panda: rd.Robot) -> None:
    random = np.random.default_rng(3)
    motion = Motion.spline([0.0, 0.6, 1.1, 2.0], START + random.uniform(-0.5, 0.5, (4, 7)))
    center = ((-0.1, 0.1), 0.0, (0.05, 0.2))
    gravity = [[-0.5, 0.5], [0.0, 0.0], [-9.9, -9.7]]
    bounds = panda.certify_torques(
        motion,
        masses=(0.9, 1.1),
        payload=Payload("panda_link8", mass=(0.0, 3.0), center_of_mass=center, radius_of_gyration=0.1),
        friction=(0.5, 2.0),
        gravity=gravity,
    )
    assert bounds.is_tight
    assert np.all(bounds.lower <= bounds.least) and np.all(bounds.greatest <= bounds.upper)
    links = [link.name for link in panda.links if link.mass > 0.0 and link.parent_joint is not None]
    for _ in range(60):
        factors = {link: random.choice([0.9, 1.1, random.uniform(0.9, 1.1)]) for link in links}
        place = [random.uniform(*np.broadcast_to(x, 2)) for x in center]
        ball = random.uniform(1e-6, 3.0), place, random.uniform(0.0, 0.1)
        robot = edited(panda, factors, ball, [random.uniform(low, high) for low, high in gravity])
        time = random.uniform(0.0, motion.duration)
        q, v, a = motion.state(time)
        tau = robot.inverse_dynamics(q, v, a) + random.uniform(0.5, 2.0) * robot.dissipation(v)
        slack = ROUNDING * np.abs(tau).max()
        assert np.all(bounds.lower - slack <= tau) and np.all(tau <= bounds.upper + slack)
        inside = (bounds.part_times[:, 0] < time) & (time < bounds.part_times[:, 1])
        assert np.all(bounds.part_lower[inside] - slack <= tau) and np.all(tau <= bounds.part_upper[inside] + slack)


def test_torque_bounds_of_one_robot_are_near_sampled_torques(panda: rd.Robot) -> None:
    motion = Motion.rest_to_rest(START, START + [0.5, -0.3, 0.4, 0.6, -0.5, 0.2, 0.3], 1.5)
    bounds = panda.certify_torques(motion, tolerance=1e-3)
    states = [motion.state(time) for time in np.linspace(0.0, 1.5, 5001)]
    tau = panda.inverse_dynamics(*(np.array(part) for part in zip(*states, strict=True)))
    width = tau.max(axis=0) - tau.min(axis=0)
    assert np.all(bounds.lower <= tau.min(axis=0) + ROUNDING) and np.all(tau.max(axis=0) <= bounds.upper + ROUNDING)
    # Each side may be larger by the tolerance; samples miss an extremum by less.
    assert np.all(bounds.upper - bounds.lower <= 1.003 * width)
    assert bounds.part_times[0, 0] == 0.0 and bounds.part_times[-1, 1] == 1.5
    assert_allclose(bounds.part_times[1:, 0], bounds.part_times[:-1, 1], rtol=0, atol=1e-15)
    assert np.all(bounds.part_upper.max(axis=0) == bounds.upper)
    # The attained torques are those at their times.
    for joint, (time, torque) in enumerate(zip(bounds.greatest_time, bounds.greatest, strict=True)):
        assert_allclose(panda.inverse_dynamics(*motion.state(time))[joint], torque, rtol=0, atol=ROUNDING * 100)


def test_limits_of_torque_are_proven_or_exceeded_or_open() -> None:
    robot = rd.example("two_r")
    motion = Motion.rest_to_rest([0.0, 0.0], [0.0, 0.0], 1.0)
    bounds = robot.certify_torques(motion, masses=(0.9, 1.1))  # at rest: 24.525 and 4.905 N·m
    assert_allclose(bounds.upper, [1.1 * 24.525, 1.1 * 4.905], rtol=1e-12)
    assert bounds.within_limits() == {"shoulder": "counterexample", "elbow": "proven"}
    between = 0.5 * (bounds.greatest + bounds.upper)
    assert np.all(bounds.greatest <= between)
    assert set(bounds.within_limits(between).values()) <= {"proven", "open"}
    one = robot.certify_torques(motion, masses={"fore": (1.0, 1.2)})
    assert_allclose(one.upper, [24.525 + 0.2 * 1.5 * 9.81, 1.2 * 4.905], rtol=1e-12)


def test_a_motion_is_its_polynomials() -> None:
    points = np.array([[0.0, 1.0], [1.0, -1.0], [-1.0, 0.3]])
    motion = Motion.spline([2.0, 2.5, 3.5], points)
    assert_allclose(motion.durations, [0.5, 1.0])
    for time, point in zip([0.0, 0.5, 1.5], points, strict=True):
        assert_allclose(motion.state(time).q, point, atol=1e-14)
    q, v, a = motion.state(0.8)
    step = 1e-5  # an error of step² times derivatives of some units
    ahead, behind = motion.state(0.8 + step).q, motion.state(0.8 - step).q
    assert_allclose((ahead - behind) / (2 * step), v, atol=1e-7)
    assert_allclose((ahead - 2 * q + behind) / step**2, a, atol=1e-4)
    powers = 0.3 ** np.arange(6)
    assert_allclose(motion.coefficients[1] @ powers, q, atol=1e-14)
    with pytest.raises(ValueError, match="time is 1.6"):
        motion.state(1.6)


@pytest.mark.parametrize("name", ["panda", "two_r", "gripper", "gantry"])
def test_reachable_sets_contain_sampled_positions(name: str) -> None:
    robot = load(name)
    frame = robot.frame_names[-1]
    lower = np.clip(robot.limits.lower, -1.0, 0.0)
    upper = np.minimum(lower + 1.5, robot.limits.upper)
    reach = robot.certify_reach(frame, lower, upper)
    q = np.random.default_rng(4).uniform(lower, upper, (2000, robot.nq))
    positions = robot.frame_pose(q, frame)[:, :3, 3]
    low, high = reach.box
    assert np.all(low - ROUNDING <= positions) and np.all(positions <= high + ROUNDING)
    for direction in np.random.default_rng(5).normal(size=(5, 3)):
        proven, attained, farthest = reach.farthest(direction)
        along = positions @ direction
        assert along.max() <= proven + ROUNDING and attained <= proven
        assert np.all((lower <= farthest) & (farthest <= upper))
        assert abs(robot.frame_pose(farthest, frame)[:3, 3] @ direction - attained) < ROUNDING


def test_a_reachable_set_within_limits_is_near_its_ends() -> None:
    reach = rd.example("two_r").certify_reach("tip", cells=128)
    # Both joints turn fully: a disc of radius 2 m in the plane of x and z.
    assert_allclose(reach.box, [[-2.0, 0.0, -2.0], [2.0, 0.0, 2.0]], atol=2e-3)


def test_digits_of_a_planar_arm_are_those_of_its_closed_form() -> None:
    robot, q, v = rd.example("two_r"), np.array([0.3, 1.1]), np.array([0.7, -0.4])
    found = robot.certify_digits(q, v, tau=[1.0, 2.0])
    assert found.keys() == {
        "mass_matrix",
        "coriolis_matrix",
        "gravity_forces",
        "bias",
        "inverse_dynamics",
        "kinetic_energy",
        "potential_energy",
        "forward_dynamics",
    }
    c2, third = np.cos(np.longdouble(q[1])), np.longdouble(1) / 3
    mass = np.array([[6 * third + c2, third + c2 / 2], [third + c2 / 2, third]])
    c1, c12 = np.cos(np.longdouble(q[0])), np.cos(np.longdouble(q[0]) + np.longdouble(q[1]))
    g = np.longdouble(9.81)
    gravity = np.array([2 * g * c1 + g * c12 / 2, g * c12 / 2])
    exact = {"mass_matrix": mass, "gravity_forces": gravity, "kinetic_energy": v @ mass @ v / 2}
    for name, number in exact.items():
        quantity = found[name]
        # The moments of the rods are decimals of the file, rounded to doubles.
        slack = 1e-15 * float(np.abs(number).max())
        assert np.all(quantity.lower - slack <= number) and np.all(number <= quantity.upper + slack)
        error = float(np.abs(quantity.computed - number).max() / np.abs(quantity.computed).max())
        assert error <= quantity.relative_error + 1e-15
        assert 14.0 < quantity.digits <= 17.0
    assert found["kinetic_energy"].lower.shape == () and found["mass_matrix"].upper.shape == (2, 2)
    assert_allclose(found["forward_dynamics"].computed, robot.forward_dynamics(q, v, [1.0, 2.0]), rtol=1e-13)


def test_digits_agree_with_the_methods_of_every_robot(robot: rd.Robot) -> None:
    q, v = robot.random_configuration(seed=6), np.linspace(-0.5, 0.5, robot.nv)
    found = robot.certify_digits(q, v, v, v)
    results = {
        "mass_matrix": robot.mass_matrix(q),
        "coriolis_matrix": robot.coriolis_matrix(q, v),
        "gravity_forces": robot.gravity(q),
        "bias": robot.bias(q, v),
        "inverse_dynamics": robot.inverse_dynamics(q, v, v),
        "kinetic_energy": robot.kinetic_energy(q, v),
    }
    for name, result in results.items():
        quantity = found[name]
        scale = np.abs(quantity.computed).max()
        # The compiled code rounds otherwise than the recursion, by an error of the same size.
        allowed = (10 * quantity.relative_error + 1e-15) * scale
        assert np.all(quantity.lower - allowed <= result) and np.all(result <= quantity.upper + allowed), name
        assert quantity.digits > 10


def test_mass_matrices_are_proven_by_inertias_or_by_division() -> None:
    assert load("panda").certify_mass_matrix().verdict == "proven by own inertias"
    # A rod has no inertia along its axis, so the proof needs divisions. A full turn is the default.
    robot = rd.example("two_r")
    proof = robot.certify_mass_matrix()
    assert proof.verdict == "proven by division" and proof.is_proven and proof.divisions is not None
    assert proof.boxes == len(proof.divisions) == 2 * np.count_nonzero(proof.divisions >= 0) + 1
    assert np.all(proof.upper >= np.pi) and np.all(proof.lower <= -np.pi)
    q = np.random.default_rng(7).uniform(proof.lower, proof.upper, (500, 2))
    assert np.linalg.eigvalsh(robot.mass_matrix(q)).min() > 0.0


def test_mass_matrices_without_a_proof_have_a_counterexample_or_an_open_box() -> None:
    # A point mass at the elbow's axis moves nothing if the elbow turns.
    robot = rd.example("two_r").with_inertia("fore", 1.0, [0.0, 0.0, 0.0])
    proof = robot.certify_mass_matrix()
    assert proof.verdict == "counterexample" and not proof.is_proven and proof.q is not None
    assert np.linalg.eigvalsh(robot.mass_matrix(proof.q)).min() < 1e-12
    limited = rd.example("two_r").certify_mass_matrix([-3.0, -3.0], [3.0, 3.0], max_boxes=1)
    assert limited.verdict == "open" and limited.open_lower is not None and limited.open_upper is not None
    assert np.all(limited.open_lower >= -3.0) and np.all(limited.open_upper <= 3.0)


def test_boxes_of_quaternions_are_unsupported(quadruped: rd.Robot) -> None:
    q = quadruped.neutral()
    assert quadruped.certify_digits(q)["mass_matrix"].digits > 12
    assert quadruped.certify_mass_matrix().is_proven
    foot = quadruped.frame_names[-1]
    with pytest.raises(rd.DescriptionError, match="quaternion"):
        quadruped.certify_reach(foot)
    motion = Motion.rest_to_rest(q, q, 1.0)
    with pytest.raises(rd.DescriptionError, match="quaternion"):
        quadruped.certify_torques(motion)


def test_wrong_arguments_are_errors() -> None:
    robot, at = rd.example("two_r"), Motion.rest_to_rest([0.0, 0.0], [1.0, 0.0], 1.0)
    body = Payload("tip", mass=1.0, radius_of_gyration=0.0)
    with pytest.raises(rd.FrameError, match="hand"):
        robot.certify_torques(at, masses={"hand": 1.0})
    with pytest.raises(rd.FrameError, match="hand"):
        robot.certify_torques(at, payload=Payload("hand", mass=1.0, radius_of_gyration=0.0))
    wrong: list[dict[str, Any]]
    wrong = [{"masses": (1.1, 0.9)}, {"masses": (-0.1, 1.0)}, {"friction": (0.0, np.inf)}, {"tolerance": np.nan}]
    for arguments in wrong:
        with pytest.raises(rd.StateError):
            robot.certify_torques(at, **arguments)
    wrong = [{"mass": (-1.0, 1.0)}, {"radius_of_gyration": -0.1}, {"frame": "base"}]
    for fields in wrong:
        with pytest.raises(rd.StateError):
            robot.certify_torques(at, payload=replace(body, **fields))
    with pytest.raises(rd.ShapeError, match="gravity"):
        robot.certify_torques(at, gravity=[0.0, 9.81])
    with pytest.raises(rd.ShapeError, match="2 are needed"):
        robot.certify_torques(Motion.rest_to_rest([0.0], [1.0], 1.0))
    with pytest.raises(rd.StateError, match="not after"):
        Motion.spline([0.0, 0.0], [[0.0], [1.0]])
    with pytest.raises(rd.StateError):
        Motion.rest_to_rest([0.0], [1.0], 0.0)
    with pytest.raises(rd.ShapeError):
        Motion.rest_to_rest([0.0], [1.0, 2.0], 1.0)
    with pytest.raises(rd.StateError, match="lower"):
        robot.certify_mass_matrix([1.0, 0.0], [0.0, 1.0])
    with pytest.raises(rd.ShapeError):
        robot.certify_mass_matrix([1.0])
    with pytest.raises(ValueError, match="power of two"):
        robot.certify_reach("tip", cells=12)
    with pytest.raises(rd.StateError):
        robot.certify_reach("tip").farthest([np.nan, 0.0, 0.0])
    with pytest.raises(rd.StateError):
        robot.certify_digits([np.nan, 0.0])


def test_a_search_is_interrupted() -> None:
    errors, _ = interrupted(
        f"""
import numpy as np, robot_dynamics as rd
robot = rd.load({str(ROBOTS / "panda.urdf")!r})
motion = rd.certified.Motion.rest_to_rest(np.zeros(7), np.ones(7), 1.0)
print("ready", flush=True)
robot.certify_torques(motion, masses=(0.9, 1.1), tolerance=0.0, max_parts=10**9)
"""
    )
    assert "KeyboardInterrupt" in errors
