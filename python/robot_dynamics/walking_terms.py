"""Observation and reward of walking, for arrays of NumPy and tensors of PyTorch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

LARGEST_TILT = 0.5
"""Cosine of the angle from upright at which an episode fails."""

Array: TypeAlias = Any
"""Array of NumPy, or tensor of PyTorch."""


@dataclass
class WalkingState:
    """State of all environments after a control step; the first axis is that of the environments."""

    xp: Any
    """Module of the arrays, `numpy` or `torch`."""
    v: Array
    """Velocities; the first six are those of the base in its frame."""
    gravity: Array
    """Direction of gravity in the base (environments, 3)."""
    command: Array
    """Commanded velocities and yaw rates (environments, 3)."""
    angles: Array
    """Angles of the joints relative to the posture [rad]."""
    joint_velocities: Array
    """Velocities of the joints [rad/s]."""
    height: Array
    """Height of the base above that of the posture [m]; NaN where there is no ground."""
    torques: Array
    """Torques of the joints [N·m]."""
    accelerations: Array
    """Accelerations of the joints [rad/s²]."""
    has_contact: Array
    """Contacts of the feet, of the base and of other links (environments, links)."""
    landed: Array
    """Time in the air of each foot that has touched down, 0 for others [s] (environments, feet)."""
    phase: Array
    """Part of the stride of the gait's clock, from 0 to 1."""
    last_actions: Array
    """Actions of this control step."""
    earlier_actions: Array
    """Actions of the control step before."""

    @property
    def feet(self) -> int:
        """Number of feet."""
        return int(self.landed.shape[1])


def gravity_direction(xp: Any, q: Array) -> Array:
    """Direction of gravity in the base's frame.

    Parameters
    ----------
    xp : module
        `numpy` or `torch`.
    q : array, shape (environments, nq)
        Configurations of a robot with a floating base.

    Returns
    -------
    array, shape (environments, 3)
        Directions.
    """
    x, y, z, w = (q[:, k] for k in range(3, 7))
    return xp.stack([2.0 * (w * y - x * z), -2.0 * (y * z + w * x), 2.0 * (x * x + y * y) - 1.0], 1)


def observation(state: WalkingState) -> Array:
    """Observation of `robot_dynamics.gym.Walk`.

    Parameters
    ----------
    state : WalkingState
        State.

    Returns
    -------
    array, shape (environments, observations)
        Observation.
    """
    xp, command = state.xp, state.command
    turn = 6.283185307179586 * state.phase
    parts = [
        2.0 * state.v[:, :3],
        0.25 * state.v[:, 3:6],
        state.gravity,
        2.0 * command[:, :2],
        0.25 * command[:, 2:],
        state.angles,
        0.05 * state.joint_velocities,
        state.last_actions,
        xp.sin(turn)[:, None],
        xp.cos(turn)[:, None],
    ]
    return xp.concatenate(parts, 1)


def has_failed(state: WalkingState) -> Array:
    """Whether the base touches something, or tilts.

    Parameters
    ----------
    state : WalkingState
        State.

    Returns
    -------
    array of bool, shape (environments,)
        Failures.
    """
    return state.has_contact[:, state.feet] | (state.gravity[:, 2] > -LARGEST_TILT)


def reward_terms(
    state: WalkingState, phases: Sequence[float], stride_time: float, control_period: float
) -> dict[str, Array]:
    """Terms of the reward of `robot_dynamics.gym.Walk`, without weights.

    Parameters
    ----------
    state : WalkingState
        State.
    phases : sequence of float
        Part of a stride by which each foot is ahead of the clock; empty without a gait.
    stride_time : float
        Period of the clock [s].
    control_period : float
        Length of a control step [s].

    Returns
    -------
    dict of str to array
        Terms by name.
    """
    xp, v, command, feet = state.xp, state.v, state.command, state.feet
    error = ((command[:, :2] - v[:, :2]) ** 2).sum(1)
    walks = xp.amax(abs(command), 1) > 0.1
    flown = xp.where(state.landed > 0.0, state.landed - 0.5 * stride_time, 0.0 * state.landed)
    return {
        "linear_velocity": xp.exp(-error / 0.25),
        "yaw_rate": xp.exp(-((command[:, 2] - v[:, 5]) ** 2) / 0.25),
        "vertical_velocity": v[:, 2] ** 2,
        "roll_pitch_rate": (v[:, 3:5] ** 2).sum(1),
        "tilt": (state.gravity[:, :2] ** 2).sum(1),
        "height": xp.nan_to_num(state.height) ** 2,
        "torque": (state.torques**2).sum(1),
        "joint_acceleration": (state.accelerations**2).sum(1),
        "action_rate": ((state.last_actions - state.earlier_actions) ** 2).sum(1),
        "collision": 1.0 * state.has_contact[:, feet + 1 :].sum(1),
        "gait": _gait(state, phases, walks),
        "air_time": flown.sum(1) * walks / control_period,
    }


def _gait(state: WalkingState, phases: Sequence[float], walks: Array) -> Array:
    """Agreement of the contacts of the feet with the gait, from −1 to 1."""
    if not phases:
        return 0.0 * state.phase
    columns = []
    for foot, phase in enumerate(phases):
        on_ground = ((state.phase + phase) % 1.0 < 0.5) | ~walks
        columns.append(2.0 * (state.has_contact[:, foot] == on_ground) - 1.0)
    return state.xp.stack(columns, 1).mean(1)


__all__ = ["LARGEST_TILT", "WalkingState", "gravity_direction", "has_failed", "observation", "reward_terms"]
