"""Robots derived from another robot by adding, removing or moving parts."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

JointKind: TypeAlias = Literal[
    "fixed", "floating", "spherical", "revolute", "continuous", "prismatic", "helical", "universal", "planar"
]
"""Kind of a joint."""


class EditedRobot(NamedTuple):
    """Robot after an edit that removes or changes other parts."""

    robot: Robot
    """The robot."""
    notes: tuple[str, ...]
    """Every other part that the edit removed or changed, such as an actuator of a removed joint."""


def with_frame(robot: Robot, name: str, parent: str, *, at: Numbers = (0.0, 0.0, 0.0)) -> Robot:
    """Robot with an additional frame.

    Parameters
    ----------
    name : str
        Name of the frame.
    parent : str
        Link or frame to which it is fixed.
    at : array_like, shape (3,) or (4, 4)
        Position [m] or pose of the frame in its parent.

    Returns
    -------
    Robot
        The robot with the frame.

    Raises
    ------
    DescriptionError
        The parent does not exist, or the name is taken.
    ShapeError
        `at` has the wrong shape.

    Examples
    --------
    >>> robot = rd.example("panda").with_frame("camera", "panda_link8", at=(0.0, 0.05, 0.02))
    >>> robot.frame_names[-1]
    'camera'
    """
    return robot._edited(robot._with_frame(name, parent, pose(at)))


def with_link(
    robot: Robot,
    name: str,
    parent: str,
    *,
    at: Numbers = (0.0, 0.0, 0.0),
    joint: JointKind = "fixed",
    axis: Numbers = (0.0, 0.0, 1.0),
    second_axis: Numbers = (0.0, 1.0, 0.0),
    pitch: float = 0.0,
    joint_name: str | None = None,
    limits: tuple[float, float] = (-inf, inf),
    velocity: float = inf,
    effort: float = inf,
    mass: float | None = None,
    center_of_mass: Numbers = (0.0, 0.0, 0.0),
    inertia: Numbers | None = None,
) -> Robot:
    """Robot with an additional link, the child of a new joint.

    Parameters
    ----------
    name : str
        Name of the link.
    parent : str
        Parent link of the joint.
    at : array_like, shape (3,) or (4, 4)
        Position [m] or pose of the joint in the parent link's frame.
    joint : str
        Kind of the joint.
    axis : array_like, shape (3,)
        Axis of the joint, or the normal of a planar joint.
    second_axis : array_like, shape (3,)
        Second axis of a universal joint.
    pitch : float
        Advance of a helical joint [m/rad].
    joint_name : str, optional
        Name of the joint; default: that of the link with ``_joint``.
    limits : tuple of float
        Lower and upper position limit [rad or m].
    velocity : float
        Speed limit [rad/s or m/s].
    effort : float
        Limit of torque or force [N·m or N].
    mass : float, optional
        Mass of the link [kg]; default: no mass.
    center_of_mass : array_like, shape (3,)
        Centre of mass in the link's frame [m].
    inertia : array_like, shape (3, 3), optional
        Inertia about the centre of mass [kg·m²]; default: 0.

    Returns
    -------
    Robot
        The robot with the link.

    Raises
    ------
    DescriptionError
        The parent does not exist, a name is taken, or no rigid body has these mass properties.
    ShapeError
        An array has the wrong shape.
    ValueError
        The kind of the joint does not exist.

    Examples
    --------
    >>> robot = rd.example("two_r").with_link("slider", "fore", joint="prismatic", axis=(1, 0, 0), mass=0.5)
    >>> robot.nv
    3
    """
    words = joint_words(joint, axis, second_axis, pitch)
    lower, upper = limits
    bounds = (float(lower), float(upper), velocity, effort)
    return robot._edited(
        robot._with_link(
            name, parent, pose(at), words, joint_name or f"{name}_joint", bounds, mass, center_of_mass, inertia
        )
    )


def with_inertia(
    robot: Robot,
    link: str,
    mass: float,
    center_of_mass: Numbers = (0.0, 0.0, 0.0),
    inertia: Numbers | None = None,
) -> Robot:
    """Robot with other mass properties of a link.

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
        The robot with this link.

    Raises
    ------
    DescriptionError
        The link does not exist, or no rigid body has these mass properties.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> rd.example("two_r").with_inertia("fore", 3.0, [0.5, 0.0, 0.0]).mass
    5.0
    """
    return robot._edited(robot._with_inertia(link, mass, center_of_mass, inertia))


def with_mass_scaled(robot: Robot, factor: float, link: str | None = None) -> Robot:
    """Robot with masses and inertias multiplied by a factor.

    Parameters
    ----------
    factor : float
        The factor.
    link : str, optional
        Name of the link; default: all links. Rotor inertias of joints stay.

    Returns
    -------
    Robot
        The robot with these masses.

    Raises
    ------
    DescriptionError
        The link does not exist, or the factor is not positive and finite.

    Examples
    --------
    >>> rd.example("two_r").with_mass_scaled(2.0).mass
    6.0
    """
    return robot._edited(robot._with_mass_scaled(factor, link))


def with_root(robot: Robot, link: str) -> EditedRobot:
    """Robot with another link as its root; the joints between the two are reversed.

    A robot that floats keeps its dynamics: q and v of its floating joint are then the pose and velocity of
    the new root, and named poses are converted. A robot on a fixed base is held at the new root.

    A reversed revolute, continuous, prismatic or helical joint has the opposite axis and the same q. The
    angles of a universal joint change places. A planar or spherical joint has the inverse motion.

    Parameters
    ----------
    link : str
        Name of the new root.

    Returns
    -------
    EditedRobot
        The robot, and notes on the parts that changed.

    Raises
    ------
    DescriptionError
        The link does not exist, or a joint has forces that the reversed joint cannot express.

    Examples
    --------
    >>> robot = rd.example("quadruped", floating_base=True)
    >>> q, foot = robot.neutral(), robot.link_names[-1]
    >>> standing = robot.with_root(foot).robot
    >>> standing.joints[0].child_link == foot
    True
    """
    return noted(robot, robot._with_root(link))


def without_joint(robot: Robot, joint: str) -> EditedRobot:
    """Robot without a joint and everything behind it.

    Actuators, sensors, tendons, equalities and contact pairs with a reference to a removed part are removed.
    A mimic joint whose leader is removed moves by itself.

    Parameters
    ----------
    joint : str
        Name of the joint.

    Returns
    -------
    EditedRobot
        The robot, and notes on the other parts that were removed or changed.

    Raises
    ------
    DescriptionError
        The joint does not exist.

    Examples
    --------
    >>> rd.example("two_r").without_joint("elbow")
    EditedRobot(robot=<Robot 'two_r': 1 degree of freedom, 2.00 kg>, notes=())
    """
    return noted(robot, robot._without_joint(joint))


def without_equality(robot: Robot, equality: str) -> EditedRobot:
    """Robot without an equality, for example to cut a loop that it closes.

    Parameters
    ----------
    equality : str
        Name of the equality.

    Returns
    -------
    EditedRobot
        The robot, and notes on the actuators and sensors that were removed with its frames.

    Raises
    ------
    DescriptionError
        The equality does not exist.

    Examples
    --------
    >>> try:
    ...     rd.example("two_r").without_equality("loop")
    ... except rd.DescriptionError as error:
    ...     print(error)
    the robot has no equality `loop`, nor any other equality
    """
    return noted(robot, robot._without_equality(equality))


def with_attached(
    robot: Robot,
    other: Robot,
    *,
    on: str,
    at: Numbers = (0.0, 0.0, 0.0),
    joint: JointKind | None = None,
    axis: Numbers = (0.0, 0.0, 1.0),
    second_axis: Numbers = (0.0, 1.0, 0.0),
    pitch: float = 0.0,
    prefix: str = "",
) -> EditedRobot:
    """Robot with another robot on one of its links or frames, for example a gripper on an arm.

    Parameters
    ----------
    other : Robot
        The other robot.
    on : str
        Link or frame that carries it.
    at : array_like, shape (3,) or (4, 4)
        Position [m] or pose of its root link in the parent's frame, in the neutral configuration.
    joint : str, optional
        Kind of the joint. Default: floating for a robot with a floating base, else fixed.
    axis : array_like, shape (3,)
        Axis of the joint, or the normal of a planar joint, in the frame of the root link.
    second_axis : array_like, shape (3,)
        Second axis of a universal joint.
    pitch : float
        Advance of a helical joint [m/rad].
    prefix : str
        Text before every name of the other robot.

    Returns
    -------
    EditedRobot
        Both robots as one, and notes on what the other robot states about the world.

    Raises
    ------
    DescriptionError
        The parent does not exist, or a name is taken.
    ShapeError
        An array has the wrong shape.
    ValueError
        The kind of the joint does not exist.

    Examples
    --------
    >>> arm = rd.example("panda")
    >>> arm.with_attached(rd.example("two_r"), on="panda_link8", prefix="tool_").robot.nv
    9
    """
    words = None if joint is None else joint_words(joint, axis, second_axis, pitch)
    return noted(robot, robot._with_attached(other, on, pose(at), words, prefix))


def with_subtree_replaced(robot: Robot, joint: str, other: Robot, prefix: str = "") -> EditedRobot:
    """Robot with another robot in place of a joint and everything behind it, for example another gripper.

    The root link of the other robot is fixed to the joint's parent, at the joint's frame.

    Parameters
    ----------
    joint : str
        Name of the joint.
    other : Robot
        The other robot.
    prefix : str
        Text before every name of the other robot.

    Returns
    -------
    EditedRobot
        The robot, and notes on the other parts that were removed or changed.

    Raises
    ------
    DescriptionError
        The joint does not exist, or a name is taken.

    Examples
    --------
    >>> arm = rd.example("panda").with_attached(rd.example("two_r"), on="panda_link8", prefix="old_").robot
    >>> other = arm.with_subtree_replaced("old_shoulder", rd.example("two_r"), "new_").robot
    >>> other.joint_names[-2:]
    ('new_shoulder', 'new_elbow')
    """
    return noted(robot, robot._with_subtree_replaced(joint, other, prefix))


def pose(at: Numbers) -> NDArray[np.float64]:
    """A pose from itself or from a position."""
    numbers = np.asarray(at, dtype=np.float64)
    if numbers.shape != (3,):
        return numbers
    pose = np.eye(4)
    pose[:3, 3] = numbers
    return pose


def joint_words(
    joint: str, axis: Numbers, second_axis: Numbers, pitch: float
) -> tuple[str, list[float], list[float], float]:
    """Kind, axis, second axis and pitch of a joint."""
    return joint, three(axis, "axis"), three(second_axis, "second_axis"), float(pitch)


def three(numbers: Numbers, name: str) -> list[float]:
    """Three numbers."""
    given = np.asarray(numbers, dtype=np.float64)
    if given.shape != (3,):
        from robot_dynamics.errors import ShapeError

        raise ShapeError(f"{name} must have shape (3,), got {given.shape}")
    return [float(x) for x in given]


def noted(robot: Robot, result: tuple[str, list[str]]) -> EditedRobot:
    state, notes = result
    return EditedRobot(robot._edited(state), tuple(notes))
