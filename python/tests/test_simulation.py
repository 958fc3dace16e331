"""`Simulation`, step by step: against one run, and against closed forms."""

import pickle
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import load, states

LINKAGE = """<mujoco model="linkage"><worldbody><geom name="floor" type="plane" size="5 5 1"/>
  <body name="crank" pos="0 0 1"><joint name="crank" axis="0 1 0" damping="0.05"/>
    <geom name="bar" type="capsule" size="0.02" fromto="0 0 0 0.4 0 0" mass="1" contype="0" conaffinity="0"/>
    <site name="tip" pos="0.4 0 0"/>
    <body name="rod" pos="0.4 0 0"><joint name="rod" axis="0 1 0" damping="0.05"/>
      <geom type="capsule" size="0.02" fromto="0 0 0 0.6 0 0" mass="1" contype="0" conaffinity="0"/></body></body>
  <body name="rocker" pos="1 0 1"><joint name="rocker" axis="0 1 0" damping="0.05"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.3" mass="0.5" contype="0" conaffinity="0"/></body>
  <body name="ball" pos="0 1 0.3"><freejoint/><geom name="ball" type="sphere" size="0.1" mass="1"/></body></worldbody>
  <tendon><fixed name="band" stiffness="3"><joint joint="crank" coef="1"/></fixed></tendon>
  <equality><connect name="pin" body1="rod" body2="rocker" anchor="0.6 0 0"/></equality>
  <actuator><motor name="motor" joint="crank" gear="2"/></actuator></mujoco>"""
"""A closed loop with a spring and a motor, beside a ball that falls on a plane."""

BALL = """<mujoco><worldbody><geom name="floor" type="plane" size="5 5 1"/><body name="ball" pos="0 0 0.3"><freejoint/>
  <geom name="shell" type="sphere" size="0.1" mass="2" friction="0.5"/></body></worldbody>
  <keyframe><key name="high" qpos="0 0 1 1 0 0 0" qvel="1 0 0 0 0 0"/></keyframe></mujoco>"""


def moved(sim: rd.Simulation, steps: int) -> tuple[Any, Any]:
    """States after each step."""
    rows = []
    for _ in range(steps):
        sim.step()
        rows.append((sim.q, sim.v))
    q, v = zip(*rows, strict=True)
    return np.array(q), np.array(v)


def robots() -> list[tuple[rd.Robot, dict[str, float] | None]]:
    return [(load("panda"), None), (load("quadruped"), None), (load("dual_arm"), None), (rd.loads(LINKAGE), {"motor": 0.4})]


@pytest.mark.parametrize("integrator", [None, "rk4", "implicit", "mujoco"])
def test_steps_from_outside_are_the_bits_of_one_run(integrator: str | None) -> None:
    for robot, controls in robots():
        if integrator == "rk4" and controls is not None:
            controls = None  # explicit methods with equalities leave out actuators
        start, tau = robot.neutral(), np.full(robot.nv, 0.5)
        sim = rd.Simulation(robot, integrator=integrator)
        sim.reset(start, controls=controls)
        run = robot.simulate(start, tau=tau, duration=0.05, integrator=integrator, controls=controls)
        sim.torques = tau
        q, v = moved(sim, 50)
        assert np.array_equal(q, run.q[1:]) and np.array_equal(v, run.v[1:]), (robot.name, integrator)
        assert (sim.method, sim.left_out, sim.steps) == (run.method, run.left_out, run.steps)
        assert repr(sim.energy_account) == repr(run.energy_account) and sim.time == run.times[-1]
        together = rd.Simulation(robot, integrator=integrator)
        together.reset(start, controls=controls)
        together.torques = tau
        together.run_for(0.05)
        assert np.array_equal(together.q, sim.q)


