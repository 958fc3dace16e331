"""Time-optimal motion along a path."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

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
    """Torques (samples, nv) [N·m or N]."""
    grid: Array = field(repr=False)
    """Path parameters s at which speeds are computed (points,)."""
    squared_speeds: Array = field(repr=False)
    """(ds/dt)² at the grid points (points,) [1/s²]."""
    saturated: float
    """Fraction of the grid on which a limit is reached."""
    largest_use: float
    """Largest |τ| or |v| over its limit, also between grid points: at most about 1.001 with `both_ends`."""
    coordinates: tuple[str, ...] = field(default=(), repr=False)
    """Names of the coordinates of v."""

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


def time_optimal(
    robot: Robot,
    waypoints: Numbers,
    *,
    torque: Numbers | None = None,
    velocity: Numbers | None = None,
    lower: Numbers | None = None,
    upper: Numbers | None = None,
    intervals: int = 500,
    start_speed: float = 0.0,
    end_speed: float = 0.0,
    both_ends: bool = True,
    samples: int = 501,
) -> TimedPath:
    """Fastest motion on the cubic spline through waypoints within the limits.

    The torques a(s) s̈ + b(s) ṡ² + c(s) = τ are kept within the limits at the ends of each piece of the
    path. Pieces end at every waypoint and are at most 1/`intervals` long in s. A piece is halved if a
    limit would be exceeded inside it by more than 1e-3 of its value.

    Parameters
    ----------
    waypoints : array_like, shape (n, nq)
        Configurations on the path.
    torque : array_like, shape (nv,), optional
        Limits of the magnitude of τ [N·m or N]; default: those of the robot.
    velocity : array_like, shape (nv,), optional
        Limits of the magnitude of v [rad/s or m/s]; default: those of the robot.
    lower : array_like, shape (nv,), optional
        Lower limits of q [rad or m]; default: those of the robot.
    upper : array_like, shape (nv,), optional
        Upper limits of q [rad or m]; default: those of the robot.
    intervals : int
        Number of pieces, at least.
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
        or the robot has quaternions.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot = rd.example("ur5")
    >>> path = robot.time_optimal([[0.0] * 6, [0.5, -0.5, 0.5, 0.0, 0.3, 0.0], [1.0, -1.0, 0.2, 0.0, 0.0, 0.0]])
    >>> 0.1 < path.duration < 10.0 and path.saturated > 0.5
    True
    """
    record = robot._time_optimal(
        waypoints,
        torque=torque,
        velocity=velocity,
        lower=lower,
        upper=upper,
        intervals=intervals,
        start_speed=start_speed,
        end_speed=end_speed,
        both_ends=both_ends,
        samples=samples,
    )
    return TimedPath(**record, coordinates=tuple(robot.coordinate_names))
