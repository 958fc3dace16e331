"""Constraints A(q) v = 0 of the motion M a + C v + g = τ + Aᵀλ: loops, contacts, rolling, couplings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import defaults
from robot_dynamics._native import Constraints
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]
_Fields: TypeAlias = tuple[str, list[str], list[float], list[str]]


def _numbers(values: Numbers) -> list[float]:
    return [float(value) for value in np.asarray(values, np.float64).ravel()]


@dataclass(frozen=True)
class FrameConstraint:
    """Loop closure: two frames coincide along the given rows."""

    a: str
    """Name of the first frame."""
    b: str
    """Name of the second frame."""
    rows: Sequence[str] = ("x", "y", "z")
    """Constrained directions out of x, y, z, rx, ry, rz, along the axes of the first frame."""

    def _fields(self) -> _Fields:
        return "frame", [self.a, self.b], [], list(self.rows)


@dataclass(frozen=True)
class Contact:
    """Contact that holds a frame at a pose in the world along the given rows."""

    frame: str
    """Name of the frame."""
    pose: Numbers
    """Pose of the frame in the world (4, 4)."""
    rows: Sequence[str] = ("x", "y", "z", "rx", "ry", "rz")
    """Constrained directions out of x, y, z, rx, ry, rz."""

    def _fields(self) -> _Fields:
        return "contact", [self.frame], _numbers(self.pose), list(self.rows)


@dataclass(frozen=True)
class PointContact:
    """Contact that holds a frame's origin at a point of the world."""

    frame: str
    """Name of the frame."""
    point: Numbers
    """Point in the world (3,) [m]."""

    def _fields(self) -> _Fields:
        return "point_contact", [self.frame], _numbers(self.point), []


@dataclass(frozen=True)
class NoSlip:
    """Nonholonomic constraint, such as a knife edge: a frame does not move along some of its own axes."""

    frame: str
    """Name of the frame."""
    rows: Sequence[str] = ("y",)
    """Constrained directions out of x, y, z, rx, ry, rz, along the frame's axes."""

    def _fields(self) -> _Fields:
        return "no_slip", [self.frame], [], list(self.rows)


@dataclass(frozen=True)
class RollingDisc:
    """Disc that rolls on a plane, with its centre at a frame's origin."""

    frame: str
    """Name of the frame."""
    axle: Numbers
    """Direction of the axle in the frame (3,)."""
    radius: float
    """Radius of the disc [m]."""
    normal: Numbers = (0.0, 0.0, 1.0)
    """Normal of the plane in the world (3,)."""
    point: Numbers = (0.0, 0.0, 0.0)
    """Point of the plane in the world (3,) [m]."""
    rows: Sequence[str] = ("forward", "side", "normal")
    """Constrained directions out of forward, side, normal."""

    def _fields(self) -> _Fields:
        numbers = [*_numbers(self.axle), self.radius, *_numbers(self.normal), *_numbers(self.point)]
        return "rolling", [self.frame], numbers, list(self.rows)


@dataclass(frozen=True)
class Coupling:
    """Coupling of coordinates, Σ factor · coordinate = offset: gears, belts, differentials, a held joint."""

    factors: Mapping[str, float]
    """Factor of each coordinate, by its name."""
    offset: float = 0.0
    """Right-hand side."""

    def _fields(self) -> _Fields:
        return "coupling", list(self.factors), [*map(float, self.factors.values()), self.offset], []


Constraint: TypeAlias = FrameConstraint | Contact | PointContact | NoSlip | RollingDisc | Coupling


@dataclass(frozen=True)
class ConstraintRows:
    """Constraints of one state: A(q) v = 0 and φ(q) = 0."""

    matrix: Array
    """Constraint Jacobian A (rows, nv)."""
    bias: Array
    """Acceleration Ȧ v (rows,)."""
    position_error: Array
    """Position error φ (rows,) [m or rad]; 0 for rows that constrain velocities only."""
    position_drift: float
    """Largest |φ|."""
    velocity_drift: float
    """Largest |A v|."""


