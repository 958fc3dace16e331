"""Proven bounds, by interval arithmetic: torques of sets of robots, positions of frames, digits of results.

>>> robot = rd.example("panda")
>>> q = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8])
>>> motion = rd.certified.Motion.rest_to_rest(q, q + 0.5, duration=1.0)
>>> bounds = robot.certify_torques(motion, masses=(0.95, 1.05))
>>> bounds.within_limits()["panda_joint2"]
'proven'

The recursions of this package run over intervals with outward rounding. The results contain the exact values
for all states, times and robots of a set. Constants are those of the robot in double precision.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native
from robot_dynamics.errors import ShapeError
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics._native import PolynomialMotion
    from robot_dynamics._native import ReachableSet as NativeSet
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]

Bounds: TypeAlias = float | tuple[float, float]
"""A number, or its lower and upper bound."""

Certainty: TypeAlias = Literal["proven", "counterexample", "open"]

Verdict: TypeAlias = Literal["proven by own inertias", "proven by division", "counterexample", "open"]


@dataclass(frozen=True, eq=False)
class EnclosedQuantity:
    """Bounds of a quantity at a state, and its result in double precision."""

    lower: Array
    """Lower bounds of the exact numbers."""
    upper: Array
    """Upper bounds of the exact numbers."""
    computed: Array
    """Results in double precision, of the recursions without compiled code."""
    relative_error: float
    """Proven bound of the error of `computed`, relative to the largest of these numbers."""
    digits: float
    """−log₁₀ of `relative_error`, at most 17."""


class State(NamedTuple):
    """State of a motion at a time."""

    q: Array
    """Configuration (nq,)."""
    v: Array
    """Velocity (nv,) [rad/s or m/s]."""
    a: Array
    """Acceleration (nv,) [rad/s² or m/s²]."""


class Motion:
    """Motion of piecewise polynomials in time; `rest_to_rest` and `spline` create one.

    >>> motion = rd.certified.Motion.rest_to_rest([0.0], [1.0], duration=2.0)
    >>> motion.state(1.0).v  # 15/8 of the mean velocity
    array([0.9375])
    """

    def __init__(self, native: PolynomialMotion) -> None:
        self._native = native

    @classmethod
    def rest_to_rest(cls, start: Numbers, end: Numbers, duration: float) -> Motion:
        """Straight motion from rest to rest, with zero acceleration at both ends.

        q = q₀ + (q₁ − q₀)(10 x³ − 15 x⁴ + 6 x⁵) with x = t/duration.

        Parameters
        ----------
        start : array_like, shape (nq,)
            Configuration at the start.
        end : array_like, shape (nq,)
            Configuration at the end.
        duration : float
            Duration [s].

        Returns
        -------
        Motion
            The motion.

        Raises
        ------
        StateError
            A number is not finite, or the duration is not positive.
        ShapeError
            The configurations have different shapes.
        """
        ends = np.asarray(start, np.float64), np.asarray(end, np.float64)
        if ends[0].ndim != 1 or ends[0].shape != ends[1].shape:
            raise ShapeError(f"start has shape {ends[0].shape} and end {ends[1].shape}; both must be (nq,)")
        return cls(_native.PolynomialMotion("rest_to_rest", np.array([0.0, duration]), np.stack(ends)))

    @classmethod
    def spline(cls, times: Numbers, points: Numbers) -> Motion:
        """Cubic spline through points, at rest at both ends, with continuous accelerations.

        Parameters
        ----------
        times : array_like, shape (n,)
            Times of the points, ascending [s].
        points : array_like, shape (n, nq)
            Configurations.

        Returns
        -------
        Motion
            The motion. Its time starts at 0.

        Raises
        ------
        StateError
            There are fewer than two points, a number is not finite, or the times do not increase.
        ShapeError
            An array has the wrong shape.

        Examples
        --------
        >>> motion = rd.certified.Motion.spline([0.0, 1.0, 2.0], [[0.0], [0.5], [1.0]])
        >>> motion.duration, motion.state(1.0).v
        (2.0, array([0.75]))
        """
        return cls(_native.PolynomialMotion("spline", times, points))

    @property
    def durations(self) -> Array:
        """Durations of the pieces (pieces,) [s]."""
        return self._native._durations()

    @property
    def duration(self) -> float:
        """Duration of the motion [s]."""
        return float(self.durations.sum())

    @property
    def coefficients(self) -> Array:
        """Coefficients of q = c₀ + c₁ s + … + c₅ s⁵, with s = 0 at the start of a piece (pieces, nq, 6)."""
        return self._native._coefficients()

    def state(self, time: float) -> State:
        """State at a time.

        Parameters
        ----------
        time : float
            Time from the start, from 0 to `duration` [s].

        Returns
        -------
        State
            Configuration, velocity and acceleration.

        Raises
        ------
        ValueError
            The time is outside the motion.
        """
        ends = np.cumsum(self.durations)
        if not 0.0 <= time <= ends[-1]:
            raise ValueError(f"time is {time}; it must be from 0 to {ends[-1]}")
        piece = min(int(np.searchsorted(ends, time, side="right")), len(ends) - 1)
        start = ends[piece - 1] if piece > 0 else 0.0
        return State(*self._native._state(piece, time - float(start)))

    def __repr__(self) -> str:
        pieces, coordinates, _ = self.coefficients.shape
        return f"<Motion: {coordinates} coordinates, {pieces} pieces, {self.duration:g} s>"


@dataclass(frozen=True, eq=False)
class Payload:
    """Rigid body that a frame carries, with mass and centre of mass within bounds."""

    frame: str | int
    """Name of the frame, or its index in `frame_names`. It belongs to a moving link."""
    mass: Bounds = field(kw_only=True)
    """Mass [kg]."""
    center_of_mass: Sequence[Bounds] = field(default=(0.0, 0.0, 0.0), kw_only=True)
    """Centre of mass in the frame, for each of x, y and z [m]."""
    radius_of_gyration: float = field(kw_only=True)
    """Largest radius of gyration about the centre of mass [m]; 0 for a point mass."""


@dataclass(frozen=True, eq=False)
class TorqueBounds:
    """Proven bounds of the torques of a motion, for all times and all robots of a set [N·m or N]."""

    coordinates: tuple[str, ...] = field(repr=False)
    """Names of the coordinates of v."""
    lower: Array
    """No torque is less (nv,)."""
    upper: Array
    """No torque is greater (nv,)."""
    least: Array
    """The least torque of some robot of the set is at most this (nv,)."""
    least_time: Array = field(repr=False)
    """Time of `least` (nv,) [s]."""
    greatest: Array
    """The greatest torque of some robot of the set is at least this (nv,)."""
    greatest_time: Array = field(repr=False)
    """Time of `greatest` (nv,) [s]."""
    is_tight: bool
    """Whether a finer division of time changes no bound by more than the tolerance."""
    part_times: Array = field(repr=False)
    """Intervals of time that cover the motion, ascending (parts, 2) [s]."""
    part_lower: Array = field(repr=False)
    """Lower bounds in each interval (parts, nv)."""
    part_upper: Array = field(repr=False)
    """Upper bounds in each interval (parts, nv)."""
    effort: Array = field(repr=False)
    """Effort limits of the robot (nv,); infinite without a limit."""

    def within_limits(self, limits: Numbers | None = None) -> dict[str, Certainty]:
        """Whether the torques stay within limits, for each coordinate.

        Parameters
        ----------
        limits : array_like, shape (nv,), optional
            Largest magnitude of each torque [N·m or N]; default: `effort`.

        Returns
        -------
        dict of str to str
            By the name of the coordinate: ``proven`` for all times and robots, ``counterexample`` if some
            robot exceeds the limit at some time, and otherwise ``open``.

        Raises
        ------
        ValueError
            The limits have the wrong shape.
        """
        most = np.broadcast_to(np.asarray(self.effort if limits is None else limits, np.float64), self.lower.shape)
        is_proven = (-most <= self.lower) & (self.upper <= most)
        is_exceeded = (self.least < -most) | (self.greatest > most)
        words: list[Certainty] = [
            "proven" if proven else "counterexample" if exceeded else "open"
            for proven, exceeded in zip(is_proven, is_exceeded, strict=True)
        ]
        return dict(zip(self.coordinates, words, strict=True))


@dataclass(frozen=True, eq=False)
class MassMatrixProof:
    """Result of a search for a proof that M(q) is positive definite in a box."""

    verdict: Verdict
    """``proven by own inertias``: in every configuration, since each link has inertia or a rotor of its own.
    ``proven by division``: in the box, by a division into `boxes`. ``counterexample``: M is not positive
    definite at `q`, or so near to it that rounding hides it. ``open``: there was no proof for a part."""
    lower: Array
    """Lower bounds of the box (nq,)."""
    upper: Array
    """Upper bounds of the box (nq,)."""
    boxes: int = 0
    """Number of boxes of the division."""
    divisions: NDArray[np.int64] | None = field(default=None, repr=False)
    """Divisions, each node before its halves: the coordinate that is halved, or −1 for a part that is not."""
    q: Array | None = None
    """Configuration of a counterexample (nq,)."""
    open_lower: Array | None = None
    """Lower bounds of a part without a proof (nq,)."""
    open_upper: Array | None = None
    """Upper bounds of a part without a proof (nq,)."""

    @property
    def is_proven(self) -> bool:
        """Whether M is proven to be positive definite."""
        return self.verdict.startswith("proven")


class Farthest(NamedTuple):
    """Farthest position of a frame in a direction n."""

    proven: float
    """n · p is at most this in all configurations."""
    attained: float
    """n · p at `q` is at least this."""
    q: Array
    """Configuration far in this direction (nq,)."""


class ReachableSet:
    """Convex set that contains all positions of a frame; `Robot.certify_reach` creates one."""

    def __init__(self, native: NativeSet, frame: str | int) -> None:
        self._native, self._frame = native, frame

    @property
    def box(self) -> Array:
        """Lower and upper bounds of the position in the world (2, 3) [m]."""
        return self._native._box()

    def farthest(self, direction: Numbers) -> Farthest:
        """Farthest position in a direction.

        Parameters
        ----------
        direction : array_like, shape (3,)
            Direction n in the world, of any length.

        Returns
        -------
        Farthest
            A proven bound of n · p, and a configuration near it.

        Raises
        ------
        StateError
            A number is not finite.
        ShapeError
            The direction has the wrong shape.
        """
        return Farthest(*self._native._farthest(direction))

    def __repr__(self) -> str:
        return f"<ReachableSet of {self._frame!r}>"


def certify_digits(
    robot: Robot,
    q: Numbers,
    v: Numbers | None = None,
    a: Numbers | None = None,
    tau: Numbers | None = None,
) -> dict[str, EnclosedQuantity]:
    """Bounds of M, C, g, C v + g, τ, the energies and a at a state, with the digits of double precision.

    Parameters
    ----------
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,), optional
        Velocity [rad/s or m/s]; default: 0.
    a : array_like, shape (nv,), optional
        Acceleration of the inverse dynamics [rad/s² or m/s²]; default: 0.
    tau : array_like, shape (nv,), optional
        Torques of the forward dynamics [N·m or N]; default: 0.

    Returns
    -------
    dict of str to EnclosedQuantity
        ``mass_matrix``, ``coriolis_matrix``, ``gravity_forces``, ``bias``, ``inverse_dynamics``,
        ``kinetic_energy``, ``potential_energy`` and ``forward_dynamics``.

    Raises
    ------
    SingularMassError
        M is singular.
    StateError
        A number is not finite, or M is nearly singular.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot = rd.example("panda")
    >>> found = robot.certify_digits(robot.neutral())
    >>> mass = found["mass_matrix"]
    >>> bool(np.all(mass.lower <= mass.computed) and np.all(mass.computed <= mass.upper)), mass.digits > 13
    (True, True)
    """
    fields = robot._certify_digits(q, v, a, tau)
    return {
        name: EnclosedQuantity(lower, upper, computed, error, digits)
        for name, lower, upper, computed, error, digits in fields
    }


def certify_torques(
    robot: Robot,
    motion: Motion,
    *,
    masses: Bounds | Mapping[str, Bounds] = 1.0,
    payload: Payload | None = None,
    friction: Bounds = 0.0,
    gravity: Numbers | None = None,
    tolerance: float = 0.01,
    max_parts: int = 200_000,
    threads: int | None = None,
) -> TorqueBounds:
    """Proven bounds of τ along a motion, for all robots of a set.

    Time is divided until a finer division changes no bound by more than the tolerance.

    Parameters
    ----------
    motion : Motion
        The motion.
    masses : float, pair of float, or mapping of str to these
        Factor on mass, first moment and inertia of every moving link, or of those links by name. Each link
        has its own factor within the bounds.
    payload : Payload, optional
        Body that a frame carries.
    friction : float or pair of float
        Factor on damping and dry friction of all joints; 0 for none.
    gravity : array_like, shape (3,) or (3, 2), optional
        Acceleration of free fall, or bounds of its components [m/s²]; default: that of the robot.
    tolerance : float
        Tolerance, relative to the range of each torque.
    max_parts : int
        Largest number of intervals of time. Bounds are proven in any case; `is_tight` tells whether they are
        within the tolerance.
    threads : int, optional
        Number of threads; default: `num_threads`.

    Returns
    -------
    TorqueBounds
        Bounds, and torques that robots of the set attain.

    Raises
    ------
    DescriptionError
        The robot has joints with quaternions.
    FrameError
        A link or frame does not exist.
    StateError
        Bounds are not finite or not in order, a mass is negative, or the frame does not move.
    ShapeError
        The motion has the wrong number of coordinates, or an array has the wrong shape.

    Examples
    --------
    >>> robot = rd.example("two_r")
    >>> motion = rd.certified.Motion.rest_to_rest([0.0, 0.0], [1.0, 0.5], duration=1.0)
    >>> load = rd.certified.Payload("tip", mass=(0.0, 1.0), radius_of_gyration=0.1)
    >>> bounds = robot.certify_torques(motion, masses={"fore": (0.9, 1.1)}, payload=load)
    >>> bool(np.all(bounds.lower <= bounds.least) and np.all(bounds.greatest <= bounds.upper)), bounds.is_tight
    (True, True)
    """
    factors: list[tuple[str | None, tuple[float, float]]]
    if isinstance(masses, Mapping):
        factors = [(link, _pair(f"masses[{link!r}]", factor)) for link, factor in masses.items()]
    else:
        factors = [(None, _pair("masses", masses))]
    acceleration = None if gravity is None else _vector_bounds("gravity", gravity)
    words = None
    if payload is not None:
        center = [_pair("center_of_mass", x) for x in payload.center_of_mass]
        if len(center) != 3:
            raise ShapeError(f"center_of_mass has {len(center)} coordinates, it must have 3")
        words = (payload.frame, _pair("mass", payload.mass), center, payload.radius_of_gyration)
    robots = (factors, _pair("friction", friction), acceleration)
    record = robot._certify_torques(motion._native, robots, words, (tolerance, max_parts), threads)
    return TorqueBounds(coordinates=tuple(robot.coordinate_names), effort=robot.limits.effort, **record)


def certify_mass_matrix(
    robot: Robot,
    lower: Numbers | None = None,
    upper: Numbers | None = None,
    *,
    max_boxes: int = 200_000,
) -> MassMatrixProof:
    """Search for a proof that M(q) is positive definite in a box of configurations.

    Parameters
    ----------
    lower : array_like, shape (nq,), optional
        Lower bounds of q; default: the position limits, −π for rotations without a limit.
    upper : array_like, shape (nq,), optional
        Upper bounds of q; default: the position limits, π for rotations without a limit.
    max_boxes : int
        Largest number of boxes.

    Returns
    -------
    MassMatrixProof
        A proof, a counterexample, or a part of the box without either.

    Raises
    ------
    DescriptionError
        The robot has joints with quaternions, and needs a division.
    StateError
        A bound is not a number, exceeds the other, or is infinite for a robot that needs a division.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> rd.example("panda").certify_mass_matrix().verdict
    'proven by own inertias'
    """
    ends = _box(robot, lower, upper, turn=float(np.nextafter(math.pi, 4.0)))
    record: dict[str, Any] = robot._certify_mass_matrix(*ends, max_boxes)
    if "divisions" in record:
        record["divisions"] = np.array(record["divisions"], np.int64)
    return MassMatrixProof(lower=ends[0], upper=ends[1], **record)


def certify_reach(
    robot: Robot,
    frame: str | int,
    lower: Numbers | None = None,
    upper: Numbers | None = None,
    *,
    cells: int = 32,
    threads: int | None = None,
) -> ReachableSet:
    """Convex set that contains the positions of a frame for all configurations of a box.

    Mimic joints count as joints of their own, which makes the set larger.

    Parameters
    ----------
    frame : str or int
        Name of the frame, or its index in `frame_names`.
    lower : array_like, shape (nq,), optional
        Lower bounds of q; default: the position limits.
    upper : array_like, shape (nq,), optional
        Upper bounds of q; default: the position limits.
    cells : int
        Steps of the grid of directions along an edge of a cube, a power of two. The overestimate falls with
        its square; with 64 it is about 0.1 % of the length of the chain.
    threads : int, optional
        Number of threads; default: `num_threads`.

    Returns
    -------
    ReachableSet
        The set.

    Raises
    ------
    DescriptionError
        A joint that moves the frame has a quaternion.
    FrameError
        The frame does not exist.
    StateError
        A bound is not a number or exceeds the other, or a sliding joint has an infinite bound.
    ShapeError
        An array has the wrong shape.
    ValueError
        `cells` is not a power of two.

    Examples
    --------
    >>> reach = rd.example("two_r").certify_reach("tip")
    >>> farthest = reach.farthest([1.0, 0.0, 0.0])  # two links of 1 m
    >>> farthest.attained <= 2.0 <= farthest.proven < 2.02
    True
    """
    ends = _box(robot, lower, upper, turn=math.inf)
    return ReachableSet(robot._certify_reach(frame, *ends, cells, threads), frame)


def _pair(name: str, bounds: Numbers) -> tuple[float, float]:
    """Lower and upper bound."""
    ends = np.asarray(bounds, np.float64)
    if ends.shape not in ((), (2,)):
        raise ShapeError(f"{name} has shape {ends.shape}; give a number, or a lower and an upper bound")
    lower, upper = np.broadcast_to(ends, (2,))
    return float(lower), float(upper)


def _vector_bounds(name: str, numbers: Numbers) -> list[tuple[float, float]]:
    """Bounds of three components."""
    rows = np.asarray(numbers, np.float64)
    if rows.shape not in ((3,), (3, 2)):
        raise ShapeError(f"{name} has shape {rows.shape}; it must have (3,), or (3, 2) for bounds")
    return [_pair(name, row) for row in rows]


def _box(robot: Robot, lower: Numbers | None, upper: Numbers | None, turn: float) -> tuple[Array, Array]:
    """Box of the given bounds, or else the position limits; `turn` for rotations without a limit."""
    limits = np.full((2, robot.nq), np.inf)
    limits[0] = -np.inf
    # A mimic joint may turn by another angle than its leader, so a turn of the leader is not all.
    leaders = {joint.mimic[0] for joint in robot.joints if joint.mimic is not None}
    for joint in robot.joints:
        if joint.q.stop - joint.q.start == joint.v.stop - joint.v.start:
            own = joint.limits.lower, joint.limits.upper
            turns = joint.kind in ("revolute", "continuous", "universal") and joint.name not in leaders
            if turns and not np.isfinite(own).all():
                own = -turn, turn
            limits[:, joint.q] = np.array(own)[:, np.newaxis]
    ends = (limits[0] if lower is None else lower), (limits[1] if upper is None else upper)
    return np.array(ends[0], np.float64), np.array(ends[1], np.float64)
