"""Walking with steps on a device: all numbers of all environments stay there.

Use it as `robot_dynamics.gym.DeviceWalk`. It needs PyTorch.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, TypeAlias

import numpy as np

from robot_dynamics import environment_state
from robot_dynamics._native import _contact_links
from robot_dynamics.errors import DescriptionError
from robot_dynamics.gpu import Device
from robot_dynamics.robot import Robot
from robot_dynamics.walking import COMMANDS, CONTACT_FORCE, STANDING, LeggedRobot, Range, quadruped, reward_weights
from robot_dynamics.walking_terms import WalkingState, gravity_direction, has_failed, observation, reward_terms

Tensor: TypeAlias = Any
"""Tensor of PyTorch, which is not imported before it is used."""


class DeviceWalk:
    """The task of `Walk` on flat ground, by `contact_step` on a device or on this processor.

    Observation, reward, commands and failures are those of `Walk`. Position control acts in each simulation
    step. The feet and the base touch the ground; other links do not. Contact is rigid, by a fixed number of
    sweeps, where `Walk` has MuJoCo's soft contact by default.

    It has the interface of `TorchEnv`: `reset` and `step` take and return tensors of the device. Environments
    restart in the step after their end, and that step has reward 0.

    With `differentiable`, observations and rewards have gradients by all actions since the last `detach`,
    through contact. Restarts and random numbers have none, and neither have contacts in the reward, because
    they are true or false. Rewards are not cut off at 0, since a cut-off reward has no gradient.

    Parameters
    ----------
    num_envs : int
        Number of environments.
    machine : LeggedRobot, optional
        Robot and its control; default: `quadruped()`.
    device : str, optional
        Device, ``"cuda"`` or ``"cpu"``; default: the first card, or this processor if there is none.
    commands : tuple of tuple of float
        Ranges of the commands: forward and left [m/s], yaw [rad/s].
    command_time : float
        Time between changes of the command [s].
    stride_time : float
        Period of the gait's clock [s].
    rewards : mapping of str to float, optional
        Weights that replace those of `robot_dynamics.walking.REWARDS`.
    dt : float
        Step size [s].
    substeps : int
        Number of steps in a control step.
    horizon : int
        Number of control steps in an episode.
    friction : tuple of float
        Range of the coefficient of friction, drawn for each episode.
    strength : tuple of float
        Range of the motors' strength as a fraction, drawn for each episode.
    sweeps : int
        Number of sweeps in a step.
    differentiable : bool
        Whether PyTorch records the steps for gradients.

    Attributes
    ----------
    num_envs : int
        Number of environments.
    observations : int
        Number of entries of an observation.
    actions : int
        Number of entries of an action.
    device : torch.device
        Device of the tensors.
    age : Tensor
        Control steps since the start of each episode.

    Raises
    ------
    ValueError
        A reward is unknown.
    DescriptionError
        A foot or the base has no shape that touches the ground.
    """

    def __init__(
        self,
        num_envs: int = 1024,
        machine: LeggedRobot | None = None,
        *,
        device: str | None = None,
        commands: tuple[Range, Range, Range] = COMMANDS,
        command_time: float = 5.0,
        stride_time: float = 0.5,
        rewards: Mapping[str, float] | None = None,
        dt: float = 4e-3,
        substeps: int = 5,
        horizon: int = 1000,
        friction: tuple[float, float] = (0.8, 0.8),
        strength: tuple[float, float] = (1.0, 1.0),
        sweeps: int = 8,
        differentiable: bool = False,
    ) -> None:
        import torch

        self.machine = quadruped() if machine is None else machine
        self.weights = reward_weights(rewards)
        """Weights of the rewards by name, per second."""
        machine = self.machine
        self.robot = _touching(machine.robot, [*machine.feet, machine.base])
        """Robot, of which only the feet and the base touch the ground."""
        self.num_envs, self.horizon, self.stride_time = num_envs, horizon, stride_time
        self.is_differentiable = differentiable
        self.dt, self.substeps, self.control_period = dt, substeps, dt * substeps
        where, step = Device(device), f"contact_step_{sweeps}_sweeps"
        self._step = where.compile(self.robot, [step], dtype="float32")[step]
        self.device = torch.device(where.name)
        self._torch = torch
        self._random = torch.Generator(self.device)
        moved = np.flatnonzero(self.robot.actuated_dofs)
        self.observations, self.actions = 14 + 3 * len(moved), len(moved)
        self._moved = torch.as_tensor(moved, device=self.device)
        self._posture = self._tensor(machine.configuration())
        self._gains = [self._tensor(gains) for gains in machine.gains()]
        self._effort = self._tensor(np.where(self.robot.actuated_dofs, self.robot.limits.effort, 0.0))
        self._ranges = [self._tensor(table) for table in (np.array(commands).T, friction, strength)]
        self._command_steps = max(1, round(command_time / self.control_period))
        self._points = self._contact_points()
        self._allocate()

    def _tensor(self, numbers: Any) -> Tensor:
        return self._torch.as_tensor(np.asarray(numbers), dtype=self._torch.float32, device=self.device)

    def _contact_points(self) -> Tensor:
        """Matrix that adds the normal impulses of the points of each foot and of the base (points, links)."""
        links, wanted = _contact_links(self.robot), [*self.machine.feet, self.machine.base]
        missing = [link for link in wanted if link not in links]
        if missing:
            raise DescriptionError(f"link `{missing[0]}` of robot `{self.robot.name}` has no shape that touches the ground")
        return self._tensor([[link == name for name in wanted] for link in links])

    def _allocate(self) -> None:
        torch, n, zeros = self._torch, self.num_envs, self._zeros
        self.q, self.v = self._posture.repeat(n, 1), zeros(self.robot.nv)
        self._impulses = zeros(*self._step.arguments["impulses"])
        self.command, self._friction, self._strength = zeros(3), zeros(1), zeros(1)
        self.age = torch.zeros(n, dtype=torch.long, device=self.device)
        self.last_actions, self.earlier_actions = zeros(self.actions), zeros(self.actions)
        feet = len(self.machine.feet)
        self.air_time, self._landed = zeros(feet), zeros(feet)
        self.has_contact = torch.zeros(n, feet + 1, dtype=torch.bool, device=self.device)
        self._torques, self._accelerations = zeros(self.robot.nv), zeros(self.robot.nv)
        self._has_ended = torch.zeros(n, dtype=torch.bool, device=self.device)
        self.terms: dict[str, Tensor] = {}
        """Terms of the last rewards by name, without their weights."""

    def _zeros(self, *shape: int) -> Tensor:
        return self._torch.zeros(self.num_envs, *shape, device=self.device)

    def _uniform(self, *shape: int) -> Tensor:
        return self._torch.rand(self.num_envs, *shape, generator=self._random, device=self.device)

    def reset(self, seed: int | None = None) -> Tensor:
        """Start an episode in every environment.

        Parameters
        ----------
        seed : int, optional
            Seed of all random numbers.

        Returns
        -------
        Tensor, shape (num_envs, observations)
            Observations.
        """
        if seed is not None:
            self._random.manual_seed(seed)
        self._restart(self._torch.ones_like(self._has_ended))
        return observation(self._state())

    def step(self, actions: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Take one control step in every environment.

        Parameters
        ----------
        actions : Tensor, shape (num_envs, actions)
            Changes of the joints' targets, clipped to [−1, 1].

        Returns
        -------
        observations : Tensor, shape (num_envs, observations)
            Observations.
        rewards : Tensor, shape (num_envs,)
            Rewards.
        terminated : Tensor of bool, shape (num_envs,)
            Whether an episode ended with failure.
        truncated : Tensor of bool, shape (num_envs,)
            Whether an episode ended without failure.
        """
        torch, again = self._torch, self._has_ended
        given = actions if self.is_differentiable else actions.detach()
        clipped = given.to(self.device, torch.float32).clamp(-1.0, 1.0)
        if self.is_differentiable:
            for tensor in (self.q, self.v, clipped):
                _drop_invalid_gradients(tensor)
        self.earlier_actions, self.last_actions = self.last_actions, clipped
        self._advance(clipped)
        self.age = self.age + 1
        self._measure()
        state = self._state()
        self.terms = reward_terms(state, self.machine.phases, self.stride_time, self.control_period)
        total = sum(self.weights[name] * term for name, term in self.terms.items())
        is_finite = torch.isfinite(self.q).all(1) & torch.isfinite(self.v).all(1)
        terminated = (has_failed(state) | ~is_finite) & ~again
        truncated = (self.age >= self.horizon) & ~terminated & ~again
        total = total if self.is_differentiable else total.clamp(min=0.0)
        rewards = torch.where(again, 0.0, self.control_period * total)
        rewards = torch.nan_to_num(rewards)
        self._restart(again | ~is_finite)
        self._has_ended = terminated | truncated
        return observation(self._state()), rewards, terminated, truncated

    def detach(self) -> None:
        """Forget the steps so far, so that later gradients end here.

        Call it before the steps of a horizon, whose rewards are then summed and differentiated.
        """
        for name in ("q", "v", "_impulses", "last_actions", "earlier_actions", "_torques", "_accelerations"):
            setattr(self, name, getattr(self, name).detach())

    def checkpoint(self) -> bytes:
        """All numbers that change, to continue later with the same bits.

        Returns
        -------
        bytes
            Checkpoint, a pickle without tensors.
        """
        return environment_state.save(self)

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
        environment_state.load(self, checkpoint)

    def _advance(self, actions: Tensor) -> None:
        """The steps of a control step, with position control in each."""
        torch, posture = self._torch, self._posture
        targets = posture[7:] + self.machine.action_scale * actions
        stiffness, damping = (gains[6:] for gains in self._gains)
        effort, q, v, impulses = self._effort[6:], self.q, self.v, self._impulses
        free = self._zeros(6)
        for _ in range(self.substeps):
            before = v
            wanted = stiffness * (targets - q[:, 7:]) - damping * v[:, 6:]
            tau = torch.cat([free, self._strength * torch.minimum(torch.maximum(wanted, -effort), effort)], 1)
            q, v, impulses = self._step(q, v, tau, self.dt, self._friction.squeeze(1), impulses)
        self.q, self.v, self._impulses = q, v, impulses
        self._torques, self._accelerations = tau, (v - before) / self.dt

    def _measure(self) -> None:
        """Contacts, times in the air, and new commands."""
        torch = self._torch
        normal = self._impulses[:, : 3 * len(self._points) : 3]
        self.has_contact = normal @ self._points > CONTACT_FORCE * self.dt
        feet = self.has_contact[:, :-1]
        air_time = self.air_time + self.control_period
        self._landed = air_time * (feet & (air_time > self.control_period))
        self.air_time = torch.where(feet, 0.0, air_time)
        due = self.age % self._command_steps == 0
        self.command = torch.where(due[:, None], self._commands(), self.command)

    def _commands(self) -> Tensor:
        low, high = self._ranges[0]
        return (low + (high - low) * self._uniform(3)) * (self._uniform(1) >= STANDING)

    def _restart(self, mask: Tensor) -> None:
        """Start near the standing posture, with a random heading and a new command."""
        torch, some = self._torch, mask[:, None]
        yaw = 2.0 * np.pi * (self._uniform(1) - 0.5)
        q = self._posture.repeat(self.num_envs, 1)
        q[:, 2] += 0.01
        q[:, 3:7] = torch.cat([0.0 * yaw, 0.0 * yaw, torch.sin(0.5 * yaw), torch.cos(0.5 * yaw)], 1)
        q[:, 7:] += 0.2 * (self._uniform(q.shape[1] - 7) - 0.5)
        drawn = [low + (high - low) * self._uniform(1) for low, high in self._ranges[1:]]
        starts = {
            "q": q,
            "v": 0.4 * (self._uniform(self.v.shape[1]) - 0.5),
            "_impulses": 0.0,
            "command": self._commands(),
            "_friction": drawn[0],
            "_strength": drawn[1],
            "last_actions": 0.0,
            "earlier_actions": 0.0,
            "air_time": 0.0,
            "_landed": 0.0,
        }
        for name, start in starts.items():
            setattr(self, name, torch.where(some, start, getattr(self, name)))
        self.age = torch.where(mask, 0, self.age)
        self._has_ended = self._has_ended & ~mask

    def _state(self) -> WalkingState:
        moved = self._moved
        return WalkingState(
            xp=self._torch,
            v=self.v,
            gravity=gravity_direction(self._torch, self.q),
            command=self.command,
            angles=self.q[:, 7:] - self._posture[7:],
            joint_velocities=self.v[:, moved],
            height=self.q[:, 2] - self.machine.height,
            torques=self._torques[:, moved],
            accelerations=self._accelerations[:, moved],
            has_contact=self.has_contact,
            landed=self._landed,
            phase=(self.age * self.control_period / self.stride_time) % 1.0,
            last_actions=self.last_actions,
            earlier_actions=self.earlier_actions,
        )


def _drop_invalid_gradients(tensor: Tensor) -> None:
    """Make gradients 0 in rows with a number that is not finite, which come from states that diverged."""
    if tensor.requires_grad and not tensor.is_leaf:
        tensor.register_hook(_finite_rows)


def _finite_rows(gradient: Tensor) -> Tensor:
    zeros: Tensor = gradient.new_zeros(())
    return gradient.where(gradient.isfinite().all(1, keepdim=True), zeros)


def _touching(robot: Robot, links: Collection[str]) -> Robot:
    """The robot without the collision shapes of other links."""
    description = robot.describe()
    shapes = description["shapes"]
    description["shapes"] = [shape for shape in shapes if shape["role"] != "collision" or shape["link"] in links]
    return Robot.from_description(description)


__all__ = ["DeviceWalk"]
