"""Controllers of the library, and motions with adaptive steps."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import interrupted, load, states
from test_motion import pendulum

Q = np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6])
HAND = "panda_link8"


def swing(t: float) -> tuple[Any, Any, Any]:
    """A motion around Q, with its velocity and acceleration."""
    return Q + 0.2 * np.sin(2 * t), np.full(7, 0.4 * np.cos(2 * t)), np.full(7, -0.8 * np.sin(2 * t))


def test_computed_torque_is_its_equation(panda: rd.Robot) -> None:
    kp, kd = np.linspace(10.0, 70.0, 7), np.linspace(1.0, 7.0, 7)
    law = rd.ComputedTorque(panda, swing, kp, kd)
    s = states(panda, 1)
    q, v, (wanted, rate, a) = s.q[0], s.v[0], swing(0.7)
    expected = panda.inverse_dynamics(q, v, a + kp * (wanted - q) + kd * (rate - v))
    assert_allclose(law(0.7, q, v), expected, rtol=1e-13, atol=1e-12)
    standing = rd.ComputedTorque(panda, Q, kp, kd)
    assert_allclose(standing(0.0, q, v), panda.inverse_dynamics(q, v, kp * (Q - q) - kd * v), rtol=1e-13, atol=1e-12)
    still = rd.ComputedTorque(panda, (Q, np.zeros(7), np.zeros(7)), kp, kd)
    assert np.array_equal(still(3.0, q, v), standing(0.0, q, v))


def test_a_motion_is_followed(panda: rd.Robot) -> None:
    law = rd.ComputedTorque(panda, swing, np.full(7, 100.0), np.full(7, 20.0))
    q, v, _ = swing(0.0)
    motion = panda.simulate(q, v, law, duration=1.0, dt=1e-3)
    # Torques are held over a step: the error is of first order in the step.
    assert np.abs(motion.q - [swing(t)[0] for t in motion.times]).max() < 1e-3
    smooth = panda.simulate(q, v, law, duration=1.0, dt=1e-2, integrator="adaptive", tolerance=1e-10)
    assert np.abs(smooth.q - [swing(t)[0] for t in smooth.times]).max() < 1e-9


def test_dissipation_is_compensated_where_asked_for() -> None:
    robot = load("two_r")
    values = robot.parameters()
    values[robot.parameter_names.index("elbow.damping")] = 0.7
    robot = robot.with_parameters(values)
    gains = [10.0, 10.0], [1.0, 1.0]
    plain, whole = (rd.ComputedTorque(robot, [0.0, 0.0], *gains, dissipation=with_it) for with_it in (False, True))
    q, v = [0.1, 0.2], [0.5, -2.0]
    assert_allclose(whole(0.0, q, v) - plain(0.0, q, v), [0.0, -1.4], atol=1e-14)


@pytest.mark.parametrize("called", [False, True])
def test_a_frame_is_led_to_a_pose_or_to_a_place(panda: rd.Robot, called: bool) -> None:
    goal = panda.frame_pose(Q, HAND) @ np.array(
        [[1.0, 0.0, 0.0, 0.05], [0.0, np.cos(0.3), -np.sin(0.3), 0.0], [0.0, np.sin(0.3), np.cos(0.3), -0.04], [0, 0, 0, 1]]
    )
    gains: dict[str, Any] = {"stiffness": 100.0, "damping": 20.0, "null_damping": 10.0}
    for target in (goal, goal[:3, 3]):
        reference: Any = (lambda t, target=target: target) if called else target
        law = rd.TaskControl(panda, HAND, reference, posture=Q, posture_stiffness=25.0, **gains)
        motion = panda.simulate(Q, tau=law, duration=2.0, dt=1e-3)
        found = panda.frame_pose(motion.q[-1], HAND)
        assert np.abs(found - goal).max() < 1e-6 if target.ndim == 2 else np.abs(found - goal)[:3, 3].max() < 1e-6
    # At rest at its target and in its posture, the torques carry the weight.
    here = rd.TaskControl(panda, HAND, panda.frame_pose(Q, HAND), posture=Q, posture_stiffness=25.0, **gains)
    assert_allclose(here(0.0, Q, np.zeros(7)), panda.gravity(Q), atol=1e-9)


def test_a_frame_is_led_along_a_path(panda: rd.Robot) -> None:
    start = panda.frame_pose(Q, HAND)[:3, 3]
    along = np.array([0.0, 0.1, 0.05])

    def path(t: float) -> tuple[Any, Any, Any]:
        return start + along * np.sin(t) ** 2, along * np.sin(2 * t), 2 * along * np.cos(2 * t)

    law = rd.TaskControl(panda, HAND, path, stiffness=400.0, damping=40.0, null_damping=5.0)
    motion = panda.simulate(Q, tau=law, duration=1.0, dt=1e-3)
    places = panda.frame_pose(motion.q, HAND)[:, :3, 3]
    assert np.abs(places - [path(t)[0] for t in motion.times]).max() < 1e-3


def test_invalid_controllers_raise_errors(panda: rd.Robot) -> None:
    gains = np.full(7, 10.0), np.full(7, 2.0)
    law = rd.ComputedTorque(panda, swing, *gains)
    with pytest.raises(rd.ControlError, match="of robot `panda`, not of this `two_r`"):
        load("two_r").simulate([0.0, 0.0], tau=law, duration=0.1)
    with pytest.raises(rd.ShapeError, match=r"stiffness has shape \(2,\)"):
        rd.ComputedTorque(panda, swing, np.ones(2), gains[1])
    with pytest.raises(rd.ShapeError, match=r"v of the reference has shape \(6,\)"):
        rd.ComputedTorque(panda, lambda t: (Q, np.zeros(6), np.zeros(7)), *gains)(0.0, Q, np.zeros(7))
    with pytest.raises(ZeroDivisionError):
        rd.ComputedTorque(panda, lambda t: 1 / 0, *gains)(0.0, Q, np.zeros(7))
    late = rd.ComputedTorque(panda, lambda t: Q if t < 0.05 else 1 / 0, *gains)
    with pytest.raises(rd.SimulationError, match="division by zero") as error:
        panda.simulate(Q, tau=late, duration=0.1)
    assert isinstance(error.value.__cause__, ZeroDivisionError) and error.value.until.times[-1] == pytest.approx(0.049)
    with pytest.raises(rd.ShapeError, match=r"the reference has shape \(2,\), it must have \(3,\)"):
        rd.TaskControl(panda, HAND, np.zeros(2), stiffness=1.0, damping=1.0)
    with pytest.raises(rd.ControlError, match="stiffness"):
        rd.TaskControl(panda, HAND, np.zeros(3), stiffness=np.nan, damping=1.0)
    with pytest.raises(rd.FrameError, match="nose"):
        rd.TaskControl(panda, "nose", np.zeros(3), stiffness=1.0, damping=1.0)


def test_adaptive_steps_are_as_accurate_as_asked_for(panda: rd.Robot) -> None:
    s = states(panda, 1)
    how: dict[str, Any] = {"duration": 0.5, "dt": 0.05, "integrator": "adaptive"}
    exact, rough = (panda.simulate(s.q[0], s.v[0], **how, tolerance=tolerance) for tolerance in (1e-13, 1e-6))
    assert exact.times.tolist() == pytest.approx(np.arange(11) * 0.05)
    assert exact.energy_account.drift < 1e-12 and np.abs(rough.q - exact.q).max() < 1e-5
    assert exact.statistics is not None and rough.statistics is not None
    assert exact.steps == exact.statistics.accepted > rough.statistics.accepted
    assert 0.0 < exact.statistics.shortest <= exact.statistics.longest < 0.5
    fine = panda.simulate(s.q[0], s.v[0], duration=0.5, dt=1e-4, sample_period=0.05, without=["limits"])
    assert_allclose(fine.q, exact.q, atol=1e-9)
    assert fine.statistics is None
    ends = panda.simulate(s.q[0], s.v[0], **how, sample_period="ends", tolerance=1e-13)
    assert ends.times.tolist() == [0.0, 0.5] and np.array_equal(ends.q[-1], exact.q[-1])


def test_adaptive_runs_hold_torques_that_are_held(panda: rd.Robot) -> None:
    rows = np.random.default_rng(1).uniform(-5.0, 5.0, (10, 7))
    held = panda.simulate(Q, tau=rows, duration=0.5, dt=0.05, integrator="adaptive", tolerance=1e-12)
    # The reference uses small steps of order 4 and holds each row for 500 of them.
    fine = panda.simulate(Q, tau=np.repeat(rows, 500, axis=0), duration=0.5, dt=1e-4, sample_period=0.05, without=["limits"])
    assert_allclose(held.q, fine.q, atol=1e-9)
    asked: list[float] = []

    def law(t: float, q: Any, v: Any) -> Any:
        asked.append(t)
        return panda.gravity(q)

    panda.simulate(Q, tau=law, duration=0.5, dt=0.1, integrator="adaptive", control_period=0.1)
    assert sorted(set(asked)) == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4, 0.5][: len(set(asked))])
    assert len(set(asked)) in (5, 6)


def test_adaptive_runs_find_events_and_refuse() -> None:
    arm = pendulum()
    down = rd.Event("down", lambda t, q, v: q[0] + np.pi / 2, terminal=True)
    motion = arm.simulate([0.0], duration=5.0, dt=0.1, integrator="adaptive", tolerance=1e-12, events=[down])
    assert motion.ended_by_event and abs(motion.q[-1, 0] + np.pi / 2) < 1e-10
    for wrong, words in (
        ({"integrator": "rk4", "tolerance": 1e-6}, "go with integrator='adaptive'"),
        ({"integrator": "adaptive", "ground": rd.Ground()}, "ground goes with integrator='implicit'"),
        ({"integrator": "adaptive", "constraints": arm.constraints({})}, "constraints go with integrator='implicit'"),
    ):
        with pytest.raises(ValueError, match=words):
            arm.simulate([0.0], duration=0.1, **wrong)
    with pytest.raises(rd.SimulationError, match="the tolerance must be between"):
        arm.simulate([0.0], duration=0.1, integrator="adaptive", tolerance=1.0)
    with pytest.raises(rd.SimulationError, match="division by zero") as error:
        arm.simulate([0.0], tau=lambda t, q, v: 1 / 0 if t > 0.5 else [0.0], duration=1.0, integrator="adaptive")
    assert isinstance(error.value.__cause__, ZeroDivisionError)
    assert error.value.until is not None and 0.0 < error.value.until.times[-1] <= 0.6


def test_adaptive_steps_say_what_they_leave_out(panda: rd.Robot) -> None:
    text = """<mujoco><worldbody><geom type="plane" size="1 1 1"/><body name="arm" pos="0 0 1"><joint name="hinge" axis="0 1 0" damping="0.2"
        range="-90 90" actuatorfrcrange="-1 1" FRICTION/><geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="1"/></body></worldbody>
        <equality><joint joint1="hinge" active="ACTIVE"/></equality><actuator><motor name="motor" joint="hinge"/></actuator></mujoco>"""
    damped = rd.loads(text.replace("FRICTION", "").replace("ACTIVE", "false"))
    rubbed = rd.loads(text.replace("FRICTION", 'frictionloss="0.1"').replace("ACTIVE", "true"))
    how: dict[str, Any] = {"duration": 0.5, "dt": 0.1, "integrator": "adaptive", "tolerance": 1e-11}

    def left_out(robot: rd.Robot, tau: Any = None, **other: Any) -> list[str]:
        return [line.split(":")[0] for line in robot.simulate([0.0], tau=tau, **how, **other).left_out]

    stated = ["position limits", "contacts"]
    assert left_out(damped) == stated
    assert left_out(rubbed) == ["damping and dry friction", *stated, "equalities"]
    assert left_out(rubbed, without=["dissipation", "contacts", "limits", "equalities"]) == []
    assert left_out(damped, lambda t, q, v: [0.0]) == stated
    assert left_out(rubbed, conservative=True) == ["equalities"]
    # Damping acts if no joint has friction, and the energy account includes its work.
    motion = damped.simulate([0.0], **how)
    fine = damped.simulate([0.0], duration=0.5, integrator="rk4", without=["actuators"], sample_period=0.1)
    assert_allclose(motion.q, fine.q, atol=1e-9)
    assert motion.energy_account.dissipated > 0.1 and abs(motion.energy_account.imbalance) < 1e-9
    assert rubbed.simulate([0.0], **how).energy_account.dissipated == 0.0
    # Torques are within the effort limits, also those of a function.
    pushed, bounded = (damped.simulate([0.0], tau=[torque], **how) for torque in (50.0, 1.0))
    assert np.array_equal(pushed.q, bounded.q)
    asked = damped.simulate([0.0], tau=lambda t, q, v: [50.0], **how)
    assert np.array_equal(asked.q, bounded.q)
    assert asked.steps_at_effort_limits is not None and asked.steps_at_effort_limits[0] == 5
    with pytest.raises(ValueError, match="there is no effect `wind`"):
        damped.simulate([0.0], **how, without=["wind"])


def test_ctrl_c_ends_an_adaptive_run() -> None:
    errors, seconds = interrupted(
        """
