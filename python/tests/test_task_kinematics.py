"""Inverse kinematics with several tasks against forward kinematics and the optimality conditions."""

import numpy as np
import pytest

import robot_dynamics as rd

START = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8])
HAND = "panda_link8"


@pytest.fixture(scope="module")
def panda() -> rd.Robot:
    return rd.example("panda")


def test_steps_reach_a_pose(panda: rd.Robot) -> None:
    target = panda.frame_pose(START, HAND)
    target[:3, 3] += [-0.1, 0.2, 0.0]
    tasks = rd.TaskKinematics(panda)
    tasks.add_pose(HAND, target, gain=0.3)
    tasks.add_posture(START, weight=1e-8)
    tasks.set_limits(acceleration=np.full(7, 20.0))
    q, v, dt = START, np.zeros(7), 0.01
    for _ in range(400):
        step = tasks.step(q, v, dt=dt)
        assert np.abs(step.velocity - v).max() <= 20.0 * dt + 1e-12
        np.testing.assert_allclose(panda.integrate(q, step.velocity * dt), step.q, atol=1e-14)
        q, v = step.q, step.velocity
    np.testing.assert_allclose(panda.frame_pose(q, HAND), target, atol=1e-6)


def test_a_step_solves_its_least_squares_problem(panda: rd.Robot) -> None:
    """Without limits the velocity is that of the damped normal equations."""
    wanted = panda.frame_pose(START, HAND)[:3, 3] + [0.02, -0.01, 0.03]
    tasks = rd.TaskKinematics(panda)
    tasks.add_pose(HAND, position=wanted, weight=2.0, gain=0.5)
    tasks.add_posture(START + 0.1, weight=0.3)
    tasks.set_damping(1e-3)
    far, dt = np.full(7, 1e6), 0.01
    tasks.set_limits(lower=-far, upper=far, velocity=far)
    error = panda.frame_pose(START, HAND)[:3, 3] - wanted
    jacobian = panda.frame_jacobian(START, HAND, reference_frame="local_world_aligned")[:3]
    hessian = 2.0 * jacobian.T @ jacobian + (0.3 + 1e-3) * np.eye(7)
    gradient = jacobian.T @ error - 0.3 * np.full(7, 0.1)
    expected = np.linalg.solve(hessian, -gradient) / dt
    # The added curvature is 1e-10 of the mean of the matrix.
    np.testing.assert_allclose(tasks.step(START, dt=dt).velocity, expected, rtol=1e-8)


def test_solutions_reach_all_targets(panda: rd.Robot) -> None:
    tasks = rd.TaskKinematics(panda)
    hand = tasks.add_pose(HAND, position=[0.4, 0.2, 0.5])
    point = np.array([0.6, 0.3, 0.0])
    tasks.add_look_at(HAND, [0.0, 0.0, 1.0], point)
    tasks.add_posture(START, level=1)
    found = tasks.solve(START)
    pose = panda.frame_pose(found.q, HAND)
    np.testing.assert_allclose(pose[:3, 3], [0.4, 0.2, 0.5], atol=2e-9)
    away = point - pose[:3, 3]
    np.testing.assert_allclose(pose[:3, 2], away / np.linalg.norm(away), atol=2e-9)
    assert found.errors.shape == (3, 2)
    assert found.errors[hand, 0] < 1e-9


def test_threads_do_not_change_batches(panda: rd.Robot) -> None:
    tasks = rd.TaskKinematics(panda)
    hand = tasks.add_pose(HAND, np.eye(4))
    targets = [panda.frame_pose(panda.random_configuration(seed=seed), HAND) for seed in range(8)]
    targets[3] = targets[3].copy()
    targets[3][:3, 3] = [3.0, 0.0, 0.0]
    options = {"max_restarts": 20}
    one = tasks.solve_many(hand, targets, threads=1, **options)
    two = tasks.solve_many(hand, targets, threads=2, **options)
    np.testing.assert_array_equal(one.q, two.q)
    assert one.found.tolist() == [True, True, True, False, True, True, True, True]
    for q, target, found in zip(one.q, targets, one.found, strict=True):
        if found:
            np.testing.assert_allclose(panda.frame_pose(q, HAND), target, atol=1e-8)


def test_constraints_hold(panda: rd.Robot) -> None:
    gear = panda.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
    tasks = rd.TaskKinematics(panda)
    tasks.add_constraints(gear)
    tasks.add_pose(HAND, position=[0.3, 0.2, 0.6])
    q = tasks.solve(START).q
    assert abs(q[0] - 2.0 * q[1]) < 1e-9
    np.testing.assert_allclose(panda.frame_pose(q, HAND)[:3, 3], [0.3, 0.2, 0.6], atol=2e-9)


SLIDERS = """<robot name="sliders">
  <link name="rail"/>
  <link name="left"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="right"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="left" type="prismatic"><parent link="rail"/><child link="left"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="right" type="prismatic"><parent link="rail"/><child link="right"/><origin xyz="0.5 0 0"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
</robot>"""


def test_links_stay_apart() -> None:
    """The left ball pushes the right one ahead of it, at the least distance."""
    robot = rd.loads(SLIDERS)
    tasks = rd.TaskKinematics(robot)
    tasks.add_pose("left", position=[1.0, 0.0, 0.0], gain=0.1)
    tasks.avoid_collisions(0.02)
    q = np.zeros(2)
    for _ in range(400):
        q = tasks.step(q, dt=0.01).q
        assert q[1] + 0.5 - q[0] - 0.2 > 0.02 - 1e-9
    np.testing.assert_allclose(q, [1.0, 0.72], atol=1e-6)
    distance = tasks.step(q, dt=0.01).distance
    assert distance is not None and abs(distance - 0.02) < 1e-6


def test_wrong_arguments_are_errors(panda: rd.Robot) -> None:
    tasks = rd.TaskKinematics(panda)
    with pytest.raises(rd.FrameError):
        tasks.add_pose("no such frame", np.eye(4))
    with pytest.raises(ValueError, match="a target or a position"):
        tasks.add_pose(HAND)
    with pytest.raises(rd.StateError):
        tasks.add_pose(HAND, np.eye(4), weight=-1.0)
    with pytest.raises(rd.ShapeError):
        tasks.set_limits(velocity=[1.0])
    tasks.add_pose(HAND, position=[3.0, 0.0, 0.0])
    with pytest.raises(rd.InverseKinematicsError, match="frame `panda_link8` is off by"):
        tasks.solve(max_restarts=2)
    with pytest.raises(rd.InverseKinematicsError, match="the step must be positive"):
        tasks.step(START, dt=0.0)
