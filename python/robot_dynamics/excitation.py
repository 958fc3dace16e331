"""Motions that excite the parameters to identify, within limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class FourierSeries:
    """Periodic motion q(t) = c + Σₖ (aₖ sin kωt − bₖ cos kωt)/(kω) with ω = 2π/T.

    Examples
    --------
    >>> swing = rd.FourierSeries(2.0, np.array([0.3]), np.array([[1.5]]), np.array([[0.0]]))
    >>> q, v, a = swing.evaluate([0.0, 0.5])
    >>> v.round(6)
    array([[1.5],
           [0. ]])
    """

    period: float
    """Period T [s]."""
    offsets: Array
    """Offsets c (nv,) [rad or m]."""
    sines: Array
    """Coefficients aₖ (nv, harmonics) [rad/s or m/s]."""
    cosines: Array
    """Coefficients bₖ (nv, harmonics) [rad/s or m/s]."""

    def evaluate(self, t: Numbers) -> tuple[Array, Array, Array]:
        """Configurations, velocities and accelerations at given times.

        Parameters
        ----------
        t : array_like, shape (n,)
            Times [s].

        Returns
        -------
        tuple of ndarray, shape (n, nv)
            Configurations q, velocities v and accelerations a.

        Raises
        ------
        ValueError
            A time is not a number.
        """
        rates = 2.0 * np.pi / self.period * np.arange(1, self.sines.shape[1] + 1)
        angle = np.multiply.outer(np.asarray(t, np.float64), rates)
        sine, cosine = np.sin(angle), np.cos(angle)
        q: Array = self.offsets + (sine / rates) @ self.sines.T - (cosine / rates) @ self.cosines.T
        v: Array = cosine @ self.sines.T + sine @ self.cosines.T
        a: Array = (-rates * sine) @ self.sines.T + (rates * cosine) @ self.cosines.T
        return q, v, a


@dataclass(frozen=True)
class Excitation:
    """Motion that excites the parameters to identify."""

    series: FourierSeries = field(repr=False)
    """Motion."""
    condition: float
    """Condition number of the rows at the samples, with columns of unit length."""
    start_condition: float
    """Condition number of the random motion from which the search started."""
    log_information: float
    """ln det(WᵀW)/(2n): the mean of −ln of the standard deviations of β, up to a constant."""
    usage: float
    """Largest part of a limit that the motion uses; at most 1."""
    steps: int
    """Number of steps of the search."""


def design_excitation(
    robot: Robot,
    period: float,
    harmonics: int,
    *,
    position: Numbers | None = None,
    velocity: Numbers | None = None,
    acceleration: Numbers | None = None,
    torque: Numbers | None = None,
    from_rest: bool = True,
    terms: Sequence[str] = (),
    noise: Numbers | None = None,
    criterion: str = "determinant",
    samples: int | None = None,
    steps: int = 60,
    seed: int = 1,
) -> Excitation:
    """Design a periodic motion within limits that determines the parameters well.

    Parameters
    ----------
    period : float
        Period T [s].
    harmonics : int
        Number of harmonics of each joint.
    position : array_like, shape (nv, 2), optional
        Smallest and largest positions [rad or m]; default: those of the robot.
    velocity : array_like, shape (nv,), optional
        Largest speed [rad/s or m/s]; default: those of the robot.
    acceleration : array_like, shape (nv,), optional
        Largest acceleration [rad/s² or m/s²]; default: without limit.
    torque : array_like, shape (nv,), optional
        Largest torque [N·m or N] with damping and friction; default: those of the robot.
    from_rest : bool
        Whether the motion starts and ends with zero velocity and acceleration.
    terms : sequence of str
        Joint terms that are identified as well; see `identify`.
    noise : array_like, shape (nv,), optional
        Standard deviation of each torque [N·m or N].
    criterion : str
        "determinant" for the volume of the confidence ellipsoid of β, or "condition".
    samples : int, optional
        Number of states at which the information is computed; default: 12 for each harmonic.
    steps : int
        Most steps for each of the four weights of the barrier of the limits.
    seed : int
        Seed of the random motions from which the search starts.

    Returns
    -------
    Excitation
        Motion and its information.

    Raises
    ------
    IdentificationError
        A limit or an option is invalid, or the torques do not hold the robot.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot = rd.example("two_r")
    >>> found = robot.design_excitation(5.0, 3, position=[[-1, 1]] * 2, velocity=[2, 3], torque=[60, 30])
    >>> q, v, a = found.series.evaluate(np.linspace(0, 5, 200))
    >>> bool((np.abs(q) <= 1.0).all()), found.usage <= 1.0
    (True, True)
    """
    found = robot._design_excitation(
        (position, velocity, acceleration, torque),
        (period, harmonics, from_rest, samples, criterion, steps, seed),
        list(terms),
        noise,
    )
    series = FourierSeries(*(found.pop(name) for name in ("period", "offsets", "sines", "cosines")))
    return Excitation(series=series, **found)
