"""Whole-body control: its equations, its limits, and motions under it."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from robot_dynamics import whole_body as wb

FEET = ("front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot")
RADIUS = 0.02


def standing(robot: rd.Robot) -> Any:
    """A configuration with all feet on the ground z = 0."""
    q = np.r_[np.zeros(6), 1.0, np.tile([0.0, 0.7, -1.4], 4)]
    q[2] = RADIUS - robot.frame_pose(q, FEET[0])[2, 3]
    return q


def stance(robot: rd.Robot, q: Any) -> tuple[wb.WholeBodyControl, int]:
    control = wb.WholeBodyControl(robot, dissipation=True)
    for foot in FEET:
        control.add_contact(wb.HeldContact(foot, wb.Ball(RADIUS), friction=0.6, sides=8))
    center = control.add_task(wb.CenterOfMass(robot.center_of_mass(q), stiffness=150.0), 10.0)
    trunk = wb.FramePose("trunk", robot.frame_pose(q, "trunk"), stiffness=150.0, rows=["rx", "ry", "rz"])
    control.add_task(trunk, 5.0)
    control.add_task(wb.Posture(q, stiffness=50.0), 1e-3)
    control.add_task(wb.ContactForces(), 1e-6)
    return control, center


def test_solution_satisfies_the_equations_of_motion(quadruped: rd.Robot) -> None:
    q, rng = standing(quadruped), np.random.default_rng(3)
    control, center = stance(quadruped, q)
    control.set_objective(center, wb.CenterOfMass(quadruped.center_of_mass(q) + [0.02, 0.01, -0.02], stiffness=80.0))
    v = 0.1 * rng.standard_normal(18)
    solution = control.solve(q, v)
    # M q̈ + C v + g + b = τ + Jᵀf with f at the points of the feet; the dissipation b is compensated.
    force = quadruped.inverse_dynamics(q, v, solution.acceleration) + quadruped.dissipation(v)
    assert len(solution.forces) == 4
    for point in solution.forces:
        frame = FEET[point.contact]
        pose = quadruped.frame_pose(q, frame)
        assert_allclose(point.position, pose[:3, 3] - [0.0, 0.0, RADIUS], atol=1e-12)
        jacobian = quadruped.frame_jacobian(q, frame, reference_frame="local_world_aligned")
        moment = np.cross(point.position - pose[:3, 3], point.force)
        force = force - jacobian.T @ np.r_[point.force, moment]
        sideways = np.hypot(point.force[0], point.force[1])
        assert sideways <= 0.6 * point.force[2] + 1e-9
    assert_allclose(force, solution.torque, atol=1e-7)
    assert np.all(solution.torque[:6] == 0.0)


def test_released_feet_carry_nothing(quadruped: rd.Robot) -> None:
    q = standing(quadruped)
    control, _ = stance(quadruped, q)
    control.hold_contact(2, False)
    solution = control.solve(q, np.zeros(18))
    assert {point.contact for point in solution.forces} == {0, 1, 3}
    total = sum(point.force[2] for point in solution.forces)
    momentum_rate = quadruped.mass * (9.81 + (quadruped.center_of_mass_jacobian(q) @ solution.acceleration)[2])
    assert_allclose(total, momentum_rate, rtol=1e-9)


def test_levels_are_strict_and_limits_hold(panda: rd.Robot) -> None:
    q, v = np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6]), np.zeros(7)
    goal = panda.frame_pose(q, "panda_link8")
    goal[:3, 3] += [0.05, -0.03, 0.02]
    control = wb.WholeBodyControl(panda)
    pose = control.add_task(wb.FramePose("panda_link8", goal, stiffness=100.0))
    alone = control.solve(q, v)
    control.add_task(wb.Posture(q + 0.5, stiffness=400.0), 100.0, level=1)
    both = control.solve(q, v)
    assert both.task_errors[pose] < 1e-8 and alone.task_errors[pose] < 1e-8
    assert np.abs(both.acceleration - alone.acceleration).max() > 1.0
    weakest = np.full(7, np.inf)
    weakest[1] = 0.9 * abs(both.torque[1])
    control.set_limits(torque=weakest)
    limited = control.solve(q, v)
    assert_allclose(abs(limited.torque[1]), weakest[1], rtol=1e-12)
    active = [limit for limit in limited.active_limits if limit.kind == "torque"]
    assert [limit.coordinate for limit in active] == [panda.coordinate_names[1]]
    assert control.limits.torque[1] == weakest[1] and control.limits.rate == 20.0


def test_a_pushed_quadruped_stands(quadruped: rd.Robot) -> None:
    q = standing(quadruped)
    control, _ = stance(quadruped, q)
    sim = rd.Simulation(quadruped, ground=rd.Ground(), dt=2e-3)
    sim.reset(q)
    home = quadruped.center_of_mass(q)
    pushed = 0.0
    for step in range(200):
        sim.clear_wrenches()
        if 20 <= step < 70:
            sim.apply_wrench("trunk", [0.0, 40.0, 0.0])
        sim.torques = control.solve(sim.q, sim.v).torque
        sim.step()
        pushed = max(pushed, float(np.abs(quadruped.center_of_mass(sim.q) - home)[1]))
    assert 1e-3 < pushed < 0.03
    assert np.abs(quadruped.center_of_mass(sim.q) - home).max() < 2e-3
    # The same controller inside of the simulation, without Python.
    motion = quadruped.simulate(q, tau=control, duration=0.1, dt=2e-3, ground=rd.Ground())
    assert np.abs(quadruped.center_of_mass(motion.q[-1]) - home).max() < 1e-3


def test_invalid_parts_are_refused(quadruped: rd.Robot, panda: rd.Robot) -> None:
    control = wb.WholeBodyControl(quadruped)
    with pytest.raises(rd.FrameError, match="nose"):
        control.add_contact(wb.HeldContact("nose", wb.Ball(0.1), friction=0.5))
    with pytest.raises(rd.StateError, match="at least three"):
        control.add_contact(wb.HeldContact(FEET[0], wb.Ball(0.1), friction=0.5, sides=2))
    with pytest.raises(rd.ShapeError, match="corners"):
        control.add_contact(wb.HeldContact(FEET[0], wb.Face([0.0, 1.0, 2.0]), friction=0.5))
    with pytest.raises(TypeError, match="HeldContact"):
        control.add_contact(wb.Ball(0.1))  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="geometry"):
        control.add_contact(wb.HeldContact(FEET[0], 0.1, friction=0.5))  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="objective"):
        control.add_task("posture")  # type: ignore[arg-type]
    with pytest.raises(rd.StateError, match="weight"):
        control.add_task(wb.ContactForces(), -1.0)
    with pytest.raises(IndexError, match="task 0 does not exist"):
        control.set_weight(0, 1.0)
    with pytest.raises(IndexError, match="contact 3 does not exist"):
        control.hold_contact(3, True)
    with pytest.raises(rd.StateError):
        control.set_limits(torque=np.full(18, -1.0))
    with pytest.raises(rd.ControlError, match="panda"):
        panda.simulate(np.zeros(7), tau=control, duration=0.1)
    control.add_contact(wb.HeldContact(FEET[0], wb.Ball(0.02), friction=0.5, normal_force=(1e6, 2e6)))
    control.add_task(wb.Posture(quadruped.neutral(), stiffness=1.0))
    control.set_limits(torque=np.full(18, 1.0), acceleration=np.full(18, 1.0))
    with pytest.raises(rd.ControlError, match="no motion satisfies"):
        control.solve(quadruped.neutral(), np.zeros(18))
