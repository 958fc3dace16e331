"""Ground of simulations: planes and height fields."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from robot_dynamics.numbers import Numbers


class Ground(NamedTuple):
    """Half-space below a plane.

    >>> motion = rd.example("quadruped", floating_base=True).simulate(
    ...     [0, 0, 0.5, 0, 0, 0, 1, *[0, 0.7, -1.6] * 4], duration=2.0, dissipation=True, ground=rd.Ground()
    ... )
    >>> bool(abs(motion.v[-1]).max() < 1e-6), round(float(motion.contact_forces[-1].sum(axis=0)[2]), 1)
    (True, 195.2)
    """

    z: float = 0.0
    """Height of the plane at the world's origin [m]."""
    slope: float = 0.0
    """Angle by which the plane rises along x [rad]."""
    friction: float | None = None
    """Friction coefficient μ of all contacts; `None` for the values of the shapes."""
    restitution: float = 0.0
    """Fraction of its normal speed with which a body rebounds."""


class HeightField(NamedTuple):
    """Ground with hills: `heights[row, column]` on a regular grid over a rectangle.

    Rows run along y and columns along x, both in ascending order. Each cell is divided along the diagonal
    from its corner of least x and y. There is no ground outside the rectangle.

    Spheres, ellipsoids and the ends of capsules touch faces, edges and corners. Boxes and meshes touch with
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
    """Heights (rows, columns) [m]."""
    half_size: tuple[float, float]
    """Half the lengths of the rectangle along x and y [m]."""
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Position in the world of the rectangle's centre at height 0 [m]."""
    friction: float | None = None
    """Friction coefficient μ of all contacts; `None` for the values of the shapes."""
    restitution: float = 0.0
    """Fraction of its normal speed with which a body rebounds."""


AnyGround: TypeAlias = Ground | HeightField | Literal["file"]
"""A plane, a height field, or the planes and height fields in the world of the robot's file."""


NativeHeightField: TypeAlias = tuple[
    int, int, tuple[float, float], list[float], tuple[float, float, float], tuple[float | None, float]
]
"""Rows, columns, half lengths, heights, position, and surface of a height field."""


def native(ground: AnyGround | None) -> Ground | NativeHeightField | Literal["file"] | None:
    """Ground as the compiled module expects it."""
    if not isinstance(ground, HeightField):
        return ground
    heights = np.asarray(ground.heights, dtype=np.float64)
    if heights.ndim != 2:
        raise ValueError(f"heights has shape {heights.shape}; a height field has (rows, columns)")
    rows, columns = heights.shape
    (x, y), (px, py, pz) = ground.half_size, ground.position
    surface = (ground.friction, float(ground.restitution))
    return rows, columns, (x, y), heights.ravel().tolist(), (px, py, pz), surface
