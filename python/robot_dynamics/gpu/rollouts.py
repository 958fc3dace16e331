"""Rollouts on a device: steps in places for states, without a wait between them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from math import prod
from typing import TYPE_CHECKING, Any

from robot_dynamics._native import CpuFunctions
from robot_dynamics.errors import DeviceError, ShapeError
from robot_dynamics.gpu.arrays import check, library_of

if TYPE_CHECKING:
    from robot_dynamics.gpu.functions import Arguments, DeviceFunction, DeviceFunctions, DeviceRollout


def state_names(step: DeviceFunction) -> list[str]:
    """Names of the tables of the state: those that a step reads, and writes with the suffix ``_next``.

    Parameters
    ----------
    step : DeviceFunction
        Step.

    Returns
    -------
    list of str
        ``q``, ``v``, and others such as the impulses of contact.

    Raises
    ------
    DeviceError
        The function is not a step.
    """
    names = [name.removesuffix("_next") for name in step.results]
    if names[:2] != ["q", "v"] or not {"tau", "h", *names} <= set(step.arguments):
        raise DeviceError(f"{step.name} is not a step: name one such as 'rk4_step'")
    return names


def arguments_of(
    step: DeviceFunction, state: tuple[Any, Any, Any], steps: int, dt: float, tables: Mapping[str, Any]
) -> list[Any]:
    """Arguments of the first step, after the checks of numbers.

    Parameters
    ----------
    step : DeviceFunction
        Step.
    state : tuple of arrays
        Configurations, velocities and torques of the first step.
    steps : int
        Number of steps.
    dt : float
        Step size [s].
    tables : mapping of str to array or float
        The other arguments of the step by name. Those of the state are 0 by default.

    Returns
    -------
    list
        Arguments in the order of the step; a number stands for the same number in all states.
    """
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < 1:
        raise ValueError(f"steps is {steps!r}: it must be a whole number from 1")
    if not (math.isfinite(dt) and dt > 0.0):
        raise ValueError(f"dt is {dt!r}: it must be positive and finite")
    own = dict(zip(("q", "v", "tau", "h"), (*state, float(dt)), strict=True))
    others = [name for name in step.arguments if name not in own]
    if unknown := [name for name in tables if name not in others]:
        raise TypeError(f"{step.name} has no argument {unknown[0]!r}; beside q, v, tau and dt it has {others}")
    of_state = state_names(step)
    if missing := [name for name in others if name not in tables and name not in of_state]:
        raise TypeError(f"{step.name} needs the argument {missing[0]}=, an array or a number")
    given = {**dict.fromkeys(of_state, 0.0), **tables, **own}
    return [given[name] for name in step.arguments]


def rollout(
    functions: DeviceFunctions,
    step: DeviceFunction,
    state: tuple[Any, Any, Any],
    steps: int,
    dt: float,
    trajectory: bool,
    out: tuple[Any, Any] | None,
    stream: Any,
    tables: Mapping[str, Any],
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
    tables : mapping of str to array or float
        The other arguments of the step.

    Returns
    -------
    DeviceRollout
        Final states, and the trajectories.
    """
    from robot_dynamics.gpu.functions import DeviceRollout

    q, v, tau = state
    library, array = library_of(tau, "tau")
    axes = len(library.shape(library_of(q, "q")[1]))
    is_each = len(library.shape(array)) == axes + 1
    if is_each and library.shape(array)[0] != steps:
        raise ShapeError(f"tau has shape {library.shape(array)}: its first axis must have steps = {steps}")
    if is_each:
        check(library, array, "tau", functions._dtype, functions._device)
    first = arguments_of(step, (q, v, array[0] if is_each else tau), steps, dt, tables)
    given = step._given(first, stream)
    at = list(step.arguments).index("tau")
    torques = array if is_each else given.arrays[at]
    if library.name == "torch" and any(x.requires_grad for x in (*given.arrays, torques)):
        from robot_dynamics.gpu import autograd

        if autograd.is_recording():
            if out is not None:
                raise TypeError("out= has no gradients: detach the arguments, or call without out=")
            q_end, v_end, q_all, v_all, *others = autograd.rollout(step, given, torques, steps, trajectory)
            return DeviceRollout(q_end, v_end, q_all, v_all, dict(zip(state_names(step)[2:], others, strict=True)))
    names = state_names(step)[2:]
    if trajectory:
        places = kept_states(step, given, torques, steps)
        ends = [place[steps] for place in places]
        if out is not None:
            for source, target in zip(ends, _outputs(step, given, out), strict=False):
                library.copy(source, target)
            ends[:2] = out
        return DeviceRollout(ends[0], ends[1], places[0][1:], places[1][1:], dict(zip(names, ends[2:], strict=True)))
    final = _final_states(step, given, torques, steps, out)
    return DeviceRollout(final[0], final[1], None, None, dict(zip(names, final[2:], strict=True)))


