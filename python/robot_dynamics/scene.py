"""Scenes: robots and objects joined to one robot."""

from __future__ import annotations

import json
import warnings
from os import PathLike
from typing import Any, Literal, Self, TypeAlias

import numpy as np

from robot_dynamics import _native
from robot_dynamics.edits import JointKind, joint_words, pose, three
from robot_dynamics.errors import LoadWarning, ShapeError
from robot_dynamics.numbers import Numbers
from robot_dynamics.robot import Robot

MountJoint: TypeAlias = JointKind
"""Kind of the joint between a part and its parent in a scene."""


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
        second_axis: Numbers = (0.0, 1.0, 0.0),
        pitch: float = 0.0,
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
        second_axis : array_like, shape (3,)
            Second axis of a universal joint.
        pitch : float
            Advance of a helical joint [m/rad].
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
        words = None if joint is None else joint_words(joint, axis, second_axis, pitch)
        for note in self._add(robot, on, pose(at), words, prefix):
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
        on: str = "world",
        joint: MountJoint | None = None,
        axis: Numbers = (0.0, 0.0, 1.0),
    ) -> None:
        """Add a box: free with a mass or a density, else fixed to the world.

        Parameters
        ----------
        name : str
            Name of its link and its shape.
        size : array_like, shape (3,)
            Edges along x, y, z [m].
        at : array_like, shape (3,) or (4, 4)
            Position of its centre [m] or its pose in its parent.
        mass : float, optional
            Mass [kg], uniformly distributed.
        density : float, optional
            Density [kg/m³].
        friction : float, optional
            Coefficient of friction.
        on : str
            Link or frame of the scene that carries it. It is fixed there unless `joint` is given.
        joint : str, optional
            Kind of the joint between the parent and the object, for example that of a door.
        axis : array_like, shape (3,)
            Axis of the joint in the object's frame.

        Raises
        ------
        DescriptionError
            The scene already has the name, the parent does not exist, or a number is invalid.
        ShapeError
            An array has the wrong shape.
        ValueError
            Both a mass and a density are given.
        """
        self._add_shape(name, "box", size, at, mass, density, friction, on, joint, axis)

    def add_sphere(
        self,
        name: str,
        radius: float,
        *,
        at: Numbers,
        mass: float | None = None,
        density: float | None = None,
        friction: float | None = None,
        on: str = "world",
        joint: MountJoint | None = None,
        axis: Numbers = (0.0, 0.0, 1.0),
    ) -> None:
        """Add a ball: free with a mass or a density, else fixed to the world.

        Parameters
        ----------
        name : str
            Name of its link and its shape.
        radius : float
            Radius [m].
        at : array_like, shape (3,) or (4, 4)
            Position of its centre [m] or its pose in its parent.
        mass : float, optional
            Mass [kg], uniformly distributed.
        density : float, optional
            Density [kg/m³].
        friction : float, optional
            Coefficient of friction.
        on : str
            Link or frame of the scene that carries it. It is fixed there unless `joint` is given.
        joint : str, optional
            Kind of the joint between the parent and the object, for example that of a door.
        axis : array_like, shape (3,)
            Axis of the joint in the object's frame.

        Raises
        ------
        DescriptionError
            The scene already has the name, the parent does not exist, or a number is invalid.
        ShapeError
            An array has the wrong shape.
        ValueError
            Both a mass and a density are given.
        """
        self._add_shape(name, "sphere", [radius], at, mass, density, friction, on, joint, axis)

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
        on: str = "world",
        joint: MountJoint | None = None,
        axis: Numbers = (0.0, 0.0, 1.0),
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
            Position of its centre [m] or its pose in its parent.
        mass : float, optional
            Mass [kg], uniformly distributed.
        density : float, optional
            Density [kg/m³].
        friction : float, optional
            Coefficient of friction.
        on : str
            Link or frame of the scene that carries it. It is fixed there unless `joint` is given.
        joint : str, optional
            Kind of the joint between the parent and the object, for example that of a door.
        axis : array_like, shape (3,)
            Axis of the joint in the object's frame.

        Raises
        ------
        DescriptionError
            The scene already has the name, the parent does not exist, or a number is invalid.
        ShapeError
            An array has the wrong shape.
        ValueError
            Both a mass and a density are given.
        """
        self._add_shape(name, "cylinder", [radius, length], at, mass, density, friction, on, joint, axis)

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
        on: str = "world",
        joint: MountJoint | None = None,
        axis: Numbers = (0.0, 0.0, 1.0),
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
            Position of its centre [m] or its pose in its parent.
        mass : float, optional
            Mass [kg], uniformly distributed.
        density : float, optional
            Density [kg/m³].
        friction : float, optional
            Coefficient of friction.
        on : str
            Link or frame of the scene that carries it. It is fixed there unless `joint` is given.
        joint : str, optional
            Kind of the joint between the parent and the object, for example that of a door.
        axis : array_like, shape (3,)
            Axis of the joint in the object's frame.

        Raises
        ------
        DescriptionError
            The scene already has the name, the parent does not exist, or a number is invalid.
        ShapeError
            An array has the wrong shape.
        ValueError
            Both a mass and a density are given.
        """
        self._add_shape(name, "capsule", [radius, length], at, mass, density, friction, on, joint, axis)

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

    def add_ground(self, *, friction: float | None = None) -> None:
        """Add the ground: the half-space z < 0 of the world, with the name ``ground``.

        Parameters
        ----------
        friction : float, optional
            Coefficient of friction.

        Raises
        ------
        DescriptionError
            The scene already has the name.
        """
        self._add_shape("ground", "plane", [], (0.0, 0.0, 0.0), friction=friction)

    def add_table(
        self,
        name: str,
        size: Numbers,
        *,
        at: Numbers = (0.0, 0.0, 0.0),
        friction: float | None = None,
        on: str = "world",
    ) -> None:
        """Add a box that stands on a floor, fixed. Its top is at the height ``size[2]`` above `at`.

        Parameters
        ----------
        name : str
            Name of its link and its shape.
        size : array_like, shape (3,)
            Length, width and height [m].
        at : array_like, shape (3,) or (4, 4)
            Position of the middle of its foot [m], or the pose of that point, in its parent.
        friction : float, optional
            Coefficient of friction.
        on : str
            Link or frame of the scene that carries it.

        Raises
        ------
        DescriptionError
            The scene already has the name, or the parent does not exist.
        ShapeError
            An array has the wrong shape.
        """
        self._add_shape(name, "table", three(size, "size"), at, friction=friction, on=on)

    def add_wall(
        self,
        name: str,
        start: Numbers,
        end: Numbers,
        height: float,
        *,
        thickness: float = 0.1,
        at: Numbers = (0.0, 0.0, 0.0),
        friction: float | None = None,
    ) -> None:
        """Add a wall between two points of a floor, fixed to the world.

        Parameters
        ----------
        name : str
            Name of its link and its shape.
        start, end : array_like, shape (2,)
            x and y of its ends [m].
        height : float
            Height [m].
        thickness : float
            Thickness [m].
        at : array_like, shape (3,) or (4, 4)
            Position [m] or pose of the floor in the world.
        friction : float, optional
            Coefficient of friction.

        Raises
        ------
        DescriptionError
            The scene already has the name.
        ShapeError
            An array has the wrong shape.
        """
        ends = np.asarray([start, end], dtype=np.float64)
        if ends.shape != (2, 2):
            raise ShapeError(f"start and end must have shape (2,), got {ends.shape[1:]}")
        self._add_shape(name, "wall", [*ends.ravel(), height, thickness], at, friction=friction)

    def add_mesh(
        self,
        name: str,
        path: str | PathLike[str],
        *,
        at: Numbers,
        scale: float | Numbers = 1.0,
        mass: float | None = None,
        density: float | None = None,
        center_of_mass: Numbers = (0.0, 0.0, 0.0),
        inertia: Numbers | None = None,
        solid: Literal["exact", "hull"] = "exact",
        friction: float | None = None,
        on: str = "world",
        joint: MountJoint | None = None,
        axis: Numbers = (0.0, 0.0, 1.0),
    ) -> None:
        """Add an object whose shape is a mesh: free with a mass or a density, else fixed to the world.

        Its frame is that of the mesh. Its shape in contact is the convex hull of the mesh.

        Parameters
        ----------
        name : str
            Name of its link and its shape.
        path : path
            Mesh file: STL, OBJ or MSH.
        at : array_like, shape (3,) or (4, 4)
            Position [m] or pose of its frame in its parent.
        scale : float or array_like, shape (3,)
            Factors of the coordinates along x, y, z, for example 0.001 for a file in millimetres.
        mass : float, optional
            Mass [kg], uniformly distributed unless `inertia` is given.
        density : float, optional
            Density [kg/m³].
        center_of_mass : array_like, shape (3,)
            Centre of mass [m], if `inertia` is given.
        inertia : array_like, shape (3, 3), optional
            Inertia about the centre of mass [kg·m²].
        solid : {"exact", "hull"}
            The solid over which the mass is distributed: that inside the mesh, which must be closed, or the
            convex hull.
        friction : float, optional
            Coefficient of friction.
        on : str
            Link or frame of the scene that carries it. It is fixed there unless `joint` is given.
        joint : str, optional
            Kind of the joint between the parent and the object.
        axis : array_like, shape (3,)
            Axis of the joint in the object's frame.

        Raises
        ------
        DescriptionError
            The file cannot be read or encloses no volume, the scene already has the name, the parent does not
            exist, or a number is invalid.
        ShapeError
            An array has the wrong shape.
        ValueError
            The mass is given in two ways.
        """
        words = None if joint is None else joint_words(joint, axis, (0.0, 1.0, 0.0), 0.0)
        scales = np.asarray(scale, dtype=np.float64)
        factors = three(np.full(3, scales) if scales.ndim == 0 else scales, "scale")
        self._add_mesh(
            name, path, factors, on, pose(at), words, mass, density, center_of_mass, inertia, solid, friction
        )

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
        mass: float | None = None,
        density: float | None = None,
        friction: float | None = None,
        on: str = "world",
        joint: MountJoint | None = None,
        axis: Numbers = (0.0, 0.0, 1.0),
    ) -> None:
        numbers = np.asarray(lengths, dtype=np.float64).ravel().tolist()
        words = None if joint is None else joint_words(joint, axis, (0.0, 1.0, 0.0), 0.0)
        self._add_object(name, shape, numbers, on, pose(at), words, mass, density, friction)
