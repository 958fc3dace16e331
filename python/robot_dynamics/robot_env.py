"""Copies of a simulation of one robot that step together, as an environment to learn from.

Use it as `robot_dynamics.gym.RobotEnv`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import environment_state
from robot_dynamics.errors import BadSimulationsError, DescriptionError
from robot_dynamics.ground import AnyGround
from robot_dynamics.numbers import Numbers
from robot_dynamics.randomization import EpisodeFactors, PushSchedule, Pushes, Randomization, variants
from robot_dynamics.robot import Robot
from robot_dynamics.simulation import SimulationBatch
from robot_dynamics.vector_env import AutoresetMode, Box, VectorEnv, batch_space

if TYPE_CHECKING:
    from robot_dynamics.torch_env import TorchEnv

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
    `effort`. See `Robot.actuated_dofs`. With `stiffness`, they move the targets of the actuated joints
    instead: target = `posture` + `action_scale` · action. The torques stiffness (target − q) − damping v
    follow the state in every simulation step, within the effort limits.

    An episode is truncated after `horizon` control steps, or where `leave` says so, and terminated where
    `fail` says so. A state that diverges or cannot be computed terminates its own episode only. Its last
    valid configuration is kept, at rest.

    All random numbers come from the seed of `reset`. The same seed and actions give the same bits for any
    number of threads.

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
    stiffness : float or array_like, shape (nv,), optional
        Stiffness of position control [N·m/rad or N/m]; default: actions are torques or controls.
    damping : float or array_like, shape (nv,)
        Damping of position control [N·m·s/rad or N·s/m].
    posture : array_like, shape (nq,), optional
        Targets of position control for action 0; default: the initial configuration of the file.
    action_scale : float or array_like, shape (actions,)
        Change of the target by an action of 1 [rad or m].
    latency : int
        Control steps by which actions act later.
    noise : float or array_like, shape (observations,)
        Largest error of each entry of an observation; the errors are uniform.
    pushes : Pushes, optional
        Wrenches on a link at random times.
    randomization : Randomization, optional
        Ranges of parameters that differ between environments and episodes.
    **options
        Other options of `SimulationBatch`.

    Raises
    ------
    DescriptionError
        A joint lacks an effort limit, or an actuator lacks a control range.
    ValueError
        An option is invalid.
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
        stiffness: Numbers | None = None,
        damping: Numbers = 0.0,
        posture: Numbers | None = None,
        action_scale: Numbers = 0.25,
        latency: int = 0,
        noise: Numbers = 0.0,
        pushes: Pushes | None = None,
        randomization: Randomization | None = None,
        **options: Any,
    ) -> None:
        self.robot, self.num_envs, self.horizon = robot, num_envs, horizon
        how: dict[str, Any] = {"integrator": integrator, "conservative": conservative, "without": without, "ground": ground}
        how["variants"] = () if randomization is None else variants(robot, ground, randomization)
        self.simulations = SimulationBatch(robot, num_envs, dt=dt, threads=threads, **how, **options)
        """Simulations of the environments.

        `simulations[k]` is a copy of one, for tasks that need contacts, sensors or forces.
        """
        self.effort: NDArray[np.float64] = np.where(robot.actuated_dofs, robot.limits.effort if effort is None else effort, 0.0)
        """Torque of a full action (nv,) [N·m or N]; 0 on coordinates without a motor."""
        self.control_range = _control_range(robot, self.simulations.control_names)
        """Smallest and largest control of each acting actuator (actuators, 2)."""
        self.is_position_controlled = stiffness is not None
        """Whether actions are targets of joints."""
        width = int(robot.actuated_dofs.sum()) if self.is_position_controlled else len(self.control_range) or int(robot.actuated_dofs.sum())
        if not self.is_position_controlled and len(self.control_range) == 0 and not np.isfinite(self.effort).all():
            raise DescriptionError(f"robot `{robot.name}` has joints without an effort limit: give effort= [N·m or N]")
        if latency < 0:
            raise ValueError(f"latency is {latency}; it must be a number of control steps, at least 0")
        self.control_period = substeps * dt
        """Length of a control step [s]."""
        self._substeps, self._noise = substeps, np.broadcast_to(np.asarray(noise, np.float64), observations)
        bound = np.full(width, 1.0, np.float32)
        self.sizes = (observations, width)
        """Numbers of entries of an observation and of an action."""
        self.single_action_space = Box(-bound, bound)
        self.single_observation_space = Box(-np.inf, np.inf, (observations,), np.float32)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.q = self.simulations.q
        """Configurations (num_envs, nq)."""
        self.v = self.simulations.v
        """Velocities (num_envs, nv)."""
        self.last_actions = np.zeros((num_envs, width))
        """Actions of the last control step, clipped to [−1, 1] (num_envs, actions)."""
        self.earlier_actions = np.zeros((num_envs, width))
        """Actions of the control step before it (num_envs, actions)."""
        self._queue = np.zeros((latency + 1, num_envs, width))
        self.age = np.zeros(num_envs, np.int64)
        """Control steps since the start of the episode (num_envs,)."""
        self._has_ended = np.zeros(num_envs, bool)
        self._last_states = (self.q.copy(), self.v.copy())
        self.factors = EpisodeFactors(num_envs, randomization, substeps if self.is_position_controlled else 0)
        """Factors of strength and gains of each environment in its episode."""
        self._pushes = None if pushes is None else PushSchedule(pushes, num_envs, self.control_period)
        if stiffness is not None:
            self._position_gains(stiffness, damping, posture, action_scale)

    def _position_gains(self, stiffness: Numbers, damping: Numbers, posture: Numbers | None, action_scale: Numbers) -> None:
        moved = self.robot.actuated_dofs
        coordinates = np.zeros(self.robot.nv, np.intp)
        for joint in self.robot.joints:
            size = joint.v.stop - joint.v.start
            if size == 1:
                coordinates[joint.v] = joint.q.start
            elif moved[joint.v].any():
                raise DescriptionError(f"joint {joint.name!r} has {size} degrees of freedom: position control needs joints with one")
        self.controlled = coordinates[moved]
        """Indices in q of the coordinates that actions move (actions,)."""
        q = self.simulations.q[0] if posture is None else np.asarray(posture, np.float64)
        self.posture: NDArray[np.float64] = q
        """Configuration that action 0 holds (nq,)."""
        self.action_scale = np.broadcast_to(np.asarray(action_scale, np.float64), moved.sum())
        """Change of the targets by an action of 1 (actions,) [rad or m]."""
        self._gains = [np.where(moved, np.broadcast_to(np.asarray(gain, np.float64), self.robot.nv), 0.0) for gain in (stiffness, damping)]

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

    def measure(self) -> None:
        """Compute what several of the other methods use, after each control step. Subclasses may override
        it."""

    def fail(self) -> NDArray[np.bool_]:
        """Environments whose episode ends with failure. Subclasses may override it.

        Returns
        -------
        ndarray of bool, shape (num_envs,)
            Environments to terminate; by default none.
        """
        return np.zeros(self.num_envs, bool)

    def leave(self) -> NDArray[np.bool_]:
        """Environments whose episode ends before `horizon` without failure. Subclasses may override it.

        Returns
        -------
        ndarray of bool, shape (num_envs,)
            Environments to truncate; by default none.
        """
        return np.zeros(self.num_envs, bool)

    def targets(self, actions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Targets of position control.

        Parameters
        ----------
        actions : ndarray, shape (num_envs, actions)
            Actions in [−1, 1].

        Returns
        -------
        ndarray, shape (num_envs, nv)
            Targets of the joints [rad or m]; 0 on coordinates without a motor.
        """
        targets = np.zeros_like(self.v)
        targets[:, self.robot.actuated_dofs] = self.posture[self.controlled] + self.action_scale * actions
        return targets

    def torques(self, actions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Torques of the motors; zero if actuators of the file act or joints are position controlled.

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
        if len(self.control_range) == 0 and not self.is_position_controlled:
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
        return self._observations(), {}

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
            Whether the state diverged, or the task failed.
        truncated : ndarray of bool, shape (num_envs,)
            Whether the episode reached `horizon`, or left the task's range.
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
        self.earlier_actions, self.last_actions = self.last_actions, clipped
        written = self._changed_states() & ~again
        if written.any():
            try:
                self.simulations.set_state(self.q[written], self.v[written], where=written)
            except BadSimulationsError as error:
                lost[list(error.errors)] = True
                self.q[lost] = self._last_states[0][lost]
        moved = ~(again | lost)
        if moved.any():
            self._set_inputs(clipped)
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
        self.age += 1
        self.measure()
        lost |= self.fail() & ~again
        rewards = self.reward(clipped)
        truncated = (self.age >= self.horizon) | self.leave()
        if again.any():
            self._restart(again)
            rewards[again], truncated[again], lost[again] = 0.0, False, False
        self._has_ended = lost | truncated
        return self._observations(), rewards, lost, truncated & ~lost, {}

    def checkpoint(self) -> bytes:
        """All numbers that change, to continue later with the same bits.

        These environments and those that `restore` the checkpoint take the same steps from here, bit by bit.
        The solver of contact starts anew at a checkpoint, as after `SimulationBatch.set_state`. So the last
        digits of later steps depend on where checkpoints are made.

        Attributes of subclasses are kept if they are numbers, arrays, texts, generators of random numbers, or
        lists and dictionaries of these. Wrenches that a subclass sets itself, the simulations' times and the
        yield of springs are not kept.

        Returns
        -------
        bytes
            Checkpoint, a pickle.

        Raises
        ------
        BadSimulationsError
            Some simulations cannot start from their states.

        Examples
        --------
        >>> from robot_dynamics.gym import SwingUp
        >>> envs, others = SwingUp(4), SwingUp(4)
        >>> _ = envs.reset(seed=1)
        >>> others.restore(envs.checkpoint())
        >>> actions = np.full((4, 1), 0.5)
        >>> np.array_equal(envs.step(actions)[0], others.step(actions)[0])
        True
        """
        return environment_state.save(self, environment_state.restart(self.simulations, self._has_ended))

    def restore(self, checkpoint: bytes) -> None:
        """Continue from a checkpoint of environments that were made in the same way.

        Parameters
        ----------
        checkpoint : bytes
            Result of `checkpoint`. It is a pickle, which can run code: restore only checkpoints of your own.

        Raises
        ------
        ValueError
            The checkpoint is of other environments.
        """
        tables = environment_state.load(self, checkpoint)
        if self.is_position_controlled:
            self._set_gains()
        environment_state.resume(self.simulations, tables, self._has_ended)

    def _set_gains(self) -> None:
        """Set the gains of position control of all environments."""
        stiffness, damping = self._gains
        self.simulations.set_position_control(
            stiffness * self.factors.stiffness * self.factors.strength,
            damping * self.factors.damping * self.factors.strength,
            limits=np.where(self.robot.actuated_dofs, self.effort, np.inf) * self.factors.strength,
            delay=self.factors.delay,
        )

    def _set_inputs(self, actions: NDArray[np.float64]) -> None:
        """Set the inputs of the next steps, and the pushes."""
        if len(self._queue) > 1:
            self._queue = np.roll(self._queue, 1, axis=0)
            self._queue[0] = actions
            actions = self._queue[-1]
        self.simulations.torques, self.simulations.controls = self.torques(actions) * self.factors.strength, self.controls(actions)
        if self.is_position_controlled:
            self.simulations.targets = self.targets(actions)
        if self._pushes is not None:
            self._pushes.advance(self.simulations, self.np_random)

    def _observations(self) -> NDArray[np.float32]:
        seen = self.observe()
        if self._noise.any():
            seen = seen + self._noise * self.np_random.uniform(-1.0, 1.0, seen.shape)
        return seen.astype(np.float32)

    def torch(self, device: Any = "cpu") -> TorchEnv:
        """These environments with tensors of PyTorch in and out.

        Parameters
        ----------
        device : str or torch.device
            Device of the tensors.

        Returns
        -------
        TorchEnv
            Environments that share this object.

        Raises
        ------
        ImportError
            PyTorch is not installed.
        """
        from robot_dynamics.torch_env import TorchEnv

        return TorchEnv(self, device)

    def _changed_states(self) -> NDArray[np.bool_]:
        """Environments whose q or v was written since the last step."""
        q, v = self._last_states
        written: NDArray[np.bool_] = (self.q != q).any(axis=1) | (self.v != v).any(axis=1)
        return written

    def _restart(self, mask: NDArray[np.bool_]) -> None:
        self.start(mask)
        self.simulations.reset(self.q[mask], self.v[mask], where=mask)
        self.last_actions[mask] = self.earlier_actions[mask] = self._queue[:, mask] = 0.0
        if self.factors.draw(mask, self.np_random) and self.is_position_controlled:
            self._set_gains()
        if self._pushes is not None:
            self._pushes.restart(mask, self.np_random)
        self._last_states = (self.q.copy(), self.v.copy())
        self.age[mask], self._has_ended[mask] = 0, False


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


__all__ = ["DIVERGED_SPEED", "RobotEnv"]
