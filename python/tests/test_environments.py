"""Environments with contact: position control, differences between environments, and the tasks Walk and
Lift."""

import dataclasses
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from robot_dynamics.gym import Lift, Pushes, Randomization, RobotEnv, Walk, humanoid, quadruped, rough_ground
from robot_dynamics.randomization import PushSchedule

STANDING = quadruped().configuration()


def batch(count: int = 3, **options: Any) -> rd.SimulationBatch:
    """Quadrupeds that stand above the ground."""
    dog = rd.example("quadruped", floating_base=True)
    simulations = rd.SimulationBatch(dog, count, dt=2e-3, integrator="mujoco", ground=rd.Ground(), **options)
    simulations.reset(STANDING)
    return simulations


def test_position_control_is_a_law_of_each_step() -> None:
    simulations = batch(2)
    gains = np.repeat([0.0, 40.0], [6, 12]), np.repeat([0.0, 0.8], [6, 12])
    simulations.set_position_control(*gains, limits=10.0, delay=[0, 3])
    assert np.array_equal(simulations.targets[:, 6:], np.tile(STANDING[7:], (2, 1)))
    wanted = np.tile(np.r_[np.zeros(6), STANDING[7:] + 0.3], (2, 1))
    simulations.targets = wanted
    simulations.torques = np.r_[np.zeros(6), np.full(12, 0.5)]
    simulations.step(5)
    for k, delay in enumerate([0, 3]):
        sim = rd.Simulation(simulations.robot, dt=2e-3, integrator="mujoco", ground=rd.Ground())
        sim.reset(STANDING)
        for step in range(5):
            target = STANDING[7:] if step < delay else wanted[k, 6:]
            own = gains[0][6:] * (target - sim.q[7:]) - gains[1][6:] * sim.v[6:]
            sim.torques = np.r_[np.zeros(6), 0.5 + np.clip(own, -10.0, 10.0)]
            sim.step()
        assert_allclose(simulations.q[k], sim.q, rtol=0, atol=1e-13)
        assert_allclose(simulations.applied_torques[k], sim.applied_torques, rtol=0, atol=1e-10)
        assert_allclose(simulations.acceleration[k], sim.acceleration, rtol=0, atol=1e-8)
    assert np.array_equal(simulations.torques[0], np.r_[np.zeros(6), np.full(12, 0.5)])


def test_position_control_names_bad_gains() -> None:
    simulations = batch(2)
    with pytest.raises(rd.SimulationInputError, match="degree of freedom 0: it must be 0|stiffness of degree of freedom 0"):
        simulations.set_position_control(np.ones(18), 0.0)
    with pytest.raises(rd.SimulationInputError, match="damping"):
        simulations.set_position_control(1.0, -1.0)
    with pytest.raises(rd.ShapeError, match="stiffness has shape"):
        simulations.set_position_control(np.ones(5), 0.0)
    with pytest.raises(ValueError, match="delay is"):
        simulations.set_position_control(1.0, 0.0, delay=-1)


def test_contact_forces_are_sums_of_contacts() -> None:
    simulations = batch(2)
    simulations.set_position_control(80.0, 1.0)
    simulations.step(1500)
    links = [*quadruped().feet, "trunk"]
    forces = simulations.contact_forces(links)
    for k in range(2):
        sums = np.zeros((5, 3))
        for contact in simulations[k].contacts:
            sums[links.index(contact.link)] += contact.force
        assert_allclose(forces[k], sums, rtol=0, atol=1e-12)
    weight = 9.81 * sum(link.mass for link in simulations.robot.links)
    # It stands after three seconds, up to slow creep of the soft contacts.
    assert_allclose(forces.sum(axis=1)[:, 2], weight, rtol=1e-2)
    with pytest.raises(ValueError, match="has no link 'tail'"):
        simulations.contact_forces(["tail"])


