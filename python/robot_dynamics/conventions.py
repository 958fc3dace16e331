"""States and forces in the conventions of MuJoCo and Pinocchio."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array = NDArray[np.float64]


class RobotState(NamedTuple):
    """A state and forces in this library's convention; `None` for the quantities that were not converted."""

    q: Array
    """Configuration (..., nq)."""
    v: Array | None = None
    """Velocity (..., nv)."""
    a: Array | None = None
    """Acceleration (..., nv)."""
    tau: Array | None = None
    """Generalised forces (..., nv) [N·m or N]."""


class PinocchioState(NamedTuple):
    """A state and forces in Pinocchio's convention; `None` for the quantities that were not converted."""

    q: Array
    """Configuration, as in `pinocchio.neutral(model)`."""
    v: Array | None = None
    """Velocity (..., nv)."""
    a: Array | None = None
    """Acceleration (..., nv)."""
    tau: Array | None = None
    """Generalised forces (..., nv) [N·m or N]."""


class MujocoState(NamedTuple):
    """A state and forces in MuJoCo's convention; `None` for the quantities that were not converted."""

    qpos: Array
    """Configuration (..., nq), `mjData.qpos`."""
    qvel: Array | None = None
    """Velocity (..., nv), `mjData.qvel`."""
    qacc: Array | None = None
    """Acceleration (..., nv), `mjData.qacc`."""
    qfrc: Array | None = None
    """Generalised forces (..., nv), for example `mjData.qfrc_applied` [N·m or N]."""


def to_mujoco(
    robot: Robot,
    q: Numbers,
    v: Numbers | None = None,
    a: Numbers | None = None,
    tau: Numbers | None = None,
) -> MujocoState:
    """Convert states and forces to MuJoCo's convention.

    MuJoCo has quaternions as w x y z and the linear velocity, acceleration and force of a free joint along
    the world's axes; their angular parts stay along the body's axes. Joints have the same order: depth first,
    siblings in the file's order. Mimic joints have no entry.

    Parameters
    ----------
    q : array_like, shape (..., nq)
        Configuration.
    v : array_like, shape (..., nv), optional
        Velocity [rad/s or m/s].
    a : array_like, shape (..., nv), optional
        Acceleration [rad/s² or m/s²]; needs `v`.
    tau : array_like, shape (..., nv), optional
        Generalised forces [N·m or N].

    Returns
    -------
    MujocoState
        `qpos`, `qvel`, `qacc` and `qfrc` with the broadcast leading dimensions.

    Raises
    ------
    ShapeError
        An argument has the wrong shape.
    StateError
        A quaternion does not have unit length.
    ValueError
        `a` is given without `v`.

    Examples
    --------
    >>> robot = rd.example("quadruped", floating_base=True)
    >>> q, v = robot.neutral(), np.zeros(robot.nv)
    >>> q[3:7] = [0.0, 0.0, 0.6, 0.8]
    >>> v[0] = 1.0  # forwards
    >>> qpos, qvel, _, _ = robot.to_mujoco(q, v)
    >>> qpos[3:7], qvel[:3].round(9)
    (array([0.8, 0. , 0. , 0.6]), array([0.28, 0.96, 0.  ]))
    """
    return MujocoState(*_converted(robot, "mujoco", False, {"q": q, "v": v, "a": a, "tau": tau}))


def from_mujoco(
    robot: Robot,
    qpos: Numbers,
    qvel: Numbers | None = None,
    qacc: Numbers | None = None,
    qfrc: Numbers | None = None,
) -> RobotState:
    """Convert MuJoCo's states and forces to this library's convention; the inverse of `to_mujoco`.

    Parameters
    ----------
    qpos : array_like, shape (..., nq)
        Configuration.
    qvel : array_like, shape (..., nv), optional
        Velocity [rad/s or m/s].
    qacc : array_like, shape (..., nv), optional
        Acceleration [rad/s² or m/s²]; needs `qvel`.
    qfrc : array_like, shape (..., nv), optional
        Generalised forces [N·m or N].

    Returns
    -------
    RobotState
        `q`, `v`, `a` and `tau` with the broadcast leading dimensions.

    Raises
    ------
    ShapeError
        An argument has the wrong shape.
    StateError
        A quaternion does not have unit length.
    ValueError
        `qacc` is given without `qvel`.

    Examples
    --------
    >>> robot = rd.example("quadruped", floating_base=True)
    >>> qpos = np.zeros(robot.nq)
    >>> qpos[3] = 1.0  # MuJoCo's w
    >>> robot.from_mujoco(qpos).q[:7]
    array([0., 0., 0., 0., 0., 0., 1.])
    """
    given = {"qpos": qpos, "qvel": qvel, "qacc": qacc, "qfrc": qfrc}
    return RobotState(*_converted(robot, "mujoco", True, given))


