"""Environments for Gymnasium: its interface, the physics, and a learned task."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd

gymnasium = pytest.importorskip("gymnasium")

from robot_dynamics.gym import PENDULUM, Reach, RobotEnv, SwingUp  # noqa: E402

TASKS = [SwingUp(7, horizon=5), Reach(7, horizon=5), Reach(7, rd.example("panda"), "panda_link8", horizon=5)]


@pytest.mark.parametrize("envs", TASKS, ids=["swing-up", "reach", "panda"])
def test_the_rules_of_vectors_hold(envs: RobotEnv) -> None:
    first, info = envs.reset(seed=3)
    assert envs.observation_space.contains(first) and info == {}
    assert envs.single_action_space.shape == (envs.robot.nv,)
    random = np.random.default_rng(1)
    actions = random.uniform(-1.5, 1.5, (12, 7, envs.robot.nv))  # some of them clipped

    def run() -> list[Any]:
        return [envs.reset(seed=3), *(envs.step(action) for action in actions)]

    once, again = run(), run()
    for one, other in zip(once, again, strict=True):
        for x, y in zip(one, other, strict=True):
            assert np.array_equal(x, y) if isinstance(x, np.ndarray) else x == y
    for k, (seen, rewards, terminated, truncated, _) in enumerate(once[1:]):
        assert envs.observation_space.contains(seen) and rewards.shape == (7,)
        # Five steps, then one that restarts without reward.
        assert truncated.tolist() == [k % 6 == 4] * 7 and not terminated.any()
        assert (rewards == 0.0).all() == (k % 6 == 5) and (rewards <= 0.0).all()
    assert not np.array_equal(envs.reset()[0], first)  # without a seed the generator continues


def test_a_step_is_that_of_a_simulation_under_the_torque() -> None:
    envs = SwingUp(3, dt=0.01, substeps=4)
    envs.reset(seed=1)
    q, v = envs.q.copy(), envs.v.copy()
    seen, rewards, _, _, _ = envs.step(np.array([[0.5], [-3.0], [0.0]]))
    for k, torque in enumerate([1.0, -2.0, 0.0]):
        sim = rd.Simulation(rd.loads(PENDULUM), dt=0.01)
        sim.reset(q[k], v[k])
        sim.torques = [torque]
        sim.step(4)
        assert np.array_equal(envs.q[k], sim.q) and np.array_equal(envs.v[k], sim.v)
    away = np.arctan2(-np.sin(envs.q[:, 0]), -np.cos(envs.q[:, 0]))
    assert_allclose(rewards, -(away**2 + 0.1 * envs.v[:, 0] ** 2 + 0.001 * np.array([1.0, 4.0, 0.0])), rtol=1e-12)
    assert_allclose(seen[:, 0], -np.cos(envs.q[:, 0]), rtol=1e-6)
    assert_allclose(np.hypot(seen[:, 0], seen[:, 1]), 1.0, rtol=1e-6)


class Watched(RobotEnv):
    """A task without reward, whose episodes start at a given state."""

    def __init__(self, robot: rd.Robot, start: Any, **options: Any) -> None:
        self.first = start
        super().__init__(2, robot, observations=1, **options)

    def start(self, mask: Any) -> None:
        self.q[mask], self.v[mask] = self.first

    def observe(self) -> Any:
        return self.q[:, :1]

    def reward(self, actions: Any) -> Any:
        return np.zeros(self.num_envs)


LIFT = """<mujoco><worldbody><geom type="plane" size="2 2 .1"/>
<body pos="0 0 0.5"><joint name="lift" type="slide" axis="0 0 1" range="-1 0.2" limited="true"/><geom type="sphere" size="0.1" mass="1"/></body>
<body pos="1 0 0.5"><joint name="led" type="slide" axis="0 0 1"/><geom type="sphere" size="0.01" mass="1" contype="0" conaffinity="0"/></body>
</worldbody><equality><joint joint1="led" joint2="lift" polycoef="0 2 0 0 0"/></equality>
<actuator><motor name="up" joint="lift" ctrlrange="-10 40"/></actuator></mujoco>"""
"""A ball above a floor on a vertical slide, a second one that moves twice as far, and a motor."""


def test_all_that_the_file_states_acts() -> None:
    robot = rd.loads(LIFT)
    envs = Watched(robot, (np.zeros(2), np.zeros(2)), dt=1e-3, substeps=1000)
    assert envs.single_action_space.shape == (1,) and envs.control_range.tolist() == [[-10.0, 40.0]]
    envs.reset(seed=1)
    envs.step(np.array([[-0.6], [1.0]]))  # no force, and full force
    # One ball lies on the floor, the other is at the limit of its slide. The second ball moves twice as far.
    assert_allclose(envs.q[:, 0], [-0.4, 0.2], atol=1e-5)
    assert_allclose(envs.q[:, 1], 2.0 * envs.q[:, 0], atol=1e-6)
    floor = sum(float(contact.force[2]) for contact in envs.simulations[0].contacts)
    assert floor == pytest.approx(3.0 * 9.81, rel=1e-3)  # both weights, the second with its lever arm
    free = Watched(robot, (np.zeros(2), np.zeros(2)), dt=1e-3, substeps=100, conservative=True, effort=1.0)
    assert free.single_action_space.shape == (2,)
    free.reset(seed=1)
    free.step(np.zeros((2, 2)))
    assert_allclose(free.q[:, 0], -0.5 * 0.6 * 9.81 * 0.1**2, rtol=1e-2)  # 3 m g moves m + 4 m
    loose = Watched(robot, (np.zeros(2), np.zeros(2)), dt=1e-3, substeps=500, without=["contacts", "limits", "equalities"])
    loose.reset(seed=1)
    loose.step(np.array([[-0.6], [-0.6]]))
    assert_allclose(loose.q, -0.5 * 9.81 * 0.5**2, rtol=1e-2)


def test_a_base_that_floats_has_no_motor() -> None:
    dog = rd.example("quadruped", floating_base=True)
    start = (np.array([0, 0, 0.35, 0, 0, 0, 1, *[0, 0.7, -1.6] * 4]), np.zeros(dog.nv))
    envs = Watched(dog, start, dt=2e-3, substeps=100, ground=rd.Ground())
    assert envs.single_action_space.shape == (12,) and not envs.effort[:6].any()
    envs.reset(seed=1)
    envs.step(np.zeros((2, 12)))
    assert (envs.q[:, 2] > 0.05).all() and np.array_equal(envs.q[0], envs.q[1])
    with pytest.raises(rd.DescriptionError, match="'up': give them one in the file"):
        Watched(rd.loads(LIFT.replace('ctrlrange="-10 40"', "")), (np.zeros(2), np.zeros(2)))


def test_the_motor_cannot_lift_it() -> None:
    envs = SwingUp(1, within=0.0, horizon=10**4)
    envs.reset(seed=1)
    highest = max(float(np.abs(envs.q).max()) for _ in range(1000) if envs.step(np.ones((1, 1))))
    assert 0.5 < highest < np.pi / 2


def test_diverged_states_end_alone() -> None:
    envs = SwingUp(4)
    envs.reset(seed=1)
    envs.v[0], envs.v[2] = 2e4, 1e200
    seen, _, terminated, truncated, _ = envs.step(np.zeros((4, 1)))
    assert terminated.tolist() == [True, False, True, False] and not truncated.any()
    assert np.isfinite(envs.q).all()
    _, rewards, terminated, _, _ = envs.step(np.zeros((4, 1)))
    assert not terminated.any() and rewards[2] == 0.0 and np.abs(envs.v).max() < 10.0


def test_simulations_that_cannot_go_on_end_alone() -> None:
    envs = SwingUp(5)
    envs.reset(seed=1)
    envs.q[1], envs.v[3] = np.inf, np.nan
    before = envs.q.copy()
    _, _, terminated, truncated, _ = envs.step(np.zeros((5, 1)))
    assert terminated.tolist() == [False, True, False, True, False] and not truncated.any()
    assert (envs.q[[0, 2, 4]] != before[[0, 2, 4]]).all() and (envs.v[[1, 3]] == 0.0).all()
    _, rewards, terminated, _, _ = envs.step(np.zeros((5, 1)))
    assert not terminated.any() and rewards[1] == rewards[3] == 0.0
    assert np.isfinite(envs.q).all() and (envs.q == envs.simulations.q).all()


def test_targets_can_be_reached() -> None:
    # Joint velocities that bring the frame there, by damped least squares, and torques M (v* − v)/T for them.
    envs = Reach(32, rd.example("panda"), "panda_link8", horizon=10**6)
    envs.reset(seed=5)
    start = np.linalg.norm(envs.target - envs.tip(), axis=1)
    for _ in range(400):
        jacobian = envs.robot.frame_jacobian(envs.q, envs.frame)[:, :3]
        gram = jacobian @ jacobian.transpose(0, 2, 1) + 1e-2 * np.eye(3)
        wanted = np.linalg.solve(gram, 2.0 * (envs.target - envs.tip())[..., np.newaxis])
        error = (jacobian.transpose(0, 2, 1) @ wanted)[..., 0] - envs.v
        tau = np.einsum("nij,nj->ni", envs.robot.mass_matrix(envs.q), error) / 0.1
        envs.step(tau / envs.effort)
    end = np.linalg.norm(envs.target - envs.tip(), axis=1)
    assert (end < 0.02 + 0.1 * start).mean() > 0.9


def test_tasks_are_made_by_name_and_say_what_they_need() -> None:
    envs = gymnasium.make_vec("robot_dynamics/Reach-v0", num_envs=3, horizon=10)
    assert isinstance(envs.unwrapped, Reach) and envs.unwrapped.horizon == 10
    assert envs.metadata["autoreset_mode"] is gymnasium.vector.AutoresetMode.NEXT_STEP
    with pytest.raises(rd.DescriptionError, match="but a pendulum has one"):
        SwingUp(2, rd.example("two_r"))
    with pytest.raises(rd.DescriptionError, match="quaternions"):
        Reach(2, rd.example("quadruped", floating_base=True))
    with pytest.raises(rd.DescriptionError, match="give effort="):
        SwingUp(2, rd.loads(PENDULUM.replace('effort="2"', 'effort="inf"')))
    with pytest.raises(ValueError, match=r"actions have shape \(2,\), they must have \(2, 1\)"):
        SwingUp(2).step(np.zeros(2))
