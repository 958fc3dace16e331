"""Two primitives of JAX: a foreign call, and a linear map with its transpose.

All operands of one bind have the leading dimensions of the whole batch, so `vmap` adds one in front. The
robot's parameters are the last operand of a call that has them. They have no leading dimensions if all states
share them.

A call has a tangent if `RULES` has one: a linear map of the changes that depends on the operands. Reverse
mode is its transpose. The transposes of inverse and forward dynamics are calls with rules, so their gradients
have derivatives. The maps themselves have none at other points: derivatives of forward mode raise an error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir, xla

from robot_dynamics import _native

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


@dataclass(frozen=True)
class Call:
    """Foreign call: everything that does not depend on the states."""

    name: str
    """Name of the function, for messages and as the key of its rule."""
    target: str
    """Name of the foreign function."""
    robot: Robot
    """Robot, which every compiled program with the call keeps alive."""
    attributes: tuple[tuple[str, Any], ...]
    """Attributes of the foreign function, by name."""
    own: tuple[int, ...]
    """Number of axes of each operand that belong to one state."""
    results: tuple[tuple[int, ...], ...]
    """Shape of each result for one state."""
    has_parameters: bool = False
    """Whether the last operand is the robot's parameters."""


@dataclass(frozen=True)
class Linear:
    """Linear map of changes at given operands."""

    call: Call
    """Call that the map is the tangent of."""
    residuals: int
    """Number of operands that the map depends on; it is linear in the others."""
    own: tuple[int, ...]
    """Number of axes of each operand that belong to one state."""
    forward: Callable[[Call, Sequence[Any], Sequence[Any]], Sequence[Any]]
    """Function of the call, the residuals and the changes."""
    transpose: Callable[[Call, Sequence[Any], Sequence[Any]], Sequence[Any]]
    """Function of the call, the residuals and the cotangents.

    It returns the cotangents of the changes, with the leading dimensions of the whole batch.
    """
    of_parameters: bool = False
    """Whether the last change is that of the robot's parameters."""


RULES: dict[str, Callable[[Call, Sequence[Any], Sequence[Any], Sequence[Any]], Sequence[Any]]] = {}
"""Tangents of calls by name: functions of the call, the operands, their changes and the results.

They return the changes of the results.
"""

call_p = Primitive("robot_dynamics")
linear_p = Primitive("robot_dynamics_linear")
call_p.multiple_results = linear_p.multiple_results = True


@cache
def _register() -> None:
    for name, handler in _native._xla_handlers().items():
        if name.endswith("_function"):
            continue  # `robot_dynamics.gpu.xla` registers these, each for its kind of device.
        jax.ffi.register_ffi_target(name, handler, platform="cpu")


def bind(call: Call, operands: Sequence[Any]) -> Sequence[Any]:
    """Bind a call to its operands.

    Parameters
    ----------
    call : Call
        The call.
    operands : sequence of jax.Array
        Operands with the leading dimensions of the whole batch.

    Returns
    -------
    sequence of jax.Array
        Results.
    """
    _register()
    results: Sequence[Any] = call_p.bind(*operands, call=call)
    return results


def tangent(linear: Linear, residuals: Sequence[Any], changes: Sequence[Any]) -> Sequence[Any]:
    """Bind a linear map to its residuals and changes.

    Parameters
    ----------
    linear : Linear
        The map.
    residuals : sequence of jax.Array
        Operands that the map depends on.
    changes : sequence of jax.Array
        Operands that the map is linear in.

    Returns
    -------
    sequence of jax.Array
        Changes of the results.
    """
    results: Sequence[Any] = linear_p.bind(*residuals, *changes, linear=linear)
    return results


def _call(*operands: Any, call: Call) -> Sequence[Any]:
    lead = operands[0].shape[: operands[0].ndim - call.own[0]]
    shapes = [jax.ShapeDtypeStruct((*lead, *own), operands[0].dtype) for own in call.results]
    # XLA's attributes are signed.
    handle = np.uint64(call.robot._xla_handle()).view(np.int64)
    attributes = {"robot": handle, "parameters": np.bool_(call.has_parameters), **dict(call.attributes)}
    results: Sequence[Any] = jax.ffi.ffi_call(call.target, shapes)(*operands, **attributes)
    return results


def _linear(*operands: Any, linear: Linear) -> Sequence[Any]:
    return linear.forward(linear.call, operands[: linear.residuals], operands[linear.residuals :])


