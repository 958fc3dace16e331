"""Control: inverse kinematics, operational space, the linear-quadratic regulator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class InverseKinematicsSolution:
    """A configuration that brings a frame to its target."""

    q: Array
    """(nq,)"""
    position_error: float
    """[m]"""
    angle_error: float
    """[rad]; 0 where only a position was asked for."""
    iterations: int
    restarts: int


@dataclass(frozen=True)
class OperationalSpace:
    """The equation of motion as felt at a frame: Λ ẍ + μ + p = F."""

    inertia: Array
    """Λ (rows, rows)."""
    jacobian: Array
    """J (rows, nv), along the world's axes."""
    consistent_inverse: Array
    """J̄ = M⁻¹JᵀΛ (nv, rows)."""
    bias_acceleration: Array
    """J̇ v (rows,)."""
    bias_force: Array
    """μ + p (rows,)."""

    def torque(self, acceleration: Numbers) -> Array:
        """τ = Jᵀ(Λ ẍ + μ + p) (nv,) that gives the frame this acceleration (rows,)."""
        force: Array = self.inertia @ np.asarray(acceleration, np.float64) + self.bias_force
        tau: Array = self.jacobian.T @ force
        return tau

    def null_torque(self, tau: Numbers) -> Array:
        """(1 − JᵀJ̄ᵀ) τ: the part that moves the robot, not the frame."""
        given = np.asarray(tau, np.float64)
        rest: Array = given - self.jacobian.T @ (self.consistent_inverse.T @ given)
        return rest


@dataclass(frozen=True)
class Dlqr:
    """The law u = −K x of least cost."""

    gain: Array
    """K (m, n)."""
    cost: Array
    """P (n, n): xᵀP x is the least cost from x on."""
    spectral_radius: float
    """The largest |λ| of A − B K."""


def dlqr(A: Numbers, B: Numbers, Q: Numbers, R: Numbers) -> Dlqr:
    """The gain of u = −K x that minimises Σ xᵀQ x + uᵀR u along xₖ₊₁ = A xₖ + B uₖ.

    A (n, n), B (n, m), Q (n, n) symmetric and positive semidefinite, R (m, m) symmetric and positive
    definite.

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
    position_tolerance: float = 1e-9,
    angle_tolerance: float = 1e-9,
    max_iterations: int = 100,
    max_restarts: int = 20,
    seed: int = 1,
) -> InverseKinematicsSolution:
    """A configuration within the joint limits that brings a frame to a pose (4, 4) or its origin to a
    position (3,).

    The search begins at `start`, (nq,) or the neutral configuration, and again at random ones where it is
    stuck.

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
    """Λ, J, J̄, J̇ v and μ + p of a frame's origin along some of x, y, z, rx, ry, rz in the world.

    >>> robot, q = rd.example("panda"), rd.example("panda").random_configuration(seed=1)
    >>> space = robot.operational_space(q, None, "panda_link8")
    >>> bool(np.allclose(space.jacobian @ space.consistent_inverse, np.eye(3)))
    True
    """
    return OperationalSpace(**robot._operational_space(q, v, frame, list(rows)))
