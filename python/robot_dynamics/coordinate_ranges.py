"""Ranges of q and v that belong together: joints with quaternions, and the numbers between them."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


class CoordinateRange(NamedTuple):
    """Slices of q and of v for the same joints."""

    q: slice
    """Slice of the configuration."""
    v: slice
    """Slice of the velocity."""
    has_quaternion: bool
    """Whether the last four numbers of q are a quaternion; otherwise q and v have the same numbers here."""


@lru_cache(maxsize=64)
def coordinate_ranges(robot: Robot) -> tuple[CoordinateRange, ...]:
    """Joints with quaternions, and the ranges between them.

    Parameters
    ----------
    robot : Robot
        Robot.

    Returns
    -------
    tuple of CoordinateRange
        Slices, in the order of q.
    """
    found: list[CoordinateRange] = []
    for joint in robot.joints:
        width, rates = joint.q.stop - joint.q.start, joint.v.stop - joint.v.start
        if width > rates or not found or found[-1].has_quaternion:
            found.append(CoordinateRange(joint.q, joint.v, width > rates))
        elif width:
            last = found.pop()
            found.append(CoordinateRange(slice(last.q.start, joint.q.stop), slice(last.v.start, joint.v.stop), False))
    return tuple(found)