def no_second_derivative(name: str) -> Exception:
    """Error of a call without a derivative.

    Parameters
    ----------
    name : str
        Name of the call.

    Returns
    -------
    Exception
        The error, to raise.
    """
    return NotImplementedError(f"{name}: second derivatives are not available, only first ones")


def _jvp_of_call(operands: Sequence[Any], changes: Sequence[Any], *, call: Call) -> tuple[Any, Any]:
    if call.name not in RULES:
        raise no_second_derivative(call.name)
    results = call_p.bind(*operands, call=call)
    if call.has_parameters and type(changes[-1]) is ad.Zero:
        changes = changes[:-1]  # constant parameters need no tangent
    changes = [ad.instantiate_zeros(change) for change in changes]
    return results, RULES[call.name](call, operands, changes, results)


def _jvp_of_linear(operands: Sequence[Any], changes: Sequence[Any], *, linear: Linear) -> tuple[Any, Any]:
    residuals, rest = operands[: linear.residuals], changes[linear.residuals :]
    if any(type(change) is not ad.Zero for change in changes[: linear.residuals]):
        raise no_second_derivative(linear.call.name)
    results = linear_p.bind(*operands, linear=linear)
    return results, linear_p.bind(*residuals, *map(ad.instantiate_zeros, rest), linear=linear)


def _transpose(cotangents: Sequence[Any], *operands: Any, linear: Linear) -> list[Any]:
    residuals = operands[: linear.residuals]
    given = [ad.instantiate_zeros(cotangent) for cotangent in cotangents]
    found = linear.transpose(linear.call, residuals, given)
    of_changes = [
        # An operand that all states share gets the sum.
        each.sum(axis=tuple(range(each.ndim - change.aval.ndim))) if ad.is_undefined_primal(change) else None
        for each, change in zip(found, operands[linear.residuals :], strict=True)
    ]
    return [None] * linear.residuals + of_changes


def _shared_operands(call: Call | None = None, linear: Linear | None = None) -> set[int]:
    """Operands that may lack the dimensions of the batch: the parameters and their change."""
    if linear is None:
        return {len(call.own) - 1} if call is not None and call.has_parameters else set()
    places = {linear.residuals - 1} if linear.call.has_parameters else set()
    return places | ({len(linear.own) - 1} if linear.of_parameters else set())


def _batch_rule(primitive: Primitive, operands: Sequence[Any], axes: Sequence[Any], **parameters: Any) -> tuple[Any, Any]:
    size = next(x.shape[axis] for x, axis in zip(operands, axes, strict=True) if axis is not None)
    own = (parameters.get("linear") or parameters["call"]).own
    lead = operands[0].shape if axes[0] is None else np.delete(operands[0].shape, axes[0])
    lead = tuple(int(length) for length in lead[: len(lead) - own[0]])
    shared = _shared_operands(**parameters)

    def moved_of(k: int, x: Any, axis: int | None) -> Any:
        if axis is None:
            return x if k in shared and x.ndim == 1 else jnp.broadcast_to(x, (size, *x.shape))
        x = jnp.moveaxis(x, axis, 0)
        if k in shared and x.ndim == 2 and lead:
            x = jnp.broadcast_to(jnp.expand_dims(x, range(1, len(lead) + 1)), (size, *lead, x.shape[-1]))
        return x

    moved = [moved_of(k, x, axis) for k, (x, axis) in enumerate(zip(operands, axes, strict=True))]
    results = primitive.bind(*moved, **parameters)
    return results, [0] * len(results)


def _abstract_results(function: Callable[..., Sequence[Any]], *operands: Any, **parameters: Any) -> Any:
    shapes = jax.eval_shape(partial(function, **parameters), *(jax.ShapeDtypeStruct(x.shape, x.dtype) for x in operands))
    return [jax.core.ShapedArray(each.shape, each.dtype) for each in shapes]


for primitive, function in ((call_p, _call), (linear_p, _linear)):
    primitive.def_impl(partial(xla.apply_primitive, primitive))
    primitive.def_abstract_eval(partial(_abstract_results, function))
    batching.primitive_batchers[primitive] = partial(_batch_rule, primitive)
    mlir.register_lowering(primitive, mlir.lower_fun(function, multiple_results=True), platform="cpu")

ad.primitive_jvps[call_p] = _jvp_of_call
ad.primitive_jvps[linear_p] = _jvp_of_linear
ad.primitive_transposes[linear_p] = _transpose
