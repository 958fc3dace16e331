"""What can be computed of the rows of a table: the methods of `Robot` that compute, by name."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native
from robot_dynamics.errors import BadStatesError, FrameError, QuantityError, StateError
from robot_dynamics.results import BY_ALGORITHM
from robot_dynamics.robot import Robot

AUDIT = ("kinetic_energy", "potential_energy", "power", "dissipated_power", "torque_residual")
"""The audit of recorded motion q, v, a, tau, row by row: K and V [J], the power vᵀτ of the motors [W], the
power vᵀb that damping and friction take, and the residual τ − M a − C v − g [N·m or N], which is 0 where
robot and record agree.

Dissipation counts with ``audit:dissipation`` alone: then the residual is τ − M a − C v − g − b. By
`arrow.ledger` the energy of whole episodes is booked from these."""


@dataclass(frozen=True)
class Quantity:
    """A quantity of one robot."""

    name: str
    """As asked for."""
    reads: tuple[str, ...]
    """The arrays that it is computed of."""
    names: tuple[str, ...]
    """The columns of its results."""
    call: Callable[..., Any]
    """Called with the arrays and `threads`."""

    def compute(self, state: dict[str, NDArray[Any]], threads: int | None) -> tuple[NDArray[Any], ...]:
        """The results for states, one for each name."""
        # `s` is one number a state, not a vector of one.
        arrays = (state[name][..., 0] if name == "s" else state[name] for name in self.reads)
        return self.split(self.call(*arrays, threads=threads))

    def split(self, results: Any) -> tuple[NDArray[Any], ...]:
        """The results, one for each name."""
        return tuple(results) if len(self.names) > 1 else (results,)


def quantity_names() -> tuple[str, ...]:
    """The quantities that a table can have; a frame follows after a colon where there is one.

    >>> from robot_dynamics.quantities import quantity_names
    >>> {"inverse_dynamics", "mass_matrix", "frame_pose:FRAME", "audit"} <= set(quantity_names())
    True
    """
    names = [f"{name}:FRAME" if "frame" in reads else name for name, reads in _METHODS.items()]
    return (*sorted(names), "audit", "audit:dissipation")


def quantity(robot: Robot, asked: str) -> Quantity:
    """The quantity of a name, such as ``mass_matrix`` or ``frame_pose:panda_link8``."""
    name, _, argument = asked.partition(":")
    if name == "audit" and argument in ("", "dissipation"):
        return Quantity(
            asked, ("q", "v", "a", "tau"), tuple(f"audit.{each}" for each in AUDIT), _Audit(robot, bool(argument))
        )
    reads = _METHODS.get(name)
    if reads is None:
        near = difflib.get_close_matches(name, [*_METHODS, "audit"], 3, 0.6)
        hint = (
            f"did you mean {' or '.join(f'`{each}`' for each in near)}?"
            if near
            else f"there are {', '.join(quantity_names())}"
        )
        raise QuantityError(f"no quantity `{asked}`: {hint}")
    arguments: dict[str, Any] = {}
    if "frame" in reads:
        if argument not in robot.frame_names:
            near = difflib.get_close_matches(argument, robot.frame_names, 3, 0.4) or list(robot.frame_names)
            raise FrameError(
                f"`{asked}`: write {name}:FRAME with a frame of robot `{robot.name}`, for example {', '.join(near)}"
            )
        arguments["frame"] = argument
    elif argument:
        raise QuantityError(f"`{asked}`: {name} has no frame")
    fields = getattr(BY_ALGORITHM.get(name), "_fields", ())
    names = tuple(f"{asked}.{field}" for field in fields) or (asked,)
    arrays = tuple(each for each in reads if each != "frame")
    return Quantity(asked, arrays, names, _Method(robot, name, arguments))


def _methods() -> dict[str, tuple[str, ...]]:
    """Methods of many states, and what they read."""
    found = {}
    for name, method in vars(_native.Robot).items():
        if name.startswith("_") or not callable(method):
            continue
        reads = tuple(inspect.signature(method).parameters)[1:]
        if "out" in reads:
            found[name] = tuple(each for each in reads if each not in ("out", "threads", "frames"))
    return found


_METHODS = _methods()


@dataclass(frozen=True)
class _Method:
    """A method of a robot with its frame."""

    robot: Robot
    name: str
    arguments: dict[str, Any]

    def __call__(self, *state: Any, threads: int | None) -> Any:
        return getattr(self.robot, self.name)(*state, **self.arguments, threads=threads)


@dataclass(frozen=True)
class _Audit:
    """The audit of recorded motion; see `AUDIT`."""

    robot: Robot
    has_dissipation: bool

    def __call__(self, q: Any, v: Any, a: Any, tau: Any, threads: int | None) -> tuple[NDArray[Any], ...]:
        robot = self.robot
        bad = [np.flatnonzero(~np.isfinite(tau).all(axis=-1))]
        reasons = ["tau is not finite"] if bad[0].size else []

        def of(method: Callable[..., Any], *state: Any) -> Any:
            try:
                return method(*state, threads=threads)
            except BadStatesError as error:
                bad.append(error.indices)
                reasons.append(str(error))
                return error.result

        kinetic, potential = of(robot.kinetic_energy, q, v), of(robot.potential_energy, q)
        residual = tau - of(robot.inverse_dynamics, q, v, a)
        lost = of(robot.dissipation, v) if self.has_dissipation else np.zeros_like(residual)
        results = kinetic, potential, _dot(v, tau), _dot(v, lost), residual - lost
        if reasons and q.ndim == 1:
            raise StateError(reasons[0])
        if reasons:
            raise BadStatesError(reasons[0], indices=np.unique(np.concatenate(bad)), result=results)
        return results


def _dot(x: NDArray[Any], y: NDArray[Any]) -> NDArray[Any]:
    """xᵀy of each row, added up in the order of the coordinates: the same bits however many rows there
    are."""
    total = np.zeros(np.broadcast_shapes(x.shape, y.shape)[:-1], x.dtype)
    for k in range(x.shape[-1]):
        total += x[..., k] * y[..., k]
    return total
