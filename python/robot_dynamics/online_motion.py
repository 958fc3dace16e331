"""Jerk-limited motion from any state to a target, computed again in each period."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]


class OnlineMotion(_native.JerkLimitedMotion):
    """Motion that follows targets at a control rate.

    Each coordinate takes the fastest motion within its limits of velocity, acceleration and jerk, and all
    reach the target at the same time. The motion starts at rest at q = 0.

    Parameters
    ----------
    robot : Robot
        Robot without quaternions.
    period : float
        Duration of a step [s].
    acceleration : array_like, shape (nv,)
        Limits of the magnitude of a [rad/s² or m/s²].
    jerk : array_like, shape (nv,)
        Limits of the magnitude of the rate of a [rad/s³ or m/s³].
    velocity : array_like, shape (nv,), optional
        Limits of the magnitude of v [rad/s or m/s]; default: those of the robot.
    lower : array_like, shape (nv,), optional
        Lower limits of q [rad or m]; default: those of the robot.
    upper : array_like, shape (nv,), optional
        Upper limits of q [rad or m]; default: those of the robot.

    Raises
    ------
    PlanningError
        A limit or the period is not positive, or the robot has quaternions.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot = rd.example("ur5")
    >>> motion = rd.OnlineMotion(robot, 0.002, acceleration=[5.0] * 6, jerk=[50.0] * 6)
    >>> motion.set_state([0.0] * 6, v=[0.2] * 6)
    >>> motion.set_target([1.0, -0.5, 0.3, 0.0, 0.0, 0.0])
    >>> while not motion.step():
    ...     command = motion.q
    >>> motion.q.round(6) + 0.0
    array([ 1. , -0.5,  0.3,  0. ,  0. ,  0. ])
    """

    def __new__(
        cls,
        robot: Robot,
        period: float,
        *,
        acceleration: Numbers,
        jerk: Numbers,
        velocity: Numbers | None = None,
        lower: Numbers | None = None,
        upper: Numbers | None = None,
    ) -> Self:
        """Make a motion of a robot; see the class."""
        return super().__new__(cls, robot, period, acceleration, jerk, velocity, lower, upper)

    def set_state(self, q: Numbers, v: Numbers | None = None, a: Numbers | None = None) -> None:
        """Set the state from which the next step starts.

        It may exceed the limits of velocity and acceleration; the motion then returns within them first.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Configuration.
        v : array_like, shape (nv,), optional
            Velocity; default: rest.
        a : array_like, shape (nv,), optional
            Acceleration; default: zero.

        Raises
        ------
        StateError
            A number is not finite.
        ShapeError
            An array has the wrong shape.
        """
        self._put_state(q, v, a)

    def set_target(self, q: Numbers, v: Numbers | None = None, a: Numbers | None = None) -> None:
        """Set the target; the motion to it starts with the next step.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Configuration of the target.
        v : array_like, shape (nv,), optional
            Velocity at the target; default: rest.
        a : array_like, shape (nv,), optional
            Acceleration at the target; default: zero.

        Raises
        ------
        PlanningError
            The target is beyond a limit, or every motion to it passes one.
        ShapeError
            An array has the wrong shape.
        """
        self._put_target(q, v, a)

    def follow_target(self, q: Numbers, v: Numbers | None = None, a: Numbers | None = None) -> None:
        """Set a target that moves on with this v and a; the motion meets it and then stays on it.

        For a target that is measured in each period, call this before each step.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Configuration of the target now.
        v : array_like, shape (nv,), optional
            Velocity of the target now; default: rest.
        a : array_like, shape (nv,), optional
            Acceleration of the target; default: zero.

        Raises
        ------
        PlanningError
            The target passes a limit before it can be met.
        ShapeError
            An array has the wrong shape.
        """
        self._follow_target(q, v, a)

    def plan(self) -> float:
        """Compute the motion to the target, if it is not computed yet.

        Returns
        -------
        float
            Remaining duration [s].

        Raises
        ------
        PlanningError
            No motion within the limits of position leads to the target.
        """
        return self._remaining()

    def step(self) -> bool:
        """Move the state by one period.

        Returns
        -------
        bool
            Whether the state has reached the target. After it the motion continues with the target's
            acceleration.

        Raises
        ------
        PlanningError
            No motion within the limits of position leads to the target.
        """
        return self._take_step()

    @property
    def q(self) -> Array:
        """Configuration (nq,)."""
        return self._state_row(0)

    @property
    def v(self) -> Array:
        """Velocity (nv,) [rad/s or m/s]."""
        return self._state_row(1)

    @property
    def a(self) -> Array:
        """Acceleration (nv,) [rad/s² or m/s²]."""
        return self._state_row(2)

    @property
    def jerk(self) -> Array:
        """Jerk (nv,) [rad/s³ or m/s³]."""
        return self._state_row(3)
