"""Time-optimal motion along a path."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native
from robot_dynamics.motion import configuration_layout
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class TimedPath:
    """Motion along a path, sampled at constant time intervals."""

    duration: float
    """Duration [s]."""
    times: Array = field(repr=False)
    """Sample times (samples,) [s]."""
    q: Array = field(repr=False)
    """Configurations (samples, nq)."""
    v: Array = field(repr=False)
    """Velocities (samples, nv) [rad/s or m/s]."""
    a: Array = field(repr=False)
    """Accelerations (samples, nv) [rad/s² or m/s²]."""
    tau: Array = field(repr=False)
    """Torques of the motors (samples, nv) [N·m or N]; with damping and friction of the joints by default."""
    grid: Array = field(repr=False)
    """Path parameters s at which speeds are computed (points,)."""
    squared_speeds: Array = field(repr=False)
    """(ds/dt)² at the grid points (points,) [1/s²]."""
    saturated: float
    """Fraction of the grid on which a limit is reached."""
    largest_use: float
    """Largest value over its limit, also between grid points: at most about 1.001 with `both_ends`."""
    tightest: tuple[str, str, float]
    """Quantity (``torque``, ``velocity``, ``acceleration``, ``power``), coordinate and s of the largest
    use."""
    coordinates: tuple[str, ...] = field(default=(), repr=False)
    """Names of the coordinates of v."""
    configuration_names: tuple[str, ...] = field(default=(), repr=False)
    """Names of the numbers of q."""

    def plot(self, axes: Any = None) -> Any:
        """Plot velocities and torques over time.

        Needs matplotlib.

        Parameters
        ----------
        axes : sequence of 2 matplotlib axes, optional
            Axes to draw on; default: those of a new figure.

        Returns
        -------
        sequence of matplotlib axes
            One for each of the two plots.

        Raises
        ------
        ImportError
            matplotlib is missing.
        ValueError
            `axes` does not have two entries.
        """
        from robot_dynamics import plots

        return plots.plot_timed_path(self, axes)

    def to_csv(self) -> str:
        """Return the samples as comma-separated values.

        The columns are ``time`` and ``q.NAME``, ``v.NAME``, ``a.NAME``, ``tau.NAME`` for each name.

        Returns
        -------
        str
            One line for each sample, after one with the names.

        Examples
        --------
        >>> path = rd.example("ur5").time_optimal([[0.0] * 6, [0.4] * 6], samples=3)
        >>> path.to_csv().splitlines()[0].split(",")[:2]
        ['time', 'q.shoulder_pan']
        """
        return self._text("csv")

    def to_ros_json(self) -> str:
        """Return the samples as a ROS 2 message ``trajectory_msgs/JointTrajectory`` in JSON.

        Returns
        -------
        str
            Joint names, and positions, velocities, accelerations, efforts and the time of each point.

        Raises
        ------
        PlanningError
            The robot has quaternions, for which the message has no place.

        Examples
        --------
        >>> import json
        >>> path = rd.example("ur5").time_optimal([[0.0] * 6, [0.4] * 6], samples=3)
        >>> json.loads(path.to_ros_json())["points"][0]["time_from_start"]
        {'sec': 0, 'nanosec': 0}
        """
        return self._text("json")

    def to_ros_yaml(self) -> str:
        """Return the samples as a ROS 2 message ``trajectory_msgs/JointTrajectory`` in YAML.

        ``ros2 topic pub`` takes this text.

        Returns
        -------
        str
            Joint names, and positions, velocities, accelerations, efforts and the time of each point.

        Raises
        ------
        PlanningError
            The robot has quaternions, for which the message has no place.

        Examples
        --------
        >>> path = rd.example("ur5").time_optimal([[0.0] * 6, [0.4] * 6], samples=3)
        >>> path.to_ros_yaml().splitlines()[0]
        'header: {stamp: {sec: 0, nanosec: 0}, frame_id: ""}'
        """
        return self._text("yaml")

    def to_arrow(self) -> Any:
        """Return the samples as an Arrow table.

        Needs pyarrow. The columns ``q``, ``v``, ``a`` and ``tau`` are lists of fixed length, as
        `robot_dynamics.arrow` reads them.

        Returns
        -------
        pyarrow.Table
            One row for each sample.

        Raises
        ------
        ImportError
            pyarrow is missing.
        """
        import pyarrow as pa

        columns: dict[str, Any] = {"time": pa.array(self.times)}
        for name, rows in (("q", self.q), ("v", self.v), ("a", self.a), ("tau", self.tau)):
            columns[name] = pa.FixedSizeListArray.from_arrays(pa.array(rows.ravel()), rows.shape[1])
        return pa.table(columns)

    def write(self, path: str | PathLike[str]) -> None:
        """Write the samples to a file; its ending says how.

        ``.csv`` is the text of `to_csv`, ``.parquet`` the table of `to_arrow`. ``.json`` and ``.yaml`` are
        the texts of `to_ros_json` and `to_ros_yaml`.

        Parameters
        ----------
        path : path-like
            File to write.

        Raises
        ------
        ValueError
            The ending of the file is not one of these.
        PlanningError
            The robot has quaternions, and the file is a ROS message.
        ImportError
            The file ends in ``.parquet``, and pyarrow is missing.
        """
        texts = {".csv": self.to_csv, ".json": self.to_ros_json, ".yaml": self.to_ros_yaml, ".yml": self.to_ros_yaml}
        ending = Path(path).suffix.lower()
        if ending == ".parquet":
            table = self.to_arrow()
            import pyarrow.parquet as pq

            pq.write_table(table, path)
        elif ending in texts:
            Path(path).write_text(texts[ending](), encoding="utf-8")
        else:
            raise ValueError(f"{path}: a timed path is written to .csv, .parquet, .json or .yaml")

    def _text(self, format: str) -> str:
        names = (self.configuration_names, self.coordinates)
        return _native._trajectory_text(format, names, self.times, [self.q, self.v, self.a, self.tau])


def time_optimal(
    robot: Robot,
    waypoints: Numbers,
    *,
    torque: Numbers | None = None,
    torque_lower: Numbers | None = None,
    velocity: Numbers | None = None,
    acceleration: Numbers | None = None,
    power: Numbers | None = None,
    lower: Numbers | None = None,
    upper: Numbers | None = None,
    dissipation: bool = True,
    intervals: int | None = None,
    start_speed: float = 0.0,
    end_speed: float = 0.0,
    both_ends: bool = True,
    samples: int = 501,
) -> TimedPath:
    """Fastest motion on the cubic spline through waypoints within the limits.

    Rotations of floating and ball joints follow a spline with a continuous angular acceleration.

    The torques a(s) s̈ + b(s) ṡ² + c(s) = τ are kept within the limits at the ends of each piece of the
    path. Pieces end at every waypoint. A piece is halved if a limit would be exceeded inside it by more than
    1e-3 of its value. All pieces are halved until that changes the duration by less than 0.5 %.

    Parameters
    ----------
    waypoints : array_like, shape (n, nq)
        Configurations on the path.
    torque : array_like, shape (nv,), optional
        Largest τ of the motors [N·m or N]; default: the effort limits of the robot.
    torque_lower : array_like, shape (nv,), optional
        Smallest τ of the motors [N·m or N]; default: −`torque`.
    velocity : array_like, shape (nv,), optional
        Limits of the magnitude of v [rad/s or m/s]; default: those of the robot.
    acceleration : array_like, shape (nv,), optional
        Limits of the magnitude of a [rad/s² or m/s²]; default: none.
    power : array_like, shape (nv,), optional
        Limits of the magnitude of τ v of each coordinate [W]; default: none.
    lower : array_like, shape (nv,), optional
        Lower limits of q [rad or m]; default: those of the robot.
    upper : array_like, shape (nv,), optional
        Upper limits of q [rad or m]; default: those of the robot.
    dissipation : bool
        Whether τ includes damping and friction of the joints.
    intervals : int, optional
        Least number of pieces, instead of those that the change of the duration decides.
    start_speed : float
        ds/dt at the start [1/s].
    end_speed : float
        ds/dt at the end [1/s].
    both_ends : bool
        Whether limits hold at both ends of each piece, or at its start only.
    samples : int
        Number of samples of the result.

    Returns
    -------
    TimedPath
        The sampled motion.

    Raises
    ------
    PlanningError
        A waypoint or the spline is beyond the position limits, a joint cannot hold the robot on the path,
        or rotations turn too far between waypoints.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot = rd.example("ur5")
    >>> path = robot.time_optimal([[0.0] * 6, [0.5, -0.5, 0.5, 0.0, 0.3, 0.0], [1.0, -1.0, 0.2, 0.0, 0.0, 0.0]])
    >>> 0.1 < path.duration < 10.0 and path.saturated > 0.5
    True
    """
    limits = {
        "torque": torque,
        "torque_lower": torque_lower,
        "velocity": velocity,
        "acceleration": acceleration,
        "power": power,
        "lower": lower,
        "upper": upper,
        "dissipation": dissipation,
    }
    record = robot._time_optimal(waypoints, limits, intervals, (start_speed, end_speed), both_ends, samples)
    names, _ = configuration_layout(robot)
    return TimedPath(**record, coordinates=tuple(robot.coordinate_names), configuration_names=names)
