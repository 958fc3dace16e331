"""The same numbers from Pinocchio, which shares no code with the library."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import NAMES, ROBOTS, present, states
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


def velocity_order(robot: rd.Robot) -> Any:
    """For each number of v its place in Pinocchio's."""
    places = robot.from_pinocchio(robot.to_pinocchio(robot.neutral()).q, np.arange(float(robot.nv))).v
    return present(places).astype(int)


def test_dynamics(pair: tuple[rd.Robot, Any, Any]) -> None:
    robot, model, data = pair
    s, iv = states(robot, 10), velocity_order(robot)
    q, v, a, tau = robot.to_pinocchio(s.q, s.v, s.a, s.tau)
    assert v is not None and a is not None and tau is not None
    for mine, back in zip((s.q, s.v, s.a, s.tau), robot.from_pinocchio(q, v, a, tau), strict=True):
        assert_allclose(present(back), mine, rtol=0, atol=1e-14)
    for k in range(len(s.q)):
        expected = pin.rnea(model, data, q[k], v[k], a[k])
        torques = present(robot.to_pinocchio(s.q[k], tau=robot.inverse_dynamics(s.q[k], s.v[k], s.a[k])).tau)
        assert_allclose(torques, expected, rtol=0, atol=1e-11 * max(1.0, np.abs(expected).max()))
        mass, own = pin.crba(model, data, q[k]), robot.mass_matrix(s.q[k])
        assert_allclose(own, mass[np.ix_(iv, iv)], rtol=0, atol=1e-11 * np.abs(mass).max())
        expected = pin.aba(model, data, q[k], v[k], tau[k])
        bound = 1e-13 * np.linalg.cond(own) * max(1.0, np.abs(expected).max())
        found = present(robot.to_pinocchio(s.q[k], s.v[k], robot.forward_dynamics(s.q[k], s.v[k], s.tau[k])).a)
        assert_allclose(found, expected, rtol=0, atol=bound)


def test_frames(pair: tuple[rd.Robot, Any, Any]) -> None:
    robot, model, data = pair
    s, iv = states(robot, 5), velocity_order(robot)
    name = robot.link_names[-1]
    frame = model.getFrameId(name)
    for k in range(len(s.q)):
        q = robot.to_pinocchio(s.q[k]).q
        pin.framesForwardKinematics(model, data, q)
        assert_allclose(robot.frame_pose(s.q[k], name), data.oMf[frame].homogeneous, rtol=0, atol=1e-12)
        for reference in REFERENCE_FRAMES:
            of_pinocchio = getattr(pin, reference.upper())
            expected = pin.computeFrameJacobian(model, data, q, frame, of_pinocchio)[:, iv]
            assert_allclose(robot.frame_jacobian(s.q[k], name, reference), expected, rtol=0, atol=1e-11)


PLANAR = """<robot name="cart"><link name="floor"/><link name="cart"><inertial><origin xyz="0.1 0.2 0.3"/><mass value="2"/>
<inertia ixx="0.2" iyy="0.3" izz="0.4" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="slide" type="planar">
<parent link="floor"/><child link="cart"/><axis xyz="0 0 1"/></joint></robot>"""


def test_planar_joint() -> None:
    robot, model = rd.loads(PLANAR), pin.buildModelFromXML(PLANAR)
    data, s = model.createData(), states(robot, 10)
    q, v, a, _ = robot.to_pinocchio(s.q, s.v, s.a)
    assert q.shape == (10, model.nq) == (10, 4) and v is not None and a is not None
    back = robot.from_pinocchio(q, v, a)
    assert_allclose(back.q, s.q, rtol=0, atol=1e-14)
    assert_allclose(present(back.a), s.a, rtol=0, atol=1e-14)
    for k in range(10):
        torques = present(robot.to_pinocchio(s.q[k], tau=robot.inverse_dynamics(s.q[k], s.v[k], s.a[k])).tau)
        assert_allclose(torques, pin.rnea(model, data, q[k], v[k], a[k]), rtol=0, atol=1e-13)
