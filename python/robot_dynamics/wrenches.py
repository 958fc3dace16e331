"""The equation of motion with wrenches from outside: M a + C v + g = τ + Σ Jᵀ f."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native
from robot_dynamics.numbers import Numbers


def _stacked(wrenches: Mapping[str, Numbers] | Mapping[int, Numbers]) -> tuple[list[Any], NDArray[Any]]:
    """The frames, and one table (..., frames, 6)."""
    if not wrenches:
        return [], np.zeros((0, 6))
    tables = np.broadcast_arrays(*(np.asarray(wrench) for wrench in wrenches.values()))
    return list(wrenches), np.stack(tables, axis=-2)


class Pushed(_native.Robot):
    """A robot that is pushed."""

    def inverse_dynamics_with_wrenches(
        self,
        q: Numbers,
        v: Numbers,
        a: Numbers,
        wrenches: Mapping[str, Numbers] | Mapping[int, Numbers],
        *,
        out: NDArray[Any] | None = None,
        threads: int | None = None,
    ) -> NDArray[Any]:
        """τ = M a + C v + g − Σ Jᵀ f: what the joints give when wrenches from outside act on frames.

        q (..., nq), v (..., nv), a (..., nv) → (..., nv). `wrenches` has for each frame (..., 6), force [N] then moment
        [N·m] at the frame's origin along its axes.

        >>> robot, rest = rd.example("two_r"), [0.0, 0.0]
        >>> held = robot.inverse_dynamics_with_wrenches(rest, rest, rest, {"tip": [0.0, 0.0, 9.81, 0.0, 0.0, 0.0]})
        >>> (robot.gravity(rest) - held).round(9)  # 9.81 N upwards at 2 m and at 1 m
        array([19.62,  9.81])
        """
        frames, table = _stacked(wrenches)
        return self._result(self._inverse_dynamics_with_wrenches(q, v, a, frames, table, out=out, threads=threads))

    def forward_dynamics_with_wrenches(
        self,
        q: Numbers,
        v: Numbers,
        tau: Numbers,
        wrenches: Mapping[str, Numbers] | Mapping[int, Numbers],
        *,
        out: NDArray[Any] | None = None,
        threads: int | None = None,
    ) -> NDArray[Any]:
        """a = M⁻¹(τ + Σ Jᵀ f − C v − g); see `inverse_dynamics_with_wrenches`.

        q (..., nq), v (..., nv), tau (..., nv) → (..., nv).

        >>> robot, q, rest, push = rd.example("two_r"), [0.3, 1.2], [0.0, 0.0], {"tip": [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]}
        >>> tau = robot.inverse_dynamics_with_wrenches(q, rest, [3.0, 4.0], push)
        >>> robot.forward_dynamics_with_wrenches(q, rest, tau, push).round(9)
        array([3., 4.])
        """
        frames, table = _stacked(wrenches)
        return self._result(self._forward_dynamics_with_wrenches(q, v, tau, frames, table, out=out, threads=threads))

    @staticmethod
    def _result(array: Any) -> NDArray[Any]:
        result: NDArray[Any] = array
        return result
