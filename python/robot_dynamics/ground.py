"""What a robot stands on."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from robot_dynamics.numbers import Numbers


class Ground(NamedTuple):
    """The half-space below a plane.

    >>> motion = rd.example("quadruped", floating_base=True).simulate(
    ...     [0, 0, 0.5, 0, 0, 0, 1, *[0, 0.7, -1.6] * 4], duration=2.0, dissipation=True, ground=rd.Ground()
    ... )
    >>> bool(abs(motion.v[-1]).max() < 1e-6), round(float(motion.contact_forces[-1].sum(axis=0)[2]), 1)
    (True, 195.2)
    """

    z: float = 0.0
    """Its height, under the world's origin [m]."""
    slope: float = 0.0
    """By how much it rises along x [rad]."""
    friction: float | None = None
    """μ of all contacts; `None`: as the shapes state."""
    restitution: float = 0.0
    """The part of its normal speed with which a body leaves that meets it."""


class HeightField(NamedTuple):
    """Ground with hills: `heights[row, column]` [m] on a grid over a rectangle, rows along y, columns along
    x, upwards both.

    A cell is divided along the diagonal from its corner of least x and y. Outside the rectangle there is
    nothing. Balls, ellipsoids and capsules' ends touch faces, edges and corners; boxes and meshes touch with
    their corners, cylinders with their rims.

    >>> valley = rd.HeightField([[1.0, 0.0, 1.0]] * 2, half_size=(1.0, 1.0))  # along y, 45 degrees on both sides
    >>> ball = rd.loads(
    ...     '''<mujoco><worldbody><body><freejoint/><geom type="sphere" size="0.1"/></body></worldbody></mujoco>'''
    ... )
    >>> motion = ball.simulate([0.03, 0, 0.2, 0, 0, 0, 1], duration=1.0, ground=valley)
    >>> round(float(motion.q[-1, 2]), 4)  # it lies on both
    0.1414
    """

    heights: Numbers
    """(rows, columns)"""
    half_size: tuple[float, float]
    """Half the rectangle's lengths along x and y [m]."""
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of its middle, at height 0, in the world [m]."""
    friction: float | None = None
    """μ of all contacts; `None`: as the shapes state."""
    restitution: float = 0.0
    """The part of its normal speed with which a body leaves that meets it."""


AnyGround: TypeAlias = Ground | HeightField | Literal["file"]
"""A plane, hills, or the height fields that the robot's file has in its world."""


def native(ground: AnyGround | None) -> Any:
    """As the native half takes it."""
    if not isinstance(ground, HeightField):
        return ground
    heights = np.asarray(ground.heights, dtype=np.float64)
    if heights.ndim != 2:
        raise ValueError(f"heights has shape {heights.shape}; a height field has (rows, columns)")
    rows, columns = heights.shape
    surface = (ground.friction, float(ground.restitution))
    return rows, columns, tuple(ground.half_size), heights.ravel().tolist(), tuple(ground.position), surface
