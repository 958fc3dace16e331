"""Results and gradients of rollouts on arrays, for JAX and PyTorch: NaN in the rows of invalid states."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from robot_dynamics.errors import BadStatesError, SimulationError, SingularMassError, StateError

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Arrays: TypeAlias = tuple[Any, ...]


def compute(robot: Robot, name: str, /, *given: Any, **options: Any) -> Arrays:
    """Results of a method of the robot; NaN in the rows of invalid states."""
    method = getattr(robot, name)
    try:
        return _result_arrays(method(*given, **options))
    except BadStatesError as error:
        return _result_arrays(error.result)
    except (SimulationError, SingularMassError, StateError):
        # One state, computed as a batch of one, which has a row for NaN.
        batch = [_add_batch_axis(x) for x in given]
        named = {key: _add_batch_axis(x) for key, x in options.items()}
        try:
            found = method(*batch, **named)
        except BadStatesError as error:
            found = error.result
        return tuple(x if x is None else x[0] for x in _result_arrays(found))


def rollout_gradients(
    robot: Robot, how: dict[str, Any], state: Arrays, ends: Arrays, cotangents: Arrays, *, by_parameters: bool = False
) -> Arrays:
    """Gradients of a rollout by its start (q, v, τ), and by parameters, from those of its results.

    `ends` are the final configurations and those of the trajectory. The gradient by q has its nq numbers.
    """
    (start, speed, forces), (q_end, q_way) = state, ends
    by_end, by_end_velocity, by_way, by_way_velocity = cotangents
    (by_position,) = compute(robot, "cotangent_from_coordinates", q_end, by_end)
    given = {"by_position": by_position, "by_velocity": by_end_velocity}
    if how["stride"]:
        (by_way,) = compute(robot, "cotangent_from_coordinates", q_way, by_way)
        given |= {"by_position_trajectory": by_way, "by_velocity_trajectory": by_way_velocity}
    options = {"parameters": by_parameters, **given, **how}
    found = compute(robot, "rollout_pullback", start, speed, forces, **options)
    # Without the counts of steps.
    by_start, *rest = found[:4]
    (by_q,) = compute(robot, "cotangent_to_coordinates", start, by_start)
    return by_q, *rest


def _add_batch_axis(x: Any) -> Any:
    return x[np.newaxis] if isinstance(x, np.ndarray) else x


def _result_arrays(found: Any) -> Arrays:
    """Arrays of a result."""
    if isinstance(found, np.ndarray):
        return (found,)
    return tuple(found) if isinstance(found, tuple) else (found.q, found.v, found.q_trajectory, found.v_trajectory)
