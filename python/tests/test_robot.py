"""The robot as an object: files, names, equality, copies, pickles."""

import copy
import pickle
import unicodedata
import warnings
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from robot_dynamics import _native
from conftest import ROBOTS, load, states

FAULTS = ROBOTS.parent / "testdata" / "faults"


def test_a_file_its_text_and_a_path_object_are_one_robot() -> None:
    path = ROBOTS / "panda.urdf"
    robot = rd.load(path)
    assert robot == rd.load(str(path)) == rd.loads(path.read_text()) == rd.example("panda")
    assert robot != rd.example("ur5") and robot != "panda" and len({robot, rd.load(path)}) == 1


def test_names_and_limits(panda: rd.Robot) -> None:
    assert (panda.nq, panda.nv, panda.name) == (7, 7, "panda")
    assert panda.joint_names == tuple(f"panda_joint{k}" for k in range(1, 8))
    assert panda.coordinate_names == list(panda.joint_names)
    assert panda.frame_names[-1] == panda.link_names[-1] == "panda_link8"
    assert panda.limits.effort.tolist() == [87.0] * 4 + [12.0] * 3
    first = panda.joints[0]
    assert (first.kind, first.q, first.limits.upper) == ("revolute", slice(0, 1), 2.8973)
    with pytest.raises(ValueError, match="read-only"):
        panda.limits.lower[0] = 0.0
    with pytest.raises(AttributeError):
        panda.nq = 3  # type: ignore[misc]


def test_a_free_root_has_seven_numbers_more() -> None:
    fixed, free = (rd.load(ROBOTS / "quadruped.urdf", floating_base=base) for base in (False, True))
    assert (free.nq - fixed.nq, free.nv - fixed.nv) == (7, 6)
    assert free.joints[0].kind == "floating" and np.isneginf(free.limits.lower[:6]).all()


def test_every_robot_comes_back_from_a_pickle_and_from_its_description(robot: rd.Robot) -> None:
    s = states(robot)
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        again = pickle.loads(pickle.dumps(robot, protocol))
        assert type(again) is rd.Robot and again == robot and hash(again) == hash(robot)
        assert again.report == robot.report
        assert np.array_equal(again.inverse_dynamics(s.q, s.v, s.a), robot.inverse_dynamics(s.q, s.v, s.a))
    assert copy.deepcopy(robot) == copy.copy(robot) == rd.Robot.from_description(robot.describe()) == robot


def test_the_last_digit_makes_another_robot(panda: rd.Robot) -> None:
    description = panda.describe()
    description["gravity"][2] = float(np.nextafter(description["gravity"][2], 0.0))
    other = rd.Robot.from_description(description)
    assert other != panda and other.fingerprint != panda.fingerprint