def _new_state(step: DeviceFunction, given: Arguments, lead: tuple[int, ...]) -> list[Any]:
    """New arrays for the tables of the state."""
    own = step._functions
    return [given.library.empty((*lead, *shape), own._dtype, own._device) for shape in step.results.values()]


def _outputs(step: DeviceFunction, given: Arguments, out: Any) -> list[Any]:
    """The arrays for the final q and v, after all checks, and new ones for the other tables of the state."""
    if not isinstance(out, (tuple, list)) or len(out) != 2:
        raise TypeError("out must be a tuple of two arrays, for q and v")
    return step._outputs(given.library, [*out, *_new_state(step, given, given.lead)[2:]], given.lead)


def _start(step: DeviceFunction, given: Arguments) -> list[Any]:
    """The tables of the state before the first step."""
    return [given.arrays[list(step.arguments).index(name)] for name in state_names(step)]


def kept_states(step: DeviceFunction, given: Arguments, torques: Any, steps: int) -> list[Any]:
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
    list of arrays
        Configurations, velocities, and the other tables of the state.
    """
    library = given.library
    with library.on_stream(step._functions._device, given.given_stream):
        tables = _new_state(step, given, (steps + 1, *given.lead))
        for source, table in zip(_start(step, given), tables, strict=True):
            library.copy(source, table[0])
    advance(step, given, torques, steps, [tuple(table[k] for table in tables) for k in range(steps + 1)])
    return tables


def _final_states(step: DeviceFunction, given: Arguments, torques: Any, steps: int, out: Any) -> Sequence[Any]:
    """The states after the last step. Steps alternate between two places, of which one is the result."""
    library = given.library
    with library.on_stream(step._functions._device, given.given_stream):
        ends = _new_state(step, given, given.lead) if out is None else _outputs(step, given, out)
        others = _new_state(step, given, given.lead)
        # The states are in the results after an even number of steps from there.
        start = ends if steps % 2 == 0 else others
        for source, target in zip(_start(step, given), start, strict=True):
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
    library, count = given.library, len(places)
    is_each = len(library.shape(torques)) == len(given.lead) + 2
    of_state, arguments = state_names(step), list(step.arguments)
    others = [name for name in arguments if name not in of_state]
    held = {name: given.arrays[arguments.index(name)] for name in others}
    if isinstance(step._compiled, CpuFunctions):
        for k in range(steps):
            held["tau"] = torques[k] if is_each else torques
            own = {**dict(zip(of_state, places[k % count], strict=True)), **held}
            step._launch(given, [own[name] for name in arguments], places[(k + 1) % count])
        return
    states, shapes = prod(given.lead), list(step.results.values())
    memory = [step._memory(library, place, shapes, states) for place in places]
    held["tau"] = torques
    sizes = [prod(step.arguments[name]) * states * (steps if name == "tau" and is_each else 1) for name in others]
    tables = [(library.address(held[name]), size) for name, size in zip(others, sizes, strict=True)]
    step._compiled._rollout(step.name, steps, memory, tables, [], given.stream, False)
