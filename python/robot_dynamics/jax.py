"""JAX: the dynamics as functions of arrays, under `jit`, `vmap`, `grad`, `jvp`, `vjp`, `scan`; on the CPU.

XLA calls the library itself, without Python. Arrays are float64 (``jax_enable_x64``) or float32 and may have
any leading dimensions, which broadcast as everywhere in this package. Reverse mode is vector-Jacobian
products in O(n), without a Jacobian or M; forward mode multiplies with the slopes. A gradient by q is by its
nq numbers; of a quaternion it is that of a function that depends on its direction alone, so an optimiser's
step has to be normalised (`Robot.normalize`). Second derivatives are refused. Results of an invalid state
(not finite, a quaternion not of unit length, a singular M) are NaN, and those of the other states are right;
so it is for parameters that are not finite. A mistake in a whole program raises an error of this package. A
robot that was called stays in memory; Ctrl-C is heard when a call has ended.

    import jax, jax.numpy as jnp
    import robot_dynamics as rd
    from robot_dynamics.jax import inverse_dynamics

    jax.config.update("jax_enable_x64", True)
    robot = rd.example("panda")

    @jax.jit
    def effort(q):
        rest = jnp.zeros(7)
        return (inverse_dynamics(robot, q, rest, rest) ** 2).sum()

    jax.grad(effort)(jnp.zeros((1000, 7)))     # (1000, 7): where to bend to hold less
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from robot_dynamics.errors import DTypeError, ShapeError

if TYPE_CHECKING:
    import jax

    from robot_dynamics.robot import Robot


def inverse_dynamics(
    robot: Robot, q: jax.Array, v: jax.Array, a: jax.Array, *, parameters: jax.Array | None = None
) -> jax.Array:
    """τ = M(q) a + C(q, v) v + g(q), (..., nv) [N·m or N], differentiable by q, v, a and parameters.

    q (..., nq), v (..., nv), a (..., nv), `parameters` (n,) or (..., n): those of the robot that is computed,
    as `Robot.parameters()` lists them; `robot` gives the geometry.
    """
    return _first(robot, "inverse_dynamics", ("q", "v", "a"), (q, v, a), parameters)


def forward_dynamics(
    robot: Robot, q: jax.Array, v: jax.Array, tau: jax.Array, *, parameters: jax.Array | None = None
) -> jax.Array:
    """a = M⁻¹(τ − C v − g), (..., nv) [rad/s² or m/s²], differentiable by q, v, τ and parameters.

    q (..., nq), v (..., nv), tau (..., nv) [N·m or N], `parameters` as for `inverse_dynamics`.
    """
    return _first(robot, "forward_dynamics", ("q", "v", "tau"), (q, v, tau), parameters)


def mass_matrix(robot: Robot, q: jax.Array) -> jax.Array:
    """M(q), (..., nv, nv) [kg·m², kg·m, kg], differentiable by q (..., nq)."""
    return _first(robot, "mass_matrix", ("q",), (q,))


def frame_pose(robot: Robot, q: jax.Array, frame: str | int) -> jax.Array:
    """`world_from_frame` as a homogeneous matrix [R p; 0 1], (..., 4, 4), differentiable by q (..., nq)."""
    index = robot.frame_names.index(frame) if isinstance(frame, str) and frame in robot.frame_names else frame
    if not isinstance(index, int) or not 0 <= index < len(robot.frame_names):
        from robot_dynamics.errors import FrameError

        raise FrameError(f"robot `{robot.name}` has no frame {frame!r}; see `frame_names`")
    return _first(robot, "frame_pose", ("q",), (q,), frame=index)


class Rollout(NamedTuple):
    """The motions of many states."""

    q: jax.Array
    """Where they end, (..., nq)."""
    v: jax.Array
    """(..., nv)"""
    q_trajectory: jax.Array
    """The states after each `stride` steps, (..., samples, nq)."""
    v_trajectory: jax.Array
    """(..., samples, nv)"""


def rollout(
    robot: Robot,
    q: jax.Array,
    v: jax.Array | None = None,
    tau: jax.Array | None = None,
    *,
    steps: int,
    dt: float = 1e-3,
    integrator: str = "rk4",
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stride: int = 0,
    parameters: jax.Array | None = None,
) -> Rollout:
    """`Robot.rollout` of arrays, differentiable by q, v, tau and parameters: one call of XLA's for all steps.

    q (..., nq), v (..., nv) or none for 0, tau (..., nv) held over all steps or (..., steps, nv), with one
    dimension more than the states. `parameters` (n,) or (..., n) are those of the robot that moves, as
    `Robot.parameters()` lists them: inertias, damping, friction, springs, gravity; friction's sign is held.
    Reverse mode computes the states again from √steps checkpoints. Effects act as in
    `Robot.rollout_pullback`; those without gradients are left out or refused.
    """
    import jax.numpy as jnp

    from robot_dynamics.motion import disabled_effects, effort_limits
    from robot_dynamics.xla import calls

    off = disabled_effects(without, dissipation, stops=True)
    row, dissipates = robot._differentiable_row(dt=dt, integrator=integrator, conservative=conservative, without=off)
    q = _array("q", q)
    v = jnp.zeros(robot.nv, q.dtype) if v is None else _array("v", v)
    lead = _lead([("q", q, (robot.nq,)), ("v", v, (robot.nv,))], robot)
    given, own, torques = [q, v], [1, 1], "none"
    if tau is not None:
        tau = _array("tau", tau)
        torques = "each" if tau.ndim > len(lead) + 1 else "held"
        last = (steps, robot.nv) if torques == "each" else (robot.nv,)
        lead = jnp.broadcast_shapes(lead, _lead([("q", q, (robot.nq,)), ("tau", tau, last)], robot))
        limits = effort_limits(robot, conservative, off)
        if limits is not None:
            tau = jnp.clip(tau, -limits.astype(tau.dtype), limits.astype(tau.dtype))
        given, own = [*given, tau], [*own, len(last)]
    if parameters is not None:
        parameters = _array("parameters", parameters)
        count = len(robot.parameter_names)
        lead = jnp.broadcast_shapes(lead, _lead([("q", q, (robot.nq,)), ("parameters", parameters, (count,))], robot))
        parameters = _of_states(parameters, lead)
    samples = steps // stride if stride > 0 else 0
    ends = calls.rollout(
        robot,
        given=_spread(given, own, lead),
        own=tuple(own),
        course=calls.Course(torques, steps, dt, row, dissipates, stride if samples else 0),
        parameters=parameters,
    )
    nothing = [jnp.zeros((*lead, 0, width), q.dtype) for width in (robot.nq, robot.nv)]
    return Rollout(*ends, *nothing[len(ends) - 2 :])


def step(
    robot: Robot,
    q: jax.Array,
    v: jax.Array,
    tau: jax.Array | None = None,
    *,
    dt: float,
    integrator: str = "rk4",
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    parameters: jax.Array | None = None,
) -> tuple[jax.Array, jax.Array]:
    """q and v after one step of `dt` seconds, differentiable by q, v, tau and parameters; as `rollout` of
    one step.

    q (..., nq), v (..., nv), tau (..., nv).
    """
    import jax.numpy as jnp

    q = _array("q", q)
    if tau is not None:
        tau = _array("tau", tau)
        q = jnp.broadcast_to(q, (*jnp.broadcast_shapes(q.shape[:-1], tau.shape[:-1]), *q.shape[-1:]))
    how: dict[str, Any] = {"integrator": integrator, "conservative": conservative, "without": without}
    end = rollout(robot, q, v, tau, steps=1, dt=dt, dissipation=dissipation, parameters=parameters, **how)
    return end.q, end.v


def _first(
    robot: Robot,
    name: str,
    names: tuple[str, ...],
    given: tuple[Any, ...],
    parameters: Any = None,
    **attributes: int,
) -> jax.Array:
    """The one result of a row of the table."""
    from robot_dynamics.xla import calls

    arrays = [_array(own, array) for own, array in zip(names, given, strict=True)]
    widths = [robot.nq if own == "q" else robot.nv for own in names]
    every: list[tuple[str, Any, tuple[int, ...]]] = [
        (own, x, (width,)) for own, x, width in zip(names, arrays, widths, strict=True)
    ]
    if parameters is not None:
        parameters = _array("parameters", parameters)
        every.append(("parameters", parameters, (len(robot.parameter_names),)))
    lead = _lead(every, robot)
    spread = _spread(arrays, [1] * len(arrays), lead)
    if parameters is not None:
        parameters = _of_states(parameters, lead)
    result: jax.Array = calls.row(robot, name, spread, parameters, **attributes)[0]
    return result


def _of_states(parameters: Any, lead: tuple[int, ...]) -> Any:
    """Parameters of each state, or as they are where all states share them."""
    import jax.numpy as jnp

    return parameters if parameters.ndim == 1 else jnp.broadcast_to(parameters, (*lead, parameters.shape[-1]))


def _array(name: str, given: Any) -> Any:
    """An array of JAX of float64 or float32."""
    try:
        import jax.numpy as jnp
    except ImportError as error:
        raise ImportError("robot_dynamics.jax needs JAX: pip install jax") from error

    array = jnp.asarray(given)
    if jnp.issubdtype(array.dtype, jnp.integer):
        return array.astype(jnp.result_type(float))
    if array.dtype not in (jnp.float32, jnp.float64):
        raise DTypeError(f"{name} has dtype {array.dtype}; float64 and float32 are computed with: convert it yourself")
    return array


def _lead(given: list[tuple[str, Any, tuple[int, ...]]], robot: Robot) -> tuple[int, ...]:
    """The dimensions of the batch, broadcast as in numpy."""
    import jax.numpy as jnp

    leads = []
    first, one, _ = given[0]
    for name, array, own in given:
        if array.shape[array.ndim - len(own) :] != own:
            needs = ", ".join(map(str, own))
            raise ShapeError(f"{name} has shape {array.shape}, robot `{robot.name}` needs (..., {needs})")
        if array.dtype != one.dtype:
            raise DTypeError(f"{first} is {one.dtype} and {name} is {array.dtype}: nothing is converted silently")
        leads.append(array.shape[: array.ndim - len(own)])
    try:
        return tuple(jnp.broadcast_shapes(*leads))
    except ValueError:
        shapes = ", ".join(f"{name} has shape {array.shape}" for name, array, _ in given)
        raise ShapeError(f"{shapes}: the leading dimensions do not broadcast") from None


def _spread(arrays: list[Any], own: list[int], lead: tuple[int, ...]) -> list[Any]:
    """The arrays with the dimensions of the whole batch."""
    import jax.numpy as jnp

    return [
        jnp.broadcast_to(array, (*lead, *array.shape[array.ndim - axes :]))
        for array, axes in zip(arrays, own, strict=True)
    ]
