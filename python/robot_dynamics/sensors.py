"""The values of a robot's sensors, and the force and moment that each joint transmits."""

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
    """A sensor of a robot."""

    name: str
    kind: str
    """Its name in MJCF: accelerometer, gyro, force, jointpos, framepos, …"""
    size: int
    """How many numbers it gives."""


class PointForce(NamedTuple):
    """A force on a link at a point of the world: a contact or a push, along the world's axes."""

    link: str
    point: Numbers
    """[m]"""
    force: Numbers
    """On the link [N]."""
    moment: Numbers = (0.0, 0.0, 0.0)
    """On the link, beside that of the force [N·m]."""
    normal: Numbers = (0.0, 0.0, 0.0)
    """The contact's unit normal, towards the link; zero for what is not a contact. Touch sensors use it."""


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
    """The values of all sensors in a state, by name: q (nq,), v (nv,), and the acceleration a (nv,) that
    all forces give.

    `actuator_forces` has the force of each actuator before its gear [N·m or N], `joint_limit_forces`
    (nv,) and `tendon_limit_forces` what position limits give; without them these are zero. `wrenches` has
    all that acts on links from outside: contacts, pushes. Accelerometers show p̈ − g; force and torque
    sensors what the link receives from its parent. Noise is not added.

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
    """The force and moment that each joint transmits from its parent link to its child, fixed joints
    included.

    q (..., nq), v (..., nv), a (..., nv) → (..., joints, 6) in the order of `joints`: force [N] then
    moment [N·m] about the origin of the child's frame, along its axes, as a force-torque sensor in the
    joint reads them. They act on the child. `wrenches` has for each frame (..., 6) what acts from
    outside, as in `inverse_dynamics_with_wrenches`.

    >>> robot, rest = rd.example("two_r"), [0.0, 0.0]
    >>> force = robot.joint_reactions(rest, rest, rest)[0, :3]  # of the first joint: it carries all that moves
    >>> float(np.linalg.norm(force).round(9))
    29.43
    """
    frames, table = stacked(wrenches or {})
    reactions: NDArray[Any] = robot._with_wrenches("joint_reactions", q, v, a, frames, table, out=out, threads=threads)
    return reactions
