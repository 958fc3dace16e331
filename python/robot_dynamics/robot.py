"""The robot."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import (
    _native,
    certified,
    checks,
    control,
    conventions,
    drives,
    edits,
    excitation,
    files,
    identification,
    motion,
    planning,
    pullbacks,
    wrenches,
)
from robot_dynamics import constraint_derivatives
from robot_dynamics import constraints as constraint_functions
from robot_dynamics import fluid as fluid_functions
from robot_dynamics import sensors as sensor_functions
from robot_dynamics.numbers import Numbers
from robot_dynamics.report import LoadReport
from robot_dynamics.sensors import Sensor


class Limits(NamedTuple):
    """Limits of a joint, for each of its degrees of freedom; infinite if the file gives none."""

    lower: float
    """Lower position limit [rad or m]."""
    upper: float
    """Upper position limit [rad or m]."""
    velocity: float
    """Speed limit [rad/s or m/s]."""
    effort: float
    """Limit of torque or force [N·m or N]."""


class Passive(NamedTuple):
    """Passive forces of a joint, for each of its degrees of freedom."""

    armature: float
    """Inertia of the rotor, reflected to the joint [kg·m² or kg]."""
    damping: float
    """Viscous damping [N·m·s/rad or N·s/m]."""
    friction: float
    """Dry friction [N·m or N]."""
    stiffness: float
    """Stiffness of the spring [N·m/rad or N/m]."""
    rest: float
    """Rest position of the spring [rad or m]."""


@dataclass(frozen=True)
class Joint:
    """A joint of a robot."""

    name: str
    """Name of the joint."""
    index: int
    """Index in `Robot.joints`."""
    kind: str
    """For example ``revolute``."""
    parent_link: str
    """The link that carries it; ``world`` for a floating base."""
    child_link: str
    """The link that it moves."""
    parent_joint: int | None
    """Index of the joint that carries the parent link; `None` at the root."""
    q: slice
    """Its entries in a configuration; empty for fixed and mimic joints."""
    v: slice
    """Its entries in a velocity; empty for fixed and mimic joints."""
    mimic: tuple[str, float, float] | None
    """Leader of a mimic joint, with ratio and offset [rad or m]."""
    limits: Limits
    """Limits for each of its degrees of freedom."""
    passive: Passive
    """Passive forces for each of its degrees of freedom."""


@dataclass(frozen=True, eq=False)
class Link:
    """A link of a robot."""

    name: str
    """Name of the link."""
    index: int
    """Index in `Robot.links`."""
    parent_joint: int | None
    """Index of the joint that carries it; `None` for the root of a robot on a fixed base."""
    mass: float
    """Mass [kg]; 0 if the file gives none."""
    center_of_mass: NDArray[np.float64]
    """Centre of mass in the link's frame (3,) [m]."""
    inertia: NDArray[np.float64]
    """Rotational inertia about the centre of mass, along the link's axes (3, 3) [kg·m²]."""


@dataclass(frozen=True)
class CoordinateLimits:
    """Limits of all coordinates, each (nv,); infinite without a limit."""

    lower: NDArray[np.float64]
    """Lower position limits [rad or m]."""
    upper: NDArray[np.float64]
    """Upper position limits [rad or m]."""
    velocity: NDArray[np.float64]
    """Speed limits [rad/s or m/s]."""
    effort: NDArray[np.float64]
    """Limits of torque or force [N·m or N]."""


@dataclass(frozen=True)
class Group:
    """A group of links and joints, such as an arm for a motion planner."""

    name: str
    """Name of the group."""
    links: tuple[str, ...]
    """All its links, in the robot's order."""
    joints: tuple[str, ...]
    """All its joints, in the robot's order."""
    chains: tuple[tuple[str, str], ...]
    """Base link and tip link of the chains that the file lists."""
    subgroups: tuple[str, ...]
    """Groups that the file lists as a part of it."""


@dataclass(frozen=True)
class EndEffector:
    """A group that is a tool, such as a gripper."""

    name: str
    """Name of the tool."""
    group: str
    """The group of its links and joints."""
    parent_link: str
    """The link that carries it."""
    parent_group: str | None
    """The group that moves it, if the file states one."""


