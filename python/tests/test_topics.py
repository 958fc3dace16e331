"""Constraints, control, planning, identification, checks, modified robots, plots."""

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import states


def test_constrained_accelerations_keep_the_constraint_and_the_equation(panda: rd.Robot) -> None:
    s = states(panda, 1)
    target = panda.frame_pose(s.q[0], "panda_link8")
    held = panda.constraints({"hand": rd.PointContact("panda_link8", target[:3, 3])})
    q, v = panda.project(held, s.q[0], s.v[0])
    rows = panda.constraint_rows(held, q, v)
    assert held.row_names == ["hand.x", "hand.y", "hand.z"] and len(held) == 3
    assert rows.velocity_drift < 1e-12 and rows.position_drift < 1e-12
    motion = panda.constrained_forward_dynamics(held, q, v, s.tau[0])
    assert_allclose(rows.matrix @ motion.acceleration, -rows.bias, rtol=0, atol=1e-9)
    pushed = s.tau[0] + rows.matrix.T @ motion.multipliers
    assert_allclose(panda.inverse_dynamics(q, v, motion.acceleration), pushed, rtol=0, atol=1e-8)
    back = panda.constrained_inverse_dynamics(held, q, v, motion.acceleration)
    assert_allclose(
        back.tau + rows.matrix.T @ back.multipliers, panda.inverse_dynamics(q, v, motion.acceleration), atol=1e-8
    )
    projection = panda.constraint_projections(held, q)
    assert_allclose(rows.matrix @ projection.velocity, 0.0, atol=1e-10)


def test_a_constrained_simulation_keeps_its_point(panda: rd.Robot) -> None:
    q = states(panda, 1).q[0]
    held = panda.constraints({"hand": rd.PointContact("panda_link8", panda.frame_pose(q, "panda_link8")[:3, 3])})
    motion = panda.simulate(q, duration=0.2, constraints=held, without=["limits"])
    places = panda.frame_pose(motion.q, "panda_link8")[:, :3, 3]
    assert_allclose(places, np.broadcast_to(places[0], places.shape), rtol=0, atol=1e-10)
    assert motion.position_drift is not None and motion.position_drift < 1e-10
    assert np.abs(motion.q[-1] - q).max() > 1e-2


def test_implicit_steps_hold_constraints(panda: rd.Robot) -> None:
    q = states(panda, 1).q[0]
    held = panda.constraints({"hand": rd.PointContact("panda_link8", panda.frame_pose(q, "panda_link8")[:3, 3])})
    explicit = panda.simulate(q, duration=0.1, constraints=held, without=["limits"])
    assert explicit.method == "rk4"
    motion = panda.simulate(q, duration=0.1, constraints=held, integrator="implicit", stops=False)
    places = panda.frame_pose(motion.q, "panda_link8")[:, :3, 3]
    assert_allclose(places, np.broadcast_to(places[0], places.shape), rtol=0, atol=1e-10)
    # Order 2: 1e-6 is h² times accelerations of a few rad/s².
    assert_allclose(motion.q[-1], explicit.q[-1], rtol=0, atol=1e-4)
    with pytest.raises(rd.SimulationError, match="off the constraint `hand"):
        panda.simulate(q + 0.01, duration=0.1, constraints=held, integrator="implicit")


def test_every_kind_of_constraint_is_made(panda: rd.Robot) -> None:
    made = panda.constraints(
        {
            "loop": rd.FrameConstraint("panda_link8", "panda_link0", rows=("x", "rz")),
            "floor": rd.Contact("panda_link8", np.eye(4), rows=("z",)),
            "blade": rd.NoSlip("panda_link8"),
            "wheel": rd.RollingDisc("panda_link8", [0.0, 0.0, 1.0], 0.1),
            "gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0}, offset=0.1),
        }
    )
    assert len(made) == 2 + 1 + 1 + 3 + 1
    assert panda.constraint_rows(made, np.zeros(7)).position_error[-1] == pytest.approx(-0.1)