def test_wrenches_push_the_link() -> None:
    simulations = batch(2)
    push = np.zeros((2, 6))
    push[1, :3] = 30.0, -20.0, 10.0
    simulations.set_wrenches({"trunk": push})
    simulations.step(10)
    sim = rd.Simulation(simulations.robot, dt=2e-3, integrator="mujoco", ground=rd.Ground())
    sim.reset(STANDING)
    sim.apply_wrench("trunk", (30.0, -20.0, 10.0))
    sim.step(10)
    assert np.array_equal(simulations.q[1], sim.q) and not np.array_equal(simulations.q[0], sim.q)
    with pytest.raises(rd.FrameError):
        simulations.set_wrenches({"tail": push})


def test_sensors_of_a_batch_are_those_of_its_simulations() -> None:
    dog = rd.example("quadruped", floating_base=True).with_sensors({"imu": ("accelerometer", "trunk"), "spin": ("gyro", "trunk")})
    simulations = rd.SimulationBatch(dog, 2, integrator="mujoco", ground=rd.Ground())
    simulations.reset(np.stack([STANDING, STANDING + np.r_[0, 0, 0.1, np.zeros(16)]]))
    simulations.step(3)
    for k in range(2):
        for name, values in simulations[k].sensors.items():
            assert np.array_equal(simulations.sensors[name][k], values)


def test_variants_have_their_own_masses_and_grounds() -> None:
    dog = rd.example("quadruped", floating_base=True)
    kinds = [(dog, rd.Ground(friction=0.1)), (dog.with_mass_scaled(1.5), rd.Ground(friction=0.9))]
    simulations = rd.SimulationBatch(dog, 3, dt=2e-3, integrator="mujoco", variants=kinds)
    moving = np.r_[1.0, np.zeros(17)]
    simulations.reset(STANDING, moving)
    simulations.step(100)
    for k in range(3):
        own, ground = kinds[k % 2]
        sim = rd.Simulation(own, dt=2e-3, integrator="mujoco", ground=ground)
        sim.reset(STANDING, moving)
        sim.step(100)
        assert np.array_equal(simulations.q[k], sim.q)
        assert simulations[k].robot == own
    assert not np.array_equal(simulations.q[0], simulations.q[1])
    with pytest.raises(rd.SimulationInputError, match="variant 1 has other joints"):
        rd.SimulationBatch(dog, 2, variants=[(dog, None), (rd.example("two_r"), None)])


def test_heights_are_those_that_a_ball_touches() -> None:
    ground = rough_ground(3, length=4.0, roughness=0.1)
    x, y = np.random.default_rng(1).uniform(-1.5, 1.5, (2, 12))
    ball = rd.loads('<mujoco><worldbody><body><freejoint/><geom type="sphere" size="0.001"/></body></worldbody></mujoco>')
    simulations = rd.SimulationBatch(ball, 12, dt=1e-3, integrator="mujoco", ground=ground)
    height = ground.height(x, y)
    q = np.stack([x, y, height + 1e-3, *np.tile([[0.0], [0.0], [0.0], [1.0]], 12)], axis=1)
    simulations.reset(q - np.eye(7)[2] * 1e-4)
    simulations.step()
    assert len([k for k in range(12) if simulations[k].contacts]) == 12
    # A ball at 2 mm above does not touch: the bumps have slopes below 1.
    simulations.reset(q + np.eye(7)[2] * 2e-3)
    simulations.step()
    assert not any(simulations[k].contacts for k in range(12))
    assert np.isnan(ground.height(2.1, 0.0))


def options(task: str) -> dict[str, Any]:
    """Everything that differs between environments."""
    if task == "lift":
        return {"latency": 1, "noise": 0.01, "pushes": Pushes("box", 0.5, 0.01, (0.1, 0.3), 0.1)}
    ranges = Randomization((0.5, 1.2), (0.8, 1.2), "trunk", 4, (0.9, 1.1), (0.8, 1.2), (0.8, 1.2), (0, 5))
    return {"latency": 1, "noise": 0.01, "pushes": Pushes("trunk", 80.0, 5.0, (0.1, 0.3), 0.1), "randomization": ranges}


def made(task: str, **more: Any) -> RobotEnv:
    """Environments of a task."""
    if task == "lift":
        return Lift(6, horizon=30, **more)
    if task == "humanoid":
        return Walk(6, humanoid(), horizon=30, **more)
    return Walk(6, horizon=30, ground=rough_ground() if task == "rough" else None, **more)


