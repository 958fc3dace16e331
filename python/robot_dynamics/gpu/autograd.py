"""Gradients of functions on a device, by their pullbacks, for tensors of PyTorch."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import prod
from typing import TYPE_CHECKING, Any

from robot_dynamics.errors import DeviceError
from robot_dynamics.gpu.coordinates import gradient_by_coordinates, gradient_by_displacement

if TYPE_CHECKING:
    from robot_dynamics.gpu.functions import Arguments, DeviceFunction

_UNWEIGHTED = {"impulses": "impulses_next"}
"""Arguments of a pullback that are results of the function. Their changes have no weights."""

_GRADIENTS = {"q": "by_position", "v": "by_velocity", "a": "by_acceleration", "tau": "by_force"}
"""Results of a pullback by the arguments that they are gradients of."""


def is_recording() -> bool:
    """Whether PyTorch records operations for gradients.

    Returns
    -------
    bool
        False inside ``torch.no_grad()``.
    """
    import torch

    return bool(torch.is_grad_enabled())


def call(function: DeviceFunction, given: Arguments) -> Sequence[Any]:
    """Results of a function with gradients.

    Parameters
    ----------
    function : DeviceFunction
        Function.
    given : Arguments
        Arguments after their checks.

    Returns
    -------
    sequence of torch.Tensor
        Results.
    """
    results: Sequence[Any] = _classes()[0].apply(function, given, *given.arrays)
    return results


def rollout(step: DeviceFunction, given: Arguments, torques: Any, steps: int, trajectory: bool) -> Sequence[Any]:
    """Final states and trajectories with gradients.

    Parameters
    ----------
    step : DeviceFunction
        Step.
    given : Arguments
        Arguments of the first step after their checks.
    torques : torch.Tensor
        Torques, held or those of each step.
    steps : int
        Number of steps.
    trajectory : bool
        Whether to return the trajectories.

    Returns
    -------
    sequence of torch.Tensor
        Final q and v, the trajectories of q and v, `None` unless requested, and the final values of the other
        tables of the state, without gradients.
    """
    q, v = given.arrays[:2]
    q_all, v_all, *others = _classes()[1].apply(step, given, steps, q, v, torques)
    trajectories = (q_all, v_all) if trajectory else (None, None)
    return q_all[-1], v_all[-1], *trajectories, *others


def pullback_of(function: DeviceFunction) -> DeviceFunction:
    """The pullback of a function, compiled if it is not yet.

    Parameters
    ----------
    function : DeviceFunction
        Function.

    Returns
    -------
    DeviceFunction
        Its pullback.

    Raises
    ------
    DeviceError
        The function is a derivative itself.
    """
    stem, colon, frame = function.name.partition(":")
    if stem.endswith(("_pullback", "_derivatives")):
        raise DeviceError(f"{function.name}: second derivatives are not available: detach the arguments")
    return function._functions._function(f"{stem}_pullback{colon}{frame}")


def pulled_back_names(function: DeviceFunction, pullback: DeviceFunction) -> list[tuple[str, str | None]]:
    """Arguments of a function, and the results of its pullback that are their gradients.

    Parameters
    ----------
    function : DeviceFunction
        Function.
    pullback : DeviceFunction
        Its pullback.

    Returns
    -------
    list of tuple
        Name of each argument, and of its gradient; `None` for an argument without one, such as the step.
    """
    names = {name: _GRADIENTS.get(name, f"by_{name}") for name in function.arguments}
    return [(name, own if own in pullback.results else None) for name, own in names.items()]


def _cotangent(function: DeviceFunction, given: Arguments, results: Sequence[Any], gradients: Sequence[Any]) -> Any:
    """Weights of the changes of all results, side by side; those of configurations are along
    displacements."""
    import torch

    parts = []
    for (name, shape), result, gradient in zip(function.results.items(), results, gradients, strict=True):
        if name in _UNWEIGHTED.values():
            continue
        flat = gradient.reshape(*given.lead, prod(shape))
        if name == "q_next":
            flat = gradient_by_displacement(function._functions._robot, result, flat)
        parts.append(flat)
    return (parts[0] if len(parts) == 1 else torch.cat(parts, dim=-1)).contiguous()


def _at_results(function: DeviceFunction, inputs: Sequence[Any], results: Sequence[Any]) -> list[Any]:
    """Arguments of the pullback, except the weights: the multipliers of contact are those after the step."""
    found = dict(zip(function.results, results, strict=True))
    names = ((name, _UNWEIGHTED.get(name, "")) for name in function.arguments)
    return [found.get(result, given) for (_, result), given in zip(names, inputs, strict=True)]


def _pulled_back(function: DeviceFunction, given: Arguments, inputs: Sequence[Any], cotangent: Any) -> dict[str, Any]:
    """Gradients by the arguments, by the names of these; that by q is along displacements."""
    pullback = pullback_of(function)
    own = given._replace(arrays=[*inputs, cotangent])
    results = dict(zip(pullback.results, pullback._run(own), strict=True))
    return {name: results[result] for name, result in pulled_back_names(function, pullback) if result is not None}


@cache
def _classes() -> tuple[Any, Any]:
    """Functions and rollouts as classes of PyTorch."""
    import torch
    from torch.autograd.function import once_differentiable

    class Call(torch.autograd.Function):
        """A function on a device."""

        @staticmethod
        def forward(ctx: Any, function: DeviceFunction, given: Arguments, *arrays: Any) -> Any:
            results = function._run(given)
            pullback_of(function)
            ctx.function, ctx.given, ctx.count = function, given._replace(arrays=[]), len(arrays)
            ctx.save_for_backward(*arrays, *results)
            unweighted = zip(function.results, results, strict=True)
            ctx.mark_non_differentiable(*(x for name, x in unweighted if name in _UNWEIGHTED.values()))
            return tuple(results)

        @staticmethod
        @once_differentiable  # type: ignore[untyped-decorator]
        def backward(ctx: Any, *gradients: Any) -> Any:
            function, given = ctx.function, ctx.given
            inputs, results = ctx.saved_tensors[: ctx.count], ctx.saved_tensors[ctx.count :]
            with given.library.on_stream(function._functions._device, given.given_stream):
                cotangent = _cotangent(function, given, results, gradients)
                found = _pulled_back(function, given, _at_results(function, inputs, results), cotangent)
                if "q" in found:
                    q = inputs[list(function.arguments).index("q")]
                    found["q"] = gradient_by_coordinates(function._functions._robot, q, found["q"])
            return None, None, *(found.get(name) for name in function.arguments)

    class Rollout(torch.autograd.Function):
        """Steps on a device: the states after each step."""

        @staticmethod
        def forward(ctx: Any, step: DeviceFunction, given: Arguments, steps: int, q: Any, v: Any, tau: Any) -> Any:
            from robot_dynamics.gpu.rollouts import kept_states

            pullback_of(step)
            tables = kept_states(step, given, tau, steps)
            ctx.step, ctx.given, ctx.steps = step, given, steps
            ctx.save_for_backward(tau, *tables)
            ends = tuple(table[-1] for table in tables[2:])
            ctx.mark_non_differentiable(*ends)
            return tables[0][1:], tables[1][1:], *ends

        @staticmethod
        @once_differentiable  # type: ignore[untyped-decorator]
        def backward(ctx: Any, by_q: Any, by_v: Any, *_: Any) -> Any:
            step, given = ctx.step, ctx.given
            tau, *tables = ctx.saved_tensors
            (q, v), robot = tables[:2], step._functions._robot
            is_each = tau.ndim == len(given.lead) + 2
            by_tau = torch.zeros_like(tau)
            with given.library.on_stream(step._functions._device, given.given_stream):
                # The gradient along displacements, as all steps pass it on.
                by_each = gradient_by_displacement(robot, q[1:], by_q)
                found = {"q": torch.zeros_like(v[0]), "v": torch.zeros_like(v[0])}
                for k in reversed(range(ctx.steps)):
                    cotangent = torch.cat([found["q"] + by_each[k], found["v"] + by_v[k]], dim=-1)
                    inputs = [q[k], v[k], tau[k] if is_each else tau, *given.arrays[3:]]
                    inputs = _at_results(step, inputs, [table[k + 1] for table in tables])
                    found = _pulled_back(step, given, inputs, cotangent)
                    by_tau[k if is_each else ...] += found["tau"]
                start = gradient_by_coordinates(robot, q[0], found["q"])
            return None, None, None, start, found["v"], by_tau

    return Call, Rollout
