"""Forces of the fluid around a robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


class FluidForceDerivatives(NamedTuple):
    """Derivatives of the forces of a fluid."""

    by_q: NDArray[np.float64]
    """∂τ/∂q (nv, nv), by the displacement of q."""
    by_v: NDArray[np.float64]
    """∂τ/∂v (nv, nv)."""


def fluid_forces(robot: Robot, q: Numbers, v: Numbers) -> NDArray[np.float64]:
    """Generalized forces of the fluid around the robot, of one state.

    They are 0 without a fluid: see `with_fluid`, and `density` and `viscosity` of MJCF's `option`. They are
    not part of `bias` and `dissipation`; simulations include them.

    Parameters
    ----------
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,)
        Velocity [rad/s or m/s].

    Returns
    -------
    ndarray, shape (nv,)
        Forces [N·m or N].

    Raises
    ------
    StateError
        `q` or `v` is invalid.

    Examples
    --------
    >>> robot = rd.example("two_r").with_fluid(1000.0)
    >>> robot.fluid_forces([0.3, 0.2], [0.0, 0.0]).any()
    np.False_
    """
    return robot._fluid_forces(q, v)


def fluid_force_derivatives(robot: Robot, q: Numbers, v: Numbers) -> FluidForceDerivatives:
    """Derivatives of `fluid_forces` of one state.

    Parameters
    ----------
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,)
        Velocity [rad/s or m/s].

    Returns
    -------
    FluidForceDerivatives
        ∂τ/∂q and ∂τ/∂v (nv, nv).

    Raises
    ------
    StateError
        `q` or `v` is invalid.

    Examples
    --------
    >>> robot = rd.example("two_r").with_fluid(0.0, 9e-4)
    >>> v = np.array([1.0, 2.0])
    >>> np.allclose(robot.fluid_force_derivatives([0.3, 0.2], v).by_v @ v, robot.fluid_forces([0.3, 0.2], v))
    True
    """
    return FluidForceDerivatives(*robot._fluid_force_derivatives(q, v))
