"""Scenes: robots and objects joined to one robot."""

from __future__ import annotations

import json
import warnings
from typing import Any, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native
from robot_dynamics.errors import LoadWarning
from robot_dynamics.numbers import Numbers
from robot_dynamics.robot import Robot

MountJoint: TypeAlias = Literal["fixed", "floating", "spherical", "revolute", "continuous", "prismatic", "planar"]
"""Kind of the joint between a robot and its parent in a scene."""


class Scene(_native.Scene):
    """Robots and objects in one world.

    Each part keeps its links, joints, shapes, actuators, sensors and named poses, with a prefix on its names.
    `robot` makes one robot of the scene, for every function of the package.

    Parameters
    ----------
    name : str
        Name of the scene.
    gravity : array_like, shape (3,)
        Gravitational acceleration in the world [m/s²].

    Examples
    --------
    >>> scene = rd.Scene("table")
    >>> scene.add(rd.example("panda"), at=(0.0, 0.0, 0.4))
    >>> scene.add_box("table", (1.0, 0.6, 0.4), at=(0.7, 0.0, 0.2))
    >>> scene.add_box("cube", (0.05, 0.05, 0.05), at=(0.5, 0.1, 0.425), density=500.0)
    >>> scene.robot().nv
    13
    """

    def __new__(cls, name: str = "scene", gravity: Numbers = (0.0, 0.0, -9.81)) -> Self:
        return super().__new__(cls, name, gravity)

    def add(
        self,
        robot: Robot,
        *,
        at: Numbers = (0.0, 0.0, 0.0),
        on: str = "world",
        joint: MountJoint | None = None,
        axis: Numbers = (0.0, 0.0, 1.0),
        prefix: str = "",
    ) -> None:
        """Add a robot, on the world or on a link or frame of the scene.

        Parameters
        ----------
        robot : Robot
            The robot.
        at : array_like, shape (3,) or (4, 4)
            Position [m] or pose of the robot's root link in the parent's frame, in the neutral configuration.
        on : str
            Name of the parent: a link or frame of the scene, with its prefix.
        joint : str, optional
            Kind of the joint between the parent and the robot. Default: floating for a robot with a floating
            base, else fixed.
        axis : array_like, shape (3,)
            Axis of the joint, or the normal of a planar joint, in the frame of the root link.
        prefix : str
            Text before every name of the robot.

        Raises
        ------
        DescriptionError
            The parent does not exist, or the scene already has a name of the robot.
        ShapeError
            An array has the wrong shape.
        ValueError
            The kind of the joint does not exist.

        Warns
        -----
        LoadWarning
            The robot states another gravity or step than the scene.
        """
        for note in self._add(robot, on, _pose(at), joint, axis, prefix):
            warnings.warn(note, LoadWarning, stacklevel=2)

    def add_box(
        self,
        name: str,
        size: Numbers,
        *,
        at: Numbers,
        mass: float | None = None,
        density: float | None = None,
        friction: float | None = None,
    ) -> None:
        """Add a box: free with a mass or a density, else fixed to the world.

        Parameters
        ----------
        name : str
            Name of its link and its shape.
        size : array_like, shape (3,)
            Edges along x, y, z [m].
        at : array_like, shape (3,) or (4, 4)
            Position of its centre [m] or its pose in the world.
        mass : float, optional
            Mass [kg], uniformly distributed.
        density : float, optional
            Density [kg/m³].
        friction : float, optional
            Coefficient of friction.

        Raises
        ------
        DescriptionError
            The scene already has the name, or a number is invalid.
        ShapeError
            An array has the wrong shape.
        ValueError
            Both a mass and a density are given.
        """
        self._add_shape(name, "box", size, at, mass, density, friction)

    def add_sphere(
        self,
        name: str,
        radius: float,
        *,
        at: Numbers,
        mass: float | None = None,
        density: float | None = None,
        friction: float | None = None,
    ) -> None:
        """Add a ball: free with a mass or a density, else fixed to the world.

        Parameters
        ----------
        name : str
            Name of its link and its shape.
        radius : float
            Radius [m].
        at : array_like, shape (3,) or (4, 4)
            Position of its centre [m] or its pose in the world.
        mass : float, optional
            Mass [kg], uniformly distributed.
        density : float, optional
            Density [kg/m³].
        friction : float, optional
            Coefficient of friction.

        Raises
        ------
        DescriptionError
            The scene already has the name, or a number is invalid.
        ShapeError
            An array has the wrong shape.
        ValueError
            Both a mass and a density are given.
        """
        self._add_shape(name, "sphere", [radius], at, mass, density, friction)

    def add_cylinder(
        self,
        name: str,
        radius: float,
        length: float,
        *,
        at: Numbers,
        mass: float | None = None,
        density: float | None = None,
        friction: float | None = None,
    ) -> None:
        """Add a cylinder about z: free with a mass or a density, else fixed to the world.

        Parameters
        ----------
        name : str
            Name of its link and its shape.
        radius : float
            Radius [m].
        length : float
            Length along z [m].
        at : array_like, shape (3,) or (4, 4)
            Position of its centre [m] or its pose in the world.
        mass : float, optional
            Mass [kg], uniformly distributed.
        density : float, optional
            Density [kg/m³].
        friction : float, optional
            Coefficient of friction.

        Raises
        ------
        DescriptionError
            The scene already has the name, or a number is invalid.
        ShapeError
            An array has the wrong shape.
        ValueError
            Both a mass and a density are given.
        """
        self._add_shape(name, "cylinder", [radius, length], at, mass, density, friction)

    def add_capsule(
        self,
        name: str,
        radius: float,
        length: float,
        *,
        at: Numbers,
        mass: float | None = None,
        density: float | None = None,
        friction: float | None = None,
    ) -> None:
        """Add a cylinder about z with half balls on its ends: free with a mass or a density, else fixed.

        Parameters
        ----------
        name : str
            Name of its link and its shape.
        radius : float
            Radius [m].
        length : float
            Length of the cylinder between the half balls [m].
        at : array_like, shape (3,) or (4, 4)
            Position of its centre [m] or its pose in the world.
        mass : float, optional
            Mass [kg], uniformly distributed.
        density : float, optional
            Density [kg/m³].
        friction : float, optional
            Coefficient of friction.

        Raises
        ------
        DescriptionError
            The scene already has the name, or a number is invalid.
        ShapeError
            An array has the wrong shape.
        ValueError
            Both a mass and a density are given.
        """
        self._add_shape(name, "capsule", [radius, length], at, mass, density, friction)

    def add_plane(self, name: str, *, at: Numbers = (0.0, 0.0, 0.0), friction: float | None = None) -> None:
        """Add the half-space below a plane, z < 0 in its own frame, fixed to the world.

        Parameters
        ----------
        name : str
            Name of its link and its shape.
        at : array_like, shape (3,) or (4, 4)
            A point of the plane [m], or the pose of its frame in the world.
        friction : float, optional
            Coefficient of friction.

        Raises
        ------
        DescriptionError
            The scene already has the name.
        ShapeError
            An array has the wrong shape.
        """
        self._add_shape(name, "plane", [], at, None, None, friction)

    def robot(self) -> Robot:
        """Make one robot of the scene as it is now.

        Returns
        -------
        Robot
            The robot, with the root link `world`.

        Raises
        ------
        LoadError
            The scene is invalid.
        """
        description: dict[str, Any] = json.loads(self._description())
        return Robot.from_description(description)

    def _add_shape(
        self,
        name: str,
        shape: str,
        lengths: Numbers,
        at: Numbers,
        mass: float | None,
        density: float | None,
        friction: float | None,
    ) -> None:
        numbers = np.asarray(lengths, dtype=np.float64)
        self._add_object(name, shape, numbers.ravel().tolist(), _pose(at), mass, density, friction)


def _pose(at: Numbers) -> NDArray[np.float64]:
    """A pose from itself or from a position."""
    numbers = np.asarray(at, dtype=np.float64)
    if numbers.shape != (3,):
        return numbers
    pose = np.eye(4)
    pose[:3, 3] = numbers
    return pose