@dataclass(frozen=True)
class ConstrainedMotion:
    """Accelerations and multipliers under constraints."""

    acceleration: Array
    """Acceleration a (nv,) [rad/s² or m/s²]."""
    multipliers: Array
    """Multipliers λ (rows,) [N or N·m]; the constraint forces are Aᵀλ."""
    rank: int
    """Number of independent rows."""
    dependent: tuple[str, ...]
    """Descriptions of the dependent rows."""
    residual: float = field(repr=False)
    """Largest |A a + Ȧ v|."""


@dataclass(frozen=True)
class ConstrainedTorque:
    """Torques and multipliers of a motion under constraints."""

    tau: Array
    """Torques τ (nv,) [N·m or N]; 0 on coordinates without a motor."""
    multipliers: Array
    """Multipliers λ (rows,) [N or N·m]."""
    residual: float
    """max |M a + C v + g − τ − Aᵀλ|: more than rounding if the motors cannot cause this motion."""


@dataclass(frozen=True)
class Support:
    """Supporting contact point with Coulomb friction: it pushes along its normal and never pulls."""

    frame: str
    """Name of the frame that the point is fixed to."""
    point: Sequence[float] = (0.0, 0.0, 0.0)
    """Point in the frame (3,) [m]."""
    normal: Sequence[float] = (0.0, 0.0, 1.0)
    """Direction in which the support pushes the robot, along the world's axes, of any length (3,)."""
    friction: float = 1.0
    """Friction coefficient μ."""

    def _fields(self) -> tuple[str, list[float], list[float], float]:
        return self.frame, _numbers(self.point), _numbers(self.normal), float(self.friction)


@dataclass(frozen=True)
class SupportedTorque:
    """Torques and support forces of a motion on supports."""

    tau: Array
    """Torques τ (nv,) [N·m or N]; 0 on coordinates without a motor."""
    forces: Array
    """Force on the robot at each support, along the world's axes (supports, 3) [N]."""
    multipliers: Array
    """Multipliers λ of the constraints (rows,) [N or N·m]."""
    missing: Array
    """M a + C v + g − τ − Aᵀλ (nv,): more than rounding if the supports cannot carry this motion."""


@dataclass(frozen=True)
class ContactImpulse:
    """Velocity and impulse of an impact."""

    velocity: Array
    """Velocity v⁺ after the impact (nv,) [rad/s or m/s]."""
    impulse: Array
    """Impulse of each row (rows,) [N·s or N·m·s]."""
    energy_lost: float
    """Kinetic energy lost in the impact [J]."""
    rank: int
    """Number of independent rows."""


class Projections(NamedTuple):
    """Projections onto the motions that constraints allow."""

    velocity: Array
    """P (nv, nv), onto velocities with A v = 0."""
    force: Array
    """P_u = Pᵀ (nv, nv), which removes constraint forces: P_u Aᵀ = 0."""


def constraints(robot: Robot, constraints: Mapping[str, Constraint]) -> Constraints:
    """Compile constraints of this robot.

    Parameters
    ----------
    constraints : mapping of str to constraint
        Constraints by name: `FrameConstraint`, `Contact`, `PointContact`, `NoSlip`, `RollingDisc` or
        `Coupling`.

    Returns
    -------
    Constraints
        Constraints of this robot, for its methods and simulations.

    Raises
    ------
    ConstraintError
        A constraint is invalid for this robot.
    FrameError
        A frame does not exist.
    ValueError
        A row does not exist, or a pose does not have 4 by 4 numbers.

    Examples
    --------
    >>> robot = rd.example("two_r")
    >>> tip = robot.frame_pose([0.3, 0.4], "tip")[:3, 3]
    >>> robot.constraints({"pin": rd.PointContact("tip", tip)})
    <Constraints of 'two_r': pin.x, pin.y, pin.z>
    """
    fields = [(name, *constraint._fields()) for name, constraint in constraints.items()]
    return Constraints(robot, fields)


