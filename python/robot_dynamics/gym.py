"""Gymnasium: many simulations of a robot with a task, which step together.

Registration by name needs the extra ``robot-dynamics[gym]``; the classes run without it, too.

    import gymnasium
    import robot_dynamics.gym

    envs = gymnasium.make_vec("robot_dynamics/SwingUp-v0", num_envs=1000)     # or SwingUp(1000), Reach(1000,
    robot) observations, _ = envs.reset(seed=1) observations, rewards, terminated, truncated, _ =
    envs.step(envs.action_space.sample())

Environments restart in the step after their end, like the vector environments of Gymnasium
(``AutoresetMode.NEXT_STEP``). The same seed and actions give the same bits, for any number of threads.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.device_walk import DeviceWalk
from robot_dynamics.errors import DescriptionError
from robot_dynamics.lifting import Lift
from robot_dynamics.loading import example, loads
from robot_dynamics.randomization import Pushes, Randomization
from robot_dynamics.robot import Robot
from robot_dynamics.robot_env import DIVERGED_SPEED, RobotEnv
from robot_dynamics.walking import LeggedRobot, Walk, humanoid, quadruped, rough_ground

PENDULUM = """<robot name="pendulum"><link name="stand"/><link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
<inertia ixx="0.0833" iyy="0.0833" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="stand"/><child link="rod"/><axis xyz="0 1 0"/>
<limit effort="2" velocity="20"/></joint></robot>"""
"""Rod of 1 kg and 1 m that hangs at q = 0 and stands at π.

Its motor has 2 N·m; gravity pulls with up to 4.9 N·m.
"""


class SwingUp(RobotEnv):
    """Task to swing up a pendulum and hold it upright, with a motor that is too weak to lift it.

    The observation is cos and sin of the angle from upright, and v/(8 rad/s). The reward of a step is
    −(angle² + 0.1 v² + 0.001 τ²), as usual for this task.

    Parameters
    ----------
    num_envs : int
        Number of environments.
    robot : Robot, optional
        Robot with one joint that hangs at q = 0; default: `PENDULUM`.
    within : float
        Largest initial angle from hanging [rad]; the initial speed is at most 1 rad/s.
    **options
        Options of `RobotEnv`.

    Raises
    ------
    DescriptionError
        The robot does not have exactly one degree of freedom.
    """

    def __init__(
        self, num_envs: int = 1, robot: Robot | None = None, *, within: float = np.pi, **options: Any
    ) -> None:
        robot = loads(PENDULUM) if robot is None else robot
        if (robot.nq, robot.nv) != (1, 1):
            raise DescriptionError(f"robot `{robot.name}` has {robot.nv} degrees of freedom, but a pendulum has one")
        super().__init__(num_envs, robot, observations=3, **options)
        self.within = within

    def start(self, mask: NDArray[np.bool_]) -> None:
        """Start at random angles and speeds."""
        angle, speed = self.np_random.uniform(-1.0, 1.0, (2, int(mask.sum()), 1))
        self.q[mask], self.v[mask] = self.within * angle, speed

    def observe(self) -> NDArray[np.float64]:
        """cos and sin of the angle from upright, and v/8."""
        away = self.q - np.pi
        return np.concatenate([np.cos(away), np.sin(away), self.v / 8.0], axis=1)

    def reward(self, actions: NDArray[np.float64]) -> NDArray[np.float64]:
        """−(angle² + 0.1 v² + 0.001 τ²)."""
        away = np.remainder(self.q[:, 0], 2.0 * np.pi) - np.pi
        tau = self.torques(actions)[:, 0]
        rewards: NDArray[np.float64] = -(away**2 + 0.1 * self.v[:, 0] ** 2 + 0.001 * tau**2)
        return rewards


class Reach(RobotEnv):
    """Task to move a frame of an arm to a target and keep it there.

    The motors carry the weight of the arm in addition to the action. The observation is q, v/5, and the
    vector from the frame to the target [m]. The reward of a step is −distance [m] − 0.01 |action|²/nv.
    Targets are positions of the frame in random configurations, so each can be reached.

    Parameters
    ----------
    num_envs : int
        Number of environments.
    robot : Robot, optional
        Robot without quaternions; default: ``rd.example("two_r")``.
    frame : str, optional
        Name of the frame; default: the last one.
    **options
        Options of `RobotEnv`.

    Raises
    ------
    DescriptionError
        The robot has quaternions.
    """

    def __init__(
        self, num_envs: int = 1, robot: Robot | None = None, frame: str | None = None, **options: Any
    ) -> None:
        robot = example("two_r") if robot is None else robot
        if robot.nq != robot.nv:
            raise DescriptionError(f"robot `{robot.name}` has quaternions; this task needs an arm without them")
        self.frame = robot.frame_names[-1] if frame is None else frame
        super().__init__(num_envs, robot, observations=2 * robot.nv + 3, **options)
        self.target = np.zeros((num_envs, 3))
        """Targets in the world (num_envs, 3) [m]."""

    def tip(self) -> NDArray[np.float64]:
        """Positions of the frame in the world.

        Returns
        -------
        ndarray, shape (num_envs, 3)
            Positions [m].
        """
        where: NDArray[np.float64] = self.robot.frame_pose(self.q, self.frame)[:, :3, 3]
        return where

    def start(self, mask: NDArray[np.bool_]) -> None:
        """Start at rest in random configurations, with random targets."""
        count = int(mask.sum())
        seed = int(self.np_random.integers(2**32))
        start, goal = np.split(self.robot.random_configuration(2 * count, seed=seed), 2)
        self.q[mask], self.v[mask] = start, 0.0
        self.target[mask] = self.robot.frame_pose(goal, self.frame)[:, :3, 3]

    def torques(self, actions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Torques that carry the weight, plus fractions of the effort limits, clipped to these limits."""
        wanted = self.robot.gravity(self.q) + super().torques(actions)
        return np.clip(wanted, -self.effort, self.effort)

    def observe(self) -> NDArray[np.float64]:
        """q, v/5, and the vector from the frame to the target."""
        return np.concatenate([self.q, self.v / 5.0, self.target - self.tip()], axis=1)

    def reward(self, actions: NDArray[np.float64]) -> NDArray[np.float64]:
        """−distance − 0.01 |action|²/nv."""
        distance = np.linalg.norm(self.target - self.tip(), axis=1)
        rewards: NDArray[np.float64] = -distance - 0.01 * (actions**2).mean(axis=1)
        return rewards


def _register() -> None:
    try:
        import gymnasium
    except ImportError:
        return
    for name in ("SwingUp", "Reach", "Walk", "Lift"):
        identifier = f"robot_dynamics/{name}-v0"
        if identifier not in gymnasium.registry:
            gymnasium.register(identifier, vector_entry_point=f"robot_dynamics.gym:{name}")


_register()

__all__ = [
    "DIVERGED_SPEED",
    "DeviceWalk",
    "LeggedRobot",
    "Lift",
    "PENDULUM",
    "Pushes",
    "Randomization",
    "Reach",
    "RobotEnv",
    "SwingUp",
    "Walk",
    "humanoid",
    "quadruped",
    "rough_ground",
]
