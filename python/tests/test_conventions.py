"""States in the conventions of MuJoCo, and links and joints by index."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import load, present, states


def test_layout_of_a_free_joint_in_mujoco(quadruped: rd.Robot) -> None:
    q, v, tau = quadruped.neutral(), np.zeros(18), np.zeros(18)
    half = np.sqrt(0.5)
    q[:7] = [1.0, 2.0, 3.0, 0.0, 0.0, half, half]  # a quarter turn about z
    v[:6] = [4.0, 0.0, 0.0, 0.0, 5.0, 6.0]
    tau[:6] = [7.0, 0.0, 0.0, 8.0, 0.0, 0.0]
    qpos, qvel, qacc, qfrc = quadruped.to_mujoco(q, v, np.zeros(18), tau)
    assert qvel is not None and qacc is not None and qfrc is not None
    assert_allclose(qpos[:7], [1.0, 2.0, 3.0, half, 0.0, 0.0, half], rtol=0, atol=1e-15)
    # Linear parts along the world's axes, angular ones along the body's.
    assert_allclose(qvel[:6], [0.0, 4.0, 0.0, 0.0, 5.0, 6.0], rtol=0, atol=1e-14)
    assert_allclose(qfrc[:6], [0.0, 7.0, 0.0, 8.0, 0.0, 0.0], rtol=0, atol=1e-14)
    # With a constant velocity in body axes: d(R u)/dt = R (ω × u), and ω × u = (0, 6 · 4, −5 · 4).
    assert_allclose(qacc[:6], [-24.0, 0.0, -20.0, 0.0, 0.0, 0.0], rtol=0, atol=1e-13)


def test_round_trip(robot: rd.Robot) -> None:
    s = states(robot, 12)
    given = [x.reshape(3, 4, -1) for x in (s.q, s.v, s.a, s.tau)]
    for there, back in ((robot.to_mujoco, robot.from_mujoco), (robot.to_pinocchio, robot.from_pinocchio)):
        for mine, found in zip(given, back(*there(*given)), strict=True):
            assert found is not None
            assert_allclose(found, mine, rtol=0, atol=1e-13)
        qpos, qvel, *rest = there(given[0], given[1][0, 0])
        assert qpos.shape[:-1] == (3, 4) and qvel is not None and qvel.shape == (3, 4, robot.nv)
        assert rest == [None, None]


def test_refuses_wrong_arguments(quadruped: rd.Robot) -> None:
    q = quadruped.neutral()
    with pytest.raises(ValueError, match="qacc needs qvel"):
        quadruped.from_mujoco(quadruped.to_mujoco(q).qpos, qacc=np.zeros(18))
    with pytest.raises(rd.ShapeError, match="v has shape"):
        quadruped.to_mujoco(q, np.zeros(19))
    with pytest.raises(rd.StateError, match="quaternion"):
        quadruped.to_pinocchio(2.0 * q)


@pytest.mark.parametrize("name", ["panda", "dual_arm", "quadruped", "humanoid"])
def test_same_accelerations_as_mujoco(name: str) -> None:
    mujoco = pytest.importorskip("mujoco")
    robot = load(name)
    model = mujoco.MjModel.from_xml_string(robot.to_text("mjcf").text)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.dof_damping[:] = 0.0
    data, s = mujoco.MjData(model), states(robot, 5)
    for q, v, tau in zip(s.q, s.v, s.tau, strict=True):
        data.qpos[:], data.qvel[:], _, data.qfrc_applied[:] = robot.to_mujoco(q, v, tau=tau)
        mujoco.mj_forward(model, data)
        found = present(robot.from_mujoco(data.qpos, data.qvel, data.qacc).a)
        expected = robot.forward_dynamics(q, v, tau)
        assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_links_and_joints_know_each_other(robot: rd.Robot) -> None:
    assert [joint.index for joint in robot.joints] == list(range(len(robot.joints)))
    assert [link.index for link in robot.links] == list(range(len(robot.links)))
    by_name = {link.name: link for link in robot.links}
    for joint in robot.joints:
        assert by_name[joint.child_link].parent_joint == joint.index
        parent = by_name.get(joint.parent_link)
        assert joint.parent_joint == (parent.parent_joint if parent else None)
        assert joint.parent_joint is None or joint.parent_joint < joint.index
    assert sum(link.parent_joint is None for link in robot.links) == (0 if robot.nq > robot.nv else 1)
    assert_allclose(sum(link.mass for link in robot.links), robot.total_mass, rtol=1e-12)
    assert robot.link_names == tuple(robot.frame_names[: len(robot.links)])
