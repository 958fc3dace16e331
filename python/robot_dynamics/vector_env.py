"""Base classes of vector environments: those of Gymnasium, or stand-ins if it is not installed.

The stand-ins have the attributes and methods that `robot_dynamics.gym` needs, so its tasks also run where
only NumPy is installed. Registration by name and the wrappers of Gymnasium need Gymnasium itself.
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from gymnasium.spaces import Box
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space
else:
    try:
        from gymnasium.spaces import Box
        from gymnasium.vector import AutoresetMode, VectorEnv
        from gymnasium.vector.utils import batch_space
    except ImportError:
        _Observations, _Actions, _Arrays = TypeVar("_Observations"), TypeVar("_Actions"), TypeVar("_Arrays")

        class AutoresetMode(Enum):
            """When environments restart after the end of an episode."""

            NEXT_STEP = "NextStep"
            SAME_STEP = "SameStep"
            DISABLED = "Disabled"

        class Box:
            """Arrays of one shape between bounds."""

            def __init__(self, low: Any, high: Any, shape: tuple[int, ...] | None = None, dtype: Any = np.float32) -> None:
                self.shape: tuple[int, ...] = np.shape(low) if shape is None else shape
                self.low: NDArray[Any] = np.broadcast_to(np.asarray(low, dtype), self.shape)
                self.high: NDArray[Any] = np.broadcast_to(np.asarray(high, dtype), self.shape)
                self.dtype = np.dtype(dtype)
                self._random = np.random.default_rng()

            def seed(self, seed: int | None = None) -> None:
                """Seed of `sample`."""
                self._random = np.random.default_rng(seed)

            def sample(self) -> NDArray[Any]:
                """Random array: uniform between finite bounds, else normal."""
                is_finite = np.isfinite(self.low) & np.isfinite(self.high)
                low, high = np.where(is_finite, self.low, 0.0), np.where(is_finite, self.high, 1.0)
                uniform = self._random.uniform(low, high, self.shape)
                normal = self._random.standard_normal(self.shape)
                return np.where(is_finite, uniform, normal).astype(self.dtype)

            def contains(self, x: Any) -> bool:
                """Whether an array has this shape and is within the bounds."""
                return bool(np.shape(x) == self.shape and (x >= self.low).all() and (x <= self.high).all())

        def batch_space(space: Box, n: int = 1) -> Box:
            """Space of n arrays."""
            return Box(np.repeat(space.low[np.newaxis], n, 0), np.repeat(space.high[np.newaxis], n, 0), dtype=space.dtype)

        class VectorEnv(Generic[_Observations, _Actions, _Arrays]):
            """Environments that step together."""

            _np_random: np.random.Generator | None = None

            @property
            def np_random(self) -> np.random.Generator:
                """Random numbers of the environments."""
                if self._np_random is None:
                    self._np_random = np.random.default_rng()
                return self._np_random

            @property
            def unwrapped(self) -> Any:
                """The environments themselves."""
                return self

            def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
                """Set the seed."""
                if seed is not None:
                    self._np_random = np.random.default_rng(seed)

            def close(self) -> None:
                """Nothing to release."""


__all__ = ["AutoresetMode", "Box", "VectorEnv", "batch_space"]
