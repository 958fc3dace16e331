"""Payload at a frame, estimated while the robot moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class Payload:
    """Body at a frame, with standard deviations."""

    mass: float
    """Mass [kg]."""
    center_of_mass: Array
    """Centre of mass in the frame (3,) [m]."""
    inertia: Array
    """Inertia about the centre of mass, along the frame's axes (3, 3) [kg·m²]."""
    mass_deviation: float
    """Standard deviation of the mass [kg]."""
    center_of_mass_deviation: Array
    """Standard deviations of the centre of mass (3,) [m]."""


class PayloadEstimator(_native.PayloadFilter):
    """Ten parameters of a body at a frame by recursive least squares, one sample after another.

    Parameters
    ----------
    robot : Robot
        Robot without the payload.
    frame : str or int
        Name or number of the frame to which the payload is fixed.
    noise : array_like, shape (nv,)
        Standard deviation of each torque [N·m or N]; infinite for a coordinate without a sensor.
    forgetting : float
        Factor of the past's information at every sample, above 0 and at most 1.
    prior : array_like, shape (10,), optional
        Parameters before the first sample; default: 0.
    prior_deviations : array_like, shape (10,), optional
        Their standard deviations; default: 100 kg, 100 kg·m and 100 kg·m².
    offsets : array_like, shape (nv,), optional
        Constant torques [N·m or N] to subtract, together with the damping and friction of the joints.
        Default: nothing is subtracted.

    Raises
    ------
    IdentificationError
        The frame is fixed to the world, or an option is invalid.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot, random = rd.example("panda"), np.random.default_rng(1)
    >>> loaded = robot.with_payload("panda_link8", 1.5, [0.0, 0.02, 0.1])
    >>> payload = rd.PayloadEstimator(robot, "panda_link8", np.full(7, 0.1))
    >>> for q, v, a in random.uniform(-1, 1, (200, 3, 7)):
    ...     payload.push(q, v, a, loaded.inverse_dynamics(q, v, a))
    >>> round(payload.payload().mass, 3)
    1.5
    """

    def __new__(
        cls,
        robot: Robot,
        frame: str | int,
        noise: Numbers,
        *,
        forgetting: float = 1.0,
        prior: Numbers | None = None,
        prior_deviations: Numbers | None = None,
        offsets: Numbers | None = None,
    ) -> Self:
        """Make the estimator of a payload; see the class."""
        if prior is None and prior_deviations is None:
            start = None
        else:
            zero, vague = np.zeros(10), np.full(10, 100.0)
            start = (zero if prior is None else prior, vague if prior_deviations is None else prior_deviations)
        return super().__new__(cls, robot, frame, noise, forgetting, start, offsets)

    def push(self, q: Numbers, v: Numbers, a: Numbers, tau: Numbers) -> None:
        """Add a state with its acceleration and the measured torque.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Configuration.
        v : array_like, shape (nv,)
            Velocity [rad/s or m/s].
        a : array_like, shape (nv,)
            Acceleration [rad/s² or m/s²].
        tau : array_like, shape (nv,)
            Measured torques [N·m or N].

        Raises
        ------
        IdentificationError
            A number is not finite.
        ShapeError
            An array has the wrong shape.
        """
        self._push(q, v, a, tau)

    def reset(self) -> None:
        """Forget all samples."""
        self._reset()

    def payload(self) -> Payload:
        """Mass, centre of mass and inertia of the body.

        Returns
        -------
        Payload
            Body with standard deviations.
        """
        return Payload(**self._payload())
