"""Gymnasium: many simulations of a robot with a task, which step together.

It needs the extra ``robot-dynamics[gym]``.

    import gymnasium
    import robot_dynamics.gym

    envs = gymnasium.make_vec("robot_dynamics/SwingUp-v0", num_envs=1000)     # or SwingUp(1000), Reach(1000,
    robot) observations, _ = envs.reset(seed=1) observations, rewards, terminated, truncated, _ =
    envs.step(envs.action_space.sample())

Environments restart in the step after their end, like the vector environments of Gymnasium
(``AutoresetMode.NEXT_STEP``). The same seed and actions give the same bits, for any number of threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from robot_dynamics.errors import BadSimulationsError, DescriptionError
from robot_dynamics.ground import AnyGround
from robot_dynamics.loading import example, loads
from robot_dynamics.robot import Robot
from robot_dynamics.simulation import SimulationBatch

PENDULUM = """<robot name="pendulum"><link name="stand"/><link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
<inertia ixx="0.0833" iyy="0.0833" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="stand"/><child link="rod"/><axis xyz="0 1 0"/>
<limit effort="2" velocity="20"/></joint></robot>"""
"""Rod of 1 kg and 1 m that hangs at q = 0 and stands at π.

Its motor has 2 N·m; gravity pulls with up to 4.9 N·m.
"""


DIVERGED_SPEED = 1e4
"""Speed [rad/s or m/s] beyond which a state counts as diverged."""


class RobotEnv(VectorEnv[NDArray[np.float32], NDArray[Any], NDArray[Any]]):
    """Copies of a `Simulation` of one robot.

    Subclasses define a task: initial states, observations and rewards.

    Everything that the robot's file states acts, as in `Simulation`: contact, position limits, equalities,
    damping, actuators.

    Actions are numbers in [−1, 1], held over a control step of `substeps` steps of `dt` seconds. If actuators
    of the file act, actions (num_envs, actuators) scale the ranges of their controls; 0 is the middle.
    Otherwise actions (num_envs, actuated degrees of freedom) are fractions of the effort limits, or of
    `effort`. See `Robot.actuated_dofs`.

    An episode is truncated after `horizon` control steps. A state that diverges or cannot be computed
    terminates its own episode only. Its last valid configuration is kept, at rest.

    Parameters
    ----------
    num_envs : int
        Number of environments.
    robot : Robot
        Robot to simulate.
    observations : int
        Number of entries of an observation.
    dt : float
        Step size [s].
    substeps : int
        Number of steps in a control step.
    horizon : int
        Number of control steps in an episode.
    effort : float, optional
        Torque of a full action [N·m or N]; default: the effort limits.
    integrator : str, optional
        Method; see `Robot.simulate`.
    conservative : bool
        Whether to leave out damping, friction, limits, actuators and contact.
    without : sequence of str
        Effects to leave out; see `Robot.simulate`.
    ground : Ground, HeightField or "file", optional
        Ground below the robot; see `Robot.simulate`.
    threads : int, optional
        Threads for a batch; default: `num_threads()`.
    **options
        Other options of `SimulationBatch`.

    Raises
    ------
    DescriptionError
        A joint lacks an effort limit, or an actuator lacks a control range.
    """

    metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": []}

    def __init__(
        self,
        num_envs: int,
        robot: Robot,
        *,
        observations: int,
        dt: float = 5e-3,
        substeps: int = 4,
        horizon: int = 250,
        effort: float | None = None,
        integrator: str | None = None,
        conservative: bool = False,
        without: Sequence[str] = (),
        ground: AnyGround | None = None,
        threads: int | None = None,
        **options: Any,
    ) -> None:
        self.robot, self.num_envs, self.horizon = robot, num_envs, horizon
        how: dict[str, Any] = {"integrator": integrator, "conservative": conservative, "without": without, "ground": ground}
        self.simulations = SimulationBatch(robot, num_envs, dt=dt, threads=threads, **how, **options)
        """Simulations of the environments.

        `simulations[k]` is a copy of one, for tasks that need contacts, sensors or forces.
        """
        self.effort: NDArray[np.float64] = np.where(robot.actuated_dofs, robot.limits.effort if effort is None else effort, 0.0)
        """Torque of a full action (nv,) [N·m or N]; 0 on coordinates without a motor."""
        self.control_range = _control_range(robot, self.simulations.control_names)
        """Smallest and largest control of each acting actuator (actuators, 2)."""
        width = len(self.control_range) or int(robot.actuated_dofs.sum())
        if len(self.control_range) == 0 and not np.isfinite(self.effort).all():
            raise DescriptionError(f"robot `{robot.name}` has joints without an effort limit: give effort= [N·m or N]")
        self._substeps = substeps
        bound = np.full(width, 1.0, np.float32)
        self.single_action_space = gymnasium.spaces.Box(-bound, bound)
        self.single_observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (observations,), np.float32)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.q = self.simulations.q
        """Configurations (num_envs, nq)."""
        self.v = self.simulations.v
        """Velocities (num_envs, nv)."""
        self._age = np.zeros(num_envs, np.int64)
        self._has_ended = np.zeros(num_envs, bool)
        self._last_states = (self.q.copy(), self.v.copy())

    def start(self, mask: NDArray[np.bool_]) -> None:
        """Write initial states of environments to `q` and `v`. Subclasses implement it.

        Parameters
        ----------
        mask : ndarray of bool, shape (num_envs,)
            Environments to start.
        """
        raise NotImplementedError

    def observe(self) -> NDArray[np.float64]:
        """Observations of all environments. Subclasses implement it.

        Returns
        -------
        ndarray, shape (num_envs, observations)
            Observations.
        """
        raise NotImplementedError

    def reward(self, actions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Rewards of the current states. Subclasses implement it.

        Parameters
        ----------
        actions : ndarray, shape (num_envs, actions)
            Actions of the last control step, clipped to [−1, 1].

        Returns
        -------
        ndarray, shape (num_envs,)
            Rewards.
        """
        raise NotImplementedError

    def torques(self, actions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Torques of the motors; zero if actuators of the file act.

        Parameters
        ----------
        actions : ndarray, shape (num_envs, actions)
            Actions in [−1, 1].

        Returns
        -------
        ndarray, shape (num_envs, nv)
            Torques [N·m or N].
        """
        torques = np.zeros_like(self.v)
        if len(self.control_range) == 0:
            torques[:, self.robot.actuated_dofs] = actions * self.effort[self.robot.actuated_dofs]
        return torques

    def controls(self, actions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Controls of the file's actuators.

        Parameters
        ----------
        actions : ndarray, shape (num_envs, actions)
            Actions in [−1, 1].

        Returns
        -------
        ndarray, shape (num_envs, actuators)
            Controls.
        """
        if len(self.control_range) == 0:
            return np.zeros((self.num_envs, 0))
        least, most = self.control_range.T
        controls: NDArray[np.float64] = 0.5 * (least + most) + 0.5 * (most - least) * actions
        return controls

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Start an episode in every environment.

        Parameters
        ----------
        seed : int, optional
            Seed of all random numbers, for these episodes and later ones.
        options : dict, optional
            Not used.

        Returns
        -------
        observations : ndarray, shape (num_envs, observations)
            Observations.
        info : dict
            Empty.

        Raises
        ------
        TypeError
            `seed` is a list.
        """
        if isinstance(seed, list):
            raise TypeError("one seed for all environments: they share a generator")
        super().reset(seed=seed)
        self._restart(np.ones(self.num_envs, bool))
        return self.observe().astype(np.float32), {}

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[NDArray[np.float32], NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Take one control step in every environment.

        Environments that ended in the last step restart instead, with reward 0.

        Parameters
        ----------
        actions : array_like, shape (num_envs, actions)
            Actions, which are clipped to [−1, 1].

        Returns
        -------
        observations : ndarray, shape (num_envs, observations)
            Observations.
        rewards : ndarray, shape (num_envs,)
            Rewards.
        terminated : ndarray of bool, shape (num_envs,)
            Whether the state diverged.
        truncated : ndarray of bool, shape (num_envs,)
            Whether the episode reached `horizon`.
        info : dict
            Empty.

        Raises
        ------
        ValueError
            `actions` has the wrong shape.
        """
        given = np.asarray(actions, np.float64)
        if given.shape != self.action_space.shape:
            raise ValueError(f"actions have shape {given.shape}, they must have {self.action_space.shape}")
        again, lost = self._has_ended.copy(), np.zeros(self.num_envs, bool)
        clipped = np.clip(given, -1.0, 1.0)
        written = self._changed_states() & ~again
        if written.any():
            try:
                self.simulations.set_state(self.q[written], self.v[written], where=written)
            except BadSimulationsError as error:
                lost[list(error.errors)] = True
                self.q[lost] = self._last_states[0][lost]
        moved = ~(again | lost)
        if moved.any():
            self.simulations.torques, self.simulations.controls = self.torques(clipped), self.controls(clipped)
            try:
                self.simulations.step(self._substeps, where=None if moved.all() else moved)
            except BadSimulationsError as error:
                lost[list(error.errors)] = True
            q, v = self.simulations.q, self.simulations.v
            lost |= moved & ~(np.abs(v) <= DIVERGED_SPEED).all(axis=1)
            kept = moved & ~lost
            self.q[kept], self.v[kept] = q[kept], v[kept]
        self.v[lost] = 0.0
        self._last_states = (self.q.copy(), self.v.copy())
        self._age += 1
        rewards = self.reward(clipped)
        truncated = self._age >= self.horizon
        if again.any():
            self._restart(again)
            rewards[again], truncated[again], lost[again] = 0.0, False, False
        self._has_ended = lost | truncated
        return self.observe().astype(np.float32), rewards, lost, truncated & ~lost, {}

    def _changed_states(self) -> NDArray[np.bool_]:
        """Environments whose q or v was written since the last step."""
        q, v = self._last_states
        written: NDArray[np.bool_] = (self.q != q).any(axis=1) | (self.v != v).any(axis=1)
        return written

    def _restart(self, mask: NDArray[np.bool_]) -> None:
        self.start(mask)
        self.simulations.reset(self.q[mask], self.v[mask], where=mask)
        self._last_states = (self.q.copy(), self.v.copy())
        self._age[mask], self._has_ended[mask] = 0, False


def _control_range(robot: Robot, names: Sequence[str]) -> NDArray[np.float64]:
    """Smallest and largest control of each actuator (names, 2)."""
    ranges = {actuator["name"]: actuator["control_range"] for actuator in robot.describe()["actuators"]}
    table = np.array([ranges[name] or (-np.inf, np.inf) for name in names], np.float64).reshape(-1, 2)
    endless = [name for name, limits in zip(names, table, strict=True) if not np.isfinite(limits).all()]
    if endless:
        raise DescriptionError(
            f"robot `{robot.name}` has actuators without a control range, for example {endless[0]!r}: give them one in the file, "
            'or disable them with without=["actuators"]'
        )
    return table


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


for _name, _task in (("SwingUp", SwingUp), ("Reach", Reach)):
    _id = f"robot_dynamics/{_name}-v0"
    if _id not in gymnasium.registry:
        gymnasium.register(_id, vector_entry_point=f"robot_dynamics.gym:{_name}")
