"""What may be given where numbers are asked for."""

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