import robot_dynamics as rd
robot = rd.example("humanoid", floating_base=True)
print("ready", flush=True)
robot.simulate(robot.neutral(), duration=1e4, dt=1e3, integrator="adaptive", tolerance=1e-12)
"""
    )
    assert "KeyboardInterrupt" in errors and seconds < 10.0


def tool_motion(robot: rd.Robot, q: Any, v: Any, tau: Any, wrench: Any) -> Any:
    """Acceleration of the hand along the world's axes, under a torque and a wrench along the hand's axes."""
    jacobian = robot.frame_jacobian(q, HAND, reference_frame="local")
    a = robot.forward_dynamics(q, v, tau + jacobian.T @ wrench)
    return robot.frame_acceleration(q, v, a, HAND, reference_frame="local_world_aligned")


def test_impedance_answers_a_wrench(panda: rd.Robot) -> None:
    v, free = np.zeros(7), np.full(7, np.inf)
    pose = panda.frame_pose(Q, HAND)
    inertia, wrench = np.array([4.0, 5.0, 6.0, 0.3, 0.4, 0.5]), np.array([3.0, -2.0, 5.0, 0.2, 0.1, -0.3])
    turn = np.kron(np.eye(2), pose[:3, :3])
    how: dict[str, Any] = {"stiffness": np.full(6, 100.0), "damping": np.full(6, 10.0), "limits": free}
    soft = rd.ImpedanceControl(panda, HAND, pose, **how, inertia=inertia, wrench=lambda t: wrench)
    assert_allclose(tool_motion(panda, Q, v, soft(0.0, Q, v), wrench), turn @ wrench / inertia, atol=1e-8)
    own = rd.ImpedanceControl(panda, HAND, pose, **how)
    space = panda.operational_space(Q, v, HAND, ("x", "y", "z", "rx", "ry", "rz"))
    moved = tool_motion(panda, Q, v, own(0.0, Q, v), wrench)
    assert_allclose(space.inertia @ moved, turn @ wrench, atol=1e-8)
    with pytest.raises(ValueError, match="belong together"):
        rd.ImpedanceControl(panda, HAND, pose, **how, inertia=inertia)
    with pytest.raises(rd.ControlError, match="panda_link3"):
        rd.ImpedanceControl(panda, HAND, pose, **how, inertia=inertia, wrench=wrench, sensor="panda_link3")


def test_commands_are_scaled_to_effort_limits(panda: rd.Robot) -> None:
    v, pose = np.zeros(7), panda.frame_pose(Q, HAND)
    far = pose[:3, 3] + [0.1, 0.4, 0.2]
    gains: dict[str, Any] = {"stiffness": 400.0, "damping": 40.0}
    limits = np.abs(panda.gravity(Q)) + 8.0
    whole = rd.TaskControl(panda, HAND, far, **gains, limits=np.full(7, np.inf))(0.0, Q, v)
    scaled = rd.TaskControl(panda, HAND, far, **gains, limits=limits)(0.0, Q, v)
    assert (np.abs(whole) > limits).any() and (np.abs(scaled) <= limits).all()
    wanted, found = (tool_motion(panda, Q, v, tau, np.zeros(6))[:3] for tau in (whole, scaled))
    assert_allclose(np.cross(wanted, found), 0.0, atol=1e-7)
    assert 0.0 < np.linalg.norm(found) < np.linalg.norm(wanted)
    with pytest.raises(ValueError, match="must not be negative"):
        rd.TaskControl(panda, HAND, far, **gains, limits=-limits)


def test_implicit_gains_are_those_of_the_library(panda: rd.Robot) -> None:
    kp, kd, free = np.full(7, 1e7), np.full(7, 100.0), np.full(7, np.inf)
    weight = panda.gravity(Q)
    of_library = rd.GravityCompensatedPd(panda, Q, kp, kd, limits=free, implicit_period=1e-3)
    q, v = Q + 0.01, np.full(7, 0.1)
    own = rd.ImplicitGains(panda, lambda t, q, v: weight + kp * (Q - q) - kd * v, kp, kd, 1e-3, limits=free)
    explicit = rd.GravityCompensatedPd(panda, Q, kp, kd, limits=free)
    wrapped = rd.ImplicitGains(panda, explicit, kp, kd, 1e-3, limits=free)
    assert_allclose(own(0.0, q, v), of_library(0.0, q, v), rtol=1e-9)
    assert np.array_equal(wrapped(0.0, q, v), of_library(0.0, q, v))
    held = panda.simulate(q, tau=of_library, duration=0.2, dt=1e-3, integrator="rk4", without=["effort_limits", "limits"])
    assert np.abs(held.q[-1] - Q).max() < 1e-4
    with pytest.raises(rd.ControlError, match="period"):
        rd.GravityCompensatedPd(panda, Q, kp, kd, implicit_period=0.0)


def test_momentum_observer_and_admittance(panda: rd.Robot) -> None:
    observer = rd.MomentumObserver(panda, np.full(7, 50.0), thresholds=np.full(7, 1.0))
    push = np.array([0.0, 5.0, 0.0, -2.0, 0.0, 0.0, 0.3])
    for _ in range(400):  # The arm stands still with this push in its joints, and motors that hold the rest.
        r = observer.update(Q, np.zeros(7), panda.gravity(Q) - push, 1e-3)
    assert_allclose(r, push * -np.expm1(-50.0 * 0.399), atol=1e-11)
    assert observer.collision == 1 and np.array_equal(observer.external_torque, r)
    observer.reset()
    assert observer.collision is None
    with pytest.raises(rd.ControlError, match="time"):
        observer.update(Q, np.zeros(7), np.zeros(7), 0.0)

    lead = rd.Admittance(np.full(6, 2.0), np.full(6, 8.0), np.full(6, 50.0))
    for _ in range(5000):
        pose, velocity, _ = lead.step(panda.frame_pose(Q, HAND), [5.0, 0.0, 0.0, 0.0, 0.0, 2.5], 1e-3)
    assert_allclose(lead.displacement, [0.1, 0.0, 0.0, 0.0, 0.0, 0.05], atol=1e-4)
    assert_allclose(pose[:3, 3] - panda.frame_pose(Q, HAND)[:3, 3], lead.displacement[:3], atol=1e-12)
    assert np.abs(velocity).max() < 1e-3
    with pytest.raises(ValueError, match="inertia"):
        rd.Admittance(np.zeros(6), np.zeros(6), np.zeros(6))


def test_controls_of_actuators_give_a_torque() -> None:
    robot = rd.loads(
        """<mujoco><worldbody>
        <body><joint name="shoulder" axis="0 1 0"/><geom size="0.1" pos="0.5 0 0" mass="2"/>
        <body pos="1 0 0"><joint name="elbow" axis="0 1 0"/><geom size="0.1" pos="0.3 0 0" mass="1"/>
        </body></body></worldbody>
        <tendon><fixed name="cable"><joint joint="shoulder" coef="1"/>
        <joint joint="elbow" coef="-0.5"/></fixed></tendon>
        <actuator><position joint="shoulder" kp="40" kv="2"/><motor tendon="cable" gear="-3"/></actuator>
        </mujoco>"""
    )
    q, v, tau = np.array([0.3, -0.4]), np.array([0.1, 0.2]), np.array([7.0, -2.0])
    controls, residual = rd.ControlAllocation(robot).controls(q, v, tau)
    assert residual < 1e-9
    sim = rd.Simulation(robot, dt=1e-9)
    sim.reset(q, v)
    sim.controls = controls
    sim.step()
    a = (sim.v - v) / 1e-9
    assert_allclose(a, robot.forward_dynamics(q, v, tau), rtol=1e-5)


def test_motors_and_elastic_joints() -> None:
    rod = rd.example("two_r").with_gravity_scaled(0.0)
    motor: dict[str, Any] = {"gear": 100.0, "rotor_inertia": 2e-5, "resistance": 1.6, "constant": 0.08}
    driven = rod.with_motor("shoulder", **motor, voltage_limit=24.0, current_limit=6.0)
    allocation = rd.ControlAllocation(driven)
    tau = driven.inverse_dynamics([0.3, 0.1], [0.5, 0.0], [1.0, 0.0])
    controls, _ = allocation.controls([0.3, 0.1], [0.5, 0.0], tau)
    current, voltage, power, heat = allocation.motor_loads()[0]
    assert current == pytest.approx(tau[0] / 100.0 / 0.08) and controls[0] == pytest.approx(0.08 * current)
    assert voltage == pytest.approx(1.6 * current + 0.08 * 100.0 * 0.5)
    assert power - heat == pytest.approx(tau[0] * 0.5)
    sim = rd.Simulation(driven, dt=1e-4)
    sim.controls = [10.0]
    sim.step()
    a = driven.forward_dynamics([0.0, 0.0], [0.0, 0.0], [100.0 * 0.08 * 6.0, 0.0])  # at the current limit
    assert_allclose(sim.v, 1e-4 * a, rtol=1e-3)
    hot = rod.with_motor("shoulder", **motor, current_limit=6.0, winding=rd.Winding(4.0, 20.0), derating=(80.0, 120.0))
    assert hot.describe()["actuators"][0]["motor"]["derating"] == {"start": 80.0, "end": 120.0}

    soft = driven.with_elastic_joint("shoulder", 1e4, 5.0, backlash=1e-3).robot
    assert soft.joint_names == ("shoulder", "shoulder_elastic", "elbow")
    assert soft.actuated_dofs.tolist() == [True, False, True]
    with pytest.raises(rd.DescriptionError, match="armature"):
        rod.with_elastic_joint("elbow", 100.0)
    with pytest.raises(rd.DescriptionError, match="winding"):
        rod.with_motor("shoulder", **motor, current_limit=6.0, derating=(80.0, 120.0))


def test_torques_act_beside_tendons_in_explicit_steps() -> None:
    robot = rd.loads(
        """<mujoco><option gravity="0 0 0"/><worldbody><body><joint name="a" axis="0 1 0" armature="0.1"/>
        <geom size="0.1" pos="0.5 0 0" mass="2"/></body></worldbody>
        <tendon><fixed name="t" stiffness="10"><joint joint="a" coef="1"/></fixed></tendon></mujoco>"""
    )
    for integrator in ("rk4", "implicit", "mujoco"):
        sim = rd.Simulation(robot, dt=1e-4, integrator=integrator)
        sim.torques = [1.2]
        sim.step()
        assert_allclose(sim.v, 1e-4 * robot.forward_dynamics([0.0], [0.0], [1.2]), rtol=1e-3, err_msg=integrator)


def test_wrapped_laws_are_of_their_robot(panda: rd.Robot) -> None:
    arm = load("two_r")
    hold = rd.GravityCompensatedPd(arm, np.zeros(2), np.ones(2), np.ones(2))
    own = rd.Delayed(arm, hold, 0.01)
    assert arm.simulate([0.0, 0.0], tau=own, duration=0.02, dt=0.01).tau[0].tolist() == [0.0, 0.0]
    with pytest.raises(rd.ControlError, match="is of robot"):
        arm.simulate([0.0, 0.0], tau=rd.Delayed(panda, hold, 0.01), duration=0.02)
    with pytest.raises(rd.ControlError, match="is of robot"):
        panda.simulate(Q, tau=rd.Delayed(panda, hold, 0.01), duration=0.02)
