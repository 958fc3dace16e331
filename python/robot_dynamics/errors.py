"""What can go wrong: one small tree of exceptions, and the warning of a suspicious robot file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


class RobotDynamicsError(Exception):
    """Any error of this package."""


class LoadError(RobotDynamicsError, ValueError):
    """A robot file has no meaning; the message has all that is wrong with it, by line."""


class ShapeError(RobotDynamicsError, ValueError):
    """An array has the wrong shape, or the batches of two do not fit together."""


class DTypeError(RobotDynamicsError, TypeError):
    """An array holds what is not computed with, or float64 and float32 are mixed."""


class StateError(RobotDynamicsError, ValueError):
    """A state is none: a number is not finite, a quaternion has not unit length, or the result is too
    large."""


class BadStatesError(StateError):
    """Some states of a batch have no valid result; those of all others are valid, and are not lost.

    >>> robot = rd.example("two_r")
    >>> try:
    ...     robot.gravity([[0.0, 0.0], [np.nan, 0.0]])
    ... except rd.BadStatesError as error:
    ...     error.indices, error.result.round(2)
    (array([1]), array([[24.52,  4.9 ],
           [  nan,   nan]]))
    """

    indices: NDArray[np.intp]
    """The bad states, ascending, counted along the batch (`np.unravel_index` where it has several
    dimensions)."""
    result: Any
    """What the call would have returned, with NaN for the bad states."""

    def __init__(self, message: str, *, indices: NDArray[np.intp], result: Any) -> None:
        super().__init__(message)
        self.indices = indices
        self.result = result

    def __reduce__(self) -> Any:
        return _bad_states, (str(self), self.indices, self.result)


def _bad_states(message: str, indices: NDArray[np.intp], result: Any) -> BadStatesError:
    return BadStatesError(message, indices=indices, result=result)


class SingularMassError(RobotDynamicsError, ArithmeticError):
    """M(q) has no inverse: some motion of the joints moves no inertia."""


class FrameError(RobotDynamicsError, LookupError):
    """The robot has no frame of that name."""


class SimulationError(RobotDynamicsError, ArithmeticError):
    """A motion could not be computed to its end; what there is of it is in `until`."""

    until: Any
    """The motion until then, a `Motion`; None where it could not start."""

    def __init__(self, message: str, *, until: Any = None) -> None:
        super().__init__(message)
        self.until = until


class BadSimulationsError(SimulationError):
    """Some simulations of a batch could not do what was asked; all others have done it.

    >>> batch = rd.SimulationBatch(rd.example("two_r"), 3)
    >>> batch.torques = [[0.0, 0.0], [0.0, np.nan], [0.0, 0.0]]
    >>> try:
    ...     batch.step(10)
    ... except rd.BadSimulationsError as error:
    ...     list(error.errors), [round(time, 3) for time in batch.times]
    ([1], [0.01, 0.0, 0.01])
    """

    errors: dict[int, str]
    """The message of each simulation that failed, by its number, ascending."""

    def __init__(self, message: str, *, errors: dict[int, str]) -> None:
        super().__init__(message)
        self.errors = errors

    def __reduce__(self) -> Any:
        return _bad_simulations, (str(self), self.errors)


def _bad_simulations(message: str, errors: dict[int, str]) -> BadSimulationsError:
    return BadSimulationsError(message, errors=errors)


class ConstraintError(RobotDynamicsError, ValueError):
    """Constraints contradict each other, or what is asked of them cannot be."""


class InverseKinematicsError(RobotDynamicsError, ArithmeticError):
    """No configuration was found that brings the frame there."""


class ControlError(RobotDynamicsError, ArithmeticError):
    """A law of control has no solution."""


class PlanningError(RobotDynamicsError, ArithmeticError):
    """A path cannot be followed within the limits."""


class IdentificationError(RobotDynamicsError, ArithmeticError):
    """Parameters cannot be told from that motion."""


class DescriptionError(RobotDynamicsError, ValueError):
    """A robot cannot be changed that way."""


class GenerateError(RobotDynamicsError, ValueError):
    """Code for a robot cannot be generated, or what was generated cannot be compiled."""


class ColumnError(RobotDynamicsError, ValueError):
    """A table has not the columns that are read, or they hold something else."""


class QuantityError(RobotDynamicsError, LookupError):
    """There is no quantity of that name."""


class LoadWarning(UserWarning):
    """Something in a robot file is suspicious and was taken as written, or is physics that the model leaves
    out."""