def test_warnings_of_suspicious_files_point_at_the_caller() -> None:
    path = FAULTS / "effort_zero.urdf"
    with pytest.warns(rd.LoadWarning, match=r"effort_zero.urdf: line \d+") as caught:
        robot = rd.load(path)
    assert caught[0].filename == __file__
    assert robot.report.warnings[0].line > 0 and "effort" in str(robot.report)
    with pytest.raises(rd.LoadError, match="effort"):
        rd.load(path, strict=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rd.load(ROBOTS / "panda.urdf")
        pickle.loads(pickle.dumps(robot))  # the warning was raised once, by `load`


def test_warnings_of_one_kind_are_one_with_a_count() -> None:
    joint = (
        "<link name='l{k}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        "<joint name='j{k}' type='continuous'><parent link='l{before}'/><child link='l{k}'/><axis xyz='0 0 1'/>"
        "<dynamics D='{k}' stiff='1e-{k}'/></joint>"
    )
    joints = "".join(joint.format(k=k, before=k - 1) for k in range(1, 15))
    with pytest.warns(rd.LoadWarning) as caught:
        robot = rd.loads(f"<robot name='chain'><link name='l0'/>{joints}</robot>")
    said = [str(one.message) for one in caught]
    assert len(said) == 2 and "unknown attribute D=" in said[0] and "unknown attribute stiff=" in said[1]
    assert all("(14 of this kind" in text and "and 10 more" in text for text in said)
    assert said == [f"the text: {text}" for text in robot.report.grouped_warnings]
    assert len(robot.report.warnings) == 28 and str(robot.report).count("unknown attribute") == 28


@pytest.mark.parametrize("path", sorted(FAULTS.glob("*.urdf")), ids=lambda path: path.stem)
def test_faulty_files_load_or_say_why(path: Path) -> None:
    try:
        robot = rd.load(path)
    except rd.LoadError as error:
        assert len(str(error)) > 20
    else:
        assert robot.report.robot == robot.name
        pickle.loads(pickle.dumps(robot))


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(rd.LoadError, match="nowhere.urdf"):
        rd.load(tmp_path / "nowhere.urdf")
    with pytest.raises(rd.LoadError):
        rd.loads("no robot")
    with pytest.raises(rd.LoadError):
        rd.Robot("json", "[]")


def test_packages_are_found_by_their_path(tmp_path: Path) -> None:
    """A mesh of `package://` is found in `package_path`, also for a text, and a confined reading refuses others."""
    mesh = tmp_path / "parts" / "meshes" / "m.stl"
    mesh.parent.mkdir(parents=True)
    mesh.write_text("solid\nendsolid\n")
    uri = "package://parts/meshes/m.stl"
    text = f"<robot name='r'><link name='a'><visual><geometry><mesh filename='{uri}'/></geometry></visual></link></robot>"
    assert str(mesh) not in str(rd.loads(text).report.files)
    assert str(mesh) in str(rd.loads(text, package_path=[tmp_path]).report.files)
    file = tmp_path / "other" / "r.urdf"
    file.parent.mkdir()
    file.write_text(text)
    assert str(mesh) in str(rd.load(file, package_path=[tmp_path]).report.files)
    assert str(mesh) not in str(rd.load(file, package_path=[tmp_path], confined=True).report.files)


def test_an_srdf_file_adds_groups_and_poses(panda: rd.Robot, tmp_path: Path) -> None:
    text = """<robot name="panda">
      <group name="arm"><chain base_link="panda_link0" tip_link="panda_link8"/></group>
      <group name="wrist"><joint name="panda_joint7"/></group>
      <group_state name="bent" group="arm"><joint name="panda_joint4" value="-1.5"/></group_state>
      <end_effector name="flange" group="wrist" parent_link="panda_link6" parent_group="arm"/>
      <passive_joint name="panda_joint1"/></robot>"""
    file = tmp_path / "panda.srdf"
    file.write_text(text)
    robot = rd.load(ROBOTS / "panda.urdf", srdf=file)
    assert robot.groups["arm"].joints == (*panda.joint_names, "panda_joint8")
    assert robot.groups["arm"].chains == (("panda_link0", "panda_link8"),)
    assert robot.end_effectors == {"flange": rd.EndEffector("flange", "wrist", "panda_link6", "arm")}
    assert robot.poses["bent"][0][3] == -1.5 and not robot.actuated_dofs[0] and robot.actuated_dofs[1]
    assert robot == rd.loads((ROBOTS / "panda.urdf").read_text(), srdf=text) and panda.groups == {}
    assert pickle.loads(pickle.dumps(robot)).groups == robot.groups
    with pytest.raises(rd.LoadError, match="line 2.*did you mean `panda_joint7`"):
        rd.loads((ROBOTS / "panda.urdf").read_text(), srdf='<robot name="panda">\n<passive_joint name="panda_joint7x"/></robot>')


def test_sdf_models_are_read(tmp_path: Path) -> None:
    folder = ROBOTS.parent / "testdata" / "sdf"
    arm = rd.load(folder / "arm.sdf")
    assert arm.nv == 11 and arm.joint_names[-1] == "left::slide" and arm.joints[0].kind == "floating"
    # The included model from memory, and the same M.
    assets = {f"hand/{name}": (folder / "hand" / name).read_bytes() for name in ("hand.sdf", "model.config")}
    q = arm.neutral()
    same = rd.loads((folder / "arm.sdf").read_text(), assets=assets)
    assert_allclose(same.mass_matrix(q), arm.mass_matrix(q), rtol=0, atol=0)
    with pytest.raises(rd.LoadError, match="no folder"):
        rd.loads((folder / "arm.sdf").read_text())


def test_usd_files_are_the_robots_they_were_made_from() -> None:
    """A converter wrote the binary file with single precision."""
    made = rd.load(ROBOTS.parent / "testdata" / "usd" / "two_r_urdf.usdc")
    own = rd.example("two_r")
    q = [0.3, -0.7]
    assert made.nv == own.nv
    assert_allclose(made.mass_matrix(q), own.mass_matrix(q), rtol=1e-5)
    with pytest.raises(rd.LoadError, match="USD"):
        rd.loads("#usda 1.0\n(")


def test_joints_without_inertia_are_named() -> None:
    text = (ROBOTS / "two_r.urdf").read_text()
    description = rd.loads(text).describe()
    for link in description["links"]:
        if link["name"] != "link1":
            link["mass_properties"] = None
    robot = rd.Robot.from_description(description)
    name = robot.massless_joints[0]
    q = np.zeros((3, 2))
    assert robot.inverse_dynamics(q, q, q).shape == (3, 2)
    for state in (q, q[0]):
        with pytest.raises(rd.SingularMassError, match=name):
            robot.forward_dynamics(state, state, state)
        with pytest.raises(rd.SingularMassError, match=name):
            robot.inverse_mass_matrix(state)


def test_random_configurations_repeat_and_keep_the_limits(robot: rd.Robot) -> None:
    q = robot.random_configuration((20, 3), seed=5)
    assert q.shape == (20, 3, robot.nq) and np.array_equal(q, robot.random_configuration((20, 3), seed=5))
    assert not np.array_equal(q, robot.random_configuration((20, 3), seed=6))
    assert robot.random_configuration(seed=5).shape == (robot.nq,)
    robot.gravity(q)  # valid configurations


def test_regressor_times_parameters_is_torque(robot: rd.Robot) -> None:
    s = states(robot)
    regressor = robot.joint_torque_regressor(s.q, s.v, s.a)
    names = robot.inertial_parameter_names
    assert regressor.shape == (*s.v.shape, len(names)) and len(names) == len(robot.inertial_parameters)
    if all(joint.passive.stiffness == joint.passive.armature == 0.0 for joint in robot.joints):
        tau = robot.inverse_dynamics(s.q, s.v, s.a)
        np.testing.assert_allclose(
            regressor @ robot.inertial_parameters, tau, rtol=0, atol=1e-12 * max(1.0, np.abs(tau).max())
        )


@pytest.mark.parametrize("format", ["urdf", "mjcf"])
def test_a_file_is_written_and_read_again(format: Literal["urdf", "mjcf"], tmp_path: Path) -> None:
    for name in ("panda", "dual_arm", "quadruped"):
        robot = rd.load(ROBOTS / f"{name}.urdf")
        path = tmp_path / f"{name}.{'urdf' if format == 'urdf' else 'xml'}"
        left_out = robot.write(path)
        assert path.read_text(encoding="utf-8") == robot.to_text(format, folder=tmp_path).text
        assert not [found for found in left_out if found.physics]
        back, q = rd.load(path), robot.random_configuration(seed=1)
        assert_allclose(back.mass_matrix(q), robot.mass_matrix(q), rtol=0, atol=1e-13)
    with pytest.raises(ValueError, match="must end in .urdf"):
        robot.write(tmp_path / "arm.txt")
    with pytest.raises(ValueError, match='must be "urdf" or "mjcf"'):
        robot.to_text("sdf")  # type: ignore[arg-type]


def test_no_file_that_was_read_is_written_over(panda: rd.Robot, tmp_path: Path) -> None:
    part, main, hard = tmp_path / "part.xml", tmp_path / "main.xml", tmp_path / "hard.xml"
    part.write_text("<mujocoinclude><body><joint axis='0 1 0'/><geom size='0.1' pos='1 0 0'/></body></mujocoinclude>")
    main.write_text("<mujoco model='arm'><worldbody><include file='part.xml'/></worldbody></mujoco>")
    robot = rd.load(main)
    assert {Path(file).name for file in robot.report.files} == {"main.xml", "part.xml"}
    hard.hardlink_to(part)
    (tmp_path / "arm.c").symlink_to(part)
    before = part.read_text(), main.read_text()
    # Robots derived from a robot have the same source files.
    for one in (robot, pickle.loads(pickle.dumps(robot)), robot.lock(robot.joints[0].name)):
        for path in (main, part, hard):
            with pytest.raises(ValueError, match="which the robot was read from"):
                one.write(path)
    with pytest.raises(ValueError, match="which the robot was read from"):
        robot.generate("c", ["gravity"], tmp_path)
    assert (part.read_text(), main.read_text()) == before
    assert not (tmp_path / "Makefile").exists()
    robot.write(tmp_path / "new.xml")
    panda.write(part)  # not a source file of the other robot
    assert sorted(path.name for path in tmp_path.iterdir()) == ["arm.c", "hard.xml", "main.xml", "new.xml", "part.xml"]


def test_each_character_of_unicode_is_seen_or_escaped() -> None:
    """The reference is Python's table of general categories.

    Characters that only one of the two versions of Unicode assigns are left out.
    """
    hidden = {"Cc", "Cf", "Zl", "Zp", "Co", "Zs"}
    for code in range(0x110000):
        if 0xD800 <= code < 0xE000 or (category := unicodedata.category(chr(code))) == "Cn":
            continue
        is_seen = _native._visible(f"a{chr(code)}b", False) == f"a{chr(code)}b"
        assert is_seen == (category not in hidden or code == 0x20), f"U+{code:04X} {category}"


def test_names_are_text_wherever_they_are_shown(tmp_path: Path) -> None:
    name = 'arm\x1b[2J\u202e\n<script>"&\x9b'
    description = rd.example("two_r").describe()
    description["name"] = name
    description["joints"][-1]["name"] = name
    robot = rd.Robot.from_description(description)
    assert robot.name == name
    shown = r"arm\u{1b}[2J\u{202e}\n&lt;script&gt;&quot;&amp;\u{9b}"
    html = robot._repr_html_() + robot.audit(states=1)._repr_html_()
    assert shown in html and "<script" not in html
    with pytest.raises(rd.FrameError) as caught:
        robot.frame_pose([0.0, 0.0], name)
    for text in (html, repr(robot), repr(robot.audit(states=1)), str(robot.report), str(caught.value)):
        assert not [letter for letter in text if letter != "\n" and unicodedata.category(letter) in {"Cc", "Cf"}], text
    (tmp_path / "arm.urdf").write_text(
        "<robot name='r'><link name='a'/><link name='b'><inertial><mass value='1'/></inertial></link><joint name='&#10;&#x202e;'"
        " type='continuous'><parent link='a'/><child link='b'/><dynamics stiff='1'/></joint></robot>"
    )
    with pytest.warns(rd.LoadWarning) as warned:
        robot = rd.load(tmp_path / "arm.urdf")
    for text in [str(one.message) for one in warned] + [str(robot.report)]:
        assert "\u202e" not in text, text


def test_code_is_generated(panda: rd.Robot, tmp_path: Path) -> None:
    files = panda.generate("rust", ["gravity", "frame_pose:panda_link8"], tmp_path / "panda", single=True, name="arm")
    assert "src/arm.rs" in files and "f32" in files["src/arm.rs"] and "f64" not in files["src/arm.rs"]
    assert (tmp_path / "panda" / "src" / "arm.rs").read_text(encoding="utf-8") == files["src/arm.rs"]
    assert files == panda.generate("rust", ["gravity", "frame_pose:panda_link8"], single=True, name="arm")
    assert "mod lanes" in panda.generate("rust", ["gravity"], lanes=True, name="arm")["src/arm.rs"]
    with pytest.raises(rd.GenerateError, match="lanes"):
        panda.generate("c", ["gravity"], lanes=True)
    with pytest.raises(rd.GenerateError, match="wisdom"):
        panda.generate("c", ["wisdom"])
    with pytest.raises(ValueError, match="must be one of rust, c"):
        panda.generate("cobol")  # type: ignore[arg-type]
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "Makefile").write_text("mine")
    with pytest.raises(rd.GenerateError, match="Makefile"):
        panda.generate("c", ["gravity"], tmp_path / "own")
    assert (tmp_path / "own" / "Makefile").read_text() == "mine"


