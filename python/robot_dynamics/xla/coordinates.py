"""Changes of a configuration by its nq numbers, and by displacements q ⊕ δq with nv numbers.

The maps are linear in the change, so JAX can transpose them. A function of q depends on the direction of each
quaternion only, F(q/|q|), as everywhere in this package.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import jax.numpy as jnp

from robot_dynamics.coordinate_ranges import coordinate_ranges

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


def displacement(robot: Robot, q: Any, change: Any) -> Any:
    """Displacement δ of a change of the numbers of q.

    For a floating joint u = Rᵀẋ, for a quaternion w = 2 (q* ⊗ q̇)/|q|².

    Parameters
    ----------
    robot : Robot
        Robot.
    q : jax.Array, shape (..., nq)
        Configuration.
    change : jax.Array, shape (..., nq)
        Change of the numbers of q.

    Returns
    -------
    jax.Array, shape (..., nv)
        Displacement δ.
    """
    if robot.nq == robot.nv:
        return change
    parts = []
    for entry in coordinate_ranges(robot):
        own, moved = q[..., entry.q], change[..., entry.q]
        if not entry.has_quaternion:
            parts.append(moved)
            continue
        vector, scalar = own[..., -4:-1], own[..., -1:]
        by_vector, by_scalar = moved[..., -4:-1], moved[..., -1:]
        if own.shape[-1] > 4:
            parts.append(_rotated(-vector, scalar, moved[..., :3]))
        turn = scalar * by_vector - by_scalar * vector - jnp.cross(vector, by_vector)
        parts.append(2.0 * turn / (own[..., -4:] ** 2).sum(axis=-1, keepdims=True))
    return jnp.concatenate(parts, axis=-1)


def coordinates(robot: Robot, q: Any, displaced: Any) -> Any:
    """Change of the numbers of q along a displacement δ.

    For a floating joint ẋ = R u, for a quaternion q̇ = ½ q ⊗ (w, 0).

    Parameters
    ----------
    robot : Robot
        Robot.
    q : jax.Array, shape (..., nq)
        Configuration.
    displaced : jax.Array, shape (..., nv)
        Displacement δ.

    Returns
    -------
    jax.Array, shape (..., nq)
        Change of the numbers of q.
    """
    if robot.nq == robot.nv:
        return displaced
    parts = []
    for entry in coordinate_ranges(robot):
        own, moved = q[..., entry.q], displaced[..., entry.v]
        if not entry.has_quaternion:
            parts.append(moved)
            continue
        vector, scalar, turn = own[..., -4:-1], own[..., -1:], moved[..., -3:]
        if own.shape[-1] > 4:
            parts.append(_rotated(vector, scalar, moved[..., :3]))
        along = -(vector * turn).sum(axis=-1, keepdims=True)
        parts.append(0.5 * jnp.concatenate([scalar * turn + jnp.cross(vector, turn), along], axis=-1))
    return jnp.concatenate(parts, axis=-1)


def _rotated(vector: Any, scalar: Any, x: Any) -> Any:
    """R x for the rotation R of a quaternion, with |q| divided out."""
    across = jnp.cross(vector, x)
    squared = (vector**2).sum(axis=-1, keepdims=True) + scalar**2
    return x + 2.0 * (scalar * across + jnp.cross(vector, across)) / squared