@pytest.mark.parametrize("integrator", ["rk4", "implicit", "mujoco"])
def test_snapshots_and_copies_go_on_with_the_same_bits(integrator: str) -> None:
    robot = rd.loads(LINKAGE)
    sim = rd.Simulation(robot, integrator=integrator)
    sim.apply_wrench("ball", force=(0.1, 0.0, 0.0))
    sim.step(30)
    kept, twin = sim.snapshot(), sim.copy()
    ahead = moved(sim, 20)
    account = sim.energy_account
    assert all(np.array_equal(*pair) for pair in zip(moved(twin, 20), ahead, strict=True))
    sim.clear_wrenches()
    sim.step(7)
    sim.restore(kept)
    assert sim.steps == 30
    assert all(np.array_equal(*pair) for pair in zip(moved(sim, 20), ahead, strict=True)) and repr(sim.energy_account) == repr(account)
    assert type(twin) is rd.Simulation and twin.robot is robot
    with pytest.raises(ValueError, match="of another simulation"):
        rd.Simulation(load("two_r")).restore(kept)


@pytest.mark.parametrize("axes", ["local", "world", "local_world_aligned"])
def test_wrenches_are_the_transposed_jacobian(axes: Any) -> None:
    robot, h = load("panda"), 1e-6
    q, push = states(robot, 1).q[0], np.array([3.0, -2.0, 5.0, 0.5, 0.3, -0.4])  # force, moment
    sim = rd.Simulation(robot, dt=h, conservative=True, integrator="semi-implicit-euler")
    sim.reset(q)
    sim.apply_wrench("panda_link8", push[:3], push[3:], axes)  # type: ignore[arg-type]
    sim.step()
    # The world's axes at the frame's origin, from the pose and its differences.
    pose = robot.frame_pose(q, "panda_link8")
    turn = pose[:3, :3] if axes == "local" else np.eye(3)
    force, moment = turn @ push[:3], turn @ push[3:]
    if axes == "world":
        moment = moment + np.cross(force, pose[:3, 3])
    jacobian, d = np.zeros((6, 7)), 1e-6
    for j in range(7):
        ahead, behind = (robot.frame_pose(q + side * d * np.eye(7)[j], "panda_link8") for side in (1, -1))
        jacobian[:3, j] = (ahead - behind)[:3, 3] / (2 * d)
        spin = (ahead - behind)[:3, :3] @ pose[:3, :3].T / (2 * d)
        jacobian[3:, j] = spin[2, 1], spin[0, 2], spin[1, 0]
    expected = robot.forward_dynamics(q, np.zeros(7), jacobian.T @ np.concatenate([force, moment]))
    # The error of differences is d² plus rounding over d, about 1e-10, times 1/M of about 100. The step moves
    # nothing by more than h.
    assert_allclose(sim.v / h, expected, rtol=1e-6, atol=1e-6)
    sim.reset(q)
    sim.step()
    assert_allclose(sim.v / h, robot.forward_dynamics(q, np.zeros(7), np.zeros(7)), rtol=1e-9, atol=1e-9)


def test_torques_are_cut_off_at_effort_limits_and_counted() -> None:
    robot = load("two_r")
    limits = robot.limits.effort
    sim = rd.Simulation(robot)
    sim.torques = [2.0 * limits[0], -0.5 * limits[1]]
    sim.step(3)
    assert_allclose(sim.applied_torques, [limits[0], -0.5 * limits[1]])
    sim.torques = [0.0, -3.0 * limits[1]]
    sim.step(2)
    assert sim.steps_at_effort_limits == [3, 2]
    free = rd.Simulation(robot, without=["effort-limits"])
    free.torques = [2.0 * limits[0], 0.0]
    free.step()
    assert free.applied_torques[0] == 2.0 * limits[0] and free.steps_at_effort_limits == [0, 0]


