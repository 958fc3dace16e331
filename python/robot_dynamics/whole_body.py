"""Whole-body control: torques, accelerations and contact forces from one quadratic program.

The variables are x = (q̈, f), with three components of force at each contact point:

    minimise ½ Σ w |A x − b|² over the tasks
    with  M q̈ + C v + g − Jᵀf = τ,  τ = 0 without a motor,  |τ| ≤ τ_max
          J q̈ + J̇ v = −kd J v for held contacts
          f in its friction pyramid,  q̈ within the bounds of the joints' limits

>>> robot = rd.example("quadruped", floating_base=True)
>>> wb, q = rd.whole_body, np.r_[0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0, np.tile([0.0, 0.7, -1.4], 4)]
>>> control = wb.WholeBodyControl(robot)
>>> for foot in ("front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"):
...     _ = control.add_contact(wb.HeldContact(foot, wb.Ball(0.02), friction=0.7))
>>> _ = control.add_task(wb.Posture(q, stiffness=100.0))
>>> solution = control.solve(q, np.zeros(18))
>>> bool(np.isclose(sum(point.force[2] for point in solution.forces), 9.81 * robot.mass))
True

The equations are eliminated, and a dual active-set method starts from the limits of the last call.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Point:
    """Point of a frame that does not move; the link may rotate about it."""

    _kind: ClassVar[str] = "point"

    offset: Numbers = (0.0, 0.0, 0.0)
    """Position along the frame's axes (3,) [m]."""


@dataclass(frozen=True, eq=False)
class Ball:
    """Ball around the origin of a frame, which rolls without slip."""

    _kind: ClassVar[str] = "ball"

    radius: float
    """Radius [m]."""


@dataclass(frozen=True, eq=False)
class Face:
    """Face of a frame that neither moves nor rotates; forces act at its corners."""

    _kind: ClassVar[str] = "face"

    corners: Numbers
    """Corners along the frame's axes (n, 3) [m]."""


@dataclass(frozen=True, eq=False)
class HeldContact:
    """Contact with the environment that does not move, with a friction pyramid at each of its points.

    The pyramid has its edges on the cone |f_t| ≤ μ f_n, and is inside it.
    """

    frame: str | int
    """Name of the frame, or its index in `frame_names`."""
    geometry: Point | Ball | Face
    """Part of the link that touches."""
    friction: float = field(kw_only=True)
    """Friction coefficient μ."""
    sides: int = field(default=4, kw_only=True)
    """Number of sides of the pyramid, at least 3."""
    normal: Numbers = field(default=(0.0, 0.0, 1.0), kw_only=True)
    """Unit vector in the world that points to the robot (3,)."""
    normal_force: Numbers = field(default=(0.0, float("inf")), kw_only=True)
    """Smallest and largest normal force at each point (2,) [N]."""
    damping: float = field(default=10.0, kw_only=True)
    """kd: the velocity of the contact decays by v̇ = −kd v [1/s]."""


@dataclass(frozen=True, eq=False)
class FramePose:
    """J q̈ + J̇ v = V̇* + kp e + kd (V* − V) with e = (x* − x, log(R*Rᵀ)), along the world's axes."""

    _kind: ClassVar[str] = "frame_pose"

    frame: str | int
    """Name of the frame, or its index in `frame_names`."""
    pose: Numbers
    """Target pose, world from frame (4, 4)."""
    stiffness: float = field(kw_only=True)
    """kp [1/s²]."""
    damping: float | None = field(default=None, kw_only=True)
    """kd [1/s]; default: 2 √kp."""
    velocity: Numbers | None = field(default=None, kw_only=True)
    """V* (6,), linear part first [m/s, rad/s]; default: rest."""
    acceleration: Numbers | None = field(default=None, kw_only=True)
    """V̇* (6,), linear part first [m/s², rad/s²]; default: zeros."""
    rows: Sequence[str] | None = field(default=None, kw_only=True)
    """Controlled directions among x, y, z, rx, ry, rz; default: all."""


@dataclass(frozen=True, eq=False)
class FrameVelocity:
    """J q̈ + J̇ v = V̇* + kd (V* − V), along the world's axes."""

    _kind: ClassVar[str] = "frame_velocity"

    frame: str | int
    """Name of the frame, or its index in `frame_names`."""
    velocity: Numbers | None = None
    """V* (6,), linear part first [m/s, rad/s]; default: rest."""
    damping: float = field(kw_only=True)
    """kd [1/s]."""
    acceleration: Numbers | None = field(default=None, kw_only=True)
    """V̇* (6,), linear part first [m/s², rad/s²]; default: zeros."""
    rows: Sequence[str] | None = field(default=None, kw_only=True)
    """Controlled directions among x, y, z, rx, ry, rz; default: all."""


