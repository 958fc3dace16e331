"""Task to walk with legs: a robot tracks commanded velocities on flat or rough ground.

Use it as `robot_dynamics.gym.Walk`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.ground import AnyGround, Ground, HeightField
from robot_dynamics.loading import example
from robot_dynamics.robot import Robot
from robot_dynamics.robot_env import RobotEnv
from robot_dynamics.walking_terms import WalkingState, gravity_direction, has_failed, observation, reward_terms

CONTACT_FORCE = 1.0
"""Force from which a link counts as in contact [N]."""

MARGIN = 0.5
"""Distance to the edge of a height field at which an episode ends [m]."""

STANDING = 0.1
"""Fraction of the commands that are zero."""

HUMANOID_POSTURE = {"hip_pitch": -0.3, "knee": 0.6, "ankle_pitch": -0.3}
"""Angles of each leg of the humanoid while it stands [rad]."""

REWARDS: Mapping[str, float] = {
    "linear_velocity": 1.0,
    "yaw_rate": 0.5,
    "vertical_velocity": -2.0,
    "roll_pitch_rate": -0.05,
    "tilt": -1.0,
    "height": -20.0,
    "torque": -1e-4,
    "joint_acceleration": -1e-7,
    "action_rate": -0.01,
    "collision": -0.5,
    "gait": 1.0,
    "air_time": 0.0,
}
"""Weights of the terms of `Walk.reward`, per second."""

Range: TypeAlias = tuple[float, float]

COMMANDS: tuple[Range, Range, Range] = ((-0.6, 1.0), (-0.4, 0.4), (-0.8, 0.8))
"""Ranges of the commanded velocities forward and to the left [m/s], and of the yaw rate [rad/s]."""


def reward_weights(replaced: Mapping[str, float] | None) -> dict[str, float]:
    """Weights of the rewards by name, per second.

    Parameters
    ----------
    replaced : mapping of str to float, optional
        Weights that replace those of `REWARDS`.

    Returns
    -------
    dict of str to float
        All weights.

    Raises
    ------
    ValueError
        A reward is unknown.
    """
    unknown = [name for name in replaced or () if name not in REWARDS]
    if unknown:
        raise ValueError(f"there is no reward {unknown[0]!r}; there are {', '.join(REWARDS)}")
    return dict(REWARDS) | dict(replaced or {})


@dataclass(frozen=True)
class LeggedRobot:
    """Robot with legs, and how its joints are controlled."""

    robot: Robot
    """Robot with a floating base."""
    base: str
    """Link that must not touch the ground."""
    feet: Sequence[str]
    """Links that shall touch the ground."""
    posture: Mapping[str, float]
    """Angles of joints while it stands [rad]; 0 for others."""
    height: float
    """Height of the base's origin above the ground while it stands [m]."""
    stiffness: float | Mapping[str, float]
    """Stiffness of all joints, or of each [N·m/rad]."""
    damping: float | Mapping[str, float]
    """Damping of all joints, or of each [N·m·s/rad]."""
    action_scale: float = 0.5
    """Change of a target by an action of 1 [rad]."""
    phases: Sequence[float] = ()
    """Part of a stride by which each foot is ahead of the clock, from 0 to 1; empty for a robot without
    gait."""

    def configuration(self) -> NDArray[np.float64]:
        """Configuration of the posture (nq,) at the height."""
        q = np.zeros(self.robot.nq)
        q[2], q[6] = self.height, 1.0
        for joint in self.robot.joints:
            if joint.name in self.posture:
                q[joint.q] = self.posture[joint.name]
        return q

    def gains(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Stiffness and damping of each degree of freedom (nv,)."""
        tables = np.zeros((2, self.robot.nv))
        for joint in self.robot.joints:
            for table, given in zip(tables, (self.stiffness, self.damping), strict=True):
                table[joint.v] = given[joint.name] if isinstance(given, Mapping) and joint.name in given else 0.0
                if not isinstance(given, Mapping):
                    table[joint.v] = given
        return tables[0], tables[1]


def quadruped() -> LeggedRobot:
    """The quadruped of the examples, which stands on bent legs."""
    legs = [f"{end}_{side}" for end in ("front", "hind") for side in ("left", "right")]
    posture = {f"{leg}_hip_pitch": 0.7 for leg in legs} | {f"{leg}_knee": -1.4 for leg in legs}
    robot = example("quadruped", floating_base=True)
    return LeggedRobot(robot, "trunk", [f"{leg}_foot" for leg in legs], posture, 0.34, 80.0, 1.0, 0.4, (0.0, 0.5, 0.5, 0.0))


def humanoid() -> LeggedRobot:
    """The humanoid of the examples, on slightly bent legs; `Walk` runs with it, but no policy has been
    trained."""
    posture = {f"{side}_{joint}": angle for side in ("left", "right") for joint, angle in HUMANOID_POSTURE.items()}
    robot = example("humanoid", floating_base=True)
    stiffness, damping = {}, {}
    for joint in robot.joints:
        if joint.v.stop - joint.v.start == 1:
            stiffness[joint.name] = min(300.0, 2.0 * joint.limits.effort)
            damping[joint.name] = 0.01 * stiffness[joint.name]
    feet = ["left_foot", "right_foot", "left_toes", "right_toes"]
    return LeggedRobot(robot, "pelvis", feet, posture, 0.949, stiffness, damping, 0.3, (0.0, 0.5, 0.0, 0.5))


def rough_ground(
    seed: int = 1, *, length: float = 24.0, roughness: float = 0.04, cell: float = 0.1, width: float = 0.4
) -> HeightField:
    """Square height field of smooth bumps.

    Parameters
    ----------
    seed : int
        Seed of the bumps.
    length : float
        Length of a side [m].
    roughness : float
        Largest height above and below zero [m].
    cell : float
        Distance of two points of the grid [m].
    width : float
        Distance of two bumps [m].

    Returns
    -------
    HeightField
        Ground with its centre at the world's origin.
    """
    count, coarse = round(length / cell) + 1, round(length / width) + 1
    bumps = np.random.default_rng(seed).uniform(-roughness, roughness, (coarse, coarse))
    at = np.linspace(0.0, coarse - 1.0, count)
    low = np.minimum(at.astype(np.intp), coarse - 2)
    part = at - low
    share = part * part * (3.0 - 2.0 * part)
    rows = bumps[low] * (1.0 - share)[:, np.newaxis] + bumps[low + 1] * share[:, np.newaxis]
    heights = rows[:, low] * (1.0 - share) + rows[:, low + 1] * share
    return HeightField(heights, (0.5 * length, 0.5 * length))


class Walk(RobotEnv):
    """Task to walk with commanded velocities.

    Actions move the targets of the joints around the standing posture; see `RobotEnv`. A command has the
    velocity forward and to the left [m/s] and the yaw rate [rad/s] of the base. It is drawn at the start of
    an episode and every `command_time` seconds; one command in ten is zero.

    The observation has, in this order:

    - linear and angular velocity of the base in its frame (times 2 and 0.25);
    - direction of gravity in that frame;
    - command (times 2, 2 and 0.25);
    - angles of the joints relative to the posture, and their velocities (times 0.05);
    - last actions;
    - sine and cosine of the angle of the gait's clock.

    The reward of a control step is its length times the weighted sum of these terms, and at least 0:

    - ``linear_velocity`` and ``yaw_rate``: exp(−error²/0.25), for both horizontal velocities and the yaw
      rate;
    - ``vertical_velocity`` and ``roll_pitch_rate``: squares of these velocities of the base;
    - ``tilt``: square of the horizontal part of gravity's direction in the base;
    - ``height``: square of the difference from the standing height above the ground;
    - ``torque`` and ``joint_acceleration``: sums of their squares over the joints;
    - ``action_rate``: sum of the squared differences of two successive actions;
    - ``collision``: number of links other than feet that touch something;
    - ``gait``: mean over the feet of 1 for each that is where the clock asks for it, and −1 otherwise. Each
      foot is on the ground for half of the stride; a zero command asks for all feet on the ground;
    - ``air_time``: time of a foot in the air minus half of `stride_time`, at its touchdown, if the command is
      not zero.

    An episode fails if the base touches something or tilts by more than 60°. It ends at the edge of a height
    field.

    Parameters
    ----------
    num_envs : int
        Number of environments.
    machine : LeggedRobot, optional
        Robot and its control; default: `quadruped()`.
    ground : Ground or HeightField, optional
        Ground; default: a plane. See `rough_ground`.
    commands : tuple of tuple of float
        Ranges of the commands: forward and left [m/s], yaw [rad/s].
    command_time : float
        Time between changes of the command [s].
    stride_time : float
        Period of the gait's clock [s].
    rewards : mapping of str to float, optional
        Weights that replace those of `REWARDS`.
    **options
        Options of `RobotEnv`. Defaults: steps of 4 ms, 5 in a control step, episodes of 1000 control steps,
        the integrator ``mujoco``, and no contact of links with each other.

    Raises
    ------
    ValueError
        A reward or an option is invalid.
    """

    def __init__(
        self,
        num_envs: int = 1,
        machine: LeggedRobot | None = None,
        *,
        ground: AnyGround | None = None,
        commands: tuple[Range, Range, Range] = COMMANDS,
        command_time: float = 5.0,
        stride_time: float = 0.5,
        rewards: Mapping[str, float] | None = None,
        **options: Any,
    ) -> None:
        self.machine = quadruped() if machine is None else machine
        weights = reward_weights(rewards)
        robot, self.ground = self.machine.robot, Ground() if ground is None else ground
        stiffness, damping = self.machine.gains()
        defaults: dict[str, Any] = {"dt": 4e-3, "substeps": 5, "horizon": 1000, "integrator": "mujoco", "only_contacts": []}
        defaults |= {"stiffness": stiffness, "damping": damping, "posture": self.machine.configuration()}
        defaults |= {"action_scale": self.machine.action_scale}
        joints = int(robot.actuated_dofs.sum())
        super().__init__(num_envs, robot, observations=14 + 3 * joints, ground=self.ground, **(defaults | options))
        self.weights = weights
        """Weights of the rewards by name, per second."""
        self.commands, self.stride_time = np.array(commands), stride_time
        self._command_steps = max(1, round(command_time / self.control_period))
        self.command = np.zeros((num_envs, 3))
        """Commanded velocities forward and to the left [m/s], and yaw rates [rad/s] (num_envs, 3)."""
        self.terms: dict[str, NDArray[np.float64]] = {}
        """Terms of the last rewards by name, without their weights, each (num_envs,)."""
        shapes = [link.name for link in robot.links if link.name not in self.machine.feet]
        self._links = [*self.machine.feet, self.machine.base, *(name for name in shapes if name != self.machine.base)]
        self.has_contact = np.zeros((num_envs, len(self._links)), bool)
        """Contacts of the feet, of the base, and of all other links (num_envs, links)."""
        self.air_time = np.zeros((num_envs, len(self.machine.feet)))
        """Time since each foot was on the ground [s] (num_envs, feet)."""
        self._landed = np.zeros_like(self.air_time)

    @property
    def phase(self) -> NDArray[np.float64]:
        """Part of the stride of the gait's clock, from 0 to 1 (num_envs,)."""
        return np.asarray((self.age * self.control_period / self.stride_time) % 1.0, np.float64)

    @property
    def gravity_direction(self) -> NDArray[np.float64]:
        """Direction of gravity in the base's frame (num_envs, 3)."""
        direction: NDArray[np.float64] = gravity_direction(np, self.q)
        return direction

    def ground_height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Height of the ground at points of the world; NaN where there is none.

        Parameters
        ----------
        x : ndarray
            Coordinates [m].
        y : ndarray
            Coordinates [m].

        Returns
        -------
        ndarray
            Heights [m].
        """
        if isinstance(self.ground, HeightField):
            return self.ground.height(x, y)
        slope, z = (self.ground.slope, self.ground.z) if isinstance(self.ground, Ground) else (0.0, 0.0)
        heights: NDArray[np.float64] = z + np.tan(slope) * np.asarray(x, np.float64)
        return heights

    def start(self, mask: NDArray[np.bool_]) -> None:
        """Start near the standing posture, with a random heading and a new command."""
        count, joints = int(mask.sum()), self.q.shape[1] - 7
        random = self.np_random
        q = np.tile(self.posture, (count, 1))
        if isinstance(self.ground, HeightField):
            half = np.array(self.ground.half_size)
            q[:, :2] = self.ground.position[:2] + random.uniform(-0.6, 0.6, (count, 2)) * half
        else:
            q[:, :2] = 0.0
        yaw = random.uniform(-np.pi, np.pi, count)
        q[:, 3:7] = np.stack([0.0 * yaw, 0.0 * yaw, np.sin(0.5 * yaw), np.cos(0.5 * yaw)], axis=1)
        q[:, 7:] += random.uniform(-0.1, 0.1, (count, joints))
        around = np.linspace(-0.3, 0.3, 5)
        x, y = np.meshgrid(around, around)
        heights = self.ground_height(q[:, :1] + x.ravel(), q[:, 1:2] + y.ravel())
        q[:, 2] += np.nanmax(heights, axis=1) + 0.01
        self.q[mask] = q
        self.v[mask] = random.uniform(-0.2, 0.2, (count, self.v.shape[1]))
        self.air_time[mask] = 0.0
        self._draw_commands(mask)

    def _draw_commands(self, mask: NDArray[np.bool_]) -> None:
        count = int(mask.sum())
        drawn = self.np_random.uniform(self.commands[:, 0], self.commands[:, 1], (count, 3))
        self.command[mask] = drawn * (self.np_random.uniform(size=(count, 1)) >= STANDING)

    def measure(self) -> None:
        """Contacts and times in the air, and new commands."""
        forces = self.simulations.contact_forces(self._links)
        self.has_contact = (forces**2).sum(axis=2) > CONTACT_FORCE**2
        feet = self.has_contact[:, : self.air_time.shape[1]]
        self.air_time += self.control_period
        self._landed = self.air_time * (feet & (self.air_time > self.control_period))
        self.air_time[feet] = 0.0
        due = (self.age > 0) & (self.age % self._command_steps == 0)
        if due.any():
            self._draw_commands(due)

    def fail(self) -> NDArray[np.bool_]:
        """Whether the base touches something, or tilts."""
        failed: NDArray[np.bool_] = has_failed(self._state())
        return failed

    def leave(self) -> NDArray[np.bool_]:
        """Whether the base is near the edge of the ground."""
        if not isinstance(self.ground, HeightField):
            return super().leave()
        away = np.abs(self.q[:, :2] - self.ground.position[:2])
        return np.asarray((away > np.array(self.ground.half_size) - MARGIN).any(axis=1), bool)

    def observe(self) -> NDArray[np.float64]:
        """Velocities and gravity in the base, command, joints, and last actions."""
        seen: NDArray[np.float64] = observation(self._state())
        return seen

    def reward(self, actions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weighted terms, at least 0."""
        self.terms = reward_terms(self._state(), self.machine.phases, self.stride_time, self.control_period)
        total = sum(self.weights[name] * term for name, term in self.terms.items())
        rewards: NDArray[np.float64] = self.control_period * np.maximum(total, 0.0)
        return rewards

    def _state(self) -> WalkingState:
        moved = self.robot.actuated_dofs
        return WalkingState(
            xp=np,
            v=self.v,
            gravity=self.gravity_direction,
            command=self.command,
            angles=self.q[:, self.controlled] - self.posture[self.controlled],
            joint_velocities=self.v[:, moved],
            height=self.q[:, 2] - self.ground_height(self.q[:, 0], self.q[:, 1]) - self.machine.height,
            torques=self.simulations.applied_torques[:, moved],
            accelerations=self.simulations.acceleration[:, moved],
            has_contact=self.has_contact,
            landed=self._landed,
            phase=self.phase,
            last_actions=self.last_actions,
            earlier_actions=self.earlier_actions,
        )


__all__ = ["LeggedRobot", "REWARDS", "Walk", "humanoid", "quadruped", "rough_ground"]
