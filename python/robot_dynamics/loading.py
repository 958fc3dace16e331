"""From a file to a robot."""

from __future__ import annotations

import os
import warnings

from robot_dynamics import _native
from robot_dynamics.errors import LoadWarning
from robot_dynamics.robot import Robot


def load(
    path: str | os.PathLike[str],
    *,
    floating_base: bool = False,
    strict: bool = False,
    repair_inertia: bool = False,
) -> Robot:
    """The robot of a file, of any format that the library reads.

    The library takes suspicious values in a file as written, with a `LoadWarning` that says by how much they
    are off. There is one warning for each kind, with the number of places and the first of them. Content
    without a meaning raises a `LoadError` that lists all of it, by line. `robot.report` has every finding.

    - `floating_base` frees the root link: six more degrees of freedom, seven more numbers in q.
    - `strict` refuses what would be a warning.
    - `repair_inertia` moves moments that no rigid body has to the edge of what a body can have.
    """
    robot = Robot(
        "path",
        os.fspath(path),
        floating_base=floating_base,
        strict=strict,
        repair_inertia=repair_inertia,
    )
    _warn(robot, os.fspath(path))
    return robot


def loads(
    text: str,
    *,
    floating_base: bool = False,
    strict: bool = False,
    repair_inertia: bool = False,
) -> Robot:
    """The robot of a file's text; see `load`.

    >>> rd.loads('<robot name="point"><link name="world"/></robot>').nv
    0
    """
    robot = Robot("text", text, floating_base=floating_base, strict=strict, repair_inertia=repair_inertia)
    _warn(robot, "the text")
    return robot


def example(name: str = "panda", *, floating_base: bool = False) -> Robot:
    """A robot that comes with the package: ``two_r``, ``ur5``, ``panda``, ``quadruped`` or ``humanoid``.

    >>> rd.example("panda").nv
    7
    """
    return Robot("text", _native.example_text(name), floating_base=floating_base)


def random_robot(seed: int, *, joints: int = 10, floating_base: bool = False) -> Robot:
    """A robot made up for tests: a tree of joints of all kinds, springs, damping and friction; the same for
    the same seed.

    >>> robot = rd.random_robot(3, joints=5)
    >>> bool(robot.audit()), robot == rd.random_robot(3, joints=5)
    (True, True)
    """
    return Robot("json", _native._random_robot(seed, joints, floating_base))


def _warn(robot: Robot, source: str) -> None:
    for group in robot.report.grouped_warnings:
        # The caller of the function that calls this one.
        warnings.warn(f"{_native._visible(source, False)}: {group}", LoadWarning, stacklevel=3)