@dataclass(frozen=True, eq=False)
class CenterOfMass:
    """c̈ = c̈* + kp (c* − c) + kd (ċ* − ċ) of the centre of mass."""

    _kind: ClassVar[str] = "center_of_mass"

    position: Numbers
    """Target c* (3,) [m]."""
    stiffness: float = field(kw_only=True)
    """kp [1/s²]."""
    damping: float | None = field(default=None, kw_only=True)
    """kd [1/s]; default: 2 √kp."""
    velocity: Numbers | None = field(default=None, kw_only=True)
    """ċ* (3,) [m/s]; default: rest."""
    acceleration: Numbers | None = field(default=None, kw_only=True)
    """c̈* (3,) [m/s²]; default: zeros."""


@dataclass(frozen=True, eq=False)
class Posture:
    """q̈ = q̈* + kp (q* ⊖ q) + kd (v* − v) of the coordinates with motors."""

    _kind: ClassVar[str] = "posture"

    q: Numbers
    """Target q* (nq,)."""
    stiffness: float = field(kw_only=True)
    """kp [1/s²]."""
    damping: float | None = field(default=None, kw_only=True)
    """kd [1/s]; default: 2 √kp."""
    velocity: Numbers | None = field(default=None, kw_only=True)
    """v* (nv,); default: rest."""
    acceleration: Numbers | None = field(default=None, kw_only=True)
    """q̈* (nv,); default: zeros."""


@dataclass(frozen=True, eq=False)
class AngularMomentum:
    """k̇ = k̇* + kd (k* − k) of the angular momentum about the centre of mass."""

    _kind: ClassVar[str] = "angular_momentum"

    damping: float = field(kw_only=True)
    """kd [1/s]."""
    momentum: Numbers | None = field(default=None, kw_only=True)
    """k* (3,) [kg·m²/s]; default: zeros."""
    rate: Numbers | None = field(default=None, kw_only=True)
    """k̇* (3,) [N·m]; default: zeros."""


@dataclass(frozen=True, eq=False)
class Torque:
    """τ = τ* of the coordinates with motors."""

    _kind: ClassVar[str] = "torque"

    torque: Numbers
    """Target τ* (nv,) [N·m, N]."""


@dataclass(frozen=True, eq=False)
class ContactForces:
    """f = 0 for the forces of all contacts [N]: a small weight distributes them evenly."""

    _kind: ClassVar[str] = "contact_forces"


Objective: TypeAlias = (
    FramePose | FrameVelocity | CenterOfMass | Posture | AngularMomentum | Torque | ContactForces
)


class Limits(NamedTuple):
    """Limits of each coordinate of the velocity; infinite entries do not limit.

    |τ| ≤ `torque`, |q̈| ≤ `acceleration`, and with the rate κ −κ (v_max + v) ≤ q̈ ≤ κ (v_max − v) and κ² (q_min
    − q) − 2κ v ≤ q̈ ≤ κ² (q_max − q) − 2κ v.
    """

    torque: Array
    """Largest |τ| (nv,) [N·m, N]."""
    acceleration: Array
    """Largest |q̈| (nv,) [rad/s², m/s²]."""
    velocity: Array
    """Largest |v| (nv,) [rad/s, m/s]."""
    lower: Array
    """Smallest q of joints with one coordinate (nv,) [rad, m]."""
    upper: Array
    """Largest q of joints with one coordinate (nv,) [rad, m]."""
    rate: float
    """κ [1/s]; at most half the frequency at which torques are computed."""


class PointForce(NamedTuple):
    """Force at a point of a contact."""

    contact: int
    """Number of the contact."""
    point: int
    """Index of the point in the contact."""
    position: Array
    """Position in the world (3,) [m]."""
    force: Array
    """Force on the robot along the world's axes (3,) [N]."""


class ActiveLimit(NamedTuple):
    """Limit that determines the solution of the last level."""

    kind: Literal["torque", "acceleration", "normal_force", "friction"]
    """Kind of the limit. The acceleration is limited by the joint's position, velocity and acceleration."""
    coordinate: str | None
    """Name of the limited coordinate."""
    contact: int | None
    """Number of the contact with the limited force."""
    point: int | None
    """Index of the point in the contact."""
    is_upper: bool
    """Whether it is the upper bound."""
    multiplier: float
    """Decrease of ½ Σ w r² of the last level for each unit by which the bound is relaxed."""


@dataclass(frozen=True, eq=False)
class Solution:
    """Torques, accelerations and contact forces of one state."""

    torque: Array
    """τ (nv,) [N·m, N]; zero for coordinates without a motor."""
    acceleration: Array
    """q̈ (nv,) [rad/s², m/s²]."""
    forces: list[PointForce]
    """Forces at the points of the held contacts."""
    active_limits: list[ActiveLimit]
    """Limits that determine the solution of the last level."""
    task_errors: Array
    """|A x − b| of each task (tasks,); zero for tasks of weight zero."""
    steps: int
    """Number of changes of the active limits."""


