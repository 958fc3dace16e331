"""Robots with parts added, removed or moved."""

from pathlib import Path

import numpy as np
import pytest

import robot_dynamics as rd

ROBOTS = Path(__file__).parents[2] / "robots"


def test_another_root_of_a_floating_robot_has_the_same_energies() -> None:
    robot = rd.example("quadruped", floating_base=True)
    rng = np.random.default_rng(3)
    for foot in ("front_left_foot", "hind_right_shank"):
        edited, _ = robot.with_root(foot)
        q = robot.random_configuration(seed=int(rng.integers(100)))
        v = rng.normal(size=robot.nv)
        new_q, new_v = edited.neutral(), np.zeros(edited.nv)
        own = {joint.name: joint for joint in robot.joints}
        for joint in (joint for joint in edited.joints[1:] if joint.v.stop > joint.v.start):
            new_q[joint.q], new_v[joint.v] = q[own[joint.name].q], v[own[joint.name].v]
        pose = robot.frame_pose(q, foot)
        new_q[:3] = pose[:3, 3]
        new_q[3:7] = quaternion(pose[:3, :3])
        new_v[:6] = robot.frame_velocity(q, v, foot, "local")
        # Rounding through a chain of links.
        assert edited.kinetic_energy(new_q, new_v) == pytest.approx(robot.kinetic_energy(q, v), rel=1e-12)
        assert edited.potential_energy(new_q) == pytest.approx(robot.potential_energy(q), abs=1e-11)
        for link in robot.link_names:
            np.testing.assert_allclose(edited.frame_pose(new_q, link), robot.frame_pose(q, link), atol=1e-13)


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """x y z w of a rotation: the eigenvector of the largest eigenvalue of Bar-Itzhack's matrix."""
    r = rotation
    matrix = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
            [r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
            [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], np.trace(r)],
        ]
    )
    return np.asarray(np.linalg.eigh(matrix / 3.0)[1][:, -1])


def test_removed_and_replaced_parts_are_told() -> None:
    arm = rd.example("panda").with_sensors({"wrist": ("jointpos", "panda_joint7")})
    robot, notes = arm.without_joint("panda_joint6")
    assert robot.nv == 5 and notes == ("sensor `wrist`: removed with joint `panda_joint7`",)
    hand = rd.load(ROBOTS / "hand.urdf")
    attached = arm.with_attached(hand, on="panda_link8", prefix="a_").robot
    mount = next(joint for joint in attached.joints if joint.parent_link == "panda_link8")
    replaced = attached.with_subtree_replaced(mount.name, rd.example("two_r"), "b_").robot
    assert replaced.nv == 9 and not any(name.startswith("a_") for name in replaced.link_names)
    with pytest.raises(rd.DescriptionError, match="did you mean `panda_joint6`"):
        arm.without_joint("panda_jiont6")
    with pytest.raises(rd.DescriptionError, match="did you mean `panda_link7`"):
        arm.with_root("panda_lnk7")


def test_added_links_and_masses() -> None:
    arm = rd.example("two_r")
    longer = arm.with_link(
        "slider", "fore", at=(1.0, 0.0, 0.0), joint="prismatic", axis=(1, 0, 0), limits=(0.0, 0.2), mass=0.5
    )
    q = [0.3, -0.4, 0.1]
    # The energy of the slider's point mass on the arm.
    jacobian = longer.frame_jacobian(q, "slider", "local_world_aligned")[:3]
    expected = np.zeros((3, 3))
    expected[:2, :2] = arm.mass_matrix(q[:2])
    np.testing.assert_allclose(longer.mass_matrix(q), expected + 0.5 * jacobian.T @ jacobian, atol=1e-13)
    np.testing.assert_allclose(arm.with_mass_scaled(2.0).mass_matrix(q[:2]), 2.0 * arm.mass_matrix(q[:2]), rtol=1e-14)
    assert arm.with_inertia("fore", 4.0, (0.5, 0.0, 0.0), np.eye(3)).mass == pytest.approx(6.0)
    with pytest.raises(ValueError, match="hinge"):
        arm.with_link("x", "fore", joint="hinge")  # type: ignore[arg-type]
    with pytest.raises(rd.ShapeError):
        arm.with_link("x", "fore", axis=(1, 0))
    with pytest.raises(rd.DescriptionError, match="factor"):
        arm.with_mass_scaled(-1.0)
