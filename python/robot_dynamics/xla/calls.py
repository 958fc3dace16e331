"""Calls and their tangents.

λ is the cotangent of a result. Forward mode is J δ, from the derivatives. Reverse mode is Jᵀλ, from the
pullbacks, which form no J.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import jax.numpy as jnp
import numpy as np

from robot_dynamics.xla.coordinates import coordinates, displacement
from robot_dynamics.xla.primitives import RULES, Call, Linear, bind, no_second_derivative, tangent

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Arrays = Sequence[Any]


def row(robot: Robot, name: str, given: Arrays, parameters: Any = None, **attributes: int) -> Arrays:
    """Results of a row of the table of algorithms, for the robot or one with other parameters.

    Parameters
    ----------
    robot : Robot
        Robot.
    name : str
        Name of the row.
    given : sequence of jax.Array
        State, with the leading dimensions of the whole batch.
    parameters : jax.Array, shape (n,) or (..., n), optional
        Other parameters, in the order of `Robot.parameters()`.
    **attributes : int
        Attributes of the call, such as the number of a frame.

    Returns
    -------
    sequence of jax.Array
        Results.
    """
    results = tuple(map(tuple, robot._result_shapes(name)))
    numbers = tuple((key, np.int64(value)) for key, value in attributes.items())
    operands = [*given] if parameters is None else [*given, parameters]
    call = Call(
        name, "robot_dynamics_row", robot, (("row", name), *numbers), (1,) * len(operands), results, parameters is not None
    )
    return bind(call, operands)


def times(matrix: Any, vector: Any) -> Any:
    """M x for each state.

    Parameters
    ----------
    matrix : jax.Array, shape (..., m, n)
        M.
    vector : jax.Array, shape (..., n)
        x.

    Returns
    -------
    jax.Array, shape (..., m)
        M x.
    """
    return jnp.einsum("...ij,...j->...i", matrix, vector)


def linear_of(call: Call, operands: Arrays, changes: Arrays, forward: Any, transpose: Any) -> Arrays:
    """Tangent of a call whose first operand is a configuration, by displacements.

    Parameters
    ----------
    call : Call
        The call.
    operands : sequence of jax.Array
        Its operands.
    changes : sequence of jax.Array
        Changes of the operands; the first is a change of the numbers of q.
    forward, transpose : callable
        Functions of `Linear`.

    Returns
    -------
    sequence of jax.Array
        Changes of the results.
    """
    moved = [displacement(call.robot, operands[0], changes[0]), *changes[1:]]
    own = call.own + call.own[: len(changes)]
    by_parameters = call.has_parameters and len(changes) == len(operands)
    return tangent(Linear(call, len(operands), own, forward, transpose, by_parameters), operands, moved)


def split_parameters(call: Call, at: Arrays) -> tuple[Arrays, Any]:
    """Operands of the state, and the parameters or `None`.

    Parameters
    ----------
    call : Call
        The call.
    at : sequence of jax.Array
        Its operands.

    Returns
    -------
    sequence of jax.Array
        State.
    jax.Array or None
        Parameters.
    """
    return (at[:-1], at[-1]) if call.has_parameters else (at, None)


# τ(q, v, a) and a(q, v, τ), of the robot or of one with other parameters p.


def _solution_forward(call: Call, at: Arrays, changes: Arrays) -> Arrays:
    state, parameters = split_parameters(call, at)
    derivatives = row(call.robot, f"{call.name}_derivatives", state, parameters)
    if call.name == "inverse_dynamics":
        derivatives = [*derivatives, *row(call.robot, "mass_matrix", state[:1], parameters)]
    moved = sum(times(each, change) for each, change in zip(derivatives, changes, strict=False))
    if len(changes) > len(derivatives):
        moved = moved + times(_by_parameters(call, state, parameters), changes[-1])
    return [moved]


def _by_parameters(call: Call, state: Arrays, parameters: Any) -> Any:
    """Derivative by the parameters (..., nv, parameters): row i is the pullback of the unit vector i."""
    nv = call.robot.nv
    each = [jnp.broadcast_to(x[..., jnp.newaxis, :], (*x.shape[:-1], nv, x.shape[-1])) for x in state]
    unit = jnp.broadcast_to(jnp.eye(nv, dtype=state[0].dtype), (*state[0].shape[:-1], nv, nv))
    if parameters.ndim > 1:
        shape = (*parameters.shape[:-1], nv, parameters.shape[-1])
        parameters = jnp.broadcast_to(parameters[..., jnp.newaxis, :], shape)
    return row(call.robot, f"{call.name}_pullback_with_parameters", [*each, unit], parameters)[-1]


def _solution_transpose(call: Call, at: Arrays, cotangents: Arrays) -> Arrays:
    state, parameters = split_parameters(call, at)
    return row(call.robot, f"{call.name}_pullback", [*state, *cotangents], parameters)


def _solution_transpose_with_parameters(call: Call, at: Arrays, cotangents: Arrays) -> Arrays:
    state, parameters = split_parameters(call, at)
    return row(call.robot, f"{call.name}_pullback_with_parameters", [*state, *cotangents], parameters)


def _solution(call: Call, operands: Arrays, changes: Arrays, _: Arrays) -> Arrays:
    changed = call.has_parameters and len(changes) == len(operands)
    transpose = _solution_transpose_with_parameters if changed else _solution_transpose
    return linear_of(call, operands, changes, _solution_forward, transpose)


# Second derivatives, by matrices: the gradient g = Jᵀλ changes by its derivative along the state, and by Jᵀ
# δλ.


def _pullback(call: Call, operands: Arrays, changes: Arrays, _: Arrays) -> Arrays:
    if call.has_parameters:
        raise no_second_derivative(f"{call.name} with parameters")
    robot, (*state, _), solution = call.robot, operands, call.name.removesuffix("_pullback")
    along = jnp.concatenate([displacement(robot, state[0], changes[0]), *changes[1:3]], axis=-1)
    (derivative,) = row(robot, f"{call.name}_derivative", operands)
    moved = jnp.split(jnp.einsum("...ij,...i->...j", derivative, along), 3, axis=-1)
    jacobians = [*row(robot, f"{solution}_derivatives", state)]
    if solution == "inverse_dynamics":
        jacobians += row(robot, "mass_matrix", state[:1])
    return [
        each + jnp.einsum("...ij,...i->...j", jacobian, changes[3])
        for each, jacobian in zip(moved, jacobians, strict=True)
    ]


def _jacobian(call: Call, operands: Arrays, changes: Arrays, _: Arrays) -> Arrays:
    frame = dict(call.attributes)["frame"]
    (derivative,) = row(call.robot, "frame_jacobian_derivative", operands, frame=frame)
    along = displacement(call.robot, operands[0], changes[0])
    return [jnp.einsum("...rjk,...k->...rj", derivative, along)]


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
    (jacobian,) = row(call.robot, "frame_jacobian", operands, frame=frame)
    twist = times(jacobian, displacement(call.robot, operands[0], changes[0]))
    turned = jnp.cross(twist[..., jnp.newaxis, 3:], jnp.swapaxes(results[0][..., :3, :3], -1, -2))
    upper = jnp.concatenate([jnp.swapaxes(turned, -1, -2), twist[..., :3, jnp.newaxis]], axis=-1)
    return [jnp.concatenate([upper, jnp.zeros_like(results[0][..., 3:, :])], axis=-2)]


# Rollouts.


@dataclass(frozen=True)
class RolloutSettings:
    """Settings of a rollout."""

    torques: str
    """``none``, ``held`` over all steps, or given for ``each`` step."""
    steps: int
    """Number of steps."""
    dt: float
    """Step size [s]."""
    integrator: str
    """Explicit method."""
    dissipation: bool
    """Whether damping and friction act."""
    stride: int
    """Number of steps between samples of the trajectory; 0 for no trajectory."""

    def attributes(self) -> tuple[tuple[str, Any], ...]:
        """Attributes of the foreign function.

        Returns
        -------
        tuple of tuple (str, value)
            Attributes by name.
        """
        return (
            ("torques", self.torques),
            ("steps", np.int64(self.steps)),
            ("dt", np.float64(self.dt)),
            ("integrator", self.integrator),
            ("dissipation", np.bool_(self.dissipation)),
            ("stride", np.int64(self.stride)),
        )

    def shapes(self, of_q: int, of_v: int) -> tuple[tuple[int, ...], ...]:
        """Shapes of the final states and, if there are any, of the trajectories.

        Parameters
        ----------
        of_q, of_v : int
            Numbers of q and of v.

        Returns
        -------
        tuple of tuple of int
            Shapes for one state.
        """
        ends: tuple[tuple[int, ...], ...] = ((of_q,), (of_v,))
        if self.stride == 0:
            return ends
        samples = self.steps // self.stride
        return (*ends, (samples, of_q), (samples, of_v))


def rollout(robot: Robot, given: Arrays, own: tuple[int, ...], settings: RolloutSettings, parameters: Any = None) -> Arrays:
    """Final q and v, and the trajectories if there are any.

    Parameters
    ----------
    robot : Robot
        Robot.
    given : sequence of jax.Array
        Initial states and torques, with the leading dimensions of the whole batch.
    own : tuple of int
        Number of axes of each array that belong to one state.
    settings : RolloutSettings
        Settings.
    parameters : jax.Array, shape (n,) or (..., n), optional
        Other parameters, in the order of `Robot.parameters()`.

    Returns
    -------
    sequence of jax.Array
        Results.
    """
    shapes = settings.shapes(robot.nq, robot.nv)
    operands, has_parameters = [*given], parameters is not None
    if has_parameters:
        operands, own = [*operands, parameters], (*own, 1)
    call = Call("rollout", "robot_dynamics_rollout", robot, settings.attributes(), own, shapes, has_parameters)
    return bind(call, operands)


def _ends(call: Call, width: int) -> tuple[tuple[int, ...], ...]:
    return tuple((*shape[:-1], width) for shape in call.results)


def _rollout_forward(call: Call, at: Arrays, changes: Arrays) -> Arrays:
    state, parameters = split_parameters(call, at)
    own, changed = call.own[: len(state)], [*changes]
    if len(changes) > len(state):
        changed[-1] = jnp.broadcast_to(changes[-1], (*at[0].shape[:-1], changes[-1].shape[-1]))
    tangents = replace(
        call,
        name="rollout's tangent",
        target="robot_dynamics_rollout_tangent",
        own=own + call.own[: len(changes)] + (1,) * call.has_parameters,
        results=_ends(call, call.robot.nv),
    )
    return bind(tangents, [*state, *changed, *([parameters] if call.has_parameters else [])])


def _pulled_back(call: Call, at: Arrays, cotangents: Arrays, by_parameters: bool) -> Arrays:
    state, parameters = split_parameters(call, at)
    own = call.own[: len(state)]
    results = tuple(x.shape[x.ndim - axes : -1] + (call.robot.nv,) for x, axes in zip(state, own, strict=True))
    gradients = replace(
        call,
        name="rollout's gradient",
        target="robot_dynamics_rollout_pullback",
        own=own + tuple(map(len, call.results)) + (1,) * call.has_parameters,
        results=(*results, (len(call.robot.parameter_names),)) if by_parameters else results,
    )
    return bind(gradients, [*state, *cotangents, *([parameters] if call.has_parameters else [])])


def _rollout_transpose(call: Call, at: Arrays, cotangents: Arrays) -> Arrays:
    return _pulled_back(call, at, cotangents, by_parameters=False)


def _rollout_transpose_with_parameters(call: Call, at: Arrays, cotangents: Arrays) -> Arrays:
    return _pulled_back(call, at, cotangents, by_parameters=True)


def _rollout(call: Call, operands: Arrays, changes: Arrays, results: Arrays) -> Arrays:
    changed = call.has_parameters and len(changes) == len(operands)
    transpose = _rollout_transpose_with_parameters if changed else _rollout_transpose
    moved = linear_of(call, operands, changes, _rollout_forward, transpose)
    return [
        coordinates(call.robot, results[k], change) if k % 2 == 0 else change for k, change in enumerate(moved)
    ]


RULES.update(
    inverse_dynamics=_solution,
    forward_dynamics=_solution,
    inverse_dynamics_pullback=_pullback,
    forward_dynamics_pullback=_pullback,
    mass_matrix=_mass,
    frame_pose=_pose,
    frame_jacobian=_jacobian,
    rollout=_rollout,
)
