"""Rollouts with contact for JAX, by callbacks to the host: the steps themselves run without Python."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from robot_dynamics.rollout_gradients import compute, rollout_gradients

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


def contact_rollout(robot: Robot, given: list[Any], how: dict[str, Any]) -> tuple[Any, Any, Any, Any]:
    """Final states and trajectories of (q, v) or (q, v, τ), with a gradient by these."""
    import jax

    samples = how["steps"] // how["stride"] if how["stride"] else 0

    def shapes(q: Any) -> tuple[Any, ...]:
        lead = q.shape[:-1]
        sizes = ((robot.nq,), (robot.nv,), (samples, robot.nq), (samples, robot.nv))
        return tuple(jax.ShapeDtypeStruct((*lead, *size), np.float64) for size in sizes)

    def whole(state: tuple[Any, ...]) -> tuple[Any, ...]:
        arrays = tuple(np.asarray(x) for x in state)
        return arrays if len(arrays) == 3 else (*arrays, None)

    def run(*state: Any) -> tuple[Any, ...]:
        return compute(robot, "rollout", *whole(state), **how)

    def pull(state: Any, ends: Any, cotangents: Any) -> tuple[Any, ...]:
        arrays = [tuple(np.asarray(x) for x in part) for part in (ends, cotangents)]
        found = rollout_gradients(robot, how, whole(state), arrays[0], arrays[1])
        return found[: len(state)]

    def call(*state: Any) -> Any:
        return jax.pure_callback(run, shapes(state[0]), *state, vmap_method="broadcast_all")

    def forward(*state: Any) -> Any:
        found = call(*state)
        return found, (state, (found[0], found[2]))

    def backward(kept: Any, cotangents: Any) -> Any:
        state, ends = kept
        sizes = tuple(jax.ShapeDtypeStruct(x.shape, np.float64) for x in state)
        return jax.pure_callback(pull, sizes, state, ends, cotangents, vmap_method="broadcast_all")

    motion = jax.custom_vjp(call)
    motion.defvjp(forward, backward)
    found: tuple[Any, Any, Any, Any] = motion(*given)
    return found
