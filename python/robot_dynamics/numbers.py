"""Types of arguments that stand for arrays of numbers."""

from __future__ import annotations

from typing import Any, Literal, Protocol, TypeAlias

from numpy.typing import ArrayLike


class SupportsDLPack(Protocol):
    """Array of another library, in the memory of this machine."""

    def __dlpack__(self, **options: Any) -> object:
        """Capsule with the array's memory."""

    def __dlpack_device__(self) -> tuple[int, int]:
        """Type and number of the device that holds the memory."""


Numbers: TypeAlias = ArrayLike | SupportsDLPack
"""Arrays, numbers, nested lists of numbers, and objects with ``__array__`` or DLPack."""

ControlReference: TypeAlias = Numbers | tuple[Numbers, Numbers, Numbers]
"""Reference of a controller: a position at rest, or a position with its velocity and acceleration."""

ReferenceFrame: TypeAlias = Literal["local", "world", "local_world_aligned"]
"""Axes and reference point of a frame's velocity, acceleration, Jacobian or wrench.

- ``local``: the frame's axes and origin.
- ``world``: the world's axes and origin.
- ``local_world_aligned``: the world's axes and the frame's origin.
"""