class WholeBodyControl(_native.WholeBody):
    """Whole-body controller of one robot: a function of (t, q, v), which `Robot.simulate` takes as `tau`.

    >>> robot = rd.example("panda")
    >>> control = rd.whole_body.WholeBodyControl(robot, dissipation=True)
    >>> q = np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6])
    >>> goal = robot.frame_pose(q + 0.1, "panda_link8")
    >>> _ = control.add_task(rd.whole_body.FramePose("panda_link8", goal, stiffness=100.0), level=0)
    >>> _ = control.add_task(rd.whole_body.Posture(q, stiffness=25.0), level=1)
    >>> motion = robot.simulate(q, tau=control, duration=2.0, without=["limits"])
    >>> bool(np.allclose(robot.frame_pose(motion.q[-1], "panda_link8"), goal, atol=1e-3))
    True
    """

    def __new__(cls, robot: Robot, *, dissipation: bool = False) -> Self:
        """Create a controller without contacts and tasks, with the limits of the robot's file.

        Parameters
        ----------
        robot : Robot
            Robot to control.
        dissipation : bool
            Whether the torques compensate damping and friction of the joints.

        Returns
        -------
        WholeBodyControl
            The controller.
        """
        return super().__new__(cls, robot, dissipation=dissipation)

    @property
    def limits(self) -> Limits:
        """Limits of the torques and of the joints' motion."""
        return Limits(**self._limits())

    def set_limits(
        self,
        *,
        torque: Numbers | None = None,
        acceleration: Numbers | None = None,
        velocity: Numbers | None = None,
        lower: Numbers | None = None,
        upper: Numbers | None = None,
        rate: float | None = None,
    ) -> None:
        """Replace limits; `None` keeps one.

        Parameters
        ----------
        torque, acceleration, velocity, lower, upper : array_like, shape (nv,), optional
            See `Limits`; infinite entries do not limit.
        rate : float, optional
            κ [1/s].

        Raises
        ------
        ShapeError
            An array has the wrong shape.
        StateError
            A limit is negative, or `lower` exceeds `upper`.
        """
        given = {"torque": torque, "acceleration": acceleration, "velocity": velocity}
        self._set_limits(given | {"lower": lower, "upper": upper, "rate": rate})

    def add_contact(self, contact: HeldContact) -> int:
        """Add a contact, which is held.

        Parameters
        ----------
        contact : HeldContact
            The contact.

        Returns
        -------
        int
            Number of the contact.

        Raises
        ------
        FrameError
            The frame does not exist.
        ShapeError
            An array has the wrong shape.
        StateError
            A number of the contact is invalid.
        TypeError
            It is not a contact.
        """
        return self._add_contact(contact)

    def hold_contact(self, contact: int, is_held: bool) -> None:
        """Hold a contact, or release it: a released contact has no force and moves freely.

        Parameters
        ----------
        contact : int
            Number of the contact.
        is_held : bool
            Whether it is held.

        Raises
        ------
        IndexError
            The contact does not exist.
        """
        self._hold_contact(contact, is_held)

    def add_task(self, objective: Objective, weight: float = 1.0, *, level: int = 0) -> int:
        """Add a task. Weights decide between tasks of one level; a level does not change those before it.

        Parameters
        ----------
        objective : Objective
            Quantity that the task controls.
        weight : float
            Weight w; 0 switches the task off.
        level : int
            Level; smaller numbers come first.

        Returns
        -------
        int
            Number of the task.

        Raises
        ------
        FrameError
            The frame does not exist.
        ShapeError
            An array has the wrong shape.
        StateError
            A number is not finite, or the weight is negative.
        TypeError
            It is not an objective.
        """
        return self._add_task(objective, weight, level)

    def set_objective(self, task: int, objective: Objective) -> None:
        """Change the objective of a task, for example its target.

        Parameters
        ----------
        task : int
            Number of the task.
        objective : Objective
            New objective.

        Raises
        ------
        FrameError
            The frame does not exist.
        IndexError
            The task does not exist.
        ShapeError
            An array has the wrong shape.
        TypeError
            It is not an objective.
        """
        self._set_objective(task, objective)

    def set_weight(self, task: int, weight: float) -> None:
        """Change the weight of a task.

        Parameters
        ----------
        task : int
            Number of the task.
        weight : float
            Weight w; 0 switches the task off.

        Raises
        ------
        IndexError
            The task does not exist.
        StateError
            The weight is negative or not finite.
        """
        self._set_weight(task, weight)

    def solve(self, q: Numbers, v: Numbers) -> Solution:
        """Compute torques, accelerations and contact forces at a state.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Configuration.
        v : array_like, shape (nv,)
            Velocity.

        Returns
        -------
        Solution
            The solution.

        Raises
        ------
        ControlError
            No motion satisfies the dynamics, the contacts and the limits together.
        ShapeError
            An array has the wrong shape.
        StateError
            `q` is not a configuration, or a number is not finite.
        """
        record: dict[str, Any] = self._solve(q, v)
        forces = [PointForce(*fields) for fields in record.pop("forces")]
        limits = [ActiveLimit(*fields) for fields in record.pop("active_limits")]
        return Solution(**record, forces=forces, active_limits=limits)