@pytest.mark.parametrize("task", ["flat", "rough", "humanoid", "lift"])
def test_the_same_seed_gives_the_same_bits_for_any_number_of_threads(task: str) -> None:
    more = options("lift" if task == "lift" else "flat")
    if task == "humanoid":
        more = {"noise": 0.01}
    actions = np.random.default_rng(1).uniform(-1.2, 1.2, (40, 6, made(task).sizes[1]))

    def run(threads: int) -> list[Any]:
        envs = made(task, threads=threads, **more)
        return [envs.reset(seed=3)[0], *(x for action in actions for x in envs.step(action)[:4])]

    once, again = run(1), run(3)
    for one, other in zip(once, again, strict=True):
        assert np.array_equal(one, other)
    ended = np.array(once[3::4]) | np.array(once[4::4])
    assert ended.any() and all(np.isfinite(seen).all() for seen in once[1::4])
    # Each environment restarts in the step after its end, without reward.
    assert (np.array(once[2::4])[1:][ended[:-1]] == 0.0).all()


def test_a_standing_robot_is_rewarded_and_a_fallen_one_fails() -> None:
    envs = Walk(4, commands=((0.0, 0.0),) * 3, rewards={"air_time": 0.0})
    envs.reset(seed=1)
    for _ in range(50):
        _, rewards, terminated, truncated, _ = envs.step(np.zeros((4, 12)))
        assert not terminated.any() and not truncated.any()
    # 2.5 per second for a robot at rest that tracks a command of zero on four feet, less its torques.
    assert (rewards > 0.9 * 2.5 * envs.control_period).all() and (rewards < 2.5 * envs.control_period).all()
    assert envs.has_contact[:, :4].all() and not envs.has_contact[:, 4:].any()
    assert_allclose(envs.gravity_direction, np.tile([0.0, 0.0, -1.0], (4, 1)), atol=0.1)
    envs.q[1, 3:7] = 1.0, 0.0, 0.0, 0.0  # on its back
    _, _, terminated, _, _ = envs.step(np.zeros((4, 12)))
    assert terminated.tolist() == [False, True, False, False]


def test_gravity_direction_is_that_of_the_base() -> None:
    envs = Walk(3)
    envs.q[:] = envs.robot.random_configuration(3, seed=1)
    rotations = envs.robot.frame_pose(envs.q, "trunk")[:, :3, :3]
    assert_allclose(envs.gravity_direction, -rotations[:, 2], atol=1e-12)


def test_the_keyframes_of_the_file_lift_the_box() -> None:
    envs = Lift(4, offset=0.002, heights=(0.15, 0.15))
    envs.reset(seed=1)
    least, most = envs.control_range.T
    rewards = np.zeros(4)
    for step in range(150):
        lift = 0.15 * min(1.0, max(0.0, (step - 30) / 60))
        controls = np.array([lift, *([0.03] * 2 if step >= 10 else [0.0] * 2)])
        _, rewards, terminated, _, _ = envs.step(np.tile(2.0 * (controls - least) / (most - least) - 1.0, (4, 1)))
        assert not terminated.any()
    assert (np.abs(envs.missing) < 0.02).all() and envs.has_contact.all() and (rewards > 0.8).all()


def test_a_weaker_motor_has_smaller_gains_and_limits() -> None:
    weak = Walk(2, randomization=Randomization(strength=(0.5, 0.5)))
    soft = Walk(2, dataclasses.replace(quadruped(), stiffness=40.0, damping=0.5))
    assert np.array_equal(weak.reset(seed=1)[0], soft.reset(seed=1)[0])
    for _ in range(5):
        weak.step(np.full((2, 12), 0.1))
        soft.step(np.full((2, 12), 0.1))
        assert np.array_equal(weak.q, soft.q)
    weak.step(np.ones((2, 12)))
    knees = [joint.v.start for joint in weak.robot.joints if joint.name.endswith("knee")]
    assert (np.abs(weak.simulations.applied_torques[:, knees]) <= 0.5 * 36.0).all()