def test_contacts_name_what_touches_and_bear_the_weight() -> None:
    sim = rd.Simulation(rd.loads(BALL))
    assert sim.contacts == [] and sim.center_of_pressure is None
    sim.run_for(2.0)  # the landing decays with a time constant of 0.1 s
    (contact,) = sim.contacts
    assert (contact.link, contact.shape, contact.other_link, contact.other_shape) == ("ball", "shell", None, "floor")
    assert contact.ground == 0
    assert_allclose(contact.normal, [0, 0, 1], atol=1e-12)
    assert abs(contact.gap) < 1e-7
    assert_allclose(contact.point, [0, 0, 0], atol=1e-5)
    assert_allclose(contact.force, [0, 0, 2 * 9.81], atol=1e-9)
    assert_allclose(contact.moment, 0, atol=1e-9)
    center = sim.center_of_pressure
    assert center is not None
    assert_allclose(center, [0, 0, 0], atol=1e-5)


@pytest.mark.parametrize("integrator", ["mujoco", "implicit"])
def test_forces_of_the_ground_are_the_change_of_momentum(integrator: str) -> None:
    robot, h, steps = rd.loads(BALL), 1e-3, 1000
    sim = rd.Simulation(robot, dt=h, integrator=integrator)
    sim.reset(np.array([0, 0, 0.3, 0, 0, 0, 1.0]), np.array([0.4, 0, 0, 0, 0, 0]))
    begun = robot.center_of_mass_velocity(sim.q, sim.v)
    impulse = np.zeros(3)
    for _ in range(steps):
        sim.step()
        impulse += h * sum((contact.force for contact in sim.contacts), np.zeros(3))
    change = 2.0 * (robot.center_of_mass_velocity(sim.q, sim.v) - begun)
    assert_allclose(impulse, change + [0, 0, 2.0 * 9.81 * steps * h], rtol=0, atol=1e-9)
    assert impulse[0] < -0.01  # friction reverses it


def test_balls_lie_on_fixed_geometry_and_on_each_other() -> None:
    text = """<mujoco><worldbody><geom name="table" type="box" size=".5 .5 .05" pos="0 0 .45"/><body name="lower" pos="0 0 .7">
        <joint type="slide" axis="0 0 1"/><geom name="low" type="sphere" size=".1" mass="1"/></body><body name="upper" pos="0 0 1">
        <joint type="slide" axis="0 0 1"/><geom name="up" type="sphere" size=".1" mass="3"/></body></worldbody></mujoco>"""
    robot = rd.loads(text)
    sim = rd.Simulation(robot)
    sim.run_for(2.0)  # the landing decays with a time constant of 0.1 s
    assert_allclose(sim.q + [0.7, 1.0], [0.6, 0.8], atol=1e-8)
    forces = {(contact.shape, contact.other_shape): abs(contact.force[2]) for contact in sim.contacts}
    assert sorted(forces.values()) == pytest.approx([3 * 9.81, 4 * 9.81], abs=1e-6)
    assert {frozenset(pair) for pair in forces} == {frozenset(("low", "table")), frozenset(("low", "up"))}
    assert np.array_equal(robot.simulate([0.0, 0.0], duration=2.0).q[-1], sim.q)
    below = robot.simulate([0.0, 0.0], duration=0.5, without=["link-contacts"], sample_period="ends")
    assert below.q[-1, 0] < -0.5  # without support


def test_a_reset_starts_anew() -> None:
    robot = rd.loads(BALL)
    sim = rd.Simulation(robot)
    sim.apply_wrench("ball", (5.0, 0.0, 0.0))
    sim.step(10)
    sim.reset(pose="high")
    assert (sim.time, sim.steps) == (0.0, 0)
    assert_allclose(sim.q, [0, 0, 1, 0, 0, 0, 1])
    assert_allclose(sim.v, [1, 0, 0, 0, 0, 0])
    sim.step()
    assert sim.v[0] == 1.0  # the wrench was cleared
    sim.set_state(robot.neutral(), np.zeros(6))
    assert sim.time == 1e-3 and np.array_equal(sim.q, robot.neutral())
    with pytest.raises(ValueError, match="give q and v, or the name of a pose"):
        sim.reset(robot.neutral(), pose="high")
    with pytest.raises(rd.SimulationError, match="low"):
        sim.reset(pose="low")


