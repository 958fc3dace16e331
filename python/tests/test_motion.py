"""Simulations, rollouts and steps, against each other, their energy accounts, and closed forms."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import interrupted, states


def pendulum(length: float = 0.5) -> rd.Robot:
    """A point mass on a rod, horizontal at q = 0 and hanging at −π/2."""
    return rd.loads(
        f"""<robot name="pendulum"><link name="world"/><link name="bob"><inertial><origin xyz="{length} 0 0"/>
        <mass value="2"/><inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="hinge" type="revolute"><parent link="world"/><child link="bob"/><axis xyz="0 -1 0"/>
        <limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>"""
    )


PENDULUM = """<robot name="pendulum"><link name="stand"/><link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
<inertia ixx="0.0833" iyy="0.0833" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="stand"/><child link="rod"/><axis xyz="0 1 0"/><dynamics damping="300"/></joint></robot>"""


def test_a_pendulum_swings_with_its_period() -> None:
    robot = pendulum()
    crossing = rd.Event("lowest", lambda t, q, v: float(q[0] + np.pi / 2), direction="rising")
    amplitude = 0.01
    motion = robot.simulate([-np.pi / 2 - amplitude], duration=5.0, dt=1e-3, events=[crossing], without=["limits"])
    assert motion.method == "rk4"
    period = 2 * np.pi * np.sqrt(0.5 / 9.81 * (1 + 1e-6 / (2 * 0.25))) * (1 + amplitude**2 / 16)
    times = [event.time for event in motion.events]
    assert len(times) == 4 and all(event.rising for event in motion.events)
    assert_allclose(np.diff(times), period, rtol=1e-7)


def test_the_books_balance_and_samples_are_the_motion(robot: rd.Robot) -> None:
    s = states(robot, 1)
    how: dict[str, Any] = {"duration": 0.005, "dt": 1e-4, "sample_period": 1e-3}
    motion = robot.simulate(s.q[0], s.v[0], 0.1 * s.tau[0], integrator="rk4", **how)
    assert motion.times.tolist() == pytest.approx([0.0, 0.001, 0.002, 0.003, 0.004, 0.005])
    assert np.array_equal(motion.q[0], s.q[0]) and motion.steps == 50
    assert_allclose(motion.energy, robot.kinetic_energy(motion.q, motion.v) + robot.potential_energy(motion.q), rtol=1e-12)
    energy_account = motion.energy_account
    scale = 1.0 + np.abs(motion.kinetic).max()
    assert abs(energy_account.start + energy_account.work - energy_account.dissipated - energy_account.kinetic - energy_account.potential) < 1e-6 * scale
    assert_allclose(energy_account.kinetic, motion.kinetic[-1], rtol=1e-12)


def test_a_rollout_is_each_simulation(panda: rd.Robot) -> None:
    s = states(panda, 20)
    rollout = panda.rollout(s.q, s.v, s.tau, steps=30, dt=1e-3, stride=10)
    assert rollout.q_trajectory.shape == (20, 3, 7)
    assert np.array_equal(rollout.q_trajectory[:, -1], rollout.q)
    for k in (0, 19):
        motion = panda.simulate(s.q[k], s.v[k], s.tau[k], duration=0.03, dt=1e-3)
        assert_allclose(rollout.q[k], motion.q[-1], rtol=0, atol=1e-10)
        assert_allclose(rollout.v_trajectory[k], motion.v[10::10], rtol=0, atol=1e-8)
    for threads in (1, 2, 3):
        again = panda.rollout(s.q, s.v, s.tau, steps=30, dt=1e-3, threads=threads)
        assert np.array_equal(again.q, rollout.q) and np.array_equal(again.v, rollout.v)


def test_torques_of_each_step_held_and_called_are_the_same(panda: rd.Robot) -> None:
    s = states(panda, 4)
    each = np.broadcast_to(s.tau[:, np.newaxis], (4, 30, 7))
    held, rolled = (panda.rollout(s.q, s.v, tau, steps=30) for tau in (s.tau, each))
    assert np.array_equal(held.q, rolled.q)
    runs = [
        panda.simulate(s.q[0], s.v[0], tau, duration=0.03)
        for tau in (s.tau[0], each[0], lambda t, q, v: s.tau[0], lambda t, q, v: s.tau[0].tolist())
    ]
    assert all(np.array_equal(run.q, runs[0].q) for run in runs)


def test_rollouts_broadcast_and_keep_float32(panda: rd.Robot) -> None:
    q = panda.neutral().astype(np.float32)
    v = np.zeros((3, 2, 7), np.float32)
    with pytest.raises(TypeError, match="needed for position limits"):
        panda.rollout(q, v, steps=5)
    rollout = panda.rollout(q, v, steps=5, stride=5, conservative=True)
    assert rollout.q.shape == (3, 2, 7) and rollout.q.dtype == np.float32
    assert rollout.v_trajectory.shape == (3, 2, 1, 7)
    assert np.array_equal(rollout.q[0, 0], rollout.q[2, 1]) and not np.array_equal(rollout.q[0, 0], q)
    assert not v.any() and not q.any()  # the arguments do not change


def test_bad_states_of_a_rollout_lose_nobody_else(panda: rd.Robot) -> None:
    s = states(panda, 40)
    v = s.v.copy()
    v[7, 2] = np.nan
    with pytest.raises(rd.BadStatesError, match="1 of 40 states is bad, the first is state 7") as error:
        panda.rollout(s.q, v, steps=10)
    assert isinstance(error.value.result, rd.Rollout)
    q = error.value.result.q
    expected = panda.rollout(s.q, s.v, steps=10).q
    good = np.arange(40) != 7
    assert error.value.indices.tolist() == [7] and np.array_equal(q[good], expected[good])


def test_a_rollout_that_grows_names_joint_time_and_a_step() -> None:
    # Damping of 300 N m s/rad on 1/3 kg m^2: rk4 at 5 ms is unstable.
    robot = rd.loads(PENDULUM)
    how: dict[str, Any] = {"dt": 5e-3, "integrator": "rk4"}
    q, v = np.zeros((3, 1)), np.array([[0.0], [1.0], [2.0]])
    with pytest.raises(rd.SimulationError) as single:
        robot.simulate(q[1], v[1], duration=1.0, **how)
    with pytest.raises(rd.BadStatesError, match="2 of 3 states are bad, the first is state 1 of") as error:
        robot.rollout(q, v, steps=200, **how)
    assert str(single.value) in str(error.value)
    assert "the motion grows without bound: `hinge`" in str(error.value) and "try a step of" in str(error.value)
    assert error.value.indices.tolist() == [1, 2]


def test_one_step_and_its_derivatives(robot: rd.Robot) -> None:
    s, h = states(robot, 1), 1e-3
    q, v, tau = s.q[0], s.v[0], s.tau[0]
    how: dict[str, Any] = {"dt": h, "integrator": "rk4"}
    end = robot.step(q, v, tau, **how)
    rollout = robot.rollout(q, v, tau, steps=1, **how)
    assert_allclose(rollout.q, end[0], rtol=0, atol=1e-12)
    by_state, by_force = robot.linearize_step(q, v, tau, **how)
    nv, d = robot.nv, 1e-6
    for j in range(2 * nv):
        moved = np.zeros(2 * nv)
        moved[j] = d
        ahead = robot.step(robot.integrate(q, moved[:nv]), v + moved[nv:], tau, **how)
        column = np.concatenate([robot.difference(end[0], ahead[0]), ahead[1] - end[1]]) / d
        assert_allclose(by_state[:, j], column, rtol=0, atol=1e-4 * max(1.0, np.abs(by_state).max()))
    assert by_force.shape == (2 * nv, nv)


def test_a_motion_that_fails_is_kept_until_then(panda: rd.Robot) -> None:
    def fails(t: float, q: Any, v: Any) -> Any:
        if t > 0.0049:
            raise ZeroDivisionError("no torque any more")
        return np.zeros(7)

    with pytest.raises(rd.SimulationError, match=r"no torque at t = 0.005") as error:
        panda.simulate(np.zeros(7), tau=fails, duration=0.1)
    assert isinstance(error.value.__cause__, ZeroDivisionError)
    assert error.value.until.times[-1] == pytest.approx(0.004)
    lost = np.where(np.arange(7) == 2, np.nan, 0.0)
    named = r"t = 0.005 s \(step 5\): torque\[2\] \(coordinate `panda_joint3`\) is NaN; every number must be finite"
    with pytest.raises(rd.SimulationError, match=named) as error:
        panda.simulate(np.zeros(7), tau=lambda t, q, v: lost if t > 0.0049 else np.zeros(7), duration=0.1)
    assert error.value.until.times[-1] == pytest.approx(0.004)
    with pytest.raises(rd.SimulationError, match="torque has shape"):
        panda.simulate(np.zeros(7), tau=lambda t, q, v: np.zeros(6), duration=0.1)
    with pytest.raises(rd.SimulationError, match="the step must be positive and finite, got 0 s"):
        panda.simulate(np.zeros(7), duration=1.0, dt=0.0)
    with pytest.raises(rd.SimulationError, match="rk5"):
        panda.simulate(np.zeros(7), duration=1.0, integrator="rk5")
    with pytest.raises(ValueError, match="steps = 5"):
        panda.rollout(np.zeros((2, 7)), tau=np.zeros((2, 4, 7)), steps=5)


def test_a_law_in_rust_is_the_law_in_python(quadruped: rd.Robot) -> None:
    s, nv = states(quadruped, 1), quadruped.nv
    law = rd.GravityCompensatedPd(quadruped, quadruped.neutral(), np.full(nv, 20.0), np.full(nv, 2.0), gravity_at="state")
    limits = quadruped.limits.effort

    def python(t: float, q: Any, v: Any) -> Any:
        away = quadruped.difference(q, quadruped.neutral())
        wanted = np.clip(quadruped.gravity(q) + 20.0 * away - 2.0 * v, -limits, limits)
        return np.where(quadruped.actuated_dofs, wanted, 0.0)  # no motor drives the base

    q, v = s.q[0], s.v[0]
    assert_allclose(law(0.0, q, v), python(0.0, q, v), rtol=0, atol=1e-10)
    runs = [quadruped.simulate(q, v, tau, duration=0.02) for tau in (law, python)]
    assert_allclose(runs[0].q[-1], runs[1].q[-1], rtol=0, atol=1e-9)
    bounded = rd.GravityCompensatedPd(quadruped, q, np.zeros(nv), np.zeros(nv), limits=np.full(nv, 0.5))
    assert np.abs(bounded(0.0, q, v)).max() == 0.5
    with pytest.raises(rd.ControlError, match="make one for it"):
        rd.example("panda").simulate(np.zeros(7), tau=law, duration=0.1)
    with pytest.raises(ValueError, match="gravity_at"):
        rd.GravityCompensatedPd(quadruped, q, v, v, gravity_at="moon")


def test_a_run_ends_at_a_limit() -> None:
    robot = pendulum()
    motion = robot.simulate([2.9], [2.0], duration=2.0, stop_at_limits=True)
    assert motion.ended_by_event and motion.q[-1, 0] == pytest.approx(3.0, abs=1e-9)
    assert "hinge" in motion.events[-1].name


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize(
    "call", ["robot.simulate(q, duration=1e6)", "robot.simulate(q, tau=lambda t, q, v: robot.gravity(q), duration=1e6)",
             "robot.rollout(np.tile(q, (100, 1)), steps=10**8)"]
)
def test_an_interrupt_ends_a_long_motion(call: str) -> None:
    program = f"""