def to_pinocchio(
    robot: Robot,
    q: Numbers,
    v: Numbers | None = None,
    a: Numbers | None = None,
    tau: Numbers | None = None,
) -> PinocchioState:
    """Convert states and forces to the layout of Pinocchio's model of the same URDF file.

    Pinocchio sorts siblings by the name of their joint. Its q has cos θ and sin θ for the angle of a
    continuous or planar joint. The velocity of a planar joint is along the axes of its link. Free joints are
    the same: x y z w, velocity along the body's axes. Mimic joints have no entry: load the file with
    Pinocchio's ``mimic=True``.

    Parameters
    ----------
    q : array_like, shape (..., nq)
        Configuration.
    v : array_like, shape (..., nv), optional
        Velocity [rad/s or m/s].
    a : array_like, shape (..., nv), optional
        Acceleration [rad/s² or m/s²]; needs `v`.
    tau : array_like, shape (..., nv), optional
        Generalised forces [N·m or N].

    Returns
    -------
    PinocchioState
        `q`, `v`, `a` and `tau` with the broadcast leading dimensions.

    Raises
    ------
    ShapeError
        An argument has the wrong shape.
    StateError
        A quaternion does not have unit length.
    ValueError
        `a` is given without `v`.

    Examples
    --------
    >>> robot = rd.example("quadruped", floating_base=True)
    >>> q = np.tile(robot.neutral(), (1000, 1))
    >>> robot.to_pinocchio(q, np.zeros((1000, robot.nv))).v.shape
    (1000, 18)
    """
    return PinocchioState(*_converted(robot, "pinocchio", False, {"q": q, "v": v, "a": a, "tau": tau}))


def from_pinocchio(
    robot: Robot,
    q: Numbers,
    v: Numbers | None = None,
    a: Numbers | None = None,
    tau: Numbers | None = None,
) -> RobotState:
    """Convert Pinocchio's states and forces to this library's layout; the inverse of `to_pinocchio`.

    The angles of continuous and planar joints are from −π to π.

    Parameters
    ----------
    q : array_like
        Configuration, as long as Pinocchio's.
    v : array_like, shape (..., nv), optional
        Velocity [rad/s or m/s].
    a : array_like, shape (..., nv), optional
        Acceleration [rad/s² or m/s²]; needs `v`.
    tau : array_like, shape (..., nv), optional
        Generalised forces [N·m or N].

    Returns
    -------
    RobotState
        `q`, `v`, `a` and `tau` with the broadcast leading dimensions.

    Raises
    ------
    ShapeError
        An argument has the wrong shape.
    StateError
        A quaternion does not have unit length.
    ValueError
        `a` is given without `v`.

    Examples
    --------
    >>> robot = rd.example("quadruped", floating_base=True)
    >>> q = robot.random_configuration(100, seed=1)
    >>> bool(np.allclose(robot.from_pinocchio(robot.to_pinocchio(q).q).q, q))
    True
    """
    return RobotState(*_converted(robot, "pinocchio", True, {"q": q, "v": v, "a": a, "tau": tau}))


def _converted(robot: Robot, convention: str, back: bool, given: dict[str, Numbers | None]) -> list[Any]:
    """The converted arrays, with the broadcast leading dimensions of those given."""
    names = list(given)
    arrays = [None if value is None else np.asarray(value) for value in given.values()]
    if arrays[2] is not None and arrays[1] is None:
        raise ValueError(f"{names[2]} needs {names[1]}: the conversion of accelerations depends on velocities")
    shapes = [array.shape for array in arrays if array is not None]
    lead = np.broadcast_shapes(*(shape[:-1] for shape in shapes))
    rows = [
        None if array is None else np.broadcast_to(array, (*lead, *array.shape[-1:])).reshape(-1, *array.shape[-1:])
        for array in arrays
    ]
    results = robot._convert(convention, back, names, rows)
    return [None if result is None else result.reshape(*lead, result.shape[-1]) for result in results]