def test_a_loop_holds_and_its_forces_have_names() -> None:
    robot = rd.loads(LINKAGE)
    run = robot.simulate(robot.neutral(), duration=0.5, sample_period="ends")
    assert run.position_drift is None or run.position_drift < 1e-8
    sim = rd.Simulation(robot)
    sim.run_for(0.5)
    assert sim.method == "implicit" and "equalities" in sim.reason
    assert sim.control_names == ("motor",) and all(name.startswith("pin") for name in sim.constraint_forces)
    assert len(sim.constraint_forces) > 0


def test_wrong_inputs_are_named() -> None:
    robot = load("panda")
    for name in ("semi-implicit-euler", "rk4", "implicit", "mujoco", "adaptive"):
        with pytest.raises(rd.SimulationError, match=f"no integrator \"rk5\".*{name}"):
            rd.Simulation(robot, integrator="rk5")
    with pytest.raises(ValueError, match="tolerance goes with integrator='adaptive'"):
        rd.Simulation(robot, tolerance=1e-6)
    with pytest.raises(ValueError, match="no effect `wind` to switch off; there are dissipation, limits"):
        rd.Simulation(robot, without=["wind"])
    with pytest.raises(TypeError, match="give a list of names"):
        rd.Simulation(robot, without="limits")
    sim = rd.Simulation(robot)
    with pytest.raises(rd.ShapeError, match="torques"):
        sim.torques = np.zeros(6)
    with pytest.raises((ValueError, rd.SimulationError), match="(?i)nan|finite"):
        sim.torques = np.full(7, np.nan)
        sim.step()
    with pytest.raises(rd.FrameError, match="nose"):
        sim.apply_wrench("nose")
    with pytest.raises(ValueError, match="axes must be 'local', 'world' or 'local_world_aligned'"):
        sim.apply_wrench("panda_link8", axes="body")  # type: ignore[arg-type]
    arm = rd.Simulation(rd.loads(LINKAGE))
    with pytest.raises(ValueError, match='no actuator "servo"; it has motor'):
        arm.controls = {"servo": 1.0}
    arm.controls = {"motor": 0.3}
    assert np.array_equal(np.asarray(arm.controls), [0.3])


def test_simulations_of_a_batch_are_single_ones() -> None:
    robot = rd.loads(BALL)
    batch = rd.SimulationBatch(robot, 3, threads=2)
    placed = batch.q
    batch.reset()
    assert (batch.q == placed).all() and (placed == rd.Simulation(robot).q).all() and placed[0, 2] == 0.3
    q = np.tile(robot.neutral(), (3, 1))
    q[:, 2] += [0.0, 0.05, 0.1]
    v = np.zeros((3, robot.nv))
    v[:, 0] = [0.0, 1.0, 2.0]
    batch.reset(q, v)
    batch.torques = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    for _ in range(5):
        batch.step(60)
    for k in range(3):
        single = rd.Simulation(robot)
        single.reset(q[k], v[k])
        single.torques = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        single.step(300)
        assert (batch.q[k] == single.q).all() and (batch.v[k] == single.v).all()
    assert len(batch) == 3 and len(batch[2].contacts) == len(single.contacts)
    batch.reset(q[1], where=[1])
    assert batch.times == pytest.approx([0.3, 0.0, 0.3]) and (batch.q[1] == q[1]).all()
    copy = batch[0]
    copy.step()
    assert batch.times[0] == pytest.approx(0.3)  # a copy is independent
    with pytest.raises(IndexError, match="the batch has 3"):
        batch.reset(q[0], where=[3])
    with pytest.raises(rd.ShapeError, match=r"\(3, 6\) or \(6,\)"):
        batch.torques = np.zeros((2, 6))


