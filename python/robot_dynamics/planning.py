"""The fastest motion along a path."""

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
    """A motion along a path, evenly sampled in time."""

    duration: float
    """[s]"""
    times: Array = field(repr=False)
    """(samples,) [s]"""
    q: Array = field(repr=False)
    """(samples, nq)"""
    v: Array = field(repr=False)
    """(samples, nv)"""
    a: Array = field(repr=False)
    """(samples, nv)"""
    tau: Array = field(repr=False)
    """(samples, nv) [N·m or N]"""
    grid: Array = field(repr=False)
    """s, the place on the path, where speeds were computed."""
    squared_speeds: Array = field(repr=False)
    """(ds/dt)² there [1/s²]."""
    saturated: float
    """The share of the grid where some limit is reached."""
    largest_use: float
    """The largest |τ|/limit or |v|/limit, between the grid's points, too: at most 1.001 or so with
    `both_ends`."""
    coordinates: tuple[str, ...] = field(default=(), repr=False)
    """The names of v's coordinates."""

    def plot(self, axes: Any = None) -> Any:
        """Velocities and torques over time; needs matplotlib. Returns the axes, one for each."""
        from robot_dynamics import plots

        return plots.timed_path(self, axes)


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
    """The fastest motion on the cubic spline through waypoints (n, nq) within limits of torque, velocity
    and position.

    Limits (nv,) of |τ|, |v| and of q, `lower` and `upper`, are the robot's where not given. a(s) s̈ + b(s)
    ṡ² + c(s) = τ is kept within them at the ends of each piece of the path, or at the start of each alone
    (`both_ends=False`). Pieces end at every waypoint, are not longer in s than 1/`intervals`, and are
    halved where a limit would be passed in between by more than 1e-3 of it.

    Raises PlanningError where a waypoint, or the spline between two, is beyond the limits of position, or
    where a joint cannot hold the robot on the path.

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
