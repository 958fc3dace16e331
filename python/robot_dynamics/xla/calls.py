"""The calls and their tangents.

With λ the cotangent of a result: forward mode is J δ, from the slopes; reverse mode is Jᵀλ by the pullbacks, which form
no J.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import jax.numpy as jnp
import numpy as np

from robot_dynamics.xla.coordinates import coordinates, displacement
from robot_dynamics.xla.primitives import RULES, Call, Linear, bind, tangent

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Arrays = Sequence[Any]


def row(robot: "Robot", name: str, given: Arrays, **attributes: int) -> Arrays:
    """The results of a row of the table of algorithms."""
    vector, square = (robot.nv,), (robot.nv, robot.nv)
    results = {
        "mass_matrix": (square,),
        "mass_matrix_rate": (square,),
        "frame_pose": ((4, 4),),
        "frame_jacobian_world_aligned": ((6, robot.nv),),
        "inverse_dynamics_derivatives": (square, square),
        "forward_dynamics_derivatives": (square, square, square),
        "inverse_dynamics_pullback": (vector, vector, vector),
        "forward_dynamics_pullback": (vector, vector, vector),
    }.get(name, (vector,))
    numbers = tuple((key, np.int64(value)) for key, value in attributes.items())
    own = (1,) * len(given)
    return bind(Call(name, "robot_dynamics_row", robot, (("row", name), *numbers), own, results), given)


def times(matrix: Any, vector: Any) -> Any:
    """M x of each state."""
    return jnp.einsum("...ij,...j->...i", matrix, vector)


def linear_of(call: Call, operands: Arrays, changes: Arrays, forward: Any, transpose: Any) -> Arrays:
    """The tangent whose first change is that of a configuration, by displacements."""
    moved = [displacement(call.robot, operands[0], changes[0]), *changes[1:]]
    own = call.own + call.own
    return tangent(Linear(call, len(operands), own, forward, transpose), operands, moved)


# τ(q, v, a)


def _inverse_forward(call: Call, at: Arrays, changes: Arrays) -> Arrays:
    by_position, by_velocity = row(call.robot, "inverse_dynamics_derivatives", at)
    (by_acceleration,) = row(call.robot, "mass_matrix", at[:1])
    slopes = (by_position, by_velocity, by_acceleration)
    return [sum(times(slope, change) for slope, change in zip(slopes, changes, strict=True))]


def _inverse_transpose(call: Call, at: Arrays, cotangents: Arrays) -> Arrays:
    return row(call.robot, "inverse_dynamics_pullback", [*at, *cotangents])


def _inverse(call: Call, operands: Arrays, changes: Arrays, _: Arrays) -> Arrays:
    return linear_of(call, operands, changes, _inverse_forward, _inverse_transpose)


# a(q, v, τ)


def _forward_forward(call: Call, at: Arrays, changes: Arrays) -> Arrays:
    slopes = row(call.robot, "forward_dynamics_derivatives", at)
    return [sum(times(slope, change) for slope, change in zip(slopes, changes, strict=True))]


def _forward_transpose(call: Call, at: Arrays, cotangents: Arrays) -> Arrays:
    return row(call.robot, "forward_dynamics_pullback", [*at, *cotangents])


def _forward(call: Call, operands: Arrays, changes: Arrays, _: Arrays) -> Arrays:
    return linear_of(call, operands, changes, _forward_forward, _forward_transpose)


# M(q): column j is τ(q, 0, eⱼ) − τ(q, 0, 0).


def _mass_forward(call: Call, at: Arrays, changes: Arrays) -> Arrays:
    return row(call.robot, "mass_matrix_rate", [*at, *changes])


def _mass_transpose(call: Call, at: Arrays, cotangents: Arrays) -> Arrays:
    robot, (q,), (of_mass,) = call.robot, at, cotangents
    columns = jnp.swapaxes(of_mass, -1, -2)
    rest = jnp.zeros_like(columns)
    unit = jnp.broadcast_to(jnp.eye(robot.nv, dtype=q.dtype), columns.shape)
    each = jnp.broadcast_to(q[..., jnp.newaxis, :], (*columns.shape[:-1], robot.nq))
    by_columns = row(robot, "inverse_dynamics_pullback", [each, rest, unit, columns])[0].sum(axis=-2)
    nothing = jnp.zeros_like(columns[..., 0, :])
    of_gravity = row(robot, "inverse_dynamics_pullback", [q, nothing, nothing, columns.sum(axis=-2)])[0]
    return [by_columns - of_gravity]


def _mass(call: Call, operands: Arrays, changes: Arrays, _: Arrays) -> Arrays:
    return linear_of(call, operands, changes, _mass_forward, _mass_transpose)


# [R p; 0 1] of a frame: ṗ is the Jacobian's upper half times v, Ṙ = [ω]× R.


def _pose(call: Call, operands: Arrays, changes: Arrays, results: Arrays) -> Arrays:
    frame = dict(call.attributes)["frame"]
    (jacobian,) = row(call.robot, "frame_jacobian_world_aligned", operands, frame=frame)
    twist = times(jacobian, displacement(call.robot, operands[0], changes[0]))
    turned = jnp.cross(twist[..., jnp.newaxis, 3:], jnp.swapaxes(results[0][..., :3, :3], -1, -2))
    upper = jnp.concatenate([jnp.swapaxes(turned, -1, -2), twist[..., :3, jnp.newaxis]], axis=-1)
    return [jnp.concatenate([upper, jnp.zeros_like(results[0][..., 3:, :])], axis=-2)]


# Rollouts.


@dataclass(frozen=True)
class Course:
    """How a rollout goes."""

    torques: str
    """``none``, ``held`` over all steps, or of ``each`` step."""
    steps: int
    step: float
    integrator: str
    dissipation: bool
    stride: int

    def attributes(self) -> tuple[tuple[str, Any], ...]:
        """As XLA passes them on."""
        return (
            ("torques", self.torques),
            ("steps", np.int64(self.steps)),
            ("step", np.float64(self.step)),
            ("integrator", self.integrator),
            ("dissipation", np.bool_(self.dissipation)),
            ("stride", np.int64(self.stride)),
        )

    def shapes(self, of_q: int, of_v: int) -> tuple[tuple[int, ...], ...]:
        """Of the ends, and of the trajectories if there are such."""
        ends: tuple[tuple[int, ...], ...] = ((of_q,), (of_v,))
        if self.stride == 0:
            return ends
        samples = self.steps // self.stride
        return (*ends, (samples, of_q), (samples, of_v))


def rollout(robot: "Robot", given: Arrays, own: tuple[int, ...], course: Course) -> Arrays:
    """The ends' q and v, and the trajectories' if there are such."""
    shapes = course.shapes(robot.nq, robot.nv)
    return bind(Call("rollout", "robot_dynamics_rollout", robot, course.attributes(), own, shapes), given)


def _ends(call: Call, width: int) -> tuple[tuple[int, ...], ...]:
    return tuple((*shape[:-1], width) for shape in call.results)


def _rollout_forward(call: Call, at: Arrays, changes: Arrays) -> Arrays:
    tangents = replace(
        call,
        name="rollout's tangent",
        target="robot_dynamics_rollout_tangent",
        own=call.own + call.own,
        results=_ends(call, call.robot.nv),
    )
    return bind(tangents, [*at, *changes])


def _rollout_transpose(call: Call, at: Arrays, cotangents: Arrays) -> Arrays:
    gradients = replace(
        call,
        name="rollout's gradient",
        target="robot_dynamics_rollout_pullback",
        own=call.own + tuple(map(len, call.results)),
        results=tuple(
            x.shape[x.ndim - axes : -1] + (call.robot.nv,) for x, axes in zip(at, call.own, strict=True)
        ),
    )
    return bind(gradients, [*at, *cotangents])


def _rollout(call: Call, operands: Arrays, changes: Arrays, results: Arrays) -> Arrays:
    moved = linear_of(call, operands, changes, _rollout_forward, _rollout_transpose)
    return [
        coordinates(call.robot, results[k], change) if k % 2 == 0 else change for k, change in enumerate(moved)
    ]


RULES.update(
    inverse_dynamics=_inverse, forward_dynamics=_forward, mass_matrix=_mass, frame_pose=_pose, rollout=_rollout
)
