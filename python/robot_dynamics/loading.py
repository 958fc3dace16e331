"""Loading of robots."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence

from robot_dynamics import _native, defaults
from robot_dynamics.errors import LoadWarning
from robot_dynamics.robot import Robot


def load(
    path: str | os.PathLike[str],
    *,
    floating_base: bool = False,
    strict: bool = False,
    repair_inertia: bool = False,
    package_path: Sequence[str | os.PathLike[str]] = (),
    confined: bool = False,
    srdf: str | os.PathLike[str] | None = None,
) -> Robot:
    """Load a robot from a file of any format that the library reads.

    URDF opens no other file. SDF opens the models that it includes, USD the layers that it references, and a
    scene the files of its robots and meshes. MJCF opens included and attached files, and the meshes from
    which the inertia of a body comes. They may be anywhere on the disk, unless `confined` is set.

    Suspicious values are taken as written. Each kind of them raises one `LoadWarning` with the error, the
    number of places and the first place. `Robot.report` has every finding.

    Parameters
    ----------
    path : path
        File of the robot.
    floating_base : bool
        Whether the root link is free: six more degrees of freedom, seven more numbers in q.
    strict : bool
        Whether a warning is an error.
    repair_inertia : bool
        Whether to move inertias that no rigid body has to the boundary of those that one can have.
    package_path : sequence of path
        Folders that are searched for `package://NAME/…`, before those of `ROS_PACKAGE_PATH` and
        `AMENT_PREFIX_PATH`: packages, or folders that contain packages.
    confined : bool
        Whether the other files that the file names must be in its folder, for files that are not trusted.
    srdf : path, optional
        SRDF file of the robot: groups, poses, passive joints, the joint to the world, and pairs of links that
        never touch. Without it no SRDF file is read, not even one beside the robot's file.

    Returns
    -------
    Robot
        The robot.

    Raises
    ------
    LoadError
        The file is invalid. The message lists all errors by line.

    Warns
    -----
    LoadWarning
        A value is suspicious, or the model leaves out physics that the file states.
    """
    robot = Robot(
        "path",
        os.fspath(path),
        floating_base=floating_base,
        strict=strict,
        repair_inertia=repair_inertia,
        package_path=_folders(package_path),
        confined=confined,
        srdf=None if srdf is None else os.fspath(srdf),
    )
    _warn(robot, os.fspath(path))
    return robot


def loads(
    text: str,
    *,
    floating_base: bool = False,
    strict: bool = False,
    repair_inertia: bool = False,
    package_path: Sequence[str | os.PathLike[str]] = (),
    assets: Mapping[str, bytes | str] | None = None,
    srdf: str | None = None,
) -> Robot:
    """Load a robot from the text of a file; see `load`.

    Parameters
    ----------
    text : str
        Content of the file.
    floating_base : bool
        Whether the root link is free: six more degrees of freedom, seven more numbers in q.
    strict : bool
        Whether a warning is an error.
    repair_inertia : bool
        Whether to move inertias that no rigid body has to the boundary of those that one can have.
    package_path : sequence of path
        Folders that are searched for `package://NAME/…`: packages, or folders that contain packages. Without
        them the meshes of a text are not located.
    assets : mapping from str to bytes or str, optional
        Contents of the files that an MJCF or SDF text names, by their relative paths: included files,
        attached models and meshes. No file on the disk is read then.
    srdf : str, optional
        Content of the SRDF file of the robot; see `load`.

    Returns
    -------
    Robot
        The robot.

    Raises
    ------
    LoadError
        The text is invalid. The message lists all errors by line.
    ValueError
        A path of `assets` is absolute, or begins with ``..``.

    Warns
    -----
    LoadWarning
        A value is suspicious, or the model leaves out physics that the text states.

    Examples
    --------
    >>> rd.loads('<robot name="point"><link name="world"/></robot>').nv
    0
    >>> ball = '<mujoco><worldbody><body><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'
    >>> rd.loads('<mujoco><include file="ball.xml"/></mujoco>', assets={"ball.xml": ball}).nv
    6
    """
    contents = None
    if assets is not None:
        contents = [
            (path, content.encode() if isinstance(content, str) else bytes(content))
            for path, content in assets.items()
        ]
    robot = Robot(
        "text",
        text,
        floating_base=floating_base,
        strict=strict,
        repair_inertia=repair_inertia,
        package_path=_folders(package_path),
        assets=contents,
        srdf=srdf,
    )
    _warn(robot, "the text")
    return robot


def example(name: str = "panda", *, floating_base: bool = False) -> Robot:
    """Load a robot that comes with the package.

    Parameters
    ----------
    name : {"two_r", "ur5", "panda", "quadruped", "humanoid", "gripper_and_box"}
        Name of the robot.
    floating_base : bool
        Whether the root link is free: six more degrees of freedom, seven more numbers in q.

    Returns
    -------
    Robot
        The robot.

    Raises
    ------
    ValueError
        The name does not exist.

    Examples
    --------
    >>> rd.example("panda").nv
    7
    """
    return Robot("text", _native.example_text(name), floating_base=floating_base)


def random_robot(seed: int, *, joints: int = defaults.RANDOM_JOINTS, floating_base: bool = False) -> Robot:
    """Generate a random robot for tests: a tree of joints of all kinds with springs, damping and friction.

    Parameters
    ----------
    seed : int
        Seed; equal arguments give equal robots.
    joints : int
        Number of joints.
    floating_base : bool
        Whether the root link is free: six more degrees of freedom, seven more numbers in q.

    Returns
    -------
    Robot
        The robot.

    Raises
    ------
    DescriptionError
        The description is invalid.

    Examples
    --------
    >>> robot = rd.random_robot(3, joints=5)
    >>> bool(robot.audit()), robot == rd.random_robot(3, joints=5)
    (True, True)
    """
    return Robot("json", _native._random_robot(seed, joints, floating_base))


def _folders(package_path: Sequence[str | os.PathLike[str]]) -> list[str]:
    if isinstance(package_path, str | os.PathLike):
        package_path = [package_path]
    return [os.fspath(folder) for folder in package_path]


def _warn(robot: Robot, source: str) -> None:
    for group in robot.report.grouped_warnings:
        # The warning points at the caller of `load` or `loads`.
        warnings.warn(f"{_native._visible(source, False)}: {group}", LoadWarning, stacklevel=3)
