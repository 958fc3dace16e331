"""What may be given where numbers are asked for."""

from __future__ import annotations

from typing import Any, Protocol, TypeAlias

from numpy.typing import ArrayLike


class SupportsDLPack(Protocol):
    """An array of another library, in this machine's memory."""

    def __dlpack__(self, **options: Any) -> Any:
        """Its memory."""

    def __dlpack_device__(self) -> tuple[int, int]:
        """Where that is."""


Numbers: TypeAlias = ArrayLike | SupportsDLPack
"""Arrays, numbers, lists of them, and what offers ``__array__`` or DLPack."""

Followed: TypeAlias = Numbers | tuple[Numbers, Numbers, Numbers]
"""What a law of control follows: a place to stand at, or a place with its rate and its acceleration."""
