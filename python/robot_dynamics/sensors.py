"""Sensor values, and the force and moment that each joint transmits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.numbers import Numbers
from robot_dynamics.wrenches import stacked

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


class Sensor(NamedTuple):
    """Sensor of a robot."""

    name: str
    """Name of the sensor."""
    kind: str
    """Name of its kind in MJCF: accelerometer, gyro, force, jointpos, framepos, …"""
    size: int
    """Number of its values."""


class PointForce(NamedTuple):
    """Force on a link at a point of the world, along the world's axes: a contact or a push."""

    link: str
    """Name of the link."""
    point: Numbers
    """Point in the world (3,) [m]."""
    force: Numbers
    """Force on the link (3,) [N]."""
    moment: Numbers = (0.0, 0.0, 0.0)
    """Moment on the link about the point (3,) [N·m]."""
    normal: Numbers = (0.0, 0.0, 0.0)
    """Unit normal of a contact, towards the link (3,), for touch sensors; zero for other forces."""


def _three(numbers: Numbers) -> list[float]:
    return [float(x) for x in np.ravel(np.asarray(numbers, np.float64))]


def sensor_values(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    a: Numbers,
    *,
    time: float = 0.0,
    actuator_forces: Numbers | None = None,
    joint_limit_forces: Numbers | None = None,
    tendon_limit_forces: Numbers | None = None,
    wrenches: Iterable[PointForce] = (),
) -> dict[str, NDArray[np.float64]]:
    """Evaluate all sensors in one state.

    Accelerometers measure p̈ − g. Force and torque sensors measure the load that the link receives from
    its parent. Noise is not added.

    Parameters
    ----------
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,)
        Velocity [rad/s or m/s].
    a : array_like, shape (nv,)
        Acceleration under all forces [rad/s² or m/s²].
    time : float
        Time for sensors of kind ``clock`` [s].
    actuator_forces : array_like, shape (actuators,), optional
        Force of each actuator before its gear [N·m or N]; default: 0.
    joint_limit_forces : array_like, shape (nv,), optional
        Forces of the joints' position limits [N·m or N]; default: 0.
    tendon_limit_forces : array_like, shape (tendons,), optional
        Forces of the tendons' length limits [N]; default: 0.
    wrenches : iterable of PointForce
        All external forces on links: contacts and pushes.

    Returns
    -------
    dict of str to ndarray
        Values of each sensor, by its name.

    Raises
    ------
    DescriptionError
        A sensor is invalid for this robot.
    FrameError
        A link does not exist.
    StateError
        A value is invalid.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot = rd.example("two_r").with_sensors({"imu": ("accelerometer", "tip"), "load": ("force", "tip")})
    >>> q, v = [np.pi / 2, 0.0], [0.0, 0.0]  # upright
    >>> robot.sensor_values(q, v, [0.0, 0.0])["imu"].round(9) + 0.0
    array([9.81, 0.  , 0.  ])
    """
    pushed = [(p.link, _three(p.point), _three(p.force), _three(p.moment), _three(p.normal)) for p in wrenches]
    values = robot._sensor_values(
        q,
        v,
        a,
        time=time,
        actuator_forces=actuator_forces,
        joint_limit_forces=joint_limit_forces,
        tendon_limit_forces=tendon_limit_forces,
        wrenches=pushed,
    )
    shown, at = {}, 0
    for name, _, size in robot._sensors():
        shown[name] = values[at : at + size]
        at += size
    return shown


def joint_reactions(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    a: Numbers,
    wrenches: Mapping[str, Numbers] | Mapping[int, Numbers] | None = None,
    *,
    out: NDArray[Any] | None = None,
    threads: int | None = None,
) -> NDArray[Any]:
    """Force and moment that each joint transmits from its parent link to its child.

    The result includes fixed joints. The loads act on the child, about the origin of its frame and along
    its axes, as a force-torque sensor in the joint measures them.

    Parameters
    ----------
    q : array_like, shape (..., nq)
        Configuration.
    v : array_like, shape (..., nv)
        Velocity [rad/s or m/s].
    a : array_like, shape (..., nv)
        Acceleration [rad/s² or m/s²].
    wrenches : mapping of frame to array_like, shape (..., 6), optional
        Force [N], then moment [N·m], at each frame's origin along its axes; default: none.
    out : ndarray, shape (..., joints, 6), optional
        Array that receives the result.
    threads : int, optional
        Threads for a batch; default: `num_threads()`.

    Returns
    -------
    ndarray, shape (..., joints, 6)
        Force [N], then moment [N·m], in the order of `joints`.

    Raises
    ------
    StateError
        The state is invalid; `BadStatesError` for a batch.
    FrameError
        A frame does not exist.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot, rest = rd.example("two_r"), [0.0, 0.0]
    >>> force = robot.joint_reactions(rest, rest, rest)[0, :3]  # of the first joint, which carries both links
    >>> float(np.linalg.norm(force).round(9))
    29.43
    """
    frames, table = stacked(wrenches or {})
    reactions: NDArray[Any] = robot._with_wrenches("joint_reactions", q, v, a, frames, table, out=out, threads=threads)
    return reactions