import numpy as np, robot_dynamics as rd
robot = rd.example("two_r")
q = robot.neutral()
print("ready", flush=True)
{call.replace("1e6)", "1e6, sample_period='ends')")}
"""
    errors, _ = interrupted(program)
    assert "KeyboardInterrupt" in errors and "SimulationError" not in errors


def test_a_word_that_means_nothing_is_refused(panda: rd.Robot) -> None:
    with pytest.raises(ValueError, match='correction = "postion" must be "none", "velocity" or "position"'):
        panda.simulate(np.zeros(7), duration=0.01, correction="postion")  # type: ignore[arg-type]


def test_implicit_steps_stick_stop_and_tell_the_losses() -> None:
    text = """<robot name="sled"><link name="rail"/><link name="sled"><inertial><mass value="2"/>
        <inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="slide" type="prismatic"><parent link="rail"/><child link="sled"/><axis xyz="1 0 0"/>
        <limit lower="-1" upper="0.5" effort="50" velocity="10"/><dynamics damping="1e6" friction="3"/></joint></robot>"""
    stiff = rd.loads(text)
    motion = stiff.simulate([0.0], [3.0], duration=0.5, integrator="implicit", dissipation=True)
    assert motion.v[-1, 0] == 0.0 and motion.losses is not None
    assert motion.losses["damping"] + motion.losses["friction"] == pytest.approx(9.0, rel=1e-9)
    gliding = rd.loads(text.replace("1e6", "0").replace('friction="3"', 'friction="0"'))
    motion = gliding.simulate([0.0], [3.0], duration=0.5, integrator="implicit", dissipation=True)
    nothing = dict.fromkeys(("damping", "friction", "corrections", "sliding", "impacts"), 0.0)
    assert motion.losses == nothing | {"stops": pytest.approx(9.0, rel=1e-12)}
    assert 0.49 < motion.q[-1, 0] <= 0.5
    free = gliding.simulate([0.0], [3.0], duration=0.5, integrator="implicit", stops=False)
    assert_allclose(free.q[-1], 1.5, rtol=1e-12)
    assert gliding.simulate([0.0], [3.0], duration=0.1, integrator="rk4").losses is None


def test_actuators_of_a_file_act_at_their_controls() -> None:
    robot = rd.loads(
        """<mujoco model="arm"><worldbody><body name="arm"><joint name="hinge" axis="0 0 1" damping="0.1"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0.5 0 0"/></body></worldbody>
        <actuator><position name="servo" joint="hinge" kp="50" kv="5"/></actuator></mujoco>"""
    )
    motion = robot.simulate([0.0], duration=4.0, integrator="implicit", dissipation=True, controls={"servo": 0.7})
    assert_allclose(motion.q[-1], 0.7, atol=1e-6)
    with pytest.raises(ValueError, match="no actuator 'motor'; it has servo|no actuator \"motor\"; it has servo"):
        robot.simulate([0.0], duration=0.1, integrator="implicit", controls={"motor": 1.0})
    by_default = robot.simulate([0.0], duration=4.0, controls={"servo": 0.7})
    assert_allclose(by_default.q[-1], 0.7, atol=1e-6)
    with pytest.raises(ValueError, match="no actuators act in this simulation"):
        robot.simulate([0.0], duration=0.1, conservative=True, controls={"servo": 1.0})


def test_a_robot_falls_and_comes_to_rest_on_ground() -> None:
    robot = rd.example("quadruped", floating_base=True)
    q = np.array([0, 0, 0.5, 0, 0, 0, 1, *[0, 0.7, -1.6] * 4])
    motion = robot.simulate(q, duration=2.0, dissipation=True, ground=rd.Ground(), sample_period=0.1)
    assert np.abs(motion.v[-1]).max() < 1e-6
    assert motion.contact_forces is not None and motion.contact_forces.shape == (21, len(motion.contact_links), 3)
    assert_allclose(motion.contact_forces[-1].sum(axis=0), [0, 0, 9.81 * robot.mass], atol=1e-3)
    assert motion.losses is not None and motion.losses["impacts"] > 1.0
    assert "front_left_foot" in motion.contact_links
    slid = robot.simulate(q, duration=2.0, ground=rd.Ground(slope=0.3, friction=0.0), sample_period="ends")
    assert slid.q[-1, 0] < -1.0
    soft = robot.simulate(q, duration=2.0, dissipation=True, ground=rd.Ground(), integrator="mujoco", sample_period="ends")
    assert soft.contact_forces is not None and np.abs(soft.v[-1]).max() < 1e-2
    # The contact is compliant: it carries the same weight, slightly lower.
    assert_allclose(soft.contact_forces[-1].sum(axis=0), [0, 0, 9.81 * robot.mass], atol=0.5)
    with pytest.raises(ValueError, match="holds position limits by its law; `implicit` can leave them out"):
        robot.simulate(q, duration=0.1, integrator="mujoco", stops=False)
    with pytest.raises(ValueError, match="`rk4` knows no contact; `implicit` and `mujoco` do"):
        robot.simulate(q, duration=0.1, integrator="rk4", ground=rd.Ground())
    with pytest.raises(ValueError, match="a coefficient of friction must be finite and not negative, got -1"):
        robot.simulate(q, duration=0.1, ground=rd.Ground(friction=-1))
    with pytest.raises(ValueError, match="has no collision shape"):
        rd.example("panda").simulate(np.zeros(7), duration=0.1, ground=rd.Ground())


BALL = '<body><freejoint/><geom type="sphere" size="0.1" friction="0.5"/></body>'


def test_a_ball_comes_to_rest_between_hills() -> None:
    ball = rd.loads(f"<mujoco><worldbody>{BALL}</worldbody></mujoco>")
    # Two planes at 45 degrees: the ball touches both if its centre is √2 radii above the bottom.
    valley = rd.HeightField([[1.0, 0.0, 1.0]] * 2, (1.0, 1.0), position=(0.0, 0.0, -2.0))
    q = [0.0, 0.3, -1.8, 0, 0, 0, 1]
    motion = ball.simulate(q, duration=1.0, ground=valley)
    assert_allclose(motion.q[-1, :3], [0.0, 0.3, -2.0 + 0.1 * np.sqrt(2)], atol=1e-6)
    # Without friction it slides like a point, on a plane and on a height field of the same plane.
    slope = 0.2
    plane = ball.simulate([0, 0, 0.2, 0, 0, 0, 1], duration=0.4, ground=rd.Ground(slope=slope, friction=0.0))
    rise = 3.0 * np.tan(slope)
    field = rd.HeightField([[-rise, rise]] * 2, (3.0, 3.0), friction=0.0)
    assert_allclose(ball.simulate([0, 0, 0.2, 0, 0, 0, 1], duration=0.4, ground=field).q, plane.q, atol=1e-12)
    ends = ball.rollout([q, q], steps=1000, ground=valley)
    assert np.array_equal(ends.q[1], motion.q[-1])


def test_grounds_that_are_none_are_refused() -> None:
    ball = rd.loads(f"<mujoco><worldbody>{BALL}</worldbody></mujoco>")

    def fall(ground: Any) -> None:
        ball.simulate([0, 0, 0.2, 0, 0, 0, 1], duration=0.1, ground=ground)

    with pytest.raises(ValueError, match=r"heights has shape \(3,\)"):
        fall(rd.HeightField([0.0, 1.0, 2.0], (1.0, 1.0)))
    with pytest.raises(ValueError, match="heights must be finite"):
        fall(rd.HeightField([[0.0, np.nan]] * 2, (1.0, 1.0)))
    with pytest.raises(ValueError, match="half lengths must be finite and above 0"):
        fall(rd.HeightField(np.zeros((2, 2)), (1.0, 0.0)))
    with pytest.raises(ValueError, match="no height field and no plane that the world carries"):
        fall("file")
    with pytest.raises(ValueError, match="give a Ground, a HeightField"):
        fall("hills")


def test_the_height_field_of_a_file_is_ground(tmp_path: Path) -> None:
    counts, heights = np.array([2, 3], "<i4"), np.array([1, 0, 1] * 2, "<f4")
    (tmp_path / "valley.bin").write_bytes(counts.tobytes() + heights.tobytes())
    (tmp_path / "ball.xml").write_text(
        f"""<mujoco><asset><hfield name="valley" file="valley.bin" size="1 1 1 0.1"/></asset>
        <worldbody><geom type="hfield" hfield="valley"/>{BALL}</worldbody></mujoco>"""
    )
    ball = rd.load(tmp_path / "ball.xml")
    motion = ball.simulate([0.0, 0.3, 0.2, 0, 0, 0, 1], duration=1.0, ground="file")
    assert_allclose(motion.q[-1, 2], 0.1 * np.sqrt(2), atol=1e-6)


def dogs() -> tuple[rd.Robot, np.ndarray[Any, np.dtype[np.float64]]]:
    """A quadruped, and five places to drop it from."""
    q = np.tile([0, 0, 0.45, 0, 0, 0, 1, *[0, 0.7, -1.6] * 4], (5, 1))
    q[:, 2] += np.linspace(0, 0.1, 5)
    return rd.example("quadruped", floating_base=True), q


@pytest.mark.parametrize("integrator", ["implicit", "mujoco"])
def test_rollouts_on_the_ground_are_runs_on_the_ground(integrator: str) -> None:
    robot, q = dogs()
    common: dict[str, Any] = {"integrator": integrator, "ground": rd.Ground(), "dissipation": True}
    ends = [robot.rollout(q, steps=200, stride=50, threads=threads, **common) for threads in (1, 2)]
    assert np.array_equal(ends[0].q, ends[1].q) and np.array_equal(ends[0].v_trajectory, ends[1].v_trajectory)
    for state in (0, 4):
        run = robot.simulate(q[state], duration=0.2, sample_period=0.05, **common)
        assert np.array_equal(run.q[1:], ends[0].q_trajectory[state])
        assert np.array_equal(run.v[-1], ends[0].v[state])


def test_rollouts_on_the_ground_say_what_they_cannot_do() -> None:
    robot, q = dogs()
    with pytest.raises(TypeError, match="float64"):
        robot.rollout(q.astype(np.float32), steps=2, ground=rd.Ground())
    with pytest.raises(ValueError, match="`rk4` knows no contact"):
        robot.rollout(q, steps=2, integrator="rk4", ground=rd.Ground())
    with pytest.raises(rd.SimulationError, match="`Robot.simulate` runs it"):
        robot.rollout(q, steps=2, integrator="adaptive")
    q[3, 1] = np.nan
    with pytest.raises(rd.BadStatesError, match="the first is state 3"):
        robot.rollout(q, steps=2, ground=rd.Ground())


def test_steps_on_the_ground_are_linearised() -> None:
    robot, q = dogs()
    rest = robot.rollout(q[0], steps=3000, ground=rd.Ground(), dissipation=True)
    on_ground: dict[str, Any] = {"dt": 1e-3, "ground": rd.Ground(), "dissipation": True}
    a, b = robot.linearize_step(rest.q, rest.v, **on_ground)
    assert a.shape == (36, 36) and b.shape == (36, 18)
    # A resting robot stays at rest: friction balances any small tangential force, and its weight any small
    # upward force.
    free: dict[str, Any] = {"dt": 1e-3, "integrator": "implicit", "stops": False}
    free_b = robot.linearize_step(rest.q, rest.v, **free)[1]
    base = slice(18, 24)
    assert np.abs(b[base, :6]).max() < 0.02 * np.abs(free_b[base, :6]).max()
    # In the air, the exact derivatives of another method with the same effects.
    v = 0.5 * np.sin(np.arange(18))
    for found, exact in zip(robot.linearize_step(q[0], v, **free), robot.linearize_step(q[0], v, dt=1e-3), strict=True):
        assert np.abs(found - exact).max() < 1e-3 * np.abs(exact).max()


def test_a_dog_stands_on_forces_that_push() -> None:
    robot, rest = rd.example("quadruped", floating_base=True), np.zeros(18)
    q = np.array([0, 0, 0.3, 0, 0, 0, 1, *[0, 0.7, -1.4] * 4])
    legs = ["front_left", "front_right", "hind_left", "hind_right"]

    def stands(a: Any, **other: Any) -> Any:
        feet = [rd.Support(leg + "_foot", friction=0.6) for leg in legs]
        return robot.supported_inverse_dynamics(feet, q, rest, a, **other)

    for push in (0.0, 2.0, 4.0):
        a = np.zeros(18)
        a[0] = push
        found = stands(a)
        normal, side = found.forces[:, 2], np.hypot(found.forces[:, 0], found.forces[:, 1])
        assert (normal >= 0).all() and (side <= 0.6 * normal * (1 + 1e-9)).all()
        assert np.abs(found.missing).max() < 1e-6 and np.abs(found.tau[:6]).max() == 0
        # Newton's law for the whole robot, whose legs move with it.
        total = found.forces.sum(axis=0) - [0, 0, robot.mass * 9.81]
        assert np.allclose(total, [robot.mass * push, 0, 0], atol=1e-6)
    a[0] = 8.0  # more than friction can transmit
    assert np.abs(stands(a).missing).max() > 1.0
    # A higher weight on forces gives smaller forces, and a lower one smaller torques.
    small, strong = stands(rest, force_weight=1.0), stands(rest, force_weight=1e-5)
    assert np.linalg.norm(small.forces) <= np.linalg.norm(strong.forces)
    assert np.linalg.norm(strong.tau) < np.linalg.norm(small.tau)
    with pytest.raises(rd.ConstraintError, match="support 1: its normal has no direction"):
        robot.supported_inverse_dynamics([rd.Support("trunk"), rd.Support("trunk", normal=(0, 0, 0))], q, rest, rest)
    with pytest.raises(rd.FrameError, match="nowhere"):
        robot.supported_inverse_dynamics([rd.Support("nowhere")], q, rest, rest)