def test_constraints_that_cannot_be_are_refused(panda: rd.Robot) -> None:
    with pytest.raises(rd.FrameError, match="`hand`: .*panda_link9"):
        panda.constraints({"hand": rd.PointContact("panda_link9", [0, 0, 0])})
    with pytest.raises(ValueError, match="rows are x, y, z"):
        panda.constraints({"hand": rd.NoSlip("panda_link8", rows=("q",))})
    with pytest.raises(rd.ConstraintError, match="panda_joint9"):
        panda.constraints({"gear": rd.Coupling({"panda_joint9": 1.0})})
    gear = panda.constraints({"gear": rd.Coupling({"panda_joint1": 1.0})})
    with pytest.raises(rd.ConstraintError, match="not of this"):
        rd.example("ur5").constraint_rows(gear, np.zeros(6))


def test_inverse_kinematics_finds_what_forward_kinematics_gave(panda: rd.Robot) -> None:
    for seed in range(5):
        wanted = panda.frame_pose(panda.random_configuration(seed=seed), "panda_link8")
        found = panda.inverse_kinematics("panda_link8", wanted)
        assert_allclose(panda.frame_pose(found.q, "panda_link8"), wanted, rtol=0, atol=1e-8)
        assert np.all((panda.limits.lower <= found.q) & (found.q <= panda.limits.upper))
        placed = panda.inverse_kinematics("panda_link8", wanted[:3, 3], found.q)
        assert placed.iterations <= 1 and placed.angle_error == 0.0
    with pytest.raises(rd.InverseKinematicsError):
        panda.inverse_kinematics("panda_link8", [5.0, 0.0, 0.0])
    with pytest.raises(rd.ShapeError, match=r"\(3,\), a position"):
        panda.inverse_kinematics("panda_link8", [5.0, 0.0])


def test_operational_space_accelerates_the_hand_as_asked(panda: rd.Robot) -> None:
    s = states(panda, 1)
    q, v = s.q[0], s.v[0]
    space = panda.operational_space(q, v, "panda_link8")
    wanted = np.array([0.3, -0.2, 0.1])
    tau = space.torque(wanted) + space.null_torque(s.tau[0])
    a = panda.forward_dynamics(q, v, tau)
    reached = panda.frame_acceleration(q, v, a, "panda_link8")[:3]
    assert_allclose(reached, wanted, rtol=0, atol=1e-9)