def test_simulations_of_a_batch_that_fail_leave_the_others_alone() -> None:
    arm = rd.example("two_r")
    batch, single = rd.SimulationBatch(arm, 21, threads=2), rd.Simulation(arm)
    q = arm.random_configuration(21, seed=4)
    batch.reset(q)
    torques = np.zeros((21, 2))
    torques[[3, 17], 1] = [np.nan, np.inf]
    batch.torques = torques
    with pytest.raises(rd.BadSimulationsError, match=r"2 of 21 simulations cannot go on, the first is simulation 3: t = 0 s \(step 0\): torque\[1\] \(coordinate `elbow`\) is NaN") as raised:
        batch.step(30)
    assert list(raised.value.errors) == [3, 17] and isinstance(raised.value, rd.SimulationError)
    again = pickle.loads(pickle.dumps(raised.value))
    assert again.errors == raised.value.errors and str(again) == str(raised.value)
    assert [round(time, 12) for time in batch.times] == [0.0 if k in (3, 17) else 0.03 for k in range(21)]
    # Some rows, by numbers and by a mask.
    batch.torques = np.zeros(2)
    where = np.arange(21) % 2 == 0
    batch.step(5, where=where)
    batch.step(where=[3])
    steps = [30 * (k not in (3, 17)) + 5 * (k % 2 == 0) + (k == 3) for k in range(21)]
    assert [round(1000 * time) for time in batch.times] == steps
    for k in (0, 1, 3, 20):
        single.reset(q[k])
        single.step(steps[k])
        assert (batch.q[k] == single.q).all() and (batch.v[k] == single.v).all()
    with pytest.raises(rd.ShapeError, match=r"where has shape \(2,\), truth values must have \(21,\)"):
        batch.step(where=[True, False])
    for numbers in ([0.5], [[0], [1]]):
        with pytest.raises(TypeError, match="it must be a sequence of simulations' numbers"):
            batch.step(where=numbers)  # type: ignore[arg-type]


def test_states_of_a_batch_are_set_row_by_row() -> None:
    arm = rd.example("two_r")
    batch = rd.SimulationBatch(arm, 4)
    batch.torques = [0.1, 0.0]
    batch.step(10)
    before = batch.q
    with pytest.raises(rd.BadSimulationsError, match="1 of 4 simulations cannot go on from there, the first is simulation 2") as raised:
        batch.set_state([[0.5, 0.5], [0.0, np.nan]], np.zeros(2), where=[1, 2])
    assert list(raised.value.errors) == [2]
    assert (batch.q == [before[0], [0.5, 0.5], before[2], before[3]]).all()
    assert batch.times == pytest.approx([0.01] * 4) and (batch.torques == [0.1, 0.0]).all()
    with pytest.raises(rd.BadSimulationsError, match="cannot start there"):
        batch.reset([np.inf, 0.0], where=[0])
    batch.reset(where=[False, True, False, False])
    assert batch.times == pytest.approx([0.01, 0.0, 0.01, 0.01]) and not batch.torques[1].any()
    assert batch.control_names == () and batch.robot is arm


def test_rollouts_keep_their_set_up_and_not_their_inputs() -> None:
    robot = rd.loads(LINKAGE)
    q = robot.neutral()[np.newaxis]
    first = robot.rollout(q, steps=20, controls={"motor": 1.0})
    without = robot.rollout(q, steps=20)
    again = robot.rollout(q, steps=20, controls={"motor": 1.0})
    assert (first.q == again.q).all() and (first.v != without.v).any()
    free = robot.rollout(q, steps=20, without=["contacts", "actuators"])
    assert (free.v == robot.rollout(q, steps=20, without=["contacts", "actuators"]).v).all()


