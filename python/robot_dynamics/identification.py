"""Inertial parameters from recorded motion: τ = Y(q, v, a) π, of which only combinations β show in
torques."""

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
class Identified:
    """What a recorded motion tells of β."""

    values: Array
    """β."""
    standard_deviations: Array
    """Of β, from the residual."""
    residual: float
    """The root mean square of τ − Y π [N·m or N]."""
    condition: float
    """Of the columns scaled to one length: far above 100 the motion excites too little."""
    base: BaseParameters = field(repr=False)
    """Which combinations β are."""


class LinkConsistency(NamedTuple):
    """Whether some body has these parameters."""

    link: str
    mass: float
    """[kg]"""
    smallest: float
    """The least eigenvalue of the pseudo-inertia, which is positive for a body."""
    largest: float
    is_consistent: bool


def base_parameters(robot: Robot, *, states: int = 200, seed: int = 1) -> BaseParameters:
    """The combinations β of π that torques show, found from random states.

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
) -> Identified:
    """β from recorded motion: q (n, nq), v (n, nv), a (n, nv), tau (n, nv), by least squares.

    The torques contain the joints' damping and friction as described, as those of `simulate` do; without
    `dissipation` they do not, as those of `inverse_dynamics`. Without `base` the combinations are those
    that this motion shows.

    >>> robot, random = rd.example("two_r"), np.random.default_rng(1)
    >>> q, v, a = random.uniform(-1, 1, (3, 100, 2))
    >>> found = robot.identify(q, v, a, robot.inverse_dynamics(q, v, a))
    >>> bool(np.allclose(found.values, found.base.values(robot.inertial_parameters)))
    True
    """
    return Identified(**robot._identify(q, v, a, tau, base, dissipation=dissipation))


def physical_consistency(robot: Robot, parameters: Numbers) -> tuple[LinkConsistency, ...]:
    """Whether each moving link of π (10·moving links,) could be a body.

    >>> robot = rd.example("panda")
    >>> all(link.is_consistent for link in robot.physical_consistency(robot.inertial_parameters))
    True
    """
    return tuple(LinkConsistency(*link) for link in robot._physical_consistency(parameters))
