"""Quantities of the rows of a table: the computing methods of `Robot`, by name."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native
from robot_dynamics.errors import BadStatesError, FrameError, QuantityError, StateError
from robot_dynamics.numbers import ReferenceFrame
from robot_dynamics.results import BY_ALGORITHM
from robot_dynamics.robot import Robot

REFERENCE_FRAMES: tuple[ReferenceFrame, ...] = get_args(ReferenceFrame)
"""The reference frames of a frame's velocity, acceleration and Jacobian; the last is the default."""

AUDIT = ("kinetic_energy", "potential_energy", "power", "dissipated_power", "torque_residual")
"""Columns of the audit of recorded motion q, v, a, tau, row by row.

- `kinetic_energy` K and `potential_energy` V [J];
- `power`, the power vᵀτ of the motors [W];
- `dissipated_power`, the power vᵀb that damping and friction dissipate [W];
- `torque_residual`, τ − M a − C v − g [N·m or N], which is 0 if robot and record agree.

Only ``audit:dissipation`` includes dissipation; its residual is τ − M a − C v − g − b. From these columns
`arrow.energy_accounts` computes the energy account of each episode.
"""


@dataclass(frozen=True)
class Quantity:
    """Quantity of one robot."""

    name: str
    """Name of the quantity, as requested."""
    reads: tuple[str, ...]
    """Names of the arguments."""
    names: tuple[str, ...]
    """Names of the result columns."""
    call: Callable[..., Any]
    """Function of the arguments and `threads`."""

    def compute(self, state: dict[str, NDArray[Any]], threads: int | None) -> tuple[NDArray[Any], ...]:
        """Compute the results for many states.

        Parameters
        ----------
        state : dict of str to ndarray, shape (rows, width)
            Arguments by name.
        threads : int or None
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        tuple of ndarray, shape (rows, ...)
            Results in the order of `names`.

        Raises
        ------
        BadStatesError
            Some states are invalid.
        """
        # `s` is one number a state, not a vector of one.
        arrays = (state[name][..., 0] if name == "s" else state[name] for name in self.reads)
        return self.split(self.call(*arrays, threads=threads))

    def split(self, results: Any) -> tuple[NDArray[Any], ...]:
        """Result of `call` as a tuple, in the order of `names`."""
        return tuple(results) if len(self.names) > 1 else (results,)


def quantity_names() -> tuple[str, ...]:
    """List the names of all quantities.

    A name that contains ``:FRAME`` takes a frame. ``:local`` or ``:world`` after the frame is its reference
    frame; the default is ``local_world_aligned``.

    Returns
    -------
    tuple of str
        Names, sorted, with ``audit`` last.

    Examples
    --------
    >>> from robot_dynamics.quantities import quantity_names
    >>> {"inverse_dynamics", "frame_pose:FRAME", "frame_jacobian:FRAME:local", "audit"} <= set(quantity_names())
    True
    """
    names = []
    for name, reads in _METHODS.items():
        names.append(f"{name}:FRAME" if "frame" in reads else name)
        if "reference_frame" in reads:
            names += [f"{name}:FRAME:{reference}" for reference in REFERENCE_FRAMES[:-1]]
    return (*sorted(names), "audit", "audit:dissipation")


def quantity(robot: Robot, asked: str) -> Quantity:
    """Look up a quantity by its name.

    Parameters
    ----------
    robot : Robot
        Robot to compute the quantity of.
    asked : str
        Name such as ``mass_matrix`` or ``frame_pose:panda_link8``.

    Returns
    -------
    Quantity
        The quantity of this robot.

    Raises
    ------
    QuantityError
        The quantity does not exist or takes no frame.
    FrameError
        The frame is missing or does not exist.
    """
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
    arguments: dict[str, str] = {}
    if "reference_frame" in reads and argument not in robot.frame_names:
        frame, _, reference = argument.rpartition(":")
        if reference in REFERENCE_FRAMES:
            argument, arguments["reference_frame"] = frame, reference
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
    arrays = tuple(each for each in reads if each not in ("frame", "reference_frame"))
    return Quantity(asked, arrays, names, _Method(robot, name, arguments))


def _methods() -> dict[str, tuple[str, ...]]:
    """Names and arguments of the methods that compute batches."""
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
    """Method of a robot with its frame."""

    robot: Robot
    name: str
    arguments: dict[str, str]

    def __call__(self, *state: NDArray[Any], threads: int | None) -> Any:
        return getattr(self.robot, self.name)(*state, **self.arguments, threads=threads)


@dataclass(frozen=True)
class _Audit:
    """Audit of recorded motion; see `AUDIT`."""

    robot: Robot
    has_dissipation: bool

    def __call__(
        self, q: NDArray[Any], v: NDArray[Any], a: NDArray[Any], tau: NDArray[Any], threads: int | None
    ) -> tuple[NDArray[Any], ...]:
        robot = self.robot
        bad = [np.flatnonzero(~np.isfinite(tau).all(axis=-1))]
        reasons = ["tau is not finite"] if bad[0].size else []

        def of(method: Callable[..., Any], *state: NDArray[Any]) -> Any:
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
    """xᵀy of each row.

    The sum runs in the order of the coordinates: the bits do not depend on the number of rows.
    """
    total = np.zeros(np.broadcast_shapes(x.shape, y.shape)[:-1], x.dtype)
    for k in range(x.shape[-1]):
        total += x[..., k] * y[..., k]
    return total