def test_pairs_of_links_that_never_touch(tmp_path: Any) -> None:
    def ball(name: str, z: float) -> str:
        joint = f'<joint name="{name}" type="slide" axis="0 0 1"/>'
        return f'<body name="{name}" pos="0 0 {z}">{joint}<geom size="0.1"/></body>'

    robot = rd.loads(
        f'<mujoco><worldbody><geom type="plane" size="0 0 1"/>{ball("low", 0.1)}{ball("high", 0.35)}</worldbody></mujoco>'
    )
    srdf = tmp_path / "pairs.srdf"
    srdf.write_text('<robot name="r"><disable_collisions link1="high" link2="low"/></robot>')
    cases: list[tuple[Any, float]] = [((), -0.05), ([("low", "high")], -0.25), (srdf, -0.25)]
    for pairs, end in cases:
        sim = rd.Simulation(robot, ignore_contacts=pairs)
        sim.run_for(1.0)
        assert_allclose(sim.q, [0.0, end], atol=1e-3)
    only = rd.Simulation(robot, only_contacts=[])
    only.run_for(1.0)
    assert_allclose(only.q, [0.0, -0.25], atol=1e-3)
    with pytest.raises(ValueError, match="did you mean `high`"):
        rd.Simulation(robot, ignore_contacts=[("low", "hig")])
    srdf.write_text("<mujoco/>")
    with pytest.raises(ValueError, match="not an SRDF file"):
        rd.Simulation(robot, ignore_contacts=srdf)


def test_report_tells_sensors_and_what_a_simulation_leaves_out() -> None:
    eggs = "".join(
        f'<body name="{name}" pos="{x} 0 1"><freejoint/><site name="{name}"/><geom type="ellipsoid" size="0.1 0.2 0.3"/></body>'
        for x, name in enumerate("abcd")
    )
    text = f'<mujoco><worldbody>{eggs}</worldbody><sensor><gyro name="turn" site="a"/></sensor></mujoco>'
    report = rd.loads(text).report
    assert report.sensors == (("turn", "gyro"),)
    assert len(report.left_out) == 1 and "and 4 more" in report.left_out[0]
    assert "sensor turn: gyro" in str(report) and report.left_out[0] in str(report)
def test_adaptive_steps_from_outside_are_those_of_a_run_to_their_tolerance() -> None:
    robot = load("panda")
    q = np.full(7, 0.1)
    sim = rd.Simulation(robot, integrator="adaptive", tolerance=1e-12, dt=0.05)
    sim.reset(q)
    sim.step(10)
    run = robot.simulate(q, duration=0.5, dt=0.05, integrator="adaptive", tolerance=1e-12)
    # About ten steps, each with an error of at most 1e-12, in a motion that amplifies errors less than a
    # hundredfold.
    assert sim.method == "adaptive" and np.abs(sim.q - run.q[-1]).max() < 1e-9
    assert sim.energy_account.drift < 1e-10
    kept = sim.snapshot()
    sim.step()
    once = sim.q
    sim.restore(kept)
    sim.step()
    assert np.array_equal(sim.q, once)


def test_a_fluid_is_part_of_a_simulation() -> None:
    """A ball in a viscous fluid slows down by the drag of the inertia box: v = v₀ e^(−3πβd t/m)."""
    text = """<mujoco><option gravity="0 0 0" viscosity="0.3"/><worldbody><body name="ball"><freejoint/>
      <geom type="sphere" size="0.1" mass="2"/></body></worldbody></mujoco>"""
    robot = rd.loads(text)
    edge = np.sqrt(6 * 0.4 * 0.1**2)
    v = np.array([1.0, 0, 0, 0, 0, 0])
    assert_allclose(robot.fluid_forces(robot.neutral(), v)[0], -3 * np.pi * 0.3 * edge, rtol=1e-14)
    by_q, by_v = robot.fluid_force_derivatives(robot.neutral(), v)
    assert_allclose(by_v @ v, robot.fluid_forces(robot.neutral(), v), atol=1e-15)
    assert not by_q.any()
    expected = np.exp(-3 * np.pi * 0.3 * edge / 2 * 0.5)
    for integrator in ("rk4", "implicit"):
        motion = robot.simulate(robot.neutral(), v=v, duration=0.5, dt=1e-3, integrator=integrator)
        assert_allclose(motion.v[-1][0], expected, rtol=1e-6)
    free = robot.simulate(robot.neutral(), v=v, duration=0.5, dt=1e-3, without=["dissipation"])
    assert_allclose(free.v[-1][0], 1.0, rtol=1e-14)
    assert_allclose(robot.with_fluid(0.0, 0.0).fluid_forces(robot.neutral(), v), 0.0)
