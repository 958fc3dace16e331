"""Control: inverse kinematics, operational space, the linear-quadratic regulator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native, defaults
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class InverseKinematicsSolution:
    """Configuration that brings a frame to its target."""

    q: Array
    """Configuration (nq,)."""
    position_error: float
    """Distance from the target [m]."""
    angle_error: float
    """Rotation angle to the target [rad]; 0 for a target without orientation."""
    iterations: int
    """Number of iterations."""
    restarts: int
    """Number of restarts from random configurations."""


@dataclass(frozen=True)
class OperationalSpace:
    """Equation of motion at a frame: Λ ẍ + μ + p = F."""

    inertia: Array
    """Λ (rows, rows) [kg, kg·m, kg·m²]."""
    jacobian: Array
    """J, along the world's axes (rows, nv)."""
    consistent_inverse: Array
    """J̄ = M⁻¹JᵀΛ (nv, rows)."""
    bias_acceleration: Array
    """J̇ v (rows,)."""
    bias_force: Array
    """μ + p (rows,)."""

    def torque(self, acceleration: Numbers) -> Array:
        """Torques τ = Jᵀ(Λ ẍ + μ + p) that give the frame an acceleration ẍ.

        Parameters
        ----------
        acceleration : array_like, shape (rows,)
            Acceleration ẍ of the frame [m/s² or rad/s²].

        Returns
        -------
        ndarray, shape (nv,)
            Torques [N·m or N].

        Raises
        ------
        ValueError
            The array has the wrong shape.
        """
        force: Array = self.inertia @ np.asarray(acceleration, np.float64) + self.bias_force
        tau: Array = self.jacobian.T @ force
        return tau

    def null_torque(self, tau: Numbers) -> Array:
        """Part of torques that does not accelerate the frame: (1 − JᵀJ̄ᵀ) τ.

        Parameters
        ----------
        tau : array_like, shape (nv,)
            Torques [N·m or N].

        Returns
        -------
        ndarray, shape (nv,)
            Torques [N·m or N].

        Raises
        ------
        ValueError
            The array has the wrong shape.
        """
        given = np.asarray(tau, np.float64)
        rest: Array = given - self.jacobian.T @ (self.consistent_inverse.T @ given)
        return rest


@dataclass(frozen=True)
class Dlqr:
    """Optimal state feedback u = −K x."""

    gain: Array
    """Gain K (m, n)."""
    cost: Array
    """P (n, n): xᵀP x is the least cost from the state x."""
    spectral_radius: float
    """Largest |λ| of the eigenvalues of A − B K."""


def dlqr(A: Numbers, B: Numbers, Q: Numbers, R: Numbers) -> Dlqr:
    """Gain K of u = −K x that minimizes Σ xᵀQ x + uᵀR u along xₖ₊₁ = A xₖ + B uₖ.

    Parameters
    ----------
    A : array_like, shape (n, n)
        State matrix.
    B : array_like, shape (n, m)
        Input matrix.
    Q : array_like, shape (n, n)
        Cost of the state, symmetric and positive semidefinite.
    R : array_like, shape (m, m)
        Cost of the input, symmetric and positive definite.

    Returns
    -------
    Dlqr
        Gain, cost matrix and spectral radius.

    Raises
    ------
    ControlError
        A matrix is invalid, or no gain stabilizes the system.

    Examples
    --------
    >>> law = rd.dlqr([[1.0, 0.1], [0.0, 1.0]], [[0.005], [0.1]], np.eye(2), [[1.0]])
    >>> law.spectral_radius < 1.0
    True
    """
    return Dlqr(**_native.dlqr(A, B, Q, R))


def inverse_kinematics(
    robot: Robot,
    frame: str | int,
    target: Numbers,
    start: Numbers | None = None,
    *,
    position_tolerance: float = defaults.POSITION_TOLERANCE,
    angle_tolerance: float = defaults.ANGLE_TOLERANCE,
    max_iterations: int = defaults.MAX_ITERATIONS,
    max_restarts: int = defaults.MAX_RESTARTS,
    seed: int = defaults.SEED,
) -> InverseKinematicsSolution:
    """Find a configuration within the joint limits that brings a frame to a pose or a position.

    The search begins at `start`, and again at random configurations if it is stuck.

    Parameters
    ----------
    frame : str or int
        Name or number of the frame.
    target : array_like, shape (4, 4) or (3,)
        Pose of the frame, or position of its origin, in the world [m].
    start : array_like, shape (nq,), optional
        First configuration; default: the neutral configuration.
    position_tolerance : float
        Largest distance from the target [m].
    angle_tolerance : float
        Largest rotation angle to the target [rad].
    max_iterations : int
        Largest number of iterations of each search.
    max_restarts : int
        Largest number of restarts from random configurations.
    seed : int
        Seed of the random configurations.

    Returns
    -------
    InverseKinematicsSolution
        Configuration and its errors.

    Raises
    ------
    InverseKinematicsError
        No search converges, or the target or a tolerance is invalid.
    FrameError
        The frame does not exist.
    ShapeError
        `target` is neither a pose nor a position.
    StateError
        `start` is invalid.

    Examples
    --------
    >>> robot = rd.example("panda")
    >>> wanted = robot.frame_pose(robot.random_configuration(seed=3), "panda_link8")
    >>> found = robot.inverse_kinematics("panda_link8", wanted)
    >>> bool(np.allclose(robot.frame_pose(found.q, "panda_link8"), wanted, atol=1e-8))
    True
    """
    return InverseKinematicsSolution(
        **robot._inverse_kinematics(
            frame,
            target,
            start,
            position_tolerance=position_tolerance,
            angle_tolerance=angle_tolerance,
            max_iterations=max_iterations,
            max_restarts=max_restarts,
            seed=seed,
        )
    )


def operational_space(
    robot: Robot,
    q: Numbers,
    v: Numbers | None,
    frame: str | int,
    rows: Sequence[str] = ("x", "y", "z"),
) -> OperationalSpace:
    """Operational-space dynamics Λ, J, J̄, J̇ v and μ + p of a frame's origin.

    Parameters
    ----------
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,), optional
        Velocity [rad/s or m/s]; 0 for `None`.
    frame : str or int
        Name or number of the frame.
    rows : sequence of str
        Directions of the task out of x, y, z, rx, ry, rz, along the world's axes.

    Returns
    -------
    OperationalSpace
        Quantities of Λ ẍ + μ + p = F.

    Raises
    ------
    ControlError
        The frame cannot accelerate along all rows.
    FrameError
        The frame does not exist.
    StateError
        `q` or `v` is invalid.
    ValueError
        A row does not exist.

    Examples
    --------
    >>> robot, q = rd.example("panda"), rd.example("panda").random_configuration(seed=1)
    >>> space = robot.operational_space(q, None, "panda_link8")
    >>> bool(np.allclose(space.jacobian @ space.consistent_inverse, np.eye(3)))
    True
    """
    return OperationalSpace(**robot._operational_space(q, v, frame, list(rows)))
