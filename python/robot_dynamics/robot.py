"""The robot."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import (
    _native,
    checks,
    control,
    files,
    identification,
    motion,
    planning,
    pullbacks,
    wrenches,
)
from robot_dynamics import constraints as constraint_functions
from robot_dynamics import sensors as sensor_functions
from robot_dynamics.numbers import Numbers
from robot_dynamics.report import LoadReport
from robot_dynamics.sensors import Sensor


class Limits(NamedTuple):
    """Limits of a joint, for each of its degrees of freedom; infinite where the file gives none."""

    lower: float
    """[rad or m]"""
    upper: float
    """[rad or m]"""
    velocity: float
    """[rad/s or m/s]"""
    effort: float
    """[N·m or N]"""


class Passive(NamedTuple):
    """Passive forces of a joint, for each of its degrees of freedom."""

    armature: float
    """Inertia of the rotor, as the joint feels it [kg·m² or kg]."""
    damping: float
    """[N·m·s/rad or N·s/m]"""
    friction: float
    """[N·m or N]"""
    stiffness: float
    """[N·m/rad or N/m]"""
    rest: float
    """Where the spring is at rest [rad or m]."""


@dataclass(frozen=True)
class Joint:
    """A joint of a robot."""

    name: str
    kind: str
    """For example ``revolute``."""
    parent: str
    """The link that carries it."""
    child: str
    """The link that it moves."""
    q: slice
    """Where its numbers are in a configuration."""
    v: slice
    """Where its numbers are in a velocity."""
    mimic: tuple[str, float, float] | None
    """The joint that it follows, ratio and offset."""
    limits: Limits
    passive: Passive


@dataclass(frozen=True)
class CoordinateLimits:
    """The limits of all coordinates, nv numbers each; infinite where there are none."""

    lower: NDArray[np.float64]
    """[rad or m]"""
    upper: NDArray[np.float64]
    """[rad or m]"""
    velocity: NDArray[np.float64]
    """[rad/s or m/s]"""
    effort: NDArray[np.float64]
    """[N·m or N]"""


class Robot(_native.Robot):
    """A robot: immutable, to be used by any number of threads at once.

    `load` makes one of a file. Robots are equal where every name and every digit of their descriptions is;
    they can be pickled and copied.

    Every method that computes takes states with any leading dimensions, q (..., nq) and v (..., nv), and
    gives results with the same. `out=` takes an array to write into, or a tuple of them, `threads=` the
    number of threads for a batch: the results are the same bits for any.

    >>> robot = rd.example("two_r")
    >>> robot
    <Robot 'two_r': 2 degrees of freedom, 3.00 kg>
    >>> import pickle
    >>> pickle.loads(pickle.dumps(robot)) == robot
    True
    """

    @cached_property
    def _data(self) -> Any:
        return json.loads(self._state())

    @cached_property
    def report(self) -> LoadReport:
        """What became of every part of the robot's file."""
        description, report = self._data
        return LoadReport._of(report, self._report_text(), self._warning_groups(), self._left_out, description.get("sensors", ()))

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """The joints, depth first, so that the coordinates of a subtree lie side by side."""
        return tuple(
            Joint(
                name,
                kind,
                parent,
                child,
                slice(q[0], q[0] + q[1]),
                slice(v[0], v[0] + v[1]),
                mimic,
                Limits(*limits),
                Passive(*passive),
            )
            for name, kind, parent, child, q, v, mimic, limits, passive in self._joints()
        )

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """The names of the joints that move."""
        return tuple(joint.name for joint in self.joints if joint.v.stop > joint.v.start)

    @cached_property
    def link_names(self) -> tuple[str, ...]:
        """The names of the links, in the file's order."""
        return tuple(link["name"] for link in self._data[0]["links"])

    @cached_property
    def limits(self) -> CoordinateLimits:
        """The limits of all coordinates.

        >>> rd.example("panda").limits.velocity
        array([2.175, 2.175, 2.175, 2.175, 2.61 , 2.61 , 2.61 ])
        """
        table = np.full((4, self.nv), np.inf)
        table[0] = -np.inf
        for joint in self.joints:
            table[:, joint.v] = np.array(joint.limits)[:, np.newaxis]
        table.flags.writeable = False
        return CoordinateLimits(*table)

    @cached_property
    def actuated_dofs(self) -> NDArray[np.bool_]:
        """The degrees of freedom that motors drive (nv,): all but those of floating joints, unless set by
        `with_actuated_joints`.

        `GravityCompensatedPd`, `ComputedTorque` and `TaskControl` give no torque to the others, and inverse
        dynamics under constraints or on supports leaves them free.

        >>> rd.example("quadruped", floating_base=True).actuated_dofs[:8]
        array([False, False, False, False, False, False,  True,  True])
        """
        actuated = np.array(self._actuated_dofs(), np.bool_)
        actuated.flags.writeable = False
        return actuated

    @cached_property
    def poses(self) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """q (nq,) and v (nv,) of the poses that the robot's file names: MJCF's keyframes."""
        return {name: (np.array(q), np.array(v)) for name, q, v in self._poses()}

    def describe(self) -> dict[str, Any]:
        """The robot as plain data: links, joints, frames, gravity; see `from_description`.

        >>> description = rd.example("two_r").describe()
        >>> description["gravity"] = [0.0, 0.0, -1.62]  # to the moon with it
        >>> rd.Robot.from_description(description).gravity([0.0, 0.0]).round(3)
        array([4.05, 0.81])
        """
        description: dict[str, Any] = json.loads(self._state())[0]
        return description

    @classmethod
    def from_description(cls, description: dict[str, Any]) -> Robot:
        """A robot of plain data, as `describe` gives it."""
        report = {"robot": description.get("name", ""), "counts": _NO_COUNTS, "findings": []}
        return cls("json", json.dumps([description, report]))

    def lock(self, *joints: str, at: Mapping[str, Numbers] | None = None) -> Robot:
        """The robot with joints held still: where they rest, or `at` given positions; see `JointMap`.

        >>> rd.example("panda").lock("panda_joint7", at={"panda_joint6": 0.5}).nv
        5
        """
        placed = {name: [float(x) for x in np.ravel(np.asarray(q, np.float64))] for name, q in (at or {}).items()}
        return self._edited(self._lock([*((name, None) for name in joints), *placed.items()]))

    def lock_massless(self) -> Robot:
        """The robot with all joints held still that move no inertia.

        >>> rd.example("panda").lock_massless().nv
        7
        """
        state, _ = self._lock_massless()
        return self._edited(state)

    def with_payload(
        self, link: str, mass: float, center_of_mass: Numbers = (0.0, 0.0, 0.0), inertia: Numbers | None = None
    ) -> Robot:
        """The robot with a body on a link: mass [kg], centre of mass [m] in the link's frame, inertia about
        it [kg·m²].

        >>> robot = rd.example("panda")
        >>> loaded = robot.with_payload("panda_link8", 2.0, [0.0, 0.0, 0.1])
        >>> round(loaded.mass - robot.mass, 9)
        2.0
        """
        return self._edited(self._with_payload(link, mass, center_of_mass, inertia))

    def with_actuated_joints(self, *joints: str) -> Robot:
        """The robot with motors at these joints and at no others; see `actuated_dofs`.

        `floating_base` is the joint of a floating base, for a robot with thrusters.

        >>> acrobot = rd.example("two_r").with_actuated_joints("elbow")
        >>> acrobot.actuated_dofs
        array([False,  True])
        """
        return self._edited(self._with_actuated_joints(list(joints)))

    def with_sensors(self, sensors: Mapping[str, tuple[str | None, ...]]) -> Robot:
        """The robot with more sensors, by name: the kind and what it is on, and for relative values a
        reference frame.

        Kinds have MJCF's names. Most are on a frame or link; `jointpos`, `tendonpos`, `actuatorfrc` and
        similar kinds on a joint, tendon or actuator; `subtreecom` and similar kinds on a link; `clock`,
        `e_kinetic` and `e_potential` on nothing.

        >>> robot = rd.example("two_r").with_sensors({"encoder": ("jointpos", "shoulder"), "time": ("clock",)})
        >>> robot.sensor_values([0.3, 1.2], [0.0, 0.0], [0.0, 0.0], time=2.0)["encoder"]
        array([0.3])
        """
        rows = [(name, *((*sensor, None, None)[:3])) for name, sensor in sensors.items()]
        return self._edited(self._with_sensors(rows))

    def with_gravity_scaled(self, factor: float) -> Robot:
        """The robot where things fall slower or faster.

        >>> rd.example("panda").with_gravity_scaled(0.0).gravity(np.zeros(7)).any()
        np.False_
        """
        return self._edited(self._with_gravity_scaled(factor))

    def with_parameters(self, parameters: Numbers, *, as_written: bool = False) -> Robot:
        """The robot with other `parameters()`: inertias, passive forces of the joints, gravity; geometry and
        limits stay.

        What is fixed to a moving link counts with the link, so that the links fixed to it have no mass in the
        result. Raises DescriptionError where a number cannot be, a negative mass for one, and where a link's
        parameters are changed to what `physical_consistency` rejects. `as_written` takes these, as `load`
        does from a file.

        >>> robot = rd.example("two_r")
        >>> values = robot.parameters()
        >>> values[robot.parameter_names.index("elbow.damping")] = 0.3
        >>> robot.with_parameters(values).dissipation([0.0, 1.0]).round(3)
        array([0. , 0.3])
        """
        return self._edited(self._with_parameters(parameters, as_written))

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """The sensors that the file states, or that `with_sensors` has added, in the order of their values.

        >>> robot = rd.example("two_r").with_sensors({"imu": ("accelerometer", "tip")})
        >>> robot.sensors
        (Sensor(name='imu', kind='accelerometer', size=3),)
        """
        return tuple(Sensor(*sensor) for sensor in self._sensors())

    # Motion in time.
    simulate = motion.simulate
    rollout = motion.rollout
    step = motion.step
    linearize_step = motion.linearize_step
    rollout_pullback = pullbacks.rollout_pullback
    step_pullback = pullbacks.step_pullback

    # External wrenches and sensors.
    inverse_dynamics_with_wrenches = wrenches.inverse_dynamics_with_wrenches
    forward_dynamics_with_wrenches = wrenches.forward_dynamics_with_wrenches
    inverse_dynamics_derivatives_with_wrenches = wrenches.inverse_dynamics_derivatives_with_wrenches
    forward_dynamics_derivatives_with_wrenches = wrenches.forward_dynamics_derivatives_with_wrenches
    joint_reactions = sensor_functions.joint_reactions
    sensor_values = sensor_functions.sensor_values

    # Constraints and supports.
    constraints = constraint_functions.constraints
    constraint_rows = constraint_functions.constraint_rows
    constrained_forward_dynamics = constraint_functions.constrained_forward_dynamics
    constrained_inverse_dynamics = constraint_functions.constrained_inverse_dynamics
    supported_inverse_dynamics = constraint_functions.supported_inverse_dynamics
    contact_impulse = constraint_functions.contact_impulse
    project = constraint_functions.project
    constraint_projections = constraint_functions.constraint_projections

    # Control, planning and identification.
    inverse_kinematics = control.inverse_kinematics
    operational_space = control.operational_space
    time_optimal = planning.time_optimal
    base_parameters = identification.base_parameters
    identify = identification.identify
    physical_consistency = identification.physical_consistency

    # Checks.
    audit = checks.audit
    suspicions = checks.suspicions

    # Files and generated code.
    to_text = files.to_text
    write = files.write
    generate = files.generate

    def _edited(self, state: str) -> Robot:
        return type(self)("json", state)

    def normalize(self, q: Numbers) -> NDArray[Any]:
        """q (..., nq) with its quaternions made of unit length.

        >>> robot = rd.example("quadruped", floating_base=True)
        >>> robot.normalize(robot.neutral() * 2.0)[:7]
        array([0., 0., 0., 0., 0., 0., 1.])
        """
        given = np.asarray(q)
        normal = np.array(given, given.dtype if given.dtype == np.float32 else np.float64)
        for joint in self.joints:
            width = joint.q.stop - joint.q.start
            if width > joint.v.stop - joint.v.start:
                quaternion = normal[..., joint.q.stop - 4 : joint.q.stop]
                quaternion /= np.linalg.norm(quaternion, axis=-1, keepdims=True)
        return normal

    def show(self, trajectory: Any = None, *, dt: float | None = None, open_browser: bool = True) -> Any:
        """Opens a viewer (meshcat, ``pip install robot-dynamics[view]``) with the robot's visual shapes and
        meshes.

        Links without visual shapes show their collision shapes. Boxes of the same inertia stand for links
        whose meshes cannot be drawn, and for a robot whose file has no shapes.

        `trajectory` is a `Motion`, a `TimedPath`, configurations (n, nq) every `dt` seconds, or one (nq,).
        Returns the viewer.
        """
        from robot_dynamics import viewer

        return viewer.show(self, trajectory, dt=dt, open_browser=open_browser)

    def _repr_html_(self) -> str:
        from robot_dynamics import html

        return html.robot_html(self)

    def __reduce__(self) -> Any:
        return _restored, (type(self), self._state())

    def __copy__(self) -> Robot:
        return self

    def __deepcopy__(self, memo: Any) -> Robot:
        return self

    def __repr__(self) -> str:
        freedoms = "degree" if self.nv == 1 else "degrees"
        return f"<Robot {self.name!r}: {self.nv} {freedoms} of freedom, {self.total_mass:.2f} kg>"


def _name_methods(cls: type) -> None:
    """Names the functions bound in a class after it, so that error messages, `help` and pickles show the
    class."""
    for name, member in vars(cls).items():
        if isinstance(member, FunctionType):
            member.__qualname__ = f"{cls.__qualname__}.{name}"
            member.__module__ = cls.__module__


_name_methods(Robot)


def _restored(cls: type[Robot], state: str) -> Robot:
    return cls("json", state)


_NO_COUNTS = dict.fromkeys(
    (
        "links",
        "joints",
        "degrees_of_freedom",
        "read",
        "defaulted",
        "as_written",
        "repaired",
        "ignored",
        "ignored_physics",
        "warnings",
        "errors",
        "not_dynamics",
        "unlisted",
    ),
    0,
)