def test_the_regulator_brings_an_arm_upright() -> None:
    robot = rd.example("two_r")
    upright, rest = np.array([np.pi / 2, 0.0]), np.zeros(2)
    hold = robot.gravity(upright)
    A, B = robot.linearize_step(upright, rest, hold, dt=0.01)
    law = rd.dlqr(A, B, np.eye(4), 0.01 * np.eye(2))
    assert law.spectral_radius < 1.0
    assert_allclose(law.cost, np.eye(4) + A.T @ law.cost @ (A - B @ law.gain), rtol=1e-9)

    def control(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        away = np.concatenate([robot.difference(upright, q), v])
        u: np.ndarray = hold - law.gain @ away
        return u

    motion = robot.simulate(upright + 0.1, tau=control, duration=8.0, dt=0.01)
    assert np.abs(motion.q[-1] - upright).max() < 1e-3
    with pytest.raises(rd.ControlError):
        rd.dlqr(2 * np.eye(2), np.zeros((2, 1)), np.eye(2), np.eye(1))


def test_the_fastest_motion_keeps_the_limits() -> None:
    robot = rd.example("ur5")
    path = robot.time_optimal(robot.random_configuration(4, seed=2) * 0.2, intervals=400)
    assert 0.9 < path.largest_use < 1.05 and path.saturated > 0.9
    limits = robot.limits
    assert (np.abs(path.tau) <= 1.05 * limits.effort).all() and (np.abs(path.v) <= 1.05 * limits.velocity).all()
    assert_allclose(path.v[[0, -1]], 0.0, atol=1e-6)
    steps = np.diff(path.times)[:, np.newaxis] * 0.5 * (path.v[1:] + path.v[:-1])
    assert_allclose(path.q[0] + np.cumsum(steps, axis=0), path.q[1:], rtol=0, atol=1e-3)
    slower = robot.time_optimal(path.q[[0, 250, 500]], torque=limits.effort, velocity=0.5 * limits.velocity)
    assert slower.largest_use < 1.05


def test_the_fastest_motion_keeps_power_acceleration_and_the_weaker_side_of_a_torque() -> None:
    robot = rd.example("ur5")
    waypoints = robot.random_configuration(4, seed=2) * 0.2
    free = robot.time_optimal(waypoints)
    effort = robot.limits.effort
    path = robot.time_optimal(
        waypoints, acceleration=[5.0] * 6, power=[100.0] * 6, torque=effort, torque_lower=-0.7 * effort
    )
    assert path.duration > free.duration and path.largest_use < 1.01
    assert (np.abs(path.a) <= 1.01 * 5.0).all() and (np.abs(path.tau * path.v) <= 101.0).all()
    assert (path.tau >= -0.71 * effort).all()
    quantity, coordinate, s = path.tightest
    assert quantity in ("torque", "velocity", "acceleration", "power")
    assert coordinate in robot.coordinate_names and 0.0 <= s <= 1.0
    with pytest.raises(rd.PlanningError, match="power limit of coordinate"):
        robot.time_optimal(waypoints, power=[0.0] * 6)
    with pytest.raises(rd.ShapeError):
        robot.time_optimal(waypoints, acceleration=[1.0])


def test_a_path_with_quaternions_is_timed(tmp_path: Path) -> None:
    robot = rd.example("quadruped", floating_base=True)
    waypoints = robot.random_configuration(3, seed=5)
    waypoints[:, 7:] = 0.3 * waypoints[:, 7:] + np.tile([0.0, 0.5, -1.0], 4)
    free = np.full(robot.nv, np.inf)
    path = robot.time_optimal(waypoints, torque=free, velocity=[1.0] * robot.nv, acceleration=[4.0] * robot.nv)
    assert 0.9 < path.largest_use < 1.01 and np.abs(path.v).max() <= 1.01 and np.abs(path.a).max() <= 4.04
    assert_allclose(path.q[0], waypoints[0], rtol=0, atol=1e-12)
    assert_allclose(np.linalg.norm(path.q[:, 3:7], axis=1), 1.0, rtol=0, atol=1e-12)
    # The body velocity is the displacement between samples; its error is of second order in the period.
    period = path.times[1]
    for k in range(100, 400, 37):
        moved = robot.difference(path.q[k - 1], path.q[k + 1]) / (2.0 * period)
        assert_allclose(moved, path.v[k], rtol=0, atol=0.02)
    path.write(tmp_path / "motion.csv")
    assert (tmp_path / "motion.csv").read_text().startswith("time,q.floating_base.x,")
    with pytest.raises(rd.PlanningError, match="quaternions"):
        path.to_ros_json()


def test_a_timed_path_is_written_in_four_formats(tmp_path: Path) -> None:
    robot = rd.example("ur5")
    path = robot.time_optimal(robot.random_configuration(3, seed=4) * 0.2, samples=11)
    for ending in ("csv", "json", "yaml", "parquet"):
        path.write(tmp_path / f"motion.{ending}")
    rows = np.genfromtxt(tmp_path / "motion.csv", delimiter=",", names=True)
    assert len(rows) == 11 and rows.dtype.names is not None and rows.dtype.names[0] == "time"
    table = np.column_stack([path.times, path.q, path.v, path.a, path.tau])
    assert (np.array(rows.tolist()) == table).all()
    message = json.loads((tmp_path / "motion.json").read_text())
    assert message["joint_names"] == list(robot.coordinate_names)
    assert message["points"][5]["effort"] == path.tau[5].tolist()
    # Each point of the YAML is five lines with the numbers of the JSON.
    lines = (tmp_path / "motion.yaml").read_text().splitlines()
    assert len(lines) == 3 + 5 * 11
    assert json.loads(lines[3 + 5 * 5].removeprefix("- positions: ")) == message["points"][5]["positions"]
    pq = pytest.importorskip("pyarrow.parquet")
    read = pq.read_table(tmp_path / "motion.parquet")
    assert read.column_names == ["time", "q", "v", "a", "tau"]
    assert (np.array(read["tau"].to_pylist()) == path.tau).all()
    with pytest.raises(ValueError, match="is written to"):
        path.write(tmp_path / "motion.txt")


def test_an_online_motion_keeps_its_limits_and_follows_targets() -> None:
    robot = rd.example("ur5")
    motion = rd.OnlineMotion(robot, 0.002, acceleration=[5.0] * 6, jerk=[50.0] * 6, velocity=[1.0] * 6)
    motion.set_state(np.zeros(6), v=np.full(6, 0.5))
    target = np.linspace(-1.0, 1.0, 6)
    motion.set_target(target)
    duration, steps = motion.plan(), 0
    before = motion.a
    while not motion.step():
        steps += 1
        assert np.abs(motion.v).max() <= 1.0 + 1e-9 and np.abs(motion.a).max() <= 5.0 + 1e-9
        assert np.abs(motion.a - before).max() <= 50.0 * 0.002 + 1e-9 and np.abs(motion.jerk).max() <= 50.0 + 1e-9
        before = motion.a
    assert abs(steps * 0.002 - duration) < 0.004
    assert_allclose(motion.q, target, rtol=0, atol=1e-6)
    for step in range(1500):
        motion.follow_target(target + 0.002 * step * 0.2, v=np.full(6, 0.2))
        motion.step()
    assert_allclose(motion.q, target + 3.0 * 0.2, rtol=0, atol=1e-5)
    with pytest.raises(rd.PlanningError, match="velocity of coordinate `shoulder_pan`"):
        motion.set_target(target, v=[2.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    with pytest.raises(rd.PlanningError, match="period"):
        rd.OnlineMotion(robot, 0.0, acceleration=[5.0] * 6, jerk=[50.0] * 6)


def test_parameters_are_found_from_motion(panda: rd.Robot) -> None:
    s = states(panda, 300)
    base = panda.base_parameters()
    tau = panda.inverse_dynamics(s.q, s.v, s.a)
    found = panda.identify(s.q, s.v, s.a, tau, base)
    true = base.values(panda.inertial_parameters)
    assert_allclose(found.values, true, rtol=0, atol=1e-9) and found.residual < 1e-10
    assert_allclose(base.combinations @ panda.inertial_parameters, true, rtol=0, atol=1e-12)
    wrong = panda.inertial_parameters * 1.1
    near = base.nearest_parameters(found.values, wrong)
    assert_allclose(base.values(near), true, rtol=0, atol=1e-9)
    assert len(base.names) == len(base) == len(true)
    with pytest.raises(rd.ShapeError):
        base.values(np.zeros(3))
    with pytest.raises(rd.ShapeError):
        panda.identify(s.q, s.v[:5], s.a, tau)
    with pytest.raises(rd.IdentificationError, match="another robot"):
        other = rd.example("ur5")
        t = states(other, 3)
        other.identify(t.q, t.v, t.a, t.tau, base)


def test_an_audit_is_a_table_and_a_verdict(robot: rd.Robot) -> None:
    audit = robot.audit(states=4)
    assert audit, str(audit)
    assert "Nothing falls short." in repr(audit) and "<table " in audit._repr_html_()
    assert robot.suspicions() == ()


def test_a_payload_weighs_what_it_weighs(panda: rd.Robot) -> None:
    s = states(panda, 5)
    loaded = panda.with_payload("panda_link8", 1.5, [0.0, 0.0, 0.1], np.diag([0.01, 0.01, 0.02]))
    jacobian = panda.frame_jacobian(s.q, "panda_link8", "local")
    up = panda.frame_pose(s.q, "panda_link8")[:, 2, :3]
    force = 1.5 * 9.81 * up  # the load on the arm, along the link's axes
    wrench = np.concatenate([force, np.cross([0.0, 0.0, 0.1], force)], axis=1)
    extra = np.einsum("nij,ni->nj", jacobian, wrench)
    assert_allclose(loaded.gravity(s.q) - panda.gravity(s.q), extra, rtol=0, atol=1e-11)
    assert loaded != panda and loaded.report == panda.report
    with pytest.raises(rd.DescriptionError, match="panda_link9"):
        panda.with_payload("panda_link9", 1.0)
    with pytest.raises(rd.DescriptionError):
        panda.with_payload("panda_link8", -1.0)


def test_a_locked_robot_is_part_of_the_whole(panda: rd.Robot) -> None:
    part = panda.lock("panda_joint3", at={"panda_joint6": 1.0})
    assert part.nv == 5
    reference = panda.neutral()
    reference[5] = 1.0
    joints = rd.JointMap(panda, part, reference)
    assert joints.locked_joints == ["panda_joint3", "panda_joint6"] and joints.v_indices == [0, 1, 3, 4, 6]
    q = part.random_configuration(seed=1)
    whole = joints.expand_configuration(q)
    assert whole[5] == 1.0 and np.array_equal(joints.restrict_configuration(whole), q)
    picked = joints.v_indices
    assert_allclose(part.mass_matrix(q), panda.mass_matrix(whole)[np.ix_(picked, picked)], rtol=0, atol=1e-12)
    with pytest.raises(rd.DescriptionError, match="panda_joint9"):
        panda.lock("panda_joint9")


def test_pictures(panda: rd.Robot) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    from matplotlib import pyplot

    axes = panda.simulate(np.zeros(7), duration=0.1).plot()
    assert [axis.get_ylabel() for axis in axes] == ["q [rad or m]", "v [rad/s or m/s]", "τ [N·m or N]", "energy [J]"]
    drawn = axes[0].get_lines()[:7]
    assert [line.get_label() for line in drawn] == list(panda.coordinate_names)
    assert [text.get_text() for text in axes[0].get_legend().get_texts()] == list(panda.coordinate_names)
    motion = panda.simulate([0, 0, 0, -0.3, 0, 0, 0], [0, 0, 0, 2.0, 0, 0, 0], duration=0.3)
    near = [line for line in motion.plot()[0].get_lines()[7:] if line.get_color() == "C3"]
    assert panda.limits.upper[3] in [line.get_ydata()[0] for line in near]  # at its limit
    dog = rd.example("quadruped", floating_base=True).simulate([0, 0, 1, 0, 0, 0, 1, *[0, 0.7, -1.6] * 4], duration=0.01)
    assert dog.configuration_names[:8] == (*(f"floating_base.{part}" for part in "x y z qx qy qz qw".split()), "front_left_abduction")
    assert dog.plot()[0].get_legend().get_title().get_text() == "the first 11 of 19"
    path = rd.example("ur5").time_optimal(np.eye(6)[:3])
    assert len(path.plot()) == 2
    with pytest.raises(ValueError, match="needs 2"):
        path.plot(axes)
    pyplot.close("all")


def test_pictures_say_what_they_need(panda: rd.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    monkeypatch.setitem(__import__("sys").modules, "meshcat", None)
    with pytest.raises(ImportError, match=r"robot-dynamics\[plot\]"):
        panda.simulate(np.zeros(7), duration=0.01).plot()
    with pytest.raises(ImportError, match=r"robot-dynamics\[view\]"):
        panda.show()


def test_html_has_the_tree_and_escapes_names() -> None:
    robot = rd.loads('<robot name="a &lt;b&gt;"><link name="world"/></robot>')
    assert "a &lt;b&gt;" in robot._repr_html_()
    text = rd.example("quadruped", floating_base=True)._repr_html_()
    assert text.count("<tr>") == 1 + len(rd.example("quadruped", floating_base=True).joints)


def test_boxes_have_the_moments_of_the_links(panda: rd.Robot) -> None:
    from robot_dynamics.viewer import inertia_boxes

    links = {link["name"]: link["mass_properties"] for link in panda.describe()["links"]}
    found = inertia_boxes(panda)
    assert set(found) == {name for name, body in links.items() if body}
    for name, (pose, edges) in found.items():
        body = links[name]
        squares = edges**2
        moments = body["mass"] / 12 * (squares.sum() - squares)
        xx, xy, xz, yy, yz, zz = body["inertia"]
        full = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        assert_allclose(pose[:3, :3] @ np.diag(moments) @ pose[:3, :3].T, full, rtol=0, atol=2e-2 * np.abs(full).max())
        assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)


def test_meshes_are_drawn_where_they_are_found(tmp_path: Path) -> None:
    pytest.importorskip("meshcat.geometry")
    from robot_dynamics.viewer import drawn_shapes

    corners = ("0 0 0", "1 0 0", "0 1 0")
    (tmp_path / "plate.stl").write_text(
        "solid plate\nfacet normal 0 0 1\nouter loop\n" + "".join(f"vertex {at}\n" for at in corners) + "endloop\nendfacet\nendsolid\n"
    )
    body = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>"
    shape = "<origin xyz='0 0 0.5' rpy='0 0 1.5707963267948966'/><geometry>{}</geometry>"
    mesh = shape.format("<mesh filename='{}' scale='2 3 4'/>")
    rod = shape.format("<capsule radius='0.1' length='0.6'/>")
    (tmp_path / "arm.urdf").write_text(
        f"<robot name='arm'><link name='base'/><link name='a'>{body}<visual>{mesh.format('plate.stl')}</visual></link>"
        f"<link name='b'>{body}<visual>{mesh.format('gone.stl')}</visual></link><link name='c'>{body}<collision>{rod}</collision></link>"
        + "".join(f"<joint name='j{x}' type='continuous'><parent link='base'/><child link='{x}'/></joint>" for x in "abc")
        + "</robot>"
    )
    with pytest.warns(UserWarning, match=r"robot `arm`: 1 mesh cannot be drawn: 'gone.stl'"):
        things = drawn_shapes(rd.load(tmp_path / "arm.urdf"))
    assert [(thing.link, type(thing.geometry).__name__) for thing in things] == [
        ("a", "MeshGeometry"), ("c", "Cylinder"), ("c", "Sphere"), ("c", "Sphere"), ("b", "Box"),
    ]  # fmt: skip
    # Rotated by 90 degrees about z, half a metre up, with the size in the file.
    assert_allclose(things[0].link_from_shape @ [1.0, 1.0, 1.0, 1.0], [-3.0, 2.0, 4.5, 1.0], atol=1e-12)
    # The cylinder of meshcat is along y: its ends are the ends of the capsule's cylinder.
    assert_allclose(things[1].link_from_shape @ [0.0, 0.3, 0.0, 1.0], [0.0, 0.0, 0.8, 1.0], atol=1e-12)
    assert_allclose([thing.link_from_shape[2, 3] for thing in things[2:4]], [0.2, 0.8])
    # A robot without shapes is drawn by its inertias.
    assert {type(thing.geometry).__name__ for thing in drawn_shapes(rd.example("panda"))} == {"Box"}