def test_poses_and_actuators_of_a_file() -> None:
    arm = rd.load(ROBOTS / "arm.xml")
    assert arm.actuator_names and "home" in arm.poses
    q, v = arm.poses["home"]
    assert q.shape == (arm.nq,) and v.shape == (arm.nv,) and q.any()
    assert load("panda").poses == {} and load("panda").actuator_names == []


def test_random_robots_are_those_of_their_seeds() -> None:
    robot = rd.random_robot(7, joints=6, floating_base=True)
    assert robot == rd.random_robot(7, joints=6, floating_base=True) != rd.random_robot(8, joints=6, floating_base=True)
    assert robot.joints[0].kind == "floating" and rd.random_robot(7).joints[0].kind != "floating"
    assert pickle.loads(pickle.dumps(robot)) == robot


def test_assets_are_the_files_of_a_text() -> None:
    """The files of a text are read from memory, with includes in folders and a mesh that gives an inertia."""
    tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    text = """<mujoco><compiler meshdir="meshes"/><asset><mesh name="m" file="rock.obj"/></asset>
      <include file="parts/ball.xml"/>
      <worldbody><body name="rock"><freejoint/><geom type="mesh" mesh="m"/></body></worldbody></mujoco>"""
    ball = '<mujoco><worldbody><body name="ball"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'
    assets: dict[str, bytes | str] = {"parts/ball.xml": ball, "meshes/rock.obj": tetrahedron.encode()}
    robot = rd.loads(text, assets=assets)
    assert robot.nv == 12
    assert {link.name: link.mass for link in robot.links}["rock"] == pytest.approx(1000 / 6)
    assert pickle.loads(pickle.dumps(robot)) == robot
    with pytest.raises(rd.LoadError, match="not among the given files"):
        rd.loads(text, assets={"meshes/rock.obj": tetrahedron})
    for path in ("/rock.obj", "../rock.obj"):
        with pytest.raises(ValueError, match="relative to the text"):
            rd.loads(text, assets={**assets, path: b""})