def constraint_rows(
    robot: Robot, constraints: Constraints, q: Numbers, v: Numbers | None = None
) -> ConstraintRows:
    """Evaluate A(q), Ȧ v and φ(q) in one state.

    Parameters
    ----------
    constraints : Constraints
        Constraints of this robot.
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,), optional
        Velocity [rad/s or m/s]; default: 0.

    Returns
    -------
    ConstraintRows
        A, Ȧ v, φ and the drift.

    Raises
    ------
    ConstraintError
        The constraints belong to another robot.
    StateError
        `q` or `v` is invalid.

    Examples
    --------
    >>> robot = rd.example("panda")
    >>> lock = robot.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
    >>> robot.constraint_rows(lock, np.zeros(7)).matrix[0, :3]
    array([ 1., -2.,  0.])
    """
    return ConstraintRows(**robot._constraint_rows(constraints, q, v))


def constrained_forward_dynamics(
    robot: Robot,
    constraints: Constraints,
    q: Numbers,
    v: Numbers,
    tau: Numbers | None = None,
    *,
    stabilization: float | None = None,
) -> ConstrainedMotion:
    """Solve M a + C v + g = τ + Aᵀλ and A a = −Ȧ v for a and λ.

    With `stabilization` γ the second equation is A a = −Ȧ v − 2γ A v − γ² φ (Baumgarte).

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
    ConstrainedMotion
        a, λ and the rank of A.

    Raises
    ------
    ConstraintError
        The system has no finite solution, or the constraints belong to another robot.
    StateError
        `q`, `v` or `tau` is invalid.

    Examples
    --------
    >>> robot, q, rest = rd.example("panda"), np.zeros(7), np.zeros(7)
    >>> gear = robot.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
    >>> a = robot.constrained_forward_dynamics(gear, q, rest).acceleration
    >>> bool(abs(a[0] - 2.0 * a[1]) < 1e-9)
    True
    """
    record = robot._constrained_forward_dynamics(constraints, q, v, tau, stabilization)
    record["dependent"] = tuple(record["dependent"])
    return ConstrainedMotion(**record)


def constrained_inverse_dynamics(
    robot: Robot,
    constraints: Constraints,
    q: Numbers,
    v: Numbers,
    a: Numbers,
    *,
    actuated: Sequence[bool] | None = None,
) -> ConstrainedTorque:
    """Smallest torques τ, and λ, of a motion under constraints: τ + Aᵀλ = M a + C v + g.

    The coordinates without motors determine part of λ by least squares. The rest of λ minimizes |τ|. Rows
    may depend on each other: λ is then the shortest.

    Parameters
    ----------
    constraints : Constraints
        Constraints of this robot.
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,)
        Velocity [rad/s or m/s].
    a : array_like, shape (nv,)
        Acceleration [rad/s² or m/s²], which keeps the constraints.
    actuated : sequence of bool, shape (nv,), optional
        Coordinates that motors drive; default: `actuated_dofs`.

    Returns
    -------
    ConstrainedTorque
        τ, λ and the residual.

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
    >>> float(robot.constrained_inverse_dynamics(gear, rest, rest, rest, actuated=drives).tau[1])
    0.0
    """
    driven = None if actuated is None else [bool(entry) for entry in actuated]
    return ConstrainedTorque(**robot._constrained_inverse_dynamics(constraints, q, v, a, driven))


