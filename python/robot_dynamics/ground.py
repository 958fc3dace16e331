"""Ground of simulations: planes and height fields."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

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

    def height(self, x: Numbers, y: Numbers) -> NDArray[np.float64]:
        """Heights of the ground at points of the world; NaN outside the rectangle.

        Parameters
        ----------
        x : array_like, shape (...)
            Coordinates along x [m].
        y : array_like, shape (...)
            Coordinates along y [m].

        Returns
        -------
        ndarray, shape (...)
            Heights in the world [m].

        Raises
        ------
        ValueError
            The heights of this field do not have the shape (rows, columns), or `x` and `y` do not fit
            together.

        Examples
        --------
        >>> slope = rd.HeightField([[0.0, 1.0]] * 2, half_size=(2.0, 1.0))
        >>> slope.height([-2.0, 0.0, 1.0, 3.0], 0.5)
        array([0.  , 0.5 , 0.75,  nan])
        """
        heights = np.asarray(self.heights, np.float64)
        rows, columns = heights.shape
        column = (np.asarray(x, np.float64) - self.position[0] + self.half_size[0]) / (2.0 * self.half_size[0]) * (columns - 1)
        row = (np.asarray(y, np.float64) - self.position[1] + self.half_size[1]) / (2.0 * self.half_size[1]) * (rows - 1)
        row, column = np.broadcast_arrays(row, column)
        is_inside = (row >= 0.0) & (row <= rows - 1) & (column >= 0.0) & (column <= columns - 1)
        i = np.clip(np.nan_to_num(row), 0, rows - 2).astype(np.intp)
        j = np.clip(np.nan_to_num(column), 0, columns - 2).astype(np.intp)
        up, along = row - i, column - j
        low, high = heights[i, j], heights[i + 1, j + 1]
        # Each cell has two triangles, on both sides of its diagonal.
        below = low + along * (heights[i, j + 1] - low) + up * (high - heights[i, j + 1])
        above = low + up * (heights[i + 1, j] - low) + along * (high - heights[i + 1, j])
        result: NDArray[np.float64] = np.where(is_inside, self.position[2] + np.where(along >= up, below, above), np.nan)
        return result


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
