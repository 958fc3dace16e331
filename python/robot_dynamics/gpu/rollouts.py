"""Rollouts on a device: steps in places for states, without a wait between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from math import prod
from typing import TYPE_CHECKING, Any

from robot_dynamics._native import CpuFunctions
from robot_dynamics.errors import DeviceError, ShapeError
from robot_dynamics.gpu.arrays import check, library_of

if TYPE_CHECKING:
    from robot_dynamics.gpu.functions import Arguments, DeviceFunction, DeviceFunctions, DeviceRollout


def rollout(
    functions: DeviceFunctions,
    step: DeviceFunction,
    state: tuple[Any, Any, Any],
    steps: int,
    dt: float,
    trajectory: bool,
    out: tuple[Any, Any] | None,
    stream: Any,
) -> DeviceRollout:
    """See `DeviceFunctions.rollout`.

    Parameters
    ----------
    functions : DeviceFunctions
        Compiled functions.
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
    out : tuple of two arrays, optional
        Arrays for the final states.
    stream : object, optional
        Stream, or its handle.

    Returns
    -------
    DeviceRollout
        Final states, and the trajectories.
    """
    from robot_dynamics.gpu.functions import DeviceRollout

    if list(step.arguments) != ["q", "v", "tau", "h"] or list(step.results) != ["q_next", "v_next"]:
        raise DeviceError(f"{step.name} is not a step from (q, v, tau, h) to the next q and v: call it for each step")
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < 1:
        raise ValueError(f"steps is {steps!r}: it must be a whole number from 1")
    if not (math.isfinite(dt) and dt > 0.0):
        raise ValueError(f"dt is {dt!r}: it must be positive and finite")
    q, v, tau = state
    library, array = library_of(tau, "tau")
    axes = len(library.shape(library_of(q, "q")[1]))
    is_each = len(library.shape(array)) == axes + 1
    if is_each and library.shape(array)[0] != steps:
        raise ShapeError(f"tau has shape {library.shape(array)}: its first axis must have steps = {steps}")
    if is_each:
        check(library, array, "tau", functions._dtype, functions._device)
    given = step._given((q, v, array[0] if is_each else tau, float(dt)), stream)
    torques = array if is_each else given.arrays[2]
    has_gradients = library.name == "torch" and any(x.requires_grad for x in (*given.arrays[:2], torques))
    if has_gradients:
        from robot_dynamics.gpu import autograd

        if autograd.is_recording():
            if out is not None:
                raise TypeError("out= has no gradients: detach the arguments, or call without out=")
            return DeviceRollout(*autograd.rollout(step, given, torques, steps, trajectory))
    if trajectory:
        places = kept_states(step, given, torques, steps)
        if out is not None:
            for source, target in zip(places, step._outputs(library, out, given.lead), strict=True):
                library.copy(source[steps], target)
        q_end, v_end = out if out is not None else (place[steps] for place in places)
        return DeviceRollout(q_end, v_end, places[0][1:], places[1][1:])
    q_end, v_end = _final_states(step, given, torques, steps, out)
    return DeviceRollout(q_end, v_end, None, None)


def kept_states(step: DeviceFunction, given: Arguments, torques: Any, steps: int) -> tuple[Any, Any]:
    """The states before the first step and after each step, (steps + 1, ..., n).

    Parameters
    ----------
    step : DeviceFunction
        Step.
    given : Arguments
        Arguments of the first step.
    torques : array
        Torques, held or those of each step.
    steps : int
        Number of steps.

    Returns
    -------
    q : array
        Configurations.
    v : array
        Velocities.
    """
    own, library = step._functions, given.library
    with library.on_stream(own._device, given.given_stream):
        q, v = (
            library.empty((steps + 1, *given.lead, *shape), own._dtype, own._device) for shape in step.results.values()
        )
        library.copy(given.arrays[0], q[0])
        library.copy(given.arrays[1], v[0])
    advance(step, given, torques, steps, [(q[k], v[k]) for k in range(steps + 1)])
    return q, v


def _final_states(step: DeviceFunction, given: Arguments, torques: Any, steps: int, out: Any) -> Sequence[Any]:
    """The states after the last step. Steps alternate between two places, of which one is the result."""
    own, library = step._functions, given.library
    with library.on_stream(own._device, given.given_stream):

        def new() -> list[Any]:
            return [library.empty((*given.lead, *shape), own._dtype, own._device) for shape in step.results.values()]

        ends = new() if out is None else step._outputs(library, out, given.lead)
        others = new()
        # The states are in the results after an even number of steps from there.
        start = ends if steps % 2 == 0 else others
        for source, target in zip(given.arrays, start, strict=False):
            if library.address(source) != library.address(target) or prod(given.lead) == 0:
                library.copy(source, target)
    places = [tuple(ends), tuple(others)] if steps % 2 == 0 else [tuple(others), tuple(ends)]
    advance(step, given, torques, steps, places)
    return ends


def advance(step: DeviceFunction, given: Arguments, torques: Any, steps: int, places: Sequence[tuple[Any, ...]]) -> None:
    """Take steps: step k reads place k mod n and writes place k + 1 mod n.

    Parameters
    ----------
    step : DeviceFunction
        Step.
    given : Arguments
        Arguments of the first step.
    torques : array
        Torques, held or those of each step.
    steps : int
        Number of steps.
    places : sequence of tuple of arrays
        Places for states.
    """
    library, h = given.library, given.arrays[3]
    count = len(places)
    is_each = len(library.shape(torques)) == len(given.lead) + 2
    if isinstance(step._compiled, CpuFunctions):
        for k in range(steps):
            tau = torques[k] if is_each else torques
            step._launch(given, [*places[k % count], tau, h], places[(k + 1) % count])
        return
    states, shapes = prod(given.lead), list(step.results.values())
    memory = [step._memory(library, place, shapes, states) for place in places]
    own = prod(step.arguments["tau"]) * states
    held = [(library.address(torques), own * steps if is_each else own), (library.address(h), states)]
    step._compiled._rollout(step.name, steps, memory, held, [], given.stream, False)