def test_factors_are_drawn_for_each_episode_within_their_ranges() -> None:
    envs = Walk(40, horizon=2, randomization=Randomization(strength=(0.8, 1.2), delay=(1, 5)))
    envs.reset(seed=1)
    first = envs.factors.strength.copy()
    for _ in range(3):
        envs.step(np.zeros((40, 12)))
    factors = envs.factors
    assert (factors.strength != first).all() and (np.abs(factors.strength - 1.0) <= 0.2).all()
    assert set(factors.delay) == {1, 2, 3, 4, 5} and (factors.stiffness == 1.0).all()


def test_pushes_have_their_length_size_and_interval() -> None:
    schedule = PushSchedule(Pushes("trunk", 10.0, 0.0, (0.2, 0.4), 0.06), 50, 0.02)
    random, simulations = np.random.default_rng(1), rd.SimulationBatch(rd.example("quadruped", floating_base=True), 50)
    schedule.restart(np.ones(50, bool), random)
    acts = []
    for _ in range(200):
        schedule.advance(simulations, random)
        assert (np.abs(schedule.wrenches[:, :3]) <= 10.0).all() and not schedule.wrenches[:, 3:].any()
        acts.append(schedule.wrenches.any(axis=1))
    pushed = np.array(acts)
    # Three control steps in each 10 to 20.
    assert 3 / 20 < pushed.mean() < 3 / 10
    begins = np.flatnonzero(np.diff(pushed[:, 0].astype(int)) == 1)
    assert set(np.diff(begins)) <= set(range(10, 21)) and not pushed[:9].any()


def test_options_that_do_not_fit_are_named() -> None:
    with pytest.raises(ValueError, match="there is no reward 'style'"):
        Walk(1, rewards={"style": 1.0})
    with pytest.raises(ValueError, match="delay is"):
        Walk(1, randomization=Randomization(delay=(0, 6)))
    with pytest.raises(ValueError, match="friction can differ"):
        Lift(1, randomization=Randomization(friction=(0.5, 1.0)))
    with pytest.raises(ValueError, match="latency is -1"):
        Walk(1, latency=-1)


def test_tensors_share_the_memory_of_the_results() -> None:
    torch = pytest.importorskip("torch")
    envs, same = Walk(3), Walk(3)
    tensors = same.torch()
    seen, _ = envs.reset(seed=1)
    assert np.array_equal(tensors.reset(seed=1).numpy(), seen)
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (3, 12)).astype(np.float32)
    results, found = envs.step(actions), tensors.step(torch.from_numpy(actions))
    assert found[0].dtype == found[1].dtype == torch.float32
    for one, other in zip(results[:4], found, strict=True):
        assert_allclose(one, other.numpy(), rtol=1e-6)


WITHOUT_GYMNASIUM = """
import sys
sys.modules["gymnasium"] = None
import numpy as np
from robot_dynamics.gym import Walk
envs = Walk(3, horizon=4)
assert envs.observation_space.contains(envs.reset(seed=5)[0]) and envs.unwrapped is envs
envs.action_space.seed(1)
assert envs.action_space.contains(envs.action_space.sample()) and envs.action_space.sample().shape == (3, 12)
for _ in range(7):
    seen = envs.step(np.full((3, 12), 0.3))[0]
envs.close()
print(seen.tobytes().hex())
"""


def test_environments_run_without_gymnasium_and_give_the_same_bits() -> None:
    pytest.importorskip("gymnasium")
    run = subprocess.run([sys.executable, "-P", "-c", WITHOUT_GYMNASIUM], capture_output=True, text=True, check=True)
    envs = Walk(3, horizon=4)
    envs.reset(seed=5)
    for _ in range(7):
        seen = envs.step(np.full((3, 12), 0.3))[0]
    assert run.stdout.strip() == seen.tobytes().hex()


def test_tasks_have_names() -> None:
    gymnasium = pytest.importorskip("gymnasium")
    for name, task in (("Walk", Walk), ("Lift", Lift)):
        envs = gymnasium.make_vec(f"robot_dynamics/{name}-v0", num_envs=2)
        assert isinstance(envs.unwrapped, task) and envs.observation_space.contains(envs.reset(seed=1)[0])
