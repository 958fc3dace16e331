"""Equation of motion with external wrenches: M a + C v + g = τ + Σ Jᵀ f."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.numbers import Numbers
from robot_dynamics.results import ForwardDynamicsDerivatives, InverseDynamicsDerivatives

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


def stacked(wrenches: Mapping[str, Numbers] | Mapping[int, Numbers]) -> tuple[list[Any], NDArray[Any]]:
    """Frames, and their wrenches as one array (..., frames, 6)."""
    if not wrenches:
        return [], np.zeros((0, 6))
    tables = np.broadcast_arrays(*(np.asarray(wrench) for wrench in wrenches.values()))
    return list(wrenches), np.stack(tables, axis=-2)


def inverse_dynamics_with_wrenches(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    a: Numbers,
    wrenches: Mapping[str, Numbers] | Mapping[int, Numbers],
    *,
    out: NDArray[Any] | None = None,
    threads: int | None = None,
) -> NDArray[Any]:
    """Inverse dynamics under external wrenches on frames: τ = M a + C v + g − Σ Jᵀ f.

    Parameters
    ----------
    q : array_like, shape (..., nq)
        Configuration.
    v : array_like, shape (..., nv)
        Velocity [rad/s or m/s].
    a : array_like, shape (..., nv)
        Acceleration [rad/s² or m/s²].
    wrenches : mapping of frame to array_like, shape (..., 6)
        Force [N], then moment [N·m], at each frame's origin along its axes.
    out : ndarray, shape (..., nv), optional
        Array that receives the result.
    threads : int, optional
        Threads for a batch; default: `num_threads()`.

    Returns
    -------
    ndarray, shape (..., nv)
        Torques τ [N·m or N].

    Raises
    ------
    StateError
        The state is invalid; `BadStatesError` for a batch.
    FrameError
        A frame does not exist.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot, rest = rd.example("two_r"), [0.0, 0.0]
    >>> held = robot.inverse_dynamics_with_wrenches(rest, rest, rest, {"tip": [0.0, 0.0, 9.81, 0.0, 0.0, 0.0]})
    >>> (robot.gravity(rest) - held).round(9)  # 9.81 N upwards at 2 m and at 1 m
    array([19.62,  9.81])
    """
    frames, table = stacked(wrenches)
    result: NDArray[Any] = robot._with_wrenches("inverse_dynamics", q, v, a, frames, table, out=out, threads=threads)
    return result


def forward_dynamics_with_wrenches(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    tau: Numbers,
    wrenches: Mapping[str, Numbers] | Mapping[int, Numbers],
    *,
    out: NDArray[Any] | None = None,
    threads: int | None = None,
) -> NDArray[Any]:
    """Forward dynamics under external wrenches on frames: a = M⁻¹(τ + Σ Jᵀ f − C v − g).

    Parameters
    ----------
    q : array_like, shape (..., nq)
        Configuration.
    v : array_like, shape (..., nv)
        Velocity [rad/s or m/s].
    tau : array_like, shape (..., nv)
        Torques [N·m or N].
    wrenches : mapping of frame to array_like, shape (..., 6)
        Force [N], then moment [N·m], at each frame's origin along its axes.
    out : ndarray, shape (..., nv), optional
        Array that receives the result.
    threads : int, optional
        Threads for a batch; default: `num_threads()`.

    Returns
    -------
    ndarray, shape (..., nv)
        Acceleration a [rad/s² or m/s²].

    Raises
    ------
    SingularMassError
        M(q) is singular.
    StateError
        The state is invalid; `BadStatesError` for a batch.
    FrameError
        A frame does not exist.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot, q, rest, push = rd.example("two_r"), [0.3, 1.2], [0.0, 0.0], {"tip": [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]}
    >>> tau = robot.inverse_dynamics_with_wrenches(q, rest, [3.0, 4.0], push)
    >>> robot.forward_dynamics_with_wrenches(q, rest, tau, push).round(9)
    array([3., 4.])
    """
    frames, table = stacked(wrenches)
    result: NDArray[Any] = robot._with_wrenches("forward_dynamics", q, v, tau, frames, table, out=out, threads=threads)
    return result


def inverse_dynamics_derivatives_with_wrenches(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    a: Numbers,
    wrenches: Mapping[str, Numbers] | Mapping[int, Numbers],
    *,
    out: tuple[NDArray[Any], NDArray[Any]] | None = None,
    threads: int | None = None,
) -> InverseDynamicsDerivatives[Any]:
    """Derivatives ∂τ/∂q and ∂τ/∂v of `inverse_dynamics_with_wrenches`.

    The wrenches keep their components in their frames.

    Parameters
    ----------
    q : array_like, shape (..., nq)
        Configuration.
    v : array_like, shape (..., nv)
        Velocity [rad/s or m/s].
    a : array_like, shape (..., nv)
        Acceleration [rad/s² or m/s²].
    wrenches : mapping of frame to array_like, shape (..., 6)
        Force [N], then moment [N·m], at each frame's origin along its axes.
    out : tuple of 2 ndarray, shape (..., nv, nv), optional
        Arrays that receive the results.
    threads : int, optional
        Threads for a batch; default: `num_threads()`.

    Returns
    -------
    InverseDynamicsDerivatives
        `by_position` and `by_velocity`, each (..., nv, nv).

    Raises
    ------
    StateError
        The state is invalid; `BadStatesError` for a batch.
    FrameError
        A frame does not exist.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot, q, rest = rd.example("two_r"), np.array([0.3, 1.2]), [0.0, 0.0]
    >>> tau = lambda q: robot.inverse_dynamics_with_wrenches(q, rest, rest, {"tip": [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]})
    >>> derivatives = robot.inverse_dynamics_derivatives_with_wrenches(
    ...     q, rest, rest, {"tip": [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]}
    ... )
    >>> bool(np.allclose(derivatives.by_position[:, 0], (tau(q + [1e-6, 0.0]) - tau(q - [1e-6, 0.0])) / 2e-6, atol=1e-8))
    True
    """
    frames, table = stacked(wrenches)
    derivatives: InverseDynamicsDerivatives[Any] = robot._with_wrenches(
        "inverse_dynamics_derivatives", q, v, a, frames, table, out=out, threads=threads
    )
    return derivatives


def forward_dynamics_derivatives_with_wrenches(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    tau: Numbers,
    wrenches: Mapping[str, Numbers] | Mapping[int, Numbers],
    *,
    out: tuple[NDArray[Any], NDArray[Any], NDArray[Any]] | None = None,
    threads: int | None = None,
) -> ForwardDynamicsDerivatives[Any]:
    """Derivatives ∂a/∂q, ∂a/∂v and ∂a/∂τ of `forward_dynamics_with_wrenches`.

    The wrenches keep their components in their frames.

    Parameters
    ----------
    q : array_like, shape (..., nq)
        Configuration.
    v : array_like, shape (..., nv)
        Velocity [rad/s or m/s].
    tau : array_like, shape (..., nv)
        Torques [N·m or N].
    wrenches : mapping of frame to array_like, shape (..., 6)
        Force [N], then moment [N·m], at each frame's origin along its axes.
    out : tuple of 3 ndarray, shape (..., nv, nv), optional
        Arrays that receive the results.
    threads : int, optional
        Threads for a batch; default: `num_threads()`.

    Returns
    -------
    ForwardDynamicsDerivatives
        `by_position`, `by_velocity` and `by_force`, each (..., nv, nv).

    Raises
    ------
    SingularMassError
        M(q) is singular.
    StateError
        The state is invalid; `BadStatesError` for a batch.
    FrameError
        A frame does not exist.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot, q, rest, push = rd.example("two_r"), [0.3, 1.2], [0.0, 0.0], {"tip": [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]}
    >>> derivatives = robot.forward_dynamics_derivatives_with_wrenches(q, rest, rest, push)
    >>> bool(np.allclose(derivatives.by_force, robot.inverse_mass_matrix(q)))
    True
    """
    frames, table = stacked(wrenches)
    derivatives: ForwardDynamicsDerivatives[Any] = robot._with_wrenches(
        "forward_dynamics_derivatives", q, v, tau, frames, table, out=out, threads=threads
    )
    return derivatives
