"""Inverse kinematics with several tasks: frames, centre of mass, posture, axes, closed loops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native, defaults
from robot_dynamics._native import Constraints
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]

AXES = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True)
class KinematicStep:
    """Velocity of one differential step."""

    velocity: Array
    """Velocity v (nv,) [rad/s, m/s]."""
    q: Array
    """Configuration q ⊕ v Δt after the step (nq,)."""
    errors: Array
    """Distance [m] and angle [rad] of each task before the step (tasks, 2)."""
    distance: float | None
    """Least distance of links within the range of the avoidance [m]."""


@dataclass(frozen=True)
class TaskSolution:
    """Configuration that brings all tasks to their targets."""

    q: Array
    """Configuration (nq,)."""
    errors: Array
    """Distance [m] and angle [rad] of each task (tasks, 2)."""
    iterations: int
    """Number of iterations."""
    restarts: int
    """Number of restarts from random configurations."""


@dataclass(frozen=True)
class TaskSolutions:
    """Configurations for many targets."""

    q: Array
    """Configurations (n, nq); the nearest one where a target was not reached."""
    found: NDArray[np.bool_]
    """Whether each target was reached (n,)."""
    errors: Array
    """Distance [m] and angle [rad] of each task (n, tasks, 2)."""


class TaskKinematics(_native.KinematicTasks):
    """Inverse kinematics of one robot with several tasks.

    A task has an error e(q) with ė = J v. `step` minimises

        ½ Σ w |J Δq + α e|² + ½ (λ + Σ μ w |e|²) |Δq|²,  Δq = v Δt

    within the limits of position, velocity, acceleration and distances of links. `solve` iterates such steps
    from several starts until e = 0. Tasks at a level with a larger number do not change those before them.

    Parameters
    ----------
    robot : Robot
        Robot to move.

    Examples
    --------
    >>> robot = rd.example("panda")
    >>> start = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8])
    >>> tasks = rd.TaskKinematics(robot)
    >>> hand = tasks.add_pose("panda_link8", position=[0.4, 0.2, 0.5])
    >>> rest = tasks.add_posture(start, level=1)
    >>> found = tasks.solve(start)
    >>> robot.frame_pose(found.q, "panda_link8")[:3, 3].round(6)
    array([0.4, 0.2, 0.5])
    """

    _robot: Robot
    _kinds: list[tuple[Any, ...]]

    def __new__(cls, robot: Robot) -> Self:
        """Make the tasks of a robot; see the class."""
        own = super().__new__(cls, robot)
        own._robot, own._kinds = robot, []
        return own

    def _add(self, objective: tuple[Any, ...], weight: float, level: int, gain: float, damping: float) -> int:
        task = self._add_task(objective, (weight, level, gain, damping))
        self._kinds.append(objective)
        return task

    def add_pose(
        self,
        frame: str | int,
        target: Numbers | None = None,
        *,
        position: Numbers | None = None,
        relative_to: str | int | None = None,
        axes: Sequence[str] | None = None,
        weights: Numbers | None = None,
        weight: float = 1.0,
        level: int = 0,
        gain: float = 1.0,
        damping: float = 0.0,
    ) -> int:
        """Add the pose or the position of a frame, in the world or relative to another frame.

        Parameters
        ----------
        frame : str or int
            Name or number of the frame.
        target : array_like, shape (4, 4), optional
            Pose T* = [R* p*; 0 1].
        position : array_like, shape (3,), optional
            Position p* [m] instead of a pose; the orientation is free.
        relative_to : str or int, optional
            Frame to which the target is relative; default: the world.
        axes : sequence of str, optional
            Controlled rows among x, y, z, rx, ry and rz, along the axes of the target; default: all.
        weights : array_like, shape (6,), optional
            Weights of the six rows instead of `axes`; zero leaves a row free.
        weight : float
            Factor of |e|².
        level : int
            Level of the task.
        gain : float
            Share α of the error that one step removes, above 0 and at most 1.
        damping : float
            Levenberg–Marquardt damping μ of the task.

        Returns
        -------
        int
            Number of the task.

        Raises
        ------
        FrameError
            A frame does not exist.
        ShapeError
            An array has the wrong shape, or there is neither a pose nor a position.
        StateError
            The target or a weight is invalid.

        Examples
        --------
        >>> robot = rd.example("panda")
        >>> tasks = rd.TaskKinematics(robot)
        >>> tasks.add_pose("panda_link8", position=[0.4, 0.2, 0.5], axes=["x", "y"])
        0
        """
        pose = np.eye(4)
        chosen = np.ones(6)
        if position is not None:
            pose[:3, 3] = np.asarray(position, dtype=float)
            chosen[3:] = 0.0
        elif target is not None:
            pose = np.asarray(target, dtype=float)
        else:
            raise ValueError("a task of a frame needs a target or a position")
        if axes is not None:
            chosen = chosen * np.array([float(axis in axes) for axis in AXES])
        if weights is not None:
            chosen = np.asarray(weights, dtype=float)
        return self._add(("pose", frame, relative_to, pose, chosen), weight, level, gain, damping)

    def add_center_of_mass(
        self,
        target: Numbers,
        *,
        weights: Numbers = (1.0, 1.0, 1.0),
        weight: float = 1.0,
        level: int = 0,
        gain: float = 1.0,
        damping: float = 0.0,
    ) -> int:
        """Add the centre of mass.

        Parameters
        ----------
        target : array_like, shape (3,)
            Position in the world [m].
        weights : array_like, shape (3,)
            Weights of x, y and z; zero leaves a row free.
        weight, level, gain, damping
            As in `add_pose`.

        Returns
        -------
        int
            Number of the task.

        Raises
        ------
        ShapeError
            An array has the wrong shape.
        StateError
            A number is invalid.

        Examples
        --------
        >>> tasks = rd.TaskKinematics(rd.example("panda"))
        >>> tasks.add_center_of_mass([0.1, 0.0, 0.4], weights=[1.0, 1.0, 0.0])
        0
        """
        return self._add(("center_of_mass", target, weights), weight, level, gain, damping)

    def add_posture(
        self,
        target: Numbers,
        *,
        weight: float = 1.0,
        level: int = 0,
        gain: float = 1.0,
        damping: float = 0.0,
    ) -> int:
        """Add a posture: e = q ⊖ q* of the coordinates with motors.

        Parameters
        ----------
        target : array_like, shape (nq,)
            Configuration q*.
        weight, level, gain, damping
            As in `add_pose`.

        Returns
        -------
        int
            Number of the task.

        Raises
        ------
        StateError
            The configuration or a number is invalid.

        Examples
        --------
        >>> robot = rd.example("panda")
        >>> rd.TaskKinematics(robot).add_posture(robot.neutral(), weight=1e-3)
        0
        """
        return self._add(("posture", target), weight, level, gain, damping)

    def add_look_at(
        self,
        frame: str | int,
        axis: Numbers,
        point: Numbers,
        *,
        weight: float = 1.0,
        level: int = 0,
        gain: float = 1.0,
        damping: float = 0.0,
    ) -> int:
        """Add an axis of a frame that points at a point.

        Parameters
        ----------
        frame : str or int
            Name or number of the frame.
        axis : array_like, shape (3,)
            Unit vector along the frame's axes.
        point : array_like, shape (3,)
            Point in the world [m].
        weight, level, gain, damping
            As in `add_pose`.

        Returns
        -------
        int
            Number of the task.

        Raises
        ------
        FrameError
            The frame does not exist.
        StateError
            The axis is not a unit vector, or a number is invalid.

        Examples
        --------
        >>> tasks = rd.TaskKinematics(rd.example("panda"))
        >>> tasks.add_look_at("panda_link8", [0.0, 0.0, 1.0], [1.0, 0.5, 0.2])
        0
        """
        return self._add(("look_at", frame, axis, point), weight, level, gain, damping)

    def add_constraints(
        self,
        constraints: Constraints,
        *,
        weight: float = 1.0,
        level: int = 0,
        gain: float = 1.0,
        damping: float = 0.0,
    ) -> int:
        """Add closed loops and couplings of joints: e = φ(q).

        Parameters
        ----------
        constraints : Constraints
            Constraints of the same robot; at a level before the others they hold strictly.
        weight, level, gain, damping
            As in `add_pose`.

        Returns
        -------
        int
            Number of the task.

        Raises
        ------
        ConstraintError
            The constraints belong to another robot.

        Examples
        --------
        >>> robot = rd.example("panda")
        >>> gear = robot.constraints({"gear": rd.Coupling({"panda_joint1": 1.0, "panda_joint2": -2.0})})
        >>> tasks = rd.TaskKinematics(robot)
        >>> tasks.add_constraints(gear)
        0
        """
        return self._add(("constraints", constraints), weight, level, gain, damping)

    def set_target(self, task: int, target: Numbers) -> None:
        """Change the target of a task; its weights stay.

        Parameters
        ----------
        task : int
            Number of the task.
        target : array_like
            Pose (4, 4) or position (3,) of a frame, centre of mass (3,), configuration (nq,), or point to
            look at (3,).

        Raises
        ------
        ShapeError
            The array has the wrong shape.
        StateError
            The target is invalid.

        Examples
        --------
        >>> tasks = rd.TaskKinematics(rd.example("panda"))
        >>> hand = tasks.add_pose("panda_link8", position=[0.4, 0.2, 0.5])
        >>> tasks.set_target(hand, [0.4, -0.2, 0.5])
        """
        objective = self._with_target(task, target)
        self._set_objective(task, objective)
        self._kinds[task] = objective

    def _with_target(self, task: int, target: Numbers) -> tuple[Any, ...]:
        objective = self._kinds[task]
        if objective[0] == "pose":
            pose = np.asarray(target, dtype=float)
            if pose.shape == (3,):
                position, pose = pose, np.array(objective[3])
                pose[:3, 3] = position
            return (*objective[:3], pose, objective[4])
        if objective[0] == "look_at":
            return (*objective[:3], target)
        return (objective[0], target, *objective[2:])

    def set_weight(self, task: int, weight: float) -> None:
        """Change the weight of a task; with zero it has no influence.

        Parameters
        ----------
        task : int
            Number of the task.
        weight : float
            Factor of |e|².

        Raises
        ------
        StateError
            The weight is negative or not finite.

        Examples
        --------
        >>> robot = rd.example("panda")
        >>> tasks = rd.TaskKinematics(robot)
        >>> rest = tasks.add_posture(robot.neutral())
        >>> tasks.set_weight(rest, 1e-3)
        """
        self._set_weight(task, weight)

    def set_limits(
        self,
        *,
        lower: Numbers | None = None,
        upper: Numbers | None = None,
        velocity: Numbers | None = None,
        acceleration: Numbers | None = None,
        position_gain: float = 1.0,
    ) -> None:
        """Set the limits; those that are not given are the robot's.

        Parameters
        ----------
        lower, upper : array_like, shape (nv,), optional
            Position limits [rad, m].
        velocity : array_like, shape (nv,), optional
            Largest |v| [rad/s, m/s].
        acceleration : array_like, shape (nv,), optional
            Largest |v̇| [rad/s², m/s²]; default: none.
        position_gain : float
            Share of the distance to a position limit that one step may use.

        Raises
        ------
        ShapeError
            An array has the wrong shape.
        StateError
            A limit is negative, or they are not ordered.

        Examples
        --------
        >>> tasks = rd.TaskKinematics(rd.example("panda"))
        >>> tasks.set_limits(acceleration=np.full(7, 10.0))
        """
        self._set_limits(lower, upper, velocity, acceleration, position_gain)

    def set_damping(self, damping: float) -> None:
        """Set λ of ½ λ |Δq|² in every step; 0 by default.

        Parameters
        ----------
        damping : float
            λ, zero or positive.

        Raises
        ------
        StateError
            The damping is negative or not finite.

        Examples
        --------
        >>> rd.TaskKinematics(rd.example("panda")).set_damping(1e-6)
        """
        self._set_damping(damping)

    def avoid_collisions(
        self, least_distance: float = 0.01, *, distance_range: float | None = None, gain: float = 0.5
    ) -> None:
        """Keep links apart whose collision shapes may touch, as in a simulation.

        Each pair of shapes counts at its nearest points. Between parallel faces these points jump, and pairs
        that no motion can separate stay near; such pairs may come nearer than `least_distance`.

        Parameters
        ----------
        least_distance : float
            Least distance [m].
        distance_range : float, optional
            Distance from which on pairs count [m]; default: 0.1 m more than `least_distance`.
        gain : float
            Share of the distance that one step may use.

        Raises
        ------
        StateError
            A number is invalid.

        Examples
        --------
        >>> rd.TaskKinematics(rd.example("humanoid")).avoid_collisions(0.02)
        """
        reach = least_distance + 0.1 if distance_range is None else distance_range
        self._avoid_collisions(least_distance, reach, gain)

    def step(self, q: Numbers, v: Numbers | None = None, *, dt: float) -> KinematicStep:
        """Compute the velocity of the next Δt.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Configuration.
        v : array_like, shape (nv,), optional
            Last velocity, from which acceleration limits count; default: rest.
        dt : float
            Δt [s].

        Returns
        -------
        KinematicStep
            Velocity, and the configuration after the step.

        Raises
        ------
        InverseKinematicsError
            The limits contradict each other, or a target is invalid.
        StateError
            The state is invalid.

        Examples
        --------
        >>> robot = rd.example("panda")
        >>> q = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8])
        >>> tasks = rd.TaskKinematics(robot)
        >>> hand = tasks.add_pose("panda_link8", position=[0.4, 0.2, 0.5], gain=0.1)
        >>> for _ in range(300):
        ...     q = tasks.step(q, dt=0.01).q
        >>> robot.frame_pose(q, "panda_link8")[:3, 3].round(4)
        array([0.4, 0.2, 0.5])
        """
        found = self._next_step(q, v, dt)
        return KinematicStep(**{**found, "errors": np.reshape(found["errors"], (-1, 2))})

    def solve(
        self,
        start: Numbers | None = None,
        *,
        position_tolerance: float = defaults.POSITION_TOLERANCE,
        angle_tolerance: float = defaults.ANGLE_TOLERANCE,
        max_iterations: int = defaults.MAX_ITERATIONS,
        max_restarts: int = defaults.MAX_RESTARTS,
        seed: int = defaults.SEED,
    ) -> TaskSolution:
        """Find a configuration within the position limits that brings all tasks of the first level to zero.

        Later levels decrease their errors without changing the first one.

        Parameters
        ----------
        start : array_like, shape (nq,), optional
            First configuration; default: the neutral configuration.
        position_tolerance : float
            Largest distance from each target [m].
        angle_tolerance : float
            Largest angle to each target [rad].
        max_iterations : int
            Largest number of iterations of each search.
        max_restarts : int
            Largest number of restarts from random configurations.
        seed : int
            Seed of the random configurations.

        Returns
        -------
        TaskSolution
            Configuration and errors.

        Raises
        ------
        InverseKinematicsError
            No search converges; the message names the tasks and the coordinates at their limits.
        StateError
            `start` is invalid.

        Examples
        --------
        >>> robot = rd.example("panda")
        >>> tasks = rd.TaskKinematics(robot)
        >>> hand = tasks.add_pose("panda_link8", position=[0.4, 0.2, 0.5])
        >>> bool(tasks.solve().errors[hand, 0] < 1e-9)
        True
        """
        first = self._robot.neutral() if start is None else start
        search = (position_tolerance, angle_tolerance, max_iterations, max_restarts, seed)
        found = self._find(first, search)
        return TaskSolution(**{**found, "errors": np.reshape(found["errors"], (-1, 2))})

    def solve_many(
        self,
        task: int,
        targets: Sequence[Numbers] | Array,
        start: Numbers | None = None,
        *,
        threads: int | None = None,
        position_tolerance: float = defaults.POSITION_TOLERANCE,
        angle_tolerance: float = defaults.ANGLE_TOLERANCE,
        max_iterations: int = defaults.MAX_ITERATIONS,
        max_restarts: int = defaults.MAX_RESTARTS,
        seed: int = defaults.SEED,
    ) -> TaskSolutions:
        """Solve for many targets of one task in several threads.

        Parameters
        ----------
        task : int
            Number of the task that has the targets.
        targets : sequence of array_like
            Targets as in `set_target`, n of them.
        start : array_like, shape (nq,) or (n, nq), optional
            First configuration, or one for each target; default: the neutral configuration.
        threads : int, optional
            Number of threads, which does not change the results; default: `num_threads()`.
        position_tolerance, angle_tolerance, max_iterations, max_restarts, seed
            As in `solve`.

        Returns
        -------
        TaskSolutions
            Configurations, and which targets were reached.

        Raises
        ------
        ShapeError
            An array has the wrong shape.
        StateError
            A target or a start is invalid.

        Examples
        --------
        >>> robot = rd.example("panda")
        >>> tasks = rd.TaskKinematics(robot)
        >>> hand = tasks.add_pose("panda_link8", position=[0.4, 0.2, 0.5])
        >>> found = tasks.solve_many(hand, [[0.4, y, 0.5] for y in (-0.2, 0.0, 0.2)])
        >>> found.q.shape, bool(found.found.all())
        ((3, 7), True)
        """
        first = self._robot.neutral() if start is None else np.asarray(start, dtype=float)
        starts = np.atleast_2d(first)
        objectives = [self._with_target(task, target) for target in targets]
        search = (position_tolerance, angle_tolerance, max_iterations, max_restarts, seed)
        all_found = self._find_many(task, objectives, list(starts), search, threads)
        return TaskSolutions(
            q=np.array([found["q"] for _, found in all_found]),
            found=np.array([is_found for is_found, _ in all_found], dtype=bool),
            errors=np.array([found["errors"] for _, found in all_found]).reshape(len(all_found), -1, 2),
        )