class Robot(_native.Robot):
    """Robot: an immutable model that any number of threads can share.

    `load` creates a robot from a file. Robots are equal if all names and all digits of their descriptions are
    equal. They can be pickled and copied.

    Computing methods take states with any leading dimensions, q (..., nq) and v (..., nv), and return results
    with the same dimensions. `out=` takes an array for the result, or a tuple of arrays. `threads=` is the
    number of threads for a batch. The results have the same bits for any number.

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
        """Report on the content of the robot's file."""
        description, report = self._data
        return LoadReport._of(report, self._report_text(), self._warning_groups(), self._left_out, description.get("sensors", ()))

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """The joints, depth first, so that the coordinates of each subtree are contiguous.

        >>> robot = rd.example("two_r")
        >>> elbow = robot.joints[1]
        >>> elbow.name, elbow.parent_link, robot.joints[elbow.parent_joint].name, elbow.q
        ('elbow', 'upper', 'shoulder', slice(1, 2, None))
        """
        return tuple(
            Joint(
                name,
                index,
                kind,
                parent_link,
                child_link,
                parent_joint,
                slice(q[0], q[0] + q[1]),
                slice(v[0], v[0] + v[1]),
                mimic,
                Limits(*limits),
                Passive(*passive),
            )
            for (name, index, kind), (parent_link, child_link, parent_joint), q, v, mimic, limits, passive in self._joints()
        )

    @cached_property
    def links(self) -> tuple[Link, ...]:
        """The links, in the file's order.

        >>> robot = rd.example("two_r")
        >>> fore = robot.links[2]
        >>> fore.name, fore.mass, fore.center_of_mass, robot.joints[fore.parent_joint].name
        ('fore', 1.0, array([0.5, 0. , 0. ]), 'elbow')
        """
        links = []
        for name, index, parent_joint, mass, center_of_mass, inertia in self._links():
            arrays = np.array(center_of_mass), np.array(inertia)
            for array in arrays:
                array.flags.writeable = False
            links.append(Link(name, index, parent_joint, mass, *arrays))
        return tuple(links)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints that move."""
        return tuple(joint.name for joint in self.joints if joint.v.stop > joint.v.start)

    @cached_property
    def link_names(self) -> tuple[str, ...]:
        """The names of the links, in the file's order."""
        return tuple(link.name for link in self.links)

    @cached_property
    def limits(self) -> CoordinateLimits:
        """Limits of all coordinates.

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
        """Degrees of freedom that motors drive (nv,).

        These are all but those of floating joints, unless set by `with_actuated_joints`.
        `GravityCompensatedPd`, `ComputedTorque` and `TaskControl` give no torque to the others. Inverse
        dynamics under constraints or on supports leaves them free.

        >>> rd.example("quadruped", floating_base=True).actuated_dofs[:8]
        array([False, False, False, False, False, False,  True,  True])
        """
        actuated = np.array(self._actuated_dofs(), np.bool_)
        actuated.flags.writeable = False
        return actuated

    @cached_property
    def poses(self) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Named poses of the file, MJCF keyframes or SRDF group states: q (nq,) and v (nv,) by name."""
        return {name: (np.array(q), np.array(v)) for name, q, v in self._poses()}

    @cached_property
    def groups(self) -> dict[str, Group]:
        """Groups of links and joints by name, of the SRDF file given to `load`."""
        groups = self._data[0].get("groups", ())
        return {
            group["name"]: Group(
                group["name"],
                tuple(group["links"]),
                tuple(group["joints"]),
                tuple((base, tip) for base, tip in group["chains"]),
                tuple(group["subgroups"]),
            )
            for group in groups
        }

    @cached_property
    def end_effectors(self) -> dict[str, EndEffector]:
        """Groups that are tools, by the name of the tool, of the SRDF file given to `load`."""
        tools = self._data[0].get("end_effectors", ())
        return {tool["name"]: EndEffector(**tool) for tool in tools}

    def describe(self) -> dict[str, Any]:
        """Plain data of the robot: links, joints, frames, gravity and more; see `from_description`.

        The page `docs/describe.md` of the repository lists every key with its unit.

        Returns
        -------
        dict
            Description, of types that JSON can express.

        Examples
        --------
        >>> description = rd.example("two_r").describe()
        >>> description["gravity"] = [0.0, 0.0, -1.62]  # on the Moon
        >>> rd.Robot.from_description(description).gravity([0.0, 0.0]).round(3)
        array([4.05, 0.81])
        """
        description: dict[str, Any] = json.loads(self._state())[0]
        return description

    @classmethod
    def from_description(cls, description: dict[str, Any]) -> Robot:
        """Create a robot from plain data, as returned by `describe`.

        Parameters
        ----------
        description : dict
            Description of the robot.

        Returns
        -------
        Robot
            The robot.

        Raises
        ------
        LoadError
            The description is invalid.
        """
        report = {"robot": description.get("name", ""), "counts": _NO_COUNTS, "findings": []}
        return cls("json", json.dumps([description, report]))

    def lock(self, *joints: str, at: Mapping[str, Numbers] | None = None) -> Robot:
        """Robot with locked joints; see `JointMap`.

        Parameters
        ----------
        *joints : str
            Names of joints to lock at their rest positions.
        at : mapping of str to array_like, optional
            Positions of further joints to lock [rad or m], by name.

        Returns
        -------
        Robot
            The robot with the other joints.

        Raises
        ------
        DescriptionError
            A joint does not exist, or a position is invalid.

        Examples
        --------
        >>> rd.example("panda").lock("panda_joint7", at={"panda_joint6": 0.5}).nv
        5
        """
        placed = {name: [float(x) for x in np.ravel(np.asarray(q, np.float64))] for name, q in (at or {}).items()}
        return self._edited(self._lock([*((name, None) for name in joints), *placed.items()]))

    def lock_massless(self) -> Robot:
        """Robot with all joints locked that move no inertia.

        Returns
        -------
        Robot
            The robot with the other joints.

        Examples
        --------
        >>> rd.example("panda").lock_massless().nv
        7
        """
        state, _ = self._lock_massless()
        return self._edited(state)

    def with_payload(
        self, link: str, mass: float, center_of_mass: Numbers = (0.0, 0.0, 0.0), inertia: Numbers | None = None
    ) -> Robot:
        """Robot with an additional body on a link.

        Parameters
        ----------
        link : str
            Name of the link.
        mass : float
            Mass [kg].
        center_of_mass : array_like, shape (3,)
            Centre of mass in the link's frame [m].
        inertia : array_like, shape (3, 3), optional
            Inertia about the centre of mass [kg·m²]; default: 0.

        Returns
        -------
        Robot
            The loaded robot.

        Raises
        ------
        DescriptionError
            The link does not exist, or no rigid body has these mass properties.
        ShapeError
            An array has the wrong shape.

        Examples
        --------
        >>> robot = rd.example("panda")
        >>> loaded = robot.with_payload("panda_link8", 2.0, [0.0, 0.0, 0.1])
        >>> round(loaded.mass - robot.mass, 9)
        2.0
        """
        return self._edited(self._with_payload(link, mass, center_of_mass, inertia))

    def with_actuated_joints(self, *joints: str) -> Robot:
        """Robot with motors at the given joints only; see `actuated_dofs`.

        Parameters
        ----------
        *joints : str
            Names of the joints. `floating_base` is the joint of a floating base, for a robot with thrusters.

        Returns
        -------
        Robot
            The robot with these motors.

        Raises
        ------
        DescriptionError
            A joint does not exist.

        Examples
        --------
        >>> acrobot = rd.example("two_r").with_actuated_joints("elbow")
        >>> acrobot.actuated_dofs
        array([False,  True])
        """
        return self._edited(self._with_actuated_joints(list(joints)))

    def with_sensors(self, sensors: Mapping[str, tuple[str, *tuple[str | None, ...]]]) -> Robot:
        """Robot with additional sensors.

        Kinds have the names of MJCF. Most are attached to a frame or link. `jointpos`, `tendonpos`,
        `actuatorfrc` and similar kinds are attached to a joint, tendon or actuator, and `subtreecom` and
        similar kinds to a link. `clock`, `e_kinetic` and `e_potential` have no object.

        Parameters
        ----------
        sensors : mapping of str to tuple
            For each name the kind, the object, and for relative values a reference frame.

        Returns
        -------
        Robot
            The robot with these sensors.

        Raises
        ------
        DescriptionError
            A kind or an object does not exist.

        Examples
        --------
        >>> robot = rd.example("two_r").with_sensors({"encoder": ("jointpos", "shoulder"), "time": ("clock",)})
        >>> robot.sensor_values([0.3, 1.2], [0.0, 0.0], [0.0, 0.0], time=2.0)["encoder"]
        array([0.3])
        """
        rows = []
        for name, (kind, *places) in sensors.items():
            place, reference, *_ = (*places, None, None)
            rows.append((name, kind, place, reference))
        return self._edited(self._with_sensors(rows))

    def with_fluid(self, density: float, viscosity: float = 0.0, *, wind: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Robot:
        """Robot in a fluid, such as air or water.

        Its drag acts on the ellipsoids that an MJCF file states, and on the inertia box of every other link
        with mass, as in MuJoCo. Simulations include it with the other dissipative forces. There is no
        buoyancy.

        Parameters
        ----------
        density : float
            Density [kg/m³]: 1.2 for air, 1000 for water.
        viscosity : float
            Viscosity [Pa·s]: 0.00002 for air, 0.0009 for water.
        wind : tuple of float
            Velocity of the fluid in the world (3,) [m/s].

        Returns
        -------
        Robot
            The robot in this fluid.

        Raises
        ------
        DescriptionError
            A number is negative or not finite.

        Examples
        --------
        >>> swimmer = rd.example("two_r").with_fluid(1000.0, 9e-4)
        >>> swimmer.fluid_forces([0.0, 0.0], [1.0, 0.0])[0] < 0
        np.True_
        """
        return self._edited(self._with_fluid(density, viscosity, wind))

    def with_gravity_scaled(self, factor: float) -> Robot:
        """Robot with gravity scaled by a factor.

        Parameters
        ----------
        factor : float
            Factor of the acceleration of gravity.

        Returns
        -------
        Robot
            The robot with this gravity.

        Raises
        ------
        DescriptionError
            The factor is not finite.

        Examples
        --------
        >>> rd.example("panda").with_gravity_scaled(0.0).gravity(np.zeros(7)).any()
        np.False_
        """
        return self._edited(self._with_gravity_scaled(factor))

    def with_parameters(self, parameters: Numbers, *, as_written: bool = False) -> Robot:
        """Robot with other `parameters()`: inertias, passive forces of the joints, and gravity.

        Geometry and limits stay. Bodies fixed to a moving link count with that link, so the links fixed to it
        have no mass in the result.

        Parameters
        ----------
        parameters : array_like, shape (n,)
            Parameters in the order of `parameter_names`.
        as_written : bool
            Whether to accept inertias that no rigid body has, as `load` does.

        Returns
        -------
        Robot
            The robot with these parameters.

        Raises
        ------
        DescriptionError
            A parameter is invalid, for example a negative mass. Without `as_written`, also if a changed link
            violates `physical_consistency`.

        Examples
        --------
        >>> robot = rd.example("two_r")
        >>> values = robot.parameters()
        >>> values[robot.parameter_names.index("elbow.damping")] = 0.3
        >>> robot.with_parameters(values).dissipation([0.0, 1.0]).round(3)
        array([0. , 0.3])
        """
        return self._edited(self._with_parameters(parameters, as_written))

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """Sensors of the file and those added by `with_sensors`, in the order of their values.

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
    fluid_forces = fluid_functions.fluid_forces
    fluid_force_derivatives = fluid_functions.fluid_force_derivatives
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
    constrained_forward_dynamics_derivatives = constraint_derivatives.constrained_forward_dynamics_derivatives
    constrained_forward_dynamics_pullback = constraint_derivatives.constrained_forward_dynamics_pullback
    constrained_inverse_dynamics_derivatives = constraint_derivatives.constrained_inverse_dynamics_derivatives
    constrained_inverse_dynamics_pullback = constraint_derivatives.constrained_inverse_dynamics_pullback
    contact_impulse_derivatives = constraint_derivatives.contact_impulse_derivatives
    contact_impulse_pullback = constraint_derivatives.contact_impulse_pullback

    # Control, planning and identification.
    inverse_kinematics = control.inverse_kinematics
    operational_space = control.operational_space
    time_optimal = planning.time_optimal
    base_parameters = identification.base_parameters
    identify = identification.identify
    identify_consistent = identification.identify_consistent
    identify_nonlinear = identification.identify_nonlinear
    design_excitation = excitation.design_excitation
    physical_consistency = identification.physical_consistency

    # Checks and proven bounds.
    audit = checks.audit
    suspicions = checks.suspicions
    certify_digits = certified.certify_digits
    certify_mass_matrix = certified.certify_mass_matrix
    certify_reach = certified.certify_reach
    certify_torques = certified.certify_torques

    # Conventions of other libraries.
    to_mujoco = conventions.to_mujoco
    from_mujoco = conventions.from_mujoco
    to_pinocchio = conventions.to_pinocchio
    from_pinocchio = conventions.from_pinocchio

    # Parts added, removed or moved.
    with_frame = edits.with_frame
    with_link = edits.with_link
    with_inertia = edits.with_inertia
    with_mass_scaled = edits.with_mass_scaled
    with_root = edits.with_root
    without_joint = edits.without_joint
    without_equality = edits.without_equality
    with_attached = edits.with_attached
    with_subtree_replaced = edits.with_subtree_replaced
    with_motor = drives.with_motor
    with_elastic_joint = drives.with_elastic_joint

    # Files and generated code.
    to_text = files.to_text
    write = files.write
    generate = files.generate

    def _edited(self, state: str) -> Robot:
        return type(self)("json", state)

    def normalize(self, q: Numbers) -> NDArray[Any]:
        """Configuration with quaternions of unit length.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.

        Returns
        -------
        ndarray, shape (..., nq)
            Normalised configuration.

        Examples
        --------
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
        """Show the robot in a browser, with its visual shapes and meshes.

        Needs meshcat (``pip install robot-dynamics[view]``).

        Links without visual shapes show their collision shapes. Links whose meshes cannot be drawn are shown
        as boxes of the same inertia. So are all links of a robot without shapes.

        Parameters
        ----------
        trajectory : Motion, TimedPath or array_like, shape (n, nq) or (nq,), optional
            Configurations to show; default: the neutral one.
        dt : float, optional
            Time between the configurations of an array [s].
        open_browser : bool
            Whether to open a browser.

        Returns
        -------
        meshcat.Visualizer
            The viewer.

        Raises
        ------
        ImportError
            meshcat is missing.
        ValueError
            The trajectory has the wrong shape, or `dt` is missing.
        """
        from robot_dynamics import viewer

        return viewer.show(self, trajectory, dt=dt, open_browser=open_browser)

    def _repr_html_(self) -> str:
        from robot_dynamics import html

        return html.robot_html(self)

    def __reduce__(self) -> tuple[Callable[[type[Robot], str], Robot], tuple[type[Robot], str]]:
        return _restored, (type(self), self._state())

    def __copy__(self) -> Robot:
        return self

    def __deepcopy__(self, memo: dict[int, object]) -> Robot:
        return self

    def __repr__(self) -> str:
        degrees = "degree" if self.nv == 1 else "degrees"
        return f"<Robot {self.name!r}: {self.nv} {degrees} of freedom, {self.total_mass:.2f} kg>"


def _name_methods(cls: type) -> None:
    """Set the qualified names of bound functions to the class, so error messages, `help` and pickles show it.
    """
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
