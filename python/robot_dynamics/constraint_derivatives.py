"""Derivatives and gradients of constrained motions: accelerations, torques, impacts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics._native import Constraints
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]


class ConstrainedMotionDerivatives(NamedTuple):
    """Accelerations and multipliers under constraints, and their derivatives."""

    acceleration: Array
    """Acceleration a (nv,) [rad/s² or m/s²]."""
    multipliers: Array
    """Multipliers λ (rows,) [N or N·m]."""
    acceleration_by_position: Array
    """∂a/∂q (nv, nv), along displacements q ⊕ δq."""
    acceleration_by_velocity: Array
    """∂a/∂v (nv, nv)."""
    acceleration_by_force: Array
    """∂a/∂τ (nv, nv)."""
    multipliers_by_position: Array
    """∂λ/∂q (rows, nv), along displacements q ⊕ δq."""
    multipliers_by_velocity: Array
    """∂λ/∂v (rows, nv)."""
    multipliers_by_force: Array
    """∂λ/∂τ (rows, nv)."""


class ConstrainedMotionPullback(NamedTuple):
    """Accelerations and multipliers under constraints, and the gradient of a loss of them."""

    acceleration: Array
    """Acceleration a (nv,) [rad/s² or m/s²]."""
    multipliers: Array
    """Multipliers λ (rows,) [N or N·m]."""
    by_position: Array
    """Gradient by q, along displacements q ⊕ δq (nv,)."""
    by_velocity: Array
    """Gradient by v (nv,)."""
    by_force: Array
    """Gradient by τ (nv,)."""
    by_parameters: Array
    """Gradient by `Robot.parameters()` (parameters,)."""


class ConstrainedTorqueDerivatives(NamedTuple):
    """Torques and multipliers of a motion under constraints, and their derivatives."""

    tau: Array
    """Torques τ (nv,) [N·m or N]; 0 on coordinates without a motor."""
    multipliers: Array
    """Multipliers λ (rows,) [N or N·m]."""
    tau_by_position: Array
    """∂τ/∂q (nv, nv), along displacements q ⊕ δq."""
    tau_by_velocity: Array
    """∂τ/∂v (nv, nv)."""
    tau_by_acceleration: Array
    """∂τ/∂a (nv, nv)."""
    multipliers_by_position: Array
    """∂λ/∂q (rows, nv), along displacements q ⊕ δq."""
    multipliers_by_velocity: Array
    """∂λ/∂v (rows, nv)."""
    multipliers_by_acceleration: Array
    """∂λ/∂a (rows, nv)."""


class ConstrainedTorquePullback(NamedTuple):
    """Torques and multipliers of a motion under constraints, and the gradient of a loss of them."""

    tau: Array
    """Torques τ (nv,) [N·m or N]; 0 on coordinates without a motor."""
    multipliers: Array
    """Multipliers λ (rows,) [N or N·m]."""
    by_position: Array
    """Gradient by q, along displacements q ⊕ δq (nv,)."""
    by_velocity: Array
    """Gradient by v (nv,)."""
    by_acceleration: Array
    """Gradient by a (nv,)."""
    by_parameters: Array
    """Gradient by `Robot.parameters()` (parameters,)."""


class ContactImpulseDerivatives(NamedTuple):
    """Velocity and impulse of an impact, and their derivatives."""

    velocity: Array
    """Velocity v⁺ after the impact (nv,) [rad/s or m/s]."""
    impulse: Array
    """Impulse ι of each row (rows,) [N·s or N·m·s]."""
    velocity_by_position: Array
    """∂v⁺/∂q (nv, nv), along displacements q ⊕ δq."""
    velocity_by_velocity: Array
    """∂v⁺/∂v (nv, nv), by the velocity before the impact."""
    velocity_by_restitution: Array
    """∂v⁺/∂e (nv,)."""
    impulse_by_position: Array
    """∂ι/∂q (rows, nv), along displacements q ⊕ δq."""
    impulse_by_velocity: Array
    """∂ι/∂v (rows, nv), by the velocity before the impact."""
    impulse_by_restitution: Array
    """∂ι/∂e (rows,)."""


class ContactImpulsePullback(NamedTuple):
    """Velocity and impulse of an impact, and the gradient of a loss of them."""

    velocity: Array
    """Velocity v⁺ after the impact (nv,) [rad/s or m/s]."""
    impulse: Array
    """Impulse ι of each row (rows,) [N·s or N·m·s]."""
    by_position: Array
    """Gradient by q, along displacements q ⊕ δq (nv,)."""
    by_velocity: Array
    """Gradient by the velocity before the impact (nv,)."""
    by_restitution: float
    """Gradient by the restitution."""


def constrained_forward_dynamics_derivatives(
    robot: Robot,
    constraints: Constraints,
    q: Numbers,
    v: Numbers,
    tau: Numbers | None = None,
    *,
    stabilization: float | None = None,
) -> ConstrainedMotionDerivatives:
    """Compute a and λ of `constrained_forward_dynamics` with their exact derivatives.

    If rows depend on others, the derivatives are those along which the rank stays. The multipliers of
    dropped rows are 0 with all their derivatives.

    Parameters
    ----------
    constraints : Constraints
        Constraints of this robot.
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,)
        Velocity [rad/s or m/s].
    tau : array_like, shape (nv,), optional
        Torques [N·m or N]; default: 0.
    stabilization : float, optional
        Baumgarte's rate γ [1/s].

    Returns
    -------
    ConstrainedMotionDerivatives
        a, λ and their derivatives by q, v and τ.

    Raises
    ------
    ConstraintError
        The system has no finite solution, or the constraints belong to another robot.
    StateError
        `q`, `v` or `tau` is invalid.

    Examples
    --------
    >>> robot, q, rest = rd.example("panda"), np.full(7, 0.3), np.zeros(7)
    >>> gear = robot.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
    >>> by = robot.constrained_forward_dynamics_derivatives(gear, q, rest)
    >>> response = by.acceleration_by_force
    >>> bool(np.abs(response[0] - 2.0 * response[1]).max() < 1e-9)
    True
    """
    record = robot._constrained_forward_dynamics_derivatives(constraints, q, v, tau, stabilization)
    return ConstrainedMotionDerivatives(**record)


def constrained_forward_dynamics_pullback(
    robot: Robot,
    constraints: Constraints,
    q: Numbers,
    v: Numbers,
    tau: Numbers | None = None,
    *,
    acceleration: Numbers | None = None,
    multipliers: Numbers | None = None,
    stabilization: float | None = None,
) -> ConstrainedMotionPullback:
    """Gradient of a loss of a and λ of `constrained_forward_dynamics`, from its gradients by these.

    Parameters
    ----------
    constraints : Constraints
        Constraints of this robot.
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,)
        Velocity [rad/s or m/s].
    tau : array_like, shape (nv,), optional
        Torques [N·m or N]; default: 0.
    acceleration : array_like, shape (nv,), optional
        Gradient of the loss by a; default: 0.
    multipliers : array_like, shape (rows,), optional
        Gradient of the loss by λ; default: 0.
    stabilization : float, optional
        Baumgarte's rate γ [1/s].

    Returns
    -------
    ConstrainedMotionPullback
        a, λ and the gradients by q, v, τ and the robot's parameters.

    Raises
    ------
    ConstraintError
        The system has no finite solution, or the constraints belong to another robot.
    ShapeError
        A gradient does not have one number for each coordinate or row.
    StateError
        `q`, `v` or `tau` is invalid.

    Examples
    --------
    >>> robot, q, rest = rd.example("panda"), np.full(7, 0.3), np.zeros(7)
    >>> gear = robot.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
    >>> by = robot.constrained_forward_dynamics_derivatives(gear, q, rest)
    >>> pulled = robot.constrained_forward_dynamics_pullback(gear, q, rest, multipliers=[3.0])
    >>> bool(np.allclose(pulled.by_position, 3.0 * by.multipliers_by_position[0]))
    True
    """
    record = robot._constrained_forward_dynamics_pullback(
        constraints, q, v, tau, acceleration, multipliers, stabilization
    )
    return ConstrainedMotionPullback(**record)


def constrained_inverse_dynamics_derivatives(
    robot: Robot,
    constraints: Constraints,
    q: Numbers,
    v: Numbers,
    a: Numbers,
    *,
    actuated: Sequence[bool] | None = None,
) -> ConstrainedTorqueDerivatives:
    """Compute τ and λ of `constrained_inverse_dynamics` with their exact derivatives.

    If rows depend on others, the derivatives are those along which the ranks stay.

    Parameters
    ----------
    constraints : Constraints
        Constraints of this robot.
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,)
        Velocity [rad/s or m/s].
    a : array_like, shape (nv,)
        Acceleration [rad/s² or m/s²].
    actuated : sequence of bool, shape (nv,), optional
        Coordinates that motors drive; default: `actuated_dofs`.

    Returns
    -------
    ConstrainedTorqueDerivatives
        τ, λ and their derivatives by q, v and a.

    Raises
    ------
    ConstraintError
        A result is not finite, or the constraints belong to another robot.
    StateError
        `q`, `v` or `a` is invalid.
    ShapeError
        `actuated` does not have nv entries.

    Examples
    --------
    >>> robot, rest = rd.example("panda"), np.zeros(7)
    >>> gear = robot.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
    >>> drives = [joint != 1 for joint in range(7)]  # no motor at the second joint
    >>> by = robot.constrained_inverse_dynamics_derivatives(gear, rest, rest, rest, actuated=drives)
    >>> float(np.abs(by.tau_by_position[1]).max())
    0.0
    """
    driven = None if actuated is None else [bool(entry) for entry in actuated]
    record = robot._constrained_inverse_dynamics_derivatives(constraints, q, v, a, driven)
    return ConstrainedTorqueDerivatives(**record)


def constrained_inverse_dynamics_pullback(
    robot: Robot,
    constraints: Constraints,
    q: Numbers,
    v: Numbers,
    a: Numbers,
    *,
    tau: Numbers | None = None,
    multipliers: Numbers | None = None,
    actuated: Sequence[bool] | None = None,
) -> ConstrainedTorquePullback:
    """Gradient of a loss of τ and λ of `constrained_inverse_dynamics`, from its gradients by these.

    Parameters
    ----------
    constraints : Constraints
        Constraints of this robot.
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,)
        Velocity [rad/s or m/s].
    a : array_like, shape (nv,)
        Acceleration [rad/s² or m/s²].
    tau : array_like, shape (nv,), optional
        Gradient of the loss by τ; default: 0.
    multipliers : array_like, shape (rows,), optional
        Gradient of the loss by λ; default: 0.
    actuated : sequence of bool, shape (nv,), optional
        Coordinates that motors drive; default: `actuated_dofs`.

    Returns
    -------
    ConstrainedTorquePullback
        τ, λ and the gradients by q, v, a and the robot's parameters.

    Raises
    ------
    ConstraintError
        A result is not finite, or the constraints belong to another robot.
    StateError
        `q`, `v` or `a` is invalid.
    ShapeError
        `actuated` or a gradient has the wrong number of entries.

    Examples
    --------
    >>> robot, rest = rd.example("panda"), np.zeros(7)
    >>> gear = robot.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
    >>> by = robot.constrained_inverse_dynamics_derivatives(gear, rest, rest, rest)
    >>> pulled = robot.constrained_inverse_dynamics_pullback(gear, rest, rest, rest, tau=np.ones(7))
    >>> bool(np.allclose(pulled.by_acceleration, by.tau_by_acceleration.sum(axis=0)))
    True
    """
    driven = None if actuated is None else [bool(entry) for entry in actuated]
    record = robot._constrained_inverse_dynamics_pullback(constraints, q, v, a, tau, multipliers, driven)
    return ConstrainedTorquePullback(**record)


def contact_impulse_derivatives(
    robot: Robot, constraints: Constraints, q: Numbers, v: Numbers, *, restitution: float = 0.0
) -> ContactImpulseDerivatives:
    """Compute v⁺ and ι of `contact_impulse` with their exact derivatives.

    Parameters
    ----------
    constraints : Constraints
        Constraints of this robot that hold after the impact.
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,)
        Velocity before the impact [rad/s or m/s].
    restitution : float
        Coefficient of restitution e, from 0 to 1.

    Returns
    -------
    ContactImpulseDerivatives
        v⁺, ι and their derivatives by q, v and e.

    Raises
    ------
    ConstraintError
        The system has no finite solution, or the constraints belong to another robot.
    StateError
        `q` or `v` is invalid.

    Examples
    --------
    >>> robot, q = rd.example("two_r"), [0.3, 0.4]
    >>> wall = robot.constraints({"wall": rd.PointContact("tip", robot.frame_pose(q, "tip")[:3, 3])})
    >>> by = robot.contact_impulse_derivatives(wall, q, [1.0, 2.0], restitution=0.5)
    >>> bool(np.allclose(by.velocity_by_velocity, -0.5 * np.eye(2)))
    True
    """
    return ContactImpulseDerivatives(**robot._contact_impulse_derivatives(constraints, q, v, restitution))


def contact_impulse_pullback(
    robot: Robot,
    constraints: Constraints,
    q: Numbers,
    v: Numbers,
    *,
    velocity: Numbers | None = None,
    impulse: Numbers | None = None,
    restitution: float = 0.0,
) -> ContactImpulsePullback:
    """Gradient of a loss of v⁺ and ι of `contact_impulse`, from its gradients by these.

    Parameters
    ----------
    constraints : Constraints
        Constraints of this robot that hold after the impact.
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,)
        Velocity before the impact [rad/s or m/s].
    velocity : array_like, shape (nv,), optional
        Gradient of the loss by v⁺; default: 0.
    impulse : array_like, shape (rows,), optional
        Gradient of the loss by ι; default: 0.
    restitution : float
        Coefficient of restitution e, from 0 to 1.

    Returns
    -------
    ContactImpulsePullback
        v⁺, ι and the gradients by q, v and e.

    Raises
    ------
    ConstraintError
        The system has no finite solution, or the constraints belong to another robot.
    ShapeError
        A gradient does not have one number for each coordinate or row.
    StateError
        `q` or `v` is invalid.

    Examples
    --------
    >>> robot, q = rd.example("two_r"), [0.3, 0.4]
    >>> wall = robot.constraints({"wall": rd.PointContact("tip", robot.frame_pose(q, "tip")[:3, 3])})
    >>> by = robot.contact_impulse_pullback(wall, q, [1.0, 2.0], velocity=[1.0, 0.0], restitution=0.5)
    >>> bool(np.allclose(by.by_velocity, [-0.5, 0.0]))
    True
    """
    record = robot._contact_impulse_pullback(constraints, q, v, velocity, impulse, restitution)
    return ContactImpulsePullback(**record)
