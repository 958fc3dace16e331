"""Loops, contacts, rolling, couplings: A(q) v = 0 beside the equation of motion, M a + C v + g = τ + Aᵀλ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics._native import Constraints
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]
_Fields: TypeAlias = tuple[str, list[str], list[float], list[str]]


def _numbers(values: Numbers) -> list[float]:
    return [float(value) for value in np.asarray(values, np.float64).ravel()]


@dataclass(frozen=True)
class Closure:
    """Two frames stay together along some rows: of x, y, z, rx, ry, rz, along the first frame's axes."""

    a: str
    b: str
    rows: Sequence[str] = ("x", "y", "z")

    def _fields(self) -> _Fields:
        return "closure", [self.a, self.b], [], list(self.rows)


@dataclass(frozen=True)
class Contact:
    """A frame stays at a pose (4, 4) in the world along some rows."""

    frame: str
    pose: Any
    rows: Sequence[str] = ("x", "y", "z", "rx", "ry", "rz")

    def _fields(self) -> _Fields:
        return "contact", [self.frame], _numbers(self.pose), list(self.rows)


@dataclass(frozen=True)
class PointContact:
    """A frame's origin stays at a point (3,) of the world [m]."""

    frame: str
    point: Any

    def _fields(self) -> _Fields:
        return "point_contact", [self.frame], _numbers(self.point), []


@dataclass(frozen=True)
class NoSlip:
    """A frame does not move along some of its own axes: a knife's edge."""

    frame: str
    rows: Sequence[str] = ("y",)

    def _fields(self) -> _Fields:
        return "no_slip", [self.frame], [], list(self.rows)


@dataclass(frozen=True)
class RollingDisc:
    """A disc with its centre in a frame rolls on a plane: rows of forward, side, normal."""

    frame: str
    axle: Any
    """The axle's direction in the frame."""
    radius: float
    """[m]"""
    normal: Any = (0.0, 0.0, 1.0)
    """The plane's normal in the world."""
    point: Any = (0.0, 0.0, 0.0)
    """A point of the plane [m]."""
    rows: Sequence[str] = ("forward", "side", "normal")

    def _fields(self) -> _Fields:
        numbers = [*_numbers(self.axle), self.radius, *_numbers(self.normal), *_numbers(self.point)]
        return "rolling", [self.frame], numbers, list(self.rows)


@dataclass(frozen=True)
class Coupling:
    """Σ factor · coordinate = offset: gears, belts, differentials, a joint held still."""

    factors: Mapping[str, float]
    offset: float = 0.0

    def _fields(self) -> _Fields:
        return "coupling", list(self.factors), [*map(float, self.factors.values()), self.offset], []


Constraint: TypeAlias = Closure | Contact | PointContact | NoSlip | RollingDisc | Coupling


@dataclass(frozen=True)
class ConstraintRows:
    """A(q) v = 0, φ(q) = 0 in one state."""

    matrix: Array
    """A (rows, nv)."""
    bias: Array
    """Ȧ v (rows,)."""
    position_error: Array
    """φ (rows,) [m or rad]; 0 for rows that are of velocities alone."""
    position_drift: float
    """The largest |φ|."""
    velocity_drift: float
    """The largest |A v|."""


@dataclass(frozen=True)
class ConstrainedMotion:
    """Accelerations under constraints."""

    acceleration: Array
    """(nv,)"""
    multipliers: Array
    """λ (rows,) [N or N·m]; the constraints push with Aᵀλ."""
    rank: int
    """How many rows are independent."""
    dependent: tuple[str, ...]
    """The others, in words."""
    residual: float = field(repr=False)
    """The largest |A a + Ȧ v| that is left."""


@dataclass(frozen=True)
class ConstrainedTorque:
    """Torques of a motion under constraints."""

    tau: Array
    """(nv,), 0 where nothing drives."""
    multipliers: Array
    """λ (rows,)."""
    residual: float
    """What the driven coordinates cannot give."""


@dataclass(frozen=True)
class Support:
    """A point on which a robot stands: it is pushed along the normal, never pulled, and held by friction."""

    frame: str
    point: Sequence[float] = (0.0, 0.0, 0.0)
    """In the frame [m]."""
    normal: Sequence[float] = (0.0, 0.0, 1.0)
    """Along the world's axes, of any length."""
    friction: float = 1.0

    def _fields(self) -> tuple[str, list[float], list[float], float]:
        return self.frame, _numbers(self.point), _numbers(self.normal), float(self.friction)


@dataclass(frozen=True)
class SupportedTorque:
    """Torques of a motion on supports."""

    tau: Array
    """(nv,), 0 where nothing drives."""
    forces: Array
    """On the robot at each support (supports, 3), along the world's axes [N]."""
    multipliers: Array
    """λ of the constraints (rows,)."""
    missing: Array
    """(nv,), more than rounding where the supports cannot carry this motion."""


@dataclass(frozen=True)
class ContactImpulse:
    """What an impact does."""

    velocity: Array
    """After it (nv,)."""
    impulse: Array
    """(rows,) [N·s or N·m·s]."""
    energy_lost: float
    """[J]"""
    rank: int


class Projections(NamedTuple):
    """Onto what constraints allow."""

    velocity: Array
    """P (nv, nv): onto velocities with A v = 0."""
    force: Array
    """P_u = Pᵀ (nv, nv): P_u Aᵀ = 0."""


def constraints(robot: Robot, constraints: Mapping[str, Constraint]) -> Constraints:
    """Constraints of this robot, by name.

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
    """A(q), Ȧ v and φ(q) of q (nq,) and v (nv,).

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
    """a and λ of M a + C v + g = τ + Aᵀλ, A a = −Ȧ v, of q (nq,), v (nv,), tau (nv,).

    `stabilization` is Baumgarte's rate γ [1/s]: A a = −Ȧ v − 2γ A v − γ² φ.

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
    """The torques of driven coordinates and the λ of a motion that keeps the constraints; the least ones.

    `actuated` (nv,) says which coordinates are driven, `robot.actuated_dofs` where it is not given.
    Coordinates that are not driven fix part of λ by least squares; the rest of λ makes |τ| least. Rows
    may depend on each other: λ is then the shortest.

    >>> robot, rest = rd.example("panda"), np.zeros(7)
    >>> gear = robot.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
    >>> drives = [joint != 1 for joint in range(7)]  # not the second joint
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
    force_weight: float = 1e-3,
) -> SupportedTorque:
    """The torques of a motion of a robot that stands, with forces in their cones of friction that carry
    it.

    The result has the least |τ|² + `force_weight` · |λ|² of all such. `actuated` (nv,) says which
    coordinates are driven, `robot.actuated_dofs` where it is not given. `constraints` are closed loops,
    which may pull as well.

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
    """The impulse that makes A v⁺ = −restitution · A v.

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
    """The nearest q with |φ(q)| ≤ tolerance, and v with A v = 0, near in the measure of M.

    >>> robot = rd.example("panda")
    >>> gear = robot.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
    >>> q, v = robot.project(gear, np.full(7, 0.5))
    >>> bool(abs(q[0] - 2.0 * q[1]) <= 1e-12)
    True
    """
    projected: tuple[Array, Array] = robot._project(constraints, q, v, tolerance)
    return projected


def constraint_projections(robot: Robot, constraints: Constraints, q: Numbers) -> Projections:
    """P and P_u of a configuration.

    >>> robot = rd.example("panda")
    >>> gear = robot.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
    >>> P, _ = robot.constraint_projections(gear, np.zeros(7))
    >>> bool(np.allclose(P @ P, P))
    True
    """
    return Projections(*robot._constraint_projections(constraints, q))
