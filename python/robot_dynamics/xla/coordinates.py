"""Changes of a configuration by its nq numbers and by displacements q ⊕ δ, nv numbers: linear in the change,
so that JAX transposes them.

A function of q is taken to depend on the direction of each quaternion alone, F(q/|q|), as everywhere in this
package.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import jax.numpy as jnp

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


class Stretch(NamedTuple):
    """Numbers of q and of v that belong together."""

    q: slice
    v: slice
    is_turned: bool
    """Whether the last of q are a quaternion; else q and v have the same numbers here."""


@lru_cache(maxsize=64)
def stretches(robot: Robot) -> tuple[Stretch, ...]:
    """The joints with quaternions, and what lies between them."""
    found: list[Stretch] = []
    for joint in robot.joints:
        width, freedoms = joint.q.stop - joint.q.start, joint.v.stop - joint.v.start
        if width > freedoms or not found or found[-1].is_turned:
            found.append(Stretch(joint.q, joint.v, width > freedoms))
        elif width:
            last = found.pop()
            found.append(Stretch(slice(last.q.start, joint.q.stop), slice(last.v.start, joint.v.stop), False))
    return tuple(found)


def displacement(robot: Robot, q: Any, change: Any) -> Any:
    """δ (..., nv) of a change of q's numbers (..., nq): u = Rᵀẋ of a floating joint, w = 2 (q* ⊗ q̇)/|q|² of a
    quaternion."""
    if robot.nq == robot.nv:
        return change
    parts = []
    for stretch in stretches(robot):
        own, moved = q[..., stretch.q], change[..., stretch.q]
        if not stretch.is_turned:
            parts.append(moved)
            continue
        vector, scalar = own[..., -4:-1], own[..., -1:]
        by_vector, by_scalar = moved[..., -4:-1], moved[..., -1:]
        if own.shape[-1] > 4:
            parts.append(_turned(-vector, scalar, moved[..., :3]))
        turn = scalar * by_vector - by_scalar * vector - jnp.cross(vector, by_vector)
        parts.append(2.0 * turn / (own[..., -4:] ** 2).sum(axis=-1, keepdims=True))
    return jnp.concatenate(parts, axis=-1)


def coordinates(robot: Robot, q: Any, displaced: Any) -> Any:
    """The change of q's numbers (..., nq) along δ (..., nv): ẋ = R u of a floating joint, q̇ = ½ q ⊗ (w, 0) of
    a quaternion."""
    if robot.nq == robot.nv:
        return displaced
    parts = []
    for stretch in stretches(robot):
        own, moved = q[..., stretch.q], displaced[..., stretch.v]
        if not stretch.is_turned:
            parts.append(moved)
            continue
        vector, scalar, turn = own[..., -4:-1], own[..., -1:], moved[..., -3:]
        if own.shape[-1] > 4:
            parts.append(_turned(vector, scalar, moved[..., :3]))
        along = -(vector * turn).sum(axis=-1, keepdims=True)
        parts.append(0.5 * jnp.concatenate([scalar * turn + jnp.cross(vector, turn), along], axis=-1))
    return jnp.concatenate(parts, axis=-1)


def _turned(vector: Any, scalar: Any, x: Any) -> Any:
    """R x of the rotation of a quaternion, |q| divided out."""
    across = jnp.cross(vector, x)
    squared = (vector**2).sum(axis=-1, keepdims=True) + scalar**2
    return x + 2.0 * (scalar * across + jnp.cross(vector, across)) / squared
