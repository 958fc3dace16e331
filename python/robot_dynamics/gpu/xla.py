"""Functions on a device in programs of JAX: foreign calls of XLA, with gradients by pullbacks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache, lru_cache
from math import prod
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np

from robot_dynamics import _native
from robot_dynamics.errors import DTypeError, ShapeError
from robot_dynamics.gpu.autograd import pulled_back_names, pullback_of
from robot_dynamics.gpu.rollouts import arguments_of, state_names
from robot_dynamics.xla.coordinates import coordinates, displacement

if TYPE_CHECKING:
    from robot_dynamics.gpu.functions import DeviceFunction, DeviceRollout

_TARGETS = {"cpu": "robot_dynamics_cpu_function", "cuda": "robot_dynamics_cuda_function"}
"""Names of the foreign functions by the kind of device."""


@cache
def _register(kind: str) -> str:
    """Name of the foreign function, which XLA knows from now on."""
    target = _TARGETS[kind]
    platform = "cpu" if kind == "cpu" else "CUDA"
    jax.ffi.register_ffi_target(target, _native._xla_handlers()[target], platform=platform)
    return target


def call(function: DeviceFunction, arguments: Sequence[Any]) -> list[Any]:
    """Results of a function, in a program or outside, with gradients.

    Parameters
    ----------
    function : DeviceFunction
        Function.
    arguments : sequence of jax.Array
        Arguments in the order of the function; a number stands for the same number in all places.

    Returns
    -------
    list of jax.Array
        Results.
    """
    if len(arguments) != len(function.arguments):
        raise TypeError(f"{function.name} has {len(function.arguments)} arguments ({', '.join(function.arguments)}), got "
                        f"{len(arguments)}")
    dtype = function._functions._dtype
    if dtype == "float64" and not jax.config.jax_enable_x64:
        raise DTypeError("JAX has no float64: jax.config.update('jax_enable_x64', True), or compile for float32")
    arrays = [
        jnp.full(shape, array, dtype) if isinstance(array, (int, float)) else array
        for array, shape in zip(arguments, function.arguments.values(), strict=True)
    ]
    leads = []
    for (name, shape), array in zip(function.arguments.items(), arrays, strict=True):
        before = array.ndim - len(shape)
        if before < 0 or array.shape[before:] != shape:
            raise ShapeError(f"{name} has shape {array.shape}, but {function.name} of robot "
                             f"`{function._functions._robot.name}` needs (..., {', '.join(map(str, shape))})")
        if array.dtype != dtype:
            raise DTypeError(f"{name} is {array.dtype}, but the functions were compiled for {dtype}")
        leads.append(array.shape[:before])
    lead = jnp.broadcast_shapes(*leads)
    wide = [
        jnp.broadcast_to(array, (*lead, *shape))
        for array, shape in zip(arrays, function.arguments.values(), strict=True)
    ]
    return list(_differentiable(function)(*wide))


def rollout(
    step: DeviceFunction,
    state: tuple[Any, Any, Any],
    steps: int,
    dt: float,
    trajectory: bool,
    tables: Mapping[str, Any],
) -> DeviceRollout:
    """Steps as a loop of JAX; see `DeviceFunctions.rollout`.

    Parameters
    ----------
    step : DeviceFunction
        Step.
    state : tuple of arrays
        Configurations, velocities and torques.
    steps : int
        Number of steps.
    dt : float
        Step size [s].
    trajectory : bool
        Whether to return the states after each step.
    tables : mapping of str to array or float
        The other arguments of the step.

    Returns
    -------
    DeviceRollout
        Final states, and the trajectories.
    """
    from robot_dynamics.gpu.functions import DeviceRollout

    q, v, tau = (jnp.asarray(array) for array in state)
    first = arguments_of(step, (q, v, tau), steps, dt, tables)
    is_each = tau.ndim == q.ndim + 1
    if is_each and tau.shape[0] != steps:
        raise ShapeError(f"tau has shape {tau.shape}: its first axis must have steps = {steps}")
    names = state_names(step)
    held = dict(zip(step.arguments, first, strict=True))
    lead = q.shape[:-1]
    start = tuple(jnp.broadcast_to(jnp.asarray(held[name], q.dtype), (*lead, *step.arguments[name])) for name in names)

    def advance(state: tuple[Any, ...], own: Any) -> tuple[tuple[Any, ...], tuple[Any, ...] | None]:
        given = {**held, **dict(zip(names, state, strict=True)), **({"tau": own} if is_each else {})}
        after = tuple(call(step, [given[name] for name in step.arguments]))
        return after, after[:2] if trajectory else None

    end, states = jax.lax.scan(advance, start, tau if is_each else None, length=steps)
    q_trajectory, v_trajectory = states or (None, None)
    return DeviceRollout(end[0], end[1], q_trajectory, v_trajectory, dict(zip(names[2:], end[2:], strict=True)))


@lru_cache(maxsize=256)
def _differentiable(function: DeviceFunction) -> Any:
    """The function of arrays with the same leading axes."""

    @jax.custom_vjp  # type: ignore[untyped-decorator]
    def compute(*arrays: Any) -> tuple[Any, ...]:
        return _foreign_call(function, arrays)

    def forward(*arrays: Any) -> tuple[tuple[Any, ...], tuple[Any, Any]]:
        results = _foreign_call(function, arrays)
        return results, (arrays, results)

    def backward(kept: tuple[Any, Any], gradients: Sequence[Any]) -> tuple[Any, ...]:
        return _pulled_back(function, *kept, gradients)

    compute.defvjp(forward, backward)
    return compute


def _foreign_call(function: DeviceFunction, arrays: Sequence[Any]) -> tuple[Any, ...]:
    """The call of XLA."""
    functions = function._functions
    first = next(iter(function.arguments.values()))
    lead = arrays[0].shape[: arrays[0].ndim - len(first)]
    shapes = [jax.ShapeDtypeStruct((*lead, *shape), functions._dtype) for shape in function.results.values()]
    target = _register(functions._device.partition(":")[0])
    foreign = jax.ffi.ffi_call(target, shapes, vmap_method="broadcast_all")
    results: list[Any] = foreign(*arrays, functions=np.uint64(function._compiled._xla_handle()), name=function.name)
    return tuple(results)


def _pulled_back(
    function: DeviceFunction, arrays: Sequence[Any], results: Sequence[Any], gradients: Sequence[Any]
) -> tuple[Any, ...]:
    """Gradients by the arguments, from those by the results."""
    robot = function._functions._robot
    first = next(iter(function.arguments.values()))
    lead = arrays[0].shape[: arrays[0].ndim - len(first)]
    parts = []
    for (name, shape), result, gradient in zip(function.results.items(), results, gradients, strict=True):
        flat = gradient.reshape(*lead, prod(shape))
        if name == "q_next":
            along = jnp.zeros((*lead, robot.nv), flat.dtype)
            flat = jax.vjp(lambda change, q=result: coordinates(robot, q, change), along)[1](flat)[0]
        parts.append(flat)
    pullback = pullback_of(function)
    found = dict(zip(pullback.results, _differentiable(pullback)(*arrays, jnp.concatenate(parts, axis=-1)), strict=True))
    by_argument = []
    for (name, own), array in zip(pulled_back_names(function, pullback), arrays, strict=True):
        if own is None:
            by_argument.append(jnp.zeros_like(array))
        elif name == "q":
            change = jnp.zeros_like(array)
            by_argument.append(jax.vjp(lambda x, q=array: displacement(robot, q, x), change)[1](found[own])[0])
        else:
            by_argument.append(found[own])
    return tuple(by_argument)