def supported_inverse_dynamics(
    robot: Robot,
    supports: Sequence[Support],
    q: Numbers,
    v: Numbers,
    a: Numbers,
    *,
    actuated: Sequence[bool] | None = None,
    constraints: Constraints | None = None,
    force_weight: float = defaults.FORCE_WEIGHT,
) -> SupportedTorque:
    """Torques of a motion on supports, with support forces p in their friction cones.

    They satisfy τ + Σ Jᵀp + Aᵀλ = M a + C v + g. The result minimizes |τ|² + `force_weight` · (|p|² +
    |λ|²).

    Parameters
    ----------
    supports : sequence of Support
        Points on which the robot stands.
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,)
        Velocity [rad/s or m/s].
    a : array_like, shape (nv,)
        Acceleration [rad/s² or m/s²], at which the supports should be at rest.
    actuated : sequence of bool, shape (nv,), optional
        Coordinates that motors drive; default: `actuated_dofs`.
    constraints : Constraints, optional
        Closed loops, whose forces have either sign.
    force_weight : float
        Weight of the forces [m²].

    Returns
    -------
    SupportedTorque
        τ, the forces, λ, and the part of the motion that the supports cannot carry.

    Raises
    ------
    ConstraintError
        A support is invalid, or the constraints belong to another robot.
    FrameError
        A frame does not exist.
    StateError
        `q`, `v` or `a` is invalid.
    ShapeError
        `actuated` does not have nv entries.

    Examples
    --------
    >>> dog = rd.example("quadruped", floating_base=True)
    >>> q, rest = np.array([0, 0, 0.3, 0, 0, 0, 1, *[0, 0.7, -1.4] * 4]), np.zeros(18)
    >>> legs = ["front_left", "front_right", "hind_left", "hind_right"]
    >>> feet = [rd.Support(leg + "_foot", friction=0.7) for leg in legs]
    >>> stands = dog.supported_inverse_dynamics(feet, q, rest, rest)
    >>> round(float(stands.forces[:, 2].sum() / dog.mass), 6), bool(np.abs(stands.missing).max() < 1e-6)
    (9.81, True)
    """
    driven = None if actuated is None else [bool(entry) for entry in actuated]
    fields = [support._fields() for support in supports]
    return SupportedTorque(
        **robot._supported_inverse_dynamics(fields, constraints, q, v, a, driven, force_weight)
    )


def contact_impulse(
    robot: Robot, constraints: Constraints, q: Numbers, v: Numbers, *, restitution: float = 0.0
) -> ContactImpulse:
    """Impulse ι of an impact: v⁺ = v + M⁻¹Aᵀι with A v⁺ = −e A v.

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
    ContactImpulse
        v⁺, ι and the energy lost.

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
    >>> bool(np.abs(robot.contact_impulse(wall, q, [1.0, 2.0]).velocity).max() < 1e-12)
    True
    """
    return ContactImpulse(**robot._contact_impulse(constraints, q, v, restitution))


def project(
    robot: Robot,
    constraints: Constraints,
    q: Numbers,
    v: Numbers | None = None,
    *,
    tolerance: float = 1e-12,
) -> tuple[Array, Array]:
    """Nearest q with |φ(q)| ≤ `tolerance` and nearest v with A v = 0, in the metric M.

    Parameters
    ----------
    constraints : Constraints
        Constraints of this robot.
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,), optional
        Velocity [rad/s or m/s]; default: 0.
    tolerance : float
        Largest magnitude of φ that is allowed [m or rad].

    Returns
    -------
    q : ndarray, shape (nq,)
        Projected configuration.
    v : ndarray, shape (nv,)
        Projected velocity [rad/s or m/s].

    Raises
    ------
    ConstraintError
        The projection does not converge, or the constraints belong to another robot.
    StateError
        `q` or `v` is invalid.

    Examples
    --------
    >>> robot = rd.example("panda")
    >>> gear = robot.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
    >>> q, v = robot.project(gear, np.full(7, 0.5))
    >>> bool(abs(q[0] - 2.0 * q[1]) <= 1e-12)
    True
    """
    projected: tuple[Array, Array] = robot._project(constraints, q, v, tolerance)
    return projected


def constraint_projections(robot: Robot, constraints: Constraints, q: Numbers) -> Projections:
    """Projections P and P_u = Pᵀ of a configuration: A P = 0.

    Parameters
    ----------
    constraints : Constraints
        Constraints of this robot.
    q : array_like, shape (nq,)
        Configuration.

    Returns
    -------
    Projections
        P and P_u (nv, nv).

    Raises
    ------
    ConstraintError
        The system has no finite solution, or the constraints belong to another robot.
    StateError
        `q` is invalid.

    Examples
    --------
    >>> robot = rd.example("panda")
    >>> gear = robot.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
    >>> P, _ = robot.constraint_projections(gear, np.zeros(7))
    >>> bool(np.allclose(P @ P, P))
    True
    """
    return Projections(*robot._constraint_projections(constraints, q))
