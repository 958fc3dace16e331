"""Exceptions of this package, and the warning for suspicious robot files."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray


class RobotDynamicsError(Exception):
    """Base class of all exceptions of this package."""


class LoadError(RobotDynamicsError, ValueError):
    """A robot file is invalid; the message lists all its errors by line."""


class ShapeError(RobotDynamicsError, ValueError):
    """An array has the wrong shape, or two batches do not broadcast."""


class DTypeError(RobotDynamicsError, TypeError):
    """An array has an unsupported dtype, or float64 and float32 are mixed."""


class StateError(RobotDynamicsError, ValueError):
    """A state is invalid.

    A number is not finite, a quaternion does not have unit length, or a result overflows.
    """


class BadStatesError(StateError):
    """Some states of a batch have no valid result; `result` keeps those of all others.

    >>> robot = rd.example("two_r")
    >>> try:
    ...     robot.gravity([[0.0, 0.0], [np.nan, 0.0]])
    ... except rd.BadStatesError as error:
    ...     error.indices, error.result.round(2)
    (array([1]), array([[24.52,  4.9 ],
           [  nan,   nan]]))
    """

    indices: NDArray[np.intp]
    """Indices of the invalid states along the flattened batch, ascending.

    `np.unravel_index` converts them for a batch with several dimensions.
    """
    result: Any
    """Return value of the call, with NaN for the invalid states."""

    def __init__(self, message: str, *, indices: NDArray[np.intp], result: Any) -> None:
        super().__init__(message)
        self.indices = indices
        self.result = result

    def __reduce__(self) -> tuple[Callable[..., BadStatesError], tuple[str, NDArray[np.intp], Any]]:
        return _bad_states, (str(self), self.indices, self.result)


def _bad_states(message: str, indices: NDArray[np.intp], result: Any) -> BadStatesError:
    return BadStatesError(message, indices=indices, result=result)


class SingularMassError(RobotDynamicsError, ArithmeticError):
    """M(q) is singular: a motion of the joints moves no inertia."""


class FrameError(RobotDynamicsError, LookupError):
    """The robot has no frame with this name."""


class SimulationError(RobotDynamicsError, ArithmeticError):
    """A motion could not be computed to its end; `until` is its first part."""

    until: Any
    """The motion up to the error as a `Motion`; `None` if it could not start."""

    def __init__(self, message: str, *, until: Any = None) -> None:
        super().__init__(message)
        self.until = until


class SimulationInputError(SimulationError, ValueError):
    """An argument of a simulation is invalid, or its method does not support a request."""


class BadSimulationsError(SimulationError):
    """Some simulations of a batch failed; all others completed the call.

    >>> batch = rd.SimulationBatch(rd.example("two_r"), 3)
    >>> batch.torques = [[0.0, 0.0], [0.0, np.nan], [0.0, 0.0]]
    >>> try:
    ...     batch.step(10)
    ... except rd.BadSimulationsError as error:
    ...     list(error.errors), [round(time, 3) for time in batch.times]
    ([1], [0.01, 0.0, 0.01])
    """

    errors: dict[int, str]
    """Message of each failed simulation, by its number, ascending."""

    def __init__(self, message: str, *, errors: dict[int, str]) -> None:
        super().__init__(message)
        self.errors = errors

    def __reduce__(self) -> tuple[Callable[..., BadSimulationsError], tuple[str, dict[int, str]]]:
        return _bad_simulations, (str(self), self.errors)


def _bad_simulations(message: str, errors: dict[int, str]) -> BadSimulationsError:
    return BadSimulationsError(message, errors=errors)


class ConstraintError(RobotDynamicsError, ValueError):
    """Constraints are invalid or contradict each other, or a system with them has no solution."""


class InverseKinematicsError(RobotDynamicsError, ArithmeticError):
    """Inverse kinematics found no configuration that brings the frame to its target."""


class ControlError(RobotDynamicsError, ArithmeticError):
    """A control problem has no solution."""


class PlanningError(RobotDynamicsError, ArithmeticError):
    """A path cannot be followed within the limits."""


class IdentificationError(RobotDynamicsError, ArithmeticError):
    """A recorded motion does not determine the parameters."""


class DescriptionError(RobotDynamicsError, ValueError):
    """A change of a robot is invalid, or a task or format does not support the robot."""


class GenerateError(RobotDynamicsError, ValueError):
    """Code for a robot cannot be generated, or the generated code does not compile."""


class DeviceError(RobotDynamicsError, RuntimeError):
    """A device is missing, cannot compile a function or failed, or an array is not on it."""


class ColumnError(RobotDynamicsError, ValueError):
    """A table lacks required columns, or they have the wrong type."""


class QuantityError(RobotDynamicsError, LookupError):
    """A quantity with this name does not exist."""


class LoadWarning(UserWarning):
    """A value in a robot file is suspicious, or the model leaves out physics that the file states."""
