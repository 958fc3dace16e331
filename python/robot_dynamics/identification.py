"""Identification of inertial parameters from recorded motion: τ = Y(q, v, a) π.

Torques depend on linear combinations β of π only.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics._native import BaseParameters
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class IdentificationResult:
    """Result of an identification."""

    values: Array
    """Identified combinations β."""
    standard_deviations: Array
    """Standard deviations of β, from the residual."""
    residual: float
    """Root mean square of τ − Y π [N·m or N]."""
    condition: float
    """Condition number of the columns scaled to unit length.

    Far above 100, the motion excites the parameters too little.
    """
    base: BaseParameters = field(repr=False)
    """Combinations that β stands for."""


class LinkConsistency(NamedTuple):
    """Physical consistency of the inertial parameters of a link."""

    link: str
    """Name of the link."""
    mass: float
    """Mass [kg]."""
    smallest: float
    """Smallest eigenvalue of the pseudo-inertia, which is positive for a rigid body."""
    largest: float
    """Largest eigenvalue of the pseudo-inertia."""
    is_consistent: bool
    """Whether a rigid body with these parameters exists, up to rounding."""


def base_parameters(robot: Robot, *, states: int = 200, seed: int = 1) -> BaseParameters:
    """Find the combinations β of the inertial parameters π that torques depend on, from random states.

    Parameters
    ----------
    states : int
        Number of random states.
    seed : int
        Seed of the random states.

    Returns
    -------
    BaseParameters
        Combinations β.

    Examples
    --------
    >>> len(rd.example("two_r").base_parameters())
    6
    """
    base: BaseParameters = robot._base_parameters(states, seed)
    return base


def identify(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    a: Numbers,
    tau: Numbers,
    base: BaseParameters | None = None,
    *,
    dissipation: bool = True,
) -> IdentificationResult:
    """Identify β from recorded motion by least squares.

    Parameters
    ----------
    q : array_like, shape (n, nq)
        Recorded configurations.
    v : array_like, shape (n, nv)
        Recorded velocities [rad/s or m/s].
    a : array_like, shape (n, nv)
        Recorded accelerations [rad/s² or m/s²].
    tau : array_like, shape (n, nv)
        Recorded torques [N·m or N].
    base : BaseParameters, optional
        Combinations to identify; default: those that this motion excites.
    dissipation : bool
        Whether `tau` contains the joints' damping and friction as described, like the torques of
        `simulate`. The torques of `inverse_dynamics` do not.

    Returns
    -------
    IdentificationResult
        β with its standard deviations.

    Raises
    ------
    IdentificationError
        The motion has too few or invalid samples, or `base` belongs to another robot.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot, random = rd.example("two_r"), np.random.default_rng(1)
    >>> q, v, a = random.uniform(-1, 1, (3, 100, 2))
    >>> found = robot.identify(q, v, a, robot.inverse_dynamics(q, v, a))
    >>> bool(np.allclose(found.values, found.base.values(robot.inertial_parameters)))
    True
    """
    return IdentificationResult(**robot._identify(q, v, a, tau, base, dissipation=dissipation))


def physical_consistency(robot: Robot, parameters: Numbers) -> tuple[LinkConsistency, ...]:
    """Check for each moving link whether a rigid body with its inertial parameters exists.

    Parameters
    ----------
    parameters : array_like, shape (10 · moving links,)
        Inertial parameters π, in the order of `inertial_parameters`.

    Returns
    -------
    tuple of LinkConsistency
        One for each moving link.

    Raises
    ------
    IdentificationError
        A parameter is not finite.
    ShapeError
        `parameters` has the wrong length.

    Examples
    --------
    >>> robot = rd.example("panda")
    >>> all(link.is_consistent for link in robot.physical_consistency(robot.inertial_parameters))
    True
    """
    return tuple(LinkConsistency(*link) for link in robot._physical_consistency(parameters))
