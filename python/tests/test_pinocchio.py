"""The same numbers from Pinocchio, which shares no code with the library."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import NAMES, ROBOTS, states
from robot_dynamics.quantities import REFERENCE_FRAMES

pin = pytest.importorskip("pinocchio")

# Mimic joints are an optional feature of Pinocchio.
SHARED = [name for name in NAMES if name not in ("gripper", "hand")]


@pytest.fixture(params=SHARED)
def pair(request: pytest.FixtureRequest) -> tuple[rd.Robot, Any, Any]:
    """A robot in both libraries."""
    name = request.param
    base = (pin.JointModelFreeFlyer(),) if NAMES[name] else ()
    path = ROBOTS / f"{name}.urdf"
    model = pin.buildModelFromUrdf(str(path), *base)
    return rd.load(path, floating_base=NAMES[name]), model, model.createData()


def order(robot: rd.Robot, model: Any) -> tuple[list[int], list[int]]:
    """Indices of q and v in Pinocchio, which sorts siblings by name."""
    q: list[int] = []
    v: list[int] = []
    for joint in robot.joints:
        if joint.v.stop == joint.v.start:
            continue
        index = model.getJointId(joint.name) if model.existJointName(joint.name) else 1
        q += range(model.joints[index].idx_q, model.joints[index].idx_q + joint.q.stop - joint.q.start)
        v += range(model.joints[index].idx_v, model.joints[index].idx_v + joint.v.stop - joint.v.start)
    return q, v


def test_dynamics(pair: tuple[rd.Robot, Any, Any]) -> None:
    robot, model, data = pair
    s, (iq, iv) = states(robot, 10), order(robot, model)
    if any(joint.kind == "continuous" for joint in robot.joints):
        pytest.skip("Pinocchio writes unlimited angles as cosine and sine")
    q, v, a, tau = (np.zeros_like(x) for x in (s.q, s.v, s.a, s.tau))
    q[:, iq], v[:, iv], a[:, iv], tau[:, iv] = s.q, s.v, s.a, s.tau
    torques, masses = robot.inverse_dynamics(s.q, s.v, s.a), robot.mass_matrix(s.q)
    accelerations = robot.forward_dynamics(s.q, s.v, s.tau)
    for k in range(len(s.q)):
        expected = pin.rnea(model, data, q[k], v[k], a[k])[iv]
        assert_allclose(torques[k], expected, rtol=0, atol=1e-11 * max(1.0, np.abs(expected).max()))
        mass = pin.crba(model, data, q[k])
        assert_allclose(masses[k], mass[np.ix_(iv, iv)], rtol=0, atol=1e-11 * np.abs(mass).max())
        expected = pin.aba(model, data, q[k], v[k], tau[k])[iv]
        bound = 1e-13 * np.linalg.cond(masses[k]) * max(1.0, np.abs(expected).max())
        assert_allclose(accelerations[k], expected, rtol=0, atol=bound)


def test_frames(pair: tuple[rd.Robot, Any, Any]) -> None:
    robot, model, data = pair
    s, (iq, iv) = states(robot, 5), order(robot, model)
    if any(joint.kind == "continuous" for joint in robot.joints):
        pytest.skip("Pinocchio writes unlimited angles as cosine and sine")
    name = robot.link_names[-1]
    frame = model.getFrameId(name)
    for k in range(len(s.q)):
        q = np.zeros(model.nq)
        q[iq] = s.q[k]
        pin.framesForwardKinematics(model, data, q)
        assert_allclose(robot.frame_pose(s.q[k], name), data.oMf[frame].homogeneous, rtol=0, atol=1e-12)
        for reference in REFERENCE_FRAMES:
            of_pinocchio = getattr(pin, reference.upper())
            expected = pin.computeFrameJacobian(model, data, q, frame, of_pinocchio)[:, iv]
            assert_allclose(robot.frame_jacobian(s.q[k], name, reference), expected, rtol=0, atol=1e-11)
