"""Scenes: robots and objects joined to one robot."""

from pathlib import Path

import numpy as np
import pytest

import robot_dynamics as rd


def test_mobile_manipulator_with_objects_is_one_robot() -> None:
    base = rd.loads(
        """<robot name="cart"><link name="cart"><inertial><mass value="20"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
    )
    arm = rd.example("panda")
    scene = rd.Scene("kitchen")
    scene.add(base, joint="planar", at=(0.0, 0.0, 0.2), prefix="base_")
    scene.add(arm, on="base_cart", at=(0.0, 0.0, 0.1), prefix="arm_")
    scene.add_box("table", (1.0, 0.6, 0.4), at=(0.9, 0.0, 0.2))
    scene.add_sphere("ball", 0.05, at=(0.8, 0.0, 0.45), mass=0.2)
    scene.add_cylinder("can", 0.03, 0.1, at=(0.9, 0.1, 0.45), density=800.0)
    scene.add_plane("floor")
    robot = scene.robot()
    assert robot.nv == 3 + arm.nv + 2 * 6
    can = 800.0 * np.pi * 0.03**2 * 0.1
    assert robot.mass == pytest.approx(20.0 + arm.mass + 0.2 + can, rel=1e-12)
    # The kinetic energy of the arm on its base at rest is its own.
    joints = [joint for joint in robot.joints if joint.name.startswith("arm_") and joint.v.stop > joint.v.start]
    assert [joint.name.removeprefix("arm_") for joint in joints] == [j.name for j in arm.joints if j.v.stop > j.v.start]
    q, v = robot.neutral(), np.zeros(robot.nv)
    own_q = np.linspace(-0.5, 0.4, arm.nq)
    own_v = np.linspace(1.0, -1.0, arm.nv)
    for k, joint in enumerate(joints):
        q[joint.q], v[joint.v] = own_q[k], own_v[k]
    assert robot.kinetic_energy(q, v) == pytest.approx(arm.kinetic_energy(own_q, own_v), rel=1e-12)
    tip = arm.frame_names[-1]
    expected = np.array(arm.frame_pose(own_q, tip))
    expected[2, 3] += 0.3
    np.testing.assert_allclose(robot.frame_pose(q, f"arm_{tip}"), expected, atol=1e-14)


def test_objects_come_to_rest_on_fixed_geometry() -> None:
    scene = rd.Scene()
    scene.add_plane("floor")
    scene.add_box("table", (1.0, 1.0, 0.4), at=(0.0, 0.0, 0.2))
    scene.add_box("cube", (0.1, 0.1, 0.1), at=(0.2, 0.0, 0.46), density=500.0)
    scene.add_sphere("ball", 0.1, at=(2.0, 0.0, 0.12), mass=1.0)
    robot = scene.robot()
    motion = robot.simulate(robot.neutral(), duration=1.0)
    height = {joint.child_link: motion.q[-1, joint.q][2] for joint in robot.joints if joint.kind == "floating"}
    # q is relative to the place where the object was added: both fell by their distance, to 1e-6 m.
    assert height["cube"] == pytest.approx(-0.01, abs=1e-6)
    assert height["ball"] == pytest.approx(-0.02, abs=1e-6)


def test_wrong_parts_are_refused() -> None:
    scene = rd.Scene()
    scene.add(rd.example("two_r"), prefix="a_")
    with pytest.raises(rd.DescriptionError, match="already has"):
        scene.add(rd.example("two_r"), prefix="a_")
    with pytest.raises(rd.DescriptionError, match="a_hand"):
        scene.add(rd.example("two_r"), on="a_hand", prefix="b_")
    with pytest.raises(rd.ShapeError):
        scene.add(rd.example("two_r"), at=(1.0, 2.0), prefix="b_")
    with pytest.raises(ValueError, match="hinge"):
        scene.add(rd.example("two_r"), joint="hinge", prefix="b_")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="not both"):
        scene.add_sphere("ball", 0.1, at=(0, 0, 0), mass=1.0, density=1.0)
    with pytest.raises(rd.DescriptionError, match="mass"):
        scene.add_sphere("ball", 0.1, at=(0, 0, 0), mass=-1.0)
    assert scene.robot().nv == 2


def test_other_gravity_is_told() -> None:
    moon = rd.example("two_r").with_gravity_scaled(0.165)
    with pytest.warns(rd.LoadWarning, match="gravity"):
        rd.Scene().add(moon)


def test_scene_file_is_the_scene_of_a_program(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(rd.example("two_r").to_text().text)
    text = """<scene name="cell"><ground friction="0.4"/>
        <robot file="arm.urdf" xyz="0 0 1" prefix="a_" joint="helical" pitch="0.1"/>
        <table name="table" size="1 0.6 0.4"/><wall name="wall" from="0 1" to="2 1" height="2" thickness="0.2"/>
        <box name="door" size="1 0.1 2" mass="10" joint="revolute" axis="1 0 0" on="table"/></scene>"""
    (tmp_path / "cell.scene").write_text(text)
    scene = rd.Scene("cell")
    scene.add_ground(friction=0.4)
    scene.add(rd.load(tmp_path / "arm.urdf"), at=(0.0, 0.0, 1.0), prefix="a_", joint="helical", pitch=0.1)
    scene.add_table("table", (1.0, 0.6, 0.4))
    scene.add_wall("wall", (0, 1), (2, 1), 2.0, thickness=0.2)
    scene.add_box("door", (1.0, 0.1, 2.0), at=(0, 0, 0), mass=10.0, on="table", joint="revolute", axis=(1, 0, 0))
    read = rd.load(tmp_path / "cell.scene")
    assert read.describe() == scene.robot().describe()
    assets = {"arm.urdf": (tmp_path / "arm.urdf").read_bytes()}
    assert rd.loads(text, assets=assets).nv == read.nv
    with pytest.raises(rd.LoadError, match="line 2"):
        rd.loads(text.replace("arm.urdf", "leg.urdf"), assets=assets)


def test_meshes_are_objects(tmp_path: Path) -> None:
    corners = [(x, y, z) for x in (0, 20) for y in (0, 40) for z in (0, 60)]
    faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {face}" for face in faces]
    (tmp_path / "brick.obj").write_text("\n".join(lines))
    scene = rd.Scene()
    scene.add_ground()
    # In centimetres.
    scene.add_mesh("brick", tmp_path / "brick.obj", at=(0, 0, 0.01), scale=0.01, density=1000.0)
    robot = scene.robot()
    assert robot.mass == pytest.approx(48.0, rel=1e-6)
    motion = robot.simulate(robot.neutral(), duration=0.5)
    assert motion.q[-1, 2] == pytest.approx(-0.01, abs=1e-5)
    (tmp_path / "open.obj").write_text("\n".join(lines[:-1]))
    with pytest.raises(rd.DescriptionError, match="open at 4 edges"):
        scene.add_mesh("open", tmp_path / "open.obj", at=(0, 0, 1), mass=1.0)
    scene.add_mesh("open", tmp_path / "open.obj", at=(0, 0, 1), mass=1.0, solid="hull")
    with pytest.raises(ValueError, match="mass"):
        scene.add_mesh("twice", tmp_path / "brick.obj", at=(0, 0, 1), mass=1.0, density=2.0)
